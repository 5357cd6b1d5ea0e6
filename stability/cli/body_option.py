"""Options for a body of revolution, and the body that they name."""

from __future__ import annotations

import argparse
from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import replace
from inspect import Parameter, signature
from typing import Any

from ..base.errors import NameUnknownError, ParameterError, StabilityError, listed, shown
from .options import number
from .system_option import contents

ACCURACY = "tolerance"
"""Argument of a body's function that is no number of its shape."""


def _shape_options() -> dict[str, list[str]]:
    """Numbers of named bodies, each with its bodies and their defaults, from their signatures."""
    from ..bodies.round_body.shapes.named import NAMED

    found: dict[str, list[str]] = {}
    for body, make in NAMED.items():
        for name, entry in _numbers_of(make).items():
            usual = entry.default
            known = type(usual) is float
            found.setdefault(name, []).append(f"{body} (default {usual:g})" if known else body)
    return found


def _numbers_of(make: Callable[..., Any]) -> dict[str, Parameter]:
    """The parameters of a body's function that have a name."""
    every = signature(make).parameters
    return {
        n: p
        for n, p in every.items()
        if n != ACCURACY and p.kind not in (p.VAR_KEYWORD, p.VAR_POSITIONAL)
    }


def add_body(
    parser: argparse.ArgumentParser, words: Sequence[str] | None, *, place: bool = True
) -> None:
    """Add the option for a body of revolution, and those for its numbers.

    Parameters
    ----------
    parser
        Parser of a command.
    words
        The command line; where it names no body nor asks for help, the options are left out, since
        their signatures load CasADi.  They are added where it is not known.
    place
        Whether the command is about members of a family, of which a body may have several.
    """
    parser.set_defaults(body=None)
    if words is not None and not any(w.startswith(("--b", "-h", "--h")) for w in words):
        return
    from ..bodies.round_body.shapes.named import NAMED

    bodies = ", ".join(
        " ".join(
            [
                body,
                *(f"--{n} X" for n, p in _numbers_of(make).items() if p.default is p.empty),
                *(f"[--{n} X]" for n, p in _numbers_of(make).items() if type(p.default) is float),
            ]
        )
        for body, make in NAMED.items()
    )
    group = parser.add_argument_group(
        "bodies of revolution",
        "in place of the disk, such as --body torus --tube 0.2",
    )
    group.add_argument(
        "--body",
        metavar="NAME",
        help=f"{bodies}; or module:name or file.py:name "
        "of a body of your own, or of a function that returns one, each of whose "
        "numbers is an option --NAME X",
    )
    for name, owners in _shape_options().items():
        of = listed([f"of {owner}" for owner in owners], "or")
        if name == "solid":
            group.add_argument("--solid", action="store_true", default=None, help=f"{of} (default)")
            group.add_argument("--hollow", action="store_false", dest="solid", help=of)
        else:
            group.add_argument(f"--{name}", type=float, help=of)
    group.add_argument("--length", type=float, help="unit of the body's numbers [m] (default 1)")
    if place:
        group.add_argument("--theta", type=float, help="where it rolls, if at several inclinations")
        group.add_argument("--pole", help="for vertical: its theta, 0 or pi (default 0)")


def shape_names() -> tuple[str, ...]:
    """Numbers of named bodies that are options."""
    return tuple(n for n in _shape_options() if n != "solid")


def where_of(options: argparse.Namespace) -> dict[str, Any]:
    """What tells members apart whose numbers are the same: an inclination, or a pole."""
    given: dict[str, Any] = {"theta": options.theta, "pole": options.pole}
    if given["pole"] == "0":
        given["pole"] = 0
    return {n: v for n, v in given.items() if v is not None}


