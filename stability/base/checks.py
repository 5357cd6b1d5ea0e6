"""Checks of arguments, one place for each kind; a refusal shows the value and what is accepted.

`name` is the argument's name in the message, and `remedy` says there what is accepted.
"""

from __future__ import annotations

import math
import re
from collections.abc import Collection, Mapping, Sequence
from typing import Any, TypeVar

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .errors import NameUnknownError, ParameterError, shown
from .exact_numbers import warn_rounded
from .types import Overwrite

Number = float | NDArray[np.float64]
MOST_WORKERS = 1024
"""Largest number of threads or processes."""
Kind = TypeVar("Kind")


def checked(name: str, value: ArrayLike) -> Number:
    """Return a finite float, or a read-only float array, or refuse with the value.

    Examples
    --------
    >>> checked("mu", 3)
    3.0
    """
    if type(value) is float and math.isfinite(value):  # the most frequent case by far
        return value
    array = real_numbers(name, value)
    if array.size == 0:
        raise ParameterError(f"{name} is an empty array; at least one number is needed.")
    bad = ~np.isfinite(array)
    if bad.any():
        raise ParameterError(f"{name} is {array[bad].flat[0]}; a finite number is needed.")
    if array.ndim == 0:
        return float(array)
    array = array.copy()
    array.flags.writeable = False
    return array


def real_numbers(name: str, value: Any) -> NDArray[np.float64]:
    """Real numbers as doubles, infinite and NaN included, or a refusal."""
    if type(value) is np.ndarray and value.dtype == np.float64:  # nothing to convert
        return value
    try:
        if value is None or isinstance(value, (str, bytes)):
            raise TypeError
        array = np.asarray(value)
        if array.dtype.kind not in "iufO":
            raise TypeError  # truth values, complex numbers, text, dates, records
        if hasattr(value, "mask") and np.ma.is_masked(value):  # the module is slow to import
            raise ParameterError(f"{name} has masked entries; give numbers only.")
        if array.dtype.kind == "O" and any(
            entry is None or isinstance(entry, (str, bytes, bool, complex)) for entry in array.flat
        ):
            raise TypeError
        with np.errstate(all="ignore"):  # an overflow is infinite; callers refuse it
            doubles = np.asarray(array, dtype=float)
    except ParameterError:
        raise
    except Exception:  # the value's own conversion may raise anything
        raise ParameterError(f"{name} is {shown(value)}; a real number is needed.") from None
    if array.dtype.kind == "O":
        warn_rounded(name, array.flat)
    return doubles


def positive(name: str, value: ArrayLike, remedy: str = "", *, zero: bool = False) -> Number:
    """Return `checked(name, value)` if all numbers are above zero, or are `zero` where allowed.

    Examples
    --------
    >>> positive("mass", 0.3)
    0.3
    """
    number = checked(name, value)
    if isinstance(number, float) and number > 0:
        return number
    values = np.asarray(number)
    low = values[values < 0 if zero else values <= 0]
    if low.size:
        needed = remedy or f"it must be {'0 or above' if zero else 'positive'}"
        raise ParameterError(f"{name} is {low.flat[0]:g}; {needed}.")
    return number


def one_number(name: str, value: Any) -> float:
    """A single finite number, or a refusal.

    Examples
    --------
    >>> one_number("tolerance", 1e-9)
    1e-09
    """
    number = checked(name, value)
    if not isinstance(number, float):
        raise ParameterError(f"{name} has shape {number.shape}; give one number.")
    return number


def rows(name: str, value: Any, names: Collection[str]) -> NDArray[np.float64]:
    """Finite numbers whose last axis holds one for each name, or a refusal.

    Examples
    --------
    >>> rows("x", [0.5, 0.0], ("angle", "rate")).shape
    (2,)
    """
    array = real_numbers(name, value)
    if names and array.shape == (0,):
        raise ParameterError(f"{name} is empty; give {', '.join(names)}.")
    if array.ndim == 0 or array.shape[-1] != len(names):
        raise ParameterError(
            f"{name} has shape {array.shape}; its last axis must hold {len(names)} values"
            + (f" ({', '.join(names)})." if names else ".")
        )
    if not np.isfinite(array).all():
        raise ParameterError(f"{name} holds NaN or infinite numbers; give finite ones.")
    return array


