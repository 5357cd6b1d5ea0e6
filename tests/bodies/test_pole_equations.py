"""The chart that is regular at the poles: against the chart of angles, and the tippe top."""

import math

import casadi as ca
import numpy as np
import pytest

import stability as st
from stability.bodies.contact_laws import LAWS
from stability.bodies.round_body.equations import round_system
from stability.bodies.round_body.pole_equations import pole_system, smooth_at

BODIES = (
    st.Spheroid(0.6),
    st.EccentricSphere(0.2),
    st.Body(
        lambda t, a: 1 + a * ca.cos(3 * t) + ca.sin(t) ** 4 / 9 + ca.cos(-t) / 50,
        axial=0.3,
        transverse=0.35,
        shape={"a": 0.02},
        name="egg",
    ),
)


def _frame(x: np.ndarray) -> tuple[np.ndarray, ...]:
    """x̂, ŷ, 1̂ and 3̂ along fixed axes, for a heading that is chosen freely."""
    s, c, heading = math.sin(x[0]), math.cos(x[0]), 0.3
    along = np.array([math.cos(heading), math.sin(heading), 0.0])
    across, up = np.array([-along[1], along[0], 0.0]), np.array([0.0, 0.0, 1.0])
    return along, across, c * along - s * up, s * along + c * up


@pytest.mark.few(3)
@pytest.mark.parametrize("law", LAWS)
@pytest.mark.parametrize("body", BODIES, ids=lambda b: b.name)
def test_both_charts_have_the_same_rates_forces_and_energy(body: st.Body, law: str) -> None:
    given = ("mu",) if LAWS[law].parameters else ()
    angles = round_system(body, LAWS[law], given, physical=True)
    fixed = pole_system(body, LAWS[law], given, physical=True)
    rng = np.random.default_rng(1)
    numbers = dict(body.shape) | {"mass": 1.7, "gravity": 9.81, "length": 0.3, "mu": 0.3}
    numbers |= dict(zip(("axial", "transverse"), body.moments(), strict=True))
    p = [numbers[n] for n in angles.parameters]
    for _ in range(20):
        x = np.array([rng.uniform(0.3, 2.8), *rng.normal(0, 2, 3), *rng.normal(0, 0.1, 2)])
        x = x[: len(angles.states)]
        rates = angles.rates(x, p)
        along, across, one, three = _frame(x)
        s, c, (theta_dot, phi_dot, omega3) = math.sin(x[0]), math.cos(x[0]), x[1:4]
        parts = np.array([-phi_dot * s, theta_dot, omega3])
        base = np.array([one, across, three])
        turn = parts @ base
        # ω̇ from the rates of its components in a frame that itself turns
        slopes = [-rates[2] * s - phi_dot * c * theta_dot, rates[1], rates[3]]
        own = phi_dot * np.array([0, 0, 1.0]) + theta_dot * across
        true = np.array(slopes) @ base + np.cross(own, turn)
        y = np.concatenate([three, turn])
        if LAWS[law].slips:
            slip = x[4] * along + x[5] * across
            y = np.concatenate([y, slip[:2]])
            moved = rates[4] * along + rates[5] * across + np.cross([0, 0, phi_dot], slip)
            true = np.concatenate([true, moved[:2]])
        found = fixed.rates(y, p)
        assert found[:3] == pytest.approx(np.cross(turn, three), abs=1e-14)
        assert found[3:] == pytest.approx(true, abs=1e-12 * (1 + np.abs(true).max()))
        mine, other = fixed.observe(y, p), angles.observe(x, p)
        names = ["energy", "normal_force", "power"] + ["determinant"] * (law != "rough")
        for name in names:
            assert mine[name] == pytest.approx(other[name], rel=1e-12, abs=1e-13), name


@pytest.mark.few(4)
@pytest.mark.parametrize("pole", [0, "pi"])
@pytest.mark.parametrize("gamma", [0.85, 1.0, 1.15])
@pytest.mark.parametrize("offset", [0.1, 0.3])
def test_tippe_top_turns_over_by_its_known_thresholds(
    offset: float, gamma: float, pole: int | str
) -> None:
    """Upright spin is unstable above ω² = m g e (R-e)²/(A - C(1 - e/R)) R, if A/C > 1 - e/R.

    Inverted spin is stable above m g e (R+e)²/(C(1 + e/R) - A) R, if A/C < 1 + e/R: conditions of
    Ebenfeld & Scheck, Ann. Phys. 243 (1995) 195-217, here with moments A and C about the centre of
    mass; they hold for every mu.
    """
    axial = 0.4
    top = st.EccentricSphere(offset, axial=axial, transverse=gamma * axial)
    side = 1 if pole == 0 else -1
    below = side * (gamma * axial - axial * (1 - side * offset))
    for mu in (0.1, 2.0):
        found = st.boundaries(
            "vertical", axis=("at", 0.01, 40, 50), body=top, contact=st.Viscous(mu), pole=pole
        )
        assert found.complete
        if below <= 0:
            assert not found
            continue
        known = math.sqrt(offset * (1 - side * offset) ** 2 / below)
        [edge] = found
        assert edge.value == pytest.approx(known, rel=1e-13)
        assert edge.stable_below is (pole == 0)
        for factor in (1 - 1e-12, 1 + 1e-12):
            near = st.spectrum(
                "vertical",
                at=known * factor,
                body=top,
                contact=st.Viscous(mu),
                pole=pole,
                certify=True,
            )
            assert near.verdict.word == ("stable" if (factor < 1) == (pole == 0) else "unstable")


