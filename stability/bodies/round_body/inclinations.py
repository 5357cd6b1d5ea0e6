"""Inclinations at which a body of revolution rolls, stands upright, or tumbles, from its height."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from functools import lru_cache
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from ...base.checks import one_number
from ...base.errors import NoMemberError
from ...base.types import Floats
from ..families import tumbling
from .shape import MOMENTS, SAMPLES, SCALES, Outline, RoundShape
from .si_law import Shape, shape_of

CLOSE = 1e-12
"""Largest slope of the height, over the height, that counts as zero at π/2 before the proof."""
COARSEST, FINEST = 2, 4
"""Binary digits of the sizes near which the equations of all bodies of one shape are sampled."""
GUESSES = (3, 12)
"""Range of the binary digits of an inclination from which a zero is sought."""
SPREAD = 1.25
"""Room between these sizes and the limits of a shape's numbers, as a factor."""

Named = tuple[tuple[str, float], ...]
"""Numbers by name, in order."""


def first_numbers(body: RoundShape) -> dict[str, float]:
    """Every number of the body by name, of arrays the first."""
    return {n: float(np.asarray(v, dtype=float).flat[0]) for n, v in body.given.items()}


def _outline(body: RoundShape) -> tuple[Callable[..., Any], Named, tuple[float, float]]:
    """What inclinations depend on: no moment and no scale; of arrays the first entry."""
    numbers = first_numbers(body)
    return body.height, tuple((n, numbers[n]) for n in body.shape), body.between


def _bare(height: Callable[..., Any], shape: Named, between: tuple[float, float]) -> Outline:
    return Outline(height, 1.0, 1.0, dict(shape), "", between)


def tumbling_ranges(body: RoundShape) -> list[tuple[float, float]]:
    """Intervals of θ in which the body tumbles, at samples, for the first of its shapes [rad].

    Parameters
    ----------
    body
        The body.

    Examples
    --------
    >>> import stability as st
    >>> [(round(a, 2), round(b, 2)) for a, b in tumbling_ranges(st.EccentricSphere(0.3))]
    [(0.0, 1.98)]
    """
    low, high = body.between
    theta = low + (high - low) * (np.arange(SAMPLES) + 0.5) / SAMPLES
    h, slope, _ = _bare(*_outline(body)).heights(theta)
    axial, transverse = (float(np.asarray(m, dtype=float).flat[0]) for m in body.moments())
    s, c = np.sin(theta), np.cos(theta)
    r, z = h * s + slope * c, h * c - slope * s
    with np.errstate(all="ignore"):
        there = tumbling(slope, r, z, s, c, transverse, axial)[0] > 0
    if stands_upright(body):
        there &= np.abs(theta - math.pi / 2) > (high - low) / SAMPLES
    ends = np.flatnonzero(np.diff(np.concatenate([[0], there.astype(int), [0]])))
    step = (high - low) / SAMPLES / 2
    return [(float(theta[a] - step), float(theta[b - 1] + step)) for a, b in ends.reshape(-1, 2)]


def sizes(body: RoundShape, *, rests: bool) -> dict[str, float]:
    """Sizes of a body's numbers, and an inclination near which it has members.

    Numbers that differ by little have the same sizes, so that what is derived near these sizes is
    derived once for all of them.

    Parameters
    ----------
    body
        The body.
    rests
        Whether the inclination is one at which the body tumbles.

    Examples
    --------
    >>> import stability as st
    >>> a, b = (sizes(st.Torus(tube), rests=True) for tube in (0.2, 0.21))
    >>> a == b, a["tube"]
    (True, 0.1875)
    """
    numbers = {n: v for n, v in first_numbers(body).items() if n not in SCALES}
    limits = getattr(body, "limits", {})
    usual = _usual(*body.between)
    for digits in range(COARSEST, FINEST + 1):
        near = {n: _rounded(v, digits) for n, v in numbers.items()}
        inside = all(
            low < near[n] / SPREAD and near[n] * SPREAD <= high for n, (low, high) in limits.items()
        )
        theta = _tumbling_at(shape_of(body), tuple(near.items())) if rests else usual
        if inside and theta is not None:
            return near | {"theta": theta}
    theta = _tumbling_at(shape_of(body), tuple(numbers.items())) if rests else usual
    return numbers | {"theta": usual if theta is None else theta}


def _usual(low: float, high: float) -> float:
    """One radian, or the middle of an interval that does not hold it."""
    return 1.0 if low < 1.0 < high else (low + high) / 2


def _rounded(value: float, digits: int) -> float:
    """A number to a few binary digits."""
    share, power = math.frexp(value)
    return math.ldexp(round(math.ldexp(share, digits)), power - digits)


@lru_cache(maxsize=256)
def _tumbling_at(shape: Shape, numbers: tuple[tuple[str, float], ...]) -> float | None:
    """The middle of the widest interval in which a body tumbles; None where it does not."""
    name, height, moments, words, between = shape
    table = dict(numbers)
    axial, transverse = (
        table[n] if m is None else m for n, m in zip(MOMENTS, moments, strict=True)
    )
    body = Outline(height, axial, transverse, {n: table[n] for n in words}, name, between)
    ranges = tumbling_ranges(body)
    if not ranges:
        return None
    low, high = max(ranges, key=lambda r: r[1] - r[0])
    return (low + high) / 2


