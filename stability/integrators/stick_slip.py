"""Dry friction without regularisation: sliding, landing, sticking, and the passage between them.

The slip is a vector, so |vA| → 0 is an event of codimension two: no signed function of the state
crosses zero there.  Near it the slip is taken in polar form with the logarithm of its size,
vA = e^ℓ (cos α, sin α), and time is stretched by dt = |vA| dτ.  Then

    dℓ/dτ = f(α, …),   dα/dτ = h(α, …)

is smooth up to |vA| = 0 (f and h are the slip's acceleration along and across its direction), and
a motion that comes to rest tends to a direction with h = 0, f < 0 (or f = 0 in the marginal case).
A motion has landed when |vA| has fallen below `REST`; the remaining time, |vA|/|f|, is below
rounding.

At rest every continuation is listed: sticking, if the force lies in the friction cone, and each
direction with h = 0, f > 0, gn > 0 in which a slip can set in.  h times the determinant D is a
trigonometric polynomial of degree two, so there are at most four directions.  Exactly one
continuation of a disk exists below mu = 2√(k(k+1)): docs/explanation/dry-friction.md.  If none or
several exist, the run ends with an outcome that says this.

tests/integrators/test_coulomb.py compares this module with an inertial formulation, with the limit
of regularised friction, and with closed formulas.
"""

from __future__ import annotations

import dataclasses
import math
from dataclasses import dataclass
from functools import lru_cache

import casadi as ca
import numpy as np
from numpy.typing import NDArray

from ..algebra.program import Program
from ..base.types import Floats
from ..bodies.model import CONE, LIFT_OFF, NO_CONTACT, WORK, Dry, Model
from .flow import Flow, flow_of
from .leg import UNRESOLVED, Budget, End, Leg, Path, too_many
from .scipy_methods import integrate as integrate_scipy
from .selection import METHODS, explicit

NEAR = 1e-3
"""Slip speed below which the polar form takes over [√(gR)]."""
AWAY = 2e-3
"""Slip speed at which the plain equations take over again [√(gR)]."""
REST = 1e-20
"""Slip speed that counts as rest: the remaining time of the landing is below rounding."""
ONSET = 1e-4
"""Time over which an onset of slip is a series, times the fastest angular velocity or √(g/R); its
error is of the order of its cube."""
DEPARTURE = 1e-6
"""Step by which a slip with f > 0 leaves rest, in the same unit; its error is of the order of its
square."""
STRETCHED = 1e12
"""Longest stretched time of one landing or onset."""
SWITCHES = 3000
"""Steps of LSODA near rest after which BDF takes over; it needs some hundred."""
ONSET_GRID = 401
"""Points over the stiff part of an onset."""
TRANSITIONS = 10_000
"""Transitions after which a run gives up."""
SMALL, LANDED, LEFT = "small", "landed", "left"
STICK, SLIP, REVERSE, NON_UNIQUE = "stick", "slip", "reverse", "non-unique"
SLIDING, STICKING = 0, 1
"""Modes of a sample."""
WIDE = 1e-4
"""Distance of a root from the unit circle, and of an acceleration from 0, for a closer look."""


@dataclass(frozen=True, eq=False)
class Transition:
    """A passage from sliding to sticking or back."""

    kind: str
    """`stick`, `slip`, or `reverse`: the slip passes through zero and sets in again at once."""
    time: float
    """Time of the passage."""
    state: Floats
    """y at that time, as for sliding, with zero slip."""
    direction: float
    """Direction of the slip before sticking, or of the slip that sets in: angle from x̂ [rad]."""


@dataclass(frozen=True, eq=False)
class DryPath:
    """A motion with dry friction."""

    path: Path
    """y as for sliding at the times of the leg, and the end."""
    modes: Floats
    """`SLIDING` or `STICKING` at each sample."""
    transitions: list[Transition]
    """Transitions in order of time."""
    mode: int
    """The mode at the end."""


