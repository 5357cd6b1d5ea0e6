"""Certified verdicts next to a threshold, at a relative distance of 1e-12, about fractions."""

from __future__ import annotations

from collections.abc import Mapping
from fractions import Fraction
from math import isqrt
from typing import Any

from mpmath import mp

import stability as st

HALF = Fraction(1, 2)
STEP = Fraction(1, 10**12)
ONE = 10**60
DIGITS = 80


def root(square: Fraction) -> Fraction:
    """The square root to 60 digits."""
    return Fraction(isqrt(square.numerator * ONE**2 // square.denominator), ONE)


def fraction(value: Any) -> Fraction:
    """A number of mpmath to 60 digits."""
    with mp.workdps(DIGITS):
        return Fraction(int(mp.nint(value * ONE)), ONE)


def words(
    family: st.Family,
    value: Fraction,
    numbers: Mapping[str, Any],
    name: str = "",
    at: tuple[Fraction, ...] = (),
) -> list[str]:
    """Verdicts below and above a value of the family's last number, or of a parameter by name.

    at: the family's other numbers, which stay.
    """
    found = []
    for side in (1 - STEP, 1 + STEP):
        place = {name: value * side} if name else {"at": [*at, value * side]}
        given = dict(numbers) | place
        if isinstance(given.get("at"), list) and len(given["at"]) == 1:
            [given["at"]] = given["at"]
        found.append(st.spectrum(family, certify=True, **given).verdict.word)
    return found
