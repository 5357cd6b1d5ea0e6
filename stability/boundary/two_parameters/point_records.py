"""Points of codimension two of a parameter plane, and the result of a search for them."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from typing import NamedTuple, overload

from ...base.errors import warned
from ...base.types import Record, Sentences
from ..brackets import Crossing


class PointKind(Sentences):
    """What meets at a point; the value of each member is the sentence a user reads.

    Source: docs/explanation/method.md; closed forms: tests/boundary/test_codimension_two.py.

    Examples
    --------
    >>> import stability as st
    >>> points = st.codimension_two("spinning", x=("at", 0.5, 5, 9), y=("mu", 0.1, 3, 9))
    >>> points[0].kind.word
    'zero hopf'
    """

    DOUBLE_ZERO = "double zero (Bogdanov-Takens): two eigenvalues vanish, beyond structural zeros"
    ZERO_HOPF = "zero and a pair (zero-Hopf): one eigenvalue vanishes and a pair is imaginary"
    DOUBLE_HOPF = "two pairs (double Hopf): two pairs of eigenvalues are imaginary at once"
    VANISHING = (
        "vanishing coefficient (Bautin): on a flutter boundary soft onset turns into hard onset"
    )
    CUSP = "cusp: two folds meet, where three steady motions are one"

    @property
    def word(self) -> str:
        """Lower-case words."""
        return self.name.lower().replace("_", " ")


@dataclass(frozen=True, eq=False)
class DegeneratePoint(Record):
    """One point of a parameter plane at which two conditions meet.

    Source: docs/explanation/method.md; closed forms: tests/boundary/test_codimension_two.py.

    Examples
    --------
    >>> import stability as st
    >>> points = st.codimension_two("spinning", x=("at", 0.5, 5, 9), y=("mu", 0.1, 3, 9))
    >>> points[0].x, points[0].y
    (2.0, 1.0)
    """

    kind: PointKind
    """What meets."""
    x: float
    """Value of the x axis, in the user's unit."""
    x_error: float
    """Proved bound on its error."""
    y: float
    """Value of the y axis, in the user's unit."""
    y_error: float
    """Proved bound on its error."""
    frequencies: tuple[float, ...]
    """|Im λ| of the pairs, in the user's unit of rate, in increasing order."""
    others: str
    """Other eigenvalues: stable, unstable (so that the verdict does not change there), or open."""
    member: Mapping[str, float] = field(default_factory=dict)
    """The unknowns there, by name, where the family is solved for and has folds."""


@dataclass(frozen=True)
class CurveOfZeros:
    """A curve in a parameter plane along which an eigenvalue vanishes, or a pair is imaginary.

    On a family that is solved for, a static curve is one of folds, or of branch points.  Each point
    is proved: one of its numbers is taken as exact, and the other has a bound.

    Source: tests/boundary/test_defining_systems.py.

    Examples
    --------
    >>> import casadi as ca, stability as st
    >>> x, p = ca.SX.sym("x"), ca.SX.sym("p", 2)
    >>> rate, names = p[0] - p[1] ** 2 - x**2, ("a", "b")
    >>> system = st.System("fold", x, p, rate, states=("x",), parameters=names)
    >>> upper = system.steady(("a", "b"), guess={"x": 1, "a": 1, "b": 0})
    >>> import warnings; warnings.simplefilter("ignore")  # a search along curves is not complete
    >>> points = st.codimension_two(upper, x=("a", -1, 2, 5), y=("b", -1, 1, 5), curves=True)
    >>> [curve] = points.curves
    >>> curve.crossing.word, max(abs(a - b * b) for a, b in zip(curve.x, curve.y)) < 1e-14
    ('static', True)
    """

    crossing: Crossing
    """Static where an eigenvalue vanishes, flutter where a pair is imaginary."""
    x: tuple[float, ...]
    """Values of the x axis along the curve."""
    y: tuple[float, ...]
    """Values of the y axis along the curve."""
    error: tuple[float, ...]
    """Proved bound on the error of x or y at each point, whichever is not exact."""
    frequency: tuple[float, ...]
    """|Im λ| of the pair at each point; 0 on a static curve."""


