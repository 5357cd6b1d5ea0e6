"""Simulation: launch a disk, and say what becomes of it."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import partial
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike

from .checks import callback
from .contact import Contact
from .disk import Disk
from .errors import ParameterError
from .flow import CASADI, FLAT, LIFT_OFF, NO_CONTACT, Floats, flow
from .integrators import FINEST, Choice, check_method, explicit, run
from .launches import Launches, gather
from .outcome import OF_END, Outcome
from .painleve import OPEN_END, closer
from .route import UNRESOLVED, End, Leg, Path
from .settings import TIGHTEST, Settings
from .settling import Nearest, deviation, nearest
from .shadow import COMPARED, SIGNS, Doubt, doubts
from .sticking import SLIDING, DryPath, Transition
from .sticking import integrate as integrate_dry

if TYPE_CHECKING:
    import xarray

GUARDS = {
    LIFT_OFF: "normal force times D",
    FLAT: "sine of theta less that of flat",
    NO_CONTACT: "D",
}
"""What each guard is, in words."""
TOGETHER = 1e-6
"""D at which a zero of gn D is taken for one of both."""
CHUNK = 4096
"""Launches that are run and checked together."""


@dataclass(frozen=True, eq=False)
class Result:
    """One launch after its run, dimensionless."""

    path: Path
    """y at the asked times, and the end."""
    choice: Choice
    """The integrator and why."""
    outcome: Outcome
    """How it ended."""
    time: float
    """When: the last time, or that of the event."""
    final: Floats
    """y then."""
    near: Nearest
    """The nearest steady motion."""
    settled_at: float
    """Time from which the distance stayed below the asked one; the end's where not settled."""
    modes: Floats | None
    """Sliding or sticking at each sample, for dry friction."""
    last_mode: int
    """The mode at the end."""
    transitions: tuple[Transition, ...]
    """Between sliding and sticking."""
    evidence: str
    """Why the outcome is what it is."""
    tolerance: float
    """What the integrator was given: not below what it accepts."""
    doubt: Doubt | None = None
    """What its shadow says; None where none was asked, or the run has no outcome."""


def simulate(
    disk: Disk,
    contact: Contact,
    start: Any,
    times: ArrayLike,
    *,
    method: str = "auto",
    tolerance: float = 1e-9,
    pose: bool = False,
    flat: float = 1e-6,
    settle: float = 1e-3,
    max_steps: int = 1_000_000,
    max_seconds: float = 10.0,
    check: bool = True,
    workers: int | None = None,
    progress: Callable[[int, int], None] | None = None,
) -> xarray.Dataset:
    """The motion of a disk from a start, and what becomes of it.

    Parameters
    ----------
    disk
        The disk; its fields may be arrays.  With m = R = g = 1 every number is dimensionless,
        otherwise SI.
    contact
        `Smooth`, `Viscous`, `LinearViscous`, `Rough`, `Coulomb` (with true sticking) or
        `RegularisedCoulomb`.
    start
        theta, theta_dot, phi_dot, omega3, slip_x, slip_y along the last axis, shape (…, 6)
        [rad, rad/s, m/s], or a mapping by these names (what is left out is 0).  Four values do for
        smooth and rough.
    times
        Times to report, rising [s], shape (t,), or a last time, which stands for 201 equal steps
        from 0.  The start is time 0.
    method
        `auto` (by stiffness and tolerance), or `heyoka`, `dop853`, `lsoda`, `radau`, `bdf`,
        `cvodes`, `idas`.
    tolerance
        Error allowed in one step, relative and absolute to 1; from 1e-16 to 1e-2.
    pose
        Whether to report φ, ψ, and the paths of centre and contact point.
    flat
        Angle from 0 or π that counts as flat [rad].
    settle
        Largest distance from a steady motion, dimensionless, at which it can count as settled on.
    max_steps
        Steps after which a run gives up.
    max_seconds
        Computing time of one launch after which its run gives up [s]; the same again for all its
        neighbours, without which its error is not known.  Other work on the machine does not count.
    check
        Whether each launch is run a second time, a little off and less finely, which tells the
        error of its final state; a launch whose neighbour ends otherwise is *undetermined*.
    workers
        Threads for many launches at once; one for each core when left out.
    progress
        Called with (launches done, launches in all).

    Returns
    -------
    xarray.Dataset
        States and observables over (…, time), with units; `outcome` (CF flags), `evidence`,
        `end_time`, `energy_error`, `final_error` (estimated: the largest over the states, each over
        1 or its own size), `end_time_error` and the nearest steady motion for each launch; the
        event log
        along `event`; provenance in the attributes.  A single run that ended early has its end as
        last sample.  Of several, each holds its last state after its end, where `running` is 0.

    Raises
    ------
    StabilityError
        In one sentence, if something is not accepted: a flat or detached start, D ≤ 0, numbers
        that are not finite, shapes that do not fit, times that do not rise.

    Source: Przybylska & Rauch-Wojciechowski 2016, Sections 2 and 5; tests/test_motion.py holds
    it against an inertial-frame formulation and closed forms.

    Examples
    --------
    >>> import stability as st
    >>> run = st.simulate(st.Disk(), st.Viscous(0.3), {"theta": 1.52, "phi_dot": 2.5}, 200.0)
    >>> run.attrs["outcome"], str(run.nearest_family.values)
    ('settled', 'spinning')
    >>> bool(run.energy_error < 1e-9)
    True
    """
    from .trajectory import assemble

    callback(progress)
    settings = Settings(
        check_method(method), tolerance, pose, flat, settle, max_steps, workers, check, max_seconds
    )
    settings.refuse()
    with CASADI:  # calls from several threads take turns; a batch uses threads of its own
        launches = gather(disk, contact, start, times)
        _not_flat(launches, settings)
        return assemble(launches, settings, results(launches, settings, progress))


