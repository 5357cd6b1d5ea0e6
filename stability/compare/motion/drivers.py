"""Drivers that compute a motion: the package's integrators, people's scripts, simpler models.

A driver is one class with `run`.  Its `tolerances` go from loose to tight.
"""

from __future__ import annotations

import warnings
from collections.abc import Callable, Collection
from dataclasses import dataclass, replace
from functools import lru_cache
from typing import Any, ClassVar

import numpy as np

from ...base.checks import known
from ...base.errors import StabilityWarning
from ...base.types import Floats
from ...bodies.contact_laws import RegularisedCoulomb, Rough, Smooth
from ...integrators.selection import METHODS
from ..marks import Method
from .reference_motions import ReferenceMotion

DECADES = tuple(10.0**-d for d in (3, 4, 6, 8, 10, 12, 14))
"""Tolerances of an integrator in the charts."""


@dataclass(frozen=True, eq=False)
class MotionAnswer:
    """Answer of a driver for a scene."""

    times: Floats
    """Times of the states, shape (t,): the given times up to the end of the motion."""
    states: Floats
    """States at these times, shape (t, 6)."""
    outcome: str
    """Outcome in a word; moving where a driver knows no other."""
    end_time: float
    """Time of the end; the last time where the motion did not end."""
    audit: float | None = None
    """Largest error of the energy account over the initial energy; None without an account."""
    stated: float | None = None
    """The driver's estimate of the error of the last state; None if it gives none."""
    events: tuple[tuple[str, float], ...] = ()
    """Kind and time of events of dry friction."""


class Driver(Method):
    """Base class of drivers; subclasses define the names and `run`."""

    tolerances: ClassVar[tuple[float, ...]] = DECADES
    """Tolerances in the charts, from loose to tight."""
    usual: ClassVar[float] = 1e-9
    """Tolerance in the catalogue of failures."""

    def takes(self, scene: ReferenceMotion) -> bool:  # noqa: ARG002
        """Whether the driver takes the scene."""
        return True

    def run(self, scene: ReferenceMotion, times: Floats, tolerance: float) -> MotionAnswer:
        """The motion at the given times, of which the first is 0."""
        raise NotImplementedError


# --- the package ---


class Simulated(Driver):
    """`simulate` with one integrator and without its check by shadows."""

    own = True
    method: ClassVar[str]
    check: ClassVar[bool] = False

    def run(self, scene: ReferenceMotion, times: Floats, tolerance: float) -> MotionAnswer:
        """Call `simulate`."""
        return simulated(
            scene,
            scene.contact(),
            times,
            method=self.method,
            tolerance=tolerance,
            check=self.check,
        )


class Default(Simulated):
    """`simulate` with its defaults: integrator by stiffness, each launch checked."""

    name, title = "simulate", "simulate(): automatic integrator, checked by neighbours"
    default = True
    method, check = "auto", True


class Unchecked(Simulated):
    """`simulate` with its defaults, but without the check."""

    name, title = "unchecked", "simulate(check=False): automatic integrator"
    method = "auto"


class Fine(Simulated):
    """`simulate` with its defaults, but with a finer tolerance."""

    name, title = "simulate-fine", "simulate(tolerance=1e-14), checked"
    method, check, usual = "auto", True, 1e-14


def _single(method: str, taken: Collection[str] = ()) -> type[Driver]:
    """`simulate` by one integrator, whose name is told from that of another driver."""
    title = f"simulate(method='{method}', check=False): {METHODS[method].about}"
    name = f"simulate-{method}" if method in taken else method
    return Simulated.variant(name=name, title=title, method=method)


def simulated(scene: ReferenceMotion, contact: Any, times: Floats, **options: Any) -> MotionAnswer:
    """Run `simulate` on a scene under a contact law."""
    from ...bodies.newton_euler import STATES
    from ...motion.result import BY_CODE
    from ...motion.simulate import simulate

    with warnings.catch_warnings():  # what has no bound is said in the run, and judged here
        warnings.simplefilter("ignore", StabilityWarning)
        run = simulate(scene.disk(), contact, list(scene.start), times, **options)
    states = np.stack([run[name].values for name in STATES], axis=-1)
    outcome = BY_CODE[int(run.outcome)].word
    kept = np.isin(run.time.values, times)
    ended = _events(run.event_kind.values.tolist(), run.event_time.values.tolist())
    return MotionAnswer(
        run.time.values[kept],
        states[kept],
        "moving" if outcome == "settled" else outcome,  # contact lasted: the only question here
        float(run.end_time),
        float(run.energy_error),
        float(run.final_error) if "final_error" in run else None,
        ended,
    )


