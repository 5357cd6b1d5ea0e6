"""The command `export`: a system or family for LaTeX, C, AUTO-07p or BifurcationKit.jl."""

from __future__ import annotations

import argparse
from collections.abc import Mapping, Sequence
from typing import Any

from ..base.errors import ParameterError, shown
from ..storage.text import json_text
from .options import number, overwriting
from .subject import (
    CONTACTS,
    add_body,
    add_family,
    add_numbers,
    body_of,
    doubles,
    exact_numbers,
    family_named,
    system_with_families,
    where_of,
)

FORMATS = ("latex", "c", "auto", "bifurcationkit")
"""Words after `export`."""
CONTINUED = ("auto", "bifurcationkit")
"""Formats of a continuation."""
POSITIVE = ("k", "mu", "c")
"""Parameters of the disk that are positive."""
EXAMPLES = (
    "stability export latex spinning --out spinning.tex",
    "stability export c --system examples/bicycle.py:upright --out bicycle",
    "stability export auto spinning --axis phi_dot:5:1.8 --set k=1/4 --set mu=0.8 --out spinning",
    "stability export bifurcationkit spinning --axis mu:0.2:1.5 --set k=1/4 --set "
    "phi_dot=2.6 --out spinning",
    "stability export auto spinning --body torus --tube 0.2 --axis phi_dot:5:1.8 --set "
    "mu=0.8 --out torus",
)
"""Examples of the help."""


def run(options: argparse.Namespace) -> None:
    """Run the command.

    Parameters
    ----------
    options
        Parsed options.
    """
    if (options.axis is None) == (options.format in CONTINUED):
        what = "needs" if options.axis is None else "has no"
        raise ParameterError(f"`export {options.format}` {what} --axis NAME:START:STOP.")
    if options.format not in ("latex",) and options.positive:
        raise ParameterError("--positive belongs to `export latex`; leave it out.")
    if options.format == "c":
        written = _c(options)
    elif options.format == "latex":
        written = _latex(options)
    else:
        written = _continuation(options)
    print(json_text(written) if options.json else written["out"])


def _subject(options: argparse.Namespace) -> Any:
    """The family that the options name."""
    return _with_body(options, {})[0]


def _with_body(options: argparse.Namespace, swept: Mapping[str, Any]) -> tuple[Any, Any]:
    """The family that the options name, and its body or None."""
    body = body_of(options, swept)
    if (options.family is None) == (options.system is None):
        raise ParameterError("give FAMILY, or --system MODULE:FAMILY, one of them.")
    if options.system is not None:
        if options.contact is not None:
            raise ParameterError("--contact belongs to the disk; with --system leave it out.")
        return family_named(options.system), None
    law = options.contact or "viscous"
    if body is not None:
        return body.family(options.family, law, **where_of(options)), body
    from ..bodies.subject import disk_family

    return disk_family(options.family, law), None


def _numbers(options: argparse.Namespace, family: Any) -> dict[str, Any]:
    """Numbers of --set, exactly as they are written."""
    return dict(exact_numbers("set", options.set, (*family.at, *family.parameters), family.name))


def _latex(options: argparse.Namespace) -> dict[str, Any]:
    from ..export.latex import latex
    from ..storage.files import write_file
    from ..storage.targets import check_suffix, check_target

    target = check_target(check_suffix(options.out, (".tex",), "--out"), overwrite=options.force)
    family = _subject(options)
    positive = tuple(options.positive.split(",")) if options.positive else ()
    if options.system is None and not options.positive:
        positive = tuple(n for n in POSITIVE if n in family.parameters)
    given = _numbers(options, family)
    text = latex(family, positive=positive, **dict[str, Any](given))
    write_file(target, text, overwrite=options.force)
    return {"out": str(target)}


def _c(options: argparse.Namespace) -> dict[str, Any]:
    from ..export.c_code import c_code

    if options.set:
        raise ParameterError("--set is no option of `export c`, whose code takes numbers.")
    if options.system is not None:
        subject = system_with_families(options.system)[0]
    else:
        subject = _subject(options)
    code = c_code(subject, options.out, overwrite=options.force)
    return {
        "out": str(code.folder),
        "name": code.name,
        "inputs": list(code.inputs),
        "outputs": list(code.outputs),
        "command": code.command,
    }


def _continuation(options: argparse.Namespace) -> dict[str, Any]:
    from ..export.continuation import auto_input, bifurcationkit_input

    write = auto_input if options.format == "auto" else bifurcationkit_input
    free, *ends = options.axis.split(":")
    if len(ends) != 2:
        raise ParameterError(f"--axis is {shown(options.axis)}; give NAME:START:STOP.")
    start, stop = (number(end, "--axis") for end in ends)
    family, body = _with_body(options, {free: (free, start, stop)})
    numbers_of = {} if body is None else body.given
    own: dict[str, Any] = {
        n: float(v) for n, v in numbers_of.items() if n in family.parameters and n != free
    }
    given = doubles(_numbers(options, family))
    for name in sorted(own.keys() & given.keys()):
        raise ParameterError(f"{name} is a number of the body; give it there alone.")
    found = write(
        family,
        options.out,
        free=free,
        start=start,
        stop=stop,
        overwrite=options.force,
        **own,
        **given,
    )
    return {"out": str(found), "files": sorted(p.name for p in found.iterdir())}


def add_arguments(sub: argparse.ArgumentParser, words: Sequence[str] | None) -> None:
    """Arguments of the command.

    Parameters
    ----------
    sub
        The command's parser.
    words
        The command line, or None.
    """
    sub.add_argument("format", choices=FORMATS, help="format of the export")
    add_family(sub)
    sub.add_argument(
        "--system",
        metavar="MODULE:FAMILY",
        help="a family of your own: module:name, or file.py:name; `c` takes a System too",
    )
    add_body(sub, words)
    sub.add_argument(
        "--contact", help=f"{CONTACTS}, or module:Class for a law of your own (default viscous)"
    )
    sub.add_argument("--mass", type=float, help="mass of --body [kg] (default 1)")
    sub.add_argument("--gravity", type=float, help="gravity of --body [m/s²] (default 1)")
    ends = "`auto`, `bifurcationkit`: what is continued, from where, to where"
    sub.add_argument("--axis", metavar="NAME:START:STOP", help=ends)
    add_numbers(
        sub,
        "a number, such as k=1/4, once for each: all others for a continuation; "
        "for `latex` those that the conditions take as numbers",
    )
    sub.add_argument(
        "--positive",
        metavar="NAMES",
        help="`latex`: positive names in the conditions, comma-separated (of the disk: k and mu)",
    )
    sub.add_argument("--out", required=True, help="`latex`: a .tex file; the others: a folder")
    overwriting(sub, "replace existing files")
