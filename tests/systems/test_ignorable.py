"""Ignorable states: found from the graph by proof, out of the spectrum, kept in motion."""

from typing import Any

import casadi as ca
import numpy as np
import pytest
from symmetric_systems import STRAIGHT, body, rolling_disc, sleigh, system, top_in_space

import stability as st
from stability import Nonlinear, Verdict
from stability.base.errors import NoMemberError, ParameterError

SLEIGH = {"m": 1.0, "a": 0.3, "I": 0.2}


def test_heading_wheel_angle_and_place_are_ignorable() -> None:
    assert rolling_disc(place=False).ignorable == ("q1", "q3")
    assert rolling_disc(place=True).ignorable == ("q1", "q3", "px", "py")
    assert sleigh().ignorable == ("heading", "px", "py")
    assert body().ignorable == ()
    assert top_in_space().system.ignorable == ()
    assert st.disk_system("viscous").ignorable == ()


@pytest.mark.parametrize(
    ("rates", "wanted"),
    [
        (lambda x, _: (x[1], ca.SX(0), -x[2]), ("a",)),  # a constant is no coordinate in motion
        (lambda x, _: (x[1], x[0], -x[2]), ()),  # a cycle
        (lambda x, _: (x[1], -x[1], x[0] - x[2]), ()),  # a acts on c, which acts on itself
        (lambda x, _: (x[1] * 0 + 1, x[2], -x[2]), ("a", "b")),
        (lambda x, p: (p, x[0] + x[2], -x[2]), ("a", "b")),  # a chain
        (lambda x, p: ((p + 1) ** 2 - p * p - 2 * p - 1, x[0], -x[2]), ("b",)),  # a hidden zero
        # the graph holds a, and the rate does not depend on it
        (lambda x, _: (x[2], x[2], -x[2] * ((x[0] + 1) * (x[0] - 1) - x[0] ** 2 + 3)), ("a", "b")),
        (lambda x, _: (x[2], x[2], x[2] * ca.sqrt(x[0] ** 2) / x[0] - 2 * x[2]), ("b",)),  # a sign
        (lambda x, _: (x[2], x[2], -x[2] + 1e-300 * x[0]), ("b",)),
        (lambda x, _: (x[2], x[2], -x[2] * (1 + 1e-9 * ca.exp(-(x[0] ** 2)))), ("b",)),
        (lambda x, _: (x[2], x[2], -x[2] * ca.floor(x[0] + 2)), ("b",)),
        (lambda x, _: (x[2], x[2], -x[2] * ca.if_else(x[0] > 100, 2, 1)), ("b",)),
    ],
)
def test_independence_is_proved_and_never_sampled(rates: Any, wanted: tuple[str, ...]) -> None:
    assert system("small", "abc", ("p",), rates).ignorable == wanted


def test_a_condition_makes_a_state_count() -> None:
    x, p = ca.SX.sym("x", 2), ca.SX.sym("p")
    plain = st.System("road", x, p, ca.vertcat(x[1], -x[1]), ("place", "speed"), ("p",))
    assert plain.ignorable == ("place",)
    ends = (st.Condition(10 - x[0], "the road ends"),)
    road = st.System(
        "road", x, p, ca.vertcat(x[1], -x[1]), ("place", "speed"), ("p",), conditions=ends
    )
    assert road.ignorable == ()


def test_a_family_may_leave_them_out_and_they_move() -> None:
    """A disc that rolls straight or in a circle turns its wheel; only its place is not steady."""
    wheel = rolling_disc(place=True)
    straight = st.Family(wheel, "straight", at=("u2",), held=STRAIGHT)
    small = st.Family(rolling_disc(place=False), "straight", at=("u2",), held=STRAIGHT)
    for u2, word in ((0.5, "unstable"), (0.6, "neutral")):
        found = st.spectrum(straight, at=u2, r=1.0, g=1.0, certify=True)
        assert found.verdict.word == word
        assert found.structural_zeros == 4 + 2  # the family, its turn, and four ignorable states
        less = st.spectrum(small, at=u2, r=1.0, g=1.0, certify=True)
        assert (less.eigenvalues == found.eigenvalues).all()
        assert "q1, q3, px, py are ignorable" in found.reason
        # λ² = (12 g/r - ... u2²)/5 changes its sign at u2² = g/(3 r): SymPy's own threshold
        assert found.eigenvalues[0] ** 2 == pytest.approx(0.8 - 2.4 * u2**2, rel=1e-14)
    circle = st.Family(
        wheel, "circle", at=("q2", "u3"), held={"u1": 0.0}, unknown={"u2": 1.0}, equations=("u1",)
    )
    assert st.spectrum(circle, at=[0.3, 0.5], r=1.0, g=1.0, certify=True).structural_zeros == 6
    modes = st.spectrum(straight, at=0.6, r=1.0, g=1.0).modes
    assert modes.vectors.shape == (2, 8) and np.isfinite(modes.vectors).all()


