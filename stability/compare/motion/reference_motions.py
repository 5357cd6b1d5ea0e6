"""Motions whose truth is known from two independent integrations, in many digits.

`reference_motions.json` holds them.  `benchmarks/truths.py` computes them and explains how.
"""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import lru_cache
from importlib.resources import files
from typing import Any

import numpy as np

from ...base.checks import known
from ...base.types import Floats
from ...bodies.contact_laws import Contact, law_named
from ...bodies.disk import Disk

UNDETERMINED = "undetermined"
"""The outcome of a motion on which two high-precision integrations do not agree."""


@dataclass(frozen=True, eq=False)
class ReferenceMotion:
    """One motion: its launch and its true course; m = R = g = 1."""

    name: str
    """Name of the scene."""
    law: str
    """A key of `stability.bodies.contact_laws.MOTION_LAWS`."""
    k: float
    """Inertia factor."""
    mu: float | None
    """Friction coefficient; None for a law without one."""
    start: tuple[float, ...]
    """The six states at time 0, taken as exact."""
    times: Floats = field(repr=False)
    """Times at which the truth is known, shape (t,)."""
    states: Floats = field(repr=False)
    """True states at these times, rounded to double, shape (t, 6)."""
    outcome: str
    """moving, lift-off, flat, or undetermined."""
    end_time: float
    """Time of the end; the last time where the motion did not end."""
    error: float
    """Largest difference of the two integrations, over 1 or the state's size."""
    events: tuple[tuple[str, float], ...] = ()
    """Kind and time of each event of dry friction."""
    last: float = 0.0
    """The last time of a run: beyond the end of the motion, where there is one."""

    def disk(self) -> Disk:
        """The disk."""
        return Disk(k=self.k)

    def contact(self) -> Contact:
        """The law with its coefficient."""
        return law_named(self.law, self.mu, motion=True)

    @property
    def asked(self) -> Floats:
        """Times for a driver: those of the truth, and `last` where it is later."""
        beyond = [self.last] if self.last > self.times[-1] else []
        return np.concatenate([self.times, beyond])

    @property
    def ends(self) -> bool:
        """Whether the motion ends before the last time."""
        return self.outcome in ("lift-off", "flat")


@lru_cache(maxsize=1)
def scenes() -> Mapping[str, ReferenceMotion]:
    """Every scene by name.

    Examples
    --------
    >>> scenes()["lift-off"].outcome, round(scenes()["lift-off"].end_time, 6)
    ('lift-off', 16.11649)
    """
    text = files(__package__).joinpath("reference_motions.json").read_text(encoding="utf-8")
    return {record["name"]: _read(record) for record in json.loads(text)["scenes"]}


def scene(name: str) -> ReferenceMotion:
    """A scene by its name.

    Raises
    ------
    NameUnknownError
        If there is none.
    """
    return scenes()[known("scene", name, scenes())]


def _read(record: Mapping[str, Any]) -> ReferenceMotion:
    times = np.array(record["times"], dtype=float)
    states = np.array([[float(v) for v in row] for row in record["states"]])
    end = float(record["end_time"])
    ended = record["outcome"] in ("lift-off", "flat")
    return ReferenceMotion(
        record["name"],
        record["law"],
        record["k"],
        record["mu"],
        tuple(record["start"]),
        times,
        states,
        record["outcome"],
        end,
        record["error"],
        tuple((e["kind"], float(e["time"])) for e in record.get("events", ())),
        last=max(float(times[-1]), end + 2.0) if ended else float(times[-1]),
    )
