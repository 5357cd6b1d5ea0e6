"""Changes of verdict along an axis: proved brackets, the kind of crossing, and its frequency.

A boundary point is a root, along one axis, of the constant term (static boundary) or of the Hurwitz
determinant (flutter boundary) of the reduced characteristic polynomial.  The polynomial is
evaluated in balls from the family's graph.  The reported bracket is proved: Routh's array, in
balls, gives different verdicts at its two ends.

A `Boundaries` holds the changes, and the pieces that stay unresolved.
"""

from __future__ import annotations

import re
from abc import ABC, abstractmethod
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Any, ClassVar, NamedTuple, TypeVar, overload

import numpy as np
from flint import arb, ctx, fmpq_poly
from numpy.typing import NDArray

from ..algebra.exact.routh import hurwitz_determinant, hurwitz_sign, product, verdict_polynomial
from ..algebra.number_types import MIXED, balls, precision
from ..algebra.polynomial import TabulatedPolynomial
from ..base.errors import NoMemberError, StabilityError, warned
from ..base.printing import html_table, in_brackets, to_bound
from ..base.quantities import behind
from ..base.types import Sentences
from ..base.verdict import DECAYING, Evidence, Verdict
from ..polynomials.identities import MOST_STATES, certain, symmetric
from ..spectra.problem import Problem, formulas_of
from ..spectra.verdict_routes import ALONE, ANYTHING, BITS, GRAPH, Point, by_routh, decided
from ..storage.text import csv_text
from ..systems.closed_form import ClosedForm, RepeatedBalls
from ..systems.structure.enclosure import (
    ball_unknowns,
    characteristic,
    in_one_box,
    matrix_polynomial,
)
from ..systems.structure.structural_zeros import structure
from .pairs import frequency


class Crossing(Sentences):
    """Kind of crossing at a boundary; the value of each member is the sentence a user reads.

    A static boundary is that of divergence.

    Source: docs/explanation/method.md; planted boundaries: tests/boundary/test_boundaries.py.

    Examples
    --------
    >>> import stability as st
    >>> st.results.Crossing("static").word
    'static'
    """

    STATIC = "static boundary: a real eigenvalue (or λ² of a conservative law) passes through zero"
    FLUTTER = "flutter boundary: a pair of eigenvalues crosses the imaginary axis"
    TOUCHING = (
        "boundary without a sign change of either determinant: found by bisection of verdicts"
    )
    STATIC_AND_FLUTTER = (
        "static and flutter boundary: a zero and pairs of eigenvalues cross at once"
    )

    @property
    def word(self) -> str:
        """One lower-case word."""
        return self.name.lower()

    @property
    def code(self) -> int:
        """The flag value in files."""
        return list(type(self)).index(self)


@dataclass(frozen=True)
class BoundaryPoint:
    """One point at which the verdict changes along an axis.

    Source: docs/explanation/method.md; planted boundaries: tests/boundary/test_boundaries.py.

    Examples
    --------
    >>> import stability as st
    >>> [edge] = st.boundaries("rolling", axis=("at", 1, 2, 9), contact=st.Viscous(0.3))
    >>> edge.value, edge.crossing.word
    (1.4142135623730951, 'flutter')
    """

    value: float
    """Value of the axis, in the user's unit."""
    error: float
    """Half-width of the bracket, same unit: the verdicts at value ± error differ, which is proved
    unless `evidence` says by floats."""
    crossing: Crossing
    """Kind of crossing."""
    frequency: float
    """|Im λ| of the crossing pair, in the user's unit of rate; 0 at a static boundary."""
    stable_below: bool
    """Whether the side that is not unstable has the smaller value."""
    good: Verdict = Verdict.UNDECIDED
    """Verdict on this side, next to the boundary: stable, neutral, drifting, or undecided which."""
    frequencies: tuple[float, ...] = ()
    """Where several cross at once: |Im λ| of each, 0 for a real one, in increasing order."""
    evidence: Evidence = field(default=Evidence.PROVED, repr=False)
    """What it rests on; by floats for a system that is a Python function."""

    def words(self, unit: str = "1", rate: str = "1") -> str:
        """The boundary in words.

        Parameters
        ----------
        unit, rate
            Units of the axis and of frequencies.

        Examples
        --------
        >>> import stability as st
        >>> [edge] = st.boundaries("rolling", axis=("at", 1, 2, 9), contact=st.Viscous(0.3))
        >>> edge.words("√(g/R)", "√(g/R)")
        '1.4142135623730951 ± 2.7e-16 √(g/R)   flutter, stable above, frequency 2 √(g/R)'
        """
        side = "below" if self.stable_below else "above"
        verdict = "not unstable" if self.good is Verdict.UNDECIDED else self.good.word
        rates = self.frequencies or ((self.frequency,) if self.frequency else ())
        several = "frequencies" if self.frequencies else "frequency"
        pair = ", ".join(f"{w:.12g}" for w in rates)
        turning = f", {several} {pair}{behind(rate)}" if pair else ""
        kind = self.crossing.word.replace("_", " ")
        value = f"{to_bound(self.value, self.error)}{behind(unit)}"
        return f"{value}   {kind}, {verdict} {side}{turning}{_unproved(self.evidence)}"


