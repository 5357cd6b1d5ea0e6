"""Straight rolling does not last: its slow flow derived again, and simulated over the long time."""

from typing import Any

import numpy as np
import pytest
import sympy
from proofs.centre_manifold import W, derive_slow_flow
from reference import beyond
from simulation import crossing, simulate

import stability as st
from stability.boundary.drift import FORMULAS

K, MU = sympy.symbols("k mu")
NAMES = {"k": K, "mu": MU, "w": W}


@pytest.mark.long
@pytest.mark.parametrize("law", ["viscous", "linear-viscous"])
def test_the_slow_flow_derived_from_the_graph_is_that_of_an_independent_derivation(
    law: str,
) -> None:
    found, theirs = derive_slow_flow(law), beyond()["slow_flow"]
    for mine, key in ((found.tilt, "a"), (found.spin, "b"), (found.launch, "rho")):
        assert sympy.simplify(mine - sympy.sympify(theirs[key], locals=NAMES)) == 0


@pytest.mark.long
def test_the_manifold_is_invariant_to_its_order() -> None:
    """The residual of the invariance equation is of the order of the tilt to the fourth."""
    found = derive_slow_flow()
    system = st.disk_system("viscous")
    k, mu, w = 0.3, 0.8, 1.9
    at = {K: sympy.Rational(3, 10), MU: sympy.Rational(4, 5)}
    sizes = []
    for tilt in (0.08, 0.04):

        def state(a: float, spin: float) -> Any:
            rest = {
                n: sum(float(c.subs(at | {W: spin})) * a ** (i + 1) for i, c in enumerate(cs))
                for n, cs in found.manifold.items()
            }
            return np.array(
                [
                    np.pi / 2 + a,
                    rest["theta_dot"],
                    rest["phi_dot"],
                    spin,
                    rest["slip_x"],
                    rest["slip_y"],
                ]
            )

        x = state(tilt, w)
        rates = system.rates(x, [k, mu])
        by_tilt = (state(tilt + 1e-5, w) - state(tilt - 1e-5, w)) / 2e-5
        by_spin = (state(tilt, w + 1e-5) - state(tilt, w - 1e-5)) / 2e-5
        residual = rates - by_tilt * rates[0] - by_spin * rates[3]
        sizes.append(np.abs(residual).max())
    assert np.log2(sizes[0] / sizes[1]) > 3.5


def test_the_closed_form_is_the_integral_of_the_slow_flow() -> None:
    a = sympy.sympify(beyond()["slow_flow"]["a"], locals=NAMES)
    b = sympy.sympify(beyond()["slow_flow"]["b"], locals=NAMES)
    # the first integral: α² (2(2k+1)w² - 1)/w² does not change along the flow
    alpha = sympy.Symbol("alpha")
    integral = alpha**2 * (2 * (2 * K + 1) * W**2 - 1) / W**2
    change = sympy.diff(integral, alpha) * a * alpha**3 + sympy.diff(integral, W) * b * alpha**2
    assert sympy.simplify(change) == 0
    from scipy.integrate import quad, solve_ivp

    for k, mu, w0, tilt in ((0.25, 1.0, 2.0, 0.01), (0.5, 0.3, 1.7, 0.02), (0.01, 5.0, 30.0, 0.03)):
        d = st.drift(at=w0, tilt=tilt, disk=st.Disk(k=k), contact=st.Viscous(mu), launch=False)
        level = tilt**2 * (2 * (2 * k + 1) * w0**2 - 1) / w0**2

        def rate(w: float, k: float = k, mu: float = mu, level: float = level) -> float:
            return mu * w * (2 * k + 1) ** 3 / (level * w**2 / (2 * (2 * k + 1) * w**2 - 1))

        whole, _ = quad(rate, (2 * k) ** -0.5, w0, epsrel=1e-12)
        assert d.time == pytest.approx(whole, rel=1e-10)
        assert d.threshold == pytest.approx((2 * k) ** -0.5)
        f = [sympy.lambdify((K, MU, W), e) for e in (a, b)]
        slow = lambda _, y, f=f, p=(k, mu): [f[0](*p, y[1]) * y[0] ** 3, f[1](*p, y[1]) * y[0] ** 2]  # noqa: E731
        flow = solve_ivp(slow, (0, d.time), [tilt, w0], rtol=1e-11, atol=1e-14)
        assert flow.y[1, -1] == pytest.approx(d.threshold, rel=1e-8)
        assert flow.y[0, -1] == pytest.approx(d.tilt_end, rel=1e-7)
        assert f[0](k, mu, w0) == pytest.approx(d.tilt_rate)
        assert f[1](k, mu, w0) == pytest.approx(d.spin_rate)


