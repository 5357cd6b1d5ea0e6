"""Flutter on lines of steady motions: normal form, another derivation, simulations."""

from typing import Any

import boundary_oracle as oracle
import mpmath
import numpy as np
import pytest
from reference import beyond
from simulation import simulate

import stability as st
from stability.algebra.number_types import precision
from stability.bodies.disk_polynomials import exact_polynomial
from stability.boundary.hopf import HopfKind, hopf, pair_at
from stability.boundary.lyapunov_coefficient import line_form

POINTS = beyond()["hopf"]


def exact_side(family: str, law: str) -> Any:
    """The flutter polynomial and its derivative along the line, which decide the type exactly.

    Energy rises with the family parameter along both lines and falls while the contact slips, so c
    is negative.  The sign of Re μ' is minus that of the derivative of the condition.
    """
    known = exact_polynomial(family, law)
    [flutter] = [p for kind, p in known.conditions if kind == "flutter"]
    return flutter, flutter.derivative(known.variables[-1])


@pytest.mark.parametrize("entry", POINTS, ids=lambda e: "{family}-k{k:.4g}-mu{mu:.4g}".format(**e))
def test_the_normal_form_is_that_of_an_independent_derivation(entry: dict[str, Any]) -> None:
    family = st.disk_family(entry["family"], "viscous")
    at = np.array([float(entry["boundary_str"])])
    with precision(256):
        pair = pair_at(family, at[0], [entry["k"], entry["mu"]])
        form = line_form(pair)
    crossing, push = float(form.speed.mid()), float(form.push.mid())
    mode = np.array([complex(float(v.real.mid()), float(v.imag.mid())) for v in pair.mode])
    assert crossing == pytest.approx(entry["re_mu_prime"], rel=1e-6, abs=1e-10)
    assert push == pytest.approx(entry["c"], rel=1e-7)
    assert float(form.speed.rad()) <= 1e-60 and float(form.push.rad()) <= 1e-60
    assert np.linalg.norm(mode) == pytest.approx(1)
    # c by energy: dE/dy c = -2 mu |slip of the mode|², which needs no second derivative
    slope = {"spinning": entry["k"] * at[0], "tumbling": 1.5 * np.cos(at[0])}[entry["family"]]
    by_energy = -2 * entry["mu"] * (np.abs(mode[4:]) ** 2).sum() / slope
    assert push == pytest.approx(by_energy, rel=1e-7)
    kind = "elliptic" if crossing * push < 0 else "hyperbolic"
    assert kind == entry["type"]


@pytest.mark.parametrize("entry", POINTS, ids=lambda e: "{family}-k{k:.4g}-mu{mu:.4g}".format(**e))
def test_the_exact_condition_gives_the_same_type(entry: dict[str, Any]) -> None:
    """Re μ' has the sign of minus the condition's slope along the line, by exact polynomials."""
    _, slope = exact_side(entry["family"], "viscous")
    at = float(entry["boundary_str"])
    x = np.sin(at) if entry["family"] == "tumbling" else at**2
    falls = slope(entry["k"], entry["mu"] ** 2, x) < 0
    assert falls == (entry["re_mu_prime"] > 0) == (entry["type"] == "elliptic")
    assert falls == (entry["stable_side"] == "y<0")


def test_spinning_is_elliptic_wherever_it_flutters() -> None:
    for k in (0.05, 0.25, 0.5):
        low, high = 4 * k / (2 * k + 1) ** 2, 24 * k / ((2 * k + 1) * (4 * k + 3))
        for share in (0.2, 0.8):
            mu = (low + share * (high - low)) ** 0.5
            [found] = hopf("spinning", disk=st.Disk(k=k), contact=st.Viscous(mu))
            assert (found.kind, found.stable_below) == (HopfKind.ELLIPTIC, True)
        for mu in (0.9 * low**0.5, 1.1 * high**0.5):
            assert hopf("spinning", disk=st.Disk(k=k), contact=st.Viscous(mu)) == []


def test_spinnings_boundary_is_found_however_near_it_is_to_the_static_one() -> None:
    """At mu = 1 it reaches phi_dot = 2 (k = 1/4: M2 = 1); Sturm on Kane's polynomial."""
    body = {"k": 0.25, "mass": 1.0, "radius": 1.0, "gravity": 1.0}
    for mu in (0.99, 1 - 1e-4, 1 - 1e-9, float(np.nextafter(1.0, 0))):
        [found] = hopf("spinning", contact=st.Viscous(mu))
        static, truth = oracle.changes("spinning", "viscous", "at", 0.05, 1e4, body | {"mu": mu})
        assert abs(static.value - 2) < 1e-30 < abs(truth.value - 2)
        assert abs(found.at - truth.value) <= np.spacing(found.at)
        assert (found.kind, found.stable_below) == (HopfKind.ELLIPTIC, True)
    assert hopf("spinning", contact=st.Viscous(0.99))[0].at == 2.014224033564628
    assert hopf("spinning", contact=st.Viscous(1.0)) == []


