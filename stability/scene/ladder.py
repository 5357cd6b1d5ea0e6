"""The ladder: the rungs in the order of their cost, until one is fine enough.

A rung is tried where its price, a prediction, is below that of the full model.  The first whose
error is below the tolerance is taken.  The full model is last, and is not run if it is not needed.
"""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import partial
from weakref import WeakKeyDictionary

import numpy as np

from ..base.checks import known
from ..base.types import Record
from ..integrators.flow import Flow
from ..integrators.selection import HEYOKA, METHODS, TURN_POWER, explicit
from .questions import QUESTIONS, UNKNOWN, Estimate, relative_error
from .rungs.creep import MOST_ORDERS, applies
from .rungs.creeping import Work, creeping, name_of
from .rungs.drifting import DRIFT, ROLLING, drifting
from .rungs.full import COARSEST, FINEST, STIFF, full
from .rungs.near_steady import CLOSED_FORMS, LINEARISED, near_steady
from .rungs.reduced import ReducedModel, reduced
from .rungs.track import LaunchProblem, Refused, Track, decade

STEP = {HEYOKA: 1.5e-6, "dop853": 2e-4}
"""Time of a step of an explicit method [s]."""
RUNS, BASE = 3.0, 5e-4
"""Runs of the full model, with neighbours, and the time around them [s]."""
IMPLICIT = 5e-3
"""Least time of an implicit method, of all runs [s]."""
PER_TURN, PER_RATE = 12.0, 0.15
"""Steps of an explicit method in a unit of the motion's time, and in one of a decay."""
CALM, LIVELY = 0.1, 0.3
"""Least share of these times and steps, near a steady motion, and the distance from it at which
they are whole."""
PER_ELEMENT, LEAST = 1e-4, 15
"""Time of an element of creep [s], and elements that it may always take.  Beyond the expected time
of the full model creep gives up.  Work is counted, so that no clock decides a choice."""
AGAIN, RETURNS = 5 / 3, 0.3
"""Runs of the full model after a stretch of creep, whose error they carry, over those from the
start; the share of its expected time from the start that all such stretches may take."""
WORTH, SURE, BRIEF, PROBE = 1.5, 0.6, 5e-3, 0.15
"""Price of creep over that of the full model above which it is not tried, and above which it is
tried on a first part of the time alone, since it may fail; the price up to which that is not worth
it [s]; that part."""
ORDERS = tuple(map(name_of, range(MOST_ORDERS + 1)))
"""Names of the orders of creep."""
RETRY = 1e4
"""Error over the tolerance up to which creep is tried again with smaller errors on the way."""
DRIFTS, EXPENSIVE = 10.0, 0.03
"""Square of the distance from rolling over the tolerance up to which its drift is tried; the least
expected time of the full model [s]."""
FINER = 2
"""Runs of the full model at a finer tolerance where a quantity needs it."""
CREEP_BASE, CREEP_ORDER, CREEP_FIXED, SLOWER = 1e-3, 1.2e-5, 3.0, 5.0
"""Time of creep; of an order on an element [s]; orders that the rest of the work is worth; the
factor without heyoka."""
CREEP_TURN, GAIN = 1.25, 3.0
"""Elements in a unit of the motion's time; friction over the rate of the motion, over the factor
that an order gains."""

ALWAYS, MOSTLY, LONG = 1e-3, 5.0, 2.0
"""Time of a climb around its rungs [s]; its time over the expected one from which it mostly built
programs; the time up to which it is then measured again [s]."""
_SEEN: WeakKeyDictionary[Flow, set[tuple[float, str | None]]] = WeakKeyDictionary()


@dataclass(frozen=True, eq=False)
class Rung(Record):
    """One rung of a ladder, as the report shows it.

    Source: the ladder of docs/explanation/scenes.md; errors against the full model: tests/scene.

    Examples
    --------
    >>> import stability as st
    >>> start = {"theta": 1.55, "omega3": 1.5}
    >>> scene = st.Scene(st.Disk(), st.Viscous(300.0), start, horizon=1.0, tolerance=1e-2)
    >>> [rung.name for rung in scene.answer().rungs if rung.chosen]
    ['linearised']
    """

    name: str
    """Name of the model."""
    dimension: int
    """Number of states that are integrated; 0 for a closed form."""
    cost: float = field(compare=False)
    """Time that it took, its estimate included, without `built` [s]; 0 where it was not run."""
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
    built: float = field(default=0.0, compare=False)
    """Time that was spent on what is built once [s]."""


@dataclass(eq=False)
class Climbed:
    """What a climb has found."""

    model: str
    """Name of the rung that was taken."""
    track: Track | None
    """Its track; None where the one rung that was asked for does not apply."""
    estimates: dict[str, Estimate]
    """Each quantity that was asked for."""
    rungs: tuple[Rung, ...]
    """All rungs in order."""
    share: float
    """Largest error over the tolerance."""
    alone: bool = False
    """Whether this rung alone was asked for."""