@lru_cache(maxsize=8)
def polar_flow(model: Model) -> Flow:
    """Sliding in polar form and stretched time: y with ln|vA|, α for the slip, then the time."""
    system, count = _at_rest(model).sliding, len(model.names)
    y, work = ca.SX.sym("y", count + 1), model.names.index(WORK)
    size, angle = ca.exp(y[4]), y[5]
    x = ca.vertcat(y[:4], size * ca.cos(angle), size * ca.sin(angle))
    seen, parameters = system.observables, ca.vertsplit(model.p)[: len(model.system.parameters)]
    inner = [system.rhs, seen["normal_force"], seen["determinant"], seen["power"]]
    p = ca.vertcat(*_at_rest(model).in_direction(parameters, angle))
    rates, normal, determinant, power = ca.substitute(inner, [system.x, system.p], [x, p])
    along = ca.cos(angle) * rates[4] + ca.sin(angle) * rates[5]
    across = ca.cos(angle) * rates[5] - ca.sin(angle) * rates[4]
    others = [*model.guards.values(), model.rhs[work + 1 :]]
    *others, more = ca.substitute(others, [model.x], [ca.vertcat(x, y[6:count])])
    rhs = [size * rates[:4], along, across, size * power, size * more, size]
    guards = dict(zip(model.guards, others, strict=True)) | {
        LIFT_OFF: normal * determinant,
        NO_CONTACT: determinant,
        LANDED: y[4] - math.log(REST),
        LEFT: math.log(AWAY) - y[4],
    }
    names = (*model.names[:4], "log_slip", "direction", *model.names[6:], "time")
    return Flow(
        dataclasses.replace(
            model,
            system=system,
            x=y,
            rhs=ca.vertcat(*rhs),
            guards=guards,
            names=names,
            friction="",
            dry=None,
        )
    )


def _at_rest(model: Model) -> Dry:
    assert model.dry is not None
    return model.dry


@lru_cache(maxsize=8)
def sliding_flow(model: Model) -> Flow:
    """Sliding as the plain equations, with a guard where the slip becomes small."""
    plain = flow_of(model)
    small = plain.x[4] ** 2 + plain.x[5] ** 2 - NEAR**2
    return plain.having(guards={**plain.guards, SMALL: small})


@lru_cache(maxsize=8)
def sticking_flow(model: Model) -> Flow:
    """Sticking, with a guard for the friction cone."""
    return flow_of(_at_rest(model).sticking())


@lru_cache(maxsize=8)
def held_flow(model: Model) -> Flow:
    """Sticking without its guards, for the brief start of an onset, which lies beyond the cone."""
    return sticking_flow(model).having(guards={})


def _held(y: Floats) -> Floats:
    """The entries y of a body at rest, from those of sliding."""
    return np.delete(y, [4, 5])


def _with_slip(y: Floats) -> Floats:
    """The entries y as for sliding, shape (…, n), from those of a body at rest."""
    return np.insert(y, [4, 4], 0.0, axis=-1)


