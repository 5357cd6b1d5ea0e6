"""Hopf bifurcations: what begins at a flutter boundary, on a line of steady motions or elsewhere.

Where steady motions are isolated, a limit cycle is born, and the sign of the first Lyapunov
coefficient says whether the onset is soft or hard.

At a flutter boundary of spinning and tumbling under friction one eigenvalue is zero by structure,
because the family is a line of steady motions.  A pair crosses the imaginary axis along that line.
Energy falls while the contact slips, so no limit cycle is born.  To leading order the distance y
along the line and the amplitude z of the pair obey

    dy/dt = c |z|²,   d|z|/dt = Re μ' y |z|,   so that  y² - (c / Re μ') |z|²  is constant.

Elliptic (c Re μ' < 0): a motion that starts next to the unstable part of the line swings out and
settles on the stable part, as far from the boundary as its start.  Hyperbolic (c Re μ' > 0): such a
motion leaves, and of the motions that start next to the stable part only those inside a cone
settle.

Source: B. Fiedler, S. Liebscher & J. C. Alexander, J. Differential Equations 167 (2000) 16-35;
tests/boundary/test_hopf.py compares with an independent derivation and with simulations.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field, replace
from functools import lru_cache
from typing import Any, NamedTuple, overload

import numpy as np
from flint import arb

from ..algebra.exact.number_fields import NotExact
from ..algebra.exact.roots import UnclearError
from ..algebra.krawczyk import NotProvedError
from ..algebra.number_types import precision, upper
from ..base.axis import Axis, AxisLike
from ..base.checks import checked, whole_number
from ..base.citation import cited
from ..base.errors import ParameterError, StabilityError, listed, shown, warned
from ..base.printing import html_table
from ..base.quantities import behind, unit_of
from ..base.types import Floats, Record, Sentences
from ..bodies.contact_laws import LAWS, Contact
from ..bodies.disk import Disk
from ..bodies.families import FAMILIES, SteadyFamily
from ..bodies.round_body.body import Body
from ..bodies.subject import subject_of
from ..spectra.axes import swept
from ..spectra.labels import axis_attributes, rate_attributes
from ..spectra.problem import Problem, problem_of
from ..systems.family import Family
from ..systems.structure.linearity import linear
from ..systems.structure.structural_zeros import structure
from .algebraic.exact_search import members_along
from .brackets import AxisCrossing, AxisScan, Boundaries, BoundaryPoint, Crossing
from .changes import MOST_SCAN, along, every_along
from .lyapunov_coefficient import (
    Coefficients,
    OneParameterFamily,
    Pair,
    coefficients,
    derivatives,
    line_form,
    others,
    pair_near,
    signed,
)


class HopfKind(Sentences):
    """Fate of a motion next to the boundary; the value is the sentence a user reads.

    Source: first Lyapunov coefficient; hidden normal forms: tests/boundary/test_hopf_any.py.

    Examples
    --------
    >>> import stability as st
    >>> st.results.HopfKind("elliptic").word
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


@dataclass(frozen=True, eq=False, repr=False)
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
    units: tuple[str, str] = field(default=("1", "1"), compare=False, repr=False)
    """Units of `at` and of `frequency`, in words where they are dimensionless."""

    def __repr__(self) -> str:
        numbers = [f"{name} = {text}" for name, text in self._texts().items()]
        side = "below" if self.stable_below else "above"
        return f"<HopfPoint: {self.kind.word}, stable {side}, {', '.join(numbers)}>"

    def _repr_html_(self) -> str:
        head = f"{'Stable below' if self.stable_below else 'Stable above'}; {self.kind.value}"
        return html_table(head, ["number", "value"], self._texts().items())

    def _texts(self) -> dict[str, str]:
        """Each number with its unit."""
        return {
            "at": f"{self.at:.12g}{behind(self.units[0])}",
            "frequency": f"{self.frequency:.12g}{behind(self.units[1])}",
            "crossing": f"{self.crossing:.6g}",
            "push": f"{self.push:.6g}",
        }

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
    >>> [kind.word for kind in st.results.Onset]
    ['soft', 'hard', 'linear', 'undecided', 'unstable']
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
    UNSTABLE = (
        "unstable: other eigenvalues are unstable, and so is the small oscillation; it is there "
        "while the pair grows if the first Lyapunov coefficient is negative, else while it decays"
    )

    @property
    def word(self) -> str:
        """One lower-case word."""
        return self.name.lower()


