"""The integrators by name, the choice of `auto` by a model of costs, and runs known at any time."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from concurrent.futures import Executor
from contextlib import closing
from dataclasses import dataclass, replace
from functools import partial
from importlib import import_module
from typing import Any

import numpy as np

from ..algebra.eigensolver import eigenvalues_alone
from ..algebra.number_types import heyoka
from ..base.checks import known
from ..base.errors import ParameterError
from ..base.types import Floats, Progress
from ..base.version import install_line
from ..jobs.pipeline import Counted, here, ordered, shared
from . import taylor
from .flow import ASKING, Evaluator, Flow, NumericFlow
from .lanes import ALONE, integrate_many
from .leg import UNRESOLVED, Budget, End, Integrator, Leg, Path
from .registry import PLACES

HEYOKA = "heyoka"


def _integrators() -> dict[str, Integrator]:
    modules = [import_module(f".{place}", __package__) for place in dict.fromkeys(PLACES.values())]
    every = {integrator.name: integrator for module in modules for integrator in module.INTEGRATORS}
    return {name: every[name] for name in PLACES}


METHODS = _integrators()
"""Every integrator by name."""
TURN_POWER = 0.12
"""An explicit method costs more where stiffness exceeds turn (tolerance / 1e-6)^-TURN_POWER.  Costs
are for equal errors at the end: at one tolerance Taylor's error is far below that of CVODES."""
PATIENCE = 4.0
"""Steps of an explicit method per turn and unit of time after which `auto` calls a leg stiff."""
SHARE = 4
"""Part of the allowed steps, as one over it, after which a leg of `auto` is looked at again."""
FEW = 10
"""Steps of an explicit method that gave up over those in which CVODES must do the whole leg."""
COMPILED = 250
"""Operations of a graph that heyoka compiles within some seconds; its time rises faster."""
EXPLICIT_TIGHT = 1e-10
"""Without heyoka: largest tolerance at which DOP853 replaces CVODES, which is of order 5."""


@dataclass(frozen=True)
class Choice:
    """The integrator of a leg and the reason for it."""

    method: str
    """Name of the integrator."""
    reason: str
    """Reason, in one sentence."""


def check_method(method: str) -> str:
    """The name of an integrator that can run here, or `auto`.

    Parameters
    ----------
    method
        Name from the user.

    Returns
    -------
    str

    Raises
    ------
    NameUnknownError
        If there is no such integrator.
    ParameterError
        If the integrator is not installed.

    Examples
    --------
    >>> check_method("lsoda")
    'lsoda'
    """
    known("method", method, ("auto", *METHODS))
    if method == "auto":
        return "auto"
    if not METHODS[method].available():
        raise ParameterError(
            f"method is {method!r}, which is not installed; {install_line(method)}, or take "
            "another method."
        )
    return method


def check_flow(method: str, flow: Flow) -> None:
    """Refuse an integrator that cannot read a flow, in one sentence."""
    if method == "auto":
        return
    why = METHODS[method].refuses(flow)
    if isinstance(flow, NumericFlow) and "scipy" not in METHODS[method].works:
        why = "which takes no Python function; give dop853, lsoda, radau, bdf, or leave it out"
    if why:
        raise ParameterError(f"method is {method!r}, {why}.")


def works_of(methods: Iterable[str]) -> list[str]:
    """Keys of the works on integrators, for `stability.base.citation.cited`.

    Examples
    --------
    >>> works_of(["heyoka", "dop853"])
    ['heyoka', 'scipy', 'hairer1993']
    """
    return [key for method in methods for key in METHODS[method].works]


