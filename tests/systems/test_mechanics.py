"""`mechanics` against closed forms, SymPy's Lagrange and Kane methods, and conserved energy."""

from collections.abc import Callable
from typing import Any

import casadi as ca
import numpy as np
import pytest
import sympy as sp
import sympy.physics.mechanics as me
from kane_disk import kane
from own_systems import symbols

import stability as st


def states(count: int, size: int, seed: int = 1) -> Any:
    return np.random.default_rng(seed).uniform(0.2, 1.2, (count, size))


def lost(system: st.System, x: Any, p: Any) -> Any:
    """dE/dt + power by the graph's own slope of the energy: zero where the equations are right."""
    seen = system.observables
    rate = ca.jtimes(seen["energy"], system.x, system.rhs) + seen["power"]
    slope = ca.Function("slope", [system.x, system.p], [rate])
    return np.array([float(slope(row, p)) for row in x])


# --- without constraints ---


def double_pendulum() -> st.System:
    a, b, da, db, m, r, g = symbols("a", "b", "da", "db", "m", "r", "g")
    speed = da**2 + db**2 * r**2 + 2 * r * da * db * ca.cos(a - b)
    return st.mechanics(
        ca.vertcat(a, b),
        ca.vertcat(da, db),
        ca.vertcat(m, r, g),
        kinetic=(da**2 + m * speed) / 2,
        potential=-g * (ca.cos(a) + m * (ca.cos(a) + r * ca.cos(b))),
    )


def test_a_double_pendulum_is_that_of_sympys_lagrange_method() -> None:
    a, b = me.dynamicsymbols("a b")
    m, r, g = sp.symbols("m r g")
    da, db = a.diff(), b.diff()
    speed = da**2 + db**2 * r**2 + 2 * r * da * db * sp.cos(a - b)
    height = -g * (sp.cos(a) + m * (sp.cos(a) + r * sp.cos(b)))
    method = me.LagrangesMethod((da**2 + m * speed) / 2 - height, [a, b])
    method.form_lagranges_equations()
    x, p = states(5, 4), [1.3, 0.7, 9.81]
    found = double_pendulum().rates(x, p)
    solve = sp.lambdify([a, b, da, db, m, r, g], [method.mass_matrix, method.forcing])
    for row, rates in zip(x, found, strict=True):
        mass, force = solve(*row, *p)
        assert rates[2:] == pytest.approx(np.linalg.solve(mass, force).ravel(), rel=1e-12)
        assert (rates[:2] == row[2:]).all()


def test_forces_by_name_take_the_energy_that_power_says() -> None:
    q, u, k, c = symbols("q", "u", "k", "c")
    system = st.mechanics(
        q,
        u,
        ca.vertcat(k, c),
        kinetic=u**2,
        potential=k * q**2 / 2,
        forces={"u": -c * u},
        observables={"twice": 2 * q},
    )
    assert system.rates([0.5, 2.0], [3.0, 0.1]) == pytest.approx([2.0, (-1.5 - 0.2) / 2])
    seen = system.observe([0.5, 2.0], [3.0, 0.1])
    assert {n: float(v) for n, v in seen.items()} == pytest.approx(
        {"energy": 4 + 3 / 8, "power": 0.4, "twice": 1.0}
    )


def test_a_turning_hoop_has_jacobis_energy() -> None:
    """A bead on a hoop that turns at the rate n: T + V is not kept, ∂T/∂u u - T + V is."""
    q, u, n = symbols("q", "u", "n")
    bead = st.mechanics(q, u, n, kinetic=(u**2 + (n * ca.sin(q)) ** 2) / 2, potential=-ca.cos(q))
    angle, rate, turn = 0.7, 0.4, 1.5
    assert bead.rates([angle, rate], [turn])[1] == pytest.approx(
        np.sin(angle) * (turn**2 * np.cos(angle) - 1), rel=1e-14
    )
    assert float(bead.observe([angle, rate], [turn])["energy"]) == pytest.approx(
        (rate**2 - (turn * np.sin(angle)) ** 2) / 2 - np.cos(angle), rel=1e-14
    )
    assert abs(lost(bead, states(4, 2), [turn])).max() < 1e-14


# --- quasi-velocities ---


