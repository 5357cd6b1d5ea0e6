"""Flutter on lines of steady motions: normal form, another derivation, simulations."""

from typing import Any

import numpy as np
import pytest
from reference import beyond
from simulation import simulate

import stability as st
from stability.lines import HopfKind, exact_side, hopf, normal_form

POINTS = beyond()["hopf"]


@pytest.mark.parametrize("entry", POINTS, ids=lambda e: "{family}-k{k:.4g}-mu{mu:.4g}".format(**e))
def test_the_normal_form_is_that_of_an_independent_derivation(entry: dict[str, Any]) -> None:
    family = st.disk_family(entry["family"], "viscous")
    at = np.array([float(entry["boundary_str"])])
    crossing, push, mode, error = normal_form(family, at, np.array([entry["k"], entry["mu"]]))
    assert crossing == pytest.approx(entry["re_mu_prime"], rel=1e-6, abs=1e-10)
    assert push == pytest.approx(entry["c"], rel=1e-7)
    assert np.linalg.norm(mode) == pytest.approx(1)
    assert abs(crossing - entry["re_mu_prime"]) <= error[0] + 1e-6 * abs(crossing)
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


@pytest.mark.parametrize("fold", beyond()["folds"], ids=lambda f: f"k{f['k']}")
def test_transversality_fails_at_the_fold_of_tumblings_boundary(fold: dict[str, float]) -> None:
    """Condition and slope vanish together at the fold; beside it the two types meet."""
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

    from stability.formulas import expression

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


@pytest.mark.parametrize(("family", "k", "mu"), [("spinning", 0.25, 0.8), ("tumbling", 0.25, 1.5)])
def test_elliptic_a_motion_beside_the_unstable_part_settles_as_far_beyond(
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
    coin = st.Disk(radius=0.012, gravity=9.81)
    rate, speed = float(coin.rate), float(coin.speed)
    [si] = hopf("spinning", disk=coin, contact=st.Viscous(0.8 / speed))
    [plain] = hopf("spinning", contact=st.Viscous(0.8))
    assert si.at / rate == pytest.approx(plain.at, rel=1e-13)
    assert si.frequency / rate == pytest.approx(plain.frequency, rel=1e-10)
    assert si.crossing == pytest.approx(plain.crossing, rel=1e-6)
    assert si.landing(0.01 * rate) == pytest.approx(-0.01 * rate)


@pytest.mark.parametrize(
    ("family", "law", "sentence"),
    [("rolling", st.Viscous(1), "passes its own slowly"), ("spinning", st.Rough(), "friction"),
     ("hopping", st.Viscous(1), "family is 'hopping'")],
)  # fmt: skip
def test_questions_without_such_a_boundary_are_refused(
    family: str, law: Any, sentence: str
) -> None:
    with pytest.raises(st.StabilityError, match=sentence):
        hopf(family, contact=law)
