"""Errors, one class for each cause; a message is one sentence with the value and the remedy."""

from __future__ import annotations

import math
import reprlib
import sys
import warnings
from collections.abc import Iterable, Sequence
from typing import Any

LONGEST = 280
"""Characters of a message at most."""
VALUE = 60
"""Characters of a user's value in a message at most."""


class StabilityError(ValueError):
    """Any input that the package refuses.

    Source: this package; a refusal for each argument: tests/faults/test_bad_input.py.

    Examples
    --------
    >>> import stability as st
    >>> try:
    ...     st.Disk(k=0.7)
    ... except st.StabilityError as error:
    ...     print(error)
    k is 0.7; a thin body has a diametral inertia factor in (0, 1/2].
    """

    def __init__(self, message: object = "") -> None:
        text = message if isinstance(message, str) else shown(message)
        super().__init__(one_line(text))


class ParameterError(StabilityError):
    """A number outside what the model accepts (sign, range, NaN, infinite, shape)."""


class NameUnknownError(StabilityError):
    """A family, axis, contact law, table or state that does not exist."""


class DomainError(StabilityError):
    """A state at which the equations of motion have no meaning (flat, or D ≤ 0)."""


class NoMemberError(StabilityError):
    """A steady motion that does not exist, or that the root-finder did not reach."""


class FileError(StabilityError):
    """A file that cannot be read or written, or that would be overwritten."""


def warned(message: str) -> None:
    """Warn at the line that called the package, however far below the package finds out.

    Parameters
    ----------
    message
        What is true but incomplete, in a sentence.
    """
    frame, level = sys._getframe(1), 2
    while frame.f_back and frame.f_globals.get("__name__", "").partition(".")[0] == PACKAGE:
        frame, level = frame.f_back, level + 1
    warnings.warn(message, StabilityWarning, stacklevel=level)


PACKAGE = __name__.partition(".")[0]


class StabilityWarning(UserWarning):
    """A result that is true but incomplete; the message says what stays open.

    Source: this package; asked for in tests/boundary/test_interval_search.py.

    Examples
    --------
    >>> import warnings
    >>> import stability as st
    >>> with warnings.catch_warnings():
    ...     warnings.simplefilter("ignore", st.StabilityWarning)  # to have it silent
    ...     found = st.boundaries("rolling", axis=("at", 0.1, 1, 9), contact=st.Smooth())
    """


