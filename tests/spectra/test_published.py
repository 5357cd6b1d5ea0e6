"""Thresholds and numbers from the literature, each with its source (see the docstrings)."""

import casadi as ca
import numpy as np
import pytest
from scipy.special import lpmv

import stability as st

KS = (0.25, 0.3125, 0.5, 0.01)


@pytest.mark.parametrize("k", KS)
@pytest.mark.parametrize(
    ("family", "law", "square"),
    [
        # straight rolling and spinning without slip: e.g. Le Saux, Leine & Glocker 2005;
        # g/3R for the disk, g/4R for the hoop
        ("rolling", st.Rough(), lambda k: 1 / (2 * (2 * k + 1))),
        ("spinning", st.Rough(), lambda k: 1 / (1 + k)),
        # the top on a smooth plane
        ("rolling", st.Smooth(), lambda k: 1 / (4 * k)),
        ("spinning", st.Smooth(), lambda k: 1 / k),
    ],
    ids=["rolling-rough", "spinning-rough", "rolling-smooth", "spinning-smooth"],
)
def test_conservative_thresholds(family: str, law, square, k: float) -> None:
    [point] = st.boundaries(
        family, axis=("at", 0.05, 40, 201, "log"), disk=st.Disk(k=k), contact=law
    )
    assert point.value**2 == pytest.approx(square(k), rel=1e-14)
    assert abs(point.value - square(k) ** 0.5) <= 2 * point.error + 1e-16
    assert not point.stable_below


def test_thresholds_in_si_units() -> None:
    disk = st.Disk.named("le-saux")
    [point] = st.boundaries("rolling", axis=("at", 1, 30, 99), disk=disk, contact=st.Rough())
    assert point.value**2 == pytest.approx(9.81 / (3 * 0.05), rel=1e-14)


def test_tumbling_meets_spinning_at_phi_dot_squared_g_over_k_r() -> None:
    disk = st.Disk(mass=0.3048, radius=0.05, gravity=9.81)
    state = st.disk_family("tumbling", "viscous").member([np.pi / 2], [0.25, 1.0])
    phi_dot = state[2] * disk.rate
    assert phi_dot**2 == pytest.approx(9.81 / (0.25 * 0.05), rel=1e-14)
    [point] = st.boundaries("spinning", axis=("at", 5, 60, 99), disk=disk, contact=st.Viscous(0.1))
    assert point.value == pytest.approx(phi_dot, rel=1e-14)


def test_relative_spin_of_y_as_2017() -> None:
    """Y. As, Technion student report 2017: R = 0.5, lean 10°, precession 0.5 rad/s: -4.6851."""
    disk = st.Disk(mass=1.0, radius=0.5, gravity=9.81)
    theta, phi_dot = np.radians(80), 0.5
    state = st.disk_family("circling", "rough").member([theta, phi_dot * disk.time], [0.25])
    relative = state[3] * disk.rate - phi_dot * np.cos(theta)
    assert relative == pytest.approx(-4.6851, abs=5e-5)


def test_circling_of_le_saux_leine_and_glocker_2005() -> None:
    """J. Nonlinear Sci. 15:27-61, eq. (5.10)-(5.12): k = 1/4, Rc = 10 r, lean 5°."""
    g, r, lean, ratio, k = 9.81, 0.05, np.radians(5), 0.1, 0.25
    square = g * np.tan(lean) / (r * ratio * ((1 + 2 * k) - (1 + k) * ratio * np.sin(lean)))
    published = 10.7364981632612
    assert np.sqrt(square) == pytest.approx(published, rel=1e-14)
    disk = st.Disk(mass=1.0, radius=r, gravity=g)
    theta, precession = np.pi / 2 - lean, 1.07364981632612
    state = st.disk_family("circling", "rough").member([theta, precession * disk.time], [k])
    relative = state[3] * disk.rate - precession * np.cos(theta)
    assert abs(relative) == pytest.approx(published, rel=1e-13)
    assert 2 * np.pi / precession == pytest.approx(5.852173782957, rel=1e-12)
    found = st.spectrum("circling", at=(theta, precession), disk=disk, contact=st.Rough())
    assert found.verdict.word in ("neutral", "unstable")


@pytest.mark.parametrize(
    ("k", "last"),
    [(0.25, 2.0), *(pytest.param(k, 6.0, marks=pytest.mark.long) for k in (0.25, 0.5))],
)
def test_rough_motions_keep_both_legendre_integrals(k: float, last: float) -> None:
    """ω₃ = C₁ P_ν(cosθ) + C₂ P_ν(-cosθ), ν(ν+1) = -2/(2k+1): dω₃/dt from the graph fits.

    C₁ and C₂ are fitted to a simulated motion; ν(ν+1) = -2/(2k+1).
    """
    from scipy.integrate import solve_ivp

    system = st.disk_system("rough")
    start = np.array([1.1, 0.3, 0.7, 0.5])
    run = solve_ivp(
        lambda _, x: system.rates(x, [k]), (0, last), start, method="DOP853", rtol=1e-12, atol=1e-13
    )
    nu = -0.5 + np.sqrt(complex(0.25 - 2 / (2 * k + 1)))
    u, spin = np.cos(run.y[0]), run.y[3]
    basis = np.array([[_legendre(nu, v), _legendre(nu, -v)] for v in u])
    constants, *_ = np.linalg.lstsq(basis, spin, rcond=None)
    assert np.ptp(u) > 0.2
    assert np.abs(basis @ constants - spin).max() < 1e-9


def _legendre(nu: complex, x: float) -> float:
    """P_ν(x) by mpmath, whose hypergeometric function shares nothing with the package."""
    import mpmath

    return float(mpmath.re(mpmath.legenp(nu, 0, x)))