def _not_flat(launches: Launches, settings: Settings) -> None:
    theta = launches.starts[:, 0]
    # a start within rounding of the border cannot be told from one on it
    bad = np.flatnonzero(np.minimum(theta, np.pi - theta) <= settings.flat * (1 + 1e-6))
    if bad.size:
        raise ParameterError(
            f"theta of start is {theta[bad[0]]:g}, flat within flat = {settings.flat:g} rad; start "
            "the disk more upright, or give a smaller flat."
        )


def results(
    launches: Launches, settings: Settings, progress: Callable[[int, int], None] | None = None
) -> list[Result]:
    """Run every launch and judge its outcome.

    Parameters
    ----------
    launches
        Checked.
    settings
        How.
    progress
        As for `simulate`.

    Returns
    -------
    list of Result
        In the order of the launches.
    """
    legs, found = _legs(launches, settings), []
    for first in range(0, len(legs), CHUNK):  # the neighbours of all would fill the memory
        some = slice(first, first + CHUNK)
        told = None if progress is None else partial(_later, progress, first, len(legs))
        found += _checked(legs[some], launches.starts[some], launches, settings, told)
    return found


def _later(
    progress: Callable[[int, int], None], before: int, total: int, done: int, _: int
) -> None:
    progress(before + done, total)


def _checked(
    legs: Sequence[Leg], starts: Floats, launches: Launches, settings: Settings,
    progress: Callable[[int, int], None] | None,
) -> list[Result]:  # fmt: skip
    """Run some launches, and their neighbours."""
    found = _run(legs, launches, settings, [settings.method] * len(legs), progress)
    if not settings.check:
        return found

    left = [settings.max_seconds] * len(legs)  # what the neighbours of each have among them

    def rerun(which: Sequence[int], tolerances: Floats, off: Floats) -> list[Result]:
        shadows = [
            replace(_shadow(legs[i], starts[i], tolerance, size), seconds=left[i])
            for i, tolerance, size in zip(which, tolerances.tolist(), off.tolist(), strict=True)
        ]
        methods = [found[i].choice.method for i in which]
        results = _run(shadows, launches, settings, methods, None)
        for i, result in zip(which, results, strict=True):
            left[i] -= result.path.seconds
        return results

    judged = doubts(found, [FINEST[r.choice.method] for r in found], rerun)
    return [_doubted(result, doubt) for result, doubt in zip(found, judged, strict=True)]


def _legs(launches: Launches, settings: Settings) -> list[Leg]:
    which = flow(launches.law, pose=settings.pose)
    sine = math.sin(settings.flat)
    lead = launches.times[:1] != 0
    times = np.concatenate([[0.0], launches.times]) if lead else launches.times
    clock = launches.scales["time"]
    # launches of one time scale share their array of times
    shared = times / float(clock) if clock.ndim == 0 else None
    return [
        Leg(
            which, np.append(p, sine), y,
            times / float(clock[i]) if shared is None else shared,
            _finer(settings.tolerance, y), settings.max_steps, settings.max_seconds,
        )
        for i, (p, y) in enumerate(zip(launches.p, which.pack(launches.starts), strict=True))
    ]  # fmt: skip


def _shadow(leg: Leg, six: Floats, tolerance: float, off: float) -> Leg:
    """The leg from a start off by a relative size, with times to compare at."""
    start = leg.flow.pack(six * (1.0 + off * SIGNS))
    times = np.linspace(leg.times[0], leg.times[-1], COMPARED)
    return replace(leg, start=start, times=times, tolerance=tolerance)


def _doubted(result: Result, doubt: Doubt | None) -> Result:
    if doubt is None or not doubt.contrary:
        return replace(result, doubt=doubt)
    return replace(result, doubt=doubt, outcome=Outcome.UNDETERMINED, evidence=doubt.contrary)


