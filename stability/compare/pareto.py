"""Cost against error as numbers: the Pareto front, and how far other routes are from it."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

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

    Parameters
    ----------
    panel
        (seconds, error) by name, for the routes without a wrong answer.

    Returns
    -------
    dict

    Examples
    --------
    >>> found = places({"quick": (1.0, 1e-3), "good": (4.0, 1e-9), "poor": (6.0, 1e-8)})
    >>> [name for name, place in found.items() if place.on_front]
    ['quick', 'good']
    >>> found["poor"].rival, found["poor"].factor
    ('good', 1.5)
    """
    found = {}
    for name, (time, error) in panel.items():
        mine = max(error, FLOOR)
        better = {
            other: t for other, (t, e) in panel.items() if max(e, FLOOR) <= mine and np.isfinite(t)
        }
        rival = min(better, key=lambda other: better[other])
        factor = time / better[rival]
        found[name] = Place(time, error, factor <= 1.0, max(factor, 1.0), rival)
    return found