@dataclass(frozen=True, eq=False, repr=False)
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
    """Soft, hard, linear, undecided or unstable."""
    stable_below: bool
    """Whether the pair decays on the side with the smaller value of the axis."""
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
    """Why the onset is undecided, linear or unstable; empty otherwise."""
    unstable: int = 0
    """Number of other eigenvalues that are unstable there, proved; -1 where others cross too."""
    citation: str = field(default="", compare=False, repr=False)
    """Keys of the works to cite, for `stability.citation`."""

    def __repr__(self) -> str:
        told = [f"{name} = {text}" for name, text in self._texts().items()]
        told += [self.reason] * bool(self.reason)
        return f"<CycleBirth: {self.kind.word}, each bound proved: {', '.join(told)}>"

    def _repr_html_(self) -> str:
        head = f"{self.kind.value}; each bound is proved"
        return html_table(head, ["number", "value"], self._texts().items(), self.reason)

    def _texts(self) -> dict[str, str]:
        """The proved numbers, each with its bound."""
        numbers = {
            "at": (self.at, self.error),
            "frequency": (self.frequency, self.frequency_error),
            "crossing": (self.crossing, self.crossing_error),
            "l1": (self.coefficient, self.coefficient_error),
        }
        return {
            name: f"{value:.12g} ± {error:.1g}"
            for name, (value, error) in numbers.items()
            if np.isfinite(error)
        }


def _units(problem: Problem, axis: str) -> tuple[str, str]:
    """Units of the axis and of frequencies."""
    return unit_of(axis_attributes(problem, axis)), unit_of(rate_attributes(problem))


PRECISIONS = (192, 512, 1536)
"""Working precisions, in turn, until every sign that decides is proved."""
NEAR = 1e-5
"""Largest distance of the pair's unknowns from those of the family's member, over 1 plus size."""

LINEAR = (
    "the rates of the states that act on others are proved to be linear in them, so that the "
    "terms of order two and three vanish identically"
)
"""Reason where there is no first Lyapunov coefficient."""


WHOLE_LINE = (
    "belongs to a user's family; the disk's lines are searched throughout, with disk=Disk(...) and "
    "contact=Viscous(mu)."
)


def births(problem: Problem, grid: Axis) -> list[CycleBirth] | list[HopfPoint]:
    """Every crossing of a pair along an axis, with the kind of its onset; boundaries on a line.

    Raises
    ------
    ParameterError
        If the family is conservative, or eigenvalues vanish by structure for another reason than
        a line of steady motions or states on which nothing depends.
    """
    family = problem.family
    on_line = _accepted(family, grid.name)
    fixed = {n: float(v) for n, v in problem.values.items() if n != grid.name}
    line = OneParameterFamily(family, grid.name, fixed)
    works = cited(
        model=bool(family.system.quantities),
        proofs=True,
        theory=["fiedler2000" if on_line else "kuznetsov2004"],
    )
    if on_line:
        units = _units(problem, grid.name)
        edges = _flutter_edges(problem, grid)
        edges.warn(grid.name)
        return [replace(_on_line(line, b), citation=works, units=units) for b in edges]
    crossings = every_along(problem, grid)
    crossings.warn(grid.name)
    pairs = [pair for crossing in crossings for pair in _pairs(crossing)]
    if not crossings.complete:  # where numbers are open a verdict may still change
        pairs += [
            (edge, -1 if edge.frequencies else 0)
            for edge in _flutter_edges(problem, grid)
            if all(abs(edge.value - c.value) > edge.error + c.error for c in crossings)
        ]
    return [
        replace(birth(line, point, number), citation=works)
        for point, number in sorted(pairs, key=lambda pair: pair[0].value)
    ]


