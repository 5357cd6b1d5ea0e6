"""Creep as rungs: a transient of the full model, creep of an order, and the full model after it.

The slip of the start decays first.  Creep then runs as far as slip follows the motion.  Where it no
longer does, before a lift-off for example, the full model takes over, and creep is tried again.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np

from ...base.types import Floats
from .creep import CreepPath, HeldMotion, applies, creep_path, held_of, transient
from .full import between, full
from .track import Finish, LaunchProblem, Refused, Track, relative

TURNS = 6
"""Most times that creep is tried again."""
AHEAD = 3.0
"""Time of the full model before creep is tried again, in units of the motion's own time."""
FINE = 1e-12
"""Tolerance of short runs between the samples of a transient."""
SHARE = 0.02
"""Least share of the horizon that creep must reach before slip is free again."""
UNABLE = 10.0
"""Error of a stretch over the tolerance above which creep is given up."""
PATIENCE = 0.1
"""Share of the horizon that the full model runs before creep holds for the first time."""
ENDS = "a guard of the full model fails before the slip has decayed"
"""The reason where the motion ends before creep begins."""
REPEATED = 2.0
"""Elements that are tried over those that are used, where creep needs several stretches."""
GROWN = 2.0
"""Factor on an error that later stretches carry."""
SHARE_OF_WINDOW = 0.1
"""Share of the tolerance for one of several stretches of creep."""


def name_of(order: int) -> str:
    """Name of a rung: the rough disk, or creep of an order.

    Examples
    --------
    >>> name_of(0), name_of(2)
    ('rough', 'creep-2')
    """
    return f"creep-{order}" if order else "rough"


@dataclass(frozen=True, eq=False)
class Piece:
    """A stretch of a track by one model."""

    begin: float
    """Its first time."""
    end: float
    """Its last time."""
    states: Callable[[Floats], Floats]
    """States at times in it."""
    errors: Callable[[Floats], Floats]
    """Errors at times in it."""


@dataclass(frozen=True)
class Work:
    """What creep may cost, counted in work so that no clock decides."""

    most: float = np.inf
    """Time after which it gives up [s]."""
    least: float = np.inf
    """Time before which it does not give up [s]."""
    returns: float = np.inf
    """Time of all stretches of the full model after which it gives up [s].  Where slip is free the
    full model's steps are short, so that a stretch may cost as much as the whole run."""
    element: float = 0.0
    """Time of an element [s]."""
    stretch: Callable[[float], float] = lambda _length: 0.0
    """Expected time of the full model over a length of time after creep [s]."""
    probe: float = np.inf
    """Length of time that creep tries first."""


@dataclass(eq=False)
class Climb:
    """The way through a problem by pieces, as far as it is known."""

    problem: LaunchProblem
    """The problem."""
    held: HeldMotion
    """The held body of its law."""
    work: Work
    """What creep may cost."""
    order: int | None = None
    """The order that is asked for, or None."""
    now: float = 0.0
    """Time reached."""
    state: Floats = field(default_factory=lambda: np.empty(0))
    """State reached, shape (n,)."""
    carried: Floats = field(default_factory=lambda: np.empty(0))
    """Its error, shape (n,)."""
    pieces: list[Piece] = field(default_factory=list)
    """The pieces so far."""
    notes: list[str] = field(default_factory=list)
    """What happened, in sentences."""
    orders: dict[str, float] = field(default_factory=dict)
    """Largest error of each order of creep that was computed."""
    highest: int = -1
    """Largest order used."""
    relaxation: float = np.inf
    """Least rate of decay of slip over that of its drive, on the stretches of creep."""
    normal: float = np.inf
    """Least normal force on the stretches of creep."""
    slip: float = 0.0
    """Largest slip there."""
    finish: Finish | None = None
    """The end before the horizon."""
    steps: int = 0
    """Steps of the full model."""
    spent: float = 0.0
    """Time that all elements are worth [s]."""
    ahead: float = 0.0
    """Time that elements to the horizon are worth where they go on as the last ones [s]."""
    stretched: float = 0.0
    """Time that the stretches of the full model are expected to take [s]."""
    lost: str = ""
    """Why no later stretch can keep the tolerance; empty where it can."""
    bound: bool = False
    """Whether the slip follows the motion already: no transient is needed."""
    reach: float = np.inf
    """Length of time that creep tries at once."""


