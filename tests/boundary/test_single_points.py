"""Single values of an axis at which the verdict is neutral, and the same on both sides of them."""

import warnings
from typing import Any

import casadi as ca
import numpy as np
import pytest
from flint import arb

import stability as st
from stability.algebra.exact.rational_functions import RING
from stability.bodies.subject import subject_of
from stability.boundary.algebraic import one_variable
from stability.boundary.algebraic.one_variable import OneVariable, StoredConditions
from stability.boundary.algebraic.tower import Base
from stability.boundary.brackets import AxisScan, refine
from stability.boundary.pairs import grows
from stability.spectra.problem import problem_of

STATES = ("q", "u", "r", "w")


def resting(damped: Any, driven: Any, *more: Any) -> st.Family:
    """Two oscillators, one damped and one driven, and further rates of growth on their own."""
    x, p = ca.SX.sym("x", 4 + len(more)), ca.SX.sym("p")
    rates = [x[1], -x[0] - damped(p) * x[1], x[3], -4 * x[2] + driven(p) * x[3]]
    rates += [rate(p) * x[4 + i] for i, rate in enumerate(more)]
    states = (*STATES, *(f"z{i}" for i in range(len(more))))
    system = st.System("two", x, p, ca.vertcat(*rates), states=states, parameters=("p",))
    return st.Family(system, "rest", at=("p",), held=dict.fromkeys(states, 0.0))


def words(family: st.Family, *values: float) -> list[str]:
    found = st.spectrum(family, at=list(values), certify=True).verdict
    return [v.word for v in np.atleast_1d(found)]


@pytest.mark.parametrize(("low", "high"), [(-1, 1), (0, 1), (-1, 0)])
def test_neutral_between_unstable_is_told_inside_and_at_either_end(low: float, high: float) -> None:
    family = resting(lambda p: p, lambda p: p)
    assert words(family, -1e-9, 0.0, 1e-9) == ["unstable", "neutral", "unstable"]
    found = st.boundaries(family, axis=("p", low, high, 9))
    assert found == [] and found.complete and found.touching == (0.0,)
    assert "at 0 alone it is neutral" in found.statement("p")
    beyond = st.boundaries(family, axis=("p", 0.1, 1, 9))
    assert beyond == [] and beyond.complete and beyond.touching == ()


def test_a_value_that_is_no_rational_is_proved_where_the_damping_vanishes() -> None:
    family = resting(lambda p: p * p - 2, lambda p: p * p - 2)
    found = st.boundaries(family, axis=("p", 0, 3, 9))
    assert found == [] and found.complete and found.touching == pytest.approx([2**0.5], rel=1e-15)


def test_a_pair_that_touches_the_axis_at_an_irrational_value_is_left_open_and_said() -> None:
    """λ³ + λ² + λ + 1 + (p² - 2)²: the product (λ² + 1)(λ + 1) at √2, unstable on both sides."""
    x, p = ca.SX.sym("x", 3), ca.SX.sym("p")
    last = -(1 + (p**2 - 2) ** 2) * x[0] - x[1] - x[2]
    system = st.System(
        "three", x, p, ca.vertcat(x[1], x[2], last), states=("a", "b", "c"), parameters=("p",)
    )
    family = st.Family(system, "rest", at=("p",), held={"a": 0, "b": 0, "c": 0})
    with pytest.warns(st.StabilityWarning, match="between unstable ones, is not decided"):
        found = st.boundaries(family, axis=("p", 0, 3, 9))
    assert found == [] and not found.complete
    [left] = found.unresolved
    assert left.low == left.high == pytest.approx(2**0.5, rel=1e-15)


@pytest.mark.parametrize(
    "more",
    [(lambda p: p + 1,), (lambda p: 3 - p, lambda p: 3 - p), (lambda p: p * p,) * 3],
    ids=["simple", "double", "triple"],
)
def test_what_stays_unstable_is_no_single_point(more: Any) -> None:
    family = resting(lambda p: p * p - 2, lambda p: p * p - 2, *more)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        found = st.boundaries(family, axis=("p", 0.5, 2.5, 9))
    assert found == [] and found.complete and found.touching == ()


def test_a_bead_on_a_turning_saddle_is_neutral_without_friction_alone() -> None:
    """λ⁴ + 2cλ³ + (2Ω² + c²)λ² - 2cΩ²λ + Ω⁴ - a² for axes that turn: -2cΩ² < 0 for every c > 0."""
    x, p = ca.SX.sym("x", 4), ca.SX.sym("p", 2)
    turn, c = p[0], p[1]
    rates = ca.vertcat(
        x[1],
        2 * turn * x[3] - (1 - turn**2) * x[0] - c * x[1],
        x[3],
        -2 * turn * x[1] + (1 + turn**2) * x[2] - c * x[3],
    )
    bead = st.System("bead", x, p, rates, states=STATES, parameters=("turn", "c"))
    family = st.Family(bead, "rest", at=("turn",), held=dict.fromkeys(STATES, 0.0))
    found = st.boundaries(family, axis=("c", 0, 1, 9), at=1.5)
    assert found == [] and found.complete and found.touching == (0.0,)
    slow = st.boundaries(family, axis=("c", 0, 1, 9), at=0.5)  # unstable without friction too
    assert slow == [] and slow.complete and slow.touching == ()


