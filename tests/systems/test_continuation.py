"""Folds and branch points by closed forms, and branches followed from one to the next."""

import math
from typing import Any

import casadi as ca
import numpy as np
import pytest

import stability as st


def scalar(rate: Any, guess: float) -> Any:
    x, p = ca.SX.sym("x"), ca.SX.sym("p")
    system = st.System("scalar", x, p, rate(x, p), states=("x",), parameters=("p",))
    return st.Family(system, "f", at=("p",), unknown={"x": guess}, equations=("x",))


def test_a_cubic_is_followed_round_both_its_folds() -> None:
    """P = x³ - 3x turns at x = ∓1, p = ±2."""
    run = st.branch(
        scalar(lambda x, p: p - x**3 + 3 * x, -2.5), -5, 5, [], points=41, arclength=True
    )
    assert run.complete
    assert [f.value for f in run.folds] == pytest.approx([2.0, -2.0], abs=4e-16)
    assert [float(f.state[0]) for f in run.folds] == pytest.approx([-1.0, 1.0], abs=1e-10)
    assert all(f.resolved and f.error < 1e-14 for f in run.folds)
    assert not run.branch_points
    x = run.state[:, 0]
    assert np.abs(x**3 - 3 * x - run.at).max() < 1e-13
    assert (np.diff(x) > 0).all()
    assert np.diff(x).max() < 0.2


def test_without_arclength_a_branch_ends_at_its_fold() -> None:
    run = st.branch(scalar(lambda x, p: p - x**2, 1.0), 2, -1, [], points=13)
    assert not run.complete
    assert isinstance(run.folds[0], st.Fold)
    assert run.folds[0].value == pytest.approx(0.0, abs=1e-15)
    assert run.ended == "ended after 0.25: a fold at p = 0"
    assert np.allclose(run.state[:, 0], np.sqrt(run.at), rtol=1e-13)


@pytest.mark.parametrize(
    ("rate", "start", "stop", "guess", "word", "place"),
    [
        (lambda x, p: -(x**3) - p * x, -1, 1, 1.0, "pitchfork", 0.0),
        (lambda x, p: -((x - 2) ** 3) - (p - 0.5) * (x - 2), -0.5, 1, 3.0, "pitchfork", 0.5),
        (lambda x, p: ca.sin(x) * (p * ca.cos(x) - 1), 2, 0.5, 1.05, "pitchfork", 1.0),
        (lambda x, p: x * (x - p), -1, 1, -1.0, "transcritical", 0.0),
        (lambda x, p: p - x**3, 1, -1, 1.0, "cusp", 0.0),
        (lambda x, p: (p - x**2) * (x - 3 - p), 1, -1, 1.0, "fold", 0.0),
        (lambda x, p: 1e-9 - x**3 - p * x, -1, 1, -1.0, "fold", -3 * (5e-10) ** (2 / 3)),
    ],
)
def test_the_point_that_ends_a_branch_has_its_name(
    rate: Any, start: float, stop: float, guess: float, word: str, place: float
) -> None:
    """Only a fold is in `folds`; the other places are known from the factors of the rate."""
    run = st.branch(scalar(rate, guess), start, stop, [], points=51)
    assert run.complete if word == "transcritical" else f": a {word} at p = " in run.ended
    assert [f.value for f in run.folds] == pytest.approx([place] if word == "fold" else [])
    crossed = [b.kind for b in run.branch_points]
    assert crossed == ([word] if word[0] in "pt" else [])
    assert [b.value for b in run.branch_points] == pytest.approx([place] * len(crossed), abs=1e-9)


def test_a_refusal_names_the_pitchfork() -> None:
    x, p = ca.SX.sym("x"), ca.SX.sym("p")
    system = st.System("s", x, p, -(x**3) - p * x, states=("x",), parameters=("p",))
    side = system.steady("p", guess={"x": 1.0, "p": -1.0})
    with pytest.raises(st.StabilityError, match="it stopped at a pitchfork at p = 0, where anoth"):
        st.spectrum(side, at=0.5)


def test_the_fold_of_bratu_with_three_points_is_that_of_an_equation_in_one_unknown() -> None:
    """U'' + λ e^u = 0 on three inner points of (0, 1), h = 1/4.

    With outer value v and middle value w: 2v - w = h²λ e^v, 2(w - v) = h²λ e^w.  Divided:
    2(w - v) e^v = (2v - w) e^w, and dλ = 0 along it: mpmath finds both to 30 digits.
    """
    import mpmath

    x, p = ca.SX.sym("x", 3), ca.SX.sym("p")
    ends = [0, *ca.vertsplit(x), 0]
    rates = [
        16 * (ends[i - 1] - 2 * ends[i] + ends[i + 1]) + p * ca.exp(ends[i]) for i in (1, 2, 3)
    ]
    system = st.System("Bratu", x, p, ca.vertcat(*rates), states=("a", "b", "c"), parameters=("p",))
    family = system.steady("p", guess={"p": 1.0})
    run = st.branch(family, 0.5, 4.0, [], points=31, arclength=True)
    with mpmath.workdps(30):

        def residual(v: Any, w: Any) -> tuple[Any, Any]:
            f = [2 * v - w, 2 * (w - v)]
            load = 16 * f[0] * mpmath.exp(-v)
            s = [load * mpmath.exp(v) / 16, load * mpmath.exp(w) / 16]
            # the slope by (v, w) at fixed load is singular
            return f[1] - s[1], (2 - s[0]) * (2 - s[1]) - 2

        v, w = mpmath.findroot(residual, (0.9, 1.2))
        exact = float(16 * (2 * v - w) * mpmath.exp(-v))
    assert len(run.folds) == 1
    assert run.folds[0].value == pytest.approx(exact, rel=4e-15)
    assert run.ended == "the branch turned and came back to 0.5"


