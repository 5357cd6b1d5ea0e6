"""Exact conditions with numbers as they were written: fractions, decimals, doubles."""

from decimal import Decimal
from fractions import Fraction

import casadi as ca
import pytest
import sympy

import stability as st
from stability.base.errors import ParameterError
from stability.base.exact_numbers import decimal_of, exact_ratio, ratio_of_text, written


def sprung(held: float = 0.0, system: type[st.System] = st.System) -> st.Family:
    """q̈ = -(9.81 - 0.3 k) q - 0.02 c q̇ about the place that is held."""
    x, p = ca.SX.sym("x", 2), ca.SX.sym("p", 2)
    rates = ca.vertcat(x[1], -(9.81 - 0.3 * p[0]) * (x[0] - held) - 0.02 * p[1] * x[1])
    one = system("sprung", x, p, rates, states=("q", "v"), parameters=("k", "c"))
    return st.Family(one, "rest", at=("k",), held={"q": held, "v": 0.0})


def signs(found: st.Conditions) -> set[str]:
    return {str(c.polynomial) for c in found.conditions}


def test_decimals_are_read_as_they_were_written() -> None:
    found = st.conditions(sprung(), decimals=True)
    # by hand: 9.81 - 0.3 k > 0 is 327 - 10 k > 0
    assert {sympy.expand(sympy.sympify(t)) for t in signs(found)} == {
        sympy.sympify("327 - 10*k"),
        sympy.sympify("c"),
    }
    for text in ("9.81 = 981/100", "0.3 = 3/10", "nearest doubles"):
        assert text in found.numbers
    plain = st.conditions(sprung())
    (static,) = (c.polynomial for c in plain.conditions if c.kind == "static")
    slope, constant = (c for c, _ in static.terms)
    assert Fraction(constant, -slope) == Fraction(9.81) / Fraction(0.3)  # the doubles themselves
    assert "9.81" in plain.numbers
    assert "decimals=True" in plain.numbers


def test_both_readings_decide_their_own_model_at_its_boundary() -> None:
    """The place 32.7 is neutral for decimals; the doubles' boundary is another rational."""
    exact = Fraction(327, 10)
    decimal = st.conditions(sprung(), decimals=True)
    double = st.conditions(sprung())
    beyond = Fraction(9.81) / Fraction(0.3)
    assert exact != beyond
    assert decimal.decide({"k": exact, "c": 1}).word == "neutral"
    assert decimal.verdict(exact, c=1).word == "neutral"
    assert decimal.verdict(Decimal("32.7"), c=sympy.Rational(1, 3)).word == "neutral"
    assert decimal.verdict(32.7, c=0.1).word == "neutral"  # floats are read as decimals too
    assert double.decide({"k": beyond, "c": 1}).word == "neutral"
    assert double.verdict(exact, c=1).word == ("stable" if exact < beyond else "unstable")
    wanted = "stable" if Fraction(32.7) < beyond else "unstable"
    assert double.verdict(32.7, c=0.1).word == wanted
    assert st.spectrum(sprung(), at=32.7, c=0.1, certify=True).verdict.word == wanted


def test_held_decimals_and_unknowns_are_those_of_the_same_model() -> None:
    assert st.conditions(sprung(0.3), decimals=True).zeros == 0
    x, p = ca.SX.sym("x", 2), ca.SX.sym("p")
    rates = ca.vertcat(x[1] - 0.1, 0.02 + p - x[0] ** 2 - 0.3 * (x[1] - 0.1))
    system = st.System("root", x, p, rates, states=("u", "w"), parameters=("p",))
    family = st.Family(
        system,
        "bent",
        at=("p",),
        held={"w": 0.1},
        unknown={"u": 1.0},
        equations=("w",),
        positive=("u",),
    )
    found = st.conditions(family, decimals=True, positive=("p",))
    (relation,) = (p for _, p in found.relations)
    ours = sympy.sympify(str(relation))
    theirs = sympy.sympify("50*u**2 - 50*p - 1")
    assert ours in (theirs, -theirs)
    assert found.verdict(Fraction("0.07"), **{}).word in ("stable", "unstable")


