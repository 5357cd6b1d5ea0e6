"""A method, a hard case, and the result of one on the other: a mark, digits, and a note."""

from __future__ import annotations

import math
from dataclasses import dataclass
from enum import Enum
from typing import Any, ClassVar, Self


class Compared:
    """A class whose fields say which method or case it is."""

    @classmethod
    def variant(cls, **fields: Any) -> type[Self]:
        """The same with other fields."""
        return type(cls.__name__.lstrip("_"), (cls,), {"__doc__": cls.__doc__, **fields})


class Method(Compared):
    """What a comparison asks; a subclass is one method."""

    name: ClassVar[str]
    """Name in tables and on the command line."""
    title: ClassVar[str]
    """Description in a few words."""
    flaw: ClassVar[str] = ""
    """Why it crashes where it does, in sentences; empty for a method that does not."""
    own: ClassVar[bool] = False
    """Whether it belongs to the package."""
    default: ClassVar[bool] = False
    """Whether the package uses it by default."""


class HardCase(Compared):
    """A question that some methods get wrong; a subclass is one case."""

    name: ClassVar[str]
    """Name in tables."""
    group: ClassVar[str]
    """Heading of its group in tables."""
    physics: ClassVar[str]
    """Physics of the case."""


class Mark(Enum):
    """The mark of a cell of the catalogue; the value is the sentence of the legend.

    Examples
    --------
    >>> Mark.WRONG.word
    'wrong'
    """

    RIGHT = "right: the true answer to the digits asked"
    DEGRADED = "degraded: true, but with fewer digits, or not over the whole range, than asked"
    UNDECIDED = "undecided: says that it cannot tell; ask for more digits or a finer tolerance"
    REFUSED = "refused: says that it does not take this question, and why"
    WRONG = "wrong: an answer that is not true, without a warning"
    CRASHED = "crashed: an exception, a number that is not finite, or the end of its process"
    LATE = "late: no answer in the time allowed"

    @property
    def word(self) -> str:
        """The mark as one word."""
        return str(self.value).split(":")[0]


ROUNDING = 1e-13
"""Errors up to this never contradict the error that a method states."""
BY_WORD = {mark.word: mark for mark in Mark}
"""Mark by its word."""
HONEST = (Mark.RIGHT, Mark.DEGRADED, Mark.UNDECIDED, Mark.REFUSED)
"""Marks that mislead nobody."""


@dataclass(frozen=True)
class Judgement:
    """A mark with its evidence."""

    mark: Mark
    """The mark."""
    digits: float = math.nan
    """Digits that are right, or decades of distance down to which the answers hold; NaN if none."""
    note: str = ""
    """Remark on the answer, in a few words."""
    steps: tuple[str, ...] = ()
    """Marks of a ladder: one word for each distance from the boundary, from far to near."""


def by_error(
    error: float, asked: float, stated: float | None = None, *, worst: float = 0.1
) -> Judgement:
    """Judge a number by its relative error.

    Parameters
    ----------
    error
        The relative error.
    asked
        Required relative error.
    stated
        Relative error that the method states; None if it states none.
    worst
        Error beyond which no digit is left.

    Returns
    -------
    Judgement
        Crashed for a number that is not finite; undecided where the stated error reaches `worst`;
        wrong where the error exceeds `worst`, or three times the stated error.

    Examples
    --------
    >>> by_error(1e-8, 1e-6).mark.word, by_error(1e-3, 1e-6).mark.word
    ('right', 'degraded')
    >>> by_error(0.5, 1e-6).mark.word, by_error(0.5, 1e-6, stated=2.0).mark.word
    ('wrong', 'undecided')
    """
    error = abs(error)
    if not math.isfinite(error) or (stated is not None and math.isnan(stated)):
        return Judgement(Mark.CRASHED, note="a number that is not finite")
    digits = 16.0 if error == 0 else min(16.0, max(0.0, -math.log10(error)))
    note = f"error {error:.0e}" + ("" if stated is None else f", stated {stated:.0e}")
    if stated is not None and stated >= worst:
        return Judgement(Mark.UNDECIDED, note=note)
    if error > worst or (stated is not None and error > 3 * stated + ROUNDING):
        return Judgement(Mark.WRONG, digits, note)
    if error <= asked:
        return Judgement(Mark.RIGHT, digits, note)
    return Judgement(Mark.DEGRADED, math.floor(digits), note)