def body_of(options: argparse.Namespace, swept: Mapping[str, Any]) -> Any | None:
    """The body that the options name, or None for the disk and for a system of one's own.

    Parameters
    ----------
    options
        Parsed options.
    swept
        Axes by name, (name, low, high, …); a number of the shape on one of them needs no value.
    """
    if options.body is None:
        return None
    from ..bodies.families import FAMILIES
    from ..bodies.round_body.shape import SCALES
    from ..bodies.round_body.shapes.named import NAMED

    for key in ("system", "disk", "k", "radius", "lean"):
        if getattr(options, key, None) is not None:
            raise ParameterError(f"--{key} does not go with --body; leave one of them out.")
    if getattr(options, "family", "") is None:
        raise ParameterError(f"FAMILY is missing; name one of {', '.join(FAMILIES)}.")
    given = {n: getattr(options, n) for n in _shape_options()}
    given = {n: v for n, v in given.items() if v is not None} | _pairs(options.rest)
    scales = {n: getattr(options, n) for n in SCALES if getattr(options, n) is not None}
    for name in sorted({*given, *scales} & set(swept)):
        raise ParameterError(f"{name} is given as --{name} and as an axis; give it once.")
    found: Any = NAMED.get(options.body)
    found = _own_body(options.body, NAMED) if found is None else found
    body = _made(options.body, found, given, swept)
    return replace(body, **scales) if scales else body


def _pairs(rest: Sequence[str]) -> dict[str, float]:
    """Numbers of a user's body from options that no parser knows: --NAME X or --NAME=X."""
    words = [part for word in rest for part in word.split("=", 1)]
    if len(words) % 2 or not all(w.startswith("--") for w in words[::2]):
        raise ParameterError(f"{' '.join(rest)} is no list of --NAME X, the numbers of a body.")
    names = [w[2:].replace("-", "_") for w in words[::2]]
    return {n: number(v, n) for n, v in zip(names, words[1::2], strict=True)}


def _own_body(place: str, named: Collection[str]) -> Any:
    """A user's body, or the function that makes it."""
    from ..bodies.round_body.body import Body

    if ":" not in place:
        raise NameUnknownError(
            f"body is {shown(place)}; known are {', '.join(named)}, or give `module:body` or "
            "`file.py:body`."
        )
    module, name, table = contents("body", "body", place)
    found = table.get(name)
    if isinstance(found, Body) or (callable(found) and not isinstance(found, type)):
        return found
    bodies = sorted(n for n, v in table.items() if isinstance(v, Body)) or ["none"]
    raise NameUnknownError(
        f"{shown(name)} is no body of {module} and no function; its bodies are {', '.join(bodies)}."
    )


def _made(label: str, found: Any, given: dict[str, Any], swept: Mapping[str, Any]) -> Any:
    """A body with numbers given by options; one on an axis has the middle of the axis."""
    from ..bodies.round_body.body import Body

    if isinstance(found, Body):
        own = {n: v for n, v in found.given.items() if n not in ("mass", "gravity", "length")}
        _refuse_others(label, given, own)
        shape = {n: given.get(n, v) for n, v in found.shape.items()}
        moments = {n: v for n, v in given.items() if n not in shape}
        return replace(found, shape=shape, **moments)
    known = _numbers_of(found)
    _refuse_others(label, given, known)
    middle = {n: (a[1] + a[2]) / 2 for n, a in swept.items() if n in known}
    missing = [n for n, p in known.items() if p.default is p.empty and n not in {**given, **middle}]
    if missing:
        raise ParameterError(f"--{missing[0]} is missing; {label} needs it.")
    try:
        body = found(**given, **middle)
    except StabilityError:
        raise
    except Exception as error:  # a user's function may raise anything
        raise ParameterError(
            f"{label} makes no body of these numbers ({type(error).__name__}: {error})."
        ) from None
    if not isinstance(body, Body):
        raise ParameterError(f"{label} returns {shown(body)}; a stability.Body is needed.")
    every = {n: p.default for n, p in known.items()} | given | middle
    own = {n: v for n, v in every.items() if type(v) in (int, float) and n not in body.given}
    return replace(body, constants={**own, **body.constants}) if own else body


def _refuse_others(label: str, given: Collection[str], known: Collection[str]) -> None:
    for name in given:
        if name not in known:
            word = "solid or --hollow" if name == "solid" else name
            own = " or ".join(f"--{n}" for n in known) or "no numbers"
            own = own.replace("--solid", "--solid or --hollow")
            raise ParameterError(f"--{word} is no number of {label}; it takes {own}.")
