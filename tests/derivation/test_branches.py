"""The ranges of printed roots: proved from the polynomials, and tried to be refuted."""

import math
from typing import Any

import mpmath
import numpy as np
import pytest
import sympy as sp

import stability as st
from stability.bodies.disk_polynomials import exact_polynomial
from stability.derivation.formulas import NOWHERE, FlutterCondition, expression, formulas

K, M, Z, S, V, X, N = sp.symbols("k M z s v x N", positive=True)
HALF = sp.Rational(1, 2)


def condition(family: str, law: str, kind: str) -> Any:
    [found] = [p for k, p in exact_polynomial(family, law).conditions if k == kind]
    value = expression(found)
    names = {str(x): x for x in value.free_symbols}
    known = {"k": K, "M": M, "z": Z, "s": S}
    return sp.expand(value.subs({x: known[n] for n, x in names.items()}))


def positive_on(poly: Any, low: Any, high: Any) -> bool:
    """Whether a polynomial in k is positive on (low, high], by Sturm and one sample."""
    poly = sp.Poly(poly, K)
    inside = poly.count_roots(low, high) - (1 if poly.eval(low) == 0 else 0)
    return bool(inside == 0 and poly.eval((low + high) / 2) > 0)


# --- spinning ---


def test_spinning_has_one_flutter_root_exactly_between_m1_and_m2_for_every_k() -> None:
    poly = sp.Poly(sp.expand(condition("spinning", "viscous", "flutter").subs(Z, V + 1 / K)), V)
    assert poly.degree() == 2
    a2, a1, a0 = (sp.factor(c) for c in poly.all_coeffs())
    m1, m2 = 4 * K / (2 * K + 1) ** 2, 24 * K / ((2 * K + 1) * (4 * K + 3))
    scale = sp.cancel(a2 / (8 * K**3 * (4 * K - (2 * K + 1) ** 2 * M)))
    assert scale.is_number or sp.Poly(sp.numer(scale), K).is_ground or scale.free_symbols <= {K}
    assert positive_on(sp.numer(scale) * sp.denom(scale), 0, HALF)
    # a2 > 0 below M1, a0 > 0 below M2, and M1 < M2
    assert sp.simplify(a2.subs(M, m1)) == 0
    assert sp.simplify(a0.subs(M, m2)) == 0
    assert positive_on(sp.numer(sp.together(m2 - m1)), 0, HALF)
    assert positive_on(sp.numer(sp.cancel(-sp.diff(a2, M))), 0, HALF)
    rest = sp.cancel(a0 / (M * (m2 - M)))
    assert rest.free_symbols <= {K}
    assert positive_on(sp.numer(rest) * sp.denom(rest), 0, HALF)
    # a1 = -(convex in M), which is negative at 0 and M1 and positive at M2
    q = sp.Poly(-a1, M)
    assert q.degree() == 2
    assert positive_on(sp.numer(sp.cancel(q.LC())), 0, HALF)
    assert positive_on(sp.numer(sp.cancel(-q.nth(0))), 0, HALF)
    at_m1, at_m2 = (sp.cancel(q.as_expr().subs(M, m)) for m in (m1, m2))
    assert positive_on(-sp.numer(at_m1) * sp.denom(at_m1), 0, HALF)
    assert positive_on(sp.numer(at_m2) * sp.denom(at_m2), 0, HALF)
    # so (Descartes): no root v > 0 up to M1, exactly one between, none from M2 on


def test_of_mu_squared_only_the_second_root_is_positive_beyond_the_static_boundary() -> None:
    poly = sp.Poly(sp.expand(condition("spinning", "viscous", "flutter").subs(Z, V + 1 / K)), M)
    assert poly.degree() == 2
    for coefficient, sign in ((poly.LC(), -1), (poly.nth(0), 1)):
        top = sp.Poly(sp.numer(sp.together(sign * coefficient)), K, V)
        assert all(c > 0 for c in top.coeffs())
    # opposite signs: one positive root, and (-b - √)/(2a) with a < 0 is the larger one


# --- tumbling ---


