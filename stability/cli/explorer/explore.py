"""The command `explore`."""

from __future__ import annotations

import argparse
from typing import Any

from ...base.errors import ParameterError
from ...storage.json_text import json_text
from ..options import _at, _disk, number
from ..subject.body_option import body_of, where_of
from ..subject.system_option import doubles, own_family, with_at

EXAMPLES = (
    "stability explore --out page.html",
    "stability explore rolling --contact rough --k 0.5 --at 0.8 --out hoop.html",
    "stability explore rolling --body torus --tube 0.2 --mu 0.3 --out tyre.html",
    "stability explore rolling --disk quarter --at 40 --mu 0.9 --out coin.html",
    "stability explore --system examples/bicycle.py:upright --at 5 --parameter g=9.81 "
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
        parser.add_argument(axis, metavar="NAME:LO:HI[:log]",
                            help=f"axis {where} at first")  # fmt: skip
    parser.add_argument("--positive", metavar="NAME,NAME",
                        help="with --system: quantities that are positive")  # fmt: skip
    parser.add_argument("--out", required=True, metavar="PAGE.html", help="page to write")


def _explore(options: argparse.Namespace) -> None:
    from ...explorer.explore import explore

    if options.contact is not None and ":" in options.contact:
        raise ParameterError("--contact names a law of your own; the page draws stored laws.")
    axes: dict[str, Any] = {"x": _axis(options.x, "x"), "y": _axis(options.y, "y")}
    common: dict[str, Any] = axes | {"out": options.out, "overwrite": options.force}
    swept = {a[0]: a for a in axes.values() if a is not None}
    body = body_of(options, swept)
    if body is None and options.system is not None:
        family: Any = own_family(options)
        given = doubles(with_at(options, family))
        names = tuple(options.positive.split(",")) if options.positive else ()
        path = explore(family, positive=names, **common, **given)
    else:
        for key in ("positive", "parameter", *(["theta", "pole"] if body is None else [])):
            if getattr(options, key, None) is not None:
                raise ParameterError(f"--{key} has no meaning for this page; leave it out.")
        name = options.family or "spinning"
        numbers = {} if options.mu is None else {"mu": options.mu}
        at: Any = None if options.at is None else _at(options.at)
        physics: dict[str, Any]
        if body is None:
            physics = {"disk": _disk(options)}
        else:
            physics = {"body": body, **where_of(options)}
        path = explore(name, at=at, contact=options.contact, **physics, **common, **numbers)
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
