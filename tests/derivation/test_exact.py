"""Polynomials over Q: derived again they are the stored ones, and other derivations agree."""

import json
from fractions import Fraction
from importlib.resources import files
from typing import Any

import mpmath
import numpy as np
import pytest
import sympy
from hypothesis import given, settings
from hypothesis import strategies as s
from proofs import stored
from proofs.disk_polynomials import derive
from reference import beyond
from spectrum_oracle import truth_matrix

import stability as st
from stability.algebra.polynomial import Polynomial
from stability.bodies.disk_polynomials import exact_polynomial
from stability.derivation.characteristic import LAM
from stability.derivation.formulas import expression
from stability.derivation.hurwitz import conditions, determinant, positive

CASES = [
    (f, law)
    for law in ("smooth", "viscous", "linear-viscous", "rough")
    for f in ("rolling", "spinning", "tumbling")
] + [("circling", "rough"), ("precession", "smooth")]


@pytest.mark.long
def test_derived_anew_the_stored_polynomials_are_the_same() -> None:
    kept = json.loads((files("stability.bodies") / "disk_polynomials.json").read_text())
    assert stored.of_disk() == kept


def characteristic(family: str, law: str, point: dict[str, Any]) -> list[Any]:
    """Coefficients of the reduced polynomial in λ from the package data, lowest first, mpmath."""
    known = exact_polynomial(family, law)
    product = [mpmath.mpf(1)]
    for factor in known.coefficients([point[n] for n in known.variables]):
        scaled = [
            c / point["mu"] ** i if "M" in known.variables and not known.even else c
            for i, c in enumerate(factor)
        ]
        product = [
            sum(product[j] * scaled[i - j] for j in range(len(product)) if 0 <= i - j < len(scaled))
            for i in range(len(product) + len(scaled) - 1)
        ]
    return [c / product[-1] for c in product]


@pytest.mark.parametrize("count", [1, pytest.param(4, marks=pytest.mark.long)])
@pytest.mark.parametrize(
    ("family", "law"), [c for c in CASES if c[0] not in ("circling", "precession")]
)
def test_the_polynomial_is_that_of_the_jacobian_at_60_digits(
    family: str, law: str, count: int
) -> None:
    random = np.random.default_rng(4)
    resolved = st.disk_family(family, law)
    with mpmath.workdps(60):
        for _ in range(count):
            k, mu, at = random.uniform(0.05, 0.5), random.uniform(0.1, 3), random.uniform(0.2, 1.5)
            q = [k, mu][: len(resolved.parameters)]
            matrix = truth_matrix(resolved, at, q)
            n = matrix.rows
            # Faddeev-LeVerrier: another way to the coefficients than SymPy's determinant
            coefficients, power = [mpmath.mpf(1)], mpmath.eye(n)
            for i in range(1, n + 1):
                power = (
                    matrix * power
                    if i == 1
                    else matrix * (power + coefficients[-1] * mpmath.eye(n))
                )
                coefficients.append(-sum(power[j, j] for j in range(n)) / i)
            zeros = exact_polynomial(family, law).zeros
            reduced = coefficients[::-1][zeros:]
            point = {
                "k": mpmath.mpf(k),
                "mu": mpmath.mpf(mu),
                "M": mpmath.mpf(mu) ** 2,
                "z": mpmath.mpf(at) ** 2,
                "s": mpmath.sin(mpmath.mpf(at)),
            }
            mine = characteristic(family, law, point)
            assert len(mine) == len(reduced)
            assert all(abs(c) < mpmath.mpf(10) ** -50 for c in coefficients[::-1][:zeros])
            for a, b in zip(mine, reduced, strict=True):
                assert abs(a - b) < mpmath.mpf(10) ** -50 * (1 + abs(b))


@pytest.mark.parametrize("family", ["spinning", "tumbling"])
def test_an_independent_derivation_finds_the_same_flutter_condition(family: str) -> None:
    [mine] = [p for kind, p in exact_polynomial(family, "viscous").conditions if kind == "flutter"]
    theirs = sympy.sympify(beyond()["conditions"][family])
    ratio = sympy.cancel(expression(mine) / theirs)
    assert ratio.is_number and ratio > 0


@pytest.mark.few(6)
@pytest.mark.parametrize(("family", "law"), CASES)
def test_every_condition_decides_as_the_roots_do(family: str, law: str) -> None:
    """Signs of the few conditions kept against numpy's roots of the whole polynomial."""
    known = exact_polynomial(family, law)
    random = np.random.default_rng(5)
    decided = 0
    for _ in range(300):
        values = {
            "k": random.uniform(1e-3, 0.5),
            "M": 10 ** random.uniform(-2, 2),
            "z": 10 ** random.uniform(-1.5, 1.5),
            "s": random.uniform(0.01, 1),
        }
        point = [values[n] for n in known.variables]
        roots = np.concatenate([np.roots(c[::-1]) for c in known.coefficients(point)])
        lead = roots.real.max()
        if known.even:
            lead = max(lead, 0.0) if np.abs(roots.real).max() > 1e-7 else -1.0
        if abs(lead) < 1e-7 * np.abs(roots).max():
            continue
        decided += 1
        good = all(p(*point) > 0 for _, p in known.conditions)
        assert good == (lead < 0)
    assert decided > 200


