"""Drivers on scenes at many tolerances: work against precision."""

from __future__ import annotations

import contextlib
import time
from typing import Any

import numpy as np

from ...base.errors import StabilityError
from ...base.types import Floats
from ...jobs.processes import Late, Task
from ..timing import timed
from .drivers import DRIVERS, MODELS, OWN, PEOPLE, Answer, Driver, driver
from .reference_motions import ReferenceMotion, scene, scenes

CHARTED: dict[str, str] = {
    "gentle": "gentle: viscous, mu = 0.3, T = 20",
    "near-threshold": "near threshold: rolling at omega3 = 1.4142 < √2, T = 200",
    "stiff-300": "stiff: mu = 300, T = 20",
    "stiff-10000": "stiff: mu = 10⁴, T = 10",
    "rough-long": "long: rough, T = 1000",
    "slides_then_sticks": "dry friction: slides, then sticks, T = 10",
    "near-flat": "approach to flatness: rough hoop, 6·10⁻⁴ rad from flat",
    "lift-off": "lift-off at t = 16.1",
}
"""Scenes of the chart and their titles."""
NAMES = tuple(d.name for d in (*OWN, *PEOPLE, *MODELS))
"""Drivers of the chart."""
PATIENCE = 0.3
"""Seconds of a run after which tighter tolerances are not tried."""
LIMIT = 7.0
"""Seconds that one cell may take."""
METRICS = ("final", "path", "audit", "event")
"""Errors kept side by side."""


def tasks() -> list[list[Task]]:
    """The cells of the chart, each in a process of its own, so that a first call is one."""
    return [
        [Task(f"motion/{s}/{name}", measure, (s, name), LIMIT)]
        for s in CHARTED
        if s in scenes()
        for name in NAMES
        if DRIVERS[name]().takes(scene(s))
    ]


def measure(which: str, name: str) -> dict[str, Any]:
    """One cell: a driver on a scene at all its tolerances.

    Parameters
    ----------
    which, name
        Motion and driver.

    Returns
    -------
    dict
        first: seconds of the first call; tolerance: those tried; for each of them, or None where
        there is no answer: final, path, audit, event (errors), outcome (a word), seconds (every
        repeat), stated; message: why there is none.
    """
    it, mine = scene(which), driver(name)
    times = it.asked
    _forget()
    out: dict[str, Any] = {"first": None, "tolerance": [], "rows": []}
    for tolerance in mine.tolerances:
        out["tolerance"].append(tolerance)
        start = time.perf_counter()
        try:
            motion = mine.run(it, times, tolerance)
            took = time.perf_counter() - start
            out["first"] = took if out["first"] is None else out["first"]
            if took > PATIENCE:  # which may have been compiling: Taylor's order has its own code
                [took] = timed(lambda t=tolerance: mine.run(it, times, t), least=1, most=1)  # type: ignore[misc]
            row = judged(it, motion)
            row |= {"seconds": _repeated(mine, it, tolerance, took), "message": ""}
        except (StabilityError, ArithmeticError, ValueError, RuntimeError) as error:
            took, row = time.perf_counter() - start, {"message": str(error)[:200]}
        except Late:
            out["rows"].append({"message": f"no answer within the {LIMIT:g} s of the cell"})
            return out
        out["rows"].append(row)
        if took > PATIENCE:
            break
    return out


def _repeated(mine: Driver, it: ReferenceMotion, tolerance: float, took: float) -> list[float]:
    """Seconds of each repeat; the one run itself where it took long."""
    if took > PATIENCE:
        return [took]
    return timed(lambda: mine.run(it, it.asked, tolerance), least=1, most=9, budget=0.08)


def _forget() -> None:
    """Keep heyoka from its store of compiled code on disk: a first call is one."""
    from ...integrators import taylor

    if taylor.available():
        import heyoka

        with contextlib.suppress(AttributeError):  # an older one has no such store
            heyoka.llvm_state.set_diskcache_enabled(False)


def judged(it: ReferenceMotion, motion: Answer) -> dict[str, Any]:
    """The errors of a motion.

    Parameters
    ----------
    it
        The scene, with its truth.
    motion
        What a driver says.

    Returns
    -------
    dict
        final: of the last state of the truth, over 1 or its size, None if the driver ended before;
        path: the largest over the times of both; audit; event: of the time of the end, where the
        truth has one, or of the events of dry friction, None where they are not of the same
        kinds; outcome; stated.
    """
    both = [t for t in it.times if t in set(motion.times.tolist())]
    mine = motion.states[np.isin(motion.times, both)]
    true = it.states[np.isin(it.times, both)]
    off = distance(mine, true)
    whole = len(both) == len(it.times)
    return {
        "final": float(off[-1]) if whole else None,
        "path": float(off.max()) if whole else None,
        "audit": motion.audit, "event": _event(it, motion), "outcome": motion.outcome,
        "stated": motion.stated,
    }  # fmt: skip


def distance(mine: Floats, true: Floats) -> Floats:
    """Largest difference of states, each over 1 or its own size.

    Parameters
    ----------
    mine, true
        Shape (t, 6).

    Returns
    -------
    ndarray
        Shape (t,).
    """
    return np.asarray((np.abs(mine - true) / np.maximum(1.0, np.abs(true))).max(axis=-1))


def _event(it: ReferenceMotion, motion: Answer) -> float | None:
    if it.ends:
        return abs(motion.end_time - it.end_time) if motion.outcome == it.outcome else None
    if not it.events:
        return None
    if [kind for kind, _ in it.events] != [kind for kind, _ in motion.events]:
        return None
    pairs = zip(it.events, motion.events, strict=True)
    return max(abs(a - b) for (_, a), (_, b) in pairs)
