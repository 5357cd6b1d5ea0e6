"""The command `table`: its options are the arguments of `stability.table`."""

from __future__ import annotations

import argparse
from collections.abc import Sequence
from typing import Any

from ..base.errors import ParameterError
from .options import _axis, _list, overwriting
from .subject import CONTACTS, add_body, add_numbers, body_of
from .terminal import progress_bar

FORMS = ("json", "csv", "latex")
"""Forms on standard output; text without one of these."""


def run(options: argparse.Namespace) -> None:
    """Compute a table, and print or write it."""
    from ..storage.targets import check_suffix, check_target
    from ..tables.table import FORMS as ENDINGS

    if options.list == (options.name is not None) and options.name != "list":
        raise ParameterError("give the name of a table, or --list to see them, one of them.")
    options.name = options.name or "list"
    asked = [form for form in FORMS if getattr(options, form)]
    if len(asked) + (options.out is not None) > 1:
        first, second = [*(f"--{form}" for form in asked), "--out"][:2]
        raise ParameterError(f"{first} and {second} are both given; give one of them.")
    if options.out is not None:  # before anything is computed
        check_target(check_suffix(options.out, tuple(ENDINGS), "--out"), overwrite=options.force)
    with progress_bar("lines") as progress:
        from ..tables.registry import table

        family, settings = _settings(options)
        found = table(options.name, family, progress=progress, **settings)
    if options.out is None:
        print(found.printed(*asked or ("text",)).rstrip("\n"))
    else:
        print(found.write(options.out, overwrite=options.force))


def _settings(options: argparse.Namespace) -> tuple[Any, dict[str, Any]]:
    """The family and the keyword arguments of `stability.table`; what is not given is left out."""
    from .subject import doubles, exact_numbers, family_named

    family: Any = options.family
    plain = ("k", "mu", "contact", "tilt", "at", "systems")
    settings = {n: getattr(options, n) for n in plain if getattr(options, n) is not None}
    scales = {n: getattr(options, n) for n in ("mass", "radius", "gravity")}
    scales = {n: v for n, v in scales.items() if v is not None}
    if options.body is not None:
        bare = {n: v for n, v in vars(options).items() if n != "family"}
        settings["body"] = body_of(argparse.Namespace(**bare), {})
    elif scales:
        from ..bodies.disk import Disk

        settings["disk"] = Disk(**scales)
    for axis in ("x", "y"):
        if getattr(options, axis) is not None:
            settings[axis] = _axis(getattr(options, axis), f"--{axis}")
    if options.positive:
        settings["positive"] = tuple(options.positive.split(","))
    if options.decimals:
        settings["decimals"] = True
    if options.system is None:
        if options.set:
            raise ParameterError("--set belongs to `table … --system`; leave it out.")
        return family, settings
    if family is not None:
        raise ParameterError("give --system MODULE:FAMILY or --family, one of them.")
    if options.name not in ("conditions", "hopf", "codimension"):
        raise ParameterError(
            "--system belongs to `table conditions`, `hopf` and `codimension`; leave it out."
        )
    for key in (*plain, "disk", "body"):
        if key in settings:
            what = {"systems": "`table benchmarks`", "body": "`table painleve`"}.get(
                key, "the disk"
            )
            raise ParameterError(f"{key} belongs to {what}; with --system leave it out.")
    family = family_named(options.system)
    names = (*family.at, *family.parameters)
    given: dict[str, Any] = dict(exact_numbers("set", options.set, names, family.name))
    return family, settings | (given if options.name == "conditions" else doubles(given))


def add_arguments(sub: argparse.ArgumentParser, words: Sequence[str] | None = None) -> None:
    """Arguments of the command.

    Parameters
    ----------
    sub
        The command's parser.
    words
        The command line, which may name a body.
    """
    sub.add_argument(
        "name",
        metavar="NAME",
        nargs="?",
        help="families, conditions, drift, hopf, codimension, painleve, benchmarks, thresholds "
        "or list",
    )
    sub.add_argument(
        "--list",
        action="store_true",
        help="the tables with source, what is published and recomputed, difference "
        "and status; the same as `table list`",
    )
    sub.add_argument(
        "--csv", action="store_true", help="print CSV: one header line with units, all digits"
    )
    sub.add_argument(
        "--latex",
        action="store_true",
        help="print LaTeX, with booktabs; `conditions`: the formulas too",
    )
    sub.add_argument("--out", metavar="FILE", help="write a .csv, .json, .tex or .txt file")
    overwriting(sub, "replace an existing file")
    lists = "`conditions`, `drift`, `hopf`: {} of the disk, comma-separated; "
    one = "`codimension --family`: one, where it is no axis"
    sub.add_argument("--k", type=_list, help=lists.format("inertia factors") + one)
    sub.add_argument("--mu", type=_list, help=lists.format("friction coefficients") + one)
    sub.add_argument("--tilt", type=_list, help="`drift`: tilts [rad], comma-separated")
    sub.add_argument(
        "--at",
        type=float,
        help="`codimension --family`: what names the member, where it is no axis",
    )
    sub.add_argument(
        "--systems",
        metavar="NAMES",
        help="`benchmarks`: names of systems or words of names, comma-separated (default: all)",
    )
    sub.add_argument(
        "--contact",
        help=f"`conditions`, `drift`, `hopf`, `codimension --family`: one law of {CONTACTS}, "
        "or module:Class of your own",
    )
    for name, unit in (("mass", "kg"), ("radius", "m"), ("gravity", "m/s²")):
        sub.add_argument(
            f"--{name}",
            type=float,
            help=f"{name} of the disk [{unit}], where --k is taken (default 1)",
        )
    _of_family(sub)
    add_body(sub, words, place=False)


def _of_family(sub: argparse.ArgumentParser) -> None:
    """Arguments of tables of one family."""
    sub.add_argument(
        "--system",
        metavar="MODULE:FAMILY",
        help="`conditions`, `hopf` or `codimension` of a family of your own: "
        "module:name, or file.py:name",
    )
    sub.add_argument("--family", help="`codimension` of one of the disk's families")
    axis = "NAME:LO:HI:N[:log]"
    sub.add_argument(
        "--x", metavar=axis, help="`codimension`: the first axis; `hopf --system`: the axis"
    )
    sub.add_argument("--y", metavar=axis, help="`codimension`: the second axis")
    sub.add_argument(
        "--positive", metavar="NAMES", help="`conditions --system`: positive names, comma-separated"
    )
    sub.add_argument(
        "--decimals",
        action="store_true",
        help="`conditions --system`: read a number of the equations, such as 9.81, as "
        "the decimal, not as its nearest double",
    )
    add_numbers(
        sub,
        "--system: a number for a parameter, such as g=9.81 or r=3/10, which "
        "`conditions` takes exactly; once for each",
    )
