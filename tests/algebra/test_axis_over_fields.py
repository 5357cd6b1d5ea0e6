"""Verdicts of polynomials with planted roots, over Q and over Q(√2), by the steps for any field."""

from functools import reduce
from typing import Any

import numpy as np
import pytest
from flint import arb, arb_poly, fmpq, fmpq_poly

from stability.algebra.exact.number_fields import Algebraic, NotExact, NumberField
from stability.algebra.exact.routh import Ground, on_the_axis_over
from stability.base.verdict import Verdict

RATIONAL = Ground(lambda c: int(c > 0) - int(c < 0), lambda c: c)
ROOT = NumberField(fmpq_poly([-2, 0, 1]), arb(2).sqrt()).generator


def sign(value: Any) -> int:
    if not isinstance(value, Algebraic):
        return RATIONAL.sign(value)
    ball = arb_poly(value.poly)(value.field.root)
    return 0 if value.poly == 0 else 1 if ball > 0 else -1


def times(p: list[Any], q: list[Any]) -> list[Any]:
    out = [fmpq(0)] * (len(p) + len(q) - 1)
    for i, a in enumerate(p):
        for j, b in enumerate(q):
            out[i + j] = out[i + j] + a * b
    return out


def factor(kind: str, a: Any, b: Any) -> list[Any]:
    """Lowest first; a and b are positive."""
    return {
        "zero": [0, 1],
        "pair on the axis": [a, 0, 1],
        "real pair": [-a, 0, 1],
        "four": [a * a + b * b, 0, 2 * a, 0, 1],  # (λ² + a)² + b², two with positive real parts
        "decaying": [a, 1],
        "decaying pair": [a, b, 1],
        "growing": [-a, 1],
        "growing pair": [a, -b, 1],
    }[kind]


GROWING = {"real pair", "four", "growing", "growing pair"}
KINDS = ["zero", "pair on the axis", "decaying", "decaying pair"]


def planted(seed: int, field: str) -> tuple[Verdict, Verdict]:
    """What is found of a product of factors, and what was put in."""
    rng = np.random.default_rng(seed)

    def number() -> Any:
        whole = fmpq(int(rng.integers(1, 9)), int(rng.integers(1, 5)))
        return whole if field == "Q" else whole + ROOT * fmpq(int(rng.integers(0, 3)))

    kinds = [str(k) for k in rng.choice(KINDS, int(rng.integers(1, 4)))]
    if seed % 3 == 0:
        kinds.append(str(rng.choice(sorted(GROWING))))
    factors = []
    for kind in kinds:  # each up to three times, so that roots are multiple
        factors += [factor(kind, number(), number())] * int(rng.integers(1, 4))
    ground = RATIONAL if field == "Q" else Ground(sign, lambda c: c)
    on_axis = {"zero", "pair on the axis"} & set(kinds)
    wanted = Verdict.NEUTRAL if on_axis else Verdict.STABLE
    wanted = Verdict.UNSTABLE if GROWING & set(kinds) else wanted
    return on_the_axis_over(ground, reduce(times, factors)), wanted


@pytest.mark.parametrize("field", ["Q", "Q(√2)"])
def test_products_of_planted_factors(field: str) -> None:
    found = {seed: planted(seed, field) for seed in range(60)}
    assert {seed: pair for seed, pair in found.items() if pair[0] is not pair[1]} == {}
    assert {wanted for _, wanted in found.values()} == set(Verdict) - {
        Verdict.UNDECIDED,
        Verdict.DRIFTING,
    }


def test_a_sign_that_is_not_proved_ends_the_proof() -> None:
    def open_(value: Any) -> int:
        raise NotExact(str(value))

    with pytest.raises(NotExact):
        on_the_axis_over(Ground(open_, lambda c: c), [1, 0, 1])
