"""The exact right angle π/2, which is not a double."""

from __future__ import annotations

from typing import Any

from ..base.errors import ParameterError


class Upright:
    """The exact right angle π/2 as a symbol: its sine is 1, its cosine 0, and no more is known.

    No double is π/2.  For a motion with the disk upright, this symbol replaces theta in the graph;
    the terms with cosθ then vanish from the graph itself.

    Examples
    --------
    >>> import stability as st
    >>> st.UPRIGHT.sin(), st.UPRIGHT.cos()
    (1, 0)
    """

    def sin(self) -> int:
        """The sine, exactly."""
        return 1

    def cos(self) -> int:
        """The cosine, exactly."""
        return 0

    def _refused(self, *_: Any) -> Any:
        raise ParameterError(
            "a state that is held at UPRIGHT stands outside a plain sine or cosine, as in "
            "cos(2 theta); write multiples by sin(theta) and cos(theta), or hold the double pi/2."
        )

    __add__ = __radd__ = __sub__ = __rsub__ = __mul__ = __rmul__ = _refused
    __truediv__ = __rtruediv__ = __neg__ = __pow__ = _refused

    def __reduce__(self) -> str:
        return "UPRIGHT"  # the only instance, also in another process

    def __repr__(self) -> str:
        return "UPRIGHT"


UPRIGHT = Upright()
"""The right angle, the only instance.

Source: exactly π/2, which no double is: docs/explanation/method.md.

Examples
--------
>>> import stability as st
>>> st.UPRIGHT.sin(), st.UPRIGHT.cos()
(1, 0)
"""
