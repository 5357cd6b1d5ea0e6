"""One record of everything that a launch needs of a body, or of a user's system."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, field
from functools import lru_cache
from typing import Any

import casadi as ca
import numpy as np

from ..algebra.program import Program
from ..base.errors import ParameterError, shown
from ..base.quantities import Quantity, time_unit
from ..base.types import Floats, Same
from ..systems.sources.numeric import NumericSystem
from ..systems.system import System
from .contact_laws import DIRECTION, MU
from .creep import CREEPS

WORK, PROBE = "work", "probe"
"""Entries of y: the energy lost since the start; a bounded function without symmetry."""
PROBE_UNIT = 1024.0
"""Unit of the probe, so large that the probe never decides a step that another entry can decide."""
TAKEN = (
    "time",
    "outcome",
    "evidence",
    "end_time",
    "end_time_error",
    "trusted_time",
    "settled_time",
    "energy_error",
    "final_error",
    "steps",
    "method",
    "running",
    "number",
    "nearest_family",
    "nearest_distance",
    "nearest_member",
    "event_launch",
    "event_time",
    "event_kind",
    "event_state",
    "event_direction",
    "start_state",
    "dissipated",
    "audit",
    "launch",
    "event",
    "state",
    WORK,
    PROBE,
)
"""Names of a motion's dataset that no state, parameter or observable can have."""


POSE = ("phi", "psi", "centre_x", "centre_y")
"""Precession angle, relative spin angle, horizontal place of the centre; x̂ = (cos φ, sin φ)."""
POSE_UNIT = 1024.0
"""Unit of the pose in the integration.  The pose grows without bound, and without this unit it
would loosen a tolerance that is relative to the largest entry of the state."""
LIFT_OFF, FLAT, NO_CONTACT, CONE = "lift-off", "flat", "no-contact", "slip"
CREEP_ENDS = "creep ends"
"""Names of the guards."""
WORDS = {
    LIFT_OFF: "normal force times D",
    FLAT: "sine of theta less that of flat",
    NO_CONTACT: "D",
    CREEP_ENDS: CREEPS,
}
"""Each guard in words."""


@dataclass(frozen=True, eq=False)
class Chart:
    """What a motion reports, where y holds other states than those."""

    pack: Callable[[Floats], Floats]
    """Reported states, shape (…, s) → y at the start, shape (…, n)."""
    report: Callable[[Floats], Floats]
    """y, shape (…, n) → reported states, shape (…, s)."""
    along: Callable[[Floats, dict[str, Floats]], dict[str, Floats]]
    """(y, series) → the series along the reported axes, with the pose where y holds one."""


def _unproved(_: Floats) -> bool:
    return False


@dataclass(frozen=True, eq=False)
class Dry:
    """What dry friction needs in addition to the model of sliding: the body at rest."""

    sliding: System
    """Sliding in a direction that is a parameter, so that the rates have a value at rest."""
    held: System
    """Held at rest by any force: four states, and the parameters without mu."""
    sticking: Callable[[], Model]
    """Gives the model held at rest, with a guard for the friction cone: y without the slip."""
    unique: Callable[[Floats], bool] = _unproved
    """Whether a proof says that at these parameters exactly one motion continues from rest."""

    def in_direction(self, p: Iterable[Any], angle: Any) -> list[Any]:
        """The parameters of `sliding` from those of the model's system and a direction."""
        values = list(p)
        values.insert(self.sliding.parameters.index(DIRECTION), angle)
        return values

    def at_rest(self, p: Iterable[Any]) -> list[Any]:
        """The parameters of `held` from those of the model's system."""
        names = [n for n in self.sliding.parameters if n != DIRECTION]
        return [v for n, v in zip(names, p, strict=True) if n != MU]

    def friction(self, p: Floats) -> float:
        """The friction coefficient among the parameters of the model's system."""
        return float(p[[n for n in self.sliding.parameters if n != DIRECTION].index(MU)])


