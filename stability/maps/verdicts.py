"""Proved verdicts from the exact conditions: over arrays, over rectangles, over the grid of a map.

Over arrays a floating-point filter has a proved bound.  Each condition P is split as P⁺ - P⁻ with
positive coefficients in positive variables, so that each part is computed with a relative error of
at most N roundings.  If P⁺ > ρ P⁻ or P⁻ > ρ P⁺ with ρ just above one, the sign of P is proved.
Other points go to exact arithmetic.

A whole rectangle of parameters has one proved verdict, or lies in the strip that encloses a
boundary. It is halved in both directions until the conditions of its family keep their signs on all
of it, or until it is as narrow as the levels allow.  For the disk the conditions are the
polynomials of `stability.bodies.disk_polynomials`, bounded over many boxes at once by the mean
value form.  For a user's family they are its polynomials over Q in the two axes, or Routh's array
in wide balls.

A tile of a map's cells lies in such a rectangle; where the signs are proved, all cells have one
verdict.  Other tiles are cut into smaller ones.  Cells of tiles that remain open go through the
filter, and from there to exact arithmetic.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..algebra.number_types import Algebra, numpy_algebra
from ..algebra.polynomial import Exact, Polynomial, TabulatedPolynomial
from ..algebra.running_error import UNIT
from ..base.axis import Axis
from ..base.checks import whole_number
from ..base.errors import NoMemberError
from ..base.types import Floats
from ..base.verdict import CODES, Verdict, best
from ..bodies.disk_polynomials import INPUT
from ..spectra.certificate import verdict
from ..spectra.problem import Problem
from .general.slice_verdicts import slice_verdicts
from .tiles import Codes, Ends, tiled

NUMPY = numpy_algebra()
RANGE = 280.0
"""Decimal exponents that a monomial may use, so that nothing over- or underflows."""


class VerdictKernel:
    """Proved verdicts over arrays.

    Parameters
    ----------
    exact
        Polynomial and conditions of a family and law.
    behind
        Number of roundings in each variable, by name; those of the disk when left out.

    Examples
    --------
    >>> from stability.bodies.disk_polynomials import exact_polynomial
    >>> kernel = VerdictKernel(exact_polynomial("rolling", "viscous"))
    >>> kernel([0.25, 1.0, np.array([1.9, 2.0, 2.1])]).tolist()  # unstable, open, stable
    [2, 0, 1]
    """

    def __init__(self, exact: Exact, behind: Mapping[str, int] = INPUT) -> None:
        self.exact = exact
        self._parts = [_Split(p, behind) for _, p in exact.conditions]

    def __call__(self, point: list[Any]) -> Codes:
        """Verdict flags at a point for broadcast arrays; 0 where the filter does not decide.

        Parameters
        ----------
        point
            Arrays or floats for each of `exact.variables`, positive.

        Returns
        -------
        ndarray
            int8, of the broadcast shape, in C order.
        """
        shape = np.broadcast_shapes(*(np.shape(v) for v in point))
        with np.errstate(all="ignore"):
            signs = [part.signs(point) for part in self._parts]
            codes = np.ascontiguousarray(np.broadcast_to(_flags(signs, self.exact.even), shape))
        sure = self.in_range(point)
        if sure is not True:
            codes = np.where(sure, codes, np.int8(0))
        return codes

    def in_range(self, point: list[Any]) -> Any:
        """Where no monomial can over- or underflow; True for everywhere."""
        powers = [
            max(p.degrees[i] for p in self._parts) if self._parts else 0 for i in range(len(point))
        ]
        with np.errstate(all="ignore"):
            reach = [
                d * max(abs(np.log10(np.min(v))), abs(np.log10(np.max(v))))
                for d, v in zip(powers, point, strict=True)
            ]
            if sum(reach) <= RANGE:
                return True
            total: Any = sum(d * np.abs(np.log10(v)) for d, v in zip(powers, point, strict=True))
        return total <= RANGE


def _flags(signs: Sequence[tuple[Any, Any]], even: bool) -> Codes:
    """Verdict flags from where each condition is positive, and where it is negative, proved."""
    good: Any = np.True_
    bad: Any = np.False_
    for above, below in signs:
        good, bad = good & above, bad | below
    good, bad = np.asarray(good).view(np.int8), np.asarray(bad).view(np.int8)
    codes: Codes = good * np.int8(CODES[best(even=even)]) + bad * np.int8(CODES[Verdict.UNSTABLE])
    return codes


class _Split:
    """P⁺ and P⁻ of a polynomial, with their Horner schemes nested for broadcast arrays."""

    def __init__(self, polynomial: Polynomial, behind: Mapping[str, int]) -> None:
        self.degrees = polynomial.degrees
        turned, self._order = polynomial.ordered()
        self._plus, self._minus = turned.parts
        most = max(self._plus.roundings(behind), self._minus.roundings(behind))
        error = 1.01 * (most + 3) * UNIT
        self.ratio = (1 + error) / (1 - error) * (1 + 8 * UNIT)

    def signs(self, point: list[Any]) -> tuple[Any, Any]:
        """Where the polynomial is positive, and where it is negative, proved."""
        place = [point[i] for i in self._order]
        plus, minus = self._plus(*place), self._minus(*place)
        return plus > self.ratio * minus, minus > self.ratio * plus


class FilteredVerdicts:
    """The whole verdict route of a problem: the filter, then exact arithmetic where it is open."""

    def __init__(self, problem: Problem) -> None:
        self.problem = problem
        exact = tabulated(problem)
        behind = exact.roundings(dimensionless=problem.dimensionless)
        self.kernel = VerdictKernel(exact.known, behind)

    def codes(self, values: Mapping[str, Any]) -> tuple[Codes, int]:
        """Verdict flags for broadcast values, each of them proved.

        Returns
        -------
        codes, handed_on
            Flags of the broadcast shape, and how many points went to exact arithmetic.
        """
        shape = np.broadcast_shapes(*(np.shape(v) for v in values.values()))
        codes = self.kernel(point(self.problem, values))
        codes = np.ascontiguousarray(np.broadcast_to(codes, shape))
        if not codes.flags.writeable:
            codes = codes.copy()
        if "lean" in values:
            codes[np.broadcast_to(np.asarray(values["lean"]) == 0, shape)] = 0
        flat = codes.reshape(-1)
        open_cells = np.flatnonzero(flat == 0)
        if len(open_cells):
            places = np.unravel_index(open_cells, shape) if shape else ((),)
            for count, cell in enumerate(open_cells):
                where = tuple(p[count] for p in places) if shape else ()
                one = {n: float(_at(v, shape, where)) for n, v in values.items()}
                flat[cell] = CODES[verdict(self.problem, one)]
        return codes, len(open_cells)


def tabulated(problem: Problem) -> TabulatedPolynomial:
    """The tabulated polynomials of a problem, on which a map's kernels rest."""
    assert isinstance(problem.exact, TabulatedPolynomial)
    return problem.exact