def euler_angles() -> tuple[ca.SX, ca.SX, ca.SX]:
    """Angles about z, y, x, the body's angular velocity, and the angles' rates."""
    q, w = ca.vertcat(*symbols("yaw", "pitch", "roll")), ca.vertcat(*symbols("w1", "w2", "w3"))
    s, c, t = ca.sin(q[2]), ca.cos(q[2]), ca.tan(q[1])
    across = s * w[1] + c * w[2]
    return q, w, ca.vertcat(across / ca.cos(q[1]), c * w[1] - s * w[2], w[0] + t * across)


def quaternion() -> tuple[ca.SX, ca.SX, ca.SX]:
    q, w = ca.vertcat(*symbols("a", "b", "c", "d")), ca.vertcat(*symbols("w1", "w2", "w3"))
    turned = q[0] * w + ca.cross(q[1:], w)
    return q, w, ca.vertcat(-ca.dot(q[1:], w), turned) / 2


@pytest.mark.parametrize("kinematics", [euler_angles, quaternion])
def test_a_free_body_obeys_eulers_equations(
    kinematics: Callable[[], tuple[ca.SX, ca.SX, ca.SX]],
) -> None:
    q, w, rates = kinematics()
    moments = np.array([1.0, 2.0, 4.0])
    body = st.mechanics(q, w, q_dot=rates, kinetic=ca.dot(w, ca.DM(moments) * w) / 2)
    x = states(6, q.numel() + 3)
    spin = x[:, -3:]
    expected = -np.cross(spin, moments * spin) / moments
    assert body.rates(x, np.zeros((6, 0)))[:, -3:] == pytest.approx(expected, abs=1e-13)


# --- the sleigh, in three ways ---

SLEIGH = [1.3, 0.3, 0.2]


def sleigh(**options: Any) -> st.System:
    """The knife edge in a frame at rest: x' sin h = y' cos h at the blade."""
    x, y, h, dx, dy, w, m, a, inertia = symbols("x", "y", "h", "dx", "dy", "w", "m", "a", "I")
    c, s = ca.cos(h), ca.sin(h)
    kinetic = m * ((dx - a * s * w) ** 2 + (dy + a * c * w) ** 2) / 2 + inertia * w**2 / 2
    return st.mechanics(
        ca.vertcat(x, y, h),
        ca.vertcat(dx, dy, w),
        ca.vertcat(m, a, inertia),
        kinetic=kinetic,
        velocity_constraints={"blade": dy * c - dx * s},
        **options,
    )


def sleigh_rates(h: Any, v: Any, w: Any) -> Any:
    """Rates of (dx, dy, w) from v' = a w², (I + m a²) w' = -m a v w."""
    m, a, inertia = SLEIGH
    dv = a * w**2
    return np.stack(
        [
            dv * np.cos(h) - v * w * np.sin(h),
            dv * np.sin(h) + v * w * np.cos(h),
            -m * a * v * w / (inertia + m * a**2),
        ],
        axis=-1,
    )


@pytest.mark.parametrize("pivots", [None, {"blade": "dx"}, {"blade": "dy"}])
def test_every_choice_of_pivots_gives_the_sleigh(pivots: Any) -> None:
    h, v, w = states(7, 3).T
    x = np.stack([0 * h, 0 * h, h, v * np.cos(h), v * np.sin(h), w], axis=-1)
    system = sleigh(pivots=pivots)
    assert system.rates(x, SLEIGH)[:, 3:] == pytest.approx(sleigh_rates(h, v, w), abs=1e-14)
    seen = system.observe(x, SLEIGH)
    m, a, inertia = SLEIGH
    force = m * (v * w - m * a**2 * v * w / (inertia + m * a**2))  # m (a w' + v w)
    assert seen["multiplier_blade"] == pytest.approx(force, abs=1e-14)
    assert abs(seen["residual_blade"]).max() < 1e-15
    assert abs(lost(system, x, SLEIGH)).max() < 1e-14
    pivot = {None: None, "dx": np.sin(h) ** 2, "dy": np.cos(h) ** 2}[pivots and pivots["blade"]]
    if pivots:
        assert seen["pivot_blade"] == pytest.approx(pivot)


