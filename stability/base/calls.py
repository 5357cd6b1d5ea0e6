"""The guard of public calls: what fails because of an argument ends in a sentence that names it."""

from __future__ import annotations

import types
from collections.abc import Callable, Iterable, Mapping, Sequence
from enum import EnumMeta
from functools import wraps
from types import FunctionType
from typing import Any, Literal, Union, get_args, get_origin

from .errors import ParameterError, StabilityError, absent, listed, meant, shown

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
    wrapped = guard(value, name, 0)
    wrapped.__module__ = PACKAGE  # by which it is pickled
    return wrapped


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
    def call(*arguments: Any, **named: Any) -> Any:
        try:
            return function(*arguments, **named)
        except StabilityError:
            raise
        except Exception as error:  # a value that does not fit may cause any
            called = _called(function, name, arguments[:first])
            fault = isinstance(error, TypeError) and _unfit(
                function, called, arguments, named, first
            )
            why = fault or misfit(function, arguments, named, first)
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


def _unfit(function: Any, name: str, arguments: Any, named: Mapping[str, Any], first: int) -> str:
    """Why the words of a call do not fit; empty where they do."""
    from inspect import Parameter, signature  # slow to import, and seldom needed

    expected, either = signature(function), Parameter.POSITIONAL_OR_KEYWORD
    kinds = {n: p.kind for n, p in expected.parameters.items()}
    free = Parameter.VAR_KEYWORD in kinds.values()
    words = [n for n, k in kinds.items() if k in (either, Parameter.KEYWORD_ONLY)][first:]
    bare = [n for n, k in kinds.items() if k in (either, Parameter.POSITIONAL_ONLY)]
    shown_words = f"it takes {', '.join(words)}" if words else "it takes no argument"
    for word in named:
        if word in bare[: len(arguments)]:
            return f"{name} has {word} twice, once without its name; give it once."
        if word not in words and not free:
            near = meant(word, words)
            said = f"; do you mean {near}" if near else ""
            return f"{name} has no argument {shown(word)}{said}; {shown_words}."
    if len(arguments) > len(bare) and Parameter.VAR_POSITIONAL not in kinds.values():
        taken, most = len(arguments) - first, len(bare) - first
        others = [n for n in words if n not in bare]
        which = f"without names it takes {', '.join(bare[first:])}" if most else ""
        rest = f"name the others: {', '.join(others)}" if others else ""
        return (
            f"{name} takes {most or 'no'} argument{'s' * (most != 1)} without a name, and {taken} "
            f"{'is' if taken == 1 else 'are'} given; {'; '.join(filter(None, (which, rest)))}"
        ).removesuffix("; ") + "."
    lacking = [
        n
        for n, p in expected.parameters.items()
        if p.default is Parameter.empty
        and n not in named
        and n not in bare[: len(arguments)]
        and p.kind in (either, Parameter.KEYWORD_ONLY, Parameter.POSITIONAL_ONLY)
    ]
    return f"{absent(lacking)} in a call of {name}; {shown_words}." if lacking else ""


def misfit(function: Any, arguments: Any, named: Mapping[str, Any], first: int) -> str:
    """The first argument of a call whose type is another than its annotation says, in a sentence.

    Parameters
    ----------
    function
        A function with annotations.
    arguments, named
        Arguments of a call that fits its signature.
    first
        Number of its first arguments that are the object or the class.

    Returns
    -------
    str
        Empty where every type fits, or none is known.
    """
    from inspect import Parameter, signature, unwrap

    expected = signature(function)
    try:
        bound = expected.bind(*arguments, **named).arguments
    except TypeError:
        return ""
    space = {**getattr(unwrap(function), "__globals__", {})}
    for name, value in list(bound.items())[first:]:
        parameter = expected.parameters[name]
        accepted = _type(parameter.annotation, space)
        pairs = [(name, value)]
        if parameter.kind is Parameter.VAR_KEYWORD:
            pairs = list(value.items())
        elif parameter.kind is Parameter.VAR_POSITIONAL:
            pairs = [(name, entry) for entry in value]
        for word, entry in pairs:
            if not fits(entry, accepted):
                return f"{word} is {shown(entry)}; give {words(accepted)}."
    return ""