def stiffness(legs: Sequence[Leg], enough: Floats | float = 0.0) -> Floats:
    """Fastest rate of the linearised motion over that of the motion itself, for each leg.

    The Jacobian is taken at the start, and there without slip, where a stiff motion soon is.  While
    a disk slides fast its normal force, and with it the stiffness, can be small.  The rate is the
    largest modulus of an eigenvalue, or an upper bound of it (the row-sum norm) where that is below
    `enough`.
    """
    flow = legs[0].flow
    count = len(flow.system.states)
    points = np.array([leg.start for leg in legs])
    p = np.array([leg.p for leg in legs])
    pace = flow.paces(points, p, np.array([leg.times[-1] - leg.times[0] for leg in legs]))
    matrices = [flow.jacobians(points, p)[:, :count, :count]]
    slip = list(flow.model.sliding)
    if slip and points[:, slip].any():
        points[:, slip] = 0.0
        matrices.append(flow.jacobians(points, p)[:, :count, :count])
    with np.errstate(all="ignore"):
        bounds = [np.abs(m).sum(axis=2).max(axis=1) / pace for m in matrices]
        fastest = np.max(bounds, axis=0)
        dear = np.flatnonzero(~(fastest < enough))
        if dear.size:
            fastest[dear] = np.max([_fastest(m[dear]) / pace[dear] for m in matrices], axis=0)
    return np.asarray(fastest)


def _fastest(matrices: Floats) -> Floats:
    """The spectral radius of each matrix; infinite for a matrix that is not finite."""
    finite = np.isfinite(matrices).all(axis=(1, 2))
    radius = np.full(len(matrices), np.inf)
    radius[finite] = np.abs(eigenvalues_alone(matrices[finite])).max(axis=1)
    return radius


def explicit(flow: Flow | None = None) -> str:
    """The best explicit method that is installed, and that can read a flow, if one is given.

    Examples
    --------
    >>> explicit() in METHODS
    True
    """
    fit = taylor.available() and (flow is None or not _unfit(flow))
    return HEYOKA if fit else "dop853"


def _unfit(flow: Flow) -> str:
    """Why heyoka does not take a flow; empty where it does."""
    if isinstance(flow, NumericFlow):
        return "takes no Python function"
    if flow.length > COMPILED:
        return "is long in compiling the graph"
    if taylor.unread(flow):
        return "cannot read the graph"
    return ""


def implicit(flow: Flow) -> str:
    """The implicit method that `auto` takes for a flow."""
    return "lsoda" if isinstance(flow, NumericFlow) else "cvodes"


def choose(legs: Sequence[Leg]) -> list[Choice]:
    """The choice of `auto` for each leg of one flow.

    An explicit method's steps are bounded by its stability, so their number grows in proportion to
    the stiffness.  The number of an implicit method's steps does not, but grows faster as the
    tolerance falls.  `benchmarks/motion.py` draws both curves.
    """
    turns, name = _turns(legs), explicit(legs[0].flow)
    rows = zip(legs, turns.tolist(), stiffness(legs, turns).tolist(), strict=True)
    return [_choice(leg, name, turn, stiff) for leg, turn, stiff in rows]


def _choice(leg: Leg, name: str, turn: float, stiff: float) -> Choice:
    if stiff > turn:
        return Choice(
            implicit(leg.flow), f"stiffness {stiff:.3g} above {turn:.3g}: implicit is cheaper"
        )
    only = ""
    if name != HEYOKA and taylor.available():
        only = f", and heyoka {_unfit(leg.flow)}"
    elif name != HEYOKA:
        only = ", and heyoka is not installed"
        if leg.tolerance > EXPLICIT_TIGHT and not isinstance(leg.flow, NumericFlow):
            name, only = "cvodes", ", but heyoka is not installed"
    why = f"stiffness up to {stiff:.3g}, below {turn:.3g}: explicit is cheaper{only}"
    return Choice(name, why)


def _turns(legs: Sequence[Leg]) -> Floats:
    """Stiffness of each leg of one flow above which an implicit method is cheaper."""
    tolerances = np.array([leg.tolerance for leg in legs])
    turns: Floats = METHODS[explicit(legs[0].flow)].turn * (tolerances / 1e-6) ** -TURN_POWER
    return turns