def test_a_pivot_that_vanishes_is_refused_and_another_is_not() -> None:
    along = [0.0, 0.0, 0.0, 1.0, 0.0, 0.5]  # heading 0: the blade leaves dx free
    with pytest.raises(st.StabilityError, match="constraint blade does not determine .* is 0\\.$"):
        sleigh(pivots={"blade": "dx"}).rates(along, SLEIGH)
    assert np.isfinite(sleigh(pivots={"blade": "dy"}).rates(along, SLEIGH)).all()
    assert np.isfinite(sleigh().rates(along, SLEIGH)).all()


def test_independent_velocities_leave_no_zero_of_the_constraint() -> None:
    """Straight running at heading 0 with every velocity as a state has one zero more."""
    reduced = sleigh(independent=("dx", "w"), ignorable=("x", "y"))
    assert reduced.states == ("h", "dx", "w")
    h, v, w = states(7, 3).T
    x = np.stack([h, v * np.cos(h), w], axis=-1)
    expected = sleigh_rates(h, v, w)
    assert reduced.rates(x, SLEIGH)[:, 1:] == pytest.approx(expected[:, [0, 2]], abs=1e-14)
    seen = reduced.observe(x, SLEIGH)
    assert seen["dy"] == pytest.approx(v * np.sin(h))
    assert seen["d_dy"] == pytest.approx(expected[:, 1])
    assert seen["pivot_dx"] == pytest.approx(SLEIGH[0] / np.cos(h) ** 2)  # dy = dx tan h
    assert seen["pivot_w"] == pytest.approx(SLEIGH[2] + SLEIGH[0] * SLEIGH[1] ** 2)
    values = dict(zip(("m", "a", "I"), SLEIGH, strict=True))
    rate = -SLEIGH[0] * SLEIGH[1] * 2 / (SLEIGH[2] + SLEIGH[0] * SLEIGH[1] ** 2)
    whole = sleigh(ignorable=("x", "y"))
    families = [
        st.Family(s, "straight", at=("dx",), held={n: 0.0 for n in s.states if n != "dx"})
        for s in (reduced, whole)
    ]
    for zeros, family in zip((2, 3), families, strict=True):
        found = st.spectrum(family, at=2.0, **values)
        assert found.structural_zeros == zeros
        assert found.eigenvalues == pytest.approx([rate])


def test_a_heading_that_the_rates_contain_is_not_ignorable() -> None:
    with pytest.raises(st.StabilityError, match="rate of dx changes with x, y, h"):
        sleigh(independent=("dx", "w"), ignorable=("x", "y", "h"))


# --- a rolling disk against SymPy's Kane method ---


def rolling_disk(**options: Any) -> st.System:
    """Units m = R = g = 1, moments k, k, 2k; the lowest point of a thin disk does not slip."""
    q = ca.vertcat(*symbols("x", "y", "z", "phi", "theta", "psi"))
    u = ca.vertcat(*symbols("dx", "dy", "dz", "dphi", "dtheta", "dpsi"))
    k = ca.SX.sym("k")
    cp, sp_, ct, st_ = ca.cos(q[3]), ca.sin(q[3]), ca.cos(q[4]), ca.sin(q[4])
    radius = ca.vertcat(cp * ct, sp_ * ct, -st_)
    axis = ca.vertcat(cp * st_, sp_ * st_, ct)
    level = ca.vertcat(-sp_, cp, 0)
    omega = u[3] * ca.SX([0, 0, 1]) + u[4] * level + u[5] * axis
    parts = [ca.dot(omega, e) for e in (radius, level, axis)]
    kinetic = (ca.sumsqr(u[:3]) + k * (parts[0] ** 2 + parts[1] ** 2 + 2 * parts[2] ** 2)) / 2
    return st.mechanics(
        q,
        u,
        k,
        kinetic=kinetic,
        potential=q[2],
        velocity_constraints=u[:3] + ca.cross(omega, radius),
        observables={"omega3": parts[2]},
        **options,
    )