def _at(value: Any, shape: tuple[int, ...], where: tuple[Any, ...]) -> Any:
    return np.broadcast_to(value, shape)[where]


def point(problem: Problem, values: Mapping[str, Any]) -> list[Any]:
    """Variables of the exact polynomial in double precision, for broadcast values.

    Returns
    -------
    list
        Arrays or floats in the order of `exact.variables`.
    """
    with np.errstate(all="ignore"):  # the filter leaves open what overflows
        found = tabulated(problem).point(values, NUMPY)
    return [v if np.ndim(v) else float(v) for v in found]


MOST_LEVELS = 16
"""Largest number of halvings; an axis is then cut into 65 536 parts."""
SLACK = 64 * UNIT
"""Relative slack of every product of bounds, more than its few roundings."""


@dataclass(frozen=True, eq=False)
class Boxes:
    """Rectangles that cover a map."""

    x: Floats
    """Low and high end along x, shape (N, 2)."""
    y: Floats
    """Low and high end along y, shape (N, 2)."""
    codes: NDArray[np.int8]
    """Flag of the verdict that is proved everywhere in the box, 0 in the strip, shape (N,)."""
    levels: int
    """Number of halvings of the map; boxes of the strip are 2^-levels of each axis wide."""
    proved: float
    """Share of the map's area that is proved, each axis in its own scale."""


class Interval:
    """A closed interval of nonnegative numbers, elementwise, rounded outwards."""

    def __init__(self, low: Any, high: Any) -> None:
        self.low, self.high = low, high

    def __mul__(self, other: Interval) -> Interval:
        return Interval(self.low * other.low * (1 - SLACK), self.high * other.high * (1 + SLACK))

    def __truediv__(self, other: Interval) -> Interval:
        return Interval(self.low / other.high * (1 - SLACK), self.high / other.low * (1 + SLACK))


