"""Points of codimension two along curves of folds and of pairs, each proved by Krawczyk's test.

Members are followed along lines of both parameters, round folds.  Where the number of unstable
eigenvalues changes, a curve of folds or of pairs crosses the line.  Each curve is followed by
pseudo-arclength through the rectangle, and from its points Newton's method seeks points of each
kind.  What it finds is proved; what it misses is not excluded.

Source: E. L. Allgower & K. Georg, Numerical Continuation Methods (1990), ch. 2;
tests/boundary/test_defining_systems.py.
"""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import suppress
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any

import numpy as np
from flint import arb

from ...algebra.exact.routh import divided, hurwitz_sign
from ...algebra.krawczyk import NotProvedError, Values, polished, tested
from ...algebra.number_types import precision
from ...base.axis import Axis
from ...base.errors import StabilityError
from ...base.types import Floats
from ...spectra.problem import Problem
from ...systems.continuation import Pace
from ...systems.family import Family
from ..brackets import Crossing
from ..hopf import rounded
from ..lyapunov_coefficient import (
    OneParameterFamily,
    Pair,
    PairEquations,
    coefficients,
    others,
    pair_of,
    signed,
    solved_pair,
)
from .defining_systems import DefiningSystem, MemberSheet
from .planes import Nature
from .point_records import CurveOfZeros, PointKind

BITS = 192
"""Precision of a proof."""
ROUGH_BITS = 64
"""Precision at which signs of first Lyapunov coefficients are compared."""
CURVE_BITS = 106
"""Precision of the proof of a point that is listed for a curve alone."""
LINES = 8, 24
"""Fewest and most lines along each axis."""
STEPS = 40
"""Fewest steps of a curve across the rectangle."""
MOST_STEPS = 300
"""Most steps of a curve in one direction."""
MARGIN = 0.1
"""How far curves are followed beyond the rectangle, over its width."""
COSINE = 0.9
"""Least cosine of the angle between tangents before and after a step."""
SHORTEST = 1e-4
"""Shortest step, over the longest."""
SAME = 1e-3
"""Distance from a curve, in scaled coordinates, below which a point lies on it."""
WIDEST = 2**12
"""Widest bracket of a change of sign, in units of the last digit."""
STARTS = 60
"""Most points of a curve from which Newton's method starts."""
DIGITS = 1e-6
"""Distance, in scaled coordinates, below which two solutions are one."""

ON_FOLDS = (PointKind.DOUBLE_ZERO, PointKind.CUSP, PointKind.ZERO_HOPF)
ON_PAIRS = (PointKind.DOUBLE_ZERO, PointKind.ZERO_HOPF, PointKind.DOUBLE_HOPF)


@dataclass(frozen=True)
class ProvedPoint:
    """A point with its proof."""

    kind: PointKind
    """Its kind."""
    x: Any
    """Ball of x."""
    y: Any
    """Ball of y."""
    nature: Nature
    """Pairs and other eigenvalues."""
    unknowns: dict[str, float]
    """The member's unknowns by name."""


@dataclass
class SingularCurve:
    """A curve of folds or of pairs."""

    system: DefiningSystem
    """Its equations."""
    z: Floats
    """Unknowns of its points in order, shape (N, ·)."""
    phases: Floats
    """Phases of its points, shape (N, ·)."""


