"""Calls of rooms above by name, for results of rooms below, which do not import these.

`stability/__init__.py` registers one function for each name.  The function is found, and
its module imported, when it is first asked for.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

_FINDERS: dict[str, Callable[[], Callable[..., Any]]] = {}


def register(name: str, finder: Callable[[], Callable[..., Any]]) -> None:
    """State what function a result of a room below calls.

    Parameters
    ----------
    name
        Name of the call, such as that of the figure of a kind of result.
    finder
        Function that returns the function.
    """
    _FINDERS[name] = finder


def function_of(name: str) -> Callable[..., Any]:
    """The function of a name."""
    return _FINDERS[name]()
