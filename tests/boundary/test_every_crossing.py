"""Every crossing of the imaginary axis, counted on both sides, against planted ones."""

import json
import math
import random
from fractions import Fraction
from typing import Any

import casadi as ca
import numpy as np
import pytest
from flint import arb, fmpq, fmpq_poly
from planted_crossings import HIGH, LOW, Plan

import stability as st
from stability.algebra.exact.routh import sign_changes, unstable_roots
from stability.boundary.pairs import unstable_count
from stability.cli import main

REACHED = "reach the imaginary axis there is not decided"


def compared(seed: int, route: str) -> int:
    """Compare one family with its plan; the number of crossings."""
    plan = Plan(seed)
    crossings, touching = plan.crossings()
    family, axis = plan.family(route)
    found = st.boundaries(family, axis=("q", axis(LOW), axis(HIGH), 9), every=True)
    touching = [axis(v) for v in touching]
    lowest = route in ("rational", "exponential")  # with sines and unknowns factors are joined
    if not lowest:  # where eigenvalues change places in a factor its number does not change
        near = [*found.touching, *(u.low for u in found.unresolved)]
        same = [e for e in crossings if e.below == e.above]
        same = [
            e for e in same if any(math.isclose(axis(e.zero.near), v, abs_tol=1e-9) for v in near)
        ]
        crossings = [e for e in crossings if e not in same]
        touching = sorted([*touching, *(axis(e.zero.near) for e in same)])
        left = [u for u in found.unresolved if REACHED in u.reason]
        touching = [v for v in touching if not any(u.low <= v <= u.high for u in left)]
        assert len(left) == len(found.unresolved) <= 2, found.unresolved
    else:
        assert found.complete, found.unresolved
    assert len(found) == len(crossings), (found, crossings)
    for one, expected in zip(found, crossings, strict=True):
        zero = expected.zero
        if route == "rational":
            low, high = (Fraction(one.value) + k * Fraction(one.error) for k in (-1, 1))
            assert zero(low) <= 0 <= zero(high)
        assert math.isclose(one.value, axis(zero.near), rel_tol=1e-14, abs_tol=1e-15)
        assert (one.unstable_below, one.unstable_above) == (expected.below, expected.above)
        if lowest:
            assert one.frequencies == pytest.approx(expected.rates, rel=1e-12)
        else:  # as far as factors that are not in lowest terms change
            assert one.frequencies
            every = [*expected.rates, *expected.touching]
            for w in one.frequencies:
                nearest = min(every, key=lambda v, w=w: abs(v - w))
                assert nearest == pytest.approx(w, rel=1e-12)
                every.remove(nearest)
        zeros, pairs = any(w == 0 for w in one.frequencies), any(one.frequencies)
        word = {(True, False): "static", (False, True): "flutter"}
        assert one.crossing.word == word.get((zeros, pairs), "static_and_flutter")
    assert found.touching == pytest.approx(touching, rel=1e-14, abs=1e-15)
    if not crossings and found.complete:
        assert found.throughout == sum(b.unstable(Fraction(1, 7)) for b in plan.blocks)
    return len(crossings)


@pytest.mark.parametrize(
    ("route", "count"), [("rational", 8), ("exponential", 8), ("sine", 4), ("unknown", 4)]
)
def test_planted_crossings_are_listed_with_both_numbers(route: str, count: int) -> None:
    assert sum(compared(seed, route) for seed in range(count)) > count


def compared_in_pieces(seed: int) -> tuple[int, int]:
    """As `compared`, on an axis that is not algebraic; the numbers of crossings and open ones."""
    plan = Plan(seed)
    family, axis = plan.family("pieces")
    found = st.boundaries(family, axis=("q", axis(LOW), axis(HIGH), 9), every=True)
    assert "ball arithmetic" in found.how
    waiting, left = list(found), 0
    for expected in plan.crossings()[0]:
        value = axis(expected.zero.near)
        near = [c for c in waiting if abs(c.value - value) <= c.error + 1e-14]
        if near:
            [one] = near
            waiting.remove(one)
            assert (one.unstable_below, one.unstable_above) == (expected.below, expected.above)
            assert one.frequencies == pytest.approx(expected.rates, rel=1e-9)
        else:
            assert any(u.low - 1e-14 <= value <= u.high + 1e-14 for u in found.unresolved)
            left += 1
    assert not waiting
    return len(found), left


def test_planted_crossings_are_listed_on_an_axis_that_is_not_algebraic() -> None:
    assert sum(compared_in_pieces(seed)[0] for seed in (3, 4, 6, 8)) > 10


@pytest.mark.long
@pytest.mark.filterwarnings("ignore::stability.StabilityWarning")  # what is left open is counted
def test_planted_crossings_of_many_families_that_are_not_algebraic() -> None:
    crossings, left = np.sum([compared_in_pieces(seed) for seed in range(100, 120)], axis=0)
    assert crossings > 2 * left


