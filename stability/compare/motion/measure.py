"""Drivers on scenes at many tolerances: work against precision."""

from __future__ import annotations

import contextlib
import time
from typing import Any

import numpy as np

from ...base.errors import StabilityError
from ...base.types import Floats
from ...jobs.measured_cells import Late, Task
from ..timing import timed
from .drivers import DRIVERS, MODELS, OWN, PEOPLE, Answer, Driver, driver
from .reference_motions import ReferenceMotion, scene, scenes

CHARTED: dict[str, str] = {
    "gentle": "gentle: viscous, μ = 0.3, until t = 20",
    "near-threshold": "near threshold: rolling at ω₃ = 1.4142, until t = 200",
    "stiff-300": "stiff: μ = 300, until t = 20",
    "stiff-10000": "stiff: μ = 10⁴, until t = 10",
    "rough-long": "long: rough, until t = 1000",
    "slides_then_sticks": "dry friction: slides, then sticks, until t = 10",
    "near-flat": "approach to flatness: rough hoop, 6·10⁻⁴ rad from flat",
    "lift-off": "lift-off at t = 16.1",
}
"""Scenes of the chart and their titles."""
NAMES = tuple(d.name for d in (*OWN, *PEOPLE, *MODELS))
"""Drivers of the chart."""
PATIENCE = 0.3
"""Time of a run beyond which no tighter tolerance is tried [s]."""
LIMIT = 7.0
"""Time limit of a cell [s]."""
METRICS = ("final", "path", "audit", "event")
"""Names of the errors of a motion."""


def tasks() -> list[list[Task]]:
    """Tasks of the chart, each in a fresh process, so that its first call is the first."""
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
        Names of the scene and of the driver.

    Returns
    -------
    dict
        first: seconds of the first call, or None; tolerance: values that were tried; rows: a dict
        for each of them.  A row holds final, path, audit, event (errors), outcome (a word), seconds
        (every repeat), stated and an empty message.  A row without an answer holds only the
        message: the reason.
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
            if took > PATIENCE:  # Taylor compiles code for each order: time the run again
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
    """Time of each repeat [s]; the first run alone where it took long."""
    if took > PATIENCE:
        return [took]
    return timed(lambda: mine.run(it, it.asked, tolerance), least=1, most=9, budget=0.08)


def _forget() -> None:
    """Keep heyoka from its store of compiled code on disk, so that a first call compiles."""
    from ...integrators import taylor

    if taylor.available():
        import heyoka

        with contextlib.suppress(AttributeError):  # older versions have no such store
            heyoka.llvm_state.set_diskcache_enabled(False)


def judged(it: ReferenceMotion, motion: Answer) -> dict[str, Any]:
    """The errors of a motion.

    Parameters
    ----------
    it
        The scene, with its truth.
    motion
        Answer of a driver.

    Returns
    -------
    dict
        final: error of the last true state, over 1 or its size; path: the largest such error along
        the path; both None where the driver lacks a time of the truth.  event: error of the time of
        the end, where the truth has one, or of the events of dry friction; None where outcome or
        kinds of events differ, or there are none.  audit, outcome, stated: as in `Answer`.
    """
    both = [t for t in it.times if t in set(motion.times.tolist())]
    mine = motion.states[np.isin(motion.times, both)]
    true = it.states[np.isin(it.times, both)]
    off = distance(mine, true)
    whole = len(both) == len(it.times)
    return {
        "final": float(off[-1]) if whole else None,
        "path": float(off.max()) if whole else None,
        "audit": motion.audit,
        "event": _event(it, motion),
        "outcome": motion.outcome,
        "stated": motion.stated,
    }


def distance(mine: Floats, true: Floats) -> Floats:
    """Largest difference of states, each over 1 or its own size.

    Parameters
    ----------
    mine, true
        States of the driver and of the truth, shape (t, 6).

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
