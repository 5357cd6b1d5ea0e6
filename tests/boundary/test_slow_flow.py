"""Slow drift under resistance: energy balances, integrated motions with their order, refusals."""

import math

import casadi as ca
import numpy as np
import pytest
from scipy.integrate import solve_ivp

import stability as st

DISK = st.Body(lambda t: ca.sin(t), axial=0.5, transverse=0.25, name="thin disk")
KINDS = (st.RollingResistance, st.PivotingResistance, st.AirTorque)


@pytest.mark.few(2)
@pytest.mark.parametrize("body", [DISK, st.Spheroid(0.5), st.Torus(0.2)], ids=lambda b: b.name)
@pytest.mark.parametrize("kind", KINDS, ids=lambda k: k.coefficient)
def test_rates_are_those_of_the_energy(body: st.Body, kind: type[st.Resistance]) -> None:
    """With the centre at rest or rolling, E(y) and the lost power give dy/dt = -P/E'(y)."""
    axial, across = body.moments()

    def motion(family: str, y: float) -> tuple[float, np.ndarray]:
        """Energy, and angular velocity (level², vertical²) of a member."""
        if family == "rolling":
            h = body.height_at(math.pi / 2)
            return (axial + h**2) * y**2 / 2, np.array([y**2, 0.0])
        if family == "spinning":
            return across * y**2 / 2, np.array([0.0, y**2])
        h, slope, s, c = body.height_at(y), body.height_at(y, 1), math.sin(y), math.cos(y)
        r, z = h * s + slope * c, h * c - slope * s
        phi_dot = math.sqrt(slope * r / (s * (across * r * c - axial * z * s)))
        one, three = -phi_dot * s, phi_dot * s * z / r
        level, up = one * c + three * s, three * c - one * s
        return h + (across * one**2 + axial * three**2) / 2, np.array([level**2, up**2])

    share = {"rho": [1, 0], "sigma": [0, 1], "drag": [1, 1]}[kind.coefficient]
    for family, at in (("rolling", 3.0), ("spinning", 3.0), ("tumbling", 0.7)):
        flow = st.slow_flow(family, body=body, contact=st.Viscous(0.5), resistance=kind(0.01))
        step = 1e-5
        gain = (motion(family, at + step)[0] - motion(family, at - step)[0]) / (2 * step)
        lost = 0.01 * float(np.dot(share, motion(family, at)[1]))
        assert flow.rate(at) == pytest.approx(-lost / gain, rel=1e-8, abs=1e-15)


@pytest.mark.few(1)
@pytest.mark.parametrize(
    ("family", "at", "kind"),
    [
        ("rolling", 3.0, st.RollingResistance),
        ("tumbling", 0.7, st.AirTorque),
        ("tumbling", 0.7, st.PivotingResistance),
    ],
)
def test_integrated_motions_follow_with_an_error_of_first_order(
    family: str, at: float, kind: type[st.Resistance]
) -> None:
    flow = st.slow_flow(
        family, body=st.Spheroid(0.5), contact=st.Viscous(0.5), resistance=kind(1.0)
    )
    system = flow.disturbed
    rhs = ca.Function("rates", [system.x, system.p], [system.rhs])
    index, gaps = system.states.index(flow.family.at[0]), []
    for small in (4e-3, 1e-3):
        start = flow.family.member([at], [flow.numbers[n] for n in flow.family.parameters])
        p = [(flow.numbers | {flow.small: small})[n] for n in system.parameters]
        last = 0.1 / small / abs(flow.rate(at))
        full = solve_ivp(
            lambda _, x, p=p: np.array(rhs(x, p)).ravel(),
            (0, last),
            start,
            method="LSODA",
            rtol=1e-9,
            atol=1e-11,
        )
        slow = solve_ivp(
            lambda _, y, small=small: [small * flow.rate(float(y[0]))], (0, last), [at], rtol=1e-8
        )
        assert abs(slow.y[0, -1] - at) > 0.05
        gaps.append(abs(full.y[index, -1] - slow.y[0, -1]))
    assert gaps[0] < 0.02
    assert gaps[0] / gaps[1] == pytest.approx(4, rel=0.35)