@dataclass(frozen=True)
class AxisCrossing:
    """One value of an axis at which eigenvalues cross the imaginary axis.

    Source: planted crossings: tests/boundary/test_every_crossing.py.

    Examples
    --------
    >>> import stability as st
    >>> [change, _] = st.boundaries(
    ...     "spinning", axis=("at", 0.1, 5, 9), contact=st.Viscous(0.97), every=True
    ... )
    >>> change.value, change.crossing.word, change.unstable_below, change.unstable_above
    (2.0, 'static', 1, 0)
    """

    value: float
    """Value of the axis, in the user's unit."""
    error: float
    """Half-width of the proved bracket, same unit: nothing else crosses in it."""
    crossing: Crossing
    """What crosses: zeros, pairs, or both."""
    frequencies: tuple[float, ...]
    """|Im λ| of what is on the imaginary axis there, in the factors of the characteristic
    polynomial that cross, in the user's unit of rate: 0 for each zero, one number for each pair."""
    unstable_below: int
    """Number of unstable eigenvalues below the value, proved; zeros by structure do not count."""
    unstable_above: int
    """The same above it."""
    evidence: Evidence = field(default=Evidence.PROVED, repr=False)
    """As for `BoundaryPoint`."""

    def words(self, unit: str = "1", rate: str = "1") -> str:
        """The crossing in words; `unit` and `rate` as in `BoundaryPoint.words`."""
        several = len(self.frequencies) > 1
        rates = [f"{w:.12g}" for w in self.frequencies if several or w]
        turning = f"{', '.join(rates)}{behind(rate)}"
        turning = f", {'frequencies' if several else 'frequency'} {turning}" if rates else ""
        kind = self.crossing.word.replace("_", " ")
        value = f"{to_bound(self.value, self.error)}{behind(unit)}"
        sides = f"{self.unstable_below} unstable below, {self.unstable_above} above"
        return f"{value}   {kind}, {sides}{turning}{_unproved(self.evidence)}"


def _unproved(evidence: Evidence) -> str:
    return "" if evidence is Evidence.PROVED else f", {evidence.word}"


class Unresolved(NamedTuple):
    """A piece of an axis on which a change of verdict was not excluded, or not located.

    Source: docs/explanation/method.md; planted boundaries: tests/boundary/test_boundaries.py.

    Examples
    --------
    >>> import stability as st
    >>> st.boundaries("rolling", axis=("at", 1, 2, 9), contact=st.Viscous(0.3)).unresolved
    ()
    """

    low: float
    """Low end, in the user's unit."""
    high: float
    """High end; equal to `low` for one point."""
    reason: str
    """Reason, in one sentence."""


HERE = "whether the member of {family} there is neutral, between {sides} ones, is not decided"
LATE = (
    "the verdict changes here, but no two doubles next to the change have proved verdicts that "
    "differ: another change is too near"
)
"""Reasons, without a full stop."""


PointT = TypeVar("PointT", BoundaryPoint, AxisCrossing)