def test_a_crossing_at_zero_is_at_zero() -> None:
    """Both numbers are proved as near to it as doubles lie; a ball that holds zero proves none."""
    x, a = ca.SX.sym("x"), ca.SX.sym("a")
    system = st.System("s", x, a, (ca.exp(a) - ca.cos(a)) * x, states=("x",), parameters=("a",))
    family = st.Family(system, "rest", at=("a",), held={"x": 0})
    for low, high in ((-1, 1), (-1, 10), (-0.5, 3)):
        [one] = st.boundaries(family, axis=("a", low, high, 9), every=True)
        assert one.value == 0.0 and one.error <= 1e-300
        assert (one.unstable_below, one.unstable_above) == (0, 1)
    assert unstable_count([arb(0, 1e-38), arb(14.3), arb(1), arb(1)], even=False) is None
    assert unstable_count([arb(0), arb(14.3), arb(1), arb(1)], even=False) == 0


def test_three_pairs_of_lorenz_84_cross_on_an_unstable_sheet() -> None:
    """At each value two eigenvalues are opposite and imaginary; counts by LAPACK on both sides."""
    x, p = ca.SX.sym("x", 4), ca.SX.sym("p", 2)
    a, b, c, u = ca.vertsplit(x)
    rates = ca.vertcat(
        -(b**2) - c**2 - a / 4 + p[0] / 4 - 0.987 * u**2,
        a * b - a * c - b + 0.25,
        a * b + a * c - c,
        -1.04 * u + 0.987 * u * a + p[1],
    )
    system = st.System("Lorenz-84", x, p, rates, states=("X", "Y", "Z", "U"), parameters=("F", "T"))
    guess = {"X": 1.1526, "Y": -0.0282, "Z": 0.2132, "U": -0.4096, "F": 2.0, "T": 0.04}
    sheet = system.steady("F", guess=guess)
    found = st.boundaries(sheet, axis=("F", 1.6, 6, 9), T=0.04, every=True)
    assert found.complete and [(c.unstable_below, c.unstable_above) for c in found] == [
        (4, 2),
        (2, 4),
        (4, 2),
    ]
    for one in found:
        values = st.spectrum(sheet, at=one.value, T=0.04).eigenvalues
        pair = values[np.abs(values.real) < 1e-12]
        assert len(pair) == 2 and abs(pair.imag).max() == pytest.approx(one.frequencies[0])
        for step, count in ((-0.01, one.unstable_below), (0.01, one.unstable_above)):
            spectrum = st.spectrum(sheet, at=one.value + step, T=0.04)
            assert (spectrum.eigenvalues.real > 0).sum() == count


@pytest.mark.long
@pytest.mark.filterwarnings("ignore::stability.StabilityWarning")  # what is left open is counted
@pytest.mark.parametrize("route", ["rational", "exponential", "sine", "unknown"])
def test_planted_crossings_of_many_families(route: str) -> None:
    assert sum(compared(seed, route) for seed in range(100, 400)) > 600


def test_two_pairs_and_a_zero_at_one_value_are_one_entry() -> None:
    """λ - p, and λ² - p λ + 1 and λ² - p λ + 4: a zero and two pairs cross at p = 0."""
    x, p = ca.SX.sym("x", 5), ca.SX.sym("p")
    rates = ca.vertcat(p * x[0], x[2], p * x[2] - x[1], x[4], p * x[4] - 4 * x[3])
    states = tuple(f"x{i}" for i in range(5))
    system = st.System("coincidence", x, p, rates, states=states, parameters=("p",))
    family = st.Family(system, "rest", at=("p",), held=dict.fromkeys(states, 0.0))
    found = st.boundaries(family, axis=("p", -1, 1, 9), every=True)
    [one] = found
    assert (one.value, one.unstable_below, one.unstable_above) == (0.0, 0, 5)
    assert one.crossing is st.Crossing.STATIC_AND_FLUTTER and one.frequencies == (0.0, 1.0, 2.0)
    said = "static and flutter, 0 unstable below, 5 above, frequencies 0, 1, 2"
    assert said in repr(found) and said in one.words()
    [row] = found.to_pandas().to_dict("records")
    assert row["unstable above"] == 5 and row["frequencies"] == "0.0; 1.0; 2.0"