def test_a_falling_disk_takes_for_ever_under_linear_laws() -> None:
    """Near flat ω² is of first order in θ for level turning, of third for turning on the spot."""
    for kind, power in zip(KINDS, (1, 3, 1), strict=True):
        flow = st.slow_flow("tumbling", body=DISK, contact=st.Viscous(0.5), resistance=kind(0.1))
        assert flow.exponent(0.0, 0.02) == pytest.approx(power, abs=1e-3)
    slow = st.slow_flow(
        "rolling", body=DISK, contact=st.Viscous(0.5), resistance=st.RollingResistance(0.01)
    )
    assert slow.time(3.0, 1.5) == pytest.approx(1.5 / 0.01 * math.log(2), rel=1e-9)


def test_families_that_survive_keep_spectra_and_others_are_refused() -> None:
    body, law = st.Spheroid(0.5), st.Viscous(0.3)
    for family, at, lives in (
        ("rolling", 2.0, "sigma"),
        ("spinning", 3.0, "rho"),
        ("vertical", 3.0, "rho"),
        ("tumbling", 0.7, ""),
    ):
        for kind in KINDS:
            given = {"at": at, "body": body, "contact": law, "resistance": kind(0.02)}
            if kind.coefficient == lives:
                found = st.spectrum(family, certify=True, **given)
                bare = st.spectrum(family, certify=True, **given | {"resistance": None})
                assert found.verdict.word in ("stable", "unstable")
                assert np.abs(found.eigenvalues[0] - bare.eigenvalues[0]) > 1e-4
            else:
                with pytest.raises(st.StabilityError, match=f"{family} of spheroid does not sur"):
                    st.spectrum(family, **given)


def test_a_system_of_ones_own_drifts_too() -> None:
    """X' = v, v' = -v + c: the line v = 0 drifts at the rate c."""
    x, c = ca.SX.sym("x", 2), ca.SX.sym("c")
    cart = st.System(
        "cart", x, c, ca.vertcat(x[1], -x[1] + c * x[0]), states=("q", "v"), parameters=("c",)
    )
    rest = st.Family(cart, "rest", at=("q",), held={"v": 0.0})
    flow = st.slow_flow(rest, small="c", c=0.1)
    assert flow.rate(2.0) == pytest.approx(0.2, rel=1e-14)
    assert flow.time(1.0, math.e) == pytest.approx(10.0, rel=1e-9)
    with pytest.raises(st.StabilityError, match="does not lead to"):
        flow.time(2.0, 1.0)


def test_a_number_of_the_system_that_is_missing_is_named() -> None:
    x, p = ca.SX.sym("x", 2), ca.SX.sym("p", 2)
    cart = st.System(
        "cart",
        x,
        p,
        ca.vertcat(x[1], -p[0] * x[1] + p[1]),
        states=("q", "v"),
        parameters=("drag", "c"),
    )
    rest = st.Family(cart, "rest", at=("q",), held={"v": 0.0})
    with pytest.raises(st.StabilityError, match="drag of rest is missing"):
        st.slow_flow(rest, small="c", c=0.1)


@pytest.mark.parametrize(
    ("given", "words"),
    [
        ({"family": "rolling", "resistance": None}, "resistance is missing"),
        ({"family": "rolling", "body": None}, "body is missing|known"),
        ({"family": "rolling", "resistance": 0.1}, "resistance is 0.1; give RollingResistance"),
    ],
)
def test_what_has_no_drift_is_refused(given: dict, words: str) -> None:  # type: ignore[type-arg]
    arguments = {"body": DISK, "contact": st.Viscous(0.3), "resistance": st.AirTorque(0.1)} | given
    with pytest.raises(st.StabilityError, match=words):
        st.slow_flow(**arguments)
    with pytest.raises(st.StabilityError, match="rho is -1"):
        st.RollingResistance(-1.0)
