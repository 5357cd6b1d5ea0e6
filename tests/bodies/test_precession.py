"""The smooth disk's regular precession, a family of two parameters, reduced by hand."""

import json
import math

import numpy as np
import pytest
import sympy as sp

import stability as st
from stability.bodies.disk_polynomials import exact_polynomial
from stability.cli import main
from stability.derivation.formulas import expression

K, Z, S = sp.symbols("k z s", positive=True)


def test_the_counterexample_to_three_families_is_a_member() -> None:
    # 0.4 said that the smooth disk's steady motions are rolling, spinning and tumbling
    k, theta, rate = 0.25, 1.0, 1.5
    s, c = math.sin(theta), math.cos(theta)
    spin = c * (k * rate**2 * s - 1) / (2 * k * rate * s)
    member = st.disk_family("precession", "smooth").member([theta, rate], [k])
    assert member == pytest.approx([theta, 0.0, rate, spin], rel=1e-14)
    rates = st.disk_system("smooth").rates(member, [k])
    assert np.abs(rates).max() < 1e-15
    assert abs(spin) > 0.1  # neither tumbling nor upright
    run = st.simulate(st.Disk(k=k), st.Smooth(), member, 50.0)
    assert float(np.ptp(run.theta.values)) < 1e-9


@pytest.mark.long
def test_the_spectrum_is_that_of_the_effective_potential() -> None:
    """With L·ẑ and omega3 kept the energy is (k + c²) θ̇²/2 + V(θ): frequency² = V''/(k + c²)."""
    th, ell, spin, rate = sp.symbols("theta ell omega rate", positive=True)
    s, c = sp.sin(th), sp.cos(th)
    potential = (ell - 2 * K * spin * c) ** 2 / (2 * K * s**2) + s
    on = {ell: K * rate * s**2 + 2 * K * spin * c}
    slope = sp.simplify(sp.diff(potential, th).subs(on))
    condition = 2 * K * rate * spin * s - c * (K * rate**2 * s - 1)
    assert sp.simplify(slope - condition / 1) == 0
    square = sp.diff(potential, th, 2).subs(on) / (K + c**2)
    square = square.subs(spin, c * (K * rate**2 * s - 1) / (2 * K * rate * s))
    found = exact_polynomial("precession", "smooth")
    assert found.zeros == 2
    assert found.even
    low, none, high = (expression(p) for p in found.factors[0])
    assert none == 0
    printed = (low / high).subs({Z: rate**2, S: s})
    names = {str(x): x for x in (low + high).free_symbols}
    printed = (low / high).subs({names["z"]: rate**2, names["s"]: s, names["k"]: K})
    assert sp.simplify(sp.trigsimp(square - printed)) == 0


@pytest.mark.parametrize(
    ("theta", "rate", "k"), [(1.0, 1.5, 0.25), (1.5, 1.9, 0.25), (0.2, -3.0, 0.5), (2.7, 0.4, 0.1)]
)
def test_plain_and_certified_meet_the_effective_potential_in_numbers(
    theta: float, rate: float, k: float
) -> None:
    import mpmath

    with mpmath.workdps(40):
        th, p, kk = mpmath.mpf(theta), mpmath.mpf(rate), mpmath.mpf(k)
        s, c = mpmath.sin(th), mpmath.cos(th)
        w = c * (kk * p * p * s - 1) / (2 * kk * p * s)
        ell = kk * p * s * s + 2 * kk * w * c
        curve = mpmath.diff(
            lambda t: (
                (ell - 2 * kk * w * mpmath.cos(t)) ** 2 / (2 * kk * mpmath.sin(t) ** 2)
                + mpmath.sin(t)
            ),
            th,
            2,
        )
        square = -curve / (kk + c * c)
        value = complex(mpmath.sqrt(square))
    for certify in (False, True):
        found = st.spectrum(
            "precession", at=(theta, rate), disk=st.Disk(k=k), contact=st.Smooth(), certify=certify
        )
        assert found.structural_zeros == 2
        assert np.abs(found.eigenvalues - [-value, value]).max() < 1e-12 * abs(value)
        unstable = square > 0
        assert found.verdict is (st.Verdict.UNSTABLE if unstable else st.Verdict.NEUTRAL)
        kept = st.Nonlinear.UNSTABLE if unstable else st.Nonlinear.BY_INTEGRALS
        assert found.nonlinear is kept