@pytest.mark.few(1)
@pytest.mark.parametrize("options", [{}, {"independent": ("dphi", "dtheta", "dpsi")}])
def test_a_rolling_disk_is_that_of_sympys_kane_method(options: dict[str, Any]) -> None:
    k = 0.3
    theta, dtheta, dphi, omega3, phi = states(6, 5).T
    zero = np.zeros_like(theta)
    truth = kane(
        "rough",
        np.stack([theta, dtheta, dphi, omega3, zero, zero], -1),
        np.broadcast_to([k, 0.0], (6, 2)),
        phi,
    )
    dpsi = omega3 - dphi * np.cos(theta)
    radius = np.stack([np.cos(phi) * np.cos(theta), np.sin(phi) * np.cos(theta), -np.sin(theta)])
    axis = np.stack([np.cos(phi) * np.sin(theta), np.sin(phi) * np.sin(theta), np.cos(theta)])
    level = np.stack([-np.sin(phi), np.cos(phi), zero])
    omega = dphi * np.array([[0.0], [0.0], [1.0]]) + dtheta * level + dpsi * axis
    velocity = -np.cross(omega.T, radius.T)
    x = [zero, zero, np.sin(theta), phi, theta, zero]
    x += [] if options else list(velocity.T)
    x = np.stack([*x, dphi, dtheta, dpsi], axis=-1)
    system = rolling_disk(**options)
    rates = dict(zip(system.states, system.rates(x, [k]).T, strict=True))
    turn = rates["dpsi"] + rates["dphi"] * np.cos(theta) - dphi * dtheta * np.sin(theta)
    found = np.stack([dtheta, rates["dtheta"], rates["dphi"], turn], axis=-1)
    assert found == pytest.approx(truth.rates[:, :4], abs=1e-11)
    seen = system.observe(x, [k])
    assert seen["multiplier_3"] == pytest.approx(truth.normal_force, abs=1e-11)
    assert seen["energy"] == pytest.approx(truth.energy, abs=1e-13)
    assert seen["omega3"] == pytest.approx(omega3)
    assert abs(lost(system, x, [k])).max() < 1e-12


def test_rolling_straight_is_lost_at_the_published_speed() -> None:
    """Straight rolling is stable above omega3² = g/(3 R) for k = 1/4.

    Source: SymPy's rolling disc, sympy/physics/mechanics/tests/test_kane.py.
    """
    disk = rolling_disk(independent=("dphi", "dtheta", "dpsi"), ignorable=("x", "y", "phi", "psi"))
    held = {"z": 1.0, "theta": st.UPRIGHT, "dphi": 0.0, "dtheta": 0.0}
    family = st.Family(disk, "rolling", at=("dpsi",), held=held, typical={"k": 0.3})
    (edge,) = st.boundaries(family, axis=("dpsi", 0.2, 3, 20), k=0.25)
    assert edge.value == pytest.approx(np.sqrt(1 / 3), abs=1e-12)


# --- holonomic constraints ---


def hanging_mass(**options: Any) -> st.System:
    """A pendulum in Cartesian coordinates, y down."""
    q, u, p = (ca.vertcat(*symbols(*n)) for n in (("x", "y"), ("dx", "dy"), ("m", "l", "g")))
    return st.mechanics(
        q,
        u,
        p,
        kinetic=p[0] * ca.sumsqr(u) / 2,
        potential=-p[0] * p[2] * q[1],
        holonomic={"rod": (ca.sumsqr(q) - p[1] ** 2) / 2},
        **options,
    )


@pytest.mark.parametrize("options", [{}, {"pivots": {"rod": "dy"}}, {"independent": ("dx",)}])
def test_a_rod_pulls_as_newton_says(options: dict[str, Any]) -> None:
    m, length, g = p = [2.0, 1.5, 9.81]
    angle, rate = states(5, 2).T
    x = length * np.stack([np.sin(angle), np.cos(angle)], -1)
    dx = length * np.stack([np.cos(angle), -np.sin(angle)], -1) * rate[:, None]
    tension = m * (length * rate**2 + g * np.cos(angle))
    turn = -g / length * np.sin(angle)
    expected = turn[:, None] * dx / rate[:, None] - rate[:, None] ** 2 * x
    system = hanging_mass(**options)
    place = np.concatenate([x, dx[:, :1] if "independent" in options else dx], axis=1)
    rates = system.rates(place, p)
    assert rates[:, 2:] == pytest.approx(expected[:, : rates.shape[1] - 2], abs=1e-12)
    seen = system.observe(place, p)
    assert seen["multiplier_rod"] == pytest.approx(-tension / length)  # force = multiplier · (x, y)
    assert abs(seen["residual_rod"]).max() < 1e-15
    assert abs(seen["residual_rate_rod"]).max() < 1e-15
    longer = place * np.where(np.arange(place.shape[1]) < 2, 1.1, 1.0)
    assert system.observe(longer, p)["residual_rod"] == pytest.approx(0.105 * length**2)


