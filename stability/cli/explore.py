"""The command `explore`."""

from __future__ import annotations

import argparse
from typing import Any

from ..base.errors import ParameterError
from ..storage.text import json_text
from .options import number
from .subject import (
    at_of,
    body_of,
    disk_of,
    doubles,
    numbers_and_at,
    own_family,
    set_numbers,
    where_of,
)

EXAMPLES = (
    "stability explore --out page.html",
    "stability explore rolling --contact rough --k 0.5 --at 0.8 --out hoop.html",
    "stability explore rolling --body torus --tube 0.2 --mu 0.3 --out tyre.html",
    "stability explore rolling --disk quarter --at 40 --mu 0.9 --out coin.html",
    "stability explore --system examples/bicycle.py:upright --at 5 --set g=9.81 "
    "--x v:0.1:10 --out bicycle.html",
)
"""Examples in the help of the command."""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the options of the command that others do not have.

    Parameters
    ----------
    parser
        Its parser.
    """
    for axis, where in (("--x", "across"), ("--y", "up")):
        parser.add_argument(axis, metavar="NAME:LO:HI[:log]", help=f"axis {where} at first")
    parser.add_argument(
        "--positive", metavar="NAME,NAME", help="with --system: quantities that are positive"
    )
    parser.add_argument("--out", required=True, metavar="PAGE.html", help="page to write")


def run(options: argparse.Namespace) -> None:
    """Write the page of a diagram, and print where it is."""
    from ..explorer.explore import explore

    if options.contact is not None and ":" in options.contact:
        raise ParameterError("--contact names a law of your own; the page draws stored laws.")
    axes: dict[str, Any] = {"x": _axis(options.x, "x"), "y": _axis(options.y, "y")}
    common: dict[str, Any] = axes | {"out": options.out, "overwrite": options.force}
    if options.body is None and options.system is not None:
        family: Any = own_family(options)
        given = doubles(numbers_and_at(options, family))
        names = tuple(options.positive.split(",")) if options.positive else ()
        path = explore(family, positive=names, **common, **given)
    else:
        others: dict[str, Any] = set_numbers(options)
        body = body_of(options, {a[0]: a for a in axes.values() if a is not None})
        for key in ("positive", *(["theta", "pole"] if body is None else [])):
            if getattr(options, key, None) is not None:
                raise ParameterError(f"--{key} has no meaning for this page; leave it out.")
        at: Any = at_of(options)
        if options.mu is not None:
            others["mu"] = options.mu
        thing: dict[str, Any] = (
            {"disk": disk_of(options)} if body is None else {"body": body, **where_of(options)}
        )
        path = explore(
            options.family or "spinning",
            at=at,
            contact=options.contact,
            **thing,
            **common,
            **others,
        )
    if options.json:
        print(json_text({"page": str(path), "bytes": path.stat().st_size}))
    else:
        print(f"open {path}")


def _axis(text: str | None, which: str) -> tuple[Any, ...] | None:
    if text is None:
        return None
    name, *ends = text.split(":")
    spacing = ends[2:]
    if len(ends) < 2 or spacing not in ([], ["log"]):
        raise ParameterError(f"--{which} is {text!r}; give NAME:LO:HI or NAME:LO:HI:log.")
    return name, *(number(end, which) for end in ends[:2]), *spacing