def shares(
    problem: LaunchProblem, track: Track, names: Sequence[str]
) -> tuple[dict[str, Estimate], float]:
    """Each quantity of a track, and the largest error over its tolerance: 1 is fine enough."""
    estimates, share = {}, 0.0
    for name in names:
        estimate = estimates[name] = QUESTIONS[name].find(problem, track)
        share = max(share, relative_error(estimate) / problem.tolerance)
    if track.finish is not None and track.finish.kind in UNKNOWN:
        share = math.inf  # the model gave up on the way
    return estimates, share


def rungs_of(problem: LaunchProblem, models: Sequence[ReducedModel]) -> tuple[str, ...]:
    """Names of all rungs that may be asked for."""
    orders = ("creep", *ORDERS) if applies(problem) else ()
    labels = [m.name for m in models]
    return tuple(dict.fromkeys((*CLOSED_FORMS, DRIFT, *labels, *orders, problem.launches.name)))


def price_of_full(problem: LaunchProblem, length: float | None = None) -> float:
    """Expected time of the full model with its neighbours [s], over a dimensionless length."""
    name, length = explicit(problem.flow), problem.last if length is None else length
    turns = length * problem.pace * min(1.0, max(CALM, problem.near.distance / LIVELY))
    steps = turns * PER_TURN
    if problem.friction:
        decay = length * PER_RATE * 3 * problem.friction
        # an implicit method takes over where it costs as much as an explicit one
        asked = max(FINEST, min(COARSEST, STIFF * problem.tolerance))
        turn = turns * PER_RATE * METHODS[name].turn * (asked / 1e-6) ** -TURN_POWER
        stiff = IMPLICIT + RUNS * turn * STEP[name]
        return BASE + float(min(RUNS * max(steps, decay) * STEP[name], stiff))
    return BASE + RUNS * steps * STEP[name]


def climb(
    problem: LaunchProblem,
    names: Sequence[str],
    models: Sequence[ReducedModel] = (),
    only: str | None = None,
    *,
    measured: bool = False,
) -> Climbed:
    """Climb the ladder until a rung answers within the tolerance.

    `models` are reduced models of a user's system, cheapest first; `only` names the one rung to
    run, with any error.  `measured` asks for the costs of a second climb where the first mostly
    built programs.
    """
    seen, key = _SEEN.setdefault(problem.flow, set()), (decade(problem.tolerance), only)
    climbed = _climb(problem, names, models, only)
    spent = sum(r.cost for r in climbed.rungs)
    due = ALWAYS + sum(r.price for r in climbed.rungs if r.cost)
    if measured and key not in seen and MOSTLY * due < spent < LONG:
        again = _climb(replace(problem), names, models, only).rungs  # nothing is kept but programs
        pairs = [(r, min(r.cost, a.cost)) for r, a in zip(climbed.rungs, again, strict=True)]
        climbed.rungs = tuple(replace(r, cost=cost, built=r.cost - cost) for r, cost in pairs)
    seen.add(key)
    return climbed


def _climb(
    problem: LaunchProblem, names: Sequence[str], models: Sequence[ReducedModel], only: str | None
) -> Climbed:
    if only is not None:
        known("only", only, rungs_of(problem, models))
    ladder = _Ladder(problem, tuple(names), only)
    steps: list[Callable[[], None]] = [partial(_near, ladder), partial(_drift, ladder)]
    steps += [partial(_reduced_rung, ladder, m) for m in models if only in (None, m.name)]
    steps += [partial(_creep, ladder), partial(_full, ladder)]
    for step in steps:
        step()
    if ladder.taken is None:
        return Climbed("none", None, {}, tuple(ladder.rungs), math.inf)
    name, track, estimates, share = ladder.taken
    return Climbed(name, track, estimates, tuple(ladder.rungs), share, only is not None)


@dataclass(eq=False)
class _Ladder:
    """A climb under way."""

    problem: LaunchProblem
    names: tuple[str, ...]
    only: str | None
    rungs: list[Rung] = field(default_factory=list)
    taken: tuple[str, Track, dict[str, Estimate], float] | None = None

    def asked(self, *names: str) -> bool:
        """Whether one of these rungs is to be tried."""
        return self.taken is None and (self.only is None or self.only in names)

    def note(
        self, name: str, dimension: int, began: float, price: float, outcome: Track | Refused
    ) -> None:
        """Record a rung, and take it if it is fine enough."""
        if isinstance(outcome, Refused):
            share, fine, why = math.inf, False, outcome.why
        else:
            estimates, share = shares(self.problem, outcome, self.names)
            fine = share <= 1 or self.only is not None
            why = "asked for" if self.only else "the cheapest whose error is below the tolerance"
            if not fine:
                many = f"its error is {share:.3g} times the tolerance"
                why = many if share < math.inf else "not known"
            if fine:
                self.taken = name, outcome, estimates, share
        cost = _since(began)
        self.rungs.append(Rung(name, dimension, cost, price, share, fine, why, outcome.indicators))


def _since(began: float) -> float:
    return time.perf_counter() - began


