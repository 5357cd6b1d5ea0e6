"""The command `explore`."""

from __future__ import annotations

import argparse
from typing import Any

from ..base.errors import ParameterError
from .options import answer, axes_of, overwriting, values, words_of
from .subject import add_subject, options_subject

EXAMPLES = (
    "stability explore --out page.html",
    "stability explore rolling --contact rough --k 0.5 --at 0.8 --out hoop.html",
    "stability explore rolling --body torus --tube 0.2 --mu 0.3 --out tyre.html",
    "stability explore rolling --disk quarter --at 40 --mu 0.9 --out coin.html",
    "stability explore --system examples/bicycle.py:upright --at 5 --set g=9.81 "
    "--x v:0.1:10 --out bicycle.html",
)
"""Examples of the help."""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the options of the command."""
    add_subject(parser)
    parser.add_argument("--at", help="member that is shown at first")
    words = {
        "--x": ("NAME:LO:HI[:log]", "axis across at first"),
        "--y": ("NAME:LO:HI[:log]", "axis up at first"),
        "--positive": ("NAME,NAME", "with --system: quantities that are positive"),
    }
    values(parser, str, words)
    parser.add_argument("--out", required=True, metavar="PAGE.html", help="page to write")
    overwriting(parser, "replace an existing file")


def run(options: argparse.Namespace) -> None:
    """Write the page of a diagram, and print where it is."""
    from ..explorer.explore import explore

    axes = axes_of(options, "x", "y", points=False)
    if options.positive is not None and options.system is None:
        raise ParameterError("--positive belongs to --system; leave it out.")
    if options.family is None and options.system is None:
        options.family = "spinning"
    subject = options_subject(options, {axis[0]: axis for axis in axes.values()}, shown_first=True)
    arguments: dict[str, Any] = dict(subject.arguments)
    numbers = arguments.pop("parameters", {})
    path = explore(
        subject.family,
        **axes,
        positive=words_of(options.positive),
        out=options.out,
        overwrite=options.force,
        **arguments,
        **numbers,
    )
    answer(options, {"page": str(path), "bytes": path.stat().st_size}, [f"open {path}"])
