"""Numbers of two doubles enclose the results of balls of 400 bits, and are narrow.

Oracle: python-flint at 400 bits; roots of systems by mpmath.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from fractions import Fraction
from typing import Any

import mpmath
import numpy as np
import pytest
from flint import arb, fmpq

from stability.algebra.double_double import DOUBLE_DOUBLE, DoubleDouble, exact
from stability.algebra.krawczyk import many_proved
from stability.algebra.number_types import balls, precision

COUNT = 200
NARROW = 1e-27
F = DOUBLE_DOUBLE.functions
B = balls().functions


def balls_of(number: DoubleDouble) -> list[Any]:
    parts = np.broadcast_arrays(number.hi, number.lo, np.zeros(COUNT))[:2]
    return [arb(h) + arb(w) for h, w in zip(*(v.tolist() for v in parts), strict=True)]


def encloses(number: DoubleDouble, wanted: list[Any], narrow: float) -> None:
    errors = np.broadcast_to(number.error, COUNT).tolist()
    for value, true, error in zip(balls_of(number), wanted, errors, strict=True):
        assert abs(value - true) <= 1.01 * error + 1e-300
        assert error <= narrow * (abs(float(true)) + 1e-3)


EXPRESSIONS: list[tuple[str, Callable[[Any, Any, dict[str, Any]], Any]]] = [
    ("sums", lambda x, y, _: x + y - x * 3 + 2 - 1 / y),
    ("products", lambda x, y, _: x * y * x - x * x * y + x),
    ("quotients", lambda x, y, _: (x - y) / (x * x + y * y) - 1 / (1 + x * x)),
    ("cancelling", lambda x, y, _: (x + y) * (x + y) - x * x - 2 * x * y - y * y + x / 1024),
    ("roots", lambda x, y, f: f["sqrt"](x * x + y * y) - f["sqrt"](f["fabs"](x))),
    ("sines", lambda x, y, f: f["sin"](x) * f["cos"](y) + f["tan"](x / 7) - f["cos"](40 * x)),
    ("constants", lambda x, y, _: x * 0.1 + 0.3 - (y - 1e-9) * -7e5 + 2.0**40 * (x + 0.7)),
    ("multiples", lambda x, y, f: 2 + f["sin"](33 * x) * f["cos"](3 * (11 * y)) - f["cos"](64 * x)),
    ("a twofold", lambda x, y, f: f["sin"](x + x) * f["cos"](-2 * y) - f["sin"](0 * y + 5 * x)),
    ("others", lambda x, y, f: f["exp"](x / 5) + f["tanh"](y) - f["atan"](x) + f["log"](y * y)),
    ("powers", lambda x, y, f: f["pow"](x, 3) - f["pow"](y, -2) + f["pow"](x * x, y / 3)),
]


@pytest.mark.parametrize(("name", "run"), EXPRESSIONS, ids=[n for n, _ in EXPRESSIONS])
@pytest.mark.parametrize("scale", [1e-3, 1.0, 7.0])
def test_numbers_of_two_doubles_are_those_of_balls(
    name: str, run: Callable[[Any, Any, dict[str, Any]], Any], scale: float
) -> None:
    rng = np.random.default_rng(len(name))
    x, y = (DoubleDouble(rng.normal(size=COUNT) * s) / 3 for s in (scale, 1.0))
    with precision(400), np.errstate(all="ignore"):
        found = run(x, y, F)
        # the operands are what two doubles hold, and within their errors
        wanted = [run(a, b, B) for a, b in zip(balls_of(x), balls_of(y), strict=True)]
        loss = 1e6 if scale < 1 and name in ("cancelling", "roots", "others", "powers") else 1e3
        encloses(found, wanted, NARROW * loss)


def test_a_wide_number_encloses_the_function_over_all_of_it() -> None:
    rng = np.random.default_rng(5)
    middle, width = rng.normal(size=COUNT), 1e-7
    wide = DoubleDouble(middle, 0.0, np.full(COUNT, width))
    for _, run in EXPRESSIONS[:6]:
        with precision(400), np.errstate(all="ignore"):
            found = run(wide, exact(2.5), F)
            for share in (-1.0, -0.3, 0.7, 1.0):
                inside = [arb(m) + arb(share * width) for m in middle.tolist()]
                wanted = [run(v, arb(2.5), B) for v in inside]
                encloses(found, wanted, math.inf)


def test_numbers_that_no_double_holds_are_read_with_an_error() -> None:
    for ratio in (Fraction(1, 3), Fraction(2**80 + 1), Fraction(-7, 10**30)):
        for number in (exact(ratio), exact(fmpq(ratio.numerator, ratio.denominator))):
            off = abs(Fraction(float(number.hi)) + Fraction(float(number.lo)) - ratio)
            assert off <= Fraction(float(number.error)) <= abs(ratio) * Fraction(1, 2**100)
    assert exact(2**60 + 1).error == 0
    with precision(400):
        pi = DoubleDouble.pi()
        assert abs(arb(float(pi.hi)) + arb(float(pi.lo)) - arb.pi()) <= float(pi.error) < 1e-29


def test_no_sign_is_proved_where_nothing_is_known() -> None:
    with np.errstate(all="ignore"):
        zero, wide = exact(0.0), DoubleDouble(np.array([1.0]), 0.0, np.array([1.0]))
        for number in (zero, 1 / wide, exact(-1.0).sqrt(), wide - 1, F["log"](exact(-1.0))):
            assert not np.any(number.sign())
        assert (exact(1.0) + exact(2.0**-80) - 1).sign() == 1
        assert not np.any((wide * 1e-320).sign())


def test_roots_of_many_systems_are_those_of_mpmath() -> None:
    """x² + y² = c, sin x = y d."""
    rng = np.random.default_rng(11)
    c, d = (DoubleDouble(rng.uniform(0.5, 1.5, 40)) for _ in range(2))

    def system(u: list[Any]) -> Any:
        x, y = u
        values = [x * x + y * y - c, F["sin"](x) - y * d]
        return values, [[2 * x, 2 * y], [F["cos"](x), -d]]

    with mpmath.workdps(60):
        start, wanted = [], []
        for cc, dd in zip(c.hi.tolist(), d.hi.tolist(), strict=True):
            root = mpmath.findroot(
                lambda x, y, cc=cc, dd=dd: (x * x + y * y - cc, mpmath.sin(x) - y * dd), (0.7, 0.7)
            )
            wanted.append(list(root))
            start.append([float(v) * (1 + 1e-13) for v in root])
        found, widths = many_proved(system, np.array(start))
        for k, number in enumerate(found):
            for i, true in enumerate(wanted):
                value = mpmath.mpf(float(number.hi[i])) + mpmath.mpf(float(number.lo[i]))
                assert abs(value - true[k]) <= number.error[i] < 1e-28
                assert number.error[i] < widths[i, k]
    # at a double root, and away from any, nothing is proved
    far, _ = many_proved(lambda u: ([u[0] * u[0] + 1], [[2 * u[0]]]), np.array([[0.3], [2.0]]))
    assert np.isinf(far[0].error).all()
