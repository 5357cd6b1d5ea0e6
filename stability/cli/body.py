"""A body of revolution by its name, or that of the user, and its numbers."""

from __future__ import annotations

import argparse
from collections.abc import Callable, Collection, Mapping
from dataclasses import replace
from inspect import Parameter, signature
from typing import Any

from ..base.errors import NameUnknownError, ParameterError, StabilityError, shown
from .modules import named_in
from .options import given, nearest, real

ACCURACY = "tolerance"
"""Argument of a body's function that is no number of its shape."""


def add_body(parser: argparse.ArgumentParser, *, place: bool = True) -> None:
    """Add the options of a body of revolution; those of its numbers belong to the body.

    Parameters
    ----------
    parser
        Parser of a command.
    place
        Whether the command is about members of a family, of which a body may have several.
    """
    parser.add_argument("--body", metavar="NAME", help=_bodies)  # type: ignore[arg-type]
    solid = "with --body: filled with uniform density (default)"
    parser.add_argument("--solid", action="store_true", default=None, help=solid)
    hollow = "with --body: a surface alone"
    parser.add_argument("--hollow", action="store_false", dest="solid", help=hollow)
    length = "with --body: unit of the body's numbers [m], with --mass and --gravity"
    parser.add_argument("--length", type=real, help=length)
    if place:
        theta = "with --body: where it rolls, if at several inclinations"
        parser.add_argument("--theta", type=real, help=theta)
        pole = "with --body, for vertical: its theta, 0 or pi (default 0)"
        parser.add_argument("--pole", help=pole)


def _bodies() -> str:
    """The named bodies with their numbers and the defaults of these, from their signatures."""
    from ..bodies.round_body.shapes.named import NAMED

    words = []
    for name, make in NAMED.items():
        words.append(name)
        for number, parameter in _numbers_of(make).items():
            if parameter.default is parameter.empty:
                words[-1] += f" --{number} X"
            elif parameter.default is None or type(parameter.default) is float:
                default = "X" if parameter.default is None else f"{parameter.default:g}"
                words[-1] += f" [--{number} {default}]"
    return (
        "a body of revolution in place of the disk, such as --body torus --tube 0.2: "
        f"{', '.join(words)}; or module:name or "
        "file.py:name of a body of your own, or of a function that returns one, each of whose "
        "numbers is an option --NAME X"
    )


def _numbers_of(make: Callable[..., Any]) -> dict[str, Parameter]:
    """The parameters of a body's function that have a name."""
    every = signature(make).parameters
    return {
        n: p
        for n, p in every.items()
        if n != ACCURACY and p.kind not in (p.VAR_KEYWORD, p.VAR_POSITIONAL)
    }


def round_body(options: argparse.Namespace, swept: Mapping[str, Any]) -> Any:
    """The body of revolution that the options name.

    Parameters
    ----------
    options
        Parsed options.
    swept
        Axes by name, (name, low, high, …); a number of the shape on one of them needs no value.
    """
    from ..bodies.round_body.shape import SCALES
    from ..bodies.round_body.shapes.named import NAMED

    for key in given(options, "system", "disk", "k", "radius", "lean"):
        raise ParameterError(f"--{key} does not go with --body; leave one of them out.")
    numbers, scales = options.numbers | given(options, "solid"), given(options, *SCALES)
    scales |= middles(swept, SCALES, scales)
    source = NAMED.get(options.body) or _own_body(options.body, NAMED)
    if callable(source):
        body = _made(options, source, numbers, swept)
    else:
        _refuse_others(options, numbers, [n for n in source.given if n not in SCALES])
        body = source.having(numbers)
    return replace(body, **scales) if scales else body


def middles(
    swept: Mapping[str, Any], names: Collection[str], stated: Collection[str]
) -> dict[str, float]:
    """The middle of each axis over one of these numbers that has no value of its own."""
    return {n: (a[1] + a[2]) / 2 for n, a in swept.items() if n in names and n not in stated}


def _own_body(place: str, named: Collection[str]) -> Any:
    """A user's body, or the function that makes it."""
    from ..bodies.round_body.body import Body

    if ":" not in place:
        raise NameUnknownError(
            f"body is {shown(place)}; known are {', '.join(named)}, or give `module:body` or "
            "`file.py:body`."
        )
    words = "body and no function", "its bodies"
    return named_in("body", place, *words, (Body,), made=True)[0]


def _made(
    options: argparse.Namespace, source: Any, numbers: dict[str, Any], swept: Mapping[str, Any]
) -> Any:
    """A body that a function makes of numbers; one on an axis has the middle of the axis."""
    from ..bodies.round_body.body import Body

    label = options.body
    parameters = _numbers_of(source)
    _refuse_others(options, numbers, parameters)
    middle = middles(swept, parameters, numbers)
    missing = [
        n for n, p in parameters.items() if p.default is p.empty and n not in numbers | middle
    ]
    if missing:
        raise ParameterError(f"--{missing[0]} is missing; {label} needs it.")
    try:
        body = source(**numbers, **middle)
    except StabilityError:
        raise
    except Exception as error:  # a user's function may raise anything
        raise ParameterError(
            f"{label} makes no body of these numbers ({type(error).__name__}: {error})."
        ) from None
    if not isinstance(body, Body):
        raise ParameterError(f"{label} returns {shown(body)}; a stability.Body is needed.")
    every = {n: p.default for n, p in parameters.items()} | numbers | middle
    constants = {n: v for n, v in every.items() if type(v) in (int, float) and n not in body.given}
    return replace(body, constants={**constants, **body.constants}) if constants else body


def _refuse_others(
    options: argparse.Namespace, numbers: Collection[str], parameters: Collection[str]
) -> None:
    """Refuse numbers that the body does not have."""
    for name in numbers:
        if name not in parameters:
            word = "solid or --hollow" if name == "solid" else name
            listing = " or ".join(f"--{n}" for n in parameters) or "no numbers"
            listing = listing.replace("--solid", "--solid or --hollow")
            near = nearest(f"--{name}", options.known)
            other = f"; an option of the command is {near}" if near else ""
            raise ParameterError(
                f"--{word} is no number of {options.body}; it takes {listing}{other}."
            )
