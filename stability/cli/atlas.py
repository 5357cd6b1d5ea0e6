"""The command `atlas`: every diagram on one page."""

from __future__ import annotations

import argparse

from ..base.errors import ParameterError
from .options import answer, flags, overwriting, whole
from .terminal import progress_bar

EXAMPLES = ("stability atlas --out atlas", "stability atlas --bodies --out bodies")
"""Examples of the help."""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the options of the command."""
    bodies = (
        "torus, spheroids, eccentric sphere, thick disk and egg, a page for each; finished figures "
        "are kept in DIR.parts until all are done"
    )
    flags(parser, {"--bodies": bodies})
    parser.add_argument("--out", required=True, metavar="DIR", help="folder to write")
    resolution = "points along the family's axis (default 400, of bodies 96)"
    parser.add_argument("--resolution", type=whole, metavar="N", help=resolution)
    draft = (
        "the diagrams alone, as PNG, without loci and PDFs; the default below 100 points, not with "
        "--bodies"
    )
    parser.add_argument("--draft", action=argparse.BooleanOptionalAction, help=draft)
    overwriting(parser, "replace files in an existing folder", same=False)


def run(options: argparse.Namespace) -> None:
    """Write the page, and print where it is."""
    if options.bodies and options.draft is not None:
        raise ParameterError("--draft belongs to the atlas of the disk; leave it or --bodies out.")
    settings = {"overwrite": options.force}
    settings |= {} if options.resolution is None else {"resolution": options.resolution}
    settings |= {} if options.bodies else {"draft": options.draft}
    with progress_bar("figures") as progress:
        from ..atlas.bodies import atlas_of_bodies
        from ..atlas.build import atlas
        from ..atlas.page import summary

        write = atlas_of_bodies if options.bodies else atlas
        page = write(options.out, progress=progress, **settings)
        record = summary(page)
    answer(options, record, [f"open {page}"])
