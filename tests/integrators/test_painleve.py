"""D and gn D at zero: apart they are lift-off, together the contact ends with gn > 0."""

from collections.abc import Callable, Sequence
from functools import cache
from typing import Any

import numpy as np
import pytest
import sympy as sp
from scipy.integrate import solve_ivp

import stability as st
from stability.integrators.flow import flow
from stability.integrators.painleve import approach
from stability.integrators.selection import METHODS
from stability.integrators.taylor import available
from stability.motion.result import BY_CODE

MU, K = 6.3175, 0.25
START = [1.01908, 0.10829, 0.63634, 1.90665, 0.1843, -0.0055]
"""Issue's counterexample to "D cannot vanish": version 0.4.0 called its end a lift-off."""
HERE = [m for m in METHODS if m != "heyoka" or available()]


def word(run: Any) -> str:
    return BY_CODE[int(run.outcome)].word


@cache
def closed() -> tuple[dict[str, Any], Callable[..., Any], Callable[..., Any]]:
    """The sliding disk by hand: Newton and Euler solved on paper with gn as a symbol.

    Returns D, N, β and the rest as expressions, and functions of the state for D, N and rates.
    """
    th, q, p, w, vx, vy, k, mu, gn = sp.symbols("theta q p w v_x v_y k mu g", real=True)
    s, c = sp.sin(th), sp.cos(th)
    acc_th = (k * p**2 * s * c - 2 * k * w * p * s - gn * (c - mu * vx * s)) / k
    acc_p = (2 * w * q - 2 * p * q * c) / s
    acc_w = -mu * gn * vy / (2 * k)
    acc_x = p * (vy - w) - mu * gn * vx - acc_th * s - q**2 * c
    acc_y = -p * (vx + q * s) - mu * gn * vy + acc_w
    # the contact point stays on the plane: d²(sin θ)/dt² = gn - 1
    vertical = acc_th * c - q**2 * s - (gn - 1)
    d = k + c**2 - mu * vx * s * c
    n = sp.expand(k * vertical.subs(gn, 0))
    assert sp.simplify(k * vertical - (n - d * gn)) == 0
    state = (th, q, p, w, vx, vy)
    rates = sp.Matrix([q, acc_th, acc_p, acc_w, acc_x, acc_y])
    numbers = {k: sp.Float(K, 30), mu: sp.Float(MU, 30)}
    make = lambda e: sp.lambdify((*state, k, mu, gn), e, "numpy")  # noqa: E731
    table = {"state": state, "d": d, "n": n, "rates": rates, "gn": gn, "k": k, "mu": mu}
    return table | {"numbers": numbers}, make([d, n]), make(list(rates))


def test_the_closed_form_is_the_graph() -> None:
    _, pair, rates = closed()
    rng = np.random.default_rng(4)
    system = st.disk_system("viscous")
    for _ in range(20):
        x = np.array(START) + rng.uniform(-0.1, 0.1, 6) - [0, 0, 0, 0, 0.15, 0]
        seen = system.observe(x, np.array([K, MU]))
        gn = float(seen["normal_force"])
        d, n = pair(*x, K, MU, gn)
        assert d == pytest.approx(float(seen["determinant"]), rel=1e-10, abs=1e-13)
        assert n / d == pytest.approx(gn, rel=1e-9)
        assert np.allclose(rates(*x, K, MU, gn), system.rates(x, [K, MU]), rtol=1e-9, atol=1e-9)


