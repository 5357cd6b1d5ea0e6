"""Growth rates of λ² + a₀ from a coefficient with a bound, against square roots of integers."""

from __future__ import annotations

from fractions import Fraction
from math import isqrt

import numpy as np

from stability.base.verdict import CODES, Verdict
from stability.maps.own.rates import rates

SCALE = 10**60


def root(value: Fraction) -> Fraction:
    """√value for value ≥ 0, to 30 digits."""
    return Fraction(isqrt(value.numerator * SCALE // value.denominator), 10**30)


def found(a: np.ndarray, error: np.ndarray) -> list[np.ndarray]:
    """Abscissa, bound, frequency, flags and whether the cell is left open."""
    none = np.zeros_like(a)
    made = rates([((np.array([a, none]), np.array([error, none])), True, 1)], modes=False)
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
    one, other = (rates([factor], modes=modes) for modes in (False, True))
    assert np.allclose(one.abscissa, other.abscissa, rtol=1e-15, atol=0)
    assert np.allclose(one.frequency, other.frequency, rtol=1e-15, atol=0)
    assert (one.codes == other.codes).all()
    assert (one.error <= 2 * other.error).all() and (other.error <= 2 * one.error).all()
