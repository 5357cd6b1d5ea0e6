"""Time of a call; cost against error: the Pareto front, and how far other routes are from it."""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np


def timed(
    call: Callable[[], Any], *, least: int = 5, most: int = 200, budget: float = 0.4
) -> list[float]:
    """Time of each of several calls [s].

    Parameters
    ----------
    call
        Function to time.
    least, most
        Smallest and largest number of calls.
    budget
        Time after which no call beyond the least starts [s].

    Examples
    --------
    >>> len(timed(lambda: None, least=3, most=3))
    3
    """
    times: list[float] = []
    begin = time.perf_counter()
    while len(times) < least or (len(times) < most and time.perf_counter() - begin < budget):
        start = time.perf_counter()
        call()
        times.append(time.perf_counter() - start)
    return times


FLOOR = 1e-16
"""Smallest error that counts: errors below it are less than the rounding of a double."""


@dataclass(frozen=True)
class Place:
    """Standing of a route in a panel."""

    time: float
    """Time of the route [s]."""
    error: float
    """Error of the route."""
    on_front: bool
    """Whether no route that is at least as accurate is faster."""
    factor: float
    """Time over that of the fastest route that is at least as accurate; 1 on the front."""
    rival: str
    """Name of that fastest route; on the front the route itself, or one that is as fast."""


def places(panel: Mapping[str, tuple[float, float]]) -> dict[str, Place]:
    """Standing of every route in a panel.

    Examples
    --------
    >>> found = places({"quick": (1.0, 1e-3), "good": (4.0, 1e-9), "poor": (6.0, 1e-8)})
    >>> [name for name, place in found.items() if place.on_front]
    ['quick', 'good']
    >>> found["poor"].rival, found["poor"].factor
    ('good', 1.5)
    """
    by_name = {}
    for name, (seconds, error) in panel.items():
        mine = max(error, FLOOR)
        better = {
            other: t for other, (t, e) in panel.items() if max(e, FLOOR) <= mine and np.isfinite(t)
        }
        rival = min(better, key=lambda other: better[other])
        factor = seconds / better[rival]
        by_name[name] = Place(seconds, error, factor <= 1.0, max(factor, 1.0), rival)
    return by_name


# --- timings in a CSV ---


def least(values: Sequence[float] | None) -> float | None:
    """The least of some times; None without any."""
    return min(values) if values else None


def timings(values: Sequence[float] | None) -> str:
    """Times as the text of one cell."""
    return " ".join(f"{v:.3e}" for v in values or ())