def prove_boxes(problem: Problem, axes: tuple[Axis, Axis], levels: int) -> Boxes:
    """Cover a map with rectangles of one proved verdict and a strip of narrow ones.

    Raises
    ------
    ParameterError
        If levels is not between 0 and `MOST_LEVELS`.

    Examples
    --------
    >>> from stability.bodies.contact_laws import Viscous
    >>> from stability.bodies.disk import Disk
    >>> from stability.spectra.problem import disk_problem
    >>> problem = disk_problem("rolling", Disk(), Viscous(1.0), 1.0)
    >>> axes = Axis("at", 0.1, 3.0, 9), Axis("mu", 0.1, 1.0, 9)
    >>> boxes = prove_boxes(problem, axes, 6)
    >>> round(boxes.proved, 2), sorted(set(boxes.codes.tolist()))
    (0.98, [0, 1, 2])
    """
    levels = whole_number("levels", levels, 0, MOST_LEVELS)
    fast = isinstance(problem.exact, TabulatedPolynomial)
    judge = BoxConditions(problem) if fast else _derived(problem, axes)
    edges = [_edges(axis, levels) for axis in axes]
    i = j = np.zeros(1, dtype=np.int64)
    found: list[tuple[Any, Any, Any]] = []
    proved = 0.0
    for level in range(levels + 1):
        width = 1 << (levels - level)
        span = [(e[n * width], e[(n + 1) * width]) for e, n in zip(edges, (i, j), strict=True)]
        codes = judge({axes[0].name: span[0], axes[1].name: span[1]})
        proved += 4.0**-level * int((codes != 0).sum())
        keep = codes != 0 if level < levels else np.ones(len(codes), dtype=bool)
        found.append((np.stack(span[0], -1)[keep], np.stack(span[1], -1)[keep], codes[keep]))
        i, j = i[~keep], j[~keep]
        i = np.concatenate([2 * i, 2 * i + 1, 2 * i, 2 * i + 1])
        j = np.concatenate([2 * j, 2 * j, 2 * j + 1, 2 * j + 1])
        if not len(i):
            break
    x, y, c = (np.concatenate(part) for part in zip(*found, strict=True))
    return Boxes(x, y, c.astype(np.int8), levels, proved)


def _edges(axis: Axis, levels: int) -> Floats:
    return Axis(axis.name, axis.low, axis.high, (1 << levels) + 1, axis.log).values


Spans = Mapping[str, tuple[Floats, Floats]]


def _derived(problem: Problem, axes: tuple[Axis, Axis]) -> Callable[[Spans], NDArray[np.int8]]:
    """Verdicts over boxes of a user's family."""
    found = None if problem.may_drift else slice_verdicts(problem, axes)
    return _WideBalls(problem) if found is None else found.boxes


class BoxConditions:
    """Verdicts proved over whole boxes from the exact conditions, vectorised."""

    def __init__(self, problem: Problem) -> None:
        self.problem, self.exact = problem, tabulated(problem)
        self.parts = [_Range(p) for _, p in self.exact.known.conditions]

    def __call__(self, spans: Spans) -> NDArray[np.int8]:
        """Verdict flags, 0 where none is proved.

        Returns
        -------
        ndarray
            Shape (N,).
        """
        count = len(next(iter(spans.values()))[0])
        values: dict[str, Any] = {}
        upright = np.zeros(count, dtype=bool)
        for name, value in self.problem.values.items():
            # what does not vary stays a number, which is bounded once
            low, high = spans.get(name) or (np.asarray(value, float), np.asarray(value, float))
            if self.exact.angle(name):
                upright |= _upright(name, low, high)
                values[name] = (name, low, high)
            else:
                inside = (low <= 0) & (high >= 0)
                if name == "phi_dot":  # circling and precession, which have no member at zero
                    upright |= inside
                least = np.where(inside, 0.0, np.minimum(np.abs(low), np.abs(high)))
                values[name] = Interval(least, np.maximum(np.abs(low), np.abs(high)))
        with np.errstate(all="ignore"):
            point = self.exact.point(values, INTERVALS)
            box = [p if isinstance(p, Interval) else Interval(p, p) for p in point]
            signs = [(sign > 0, sign < 0) for sign in (part(box) for part in self.parts)]
        codes = np.array(np.broadcast_to(_flags(signs, self.exact.known.even), count))
        codes[upright] = 0  # the static boundary itself runs through such a box
        return codes


def _upright(name: str, low: Floats, high: Floats) -> NDArray[np.bool_]:
    """Whether a box may hold the right angle: no double theta is one, a lean of 0 is."""
    if name == "lean":
        return (low <= 0) & (high >= 0)
    return (low <= np.pi / 2) & (high > np.pi / 2)


def _sine(angle: tuple[str, Floats, Floats]) -> Interval:
    name, low, high = angle
    ends = (np.cos(low), np.cos(high)) if name == "lean" else (np.sin(low), np.sin(high))
    top = np.where(_upright(name, low, high), 1.0, np.maximum(*ends) * (1 + SLACK))
    return Interval(np.minimum(*ends) * (1 - SLACK), np.minimum(top, 1.0))


INTERVALS = Algebra("intervals", float, {"sin": _sine, "cos": _sine})
"""Sines over boxes; the sine of theta is the cosine of a lean."""


