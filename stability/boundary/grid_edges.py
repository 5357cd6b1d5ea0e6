"""Edges of a grid on which the verdict changes, all bracketed together.

Every kind of family has its characteristic polynomial in any number type: from stored factors, from
formulas, or from its graph.  Routh's array gives the functions of which one vanishes where the
verdict changes.  In doubles they lead to the root; in numbers of two doubles
(`stability.algebra.double_double`) they prove that the verdicts at both ends of a bracket of a few
units in the last place differ, and, over the bracket as a ball, what crosses there.

What stays open is left to balls: a root of higher order, a verdict that Routh's array does not
prove, a family whose structure is not proved.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import suppress
from dataclasses import dataclass
from functools import cached_property, reduce
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..algebra.double_double import DOUBLE_DOUBLE, DoubleDouble, exact
from ..algebra.exact.number_fields import characteristic
from ..algebra.exact.routh import routh, verdict_polynomial
from ..algebra.krawczyk import many_proved
from ..algebra.number_types import Algebra, numpy_algebra
from ..algebra.polynomial import TabulatedPolynomial
from ..base.errors import StabilityError
from ..base.types import Floats
from ..polynomials.identities import certain, symmetric
from ..spectra.problem import Problem, formulas_of
from ..systems.sources.numeric import NumericSystem
from ..systems.structure.structural_zeros import structure
from .brackets import BoundaryPoint, Crossing

MOST_STATES = 8
"""Most states of a graph whose polynomial is expanded number by number."""
STEPS = 60
"""Most steps of the search in doubles."""
CLOSE = 1e-9
"""Width of the search's last bracket, over the edge."""
AT_END = 1e-12
"""Value at an end, over the other one, at which the root is taken to be that end."""
APART = 1e-5
"""Distance of the points between which a slope is taken, over the edge."""
ROUNDS = 6
"""Brackets that are tried, about a nearer root or twice as wide as the one before."""
NEAR_ZERO = 1e-15
"""Root, over the edge, that is taken to be 0."""
LEAST = 1e-300
"""Half-width of a bracket about 0."""
PLAIN = numpy_algebra()


@dataclass(frozen=True)
class Edges:
    """Edges along either axis of a grid; all arrays have one entry for each."""

    axis: NDArray[np.int8]
    """0 for x or 1 for y."""
    low: Floats
    """Low end."""
    high: Floats
    """High end."""
    other: Floats
    """Value of the other axis."""

    def __getitem__(self, some: Any) -> Edges:
        return Edges(*(v[some] for v in vars(self).values()))

    def places(self, values: Floats) -> tuple[Floats, Floats]:
        """Values of both axes, at one along each edge."""
        x, y = (np.where(self.axis == k, values, self.other) for k in (0, 1))
        return x, y


@dataclass(frozen=True)
class Reading:
    """What Routh's array says at points."""

    functions: list[Any]
    """For each factor its constant term, then its last Hurwitz determinant but one, in doubles."""
    constants: list[Any]
    """Proved sign of each constant term."""
    sign: Any
    """Proved verdict: 1, -1, or 0."""
    squares: list[Any]
    """For each factor the square of the frequency of a pair that crosses."""
    boxes: Sequence[DoubleDouble] = ()
    """Where unknowns are solved for: boxes in which each is the only root."""

    def joined(self, count: int) -> Any:
        """Whether members at both ends of brackets are in the box of the members between them."""
        same = np.ones(count, dtype=bool)
        for box in self.boxes:
            (*hi, middle), (*lo, rest) = box.hi.reshape(3, count), box.lo.reshape(3, count)
            for end, small in zip(hi, lo, strict=True):
                same &= np.abs((end - middle) + (small - rest)) < box.error.reshape(3, count)[2] / 2
        return same