def broadcast(**shapes: tuple[int, ...]) -> tuple[int, ...]:
    """The shape to which shapes broadcast, or a refusal that lists them by name.

    Examples
    --------
    >>> broadcast(at=(3, 1), mu=(4,))
    (3, 4)
    """
    different = {shape for shape in shapes.values() if shape}
    if len(different) < 2:
        return next(iter(different), ())
    try:
        return np.broadcast_shapes(*different)
    except ValueError:
        listed = ", ".join(f"{n} {s}" for n, s in shapes.items() if s)
        raise ParameterError(
            f"the arrays do not broadcast: their shapes are {listed}; make them fit."
        ) from None


def flag(name: str, value: Any) -> bool:
    """True or False, or a refusal.

    Examples
    --------
    >>> flag("certify", True)
    True
    """
    if not isinstance(value, (bool, np.bool_)):
        raise ParameterError(f"{name} is {shown(value)}; give True or False.")
    return bool(value)


def overwriting(value: Any) -> Overwrite:
    """True, False or "same", or a refusal.

    Examples
    --------
    >>> overwriting("same")
    'same'
    """
    if isinstance(value, str) and value == "same":
        return "same"
    if not isinstance(value, (bool, np.bool_)):
        raise ParameterError(f"overwrite is {shown(value)}; give True, False or 'same'.")
    return bool(value)


def whole_number(
    name: str, value: Any, least: int = 1, most: int | None = None, remedy: str = ""
) -> int:
    """A whole number from `least` to `most`, both included, or a refusal.

    Examples
    --------
    >>> whole_number("points", 5, least=2)
    5
    """
    integer = isinstance(value, (int, np.integer)) and not isinstance(value, bool)
    if not integer or value < least:
        raise ParameterError(
            f"{name} is {shown(value)}; a whole number of at least {least} is needed."
        )
    if most is not None and value > most:
        hint = f"; {remedy}" if remedy else ""
        raise ParameterError(f"{name} is {shown(value)}; at most {most} are allowed{hint}.")
    return int(value)


def known(name: str, value: Any, names: Collection[str]) -> str:
    """One of several names, or a refusal that lists them.

    Examples
    --------
    >>> known("contact", "rough", ("smooth", "rough"))
    'rough'
    """
    if not isinstance(value, str) or value not in names:
        raise NameUnknownError(f"{name} is {shown(value)}; known are {', '.join(names)}.")
    return str(value)


def chosen(name: str, choice: str | Sequence[str], names: Mapping[str, str]) -> list[str]:
    """Some of several names, or a refusal that lists them.

    `names` holds the heading of each name, or an empty text.  What is no name chooses every name in
    which, or in whose heading, a word begins with it.  The order is that of `names`.

    Examples
    --------
    >>> chosen("method", "ad, MP", {"ad": "", "radau": "", "mpmath-30": ""})
    ['ad', 'mpmath-30']
    """
    words = choice.split(",") if isinstance(choice, str) and choice not in names else choice
    words = [words] if isinstance(words, str) else words
    if not isinstance(words, Sequence) or not words:
        raise ParameterError(f"{name} is {shown(choice)}; give a list of names.")
    selected: set[str] = set()
    for word in words:
        part = word.strip().lower() if isinstance(word, str) else ""
        begins = re.compile(rf"(?<!\w){re.escape(part)}", re.IGNORECASE)
        parts = [n for n, head in names.items() if part and begins.search(f"{n} {head}")]
        exact = [n for n in names if part == n.lower()]
        if not parts:
            every = ", ".join(dict.fromkeys(head or n for n, head in names.items()))
            raise NameUnknownError(f"{name} is {shown(word)}; known are {every}.")
        selected |= set(exact or parts)
    return [n for n in names if n in selected]


def instance(name: str, value: Any, kind: type[Kind], remedy: str) -> Kind:
    """An object of a class, or a refusal.

    Examples
    --------
    >>> instance("title", "a few words", str, "give a string")
    'a few words'
    """
    if not isinstance(value, kind):
        raise ParameterError(f"{name} is {shown(value)}; {remedy}.")
    return value


def callback(value: Any) -> None:
    """Refuse a function of (done, total) that cannot be called."""
    if value is not None and not callable(value):
        raise ParameterError(f"progress is {shown(value)}; give a function of (done, total).")
