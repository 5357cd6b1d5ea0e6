"""The characteristic polynomial over Q, with any numbers free, against SymPy's determinant."""

from itertools import combinations
from typing import Any

import casadi as ca
import pytest
import sympy

import stability as st
from stability.algebra.exact.hurwitz_forms import Budget
from stability.algebra.exact.number_fields import NotExact, rational
from stability.polynomials.characteristic import CharacteristicPolynomial

NUMBERS = {"p": 0.75, "q": -1.5, "r": 2.25}
POINTS = (NUMBERS, {"p": 1.25, "q": 0.5, "r": -0.75})
FREE = [some for count in range(4) for some in combinations(NUMBERS, count)]
LAMBDAS = (1, -2, sympy.Rational(1, 3), 5)


def entries(p: Any, q: Any, r: Any, root: Any = 0) -> list[list[Any]]:
    """Two blocks, one above the other: a quotient, a zero by structure, and a root."""
    return [
        [p, q / (1 + p * p), 0, r],
        [r, -q + root, 1, 0],
        [0, 0, 0, 0],
        [0, 0, q, p * q * r],
    ]


def family(root: Any = 0) -> st.Family:
    """A linear system at rest whose matrix is `entries`."""
    x, p = ca.SX.sym("x", 4), ca.SX.sym("p", 3)
    rows = entries(*ca.vertsplit(p), root(p) if root else 0)
    matrix = ca.vertcat(*[ca.horzcat(*row) for row in rows])
    states = ("a", "b", "c", "d")
    system = st.System("planted", x, p, matrix @ x, states=states, parameters=tuple(NUMBERS))
    return st.Family(system, "rest", at=("p",), held=dict.fromkeys(states, 0.0))


def value(polynomial: CharacteristicPolynomial, point: dict[str, Any], lam: Any) -> Any:
    """The product of the factors at a point."""
    found = polynomial.factored
    where = [rational(point[n]) for n in found.names]
    total = lam**found.zeros
    for row, count in found.factors:
        total *= sum(sympy.Rational(str(c(*where, 0))) * lam**k for k, c in enumerate(row)) ** count
    return total


@pytest.mark.parametrize("free", FREE, ids="-".join)
def test_it_is_the_determinant_whichever_numbers_are_free(free: tuple[str, ...]) -> None:
    for point in POINTS:
        given = {n: rational(v) for n, v in point.items() if n not in free}
        found = CharacteristicPolynomial(family(), given, Budget(1000, 10.0))
        numbers = [sympy.Rational(point[n]) for n in NUMBERS]
        matrix = sympy.Matrix(entries(*numbers))
        shares = {value(found, point, lam) / (lam * sympy.eye(4) - matrix).det() for lam in LAMBDAS}
        assert len(shares) == 1 and shares != {0}
        assert found.factored.zeros == 1
        assert set(found.factored.names) <= set(free)


def test_a_pole_of_an_entry_between_two_blocks_is_named() -> None:
    given = {n: rational(v) for n, v in NUMBERS.items() if n != "p"}
    found = CharacteristicPolynomial(family(), given, Budget(1000, 10.0)).factored
    poles = [p for p in found.nonzero if p.degrees()[0] == 2]
    assert poles and all(p(rational(1), 0) != 0 for p in poles)


def test_a_root_is_a_variable_with_its_relation() -> None:
    given = {n: rational(v) for n, v in NUMBERS.items() if n != "p"}
    rooted = CharacteristicPolynomial(
        family(lambda p: ca.sqrt(1 + p[0] ** 2)), given, Budget(1000, 10.0)
    ).factored
    assert rooted.names == ("p", "sqrt(p**2 + 1)")
    [(place, relation)] = rooted.relations
    assert place == 1 and relation(rational(0.75), rational(1.25), 0) == 0


def test_a_polynomial_beyond_its_budget_is_refused() -> None:
    with pytest.raises(NotExact):
        _ = CharacteristicPolynomial(family(), {}, Budget(3, 10.0)).factored