def test_the_sleigh_runs_straight_or_turns_around_for_every_heading() -> None:
    """Straight runs attract at the rate -m a v/(I + m a²): asymptotic, without dissipation."""
    runs = st.Family(sleigh(), "run", at=("v",), held={"w": 0.0})
    found = st.spectrum(runs, at=2.0, **SLEIGH, certify=True)
    assert found.eigenvalues.tolist() == [pytest.approx(-0.6 / 0.29, rel=1e-15)]
    assert found.structural_zeros == 4
    assert found.nonlinear is Nonlinear.ASYMPTOTIC  # one zero along v, three of ignorable states
    assert st.spectrum(runs, at=-2.0, **SLEIGH, certify=True).verdict is Verdict.UNSTABLE
    [point] = st.boundaries(runs, axis=("v", -1, 1, 4), **SLEIGH)
    assert point.value == 0.0 and not point.stable_below


def test_motion_keeps_them() -> None:
    """V∞² = v0² + (I + m a²) w0²/m; the heading turns, and the place moves on."""
    model = sleigh()
    runs = st.Family(model, "run", at=("v",), held={"w": 0.0})
    start = {"v": 1.0, "w": 0.05, "heading": 0.3, "px": 7.0, "py": 0.0}
    run = st.simulate(model, SLEIGH, start, 25.0, families=runs, check=False)
    last = {n: float(run[n].values[..., -1]) for n in model.states}
    assert last["v"] == pytest.approx((1 + 0.29 * 0.05**2) ** 0.5, rel=1e-8)
    assert last["px"] > 25 and last["heading"] > 0.3
    assert run.attrs["outcome"] != "settled"  # places that move on are not proved to converge


def test_what_cannot_be_left_out_is_named() -> None:
    wheel = rolling_disc(place=True)
    with pytest.raises(ParameterError, match="leaves q1 out, but the rate of px depends on it"):
        st.Family(wheel, "x", at=("u2",), held={**STRAIGHT, "px": 0.0, "py": 0.0, "q3": 0.0})
    with pytest.raises(ParameterError, match="state 'u3' of family x is given 0 times"):
        st.Family(wheel, "x", at=("u2",), held={"q2": 0.0, "u1": 0.0})
    given = {**STRAIGHT, "q1": 0.0, "q3": 0.0, "px": 0.0, "py": 0.0}
    held = st.Family(wheel, "x", at=("u2",), held=given)
    with pytest.raises(NoMemberError, match="it is ignorable, so leave it out of the family"):
        st.spectrum(held, at=1.0, r=1.0, g=1.0)


def test_a_constant_velocity_stays_a_redundant_state() -> None:
    """X' = v, v' = 0, z' = -z: x is ignorable; v is constant, and its zero is structural."""
    free = system("free", "xvz", (), lambda x: (x[1], ca.SX(0), -x[2]))
    assert free.ignorable == ("x",)
    moving = st.Family(free, "moving", at=("v",), held={"z": 0.0})
    found = st.spectrum(moving, at=3.0, certify=True)
    assert (found.structural_zeros, found.verdict) == (2, Verdict.STABLE)
    assert found.nonlinear is Nonlinear.ASYMPTOTIC
    rest = st.Family(free, "rest", at=("x",), held={"v": 0.0, "z": 0.0})
    assert st.spectrum(rest, at=1.0).nonlinear is Nonlinear.GROWS
    stopped = st.Family(free, "stopped", at=("z",), held={"v": 0.0})
    with pytest.raises(NoMemberError):
        st.spectrum(stopped, at=1.0)


def test_left_out_values_never_reach_the_verdict() -> None:
    """The same system with its ignorable state given, at values all over, and left out."""
    rng = np.random.default_rng(7)
    model = sleigh()
    left = st.spectrum(st.Family(model, "run", at=("v",), held={"w": 0.0}), at=0.7, **SLEIGH)
    for _ in range(20):
        x = [0.7, 0.0, *(rng.normal(size=3) * 100)]
        matrix = model.linearise(x, list(SLEIGH.values()))
        values = np.sort(np.linalg.eigvals(matrix[:2, :2]).real)
        assert values == pytest.approx([left.eigenvalues[0].real, 0.0], abs=1e-14)
        assert (matrix[:2, 2:] == 0).all()


