"""Simulation: the motion of a disk, or of a user's system, from a launch, and its outcome."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from concurrent.futures import Executor
from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike

from ..base.errors import ParameterError, warned
from ..bodies.disk import Disk
from ..bodies.model import FLAT
from ..bodies.resistance import Resistance
from ..bodies.round_body.body import Body
from ..integrators.flow import CASADI, flow_of
from ..integrators.selection import check_flow, check_method
from ..jobs.pipeline import check_run
from ..settling.departure import departures
from ..systems.family import Family
from ..systems.system import System
from .gather import launches_of, moving
from .result import Outcome, Result, Settings
from .starts import Starts

if TYPE_CHECKING:
    import xarray

from .run import resampled, results


def simulate(
    disk: Disk | Body | System | None = None,
    contact: Any = None,
    start: Any = None,
    times: ArrayLike | None = None,
    *,
    body: Body | Disk | None = None,
    resistance: Resistance | Sequence[Resistance] | None = None,
    families: Family | Sequence[Family] = (),
    method: str = Settings.method,
    tolerance: float = Settings.tolerance,
    pose: bool = False,
    flat: float = Settings.flat,
    settle: float = Settings.settle,
    max_steps: int = Settings.max_steps,
    max_seconds: float = Settings.max_seconds,
    check: bool = True,
    workers: int | None = None,
    executor: Executor | None = None,
    progress: Callable[[int, int], None] | None = None,
    **parameters: ArrayLike,
) -> xarray.Dataset:
    """The motion of a disk, another body, or a user's system, from a start, and its outcome.

    Parameters
    ----------
    disk
        The disk; its fields may be arrays.  With m = R = g = 1 every number is dimensionless,
        otherwise SI; so it is when left out.  Alternatively a `Body`, with its own units, or a
        `System`, whose numbers are in its own units.
    contact
        `Smooth`, `Viscous`, `LinearViscous`, `Rough`, `Coulomb` (with true sticking) or
        `RegularisedCoulomb`; or the name or class of a law, with its parameters by name.  For a
        system its parameters: values by name, or along the last axis; None where it has none, or
        where they are given by name.
    start
        States theta, theta_dot, phi_dot, omega3, slip_x, slip_y along the last axis, shape (…, 6)
        [rad, rad/s, m/s], or a mapping by these names (theta is needed, missing ones are 0).  Four
        values are enough for smooth and rough.  For a system every state by name, or along the last
        axis.
    times
        Times to report, rising [s], shape (t,), or a last time: then 201 evenly spaced times from
        0, of a single run up to its end; with `pose`, as many as draw its path as a smooth curve,
        closer where it turns faster.  The start is time 0.
    body
        A `Body`, or a `Disk`, in place of the first argument.
    resistance
        `RollingResistance`, `PivotingResistance` or `AirTorque`, or several of these, of a body or
        disk.
    families
        Families of the user's system on which it may settle; the disk has its own.  Angles are
        not wrapped: a member a whole turn away is a different one.  The evidence says *departs*
        where the member nearest to the start is unstable, and the distance from its family has
        grown at least tenfold, beyond `settle` and its error.
    method
        `auto` (by stiffness and tolerance), or `heyoka`, `dop853`, `lsoda`, `radau`, `bdf`,
        `cvodes`, `idas` (a system needs a mass matrix for it).
    tolerance
        Error allowed in one step, relative, and absolute to 1 in a system's own units; from 1e-16
        to 1e-2.
    pose
        Whether to report φ, ψ, and the paths of centre and contact point.
    flat
        Angle from 0 or π that counts as flat [rad].
    settle
        Largest distance from a steady motion, dimensionless, at which it can count as settled on.
    max_steps
        Steps after which a run gives up.
    max_seconds
        Computing time of one launch after which its run gives up [s].  All its neighbours together
        have the same time again, beyond which the error is not known.  Other work on the machine
        does not count.
    check
        Whether each launch is compared with neighbours: runs at other tolerances and from slightly
        changed starts.  They give the error of its final state.  A launch whose neighbour ends
        differently is *undetermined*.
    workers
        Threads for many launches at once; one for each core when left out.
    executor
        Any `concurrent.futures.Executor` that runs the launches in place of the threads, in
        processes or on another machine; `workers` is then its number of workers.
    progress
        Called with (launches done, launches in all).
    **parameters
        Parameters by name, of a contact law that is named, or of a system.

    Returns
    -------
    xarray.Dataset
        States and observables over (…, time), with units; `outcome` (CF flags), `evidence`,
        `end_time`, `energy_error`, `final_error` (estimated: the largest over the states, each over
        1 or its own size), `end_time_error`, `trusted_time` (after which runs within the tolerance
        part) and the nearest steady motion for each launch, and `start_state` among the
        coordinates; the event log along `event`; provenance in the attributes.  A single run that
        ended early has its end as last sample.  Of several runs, each keeps its last state after
        its end, where `running` is 0.  A system has its own
        observables; the energy account if `energy` and `power` (the energy lost in a unit of time)
        are among them; the nearest steady motion if families were given.  Its run ends where a
        condition reaches zero (*domain-end*).

    Raises
    ------
    StabilityError
        In one sentence, if something is not accepted: a flat or detached start, D ≤ 0, a condition
        that fails, numbers that are not finite, shapes that do not fit, times that do not rise.

    Warns
    -----
    StabilityWarning
        If the error of a final state has no bound, such as late in a chaotic motion.

    Source: Przybylska & Rauch-Wojciechowski 2016, Sections 2 and 5; tests/motion/test_motion.py
    compares it with an inertial-frame formulation and closed forms;
    tests/motion/test_system_motion.py compares systems with closed forms.

    Examples
    --------
    >>> import stability as st
    >>> run = st.simulate(st.Disk(), st.Viscous(0.3), {"theta": 1.52, "phi_dot": 2.5}, 200.0)
    >>> run.attrs["outcome"], str(run.nearest_family.values)
    ('settled', 'spinning')
    >>> bool(run.energy_error < 1e-9)
    True
    >>> start = {"theta": 1.52, "phi_dot": 2.5}
    >>> st.simulate(contact="viscous", mu=0.3, start=start, times=200.0).attrs["outcome"]
    'settled'

    A user's pendulum:

    >>> import casadi as ca
    >>> x, c = ca.SX.sym("x", 2), ca.SX.sym("c")
    >>> pendulum = st.System("pendulum", x, c, ca.vertcat(x[1], -ca.sin(x[0]) - c * x[1]),
    ...                      states=("angle", "rate"), parameters=("c",))
    >>> hanging = st.Family(pendulum, "hanging", at=("c",), held={"angle": 0, "rate": 0})
    >>> start = {"angle": 1.0, "rate": 0.0}
    >>> run = st.simulate(pendulum, start=start, times=100.0, c=0.2, families=hanging)
    >>> run.attrs["outcome"]
    'settled'
    """
    from .dataset import assemble

    check_run(None, progress, executor)
    settings = Settings(
        check_method(method),
        tolerance,
        pose,
        flat,
        settle,
        max_steps,
        workers,
        check,
        max_seconds,
        executor,
    )
    settings.refuse()
    mover = moving(disk, body, numeric=True)
    with CASADI:  # calls from several threads take turns; a batch uses its own threads
        launches = launches_of(
            mover,
            contact,
            start,
            times,
            numbers=parameters,
            families=families,
            resistance=resistance,
            pose=pose,
        )
        check_flat(launches, settings)
        check_flow(settings.method, flow_of(launches.model))
        runs = results(launches, settings, progress)
        runs = _described(launches, settings, _departed(launches, settings, runs))
        if times is not None and np.ndim(times) == 0 and launches.shape == ():
            launches, runs = resampled(launches, settings, runs)
        dataset = assemble(launches, settings, runs)
    _warn(runs)
    return dataset


def _warn(results: list[Result]) -> None:
    """Warn of final states without a bound of their error; other outcomes say so by their name."""
    silent = (Outcome.UNRESOLVED, Outcome.UNDETERMINED)
    open_ = [
        i
        for i, r in enumerate(results)
        if r.doubt and not np.isfinite(r.doubt.final_error) and r.outcome not in silent
    ]
    if open_:
        which = f"launch {open_[0]}: " if len(results) > 1 else ""
        more = f" ({len(open_)} of {len(results)} launches)" if len(open_) > 1 else ""
        said = results[open_[0]].evidence.rpartition("; the error")
        warned(f"{which}the error{said[2]}{more}.")


def _departed(launches: Starts, settings: Settings, results: list[Result]) -> list[Result]:
    """The results, whose evidence says which motions have departed from an unstable member."""
    reported = flow_of(launches.model).reported
    ends = np.array([reported(result.final) for result in results])
    errors = np.array([r.doubt.final_error if r.doubt else 0.0 for r in results])
    errors *= np.hypot.reduce(np.maximum(1.0, np.abs(ends)), axis=-1)
    within = settings.settle
    said = departures(launches.settling, launches.starts, ends, launches.p, within, errors)
    return [
        replace(r, evidence=f"{r.evidence}; {why}")
        if why and r.outcome is not Outcome.UNDETERMINED
        else r
        for r, why in zip(results, said, strict=True)
    ]


CALM = 1e-6
"""Largest rate of a state, over 1 or its size, that counts as no change."""
LOW = 0.01
"""Angle from flat below which a body is said to lie almost flat [rad]."""


def _described(launches: Starts, settings: Settings, results: list[Result]) -> list[Result]:
    """The results; of a run that lasted the evidence says whether it rests, or lies almost flat."""
    lasting = [i for i, result in enumerate(results) if result.outcome is Outcome.MOVING]
    if not lasting:
        return results
    flow, out = flow_of(launches.model), list(results)
    ends = np.array([results[i].final for i in lasting])
    count = len(flow.system.states)
    size = np.maximum(1.0, np.abs(ends[:, :count]))
    if launches.dry:  # at rest the equations of sliding have no value
        changes, word = np.abs(ends[:, 1:count]), "it rests"
    else:
        rates = flow.rates_at(ends, launches.flow_p(settings.flat)[lasting])
        changes = np.abs(rates[:, :count]) / size
        word = f"at the end no state changes by more than {CALM:g} in a unit of time"
    calm = (changes < CALM).all(axis=1)
    lying = np.full(len(lasting), np.inf)
    if FLAT in launches.model.guards:
        angle = flow.reported(ends)[:, 0]
        lying = np.minimum(angle, np.pi - angle)
    for i, still, low in zip(lasting, calm, lying, strict=True):
        near = results[i].near
        unlisted = ", on no steady motion of a known family" * (near.distance > settings.settle)
        said = [word + unlisted] * bool(still)
        said += [f"it lies {low:.2g} rad from flat"] * bool(low < LOW)
        if said:
            out[i] = replace(results[i], evidence="; ".join([results[i].evidence, *said]))
    return out


def check_flat(launches: Starts, settings: Settings) -> None:
    """Refuse a start that is flat, and an angle of flat for what never is."""
    if "flat" not in launches.subject.settings and settings.flat != Settings.flat:
        raise ParameterError(
            f"flat is {settings.flat:g}, and only a disk falls flat; leave it out."
        )
    bad = launches.flat(settings.flat)
    if bad.size:
        theta = launches.starts[bad[0], 0]
        raise ParameterError(
            f"theta of start is {theta:g}, flat within flat = {settings.flat:g} rad; start "
            "more upright, or give a smaller flat."
        )
