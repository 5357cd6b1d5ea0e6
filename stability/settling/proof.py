"""Proof that a motion converges: by the tube of a member, otherwise by a box about the state."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from ..base.errors import StabilityError
from ..base.types import Floats
from .attraction import Attraction, Surroundings, attraction
from .tube.nodes import in_tube


def settles(
    around: Surroundings, given: Sequence[float], y: Sequence[Any], e: Sequence[Any]
) -> Attraction | None:
    """A proof that a motion converges to one steady motion of a family.

    Parameters
    ----------
    around, given, y, e
        As for `attraction`.

    Returns
    -------
    Attraction or None
        None where it is not proved.
    """
    if around.field is not None:
        try:
            found = in_tube(around, [v[:, 0] for v in _doubles(y)], np.array([given], dtype=float),
                            _doubles(e))  # fmt: skip
        except StabilityError:  # a function without a kernel
            return attraction(around, given, y, e)
        if found.proved[0]:
            numbers = (float(v[0]) for v in (found.limit, found.error, found.rate, found.half))
            limit, *rest = numbers
            return Attraction((limit,), *rest)
        if found.known[0]:
            return None
    return attraction(around, given, y, e)


def _doubles(balls: Sequence[Any]) -> tuple[Floats, Floats]:
    """Balls of doubles that hold balls, as centres and radii of one launch."""
    mid = [float(v.mid()) for v in balls]
    rad = [float(abs(v - m).abs_upper()) * (1 + 2.0**-50) for v, m in zip(balls, mid, strict=True)]
    return np.array([mid]), np.array([rad])
