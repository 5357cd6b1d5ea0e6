"""Families of a body of revolution: closed forms, steadiness, and a search for others."""

import math
from dataclasses import replace

import casadi as ca
import numpy as np
import pytest
from scipy.optimize import fsolve

import stability as st
from stability.bodies.contact_laws import LAWS
from stability.bodies.round_body.equations import round_system
from stability.bodies.round_body.families import round_family
from stability.bodies.round_body.inclinations import level, tumbling_ranges

EGG = st.Body(
    lambda theta, a, b: 1 + a * ca.cos(theta) + b * ca.cos(2 * theta) + 0.01 * ca.cos(3 * theta),
    axial=0.3, transverse=0.4, shape={"a": 0.1, "b": 0.08}, name="egg",
)  # fmt: skip
BODIES = (st.Torus(0.2), st.Spheroid(0.4), st.Spheroid(1.7), st.EccentricSphere(0.2), EGG,
          st.ThickDisk(0.3))  # fmt: skip


def _numbers(body: st.Body, mu: float) -> dict[str, float]:
    axial, transverse = body.moments()
    return {"axial": axial, "transverse": transverse, "mu": mu} | dict(body.shape)


def _tumbles(body: st.Body, theta: float) -> tuple[float, float] | None:
    """phi_dot and omega3 of tumbling by the closed form, from h and h' as numbers."""
    h, slope = body.height_at(theta), body.height_at(theta, 1)
    axial, transverse = body.moments()
    s, c = math.sin(theta), math.cos(theta)
    r, z = h * s + slope * c, h * c - slope * s
    square = slope * r / (s * (transverse * r * c - axial * z * s))
    return (math.sqrt(square), math.sqrt(square) * s * z / r) if square > 0 else None


@pytest.mark.parametrize("law", LAWS)
@pytest.mark.parametrize("body", BODIES, ids=lambda b: b.name)
def test_tumbling_has_the_closed_form_and_is_steady(body: st.Body, law: str) -> None:
    given = ("mu",) if LAWS[law].parameters else ()
    family = round_family(body, "tumbling", LAWS[law], given, physical=False)
    p = [_numbers(body, 0.4)[n] for n in family.parameters]
    low, high = body.between
    met = 0
    for theta in np.linspace(low, high, 14)[1:-1]:  # never upright
        known = _tumbles(body, float(theta))
        if known is None:
            with pytest.raises(st.StabilityError):
                family.member([theta], p)
            continue
        state = family.member([theta], p)
        assert state[2:4] == pytest.approx(known, rel=1e-9)
        assert np.abs(family.system.rates(state, p)).max() < 1e-9
        met += 1
    assert met or body.name == "eccentric sphere"


@pytest.mark.parametrize(("thickness", "theta"), [(0.2, 1.0), (0.2, 0.3), (0.8, 0.5), (0.8, 1.3)])
def test_a_thick_disk_tumbles_whatever_its_thickness(thickness: float, theta: float) -> None:
    """Sizes at which structure is sampled are those of the body: at thickness 1 there is none."""
    body = st.ThickDisk(thickness)
    assert _tumbles(body, theta) is not None
    found = st.spectrum("tumbling", at=theta, body=body, contact=st.Viscous(0.3))
    assert found.structural_zeros == 1
    assert found.states[2:4] == pytest.approx(_tumbles(body, theta), rel=1e-9)


def test_a_body_tumbles_in_the_ranges_of_the_closed_form() -> None:
    for body in (st.Torus(0.3), st.Spheroid(1.7), st.EccentricSphere(0.2), st.ThickDisk(0.8)):
        ranges = tumbling_ranges(body)
        assert ranges
        low, high = body.between
        for theta in np.linspace(low, high, 40)[1:-1]:
            if min(abs(theta - end) for pair in ranges for end in pair) < 0.01:
                continue
            inside = any(a < theta < b for a, b in ranges)
            assert inside == (_tumbles(body, float(theta)) is not None), (body.name, theta)
    ball = st.Body(lambda _: 1.0, axial=0.4, transverse=0.4, name="ball")
    assert tumbling_ranges(ball) == []


