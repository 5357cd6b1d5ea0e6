"""Growth rates of λ² + a₀ from a coefficient with a bound, against square roots of integers."""

from __future__ import annotations

from fractions import Fraction
from math import isqrt

import numpy as np
import pytest

from stability.algebra.kernels import double_balls
from stability.algebra.kernels.compiled import compiled, numba_found
from stability.base.verdict import CODES, Verdict
from stability.maps.compiled import squares
from stability.maps.engine import FLAGS
from stability.maps.rates import WANTED, rates

SCALE = 10**60


def root(value: Fraction) -> Fraction:
    """√value for value ≥ 0, to 30 digits."""
    return Fraction(isqrt(value.numerator * SCALE // value.denominator), 10**30)


def found(a: np.ndarray, error: np.ndarray) -> list[np.ndarray]:
    """Abscissa, bound, frequency, flags and whether the cell is left open."""
    none = np.zeros_like(a)
    made = rates(
        [((np.array([a, none]), np.array([error, none])), True, 1)], (1, len(a)), modes=False
    )
    return [made.abscissa, made.error, made.frequency, made.codes, made.poor]


def test_every_root_within_the_coefficient_is_within_the_bound() -> None:
    random = np.random.default_rng(5)
    a = random.choice([-1, 1], 400) * 10.0 ** random.uniform(-9, 9, 400)
    error = np.abs(a) * 10.0 ** random.uniform(-17, 1, 400)
    top, bound, turn, codes, poor = found(a, error)
    decided = 0
    for i in range(len(a)):
        for end in (-1, 0, 1):
            y = -(Fraction(a[i]) + end * Fraction(error[i]))
            growth = root(y) if y > 0 else Fraction(0)
            verdict = Verdict.UNSTABLE if y > 0 else Verdict.NEUTRAL
            assert codes[i] in (0, CODES[verdict])
            if not poor[i]:
                assert abs(growth - Fraction(top[i])) <= Fraction(bound[i])
        decided += not poor[i]
        assert poor[i] or error[i] < (1e-9 if a[i] < 0 else 1) * abs(a[i])
        assert poor[i] or abs(turn[i] - (abs(a[i]) ** 0.5 if a[i] > 0 else 0)) <= 1e-15 * turn[i]
        assert not poor[i] or error[i] > 1e-12 * abs(a[i])  # what could be decided is
    assert 100 < decided < 300


def test_what_is_no_number_is_left_open() -> None:
    a = np.array([0.0, 1.0, -1.0, np.nan, np.inf, 1.0, -1.0, 5e-324])
    error = np.array([0.0, np.inf, np.nan, 0.0, 0.0, 1.0, 1.0, 5e-324])
    *_, codes, poor = found(a, error)
    assert poor.all()
    assert not codes.any()


def test_the_rates_are_those_with_all_eigenvalues() -> None:
    random = np.random.default_rng(6)
    a = random.normal(size=300) * 10.0 ** random.uniform(-3, 3, 300)
    error = 1e-15 * np.abs(a)
    none = np.zeros_like(a)
    factor = ((np.array([a, none]), np.array([error, none])), True, 1)
    one, other = (
        rates([factor], (1, len(factor[0][0][0])), modes=modes) for modes in (False, True)
    )
    assert np.allclose(one.abscissa, other.abscissa, rtol=1e-15, atol=0)
    assert np.allclose(one.frequency, other.frequency, rtol=1e-15, atol=0)
    assert (one.codes == other.codes).all()
    assert (one.error <= 2 * other.error).all() and (other.error <= 2 * one.error).all()


def swept(
    c: np.ndarray,
    lead: np.ndarray,
    off: np.ndarray,
    slack: np.ndarray,
    number: np.ndarray,
    doubt: np.ndarray,
) -> list[np.ndarray]:
    """Cells of compiled loops for given coefficients: a tape without a step."""
    given = np.array([c, lead, off, slack, number, doubt])
    out, codes = np.empty((3, len(c))), np.empty(len(c), dtype=np.int8)
    kernel = compiled(double_balls, squares, plain=not numba_found())
    with np.errstate(all="ignore"):
        kernel.sweep(
            np.empty((0, 4), dtype=np.int64),
            np.zeros(7),
            (np.arange(6), given),
            (np.array([6]), np.zeros((1, 1))),
            np.arange(6),
            WANTED,
            np.array(FLAGS, dtype=np.int8),
            tuple(out),
            codes,
        )
    return [*out, codes]


@pytest.mark.parametrize("count", [60, pytest.param(700, marks=pytest.mark.long)])
def test_the_loops_hold_every_root_within_both_coefficients(count: int) -> None:
    random = np.random.default_rng(7)
    c, lead = (
        random.choice([-1, 1], count) * 10.0 ** random.uniform(-5, 5, count) for _ in range(2)
    )
    off, slack = (np.abs(v) * 10.0 ** random.uniform(-17, 1, count) for v in (c, lead))
    none = np.full(count, 1.0), np.zeros(count)
    top, bound, turn, codes = swept(c, lead, off, slack, *none)
    neutral, unstable, left, _ = FLAGS
    seen = set()
    for i in range(count):
        seen.add(int(codes[i]))
        assert (codes[i] == left) == np.isinf(bound[i])
        if codes[i] == left:
            assert off[i] > 1e-12 * abs(c[i]) or slack[i] > 1e-12 * abs(lead[i])
            continue
        for one in (-1, 0, 1):
            for other in (-1, 0, 1):
                y = -(Fraction(c[i]) + one * Fraction(off[i]))
                y /= Fraction(lead[i]) + other * Fraction(slack[i])
                assert codes[i] == (unstable if y > 0 else neutral)
                growth = root(y) if y > 0 else Fraction(0)
                assert abs(growth - Fraction(top[i])) <= Fraction(bound[i]) + Fraction(1, 10**29)
        assert abs(top[i] + turn[i] - abs(c[i] / lead[i]) ** 0.5) <= 1e-15 * (top[i] + turn[i])
        assert (top[i] == 0) == (codes[i] == neutral)
    assert seen == {neutral, unstable, left}


def test_the_loops_know_members_from_what_may_be_none() -> None:
    number = np.array([1.0, 1.0, 1.0, 0.0, -1.0, -1.0, -2.0, np.nan, 1.0])
    doubt = np.array([0.5, 1.0, 2.0, 0.0, 2.0, 1.0, 1.0, 0.0, np.nan])
    one = np.ones(len(number))
    top, bound, turn, codes = swept(-one, one, 0 * one, 0 * one, number, doubt)
    _, unstable, left, lacking = FLAGS
    assert codes.tolist() == [unstable, *[left] * 5, lacking, left, left]
    assert np.isinf(bound[codes == left]).all()
    for rate in (top, bound, turn):
        assert (np.isnan(rate) == (codes == lacking)).all()