@dataclass(frozen=True, eq=False)
class AxisPoints(Sequence[PointT], ABC):
    """Points of an axis in increasing order, and the pieces that stay unresolved.

    A sequence that equals the list of its points, and is false if empty.
    """

    points: tuple[PointT, ...]
    """The points."""
    unresolved: tuple[Unresolved, ...] = ()
    """Pieces on which a point was not excluded, or not bracketed; each with a reason."""
    touching: tuple[float, ...] = ()
    """Values at which eigenvalues are on the imaginary axis, and both sides are alike."""
    how: str = ""
    """One sentence on how the axis was searched."""
    searched: tuple[str, float, float] | None = None
    """Name of the axis, and the closed interval that was searched; None where nobody said."""
    citation: str = ""
    """Keys of the works to cite, for `stability.citation`."""
    throughout: Verdict | int | None = None
    """What was proved on the whole interval, where it holds no point; None elsewhere."""
    note: str = ""
    """The law with its formula, where nobody has named it."""
    unit: str = "1"
    """Unit of the axis, in words where it is dimensionless."""
    rate_unit: str = "1"
    """Unit of frequencies."""

    one: ClassVar[str]
    """Name of a point."""
    several: ClassVar[str]
    """Name of points."""
    what: ClassVar[str]
    """What is sought along an axis."""
    alone: ClassVar[str]
    """What holds at a single value in `touching`."""

    @property
    @abstractmethod
    def constant(self) -> str:
        """What `throughout` says, in words; empty for nothing."""

    @abstractmethod
    def flat(self) -> tuple[list[str], list[list[Any]]]:
        """Header with units, and a row for each point."""

    @property
    def evidence(self) -> Evidence:
        """What the points rest on."""
        return next((p.evidence for p in self.points), Evidence.PROVED)

    @property
    def complete(self) -> bool:
        """Whether the points are proved to be all on the closed interval."""
        return not self.unresolved

    def __len__(self) -> int:
        return len(self.points)

    @overload
    def __getitem__(self, index: int) -> PointT: ...
    @overload
    def __getitem__(self, index: slice) -> list[PointT]: ...
    def __getitem__(self, index: int | slice) -> PointT | list[PointT]:
        return list(self.points)[index]

    def __iter__(self) -> Iterator[PointT]:
        return iter(self.points)

    def __eq__(self, other: object) -> bool:
        if isinstance(other, AxisPoints):
            return (self.points, self.unresolved) == (other.points, other.unresolved)
        if isinstance(other, (list, tuple)):
            return list(self.points) == list(other)
        return NotImplemented

    def __hash__(self) -> int:
        return hash(self.points)

    def __add__(self, other: Any) -> list[PointT]:
        return [*self.points, *other]

    def __radd__(self, other: Any) -> list[PointT]:
        return [*other, *self.points]

    def __repr__(self) -> str:
        where = ""
        if self.searched:
            axis, low, high = self.searched
            where = f" along {axis} from {low:.10g} to {high:.10g}{behind(self.unit)}"
        if self.note:
            where += f", {self.note}"
        if self.constant:
            where += f", {self.constant} throughout"
        state = f"; complete: {self.how}" if self.how else "; complete"
        if self.unresolved:
            state = f"; not complete, {len(self.unresolved)} unresolved: {self._first()}"
        said = (re.sub(" {3}", ", ", p.words(self.unit, self.rate_unit)) for p in self.points)
        points = f": {'; '.join(said)}" if self.points else ""
        points += self._alone()
        count = f"{len(self.points)} {self.one if len(self.points) == 1 else self.several}"
        return f"<{count}{where}{points}{state}>"

    @property
    def _error(self) -> str:
        """Heading of the errors."""
        return "error" if self.evidence is Evidence.PROVED else "error by floats"

    def to_csv(self) -> str:
        """The points as CSV: one header line with units, numbers with all their digits.

        Examples
        --------
        >>> import stability as st
        >>> changes = st.boundaries("rolling", axis=("at", 1, 2, 9), contact=st.Viscous(0.3))
        >>> changes.to_csv().splitlines()[0]
        'at [√(g/R)],error [√(g/R)],crossing,verdict,side,frequency [√(g/R)]'
        """
        return csv_text(*self.flat())

    def to_pandas(self) -> Any:
        """The points as a pandas DataFrame, with the header of the CSV."""
        import pandas as pd

        header, rows = self.flat()
        return pd.DataFrame(rows, columns=header)

    def _repr_html_(self) -> str:
        name = (self.searched or ("value",))[0]
        header, rows = self.flat()
        cells = [
            [f"{v:.15g}" if isinstance(v, float) else "" if v is None else str(v) for v in row]
            for row in rows
        ]
        head = repr(self)[1:-1].partition(": " if self.points else "; ")[0]
        return html_table(head, header if rows else [], cells, self.statement(name))

    def _first(self) -> str:
        first, more = self.unresolved[0], len(self.unresolved) - 1
        said = f"from {first.low:.10g} to {first.high:.10g}: {first.reason}"
        return said + (f" (and {more} more in .unresolved)" if more else "")

    def statement(self, axis: str) -> str:
        """One sentence on how the axis was searched and what was not excluded.

        Parameters
        ----------
        axis
            Name of the axis.
        """
        if not self.complete:
            return f"the search along {axis} is not complete; {self._first()}"
        if self.constant and self.searched:
            where = f"from {self.searched[1]:.10g} to {self.searched[2]:.10g}{behind(self.unit)}"
            said = f"no {self.what} along {axis} {where}, {self.constant} throughout"
        else:
            said = f"every {self.what} along {axis} was found"
        return f"{said}: {self.how}{self._alone()}."

    def _alone(self) -> str:
        return "".join(f"; at {value:.10g} {self.alone}" for value in self.touching)

    def warn(self, axis: str) -> None:
        """Issue a `StabilityWarning` where the search was not complete.

        Parameters
        ----------
        axis
            Name of the axis.
        """
        if not self.complete:
            warned(self.statement(axis))


