"""Questions of users, with values that follow by hand: circulant matrices, one-line roots, logs."""

from __future__ import annotations

import casadi as ca
import numpy as np
import pytest

import stability as st
from stability.base.errors import DomainError


def ring(cars: int) -> st.Family:
    """Cars on a ring, whose headways add up to its length: a zero that no single entry shows."""
    h, v, a = ca.SX.sym("h", cars), ca.SX.sym("v", cars), ca.SX.sym("a")
    wanted = ca.tanh(h - 2) + ca.tanh(ca.SX(2))
    rates = [v[(i + 1) % cars] - v[i] for i in range(cars)]
    names = [f"h{i}" for i in range(cars)] + [f"v{i}" for i in range(cars)]
    system = st.System(
        "ring", ca.vertcat(h, v), a, ca.vertcat(*rates, a * (wanted - v)), names, ("a",)
    )
    guess = {n: 2.0 if n[0] == "h" else np.tanh(2) for n in names}
    return system.steady("h0", guess=guess | {"a": 1.0})


@pytest.mark.parametrize("cars", [12, 14])
def test_a_sum_that_is_conserved_is_a_structural_zero_on_long_rings(cars: int) -> None:
    """λ² + a λ + a (1 - exp(2πi j/n)) = 0 for each wave j, with a at the spacing 2 (slope 1)."""
    a = 2.5
    found = st.spectrum(ring(cars), at=2.0, a=a, certify=True)
    waves = a * (1 - np.exp(2j * np.pi * np.arange(1, cars) / cars))
    slowest = ((-a + np.sqrt(a * a - 4 * waves)) / 2).real.max()
    assert found.verdict is st.Verdict.STABLE
    assert found.structural_zeros == 1
    assert found.abscissa == pytest.approx(slowest, abs=1e-13)


def test_a_system_without_parameters_settles_on_its_one_motion() -> None:
    """By symmetry each well of x - x³ takes half of the states that are spread about the middle."""
    x, v = ca.SX.sym("x"), ca.SX.sym("v")
    rates = ca.vertcat(v, x - x**3 - 0.2 * v)
    wells = st.System("wells", ca.vertcat(x, v), ca.SX.sym("p", 0), rates, ("x", "v"), ())
    right = st.Family(wells, "right", at=(), held={"x": 1, "v": 0})
    left = st.Family(wells, "left", at=(), held={"x": -1, "v": 0})
    found = st.basins(
        wells, x=("x", -2, 2, 6), y=("v", -2, 2, 6), horizon=300.0, families=[right, left]
    )
    outcome = np.asarray(found.outcome)
    assert (outcome == 1).all()
    assert int((found.family == 1).sum()) == 18


def test_a_power_of_a_state_has_its_spectrum_and_boundary() -> None:
    """The term q (2^(T/10) - 1) has the slope q log 2 / 10 at rest."""
    T, q, r = (ca.SX.sym(n) for n in "Tqr")
    rate = -q * (2 ** (T / 10) - 1) - r * T
    warm = st.System("warm", T, ca.vertcat(q, r), rate, states=("T",), parameters=("q", "r"))
    rest = st.Family(warm, "rest", at=("q",), held={"T": 0})
    slope = np.log(2) / 10
    assert st.spectrum(rest, at=1.0, r=0.0).eigenvalues[0] == pytest.approx(-slope, rel=1e-14)
    for _ in range(2):
        found = st.boundaries(rest, axis=("r", -1, 1, 9), at=1.0)
        assert found.complete
        assert [p.value for p in found] == pytest.approx([-slope], rel=1e-14)


@pytest.mark.long  # its boundary is a curve of pitchforks, which the search does not find
def test_a_map_of_a_symmetric_pair_has_all_its_cells() -> None:
    """At x = y = a/(1 + exp(p(x - 1))) the rates' slopes are -1 ± x (1 - x/a) p."""
    x, y, p, a = (ca.SX.sym(n) for n in "xypa")
    rates = [a / (1 + ca.exp(p * (one - 1))) - two for one, two in ((y, x), (x, y))]
    toggle = st.System(
        "toggle", ca.vertcat(x, y), ca.vertcat(p, a), ca.vertcat(*rates), ("x", "y"), ("p", "a")
    )
    even = toggle.steady("p", guess={"x": 1.0, "y": 1.0, "p": 0.5}, a=2.2)
    found = st.stability_map(even, x=("p", 0.2, 6, 8), y=("a", 1.0, 4.0, 6))
    for i, j in np.ndindex(found.verdict.shape):
        steep, high = float(found.p[j]), float(found.a[i])
        low, top = 0.0, high
        for _ in range(60):  # the members lie where the two sides of x = f(x) meet
            middle = (low + top) / 2
            above = high / (1 + np.exp(steep * (middle - 1))) > middle
            low, top = (middle, top) if above else (low, middle)
        growth = low * (1 - low / high) * steep - 1
        assert int(found.verdict[i, j]) == (1 if growth < 0 else 2), (steep, high, growth)


def test_conditions_refuse_a_member_of_another_branch() -> None:
    """On y = p the linearisation is 1 - 2p; the family's member at p = -1 is y = 1 - p = 2."""
    y, p = ca.SX.sym("y"), ca.SX.sym("p")
    system = st.System("s", y, p, -(y - p) * (y + p - 1), states=("y",), parameters=("p",))
    family = st.Family(
        system, "m", at=("p",), unknown={"y": 2.0}, equations=("y",), typical={"p": 2.0}
    )
    conditions = st.conditions(family)
    assert dict(conditions.solved) == {"y": "p"}
    assert st.spectrum(family, at=-1.0, certify=True).eigenvalues == pytest.approx([-3.0])
    with pytest.raises(DomainError, match="another branch"):
        conditions.verdict(-1.0)
