"""Questions of users, with values that follow by hand: circulant matrices, one-line roots, logs."""

from __future__ import annotations

import casadi as ca
import numpy as np
import pytest
from scipy.linalg import eigvals

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


def test_where_all_pairs_of_a_large_ring_meet_at_zero_the_search_is_complete() -> None:
    """λ² = -4 K sin²(π j/n): every pair is imaginary above K = 0, and real below."""
    n = 7
    d, w, K = ca.SX.sym("d", n), ca.SX.sym("w", n), ca.SX.sym("K")
    pull = [K * (ca.sin(d[(i + 1) % n] - d[i]) + ca.sin(d[i - 1] - d[i])) for i in range(n)]
    names = [f"d{i}" for i in range(n)] + [f"w{i}" for i in range(n)]
    grid = st.System(
        "grid",
        ca.vertcat(d, w),
        K,
        ca.vertcat(w, *[p - v / 10 for p, v in zip(pull, ca.vertsplit(w), strict=True)]),
        names,
        ("K",),
    )
    sync = st.Family(grid, "sync", at=("K",), held=dict.fromkeys(names, 0.0))
    found = st.boundaries(sync, axis=("K", -0.5, 1, 11))
    assert found.complete
    assert [(b.value, b.crossing, b.stable_below) for b in found] == [
        (0.0, st.results.Crossing.STATIC, False)
    ]


def test_pairs_that_touch_at_one_value_are_told_apart_in_a_ring_of_pendula() -> None:
    """λ² + (1/10 - p) λ + 1 + 4 c sin²(π j/n) = 0: all pairs cross at p = 1/10."""
    n, p = 7, ca.SX.sym("p")
    q, v = ca.SX.sym("q", n), ca.SX.sym("v", n)
    pull = [
        3 * (ca.sin(q[(i + 1) % n] - q[i]) + ca.sin(q[i - 1] - q[i])) / 10 - ca.sin(q[i])
        for i in range(n)
    ]
    rates = [a + (p * ca.cos(q[i - 1]) - 0.1) * v[i] for i, a in enumerate(pull)]
    names = [f"q{i}" for i in range(n)] + [f"v{i}" for i in range(n)]
    ring = st.System("pendula", ca.vertcat(q, v), p, ca.vertcat(v, *rates), names, ("p",))
    hanging = st.Family(ring, "hanging", at=("p",), held=dict.fromkeys(names, 0.0))
    found = st.boundaries(hanging, axis=("p", 0, 3, 11))
    assert found.complete
    [point] = found
    assert point.value == 0.1
    waves = np.sqrt(1 + 1.2 * np.sin(np.pi * np.arange(n) / n) ** 2)
    assert np.sort(point.frequencies) == pytest.approx(np.sort(waves), rel=1e-9)


def test_every_cell_of_a_cusps_plane_counts_its_equilibria() -> None:
    """Bazykin's model: with prey x > 0 and both alive, x obeys a cubic; NumPy counts its roots."""
    x, y, a, d = (ca.SX.sym(n) for n in "xyad")
    catch = x * y / (1 + a * x)
    prey = st.System(
        "prey",
        ca.vertcat(x, y),
        ca.vertcat(a, d),
        ca.vertcat(x - catch - x**2 / 100, -y + catch - d * y**2),
        ("x", "y"),
        ("a", "d"),
    )
    both = prey.steady("a", guess={"x": 1.0, "y": 0.99, "a": 0.0}, d=0.0)
    chart = st.stability_map(
        both,
        x=("a", 0.01, 1.19, 12),
        y=("d", 0.01, 0.59, 9),
        box={"x": (0.01, 99.9), "y": (0.01, 999)},
    )
    for i, j in np.ndindex(chart.equilibria.shape):
        slope, crowd = float(chart.a[j]), float(chart.d[i])
        # y = (1 - x/100)(1 + a x) in -1 + x/(1 + a x) - d y = 0, times 1 + a x
        line = np.poly1d([slope, 1.0])
        high = np.poly1d([-0.01, 1.0]) * line
        roots = (np.poly1d([1.0, 0.0]) - line - crowd * high * line).roots
        alive = [r.real for r in roots if abs(r.imag) < 1e-9 and 0.01 < r.real < 99.9]
        alive = [r for r in alive if 0.01 < high(r) < 999]
        assert int(chart.equilibria[i, j]) == len(alive), (slope, crowd)