@dataclass(frozen=True, eq=False, repr=False)
class Boundaries(AxisPoints[BoundaryPoint]):
    """Every change of verdict that a search found, in increasing order, and the unresolved pieces.

    A sequence that equals the list of its points, and is false if empty.  At the values in
    `touching` alone the verdict is neutral: stable on both sides, or unstable on both.

    Source: docs/explanation/method.md; planted boundaries: tests/boundary/test_boundaries.py.

    Examples
    --------
    >>> import stability as st
    >>> changes = st.boundaries("rolling", axis=("at", 0.1, 1, 9), contact=st.Smooth())
    >>> len(changes), changes[0].value, changes.complete, changes.unresolved
    (1, 1.0, True, ())
    >>> changes == [changes[0]], bool(changes)
    (True, True)
    """

    throughout: Verdict | None = None
    """The one verdict on the whole interval, where it was proved not to change; None elsewhere."""
    one, several, what = "boundary", "boundaries", "change of verdict"
    alone = "alone it is neutral"

    @property
    def constant(self) -> str:
        """The one verdict, as a word."""
        return self.throughout.word if self.throughout else ""

    def flat(self) -> tuple[list[str], list[list[Any]]]:
        """Header with units, and a row for each boundary."""
        name, unit = (self.searched or ("value",))[0], in_brackets(self.unit)
        header = [f"{name}{unit}", f"{self._error}{unit}", "crossing", "verdict", "side"]
        rows = [
            [
                b.value,
                b.error,
                b.crossing.word.replace("_", " "),
                "not unstable" if b.good is Verdict.UNDECIDED else b.good.word,
                "below" if b.stable_below else "above",
                "; ".join(repr(w) for w in b.frequencies) or b.frequency or None,
            ]
            for b in self.points
        ]
        return [*header, f"frequency{in_brackets(self.rate_unit)}"], rows


@dataclass(frozen=True, eq=False, repr=False)
class Crossings(AxisPoints[AxisCrossing]):
    """Every value of an axis at which eigenvalues cross the imaginary axis, as `Boundaries`.

    At the values in `touching` eigenvalues reach the imaginary axis, and as many are unstable on
    both sides.

    Source: planted crossings: tests/boundary/test_every_crossing.py.

    Examples
    --------
    >>> import stability as st
    >>> edges = st.boundaries("rolling", axis=("at", 0.1, 5, 9), contact=st.Viscous(1), every=True)
    >>> [(c.unstable_below, c.unstable_above) for c in edges], edges.complete
    ([(1, 2), (2, 0)], True)
    """

    throughout: int | None = None
    """The number of unstable eigenvalues on the whole interval, where none crosses."""
    one, several, what = "crossing", "crossings", "crossing of the imaginary axis"
    alone = "eigenvalues reach the imaginary axis, and as many are unstable on both sides"

    @property
    def constant(self) -> str:
        """The number of unstable eigenvalues, in words."""
        number = self.throughout
        return "" if number is None else f"{number} unstable eigenvalue{'s' * (number != 1)}"

    def flat(self) -> tuple[list[str], list[list[Any]]]:
        """Header with units, and a row for each crossing."""
        name, unit = (self.searched or ("value",))[0], in_brackets(self.unit)
        sides = ["unstable below", "unstable above"]
        header = [f"{name}{unit}", f"{self._error}{unit}", "crossing", *sides]
        rows: list[list[Any]] = [
            [
                c.value,
                c.error,
                c.crossing.word.replace("_", " "),
                c.unstable_below,
                c.unstable_above,
                "; ".join(map(repr, c.frequencies)),
            ]
            for c in self.points
        ]
        return [*header, f"frequencies{in_brackets(self.rate_unit)}"], rows


def bracket(
    sign: Callable[[float], int], root: float, room: float = np.inf
) -> tuple[float, bool] | None:
    """The narrowest bracket about a root, of a few tried, whose verdicts are proved to differ.

    Parameters
    ----------
    sign
        The proved verdict at a value of the axis: 1, -1, or 0 where none is proved.
    root
        Value of the axis.
    room
        Distance to the next root.

    Returns
    -------
    width, stable_below
        Half-width, and whether the stable side is below; None if no bracket is proved.
    """
    width = float(np.spacing(abs(root))) if root else 1e-300
    while width <= min(1e-6 * max(abs(root), 1e-3), 0.9 * room):
        below, above = sign(root - width), sign(root + width)
        if below and above and below != above:
            return width, below > 0
        width *= 2 if root else 1024
    return None


