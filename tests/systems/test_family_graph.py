"""A family's graph holds no number that CasADi has rounded, by whichever way it was read."""

from collections.abc import Callable
from fractions import Fraction

import casadi as ca
import numpy as np
import pytest

import stability as st
from stability.systems.graph import constants, family_graph

Make = Callable[[ca.SX, ca.SX], ca.SX]


def family(make: Make, held: float = 0.0) -> st.Family:
    """ẋ = -x, ẏ = make(x, p) y at x = held."""
    x, p = ca.SX.sym("x", 2), ca.SX.sym("p")
    system = st.System(
        "one", x, p, ca.vertcat(-x[0], x[1] * make(x[0], p)), states=("x", "y"), parameters=("p",)
    )
    return st.Family(system, "rest", at=("p",), held={"x": held, "y": 0.0})


def TWO(x: ca.SX) -> ca.SX:  # noqa: N802
    return ca.cos(x) + ca.exp(x)


def THREE(x: ca.SX) -> ca.SX:  # noqa: N802
    return ca.cos(x) + ca.exp(x) + ca.cosh(x)


def tenths(x: ca.SX) -> ca.SX:
    """Ten tenths, each another expression of x: 0.9999999999999999 in doubles."""
    c, e, h = ca.cos(x), ca.exp(x), ca.cosh(x)
    parts = [c, e, h, c * e, c * h, e * h, c * c, e * e, h * h, c * e * h]
    whole = sum(parts[1:], parts[0])
    return sum((part / whole for part in parts[1:]), parts[0] / whole)


@pytest.mark.few(1)
@pytest.mark.parametrize(
    "make",
    [
        lambda x, p: p * tenths(x) - p,
        lambda x, p: ca.sqrt(TWO(x)) ** 2 - TWO(x) + 0 * p,
        lambda x, p: p * ca.sqrt(TWO(x)) * ca.sqrt(ca.cosh(x) + ca.exp(x)) - p * TWO(x),
        lambda x, p: ca.exp(ca.cos(x)) * ca.exp(-ca.cos(x)) - 1 + 0 * p,
    ],
)
def test_an_eigenvalue_that_is_exactly_zero_is_never_proved_to_be_another(make: Make) -> None:
    """√2 √2 - 2 is 4e-16 in doubles: a proof from that number would be wrong."""
    found = st.spectrum(family(make), at=1.0, certify=True)
    assert found.verdict.word in ("stable", "undecided")
    assert "proved" not in found.reason or found.structural_zeros == 1


@pytest.mark.parametrize(
    "make",
    [
        lambda x, p: p * ca.cos(x) - ca.sin(x) + x**2 * ca.exp(p),
        lambda x, p: ca.sqrt(p + x**2) / (1 + ca.cosh(x)),
        lambda x, p: p**3 / THREE(x) + ca.acos(x),
        lambda x, p: ca.fabs(p - 1) * x + ca.log(ca.cos(x)) - ca.tan(x + p) / 7,
    ],
)
@pytest.mark.parametrize("held", [0.0, 0.3])
def test_both_ways_of_reading_a_graph_give_the_same_numbers(
    make: Make, held: float, monkeypatch: pytest.MonkeyPatch
) -> None:
    plain = family(make, held)
    a, q = np.array([[0.7], [1.3]]), np.zeros((2, 0))
    fast = plain.matrix(a, q, q)
    monkeypatch.setattr(family_graph, "exact_numbers", lambda *_: False)
    slow = family(make, held).matrix(a, q, q)
    assert fast == pytest.approx(slow, rel=1e-15, abs=1e-16)
    system = plain.system
    state = np.broadcast_to([held, 0.0], (2, 2))
    assert fast == pytest.approx(system.linearise(state, a), rel=1e-14, abs=1e-15)


def test_small_binary_numbers_count_as_exact_and_others_do_not() -> None:
    x = ca.SX.sym("x")
    for number, exact in ((0.5, True), (3.0, True), (1 / 3, False), (2.0**-54, False)):
        assert constants.exact_numbers(x * number + ca.sin(x)) is exact, Fraction(number)