@dataclass
class CurveSearch:
    """The curves of a plane, and the points on them.

    Parameters
    ----------
    problem
        A user's family with a number for every quantity but the axes, without structural zeros.
    axes
        x and y.
    """

    problem: Problem
    axes: tuple[Axis, Axis]
    curves: list[SingularCurve] = field(default_factory=list)
    """Curves of folds and of pairs."""
    points: list[ProvedPoint] = field(default_factory=list)
    """What was proved."""
    covered: bool = True
    """Whether a member was found at each crossing of two lines, and no zero is in the rectangle."""

    @cached_property
    def sheet(self) -> MemberSheet:
        """The members."""
        return MemberSheet(self.problem, (self.axes[0].name, self.axes[1].name))

    def system(self, what: PointKind | str) -> DefiningSystem:
        """The equations of a kind of point, or of the curves of folds or of pairs."""
        if what not in self._systems:
            zero, pairs = {
                "fold": ("simple", 0),
                "pair": ("", 1),
                PointKind.DOUBLE_ZERO: ("double", 0),
                PointKind.CUSP: ("cusp", 0),
                PointKind.ZERO_HOPF: ("simple", 1),
                PointKind.DOUBLE_HOPF: ("", 2),
            }[what]
            self._systems[what] = DefiningSystem(self.sheet, zero, pairs)
        return self._systems[what]

    @cached_property
    def _systems(self) -> dict[Any, DefiningSystem]:
        return {}

    def run(self) -> bool:
        """Search, once; whether the family's derivatives and equations allow it."""
        return self._done

    @cached_property
    def _done(self) -> bool:
        family = self.problem.family
        if not set(family.equations) <= set(family.system.states):
            return False
        try:
            for line in self._lines():
                self._cross(line)
            for curve in self.curves:
                self._examine(curve)
                if curve.system.pairs:
                    self._compare_signs(curve)
                if curve.system.zero and any(map(self._admitted, curve.z)):
                    self.covered = False
        except StabilityError:
            return False
        return True

    def listed(self, *kinds: PointKind) -> list[ProvedPoint]:
        """The points of some kinds."""
        return [p for p in self.points if p.kind in kinds]

    def possible(self, kind: PointKind) -> bool:
        """Whether the family has states enough for a kind, and folds for a cusp."""
        least = {
            PointKind.DOUBLE_ZERO: 2,
            PointKind.CUSP: 1,
            PointKind.ZERO_HOPF: 3,
            PointKind.DOUBLE_HOPF: 4,
        }[kind]
        return len(self.sheet.kept) >= least and (kind is not PointKind.CUSP or bool(self._folds))

    @property
    def _folds(self) -> int:
        return len(self.sheet.solved)

    def proved_curves(self) -> list[CurveOfZeros]:
        """The curves within the rectangle, each with the points that are proved."""
        if not self.run():
            return []
        return [piece for curve in self.curves for piece in self._pieces(curve)]

    def _pieces(self, curve: SingularCurve) -> Iterator[CurveOfZeros]:
        """Parts of a curve whose points are all proved."""
        crossing = Crossing.FLUTTER if curve.system.pairs else Crossing.STATIC
        rows: list[tuple[float, float, float, float]] = []
        for point in (*(self._on_curve(curve, i) for i in range(len(curve.z))), None):
            if point is not None:
                rows.append(point)
                continue
            if len(rows) > 1:
                x, y, error, frequency = zip(*rows, strict=True)
                yield CurveOfZeros(crossing, x, y, error, frequency)
            rows = []

    def _on_curve(self, curve: SingularCurve, i: int) -> tuple[float, float, float, float] | None:
        """A point of a curve with one parameter held; None where it is not proved, or no member."""
        z, cut = curve.z[i], self.sheet.count
        if not self._inside(z, 0):
            return None
        across = curve.z[max(i - 1, 0)] - curve.z[min(i + 1, len(curve.z) - 1)]
        held = cut - 2 + int(np.argmax(np.abs(across[cut - 2 : cut]) / self._width))
        whole = curve.system.in_balls(curve.phases[i])
        exact = arb(float(z[held]))

        def reduced(free: Values) -> tuple[Values, list[Values]]:
            values, slopes = whole([*free[:held], exact, *free[held:]])
            return values, [[*row[:held], *row[held + 1 :]] for row in slopes]

        try:
            with precision(CURVE_BITS):
                image, _ = tested(reduced, polished(reduced, np.delete(z, held).tolist()))
                point = [*image[:held], exact, *image[held:]]
                if not self._admissible(point[:cut]):
                    return None
                places = [rounded(v) for v in point[cut - 2 : cut]]
                frequency = abs(rounded(point[-1])[0]) if curve.system.pairs else 0.0
        except (NotProvedError, StabilityError, ArithmeticError):
            return None
        (x, x_error), (y, y_error) = places
        return x, y, max(x_error, y_error), frequency

    # --- coordinates ---

    @cached_property
    def _low(self) -> Floats:
        return np.array([g.low for g in self.axes])

    @cached_property
    def _width(self) -> Floats:
        return np.array([g.high - g.low for g in self.axes])

    def _scale(self, z: Floats) -> Floats:
        """Typical sizes of unknowns: that of the number itself or 1, and widths of the axes."""
        scale = np.maximum(np.abs(z), 1.0)
        cut = self.sheet.count
        scale[cut - 2 : cut] = self._width
        return scale

    def _inside(self, z: Floats, margin: float) -> bool:
        cut = self.sheet.count
        share = (z[cut - 2 : cut] - self._low) / self._width
        return bool((share >= -margin).all() and (share <= 1 + margin).all())

    def _admitted(self, z: Floats) -> bool:
        """Whether a point is in the rectangle, with positive unknowns where they must be."""
        names = zip(self.problem.family.unknown, z[: self._folds], strict=False)
        positive = self.problem.family.positive
        return self._inside(z, 0) and all(v > 0 for n, v in names if n in positive)

    # --- members along lines ---

    def _lines(self) -> Iterator[Floats]:
        """Points of the sheet along lines, each in order."""
        places = [lines_of(g) for g in self.axes]
        counts = [len(v) for v in places]
        x, y = (v.ravel() for v in np.meshgrid(*places, indexing="ij"))
        a, q, *_ = self.problem.arrays(
            {**self.problem.values, self.axes[0].name: x, self.axes[1].name: y}
        )
        members = self.problem.family.search(a, q)
        self.covered = bool(members.good.all())
        unknowns = members.u if self._folds else members.u[:, :0]
        table = np.column_stack([unknowns, x, y]).reshape(*counts, -1)
        good = members.good.reshape(counts)
        for axis in (0, 1):
            for i in range(counts[axis]):
                row, fine = (np.moveaxis(v, axis, 0)[i] for v in (table, good))
                yield from self._along(row, fine, 1 - axis)

    def _along(self, row: Floats, fine: Any, axis: int) -> Iterator[Floats]:
        """Members along one line, on every piece of the sheet that is reached from the grid."""
        if not self._folds:
            places = np.linspace(0, 1, 4 * len(row) + 1)
            line = row[0] + places[:, None] * (row[-1] - row[0])
            yield line
            return
        curve = DefiningSystem(self.sheet)
        fixed = self.sheet.count - 1 - axis
        lines: list[Floats] = []
        for start in row[fine]:
            scale = self._scale(start)
            if any(_distance(line / scale, start / scale) < SAME for line in lines):
                continue
            parts = [
                self._walked(curve, start, np.zeros(0), side, held=fixed).z for side in (-1, 1)
            ]
            line = np.vstack([parts[0][::-1], parts[1][1:]])
            lines.append(line)
            yield line

    # --- curves ---

    def _cross(self, line: Floats) -> None:
        """Follow the curves that cross a line and are not known."""
        whole, _ = self.sheet.matrices(line)
        fine = np.isfinite(whole).all(axis=(1, 2))
        line, whole = line[fine], whole[fine]
        if not len(line):
            return
        values = np.linalg.eigvals(whole)
        unstable = (values.real > 0).sum(axis=1)
        sign = np.linalg.slogdet(whole)[0]
        for i in np.flatnonzero((np.diff(unstable) != 0) | (np.diff(sign) != 0)):
            near = line[i : i + 2]
            near = np.vstack([near, near.mean(axis=0)])
            what = ["fold"] if sign[i] != sign[i + 1] else []
            if abs(int(unstable[i + 1]) - int(unstable[i])) > 1:
                what.append("pair")
            for kind in what:
                if kind == "fold" or len(self.sheet.kept) > 1:
                    self._start(kind, near)

    def _start(self, kind: str, near: Floats) -> None:
        """Follow the curves of a kind through points nearby."""
        system = self.system(kind)
        z, c = system.starts(near)
        if len(z):
            z, c = system.solved(z, c, self._scale(z[0]))
        for point, phases in zip(z, c, strict=True):
            if not self._inside(point, MARGIN) or (kind == "pair" and point[-1] <= 0):
                continue
            if not self._is_found(system, point):
                both = [self._walked(system, point, phases, side) for side in (-1, 1)]
                self.curves.append(
                    SingularCurve(
                        system,
                        np.vstack([both[0].z[::-1], both[1].z[1:]]),
                        np.vstack([both[0].phases[::-1], both[1].phases[1:]]),
                    )
                )

    def _plain(self, system: DefiningSystem, z: Floats) -> Floats:
        """Member, parameters and frequency: what tells points of curves apart."""
        cut = self.sheet.count
        parts = [*range(cut), *([system.size - 1] if system.pairs else [])]
        return z[..., parts]

    def _is_found(self, system: DefiningSystem, z: Floats) -> bool:
        plain = self._plain(system, z)
        scale = self._scale(plain)
        return any(
            _distance(self._plain(system, c.z) / scale, plain / scale) < SAME
            for c in self.curves
            if c.system is system
        )

    def _walked(
        self,
        system: DefiningSystem,
        z: Floats,
        phases: Floats,
        side: int,
        *,
        held: int | None = None,
    ) -> SingularCurve:
        """A curve by pseudo-arclength until it leaves the rectangle, or closes."""
        scale = self._scale(z)
        points, turns = [z], [phases]
        longest = step = (1 if held is None else 2) / STEPS

        def at(z: Floats) -> tuple[Floats, Floats]:
            values, slopes = (v[0] for v in system.at(z[None], phases[None]))
            if held is not None:
                row = np.eye(1, len(z), held)
                return np.append(values, 0.0), np.vstack([slopes, row])
            return values, slopes

        pace = Pace(at, scale)
        begin = pace.tangent(z, np.ones(len(z)))
        if begin is None:
            return SingularCurve(system, np.array(points), np.array(turns))
        along, _ = begin
        cut = self.sheet.count
        lead = int(np.argmax(np.abs(along[:cut])))
        along = along * np.copysign(1.0, side * along[lead])
        first = along
        while len(points) < MOST_STEPS and step >= SHORTEST * longest:
            quick = float(np.abs(along[cut - 2 : cut]).max())
            step = min(step, longest / max(quick, 1e-300))
            new = pace.corrected(z + step * along * scale, along)
            after = pace.tangent(new, along) if new is not None else None
            if new is None or after is None or after[0] @ along < COSINE:
                step /= 2
                continue
            along = after[0]
            z, phases = new, _turned(system, new, phases)
            points.append(z)
            turns.append(phases)
            step = min(2 * step, longest * max(1.0, float(np.abs(z / scale).max())))
            if not self._inside(z, MARGIN) or (system.pairs and z[-1] <= 0):
                break
            if len(points) > 8 and along[:cut] @ first[:cut] > 0:
                way = np.abs(self._plain(system, z - points[0]) / self._plain(system, scale))
                if way.max() < longest / 2:
                    break
        return SingularCurve(system, np.array(points), np.array(turns))

    # --- points ---

    def _examine(self, curve: SingularCurve) -> None:
        """Every point that Newton's method reaches from the points of a curve."""
        step = max(1, len(curve.z) // STARTS)
        near = curve.z[::step, : self.sheet.count]
        for kind in ON_PAIRS if curve.system.pairs else ON_FOLDS:
            if not self.possible(kind):
                continue
            system = self.system(kind)
            z, c = system.starts(near)
            if not len(z):
                continue
            scale = self._scale(np.median(z, axis=0))
            z, c = system.solved(*self._nearest(system, z, c, scale), scale)
            for point, phases in zip(z, c, strict=True):
                if self._inside(point, 1e-9) and not self._met(kind, point):
                    self._prove(kind, system, point, phases)

    def _nearest(
        self, system: DefiningSystem, z: Floats, c: Floats, scale: Floats
    ) -> tuple[Floats, Floats]:
        """Starts from which the first step is shorter than from their neighbours."""
        way = system.first_steps(z, c, scale)
        padded = np.concatenate([[np.inf], way, [np.inf]])
        least = np.isfinite(way) & (way <= padded[:-2]) & (way <= padded[2:])
        return z[least], c[least]

    # --- first Lyapunov coefficients ---

    def _compare_signs(self, curve: SingularCurve) -> None:
        """Points of a curve of pairs at which the first Lyapunov coefficient changes sign."""
        step = max(1, len(curve.z) // STARTS)
        rows = [i for i in range(0, len(curve.z), step) if curve.z[i, -1] > 0]
        before: tuple[Floats, int] | None = None
        for z in curve.z[rows]:
            try:
                with precision(ROUGH_BITS):  # no proof yet: the sign says where to look
                    _, equations, start = self._pair_equations(z, 1)
                    sign = signed(_numerator(pair_of(equations, [arb(float(v)) for v in start])))
            except (NotProvedError, StabilityError, ArithmeticError):
                before = None
                continue
            if before and sign * before[1] < 0:
                self._change(before[0], z)
            before = z, sign

    def _pair_equations(self, z: Floats, other: int) -> tuple[Follower, PairEquations, list[float]]:
        """The equations of a pair with x or y held, and a point of a curve as a start."""
        names = self.sheet.axes
        follower = Follower(
            self.problem.family,
            names[1 - other],
            names[other],
            {
                self.problem.family.meaning(n): float(v)
                for n, v in self.problem.values.items()
                if n not in (self.axes[0].name, self.axes[1].name)
            },
        )
        cut, n = self.sheet.count, len(self.sheet.kept)
        mode = z[cut : cut + n] + 1j * z[cut + n : cut + 2 * n]
        equations = PairEquations(
            follower.line(float(z[cut - 2 + other])), mode / np.linalg.norm(mode) ** 2
        )
        start = [z[cut - 1 - other], *z[: cut - 2], *z[cut:]]
        return follower, equations, start

    def _change(self, low: Floats, high: Floats) -> None:
        """The point between two points of a curve at which the coefficient changes sign."""
        cut = self.sheet.count
        way = np.abs(high - low)[cut - 2 : cut] / self._width
        for other in (int(np.argmax(way)), int(np.argmin(way))):
            follower, equations, start = self._pair_equations(low, other)
            ends = float(low[cut - 2 + other]), float(high[cut - 2 + other])
            with (
                suppress(NotProvedError, StabilityError, ArithmeticError, ValueError),
                precision(BITS),
            ):
                over = follower.change(solved_pair(equations, start), ends)
                self._record_change(follower, over, other)
                return

    def _record_change(self, follower: Follower, over: Pair, other: int) -> None:
        place = over.value, over.line.fixed[follower.other]
        x, y = place if other == 1 else place[::-1]
        if not self._admissible([*over.unknowns, x, y]):
            return
        plain = np.array([float(v.mid()) for v in (*over.unknowns, x, y)])
        if self._met(PointKind.VANISHING, plain):
            return
        self._seen.append((PointKind.VANISHING, plain))
        nature = Nature((over.frequency,), others(over))
        self.points.append(
            ProvedPoint(PointKind.VANISHING, x, y, nature, self._named(over.unknowns))
        )

    # --- proofs ---

    def _met(self, kind: PointKind, z: Floats) -> bool:
        plain = z[: self.sheet.count]
        scale = self._scale(plain)
        return any(
            bool((np.abs(plain - earlier) <= DIGITS * scale).all())
            for other, earlier in self._seen
            if other is kind
        )

    @cached_property
    def _seen(self) -> list[tuple[PointKind, Floats]]:
        return []

    def _prove(self, kind: PointKind, system: DefiningSystem, z: Floats, c: Floats) -> None:
        try:
            with precision(BITS):
                equations = system.in_balls(c)
                image, _ = tested(equations, polished(equations, [float(v) for v in z]))
                point = self._judged(kind, system, image)
        except (NotProvedError, StabilityError, ArithmeticError):
            return
        self._seen.append((kind, z[: self.sheet.count]))
        if point is not None:
            self.points.append(point)

    def _judged(self, kind: PointKind, system: DefiningSystem, z: Values) -> ProvedPoint | None:
        """The point at a proved solution; None where it is no member, or not in the rectangle."""
        cut = self.sheet.count
        member = z[:cut]
        if not self._admissible(member):
            return None
        frequencies = _frequencies(system, z, cut)
        if any(w < 0 for w in frequencies):
            return None
        if not all(w > 0 for w in frequencies):
            raise NotProvedError
        p = self.sheet.matrix(z).charpoly().coeffs()
        zeros = {"": 0, "simple": 1, "double": 2, "cusp": 1}[system.zero]
        rest = p[zeros:]
        if len(frequencies) == 2:
            low, high = frequencies
            if low.overlaps(high):
                raise NotProvedError
            frequencies = (low, high) if low < high else (high, low)
        for w in frequencies:
            rest = divided(rest, [w * w, arb(0), arb(1)])
        if rest[0].contains(0):  # one more eigenvalue vanishes, or is not told from zero
            raise NotProvedError
        nature = Nature(frequencies, hurwitz_sign(rest))
        return ProvedPoint(kind, member[-2], member[-1], nature, self._named(member[:-2]))

    def _named(self, unknowns: Values) -> dict[str, float]:
        names = self.problem.family.unknown
        return {n: rounded(v)[0] for n, v in zip(names, unknowns, strict=False)}

    def _admissible(self, member: Values) -> bool:
        """Whether a proved point is a member in the closed rectangle."""
        family = self.problem.family
        for v, axis in zip(member[-2:], self.axes, strict=True):
            if v < axis.low or v > axis.high:
                return False
        for name, v in zip(family.unknown, member[:-2], strict=False):
            if name in family.positive and not v > 0:
                return False
        state = self.sheet.points(np.array([[float(v.mid()) for v in member]]))
        size = len(family.system.states)
        return bool(family.system.valid(state[:, :size], state[:, size:]).all())


def _numerator(pair: Pair) -> Any:
    """The first Lyapunov coefficient times det A: without its pole where an eigenvalue vanishes."""
    return coefficients(pair).first * pair.matrix.det()


class Follower:
    """Crossing pairs along one axis, followed as the other quantity changes.

    Parameters
    ----------
    family
        The family.
    axis
        Name of the axis along which pairs cross.
    other
        Name of the quantity that changes.
    fixed
        Every other quantity.
    """

    def __init__(self, family: Family, axis: str, other: str, fixed: dict[str, Any]) -> None:
        self.family, self.axis, self.other, self.fixed = family, axis, other, fixed

    def line(self, place: Any) -> OneParameterFamily:
        """The line at a value of the other quantity."""
        return OneParameterFamily(self.family, self.axis, self.fixed | {self.other: place})

    def moved(self, near: Pair, place: Any) -> Pair:
        """The pair at another value, from one nearby, with the same phase."""
        return solved_pair(near.equations.on(self.line(place)), near.box)

    def one_branch(self, low: Pair, high: Pair) -> Pair:
        """The pair over all values between two, proved to be one branch with both at its ends."""
        places = [p.line.fixed[self.other] for p in (low, high)]
        over = low.equations.on(self.line(arb(places[0]).union(arb(places[1]))))
        middle = [((a + b) / 2).mid() for a, b in zip(low.box, high.box, strict=True)]
        far = [4 * abs(a - b) for a, b in zip(low.box, high.box, strict=True)]
        least = [v.abs_upper() + arb(2) ** (8 - BITS // 2) for v in far]
        image, box = tested(over, middle, least)
        for pair in (low, high):
            if not all(b.contains(v) for b, v in zip(box, pair.box, strict=True)):
                raise NotProvedError
        return pair_of(over, image)

    def change(self, pair: Pair, places: tuple[float, float]) -> Pair:
        """The pair over a narrow bracket in which its first Lyapunov coefficient changes sign."""
        from scipy.optimize import brentq

        near = pair

        def at(place: float) -> Pair:
            nonlocal near
            near = self.moved(near, place)
            return near

        def size(place: float) -> float:
            return float(_numerator(at(place)).mid())

        if size(places[0]) * size(places[1]) >= 0:
            raise NotProvedError
        root = float(brentq(size, *places, xtol=1e-300, rtol=4 * np.finfo(float).eps))
        width = float(np.spacing(abs(root))) or 1e-300
        most = WIDEST * width
        while width <= most:
            low, high = at(root - width), at(root + width)
            if signed(coefficients(low).first) * signed(coefficients(high).first) < 0:
                over = self.one_branch(low, high)
                if not coefficients(over).first.is_finite():  # it may change sign at a pole
                    raise NotProvedError
                return over
            width *= 2
        raise NotProvedError


def lines_of(axis: Axis) -> Floats:
    """Places of the lines across an axis."""
    return np.linspace(axis.low, axis.high, min(max(axis.count, LINES[0]), LINES[1]))


def _frequencies(system: DefiningSystem, z: Values, cut: int) -> tuple[Any, ...]:
    """ω of each pair among the unknowns."""
    n = len(system.sheet.kept)
    first = cut + (n if system.zero else 0) + 2 * n
    return tuple(z[first + k * (2 * n + 1)] for k in range(system.pairs))


def _turned(system: DefiningSystem, z: Floats, phases: Floats) -> Floats:
    """Phases by which the vectors of a curve keep their length and do not turn to the phases."""
    size = len(phases)
    if not size:
        return phases
    vector = z[system.sheet.count :][:size]
    out: Floats = vector / (vector @ vector)
    return out


def _distance(line: Floats, point: Floats) -> float:
    """Distance of a point from a polygon."""
    if len(line) == 1:
        return float(np.linalg.norm(line[0] - point))
    start, way = line[:-1], np.diff(line, axis=0)
    share = ((point - start) * way).sum(axis=1) / np.maximum((way * way).sum(axis=1), 1e-300)
    near = start + np.clip(share, 0, 1)[:, None] * way
    return float(np.linalg.norm(near - point, axis=1).min())
