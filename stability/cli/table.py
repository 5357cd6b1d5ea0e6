"""The command `table`: its options are the arguments of `stability.table`."""

from __future__ import annotations

import argparse
from typing import Any

from ..base.errors import ParameterError, listed
from ..bodies.disk import Disk
from .body import add_body
from .modules import family_named
from .options import (
    AXIS,
    axes_of,
    flags,
    given,
    numbers,
    overwriting,
    real,
    targets_of,
    values,
    words_of,
)
from .subject import (
    PLACE,
    SCALES,
    add_contact,
    add_numbers,
    body_of,
    doubles,
    exact_numbers,
)
from .terminal import progress_bar

EXAMPLES = (
    "stability table --list",
    "stability table conditions --k 0.25,0.5 --mu 0.1,1,10",
    "stability table drift --k 0.25 --mu 0.3 --out drift.tex",
    "stability table painleve --body torus --tube 0.2",
    "stability table conditions --system examples/bicycle.py:upright --positive v,g --decimals",
    "stability table hopf --system examples/railway_wheelset.py:centred --x v:1:50:50 --set m=1",
)
"""Examples of the help."""
FORMS = ("json", "csv", "latex")
"""Forms on standard output; text without one of these."""


def run(options: argparse.Namespace) -> None:
    """Compute a table, and print or write it."""
    from ..tables.table import FORMS as ENDINGS

    if options.list == (options.name is not None) and options.name != "list":
        raise ParameterError("give the name of a table, or --list to see them, and not both.")
    options.name = options.name or "list"
    asked = [form for form in FORMS if getattr(options, form)]
    if len(asked) + (options.out is not None) > 1:
        first, second = [*(f"--{form}" for form in asked), "--out"][:2]
        raise ParameterError(f"{first} and {second} are both given; give one of them.")
    targets_of(options, out=tuple(ENDINGS))
    with progress_bar("lines") as progress:
        from ..tables.registry import table

        family, settings = _settings(options)
        result = table(options.name, family, progress=progress, **settings)
    if options.out is None:
        print(result.printed(*asked or ("text",)).rstrip("\n"))
    else:
        print(result.write(options.out, overwrite=options.force))


def _settings(options: argparse.Namespace) -> tuple[Any, dict[str, Any]]:
    """The family and the keyword arguments of `stability.table`; what is not given is left out."""
    family: Any = options.family
    settings = given(options, "k", "mu", "contact", "tilt", "at", "systems")
    scales = given(options, *SCALES)
    if options.body is not None:
        settings["body"] = body_of(options, {}).body
    elif scales:
        settings["disk"] = Disk(**scales)
    settings |= axes_of(options, "x", "y")
    if options.positive:
        settings["positive"] = words_of(options.positive)
    if options.decimals:
        settings["decimals"] = True
    if options.system is None:
        if options.set:
            raise ParameterError("--set belongs to `table … --system`; leave it out.")
        return family, settings
    if family is not None:
        raise ParameterError("give --system MODULE:FAMILY or --family, one of them.")
    family = family_named(options.system)
    names = (*family.at, *family.parameters)
    exact: dict[str, Any] = exact_numbers("set", options.set, names, family.name)
    return family, settings | (exact if options.name == "conditions" else doubles(exact))


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the options of the command."""
    parser.add_argument("name", metavar="NAME", nargs="?", help=_tables)  # type: ignore[arg-type]
    flags(
        parser,
        {
            "--list": "the tables with source, what is published and recomputed, difference and "
            "status; the same as `table list`",
            "--csv": "print CSV: one header line with units, all digits",
            "--latex": "print LaTeX, with booktabs; `conditions`: the formulas too",
            "--decimals": "`conditions --system`: read a number of the equations, such as 9.81, as "
            "the decimal, not as its nearest double",
        },
    )
    parser.add_argument("--out", metavar="FILE", help="write a .csv, .json, .tex or .txt file")
    overwriting(parser, "replace an existing file")
    lists = "`conditions`, `drift`, `hopf`: {} of the disk, comma-separated; "
    single = "`codimension --family`: one, where it is no axis"
    several = {
        "--k": ("K", lists.format("inertia factors") + single),
        "--mu": ("MU", lists.format("friction coefficients") + single),
        "--tilt": ("TILT", "`drift`: tilts [rad], comma-separated"),
    }
    values(parser, numbers, several)
    scales = {
        f"--{name}": (
            name.upper(),
            f"{name} of the disk [{unit}], where --k is taken; all three or none",
        )
        for name, (_, unit) in SCALES.items()
    }
    member = "`codimension --family`: what names the member, where it is no axis"
    values(parser, real, scales | {"--at": ("AT", member)})
    systems = "`benchmarks`: names of systems or words of names, comma-separated (default: all)"
    family = f"`conditions`, `hopf` or `codimension` of a family of your own: {PLACE}"
    words = {
        "--systems": ("NAMES", systems),
        "--system": ("MODULE:FAMILY", family),
        "--family": ("FAMILY", "`codimension` of one of the disk's families"),
        "--x": (AXIS, "`codimension`: the first axis; `hopf --system`: the axis"),
        "--y": (AXIS, "`codimension`: the second axis"),
        "--positive": ("NAMES", "`conditions --system`: positive names, comma-separated"),
    }
    values(parser, str, words)
    add_contact(parser, of="`conditions`, `drift`, `hopf`, `codimension --family`: ")
    add_numbers(
        parser,
        "--system: a number for a parameter, such as g=9.81 or r=3/10, which `conditions` takes "
        "exactly; once for each",
    )
    add_body(parser, place=False)


def _tables() -> str:
    from ..tables.registry import PLACES

    *names, last = PLACES
    return listed([*names, "codimension", last], "or")
