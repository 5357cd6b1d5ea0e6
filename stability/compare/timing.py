"""Timing of one call."""

from __future__ import annotations

import time
from collections.abc import Callable
from typing import Any


def timed(
    call: Callable[[], Any], *, least: int = 5, most: int = 200, budget: float = 0.4
) -> list[float]:
    """Seconds of each of several calls, all of them.

    Parameters
    ----------
    call
        What is timed.
    least, most
        Number of calls.
    budget
        Seconds after which no further call is made beyond the least.

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