class UnresolvedBox(NamedTuple):
    """A part of the plane in which points of a kind are not excluded, or not proved."""

    kind: PointKind
    """Kind of point."""
    x: tuple[float, float]
    """Ends along x."""
    y: tuple[float, float]
    """Ends along y."""
    reason: str
    """Reason, in one sentence."""


@dataclass(frozen=True, eq=False)
class CodimensionTwo(Record, Sequence[DegeneratePoint]):
    """Every point that a search found, and what it left open.

    A sequence of its points, sorted by kind and x.

    Source: docs/explanation/method.md; closed forms: tests/boundary/test_codimension_two.py.

    Examples
    --------
    >>> import stability as st
    >>> points = st.codimension_two("spinning", x=("at", 0.5, 5, 9), y=("mu", 0.1, 3, 9))
    >>> points.complete, len(points)
    (True, 1)
    """

    points: tuple[DegeneratePoint, ...]
    """The points."""
    axes: tuple[tuple[str, float, float], tuple[str, float, float]]
    """Name and ends of x and y."""
    unresolved: tuple[UnresolvedBox, ...]
    """Parts of the plane that stay open, each with a reason."""
    how: str
    """One sentence on how double zeros, zeros with a pair, and two pairs were sought."""
    vanishing: str
    """One sentence on how vanishing coefficients were sought."""
    vanishing_complete: bool = False
    """Whether every vanishing coefficient in the closed rectangle is listed, by proof."""
    citation: str = ""
    """Keys of the works to cite, for `stability.citation`."""
    curves: tuple[CurveOfZeros, ...] = ()
    """Curves of folds and of pairs, where they were asked for."""

    @property
    def complete(self) -> bool:
        """Whether every point in the closed rectangle is listed, but for vanishing coefficients.

        For these see `vanishing_complete`.
        """
        return all(box.kind is PointKind.VANISHING for box in self.unresolved)

    def __len__(self) -> int:
        return len(self.points)

    @overload
    def __getitem__(self, index: int) -> DegeneratePoint: ...
    @overload
    def __getitem__(self, index: slice) -> tuple[DegeneratePoint, ...]: ...
    def __getitem__(self, index: int | slice) -> DegeneratePoint | tuple[DegeneratePoint, ...]:
        return self.points[index]

    def __iter__(self) -> Iterator[DegeneratePoint]:
        return iter(self.points)

    def __repr__(self) -> str:
        (x, *xs), (y, *ys) = self.axes
        where = f"{x} from {xs[0]:.10g} to {xs[1]:.10g}, {y} from {ys[0]:.10g} to {ys[1]:.10g}"
        said = f"{list(self.points)!r}; {self.statement}"
        return f"<{len(self)} points of codimension two, {where}: {said}>"

    @property
    def statement(self) -> str:
        """What was searched, and what stays open."""
        open_ = [b for b in self.unresolved if b.kind is PointKind.VANISHING]
        spectral = [b for b in self.unresolved if b.kind is not PointKind.VANISHING]
        said = self._not(spectral) if spectral else self.how
        return f"{said}; {self._not(open_) + '; ' if open_ else ''}{self.vanishing}"

    def _not(self, boxes: Sequence[UnresolvedBox]) -> str:
        """What stays open in boxes."""
        first, more = boxes[0], len(boxes) - 1
        return (
            f"not complete: {first.kind.word} near {self.axes[0][0]} {first.x[0]:.10g} to "
            f"{first.x[1]:.10g}, {self.axes[1][0]} {first.y[0]:.10g} to {first.y[1]:.10g}: "
            f"{first.reason}" + (f" (and {more} more in .unresolved)" if more else "")
        )

    def warn(self) -> None:
        """Issue a `StabilityWarning` where the search was not complete."""
        if not self.complete:
            warned(self.statement)
