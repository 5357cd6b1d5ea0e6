"""Numbers of exact conditions: as they are, or doubles read as the decimals that were written."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, fields
from fractions import Fraction
from functools import cached_property
from typing import Any

import numpy as np
from flint import arb, fmpq

from ...algebra.exact.number_fields import rational
from ...base.checks import known, one_number
from ...base.errors import ParameterError, shown
from ...base.exact_numbers import decimal_of, double, exact_ratio, written
from ...systems.family import Family
from ...systems.graph.family_graph import FamilyGraph

AS_DOUBLES = (
    "Numbers such as {decimal} are taken as their nearest doubles, exactly ({double}); with "
    "decimals=True (--decimals) as they are written."
)
AS_DECIMALS = (
    "Read as decimals, as written: {listed}.  The conditions hold for the model with these "
    "decimals; `spectrum`, `boundaries` and maps take the nearest doubles."
)
KEPT = (
    "Exact doubles still, since they are no decimals of at most 15 digits (CasADi may have joined "
    "them): {listed}."
)
"""Statements on the numbers of a result."""
MOST_LISTED = 12
"""Decimals that a statement lists."""


@dataclass(frozen=True, eq=False, repr=False)
class DecimalFamily(Family):
    """A family in whose graph each double next to a short decimal is the decimal, exactly."""

    @cached_property
    def graph(self) -> FamilyGraph:
        """The system's graph with decimals."""
        return FamilyGraph(self._frame(decimals=True))


@dataclass(frozen=True)
class Numbers:
    """How numbers are read: fractions exactly, doubles exactly or as decimals."""

    decimals: bool = False
    """Whether a double that is the nearest one to a short decimal is read as the decimal."""

    def family(self, family: Family) -> Family:
        """The family whose graph has these numbers.

        Parameters
        ----------
        family
            The family.
        """
        if not self.decimals:
            return family
        return DecimalFamily(**{f.name: getattr(family, f.name) for f in fields(family)})

    def ratio(self, value: float) -> Any:
        """A double as a rational.

        Parameters
        ----------
        value
            A finite double.

        Examples
        --------
        >>> Numbers(decimals=True).ratio(9.81), Numbers().ratio(0.375)
        (981/100, 3/8)
        """
        short = decimal_of(value) if self.decimals else None
        return rational(value) if short is None else fmpq(short.numerator, short.denominator)

    def rational(self, name: str, value: Any) -> Any:
        """A number that a user gives as a rational, or a refusal.

        Parameters
        ----------
        name
            Name of the number in the message.
        value
            A float, or a number that is exact by its type.
        """
        exact = exact_ratio(value)
        if exact is None:
            return self.ratio(one_number(name, value))
        one_number(name, double(exact))  # refuses what no double is near
        return fmpq(exact.numerator, exact.denominator)

    def point(self, given: Mapping[str, Any]) -> dict[str, Any]:
        """Numbers by name as rationals; balls stay.

        Parameters
        ----------
        given
            Numbers or balls by name.
        """
        return {
            n: v if isinstance(v, (arb, fmpq)) else self.rational(n, v) for n, v in given.items()
        }

    def intervals(
        self, family: Family, positive: Sequence[str], between: Mapping[str, tuple[Any, Any]]
    ) -> dict[str, tuple[Any, Any]]:
        """Open intervals by name, as rationals; None for an infinite end.

        Parameters
        ----------
        family, positive, between
            As in `stability.conditions`.
        """
        names = (*family.at, *family.unknown, *family.parameters)
        if isinstance(positive, str):
            raise ParameterError(f"positive is {shown(positive)}; give a tuple of names.")
        out: dict[str, tuple[Any, Any]] = {}
        for name in positive:
            out[known("positive", name, names)] = (fmpq(0), None)
        for name, limits in between.items():
            known("between", name, names)
            out[name] = self._interval(name, limits)
        return out

    def _interval(self, name: str, limits: Any) -> tuple[Any, Any]:
        if isinstance(limits, (tuple, list, np.ndarray)) and len(limits) == 2:
            below, above = (isinstance(v, float) and math.isinf(v) for v in limits)
            low = None if below else self.rational(f"an end of {name}", limits[0])
            high = None if above else self.rational(f"an end of {name}", limits[1])
            ordered = low is None or high is None or low < high
            if ordered and not (below and limits[0] > 0) and not (above and limits[1] < 0):
                return low, high
        raise ParameterError(f"between of {name} is {shown(limits)}; give (low, high).")

    def statement(self, family: Family, given: Sequence[Any]) -> str:
        """Sentences on the doubles that are no short decimals exactly, or empty.

        Parameters
        ----------
        family
            The family whose graph was read.
        given
            Floats among the numbers that the user gave.
        """
        asis, read = family.graph.numbers
        own = (v for v in given if isinstance(v, float))
        doubles = {v: decimal_of(v) for v in (*own, *asis, *read)}
        short = {v: d for v, d in doubles.items() if d is not None and d != Fraction(v)}
        others = [f"{v!r}" for v, d in doubles.items() if d is None]
        if not self.decimals:
            v, d = next(iter(short.items()), (0.0, Fraction(0)))
            return AS_DOUBLES.format(decimal=written(d), double=Fraction(v)) if short else ""
        said = []
        if short:
            listed = (f"{written(d)} = {d}" for d in short.values())
            said = [AS_DECIMALS.format(listed=_shortened(list(listed)))]
        if others:
            said += [KEPT.format(listed=_shortened(others))]
        return "  ".join(said)


def _shortened(texts: list[str]) -> str:
    more = len(texts) - MOST_LISTED
    return ", ".join(texts[:MOST_LISTED]) + (f" and {more} more" if more > 0 else "")


def sign_of(value: Any) -> int | None:
    """The sign of a rational or a ball; None where a ball has both.

    Examples
    --------
    >>> sign_of(2), sign_of(0)
    (1, 0)
    """
    return 1 if value > 0 else -1 if value < 0 else 0 if value == 0 else None