def test_divergence_behind_flutter_is_printed_by_the_command(
    capsys: pytest.CaptureFixture[str],
) -> None:
    """Below flutter at √2 a rolling disk has two unstable eigenvalues, below √(1/3) one."""
    words = ["boundaries", "rolling", "--axis", "at:0.1:5:9", "--mu", "1", "--every", "--json"]
    assert main(words) == 0
    found = json.loads(capsys.readouterr().out)
    squares = [c["value"] ** 2 for c in found["crossings"]]
    assert squares == pytest.approx([1 / 3, 2], rel=1e-15)
    counts = [(c["unstable_below"], c["unstable_above"]) for c in found["crossings"]]
    assert counts == [(1, 2), (2, 0)]
    for number in (0.5, 1.0, 1.5):
        spectrum = st.spectrum("rolling", at=number, contact=st.Viscous(1))
        expected = counts[0][0] if number < squares[0] ** 0.5 else counts[1][number > 1.414]
        assert sum(spectrum.eigenvalues.real > 1e-9) == expected


def test_squares_of_a_spinning_saddle_meet_cross_zero_or_touch_it() -> None:
    """λ⁴ + (1 - a - b) λ² + a b: λ² meet at -1/4 for a = b = 1/4, and are 0 for a = 0."""
    x, p = ca.SX.sym("x", 4), ca.SX.sym("p", 2)
    for b, crossings, touching in (
        (p[0] + p[1], [(0.25, 0, 2, (0.5,))], (0.0,)),
        (p[1] - 1, [(0.0, 0, 1, (0.0,))], ()),
    ):
        turned = ca.vertcat(x[1], p[0] * x[0] + x[3], x[3], b * x[2] - x[1])
        system = st.System("saddle", x, p, turned, states=tuple("xuyv"), parameters=("a", "c"))
        family = st.Family(system, "rest", at=("a",), held=dict.fromkeys("xuyv", 0.0))
        found = st.boundaries(family, axis=("a", -0.9, 0.9, 9), c=0.0, every=True)
        assert found.complete and found.touching == touching
        assert [
            (c.value, c.unstable_below, c.unstable_above, c.frequencies) for c in found
        ] == crossings


def test_the_number_throughout_is_that_of_the_interval_and_not_of_its_surroundings() -> None:
    """√(1/3) is a little below the interval, and √2 a little above."""
    found = st.boundaries("rolling", axis=("at", 0.58, 1.41, 9), contact=st.Viscous(1), every=True)
    assert not found and found.complete and found.throughout == 2
    assert "2 unstable eigenvalues throughout" in found.statement("at")


def test_a_locus_tells_boundaries_from_other_crossings() -> None:
    law = st.Viscous(1)
    found = st.boundaries("rolling", axis=("at", 0.1, 3, 9), contact=law, every=True)
    spectrum = st.spectrum("rolling", at=np.linspace(0.1, 3, 30), contact=law)
    panel = st.plot_locus(spectrum, thresholds=found).axes[0]
    dotted = [line for line in panel.lines if line.get_label() == "change of verdict"]
    assert [line.get_xdata()[0] for line in dotted] == [found[1].value]


@pytest.mark.parametrize("law", ["smooth", "viscous", "linear-viscous", "rough"])
def test_boundaries_of_the_disk_are_the_crossings_without_others(law: str) -> None:
    """Boundaries come from conditions, crossings from the polynomial; along k also with sin 0.5."""
    contact: dict[str, Any] = {"contact": law}
    contact |= {"viscous": {"mu": 0.42}, "linear-viscous": {"c": 26.0}}.get(law, {})
    asked = [("rolling", ("at", 0.1, 5, 9), {}), ("spinning", ("at", 0.1, 5, 9), {})]
    asked += [("tumbling", ("at", 0.1, 1.5, 9), {}), ("tumbling", ("k", 0.05, 0.5, 9), {"at": 0.5})]
    for family, axis, given in asked:
        edges = st.boundaries(family, axis=axis, **given, **contact)
        crossings = st.boundaries(family, axis=axis, every=True, **given, **contact)
        assert crossings.complete
        alone = [c for c in crossings if min(c.unstable_below, c.unstable_above) == 0]
        assert [c.value for c in alone] == [e.value for e in edges]
        for one, edge in zip(alone, edges, strict=True):
            assert (one.unstable_below == 0) == edge.stable_below
            assert max(one.frequencies) == pytest.approx(edge.frequency, rel=1e-12)


def test_unstable_roots_are_counted_with_multiplicities() -> None:
    draw = random.Random(20261129)
    for _ in range(500):
        p, expected = fmpq_poly([draw.choice([1, -3])]), 0
        for _ in range(draw.randint(0, 4)):
            a, b = fmpq(draw.randint(-4, 4), 2), fmpq(draw.randint(1, 9), 3)
            pair, power = draw.random() < 0.5, draw.choice([1, 1, 2, 3])
            p *= fmpq_poly([a * a + b, -2 * a, 1] if pair else [-a, 1]) ** power
            expected += (a > 0) * (2 if pair else 1) * power
        assert unstable_roots(p) == expected
        if p.degree() and (count := sign_changes([arb(c) for c in p.coeffs()])) is not None:
            assert count == expected
