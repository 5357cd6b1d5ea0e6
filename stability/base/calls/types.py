"""Whether arguments of a failed call have the types that the signature states."""

from __future__ import annotations

import types
from collections.abc import Callable, Iterable, Mapping, Sequence
from typing import Any, Literal, Union, get_args, get_origin

from ..errors import listed, shown


def misfit(function: Any, given: Any, named: Mapping[str, Any], first: int) -> str:
    """The first argument of a call whose type is another than its annotation says, in a sentence.

    Parameters
    ----------
    function
        A function with annotations.
    given, named
        Arguments of a call that fits its signature.
    first
        Number of its first arguments that are the object or the class.

    Returns
    -------
    str
        Empty where every type fits, or none is known.
    """
    from inspect import Parameter, signature

    own = signature(function)
    try:
        bound = own.bind(*given, **named).arguments
    except TypeError:
        return ""
    space = {**getattr(function, "__globals__", {})}
    for name, value in list(bound.items())[first:]:
        one = own.parameters[name]
        accepted = _type(one.annotation, space)
        pairs = [(name, value)]
        if one.kind is Parameter.VAR_KEYWORD:
            pairs = list(value.items())
        elif one.kind is Parameter.VAR_POSITIONAL:
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

    Parameters
    ----------
    value
        Any value.
    accepted
        A type, or a form of one.

    Examples
    --------
    >>> fits(3, float | None), fits([1], Sequence[str]), fits("a", Sequence[str])
    (True, False, False)
    """
    origin, inner = get_origin(accepted), get_args(accepted)
    if _of_numbers(accepted):
        return _numeric(value)
    if origin in (Union, types.UnionType):
        return any(fits(value, one) for one in inner)
    if accepted is None or accepted is type(None):
        return value is None
    if origin is Literal:
        return any(type(value) is type(one) and value == one for one in inner)
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
        found = np.asarray(value)
        return found.dtype.kind in "iufO" and (most is None or found.ndim <= most)
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
        found = [words(one) for one in inner if one not in (None, type(None))]
        return listed(list(dict.fromkeys(found)), "or")
    if origin is Literal:
        return listed([repr(one) for one in inner], "or")
    kind = origin or accepted
    if kind in _WORDS:
        return _WORDS[kind]
    if kind in _MANY:
        return "a list" + (" of texts" if inner[:1] == (str,) else "")
    name = getattr(kind, "__name__", str(kind))
    return "a path" if name == "PathLike" else f"{'an' if name[0] in 'AEIOU' else 'a'} {name}"
