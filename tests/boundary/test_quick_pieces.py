"""What the kernel of pieces claims, against balls of many digits from the same formulas."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from flint import arb, arb_series, ctx

import stability as st
from stability.algebra.kernels.tape import recorded, recorded_series
from stability.algebra.number_types import balls, precision
from stability.bodies.subject import subject_of
from stability.boundary import brackets
from stability.boundary.interval_search.meetings import FormulaMeetings, watched
from stability.boundary.interval_search.quick_pieces import ORDER, Rounds, rounds_of
from stability.boundary.interval_search.taylor import coefficient, series_algebra, terms
from stability.spectra.problem import problem_of
from stability.systems.closed_form import ImplicitForm

LINES: dict[str, tuple[st.Body, str, str, str, dict[str, float], tuple[float, float]]] = {
    "theta": (st.Torus(0.2), "tumbling", "viscous", "theta", {"tube": 0.2, "mu": 0.3}, (0.1, 1.5)),
    "mu": (
        st.Spheroid(0.6),
        "tumbling",
        "viscous",
        "mu",
        {"aspect": 0.6, "theta": 2.55},
        (0.05, 2.0),
    ),
    "number": (st.Torus(0.2), "tumbling", "rough", "tube", {"theta": 0.9}, (0.05, 0.5)),
    "solved": (
        st.ThickDisk(0.1),
        "rolling",
        "viscous",
        "omega3",
        {"thickness": 0.1, "mu": 0.3},
        (0.2, 3.0),
    ),
}


def rounds(name: str) -> Rounds:
    body, family, law, axis, values, _ = LINES[name]
    line = brackets.AxisScan(
        problem_of(subject_of(body.family(family, law), parameters=values)), axis, values
    )
    assert line.formulas is not None
    found = rounds_of(FormulaMeetings(line, line.formulas))
    assert found is not None
    return found


def exactly(found: Rounds, value: float, order: int) -> list[list[Any]]:
    """Taylor coefficients of each function at a point, in balls of 256 bits."""
    line, formulas = found.meetings.line, found.meetings.formulas
    with precision(256), terms(order + 1):
        a, q = line.numbers_at(arb_series([arb(value), 1]))
        coefficients, _, positive = formulas(series_algebra(), a, q)
        both = [*watched(coefficients, even=formulas.even), *positive]
        return [[coefficient(f, k) for k in range(order + 1)] for f in both]


def holds(mid: float, rad: float, true: Any) -> bool:
    with precision(256):
        return bool(abs(true - arb(float(mid))) <= arb(float(rad)) + arb(2) ** -180)


@pytest.mark.few(2)
@pytest.mark.parametrize("name", LINES)
def test_coefficients_at_points_and_over_pieces_hold_the_true_ones(name: str) -> None:
    found, (low, high) = rounds(name), LINES[name][-1]
    points = np.random.default_rng(3).uniform(low, high, 12)
    for tape, order in ((found.whole, ORDER), (found.inner, ORDER - 1), (found.slope, 1)):
        for width in (0.0, 1e-3):
            mid, rad = found._at(points, np.full(12, width), tape)
            assert np.isfinite(rad).all()
            for i, point in enumerate(points):
                for side in (-0.9, 0.0, 0.9):
                    for f, series in enumerate(exactly(found, point + side * width, order)):
                        for k, true in enumerate(series):
                            assert holds(mid[f, k, i], rad[f, k, i], true), (f, k)


def test_the_solved_inclination_has_a_radius() -> None:
    """Its double is off by some share of its last digit, which the kernel must know."""
    found = rounds("solved")
    formulas = found.meetings.formulas
    assert isinstance(formulas, ImplicitForm)
    with precision(256):
        true = formulas.solved(balls(), [arb(0.1), arb(0.3)])
    [place] = [i for i, e in enumerate(found.inputs[1]) if e > 0]
    assert 0 < found.inputs[1][place] < 1e-15
    assert holds(found.inputs[0][place], found.inputs[1][place], true)


def test_a_kept_unknown_is_one_of_the_precision_that_is_asked() -> None:
    found = rounds("solved").meetings.formulas
    assert isinstance(found, ImplicitForm)
    for bits in (64, 256):  # the second must not find what the first has kept
        with precision(bits):
            assert found.solved(balls(), [arb(0.1), arb(0.3)]).rad() < arb(2) ** (20 - bits)


def test_a_solved_unknown_over_wide_parameters_holds_both_ends() -> None:
    found = rounds("solved").meetings.formulas
    assert isinstance(found, ImplicitForm)
    with precision(128):
        wide = found.solved(balls(), [arb(0.1, 1e-4), arb(0.3)])
        for end in (arb(0.1) - arb(0.99e-4), arb(0.1) + arb(0.99e-4)):
            one = found.solved(balls(), [end, arb(0.3)])
            assert wide.contains(one)
    assert ctx.prec == 53


@pytest.mark.long
@pytest.mark.parametrize("name", LINES)
def test_judged_pieces_are_clear_or_monotone_as_said(name: str) -> None:
    """At many points of each: no zero, a member, and one sign of the slope where that is said."""
    found, (low, high) = rounds(name), LINES[name][-1]
    said = [0, 0]
    for count in (40, 5000):
        cuts = np.linspace(low, high, count + 1)
        free, slopes = found._judged(cuts[:-1], cuts[1:])
        for i in range(count):
            inside = np.linspace(cuts[i], cuts[i + 1], 25)
            mid, rad = found._at(inside, np.zeros(25), found.slope)
            if free[i]:
                said[0] += 1
                signs = np.sign(mid[:, 0])
                assert (np.abs(mid[:, 0]) > rad[:, 0]).all()
                assert (signs == signs[:, :1]).all()
                assert (mid[found.functions :, 0] > 0).all()
            for f in np.flatnonzero(slopes[:, i] & ~free[i]):
                said[1] += 1
                assert len(set(np.sign(mid[f, 1]))) == 1
    assert min(said[0], said[1] if name != "number" else 1) > 0


def test_no_piece_with_an_inclination_beyond_the_height_is_judged() -> None:
    """Beyond π/2 a thick disk has no member although its formulas have values."""
    body = st.ThickDisk(0.1)
    values = {"thickness": 0.1, "phi_dot": 1.7}
    problem = problem_of(subject_of(body.family("precession", "smooth"), parameters=values))
    line = brackets.AxisScan(problem, "theta", values)
    assert line.formulas is not None
    found = rounds_of(FormulaMeetings(line, line.formulas))
    assert found is not None
    cuts = np.linspace(1.5, 1.65, 61)
    free, slopes = found._judged(cuts[:-1], cuts[1:])
    outside = cuts[1:] > np.pi / 2
    assert free[~outside].any()
    assert not free[outside].any()
    assert not slopes[:, outside].any()


def test_powers_of_series_are_those_of_their_functions() -> None:
    tape = recorded_series(
        lambda a, t: [t.functions["pow"](a[0], -2.0), t.functions["pow"](a[0], 3.0)], 1, 0, 3
    )
    mid, rad = tape.run(np.array([[0.8]]))
    true = [0.8**-2, -2 * 0.8**-3, 3 * 0.8**-4, -4 * 0.8**-5, 0.8**3, 3 * 0.8**2, 3 * 0.8, 1.0]
    assert (np.abs(mid[:, 0] - true) <= rad[:, 0] + 1e-15).all()
    assert (rad < 1e-12).all()


def test_a_tape_of_order_zero_gives_the_values() -> None:
    def run(a: list[Any], t: Any) -> list[Any]:
        return [t.functions["sin"](a[0]) * a[1] / (a[0] + a[1])]

    given = np.array([[0.4, 1.1], [2.0, 0.3]])
    plain, series = recorded(run, 2), recorded_series(run, 2, 0, 0)
    (m, r), (n, s) = plain.run(given), series.run(given)
    assert (np.abs(m - n) <= r + s).all()
    assert (np.abs(m - np.sin(given[0]) * given[1] / given.sum(axis=0)) < 1e-15).all()