def test_a_pitchfork_is_located_and_both_its_arms_are_followed() -> None:
    rest = scalar(lambda x, p: p * x - x**3, 0.0)
    run = st.branch(rest, -1, 1, [], points=12)
    [point] = run.branch_points
    assert (point.kind, run.complete) == ("pitchfork", True)
    assert abs(point.value) < 1e-14
    for side in (1, -1):
        arm = point.switch(1.0, side=side, points=31)
        assert arm.complete
        assert np.allclose(arm.state[:, 0], side * np.sqrt(arm.at), atol=1e-12)
    assert point.switch(-1.0).ended == "the branch runs the other way, from 0 to 1"


@pytest.mark.parametrize("arclength", [False, True])
def test_a_transcritical_point_has_two_directions(arclength: bool) -> None:
    run = st.branch(
        scalar(lambda x, p: (x - p) * (x - 2 * p + 3), -1.0),
        -1,
        5,
        [],
        points=14,
        guess=[-1.0],
        arclength=arclength,
    )
    [point] = run.branch_points
    assert point.kind == "transcritical"
    assert point.value == pytest.approx(3.0, abs=1e-14)
    assert run.complete
    assert np.allclose(run.state[:, 0], run.at, atol=1e-12)
    assert point.other is not None
    assert point.other[0] / point.other[1] == pytest.approx(2.0, rel=1e-8)
    for stop in (1.0, 5.0):
        other = point.switch(stop, points=11)
        assert other.complete
        assert np.allclose(other.state[:, 0], 2 * other.at - 3, atol=1e-12)


def test_a_broken_pitchfork_has_a_fold_and_no_branch_point() -> None:
    """P x - x³ + ε: no branch crosses; the lower arms turn at p = 3 (ε/2)^(2/3)."""
    eps = 1e-4
    imperfect = scalar(lambda x, p: eps + p * x - x**3, 1.0)
    upper = st.branch(imperfect, 2, -2, [], points=12, guess=[1.4], arclength=True)
    lower = st.branch(imperfect, 2, -2, [], points=12, guess=[-1.4], arclength=True)
    assert upper.complete
    assert not upper.branch_points
    assert not lower.branch_points
    assert lower.folds[0].value == pytest.approx(3 * (eps / 2) ** (2 / 3), rel=1e-13)
    assert lower.ended == "the branch turned and came back to 2"


def test_a_closed_curve_of_members_closes() -> None:
    run = st.branch(
        scalar(lambda x, p: 1 - (x - 3) ** 2 - p**2, 4.0),
        0,
        2,
        [],
        points=31,
        guess=[4.0],
        arclength=True,
    )
    assert [f.value for f in run.folds][:1] == pytest.approx([1.0], abs=1e-15)
    assert not run.complete
    assert np.allclose((run.state[:, 0] - 3) ** 2 + run.at**2, 1, atol=1e-12)


def test_the_origin_of_lorenz_leads_to_the_fixed_points_and_back() -> None:
    x, p = ca.SX.sym("x", 3), ca.SX.sym("p", 3)
    rates = ca.vertcat(p[0] * (x[1] - x[0]), x[0] * (p[1] - x[2]) - x[1], x[0] * x[1] - p[2] * x[2])
    system = st.System("L", x, p, rates, states=("x", "y", "z"), parameters=("sigma", "r", "b"))
    origin = st.Family(
        system,
        "origin",
        at=("r",),
        unknown={"x": 0.0, "y": 0.0, "z": 0.0},
        equations=("x", "y", "z"),
    )
    [point] = st.branch(origin, 0.5, 28, [10, 8 / 3], points=11).branch_points
    assert (point.kind, point.value) == ("pitchfork", pytest.approx(1.0, abs=1e-14))
    arm = point.switch(28.0)
    assert arm.complete
    assert np.allclose(
        np.abs(arm.state[:, 0]), np.sqrt(8 / 3 * np.maximum(arm.at - 1, 0)), atol=1e-9
    )
    plus = system.steady("r", guess={"x": 8, "y": 8, "z": 27, "r": 28, "sigma": 10, "b": 8 / 3})
    back = st.branch(plus, 28, 0.5, [10, 8 / 3], points=11)
    assert back.ended == "ended after 3.25: a pitchfork at r = 1"
    assert back.branch_points[0].value == pytest.approx(1.0, abs=1e-12)


def test_the_disks_tumbling_branch_has_no_fold() -> None:
    """φ' from k φ'² s = g_n, as the test of families derives it (tests/bodies/test_families.py)."""
    family = st.disk_family("tumbling", "viscous")
    run = st.branch(family, 1.5, 0.1, [0.25, 0.3], points=15)
    assert run.complete
    assert run.folds == run.branch_points == ()
    assert np.allclose(run.at, np.linspace(1.5, 0.1, 15), rtol=0, atol=1e-15)
    direct = family.member(run.at[:, None], [0.25, 0.3])
    assert np.allclose(run.state, direct, rtol=1e-13)


def test_an_unresolved_request_is_refused() -> None:
    rest = scalar(lambda x, p: p * x - x**3, 0.0)
    [point] = st.branch(rest, -1, 1, [], points=12).branch_points
    for given, said in (({"side": 2}, "side is 2"), ({"points": 1}, "points is 1")):
        with pytest.raises(st.StabilityError, match=said):
            point.switch(1.0, **given)
    with pytest.raises(st.StabilityError, match="stop is"):
        point.switch(point.value)
    with pytest.raises(st.StabilityError, match="leave arclength out"):
        st.branch(rest, -1, 1, [], arclength=True)
    assert math.isfinite(point.error)