def test_a_stiff_system_is_integrated_by_a_stiff_method_however_long() -> None:
    """Robertson's kinetics at 1e5; the value is that of SciPy's Radau at a tolerance of 1e-11."""
    x, y, z, k = (ca.SX.sym(n) for n in "xyzk")
    slow, fast = 0.04 * x - k * y * z, 3e7 * y**2
    rates = ca.vertcat(-slow, slow - fast, fast)
    system = st.System("Robertson", ca.vertcat(x, y, z), k, rates, ("x", "y", "z"), ("k",))
    run = st.simulate(system, [1e4], [1.0, 0.0, 0.0], 1e5)
    assert str(run.method.values) == "cvodes"
    assert float(run.x[-1]) == pytest.approx(0.0178659211, abs=1e-8)


def test_a_kink_of_a_coefficient_is_no_meeting_of_motions() -> None:
    x, p = ca.SX.sym("x"), ca.SX.sym("p")
    system = st.System("s", x, p, -(1 + ca.fabs(p)) * x, states=("x",), parameters=("p",))
    found = st.boundaries(st.Family(system, "rest", at=("p",), held={"x": 0}), axis=("p", -2, 2, 9))
    assert found.complete and not len(found)


def test_a_cell_at_a_crossing_of_branches_leaves_the_others_decided() -> None:
    """The roots are p and q: cells with p = q have a double root, all others one that is simple."""
    y, P = ca.SX.sym("y"), ca.SX.sym("P", 2)
    system = st.System("s", y, P, -(y - P[0]) * (y - P[1]), states=("y",), parameters=("p", "q"))
    family = st.Family(
        system,
        "m",
        at=("p",),
        unknown={"y": 1.0},
        equations=("y",),
        typical={"p": 1.0, "q": -1.0},
    )
    verdict = st.stability_map(family, x=("p", -1, 1, 4), y=("q", -1, 1, 4)).verdict.values
    apart = ~np.eye(4, dtype=bool)
    assert (verdict[apart] == 1).all() and (verdict[~apart] == 0).all()


@pytest.mark.parametrize("seed", range(3))
def test_algebraic_variables_go_in_as_unknowns(seed: int) -> None:
    """The finite eigenvalues of the pencil (A, diag(1, 1, 1, 0, 0)), by SciPy."""
    a = np.random.default_rng(seed).integers(-4, 5, (5, 5)) - 6.0 * np.eye(5)
    x, p = ca.SX.sym("x", 3), ca.SX.sym("p")
    mass = ca.vertcat(
        ca.horzcat(ca.DM.eye(3), -p * ca.DM(a[:3, 3:])), ca.horzcat(ca.DM(2, 3), -ca.DM(a[3:, 3:]))
    )
    system = st.System.from_mass_matrix(
        "index one",
        x,
        p,
        mass,
        ca.mtimes(ca.DM(a[:, :3]), x),
        unknowns=("d_a", "d_b", "d_c", "y", "z"),
        rates={},
        states=("a", "b", "c"),
        parameters=("p",),
    )
    rest = st.Family(system, "rest", at=("p",), held=dict.fromkeys("abc", 0.0))
    found = st.spectrum(rest, at=1.0, certify=True)
    pencil = eigvals(a, np.diag([1.0, 1, 1, 0, 0]))
    finite = pencil[np.isfinite(pencil) & (abs(pencil) < 1e6)]
    finite = sorted(finite, key=lambda v: (round(v.real, 6), v.imag))
    assert found.eigenvalues == pytest.approx(finite, abs=1e-11)
