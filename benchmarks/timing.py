"""Times of calls, taken in turns: a machine that is busy for a while hits all of them alike."""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping
from typing import Any

Clock = Callable[[], float]


def seconds(run: Callable[[], Any], clock: Clock = time.perf_counter) -> float:
    """Time of a call [s]; `time.process_time` counts the processor's, of all threads."""
    start = clock()
    run()
    return clock() - start


def in_turns(
    runs: Mapping[str, Callable[[], Any]], turns: int, clock: Clock = time.perf_counter
) -> dict[str, list[float]]:
    """Time of each call in each turn [s]; every other turn goes backwards."""
    times: dict[str, list[float]] = {name: [] for name in runs}
    for turn in range(turns):
        for name in reversed(runs) if turn % 2 else runs:
            times[name].append(seconds(runs[name], clock))
    return times


def least(
    runs: Mapping[str, Callable[[], Any]], turns: int, clock: Clock = time.perf_counter
) -> dict[str, float]:
    """Least time of each call [s]."""
    return {name: min(times) for name, times in in_turns(runs, turns, clock).items()}