class _Polynomials(NamedTuple):
    """The characteristic polynomial at points, in a number type."""

    factors: Sequence[Sequence[Any]]
    """Coefficients of each factor, lowest first."""
    positive: Sequence[Any] = ()
    """Numbers that are positive at members."""
    boxes: Sequence[DoubleDouble] = ()
    """As in `Reading`."""


class GridPolynomials:
    """The characteristic polynomial of a problem at scattered points of two axes.

    Parameters
    ----------
    problem
        Family with values in the user's units.
    names
        Names of both axes.
    """

    def __init__(self, problem: Problem, names: tuple[str, str]) -> None:
        self.problem, self.names = problem, names
        self.fixed = {n: float(v) for n, v in problem.values.items() if n not in names}

    @cached_property
    def stored(self) -> TabulatedPolynomial | None:
        """The stored polynomial, where it is proved for every member."""
        exact = self.problem.exact
        return exact if isinstance(exact, TabulatedPolynomial) else None

    @cached_property
    def even(self) -> bool:
        """Whether λ² decides."""
        if self.stored is not None:
            return self.stored.known.even
        return self.problem.family.conservative or symmetric(self.problem.family)

    @cached_property
    def readable(self) -> bool:
        """Whether the polynomial is that of every member, and has few enough terms."""
        family = self.problem.family
        if self.stored is not None:
            return True
        if isinstance(family.system, NumericSystem) or not certain(family):
            return False
        return formulas_of(family) is not None or len(family.system.states) <= MOST_STATES

    def signs(self, x: Floats, y: Floats) -> NDArray[np.int_]:
        """Proved verdicts at points: 1, -1, or 0 where open.

        Parameters
        ----------
        x, y
            Values of both axes.
        """
        if len(x) and self.readable:
            with suppress(StabilityError, ArithmeticError):
                return np.asarray(self(DOUBLE_DOUBLE, DoubleDouble(x), DoubleDouble(y)).sign)
        return np.zeros(len(x), dtype=int)

    def separated(self, edges: Edges) -> NDArray[np.bool_]:
        """Edges whose ends are proved to lie on two sides of a branch point, or on two sheets.

        Where every state is solved for, the constant term is the determinant by which members are
        isolated: no box of one member holds both ends.
        """
        family = self.problem.family
        none = np.zeros(len(edges.axis), dtype=bool)
        if not len(none) or self.stored is not None or not self.readable:
            return none
        if formulas_of(family) is not None or family.closed:
            return none
        if {*family.unknown} != {*family.system.states}:
            return none
        with suppress(StabilityError, ArithmeticError):
            low, high = (
                self(DOUBLE_DOUBLE, *map(DoubleDouble, edges.places(end)))
                for end in (edges.low, edges.high)
            )
            at_low, at_high = low.functions[1], high.functions[1]
            return np.asarray((low.constants[0] * high.constants[0] < 0) & (at_low * at_high > 0))
        return none

    def _read(self, algebra: Algebra, values: dict[str, Any]) -> _Polynomials:
        if self.stored is not None:
            return _Polynomials([list(f) for f in self.stored.coefficients(values, algebra)])
        family = self.problem.family
        a, q, _ = self.problem.reduce(values, algebra.functions["sqrt"])
        formulas = formulas_of(family)
        if formulas is not None:
            coefficients, _, positive = formulas(algebra, a, q)
            return _Polynomials([coefficients], positive)
        u, boxes = self._unknowns(algebra, a, q)
        # values at scattered points, of any graph; a zero that is no number costs no product
        table = family.graph.matrix.dense(algebra, [a, u, q], zero=0)
        positive = [v for n, v in zip(family.unknown, u, strict=True) if n in family.positive]
        return _Polynomials([characteristic(table)[structure(family).zeros :]], positive, boxes)

    def _unknowns(
        self, algebra: Algebra, a: list[Any], q: list[Any]
    ) -> tuple[list[Any], list[DoubleDouble]]:
        """Unknowns of members, and boxes in which each is the only root, where one is sought."""
        family = self.problem.family
        if not family.unknown or family.closed:
            return [algebra.constant(v) for v in family.unknown.values()], []
        rows = np.array(np.broadcast_arrays(*map(_double, (*a, *q)))).T
        members = family.search(rows[:, : len(a)], rows[:, len(a) :])
        near = np.where(members.good[:, None], members.u, np.nan)
        if algebra is PLAIN:
            return list(near.T), []

        def equations(u: list[Any]) -> Any:
            values, slopes = family.graph.residual.run(algebra, [a, u, q])
            return values, family.graph.place(slopes)

        proved, widths = many_proved(equations, near)
        boxes = [DoubleDouble(v.hi, v.lo, w) for v, w in zip(proved, widths.T, strict=True)]
        return proved, boxes

    def __call__(self, algebra: Algebra, x: Any, y: Any) -> Reading:
        """Routh's array at points, numbers of an algebra: doubles, or with proved signs."""
        values: dict[str, Any] = dict(self.fixed)
        if algebra is DOUBLE_DOUBLE:
            values = {n: exact(v) for n, v in self.problem.rationals(self.fixed).items()}
        values |= dict(zip(self.names, (x, y), strict=True))
        with np.errstate(all="ignore"):
            polynomials = self._read(algebra, values)
            readings = [self._routh(f) for f in polynomials.factors if len(f) > 1]
            sign = reduce(_both, (r.sign for r in readings))
            for number in polynomials.positive:
                sign = np.where(_sign(number) > 0, sign, 0)
        shape = np.shape(_double(x))

        def spread(numbers: Iterator[Any]) -> list[Any]:
            return [np.broadcast_to(v, shape) for v in numbers]

        return Reading(
            spread(f for r in readings for f in r.functions),
            spread(c for r in readings for c in r.constants),
            np.broadcast_to(sign, shape),
            spread(s for r in readings for s in r.squares),
            polynomials.boxes,
        )

    def _routh(self, factor: Sequence[Any]) -> Reading:
        p = verdict_polynomial(factor, 0, self.even)
        lead = _sign(p[-1])
        if np.any(lead < 0):
            turn = np.where(lead < 0, -1.0, 1.0)
            p = [c * turn for c in p]
        column = list(routh(p))
        unstable, stable = False, lead != 0
        for c in p:
            unstable = unstable | (_sign(c) < 0)
        for number in column[1:]:
            sign = _sign(number)
            unstable = unstable | (stable & (sign < 0))
            stable = stable & (sign > 0)
        determinant: Any = 1.0
        for number in column[1:-1]:
            determinant = determinant * _double(number)
        constant = _double(p[0])
        square = constant / _double(column[-3]) if len(column) > 2 else np.nan * constant
        verdict = np.where(unstable & (lead != 0), -1, np.where(stable, 1, 0))
        return Reading([constant, determinant], [_sign(p[0])], verdict, [square])


