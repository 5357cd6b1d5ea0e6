"""Pieces of an axis proved in double precision, many at once, from the formulas of a family.

Every function of `FormulaMeetings` is a Taylor form on each piece: coefficients at the midpoint and
a remainder over the piece, all as balls of doubles by one kernel.  Pieces that stay open are cut;
the few that are still open at the end are left to balls of any precision.

Source: tests/boundary/test_formula_boundaries.py.
"""

from __future__ import annotations

from collections.abc import Sequence
from contextlib import suppress
from dataclasses import dataclass
from functools import lru_cache
from typing import Any

import numpy as np
from flint import arb
from numpy.typing import NDArray

from ...algebra.kernels.tape import Tape, recorded_series
from ...algebra.number_types import Algebra, balls, precision
from ...base.errors import NoMemberError, StabilityError
from ...base.types import Floats
from ...spectra.verdict_routes import BITS
from ...systems.closed_form import ClosedForm, ImplicitForm
from ..brackets import Crossing
from .meetings import FormulaMeetings, watched

ORDER = 3
"""Order of the Taylor forms."""
FIRST = 64
"""Pieces of the first round."""
SPLIT = 4
"""Parts into which an open piece is cut."""
MOST = 2048
"""Largest number of pieces of all rounds."""
ROUNDS = 12
"""Largest number of rounds."""
ROOM = 1 + 2.0**-40
"""Factor for the roundings of a sum of sizes."""
SKEW = 0.0137
"""Share by which the first cuts are moved: no simple numbers, since boundaries often are."""
STEPS = 40
"""Most steps of Newton's method from a piece to the root in it."""
CLOSE = 1e-10
"""Step, relative to the root, after which one step with balls gives all digits of a double."""
POLISHED = 3
"""Most steps with balls."""

Flags = NDArray[np.bool_]
Span = tuple[float, float]


@dataclass(frozen=True)
class Leaf:
    """A piece of the axis at which the search ended."""

    low: float
    """Low end."""
    high: float
    """High end."""
    meetings: int | None
    """Number of simple meetings with the imaginary axis in it; None where this is not proved."""
    reason: str = ""
    """Reason why nothing is proved."""
    near: tuple[float, Crossing] | None = None
    """The single meeting to double precision, where it is known."""
    sure: bool = False
    """Whether it is proved what meets the axis there."""


@dataclass(frozen=True)
class DoublesProof:
    """What doubles prove along an axis."""

    leaves: tuple[Leaf, ...]
    """Pieces without a meeting, neighbours as one, and pieces with one."""
    left: tuple[Span, ...]
    """Pieces that stay open."""
    count: int
    """Number of pieces that were examined."""


def quick_pieces(
    meetings: FormulaMeetings, low: float, high: float, *, log: bool
) -> DoublesProof | None:
    """Pieces of an interval, proved in doubles; None where the formulas have no kernel.

    Parameters
    ----------
    meetings
        The functions along a line.
    low, high
        Ends of the interval.
    log
        Whether pieces are cut at equal ratios.
    """
    rounds = rounds_of(meetings)
    return None if rounds is None else rounds.run(low, high, log=log)


def rounds_of(meetings: FormulaMeetings) -> Rounds | None:
    """Rounds of pieces with the kernel of a line's formulas; None where these have none."""
    line = meetings.line
    names = (*line.problem.family.at, *line.problem.family.parameters)
    if line.problem.ratios or not line.problem.plain or line.axis not in names:
        return None
    cut = len(line.problem.family.at)
    place = names.index(line.axis)
    values = np.array([line.fixed.get(n, 0.0) for n in names])
    errors = np.zeros(len(names))
    if isinstance(meetings.formulas, ImplicitForm):
        if place - cut in meetings.formulas.used:
            return None
        with precision(BITS), suppress(NoMemberError):
            ball = meetings.formulas.solved(balls(), [arb(v) for v in values[cut:]])
            off = float((ball - arb(float(ball.mid()))).abs_upper())
            values = np.insert(values, cut, float(ball.mid()))
            errors = np.insert(errors, cut, np.nextafter(off, np.inf))
        place += place >= cut
    try:
        tapes = [_tape(meetings.formulas, place, order) for order in (ORDER, ORDER - 1, 1)]
    except StabilityError:
        return None
    if len(values) < tapes[0].inputs:  # no root is proved
        return None
    return Rounds(meetings, tapes, (values, errors), place)


