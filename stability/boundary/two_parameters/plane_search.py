"""Every solution of two equations in a rectangle: isolated over Q, or by halving boxes.

Source: R. Krawczyk, Computing 4 (1969) 187-201, for existence and uniqueness in a box.
"""

from __future__ import annotations

import heapq
import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

from flint import arb, arb_mat, arb_poly

from ...algebra.exact.hurwitz_forms import factors
from ...algebra.exact.rational_functions import univariate
from ...algebra.krawczyk import NotProvedError, Values, operator, polished, tested
from ...algebra.number_types import precision
from ...base.errors import NoMemberError, StabilityError
from ...derivation.signs import real_roots
from ...systems.graph.family_graph import Sloped
from .planes import ExactPlane, GraphPlane, Nature, equations, nature, slope, value_of
from .point_records import PointKind, UnresolvedBox

SPECTRAL = (PointKind.DOUBLE_ZERO, PointKind.ZERO_HOPF, PointKind.DOUBLE_HOPF)
"""Kinds that a characteristic polynomial alone decides."""
BITS = 192
"""Precision of boxes and of the proof of a point."""
EXACT_BITS = (256, 1024)
"""Precisions of the roots over Q, in turn."""
WIDER = 1.1
"""Half-width of the box of a test over that of the box that it covers."""
MOST_BOXES = 6000
"""Most boxes of a kind."""
WORK = 400_000
"""Most boxes times the cube of the number of states."""
NARROW = 2.0**-30
"""Share of an axis below which no box is cut."""
CUT = 0.4871
"""Where a box is cut: no round number, at which solutions often lie."""
SINGULAR = "solutions there are not simple, or other eigenvalues meet there too"
SEVERAL = (
    "the equations of the steady motions have several branches, of which one was searched; take "
    "the family from System.steady, or state the branch by its own equation"
)
NO_VALUE = "the family has no proved member, or its linearisation no value, in all of the box"
BUDGET = "the budget of {count} boxes ended"

Rectangle = tuple[tuple[float, float], tuple[float, float]]
Plane = GraphPlane | ExactPlane


@dataclass(frozen=True)
class SpectralPoint:
    """A proved point."""

    kind: PointKind
    """Its kind."""
    x: Any
    """Ball of x."""
    y: Any
    """Ball of y."""
    nature: Nature
    """Pairs and other eigenvalues."""


class PlaneEquations:
    """The equations of a kind over a plane, as values and slopes.

    Parameters
    ----------
    plane, kind
        The polynomial and the kind of point.
    """

    def __init__(self, plane: Plane, kind: PointKind) -> None:
        self.plane, self.kind = plane, kind

    def __call__(self, z: Values) -> tuple[Values, list[Values]]:
        """Values and rows of slopes at (x, y)."""
        return split(self.kind, self.plane.at(*z))


def split(kind: PointKind, p: Sequence[Sloped]) -> tuple[Values, list[Values]]:
    """Values and rows of slopes of a kind's equations, from coefficients with slopes."""
    functions = equations(kind, list(p)) or []
    return [f.value for f in functions], [slope(f) for f in functions]


def concluded(plane: Plane, kind: PointKind, x: Any, y: Any) -> SpectralPoint | None:
    """The point at a proved solution; None where no pair is on the imaginary axis there.

    Raises
    ------
    NotProvedError
        If this is not decided.
    """
    p = [c.value for c in plane.at(x, y)]
    on_axis = nature(kind, p)
    return None if on_axis is None else SpectralPoint(kind, x, y, on_axis)


def within(x: Any, y: Any, rectangle: Rectangle) -> bool:
    """Whether a point may be in the closed rectangle."""
    return all(
        not (v < arb(low) or v > arb(high))
        for v, (low, high) in zip((x, y), rectangle, strict=True)
    )


# --- over Q ---