def test_tumbling_flutters_exactly_where_its_leading_coefficient_is_negative() -> None:
    whole = sp.expand(condition("tumbling", "viscous", "flutter").subs(M, N / S))
    poly = sp.Poly(sp.expand(sp.expand(whole).subs(S**2, 1 - X).subs(S**4, (1 - X) ** 2)), N)
    common = sp.gcd_list([sp.factor(c) for c in poly.all_coeffs()])
    a, b, c = (
        sp.cancel(sp.expand(co).subs(S, sp.sqrt(1 - X)) / common.subs(S, sp.sqrt(1 - X)))
        for co in poly.all_coeffs()
    )
    said = (
        (2 * K + 1) ** 2
        * (K * (4 * K + 3) + (2 * K + 1) * X)
        * ((1 - 3 * K) * (1 + 2 * K) * X - K),
        4
        * K
        * (2 * K + 1)
        * (6 * K**2 + K * (8 - 25 * K) * X + (2 - 7 * K + 9 * K**2 - 36 * K**3) * X**2),
        96 * K**3 * X * (K + (1 - 3 * K) * X),
    )
    ratio = sp.cancel(a / said[0])
    for one, other in zip((a, b, c), said, strict=True):
        assert sp.simplify(one - ratio * other) == 0
    assert ratio.is_number or sp.simplify(ratio.subs({K: sp.Rational(1, 3), X: HALF})) > 0
    # A >= 0 needs k <= (√7 - 1)/6, where B > 0, so that no root N > 0 is left; C > 0 throughout
    limit = (sp.sqrt(7) - 1) / 6
    assert sp.simplify(((1 - 3 * K) * (1 + 2 * K) - K).subs(K, limit)) == 0
    above = sp.Rational(2743, 10000)
    assert limit < above
    assert positive_on(8 - 25 * K, 0, above)
    assert positive_on(2 - 7 * K + 9 * K**2 - 36 * K**3, 0, above)
    # C: k + (1 - 3k)x is linear in x and positive at both ends
    assert positive_on(1 - 2 * K, 0, sp.Rational(49, 100))


# --- circling and precession ---


@pytest.mark.parametrize(
    ("family", "law", "least"),
    [
        (
            "circling",
            "rough",
            (2 * K + 3 + sp.sqrt(6 * (K + 1) * (2 * K + 1) ** 3)) / (2 * (4 * K**2 + 6 * K + 3)),
        ),
        ("precession", "smooth", sp.sqrt(3) / 2),
    ],
)
def test_both_roots_of_two_parameter_families_are_admissible_from_a_stated_tilt_on(
    family: str, law: str, least: Any
) -> None:
    poly = sp.Poly(condition(family, law, "static"), Z)
    a, b, c = poly.all_coeffs()
    y = sp.Symbol("y", positive=True)  # sin²θ
    inner = sp.cancel(sp.expand(sp.discriminant(poly.as_expr(), Z)) / S**2)
    inner = sp.Poly(sp.expand(inner).subs(S, sp.sqrt(y)), y)
    assert inner.degree() == 2
    assert sp.simplify(inner.as_expr().subs(y, least)) == 0
    for k in (sp.Rational(1, 100), sp.Rational(1, 4), HALF):
        bound = sp.N(least.subs(K, k) if least.has(K) else least, 30)
        roots = [sp.N(r, 30) for r in sp.Poly(inner.as_expr().subs(K, k), y).nroots(n=30)]
        assert abs(max(sp.re(r) for r in roots) - bound) < 1e-25
        # both roots are positive there, and negative where they are real below it
        assert bound > HALF
    assert sp.simplify(sp.factor(-b / a) / (2 * S**2 - 1)).subs({K: HALF, S: HALF}) > 0
    assert sp.simplify((c / a).subs({K: HALF, S: HALF})) > 0