class _Range:
    """Sign of a polynomial over boxes by the mean value form."""

    def __init__(self, polynomial: Polynomial) -> None:
        self.value = polynomial.parts
        self.slopes = [polynomial.derivative(n).parts for n in polynomial.variables]
        most = max(p.roundings(dict.fromkeys(polynomial.variables, 1)) for p in self.value)
        self.error = 4 * (most + 4) * UNIT

    def __call__(self, box: list[Interval]) -> NDArray[np.int8]:
        """1: positive everywhere, proved; -1: negative everywhere; 0: open."""
        low, high = [b.low for b in box], [b.high for b in box]
        middle = [0.5 * (b.low + b.high) for b in box]
        plus, minus = self.value[0](*middle), self.value[1](*middle)
        spread: Any = self.error * (plus + minus)
        for b, m, (up, down) in zip(box, middle, self.slopes, strict=True):
            if np.all(b.low == b.high):
                continue
            # |∂P| is at most the larger of these over the box
            steepest = np.maximum(up(*high) - down(*low), down(*high) - up(*low))
            steepest = steepest + self.error * (up(*high) + down(*high))
            reach = np.maximum(b.high - m, m - b.low) * (1 + SLACK)
            spread = spread + reach * steepest * (1 + SLACK)
        size = plus - minus
        sure = np.abs(size) > spread  # NaN, from an overflow, is not sure
        return np.where(sure, np.sign(size), 0).astype(np.int8)


class _WideBalls:
    """Routh's array in balls as wide as the box, for a family without an exact polynomial."""

    BITS = 96

    def __init__(self, problem: Problem) -> None:
        self.problem = problem

    def __call__(self, spans: Spans) -> NDArray[np.int8]:
        count = len(next(iter(spans.values()))[0])
        return np.array([self._one(spans, n) for n in range(count)], dtype=np.int8)

    def _one(self, spans: Spans, n: int) -> int:
        from flint import arb

        from ..algebra.number_types import precision
        from ..spectra.certificate import in_balls

        with precision(self.BITS):
            values = {name: arb(float(v)) for name, v in self.problem.values.items()}
            for name, (low, high) in spans.items():
                values[name] = arb(float(low[n])).union(arb(float(high[n])))
            a, q, _ = self.problem.reduce(values, lambda v: v.sqrt())
            try:
                found = in_balls(self.problem.family, a, q)
            except NoMemberError:
                return 0
        return CODES[found] if found is not None else 0


SIDES = (32, 8)
"""Cells along the side of a tile, coarse to fine."""


class GridVerdicts:
    """Proved verdicts over grids of two axes of a problem.

    Examples
    --------
    >>> from stability.bodies.contact_laws import Viscous
    >>> from stability.bodies.disk import Disk
    >>> from stability.spectra.problem import disk_problem
    >>> verdicts = GridVerdicts(disk_problem("rolling", Disk(), Viscous(1.0), 1.0), "at", "mu")
    >>> codes, handed_on = verdicts(np.linspace(1, 2, 200), np.linspace(0.1, 1, 100))
    >>> codes.shape, np.unique(codes).tolist(), handed_on
    ((100, 200), [1, 2], 0)
    """

    def __init__(self, problem: Problem, x: str, y: str) -> None:
        self.x, self.y = x, y
        self.problem = problem
        self.cells = FilteredVerdicts(problem)
        self.boxes = BoxConditions(problem)

    def __call__(self, xs: Floats, ys: Floats, known: Codes | None = None) -> tuple[Codes, int]:
        """Verdict flags over a grid.

        Parameters
        ----------
        xs, ys
            Increasing values of the axes.
        known
            Flags that are proved already, flat, 0 for others; they change in place.

        Returns
        -------
        codes, handed_on
            Flags, shape (y, x), and how many cells went to exact arithmetic.
        """
        shape = len(ys), len(xs)
        if known is not None:
            codes = known.reshape(shape)
            return codes, self._single(
                codes, *np.divmod(np.flatnonzero(known == 0), len(xs)), 1, xs, ys
            )
        padded, i, j, _ = tiled(xs, ys, SIDES, self._judge, np.empty((0, 1)))
        codes, side = padded[: shape[0], : shape[1]], SIDES[-1]
        return codes, self._single(codes, i * side, j * side, side, xs, ys)

    def _judge(self, x: Ends, y: Ends, signs: Any) -> tuple[Codes, Any]:
        return self.boxes({self.x: x, self.y: y}), signs

    def _single(self, codes: Codes, i: Any, j: Any, side: int, xs: Floats, ys: Floats) -> int:
        if not len(i):
            return 0
        steps = np.arange(side)
        rows, columns = (
            np.broadcast_to(v, (len(i), side, side)).reshape(-1)
            for v in (i[:, None, None] + steps[:, None], j[:, None, None] + steps)
        )
        inside = (rows < codes.shape[0]) & (columns < codes.shape[1])
        rows, columns = rows[inside], columns[inside]
        swept = {self.x: xs[columns], self.y: ys[rows]}
        found, left = self.cells.codes(dict(self.problem.values) | swept)
        codes[rows, columns] = found
        return left