def _events(kinds: list[str], times: list[float]) -> tuple[tuple[str, float], ...]:
    """Events of dry friction; a reversal counts as a stick and a slip at one time."""
    events: list[tuple[str, float]] = []
    for kind, time in zip(kinds, times, strict=True):
        parts = ("stick", "slip") if kind == "reverse" else (kind,)
        events += [(part, time) for part in parts]
    return tuple(events)


# --- people's scripts ---


@lru_cache(maxsize=8)
def _rates(law: str) -> Callable[[Any, Any], Any]:
    """The right-hand side as a function of (state, parameters), fast for one point."""
    from ...integrators.flow import flow

    which = flow(law)
    count = len(which.system.states)
    pad = len(which.names) - count

    def rates(y: Any, p: Any) -> Any:
        return which.quick.rates(p, np.concatenate([y, np.zeros(pad)]))[:count]

    return rates


def _plain(scene: ReferenceMotion) -> tuple[Callable[[float, Any], Any], Any, Any]:
    """Rates f(t, y), the start, and the normal force at (t, y)."""
    from ...integrators.flow import flow

    rates, which = _rates(scene.law), flow(scene.law)
    p = np.array([scene.k, *([] if scene.mu is None else [scene.mu]), 1e-6])
    count = 4 if scene.law == "rough" else 6
    pad = np.zeros(len(which.names) - count)

    def normal(_: float, y: Any) -> Any:
        return which.quick.watch(p, np.concatenate([y, pad]))[0][0]

    normal.terminal = True  # type: ignore[attr-defined]
    return lambda _t, y: rates(y, p), np.array(scene.start[:count]), normal


def _six(states: Any) -> Floats:
    return np.pad(states, ((0, 0), (0, 6 - states.shape[1])))


class RungeKutta45(Driver):
    """SciPy's `solve_ivp` with a given tolerance and without events."""

    name, title = "rk45", "solve_ivp (RK45), no events"
    tolerances = DECADES[:6]

    def takes(self, scene: ReferenceMotion) -> bool:
        """Whether the equations are smooth."""
        return scene.law != "coulomb"

    def run(self, scene: ReferenceMotion, times: Floats, tolerance: float) -> MotionAnswer:
        """Call `scipy.integrate.solve_ivp`."""
        return self.solved(scene, times, rtol=tolerance, atol=tolerance)

    def solved(
        self, scene: ReferenceMotion, times: Floats, *, ends: bool = False, **options: Any
    ) -> MotionAnswer:
        """Call `solve_ivp` with these options; with `ends` it stops where the disk lifts off."""
        from scipy.integrate import solve_ivp

        f, start, normal = _plain(scene)
        options |= {"events": normal} if ends else {}
        solution = solve_ivp(f, times[[0, -1]], start, t_eval=times, **options)
        if not solution.success:
            raise ArithmeticError(solution.message)
        if not np.isfinite(solution.y).all():
            raise ArithmeticError("a state that is not finite")
        if ends and solution.t_events[0].size:
            return MotionAnswer(
                solution.t, _six(solution.y.T), "lift-off", float(solution.t_events[0][0])
            )
        return MotionAnswer(solution.t, _six(solution.y.T), "moving", float(solution.t[-1]))


class AsItComes(RungeKutta45):
    """`solve_ivp` with the default tolerances of SciPy."""

    name, title, usual = "rk45-default", "solve_ivp with its defaults (rtol 1e-3), no events", 1e-3
    flaw = (
        "Under stiff decay the step of this explicit method at its loose default tolerance shrinks "
        "below the spacing of doubles; radau, bdf and cvodes are made for such motions."
    )

    def run(self, scene: ReferenceMotion, times: Floats, tolerance: float) -> MotionAnswer:  # noqa: ARG002
        """Call `scipy.integrate.solve_ivp` without options."""
        return self.solved(scene, times)