def _flutter_edges(problem: Problem, grid: Axis) -> Boundaries:
    """The boundaries along an axis at which pairs cross."""
    changes = along(problem, grid.name, grid.low, grid.high, points=grid.count, log=grid.log)
    kinds = (Crossing.FLUTTER, Crossing.STATIC_AND_FLUTTER)
    return replace(changes, points=tuple(b for b in changes if b.crossing in kinds))


def _pairs(crossing: AxisCrossing) -> Iterator[tuple[BoundaryPoint, int]]:
    """Each pair of a crossing, with the number of other eigenvalues that are unstable there."""
    below, above = crossing.unstable_below, crossing.unstable_above
    number = min(below, above) if len(crossing.frequencies) == 1 else -1
    for frequency in filter(None, dict.fromkeys(crossing.frequencies)):
        yield (
            BoundaryPoint(
                crossing.value, crossing.error, Crossing.FLUTTER, frequency, below < above
            ),
            number,
        )


NO_PAIR = (
    "no simple pair that crosses with speed is proved there, or the rates have no second derivative"
)
NO_COEFFICIENT = (
    "zero or twice the pair may be an eigenvalue too, or the rates have no third derivative there"
)
"""Why a first Lyapunov coefficient is not known."""


def zeros_left(family: Family) -> int:
    """Structural zeros that remain without the states on which nothing depends."""
    dropped = len(family.system.states) - len(derivatives(family.judged).kept)
    return structure(family).zeros - dropped


def _accepted(family: Family, axis: str) -> bool:
    """Whether the family is a line of steady motions along the axis; others are refused."""
    if family.conservative or structure(family).even:
        raise ParameterError(
            f"{family.name} is conservative, where pairs stay on the imaginary axis; a first "
            "Lyapunov coefficient needs a family with damping."
        )
    left = zeros_left(family)
    if left == 0:
        return False
    lines = [family.at[i] for i in family.moved]
    if left == 1 and axis in lines:
        return True
    if left == 1 and lines:
        raise ParameterError(
            f"{family.name} is a line of steady motions along {', '.join(lines)}, and axis is "
            f"{axis!r}; make {' or '.join(lines)} the axis."
        )
    raise ParameterError(
        f"{family.name} has {left} eigenvalues that vanish by structure, beyond states on which "
        "nothing depends; accepted are families with none, or with one along a state in `at`."
    )


def birth(line: OneParameterFamily, point: BoundaryPoint, unstable: int = 0) -> CycleBirth:
    """The first Lyapunov coefficient at a flutter boundary, with proved bounds."""
    reason = ""
    for bits in PRECISIONS:
        with precision(bits):
            reason = NO_PAIR
            try:
                pair = _checked(line, point)
                reason = NO_COEFFICIENT
                lyapunov = coefficients(pair)
                reason = LINEAR if linear(line.family.system) else _open(lyapunov)
                if not reason or bits == PRECISIONS[-1]:
                    return _record(point, pair, lyapunov, reason, unstable)
            except NotProvedError:
                continue
    nan = float("nan")
    return CycleBirth(
        point.value,
        point.error,
        Onset.UNDECIDED,
        point.stable_below,
        point.frequency,
        nan,
        nan,
        nan,
        nan,
        nan,
        reason,
        unstable,
    )


def _checked(line: OneParameterFamily, point: BoundaryPoint) -> Pair:
    """The pair of a boundary, which lies in its bracket."""
    pair = pair_near(line, point.value, point.frequency)
    rough = line.member(point.value)
    near = [
        abs(u - v) <= NEAR * (1 + abs(arb(v))) for u, v in zip(pair.unknowns, rough, strict=True)
    ]
    if not all(near):  # another member, which the verdicts are not about
        raise NotProvedError
    room = 2 * point.error + 1e-9 * abs(point.value)
    if not abs(pair.value - point.value) <= room:
        raise NotProvedError
    return pair


def _open(lyapunov: Coefficients) -> str:
    """Why the onset is undecided, or nothing."""
    if not lyapunov.others:
        return "another eigenvalue is not proved to be stable at the boundary"
    if not signed(lyapunov.speed):
        return "the pair's speed is not proved to differ from zero"
    if not signed(lyapunov.first):
        return "the first Lyapunov coefficient is zero within its bound; higher orders decide"
    return ""