LADDER = (128, 256, 512, 1024)
"""Precisions of a sign, in turn; one that is still open then counts as zero."""
MOST_BITS = LADDER[-1]
FINE_BITS = 8192
"""Precision at which a bracket is halved further."""
SHORT_WAY = 1e-15
"""Way from a boundary to where its unstable eigenvalues are counted, over the value or 1e-3."""
ZERO = 1e-9
"""Frequency, over the largest eigenvalue, up to which an eigenvalue at a boundary is zero."""
LOW = 1e-3
"""Frequency, over the largest eigenvalue, below which an eigenvalue counts as real there."""
ON_AXIS = 1e-7
"""Largest real part, over the largest eigenvalue, of one that may be on the axis at a boundary."""
NOISE = 1e-60
"""Real part, over the largest eigenvalue, below which one next to a boundary counts as on the axis;
rounding is smaller where up to four eigenvalues coincide, and what crosses is larger."""
HALVINGS = 256
"""Most halvings of a bracket in which a zero eigenvalue is not excluded.

At the double next to an exact angle a term may be the fourth power of 2⁻⁵²."""


class LinePoint(Point):
    """A point of a line, whose polynomial comes from the line."""

    def __init__(self, line: AxisScan, value: float) -> None:
        super().__init__(line.problem, line.fixed | {line.axis: value})
        self.line, self.value = line, value
        self.has = {ANYTHING, ALONE} if line.problem.derived else {ANYTHING, ALONE, GRAPH}
        large = len(line.problem.family.system.states) > MOST_STATES  # over Q is slower
        self.quick = LADDER if line.problem.derived or large else (BITS,)

    def coefficients(self, bits: int) -> Sequence[Any] | None:
        """The characteristic polynomial in balls."""
        return self.line.coefficients(self.value, bits)

    @property
    def stays(self) -> bool:
        """Whether all eigenvalues of a neutral member are on the axis; otherwise one crosses it."""
        flags = self.member.flags
        return all(flags[self.zeros + 1 :: 2]) and not flags[self.zeros]


