"""What is said of a table in the list of tables: its source, what is recomputed, its standing."""

from __future__ import annotations

from dataclasses import dataclass

from ...base.types import Record, Sentences


class Standing(Sentences):
    """Whether a table is reproduced; the value of each member is the sentence a user reads.

    Examples
    --------
    >>> print(Standing.REPRODUCED)
    reproduced
    >>> Standing("recomputed") is Standing.RECOMPUTED
    True
    """

    REPRODUCED = "reproduced: every value was at hand as printed, and is recomputed"
    PARTLY = (
        "reproduced in part: values that were at hand as printed are marked `published`; all "
        "others are recomputed by a second route"
    )
    RECOMPUTED = "recomputed: no printed value was at hand"
    DERIVED = "derived: the statements are this package's own, and each is proved or computed here"


@dataclass(frozen=True, eq=False)
class About(Record):
    """Where a table comes from, and what its numbers are compared with.

    Examples
    --------
    >>> About("this package", "no value", "all", Standing.DERIVED).difference
    'no value to compare with'
    >>> About("a paper", "one value", "all", Standing.PARTLY, largest=3e-12).difference
    'at most 3e-12 of the known value, its rounding included'
    """

    source: str
    """Paper, course, code or derivation."""
    published: str
    """What of it was at hand as printed."""
    recomputed: str
    """What the package computes, and by which route."""
    standing: Standing
    """Whether it is reproduced."""
    largest: float | None = None
    """Bound on the difference, relative to the known values; None without such values."""

    @property
    def difference(self) -> str:
        """How far recomputed values are from known ones."""
        if self.largest is None:
            return "no value to compare with"
        return f"at most {self.largest:.0e} of the known value, its rounding included"
