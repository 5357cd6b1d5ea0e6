"""Rough and smooth motions keep their integrals, and meet their quadratures."""

from typing import Any

import mpmath
import numpy as np
import pytest
import reference

import stability as st
from stability.bodies.newton_euler import STATES
from stability.integrators import taylor

CONTACT = {"rough": st.Rough(), "smooth": st.Smooth()}
TWO = [
    "dop853",
    pytest.param(
        "heyoka", marks=pytest.mark.skipif(not taylor.available(), reason="heyoka is an extra")
    ),
]
TAYLOR = pytest.mark.skipif(not taylor.available(), reason="heyoka is an extra")
LONG = [
    ("dop853", 8.0, 3),
    pytest.param("dop853", 1000.0, 41, marks=pytest.mark.long),
    pytest.param("heyoka", 1000.0, 9, marks=TAYLOR),
    pytest.param("heyoka", 1000.0, 41, marks=[TAYLOR, pytest.mark.long]),
]
LAUNCH = [1.3, 0.1, 0.4, 1.1, 0.0, 0.0]


def legendre(theta: float, phi_dot: float, omega3: float, k: float) -> tuple[float, float]:
    """C1, C2 of omega3 = C1 P_ν(cosθ) + C2 P_ν(−cosθ), ν(ν+1) = −2/(2k+1)."""
    with mpmath.workdps(25):
        nu = mpmath.findroot(
            lambda n: n * (n + 1) + mpmath.mpf(2) / (2 * mpmath.mpf(k) + 1), mpmath.mpc(-0.5, 1)
        )
        c = mpmath.cos(mpmath.mpf(theta))

        def p(x: Any) -> Any:
            return mpmath.legenp(nu, 0, x)

        def slope(x: Any) -> Any:  # (1 − x²) P' = (ν + 1)(x P_ν − P_{ν+1})
            return (nu + 1) * (x * p(x) - mpmath.legenp(nu + 1, 0, x)) / (1 - x * x)

        # dω₃/dc = −φ̇/(2k + 1)
        matrix = mpmath.matrix([[p(c), p(-c)], [slope(c), -slope(-c)]])
        right = mpmath.matrix([mpmath.mpf(omega3), -mpmath.mpf(phi_dot) / (2 * mpmath.mpf(k) + 1)])
        one, two = mpmath.lu_solve(matrix, right)
        return float(one.real), float(two.real)


def columns(run: Any) -> Any:
    return np.stack([run[name].values for name in STATES], axis=-1)


@pytest.mark.few(4)
@pytest.mark.parametrize("kind", ["rough", "smooth"])
@pytest.mark.parametrize("method", [*TWO, "lsoda"])
@pytest.mark.parametrize("share", [0.05, pytest.param(1.0, marks=pytest.mark.long)])
def test_states_and_pose_meet_the_quadrature(kind: str, method: str, share: float) -> None:
    cases = reference.closed()[kind]
    for case in cases if share == 1 else cases[-2:]:
        times = np.array([float(t) for t in case["times"]])
        keep = times <= share * (1000 if method == "heyoka" else 100)
        assert keep.any()
        run = st.simulate(
            st.Disk(k=float(case["k"])),
            CONTACT[kind],
            [float(v) for v in case["start"]],
            times[keep],
            method=method,
            tolerance=1e-15,
            pose=True,
        )
        exact = np.array(case["states"], dtype=float)[keep]
        pose = np.array(case["pose"], dtype=float)[keep]
        mine = np.stack([run[n].values for n in ("phi", "psi", "centre_x", "centre_y")], axis=-1)
        allowed = 1e-8 if method == "lsoda" else 1e-9
        assert np.abs(columns(run) - exact).max() < allowed
        assert np.abs(mine - pose).max() < allowed * max(1.0, np.abs(pose).max())


@pytest.mark.parametrize(("method", "last", "count"), LONG)
@pytest.mark.parametrize("k", [0.25, pytest.param(0.5, marks=pytest.mark.long)])
def test_the_rough_disk_keeps_both_legendre_integrals(
    method: str, last: float, count: int, k: float
) -> None:
    times = np.linspace(0, last, count)
    run = st.simulate(st.Disk(k=k), st.Rough(), LAUNCH, times, method=method, tolerance=1e-16)
    six = columns(run)
    found = np.array([legendre(x[0], x[2], x[3], k) for x in six])
    assert np.abs(found - found[0]).max() < 1e-11 * np.abs(found[0]).max()
    assert float(run.energy_error) < 1e-11
    assert np.ptp(six[:, 0]) > 0.1  # it moved


@pytest.mark.parametrize(("method", "last", "count"), LONG)
def test_the_smooth_disk_keeps_its_three_integrals(method: str, last: float, count: int) -> None:
    k = 0.3
    start = [1.3, 0.1, 0.4, 1.1, 0.2, -0.3]
    run = st.simulate(
        st.Disk(k=k),
        st.Smooth(),
        start,
        np.linspace(0, last, count),
        method=method,
        tolerance=1e-16,
    )
    theta, _, phi_dot, omega3, _, _ = columns(run).T
    vertical = k * phi_dot * np.sin(theta) ** 2 + 2 * k * omega3 * np.cos(theta)
    for kept in (vertical, omega3, run.energy.values):
        assert np.abs(kept - kept[0]).max() < 1e-11 * np.abs(kept[0])
    assert np.ptp(theta) > 0.1


@pytest.mark.parametrize("kind", ["rough", "smooth"])
def test_the_nutation_period_is_that_of_the_quadrature(kind: str) -> None:
    case = reference.closed()[kind][0]
    period = float(case["period"])
    start = [float(v) for v in case["start"]]
    run = st.simulate(
        st.Disk(k=float(case["k"])),
        CONTACT[kind],
        start,
        [period, 7 * period],
        tolerance=1e-14,
        pose=True,
    )
    assert np.abs(columns(run)[:, :4] - np.array(start)[:4]).max() < 1e-10
    advance = run.phi.values / np.array([1, 7])
    assert np.abs(advance - float(case["phi_advance"])).max() < 1e-10


@pytest.mark.few(1)
@pytest.mark.parametrize("method", ["heyoka", "dop853"])
def test_the_order_of_convergence_shows(method: str) -> None:
    # the error of a run falls with the tolerance, over six decades of it
    if method == "heyoka" and not taylor.available():
        pytest.skip("heyoka is an extra")
    case = reference.closed()["rough"][0]
    times = np.array(case["times"], dtype=float)
    at = int(np.flatnonzero(times == 20)[0])
    exact = np.array(case["states"], dtype=float)[at]
    errors = []
    for tolerance in (1e-4, 1e-7, 1e-10):
        run = st.simulate(
            st.Disk(k=float(case["k"])),
            st.Rough(),
            [float(v) for v in case["start"]],
            [times[at]],
            method=method,
            tolerance=tolerance,
        )
        errors.append(np.abs(columns(run)[-1] - exact).max())
    # heyoka's order rises as the tolerance falls, so only the whole is in proportion
    assert errors[0] > errors[1] > errors[2]
    assert 0.7 < np.log10(errors[0] / errors[2]) / 6 < 1.3