@pytest.mark.long
def test_the_printed_ranges_hold_at_random_points() -> None:
    """Real and admissible exactly where it says so: 40 digits, up to hundreds of points."""
    rng = np.random.default_rng(31)

    def functions(family: str, law: str, of: str, names: Any) -> Any:
        found = [b for b in formulas(family, law).boundaries if b["of"] == of and "where" in b]
        return [(b["where"], sp.lambdify(names, sp.sympify(b["formula"]), "mpmath")) for b in found]

    k, m, z, s = sp.symbols("k M z s")
    spin = functions("spinning", "viscous", "phi_dot**2", (k, m))
    spin_mu = functions("spinning", "viscous", "mu**2", (k, z))
    tumble = functions("tumbling", "viscous", "mu**2", (k, s))
    circle = functions("circling", "rough", "phi_dot**2", (k, s))
    assert [w == NOWHERE for w, _ in spin + spin_mu + tumble] == [True, False] * 3
    with mpmath.workdps(40):
        for _ in range(120):
            kk = mpmath.mpf(rng.uniform(0.005, 0.5))
            m1, m2 = 4 * kk / (2 * kk + 1) ** 2, 24 * kk / ((2 * kk + 1) * (4 * kk + 3))
            mm = m1 + (m2 - m1) * mpmath.mpf(rng.uniform(-0.3, 1.3))
            if mm > 0:
                seen = [f(kk, mm) for _, f in spin]
                good = [mpmath.im(v) == 0 and mpmath.re(v) > 1 / kk for v in seen]
                assert good == [False, bool(m1 < mm < m2)]
            seen = [f(kk, (1 + mpmath.mpf(10 ** rng.uniform(-4, 3))) / kk) for _, f in spin_mu]
            assert [mpmath.im(v) == 0 and mpmath.re(v) > 0 for v in seen] == [False, True]
            ss = mpmath.mpf(rng.uniform(1e-3, 1))
            seen = [f(kk, ss) for _, f in tumble]
            negative = (1 - 3 * kk) * (1 + 2 * kk) * (1 - ss**2) < kk
            good = [mpmath.im(v) == 0 and mpmath.re(v) > 0 for v in seen]
            assert good == [False, bool(negative)]
            seen = [f(kk, ss) for _, f in circle]
            least = (2 * kk + 3 + mpmath.sqrt(6 * (kk + 1) * (2 * kk + 1) ** 3)) / (
                2 * (4 * kk**2 + 6 * kk + 3)
            )
            good = [mpmath.im(v) == 0 and mpmath.re(v) > 0 for v in seen]
            assert good == [bool(ss**2 >= least)] * 2


def test_where_the_roots_are_not_real_every_member_is_neutral_and_between_them_unstable() -> None:
    for k, theta in ((0.25, 1.2), (0.5, 1.5), (0.1, 1.45)):
        s = math.sin(theta)
        inner = 6 * (k + 1) * (2 * k + 1) ** 3
        real = s * s >= (2 * k + 3 + math.sqrt(inner)) / (2 * (4 * k * k + 6 * k + 3))
        at = np.column_stack([np.full(400, theta), np.linspace(0.05, 6, 400)])
        found = st.spectrum("circling", at=at, disk=st.Disk(k=k), contact=st.Rough())
        assert any(v is st.Verdict.UNSTABLE for v in found.verdict) == real


def test_a_factor_without_mu_keeps_a_statement_from_every_k() -> None:
    # 0.4 looked only at factors with mu: for k above 1/3 this changes sign along the family, and
    # it was said to be stable for every k in (0, 1/2]
    from stability.derivation.characteristic import SQUARE
    from stability.derivation.characteristic import K as k
    from stability.derivation.characteristic import M as m

    line = FlutterCondition("spinning", sp.expand((1 - 3 * k) * SQUARE + m + 10), 1 / k)
    assert line.for_every_k() is None
    patterns = [
        [
            r.pattern
            for r in FlutterCondition(
                "spinning", sp.expand((1 - 3 * k) * SQUARE + m + 10), 1 / k
            ).for_one_k(v)
        ]
        for v in (sp.Rational(1, 4), HALF)
    ]
    assert patterns[0] != patterns[1]


def test_limits_in_mu_are_not_uniform() -> None:
    """A hoop: as mu -> 0 each member is stable, yet for each mu some member is unstable."""
    for mu in (0.1, 0.01, 1e-3):
        found = st.spectrum(
            "tumbling",
            at=[1e-3 * mu, 0.5],
            disk=st.Disk.hoop(),
            contact=st.Viscous(mu),
            certify=True,
        )
        assert found.verdict.tolist() == [st.Verdict.UNSTABLE, st.Verdict.STABLE]