@dataclass(frozen=True, eq=False)
class Held:
    """What creep needs as well as the model: the body without slip, and held to a stated slip."""

    rough: Callable[[], Model]
    """Gives the model without slip; y holds the states of the model's system, the slip left out."""
    programs: Callable[[], tuple[Program, Program]]
    """As `stability.bodies.held_motion.held_programs`, of the parameters without the law's."""


@dataclass(frozen=True, eq=False)
class Model:
    """Equations, guards, observables and names that a launch needs.

    y holds the states of the system, then the energy lost (where it is counted), then further
    entries such as the pose.  A guard is a function of y that stays positive.  The run ends where
    the first guard reaches zero.
    """

    system: System
    """The equations of motion with their observables."""
    states: tuple[str, ...]
    """Names of the states that a motion reports; those that the system does not have are 0."""
    x: ca.SX
    """Symbols of y, shape (n,)."""
    p: ca.SX
    """Parameters: those of the system, then those of the guards."""
    rhs: ca.SX
    """dy/dt, shape (n,)."""
    names: tuple[str, ...]
    """Names of the entries of y."""
    guards: Mapping[str, ca.SX]
    """Functions that stay positive, by name."""
    words: Mapping[str, str] = field(default_factory=dict)
    """Each guard in words."""
    series: Mapping[str, ca.SX] = field(default_factory=dict)
    """Scalar functions of the system's states and parameters that a motion reports."""
    quantities: Mapping[str, Quantity] = field(default_factory=dict)
    """Names in words and units; a name without a record has its unit from the system."""
    friction: str = ""
    """Name of the parameter that the decay rate of slip is proportional to; empty for none."""
    turning: tuple[int, ...] = ()
    """Indices in y of the angular velocities, which give the pace of the motion."""
    sliding: tuple[int, ...] = ()
    """Indices in y of the entries that soon decay if stiff; stiffness is found without them too."""
    sound: Callable[[Any], bool] | None = None
    """Cheap test that no guard failed at states, shape (t, n), by which heyoka may watch for one
    event, the product of the guards; None: it watches for each, and all guards are evaluated."""
    chart: Chart | None = None
    """How reported states follow from y; None where y begins with them."""
    short: Callable[[Model], Model] | None = None
    """(this model) → the same motion in states that need fewer operations, in a chart."""
    dry: Dry | None = None
    """The body at rest, under a law that sticks."""
    held: Held | None = None
    """The body held to a slip, under a law whose slip decays."""
    title: str = ""
    """Title of a motion's dataset."""
    source: str = ""
    """Source of the equations."""

    @property
    def accounted(self) -> bool:
        """Whether y counts the energy lost."""
        return WORK in self.names

    def attributes(self, name: str, *, dimensionless: bool) -> dict[str, str]:
        """Name in words and units of a labelled array.

        Parameters
        ----------
        name
            A state, parameter or observable, or `time`.
        dimensionless
            Whether the body's units are all 1; not used for a user's system, which states units.
        """
        quantity = self.quantities.get(name)
        if quantity is not None:
            return quantity.attributes(dimensionless=dimensionless)
        units, same = self.system.units, {"dissipated": "energy", "audit": "energy"}
        unit = time_unit(units) if name == "time" else units.get(same.get(name, name), "1")
        return {"long_name": name.replace("_", " "), "units": unit}


def system_model(system: System) -> Model:
    """The model of a user's system: its conditions are the guards, its observables are reported.

    Parameters
    ----------
    system
        Any system; the energy lost is counted if `energy` and `power` are among its observables.

    Returns
    -------
    Model

    Raises
    ------
    ParameterError
        If a name is in `TAKEN`, cannot be stored in a file, or is both that of an observable and
        that of a state or parameter.

    Examples
    --------
    >>> x, p = ca.SX.sym("x", 2), ca.SX.sym("p")
    >>> s = System("cart", x, p, ca.vertcat(x[1], -p * x[1]), states=("q", "v"), parameters=("c",),
    ...            observables={"energy": x[1] ** 2 / 2, "power": p * x[1] ** 2})
    >>> system_model(s).names
    ('q', 'v', 'work', 'probe')
    """
    return _system_model(Same(system))