class _Dry:
    """One run through its modes; y is as for sliding (with slip) in every mode."""

    def __init__(self, leg: Leg, method: str) -> None:
        self.leg, self.method, self.model = leg, method, leg.flow.model
        self.dry = _at_rest(self.model)
        self.p = leg.p[: len(self.model.system.parameters)]
        self.times = leg.times
        self.time, self.y = float(leg.times[0]), leg.start.copy()
        self.rows: list[Floats] = [leg.start.copy()]
        self.modes: list[int] = []
        self.transitions: list[Transition] = []
        self.steps = 0
        self.budget = Budget(leg.seconds)
        self.onset = 0.0  # stretched time of the first part of an onset, which is stiff
        self.end: End | None = None

    def run(self) -> DryPath:
        size = math.hypot(self.y[4], self.y[5])
        mode = self._rest(None) if size <= REST else SLIDING
        self.modes.append(STICKING if mode == STICKING else SLIDING)
        last = float(self.times[-1])
        while self.end is None and self.time < last:
            if len(self.transitions) > TRANSITIONS:
                self._stop(UNRESOLVED, f"more than {TRANSITIONS} transitions")
            elif self.steps > self.leg.max_steps:
                self._stop(UNRESOLVED, too_many(self.leg.max_steps))
            elif self.budget.spent:
                self._stop(UNRESOLVED, self.budget.message)
            elif mode == STICKING:
                mode = self._stick()
            elif math.hypot(self.y[4], self.y[5]) <= NEAR:
                mode = self._run_polar()
            else:
                mode = self._slide()
        path = Path(np.array(self.rows), self.end, self.steps, self.budget.used)
        return DryPath(path, np.array(self.modes, dtype=float), self.transitions, mode)

    # --- one mode each: run to its end, and return the next ---

    def _slide(self) -> int:
        kind = self._advance(sliding_flow(self.model), SLIDING)
        if kind is not None and kind != SMALL:
            self._stop(kind)
        elif kind == SMALL:  # step inside, so that rounding cannot hold it at the border
            self.y[4:6] *= NEAR * (1 - 1e-12) / math.hypot(self.y[4], self.y[5])
        return SLIDING

    def _stick(self) -> int:
        first = len(self.rows)
        kind = self._advance(sticking_flow(self.model), STICKING)
        if self._ambiguous(first):
            return STICKING
        if kind == CONE:
            return self._onset()
        if kind is not None:
            self._stop(kind)
        return STICKING

    def _ambiguous(self, first: int) -> bool:
        """Whether slip could also have set in at a sample of sticking: then the run ends there."""
        if self.dry.unique(self.p):
            return False
        if first == len(self.rows):
            return False
        looked = np.array(self.rows[first:])[:, :4]
        for i in first + np.flatnonzero(suspects(self.dry, looked, self.p)):
            ways = continuations(self.dry, self.rows[i][:4], self.p)
            if ways.directions or ways.lifts:
                self.time, self.y = float(self.times[i]), self.rows[i].copy()
                del self.rows[i + 1 :], self.modes[i + 1 :]
                lifts = ", and the contact can lift off" if ways.lifts else ""
                why = f"while sticking slip can set in at {ways.directions} rad{lifts}"
                self._stop(NON_UNIQUE, why)
                return True
        return False

    def _run_polar(self) -> int:
        """Run in polar form: to rest, back to plain sliding, or to an end."""
        state = np.append(self.y, self.time)
        state[4] = math.log(math.hypot(self.y[4], self.y[5]))
        state[5] = math.atan2(self.y[5], self.y[4])
        path = self._setting_in(state) if self.onset else None
        self.onset = 0.0
        if path is None or path.end is None:
            path = self._stretched(path.states[-1] if path else state)
        if path.end is None:  # the last sample was reached, or nothing happens any more
            if len(self.rows) < len(self.times):
                self._stop(UNRESOLVED, "the slip neither ends nor grows")
            self.time = float(self.times[-1])
            return SLIDING
        self.time, self.y = float(path.end.state[-1]), self._cartesian(path.end.state)
        if path.end.kind == LANDED:
            angle = float(path.end.state[5])
            self.y[4:6] = 0.0
            return self._rest(angle)
        if path.end.kind != LEFT:
            self._stop(path.end.kind, path.end.message)
        return SLIDING

    def _stretched(self, state: Floats) -> Path:
        """Run in stretched time; LSODA may take a stiff slip for one that is not: then by BDF."""
        leg = self._polar_leg(state, np.array([0.0, STRETCHED]))
        for solver, most in (("LSODA", min(SWITCHES, leg.max_steps)), ("BDF", leg.max_steps)):
            leg = dataclasses.replace(leg, max_steps=most)
            path = integrate_scipy(leg, solver=solver, clock=self.times[len(self.rows) :])
            self.steps += path.steps
            for row in path.states:
                self._sample(self._cartesian(row), SLIDING)
            if path.end is None or path.end.kind != UNRESOLVED or self.budget.spent:
                break
            leg = self._polar_leg(path.end.state, np.array([path.end.time, STRETCHED]))
        return path

    def _polar_leg(self, state: Floats, span: Floats) -> Leg:
        tolerance = max(self.leg.tolerance / 10, 1e-14)
        which = polar_flow(self.model)
        return self._leg(which, state, span, tolerance)

    def _leg(self, which: Flow, start: Floats, times: Floats, tolerance: float) -> Leg:
        """A leg with the computing time that is left."""
        most, left = self.leg.max_steps, self.budget.left
        return Leg(which, self.leg.p, start, times, tolerance, most, left)

    def _setting_in(self, state: Floats) -> Path:
        """The first part of an onset, which is stiff: the direction adjusts at once.

        Samples come from cubics through the grid in time, with the rates at both ends.
        """
        from scipy.interpolate import CubicHermiteSpline

        # even in the logarithm of time: t from the first instant to a hundred times it
        grid = (1 - 1 / np.geomspace(1.0, 100.0, ONSET_GRID)) * (self.onset / 0.99)
        # a slow onset would need a very fine even grid in stretched time: 50 000 looks
        leg = dataclasses.replace(self._polar_leg(state, grid), dense=True)
        path = METHODS["cvodes"](leg)
        self.steps += path.steps
        samples = path.states if path.end is None else np.vstack([path.states, path.end.state])
        due = self.times[len(self.rows) :]
        due = due[due <= samples[-1, -1]]
        if due.size:
            cartesian = np.array([self._cartesian(row) for row in samples])
            rates = np.array(self.leg.flow.rates(cartesian.T, self.leg.p)).T
            # a loose run's time may stand still or go back by its error: only later times count
            latest = np.maximum.accumulate(samples[:, -1])
            keep = np.append(True, samples[1:, -1] > latest[:-1])
            cubic = CubicHermiteSpline(samples[keep, -1], cartesian[keep], rates[keep])
            for row in cubic(due):
                self._sample(row, SLIDING)
        return path

    def _cartesian(self, state: Floats) -> Floats:
        """The state of plain sliding from that in polar form."""
        y = state[: len(self.y)].copy()
        size = math.exp(state[4])
        y[4:6] = size * math.cos(state[5]), size * math.sin(state[5])
        return y

    def _rest(self, arrival: float | None) -> int:
        """Take the one continuation from rest, or end the run."""
        ways = continuations(self.dry, self.y[:4], self.p)
        if ways.count == 1 and ways.sticks:
            if arrival is not None:
                self._note(STICK, arrival)
            return STICKING
        if ways.count == 1 and ways.directions:
            return self._depart(ways.directions[0], arrival)
        if ways.count == 0 and ways.ratio <= 1 + 1e-9:  # on the edge of the cone
            return self._onset()
        kind = NO_CONTACT if ways.count == 0 else NON_UNIQUE
        if ways.lifts and not ways.pressed:
            kind = LIFT_OFF
        self._stop(
            kind,
            f"|F|/(mu gn) of sticking is {ways.ratio:.6g}, slip can set in at "
            f"{[round(a, 6) for a in ways.directions]} rad"
            + (", and the contact can lift off" if ways.lifts else ""),
        )
        return STICKING

    def _depart(self, angle: float, arrival: float | None) -> int:
        """Leave rest at once in a direction with f > 0: the slip grows in proportion to time."""
        self._note(SLIP if arrival is None else REVERSE, angle)
        plain = self.leg.flow
        rates = np.array(plain.rates(self._along(angle), self.leg.p)).ravel()
        rates[:6] = self._slipping(self.y, angle)
        due = float(self.times[len(self.rows)])
        step = min(self._brief(DEPARTURE), (due - self.time) / 2)
        step = self._before_a_guard(plain, step, rates)
        self.y += step * rates
        self.time += step
        return SLIDING

    def _before_a_guard(self, plain: Flow, step: float, rates: Floats) -> float:
        """A step that is short enough to pass no guard."""
        for _ in range(60):
            there = self.y + step * rates
            if (plain.margins(there, self.leg.p)[0] > 0).all():
                break
            step /= 4
        return step

    def _along(self, angle: float) -> Floats:
        """The state with the least slip in a direction, where the plain rates have a meaning."""
        y = self.y.copy()
        y[4:6] = REST * math.cos(angle), REST * math.sin(angle)
        return y

    def _onset(self) -> int:
        """Leave the friction cone: slip sets in against the force, and grows as time squared."""
        _, fx, fy = sticking_force(self.dry, self.y[:4], self.p)
        angle = math.atan2(-fy, -fx)
        others = [
            a
            for a in continuations(self.dry, self.y[:4], self.p).directions
            if math.cos(a - angle) < 0.999
        ]
        if others:
            self._stop(NON_UNIQUE, f"at the edge of the cone slip can also set in at {others} rad")
            return STICKING
        before, when, span = self.y.copy(), self.time, self._brief(ONSET)
        due = self.times[len(self.rows) :]
        due = due[due < when + span]
        grid = np.concatenate([[when], due[due > when], [when + span]])
        leg = self._leg(held_flow(self.model), _held(before), grid, 1e-13)
        stuck = _with_slip(METHODS["dop853"](leg).states)
        after = stuck[-1]
        angle = polish(self.dry, after[:4], self.p, angle)
        f = float(slip_acceleration(self.dry, after[:4], self.p, np.array([angle]))[0][0])
        for t, row in zip(leg.times[1:-1], stuck[1:-1], strict=True):
            share = (t - when) / span
            excess = self._excess(after, angle, span) - after if f > 0 else 0.0 * after
            excess[1:] *= share**2
            excess[0] *= share**3
            self._sample(row + excess, SLIDING if f > 0 else STICKING)
        self.time = when + span
        if f <= 0:  # the cone was only grazed
            self.y = after
            return STICKING
        self.transitions.append(Transition(SLIP, when, before, angle))
        # with |vA| = c t²/2 the stretched time from t to infinity is 2/(c t), and f = c t
        self.y, self.onset = self._excess(after, angle, span), 0.99 * 2 / f
        return SLIDING

    def _brief(self, share: float) -> float:
        """A short time: a share of that in which the disk turns by a radian."""
        return share / max(1.0, float(np.abs(self.y[1:4]).max()))

    def _excess(self, stuck: Floats, angle: float, span: float) -> Floats:
        """The state after a brief time of slip, from that of sticking.

        The excess acceleration grows in proportion to time t, so that velocities gain t/2 times it
        and angles t²/6 times it.
        """
        held = self.dry.held.rates(stuck[:4], self.dry.at_rest(self.p))
        excess = self._slipping(stuck, angle) - np.append(held, [0.0, 0.0])
        y = stuck.copy()
        y[1:6] += excess[1:6] * span / 2
        y[0] += excess[1] * span**2 / 6
        return y

    def _slipping(self, y: Floats, angle: float) -> Floats:
        """Rates of the six states where slip sets in in a direction."""
        parameters = self.dry.in_direction(self.p.tolist(), angle)
        rates: Floats = self.dry.sliding.rates(y[:6], parameters)
        return rates

    # --- book-keeping ---

    def _advance(self, which: Flow, mode: int) -> str | None:
        """Run the flow of a mode over the remaining samples; the guard that ended it, or None."""
        times = np.append(self.time, self.times[len(self.rows) :])
        start, back = (_held(self.y), _with_slip) if mode == STICKING else (self.y, np.copy)
        leg = self._leg(which, start, times, self.leg.tolerance)
        auto = self.method == "auto"
        path = METHODS[explicit() if auto else self.method](leg)
        if auto and path.end is not None and path.end.kind == UNRESOLVED:
            path = METHODS["lsoda"](leg)
        self.steps += path.steps
        for row in path.states[1:]:
            self._sample(back(row), mode)
        if path.end is None:
            self.time, self.y = float(self.times[-1]), self.rows[-1].copy()
            return None
        self.time, self.y = path.end.time, back(path.end.state)
        if path.end.kind == UNRESOLVED:
            self._stop(UNRESOLVED, path.end.message)
        return path.end.kind

    def _sample(self, y: Floats, mode: int) -> None:
        self.rows.append(y)
        self.modes.append(mode)

    def _note(self, kind: str, angle: float) -> None:
        self.transitions.append(Transition(kind, self.time, self.y.copy(), angle))

    def _stop(self, kind: str, message: str = "") -> None:
        if kind == UNRESOLVED and self.budget.spent:  # not that of the last piece
            message = self.budget.message
        if self.end is None:
            self.end = End(kind, self.time, self.y.copy(), message)


