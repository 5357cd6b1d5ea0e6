"""The command `cite`: what to cite for this package, or for a file that it wrote."""

from __future__ import annotations

import argparse

from ..base.citation import Citation, citation
from .options import answer

EXAMPLES = ("stability cite --bibtex", "stability cite map.nc")
"""Examples of the help."""


def run(options: argparse.Namespace) -> None:
    """Print what to cite."""
    cited = citation() if options.file is None else _of_file(options.file)
    fields = ("key", "role", "text", "doi", "bibtex")
    works = [{n: getattr(work, n) for n in fields} for work in cited.works]
    answer(options, {"works": works}, [cited.bibtex if options.bibtex else cited.text])


def _of_file(path: str) -> Citation:
    """What a file says; the readers check it as ever."""
    from ..basin.dataset import FORMAT as BASINS
    from ..motion.dataset import FORMAT as MOTION
    from ..scene.answer import FORMAT as PATH
    from ..spectra.labels import FORMAT as MAP
    from ..storage.datasets import read_dataset

    kinds = {MAP: "a map", MOTION: "a motion", PATH: "the motion of a scene", BASINS: "launches"}
    with read_dataset(path, kinds, lazy=True) as dataset:
        return citation(dataset)


def add_arguments(sub: argparse.ArgumentParser) -> None:
    """Add the options of the command."""
    sub.add_argument(
        "file",
        metavar="FILE",
        nargs="?",
        help="a map, motion (also of a scene) or store of launches that this package wrote (.nc or "
        ".zarr); without it: this package, and the paper of the disk",
    )
    sub.add_argument("--bibtex", action="store_true", help="entries of BibTeX alone")