def _type(annotation: Any, space: dict[str, Any]) -> Any:
    """The type that an annotation states; Any where it cannot be known here."""
    if not isinstance(annotation, str):
        return annotation
    inner = annotation.removeprefix("InitVar[").removesuffix("]")
    text = inner if annotation.startswith("InitVar[") else annotation
    try:
        return eval(text, space)  # noqa: S307  # the package's own text
    except (NameError, AttributeError, TypeError):  # imported for types alone
        return Any


def fits(value: Any, accepted: Any) -> bool:
    """Whether a value may be meant for a type: it is of that type, or is one when converted.

    Examples
    --------
    >>> fits(3, float | None), fits([1], Sequence[str]), fits("a", Sequence[str])
    (True, False, False)
    """
    origin, inner = get_origin(accepted), get_args(accepted)
    if _of_numbers(accepted):
        return _numeric(value)
    if origin in (Union, types.UnionType):
        return any(fits(value, choice) for choice in inner)
    if accepted is None or accepted is type(None):
        return value is None
    if origin is Literal:
        return any(type(value) is type(choice) and value == choice for choice in inner)
    if origin is type:
        return isinstance(value, type)
    if accepted in (float, int, complex):
        return _numeric(value, most=0)
    kind = origin or accepted
    if kind is bool:
        return type(value).__name__ in ("bool", "bool_")
    if kind is Callable:
        return callable(value)
    if kind is Any or not isinstance(kind, type):
        return True
    if not isinstance(value, kind) or (isinstance(value, (str, bytes)) and kind in _MANY):
        return False
    if isinstance(value, Mapping) and len(inner) > 1:
        return all(fits(n, inner[0]) and fits(v, inner[1]) for n, v in value.items())
    if kind in _MANY and kind is not tuple and inner and isinstance(value, Sequence):
        return all(fits(entry, inner[0]) for entry in value)
    return True


_MANY = (Sequence, Iterable, list, tuple)


def _of_numbers(accepted: Any) -> bool:
    """Whether a type is NumPy's of anything that becomes an array, or an array."""
    return "_SupportsArray" in str(accepted) or "ndarray" in str(accepted)


def _numeric(value: Any, most: int | None = None) -> bool:
    """Whether a value is numbers, also those of a graph, with at most so many axes."""
    import numpy as np

    if value is None or isinstance(value, (str, bytes, Mapping, *_NO_NUMBERS)):
        return False
    try:
        array = np.asarray(value)
        return array.dtype.kind in "iufO" and (most is None or array.ndim <= most)
    except Exception:  # the value's own conversion may raise anything
        return False


_NO_NUMBERS = (type, types.FunctionType, types.BuiltinFunctionType, set)
_WORDS: dict[Any, str] = {
    bool: "True or False",
    int: "a whole number",
    float: "a number",
    complex: "a number",
    str: "a text",
    dict: "a mapping by name",
    Mapping: "a mapping by name",
    Callable: "a function",
    type(None): "nothing",
}


def words(accepted: Any) -> str:
    """A type as a reader knows it.

    Examples
    --------
    >>> words(Sequence[str] | None), words(float | str)
    ('a list of texts', 'a number or a text')
    """
    origin, inner = get_origin(accepted), get_args(accepted)
    if _of_numbers(accepted):
        return "numbers"
    if origin in (Union, types.UnionType):
        choices = [words(choice) for choice in inner if choice not in (None, type(None))]
        return listed(list(dict.fromkeys(choices)), "or")
    if origin is Literal:
        return listed([repr(choice) for choice in inner], "or")
    kind = origin or accepted
    if kind in _WORDS:
        return _WORDS[kind]
    if kind in _MANY:
        return "a list" + (" of texts" if inner[:1] == (str,) else "")
    name = getattr(kind, "__name__", str(kind))
    return "a path" if name == "PathLike" else f"{'an' if name[0] in 'AEIOU' else 'a'} {name}"