def integrate(leg: Leg, method: str = "auto") -> DryPath:
    """Run one launch with dry friction through sliding and sticking.

    Parameters
    ----------
    leg
        Leg with the flow of a model of sliding.
    method
        Integrator of sliding and sticking; landings use LSODA, onsets CVODES.

    Returns
    -------
    DryPath
    """
    return _Dry(leg, method).run()


@dataclass(frozen=True, eq=False)
class Continuations:
    """Continuations of a motion from rest."""

    sticks: bool
    """Whether the force of sticking lies inside the friction cone, with gn > 0."""
    ratio: float
    """|F| / (mu gn) of sticking."""
    directions: tuple[float, ...]
    """Angles in which a slip can set in [rad]."""
    lifts: bool = False
    """Whether the contact point, left to itself, accelerates upwards, so that it can lift off."""

    @property
    def count(self) -> int:
        """Number of continuations."""
        return self.sticks + self.lifts + len(self.directions)

    @property
    def pressed(self) -> bool:
        """Whether a continuation keeps the contact."""
        return self.sticks or bool(self.directions)


@lru_cache(maxsize=32)
def _rest_programs(dry: Dry) -> tuple[Program, Program]:
    """Programs at rest: slip acceleration, gn and D in a direction; gn and force of sticking."""
    along, held = dry.sliding, dry.held
    seen, there = along.observables, held.observables
    sliding = ca.vertcat(along.rhs[4:6], seen["normal_force"], seen["determinant"])
    sticking = ca.vertcat(there["normal_force"], there["contact_force"])
    return (
        Program(ca.Function("sliding", [along.x, along.p], [sliding])),
        Program(ca.Function("sticking", [held.x, held.p], [sticking])),
    )