@pytest.mark.parametrize(("options", "zeros"), [({}, 2), ({"independent": ("dx",)}, 1)])
def test_a_rod_leaves_as_many_zeros_as_the_docstring_says(
    options: dict[str, Any], zeros: int
) -> None:
    system = hanging_mass(**options)
    held = {n: 0.0 for n in system.states if n != "y"}
    family = st.Family(system, "hanging", at=("y",), held=held)
    found = st.spectrum(family, at=1.5, m=2.0, l=1.5, g=9.81)
    assert found.structural_zeros == zeros
    assert found.eigenvalues == pytest.approx(np.sqrt(9.81 / 1.5) * np.array([-1j, 1j]), abs=1e-12)


def test_a_moving_constraint_does_work() -> None:
    """A cart pulled at the speed c stretches a spring: the rope's power is k x c."""
    x, y, dx, dy, k, c = symbols("x", "y", "dx", "dy", "k", "c")
    cart = st.mechanics(
        ca.vertcat(x, y),
        ca.vertcat(dx, dy),
        ca.vertcat(k, c),
        kinetic=(dx**2 + dy**2) / 2,
        potential=k * x**2 / 2,
        velocity_constraints={"rope": dx - c},
    )
    seen = cart.observe([0.5, 0.0, 2.0, 1.0], [3.0, 2.0])
    assert float(seen["multiplier_rope"]) == pytest.approx(1.5)
    assert float(seen["power"]) == pytest.approx(-3.0)
    assert abs(lost(cart, np.array([[0.5, 0.0, 2.0, 1.0]]), [3.0, 2.0])).max() < 1e-15


def test_a_velocity_without_mass_is_solved_from_its_constraint() -> None:
    """A massless wheel turns with a cart: r n = v."""
    x, angle, v, n, r = symbols("x", "angle", "v", "n", "r")
    options = {"velocity_constraints": {"wheel": v - r * n}, "forces": {"n": 1.0}}
    args = ca.vertcat(x, angle), ca.vertcat(v, n), r
    with pytest.raises(st.StabilityError, match="mass matrix that is singular at every state"):
        st.mechanics(*args, kinetic=v**2 / 2, **options)
    cart = st.mechanics(*args, kinetic=v**2 / 2, pivots={"wheel": "n"}, **options)
    assert cart.rates([0, 0, 1, 2], [0.5]) == pytest.approx([1, 2, 2, 4])  # torque 1 / radius


# --- bad input ---


def refusal(**changes: Any) -> str:
    x, y, dx, dy, m, z = symbols("x", "y", "dx", "dy", "m", "z")
    given = {
        "q": ca.vertcat(x, y),
        "u": ca.vertcat(dx, dy),
        "p": m,
        "kinetic": m * (dx**2 + dy**2) / 2,
        "potential": x * y,
        "stranger": z,
    }
    table = {n: v(given) if callable(v) else v for n, v in changes.items()}
    given.pop("stranger")
    with pytest.raises(st.StabilityError) as caught:
        st.mechanics(**(given | table))
    return str(caught.value)


