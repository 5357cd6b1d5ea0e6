"""Names in a user's own modules: found from a folder too, and refused in one sentence."""

from __future__ import annotations

import sys
from collections.abc import Callable
from typing import TypeVar

from .errors import NameUnknownError, shown

T = TypeVar("T")


def imported(what: str, place: str, load: Callable[[], T], folder: str, remedy: str) -> T:
    """What a user's module gives, with a folder at the head of Python's path while it is imported.

    Parameters
    ----------
    what, place
        Name and value of the argument, for the message.
    load
        Imports the module and returns what is wanted of it.
    folder
        The folder.
    remedy
        What is accepted, for the message.

    Raises
    ------
    NameUnknownError
        If the import raises anything.

    Examples
    --------
    >>> imported("law", "math:pi", lambda: __import__("math").pi, ".", "give another")
    3.141592653589793
    """
    before = list(sys.path)
    sys.path.insert(0, folder)
    try:
        return load()
    except Exception as error:  # a user's module may raise anything while it is imported
        why = f"{type(error).__name__}: {error}".splitlines()[0]
        raise NameUnknownError(
            f"{what} is {shown(place)}, which cannot be imported ({why[:120]}); {remedy}."
        ) from None
    finally:
        sys.path[:] = before
