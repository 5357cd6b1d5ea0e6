"""Figures by name: a result is drawn by a room above, which no room below imports.

The face (`stability/__init__.py`) registers one function for each kind of result.  The function is
found, and its module imported, when the first figure is asked for.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

Drawing = Callable[..., Any]
_FINDERS: dict[str, Callable[[], Drawing]] = {}


def register(kind: str, finder: Callable[[], Drawing]) -> None:
    """State how a kind of result is drawn.

    Parameters
    ----------
    kind
        Kind of result.
    finder
        Function that returns the drawing function: (result, options by name) → figure.
    """
    _FINDERS[kind] = finder


def figure_of(kind: str) -> Drawing:
    """The function that draws a kind of result."""
    return _FINDERS[kind]()