@pytest.mark.parametrize(
    ("changes", "said"),
    [
        ({"q": "x"}, "q is 'x'; give one column of symbols"),
        ({"q": ca.SX(0, 1)}, "q or u is empty"),
        ({"u": lambda g: g["u"][0]}, "q has 2 entries and u has 1"),
        ({"u": lambda g: g["q"]}, "names 'x' twice"),
        ({"p": lambda g: g["u"][0]}, "names 'dx' twice"),
        ({"kinetic": "much"}, "kinetic is 'much'; give a CasADi SX expression"),
        ({"kinetic": lambda g: g["u"]}, "kinetic has shape 2 x 1; give 1 x 1"),
        ({"kinetic": lambda g: g["stranger"] * g["kinetic"]}, "kinetic has the symbol z"),
        ({"kinetic": lambda g: g["u"][0] ** 2}, "singular at every state"),
        ({"kinetic": lambda g: ca.sum1(g["u"]) ** 2}, "singular at every state"),
        ({"kinetic": lambda g: g["u"][0] ** 2 - g["u"][1] ** 2}, "pivot for dy is -2"),
        ({"potential": lambda g: g["u"][0]}, "potential has the symbol dx, which is not in q or p"),
        ({"forces": lambda g: g["p"]}, "forces has shape 1 x 1; give 2 x 1"),
        ({"forces": {"x": 1.0}}, "forces is 'x'; known are dx, dy"),
        ({"velocity_constraints": lambda g: g["u"][0] ** 2}, "constraint 1 is not linear in u"),
        (
            {"velocity_constraints": lambda g: {"edge": ca.norm_2(g["u"])}},
            "edge is not linear in u",
        ),
        (
            {"velocity_constraints": lambda g: [g["stranger"]]},
            "velocity constraint 1 has the symbol z",
        ),
        ({"velocity_constraints": lambda g: [g["u"][0], 2 * g["u"][0]]}, "together are singular"),
        ({"velocity_constraints": lambda g: g["u"].T}, "velocity_constraints has 2 columns"),
        ({"holonomic": lambda g: g["u"][0]}, "holonomic constraint 1 has the symbol dx"),
        ({"holonomic": lambda g: g["p"]}, "together are singular"),
        (
            {
                "velocity_constraints": lambda g: {"a": g["u"][0]},
                "holonomic": lambda g: {"a": g["q"][1]},
            },
            "names 'a' twice",
        ),
        ({"q_dot": lambda g: g["u"] ** 2}, "q_dot is not linear in u"),
        ({"q_dot": lambda g: g["u"] + 1}, "q_dot is not linear in u without a free term"),
        ({"q_dot": lambda g: ca.vertcat(g["u"][0], g["u"][0])}, "q_dot does not determine u"),
        ({"q_dot": lambda g: g["u"][0]}, "q_dot has shape 1 x 1; give 2 x 1"),
        ({"independent": ("dx",)}, "independent names 1 velocities; give 2"),
        ({"independent": ("x", "dx")}, "independent is 'x'; known are dx, dy"),
        ({"velocity_constraints": lambda g: g["u"][0], "independent": ("dx",)}, "do not determine"),
        (
            {"velocity_constraints": lambda g: g["u"][0], "pivots": {"1": "dy"}},
            "cannot be solved for dy",
        ),
        (
            {"velocity_constraints": lambda g: g["u"][0], "pivots": {"2": "dy"}},
            "name each constraint",
        ),
        ({"velocity_constraints": lambda g: g["u"][0], "pivots": {"1": "x"}}, "known are dx, dy"),
        (
            {
                "velocity_constraints": lambda g: g["u"][0],
                "pivots": {"1": "dx"},
                "independent": ("dx",),
            },
            "give each velocity outside independent one constraint",
        ),
        ({"ignorable": ("x",)}, "the rate of dy changes with x"),
        ({"ignorable": ("dx",)}, "ignorable is 'dx'; known are x, y"),
        ({"observables": {"energy": 1.0}}, "names 'energy' twice"),
        ({"observables": lambda g: {"seen": g["stranger"]}}, "observable seen has the symbol z"),
        ({"conditions": 3}, "conditions is 3; give a tuple"),
        (
            {"conditions": lambda g: [st.Condition(g["stranger"], "no")]},
            "a condition has the symbol z",
        ),
        ({"name": ""}, "name of the system is ''"),
    ],
)
def test_bad_input_is_refused_in_one_sentence(changes: dict[str, Any], said: str) -> None:
    found = refusal(**changes)
    assert said in found
    assert found.endswith(".") and "\n" not in found


def test_too_few_velocities_on_no_surface_are_refused() -> None:
    """A knife edge by two velocities: q_dot alone would hide the force of the blade."""
    q, u = ca.vertcat(*symbols("x", "y", "h")), ca.vertcat(*symbols("v", "w"))
    rates = ca.vertcat(ca.cos(q[2]) * u[0], ca.sin(q[2]) * u[0], u[1])
    with pytest.raises(st.StabilityError, match="q_dot is no motion on a surface"):
        st.mechanics(q, u, q_dot=rates, kinetic=ca.sumsqr(u))