@pytest.mark.parametrize("value", [Fraction(3, 10), Decimal("0.3"), sympy.Rational(3, 10)])
def test_exact_numbers_stay_exact(value: object) -> None:
    found = st.conditions(sprung(), c=value, between={"k": (Fraction(1, 3), Decimal("0.7"))})
    assert found.given == {"c": Fraction(3, 10)}
    assert {"k > 1/3", "k < 7/10"} <= set(found.domain) or "1/3 < k < 7/10" in found.domain
    assert st.conditions(sprung(), c=0.3).given == {"c": Fraction(0.3)}
    assert st.conditions(sprung(), c=0.3, decimals=True).given == {"c": Fraction(3, 10)}
    with pytest.raises(ParameterError, match="c is"):
        st.conditions(sprung(), c="3/10")


def test_a_joined_number_stays_a_double_and_is_named() -> None:
    x, p = ca.SX.sym("x", 1), ca.SX.sym("p")
    rate = 0.1 * (3 * (p * x))  # CasADi makes 0.30000000000000004 of it
    system = st.System("joined", x, p, rate - x * 0.7, states=("x",), parameters=("p",))
    family = st.Family(system, "rest", at=("p",), held={"x": 0.0})
    said = st.conditions(family, decimals=True).numbers
    assert "0.30000000000000004" in said
    assert "0.7 = 7/10" in said
    whole = st.System("whole", x, p, p * x - 2 * x, states=("x",), parameters=("p",))
    rest = st.Family(whole, "rest", at=("p",), held={"x": 0.0})
    assert st.conditions(rest).numbers == ""


def test_extreme_decimals_are_exact() -> None:
    """Powers of ten beyond 2⁵³ and subnormal numbers, against Python's own fractions."""
    for text in (
        "6.02214076e23",
        "1.380649e-23",
        "5.62949953421312e-200",
        "-4e-30",
        "1e300",
        "1e-310",
        "123456789012345e-7",
    ):
        x, p = ca.SX.sym("x", 1), ca.SX.sym("p")
        rate = (p - float(text)) * x
        system = st.System("one", x, p, rate, states=("x",), parameters=("p",))
        family = st.Family(system, "rest", at=("p",), held={"x": 0.0})
        found = st.conditions(family, decimals=True)
        assert found.decide({"p": Fraction(text)}).word == "neutral", text
        assert found.decide({"p": Fraction(text) * Fraction(10**40 + 1, 10**40)}).word in (
            "stable",
            "unstable",
        )


def test_numbers_as_text() -> None:
    for text, ratio in (("9.81", (981, 100)), ("-3/10", (-3, 10)), (".5e-3", (1, 2000))):
        assert ratio_of_text("g", text) == Fraction(*ratio)
    for text in ("1/0", "nan", "1e999", "0x1", "", "1_0", "9" * 500, "1e99999999"):
        with pytest.raises(ParameterError, match="g is"):
            ratio_of_text("g", text)
    assert decimal_of(1 / 3) is None
    assert exact_ratio(True) is None
    assert written(Fraction(-49, 50)) == "-0.98"
    assert written(Fraction(1, 7)) == "1/7"


@pytest.mark.parametrize(
    "limits",
    [
        (1.0, 0.5),
        ("a", 1.0),
        (float("inf"), 1.0),
        (0.0, -float("inf")),
        (float("nan"), 1.0),
        1.0,
        (Fraction(1, 3), Fraction(1, 3)),
        (0, 1, 2),
        "ab",
        (None, 1),
    ],
)
def test_a_wrong_interval_is_refused_in_one_sentence(limits: object) -> None:
    with pytest.raises(ParameterError, match="k is"):
        st.conditions(sprung(), between={"k": limits})