def _record(
    point: BoundaryPoint, pair: Pair, lyapunov: Coefficients, reason: str, unstable: int
) -> CycleBirth:
    kind = Onset.SOFT if lyapunov.first < 0 else Onset.HARD
    if reason:
        kind = Onset.LINEAR if reason == LINEAR else Onset.UNDECIDED
    elif lyapunov.others < 0:
        kind = Onset.UNSTABLE
        reason = "another eigenvalue is unstable there"
        reason = f"{unstable} other eigenvalues are unstable there" if unstable > 1 else reason
    below = lyapunov.speed > 0 if signed(lyapunov.speed) else point.stable_below
    value, error = rounded(pair.value)
    frequency, speed, first = map(rounded, (pair.frequency, lyapunov.speed, lyapunov.first))
    return CycleBirth(
        value,
        error,
        kind,
        bool(below),
        *frequency,
        *speed,
        *first,
        reason,
        unstable,
    )


def rounded(ball: Any) -> tuple[float, float]:
    """The nearest double to a ball's midpoint, and a bound on its distance from the true number."""
    value = 0.0 if arb(ball).contains(0) else float(arb(ball).mid())
    return value, upper(abs(arb(ball) - arb(value)))


def _on_line(line: OneParameterFamily, point: BoundaryPoint) -> HopfPoint:
    for bits in PRECISIONS:
        with precision(bits):
            try:
                pair = _checked(line, point)
                form = line_form(pair)
                stable = others(pair, zeros=1) > 0
                signs = signed(form.speed) * signed(form.push) if stable else 0
            except NotProvedError:
                continue
            if not signs and bits < PRECISIONS[-1]:
                continue
            kind = HopfKind.HYPERBOLIC if signs > 0 else HopfKind.ELLIPTIC
            mode = np.array([complex(float(v.real.mid()), float(v.imag.mid())) for v in pair.mode])
            whole = np.zeros(len(line.family.system.states), dtype=complex)
            whole[line.d.kept] = mode
            return HopfPoint(
                rounded(pair.value)[0],
                kind if signs else HopfKind.DEGENERATE,
                point.stable_below,
                float(pair.frequency.mid()),
                float(form.speed.mid()),
                float(form.push.mid()),
                whole,
                1.0,
            )
    raise StabilityError(
        f"{line.family.name} at {line.axis} = {point.value:.10g}: {NO_PAIR}, so its normal form is "
        "not known."
    )


BITS = 256
"""Working precision of the first attempt."""
MOST_BITS = 4096
"""Highest precision; a sign that is still open there makes the point degenerate."""
MOST_POINTS = 100_000
"""Most points of the search."""


