"""Exact numbers as a user gives them: fractions, decimals, texts, and doubles next to decimals."""

from __future__ import annotations

import re
from collections.abc import Iterable
from decimal import Decimal
from fractions import Fraction
from numbers import Rational
from typing import Any

import numpy as np

from .errors import ParameterError, shown, warned

MOST_DIGITS = 15
"""Digits of a decimal that its nearest double still identifies, for every decimal."""
LARGEST_POWER = 330
"""Largest power of ten of an exact number: beyond that of any double."""
LONGEST = 400
"""Characters of a number as text."""


def exact_ratio(value: Any) -> Fraction | None:
    """The ratio of a number that is exact by its type, or None for a float and anything else.

    Parameters
    ----------
    value
        An integer of Python or NumPy, a Fraction, a Decimal, a rational of SymPy.

    Examples
    --------
    >>> exact_ratio(Decimal("0.3")), exact_ratio(0.3)
    (Fraction(3, 10), None)
    """
    if isinstance(value, np.ndarray) and value.ndim == 0:
        value = value.item()
    if isinstance(value, (bool, np.bool_)):
        return None
    if isinstance(value, Decimal):
        small = value.is_finite() and abs(value.adjusted()) <= LARGEST_POWER
        small = small and len(value.as_tuple().digits) <= LONGEST
        return Fraction(value) if small or not value else None
    if isinstance(value, Rational):
        return Fraction(int(value.numerator), int(value.denominator))
    return None


def double(ratio: Fraction) -> float:
    """The nearest double, infinite where the number is too large."""
    try:
        return float(ratio)
    except OverflowError:
        return float("inf") if ratio > 0 else -float("inf")


def ratio_of_text(name: str, text: str) -> Fraction:
    """The number that a text writes, exactly: `9.81` is 981/100, `3/10` is 3/10.

    Parameters
    ----------
    name
        Name of the number in the message.
    text
        A decimal, with a power of ten or not, or a fraction of integers.

    Raises
    ------
    ParameterError
        If the text is no finite number.

    Examples
    --------
    >>> ratio_of_text("g", "9.81"), ratio_of_text("ratio", "-1/3")
    (Fraction(981, 100), Fraction(-1, 3))
    """
    plain, ratio = text.strip(), None
    if len(plain) <= LONGEST and re.fullmatch(r"[+-]?\d+/\d*[1-9]\d*", plain, re.ASCII):
        ratio = Fraction(plain)
    elif len(plain) <= LONGEST and re.fullmatch(
        r"[+-]?(\d+\.?\d*|\.\d+)(e[+-]?\d{1,6})?", plain, re.ASCII | re.IGNORECASE
    ):
        ratio = exact_ratio(Decimal(plain))
    if ratio is None or abs(double(ratio)) == float("inf"):
        endless = ratio is not None or plain.lower().strip("+-") in ("inf", "infinity", "nan")
        wanted = "a finite number" if endless else "a number such as 9.81 or 3/10"
        raise ParameterError(f"{name} is {shown(text)}; {wanted} is needed.")
    return ratio


def decimal_of(value: float) -> Fraction | None:
    """The decimal of at most 15 digits whose nearest double this is; None where there is none.

    No two such decimals have the same double, so that the decimal is the one that was written.

    Examples
    --------
    >>> decimal_of(9.81), decimal_of(0.1 * 3)
    (Fraction(981, 100), None)
    """
    written = Decimal(repr(float(value)))
    if len(written.normalize().as_tuple().digits) > MOST_DIGITS:
        return None
    return Fraction(written)


def written(ratio: Fraction) -> str:
    """A number as one writes it: its shortest decimal where that is exact, otherwise a fraction.

    Examples
    --------
    >>> written(Fraction(981, 100)), written(Fraction(1, 3)), written(Fraction(5))
    ('9.81', '1/3', '5')
    """
    text = f"{double(ratio):.{MOST_DIGITS}g}"
    if "inf" not in text and Fraction(Decimal(text)) == ratio:
        return text
    return str(ratio)


def no_double(value: Any) -> Fraction | None:
    """The ratio of a number that is exact by its type, where the number is no double.

    Examples
    --------
    >>> no_double(Fraction(3, 10)), no_double(Fraction(3, 8)), no_double(0.3)
    (Fraction(3, 10), None, None)
    """
    ratio = exact_ratio(value)
    near = 0.0 if ratio is None else double(ratio)
    return None if ratio is None or abs(near) == float("inf") or Fraction(near) == ratio else ratio


def warn_rounded(name: str, values: Iterable[Any]) -> None:
    """Warn that exact numbers are rounded to doubles, where they are no doubles."""
    ratio = next((r for v in values if (r := no_double(v)) is not None), None)
    if ratio is not None:
        warned(
            f"{name} is {shown(str(ratio)).strip(chr(39))}, which is no double; the nearest double "
            "is taken. For your own systems `spectrum` at single members, `boundaries` and "
            "`conditions` take fractions exactly."
        )