@lru_cache(maxsize=64)
def _tape(formulas: ClosedForm, place: int, order: int) -> Tape:
    """Taylor coefficients of the functions, then of the numbers that are positive at members."""
    cut, count = formulas.function.numel_in(0), formulas.function.numel_in(1)

    def run(inputs: list[Any], algebra: Algebra) -> list[Any]:
        coefficients, _, positive = formulas.entries(algebra, inputs[:cut], inputs[cut:])
        return [*watched(coefficients, even=formulas.even), *positive]

    return recorded_series(run, cut + count, place, order)


class Rounds:
    """Rounds of pieces, each cut where the one before left it open."""

    def __init__(
        self,
        meetings: FormulaMeetings,
        tapes: Sequence[Tape],
        inputs: tuple[Floats, Floats],
        place: int,
    ) -> None:
        self.meetings, self.inputs, self.place = meetings, inputs, place
        self.whole, self.inner, self.slope = tapes
        self.functions = len(meetings.kinds)
        self.asked: int = meetings.formulas.function.numel_out(2)

    def run(self, low: float, high: float, *, log: bool) -> DoublesProof:
        """All rounds."""
        cuts = (np.arange(FIRST + 1) + SKEW) / FIRST
        cuts = low * (high / low) ** cuts if log and low > 0 else low + (high - low) * cuts
        cuts[0], cuts[-1] = low, high
        lows, highs = cuts[:-1], cuts[1:]
        clear: list[Floats] = []
        single: list[Leaf] = []
        left: list[Span] = []
        count = 0
        for number in range(ROUNDS):
            count += len(lows)
            free, slopes = self._judged(lows, highs)
            clear.append(np.stack([lows[free], highs[free]]))
            done = free.copy()
            some = np.flatnonzero(~free & slopes.any(axis=0))
            if len(some):
                none, turned = self._turned(lows[some], highs[some], slopes[:, some])
                clear.append(np.stack([lows[some[none]], highs[some[none]]]))
                single += [meeting for _, meeting in turned]
                done[some[none]] = done[some[[i for i, _ in turned]]] = True
            lows, highs = lows[~done], highs[~done]
            if not len(lows):
                break
            if number == ROUNDS - 1 or count + SPLIT * len(lows) > MOST:
                left += zip(lows.tolist(), highs.tolist(), strict=True)
                break
            lows, highs = _cut(lows, highs, log=log and low > 0)
        leaves = *(Leaf(*ends, 0) for ends in _joined(np.hstack(clear))), *single
        return DoublesProof(leaves, tuple(left), count)

    def _at(self, points: Floats, radius: Floats, tape: Tape) -> tuple[Any, Any]:
        """Coefficients as balls at points, or over pieces, shape (functions, orders, points)."""
        mid, rad = (np.repeat(v[:, None], len(points), axis=1) for v in self.inputs)
        mid[self.place], rad[self.place] = points, radius
        m, r = tape.run(mid, rad)
        shape = (self.functions + self.asked, -1, len(points))
        return m.reshape(shape), r.reshape(shape)

    def _judged(self, lows: Floats, highs: Floats) -> tuple[Flags, Flags]:
        """Pieces without a zero; and functions that are open but monotone there, where all are."""
        points = lows + (highs - lows) / 2
        half = np.nextafter(np.maximum(highs - points, points - lows), np.inf)
        inner = self._at(points, np.zeros(len(points)), self.inner)
        outer = self._at(points, half, self.whole)
        with np.errstate(all="ignore"):
            m, r = (
                np.concatenate([v, w[:, ORDER:]], axis=1) for v, w in zip(inner, outer, strict=True)
            )
            powers = half ** np.arange(ORDER + 1)[:, None]
            size = (np.abs(m) + r) * powers
            rest = (r[:, 0] + size[:, 1:].sum(axis=1)) * ROOM
            free = np.abs(m[:, 0]) > rest
            member = (m[self.functions :, 0] > rest[self.functions :]).all(axis=0)
            turns = np.arange(ORDER + 1)[:, None] * size
            bent = (r[:, 1] * half + turns[:, 2:].sum(axis=1)) * ROOM
            steep = np.abs(m[:, 1]) * half > bent
        open_ = ~free[: self.functions]
        monotone = member & (~open_ | steep[: self.functions]).all(axis=0)
        return member & ~open_.any(axis=0), open_ & monotone

    def _turned(
        self, lows: Floats, highs: Floats, open_: Flags
    ) -> tuple[Flags, list[tuple[int, Leaf]]]:
        """Pieces without a zero, and those with one; on each the open functions are monotone."""
        count = len(lows)
        m, r = self._at(np.concatenate([lows, highs]), np.zeros(2 * count), self.slope)
        value, error = (v[: self.functions, 0].reshape(-1, 2, count) for v in (m, r))
        sure = ((np.abs(value) > error).all(axis=1) | ~open_).all(axis=0)
        turned = ((value[:, 0] > 0) != (value[:, 1] > 0)) & open_
        single = np.flatnonzero(sure & (turned.sum(axis=0) == 1))
        which = np.argmax(turned[:, single], axis=0)
        rises = value[which, 1, single] > 0
        roots = self._roots(lows[single], highs[single], which, rises) if len(single) else ()
        leaves = [
            Leaf(float(lows[i]), float(highs[i]), 1, "", self._root_and_crossing(root, k))
            for i, k, root in zip(single, which, roots, strict=True)
        ]
        return sure & ~turned.any(axis=0), list(zip(single.tolist(), leaves, strict=True))

    def _root_and_crossing(self, root: float, which: int) -> tuple[float, Crossing] | None:
        kind = self.meetings.kinds[which]
        return None if kind is None else (root, kind)

    def _roots(self, lows: Floats, highs: Floats, which: NDArray[Any], rises: Flags) -> list[float]:
        """The zeros of functions between two signs: Newton's method, at last with balls."""
        low, high, lanes = lows.copy(), highs.copy(), np.arange(len(lows))
        here = low + (high - low) / 2
        for _ in range(STEPS):
            m, _ = self._at(here, np.zeros(len(here)), self.slope)
            value, slope = m[which, 0, lanes], m[which, 1, lanes]
            above = (value > 0) == rises
            high, low = np.where(above, here, high), np.where(above, low, here)
            with np.errstate(all="ignore"):
                step = np.where(slope != 0, value / slope, np.inf)
            near = np.abs(step) <= CLOSE * np.abs(here)
            if near.all():
                break
            after = here - step
            inside = (low < after) & (after < high)
            here = np.where(near, here, np.where(inside, after, low + (high - low) / 2))
        return [
            self._polished(*point)
            for point in zip(
                here.tolist(),
                slope.tolist(),
                which.tolist(),
                lows.tolist(),
                highs.tolist(),
                strict=True,
            )
        ]

    def _polished(self, here: float, slope: float, which: int, low: float, high: float) -> float:
        """A zero to all digits of a double, by balls."""
        for _ in range(POLISHED):
            exact = self.meetings.values(here, BITS, None)
            step = float(arb(exact[which]).mid()) / slope if exact is not None and slope else 0.0
            if low <= here - step <= high:
                here -= step
            if abs(step) <= CLOSE * abs(here):
                break
        return here


def _joined(spans: Floats) -> tuple[Span, ...]:
    """Pieces, shape (2, pieces), in order; neighbours as one."""
    lows, highs = spans[:, np.argsort(spans[0])]
    first = np.append(True, lows[1:] > highs[:-1])[: len(lows)]
    ends = highs[np.append(first[1:], True)[: len(lows)]]
    return tuple(zip(lows[first].tolist(), ends.tolist(), strict=True))


def _cut(lows: Floats, highs: Floats, *, log: bool) -> tuple[Floats, Floats]:
    """Each piece in parts."""
    share = np.arange(SPLIT + 1)[:, None] / SPLIT
    with np.errstate(all="ignore"):
        cuts = lows * (highs / lows) ** share if log else lows + (highs - lows) * share
    cuts[0], cuts[-1] = lows, highs
    cuts = np.sort(np.clip(cuts, lows, highs), axis=0)
    first, last = cuts[:-1].ravel(), cuts[1:].ravel()
    wide = last > first
    return first[wide], last[wide]