class AxisScan:
    """A family along one axis, all other quantities fixed, evaluated in balls.

    Parameters
    ----------
    problem
        Family with values in the user's units.
    axis
        Name of the axis.
    fixed
        Value of every other quantity.
    """

    def __init__(self, problem: Problem, axis: str, fixed: Mapping[str, float]) -> None:
        self.problem, self.axis, self.fixed = problem, axis, dict(fixed)
        self.neutral: bool | None = None
        """Whether neutral members are on the good side; None: each is judged by itself."""
        self._near: list[float] | None = None
        self._solution: tuple[int, list[Any], list[Any]] | None = None
        self._known: dict[tuple[float, int], list[Any]] = {}
        self._proofs: dict[float, tuple[Verdict, bool]] = {}
        self._formulas: dict[int, RepeatedBalls] = {}

    def numbers_at(self, value: Any) -> tuple[list[Any], list[Any]]:
        """Family parameters and parameters at a number, a ball or a series of the axis."""
        return self.problem.balls(self.fixed | {self.axis: value})

    def followed(self, values: Sequence[Any]) -> list[list[float] | None]:
        """Unknowns of many members in double precision, followed all at once; None without one."""
        with precision(BITS):
            parameters = [self.numbers_at(arb(v)) for v in values]
        a, q = (
            np.array([[float(v.mid()) for v in pair[i]] for pair in parameters]).reshape(
                len(parameters), -1
            )
            for i in (0, 1)
        )
        members = self.problem.family.search(a, q)
        return [
            u.tolist() if good else None for good, u in zip(members.good, members.u, strict=True)
        ]

    def rate(self, value: float) -> float:
        """The user's unit of rate."""
        *_, rate, _ = self.problem.arrays(self.fixed | {self.axis: value})
        return float(rate[0])

    @cached_property
    def even(self) -> bool:
        """Whether λ² decides: the family is conservative, or proved symmetric under λ → -λ."""
        return self.problem.family.conservative or symmetric(self.problem.family)

    def coefficients(self, value: float, bits: int) -> list[Any]:
        """Characteristic polynomial at a point of the line, at a precision in bits; cached."""
        key = value, bits
        if key not in self._known:
            self._known[key] = self.enclosed(value, bits)
        return self._known[key]

    def enclosed(self, value: Any, bits: int) -> list[Any]:
        """The same for every value in a ball; not cached."""
        family = self.problem.family
        with precision(bits):
            a, q = self.numbers_at(value)
            form = self.formulas
            if form is not None:
                formulas = self._formulas.setdefault(bits, RepeatedBalls(form))
                return form.polynomial(a, q, formulas)
            if not family.unknown or family.closed:
                return characteristic(family, a, q)
            # a member that is not unique is found from the family's guess alone
            for near in (self._near, None) if self.problem.derived else (None,):
                try:
                    return self._solved(a, q, near)
                except NoMemberError:
                    continue
            # where the family's equation is singular, as at tumbling's branch point
            return self._exact(value) or self._solved(a, q, None)

    def determinant(self, value: float) -> Any:
        """The determinant of algebraic equations at a point of the line, a ball."""
        family = self.problem.family
        a, q = self.numbers_at(value)
        u = ball_unknowns(family, a, q)
        return family.graph.determinant.dense(balls(), [a, u, q])[0][0]

    @cached_property
    def formulas(self) -> ClosedForm | None:
        """Formulas of the family, or None."""
        return formulas_of(self.problem.family)

    def _exact(self, value: float) -> list[Any] | None:
        """The characteristic polynomial from the one over Q, where that is known."""
        exact = self.problem.exact
        if not isinstance(exact, TabulatedPolynomial):
            return None
        values = {n: arb(v) for n, v in self.problem.rationals(self.fixed).items()}
        values[self.axis] = arb(float(value))
        scale = arb(exact.natural(exact.point(values, MIXED))).sqrt()
        factors = exact.coefficients(values, MIXED)
        scaled = [[c / scale**i for i, c in enumerate(factor)] for factor in factors]
        return [arb(0)] * exact.zeros + product(scaled)

    def _solved(self, a: list[Any], q: list[Any], near: list[float] | None) -> list[Any]:
        family = self.problem.family
        # quantities that are not in the equation (mu, for the disk) change without a new solution
        used = [(*a, *q)[i] for i in family.graph.used]
        if self._solution and self._solution[0] == ctx.prec and self._solution[1] == used:
            return matrix_polynomial(family, a, self._solution[2], q)
        unknowns = ball_unknowns(family, a, q, near)
        self._solution = ctx.prec, used, unknowns
        self._near = [float(v.mid()) for v in unknowns]
        for name, value in zip(family.unknown, self._near, strict=True):
            if name in family.positive and value <= 0:
                raise NoMemberError(f"{family.name}: {name} came out as {value:.3g}, not positive.")
        return matrix_polynomial(family, a, unknowns, q)

    def joined(self, low: float, middle: float, high: float) -> bool:
        """Whether members at both ends are in a box about the one at the middle, a single root."""
        if self.problem.derived or self.formulas is not None:
            return True
        with precision(BITS):
            places = [
                self.numbers_at(v)
                for v in (arb(middle), arb(low).union(arb(high)), arb(low), arb(high))
            ]
            return in_one_box(self.problem.family, *places)

    def polynomial(self, value: float, bits: int = BITS) -> list[Any]:
        """The polynomial whose Hurwitz stability is the verdict."""
        return self._verdict_polynomial(self.coefficients(value, bits))

    def sign(self, value: float) -> int:
        """Proved verdict: 1 stable or neutral, -1 unstable, 0 on the boundary or undecided."""
        return self.sign_of(*self._proved(value))

    def quick_sign(self, value: float) -> int:
        """Verdict in the search for a bracket, as `sign`; structural zeros may lack a proof."""
        return self.sign_of(*self.look(value))

    def sign_of(self, verdict: Verdict, generic: bool) -> int:
        """A verdict as a sign."""
        if verdict is Verdict.NEUTRAL:
            return int(generic if self.neutral is None else self.neutral)
        return 1 if verdict in DECAYING else -int(verdict is Verdict.UNSTABLE)

    def look(self, value: float) -> tuple[Verdict, bool]:
        """The verdict for `quick_sign`; if neutral, whether verdicts on one side may be too."""
        family = self.problem.family
        if not self.problem.derived and not certain(family):
            with precision(BITS):
                dropped = self.coefficients(value, BITS)[: structure(family).zeros]
                if all(c.contains(0) for c in dropped):
                    verdict = by_routh(family, self.coefficients(value, BITS), len(dropped))
                    if verdict is not None:
                        return verdict, self.even
        return self._proved(value)

    def _proved(self, value: float) -> tuple[Verdict, bool]:
        if value not in self._proofs:
            point = LinePoint(self, value)
            proof = decided(point)
            generic = proof.nearby or (proof.verdict is Verdict.NEUTRAL and point.stays)
            self._proofs[value] = proof.verdict, generic
        return self._proofs[value]

    def vanishing(self, value: float, width: float, otherwise: Crossing) -> Crossing:
        """What crosses within a proved bracket: a pair where no eigenvalue is zero in all of it.

        Parameters
        ----------
        value, width
            Middle and half-width of the bracket.
        otherwise
            The answer where no member is proved over the bracket.
        """
        with precision(FINE_BITS):  # exact
            ends = arb(value) - arb(width), arb(value) + arb(width)
        try:
            with precision(BITS):
                if not self._at(ends[0].union(ends[1]), BITS)[0].contains(0):
                    return Crossing.FLUTTER
            with precision(FINE_BITS):
                zero = self._halved(*ends)
        except (StabilityError, ArithmeticError):  # no member is proved over the bracket
            return otherwise
        return Crossing.STATIC if zero else Crossing.FLUTTER

    def _at(self, value: Any, bits: int) -> list[Any]:
        """The polynomial whose Hurwitz stability is the verdict, at a ball."""
        return self._verdict_polynomial(self.enclosed(value, bits))

    def _verdict_polynomial(self, coefficients: Sequence[Any]) -> list[Any]:
        return verdict_polynomial(coefficients, structure(self.problem.family).zeros, self.even)

    def _halved(self, low: Any, high: Any) -> bool:
        """Whether the constant term is not proved to differ from zero where the verdict changes."""
        first = hurwitz_sign(self._at(low, FINE_BITS))
        for _ in range(HALVINGS):
            if not self._at(low.union(high), FINE_BITS)[0].contains(0):
                return False
            middle = ((low + high) / 2).mid()
            p = self._at(middle, FINE_BITS)
            sign = hurwitz_sign(p)
            if not sign or not first:
                return bool(p[0].contains(0))
            low, high = (middle, high) if sign == first else (low, middle)
        return True

    def function(self, crossing: Crossing) -> Callable[[float], float]:
        """Function of the axis whose sign changes at a crossing: a float with the proved sign."""

        def signed(value: float) -> float:
            bits = BITS
            while bits <= MOST_BITS:
                with precision(bits):
                    p = self.polynomial(value, bits)
                    number = p[0] if crossing is Crossing.STATIC else hurwitz_determinant(p)
                    if not number.contains(0):
                        size = float(number.mid())
                        return size if size else (1e-300 if number > 0 else -1e-300)
                bits *= 2
            return 0.0

        return signed