def isolated(
    plane: ExactPlane, kind: PointKind, rectangle: Rectangle
) -> tuple[list[SpectralPoint], list[UnresolvedBox]]:
    """Every point of a kind in the closed rectangle, from resultants over Q.

    Parameters
    ----------
    plane, kind, rectangle
        The polynomial, the kind, and the ends of x and y.

    Raises
    ------
    NotExact
        If the variable of an axis is a function of it that is not monotonic.
    """
    with precision(EXACT_BITS[-1]):
        inner = tuple(plane.ends(i, *ends) for i, ends in enumerate(rectangle))
    pair = equations(kind, list(plane.coefficients))
    if pair is None:
        return [], []
    open_ = [] if plane.alone else [UnresolvedBox(kind, *rectangle, SEVERAL)]
    if any(f.is_constant() and f != 0 for f in pair):
        return [], open_
    whole = UnresolvedBox(kind, *rectangle, "its equations hold along a whole curve")
    if all(f == 0 for f in pair):
        return [], [whole]
    common = pair[0].gcd(pair[1])
    f, g = (p / common for p in pair)
    if any(meets(h, inner) for h, _ in factors(common)[1]):
        open_.append(whole)
    if f.is_constant() or g.is_constant():
        return [], open_

    def judged(place: PlanePoint) -> tuple[SpectralPoint | None, str]:
        try:
            image, box = tested(PlaneEquations(plane, kind), [v.mid() for v in place])
            if not all(b.contains(v) for b, v in zip(box, place, strict=True)):
                raise NotProvedError
            point = concluded(plane, kind, *image)
            x, y = (plane.back(i, v) for i, v in enumerate(image))
            if not (x.is_finite() and y.is_finite()):
                raise NotProvedError
            if point is None or not plane.holds(x, y):
                return None, ""
            return replace(point, x=x, y=y), ""
        except (NotProvedError, NoMemberError):
            return None, SINGULAR

    points, left = judged_places(plane, kind, rectangle, PolynomialPair(f, g), judged)
    return points, open_ + left


PlanePoint = tuple[Any, Any]
"""Values of both variables, as balls."""


class PolynomialPair:
    """Two polynomials without common factor, with their slopes as a system of equations."""

    def __init__(self, f: Any, g: Any) -> None:
        self.pair = f, g
        self._rows = [(p, p.derivative("x"), p.derivative("y")) for p in self.pair]

    def __call__(self, z: Values) -> tuple[Values, list[Values]]:
        """Values and rows of slopes at (x, y)."""
        rows = [[value_of(p, *z) for p in row] for row in self._rows]
        return [row[0] for row in rows], [row[1:] for row in rows]

    @cached_property
    def sides(self) -> list[Any]:
        """Polynomials over Q whose roots hold x and y of every common zero: resultants."""
        f, g = self.pair
        return [univariate(f.resultant(g, name), i) for i, name in ((0, "y"), (1, "x"))]

    def near(self, roots: Sequence[Sequence[Any]]) -> Iterator[tuple[Any, Any]]:
        """Pairs of roots at which both polynomials may vanish."""
        for x in roots[0]:
            rows = [arb_poly(_collapsed(p, x)) for p in self.pair]
            for y in roots[1]:
                if all(_horner(row, y).contains(0) for row in rows):
                    yield x, y


def judged_places(
    plane: ExactPlane,
    kind: PointKind,
    rectangle: Rectangle,
    pair: PolynomialPair,
    judge: Callable[[PlanePoint], tuple[Any, str]],
) -> tuple[list[Any], list[UnresolvedBox]]:
    """What the common zeros of two polynomials are, at a precision that leaves none open if any.

    Parameters
    ----------
    plane, kind, rectangle
        As for `isolated`.
    pair
        The polynomials.
    judge
        Function from a place to what it is, or None, and the reason why that stays open, or empty.
    """
    points: list[Any] = []
    left: list[UnresolvedBox] = []
    with precision(EXACT_BITS[-1]):
        inner = [plane.ends(i, *ends) for i, ends in enumerate(rectangle)]
    for bits in EXACT_BITS:
        with precision(bits):
            points, left = [], []
            roots = [_inside(side, ends) for side, ends in zip(pair.sides, inner, strict=True)]
            for place in pair.near(roots):
                point, reason = judge(place)
                if reason:
                    ends = [box_of(plane.back(i, v), rectangle[i]) for i, v in enumerate(place)]
                    left.append(UnresolvedBox(kind, ends[0], ends[1], reason))
                elif point is not None:
                    points.append(point)
        if not left:
            break
    return points, left