def _near(ladder: _Ladder) -> None:
    """The three closed forms near a steady motion."""
    if not ladder.asked(*CLOSED_FORMS):
        return
    began = time.perf_counter()
    if ladder.problem.launches.dry:
        why = Refused("dry friction has no linear motion: it is not differentiable at rest")
        ladder.note(LINEARISED, 0, began, 0.0, why)
        return
    with np.errstate(all="ignore"):
        tracks = near_steady(
            ladder.problem, always=ladder.only is not None, price=price_of_full(ladder.problem)
        )
    if isinstance(tracks, Refused):
        ladder.note(ladder.only or LINEARISED, 0, began, 0.0, tracks)
        return
    for name, track in tracks.items():
        if ladder.asked(name):
            ladder.note(name, 0, began, 0.0, track)
            began = time.perf_counter()


def _drift(ladder: _Ladder) -> None:
    """The slow drift of rolling, where it may be fine enough and the full model is expensive."""
    problem = ladder.problem
    if not ladder.asked(DRIFT):
        return
    began = time.perf_counter()
    if ladder.only is None:
        if not problem.friction:
            return
        near = problem.near
        hopeless = near.distance**2 > DRIFTS * problem.tolerance
        if near.family != ROLLING or hopeless or price_of_full(problem) < EXPENSIVE:
            return
    with np.errstate(all="ignore"):
        ladder.note(DRIFT, 0, began, 0.0, drifting(problem))


def _reduced_rung(ladder: _Ladder, model: ReducedModel) -> None:
    """A user's reduced model."""
    if not ladder.asked(model.name):
        return
    began = time.perf_counter()
    ladder.note(model.name, len(model.system.states), began, 0.0, reduced(ladder.problem, model))


def _creep(ladder: _Ladder) -> None:
    """The rough disk and creep, which are one run."""
    problem = ladder.problem
    if not problem.touches or not ladder.asked("creep", *ORDERS):
        return
    whole, began = price_of_full(problem), time.perf_counter()
    states = problem.own - len(problem.launches.model.sliding)
    if not applies(problem):
        ladder.note("creep", states, began, 0.0, creeping(problem)[2])
        return
    price = _price_of_creep(problem)
    if price > WORTH * whole and ladder.only is None:
        why = f"not tried: expected to take {price / whole:.2g} times as long as the full model"
        ladder.rungs.append(Rung("creep", states, 0.0, price, math.inf, False, why))
        return
    order = ORDERS.index(ladder.only) if ladder.only in ORDERS else None
    work = Work()
    if ladder.only is None:
        least = PER_ELEMENT * LEAST
        work = Work(
            max(least, whole),
            least,
            max(least, RETURNS * whole),
            PER_ELEMENT,
            lambda length: AGAIN * price_of_full(problem, length),
            math.inf if price < max(SURE * whole, BRIEF) else PROBE * problem.last,
        )
    with np.errstate(all="ignore"):
        orders, name, track = creeping(problem, work, order)
        if not isinstance(track, Refused) and order is None:
            share = track.error / problem.tolerance
            if 1 < share < RETRY:  # several stretches: the errors of all add
                finer = replace(problem, tolerance=problem.tolerance / (5 * share))
                orders, name, track = creeping(finer, work)
    for i in range(len(orders)):
        if name_of(i) == name:
            break
        share = orders[name_of(i)] / problem.tolerance
        why = f"its error is {share:.3g} times the tolerance on the way"
        if share <= 1:
            why += ", more than one of several stretches may have"
        ladder.rungs.append(Rung(name_of(i), states, 0.0, price, share, False, why))
    ladder.note("creep" if isinstance(track, Refused) else name, states, began, price, track)


def _price_of_creep(problem: LaunchProblem) -> float:
    """Expected time of creep [s]."""
    elements = problem.last * problem.pace * CREEP_TURN
    gain = math.log(max(problem.friction / (GAIN * problem.pace), 1.5))
    orders = CREEP_FIXED + math.log(1 / problem.tolerance) / gain
    price = CREEP_BASE + elements * orders * CREEP_ORDER
    return price * (1.0 if explicit(problem.flow) == HEYOKA else SLOWER)


def _full(ladder: _Ladder) -> None:
    """The full model, run where no other rung was taken."""
    problem, name, whole = (
        ladder.problem,
        ladder.problem.launches.name,
        price_of_full(ladder.problem),
    )
    if not ladder.asked(name):
        if ladder.only is None:
            why = "the full model: not needed"
            ladder.rungs.append(Rung(name, problem.own, 0.0, whole, math.inf, False, why))
        return
    began = time.perf_counter()
    track = full(problem)
    estimates, share = shares(problem, track, ladder.names)
    for _ in range(FINER):
        if not 1 < share < math.inf or track.errors[-1] <= FINEST * 1e2:
            break
        finer = full(replace(problem, tolerance=problem.tolerance / (3 * share)))
        other = shares(problem, finer, ladder.names)
        if other[1] >= share:
            break
        track, (estimates, share) = finer, other
    why = "the full model; no cheaper one is fine enough" if ladder.only is None else "asked for"
    if share > 1:
        why = "the full model, and its own error is above the tolerance"
    cost = _since(began)
    ladder.rungs.append(Rung(name, problem.own, cost, whole, share, True, why, track.indicators))
    ladder.taken = name, track, estimates, share
