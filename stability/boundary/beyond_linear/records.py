"""Records of what happens at a flutter boundary: a limit cycle, or a line of steady motions."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from ...base.checks import checked
from ...base.errors import ParameterError
from ...base.types import Floats, Record, Sentences


class HopfKind(Sentences):
    """Fate of a motion next to the boundary; the value is the sentence a user reads.

    Source: first Lyapunov coefficient; hidden normal forms: tests/boundary/test_hopf_any.py.

    Examples
    --------
    >>> import stability as st
    >>> st.HopfKind("elliptic").word
    'elliptic'
    """

    ELLIPTIC = (
        "elliptic: a motion near the unstable part of the line swings out and settles on the "
        "stable part, about as far beyond the boundary as it began before it"
    )
    HYPERBOLIC = (
        "hyperbolic: a motion near the unstable part leaves a neighbourhood of the boundary, and "
        "may settle elsewhere on the family; near the stable part only motions inside a cone "
        "of small amplitude settle nearby"
    )
    DEGENERATE = (
        "degenerate: the pair does not cross with speed, or does not move the motion along the "
        "line, within the error of the computation; higher orders decide"
    )

    @property
    def word(self) -> str:
        """One lower-case word."""
        return self.name.lower()


@dataclass(frozen=True, eq=False)
class HopfPoint(Record):
    """A flutter boundary along a line of steady motions, with its normal form.

    Source: first Lyapunov coefficient; hidden normal forms: tests/boundary/test_hopf_any.py.

    Examples
    --------
    >>> import stability as st
    >>> [(p.at, p.kind.word) for p in st.hopf("spinning", contact=st.Viscous(0.8))]
    [(2.597367404552053, 'elliptic')]
    """

    at: float
    """Family parameter at the boundary, in the user's unit."""
    kind: HopfKind
    """Elliptic, hyperbolic or degenerate."""
    stable_below: bool
    """Whether the stable part of the line has the smaller family parameter."""
    frequency: float
    """|Im λ| of the pair, in the user's unit of rate."""
    crossing: float
    """Re μ': speed of the pair's real part along the line, dimensionless."""
    push: float
    """c: drift along the line by the pair, for the mode of unit length, dimensionless."""
    mode: Floats
    """The pair's eigenvector, complex, of unit length over the states, dimensionless."""
    unit: float
    """One dimensionless unit of the family parameter in the user's unit."""
    citation: str = field(default="", compare=False, repr=False)
    """Keys of the works to cite, for `stability.citation`."""

    def landing(self, distance: float, amplitude: float = 0.0) -> float | None:
        """Place on the line where a motion settles, to leading order.

        Parameters
        ----------
        distance
            Signed distance of the start from the boundary along the line, in the user's unit.
        amplitude
            |z| of the start: the disturbance is 2 Re(z mode).

        Returns
        -------
        float or None
            Signed distance of the end from the boundary; None if the motion leaves the line.

        Examples
        --------
        >>> import stability as st
        >>> [point] = st.hopf("spinning", contact=st.Viscous(0.8))
        >>> round(point.landing(0.01), 12)  # unstable side, vanishing amplitude
        -0.01
        """
        if self.kind is HopfKind.DEGENERATE:
            raise ParameterError("the boundary is degenerate there; no landing can be told.")
        far, size = checked("distance", distance), checked("amplitude", amplitude)
        if not isinstance(far, float) or not isinstance(size, float):
            raise ParameterError("distance and amplitude must be one number each.")
        y = far / self.unit
        square = y * y - self.push / self.crossing * size * size
        stable_side = -1.0 if self.stable_below else 1.0
        if square < 0 or (self.kind is HopfKind.HYPERBOLIC and y * stable_side <= 0):
            return None
        return float(stable_side * np.sqrt(square) * self.unit)


class Onset(Sentences):
    """How oscillation begins at a flutter boundary; the value is the sentence a user reads.

    Source: first Lyapunov coefficient; hidden normal forms: tests/boundary/test_hopf_any.py.

    Examples
    --------
    >>> import stability as st
    >>> [kind.word for kind in st.Onset]
    ['soft', 'hard', 'linear', 'undecided']
    """

    SOFT = (
        "soft (supercritical): beyond the boundary a small stable oscillation appears, whose "
        "amplitude grows from zero as the root of the distance"
    )
    HARD = (
        "hard (subcritical): no small stable oscillation takes over beyond the boundary, so that "
        "motions jump away; before the boundary an unstable oscillation limits the disturbances "
        "that die out"
    )
    LINEAR = (
        "linear: the system is linear, so that there is no first Lyapunov coefficient and no "
        "oscillation of its own size: beyond the boundary a disturbance grows forever"
    )
    UNDECIDED = "undecided: no sign of the first Lyapunov coefficient is proved"

    @property
    def word(self) -> str:
        """One lower-case word."""
        return self.name.lower()


@dataclass(frozen=True, eq=False)
class CycleBirth(Record):
    """A flutter boundary of isolated steady motions, with its first Lyapunov coefficient.

    Each bound is proved in ball arithmetic: the true number is within it.  All four numbers are NaN
    where nothing is proved; `reason` then says why.

    Source: first Lyapunov coefficient; hidden normal forms: tests/boundary/test_hopf_any.py.

    Examples
    --------
    >>> import stability as st
    >>> import casadi as ca
    >>> x, p = ca.SX.sym("x", 2), ca.SX.sym("p")
    >>> r = p - x[0] ** 2 - x[1] ** 2
    >>> rates = ca.vertcat(r * x[0] - x[1], r * x[1] + x[0])
    >>> s = st.System("f", x, p, rates, states=("x", "y"), parameters=("p",))
    >>> rest = st.Family(s, "rest", at=("p",), held={"x": 0, "y": 0})
    >>> [birth] = st.hopf(rest, axis=("p", -1, 1, 9))
    >>> birth.kind.word
    'soft'
    """

    at: float
    """Value of the axis at the boundary, in the user's unit."""
    error: float
    """Half-width of the proved bracket, same unit."""
    kind: Onset
    """Soft, hard, linear or undecided."""
    stable_below: bool
    """Whether the stable side has the smaller value of the axis."""
    frequency: float
    """ω = |Im λ| of the pair, in the user's unit of rate."""
    frequency_error: float
    """Bound on its error."""
    crossing: float
    """d Re λ / d axis."""
    crossing_error: float
    """Bound on its error."""
    coefficient: float
    """l1 for the mode of unit length over the states in the user's units; its sign depends on no
    unit, its size does."""
    coefficient_error: float
    """Bound on its error."""
    reason: str = ""
    """Why the onset is undecided, or linear; empty otherwise."""
    citation: str = field(default="", compare=False, repr=False)
    """Keys of the works to cite, for `stability.citation`."""