def test_near_d_and_n_zero_the_motion_in_stretched_time_is_linear_with_beta_mu_k_plus_one() -> None:
    table, *_ = closed()
    gn, k, mu = table["gn"], table["k"], table["mu"]
    rate_d = sum(
        sp.diff(table["d"], x) * r for x, r in zip(table["state"], table["rates"], strict=True)
    )
    th, vx = table["state"][0], table["state"][4]
    beta = sp.expand(rate_d).coeff(gn, 1)
    on_zero = beta.subs(vx, (k + sp.cos(th) ** 2) / (mu * sp.sin(th) * sp.cos(th)))
    assert sp.simplify(on_zero - mu * (k + 1)) == 0
    rate_n = sum(
        sp.diff(table["n"], x) * r for x, r in zip(table["state"], table["rates"], strict=True)
    )
    assert sp.degree(sp.Poly(sp.expand(rate_n), gn)) == 1  # N' = n0 D + n1 N
    # the package's matrix at the end of the counterexample against this one
    run = st.simulate(st.Disk(k=K), st.Viscous(MU), START, 1.0, tolerance=1e-12)
    x = np.array([float(run[name][-1]) for name in st.disk_system("viscous").states])
    values = dict(zip(table["state"], x, strict=True)) | {k: K, mu: MU}
    d0, b = (float(sp.expand(rate_d).coeff(gn, i).subs(values)) for i in (0, 1))
    n0, n1 = (float(sp.expand(rate_n).coeff(gn, i).subs(values)) for i in (0, 1))
    slow, fast = sorted(np.linalg.eigvals(np.array([[d0, b], [n0, n1]])).real, reverse=True)
    found = approach(flow("viscous"), flow("viscous").pack(x), np.array([K, MU, 1e-6]))
    assert np.allclose(found.rates, [slow, fast], rtol=1e-5)
    assert 0 > slow > d0  # so that gn tends to a positive number
    assert found.normal == pytest.approx((slow - d0) / b, rel=1e-5)


def independent(start: Any, k: float, mu: float, last: float) -> tuple[str, float, float, float]:
    """Which comes first, D = 1e-8 or N = 0, when, and gn, by the closed form in stretched time.

    The last entry is how far gn still went from D = 1e-7 on.
    """
    _, pair, rates = closed()

    def rhs(_t: float, y: Any) -> Any:
        d, n = pair(*y[:6], k, mu, 0.0)
        return np.append(d * np.array(rates(*y[:6], k, mu, n / d)), d)

    def lifts(_t: float, y: Any) -> float:
        return float(pair(*y[:6], k, mu, 0.0)[1])

    def narrow(_t: float, y: Any) -> float:
        return float(pair(*y[:6], k, mu, 0.0)[0]) - 1e-8

    def late(_t: float, y: Any) -> float:
        return float(y[6]) - last

    def near(_t: float, y: Any) -> float:
        return float(pair(*y[:6], k, mu, 0.0)[0]) - 1e-7

    events: Any = [lifts, narrow, late, near]
    for event in events[:3]:
        event.terminal = True
    run = solve_ivp(
        rhs, (0, 1e9), np.append(start, 0.0), method="DOP853", rtol=1e-12, atol=1e-14, events=events
    )
    which = [i for i, found in enumerate(run.t_events[:3]) if len(found)][0]
    y = run.y[:, -1]
    d, n = pair(*y[:6], k, mu, 0.0)
    before = [n / d for d, n in (pair(*x[:6], k, mu, 0.0) for x in run.y_events[3])]
    still = abs(n / d - before[-1]) if before else 0.0
    return ("lift-off", "no-contact", "moving")[which], float(y[6]), n / d, still


@pytest.mark.parametrize("check", [False, pytest.param(True, marks=pytest.mark.long)])
def test_the_counterexample_ends_without_contact_and_with_a_normal_force(check: bool) -> None:
    kind, when, gn, _ = independent(START, K, MU, 1.0)
    assert kind == "no-contact"
    assert gn == pytest.approx(0.10154, abs=1e-5)
    for method in HERE:
        run = st.simulate(st.Disk(k=K), st.Viscous(MU), START, 1.0, method=method, check=check)
        assert word(run) == "no-contact"
        assert run.event_kind.values.tolist() == ["no-contact"]
        assert float(run.normal_force[-1]) == pytest.approx(gn, abs=1e-5)
        assert float(run.end_time) == pytest.approx(when, abs=2e-6)
        assert "together" in str(run.evidence.values)


