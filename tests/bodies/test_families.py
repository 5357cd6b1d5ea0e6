"""Families: found by the root-finder, followed by continuation, complete, refused with a reason."""

import casadi as ca
import numpy as np
import pytest
from proofs.search import search

import stability as st
from stability.bodies.contact_laws import LAWS

AT = {"rolling": 1.3, "spinning": 1.7, "tumbling": 0.6}
Q = {law: [0.3, 0.4] if cls.parameters else [0.3] for law, cls in LAWS.items()}


@pytest.mark.parametrize("family", AT)
def test_members_are_steady_under_every_law_and_reached_from_elsewhere(family: str) -> None:
    for law in LAWS:
        resolved, system = st.disk_family(family, law), st.disk_system(law)
        state = resolved.member([AT[family]], Q[law])
        assert np.abs(system.rates(state, Q[law])).max() < 1e-14, law
        force = system.observe(state, Q[law])["normal_force"]
        assert force == pytest.approx(1, abs=1e-14), law
        again = resolved.member([AT[family]], Q[law], guess=[2.3])
        assert np.abs(again - state).max() < 1e-12, law


def test_tumbling_obeys_phi_dot_squared_g_over_k_r_sin_theta() -> None:
    theta = np.linspace(1e-4, np.pi - 1e-4, 301)[:, None]
    for k in (1e-3, 0.25, 0.5):
        state = st.disk_family("tumbling", "viscous").member(theta, [k, 0.3])
        assert state[:, 2] == pytest.approx(1 / np.sqrt(k * np.sin(theta[:, 0])), rel=1e-14)


@pytest.mark.parametrize(("k", "theta", "phi_dot"), [(0.25, 1.2, 0.5), (0.5, 0.3, 2.0)])
def test_circling_solves_the_published_equation(k: float, theta: float, phi_dot: float) -> None:
    """Le Saux, Leine & Glocker 2005: the balance of moments about the contact point."""
    spin = st.disk_family("circling", "rough").member([theta, phi_dot], [k])[3]
    left = (2 * k + 1) * spin * phi_dot * np.sin(theta)
    assert left == pytest.approx(np.cos(theta) * (k * phi_dot**2 * np.sin(theta) - 1), rel=1e-13)


def test_circling_with_omega3_zero_is_tumbling_and_upright_limit_is_rolling() -> None:
    theta, k = 0.8, 0.25
    phi_dot = 1 / np.sqrt(k * np.sin(theta))
    circling = st.disk_family("circling", "rough").member([theta, phi_dot], [k])
    assert abs(circling[3]) < 1e-14


# --- continuation ---


def test_continuation_follows_tumbling_almost_flat_and_through_upright() -> None:
    run = st.branch(st.disk_family("tumbling", "viscous"), 1e-3, np.pi - 1e-3, [0.25, 0.3])
    assert run.complete
    assert run.state[:, 2] == pytest.approx(1 / np.sqrt(0.25 * np.sin(run.at)), rel=1e-13)


def test_continuation_says_where_and_why_it_ends() -> None:
    """x² = a exists for a > 0 only: the branch to -1 ends at the fold."""
    x, a = ca.SX.sym("x"), ca.SX.sym("a")
    system = st.System("fold", x, a, a - x**2, states=("x",), parameters=("a",))
    fold = st.Family(system, "fold", at=("a",), unknown={"x": 1.0}, equations=("x",))
    run = st.branch(fold, 1.0, -1.0, [], points=41)
    assert not run.complete
    assert 0 <= run.at[-1] < 0.06
    assert "ended after" in run.ended
    assert run.state[:, 0] == pytest.approx(np.sqrt(run.at), abs=1e-12)


def test_continuation_of_circling_keeps_the_second_parameter() -> None:
    run = st.branch(st.disk_family("circling", "rough"), 1.0, 1.4, [0.25], fixed=[0.7], points=9)
    assert run.complete
    assert np.all(run.state[:, 2] == 0.7)


