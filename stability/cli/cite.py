"""The command `cite`: what to cite for this package, or for a file that it wrote."""

from __future__ import annotations

import argparse

from ..base.citation import citation
from .options import answer

EXAMPLES = ("stability cite --bibtex", "stability cite map.png")
"""Examples of the help."""


def run(options: argparse.Namespace) -> None:
    """Print what to cite."""
    cited = citation(options.file)
    fields = ("key", "role", "text", "doi", "bibtex")
    works = [{n: getattr(work, n) for n in fields} for work in cited.works]
    answer(
        options,
        {"made": cited.made, "works": works},
        [cited.bibtex if options.bibtex else cited.text],
    )


def add_arguments(sub: argparse.ArgumentParser) -> None:
    """Add the options of the command."""
    sub.add_argument(
        "file",
        metavar="FILE",
        nargs="?",
        help="a figure, film, page or dataset that this package wrote; without it: this package, "
        "and the paper of the disk",
    )
    sub.add_argument("--bibtex", action="store_true", help="entries of BibTeX alone")