def one_line(text: str, longest: int = LONGEST) -> str:
    r"""A text as one printable line; words in its middle are left out where it is too long.

    Parameters
    ----------
    text
        Any text: with line breaks, control characters, lone surrogates.
    longest
        Characters at most.

    Examples
    --------
    >>> one_line("a\n  b\x1b")
    'a b\\x1b'
    >>> one_line("0123456789", 7)
    '01 … 89'
    >>> one_line("height, horizon, tolerance, check", 20)
    'height, … check'
    """
    if len(text) > 40 * longest:  # the part that is cut away below needs no work
        text = f"{text[: 20 * longest]} {text[-20 * longest :]}"
    plain = " ".join(text.split())
    if not plain.isprintable():
        plain = "".join(c if c.isprintable() else repr(c)[1:-1] for c in plain)
    if len(plain) <= longest:
        return plain
    room = longest - 3
    head = room - room // 2
    first, last = plain[:head].rstrip(), plain[len(plain) - room // 2 :].lstrip()
    if " " in first and plain[len(first)] != " ":  # whole words
        first = first.rsplit(" ", 1)[0]
    if " " in last and plain[-len(last) - 1] != " ":
        last = last.split(" ", 1)[1]
    return f"{first} … {last}"


class _Short(reprlib.Repr):
    """Short texts of values; `shown` catches the errors of a value's own code."""

    def __init__(self) -> None:
        super().__init__()
        self.maxlevel = 3
        self.maxlist = self.maxtuple = self.maxset = self.maxfrozenset = self.maxdict = 6
        self.maxstring = self.maxlong = self.maxother = VALUE

    def repr_int(self, x: int, level: int) -> str:  # noqa: ARG002
        """Digits, or the number of bits; Python refuses to print very long integers."""
        return repr(x) if x.bit_length() < 180 else f"an integer of {x.bit_length()} bits"

    def repr_ndarray(self, x: Any, level: int) -> str:  # noqa: ARG002
        """Shape and type of its entries."""
        return f"an array of shape {x.shape}, {x.dtype}"

    repr_MaskedArray = repr_matrix = repr_ndarray  # noqa: N815  # reprlib looks up the type's name

    def repr_Dataset(self, x: Any, level: int) -> str:  # noqa: ARG002, N802  # the type's name
        """The title of a dataset."""
        return f"a dataset ({x.attrs.get('title', 'no title')})"

    def repr_instance(self, x: Any, level: int) -> str:  # noqa: ARG002
        """The value's own `repr` if short and no address; the name of a class or a function."""
        kind = type(x).__name__
        if isinstance(x, type):
            return f"the class {x.__name__}"
        try:
            said = repr(x)
        except Exception:  # the value's own code may raise anything
            said = ""
        if said.startswith("<") and said.endswith(">"):
            named = str(getattr(x, "__name__", ""))
            if callable(x) and named.isidentifier():
                return f"the function {named}"
            said = "" if " at 0x" in said else said
        article = "an" if kind[:1].lower() in tuple("aeiou") else "a"
        return said if said.isprintable() and 0 < len(said) <= VALUE else f"{article} {kind}"


_SHORT = _Short()


def shown(value: object) -> str:
    """A user's value for a message: one short printable line for any value.

    Parameters
    ----------
    value
        Any value: arrays show their shape, datasets and graphs their type.

    Returns
    -------
    str
        At most `VALUE` characters.

    Examples
    --------
    >>> shown("x" * 5000)
    "'xxxxxxxxxxxxxxxxxxxxxxxxxxxx … xxxxxxxxxxxxxxxxxxxxxxxxxxx'"
    >>> import numpy as np
    >>> shown(np.zeros((2, 3))), shown([0.5] * 100)
    ('an array of shape (2, 3), float64', '[0.5, 0.5, 0.5, 0.5, 0.5, 0.5, ...]')
    >>> shown(int), shown(shown), shown(lambda: 0)
    ('the class int', 'the function shown', 'a function')
    """
    try:
        if isinstance(value, str):  # its two ends say more than reprlib's three dots
            return one_line(repr(str(value)), VALUE)
        return one_line(_SHORT.repr(value), VALUE)
    except Exception:  # as above
        return one_line(f"a {type(value).__name__}", VALUE)


def if_degrees(value: float) -> str:
    """The end of a sentence about an angle out of range: its radians, if it was in degrees.

    Parameters
    ----------
    value
        The angle as it was given; beyond 360 nothing is said.

    Examples
    --------
    >>> if_degrees(85.0)
    '; angles are in radians, and 85 degrees are 1.48353'
    """
    if not 2 <= abs(value) <= 360:
        return ""
    return f"; angles are in radians, and {value:g} degrees are {math.radians(value):.6g}"


def listed(words: Sequence[str], last: str = "and") -> str:
    """One or more words as a list within a sentence, such as `a, b and c`."""
    *first, end = words
    return f"{', '.join(first)} {last} {end}" if first else end


def absent(words: Iterable[str]) -> str:
    """One or more names that are missing, such as `a and b are missing`."""
    names = list(words)
    return f"{listed(names)} {'is' if len(names) == 1 else 'are'} missing"


def meant(word: str, names: Iterable[str]) -> str:
    """The known name that a wrong one is likely to be meant for; empty where none is near.

    Examples
    --------
    >>> meant("mue", ["mu", "k"]), meant("speed", ["mu", "k"])
    ('mu', '')
    """
    from difflib import get_close_matches

    near = get_close_matches(word, list(names), 1)
    return near[0] if near else ""


def listing(names: Iterable[str], values: Iterable[Any]) -> str:
    """Names with their values, for a message.

    Examples
    --------
    >>> listing(("m", "g"), (2.0, 9.81))
    'm = 2, g = 9.81'
    """
    return ", ".join(f"{n} = {v:.6g}" for n, v in zip(names, values, strict=True))