def slip_acceleration(
    dry: Dry, four: Floats, p: Floats, angles: Floats
) -> tuple[Floats, Floats, Floats, Floats]:
    """The slip's acceleration at rest, for an onset in directions: f, h, gn and D.

    `four` are theta, theta_dot, phi_dot and omega3, shape (4, …); `angles` are from x̂, shape (…,
    n), as are the results.
    """
    x = [np.broadcast_to(np.asarray(v)[..., None], angles.shape) for v in four]
    x += [np.zeros_like(angles), np.zeros_like(angles)]
    parameters = dry.in_direction([np.full_like(angles, v) for v in p], angles)
    values = _rest_programs(dry)[0].arrays([x, parameters], angles.shape)[0][..., 0]
    vx, vy, normal, d = np.moveaxis(values, -1, 0)
    c, s = np.cos(angles), np.sin(angles)
    return c * vx + s * vy, c * vy - s * vx, normal, d


def sticking_force(dry: Dry, four: Floats, p: Floats) -> tuple[float, float, float]:
    """Normal force, and force along x̂ and ŷ, that hold the contact point at rest [m g].

    Examples
    --------
    >>> from stability.bodies.thin_disk import disk_model
    >>> dry = disk_model("coulomb").dry
    >>> sticking_force(dry, np.array([math.pi / 2, 0, 0, 1.2]), np.array([0.25, 0.3]))[0]
    1.0
    """
    arguments = [[np.float64(v) for v in four], [np.float64(v) for v in dry.at_rest(p)]]
    values = _rest_programs(dry)[1].arrays(arguments, ())[0][..., 0]
    return float(values[0]), float(values[1]), float(values[2])