def rates(polynomials: GridPolynomials, x: Floats, y: Floats, square: Floats) -> Floats:
    """Frequencies in the user's unit of rate.

    Parameters
    ----------
    polynomials
        The polynomial.
    x, y
        Points.
    square
        Squares of the frequencies in the unit of the polynomial.
    """
    values = {**polynomials.fixed, **dict(zip(polynomials.names, (x, y), strict=True))}
    if polynomials.stored is not None:
        unit, unit_square = polynomials.stored.scale(values)
    else:
        unit, unit_square = polynomials.problem.arrays(values)[2], None
    frequencies: Floats = np.sqrt(square * unit_square) if unit is None else np.sqrt(square) * unit
    return frequencies


def _double(number: Any) -> Any:
    return number.hi if isinstance(number, DoubleDouble) else np.asarray(number, dtype=float)


def _sign(number: Any) -> Any:
    return number.sign() if isinstance(number, DoubleDouble) else np.sign(number)


def _both(first: Any, second: Any) -> Any:
    """The verdict of a product of polynomials."""
    return np.where((first < 0) | (second < 0), -1, np.minimum(first, second))


def bracketed(polynomials: GridPolynomials, edges: Edges) -> list[BoundaryPoint | None]:
    """The boundary on each edge whose ends differ in verdict; None where it stays open.

    Parameters
    ----------
    polynomials
        The polynomial of the family.
    edges
        The edges.
    """
    points: list[BoundaryPoint | None] = [None] * len(edges.axis)
    if not points or not polynomials.readable:
        return points
    with np.errstate(all="ignore"), suppress(StabilityError, ArithmeticError):
        search = EdgeSearch(polynomials, edges)
        root = search.between()
        some = np.flatnonzero(np.isfinite(root))
        if len(some):
            inner = EdgeSearch(polynomials, edges[some], [s[some] for s in search.sizes])
            for k, point in inner.proved(inner.polished(root[some])):
                points[some[k]] = point
    return points