@overload
def hopf(
    family: str,
    *,
    contact: Contact | type[Contact] | str | None = None,
    disk: Disk | None = None,
    points: int = 400,
    **parameters: float,
) -> list[HopfPoint]: ...
@overload
def hopf(
    family: str, *, body: Body, contact: Contact | str, axis: AxisLike, **parameters: float
) -> list[CycleBirth] | list[HopfPoint]: ...
@overload
def hopf(
    family: Family, *, axis: AxisLike, **parameters: float
) -> list[CycleBirth] | list[HopfPoint]: ...
def hopf(
    family: str | Family,
    *,
    contact: Any = None,
    disk: Any = None,
    body: Any = None,
    points: Any = 400,
    axis: Any = None,
    **parameters: Any,
) -> list[CycleBirth] | list[HopfPoint]:
    """Every flutter boundary, with what begins there: soft or hard, elliptic or hyperbolic.

    For a user's family whose steady motions are isolated: each crossing of a pair along an axis,
    also where others are unstable, with its first Lyapunov coefficient and a proved bound.  Where
    the axis is a state in `at`, so that they are a line: the flutter boundaries, each with the
    normal form of a line.  States on which nothing depends are left out first.

    For the disk the search is complete: every real root of the conditions over Q is isolated, along
    all of the line (phi_dot > 0; theta between 0 and upright, beyond which it is mirrored).  A
    user's law has no stored conditions.  Where its graph is not rational, part of the line is
    scanned, and a `StabilityWarning` says which part.

    Parameters
    ----------
    family
        A family of a user's system; or `spinning`, `tumbling`, or another family of the disk with
        `SteadyFamily.flutter`.
    contact
        For the disk: a law with friction, or the name or class of one with its parameters by name,
        such as `contact="viscous", mu=0.3`; each parameter is one number.
    disk
        The body, one number each; the uniform disk with m = R = g = 1 when left out.
    body
        A `Body` in place of the disk; its families by name need an axis.
    points
        For the disk: number of points of the scan, where one is needed.
    axis
        For a body and a user's family: (name, low, high, n) or (name, low, high, n, "log"), as for
        `boundaries`.
    **parameters
        For a user's family: every other quantity, one number each, or `at` as for `boundaries`; for
        the disk: the parameters of a law that is named.

    Returns
    -------
    list of CycleBirth or HopfPoint
        In increasing order of the axis; empty where there is none.

    Raises
    ------
    ParameterError
        If the family is conservative, or has structural zeros for another reason; for the disk if
        the family is no line, or the law has no friction.  (Rolling's boundary has two zeros and a
        pair, and is passed slowly instead: see `stability.drift`.)

    Warns
    -----
    StabilityWarning
        If the search for boundaries was not complete.

    Source: tests/boundary/test_hopf.py, test_hopf_any.py.

    Examples
    --------
    >>> import stability as st
    >>> [(p.kind.word, p.stable_below) for p in st.hopf("tumbling", contact=st.Viscous(0.9),
    ...                                                 disk=st.Disk(k=0.375))]
    [('elliptic', True), ('hyperbolic', False)]

    >>> import casadi as ca, stability as st
    >>> x, c = ca.SX.sym("x", 2), ca.SX.sym("c")
    >>> rates = ca.vertcat(x[1], -x[0] + (c - x[0] ** 2) * x[1])
    >>> oscillator = st.System("van der Pol", x, c, rates, states=("q", "v"), parameters=("c",))
    >>> rest = st.Family(oscillator, "rest", at=("c",), held={"q": 0, "v": 0})
    >>> [point] = st.hopf(rest, axis=("c", -1, 1, 9))
    >>> point.kind.word, point.coefficient, point.crossing
    ('soft', -0.25, 0.5)
    """
    if axis is not None:
        problem, (grid,) = swept(
            family, {"axis": axis}, disk, body, contact, None, parameters, most=MOST_SCAN
        )
        if not problem.plain:
            raise ParameterError(f"axis {WHOLE_LINE}")
        return births(problem, grid)
    asked = subject_of(
        family,
        disk=disk,
        body=body,
        contact=contact,
        parameters=parameters,
        laws={name: law for name, law in LAWS.items() if law.parameters},
    )
    record, law = asked.record, asked.law
    if asked.disk is None:
        raise ParameterError(
            f"axis is missing; {asked.family.name} needs (name, low, high, n), as for boundaries."
        )
    if record is None or record.flutter is None:
        lines = listed([name for name, entry in FAMILIES.items() if entry.flutter])
        raise ParameterError(
            f"family is {shown(family)}; {lines} have such boundaries (rolling passes its own "
            "slowly, see drift)."
        )
    if asked.member:
        raise ParameterError(f"{next(iter(asked.member))} {WHOLE_LINE}")
    if law is None or not law.parameters:
        raise ParameterError(f"contact is {shown(contact)}; a law with friction is needed.")
    points = whole_number("points", points, 2, MOST_POINTS, "the search takes time for each")
    problem = problem_of(replace(asked, member={"at": 1.0}))
    for name, value in problem.values.items():
        if np.ndim(value):
            raise ParameterError(f"{name} is an array; give one number.")
    works = cited(law.name, model=True, proofs=True, theory=["fiedler2000"])
    unit = record.unit(float(np.asarray(asked.disk.rate)))
    bits = BITS
    while True:  # until the signs that decide the type are proved
        last = bits >= MOST_BITS
        try:
            with precision(bits):
                marks = _flutter(problem, record, bits, unit, points)
                hopf_points = [_point(problem, mark, unit) for mark in marks]
        except (StabilityError, UnclearError, NotProvedError) as error:
            if last:
                raise StabilityError(
                    str(error)
                    or f"{bits} bits do not prove every pair on the imaginary axis; give numbers "
                    "nearer to 1, or other ones."
                ) from None
            hopf_points = None
        if last or (
            hopf_points is not None and all(p.kind is not HopfKind.DEGENERATE for p in hopf_points)
        ):
            units = _units(problem, "at")
            return [replace(point, citation=works, units=units) for point in hopf_points or []]
        bits *= 2