def creeping(
    problem: LaunchProblem, work: Work = Work(), order: int | None = None
) -> tuple[dict[str, float], str, Track | Refused]:
    """The lowest order of creep that is fine enough, with what is before and after.

    The error of each order that was computed, by name; the order chosen; its track, or the reason
    why there is none.  A given `order` is taken with any error.
    """
    if not applies(problem):
        why = f"{problem.launches.name} has no creep: its slip does not decay at a rate mu"
        return {}, "creep", Refused(why)
    climb = Climb(
        problem,
        held_of(problem),
        work,
        order,
        state=problem.start,
        carried=np.zeros(problem.own),
        reach=work.probe,
    )
    turns, why = 0, ""
    while climb.finish is None and climb.now < problem.last:
        if climb.spent > work.least and climb.spent + climb.ahead > work.most:
            why = f"creep needs many stretches and is given up at {problem.when(climb.now)}"
            return climb.orders, "creep", Refused(why, _indicators(climb))
        before = climb.now
        said = _forward(climb)
        if not said and climb.now > before:
            continue
        if climb.lost:
            return climb.orders, "creep", Refused(climb.lost, _indicators(climb))
        why, climb.bound = why or said, False
        turns += 1
        if turns > TURNS:
            break
        ahead = climb.now + AHEAD * turns / problem.pace
        late = ahead - climb.now > PATIENCE * problem.last
        if climb.highest < 0 and (late or said == ENDS):
            return climb.orders, "creep", Refused(why, _indicators(climb))
        ahead = problem.last if turns == TURNS else min(ahead, problem.last)
        climb.stretched += work.stretch(ahead - climb.now)
        if climb.stretched > work.returns:
            why = f"{why}, and the full model there may cost as much as from the start"
            return climb.orders, "creep", Refused(why, _indicators(climb))
        _by_full(climb, ahead)
        if climb.lost and climb.now < problem.last:
            return climb.orders, "creep", Refused(climb.lost, _indicators(climb))
    if climb.highest < 0:
        return climb.orders, "creep", Refused(why or "creep reaches nothing", _indicators(climb))
    return climb.orders, name_of(climb.highest), _joined(climb)


def _indicators(climb: Climb) -> dict[str, float]:
    if not np.isfinite(climb.relaxation):
        return {}
    return {
        "rate of decay of slip over that of its drive": climb.relaxation,
        "least normal force": climb.normal,
        "largest slip": climb.slip,
    }


def _forward(climb: Climb) -> str:
    """A transient, and creep as far as it holds; the reason where it does not hold at all."""
    problem, tolerance = climb.problem, climb.problem.tolerance
    times, states = np.array([climb.now]), climb.state[None]
    if not climb.bound:
        early = transient(problem, climb.held, climb.state, climb.now, tolerance)
        if isinstance(early, str):
            return early
        times, states, end = early
        if end is not None:
            return ENDS
        if times[-1] >= problem.last:
            return "the horizon ends before the slip has decayed"
    begin = float(times[-1])
    last = min(problem.last, begin + climb.reach)
    fine = tolerance if climb.bound or climb.reach == np.inf else SHARE_OF_WINDOW * tolerance
    path = creep_path(problem, climb.held, states[-1], begin, last, fine)
    if isinstance(path, str):
        return path
    done = path.elements.edges[-1]
    if not path.bound and done - climb.now < SHARE * (problem.last - climb.now):
        return f"slip follows the motion only up to {problem.when(done)}"
    climb.spent += climb.work.element * path.tried
    said = _use(climb, times, states, path)
    if said:
        return said
    stretches = (problem.last - done) / (done - begin) if path.bound else 0.0
    climb.ahead = climb.work.element * REPEATED * len(path.relaxation) * stretches
    whole = climb.reach == climb.work.probe and done >= last  # what follows is tried at once
    climb.bound, climb.reach = path.bound, np.inf if whole else 2 * (done - begin)
    return ""


