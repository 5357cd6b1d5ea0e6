"""The atlas of bodies: diagrams of the families of bodies of revolution, a page for each body.

Each figure is one job.  Finished figures are kept next to the target until the atlas is complete,
so that the same call goes on after an interruption.
"""

from __future__ import annotations

import json
import os
import shutil
from collections.abc import Callable
from concurrent.futures import Executor
from contextlib import closing, suppress
from dataclasses import asdict
from functools import partial
from pathlib import Path

from ..base.checks import whole_number
from ..base.errors import FileError
from ..base.version import __version__
from ..jobs.following import processes
from ..jobs.pipeline import Counted, check_run, here, ordered, resumable
from ..storage.files import atomic_write
from ..storage.targets import path_text, refusing
from .body_diagrams import BODIES, Diagram, Key, absence, draw, kinds, names
from .body_pages import pages
from .build import FINEST, folder_for, move
from .page import Picture

RESOLUTION = 96
"""Points along the axis of the family, where none is asked for."""


def atlas_of_bodies(
    out: str | os.PathLike[str],
    *,
    resolution: int = RESOLUTION,
    overwrite: bool = False,
    workers: int | None = None,
    executor: Executor | None = None,
    progress: Callable[[int, int], None] | None = None,
) -> Path:
    """Write the atlas of bodies into a folder: figures (PNG, PDF), maps (NetCDF), a page a body.

    Parameters
    ----------
    out
        Folder to write.  Finished figures are kept in the folder `OUT.parts` until all are done; a
        call that was interrupted goes on from there.
    resolution, overwrite, workers, executor, progress
        As for `stability.atlas.build.atlas`.

    Returns
    -------
    Path
        The page with a link to that of each body, `index.html` in the folder.

    Raises
    ------
    FileError
        If the folder is not empty and `overwrite` is off, or if it cannot be written.
    ParameterError
        If the resolution is below 8 or above `FINEST`.
    """
    resolution = whole_number("resolution", resolution, 8, FINEST)
    check_run(workers, progress, executor)
    target = folder_for(out, overwrite=overwrite)
    jobs, absent = _jobs()
    keep = _Figures(target, resolution)
    counted = Counted(progress, len(jobs))
    counted.add(0)
    count = min(workers or os.cpu_count() or 1, len(jobs))
    with (
        resumable(keep.folder, counted, said="figures are kept in"),
        closing(
            ordered(
                jobs,
                lambda job: partial(draw, *job, str(keep.folder), resolution),
                executor=executor,
                workers=count,
                own=here if workers == 1 else processes,
                keep=keep,
                progress=counted,
            )
        ) as results,
    ):
        found = dict(results)
    for name, text in pages(BODIES, found, absent, resolution).items():
        (keep.folder / name).write_text(text, encoding="utf-8")
    keep.release()
    move(keep.folder, target)
    shutil.rmtree(keep.folder, ignore_errors=True)
    return target / "index.html"


def _jobs() -> tuple[list[Key], dict[tuple[str, str], str]]:
    """Every diagram, and a sentence for each family that a body does not have."""
    jobs: list[Key] = []
    absent = {}
    for key, shown in BODIES.items():
        for name in names(shown):
            missing = absence(shown, name)
            if missing:
                absent[key, name] = missing
            else:
                jobs += [(key, name, kind) for kind in kinds(shown, name)]
    return jobs, absent


class _Figures:
    """Finished figures in a folder next to the target, until the atlas is complete."""

    NOTE = "atlas.json"

    def __init__(self, target: Path, resolution: int) -> None:
        self.folder = target.with_name(f"{target.name}.parts")
        self._label = [__version__, resolution]
        with refusing(self.folder, "used"):
            self.folder.mkdir(parents=True, exist_ok=True)
            if any(self.folder.iterdir()) and not (self.folder / self.NOTE).is_file():
                raise FileError(f"{path_text(self.folder)} holds other files; move it aside.")
            (self.folder / self.NOTE).write_text("figures of an unfinished atlas\n")

    def done(self, key: Key) -> bool:
        """Whether a figure is there."""
        return self.get(key) is not None

    def get(self, key: Key) -> Diagram | None:
        """A finished figure; None where it is missing, or of another atlas."""
        with suppress(OSError, ValueError, KeyError, TypeError):
            found = json.loads(self._path(key).read_text(encoding="utf-8"))
            diagram = Diagram(Picture(**found["picture"]), found["figure"] is True)
            kinds_ = ("png", "pdf", "nc") if diagram.figure else ("nc",)
            files = [self.folder / f"{diagram.picture.stem}.{s}" for s in kinds_]
            if found["label"] == self._label and all(f.is_file() for f in files):
                return diagram
        return None

    def add(self, key: Key, value: Diagram) -> None:
        """State that a figure is finished."""
        with atomic_write(self._path(key), overwrite=True, result=False) as draft:
            text = json.dumps({"label": self._label} | asdict(value))
            draft.write_text(text, encoding="utf-8")

    def release(self) -> None:
        """Remove what is no part of the atlas."""
        for path in [*self.folder.glob("*.part.json"), self.folder / self.NOTE]:
            path.unlink()

    def _path(self, key: Key) -> Path:
        return self.folder / f"{'-'.join(key)}.part.json"
