"""The ladder: the rungs in the order of their cost, until one is fine enough.

A rung is tried where its price, a prediction, is below that of the full model.  The first whose
error is below the tolerance is taken.  The full model is last, and is not run if it is not needed.
"""

from __future__ import annotations

import math
import time
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from ..integrators.selection import HEYOKA, explicit
from .questions import QUESTIONS, Found
from .rungs.creep import applies
from .rungs.creeping import creeping, name_of
from .rungs.full import FINEST, full
from .rungs.near_steady import LINEARISED, SECOND, STEADY, near_steady
from .rungs.reduced import ReducedModel, reduced
from .rungs.track import Problem, Refused, Track

STEP = {HEYOKA: 3.5e-6, "dop853": 4e-4}
"""Time of a step of an explicit method [s]."""
RUNS, BASE, IMPLICIT = 3.0, 1.5e-3, 4e-3
"""Runs of the full model, with neighbours; time around them, and of an implicit run [s]."""
PER_TURN, PER_RATE = 7.5, 0.25
"""Steps of an explicit method in a unit of the motion's time, and in one of a decay."""
PER_ELEMENT, LEAST = 1.5e-4, 300
"""Time of an element of creep [s], and elements that creep may always take: beyond the expected
time of the full model it gives up.  They are counted, so that a loaded machine changes no choice."""
RETRY = 1e4
"""Error over the tolerance up to which creep is tried again with smaller errors on the way."""
FINER = 2
"""Runs of the full model at a finer tolerance where a quantity needs it."""
CREEP_BASE, CREEP_TURN = 3e-3, 8e-5
"""Time of creep, and for each unit of the motion's time [s]."""


@dataclass(frozen=True)
class Rung:
    """One rung of a ladder, as the report shows it."""

    name: str
    """Name of the model."""
    dimension: int
    """Number of states that are integrated; 0 for a closed form."""
    cost: float
    """Time that it took, its estimate included [s]; 0 where it was not run."""
    price: float
    """Time that was expected [s]."""
    estimate: float
    """Estimated error of what was asked, in units of the tolerance; infinite where unknown."""
    chosen: bool
    """Whether it gives the answer."""
    why: str
    """Why it was chosen or not."""
    indicators: Mapping[str, float] = field(default_factory=dict)
    """Numbers that say how valid it is, by name."""


@dataclass(eq=False)
class Climbed:
    """What a climb has found."""

    model: str
    """Name of the rung that was taken."""
    track: Track
    """Its track."""
    found: dict[str, Found]
    """Each quantity that was asked for."""
    rungs: tuple[Rung, ...]
    """All rungs in order."""


def shares(problem: Problem, track: Track, names: Sequence[str]) -> tuple[dict[str, Found], float]:
    """Each quantity of a track, and the largest error over its tolerance.

    Parameters
    ----------
    problem
        The problem.
    track
        The track.
    names
        Names of quantities.

    Returns
    -------
    found, share
        Values by name; a share up to 1 is within the tolerance.
    """
    found, share = {}, 0.0
    for name in names:
        one = found[name] = QUESTIONS[name].find(problem, track)
        size = abs(one.value) if isinstance(one.value, float) else 1.0
        share = max(share, one.error / (problem.tolerance * max(1.0, size)))
    return found, share


def price_of_full(problem: Problem) -> float:
    """Expected time of the full model with its neighbours [s].

    Parameters
    ----------
    problem
        The problem.
    """
    name = explicit(problem.flow)
    steps = problem.last * PER_TURN * problem.pace
    if problem.launches.law is not None and problem.launches.law.relaxes:
        mu = float(problem.p[1])
        decay = problem.last * PER_RATE * 3 * mu
        stiff = IMPLICIT + problem.last * problem.pace * 1e-4
        return BASE + RUNS * min(max(steps, decay) * STEP[name], stiff)
    return BASE + RUNS * steps * STEP[name]


def climb(
    problem: Problem, names: Sequence[str], models: Sequence[ReducedModel] = (),
    only: str | None = None,
) -> Climbed:  # fmt: skip
    """Climb the ladder until a rung answers within the tolerance.

    Parameters
    ----------
    problem
        The problem.
    names
        Quantities that are asked for.
    models
        Reduced models of a user's system, cheapest first.
    only
        Name of the one rung to run, with any error; None for the choice.

    Returns
    -------
    Climbed
    """
    ladder = _Ladder(problem, tuple(names), only)
    every = models if only is None else [m for m in models if m.name == only]
    steps: list[Any] = [lambda: _near(ladder), *(lambda m=m: _own(ladder, m) for m in every),
                        lambda: _creep(ladder)]  # fmt: skip
    for step in steps:
        step()
        if ladder.taken is not None:
            break
    _full(ladder)
    assert ladder.taken is not None
    name, track, found = ladder.taken
    return Climbed(name, track, found, tuple(ladder.rungs))