def _run(
    legs: Sequence[Leg], launches: Launches, settings: Settings, methods: Sequence[str],
    progress: Callable[[int, int], None] | None,
) -> list[Result]:  # fmt: skip
    """Run legs, each by its method, and judge how they ended."""
    found: list[Result | None] = [None] * len(legs)
    if launches.law == "coulomb":
        for i, (leg, method) in enumerate(zip(legs, methods, strict=True)):
            dry = integrate_dry(leg, method, pose=settings.pose)
            name = explicit() if method == "auto" else method
            choice = Choice(name, "sliding and sticking; landings by LSODA, onsets by CVODES")
            found[i] = _judge(leg, dry.path, choice, launches, settings, dry)
            if progress is not None:
                progress(i + 1, len(legs))
    else:
        for method in dict.fromkeys(methods):
            mine = [i for i, name in enumerate(methods) if name == method]
            paths, choices = run(
                [legs[i] for i in mine], method, workers=settings.workers, progress=progress
            )
            for i, path, choice in zip(mine, paths, choices, strict=True):
                found[i] = _judge(legs[i], path, choice, launches, settings, None)
    return [result for result in found if result is not None]


def _finer(tolerance: float, y: Floats) -> float:
    """The tolerance of a launch: finer by a decade for each in which it turns faster than 10.

    The normal force holds products of angular velocities, whose error is theirs times the other.
    """
    fast = float(np.abs(y[1:4]).max()) / 10
    return tolerance if fast <= 1 else max(tolerance * 10.0 ** -np.ceil(np.log10(fast)), TIGHTEST)


def _judge(
    leg: Leg, path: Path, choice: Choice, launches: Launches, settings: Settings,
    dry: DryPath | None,
) -> Result:  # fmt: skip
    why = ""
    if path.end is not None and dry is None and path.end.kind != FLAT:
        path, why = closer(leg, path) or (path, "")
    end: End | None = path.end
    final = path.states[-1] if end is None else end.state
    time = float(leg.times[-1]) if end is None else end.time
    six = leg.flow.six(final)
    near = nearest(six, launches.law, leg.p[:-1], settings.settle)
    since = time
    if end is not None:
        outcome, evidence = _ending(leg, end)
        evidence = why or evidence
        if end.kind in leg.flow.guards and not end.early:
            path = replace(path, end=replace(end, lags=_lags(leg, end)))
    else:
        outcome, evidence = Outcome.MOVING, near.evidence
        if near.settled:
            outcome = Outcome.SETTLED
            since = _since(leg, path, near, settings.settle)
    return Result(
        path, choice, outcome, time, final, near, since,
        dry.modes if dry else None, dry.mode if dry else SLIDING,
        tuple(dry.transitions) if dry else (),
        evidence + ("" if launches.dimensionless else " (dimensionless numbers)"),
        max(leg.tolerance, FINEST[choice.method]),
    )  # fmt: skip


def _lags(leg: Leg, end: End) -> Floats:
    """How much later the guard of an end vanishes for a change of each entry of the state."""
    index = list(leg.flow.guards).index(end.kind)
    rate = abs(float(leg.flow.margins(end.state, leg.p)[1][index]))
    slope: Floats = np.abs(np.array(leg.flow.guard_slopes(end.state, leg.p))[index])
    return slope / rate if rate else np.where(slope > 0, np.inf, 0.0)


def _ending(leg: Leg, end: End) -> tuple[Outcome, str]:
    """The outcome of an early end, and its evidence, dimensionless.

    Where dry friction makes D run to zero an integrator gives up: near t* then D goes like the
    root of t* - t, so that D over twice its rate is what is left.  Or gn D and D reach zero
    together, at a point that attracts sliding motions, where gn, their ratio, is still positive:
    no lift-off (Génot & Brogliato, Eur. J. Mech. A/Solids 18 (1999) 653-677, for the planar rod).
    """
    if end.kind == OPEN_END:
        return Outcome.UNDETERMINED, ""
    margins = zip(*leg.flow.margins(end.state, leg.p), strict=True)
    seen = {n: (float(v), float(r)) for n, (v, r) in zip(leg.flow.guards, margins, strict=True)}
    d, d_rate = seen.get(NO_CONTACT, (np.inf, 0.0))
    if end.kind == LIFT_OFF and abs(d) < TOGETHER:
        why = "gn D and D have reached zero together: the contact force is not determined there"
        return Outcome.NO_CONTACT, why
    if end.kind == UNRESOLVED and d_rate < 0 and d < 1e-2:
        if d / (2 * -d_rate) < 1e-6 * max(1.0, end.time):
            why = f"D = {d:.1e} falls at {-d_rate:.1e}: it runs to zero, and the contact force "
            return Outcome.NO_CONTACT, why + "grows without bound"
    outcome = OF_END[end.kind]
    if end.message or end.kind not in seen:
        return outcome, end.message or end.kind
    value, rate = seen[end.kind]
    return outcome, f"{GUARDS[end.kind]} {value:.1e}, falling at {-rate:.4g}"


def _since(leg: Leg, path: Path, near: Nearest, within: float) -> float:
    """The first sample from which the motion stayed within the distance of the family."""
    _, e = deviation(leg.flow.six(path.states), float(leg.p[0]), near.family)
    outside = np.flatnonzero(np.linalg.norm(e, axis=-1) > within)
    first = 0 if outside.size == 0 else min(int(outside[-1]) + 1, len(leg.times) - 1)
    return float(leg.times[first])
