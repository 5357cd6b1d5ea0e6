"""Structural zeros and thresholds, derived exactly over the rational functions of parameters."""

import casadi as ca
import pytest
import sympy
from sympy import Matrix, Rational, Symbol, factor, symbols

import stability as st
from stability.algebra.number_types import sympy_algebra
from stability.algebra.program import Program
from stability.systems.structure.structural_zeros import structure

K, MU, W, S, C = symbols("k mu w s c", positive=True)
LAM = Symbol("lam")


def characteristic(family: str, law: str) -> sympy.Expr:
    """det(λ - A) with SymPy from the graph, all quantities symbols; w is at, or φ̇ for tumbling."""
    system = st.disk_system(law)
    graph = Program(ca.Function("jacobian", [system.x, system.p], [system.jacobian]))
    algebra = sympy_algebra()
    upright = family in ("rolling", "spinning")
    sine, cosine = (sympy.Integer(1), sympy.Integer(0)) if upright else (S, C)
    functions = dict(algebra.functions) | {"sin": lambda _: sine, "cos": lambda _: cosine}
    algebra = type(algebra)(algebra.name, algebra.constant, functions)
    zero = sympy.Integer(0)
    phi = {"rolling": zero, "spinning": W, "tumbling": W}[family]
    spin = W if family == "rolling" else zero
    state = [zero, zero, phi, spin, zero, zero][: len(system.states)]
    # a distinct symbol for θ, which the sine and cosine above swallow
    rows = graph.dense(algebra, [[Symbol("theta"), *state[1:]], [K, MU][: len(system.parameters)]])
    matrix = Matrix(rows)
    if not upright:  # φ̇² = 1/(k sinθ), and cos² = 1 - sin² in what is left
        matrix = matrix.subs(K, 1 / (S * W**2))
    poly = sympy.expand(matrix.charpoly(LAM).as_expr())
    poly = sympy.together(poly)
    top, bottom = sympy.fraction(poly)
    top = sympy.expand(top)
    if not upright:
        top = sympy.rem(sympy.Poly(top, C), sympy.Poly(C**2 + S**2 - 1, C)).as_expr()
    return sympy.Poly(sympy.expand(top), LAM)


CASES = [
    (family, law, zeros)
    for law, counts in {
        "smooth": (2, 2, 2),
        "viscous": (2, 1, 1),
        "linear-viscous": (2, 1, 1),
        "rough": (2, 2, 2),
    }.items()
    for family, zeros in zip(("rolling", "spinning", "tumbling"), counts, strict=True)
]


@pytest.mark.few(2)
@pytest.mark.parametrize(
    ("family", "law", "zeros"),
    [c if c[0] != "tumbling" else pytest.param(*c, marks=pytest.mark.long) for c in CASES],
)
def test_structural_zeros_are_the_exact_multiplicity_of_lambda(
    family: str, law: str, zeros: int
) -> None:
    coefficients = characteristic(family, law).all_coeffs()[::-1]
    assert all(sympy.simplify(c) == 0 for c in coefficients[:zeros])
    assert sympy.simplify(coefficients[zeros]) != 0
    found = structure(st.disk_family(family, law))
    assert found.zeros == zeros
    even = all(sympy.simplify(c) == 0 for c in coefficients[zeros + 1 :: 2])
    assert found.even == even == (law in ("smooth", "rough"))


def test_circling_has_two_structural_zeros_and_two_tangents() -> None:
    family = st.disk_family("circling", "rough")
    assert structure(family).zeros == family.tangents == 2


def test_rollings_second_zero_is_not_a_tangent_so_it_drifts() -> None:
    family = st.disk_family("rolling", "viscous")
    assert (structure(family).zeros, family.tangents) == (2, 1)
    stable = st.spectrum("rolling", at=1.8, contact=st.Viscous(0.3))
    assert stable.nonlinear is st.Nonlinear.DRIFTS


def test_viscous_rolling_changes_at_omega3_squared_1_over_2k_for_every_mu() -> None:
    """The exact Hurwitz determinant has the factor 2k w² - 1 and no other root."""
    poly = characteristic("rolling", "viscous")
    reduced = poly.all_coeffs()[:-2]
    # one factor is linear (decay of lateral slip); the rest is a cubic
    [linear] = [f for f, _ in sympy.Poly(reduced, LAM).factor_list()[1] if f.degree() == 1]
    cubic = sympy.quo(sympy.Poly(reduced, LAM), linear)
    a3, a2, a1, a0 = cubic.all_coeffs()
    determinant = factor(a2 * a1 - a3 * a0)
    assert sympy.simplify(determinant.subs(W, sympy.sqrt(1 / (2 * K)))) == 0
    others = sympy.solve(determinant, W**2)
    assert [sympy.simplify(o) for o in others] == [1 / (2 * K)]


def test_spinnings_static_boundary_is_phi_dot_squared_1_over_k() -> None:
    poly = characteristic("spinning", "viscous")
    constant = factor(poly.all_coeffs()[-2])
    assert [z for z in sympy.solve(constant, W**2) if z != 0] == [1 / K]


@pytest.mark.parametrize(
    ("family", "law", "square"),
    [
        ("rolling", "rough", 1 / (2 * (2 * K + 1))),
        ("rolling", "smooth", 1 / (4 * K)),
        ("spinning", "rough", 1 / (1 + K)),
        ("spinning", "smooth", 1 / K),
    ],
)
def test_conservative_thresholds_are_those_of_the_literature(
    family: str, law: str, square: sympy.Expr
) -> None:
    constant = characteristic(family, law).all_coeffs()[-3]
    assert [sympy.simplify(s - square) for s in sympy.solve(constant, W**2)] == [0]


def test_published_all_zero_spectrum_of_the_rough_disc() -> None:
    """SymPy's own test of Kane's method: rolling disc, spin 1/√3, every eigenvalue zero."""
    poly = characteristic("rolling", "rough").subs({K: Rational(1, 4), W: 1 / sympy.sqrt(3)})
    coefficients = sympy.Poly(poly, LAM).all_coeffs()
    assert all(sympy.simplify(c) == 0 for c in coefficients[1:])
