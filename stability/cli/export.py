"""The command `export`: a system or family for LaTeX, C, AUTO-07p or BifurcationKit.jl."""

from __future__ import annotations

import argparse
from collections.abc import Mapping
from typing import Any

from ..base.errors import ParameterError, shown
from ..base.exact_numbers import ratio_of_text
from .options import answer, number, overwriting, targets_of, values, words_of
from .subject import PLACE, add_subject, doubles, exact_numbers, options_subject, refuse_option

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
    """Write the export, and print where it is."""
    if (options.axis is None) == (options.format in CONTINUED):
        what = "needs" if options.axis is None else "has no"
        raise ParameterError(f"`export {options.format}` {what} --axis NAME:START:STOP.")
    if options.format != "latex" and options.positive:
        raise ParameterError("--positive belongs to `export latex`; leave it out.")
    if (options.family is None) == (options.system is None):
        raise ParameterError("give FAMILY, or --system MODULE:FAMILY, one of them.")
    write = {"c": _c, "latex": _latex}.get(options.format, _continuation)
    written = write(options)
    answer(options, written, [written["out"]])


def _equations(
    options: argparse.Namespace, swept: Mapping[str, Any] | None = None, *, motion: bool = False
) -> tuple[Any, dict[str, Any], dict[str, Any]]:
    """The family or system, numbers that it has anyhow, and those given, exactly as written."""
    texts, options.set = options.set, None  # names of states too, which no law has
    subject = options_subject(options, swept or {}, motion=motion, shown_first=True)
    assert subject.equations is not None
    equations = subject.equations()
    if motion:
        return equations, {}, {}
    if subject.scales == "SI" and "mass" not in equations.parameters:
        raise ParameterError(
            "the disk is exported without units, m = R = g = 1; leave --disk, --mass, --radius and "
            "--gravity out."
        )
    names = (*equations.at, *equations.parameters)
    numbers: dict[str, Any] = exact_numbers("set", texts, names, equations.name)
    for name in numbers:
        refuse_option(options, name, "by --set")
    for name in ("mu", "k"):
        if getattr(options, name) is not None:
            numbers[name] = ratio_of_text(name, repr(getattr(options, name)))
    usual = {n: v for n, v in subject.numbers.items() if n in equations.parameters}
    return equations, usual, numbers


def _latex(options: argparse.Namespace) -> dict[str, Any]:
    from ..export.to_latex import latex
    from ..storage.files import write_file

    [target] = targets_of(options, out=(".tex",)).values()
    family, _, numbers = _equations(options)
    positive = words_of(options.positive)
    if options.system is None and not positive:
        positive = tuple(n for n in POSITIVE if n in family.parameters)
    text = latex(family, positive=positive, **numbers)
    write_file(target, text, overwrite=options.force)
    return {"out": str(target)}


def _c(options: argparse.Namespace) -> dict[str, Any]:
    from ..export.to_c import c_code

    if options.set:
        raise ParameterError("--set is no option of `export c`, whose code takes numbers.")
    subject, _, _ = _equations(options, motion=options.family is None)
    code = c_code(subject, options.out, overwrite=options.force)
    return {
        "out": str(code.folder),
        "name": code.name,
        "inputs": list(code.inputs),
        "outputs": list(code.outputs),
        "command": code.command,
    }


def _continuation(options: argparse.Namespace) -> dict[str, Any]:
    from ..export.to_continuation import auto_input, bifurcationkit_input

    write = auto_input if options.format == "auto" else bifurcationkit_input
    free, *ends = options.axis.split(":")
    if len(ends) != 2:
        raise ParameterError(f"--axis is {shown(options.axis)}; give NAME:START:STOP.")
    start, stop = (number(end, "--axis") for end in ends)
    family, usual, numbers = _equations(options, {free: (free, start, stop)})
    usual.pop(free, None)
    path = write(
        family,
        options.out,
        free=free,
        start=start,
        stop=stop,
        overwrite=options.force,
        **doubles(usual | numbers),
    )
    return {"out": str(path), "files": sorted(p.name for p in path.iterdir())}


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the options of the command."""
    parser.add_argument("format", choices=FORMATS, help="format of the export")
    add_subject(
        parser,
        system=f"a family of your own: {PLACE}; `c` takes a System too",
        numbers="a number, such as k=1/4, once for each: all others for a continuation; for "
        "`latex` those that the conditions take as numbers",
    )
    axis = "`auto`, `bifurcationkit`: what is continued, from where, to where"
    positive = "`latex`: positive names in the conditions, comma-separated (of the disk: k and mu)"
    words = {"--axis": ("NAME:START:STOP", axis), "--positive": ("NAMES", positive)}
    values(parser, str, words)
    parser.add_argument("--out", required=True, help="`latex`: a .tex file; the others: a folder")
    overwriting(parser, "replace existing files")
