"""One axis of a map or scan."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from .checks import one_number
from .errors import ParameterError, shown
from .types import Floats

MOST_POINTS = 10_000_000
"""Largest number of points of an axis."""


AxisLike = tuple[str, float, float, int] | tuple[str, float, float, int, str]
"""An axis as a user gives it: (name, low, high, count), with "log" for logarithmic steps."""


@dataclass(frozen=True)
class Axis:
    """One axis of a map."""

    name: str
    """Name of the parameter that varies."""
    low: float
    """First value."""
    high: float
    """Last value."""
    count: int
    """Number of values."""
    log: bool = False
    """Whether the values have even steps in the logarithm."""
    alias: str = field(default="", compare=False, repr=False)
    """Another name of the same number; a result has it as a second coordinate."""

    @classmethod
    def of(cls, axis: Sequence[Any], which: str, most: int = MOST_POINTS) -> Axis:
        """An axis from (name, low, high, n) or (name, low, high, n, "log").

        Raises
        ------
        ParameterError
            If an entry is not accepted; the message says which entries are.

        Examples
        --------
        >>> Axis.of(("mu", 0.1, 10, 3, "log"), "x").values.round(12).tolist()
        [0.1, 1.0, 10.0]
        """
        if not isinstance(axis, (tuple, list)) or len(axis) not in (4, 5):
            raise ParameterError(
                f"{which} is {shown(axis)}; give (name, low, high, n) or (…, 'log')."
            )
        what = which if which == "axis" else f"{which} axis"
        name, low, high, count, *rest = axis
        if not isinstance(name, str):
            raise ParameterError(f"{what} name is {shown(name)}; give a string such as 'at'.")
        if rest and not (isinstance(rest[0], str) and rest[0] in ("log", "linear")):
            raise ParameterError(f"{which} spacing is {shown(rest[0])}; give 'linear' or 'log'.")
        low, high = (
            one_number(f"the {side} end of the {what} {name}", value)
            for side, value in (("low", low), ("high", high))
        )
        integer = isinstance(count, (int, np.integer)) and not isinstance(count, bool)
        if not integer or count < 2:
            raise ParameterError(
                f"{what} {shown(name)} has {shown(count)} points; a whole number of at "
                "least 2 is needed."
            )
        if not low < high:
            raise ParameterError(
                f"{what} {name} runs from {low:g} to {high:g}; the low end must be below "
                "the high end."
            )
        log = bool(rest) and rest[0] == "log"
        if log and low <= 0:
            raise ParameterError(
                f"{what} {name} starts at {low:g}; a logarithmic axis starts above zero."
            )
        if count > most:
            raise ParameterError(f"{what} {name} has {shown(count)} points; take at most {most}.")
        grid = cls(name, low, high, int(count), log)
        with np.errstate(all="ignore"):
            apart = np.diff(grid.values)
        if not (apart > 0).all():
            raise ParameterError(
                f"{what} {name} from {low!r} to {high!r} has no {count} different numbers; "
                "widen it or ask for fewer points."
            )
        return grid

    @property
    def values(self) -> Floats:
        """The values, shape (count,); both ends are exact."""
        if self.log:
            values = np.geomspace(self.low, self.high, self.count)
        else:
            values = np.linspace(self.low, self.high, self.count)
        values[0], values[-1] = self.low, self.high
        return values

    @property
    def text(self) -> str:
        """The axis as text for the command line."""
        return f"{self.name}:{self.low:g}:{self.high:g}:{self.count}" + ":log" * self.log