def test_the_catalogue_of_viscous_and_linear_viscous_is_one() -> None:
    for family in ("rolling", "spinning", "tumbling"):
        one, other = (exact_polynomial(family, law) for law in ("viscous", "linear-viscous"))
        assert one.factors == other.factors
        assert one.conditions == other.conditions


def test_the_graph_as_it_is_gives_what_it_must_for_rolling() -> None:
    [linear, cubic] = derive("rolling", "viscous").factors
    assert sympy.degree(linear.as_expr(), LAM) == 1
    assert sympy.degree(cubic.as_expr(), LAM) == 3


def test_hurwitz_determinants_are_orlandos_product() -> None:
    """Δ(n-1) = (-1)^(n(n-1)/2) a0^(n-1) ∏ (λi + λj): Gantmacher vol. 2, ch. XV § 7."""
    x = sympy.Symbol("x")
    roots = [sympy.Integer(r) for r in (-1, -2, 3, -5)]
    poly = sympy.Poly(sympy.expand(sympy.prod(x - r for r in roots)), x)
    product = sympy.prod(roots[i] + roots[j] for i in range(4) for j in range(i))
    assert determinant(poly, 3) == product


def test_a_proof_of_positivity_is_not_given_where_it_is_false() -> None:
    k, sine = sympy.symbols("k s")
    assert positive(1 - 2 * k) is None  # zero at k = 1/2, which belongs to the domain
    assert positive(sine - sympy.Rational(1, 10)) is None
    assert positive(k - sine) is None
    assert positive(1 - sine**2) is not None


@pytest.mark.parametrize(
    ("cases", "draws"),
    [([("spinning", "viscous")], 100), pytest.param(CASES, 1000, marks=pytest.mark.long)],
)
def test_conditions_that_were_dropped_hold_wherever_the_kept_ones_do(
    cases: list[tuple[str, str]], draws: int
) -> None:
    """An attempt to refute the proofs: random points, and points close to the edges."""
    random = np.random.default_rng(6)
    for family, law in cases:
        known = exact_polynomial(family, law)
        derived_ = derive(family, law)
        names = [sympy.Symbol(n) for n in known.variables]
        every = [sympy.lambdify(names, v, "numpy") for _, v in conditions(derived_)]
        for _ in range(draws):
            edge = 10 ** random.uniform(-6, 0, 4)
            values = {
                "k": 0.5 * edge[0],
                "M": 10 ** random.uniform(-5, 5),
                "z": 10 ** random.uniform(-4, 4),
                "s": 1 - 0.9 * edge[3],
            }
            point = [values[n] for n in known.variables]
            kept = [p(*point) for _, p in known.conditions]
            if all(v > 0 for v in kept) and min(kept, default=1) > 1e-9:
                assert all(f(*point) > -1e-9 for f in every)


@pytest.mark.parametrize("examples", [25, pytest.param(200, marks=pytest.mark.long)])
def test_horner_schemes_give_the_sum_of_the_terms(examples: int) -> None:
    powers = s.tuples(s.integers(0, 3), s.integers(0, 2))
    terms = s.lists(s.tuples(s.integers(-9, 9), powers), max_size=8)
    ask = given(terms, s.fractions(-3, 3), s.fractions(-3, 3))(horner_and_sum)
    settings(max_examples=examples, deadline=None)(ask)()


def horner_and_sum(terms: list[tuple[int, tuple[int, int]]], x: Fraction, y: Fraction) -> None:
    polynomial = Polynomial(("x", "y"), tuple(terms))
    plain = sum((c * x ** e[0] * y ** e[1] for c, e in terms), Fraction(0))
    assert polynomial(x, y) == plain
    plus, minus = polynomial.parts
    assert plus(x, y) - minus(x, y) == plain
    slope = sum((c * e[0] * x ** (e[0] - 1) * y ** e[1] for c, e in terms if e[0]), Fraction(0))
    assert polynomial.derivative("x")(x, y) == slope


@pytest.mark.parametrize("points", [15, pytest.param(50, marks=pytest.mark.long)])
def test_rounding_counts_bound_the_error_of_both_parts(points: int) -> None:
    """P⁺ and P⁻ in doubles against exact rationals: within the counted roundings, not idle."""
    random = np.random.default_rng(8)
    worst = 0.0
    for family, law in CASES:
        for _, polynomial in exact_polynomial(family, law).conditions:
            for part in polynomial.parts:
                count = part.roundings(dict.fromkeys(part.variables, 0))
                for _ in range(points):
                    point = [float(v) for v in 10 ** random.uniform(-3, 3, len(part.variables))]
                    truth = Fraction(part(*[Fraction(v) for v in point]))
                    if truth:
                        off = abs(Fraction(part(*point)) - truth) / truth
                        assert off <= Fraction(count) * Fraction(2) ** -53 * Fraction(1001, 1000)
                        worst = max(worst, float(off))
    assert worst > 2.0**-53