def _share(leg: Leg) -> int:
    """Steps of an explicit method after which it must be known whether the leg is stiff."""
    return max(leg.max_steps // SHARE, 1)


def _patient(legs: Sequence[Leg], choices: Sequence[Choice]) -> list[Leg]:
    """The legs, with few steps where an explicit method was chosen: then implicit is cheaper."""
    starts, p = np.array([leg.start for leg in legs]), np.array([leg.p for leg in legs])
    lengths = np.array([leg.times[-1] - leg.times[0] for leg in legs])
    with np.errstate(over="ignore"):  # an endless span asks for the steps that a leg has
        spans = lengths * legs[0].flow.paces(starts, p, lengths)
        most = 20_000 + PATIENCE * _turns(legs) * spans
    return [
        leg
        if choice.method == implicit(leg.flow)
        else replace(leg, max_steps=int(min(_share(leg), steps)))
        for leg, choice, steps in zip(legs, choices, most.tolist(), strict=True)
    ]


def run(
    legs: Sequence[Leg],
    method: str = "auto",
    *,
    workers: int | None = None,
    progress: Progress | None = None,
    executor: Executor | None = None,
) -> tuple[list[Path], list[Choice]]:
    """Run legs of one flow and one number of times.

    Parameters
    ----------
    legs
        Legs to run.
    method
        A key of `METHODS`, or `auto`: then a leg whose integrator gives up is run with another.
    workers
        Threads for heyoka's batches.
    progress
        Called with (done, total).
    executor
        Executor of every leg; None for heyoka's batches in threads and the others in this one.

    Returns
    -------
    paths, choices
        Path and choice of each leg.
    """
    auto = method == "auto"
    choices = choose(legs) if auto else [Choice(method, "asked for")] * len(legs)
    asked = legs
    if auto:
        legs = _patient(legs, choices)
    paths: list[Path | None] = [None] * len(legs)
    counted = Counted(progress, len(legs))
    groups: dict[float, list[int]] = {}
    for i, (leg, choice) in enumerate(zip(legs, choices, strict=True)):
        if choice.method == HEYOKA:
            groups.setdefault(leg.tolerance, []).append(i)
    for mine in groups.values():
        if len(mine) <= ALONE:
            continue
        integrated = integrate_many([legs[i] for i in mine], workers, counted, executor)
        for i, path in zip(mine, integrated, strict=True):
            paths[i] = path
    left = [i for i, p in enumerate(paths) if p is None or (auto and _gave_up(p, asked[i]))]
    alone = {i for i in left if paths[i] is None}
    flow = shared(legs[0].flow, executor)

    def task(i: int) -> Callable[[], tuple[Path, Choice]]:
        most = legs[i].max_steps
        return partial(_alone, flow, asked[i].numbers, most, paths[i], choices[i], auto)

    with closing(
        ordered(
            left,
            task,
            executor=executor,
            workers=workers or taylor.CORES,
            start_pool=here,
            progress=counted,
            size=lambda i: i in alone,
        )
    ) as results:
        for i, (path, choice) in results:
            paths[i], choices[i] = path, choice
    return [p for p in paths if p is not None], choices


def _gave_up(path: Path, leg: Leg) -> bool:
    """Whether the integrator gave up before the leg's own number of steps."""
    gave_up = path.end is not None and path.end.kind == UNRESOLVED
    return gave_up and path.steps < leg.max_steps


def _alone(
    flow: Callable[[], Flow],
    numbers: tuple[Any, ...],
    most: int,
    path: Path | None,
    choice: Choice,
    auto: bool,
) -> tuple[Path, Choice]:
    """One leg, in a worker: a first path if there is none, and another where that gave up."""
    with ASKING:
        leg = Leg(flow(), *numbers)
        if path is None:
            fewer = leg if most == leg.max_steps else replace(leg, max_steps=most)
            path = _timed(choice.method, fewer)
        return _second(leg, path, choice, most) if auto and _gave_up(path, leg) else (path, choice)


def _stiff_at(leg: Leg, end: End) -> bool:
    """Whether a leg is stiff where an explicit method gave up; at the start it was not."""
    here = replace(leg, start=end.state)
    with np.errstate(all="ignore"):
        return bool(stiffness([here])[0] > _turns([leg])[0])


def _timed(method: str, leg: Leg) -> Path:
    """The path by one method, with the computing time that it took."""
    budget = Budget(leg.seconds)
    path = METHODS[method](leg)
    return replace(path, seconds=budget.used)


def _second(leg: Leg, first: Path, choice: Choice, most: int) -> tuple[Path, Choice]:
    """Path by another integrator where the chosen one gave up; the first if both give up."""
    end = first.end
    assert end is not None
    gave_up = f"{choice.method} gave up at {end.time:.6g}"
    if first.seconds >= leg.seconds:
        return first, choice
    other = "lsoda" if choice.method == "cvodes" else implicit(leg.flow)
    other = "radau" if other == choice.method else other
    shared_steps = most < leg.max_steps and first.steps >= most == _share(leg)
    if shared_steps and not _stiff_at(leg, end):
        few = replace(leg, seconds=leg.seconds - first.seconds, max_steps=max(most // FEW, 1))
        second = _timed(other, few)  # it may be stiff elsewhere
        first = replace(first, seconds=first.seconds + second.seconds)
        if second.end is None or second.end.kind != UNRESOLVED:
            return replace(second, seconds=first.seconds), Choice(other, gave_up)
        other = choice.method  # its other steps may be enough
    second = _timed(other, replace(leg, seconds=leg.seconds - first.seconds))
    second = replace(second, seconds=first.seconds + second.seconds)
    if second.end is not None and second.end.kind == UNRESOLVED:
        short = most < leg.max_steps and first.steps >= most  # no limit of the user's ended it
        end = replace(end, message=second.end.message) if short else end
        longer = second if other == choice.method else replace(first, end=end)
        return replace(longer, seconds=second.seconds), choice
    if other == choice.method:
        return second, choice
    return second, Choice(other, gave_up)


@dataclass(frozen=True, eq=False)
class DensePath:
    """A path as a function of time, up to its last step or to a guard's zero."""

    steps: Floats
    """Times of the steps, the start and the end among them, shape (s,)."""
    at: Callable[[Floats], Floats]
    """y at times between the first and the last step, shape (t,) to (t, n)."""
    whole: bool
    """Whether the path reaches the leg's last time."""


def dense(leg: Leg) -> DensePath:
    """Run a leg by an explicit method and keep its steps; the leg's own times are only its span.

    A run that gives up ends at its last good step.

    Examples
    --------
    >>> from stability.integrators.flow import flow
    >>> f = flow("rough")
    >>> start = f.pack(np.array([1.3, 0.1, 0.4, 1.1]))
    >>> path = dense(Leg(f, np.array([0.25, 1e-6]), start, np.array([0.0, 2.0]), 1e-12, 1000))
    >>> path.whole, path.at(np.array([0.0]))[0, :4].tolist()
    (True, [1.3, 0.1, 0.4, 1.1])
    """
    return _by_heyoka(leg) if explicit(leg.flow) == HEYOKA else _by_dop853(leg)


def _by_heyoka(leg: Leg) -> DensePath:
    """A run for the steps and one for the values: heyoka's own continuous output costs more.

    The path ends at the last whole step before a guard's zero.
    """
    hy = heyoka()
    steps = [float(leg.times[0])]

    def note(ta: Any) -> bool:
        steps.append(float(ta.time))
        return True

    with taylor.lent(leg) as ta:
        outcome, *_ = ta.propagate_until(
            float(leg.times[-1]), max_steps=leg.max_steps, callback=note
        )
    whole = outcome == hy.taylor_outcome.time_limit

    def at(times: Floats) -> Floats:
        grid, places = np.unique(np.append(times, leg.times[0]), return_inverse=True)
        with taylor.lent(leg) as ta:
            states = np.array(ta.propagate_grid(grid, max_steps=leg.max_steps)[5])
        rows: Floats = states[places[:-1]]
        return rows

    return DensePath(np.array(steps if whole else steps[:-1]), at, whole)


def _by_dop853(leg: Leg) -> DensePath:
    from scipy.integrate import solve_ivp

    ask = Evaluator(leg.flow, leg.p)

    def ended(_t: float, y: Floats) -> float:
        return float(ask.watch(y)[0].min(initial=1.0))

    ended.terminal = True  # type: ignore[attr-defined]  # as SciPy reads it
    run = solve_ivp(
        ask.rates,
        (leg.times[0], leg.times[-1]),
        leg.start,
        method="DOP853",
        dense_output=True,
        rtol=max(leg.tolerance, 3e-14),
        atol=leg.absolute,
        events=ended,
    )
    return DensePath(run.sol.ts, lambda times: run.sol(times).T, run.status == 0)