def refine(line: AxisScan, low: float, high: float) -> BoundaryPoint | None:
    """The boundary between two points of a line whose verdicts differ.

    Parameters
    ----------
    line
        The line.
    low, high
        Two values of its axis, low < high.

    Returns
    -------
    BoundaryPoint or None
        None if the verdicts at the two ends are the same, or no bracket is proved.
    """
    signs = line.quick_sign(low), line.quick_sign(high)
    if signs[0] == signs[1] and signs[0]:
        return None
    for end, sign in zip((low, high), signs, strict=True):
        if not sign:
            return at_point(line, end)
    # to a zero at 0 itself bisection would take a thousand halvings
    if low < 0 < high and not line.quick_sign(0.0) and (point := at_point(line, 0.0)):
        return point
    point = _crossing(line, low, high)
    if point is not None:
        return point
    for end, other, beyond in ((low, high, signs[1]), (high, low, signs[0])):
        if line.quick_sign(float(np.nextafter(end, other))) == beyond:
            return at_point(line, end)  # only the end itself differs, as without any damping
    # Both determinants may change sign an even number of times: find the change of verdict first.
    root = zero_between(lambda v: float(line.quick_sign(v)), low, high)
    for width in (1e-6, 1e-9, 1e-12):
        near = max(low, root - width * abs(root)), min(high, root + width * abs(root))
        point = _crossing(line, *near)
        if point is not None:
            return point
    return bracketed(line, root, Crossing.TOUCHING)


def zeros(line: AxisScan, low: float, high: float) -> list[float]:
    """A zero between two points of each determinant that changes its sign, as proved in balls."""
    functions = [line.function(c) for c in (Crossing.STATIC, Crossing.FLUTTER)]
    return [zero_between(f, low, high) for f in functions if f(low) * f(high) < 0]