def test_scipy_and_mpmath_agree_on_the_legendre_function() -> None:
    assert lpmv(0, 2, 0.3) == pytest.approx(_legendre(2, 0.3))


# --- the bicycle: a system of the user's own, through the same spectrum ---

MASS = np.array([[80.81722, 2.31941332208709], [2.31941332208709, 0.29784188199686]])
C1 = np.array([[0, 33.86641391492494], [-0.85035641456978, 1.68540397397560]])
K0 = np.array([[-80.95, -2.59951685249872], [-2.59951685249872, -0.80329488458618]])
K2 = np.array([[0, 76.59734589573222], [0, 2.65431523794604]])


def bicycle() -> st.Family:
    """Meijaard, Papadopoulos, Ruina & Schwab, Proc. R. Soc. A 463 (2007) 1955-1982."""
    x, v, g = ca.SX.sym("x", 4), ca.SX.sym("v"), ca.SX.sym("g")
    force = -(v * ca.mtimes(ca.DM(C1), x[2:]) + ca.mtimes(g * ca.DM(K0) + v**2 * ca.DM(K2), x[:2]))
    system = st.System.from_mass_matrix(
        "bicycle",
        x,
        ca.vertcat(v, g),
        ca.SX(ca.DM(MASS)),
        force,
        unknowns=("d_lean_rate", "d_steer_rate"),
        rates={"lean": x[2], "steer": x[3]},
        states=("lean", "steer", "lean_rate", "steer_rate"),
        parameters=("v", "g"),
    )
    upright = dict.fromkeys(system.states, 0.0)
    return st.Family(system, "upright", at=("v",), held=upright, typical={"v": 5.0, "g": 9.81})


def test_bicycle_eigenvalues_at_5_metres_per_second() -> None:
    found = st.spectrum(bicycle(), at=5.0, g=9.81)
    published = [-14.0783896927982, -0.77534188219585, -0.77534188219585, -0.32286642900409]
    assert found.structural_zeros == 0
    assert np.abs(found.eigenvalues.real - published).max() < 1e-10
    # The paper's weave frequency is 4.464 867 713 788 23; one digit of it has been seen misprinted
    # (…866…), so the whole spectrum is also held against 40-digit arithmetic.
    assert np.abs(found.eigenvalues.imag[1:3] - [-4.46486771378823, 4.46486771378823]).max() < 1e-10
    assert np.abs(found.eigenvalues - forty_digits(5)).max() < 1e-11
    assert found.verdict is st.Verdict.STABLE


def forty_digits(speed: int) -> list[complex]:
    """Roots of det(M λ² + v C λ + K) by mpmath, sorted by real, then imaginary part."""
    import mpmath

    with mpmath.workdps(40):
        v, g = mpmath.mpf(speed), mpmath.mpf(981) / 100
        entries = {
            (i, j): [
                mpmath.mpf(MASS[i, j]),
                v * mpmath.mpf(C1[i, j]),
                g * mpmath.mpf(K0[i, j]) + v * v * mpmath.mpf(K2[i, j]),
            ]
            for i in (0, 1)
            for j in (0, 1)
        }
        product = [mpmath.mpf(0)] * 5
        for sign, left, right in ((1, (0, 0), (1, 1)), (-1, (0, 1), (1, 0))):
            for i, a in enumerate(entries[left]):
                for j, b in enumerate(entries[right]):
                    product[i + j] += sign * a * b
        roots = [complex(r) for r in mpmath.polyroots(product, maxsteps=200, extraprec=200)]
    return sorted(roots, key=lambda r: (round(r.real, 9), r.imag))


def test_bicycle_weave_and_capsize_speeds() -> None:
    weave, capsize = st.boundaries(bicycle(), axis=("v", 0.1, 10, 100), g=9.81)
    assert weave.value == pytest.approx(4.29238253634111, abs=1e-10)
    assert capsize.value == pytest.approx(6.02426201538837, abs=1e-10)
    assert (weave.crossing, capsize.crossing) == (st.Crossing.FLUTTER, st.Crossing.STATIC)
    assert weave.frequency > 0 == capsize.frequency
    assert max(weave.error, capsize.error) < 1e-14


def test_bicycle_eigenvalues_agree_with_a_companion_pencil_solved_by_scipy() -> None:
    from scipy.linalg import eig

    for v in (0.5, 3.0, 5.0, 8.0):
        stiffness = 9.81 * K0 + v**2 * K2
        a = np.block([[np.zeros((2, 2)), np.eye(2)], [-stiffness, -v * C1]])
        b = np.block([[np.eye(2), np.zeros((2, 2))], [np.zeros((2, 2)), MASS]])
        expected = eig(a, b, right=False)
        found = st.spectrum(bicycle(), at=v, g=9.81).eigenvalues
        assert np.abs(found[:, None] - expected).min(axis=1).max() < 1e-11
        assert np.abs(found[:, None] - expected).min(axis=0).max() < 1e-11


@pytest.mark.parametrize("size", [(6, 3), pytest.param((40, 30), marks=pytest.mark.long)])
def test_a_users_system_has_maps_too(size: tuple[int, int]) -> None:
    found = st.stability_map(bicycle(), x=("v", 1, 10, size[0]), y=("g", 5, 15, size[1]))
    assert found.abscissa.dims == ("g", "v")
    # both speeds scale with √g
    kinds = found.boundary_kind.values
    ratio = found.boundary_v.values / np.sqrt(found.boundary_g.values / 9.81)
    for kind, speed in ((1, 4.29238253634111), (0, 6.02426201538837)):
        assert np.abs(ratio[kinds == kind] - speed).max() < 1e-10