class FixedStep(Driver):
    """The classical Runge-Kutta method with a fixed step; gn is checked after each step."""

    name, title = "rk4", "RK4 with a fixed step; normal force looked at between steps"
    flaw = (
        "Its step of 0.05 times a rate of decay of 900 and more exceeds 2.8, RK4's limit of "
        "stability, and the numbers grow beyond any double; a step that is short enough is slow."
    )
    tolerances = (0.2, 0.1, 0.05, 0.02, 0.01, 0.005, 0.002, 0.001)
    usual = 0.05

    def takes(self, scene: ReferenceMotion) -> bool:
        """Whether the equations are smooth."""
        return scene.law != "coulomb"

    def run(self, scene: ReferenceMotion, times: Floats, tolerance: float) -> MotionAnswer:
        """Integrate; `tolerance` is the step."""
        f, y, normal = _plain(scene)
        rows = [y]
        for a, b in zip(times[:-1], times[1:], strict=True):
            count = max(1, round((b - a) / tolerance))
            h = (b - a) / count
            for i in range(count):
                y = _step(f, y, h)
                if not np.isfinite(y).all():
                    raise ArithmeticError("a state that is not finite")
                if normal(0.0, y) <= 0:
                    states = _six(np.array(rows))
                    return MotionAnswer(times[: len(rows)], states, "lift-off", a + (i + 1) * h)
            rows.append(y)
        return MotionAnswer(times, _six(np.array(rows)), "moving", float(times[-1]))


def _step(f: Callable[[float, Any], Any], y: Any, h: float) -> Any:
    with np.errstate(all="ignore"):
        a = f(0.0, y)
        b = f(0.0, y + h / 2 * a)
        c = f(0.0, y + h / 2 * b)
        d = f(0.0, y + h * c)
        return y + h / 6 * (a + 2 * b + 2 * c + d)


# --- smaller models ---


class RoughInstead(Driver):
    """The rough disk, in place of a disk with large friction."""

    name, title = "rough-model", "the rough disk in place of large friction"
    tolerances = DECADES[::2]

    def takes(self, scene: ReferenceMotion) -> bool:
        """Whether friction is viscous; the error shows how good the model is."""
        return scene.law == "viscous"

    def run(self, scene: ReferenceMotion, times: Floats, tolerance: float) -> MotionAnswer:
        """`simulate` of the rough disk from the same start without its slip."""
        scene = replace(scene, start=(*scene.start[:4], 0.0, 0.0))
        return simulated(scene, Rough(), times, method="auto", tolerance=tolerance, check=False)


class SmoothInstead(RoughInstead):
    """The smooth disk, in place of a disk with small friction."""

    name, title = "smooth-model", "the smooth disk in place of small friction"

    def run(self, scene: ReferenceMotion, times: Floats, tolerance: float) -> MotionAnswer:
        """`simulate` of the smooth disk from the same start."""
        return simulated(scene, Smooth(), times, method="auto", tolerance=tolerance, check=False)


class Regularised(Driver):
    """Dry friction made smooth: mu gn v/√(v² + ε²)."""

    name, title = "regularised", "dry friction regularised, ε = tolerance"
    tolerances = (1e-1, 1e-2, 1e-3, 1e-4, 1e-5, 1e-6)
    usual = 1e-4

    def takes(self, scene: ReferenceMotion) -> bool:
        """Whether friction is dry."""
        return scene.law == "coulomb"

    def run(self, scene: ReferenceMotion, times: Floats, tolerance: float) -> MotionAnswer:
        """`simulate` of the regularised law with a fine tolerance; `tolerance` is ε."""
        law = RegularisedCoulomb(scene.mu or 0.0, tolerance)
        return simulated(scene, law, times, method="auto", tolerance=1e-9, check=False)


PEOPLE: tuple[type[Driver], ...] = (RungeKutta45, FixedStep)
MODELS: tuple[type[Driver], ...] = (RoughInstead, SmoothInstead, Regularised)
_OTHERS: tuple[type[Driver], ...] = (Default, Unchecked, *PEOPLE, *MODELS, Fine, AsItComes)
SINGLE: tuple[type[Driver], ...] = tuple(_single(m, [d.name for d in _OTHERS]) for m in METHODS)
OWN: tuple[type[Driver], ...] = (Default, Unchecked, *SINGLE)
"""The package's integrators."""
_EVERY: tuple[type[Driver], ...] = (*OWN, *PEOPLE, *MODELS, Fine, AsItComes)
DRIVERS = {d.name: d for d in _EVERY}
"""Every driver by name."""


def driver(name: str) -> Driver:
    """A driver by its name.

    Raises
    ------
    NameUnknownError
        If there is none.

    Examples
    --------
    >>> driver("simulate").default
    True
    """
    return DRIVERS[known("driver", name, DRIVERS)]()