def _use(climb: Climb, times: Floats, states: Floats, path: CreepPath) -> str:
    """Add the transient and the lowest order of creep that is fine enough; or why none is.

    Where the first stretch is too coarse, creep is given up; later the full model takes over.
    """
    elements, tolerance = path.elements, climb.problem.tolerance
    deviation = np.zeros((*path.orders[0].path.shape[:-1], climb.problem.own))
    if climb.carried.any():
        n = climb.held.n
        along = path.linear.solve(np.zeros_like(deviation[..., :n]), climb.carried[:n])
        deviation[..., :n] = along
    sizes = []
    for i, order in enumerate(path.orders):
        # signs of the parts are known, their higher orders are not
        size = relative(np.abs(order.errors) + GROWN * np.abs(deviation), order.states)
        sizes.append(size + path.unresolved)
        name = name_of(i)
        climb.orders[name] = max(climb.orders.get(name, 0.0), float(sizes[-1].max()))
    left = tolerance if elements.edges[-1] >= climb.problem.last else SHARE_OF_WINDOW * tolerance
    fine = [i for i, size in enumerate(sizes) if size.max() <= left]
    best = fine[0] if fine else int(np.argmin([size.max() for size in sizes]))
    if not fine and climb.order is None and sizes[best].max() > UNABLE * tolerance:
        why = f"its orders end at an error of {sizes[best].max():.2g}"
        climb.lost = why if climb.highest < 0 else ""
        return why
    if climb.order is not None:
        best = min(climb.order, len(sizes) - 1)
    chosen, size = path.orders[best], sizes[best]
    six, first = chosen.states, float(times[-1])

    tails = elements.tails(six)

    def inside(asked: Floats) -> Floats:
        """Error of interpolation, which slip has in full: it follows from accelerations."""
        which = np.clip(np.searchsorted(elements.edges, asked, side="right") - 1, 0, len(six) - 1)
        return np.where(np.isin(asked, elements.edges), 0.0, tails[which])

    def early(asked: Floats) -> Floats:
        return between(climb.problem, times[:1], states[:1], asked, FINE)  # one run for all

    small = float(relative(climb.carried, states[0]))
    if first > climb.now:
        still = Piece(climb.now, first, early, lambda asked: np.full(len(asked), small))
        climb.pieces.append(still)
    climb.pieces += [
        Piece(
            first,
            float(elements.edges[-1]),
            lambda asked: elements.at(asked, six),
            lambda asked: elements.at(asked, size[..., None])[:, 0] + inside(asked),
        ),
    ]
    when = climb.problem.when
    if first > climb.now:
        climb.notes.append(f"the full model to {when(first)}, until the slip has decayed")
    many = "1 element" if len(six) == 1 else f"{len(six)} elements"
    climb.notes.append(f"{name_of(best)} to {when(elements.edges[-1])} on {many}")
    climb.highest = max(climb.highest, best)
    climb.relaxation = min(climb.relaxation, float(path.relaxation.min()))
    climb.normal = min(climb.normal, path.normal)
    climb.slip = max(climb.slip, float(np.hypot(*np.moveaxis(chosen.slip, -1, 0)).max()))
    climb.now, climb.state = float(elements.edges[-1]), six[-1, -1]
    last = (chosen.errors + deviation)[-1, -1]
    climb.carried = last + np.copysign(path.unresolved, last)
    return ""


def _by_full(climb: Climb, last: float) -> None:
    """The full model from where creep no longer holds."""
    track = full(climb.problem, climb.now, climb.state, climb.carried, last)
    climb.pieces.append(
        Piece(
            climb.now,
            float(track.times[-1]),
            track.at,
            lambda asked: np.interp(asked, track.times, track.errors),
        )
    )
    reached = climb.problem.when(track.times[-1])
    climb.notes.append(f"the full model to {reached}, where slip is not bound")
    climb.steps += track.steps
    climb.finish = track.finish
    climb.now, climb.state = float(track.times[-1]), track.states[-1]
    count = climb.problem.own
    climb.carried = np.full(count, track.errors[-1] / count**0.5)
    if not np.isfinite(climb.carried).all():
        climb.lost = "the error of the full model between two stretches has no bound"


def _joined(climb: Climb) -> Track:
    """One track from the pieces."""
    pieces, problem = climb.pieces, climb.problem
    last = climb.now
    times = problem.times[problem.times <= last]
    if climb.finish is not None and (not len(times) or times[-1] < last):
        times = np.append(times, last)
    begins = np.array([p.begin for p in pieces])

    def gather(asked: Floats, of: Callable[[Piece], Callable[[Floats], Floats]]) -> Floats:
        which = np.clip(np.searchsorted(begins, asked, side="right") - 1, 0, len(pieces) - 1)
        values: list[Floats] = []
        for i in np.unique(which):
            mine = asked[which == i]
            values.append(of(pieces[i])(np.clip(mine, pieces[i].begin, pieces[i].end)))
        return np.concatenate(values)  # the times rise, and so do the pieces

    def at(asked: Floats) -> Floats:
        order = np.argsort(asked, kind="stable")
        values = np.empty((len(asked), problem.own))
        values[order] = gather(asked[order], lambda piece: piece.states)
        return values

    errors = gather(times, lambda piece: piece.errors)
    return Track(
        times,
        at(times),
        errors,
        at,
        climb.finish,
        climb.steps,
        tuple(climb.notes),
        _indicators(climb),
    )