def _inside(p: Any, ends: tuple[Any, Any]) -> list[Any]:
    """Real roots that are not proved to be outside a closed interval, as balls."""
    roots = map(arb, real_roots(p))
    return [r for r in roots if not (r < ends[0] or r > ends[1])]


def _collapsed(p: Any, x: Any) -> list[Any]:
    """Coefficients in y at a ball of x."""
    powers = [arb(1)]
    for _ in range(p.degrees()[0]):
        powers.append(powers[-1] * x)
    out = [arb(0)] * (p.degrees()[1] + 1)
    for (i, j), c in p.to_dict().items():
        out[int(j)] += powers[int(i)] * c
    return out


def _horner(row: Any, y: Any) -> Any:
    total = arb(0)
    for c in reversed(row.coeffs()):
        total = total * y + c
    return total


def box_of(ball: Any, whole: tuple[float, float]) -> tuple[float, float]:
    """Doubles around a ball.

    Parameters
    ----------
    ball
        The ball.
    whole
        Ends of the axis, for a ball that is not finite.
    """
    if not ball.is_finite():
        return whole
    return (
        math.nextafter(float(ball.lower()), -math.inf),
        math.nextafter(float(ball.upper()), math.inf),
    )


def meets(p: Any, ends: Any) -> bool:
    """Whether a polynomial may vanish between ends of its variables, by a few halvings.

    Parameters
    ----------
    p
        An element of `PLANE`.
    ends
        Balls of both ends of each variable.
    """
    boxes = [tuple(low.union(high) for low, high in ends)]
    for count in range(256):
        if not boxes:
            return False
        box = boxes.pop(0)
        if not value_of(p, *box).contains(0):
            continue
        side = box[count % 2]
        middle = side.mid()
        for part in (side.lower().union(middle), middle.union(side.upper())):
            boxes.append((part, box[1]) if count % 2 == 0 else (box[0], part))
    return bool(boxes)


# --- by halving boxes ---


def _shares(box: Rectangle, whole: Rectangle) -> list[float]:
    return [(b - a) / (d - c) for (a, b), (c, d) in zip(box, whole, strict=True)]


def _halves(box: Rectangle, whole: Rectangle, axes: Sequence[int] = (0, 1)) -> Iterator[Rectangle]:
    shares = _shares(box, whole)
    axis = max(axes, key=lambda i: shares[i])
    low, high = box[axis]
    cut = low + (high - low) * CUT
    for part in ((low, cut), (cut, high)):
        yield (part, box[1]) if axis == 0 else (box[0], part)