def test_tangent_is_the_derivative_of_the_member() -> None:
    for name, at in (("tumbling", 0.7), ("rolling", 1.1)):
        family = st.disk_family(name, "viscous")
        q = np.array([[0.3, 0.4]])
        tangents = []
        for step in (1e-3, 5e-4):
            ends = [family.member([at + s * step], q[0]) for s in (1, -1)]
            tangents.append((ends[0] - ends[1]) / (2 * step))
        a = np.array([[at]])
        exact = family.tangent(a, family.solve(a, q), q)[0, :, 0]
        errors = [np.abs(t - exact).max() for t in tangents]
        assert errors[1] < 1e-5
        if errors[0] > 1e-10:  # the order of the difference is two
            assert errors[0] / errors[1] == pytest.approx(4, rel=0.01)


# --- completeness ---


@pytest.mark.parametrize("law", ["viscous", "linear-viscous"])
def test_multi_start_search_finds_all_three_families_and_no_other(law: str) -> None:
    found = search(6000, law=law)
    assert found.outside == 0
    assert min(found.found.values()) > 100


# --- impossible requests ---


@pytest.mark.parametrize("theta", [0.0, np.pi, -0.2, 4.0])
def test_tumbling_flat_is_refused_with_the_reason(theta: float) -> None:
    with pytest.raises(st.StabilityError, match="strictly between 0 and π"):
        st.spectrum("tumbling", at=theta, contact=st.Viscous(0.3))


def test_rough_circling_without_precession_is_refused() -> None:
    with pytest.raises(st.StabilityError, match="no admissible isolated solution"):
        st.spectrum("circling", at=(1.2, 0.0), contact=st.Rough())


def test_circling_under_a_law_that_slips_is_refused() -> None:
    with pytest.raises(st.StabilityError, match="family of the rough disk"):
        st.spectrum("circling", at=(1.2, 0.5), contact=st.Viscous(0.3))


def test_a_family_that_is_not_steady_is_refused() -> None:
    x, a = ca.SX.sym("x", 2), ca.SX.sym("a")
    system = st.System("drift", x, a, ca.vertcat(a - x[0], 1), states=("x", "y"), parameters=("a",))
    family = st.Family(
        system, "drift", at=("a",), held={"y": 0.0}, unknown={"x": 0.0}, equations=("x",)
    )
    with pytest.raises(st.StabilityError, match="is not steady: y still changes at 1"):
        family.member([0.5], [])


@pytest.mark.parametrize(
    ("changes", "sentence"),
    [
        ({"at": ("nothing",)}, "neither a state nor a parameter"),
        ({"held": {"angle": 0.0}}, "given 0 times"),
        ({"held": {"angle": 0.0, "rate": 0.0, "mass": 1.0}}, "state is 'mass'"),
        ({"equations": ("rate",)}, "0 unknowns and 1 equations"),
    ],
)
def test_a_family_that_does_not_fit_its_system_is_refused(changes: dict, sentence: str) -> None:
    x, p = ca.SX.sym("x", 2), ca.SX.sym("p")
    system = st.System(
        "pendulum",
        x,
        p,
        ca.vertcat(x[1], -p * ca.sin(x[0])),
        states=("angle", "rate"),
        parameters=("g",),
    )
    given = {"at": ("g",), "held": {"angle": 0.0, "rate": 0.0}} | changes
    with pytest.raises(st.StabilityError, match=sentence):
        st.Family(system, "hanging", **given)


def test_a_root_that_is_not_proved_is_not_handed_out() -> None:
    """x² = a has no real root for a < 0; Newton's last iterate must not pass for one."""
    from flint import arb

    from stability.algebra.number_types import precision
    from stability.systems.structure.enclosure import ball_unknowns

    x, a = ca.SX.sym("x"), ca.SX.sym("a")
    system = st.System("fold", x, a, a - x**2, states=("x",), parameters=("a",))
    fold = st.Family(system, "fold", at=("a",), unknown={"x": 1.0}, equations=("x",))
    with precision(128):
        [root] = ball_unknowns(fold, [arb(2)], [], [1.4142136])
        assert root.contains(arb(2).sqrt())
        assert root.rel_accuracy_bits() > 60
        for value in (-1e-30, -1.0, 0.0):
            with pytest.raises(st.StabilityError, match="no root is proved"):
                ball_unknowns(fold, [arb(value)], [], [1e-9])
        with pytest.raises(st.StabilityError, match="no root is proved"):
            ball_unknowns(fold, [arb(2)], [], [1e-3])  # Newton's method ends at another place
