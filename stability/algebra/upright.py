"""The exact right angle π/2, which is not a double."""

from __future__ import annotations


class Upright:
    """The exact right angle π/2 as a symbol: its sine is 1, its cosine 0, and no more is known.

    No double is π/2.  For a motion with the disk upright, this symbol replaces theta in the graph;
    the terms with cosθ then vanish from the graph itself.

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

    def __reduce__(self) -> str:
        return "UPRIGHT"  # the only instance, also in another process

    def __repr__(self) -> str:
        return "UPRIGHT"


UPRIGHT = Upright()
"""The right angle, the only instance."""