def _crossing(line: AxisScan, low: float, high: float) -> BoundaryPoint | None:
    """A change of verdict at a zero of one of the two determinants, if one changes sign."""
    for crossing in (Crossing.STATIC, Crossing.FLUTTER):
        f = line.function(crossing)
        if f(low) * f(high) < 0:
            point = bracketed(line, zero_between(f, low, high), crossing)
            if point is not None:
                return point
    return None


def zero_between(f: Callable[[float], float], low: float, high: float) -> float:
    """A zero between two numbers at which the signs of a function differ."""
    from scipy.optimize import brentq

    return float(brentq(f, low, high, xtol=1e-300, rtol=4 * np.finfo(float).eps, maxiter=5000))


def bracketed(
    line: AxisScan, root: float, crossing: Crossing, *, sure: bool = False
) -> BoundaryPoint | None:
    """The boundary at a root that is known to double precision; None where none is proved.

    `sure` says that what crosses is proved.
    """
    proof = bracket(line.sign, root)
    if proof is None or not line.joined(root - proof[0], root, root + proof[0]):
        return None  # from one branch to another the verdict changes without a crossing
    if crossing is not Crossing.STATIC and not sure:  # real eigenvalues may cross two at a time
        crossing = line.vanishing(root, proof[0], crossing)
    return BoundaryPoint(root, proof[0], crossing, crossing_rate(line, root, crossing), proof[1])


def crossing_rate(line: AxisScan, root: float, crossing: Crossing) -> float:
    """|Im λ| of the pair that crosses, in the user's unit of rate; 0 at a static boundary."""
    if crossing is Crossing.STATIC:
        return 0.0
    family = line.problem.family
    with precision(BITS):
        coefficients = line.coefficients(root, BITS)[structure(family).zeros :]
    value = frequency(coefficients, even=line.even)
    return value * line.rate(root)


def crossed(line: AxisScan, point: BoundaryPoint) -> BoundaryPoint:
    """A boundary with kind and frequencies of what crosses there, not of what touches the axis.

    The eigenvalues that are unstable next to the boundary are those that have crossed it.
    """
    if line.even or point.crossing not in (Crossing.STATIC, Crossing.FLUTTER):
        return point
    way = max(SHORT_WAY * max(abs(point.value), 1e-3), point.error)
    way = way if point.stable_below else -way
    try:
        here, beyond = (_roots(line, v) for v in (point.value, point.value + way))
    except (StabilityError, ArithmeticError):  # no member is proved next to the boundary
        return point
    largest = float(np.abs(here).max(initial=0.0))
    turns = np.abs(here.imag[np.abs(here.real) <= ON_AXIS * largest])
    unstable = np.abs(beyond.imag[beyond.real > NOISE * largest])
    unclear = (turns > ZERO * largest) & (turns < LOW * largest)
    if not turns.size or not unstable.size or unclear.any():
        return point
    turns[turns <= LOW * largest] = 0.0
    unstable[unstable <= (LOW * largest or np.inf)] = 0.0
    nearest = np.abs(unstable[:, None] - turns).argmin(axis=1)
    if not np.allclose(unstable, turns[nearest], rtol=LOW, atol=0):
        return point
    zeros = int((unstable == 0).sum())
    pairs = np.sort(turns[nearest][unstable > 0])[::2]
    frequencies = (0.0,) * zeros + tuple((pairs * line.rate(point.value)).tolist())
    kind, first = Crossing.STATIC, 0.0
    if len(pairs):
        kind = Crossing.STATIC_AND_FLUTTER if zeros else Crossing.FLUTTER
        first = frequencies[zeros]
    if len(frequencies) == 1:
        same = kind is point.crossing and abs(first - point.frequency) <= LOW * first
        return point if same else replace(point, crossing=kind, frequency=first)
    return replace(point, crossing=kind, frequency=first, frequencies=frequencies)


def _roots(line: AxisScan, value: float) -> NDArray[np.complex128]:
    """Eigenvalues at a value of the axis, without structural zeros."""
    with precision(MOST_BITS):  # roots that coincide part by their multiplicity's root of rounding
        coefficients = line.coefficients(value, MOST_BITS)[structure(line.problem.family).zeros :]
        roots = fmpq_poly([arb(c).mid().fmpq() for c in coefficients]).numer().complex_roots()
        return np.array([complex(r) for r, count in roots for _ in range(count)])


def at_point(line: AxisScan, value: float) -> BoundaryPoint | None:
    """The boundary at a point where no verdict is proved, if the verdicts next to it differ."""
    with precision(MOST_BITS):  # to see which of the two determinants vanishes
        p = line.polynomial(value, MOST_BITS)
        crossing = Crossing.STATIC if p[0].contains(0) else Crossing.FLUTTER
    return bracketed(line, value, crossing)