def quaternion(w: Any, q: Any) -> Any:
    """Rate of a quaternion that the angular velocity w in the body turns."""
    return (
        ca.vertcat(
            -q[1] * w[0] - q[2] * w[1] - q[3] * w[2],
            q[0] * w[0] + q[2] * w[2] - q[3] * w[1],
            q[0] * w[1] - q[1] * w[2] + q[3] * w[0],
            q[0] * w[2] + q[1] * w[1] - q[2] * w[0],
        )
        / 2
    )


def free_body(*, attitude: bool) -> st.System:
    q, w, inertia = ca.SX.sym("q", 4), ca.SX.sym("w", 3), ca.SX.sym("I", 3)
    a, b, c = ca.vertsplit(inertia)
    rates = ca.vertcat(
        (b - c) * w[1] * w[2] / a, (c - a) * w[2] * w[0] / b, (a - b) * w[0] * w[1] / c
    )
    names = ("I1", "I2", "I3")
    if not attitude:
        return st.System("body", w, inertia, rates, ("w1", "w2", "w3"), names)
    states = ("q0", "q1", "q2", "q3", "w1", "w2", "w3")
    every = ca.vertcat(quaternion(w, q), rates)
    return st.System("body", ca.vertcat(q, w), inertia, every, states, names)


def test_a_quaternion_that_nothing_reads_is_ignorable_as_a_whole() -> None:
    """Euler's equations alone give the spin's eigenvalues, conditions and boundaries."""
    whole, alone = free_body(attitude=True), free_body(attitude=False)
    assert whole.ignorable == ("q0", "q1", "q2", "q3")
    held = {"w1": 0.0, "w3": 0.0}
    spin, reduced = (st.Family(s, "spin", at=("w2",), held=held) for s in (whole, alone))
    for middle in (1.0, 2.0, 3.0):
        given = {"I1": 1.5, "I2": middle, "I3": 2.5}
        found, true = (st.spectrum(f, at=1.5, certify=True, **given) for f in (spin, reduced))
        assert found.verdict is true.verdict
        assert (found.eigenvalues == true.eigenvalues).all()
        assert "q0, q1, q2, q3 are ignorable" in found.reason
    edges = st.boundaries(spin, axis=("I2", 0.5, 4, 9), at=1.5, I1=1.5, I3=2.5)
    assert edges.complete and [e.value for e in edges] == [1.5, 2.5]
    axes = {"x": ("I2", 0.5, 4, 9), "y": ("I1", 0.5, 4, 9)}
    maps = [st.stability_map(f, **axes, at=1.5, I3=2.5) for f in (spin, reduced)]
    assert (maps[0].verdict == maps[1].verdict).all()
    with pytest.raises(ParameterError, match="leaves q1 out, but the rate of q0 depends on it"):
        st.Family(whole, "spin", at=("w2",), held={**held, "q0": 1.0})


def test_only_what_others_turn_is_a_group() -> None:
    """A pair that swings on its own, or a spiral, is a motion to be judged, not an attitude."""

    def pair(rates: Any) -> tuple[str, ...]:
        return system("pair", "cse", ("p",), rates).ignorable

    assert pair(lambda x, _: (-x[2] * x[1], x[2] * x[0], -x[2])) == ("c", "s")
    assert pair(lambda x, _: (-x[1], x[0], -x[2])) == ()
    assert pair(lambda x, _: (-x[2] * x[1] - x[0], x[2] * x[0] - x[1], -x[2])) == ()
    assert pair(lambda x, _: (-x[2] * x[1], x[2] * x[0], -x[2] + x[0])) == ()


def test_the_onset_of_a_cycle_does_not_see_what_it_turns() -> None:
    """The rate of the radius, p r - r³, is that of the plain oscillator, of all it turns."""

    def oscillator(x: Any, y: Any, p: Any) -> tuple[Any, Any]:
        r = p - x**2 - y**2
        return r * x - y, r * y + x

    x, p = ca.SX.sym("x", 4), ca.SX.sym("p")
    rates = ca.vertcat(*oscillator(x[0], x[1], p), -x[0] * x[3], x[0] * x[2])
    turning = st.System("turning", x, p, rates, ("x", "y", "c", "s"), ("p",))
    bare = ca.vertcat(*oscillator(x[0], x[1], p))
    plain = st.System("plain", x[:2], p, bare, ("x", "y"), ("p",))
    births = [
        st.hopf(st.Family(s, "rest", at=("p",), held={"x": 0, "y": 0}), axis=("p", -1, 1, 9))
        for s in (turning, plain)
    ]
    assert [len(b) for b in births] == [1, 1]
    assert births[0][0].coefficient == births[1][0].coefficient < 0