class EdgeSearch:
    """Functions along edges, of which the least vanishes where the verdict changes.

    Parameters
    ----------
    polynomials, edges
        As for `bracketed`.
    sizes
        The larger size of each function at both ends; computed when left out.
    """

    def __init__(
        self, polynomials: GridPolynomials, edges: Edges, sizes: list[Floats] | None = None
    ) -> None:
        self.polynomials, self.edges = polynomials, edges
        self.width = edges.high - edges.low
        self.sizes = sizes or [
            np.maximum(np.abs(a), np.abs(b))
            for a, b in zip(*(reading.functions for reading in self.ends), strict=True)
        ]

    @cached_property
    def ends(self) -> tuple[Reading, Reading]:
        """The polynomial at the low and the high end of each edge."""
        return self._at(PLAIN, self.edges.low), self._at(PLAIN, self.edges.high)

    def _at(
        self, algebra: Algebra, root: Floats, some: Any = slice(None), error: Any = 0.0
    ) -> Reading:
        """The polynomial at one value on each of some edges."""
        edges = self.edges[some]
        x, y = edges.places(root)
        if algebra is PLAIN:
            return self.polynomials(algebra, x, y)
        along = (np.where(edges.axis == k, error, 0.0) for k in (0, 1))
        return self.polynomials(
            algebra, *(DoubleDouble(v, 0.0, e) for v, e in zip((x, y), along, strict=True))
        )

    def _least(self, reading: Reading, some: Any = slice(None)) -> Floats:
        """The least function over its size; not negative where the member is not unstable."""
        scaled = [f / s[some] for f, s in zip(reading.functions, self.sizes, strict=True)]
        out: Floats = np.min(scaled, axis=0)
        return out

    def between(self) -> Floats:
        """The root between the ends to about ten digits, by inverse interpolation or bisection.

        Source: T. R. Chandrupatla, Adv. Eng. Softw. 28 (1997) 145-149.
        """
        edges = self.edges
        low, high = map(self._least, self.ends)
        at_low, at_high = np.abs(low) <= AT_END, np.abs(high) <= AT_END
        a, b, fa, fb = edges.high, edges.low, high, low
        lost = ~(at_low | at_high | (fa * fb < 0))
        done = at_low | at_high | lost
        share, best = np.full(len(a), 0.5), a
        for _ in range(STEPS):
            x = a + share * (b - a)
            fx = self._least(self._at(PLAIN, x))
            same = np.sign(fx) == np.sign(fa)
            c, fc = np.where(same, a, b), np.where(same, fa, fb)
            b, fb = np.where(same, b, a), np.where(same, fb, fa)
            a, fa = x, fx
            best = np.where(done, best, np.where(np.abs(fa) < np.abs(fb), a, b))
            limit = CLOSE * self.width / np.abs(b - a)
            done = done | ~(limit <= 0.5) | (fa == 0)
            if done.all():
                break
            xi, phi = (a - b) / (c - b), (fa - fb) / (fc - fb)
            inverse = fa / (fb - fa) * fc / (fb - fc)
            inverse = inverse + (c - a) / (b - a) * fa / (fc - fa) * fb / (fc - fb)
            smooth = (phi**2 < xi) & ((1 - phi) ** 2 < 1 - xi)
            share = np.where(smooth, np.clip(inverse, limit, 1 - limit), 0.5)
        best = np.where(at_low, edges.low, np.where(at_high, edges.high, best))
        return np.where(lost, np.nan, best)

    def polished(self, root: Floats) -> Floats:
        """The double nearest to each simple root, by one secant in numbers of two doubles."""
        step = APART * self.width
        right, left = (self._least(self._at(PLAIN, root + s)) for s in (step, -step))
        value = self._least(self._at(DOUBLE_DOUBLE, root))
        root = root - value * (2 * step) / (right - left)
        return np.where(np.abs(root) < NEAR_ZERO * self.width, 0.0, root)

    def proved(self, root: Floats) -> Iterator[tuple[int, BoundaryPoint]]:
        """Place and point of each edge on which a bracket is proved, the narrowest that is."""
        left = np.flatnonzero(np.isfinite(root))
        factor = np.ones(len(root))
        for _ in range(ROUNDS):
            if not len(left):
                return
            here, three, none = root[left], np.tile(left, 3), np.zeros(2 * len(left))
            width = factor[left] * np.where(here == 0, LEAST, np.spacing(np.abs(here)))
            places = np.concatenate([here - width, here + width, here])
            reading = self._at(DOUBLE_DOUBLE, places, three, np.concatenate([none, width]))
            below, above, _ = np.reshape(reading.sign, (3, -1))
            kind, square = _crossings(reading, len(left))
            sure = (below * above < 0) & (kind >= 0) & reading.joined(len(left))
            sure &= (self.edges.low[left] <= here + width) & (here - width <= self.edges.high[left])
            yield from self._points(
                left[sure], here[sure], width[sure], kind[sure], square[sure], below[sure]
            )
            low, high, middle = self._least(reading, three).reshape(3, -1)
            step = middle * (2 * width) / (high - low)
            root[left] -= np.where(np.abs(step) < APART * self.width[left], step, 0.0)
            factor[left[root[left] == here]] *= 2  # the bracket is wider only about the same root
            left = left[~sure]

    def _points(
        self, some: Any, root: Floats, width: Floats, kind: Any, square: Floats, below: Any
    ) -> Iterator[tuple[int, BoundaryPoint]]:
        if not len(some):
            return
        edges = self.edges[some]
        x, y = edges.places(root)
        rate = rates(self.polynomials, x, y, square)
        rate = np.where(kind == Crossing.STATIC.code, 0.0, rate)
        kinds = list(Crossing)
        for k, value, error, code, frequency, sign in zip(
            some.tolist(),
            root.tolist(),
            width.tolist(),
            kind.tolist(),
            rate.tolist(),
            below.tolist(),
            strict=True,
        ):
            yield k, BoundaryPoint(value, error, kinds[code], frequency, sign > 0)


def _crossings(reading: Reading, count: int) -> tuple[Any, Floats]:
    """The code of what crosses, -1 where it is open, and the square of its frequency."""
    static, open_ = np.zeros((2, count), dtype=bool)
    square = np.full(count, np.nan)
    for k, sign in enumerate(reading.constants):
        below, above, over = sign.reshape(3, count)
        static = static | (below * above < 0)
        open_ = open_ | (over == 0)
        ends = reading.functions[2 * k + 1].reshape(3, count)
        squares = reading.squares[k].reshape(3, count)
        turns = ends[0] * ends[1] < 0
        square = np.where(turns, (squares[0] + squares[1]) / 2, square)
    kind = np.where(open_ | ~(square > 0), -1, Crossing.FLUTTER.code)
    return np.where(static, Crossing.STATIC.code, kind), square