@lru_cache(maxsize=64)
def _system_model(same: Same) -> Model:
    system: System = same.value
    series: dict[str, ca.SX] = {}
    for name, value in system.observables.items():
        parts = ca.vertsplit(ca.vec(ca.densify(value)))
        series |= {name if len(parts) == 1 else f"{name}_{i}": v for i, v in enumerate(parts)}
    system.refuse_algebraic("a motion")
    for name in (*system.states, *system.parameters, *series):
        if "/" in name or not name.isprintable() or not name.strip():
            raise ParameterError(
                f"{system.name} has a quantity called {shown(name)}, which no file can hold; give "
                "it a printable name without a slash."
            )
        if name in TAKEN:
            raise ParameterError(
                f"{system.name} has a quantity called {name!r}, a name that a motion has for "
                "itself; give it another one."
            )
    for name in series:
        if name in (*system.states, *system.parameters):
            raise ParameterError(
                f"{system.name} observes {name!r}, which is a state or a parameter; give it "
                "another name."
            )
    if isinstance(system, NumericSystem):
        return Model(
            system,  # it has the face that motions ask for
            system.states,
            ca.SX.sym("x", len(system.states)),
            ca.SX.sym("p", len(system.parameters)),
            ca.SX(np.full(len(system.states), np.nan)),  # whoever reads them gets no number
            system.states,
            {},
            title=f"motion of {system.name}",
            source="a Python function, integrated by floats",
        )
    x, rhs, names = [system.x], [system.rhs], [*system.states]
    if "energy" in series and "power" in series:
        x, rhs, names = [*x, ca.SX.sym(WORK)], [*rhs, series["power"]], [*names, WORK]
    probe = ca.SX.sym(PROBE)
    x, rhs, names = [*x, probe], [*rhs, _probed(system.x, probe)], [*names, PROBE]
    sentences = {f"condition {i}": c.sentence for i, c in enumerate(system.conditions, 1)}
    return Model(
        system,
        system.states,
        ca.vertcat(*x),
        system.p,
        ca.vertcat(*rhs),
        tuple(names),
        dict(zip(sentences, (c.value for c in system.conditions), strict=True)),
        sentences,
        series,
        title=f"motion of {system.name}",
        source="user's system, integrated",
    )


def _probed(x: ca.SX, probe: ca.SX) -> ca.SX:
    """The rate of the probe: its Taylor series has all orders where those of the states have gaps.

    A Taylor integrator takes its step from the last two orders.  The angle of a pendulum that
    starts at rest at a right angle has the orders 2, 6, 10, 14 alone.  At order 12 both are zero,
    and the step has no bound (tests/motion/test_system_motion.py).
    """
    weights = 0.7 + 0.3 * np.modf((5**0.5 - 1) / 2 * np.arange(x.numel()))[0]
    sum_of_all = ca.dot(ca.DM(weights), x)
    square = sum_of_all**2
    return (square / (1 + square) - probe) / PROBE_UNIT


def placed(x: ca.SX, along_x: ca.SX, along_y: ca.SX, pose: ca.SX) -> ca.SX:
    """φ̇, ψ̇ = ω₃ − φ̇ cosθ, and the horizontal velocity of the centre turned by φ."""
    theta, phi_dot, omega3 = x[0], x[2], x[3]
    heading = POSE_UNIT * pose[0]
    cosine, sine = ca.cos(heading), ca.sin(heading)
    rates = ca.vertcat(
        phi_dot,
        omega3 - phi_dot * ca.cos(theta),
        cosine * along_x - sine * along_y,
        sine * along_x + cosine * along_y,
    )
    return rates / POSE_UNIT