@pytest.mark.parametrize(("count", "least"), [(6, 2), pytest.param(12, 4, marks=pytest.mark.long)])
def test_an_open_set_of_starts_ends_so_and_not_all_its_neighbours(count: int, least: int) -> None:
    rng = np.random.default_rng(8)
    found: dict[str, int] = {}
    starts, truths = [], []
    while len(starts) < count:
        x = np.array(START) * (1 + rng.uniform(-0.01, 0.01, 6))
        d, n = closed()[1](*x, K, MU, 0.0)
        if 0 < d < 0.3 and n > 0:
            starts.append(x)
            truths.append(independent(x, K, MU, 0.02))
    for tolerance in (1e-3, 1e-9):
        runs = st.simulate(st.Disk(k=K), st.Viscous(MU), starts, [0.02], tolerance=tolerance)
        for i, (kind, when, gn, still) in enumerate(truths):
            run = runs.isel(launch=i)
            name = word(run)
            if tolerance == 1e-3 and name == "undetermined":
                continue
            assert name == kind
            found[name] = found.get(name, 0) + 1
            if kind == "no-contact" and tolerance == 1e-9:
                assert float(run.normal_force[-1]) == pytest.approx(gn, abs=2 * still + 1e-5)
                assert float(run.end_time) == pytest.approx(when, rel=1e-5)
    assert found["no-contact"] >= least
    assert found["moving"] >= least


@pytest.mark.parametrize(
    "methods", [("dop853", "lsoda"), pytest.param(HERE, marks=pytest.mark.long)], ids=["two", "all"]
)
def test_a_real_lift_off_with_a_small_d_stays_one(methods: Sequence[str]) -> None:
    x = np.array(
        [
            1.01908,
            0.11646887712150475,
            0.5773447867225326,
            2.067745929933388,
            0.18242974825821903,
            -0.005761796842540787,
        ]
    )
    kind, when, *_ = independent(x, K, MU, 1.0)
    assert kind == "lift-off"
    for method in methods:
        run = st.simulate(st.Disk(k=K), st.Viscous(MU), x, 1.0, method=method)
        assert word(run) == "lift-off"
        assert float(run.end_time) == pytest.approx(when, abs=1e-6)
        six = [float(run[name][-1]) for name in st.disk_system("viscous").states]
        assert 0.005 < closed()[1](*six, K, MU, 0.0)[0] < 0.01


@pytest.mark.parametrize(
    "methods",
    [("dop853",), pytest.param(HERE, marks=pytest.mark.long)],
    ids=["one", "all"],
)
def test_where_d_alone_runs_to_zero_the_force_grows_without_bound_by_every_method(
    methods: Sequence[str],
) -> None:
    law = st.RegularisedCoulomb(5.753758471817282, 0.00028800461614589425)
    start = [1.0525640005202301, 0.6767085152932947, 0, 0, 0, -0.3436609788816844]
    disk = st.Disk(k=0.2556196142891559)
    for method in methods:
        run = st.simulate(disk, law, start, 5.0, method=method, tolerance=1e-10)
        assert word(run) == "no-contact"
        assert "grows without bound" in str(run.evidence.values)
        assert float(run.end_time) == pytest.approx(0.0474634037, abs=1e-8)
        assert float(run.normal_force[-1]) > 1e8


def test_samples_up_to_the_end_are_all_there() -> None:
    times = np.linspace(0, 0.0112761, 12)
    run = st.simulate(st.Disk(k=K), st.Viscous(MU), START, [*times, 1.0], tolerance=1e-6)
    assert np.allclose(run.time.values[:12], times)
    assert (run.normal_force.values > 0.05).all()


def test_an_end_at_which_the_force_has_no_value_is_told_without_nan() -> None:
    """D reaches zero at an event: no step is made on rates that are not finite."""
    disk, start = st.Disk(k=0.0109), [1.831, 0.306, 0.193, 0, -0.191, 0.166]
    run = st.simulate(disk, st.Coulomb(0.356), start, 4.72, tolerance=3.54e-5, pose=True)
    assert run.attrs["outcome"] == "no-contact"
    assert "nan" not in str(run.evidence.values)
    assert np.isfinite(run.theta.values).all()
