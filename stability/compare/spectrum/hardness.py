"""Hardness classes: sets of points that are easy or hard for routes to a spectrum.

Every point is a double that can be typed in.  Random points come from a fixed seed.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from functools import lru_cache
from typing import Any

import numpy as np

from ...base.types import Floats
from ...bodies.families import FAMILIES
from .points import Points, edge

SEED = 20161
EDGES: tuple[tuple[str, str, float, float | None, float, float], ...] = (
    ("rolling", "viscous", 0.25, 0.3, 1.0, 2.0),
    ("rolling", "viscous", 0.5, 300.0, 0.5, 2.0),
    ("spinning", "viscous", 0.25, 0.3, 1.0, 3.0),
    ("spinning", "viscous", 0.3125, 0.9, 2.0, 9.0),
    ("tumbling", "viscous", 0.25, 3.0, 0.3, 1.5),
    ("tumbling", "viscous", 0.5, 0.1, 0.01, 0.1),
    ("tumbling", "viscous", 0.5, 0.003, 1e-6, 1e-3),
    ("tumbling", "viscous", 0.375, 0.9, 0.7, 1.0),
    ("tumbling", "viscous", 0.3125, 10.0, 0.001, 0.1),
    ("rolling", "linear-viscous", 0.3125, 2.0, 0.5, 3.0),
    ("rolling", "rough", 0.25, None, 0.3, 1.0),
    ("rolling", "smooth", 0.3, None, 0.3, 2.0),
    ("spinning", "rough", 0.25, None, 0.3, 2.0),
    ("spinning", "smooth", 0.375, None, 0.5, 3.0),
)
"""Boundaries of the verdict along `at`: family, law, k, mu, and values on either side."""
DEGREES = (0.1, 0.3, 1.0, 2.0, 5.0)
"""Inclinations of a hoop that is nearly flat [degrees]."""


def close_to(
    where: tuple[str, str, float, float | None, float, float], distances: Sequence[float]
) -> Points:
    """Points on both sides of a boundary, at relative distances.

    Parameters
    ----------
    where
        One of `EDGES`.
    distances
        Relative distances from the boundary along `at`.

    Returns
    -------
    Points
        For each distance, the point below the boundary, then the point above.
    """
    family, law, k, mu, low, high = where
    value = edge(family, law, k, mu, low, high)
    at = np.array([value * (1 + side * d) for d in distances for side in (-1, 1)])
    friction = "" if mu is None else f", mu = {mu:g}"
    return _points(family, law, k, mu, at, f"{family}, {law}, k = {k:g}{friction}")


def _points(family: str, law: str, k: Any, mu: Any, at: Any, label: str = "") -> Points:
    at = np.asarray(at, dtype=float)

    def full(value: Any) -> Floats:
        return np.broadcast_to(np.asarray(value, dtype=float), at.shape).copy()

    return Points(family, law, full(k), None if mu is None else full(mu), at, label=label)


def _random(rng: np.random.Generator, count: int, mu: tuple[float, float]) -> list[Points]:
    """Members of the viscous families, mu* log-uniform."""
    ranges = {name: family.sampled for name, family in FAMILIES.items() if family.sampled}
    return [
        _points(
            family,
            "viscous",
            rng.uniform(0.05, 0.5, count),
            10 ** rng.uniform(math.log10(mu[0]), math.log10(mu[1]), count),
            rng.uniform(low, high, count),
        )
        for family, (low, high) in ranges.items()
    ]


def _flat_hoop() -> list[Points]:
    theta, mu = np.meshgrid(np.radians(DEGREES), [0.01, 0.1, 1.0, 10.0])
    return [_points("tumbling", "viscous", 0.5, mu.ravel(), theta.ravel())]


def coalescence(family: str, k: float, mu: float, low: float, high: float) -> float:
    """The double next to the value of `at` at which two eigenvalues of a viscous family meet.

    Parameters
    ----------
    family, k, mu
        Family, inertia factor and coefficient of viscous friction.
    low, high
        Values between which the number of real eigenvalues changes once.

    Returns
    -------
    float

    Examples
    --------
    >>> 0.5 < coalescence("spinning", 0.25, 4.0, 0.5, 1.0) < 1.0
    True
    """

    def real(at: float) -> int:
        values = _points(family, "viscous", k, mu, [at]).truth.eigenvalues
        return int((values.imag == 0).sum())

    ends = real(low), real(high)
    while (middle := (low + high) / 2) not in (low, high):
        if real(middle) == ends[0]:
            low = middle
        else:
            high = middle
    return low


MEETINGS = (
    ("rolling", 0.25, 1.0, 0.2, 1.0),
    ("rolling", 0.5, 3.0, 0.05, 0.6),
    ("spinning", 0.25, 4.0, 0.5, 1.0),
    ("tumbling", 0.25, 4.0, 0.3, 0.6),
)
"""Where eigenvalues coalesce along `at`: family, k, mu and values on either side."""


def _meeting() -> list[Points]:
    found = []
    for family, k, mu, low, high in MEETINGS:
        at = coalescence(family, k, mu, low, high)
        near = [at, math.nextafter(at, math.inf), *(at * (1 + s) for s in (1e-14, 1e-12, 1e-10))]
        found.append(_points(family, "viscous", k, mu, near))
    return found


def _conservative() -> list[Points]:
    return [
        close_to(e, (1e-2, 1e-5, 1e-8, 1e-11, 1e-15)) for e in EDGES if e[1] in ("rough", "smooth")
    ]


def _viscous() -> list[Any]:
    return [e for e in EDGES if e[3] is not None]


@lru_cache(maxsize=1)
def _makers() -> Mapping[str, tuple[str, Callable[[], list[Points]]]]:
    rng = np.random.default_rng
    return {
        "open": ("anywhere: random k, μ* in 0.1…10", lambda: _random(rng(SEED), 16, (0.1, 10.0))),
        "near": (
            "near a boundary: relative distance 10⁻³…10⁻⁷",
            lambda: [close_to(e, (1e-3, 1e-5, 1e-7)) for e in _viscous()],
        ),
        "very-near": (
            "very near a boundary: relative distance 10⁻⁹…10⁻¹⁵",
            lambda: [close_to(e, (1e-9, 1e-12, 1e-15)) for e in _viscous()],
        ),
        "large-mu": ("large friction: μ* in 10³…10⁸", lambda: _random(rng(SEED), 16, (1e3, 1e8))),
        "small-mu": (
            "small friction: μ* in 10⁻¹⁰…10⁻³",
            lambda: _random(rng(SEED), 16, (1e-10, 1e-3)),
        ),
        "flat-hoop": ("tumbling hoop at 0.1°…5° from flat", _flat_hoop),
        "meeting": ("two eigenvalues coalesce (defective), to 1 ulp…10⁻¹⁰", _meeting),
        "conservative": ("smooth and rough: 10⁻²…10⁻¹⁵ next to a Jordan block", _conservative),
    }


def classes() -> dict[str, str]:
    """Title of each hardness class, in order of display.

    Returns
    -------
    dict

    Examples
    --------
    >>> list(classes())[:2]
    ['open', 'near']
    """
    return {name: title for name, (title, _) in _makers().items()}


@lru_cache(maxsize=8)
def points_of(name: str) -> tuple[Points, ...]:
    """The points of a hardness class, in groups of one family and law.

    Parameters
    ----------
    name
        A key of `classes()`.

    Returns
    -------
    tuple of Points
    """
    return tuple(_makers()[name][1]())