@dataclass(eq=False)
class _Ladder:
    """A climb under way."""

    problem: Problem
    names: tuple[str, ...]
    only: str | None
    rungs: list[Rung] = field(default_factory=list)
    taken: tuple[str, Track, dict[str, Found]] | None = None

    def asked(self, name: str) -> bool:
        return self.only in (None, name)

    def note(
        self, name: str, dimension: int, began: float, price: float, told: Track | Refused
    ) -> None:
        """Record a rung, and take it if it is fine enough."""
        if isinstance(told, Refused):
            self.rungs.append(Rung(name, dimension, _since(began), price, math.inf, False,
                                   told.why, told.indicators))  # fmt: skip
            return
        found, share = shares(self.problem, told, self.names)
        fine = share <= 1 or self.only == name
        why = "the cheapest whose error is below the tolerance"
        if not fine:
            why = f"its error is {share:.3g} times the tolerance"
        elif self.only:
            why = "asked for"
        self.rungs.append(Rung(name, dimension, _since(began), price, share, fine, why,
                               told.indicators))  # fmt: skip
        if fine:
            self.taken = name, told, found


def _since(began: float) -> float:
    return time.perf_counter() - began


def _near(ladder: _Ladder) -> None:
    """The three closed forms near a steady motion."""
    if not any(ladder.asked(n) for n in (STEADY, LINEARISED, SECOND)):
        return
    began = time.perf_counter()
    if ladder.problem.launches.dry:
        why = Refused("dry friction has no linear motion: it is not differentiable at rest")
        ladder.note(LINEARISED, 0, began, 0.0, why)
        return
    with np.errstate(all="ignore"):
        tracks = near_steady(ladder.problem)
    if len({id(t) for t in tracks.values()}) == 1:  # one reason for all
        ladder.note(LINEARISED, 0, began, 0.0, tracks[LINEARISED])
        return
    for name, track in tracks.items():
        if ladder.asked(name) and ladder.taken is None:
            ladder.note(name, 0, began, 0.0, track)
            began = time.perf_counter()


def _own(ladder: _Ladder, model: ReducedModel) -> None:
    """A user's reduced model."""
    began = time.perf_counter()
    ladder.note(model.name, len(model.system.states), began, 0.0, reduced(ladder.problem, model))


def _creep(ladder: _Ladder) -> None:
    """The rough disk and creep, which are one run."""
    problem = ladder.problem
    if problem.launches.law is None or not ladder.asked("creep"):
        return
    whole, began = price_of_full(problem), time.perf_counter()
    if not applies(problem):
        ladder.note("creep", 4, began, 0.0, creeping(problem)[2])
        return
    price = CREEP_BASE + problem.last * problem.pace * CREEP_TURN
    if explicit(problem.flow) != HEYOKA:
        price *= 5
    if price > whole and ladder.only is None:
        why = f"it would take about {1e3 * price:.2g} ms, and the full model {1e3 * whole:.2g} ms"
        ladder.rungs.append(Rung("creep", 4, 0.0, price, math.inf, False, why))
        return
    most = max(LEAST, whole / PER_ELEMENT)
    with np.errstate(all="ignore"):
        orders, name, track = creeping(problem, most)
        if not isinstance(track, Refused):  # several stretches: the errors of all add
            share = track.error / problem.tolerance
            if 1 < share < RETRY:
                finer = replace(problem, tolerance=problem.tolerance / (5 * share))
                orders, name, track = creeping(finer, most)
    for i in range(len(orders)):
        if name_of(i) == name:
            break
        share = orders[name_of(i)] / problem.tolerance
        why = f"its error is {share:.3g} times the tolerance on the way"
        ladder.rungs.append(Rung(name_of(i), 4, 0.0, price, share, False, why))
    ladder.note("creep" if isinstance(track, Refused) else name, 4, began, price, track)
    if ladder.only == "creep" and not isinstance(track, Refused):
        ladder.taken = name, track, shares(problem, track, ladder.names)[0]


def _full(ladder: _Ladder) -> None:
    """The full model, run where no other rung was taken."""
    problem = ladder.problem
    law = problem.launches.law
    name = law.name if law is not None else problem.flow.system.name
    whole = price_of_full(problem)
    if ladder.taken is not None:
        why = "the full model: not needed"
        ladder.rungs.append(Rung(name, problem.own, 0.0, whole, math.inf, False, why))
        return
    began = time.perf_counter()
    track = full(problem)
    found, share = shares(problem, track, ladder.names)
    for _ in range(FINER):
        if not 1 < share < math.inf or track.errors[-1] <= FINEST * 1e2:
            break
        finer = full(replace(problem, tolerance=problem.tolerance / (3 * share)))
        other = shares(problem, finer, ladder.names)
        if other[1] >= share:
            break
        track, (found, share) = finer, other
    why = "the full model; no cheaper one is fine enough"
    if share > 1:
        why = "the full model, and its own error is above the tolerance"
    cost = _since(began)
    ladder.rungs.append(Rung(name, problem.own, cost, whole, share, True, why, track.indicators))
    ladder.taken = name, track, found
