"""Whether a height is that of a convex body above the plane: proved on pieces of the inclination.

The radius of curvature ρ = h + h'' of the meridian is a Taylor form on each piece m ± r: it differs
from ρ(m) by at most r |ρ'(m)| + r²/2 max |ρ''|.  The values at m, and the maximum over the piece,
come from sums of waves where the height is one.  Otherwise they come from balls: of doubles, all
pieces at once, or of any precision where a function has no kernel.  Pieces that stay open are
halved.  What is open in the end is told; there samples alone speak, and the mean of ρ, since its
integral is h' at the ends and the integral of h: at a corner that points inwards it is negative.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import lru_cache
from typing import Any

import casadi as ca
import numpy as np

from ....algebra.kernels.tape import recorded
from ....algebra.number_types import Algebra, balls, precision
from ....algebra.program import Program
from ....base.errors import StabilityError
from ....base.types import Floats
from .expression import ShapeFunction
from .wave_sum import WaveSum, wave_sum

Span = tuple[float, float]
HeightPiece = tuple[float, float, int]
"""An interval of θ, and the shape for which it is open."""
Enclosure = Callable[[Floats, Floats, Any], tuple[Floats, Floats]]
"""From middles, half lengths and shapes of pieces to balls of h, h', ρ, ρ' and ρ''."""
Balls = Callable[[Floats, Floats], tuple[Floats, Floats]]
"""From centres and radii of θ and the numbers of the shape, shape (inputs, pieces), to the same."""
Numbers = tuple[tuple[float, ...], ...]
LEAST = -1e-9
"""Least radius of curvature, over the largest height, that counts as not negative."""
GROUND = -1e-12
"""Least height, over the largest, that counts as not negative: that of a disk at an end is 0."""
SHARP = -1e-6
"""Fall of h' in a piece, over the largest height, that is certain for no convex body."""
FIRST = 64
"""Pieces of the first round."""
MOST, FEWER = 4096, 200
"""Most pieces of all rounds, by doubles and by balls of any precision; of these 1 in 8 at first."""
MOST_SHAPES = 32
"""Most shapes for which a proof is tried."""
SHORTEST = 1e-5
"""Length below which no piece is halved [rad]."""
CORNER = 1e-3
"""Length of an open piece below which the height grows by less than its own size."""
BITS = 64
"""Precision of balls where a function has no kernel."""
LONGEST = 400
"""Most instructions of a graph that is read in these."""
U = 2.0**-50
"""Room for the roundings of a bound, over the size of its terms."""


@dataclass(frozen=True)
class Convexity:
    """What is proved about a height."""

    open: tuple[Span, ...]
    """Intervals of θ in which nothing is proved."""
    wrong: tuple[str, float, float] | None = None
    """`height` or `radius`, a value that is certain to be negative, and the θ there."""


def convexity(
    height: ShapeFunction, names: tuple[str, ...], shapes: Numbers, between: Span
) -> Convexity:
    """What is proved about a height: that it is not negative, and that of a convex body.

    Parameters
    ----------
    height
        The height.
    names
        Names of the numbers of the shape.
    shapes
        Numbers of each shape, in this order.
    between
        Interval of θ.

    Returns
    -------
    Convexity

    Source: Taylor's remainder; tests/bodies/test_convexity.py.

    Examples
    --------
    >>> from .expression import expression
    >>> sine = expression("height", ca.sin, ["theta"], 1)
    >>> convexity(sine, (), ((),), (0.5, 2.5)).open  # a disk: its radius of curvature is 0
    ()
    >>> convexity(expression("height", lambda t: 1 + ca.cos(3 * t), ["theta"], 1), (), ((),),
    ...           (0.5, 2.5)).wrong[0]
    'radius'
    """
    if len(shapes) > MOST_SHAPES:
        return Convexity((between,))
    return _proved(height, names, shapes, between)


