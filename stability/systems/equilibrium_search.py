"""Every zero of the rates in boxes: these are narrowed, excluded, proved to hold one, or halved.

Many boxes are worked on at once, as arrays of intervals through the graph.  Each is narrowed by the
graph read backwards, then by Krawczyk's operator at the middle of a box that is a little larger.
Where the image lies inside this larger box, one zero does (R. Krawczyk, Computing 4 (1969)
187-201; the larger box lets zeros on common faces of boxes be proved).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any

import casadi as ca
import numpy as np
from numpy.typing import NDArray

from ..algebra.double_double import DOUBLE_DOUBLE, DoubleDouble
from ..algebra.intervals import INTERVALS, Interval, Tape, part_of
from ..algebra.krawczyk import Values, many_proved
from ..algebra.linear_systems import inverse_of
from ..algebra.program import Program
from ..algebra.running_error import TINY, UNIT
from ..base.types import Floats

MOST_BOXES = 100_000
"""Most boxes of one search; those that are left then stay open."""
TOGETHER = 1024
"""Most boxes that are worked on at once."""
SWEEPS = 2
"""Times that the graph is read backwards before a box is halved."""
LARGER = 0.02
"""Room about a box on each side, over its width, in which a zero may be proved."""
LEAST = 2.0**-46
"""Least room, over the first width or the size of the numbers."""
FINEST = 2.0**-26
"""Width over the first one, or over the size of its numbers, at which a box stays open."""
NEAR_ZERO = 2.0**-40
"""Least size of numbers, over the first width."""
SHRUNK = 0.7
"""Share of the widest side, over the first width, up to which a box is narrowed again."""
LAGGING = 1 / 16
"""Width, over the largest one, below which a side is not halved."""
FEW = 128
"""Boxes up to which all are halved several times at once."""
SPLIT = 0.49
"""Where a side is cut; not in the middle, where symmetric systems have zeros."""
POLISH = 12
"""Newton steps in doubles before the proof in two doubles."""

Marks = NDArray[np.bool_]
Owners = NDArray[np.intp]


@dataclass
class SearchBoxes:
    """Boxes of one or more searches."""

    lo: Floats
    """Low ends, shape (N, n)."""
    hi: Floats
    owner: Owners
    """Number of the search of each."""

    def __len__(self) -> int:
        return len(self.lo)

    def __getitem__(self, rows: Marks | slice | Owners) -> SearchBoxes:
        return SearchBoxes(self.lo[rows], self.hi[rows], self.owner[rows])

    @classmethod
    def joined(cls, parts: list[SearchBoxes]) -> SearchBoxes:
        """Boxes of several lists."""
        names = ("lo", "hi", "owner")
        return cls(*(np.concatenate([getattr(b, n) for b in parts]) for n in names))


@dataclass
class Zeros:
    """What a search found."""

    x: Floats
    """Proved zeros as doubles, shape (N, n)."""
    rest: Floats
    """What is to be added to these."""
    error: Floats
    """Bounds on the errors of both together."""
    boxes: SearchBoxes
    """Boxes in which each is the only one."""
    open: SearchBoxes
    """Boxes in which a zero is neither excluded nor proved."""
    spent: Marks
    """Whether the most boxes were used up, for each search."""
    count: int
    """Number of boxes in all."""


@dataclass(frozen=True, eq=False)
class SquareSystem:
    """As many rates as unknowns, as functions of the unknowns and of parameters."""

    x: ca.SX
    p: ca.SX
    rates: ca.SX

    @cached_property
    def values(self) -> Program:
        """The rates."""
        return Program(ca.Function("rates", [self.x, self.p], [ca.densify(self.rates)]))

    @cached_property
    def both(self) -> Program:
        """The rates, and their slopes."""
        slopes = ca.jacobian(self.rates, self.x)
        outputs = [ca.densify(self.rates), slopes]
        return Program(ca.Function("slopes", [self.x, self.p], outputs))

    @cached_property
    def free(self) -> Marks:
        """Unknowns whose sides are halved; others follow from these by rates linear in them."""
        n = self.x.numel()
        slopes = ca.jacobian(self.rates, self.x)
        needs = np.array(ca.DM(slopes.sparsity(), 1.0)) != 0
        follows: dict[int, set[int]] = {}
        used: set[int] = set()
        for j in np.argsort(needs.sum(axis=0), kind="stable")[::-1].tolist():
            for i in np.argsort(needs.sum(axis=1), kind="stable").tolist():
                slope = slopes[i, j]
                constant = needs[i, j] and not ca.depends_on(slope, self.x)
                if i in used or not constant or slope.is_zero():
                    continue
                others = {int(k) for k in np.flatnonzero(needs[i]) if k != j}
                if j not in _reached(others, follows):
                    follows[j] = others
                    used.add(i)
                    break
        return np.array([j not in follows for j in range(n)])

    def evaluated(
        self, program: Program, lo: Floats, hi: Floats, p: Sequence[Any]
    ) -> tuple[list[Floats], Tape]:
        """Outputs over boxes: low and high ends, shape (2, N, rows, columns), and the marks."""
        tape = Tape(recording=False)
        x = [Interval(a, b, tape) for a, b in zip(lo.T.copy(), hi.T.copy(), strict=True)]
        values = program.run(INTERVALS, [x, [Interval(v, v) for v in p]])
        tables = []
        for entries, places, shape in zip(values, program.places, program.shapes, strict=True):
            table = np.zeros((2, len(lo), *shape))
            for (i, j), entry in zip(places, entries, strict=True):
                pair = entry.pair if isinstance(entry, Interval) else (entry, entry)
                table[0, :, i, j], table[1, :, i, j] = pair
            tables.append(table)
        return tables, tape

    def narrowed(self, lo: Floats, hi: Floats, p: Sequence[Any]) -> tuple[Floats, Floats, Marks]:
        """Boxes without parts that the graph excludes, and those of which nothing is left."""
        tape = Tape()
        x = [Interval(a, b, tape) for a, b in zip(lo.T.copy(), hi.T.copy(), strict=True)]
        for rate in self.values.run(INTERVALS, [x, [Interval(v, v) for v in p]])[0]:
            if isinstance(rate, Interval):
                tape.void = tape.void | (rate.lo > 0) | (rate.hi < 0)
                rate.meet((0.0, 0.0))
        tape.narrowed()
        low, high = (np.stack([getattr(v, end) for v in x], axis=1) for end in ("lo", "hi"))
        return low, high, (low > high).any(axis=1) | tape.void


def _reached(start: set[int], follows: dict[int, set[int]]) -> set[int]:
    """Unknowns that some depend on."""
    seen: set[int] = set()
    left = list(start)
    while left:
        if (k := left.pop()) not in seen:
            seen.add(k)
            left += follows.get(k, ())
    return seen


@dataclass
class _Step:
    """What one step leaves of boxes."""

    lo: Floats
    hi: Floats
    void: Marks
    proved: Marks
    """Whether one zero is in the larger box."""
    larger: tuple[Floats, Floats]
    """Low and high ends of the larger box."""
    smear: Floats
    """Largest change of a rate along each side, over that along all."""
    middle: Floats
    """Of the image."""
    error: Floats
    """Half-widths of the image."""
    defined: Marks
    """Whether the graph has a value everywhere in the larger box."""


def _stepped(
    system: SquareSystem, lo: Floats, hi: Floats, p: Sequence[Any], first: Floats
) -> _Step:
    """Krawczyk's operator over a box that is a little larger.

    Parameters
    ----------
    system
        The equations.
    lo, hi
        Boxes, shape (N, n).
    p
        Parameters, one column or number for each.
    first
        Widths at the start, shape (N, n).
    """
    n = lo.shape[1]
    room = LARGER * (hi - lo) + LEAST * np.maximum(first, np.maximum(np.abs(lo), np.abs(hi)))
    low, high = lo - room, hi + room
    middle = (low + high) / 2
    radius = np.nextafter(np.maximum(high - middle, middle - low), np.inf)
    (_, (slopes_low, slopes_high)), over = system.evaluated(system.both, low, high, p)
    (values,), at = system.evaluated(system.values, middle, middle, p)
    values = values[..., 0]
    fine = np.isfinite(slopes_low).all(axis=(1, 2)) & np.isfinite(slopes_high).all(axis=(1, 2))
    fine &= np.isfinite(values).all(axis=(0, 2)) & ~np.asarray(over.broken | at.part)
    slope = np.where(fine[:, None, None], (slopes_low + slopes_high) / 2, np.eye(n))
    doubt = np.where(
        fine[:, None, None],
        (np.maximum(slopes_high - slope, slope - slopes_low)) * (1 + 4 * UNIT) + TINY,
        np.inf,
    )
    value = np.where(fine[:, None], values.mean(axis=0), 0.0)
    unsure = np.where(fine[:, None], np.abs(values - value).max(axis=0) * (1 + 4 * UNIT) + TINY, 0)
    size = np.abs(slope) + np.where(fine[:, None, None], doubt, 0.0)
    # the mean-value form of each rate by itself
    reach = unsure + (size @ radius[..., None])[..., 0] * (1 + 4 * n * UNIT)
    void = fine & (np.abs(value) * (1 - 4 * UNIT) > reach).any(axis=1)
    smear = size * radius[:, None, :]
    with np.errstate(all="ignore"):
        smear = np.nan_to_num(smear / smear.sum(axis=2, keepdims=True)).max(axis=1)
    smear[~fine] = (radius / first)[~fine]
    sloped = fine.copy()
    inverse = inverse_of(slope)
    fine &= np.isfinite(inverse).all(axis=(1, 2))
    inverse = np.where(fine[:, None, None], inverse, 0.0)
    whole = np.abs(inverse)
    change = np.abs(np.eye(n) - inverse @ slope) + whole @ np.where(
        fine[:, None, None], doubt + 2 * n * UNIT * size, 0.0
    )
    change = change * (1 + 4 * n * UNIT) + n * TINY
    shift = (inverse @ value[..., None])[..., 0]
    off = (whole @ (unsure + 2 * n * UNIT * np.abs(value))[..., None])[..., 0]
    off = (off + (change @ radius[..., None])[..., 0]) * (1 + 4 * n * UNIT) + n * TINY
    proved = fine & (np.abs(shift) * (1 + 4 * UNIT) + off < radius * (1 - 4 * UNIT)).all(axis=1)
    centre = middle - shift
    off = np.where(fine[:, None], off, np.inf)
    off = off + 4 * UNIT * (np.abs(middle) + np.abs(shift))
    # each rate solved for each unknown, by its mean-value form
    rest = np.maximum(reach[..., None] - size * radius[:, None, :], 0.0)
    rest += 8 * n * UNIT * reach[..., None]
    some = -value[..., None] - rest, -value[..., None] + rest
    about = (low - middle)[:, None, :], (high - middle)[:, None, :]
    ends = part_of(about, some, (slopes_low, slopes_high))
    left = np.nextafter(middle + ends[0].max(axis=1), -np.inf)
    right = np.nextafter(middle + ends[1].min(axis=1), np.inf)
    left, right = np.fmax(left, centre - off), np.fmin(right, centre + off)
    known_slopes = sloped[:, None]
    new_lo = np.where(known_slopes, np.fmax(lo, left), lo)
    new_hi = np.where(known_slopes, np.fmin(hi, right), hi)
    void |= (new_lo > new_hi).any(axis=1)
    return _Step(
        new_lo,
        new_hi,
        void,
        proved & ~void,
        (low, high),
        smear,
        centre,
        off,
        ~(over.part | over.broken),
    )


@dataclass
class _Search:
    """Boxes in work, and what came of the others."""

    system: SquareSystem
    first: Floats
    """Widths at the start, for each search, shape (M, n)."""
    p: Floats
    """Parameters of each search, shape (M, m)."""
    most: int
    proved: list[tuple[SearchBoxes, Floats]] = field(default_factory=list)
    """Boxes in which one zero is, and a point near it."""
    open: list[SearchBoxes] = field(default_factory=list)
    count: int = 0

    @cached_property
    def same(self) -> list[bool]:
        """Whether each parameter is the same in all searches."""
        return (self.p == self.p[:1]).all(axis=0).tolist()  # type: ignore[no-any-return]

    def run(self, stack: SearchBoxes) -> Marks:
        """Work until no box is left; returns which searches used up their boxes."""
        spent = np.zeros(len(self.first), dtype=bool)
        used = np.zeros(len(self.first), dtype=np.intp)
        parts = [stack]
        while parts:
            boxes = parts.pop()
            if len(boxes) > TOGETHER:
                parts.append(boxes[: len(boxes) - TOGETHER])
                boxes = boxes[len(boxes) - TOGETHER :]
            elif parts and len(boxes) + len(parts[-1]) <= TOGETHER:
                parts.append(SearchBoxes.joined([parts.pop(), boxes]))
                continue
            np.add.at(used, boxes.owner, 1)
            self.count += len(boxes)
            spent |= used > self.most
            if (late := spent[boxes.owner]).any():
                self.open.append(boxes[late])
                boxes = boxes[~late]
            if len(boxes) and len(halves := self._worked(boxes)):
                parts.append(halves)
        return spent

    def _last(self, boxes: SearchBoxes) -> None:
        """Try the smallest boxes with the least room, in which zeros next to each other fit."""
        step = _stepped(
            self.system, boxes.lo, boxes.hi, self._parameters(boxes.owner), boxes.lo * 0 + TINY
        )
        self._keep(step, boxes.owner)
        self.open.append(boxes[~(step.proved | step.void)])

    def _keep(self, step: _Step, owner: Owners) -> None:
        low, high = (ends[step.proved] for ends in step.larger)
        self.proved.append((SearchBoxes(low, high, owner[step.proved]), step.middle[step.proved]))

    def _parameters(self, owner: Owners) -> Sequence[Any]:
        """One number for each parameter where they are the same, so that exponents stay exact."""
        return [c[0] if same else c[owner] for c, same in zip(self.p.T, self.same, strict=True)]

    def _worked(self, boxes: SearchBoxes) -> SearchBoxes:
        """What is left of boxes, halved where it did not shrink."""
        lo, hi, owner = boxes.lo, boxes.hi, boxes.owner
        for _ in range(SWEEPS):
            lo, hi, void = self.system.narrowed(lo, hi, self._parameters(owner))
            lo, hi, owner, before = lo[~void], hi[~void], owner[~void], boxes
            boxes = before[~void]
            if not len(lo):
                return boxes
        first = self.first[owner]
        step = _stepped(self.system, lo, hi, self._parameters(owner), first)
        self._keep(step, owner)
        keep = ~(step.void | step.proved)
        lo, hi, owner, first = step.lo[keep], step.hi[keep], owner[keep], first[keep]
        boxes, smear = boxes[keep], step.smear[keep]
        width = (hi - lo) / first
        free = np.where(self.system.free, width, LAGGING * width)
        most = np.maximum(np.abs(lo), np.abs(hi))
        size = np.minimum(first, np.maximum(most, NEAR_ZERO * first))
        finest = (free * first <= FINEST * size).all(axis=1)
        narrow = (hi - lo <= 4 * np.spacing(most)).all(axis=1)
        if (done := finest | narrow).any():
            self._last(SearchBoxes(lo[done], hi[done], owner[done]))
        again = ~done & (width.max(axis=1) <= SHRUNK * ((boxes.hi - boxes.lo) / first).max(axis=1))
        cut = ~done & ~again
        lags = free < LAGGING * free.max(axis=1, keepdims=True)
        smear = np.where(lags, 0.0, smear * np.where(self.system.free, 1.0, LAGGING))[cut]
        halves = SearchBoxes(lo[cut], hi[cut], owner[cut])
        # an operation on a few boxes costs as much as one on a hundred
        while len(halves):
            halves, smear = _halved(halves, smear)
            if 2 * len(halves) > FEW:
                break
        return SearchBoxes.joined([SearchBoxes(lo[again], hi[again], owner[again]), halves])


def _halved(boxes: SearchBoxes, smear: Floats) -> tuple[SearchBoxes, Floats]:
    """Two parts of each box, cut across the side of the largest smear."""
    rows, side = np.arange(len(boxes)), smear.argmax(axis=1)
    low, high = boxes.lo[rows, side], boxes.hi[rows, side]
    left, right, smear = boxes.hi.copy(), boxes.lo.copy(), smear.copy()
    left[rows, side] = right[rows, side] = low + SPLIT * (high - low)
    smear[rows, side] /= 2
    parts = SearchBoxes(boxes.lo, left, boxes.owner), SearchBoxes(right, boxes.hi, boxes.owner)
    return SearchBoxes.joined(list(parts)), np.concatenate([smear, smear])


@np.errstate(all="ignore")  # ends that are infinite or no numbers exclude nothing
def search(
    system: SquareSystem, lo: Floats, hi: Floats, p: Floats, most: int = MOST_BOXES
) -> Zeros:
    """Every zero in boxes, one search for each row.

    Zeros that lie just outside a box may be among those that are found.

    Parameters
    ----------
    system
        The equations.
    lo, hi
        Ends of the box of each search, shape (M, n).
    p
        Parameters of each search, shape (M, m).
    most
        Most boxes of each search.
    """
    work = _Search(system, np.maximum(hi - lo, TINY), p, most)
    spent = work.run(SearchBoxes(lo, hi, np.arange(len(lo))))
    n = lo.shape[1]
    none = SearchBoxes(np.zeros((0, n)), np.zeros((0, n)), np.zeros(0, dtype=np.intp))
    boxes = SearchBoxes.joined([none, *(b for b, _ in work.proved)])
    near = np.concatenate([np.zeros((0, n)), *(m for _, m in work.proved)])
    x, rest, error = enclosed(system, near, p[boxes.owner])
    radius = error + np.abs(rest)
    inside = within(x, radius, boxes.lo, boxes.hi)
    open_ = SearchBoxes.joined([none, *work.open, boxes[~inside]])
    boxes, x, rest, error = boxes[inside], x[inside], rest[inside], error[inside]
    rows = _different(boxes, x, radius[inside])
    outside = np.ones(len(open_), dtype=bool)
    for k in rows[
        np.isin(boxes.owner[rows], open_.owner)
    ]:  # of what is inside the box of a proof all is known
        inner = (open_.lo >= boxes.lo[k]) & (open_.hi <= boxes.hi[k])
        outside &= ~(inner.all(axis=1) & (open_.owner == boxes.owner[k]))
    return Zeros(x[rows], rest[rows], error[rows], boxes[rows], open_[outside], spent, work.count)


@np.errstate(all="ignore")
def enclosed(system: SquareSystem, x: Floats, p: Floats) -> tuple[Floats, Floats, Floats]:
    """Zeros near points, proved in two doubles: both, and bounds on their errors."""
    if not len(x):
        return x, x, x
    for _ in range(POLISH):
        values, slopes = system.both.arrays([list(x.T), list(p.T)], x.shape[:1])
        step = (inverse_of(slopes) @ values)[..., 0]
        x = x - np.where(np.isfinite(step), step, 0.0)
    parameters = [DoubleDouble(v if len(set(v.tolist())) > 1 else v[0]) for v in p.T]

    def equations(unknowns: Values) -> tuple[Values, list[Values]]:
        table = system.both.dense(DOUBLE_DOUBLE, [unknowns, parameters], 0)
        return [row[0] for row in table], system.both.dense(
            DOUBLE_DOUBLE, [unknowns, parameters], 1
        )

    numbers, _ = many_proved(equations, x)
    value, rest, error = (
        np.stack([getattr(v, part) for v in numbers], axis=1) for part in ("hi", "lo", "error")
    )
    proved = np.isfinite(value) & np.isfinite(rest) & np.isfinite(error)
    rest, error = np.where(proved, rest, 0.0), np.where(proved, error * 1.01 + TINY, np.inf)
    # a power whose exponent is a difference has no value at 0 in two doubles
    if (lost := ~proved.all(axis=1)).any():
        columns = p[0] if len(np.unique(p, axis=0)) == 1 else p[lost].T
        step = _stepped(system, x[lost], x[lost], columns, np.ones_like(x[lost]))
        sound = (step.proved & step.defined)[:, None]
        value[lost], rest[lost] = np.where(sound, step.middle, x[lost]), 0.0
        error[lost] = np.where(sound, step.error, np.inf)
    return value, rest, error


def within(x: Floats, radius: Floats, lo: Floats, hi: Floats) -> Marks:
    """Whether numbers are inside boxes with all of their errors."""
    low, high = np.nextafter(x - radius, -np.inf), np.nextafter(x + radius, np.inf)
    return np.asarray(((low > lo) & (high < hi)).all(axis=-1))


def _different(boxes: SearchBoxes, x: Floats, radius: Floats) -> Owners:
    """Rows of different zeros: one that lies in the box of another's proof is that one."""
    kept: list[int] = []
    first, owner = 0, -1
    for k in np.lexsort((*x.T[::-1], boxes.owner)).tolist():
        if boxes.owner[k] != owner:
            first, owner = len(kept), boxes.owner[k]
        rows = np.array(kept[first:], dtype=np.intp)
        inside = within(x[k], radius[k], boxes.lo[rows], boxes.hi[rows])
        around = within(x[rows], radius[rows], boxes.lo[k], boxes.hi[k])
        if not (inside | around).any():
            kept.append(k)
    return np.array(kept, dtype=np.intp)
