"""Timing of one call."""

from __future__ import annotations

import time
from collections.abc import Callable
from typing import Any


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

    Returns
    -------
    list of float

    Examples
    --------
    >>> len(timed(lambda: None, least=3, most=3))
    3
    """
    found: list[float] = []
    begin = time.perf_counter()
    while len(found) < least or (len(found) < most and time.perf_counter() - begin < budget):
        start = time.perf_counter()
        call()
        found.append(time.perf_counter() - start)
    return found