def test_rolling_leans_where_the_height_has_its_flat_points() -> None:
    assert level(st.Torus(0.2)) is None
    thick = st.ThickDisk(0.3)
    assert level(thick) == pytest.approx(math.atan(2 / 0.3), rel=1e-14)
    family = round_family(thick, "rolling", LAWS["viscous"], ("mu",), physical=False)
    state = family.member([1.3], [0.3, 0.5])
    assert state[0] == pytest.approx(math.atan(2 / 0.3), rel=1e-14)
    assert np.abs(family.system.rates(state, [0.3, 0.5])).max() < 1e-14
    lean = st.Body(lambda t: 1 + 0.08 * ca.cos(4 * t) / 2, axial=0.3, transverse=0.3, name="knob")
    with pytest.raises(st.StabilityError, match="give theta="):
        level(st.Body(lambda t: 1 + 0.02 * ca.cos(3 * t), axial=0.3, transverse=0.3))
    assert level(lean) is None
    assert level(lean, 0.8) == pytest.approx(math.pi / 4)


@pytest.mark.parametrize("body", BODIES, ids=lambda b: b.name)
def test_no_other_steady_motion_is_found(body: st.Body) -> None:
    """Roots of all rates from random starts are rolling, spinning or tumbling, and slip nowhere."""
    system = round_system(body, LAWS["viscous"], ("mu",), physical=False)
    p = [_numbers(body, 0.4)[n] for n in system.parameters]
    rhs = ca.Function("rates", [system.x, system.p], [system.rhs])
    rng = np.random.default_rng(5)
    low, high = body.between
    seen = 0
    for _ in range(150):
        pinned = rng.uniform(0.1, 3.0)
        start = [rng.uniform(low + 0.1, high - 0.1), *rng.normal(0, 1.0, 2), *rng.normal(0, 0.3, 2)]

        def rates(y: np.ndarray, spin: float = pinned) -> np.ndarray:
            theta, phi_dot, omega3, vx, vy = y
            state = [theta, 0.0, phi_dot, omega3, vx, vy]
            found = np.asarray(rhs(state, p)).ravel()
            return np.array([*found[[1, 4, 5]], found[3], phi_dot**2 + omega3**2 - spin**2])

        with np.errstate(all="ignore"):
            y, _, done, _ = fsolve(rates, start, full_output=True, xtol=1e-13)
        if done != 1 or not low + 1e-3 < y[0] < high - 1e-3 or np.abs(rates(y)).max() > 1e-11:
            continue
        theta, phi_dot, omega3, vx, vy = y
        seen += 1
        assert np.hypot(vx, vy) < 1e-6
        slope = body.height_at(theta, 1)
        known = _tumbles(body, theta)
        rolls = abs(phi_dot) < 1e-6 and abs(slope) < 1e-6
        spins = abs(theta - math.pi / 2) < 1e-5 and abs(omega3) < 1e-5 and abs(slope) < 1e-5
        tumbles = (
            known is not None
            and abs(abs(phi_dot) - known[0]) < 1e-5 * known[0]
            and (abs(omega3 * math.copysign(1, phi_dot) - known[1]) < 1e-5 * (1 + abs(known[1])))
        )
        assert rolls or spins or tumbles, (body.name, y)
    assert seen > 5


@pytest.mark.parametrize(
    ("body", "theta"),
    [
        # random members next to this one rest at no such inclination
        (replace(st.Egg(0.2), axial=0.2), 1.6),
        # at the middle of its numbers the contact point is below the centre, at every rate of turn
        (replace(st.ThickDisk(1.88), axial=0.1638, transverse=0.1644), 1.154),
    ],
)
@pytest.mark.parametrize("law", ["rough", "smooth", "viscous"])
def test_a_member_is_not_refused_for_others_that_do_not_exist(
    body: st.Body, theta: float, law: str
) -> None:
    """What is established at random members is established where there are some."""
    mu = {"mu": 0.3} if law == "viscous" else {}
    found = st.spectrum("tumbling", at=theta, contact=law, body=body, certify=True, **mu)
    system = found.family.system
    jacobian = ca.Function("J", [system.x, system.p], [ca.densify(system.jacobian)])
    known = body.given | mu
    true = np.linalg.eigvals(
        np.asarray(jacobian(found.states, [known[n] for n in system.parameters]))
    )
    left = true[np.argsort(np.abs(true))][found.structural_zeros :]
    assert abs(left.real.max() - found.abscissa) < 1e-6 * np.abs(true).max()
    assert (found.verdict is st.Verdict.UNSTABLE) == (found.abscissa > 1e-6)
