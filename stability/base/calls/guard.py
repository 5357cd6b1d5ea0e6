"""The guard of public calls: what fails because of an argument ends in a sentence that names it."""

from __future__ import annotations

from collections.abc import Mapping
from enum import EnumMeta
from functools import wraps
from types import FunctionType
from typing import Any

from ..errors import ParameterError, StabilityError, absent, meant, shown
from .types import misfit

PACKAGE = __name__.partition(".")[0]
_GUARDED: set[type] = set()


def guarded(value: Any, name: str) -> Any:
    """A public function or class whose calls with wrong arguments are refused in a sentence.

    A guard acts where a call has failed with an error that is none of the package: it costs nothing
    before.  A class is guarded in place, with its public methods and those of its bases here.

    Parameters
    ----------
    value
        The value of a public name; anything but a function or a class is left as it is.
    name
        The public name.
    """
    if isinstance(value, type):
        for base in reversed(value.__mro__):
            if base.__module__.startswith(PACKAGE) and base not in _GUARDED:
                _GUARDED.add(base)
                _guard_class(base)
        return value
    if not callable(value):
        return value
    found = guard(value, name, 0)
    found.__module__ = PACKAGE  # by which it is pickled
    return found


def _guard_class(cls: type) -> None:
    """Guard the methods that a class itself defines."""
    if isinstance(cls, EnumMeta):
        meta = type(cls)
        if meta is not EnumMeta and meta not in _GUARDED:
            _GUARDED.add(meta)
            meta.__call__ = guard(meta.__call__, "", 1)  # type: ignore[method-assign]
    for name, entry in list(vars(cls).items()):
        made = name in ("__init__", "__new__")
        if (name.startswith("_") and not (made or name == "__call__")) or (
            made and isinstance(cls, EnumMeta)
        ):
            continue
        words = cls.__name__ if made or name == "__call__" else f"{cls.__name__}.{name}"
        if isinstance(entry, (classmethod, staticmethod)):
            first = int(isinstance(entry, classmethod) or name == "__new__")
            if isinstance(entry.__func__, FunctionType):
                setattr(cls, name, type(entry)(guard(entry.__func__, words, first)))
        elif isinstance(entry, FunctionType):
            setattr(cls, name, guard(entry, words, 1))


def guard(function: Any, name: str, first: int) -> Any:
    """A function whose call, once it has failed, is refused by the argument that does not fit.

    Any other error is left as it is: one of a user's own function, or a fault of the package.

    Parameters
    ----------
    function
        Any function.
    name
        Its name for a reader.
    first
        Number of its first arguments that are no words of a user: the object, or the class.
    """

    @wraps(function)
    def call(*given: Any, **named: Any) -> Any:
        try:
            return function(*given, **named)
        except StabilityError:
            raise
        except Exception as error:  # a value that does not fit may cause any
            called = _called(function, name, given[:first])
            fault = isinstance(error, TypeError) and _unfit(function, called, given, named, first)
            why = fault or misfit(function, given, named, first)
            if not why:
                raise
            raise ParameterError(why) from (None if fault else error)

    return call


def _called(function: Any, name: str, owner: Any) -> str:
    """Name of a call for a reader: that of the object's own class, where it inherits."""
    if not owner:
        return name
    cls = owner[0] if isinstance(owner[0], type) else type(owner[0])
    if function.__name__ in ("__init__", "__new__") or not name:
        return str(cls.__name__)
    return name


def _unfit(function: Any, name: str, given: Any, named: Mapping[str, Any], first: int) -> str:
    """Why the words of a call do not fit; empty where they do."""
    from inspect import Parameter, signature  # slow to import, and seldom needed

    own, either = signature(function), Parameter.POSITIONAL_OR_KEYWORD
    kinds = {n: p.kind for n, p in own.parameters.items()}
    free = Parameter.VAR_KEYWORD in kinds.values()
    words = [n for n, k in kinds.items() if k in (either, Parameter.KEYWORD_ONLY)][first:]
    bare = [n for n, k in kinds.items() if k in (either, Parameter.POSITIONAL_ONLY)]
    shown_words = f"it takes {', '.join(words)}" if words else "it takes no argument"
    for word in named:
        if word in bare[: len(given)]:
            return f"{name} has {word} twice, once without its name; give it once."
        if word not in words and not free:
            near = meant(word, words)
            said = f"; do you mean {near}" if near else ""
            return f"{name} has no argument {shown(word)}{said}; {shown_words}."
    if len(given) > len(bare) and Parameter.VAR_POSITIONAL not in kinds.values():
        taken, most = len(given) - first, len(bare) - first
        others = [n for n in words if n not in bare]
        which = f"without names it takes {', '.join(bare[first:])}" if most else ""
        rest = f"name the others: {', '.join(others)}" if others else ""
        return (
            f"{name} takes {most or 'no'} argument{'s' * (most != 1)} without a name, and {taken} "
            f"{'is' if taken == 1 else 'are'} given; {'; '.join(filter(None, (which, rest)))}"
        ).removesuffix("; ") + "."
    lacking = [
        n
        for n, p in own.parameters.items()
        if p.default is Parameter.empty
        and n not in named
        and n not in bare[: len(given)]
        and p.kind in (either, Parameter.KEYWORD_ONLY, Parameter.POSITIONAL_ONLY)
    ]
    return f"{absent(lacking)} in a call of {name}; {shown_words}." if lacking else ""
