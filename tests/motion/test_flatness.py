"""A spun disk comes down: exponents near flatness, simulated and by energy.

A disk that tumbles with its centre at rest at a small inclination a has the energy 3/2 m g R a, the
precession (g/(k R a))^(1/2) and, relative to the turning frame, a spin of the same size.  A law
whose power is P gives da/dt = -P/(3/2 m g R) = -C a^p.  Units m = R = g = 1.
"""

import math
from collections.abc import Callable
from typing import Any, NamedTuple

import casadi as ca
import numpy as np
import pytest
from scipy.interpolate import CubicSpline

import stability as st

START, HIGH, LOW, RATIO = 0.04, 0.03, 0.01, 1.5
"""Inclinations [rad]: at the start, and of the two stretches that are timed, with their ratio."""
SLOW, SLIDING = 1e-3, 20.0
"""Rate of decay at the start, da/dt over a, which is small next to the precession; coefficient of
viscous sliding, which keeps the centre at rest."""


class Law(NamedTuple):
    """A law of dissipation: da/dt = -2/3 c k^(-over_k) a^p by energy."""

    by: Any
    """A resistance of the package, or a force along the rim from its speed and sin theta."""
    power: float
    over_k: float

    def coefficient(self, c: float, k: float) -> float:
        """C for a coefficient of the law."""
        return 2 / 3 * c / k**self.over_k


LAWS = {
    "rolling resistance": Law(st.RollingResistance, 1.0, 1.0),
    "pivoting resistance": Law(st.PivotingResistance, 3.0, 1.0),
    "air torque": Law(st.AirTorque, 1.0, 1.0),
    # contour friction of Le Saux, Leine & Glocker, J. Nonlinear Sci. 15 (2005)
    "dry friction along the rim": Law(lambda rim, _: -ca.sign(rim), -0.5, 0.5),
    "viscous friction along the rim": Law(lambda rim, _: -rim, -1.0, 1.0),
    # Moffatt, Nature 404 (2000) 833-834, with c = pi k mu for air of viscosity mu
    "layer of air below": Law(lambda rim, s: -rim / s, -2.0, 1.0),
}


def rim_disk(force: Callable[[Any, Any], Any]) -> st.System:
    """A thin disk with viscous sliding and a force along its rim, by Lagrange's equations.

    The force acts on the spin relative to the turning frame: that is the speed at which the contact
    point moves along the rim.
    """
    q = ca.vertcat(*(ca.SX.sym(n) for n in ("x", "y", "phi", "theta", "psi")))
    u = ca.vertcat(*(ca.SX.sym(n) for n in ("dx", "dy", "dphi", "dtheta", "dpsi")))
    k, sliding, c = (ca.SX.sym(n) for n in ("k", "sliding", "c"))
    east, north, level, up = ca.cos(q[2]), ca.sin(q[2]), ca.cos(q[3]), ca.sin(q[3])
    radius = ca.vertcat(east * level, north * level, -up)
    axis = ca.vertcat(east * up, north * up, level)
    across = ca.vertcat(-north, east, 0)
    turn = u[2] * ca.SX([0, 0, 1]) + u[3] * across + u[4] * axis
    one, two, three = (ca.dot(turn, e) for e in (radius, across, axis))
    centre = ca.vertcat(u[0], u[1], level * u[3])
    slip = (centre + ca.cross(turn, radius))[:2]
    forces = -sliding * ca.jacobian(slip, u).T @ slip
    forces[4] += c * force(u[4], up)
    return st.mechanics(
        q,
        u,
        ca.vertcat(k, sliding, c),
        potential=up,
        forces=forces,
        kinetic=(ca.sumsqr(centre) + k * (one**2 + two**2 + 2 * three**2)) / 2,
        ignorable=("x", "y", "psi"),
        name="disk with friction along its rim",
    )


def lasting(law: Law, rate: float, high: float, low: float) -> float:
    """Time between two inclinations by energy."""
    if law.power == 1:
        return math.log(high / low) / rate
    p = 1 - law.power
    return float((high**p - low**p) / (p * rate))


def descent(law: Law, k: float, c: float) -> Any:
    """A simulated motion from tumbling at the inclination `START` to one below `LOW`."""
    turn = (k * math.sin(START)) ** -0.5
    times = np.linspace(0.0, lasting(law, law.coefficient(c, k), START, 0.9 * LOW), 801)
    limits: dict[str, Any] = {"check": False, "max_seconds": 60.0, "max_steps": 10**7}
    if isinstance(law.by, type):
        start = {"theta": START, "phi_dot": turn}
        contact, resistance = st.Viscous(SLIDING), law.by(c)
        return st.simulate(st.Disk(k=k), contact, start, times, resistance=resistance, **limits)
    system = rim_disk(law.by)
    moving = {"theta": START, "dphi": turn, "dpsi": -turn * math.cos(START)}
    rest = dict.fromkeys(system.states, 0.0)
    return st.simulate(system, [k, SLIDING, c], rest | moving, times, **limits)