def slope_of(body: RoundShape) -> Callable[[ArrayLike], Floats]:
    """Slope of the height at inclinations, for the first of the body's shapes.

    Parameters
    ----------
    body
        The body.
    """
    first = _bare(*_outline(body))
    return lambda theta: np.asarray(first.height_at(theta, 1))


def stands_upright(body: RoundShape) -> bool:
    """Whether the slope of the height vanishes at π/2, to double precision.

    Parameters
    ----------
    body
        The body.
    """
    return _upright(*_outline(body))


@lru_cache(maxsize=256)
def _upright(height: Callable[..., Any], shape: Named, between: tuple[float, float]) -> bool:
    """The same, found once for each height."""
    low, high = between
    if not low < math.pi / 2 < high:
        return False
    body = _bare(height, shape, between)
    scale = float(body.height_at(math.pi / 2))
    return abs(float(slope_of(body)(math.pi / 2))) <= CLOSE * scale


def levels(body: RoundShape) -> list[float]:
    """Inclinations at which the slope of the height vanishes; π/2 comes first where it is one.

    Parameters
    ----------
    body
        The body; of arrays the first entry counts.
    """
    return list(_levels(*_outline(body)))


@lru_cache(maxsize=256)
def _levels(
    height: Callable[..., Any], shape: Named, between: tuple[float, float]
) -> tuple[float, ...]:
    """The same, found once for each height."""
    low, high = between
    slope = slope_of(_bare(height, shape, between))
    upright = _upright(height, shape, between)
    grid = low + (high - low) * (np.arange(SAMPLES) + 0.5) / SAMPLES
    slopes = slope(grid)
    roots = [math.pi / 2] * upright
    for i in np.flatnonzero(slopes[:-1] * slopes[1:] < 0):
        (a, b), (f, g) = grid[i : i + 2].tolist(), slopes[i : i + 2].tolist()
        if not (upright and a <= math.pi / 2 <= b):
            from scipy.optimize import brentq  # slow to import, and a disk needs no search

            root = float(brentq(slope, a, b, xtol=1e-15))
            if abs(slope(root)) < 1e-3 * (abs(f) + abs(g)):  # a corner of the height has no zero
                roots.append(root)
    return tuple(roots)


def stays_level(body: RoundShape, numbers: Mapping[str, float], at: float) -> bool:
    """Whether the body rolls close to an inclination where its shape has other numbers.

    Parameters
    ----------
    body
        The body.
    numbers
        The other numbers by name.
    at
        The inclination.
    """
    low, high = body.between
    shape = tuple((n, numbers[n]) for n in body.shape)
    near = min(at - low, high - at) / 10
    return any(abs(t - at) < near for t in _levels(body.height, shape, body.between))


def level(body: RoundShape, theta: float | None = None) -> float | None:
    """Inclination at which the slope of the height vanishes; None for exactly upright.

    Parameters
    ----------
    body
        The body; of arrays the first entry counts.
    theta
        A number near the one that is meant, where there are several [rad].

    Raises
    ------
    NoMemberError
        If there is none, or there are several and none is meant.
    """
    low, high = body.between
    roots = levels(body)
    if not roots:
        raise NoMemberError(
            f"{body.name} rolls nowhere: the slope of its height has no zero between "
            f"{low:.6g} and {high:.6g}."
        )
    if theta is not None:
        wanted = one_number("theta", theta)
        best = min(roots, key=lambda t: abs(t - wanted))
    elif roots[0] == math.pi / 2 or len(roots) == 1:
        best = roots[0]
    else:
        angles = ", ".join(f"{t:.6g}" for t in roots)
        raise NoMemberError(
            f"{body.name} rolls at theta = {angles}; give theta=, a number near one of them."
        )
    return None if best == math.pi / 2 and stands_upright(body) else best


def start(body: RoundShape, at: float, theta: float | None = None) -> float:
    """A number to which a zero of the height's slope is the nearest.

    It has few digits where none was given, so that bodies that differ by little have the same.

    Parameters
    ----------
    body
        The body.
    at
        The zero, from `level`.
    theta
        The number near it that was given, or None.

    Examples
    --------
    >>> import stability as st
    >>> coin = st.ThickDisk(0.3)
    >>> level(coin), start(coin, level(coin))
    (1.4219063791853994, 1.375)
    """
    if theta is not None:  # members of all shapes are those nearest to it
        return float(theta)
    others = [abs(v - at) for v in levels(body) if v != at]
    low, high = body.between
    room = min([*others, at - low, high - at]) / 2
    tries = (round(at * 2**n) / 2**n for n in range(*GUESSES))
    return next((near for near in tries if abs(near - at) < room), at)


def tumbling_rates(body: RoundShape, theta: Any) -> tuple[Any, Any]:
    """φ̇ > 0 and ω₃ of tumbling over √(g/length); NaN where the body does not tumble.

    Parameters
    ----------
    body
        The body.
    theta
        Inclinations [rad].
    """
    h, slope, _ = body.heights(theta)
    axial, transverse = body.moments()
    s, c = np.sin(theta), np.cos(theta)
    r, z = h * s + slope * c, h * c - slope * s
    square, share = tumbling(slope, r, z, s, c, transverse, axial)
    phi_dot = np.sqrt(square)
    return phi_dot, phi_dot * share