@lru_cache(maxsize=256)
def _proved(
    height: ShapeFunction, names: tuple[str, ...], shapes: Numbers, between: Span
) -> Convexity:
    read = _enclosure(height, names, shapes)
    if read is None:
        return Convexity((between,))
    enclose, most = read
    count = len(shapes)
    first = min(FIRST, most // 8)
    edges = np.linspace(*between, first + 1)
    which = np.tile(np.arange(count), first)
    low, high = np.repeat(edges[:-1], count), np.repeat(edges[1:], count)
    kept: list[HeightPiece] = []
    done, size = 0, np.zeros(0)
    while low.size:
        done += low.size
        middle = (low + high) / 2
        half = np.maximum(high - middle, middle - low) * (1 + U)
        both = enclose(np.tile(middle, 2), np.concatenate([0 * half, half]), np.tile(which, 2))
        at, over = ([v[:, part] for v in both] for part in (slice(low.size), slice(low.size, None)))
        if not size.size:
            seen = np.nan_to_num(np.abs(at[0][0]), nan=0.0, posinf=0.0)
            size = seen.reshape(first, count).max(axis=0)
        proved, wrong = _judged(middle, half, at, over, size[which])
        if wrong is not None:
            return Convexity((), wrong)
        low, middle, high, which = (v[~proved] for v in (low, middle, high, which))
        short = (high - low < SHORTEST) | (done + 2 * low.size > most * count)
        kept += zip(*(v[short].tolist() for v in (low, high, which)), strict=True)
        low, middle, high, which = (v[~short] for v in (low, middle, high, which))
        low, high = (np.stack(p, axis=1).ravel() for p in ((low, middle), (middle, high)))
        which = np.repeat(which, 2)
    kept = [p for p in kept if p[1] - p[0] > SHORTEST or not _rising(enclose, p, size)]
    return Convexity(_joined(kept), _corner(enclose, kept, size))


def _judged(
    middle: Floats, half: Floats, at: Sequence[Floats], over: Sequence[Floats], size: Floats
) -> tuple[Any, tuple[str, float, float] | None]:
    """Pieces that are proved, and what is certain to be wrong at the middle of one."""
    (h, _, curve, *_), around = at
    with np.errstate(all="ignore"):
        span = half * (abs(over[0][1]) + over[1][1])
        above = h - around[0] - span - U * (abs(h) + span)
        proved = (above > GROUND * size) & (_room(half, at, over) > LEAST * size)
        below, hollow = h + around[0] <= 0, curve + around[2] < LEAST * size
        certain = {"height": (h, below), "radius": (curve, hollow)}
    for what, (values, bad) in certain.items():
        if bad.any():
            i = int(np.argmin(np.where(bad, values, math.inf)))
            return proved, (what, float(values[i]), float(middle[i]))
    return proved, None


def _room(half: Floats, at: Sequence[Floats], over: Sequence[Floats]) -> Floats:
    """Lower bound of ρ on each piece."""
    (_, _, curve, bend, _), around = at
    span = half * (abs(bend) + around[3]) + half**2 / 2 * (abs(over[0][4]) + over[1][4])
    return np.asarray(curve - around[2] - span - U * (abs(curve) + span))


def _rising(enclose: Enclosure, piece: HeightPiece, size: Floats) -> bool:
    """Whether a short piece is proved by a height that only rises or falls, as from 0 at an end."""
    low, high, shape = piece
    middle = (low + high) / 2
    half = np.array([0, (high - low) / 2 * (1 + 2 * U), 0, 0])
    mid, rad = enclose(np.array([middle, middle, low, high]), half, np.full(4, shape))
    with np.errstate(all="ignore"):
        room = _room(half[1:2], (mid[:, :1], rad[:, :1]), (mid[:, 1:2], rad[:, 1:2]))
        ends = (mid[0, 2:] - rad[0, 2:]).min() > GROUND * size[shape]
        return bool(ends and abs(mid[1, 1]) > rad[1, 1] and room[0] > LEAST * size[shape])


def _corner(
    enclose: Enclosure, pieces: Sequence[HeightPiece], size: Floats
) -> tuple[str, float, float] | None:
    """A short open piece in which h' falls by more than the integral of h gives back."""
    for shape in {which for _, _, which in pieces}:
        for low, high in _joined([p for p in pieces if p[2] == shape]):
            mid, rad = enclose(np.array([low, high]), np.zeros(2), np.array([shape, shape]))
            rise = mid[1, 1] - mid[1, 0] + rad[1].sum() + 2 * size[shape] * (high - low)
            if high - low < CORNER and rise < SHARP * size[shape]:
                return "radius", float(rise / (high - low)), (low + high) / 2
    return None


def _joined(pieces: Sequence[HeightPiece]) -> tuple[Span, ...]:
    """Pieces in order, neighbours as one."""
    spans: list[Span] = []
    for low, high, _ in sorted(pieces):
        if spans and low <= spans[-1][1]:
            spans[-1] = spans[-1][0], max(high, spans[-1][1])
        else:
            spans.append((low, high))
    return tuple(spans)


# --- values of a height and its slopes on pieces ---


def _enclosure(
    height: ShapeFunction, names: tuple[str, ...], shapes: Numbers
) -> tuple[Enclosure, int] | None:
    """The values, and the most pieces that are worth their time; None where no graph is read."""
    plain = _program(height)
    if plain is None:
        return None
    waves = [wave_sum(plain, numbers) for numbers in shapes]
    if all(waves):
        return _by_waves(waves), MOST  # type: ignore[arg-type]  # none of them is None
    graph = _of_graph(height, names)
    if graph is None:
        return None
    run, most = graph
    numbers = np.array(shapes).reshape(len(shapes), -1).T

    def enclose(middle: Floats, half: Floats, which: Any) -> tuple[Floats, Floats]:
        columns = numbers[:, which]
        return run(np.concatenate([[middle], columns]), np.concatenate([[half], 0 * columns]))

    return enclose, most


def _by_waves(waves: Sequence[WaveSum]) -> Enclosure:
    """Values of sums of waves, shape by shape."""

    def enclose(middle: Floats, half: Floats, which: Any) -> tuple[Floats, Floats]:
        balls = np.zeros((2, 5, len(middle)))
        for shape, wave in enumerate(waves):
            mine = which == shape
            if mine.any():
                with np.errstate(all="ignore"):  # what is not finite proves nothing
                    balls[:, :, mine] = wave.values(middle[mine], half[mine])
        return balls[0], balls[1]

    return enclose


@lru_cache(maxsize=64)
def _program(height: ShapeFunction) -> Program | None:
    """The height as a list of instructions; None where one of these is not read."""
    try:
        return Program(height.function)
    except StabilityError:
        return None


@lru_cache(maxsize=64)
def _of_graph(height: ShapeFunction, names: tuple[str, ...]) -> tuple[Balls, int] | None:
    """Balls of a height and its slopes, from centres and radii of θ and the shape's numbers."""
    theta, *numbers = symbols = [ca.SX.sym(n) for n in ("theta", *names)]
    rows = [ca.SX(height(theta, *numbers))]
    for _ in range(4):
        rows.append(ca.jacobian(rows[-1], theta))
    curves = [rows[i] + rows[i + 2] for i in range(3)]
    outputs = ca.cse([ca.densify(v) for v in (*rows[:2], *curves)])
    try:
        program = Program(ca.Function("curves", symbols, outputs))
    except StabilityError:
        return None

    def run(arguments: Sequence[Any], algebra: Algebra) -> list[Any]:
        return [v for [v] in program.run(algebra, [[v] for v in arguments])]

    try:
        tape = recorded(run, len(symbols))
    except StabilityError:
        return (_by_balls(run), FEWER) if program.size <= LONGEST else None
    return (lambda mid, rad: tape.run(mid, rad, plain=True)), MOST


def _by_balls(run: Callable[[Sequence[Any], Algebra], list[Any]]) -> Balls:
    """Balls of any precision, piece by piece."""
    from flint import arb

    plain, nan = balls(), arb("nan")
    table = plain.functions | {"sign": lambda x: arb(1) if x > 0 else arb(-1) if x < 0 else nan}
    algebra = Algebra("signed balls", plain.constant, table)

    def enclose(mid: Floats, rad: Floats) -> tuple[Floats, Floats]:
        enclosures = np.full((2, 5, mid.shape[1]), math.nan)
        with precision(BITS):
            for lane, pair in enumerate(zip(mid.T.tolist(), rad.T.tolist(), strict=True)):
                values = run(list(map(arb, *pair)), algebra)
                for i, value in enumerate(values):
                    if value.is_finite():
                        middle = float(value.mid())
                        away = float((value - middle).abs_upper())
                        enclosures[:, i, lane] = middle, np.nextafter(away, math.inf)
        return enclosures[0], enclosures[1]

    return enclose
