"""The reference of the command line, from its parser."""

from __future__ import annotations

import argparse
import re
from pathlib import Path
from typing import Any

from .notebooks import written

TARGET = Path(__file__).resolve().parents[1] / "reference" / "commands.rst"
HEAD = """Command line
============

Every command has ``--help``, prints JSON with ``--json``, and answers bad input with one sentence
and exit code 2. This page is made from the commands' own help.

An axis is ``NAME:LO:HI:N``, with ``:log`` for logarithmic steps. A list is separated by commas.

"""


def commands() -> dict[str, argparse.ArgumentParser]:
    """The parser of each command."""
    from stability.cli.commands import _parser

    found: dict[str, argparse.ArgumentParser] = {}
    for action in _parser()._actions:
        if isinstance(action, argparse._SubParsersAction):
            found.update(action.choices)
    return found


def plain(text: str) -> str:
    """A text of the help, where stars and underscores are letters."""
    marked = (
        (text or "")
        .replace("%%", "%")
        .replace("\\", "\\\\")
        .replace("*", "\\*")
        .replace("_", "\\_")
        .replace("`", "")
    )
    return re.sub(r"\btcp://\S+", r"``\g<0>``", marked)  # otherwise a link that leads nowhere


def option(action: argparse.Action) -> str:
    """One option or argument with its help."""
    value = ""
    if action.nargs != 0:
        value = str(action.metavar or (action.dest.upper() if action.option_strings else ""))
        if not action.metavar and action.choices:
            value = "{" + ",".join(map(str, action.choices)) + "}"
    names = ", ".join(f"{name} {value}".strip() for name in action.option_strings)
    text = plain(str(action.help))
    if action.required and action.option_strings:
        text = f"{text} (required)"
    return f".. option:: {names or value or action.dest}\n\n   {text}\n\n"


def section(name: str, parser: argparse.ArgumentParser) -> str:
    """One command: what it does, its use, its options, an example."""
    parser.format_help()  # some lists of the help are read only there
    title = f"stability {name}"
    lines = [f".. program:: {title}\n", title, "-" * len(title), "", plain(parser.description), ""]
    usage = " ".join(parser.format_usage().split()).removeprefix("usage: ")
    lines += [".. code-block:: text", "", f"   {usage}", ""]
    text = "\n".join(lines) + "\n"
    text += "".join(option(a) for a in parser._actions if a.dest != "help")
    examples = [e.removeprefix("example: ").strip() for e in (parser.epilog or "").split("; ")]
    shown = [e for e in examples if e.startswith("stability")]
    if shown:
        text += "Examples:\n\n.. code-block:: sh\n\n"
        text += "".join(f"   {one}\n" for one in shown) + "\n"
    return text


def write() -> None:
    """Write the page."""
    found: dict[str, Any] = commands()
    written(TARGET, HEAD + "".join(section(n, p) for n, p in found.items()))