RECORDS = beyond()["rolling"]


def test_the_formula_is_the_limit_of_another_authors_simulations() -> None:
    """T_sim / T - 1 falls with the square of the tilt, in all 54 pairs of parameters and starts."""
    groups: dict[Any, list[tuple[float, float]]] = {}
    for r in RECORDS:
        d = st.drift(
            at=r["w0"],
            tilt=r["alpha0"],
            disk=st.Disk(k=r["k"]),
            contact=st.Viscous(r["mu"]),
            launch=r["kind"] == "launch",
        )
        key = r["k"], r["mu"], round(r["w0"], 9), r["kind"]
        groups.setdefault(key, []).append((r["alpha0"], r["T_sim"] / d.time - 1))
    assert len(groups) == 36
    for points in groups.values():
        points.sort()
        assert abs(points[0][1]) < 24 * points[0][0] ** 2
        for (small, off), (large, more) in zip(points[:-1], points[1:], strict=True):
            order = np.log(more / off) / np.log(large / small)
            assert 1.8 < order < 2.2


def time_to_threshold(
    k: float, mu: float, w0: float, tilt: float, launch: bool, beyond: float = 1.05
) -> tuple[float, float]:
    d = st.drift(at=w0, tilt=tilt, disk=st.Disk(k=k), contact=st.Viscous(mu), launch=launch)
    x = np.array([np.pi / 2 + tilt, 0.0, 0.0, w0, 0.0, 0.0])
    if not launch:
        x[2], x[4] = tilt / (w0 * (2 * k + 1)), -tilt / (mu * (2 * k + 1))
        x[5] = 2 * k * tilt**2 / (mu**2 * w0 * (2 * k + 1) ** 3)
    # not far beyond: there the motion departs, may lift off, and is nobody's concern here
    times = np.linspace(0, beyond * d.time, 701)[1:]
    states = simulate(k, mu, x, times)
    return crossing(times, states[:, 3], d.threshold), d.time


@pytest.mark.few(2)
@pytest.mark.parametrize("launch", [False, True])
@pytest.mark.parametrize(("k", "mu"), [(0.25, 0.3), (0.5, 2.0)])
def test_simulations_of_the_full_equations_cross_the_threshold_when_told(
    k: float, mu: float, launch: bool
) -> None:
    w0 = 1.5 / (2 * k) ** 0.5
    off = []
    for tilt in (0.06, 0.03):
        found, told = time_to_threshold(k, mu, w0, tilt, launch)
        off.append(found / told - 1)
    assert abs(off[1]) < 0.012
    assert np.log2(off[0] / off[1]) == pytest.approx(2, abs=0.35)


@pytest.mark.long
@pytest.mark.parametrize("launch", [False, True])
@pytest.mark.parametrize("k", [0.25, 0.3, 0.5])
@pytest.mark.parametrize("mu", [0.1, 1.0, 5.0])
def test_simulations_over_the_whole_long_time(k: float, mu: float, launch: bool) -> None:
    for ratio in (1.5, 2.5):
        found, told = time_to_threshold(k, mu, ratio / (2 * k) ** 0.5, 0.01, launch, 1.006)
        print(f"k {k} mu {mu} ratio {ratio} launch {launch}: T {found:.6g}, formula {told:.6g}")
        assert abs(found / told - 1) < 0.003


def test_the_launch_changes_the_tilt_at_first_order() -> None:
    """After the transient the mean tilt is that of the formula, not that of the launch."""
    k, mu, w0 = 0.25, 1.0, 1.6
    off = []
    for tilt in (0.02, 0.01):
        times = np.linspace(0, 260, 2601)[1:]
        states = simulate(k, mu, [np.pi / 2 + tilt, 0, 0, w0, 0, 0], times)
        d = st.drift(at=w0, tilt=tilt, contact=st.Viscous(mu))
        late = states[-400:, 0].mean() - np.pi / 2
        off.append(late / d.tilt_start - 1)
        assert abs(late / tilt - 1) > 0.1
    assert abs(off[1]) < 2e-3
    assert abs(off[1]) < abs(off[0]) / 2.5


