"""Cost against error as numbers: which routes nothing beats, and by how much the others lose."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

FLOOR = 1e-16
"""Errors below the rounding of a double count as this."""


@dataclass(frozen=True)
class Place:
    """Where a route stands in a panel."""

    time: float
    """Seconds."""
    error: float
    """Its error."""
    on_front: bool
    """Whether no other route is both faster and no less accurate, or as fast and more accurate."""
    factor: float
    """Its time over that of the fastest route that is no less accurate; 1 on the front."""
    rival: str
    """That route; its own name on the front."""


def places(panel: Mapping[str, tuple[float, float]]) -> dict[str, Place]:
    """The standing of every route that answered, none of them wrongly.

    Parameters
    ----------
    panel
        (seconds, error) by name.

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