def quintic(family: str, k: Any, m: Any, x: Any) -> list[Any]:
    """Coefficients by powers of σ = λ/mu at z = at² or s = sinθ."""
    z, s = (x, 1) if family == "spinning" else (1, x)
    return [
        mpmath.fsum(c * k**a * m**b * z**e * s**f for c, a, b, e, f in terms)
        for terms in oracle.polynomials()[f"{family} viscous"]
    ]


@pytest.mark.parametrize(
    ("family", "k", "mu", "at", "crossing"),
    [
        ("tumbling", 0.5, 0.02, 0.0011999991360014308, -1.92e-12),
        ("tumbling", 0.5, 0.005, 7.4999999789e-05, None),
        ("tumbling", 0.5, 1e-4, None, None),
        ("tumbling", 0.375, 0.9, None, None),
        ("spinning", 0.25, 0.99, 2.014224033564628, None),
        ("spinning", 0.02, 0.29, None, None),
    ],
)
def test_the_pairs_speed_has_the_sign_and_size_of_kanes_quintic(
    family: str, k: float, mu: float, at: float | None, crossing: float | None
) -> None:
    """Re dλ/dat = -Re (∂χ/∂at)/(∂χ/∂λ) in 60 digits, beyond what double precision sees."""
    points = hopf(family, disk=st.Disk(k=k), contact=st.Viscous(mu))
    if at is not None:
        assert [p.at for p in points] == [pytest.approx(at, rel=1e-10)]
    with mpmath.workdps(60):
        for point in points:
            place = mpmath.sin if family == "tumbling" else lambda v: v * v

            def chi(lam: Any, where: Any, place: Any = place) -> Any:
                a = quintic(family, mpmath.mpf(k), mpmath.mpf(mu) ** 2, place(where))
                return mpmath.polyval(a[::-1], lam / mpmath.mpf(mu))

            where = mpmath.mpf(point.at)
            root = mpmath.findroot(
                lambda v, f=chi, w=where: f(v, w), 1j * point.frequency, tol=1e-70
            )
            assert abs(root.real) <= 1e-14 * abs(root)
            step = where * mpmath.mpf(10) ** -20
            slope = (chi(root, where + step) - chi(root, where - step)) / (2 * step)
            h = root * mpmath.mpf(10) ** -20
            turn = (chi(root + h, where) - chi(root - h, where)) / (2 * h)
            truth = -(slope / turn).real
            assert point.crossing == pytest.approx(float(truth), rel=1e-9)
            assert point.kind is not HopfKind.DEGENERATE
            assert (point.crossing > 0) == point.stable_below
            assert (point.kind is HopfKind.ELLIPTIC) == (point.crossing > 0)
    if crossing is not None:
        assert points[0].crossing == pytest.approx(crossing, rel=1e-5)


def test_tumblings_boundaries_are_those_of_the_closed_form() -> None:
    """A N² + B N + C with N = M sinθ and x = cos²θ: stable for every mu, or below M_b(θ).

    The number of hopf points is that of crossings of M_b by mu², counted on a fine scan.
    """
    rng = np.random.default_rng(3)
    for k in (0.05, 0.2, 0.27, 0.28, 0.32, 0.335, 0.4, 0.45, 0.49, 0.5):
        theta = np.concatenate([np.geomspace(1e-7, 0.01, 4000), np.linspace(0.01, 1.5707, 40000)])
        x = np.cos(theta) ** 2
        a = (
            (2 * k + 1) ** 2
            * (k * (4 * k + 3) + (2 * k + 1) * x)
            * ((1 - 3 * k) * (1 + 2 * k) * x - k)
        )
        b = (
            4
            * k
            * (2 * k + 1)
            * (6 * k**2 + k * (8 - 25 * k) * x + (2 - 7 * k + 9 * k**2 - 36 * k**3) * x**2)
        )
        c = 96 * k**3 * x * (k + (1 - 3 * k) * x)
        root = np.sqrt(np.maximum(b * b - 4 * a * c, 0))
        with np.errstate(all="ignore"):
            bound = np.where(a >= 0, np.inf, 2 * c / ((root - b) * np.sin(theta)))
        for mu2 in (*rng.uniform(0.05, 3, 3), 10 ** rng.uniform(-5, 1)):
            stable = bound > mu2
            places = theta[np.flatnonzero(stable[1:] != stable[:-1])]
            points = hopf("tumbling", disk=st.Disk(k=k), contact=st.Viscous(float(mu2) ** 0.5))
            assert [p.at for p in points] == pytest.approx(list(places), rel=5e-3, abs=1e-4)
            assert all(p.kind is not HopfKind.DEGENERATE for p in points)


