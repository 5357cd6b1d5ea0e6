"""The exact right angle, which no double is."""

from __future__ import annotations


class Upright:
    """The exact right angle π/2 as a symbol: its sine is 1, its cosine 0, and no more is known.

    No double is π/2, so a motion with the disk upright is read from the graph with this in place
    of theta; the terms with cosθ then vanish from the graph itself.

    Examples
    --------
    >>> UPRIGHT.sin(), UPRIGHT.cos()
    (1, 0)
    """

    def sin(self) -> int:
        """The sine, exactly."""
        return 1

    def cos(self) -> int:
        """The cosine, exactly."""
        return 0

    def __repr__(self) -> str:
        return "UPRIGHT"


UPRIGHT = Upright()
"""The one right angle."""