def test_scales_are_carried() -> None:
    coin = st.Disk(mass=0.00567, radius=0.01213, gravity=9.81)
    rate, speed = float(coin.rate), float(coin.speed)
    si = st.drift(at=2.0 * rate, tilt=0.01, disk=coin, contact=st.Viscous(0.4 / speed))
    plain = st.drift(at=2.0, tilt=0.01, contact=st.Viscous(0.4))
    linear = st.drift(at=2.0, tilt=-0.01, contact=st.LinearViscous(0.4))
    assert si.time * rate == pytest.approx(plain.time, rel=1e-13)
    assert si.spin_rate / rate**2 == pytest.approx(plain.spin_rate, rel=1e-13)
    assert si.threshold / rate == pytest.approx(plain.threshold, rel=1e-13)
    assert linear.time == plain.time


@pytest.mark.parametrize(
    ("options", "sentence"),
    [
        ({"at": 1.0}, "not beyond the threshold"),
        ({"tilt": 0.0}, "tilt is 0"),
        ({"tilt": 2.0}, "small angle"),
        ({"tilt": 1.5}, "past π/2"),
        ({"tilt": 1.5, "launch": False, "at": 5.0}, "past π/2"),
        ({"contact": st.Rough()}, "law with friction"),
        ({"contact": None}, "contact is missing; give Viscous"),
        ({"tilt": float("nan")}, "tilt is nan"),
        ({"launch": 1}, "launch is 1"),
    ],
)
def test_drifts_that_cannot_be_are_refused(options: dict[str, Any], sentence: str) -> None:
    with pytest.raises(st.StabilityError, match=sentence):
        st.drift(**({"at": 2.0, "tilt": 0.01, "contact": st.Viscous(0.3)} | options))


def test_the_printed_formulas_are_the_computed_ones() -> None:
    text = FORMULAS["time"].split("=", 1)[1]
    names = {"k": 0.3, "mu": 0.7, "w0": 1.9, "tilt": 0.01, "log": np.log, "sqrt": np.sqrt}
    for power in ("(2k+1)", "(2k)"):
        text = text.replace(power, power.replace("2k", "2*k"))
    text = text.replace("mu (", "mu*(").replace("^3 w0", "^3*w0").replace("2 (", "2*(")
    text = text.replace(") w0", ")*w0").replace(") tilt", ")*tilt").replace("2k", "2*k")
    text = text.replace("sqrt(2*k)", "sqrt(2*k)").replace("w0 sqrt", "w0*sqrt").replace(")(", ")*(")
    value = eval(text.replace("^", "**"), {}, names)
    d = st.drift(at=1.9, tilt=0.01, disk=st.Disk(k=0.3), contact=st.Viscous(0.7), launch=False)
    assert value == pytest.approx(d.time, rel=1e-13)


def test_however_small_the_tilt_the_spin_falls_by_the_same_and_stays_near_the_line() -> None:
    """Lyapunov-unstable: the time grows like tilt⁻², the fall does not shrink."""
    w0, mu = 1.6, 0.3
    for tilt in (0.04, 0.02, 0.01):
        d = st.drift(at=w0, tilt=tilt, contact=st.Viscous(mu))
        run = simulate(0.25, mu, [np.pi / 2 + tilt, 0, 0, w0, 0, 0], [d.time])
        spin, lean = run[-1][3], abs(run[-1][0] - np.pi / 2)
        assert w0 - spin == pytest.approx(w0 - d.threshold, abs=tilt**2)
        assert lean < 1.3 * tilt  # the distance to the line of rolling until then


def test_without_a_slow_tilt_rolling_is_reached_and_stays() -> None:
    """θ = π/2, θ̇ = φ̇ = v_x = 0 is invariant, and tends to rolling: codimension one of the rest."""
    from stability.algebra.number_types import casadi_algebra
    from stability.algebra.program import Program
    from stability.algebra.upright import UPRIGHT

    system = st.disk_system("viscous")
    import casadi as ca

    w, vy = ca.SX.sym("w"), ca.SX.sym("vy")
    graph = Program(ca.Function("f", [system.x, system.p], [system.rhs]))
    zero = ca.SX(0)
    values = graph.run(
        casadi_algebra(), [[UPRIGHT, zero, zero, w, zero, vy], ca.vertsplit(system.p)]
    )
    rates = dict(zip((row for row, _ in graph.places[0]), values[0], strict=True))
    for held in (0, 1, 2, 4):
        assert held not in rates or ca.simplify(ca.SX(rates[held])).is_zero()
    k, mu = 0.25, 0.3
    rate = ca.Function("r", [w, vy, system.p], [rates[5]])
    # v_y falls like exp(-mu (1 + 1/2k) t), gn = 1
    assert float(rate(1.7, 0.2, [k, mu])) == pytest.approx(-mu * (1 + 1 / (2 * k)) * 0.2, rel=1e-14)