def test_random_lines_have_every_flutter_boundary() -> None:
    """Any k, mu over eight decades: places by Sturm on Kane's polynomial, type by its slope."""
    rng = np.random.default_rng(21)
    seen = 0
    for _ in range(14):
        k, mu = float(rng.uniform(0.005, 0.5)), float(10 ** rng.uniform(-4, 4))
        if rng.random() < 0.5:
            mu = float(rng.uniform(0.2, 1.2))
        body = {"k": k, "mass": 1.0, "radius": 1.0, "gravity": 1.0, "mu": mu}
        for family, ends in (("spinning", (1e-3, 1e6)), ("tumbling", (1e-12, 1.5707963))):
            wanted = oracle.changes(family, "viscous", "at", *ends, body)
            if family == "spinning":  # the static boundary k at² = 1 is none of these
                with mpmath.workdps(40):
                    wanted = [c for c in wanted if abs(k * c.value**2 - 1) > 1e-25]
            found = hopf(family, disk=st.Disk(k=k), contact=st.Viscous(mu))
            seen += len(found)
            assert [p.at for p in found] == pytest.approx(
                [float(c.value) for c in wanted], rel=1e-15
            )
            assert [p.stable_below for p in found] == [c.stable_below for c in wanted]
            assert all((p.kind is HopfKind.ELLIPTIC) == p.stable_below for p in found)
    assert seen > 4


@pytest.mark.parametrize("fold", beyond()["folds"], ids=lambda f: f"k{f['k']}")
def test_transversality_fails_at_the_fold_of_tumblings_boundary(fold: dict[str, float]) -> None:
    """Condition and slope vanish together at the fold; near it the two types meet."""
    condition, slope = exact_side("tumbling", "viscous")
    point = fold["k"], fold["mu"] ** 2, np.sin(fold["theta"])
    scale = sum(p(*point) for p in condition.parts)
    assert abs(condition(*point)) < 1e-9 * scale
    assert abs(slope(*point)) < 1e-7 * sum(p(*point) for p in slope.parts)
    disk = st.Disk(k=fold["k"])
    assert hopf("tumbling", disk=disk, contact=st.Viscous(fold["mu"] - 1e-4)) == []
    pair = hopf("tumbling", disk=disk, contact=st.Viscous(fold["mu"] + 1e-4), points=3000)
    assert [p.kind for p in pair] == [HopfKind.ELLIPTIC, HopfKind.HYPERBOLIC]
    assert abs(pair[0].crossing) < 1e-3 and abs(pair[1].crossing) < 1e-3


def test_folds_are_born_where_an_independent_derivation_says() -> None:
    """The fold reaches upright, where the condition and its slope vanish at once, at one k."""
    import sympy

    from stability.derivation.formulas import expression

    k, m, s = sympy.symbols("k M s")
    condition, slope = (expression(p) for p in exact_side("tumbling", "viscous"))
    upright = 24 * k / ((2 * k + 1) * (4 * k + 3))
    assert sympy.simplify(condition.subs({s: 1, m: upright})) == 0
    left = sympy.fraction(sympy.together(slope.subs({s: 1, m: upright})))[0]
    factors = [f for f, _ in sympy.factor_list(left)[1]]
    assert 128 * k**3 + 196 * k**2 + 31 * k - 36 in factors
    [birth] = [r for f in factors for r in sympy.real_roots(f, k) if 0 < r < sympy.Rational(1, 2)]
    assert float(birth) == pytest.approx(0.329136518894768, abs=1e-14)


def member(family: str, at: float, k: float, mu: float) -> Any:
    return st.disk_family(family, "viscous").member([at], [k, mu])


def ends_at(point: Any, family: str, k: float, mu: float, y: float, z: float, time: float) -> Any:
    start = member(family, point.at + y, k, mu) + 2 * z * point.mode.real
    states = simulate(k, mu, start, np.linspace(0, time, 41)[1:], 1e-10)
    return states[:, 2 if family == "spinning" else 0] - point.at, states