def measured(times: Any, angle: Any, power: float) -> tuple[float, float]:
    """Exponent and coefficient of da/dt = -C a^p from the times of two stretches.

    Both stretches have the same ratio of inclinations, so that their times have the ratio of their
    inclinations to the power 1 - p, for every C.
    """
    last = int(np.argmax(angle < LOW)) + 2
    spline = CubicSpline(times[:last], np.log(angle[:last]))
    ends = [HIGH, HIGH / RATIO, LOW * RATIO, LOW]
    at = [float(spline.solve(math.log(a), extrapolate=False)[0]) for a in ends]
    upper, lower = at[1] - at[0], at[3] - at[2]
    p = 1 - power
    grown = math.log(HIGH / LOW) if p == 0 else (HIGH**p - LOW**p) / p
    return 1 - math.log(lower / upper) / math.log(LOW * RATIO / HIGH), grown / (at[3] - at[0])


@pytest.mark.parametrize("power", [3.0, 1.0, -0.5, -2.0])
def test_exponent_and_coefficient_of_an_exact_decay_are_found(power: float) -> None:
    """Closed forms of da/dt = -C a^p, with C = 0.002."""
    p, c = 1 - power, 2e-3
    angle = np.geomspace(0.04, 0.008, 400)
    times = np.log(0.04 / angle) / c if p == 0 else (0.04**p - angle**p) / (p * c)
    assert measured(times, angle, power) == pytest.approx((power, c), rel=1e-7)


@pytest.mark.parametrize(
    ("name", "k", "within"),
    [("air torque", 0.25, 4e-3), ("layer of air below", 0.25, 4e-3)]
    + [pytest.param(n, k, 5e-3, marks=pytest.mark.long) for n in LAWS for k in (0.25, 0.4)],
)
def test_a_spun_disk_comes_down_as_energy_says(name: str, k: float, within: float) -> None:
    law = LAWS[name]
    c = SLOW * START ** (1 - law.power) / law.coefficient(1.0, k)  # each law as slow at the start
    c = min(c, 1e-3 * SLIDING)  # sliding changes the power of a law by some c over SLIDING
    run = descent(law, k, c)
    power, rate = measured(run.time.values, np.ravel(run.theta.values), law.power)
    assert power == pytest.approx(law.power, abs=3e-3 * min(abs(law.power), 1.0))
    assert rate == pytest.approx(law.coefficient(c, k), rel=within)


def test_moffatts_time_to_rest_follows_from_the_coefficient() -> None:
    """t_0 = a_0^3 M/(2 pi mu a) for a layer of air of viscosity mu, with M = a = g = 1."""
    viscosity, start, k, law = 1e-4, 0.1, 0.25, LAWS["layer of air below"]
    rate = law.coefficient(math.pi * k * viscosity, k)
    left = lasting(law, rate, start, 0.0)
    assert left == pytest.approx(start**3 / (2 * math.pi * viscosity), rel=1e-14)


def test_the_disk_with_a_rim_is_that_of_the_package_without_its_force() -> None:
    """Rates of both at random states, at linear sliding."""
    system = rim_disk(lambda rim, _: -rim)
    rng = np.random.default_rng(1)
    k, sliding = 0.3, 0.7
    for _ in range(5):
        theta, d_theta, d_phi, omega3, sx, sy = rng.uniform(0.3, 1.2, 6)
        rates = st.disk_system("linear-viscous").rates(
            [theta, d_theta, d_phi, omega3, sx, sy], [k, sliding]
        )
        # at phi = 0: x along the radius, y across; slip = velocity of the centre + turn x radius
        d_psi = omega3 - d_phi * math.cos(theta)
        turn = np.array([-d_phi * math.sin(theta), d_theta, omega3])
        lifted = np.array(
            [
                [math.cos(theta), 0, -math.sin(theta)],
                [0, 1, 0],
                [math.sin(theta), 0, math.cos(theta)],
            ]
        )
        arm = np.cross(turn @ lifted, lifted[0])
        state = {
            "phi": 0.0,
            "theta": theta,
            "dx": sx - arm[0],
            "dy": sy - arm[1],
            "dphi": d_phi,
            "dtheta": d_theta,
            "dpsi": d_psi,
        }
        found = dict(
            zip(
                system.states,
                system.rates([state[n] for n in system.states], [k, sliding, 0.0]),
                strict=True,
            )
        )
        assert found["dtheta"] == pytest.approx(rates[1], rel=1e-10)
        assert found["dphi"] == pytest.approx(rates[2], rel=1e-10)
