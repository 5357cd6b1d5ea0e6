"""Figures of pages that the build draws again, in place of the copies that the repository shows.

The repository keeps a copy of each for readers of the files.  Figures of measured times are drawn
from the measured numbers, which the repository keeps.
"""

from __future__ import annotations

import csv
import hashlib
import os
import shutil
import subprocess
import sys
import tempfile
from collections.abc import Callable
from contextlib import redirect_stdout
from functools import cache
from io import StringIO
from pathlib import Path
from typing import Any

from docutils import nodes
from sphinx.util import logging

from .commands import MADE, ROOT, environment

DOCS = ROOT / "docs"
REPORT = DOCS / "report"
SOURCES = (".py", ".json", ".html", ".js", ".css")


@cache
def fingerprint() -> str:
    """A word that changes with any file of the package or of the proofs, and with this one."""
    found = hashlib.sha256()
    folders = (ROOT / "stability", ROOT / "notebooks" / "proofs")
    paths = [p for folder in folders for p in folder.rglob("*") if p.suffix in SOURCES]
    for path in (*sorted(paths), Path(__file__), DOCS / "films.py"):
        found.update(path.read_bytes())
    return found.hexdigest()[:16]


def command(words: str, result: str, path: Path) -> None:
    """Run a command of the package in the repository, and take one file that it writes."""
    folder = Path(tempfile.mkdtemp(prefix="work-", dir=path.parent))  # pages are read in parallel
    done = subprocess.run(
        ["bash", "-ec", words.replace("OUT", str(folder))],
        cwd=ROOT,
        env=environment(),
        text=True,
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        check=False,
    )
    if done.returncode:
        raise RuntimeError(f"{words!r} ended with {done.returncode}:\n{done.stdout}")
    (folder / result).rename(path)
    shutil.rmtree(folder)


def basins(path: Path) -> None:
    """The picture of launches near rolling, with fewer launches."""
    command(
        "stability basins --family rolling --x at:0.02:3:48 --y tilt:0.01:1.2:36 --mu 0.3 "
        "--time 1000 --out OUT/rolling.zarr --plot OUT/rolling.png",
        "rolling.png",
        path,
    )


def scene(path: Path) -> None:
    """The chart of a scene, measured now."""
    command(
        "stability scene examples/scenes/hoop-on-a-rough-floor.toml --plot OUT/scene.png",
        "scene.png",
        path,
    )


def launch(path: Path) -> None:
    """A disk that rolls too slowly."""
    command(
        "stability simulate --theta 1.47 --omega3 1.2 --mu 0.3 --time 100 --plot OUT/launch.png",
        "launch.png",
        path,
    )


def towed_wheel(path: Path) -> None:
    """The map of the tutorial, by the tutorial's own code."""
    import re

    page = DOCS / "tutorials" / "towed-wheel.md"
    space: dict[str, Any] = {}
    for block in re.findall(r"```python\n(.*?)```", page.read_text(encoding="utf-8"), re.DOTALL):
        if load := re.match(r":load: (\S+)", block):
            block = (page.parent / load[1]).read_text(encoding="utf-8")
        with redirect_stdout(StringIO()):
            exec(block.replace('"towed-wheel.png"', repr(str(path))), space)
        if "towed-wheel.png" in block:
            return


def explorer(path: Path) -> None:
    """The picture of the explorer, taken by Chromium; the kept one where there is no Chromium."""
    import explorer_picture as script

    if any(shutil.which(name) for name in script.BROWSERS):
        script.main(path)
    else:
        logging.getLogger(__name__).info("no Chromium: explorer.png is the kept picture")
        shutil.copy(script.PICTURE, path)


def of_films(name: str) -> Callable[[Path], Any]:
    """The maker of a film, from `docs/films.py`."""

    def make(path: Path) -> Any:
        import films

        return films.PICTURES[name](path)

    return make


def of_report(name: str) -> Callable[[Path], None]:
    """The maker of a figure of the example report, from its measured numbers."""

    def make(path: Path) -> None:
        from stability.figures.canvas import save_figure

        save_figure(_report_figure(name), path)

    return make


def _report_figure(name: str) -> Any:
    import xarray

    from stability.compare import failures, figures

    def data(stem: str) -> Any:
        with xarray.open_dataset(REPORT / f"{stem}.nc", engine="h5netcdf") as found:
            return found.load()

    part, _, what = name.partition("-")
    if part == "calls":
        lines = csv.DictReader((REPORT / "calls.csv").read_text(encoding="utf-8").splitlines())
        of = {"error": lambda v: float(v) if v else None, "time [s]": float}
        return figures.calls_figure([{n: of.get(n, str)(v) for n, v in r.items()} for r in lines])
    if part == "failures":
        cases = failures.from_csv((REPORT / "failures.csv").read_text(encoding="utf-8"))
        if what == "ladder":
            return figures.ladder_figure(cases)
        return figures.failure_figure([e for e in cases if e.part == what])
    if part == "motion":
        found = data("motion")
        if what == "first":
            return figures.first_call_figure(found)
        return figures.motion_figure(found, what)
    draw = {
        "verdict": figures.verdict_figure,
        "eigenvalues": figures.spectrum_figure,
        "boundary": figures.boundary_figure,
    }
    return draw[what](data("spectrum"))


def scaling(path: Path) -> None:
    """The share of time in chunks over the number of workers, from measured times."""
    import scaling_picture as script

    script.main(path)


def house(path: Path) -> None:
    """The picture of the folders."""
    import house as script

    script.main(path)


FROM_REPORT = (
    "spectrum-verdict",
    "spectrum-eigenvalues",
    "spectrum-boundary",
    "motion-path",
    "motion-event",
    "motion-first",
    "calls",
    "failures-linear",
    "failures-motion",
    "failures-ladder",
)
MAKERS: dict[str, Callable[[Path], Any]] = {
    "basins.png": basins,
    "explorer.png": explorer,
    "launch.png": launch,
    "scene.png": scene,
    "towed-wheel.png": towed_wheel,
    "house.svg": house,
    "scaling.png": scaling,
    **{
        f"films/{n}": of_films(n)
        for n in ("tippe-top.gif", "egg.gif", "ring.gif", "retrograde.png")
    },
    **{f"report/{n}.png": of_report(n) for n in FROM_REPORT},
}
"""Function that makes each figure, by its path within `docs`."""


def made(name: str) -> Path:
    """A figure of today's package: drawn, or found from an earlier build."""
    path = MADE / "figures" / fingerprint() / name
    if not path.is_file():
        path.parent.mkdir(parents=True, exist_ok=True)
        draft = path.with_name(f"draft-{os.getpid()}-{path.name}")
        MAKERS[name](draft)
        draft.rename(path)
    return path


def replaced(app: Any, doctree: nodes.document) -> None:
    """Take the figures of today's package in place of kept copies."""
    here = Path(app.env.doc2path(app.env.docname)).parent
    for node in doctree.findall(nodes.image):
        target = (here / node["uri"]).resolve()
        if "://" in node["uri"] or not target.is_relative_to(DOCS):
            continue
        name = target.relative_to(DOCS).as_posix()
        if name in MAKERS:
            logging.getLogger(__name__).info("drawing %s", name)
            node["uri"] = "/" + made(name).relative_to(DOCS).as_posix()
        elif target.is_file() and MADE not in target.parents:
            if not name.startswith("sphinx_parts"):
                raise RuntimeError(f"{name} is a figure that no part of the build makes")


if __name__ == "__main__":
    for wanted in sys.argv[1:] or MAKERS:
        print(made(wanted))
