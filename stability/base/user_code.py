"""A user's own modules and formulas: what they raise becomes one sentence."""

from __future__ import annotations

import sys
from collections.abc import Callable
from functools import wraps
from typing import Any, TypeVar

import numpy as np

from .calls import guard
from .errors import NameUnknownError, ParameterError, StabilityError, one_line, shown

T = TypeVar("T")
Method = TypeVar("Method", bound=Callable[..., Any])

REASON = 120
"""Most characters of what a module raised."""


def imported(what: str, place: str, load: Callable[[], T], folder: str, remedy: str) -> T:
    """What a user's module gives, with a folder at the head of Python's path while it is imported.

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
        # the path of a file is in `place`
        system = error.strerror if isinstance(error, OSError) else ""
        why = one_line(system or f"{type(error).__name__}: {error}".splitlines()[0], REASON)
        raise NameUnknownError(
            f"{what} is {shown(place)}, which cannot be imported ({why}); {remedy}."
        ) from None
    finally:
        sys.path[:] = before


def arithmetic(remedy: str) -> Callable[[Method], Method]:
    """Wrap a formula over any number type; a failed operation becomes a refusal in a sentence.

    Returns
    -------
    function
        A decorator of methods.
    """

    def wrap(method: Method) -> Method:
        fitting = guard(method, method.__qualname__, 1)

        @wraps(method)
        def formula(self: Any, *values: Any, **named: Any) -> Any:
            try:
                with np.errstate(divide="raise", invalid="raise", over="ignore"):
                    value = fitting(self, *values, **named)
                parts = value if isinstance(value, list) else [value]
                if any(isinstance(v, (float, np.ndarray)) and np.isnan(v).any() for v in parts):
                    raise FloatingPointError
                return value
            except StabilityError:
                raise
            except Exception as error:  # the numbers' own code may raise anything
                arguments = ", ".join(map(shown, (*values, *named.values())))
                raise ParameterError(f"{arguments}: {type(error).__name__}; {remedy}.") from None

        return formula  # type: ignore[return-value]

    return wrap