class BoxSearch:
    """Points of the spectral kinds in a rectangle, by halving boxes."""

    def __init__(self, plane: Plane, rectangle: Rectangle, size: int) -> None:
        self.plane, self.rectangle = plane, rectangle
        self.most = max(200, min(MOST_BOXES, WORK // size**3))
        self.points: list[SpectralPoint] = []
        self.unique: list[tuple[PointKind, Values]] = []
        self.left: list[UnresolvedBox] = []
        self.count = 0
        # a member that is not proved is sought in boxes that are narrow in what it depends on
        self.cuts = plane.solved if isinstance(plane, GraphPlane) else (0, 1)

    def run(self, kinds: Sequence[PointKind] = SPECTRAL) -> None:
        """Search; the results are in `points` and `left`."""
        with precision(BITS):
            heap = [(-1.0, self.count, self.rectangle, tuple(kinds), "")]
            while heap:
                share, _, box, asked, reason = heapq.heappop(heap)
                if self.count >= self.most:
                    why = BUDGET.format(count=self.most) + (reason and f"; {reason}")
                    self.left += [UnresolvedBox(kind, *box, why) for kind in asked]
                    continue
                rest, reason = self._examined(box, asked)
                if not rest:
                    continue
                if -share < NARROW**2:
                    self.left += [UnresolvedBox(kind, *box, reason) for kind in rest]
                    continue
                for part in _halves(
                    box, self.rectangle, self.cuts if reason == NO_VALUE else (0, 1)
                ):
                    self.count += 1
                    heapq.heappush(heap, (self._share(part), self.count, part, rest, reason))
        self.left = joined(self.left)

    def _share(self, box: Rectangle) -> float:
        shares = _shares(box, self.rectangle)
        return -shares[0] * shares[1]

    def _examined(
        self, box: Rectangle, kinds: Sequence[PointKind]
    ) -> tuple[tuple[PointKind, ...], str]:
        """Kinds that stay open in a box, and why."""
        tight = [arb(low).union(arb(high)) for low, high in box]
        middle = [v.mid() for v in tight]
        wide = [arb(v.mid(), (arb(v.rad()) * WIDER).abs_upper()) for v in tight]
        try:
            over = self.plane.at(*wide)
            here = self.plane.at(*middle)
        except (StabilityError, ArithmeticError):
            return tuple(kinds), NO_VALUE
        if not all(v.is_finite() for c in over for v in (c.value, *slope(c))):
            return tuple(kinds), NO_VALUE
        rest = [k for k in kinds if not self._settled(k, here, over, (tight, middle, wide))]
        return tuple(rest), SINGULAR

    def _settled(
        self, kind: PointKind, here: Sequence[Sloped], over: Sequence[Sloped], boxes: Any
    ) -> bool:
        """Whether a box has no point of a kind, or one that is proved and recorded."""
        tight, middle, wide = boxes
        values, slopes = split(kind, over)
        if not values or any(not v.contains(0) for v in values):
            return True
        at, _ = split(kind, here)
        away = arb_mat(2, 1, [w - m for w, m in zip(wide, middle, strict=True)])
        spread = arb_mat(slopes) * away
        if any(not (v + spread[i, 0]).contains(0) for i, v in enumerate(at)):
            return True
        try:
            inverse = arb_mat(slopes).mid().inv().mid()
        except ZeroDivisionError:
            return False
        way = operator(inverse, arb_mat(slopes), away, inverse * arb_mat(2, 1, at))
        image = [m + v for m, v in zip(middle, way.entries(), strict=True)]
        if any(not v.overlaps(t) for v, t in zip(image, tight, strict=True)):
            return True
        if not all(w.contains_interior(v) for w, v in zip(wide, image, strict=True)):
            return False
        return self._recorded(kind, image, wide)

    def _recorded(self, kind: PointKind, image: Values, wide: Values) -> bool:
        """Narrow the only solution in `wide`, and record it unless it is known already."""
        system = PlaneEquations(self.plane, kind)
        try:
            rough = polished(system, [float(v.mid()) for v in image])
            narrow, _ = tested(system, rough)
            if not all(w.contains(v) for w, v in zip(wide, narrow, strict=True)):
                return False
            point = concluded(self.plane, kind, *narrow)
        except (NotProvedError, StabilityError, ArithmeticError):
            return False
        for earlier, box in self.unique:
            if earlier is kind and all(b.contains(v) for b, v in zip(box, narrow, strict=True)):
                return True
        self.unique.append((kind, wide))
        if point is not None and within(point.x, point.y, self.rectangle):
            self.points.append(point)
        return True


def joined(some: Sequence[UnresolvedBox]) -> list[UnresolvedBox]:
    """Boxes that touch, of one kind and reason, as one box around them."""
    out: list[UnresolvedBox] = []
    for box in sorted(some, key=lambda b: (b.kind.name, b.x, b.y)):
        new = box
        again = True
        while again:
            again = False
            for old in out:
                same = (old.kind, old.reason) == (new.kind, new.reason)
                if same and all(
                    a[0] <= b[1] and b[0] <= a[1] for a, b in ((old.x, new.x), (old.y, new.y))
                ):
                    out.remove(old)
                    x, y = (
                        (min(a[0], b[0]), max(a[1], b[1]))
                        for a, b in ((old.x, new.x), (old.y, new.y))
                    )
                    new = UnresolvedBox(new.kind, x, y, new.reason)
                    again = True
                    break
        out.append(new)
    return out