def test_growth_is_proved_from_what_grows_alone() -> None:
    random = np.random.default_rng(20261122)
    proved = 0
    for _ in range(300):
        pairs = random.uniform(-2, 0.3, 2) + 1j * random.uniform(0, 2, 2)
        roots = np.concatenate([pairs, pairs.conj(), np.repeat(random.uniform(-2, 0.3), 2)])
        exact = [arb(1)]
        for root in (pairs[0], pairs[1]):
            square = [arb(abs(root.real)) ** 2 + arb(root.imag) ** 2, -2 * arb(root.real), arb(1)]
            exact = _product(exact, square)
        double = [arb(-float(roots[-1].real)), arb(1)]
        exact = _product(_product(exact, double), double)
        wanted = bool((roots.real > 0).any())
        assert not grows(exact) or wanted
        proved += grows(exact) and wanted
        assert grows(exact) == wanted or 0 < roots.real.max() < 1e-6
    assert proved > 50


def _product(a: list[Any], b: list[Any]) -> list[Any]:
    out = [arb(0)] * (len(a) + len(b) - 1)
    for i, p in enumerate(a):
        for j, q in enumerate(b):
            out[i + j] += p * q
    return out


def test_a_map_with_an_edge_of_neutral_members_says_what_is_open_and_ends_soon() -> None:
    """Bisection of the verdict once ran towards 0 through a thousand doubles, for every cell."""
    family = resting(lambda p: p, lambda p: p)
    line = AxisScan(problem_of(subject_of(family, at=0.0, parameters={})), "p", {})
    asked: list[float] = []
    sign = line.quick_sign
    line.quick_sign = lambda value: asked.append(value) or sign(value)  # type: ignore[method-assign, func-returns-value]
    assert refine(line, 0.0, 1.0) is None  # unstable on both sides: no bracket
    assert len(asked) < 20


@pytest.mark.parametrize("word", ["NEUTRAL", "UNSTABLE", "UNDECIDED"])
def test_a_condition_that_is_zero_between_unstable_sides_proves_nothing_alone(
    word: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    x = RING.gens()[0]
    source = StoredConditions([("static", RING.constant(1)), ("flutter", -(x**2))], None)
    family = resting(lambda p: p, lambda p: p)
    line = AxisScan(problem_of(subject_of(family, at=0.0, parameters={})), "p", {})
    members = OneVariable(line, source, Base("plain"), (-1.0, 1.0), dissipative=True)
    [(one, below, above)] = members.between()
    assert below.look.sign == above.look.sign == -1
    monkeypatch.setattr(one_variable, "certified", lambda *_: st.Verdict[word])
    assert members.unstable(one) is (False if word == "NEUTRAL" else None)


def test_a_result_names_the_value_at_which_alone_a_stable_member_is_neutral() -> None:
    x, c = ca.SX.sym("x", 2), ca.SX.sym("c")
    swing = st.System(
        "swing", x, c, ca.vertcat(x[1], -x[0] - c**2 * x[1]), states=("q", "v"), parameters=("c",)
    )
    rest = st.Family(swing, "rest", at=("c",), held={"q": 0, "v": 0})
    found = st.boundaries(rest, axis=("c", -1, 1, 9))
    assert (len(found), found.touching, found.complete) == (0, (0.0,), True)
    assert "at 0 alone it is neutral" in repr(found)
    words = [st.spectrum(rest, at=v, certify=True).verdict.word for v in (-0.5, 0.0, 0.5)]
    assert words == ["stable", "neutral", "stable"]


class Slow(st.ExactPolynomial):
    """G λ + 1: the eigenvalue is infinite at g = 0."""

    def coefficients(self, values: Any, _: Any) -> Any:
        return [[1, values["g"]]]


@pytest.mark.parametrize(
    ("below", "slow", "said"),
    [
        (lambda g: g, True, "differs on the two sides"),
        (lambda g: g, False, "is the same on both sides"),
        (ca.sin, False, "is the same on both sides"),
    ],
    ids=["stated", "rational", "algebraic"],
)
def test_a_value_without_a_linearisation_is_left_open(below: Any, slow: bool, said: str) -> None:
    """Also where the entry without a value lies between two strong components: y drives x."""
    x, g = ca.SX.sym("x", 1 if slow else 2), ca.SX.sym("g")
    rates = -x / g if slow else ca.vertcat(-x[0] + x[1] / below(g), -2 * x[1])
    states = ("x", "y")[: len(rates.elements())]
    system = st.System("pole", x, g, rates, states=states, parameters=("g",))
    held = dict.fromkeys(states, 0.0)
    family = st.Family(system, "rest", ("g",), held=held, exact=Slow() if slow else None)
    with pytest.warns(st.StabilityWarning, match="no value there"):
        found = st.boundaries(family, axis=("g", -1, 2, 9))
    [left] = found.unresolved
    assert found == [] and left.low <= 0 <= left.high and said in left.reason
