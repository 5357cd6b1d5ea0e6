"""How a method did on a hard case: a mark, the digits that are left, and a note."""

from __future__ import annotations

import math
from dataclasses import dataclass
from enum import Enum


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
"""An error up to this is not held against what a method states."""
BY_WORD = {mark.word: mark for mark in Mark}
"""Mark by its word."""
HONEST = (Mark.RIGHT, Mark.DEGRADED, Mark.UNDECIDED, Mark.REFUSED)
"""Marks that mislead nobody."""


@dataclass(frozen=True)
class Judgement:
    """A mark with what it rests on."""

    mark: Mark
    """The mark."""
    digits: float = math.nan
    """Digits that are right, or decades of distance down to which the answers hold; NaN if none."""
    note: str = ""
    """What was seen, in a few words."""
    steps: tuple[str, ...] = ()
    """Of a ladder: the mark at each distance from the boundary, from far to near."""


def by_error(
    error: float, asked: float, stated: float | None = None, *, worst: float = 0.1
) -> Judgement:
    """Judge a number by its relative error.

    Parameters
    ----------
    error
        The relative error.
    asked
        The error that was asked for.
    stated
        The error that the method itself states, if it does.
    worst
        Error from which nothing is left.

    Returns
    -------
    Judgement
        Undecided where the method itself says that nothing is left; wrong where nothing is, or
        where fewer digits are left than it states.

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