@pytest.mark.long
@pytest.mark.parametrize(
    ("family", "k", "mu"),
    [pytest.param("spinning", 0.25, 0.8, marks=pytest.mark.long), ("tumbling", 0.25, 1.5)],
)
def test_elliptic_a_motion_near_the_unstable_part_settles_as_far_beyond(
    family: str, k: float, mu: float
) -> None:
    [point] = hopf(family, disk=st.Disk(k=k), contact=st.Viscous(mu))
    assert point.kind is HopfKind.ELLIPTIC and point.stable_below
    ratio = []
    for y in (0.1, 0.05):
        time = 60 / (point.crossing * y)
        path, states = ends_at(point, family, k, mu, y, 1e-3 * y, time)
        assert np.abs(states[-1, [1, 3, 4, 5]]).max() < 1e-3 * y  # on the line again
        ratio.append(path[-1] / point.landing(y))
    assert abs(ratio[1] - 1) < 0.12
    assert (1 - ratio[0]) / (1 - ratio[1]) == pytest.approx(2, abs=0.4)  # first order in y


@pytest.mark.long
def test_hyperbolic_a_motion_leaves_the_unstable_part_and_settles_only_inside_the_cone() -> None:
    k, mu = 0.5, 1.0
    [point] = hopf("tumbling", disk=st.Disk(k=k), contact=st.Viscous(mu))
    assert point.kind is HopfKind.HYPERBOLIC and not point.stable_below
    assert point.landing(-0.05) is None
    path, _ = ends_at(point, "tumbling", k, mu, -0.1, 0.05, 600.0)
    assert path[-5:].max() < -0.9  # towards flat, and not back
    # the stable side: |z| = A √(Re μ'/c) y settles for A < 1 near y √(1 - A²)
    cone = (point.crossing / point.push) ** 0.5
    off = []
    for y in (0.04, 0.02):
        z = 0.6 * cone * y
        path, _ = ends_at(point, "tumbling", k, mu, y, z, 120 / (abs(point.crossing) * y))
        off.append(abs(path[-1] / point.landing(y, z) - 1))
    assert off[1] < 0.1
    assert off[1] < 0.7 * off[0]
    assert point.landing(0.04, 1.2 * cone * 0.04) is None


def test_both_sides_of_the_line_do_what_the_spectrum_says() -> None:
    [point] = hopf("spinning", contact=st.Viscous(0.8))
    for y, wanted in ((0.1, "unstable"), (-0.1, "stable")):
        spectrum = st.spectrum("spinning", at=point.at + y, contact=st.Viscous(0.8), certify=True)
        assert spectrum.verdict.word == wanted
        assert spectrum.abscissa == pytest.approx(point.crossing * y, rel=0.15)


def test_units_are_carried() -> None:
    coin = st.Disk(mass=1.0, radius=0.012, gravity=9.81)
    rate, speed = float(coin.rate), float(coin.speed)
    [si] = hopf("spinning", disk=coin, contact=st.Viscous(0.8 / speed))
    [plain] = hopf("spinning", contact=st.Viscous(0.8))
    assert si.at / rate == pytest.approx(plain.at, rel=1e-13)
    assert si.frequency / rate == pytest.approx(plain.frequency, rel=1e-10)
    assert si.crossing == pytest.approx(plain.crossing, rel=1e-6)
    assert si.landing(0.01 * rate) == pytest.approx(-0.01 * rate)


@pytest.mark.parametrize(
    ("family", "law", "sentence"),
    [
        ("rolling", st.Viscous(1), "passes its own slowly"),
        ("spinning", st.Rough(), "friction"),
        ("hopping", st.Viscous(1), "family is 'hopping'"),
    ],
)
def test_questions_without_such_a_boundary_are_refused(
    family: str, law: Any, sentence: str
) -> None:
    with pytest.raises(st.StabilityError, match=sentence):
        hopf(family, contact=law)


@pytest.mark.long
def test_beside_a_hyperbolic_point_a_motion_may_come_back_to_the_family_elsewhere() -> None:
    # 0.4 said that it leaves the line for good; the statement is local
    disk, mu = st.Disk(k=0.375), np.sqrt(0.8)
    found = st.hopf("tumbling", disk=disk, contact=st.Viscous(mu))
    hyperbolic = next(p for p in found if p.kind is HopfKind.HYPERBOLIC)
    assert hyperbolic.at == pytest.approx(0.8139, abs=1e-4)
    at = hyperbolic.at - 0.02
    side = st.spectrum("tumbling", at=at, disk=disk, contact=st.Viscous(mu))
    assert side.verdict is st.Verdict.UNSTABLE
    start = st.launch("tumbling", at=at, tilt=0.0, disk=disk)
    start[1] += 0.03
    run = st.simulate(disk, st.Viscous(mu), start, [3e4], check=False)
    assert run.attrs["outcome"] == "settled"
    assert str(run.nearest_family.values) == "tumbling"
    assert 0.40 < float(run.nearest_at) < 0.42  # on the stable part beyond the elliptic point
    assert "neighbourhood" in HopfKind.HYPERBOLIC.value
