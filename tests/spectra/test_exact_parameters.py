"""Fractions as parameters stay exact: verdicts and boundaries at numbers that are no doubles."""

import warnings
from collections.abc import Callable
from decimal import Decimal
from fractions import Fraction

import casadi as ca
import numpy as np
import pytest
import sympy

import stability as st
from stability.base.errors import ParameterError
from stability.bodies.subject import subject_of
from stability.spectra.deflation import tracked_matrix
from stability.spectra.problem import problem_of
from stability.spectra.spectrum import Rows

THIRD = Fraction(1, 3)


def balanced(sine: bool = False) -> st.Family:
    """q̈ = -(a - 3 b) q - c q̇: neutral where a = 3 b, which no double b reaches for a = 1."""
    x, p = ca.SX.sym("x", 2), ca.SX.sym("p", 3)
    a, b, c = ca.vertsplit(p)
    a = ca.sin(a) if sine else a
    rates = ca.vertcat(x[1], -(a - 3 * b) * x[0] - c * x[1])
    system = st.System("balanced", x, p, rates, states=("q", "v"), parameters=("a", "b", "c"))
    return st.Family(system, "rest", at=("a",), held={"q": 0.0, "v": 0.0})


@pytest.mark.parametrize("third", [THIRD, sympy.Rational(1, 3)])
def test_a_fraction_is_decided_at_its_own_value(third: object) -> None:
    """One third is neutral; its double, smaller than one third, is stable."""
    found = st.spectrum(balanced(), at=1, b=third, c=1.0, certify=True)
    assert found.verdict.word == "neutral"
    assert found.eigenvalues.tolist() == [-1, 0]
    assert st.spectrum(balanced(), at=1, b=1 / 3, c=1.0, certify=True).verdict.word == "stable"
    assert st.spectrum(balanced(), at=1, b=third, c=1.0).verdict.word == "neutral"
    exact = st.spectrum(balanced(), at=Fraction(9, 10), b=Decimal("0.3"), c=1.0, certify=True)
    assert exact.verdict.word == "neutral"


def test_the_discs_of_double_precision_hold_the_eigenvalue_of_the_fraction() -> None:
    """ẋ = -b x: the eigenvalue is -b, and the rounding of b is in the radius."""
    x, b = ca.SX.sym("x"), ca.SX.sym("b")
    system = st.System("decay", x, b, -b * x, states=("x",), parameters=("b",))
    rest = st.Family(system, "rest", at=("b",), held={"x": 0.0})
    for ratio in (Fraction(1, 7), Fraction(10, 3), Fraction(10**17 + 1, 3 * 10**17)):
        found = st.spectrum(rest, at=ratio, escalate=False)
        off = abs(Fraction(float(found.eigenvalues[0].real)) + ratio)
        assert 0 < off <= Fraction(float(found.radius[0]))
        proved = st.spectrum(rest, at=ratio, certify=True)
        assert off <= Fraction(float(proved.radius[0])) < 2 * off


def test_boundaries_hold_the_other_numbers_exactly() -> None:
    (found,) = st.boundaries(balanced(), axis=("a", 0.5, 2, 9), b=THIRD, c=1.0)
    assert found.value == 1.0
    for b in (Fraction(1, 7), 1 / 7):
        one = st.boundaries(balanced(sine=True), axis=("b", 0.01, 0.5, 9), at=b, c=Fraction(1, 3))
        assert one.complete
        assert abs(one[0].value - float(sympy.sin(sympy.Rational(b)).evalf(30)) / 3) < 1e-15
    # a line on which everything is neutral for fractions, and nothing for their doubles
    line = st.boundaries(balanced(), axis=("c", 0.5, 2, 9), at=1, b=THIRD)
    assert list(line) == []
    assert line.complete


def test_the_rounding_of_a_fraction_is_in_the_bound_on_its_linearisation() -> None:
    """ẋ = b x: the entry is b itself, so its only error is that of its double."""
    x, b = ca.SX.sym("x"), ca.SX.sym("b")
    system = st.System("growth", x, b, b * x, states=("x",), parameters=("b",))
    rest = st.Family(system, "rest", at=("b",), held={"x": 0.0})
    for value in (THIRD, Fraction(1, 7), 1 / 3):
        rows = Rows(problem_of(subject_of(rest, at=value)), exact=False)
        place = rows.place
        matrix, error = tracked_matrix(rest, place.a, place.q, place.u, place.roundings)
        off = abs(Fraction(value) - Fraction(float(matrix[0, 0, 0])))
        assert off <= Fraction(float(error[0, 0, 0]))
        assert (off > 0) == isinstance(value, Fraction)


@pytest.mark.parametrize("function", [lambda a: a, ca.sqrt, ca.tanh])
def test_a_boundary_that_only_touches_for_the_fraction(function: Callable[[ca.SX], ca.SX]) -> None:
    """(f(a) - f(1) 3 b) (f(a) - f(1)) is a square at b = 1/3, and changes sign for its double."""
    x, p = ca.SX.sym("x", 2), ca.SX.sym("p", 3)
    a, b, d = ca.vertsplit(p)
    value = function(a) / function(d)
    rates = ca.vertcat(x[1], -(value - 3 * b) * (value - 1) * x[0] - x[1])
    system = st.System("touching", x, p, rates, states=("q", "v"), parameters=("a", "b", "d"))
    family = st.Family(system, "rest", at=("a",), held={"q": 0.0, "v": 0.0})
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", st.StabilityWarning)
        found = st.boundaries(family, axis=("a", 0.5, 2, 5), b=THIRD, d=1)
        double = st.boundaries(family, axis=("a", 0.5, 2, 5), b=1 / 3, d=1)
    assert list(found) == []
    if function is not ca.tanh:  # in pieces, no proof reaches a double root
        assert found.complete
        assert found.touching == (1.0,)
        assert not double.complete


def test_where_fractions_are_rounded_a_warning_says_so() -> None:
    with pytest.warns(st.StabilityWarning, match="b is 1/3, which is no double"):
        st.stability_map(balanced(), x=("a", 0.5, 2, 3), y=("c", 1, 2, 3), b=THIRD)
    with pytest.warns(st.StabilityWarning, match="at is 1/3"):
        st.spectrum(balanced(), at=np.array([THIRD, Fraction(1)]), b=1.0, c=1.0)
    with pytest.warns(st.StabilityWarning, match="k is 3/10"):
        st.Disk(k=Fraction(3, 10))
    st.stability_map(balanced(), x=("a", 0.5, 2, 3), y=("c", 1, 2, 3), b=Fraction(1, 4))
    with pytest.raises(ParameterError, match="b is"):
        st.spectrum(balanced(), at=1, b=Fraction(10) ** 400, c=1.0)