def directions(dry: Dry, four: Floats, p: Floats) -> Floats:
    """Every direction, at most four, in which the slip's acceleration at rest is radial (h = 0)."""
    angles: Floats = np.arange(8.0) * (math.pi / 4)
    _, across, _, d = slip_acceleration(dry, four, p, angles)
    if not np.isfinite(across * d).all():
        angles = angles + 0.1  # a sample hit D = 0
        _, across, _, d = slip_acceleration(dry, four, p, angles)
    waves = np.fft.fft(across * d) / 8
    waves = waves * np.exp(-1j * np.fft.fftfreq(8, 1 / 8) * angles[0])
    polynomial = np.array([waves[2], waves[1], waves[0], waves[-1], waves[-2]])
    roots = np.roots(polynomial)
    near = np.angle(roots[np.abs(np.abs(roots) - 1) < 1e-6])
    return np.array([polish(dry, four, p, a) for a in near])


def suspects(dry: Dry, rows: Floats, p: Floats) -> NDArray[np.bool_]:
    """Rows at which a slip may set in, or the contact may lift off; the others have no such way."""
    angles = np.tile(0.1 + np.arange(8.0) * (math.pi / 4), (len(rows), 1))
    with np.errstate(all="ignore"):
        _, across, normal, d = slip_acceleration(dry, rows.T, p, angles)
        waves = np.fft.fft(across * d) / 8
        first = waves[:, [2]]
        finite = np.isfinite(waves).all(axis=1) & (np.abs(first[:, 0]) > 0)
        companion = np.tile(np.eye(4, k=-1, dtype=complex), (len(rows), 1, 1))
        companion[finite, 0] = -(waves[:, [1, 0, -1, -2]] / first)[finite]
        roots = np.linalg.eigvals(companion)
        near = np.abs(np.abs(roots) - 1) < WIDE
        along, _, pressed, _ = slip_acceleration(dry, rows.T, p, np.angle(roots) + 0.1)
        free = near & ~((along < -WIDE * (1 + np.abs(along))) | (pressed < 0))
    open_rows: NDArray[np.bool_] = ~finite | free.any(axis=1) | ~(normal[:, 0] * d[:, 0] > 0)
    return open_rows