class FlutterBoundary(NamedTuple):
    """A flutter boundary."""

    value: Any
    """Ball in the unit of the axis."""
    stable_below: bool
    """Whether the stable side has the smaller value."""


def _flutter(
    problem: Problem, record: SteadyFamily, bits: int, unit: float, points: int
) -> list[FlutterBoundary]:
    """The flutter boundaries along the whole line, in balls."""
    fixed = {n: float(v) for n, v in problem.values.items() if n != "at"}
    try:
        members = members_along(AxisScan(problem, "at", fixed), (None, None), bits)
    except NotExact:
        return _scanned(problem, record, unit, points)
    except UnclearError:
        raise ParameterError(
            f"the boundaries of {problem.family.name} cannot be separated at these numbers; give "
            "values nearer to 1."
        ) from None
    end = arb.pi() / 2 if record.by_angle else arb("inf")
    return [
        FlutterBoundary(candidate.value, below.look.sign > 0)
        for candidate, below, above in members.between()
        if not candidate.kinds & {"static", "pole", "edge"}
        and below.look.sign != above.look.sign
        and 0 < candidate.value < end
    ]


@lru_cache(maxsize=1)
def _scanned(
    problem: Problem, record: SteadyFamily, unit: float, points: int
) -> list[FlutterBoundary]:
    """The flutter boundaries along part of the line, bracketed between the points of a scan."""
    low, high = (v * unit for v in record.flutter or ())
    changes = along(problem, "at", low, high, points=points)
    name = problem.family.name
    warned(
        f"{name} under this law has no stored conditions: it was scanned from {low:.6g} to "
        f"{high:.6g} at {points} points; two boundaries between two points are not excluded."
    )
    return [
        FlutterBoundary(arb(b.value, b.error), b.stable_below)
        for b in changes
        if b.crossing is Crossing.FLUTTER
    ]


def _point(problem: Problem, mark: FlutterBoundary, unit: float) -> HopfPoint:
    values = {n: arb(float(v)) for n, v in problem.values.items()} | {"at": mark.value}
    a, q, rate = problem.reduce(values, lambda v: v.sqrt())
    pair = pair_at(problem.family, a[0], q)
    form = line_form(pair)
    sign = signed(form.speed) * signed(form.push)
    if not pair.value.overlaps(a[0]):
        raise NotProvedError
    kinds = {-1: HopfKind.ELLIPTIC, 0: HopfKind.DEGENERATE, 1: HopfKind.HYPERBOLIC}
    mode = np.array([complex(float(v.real.mid()), float(v.imag.mid())) for v in pair.mode])
    largest = mode[np.abs(mode).argmax()]
    return HopfPoint(
        float(mark.value.mid()),
        kinds[sign],
        mark.stable_below,
        float((pair.frequency * rate).mid()),
        float(form.speed.mid()),
        float(form.push.mid()),
        mode * abs(largest) / largest,
        unit,
    )


def pair_at(family: Family, at: Any, parameters: Sequence[Any]) -> Pair:
    """The crossing pair near a member of one of the disk's lines, proved.

    Parameters
    ----------
    family
        One of the disk's families, with one tangent.
    at, parameters
        Family parameter and parameters, dimensionless: doubles, taken as exact, or balls.

    Raises
    ------
    NotProvedError
        If none is proved there.
    """
    line = OneParameterFamily(
        family, family.at[0], dict(zip(family.parameters, parameters, strict=True))
    )
    return pair_near(line, float(arb(at).mid()))