@pytest.mark.few(3)
@pytest.mark.parametrize("mu", [0.3, 3.0, 30.0])
@pytest.mark.parametrize("make", ["named", "own"])
def test_a_tippe_top_in_si_turns_over_at_the_numbers_of_the_literature(
    make: str, mu: float
) -> None:
    """S. Rauch-Wojciechowski and N. Rutstam, SIGMA 10 (2014) 017: m = R = 0.02, a = 0.3, g = 9.82.

    I3 = 2mR²/5, I1 = 131mR²/350 about the centre of mass; their threshold of Jellett's integral is
    sqrt(m g R³ I3 a) (1 + a)²/sqrt(1 + a - I1/I3).
    """
    given = {"axial": 2 / 5, "transverse": 131 / 350, "mass": 0.02, "length": 0.02, "gravity": 9.82}
    if make == "named":
        top = st.EccentricSphere(0.3, **given)
    else:
        top = st.Body(lambda theta: 1 - 0.3 * ca.cos(theta), name="own top", **given)
    for pole, known, stable_below in ((0, 27.667917094780, True), ("pi", 41.332688957659, False)):
        found = st.boundaries(
            "vertical", axis=("at", 0.1, 200, 50), body=top, contact=st.Viscous(mu), pole=pole
        )
        assert found.complete
        [edge] = found
        assert edge.value == pytest.approx(known, rel=1e-13)
        assert edge.stable_below is stable_below
        for side in (1 - 1e-12, 1 + 1e-12):
            near = st.spectrum(
                "vertical",
                at=edge.value * side,
                body=top,
                contact=st.Viscous(mu),
                pole=pole,
                certify=True,
            )
            assert near.verdict.word == ("stable" if (side < 1) == stable_below else "unstable")
    share = given["mass"] * given["length"] ** 2
    i3, a = 0.4 * share, 0.3
    jellett = i3 * given["length"] * (1 + a) * edge.value  # inverted: L·a at the pole
    weight = given["mass"] * given["gravity"] * given["length"] ** 3 * i3 * a
    threshold = math.sqrt(weight) * (1 + a) ** 2 / math.sqrt(1 + a - 131 / 140)
    assert jellett == pytest.approx(threshold, rel=1e-13)
    assert threshold == pytest.approx(3.438879721e-6, rel=1e-9)


def test_poles_of_bodies_that_are_not_smooth_there_are_refused() -> None:
    assert [smooth_at(b, 1) for b in (st.Torus(0.2), st.ThickDisk(0.1))] == [False, False]
    assert all(smooth_at(b, pole) for b in BODIES for pole in (1, -1))
    cone = st.Body(lambda t: 1 + 0.3 * ca.sin(t), axial=0.3, transverse=0.3, name="top")
    assert not smooth_at(cone, 1)
    with pytest.raises(st.StabilityError, match=r"torus is not smooth at theta = π"):
        st.spectrum("vertical", at=1.0, body=st.Torus(0.2), contact=st.Rough(), pole="pi")
    with pytest.raises(st.StabilityError, match="pole is 1; give 0 or 'pi'"):
        st.spectrum("vertical", at=1.0, body=BODIES[0], contact=st.Rough(), pole=1)
    with pytest.raises(st.StabilityError, match="pole belongs to vertical spin"):
        st.spectrum("rolling", at=1.0, body=BODIES[0], contact=st.Rough(), pole=0)


def test_a_law_with_directions_of_its_own_is_refused_at_a_pole() -> None:
    class Grooved(st.Contact):
        nu: float
        name = "grooved"
        parameters = (st.Parameter("nu", "s/m"),)

        def force(self, slip, normal, nu):  # type: ignore[no-untyped-def]
            return [-nu * normal * slip[0], -2 * nu * normal * slip[1]]

    with pytest.raises(st.StabilityError, match="depends on the direction of slip"):
        pole_system(BODIES[0], Grooved, ("nu",), physical=False)


def test_jellett_is_kept_by_a_sphere_at_every_state() -> None:
    """J = -L·a: its rate vanishes identically for h = 1 - e cos θ, under every law."""
    body = st.EccentricSphere(0.25)
    rng = np.random.default_rng(2)
    for law in LAWS:
        if law == "smooth":  # its slip is that of a centre at rest, which the chart leaves out
            continue
        given = ("mu",) if LAWS[law].parameters else ()
        system = pole_system(body, LAWS[law], given, physical=False)
        value = system.observables["jellett"]
        slope = ca.jacobian(value, system.x)
        f = ca.Function("f", [system.x, system.p], [slope @ system.rhs, ca.norm_1(slope.T)])
        for _ in range(10):
            axis = rng.normal(size=3)
            x = [*axis / np.linalg.norm(axis), *rng.normal(size=3), *rng.normal(0, 0.1, 2)]
            rate, size = f(x[: len(system.states)], [0.25, 0.3][: len(system.parameters)])
            assert abs(float(rate)) < 1e-13 * float(size)