def polish(dry: Dry, four: Floats, p: Floats, angle: float) -> float:
    """A direction with h = 0 near a given one, by Newton's rule with a difference for the slope.

    Near an angle without a simple zero of h it stays there.
    """
    step = 1e-6
    for _ in range(3):
        h = slip_acceleration(dry, four, p, np.array([angle - step, angle, angle + step]))[1]
        slope = (h[2] - h[0]) / (2 * step)
        if slope == 0 or not np.isfinite(slope) or abs(h[1] / slope) > 1e-3:
            break
        angle -= h[1] / slope
    return float(angle)


def continuations(dry: Dry, four: Floats, p: Floats) -> Continuations:
    """Every continuation from rest.

    Examples
    --------
    >>> at_rest = np.array([math.pi / 2, 0.0, 0.0, 1.2])
    >>> from stability.bodies.thin_disk import disk_model
    >>> c = continuations(disk_model("coulomb").dry, at_rest, np.array([0.25, 0.3]))
    >>> c.sticks, c.directions
    (True, ())
    """
    normal, fx, fy = sticking_force(dry, four, p)
    ratio = math.hypot(fx, fy) / (dry.friction(p) * normal) if normal > 0 else math.inf
    candidates = directions(dry, four, p)
    free: tuple[float, ...] = ()
    # gn D has one value in every direction; with bz > 0 a direction with gn > 0 has D < 0
    _, _, weight, d = slip_acceleration(dry, four, p, np.zeros(1))
    lifts = bool(weight[0] * d[0] < 0)
    if candidates.size:
        along, _, gn, _ = slip_acceleration(dry, four, p, candidates)
        free = tuple(float(a) for a in candidates[(along > 1e-9) & (gn > 0)])
    return Continuations(ratio <= 1.0, ratio, free, lifts)
