"""Types that many modules name; records, and enumerations whose values are sentences."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Set
from dataclasses import fields, is_dataclass
from enum import Enum, EnumMeta
from functools import cache
from typing import Any, ClassVar, Literal, Self

import numpy as np
from numpy.typing import NDArray

from .errors import NameUnknownError, shown

Floats = NDArray[np.float64]
Complexes = NDArray[np.complex128]
Progress = Callable[[int, int], None]
Overwrite = bool | Literal["same"]
"""Whether a file may be replaced: always, never, or where the same call wrote it."""


def fields_of(record: Any) -> dict[str, Any]:
    """Fields of a frozen record without its cached values: its state when pickled."""
    return {f.name: getattr(record, f.name) for f in fields(record)}


class Record:
    """A frozen dataclass whose instances are equal if their fields are, arrays included.

    Fields with `compare=False` do not count.  Take `@dataclass(frozen=True, eq=False)`.
    """

    def __eq__(self, other: object) -> bool:
        if self is other:
            return True
        if type(self) is not type(other):
            return NotImplemented
        return self._content() == other._content()

    def __hash__(self) -> int:
        return hash(self._content())

    def _content(self) -> tuple[Any, ...]:
        """Everything that equal records have in common, as values with a hash."""
        kind = type(self)
        return (kind, *(content(getattr(self, name)) for name in _compared(kind)))  # type: ignore[arg-type]  # a class is hashable


@cache
def _compared(kind: type[Record]) -> tuple[str, ...]:
    """Names of the fields that count."""
    return tuple(f.name for f in fields(kind) if f.compare)  # type: ignore[arg-type]


def content(value: Any) -> Any:
    """A value with a hash, equal for equal data: NaN equals NaN, a list equals a tuple.

    Parameters
    ----------
    value
        Numbers, texts, arrays, labelled arrays, records, and collections of these.

    Examples
    --------
    >>> content([0.0, np.ones(2)]) == content((-0.0, np.ones(2)))
    True
    >>> content(np.ones(2)) == content(np.ones(3))
    False
    """
    if value is None or isinstance(value, (str, int)):  # the most frequent by far
        return value
    if isinstance(value, (float, np.floating)):
        return "NaN" if value != value else float(value)  # noqa: PLR0124  # NaN alone differs
    if isinstance(value, np.ndarray):
        return _of_array(value)
    if hasattr(value, "data_vars"):  # a labelled dataset, which is a mapping too
        return content(value.to_dict(data="array"))
    if isinstance(value, Mapping):
        return ("mapping", frozenset((content(k), content(v)) for k, v in value.items()))
    if isinstance(value, (tuple, list)):
        return ("sequence", *map(content, value))
    if isinstance(value, Set):
        return ("set", frozenset(map(content, value)))
    if is_dataclass(value) and not isinstance(value, (type, Record)):
        return (type(value), *map(content, fields_of(value).values()))
    return value


def _of_array(array: NDArray[Any]) -> Any:
    if array.dtype == object:
        return ("array", array.shape, *map(content, array.flat))
    if array.dtype.kind in "fc":
        array = array + 0.0  # -0.0 equals 0.0
    return ("array", array.shape, array.dtype.str, array.tobytes())


class Same:
    """A key of a cache that compares by identity.

    CasADi's symbols and functions belong to one object and one thread: an equal one has others.
    """

    __slots__: ClassVar[tuple[str, ...]] = ("value",)

    def __init__(self, value: Any) -> None:
        self.value = value

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Same) and self.value is other.value

    def __hash__(self) -> int:
        return id(self.value)


class TupleRecord(tuple[Any, ...]):
    """A named tuple with the equality and hash of a `Record`."""

    __slots__ = ()

    def __eq__(self, other: object) -> bool:
        return type(self) is type(other) and content(list(self)) == content(list(other))

    def __ne__(self, other: object) -> bool:  # that of a tuple compares arrays
        return not self == other

    def __hash__(self) -> int:
        return hash(content(list(self)))


class _ByText(EnumMeta):
    """An enumeration that finds its members by text alone; other values may lack comparison."""

    def __call__(cls, value: Any) -> Any:  # type: ignore[override]
        if not isinstance(value, (str, cls)):
            return cls._missing_(value)  # type: ignore[attr-defined]
        return super().__call__(value)


class Sentences(Enum, metaclass=_ByText):
    """An enumeration whose values are sentences: it prints a word, and takes a word or a code.

    A member equals its word, alone and in an array, and has its hash.  An unknown word is refused
    with the known ones where a member is looked up.
    """

    @property
    def word(self) -> str:
        """The part of the sentence before the colon."""
        return str(self.value).split(":")[0]

    @property
    def code(self) -> int | None:
        """The flag value in files; None where no file holds one."""
        return None

    def __eq__(self, other: object) -> bool:
        return self is other or (isinstance(other, str) and other == self.word)

    def __hash__(self) -> int:
        return hash(self.word)

    def __str__(self) -> str:
        return self.word

    def __repr__(self) -> str:
        return f"<{type(self).__name__}.{self.name}>"

    @classmethod
    def _missing_(cls, value: object) -> Self:
        whole = isinstance(value, (int, np.integer)) and not isinstance(value, bool)
        for member in cls:
            if (isinstance(value, str) and value in (member.word, member.name)) or (
                whole and member.code == value
            ):
                return member
        words = ", ".join(member.word for member in cls)
        codes = " or the code in a file" if next(iter(cls)).code is not None else ""
        raise NameUnknownError(f"{shown(value)} is no {cls.__name__}; give {words}{codes}.")