def test_precession_is_unstable_between_two_branches_real_where_s4_is_above_3_quarters() -> None:
    low = expression(exact_polynomial("precession", "smooth").conditions[0][1])
    names = {str(x): x for x in low.free_symbols}
    w, s = sp.symbols("w s", positive=True)  # w = k φ̇²
    low = sp.expand(low.subs({names["z"]: w / names["k"], names["s"]: s}))
    quadratic = sp.Poly(low, w)
    assert quadratic.degree() == 2
    assert sp.factor(sp.discriminant(quadratic.as_expr(), w) - s**2 * (4 * s**4 - 3)) == 0
    # above the threshold both branches are positive: product c²/s² and sum (2s² - 1)/s
    a, b, c = quadratic.all_coeffs()
    assert sp.simplify(c / a - (1 - s**2) / s**2) == 0
    assert sp.simplify(-b / a - (2 * s**2 - 1) / s) == 0


def test_it_contains_tumbling_and_meets_spinning_where_tumbling_does() -> None:
    theta, k = 0.8, 0.3
    rate = 1 / math.sqrt(k * math.sin(theta))
    both = [
        st.disk_family(n, "smooth").member(at, [k])
        for n, at in (("precession", [theta, rate]), ("tumbling", [theta]))
    ]
    assert both[0] == pytest.approx(both[1], abs=1e-14)
    disk = st.Disk(k=k)
    one = st.spectrum("precession", at=(theta, rate), disk=disk, contact=st.Smooth())
    other = st.spectrum("tumbling", at=theta, disk=disk, contact=st.Smooth())
    assert np.allclose(one.eigenvalues, other.eigenvalues, atol=1e-12)


def test_the_command_line_takes_the_pair_and_refuses_other_laws(
    capsys: pytest.CaptureFixture[str],
) -> None:
    words = ["spectrum", "precession", "--at", "1,1.5", "--contact", "smooth", "--json"]
    assert main(words) == 0
    found = json.loads(capsys.readouterr().out)
    assert (found["verdict"], found["structural_zeros"]) == ("neutral", 2)
    assert main(["spectrum", "precession", "--at", "1,1.5", "--contact", "rough"]) == 2
    assert "family of the smooth disk" in capsys.readouterr().err
    assert main(["spectrum", "precession", "--at", "1,0", "--contact", "smooth"]) == 2
    assert "no admissible" in capsys.readouterr().err


def test_a_map_over_both_parameters_agrees_with_points() -> None:
    axes = {"x": ("theta", 1.2, 1.55, 7), "y": ("phi_dot", 0.5, 2.5, 6)}
    found = st.stability_map("precession", **axes, contact=st.Smooth())
    for i in range(7):
        for j in range(6):
            at = (float(found.theta[i]), float(found.phi_dot[j]))
            one = st.spectrum("precession", at=at, contact=st.Smooth())
            assert int(found.verdict.transpose("theta", "phi_dot")[i, j]) == one.verdict.code


def test_its_boundaries_are_the_two_branches_along_either_axis() -> None:
    """K φ̇² = ((2s² - 1) ± √(4s⁴ - 3))/(2s), from the discriminant above; θ by bisection of it."""
    import mpmath

    def branches(theta: float, k: float) -> list[float]:
        with mpmath.workdps(40):
            s = mpmath.sin(mpmath.mpf(theta))
            inside = 4 * s**4 - 3
            if inside < 0:
                return []
            roots = [(2 * s * s - 1 + sign * mpmath.sqrt(inside)) / (2 * s) for sign in (-1, 1)]
            return [float(mpmath.sqrt(w / mpmath.mpf(k))) for w in roots]

    rng = np.random.default_rng(3)
    seen = set()
    for _ in range(12):
        theta, k = rng.uniform(0.4, 2.7), rng.uniform(0.05, 0.5)
        disk = st.Disk(k=k)
        found = st.boundaries(
            "precession",
            axis=("phi_dot", 0.01, 30.0, 20),
            at=theta,
            disk=disk,
            contact=st.Smooth(),
        )
        truth = branches(theta, k)
        seen.add(len(truth))
        assert found.complete
        assert [b.value for b in found] == pytest.approx(truth, rel=1e-13)
        for b, exact in zip(found, truth, strict=True):
            assert abs(b.value - exact) <= b.error + 1e-15 * exact
        rate = rng.uniform(0.3, 4.0)
        along = st.boundaries(
            "precession", axis=("theta", 0.4, 2.7, 20), at=rate, disk=disk, contact=st.Smooth()
        )
        assert along.complete
        # where a branch has this rate: a root in s of w² - (2s² - 1) w/s + (1 - s²)/s² = 0
        w = k * rate * rate  # (s² w² - (2 s³ - s) w + 1 - s² = 0)
        roots = np.roots([-2 * w, w * w - 1, w, 1.0])
        lean = [float(r.real) for r in roots if abs(r.imag) < 1e-12 and 0 < r.real < 1]
        expected = sorted(
            t for s in lean for t in (math.asin(s), math.pi - math.asin(s)) if 0.4 < t < 2.7
        )
        assert [b.value for b in along] == pytest.approx(expected, abs=1e-9)
    assert seen == {0, 2}
