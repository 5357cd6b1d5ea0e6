"""The atlas: diagrams and loci of the three families for three bodies, with data and a page.

Each (body, family) pair is one job; jobs run in processes of their own.  Everything is written into
a folder beside the target and moved there when it is whole.
"""

from __future__ import annotations

import csv
import html
import json
import math
import multiprocessing
import os
import shutil
from collections.abc import Callable, Iterator
from concurrent.futures import ProcessPoolExecutor
from concurrent.futures.process import BrokenProcessPool
from dataclasses import dataclass
from datetime import UTC, datetime
from importlib.metadata import version
from pathlib import Path
from typing import Any

import numpy as np

from . import __version__
from .checks import whole_number
from .contact import Rough, Smooth, Viscous
from .crossings import Crossing
from .curves import KINDS
from .dataset import LIBRARIES, LONG_NAMES
from .disk import Disk
from .errors import FileError, StabilityError
from .files import deaf, postponed, record
from .litter import clear, temporary
from .maps import boundaries, stability_map
from .pipeline import completed
from .query import spectrum
from .steady import AT
from .targets import check_folder, path_text, place, refusing
from .verdict import CODES
from .workers import follow

BODIES: dict[str, tuple[Callable[[], Disk], str, str]] = {
    "disk": (Disk.uniform, "uniform disk", "k = 1/4"),
    "annulus": (lambda: Disk.annulus(0.5), "annulus with inner radius R/2", "k = 5/16"),
    "hoop": (Disk.hoop, "hoop", "k = 1/2"),
}
"""The bodies of the atlas: disk, name, inertia."""
FINEST = 4000
"""Most points along the axis of a family."""
RANGES = {"rolling": (0.02, 3.0), "spinning": (0.02, 5.0), "tumbling": (0.02, math.pi / 2)}
"""Interval of `at`, dimensionless."""
FRICTION = (0.01, 100.0)
"""Interval of mu*, even in the logarithm."""
LOCUS_FRICTION = (0.3, 3.0)
"""mu* of the loci."""
COLUMNS = (
    "body", "k", "family", "contact", "curve", "quantity", "at", "mu", "crossing", "frequency",
    "error", "error_along",
)  # fmt: skip
"""Columns of the CSV of boundaries."""
CODE_KINDS = {code: crossing for crossing, code in KINDS.items()}


@dataclass(frozen=True)
class Picture:
    """One figure of the atlas."""

    stem: str
    """File name without suffix."""
    caption: str
    """What was computed, exactly."""
    alternative: str
    """The figure in a few words, for those who cannot see it."""


@dataclass(frozen=True)
class Page:
    """What one job made."""

    body: str
    """Key of `BODIES`."""
    family: str
    """Family."""
    pictures: tuple[Picture, ...]
    """Figures, the diagram first."""
    rows: tuple[tuple[Any, ...], ...]
    """Rows of the CSV."""


def atlas(
    out: str | os.PathLike[str],
    *,
    resolution: int = 400,
    force: bool = False,
    workers: int | None = None,
    progress: Callable[[int, int], None] | None = None,
) -> Path:
    """Draw the atlas into a folder: figures (PNG, PDF), maps (NetCDF), boundaries (CSV), a page.

    Parameters
    ----------
    out
        Folder to make.
    resolution
        Points along the axis of the family; three quarters as many along mu.
    force
        Whether files in an existing folder may be replaced; other files there are left alone.
    workers
        Processes; all processors when left out.  With 1 everything runs in this process.
    progress
        Called with (jobs done, jobs in all).

    Returns
    -------
    Path
        The page, `index.html` in the folder.

    Raises
    ------
    FileError
        If the folder exists without `force`, or cannot be made.
    ParameterError
        If the resolution is below 8.
    """
    resolution = whole_number(
        "resolution", resolution, 8, FINEST, "`stability map --verdict-only` draws finer ones"
    )
    taken = f"{path_text(out)} exists and is not empty; choose another, or use --force."
    target = check_folder(place(out), "" if force else taken)
    with _beside(target) as folder:
        jobs = [(body, family, str(folder), resolution) for body in BODIES for family in RANGES]
        pages: dict[tuple[str, str], Page] = {}
        if progress:
            progress(0, len(jobs))
        for page in _run(jobs, workers or os.cpu_count() or 1):
            pages[page.body, page.family] = page
            if progress:
                progress(len(pages), len(jobs))
        ordered = [pages[job[0], job[1]] for job in jobs]
        _write_csv(folder / "boundaries.csv", ordered)
        (folder / "index.html").write_text(_html(ordered, resolution), encoding="utf-8")
        _move(folder, target)
    return target / "index.html"


class _beside:  # noqa: N801  # a context manager that reads as a word
    """A temporary folder beside the target, gone afterwards whatever happens."""

    def __init__(self, target: Path) -> None:
        self.target = target

    def __enter__(self) -> Path:
        with refusing(self.target):
            parent = Path(os.path.realpath(self.target)).parent
            clear(parent, always=True)
            self.folder = parent / temporary()
            self.folder.mkdir(0o700)
        return self.folder

    def __exit__(self, *_: object) -> None:
        shutil.rmtree(self.folder, ignore_errors=True)


def _move(folder: Path, target: Path) -> None:
    """Give the folder its name, or its files theirs where the target holds other files."""
    mask = os.umask(0)
    os.umask(mask)
    with refusing(target), postponed():
        for path in folder.iterdir():
            path.chmod(0o666 & ~mask)
        if not os.path.lexists(target):
            folder.chmod(0o777 & ~mask)
            folder.replace(target)  # at once
        else:
            target.mkdir(exist_ok=True)
            for path in folder.iterdir():  # all or nothing
                if (target / path.name).is_dir():
                    raise FileError(
                        f"{path_text(target / path.name)} is a folder in the way; move it aside."
                    )
            for path in sorted(folder.iterdir(), key=lambda p: p.name == "index.html"):
                path.replace(target / path.name)  # the page last: it points at what is there
        record(target)


def _run(jobs: list[tuple[str, str, str, int]], workers: int) -> Iterator[Page]:
    if workers == 1:
        for job in jobs:
            yield _job(*job)
        return
    context = multiprocessing.get_context("spawn")
    others = set(multiprocessing.active_children())
    mine = (os.getpid(),)
    pool: ProcessPoolExecutor | None = None
    try:
        with deaf():  # a signal to stop is for this process to handle
            pool = ProcessPoolExecutor(min(workers, len(jobs)), context, follow, mine)
            ordered = sorted(jobs, key=lambda j: j[1] != "tumbling")  # the longest first
            futures = [pool.submit(_job, *job) for job in ordered]
        yield from completed(futures)
        pool.shutdown()
    except BaseException as stop:
        if pool is not None:
            pool.shutdown(wait=False, cancel_futures=True)
        for child in set(multiprocessing.active_children()) - others:
            child.kill()  # it has nothing to put in order
            child.join()
        if isinstance(stop, BrokenProcessPool):
            raise StabilityError(
                "a process that draws the atlas was ended from outside; nothing was written. "
                "If the memory is short, take a lower resolution or fewer workers."
            ) from None
        raise


# --- one job ---


def _job(body: str, family: str, folder: str, resolution: int) -> Page:
    from .files import write_map
    from .plots import Strip, diagram, save

    make, name, inertia = BODIES[body]
    disk, here, stem = make(), Path(folder), f"{family}-{body}"
    low, high = RANGES[family]
    dataset = stability_map(
        family, x=("at", low, high, resolution), y=("mu", *FRICTION, 3 * resolution // 4, "log"),
        disk=disk, workers=1,
    )  # fmt: skip
    write_map(dataset, here / f"{stem}.nc", overwrite=True)
    rows = _curve_rows(body, disk, family, dataset)
    strips, limits = [], []
    for law in (Rough(), Smooth()):
        points = boundaries(family, axis=("at", low, high, 301), disk=disk, contact=law)
        at = np.linspace(low, high, 2 * resolution)
        growth = spectrum(family, at=at, disk=disk, contact=law).abscissa
        strips.append(Strip(law.name, at, growth, tuple(p.value for p in points)))
        rows += [
            (body, disk.k, family, law.name, i, AT[family][0], p.value, "", p.crossing.word,
             p.frequency, p.error, "at")
            for i, p in enumerate(points)
        ]  # fmt: skip
        where = ", ".join(f"{p.value:.6g}" for p in points)
        limits.append(
            f"{law.name}: " + (f"verdict changes at {where}" if where else "neutral throughout")
        )
    save(diagram(dataset, above=strips[0], below=strips[1], title=f"{family}: {name}"), here / stem)
    caption = _diagram_caption(family, name, inertia, dataset, limits)
    pictures = [Picture(stem, caption, f"Stability diagram of {family} of the {name}")]
    pictures += [_locus(here, body, family, mu, resolution) for mu in LOCUS_FRICTION]
    return Page(body, family, tuple(pictures), tuple(rows))


def _locus(here: Path, body: str, family: str, mu: float, resolution: int) -> Picture:
    from .loci import locus
    from .plots import save

    make, name, inertia = BODIES[body]
    disk = make()
    low, high = RANGES[family]
    at = np.linspace(low, high, 2 * resolution)
    law = Viscous(mu)
    spectra = spectrum(family, at=at, disk=disk, contact=law)
    points = boundaries(family, axis=("at", low, high, 301), disk=disk, contact=law)
    stem = f"locus-{family}-{body}-mu{mu:g}".replace(".", "_")
    title = rf"{family}: {name}, $\mu = {mu:g}$"
    save(locus(spectra, thresholds=[p.value for p in points], title=title), here / stem)
    quantity = LONG_NAMES[AT[family][0]]
    changes = "; ".join(f"{p.crossing.word} boundary at {p.value:.10g}" for p in points)
    caption = (
        f"Eigenvalues of {family} of the {name} ({inertia}) under viscous friction, μ = {mu:g} "
        f"/√(gR), against the {quantity}: growth rate above (linear below 10⁻³, logarithmic "
        f"beyond), frequency below, in √(g/R), at {len(at)} points; "
        f"without the {_zeros(spectra.structural_zeros)}. One colour and number for each "
        "mode, followed by eigenvector overlap and named by the states that lead it on average; "
        "where a pair splits into two real eigenvalues, one of them is dashed. Dotted: "
        f"{changes or 'no change of verdict in this range'}."
    )
    return Picture(stem, caption, f"Eigenvalue loci of {family} of the {name} at mu = {mu:g}")


def _zeros(count: int) -> str:
    return "structural zero" if count == 1 else f"{count} structural zeros"


def _curve_rows(body: str, disk: Disk, family: str, dataset: Any) -> list[tuple[Any, ...]]:
    names = ("boundary_curve", "boundary_at", "boundary_mu", "boundary_kind", "boundary_frequency",
             "boundary_error", "boundary_axis")  # fmt: skip
    columns = [dataset[n].values.tolist() for n in names]
    return [
        (body, disk.k, family, "viscous", curve, AT[family][0], at, mu, CODE_KINDS[kind].word,
         frequency, error, ("at", "mu")[axis])
        for curve, at, mu, kind, frequency, error, axis in zip(*columns, strict=True)
    ]  # fmt: skip


def _diagram_caption(family: str, name: str, inertia: str, dataset: Any, limits: list[str]) -> str:
    count = {v.word: int((dataset.verdict == c).sum()) for v, c in CODES.items()}
    verdicts = ", ".join(f"{n:,} {word}".replace(",", " ") for word, n in count.items() if n)
    undecided = "" if count["undecided"] else "; none undecided"
    kinds = [CODE_KINDS[c] for c in np.unique(dataset.boundary_kind.values).tolist()]
    style = {Crossing.STATIC: "static (solid)", Crossing.FLUTTER: "flutter (dashed)",
             Crossing.TOUCHING: "touching (dotted)"}  # fmt: skip
    curve = "No boundary between verdicts in this range."
    if kinds:
        size = np.where(dataset.boundary_axis == 0, dataset.boundary_at, dataset.boundary_mu)
        worst = float((dataset.boundary_error.values / np.abs(size)).max())
        curve = (
            f"Black: boundary of the verdict, {' and '.join(style[k] for k in kinds)}, "
            f"{dataset.sizes['boundary_point']} points, each a bracket of relative half-width at "
            f"most {worst:.0e} proved in ball arithmetic."
        )
    return (
        f"{family.capitalize()} of the {name} ({inertia}) under viscous friction. Colour: largest "
        "real part of the eigenvalues other than the "
        f"{_zeros(dataset.attrs['structural_zeros'])}, on "
        f"{dataset.sizes['at']} × {dataset.sizes['mu']} points, in √(g/R), linear below 10⁻⁴ and "
        f"logarithmic beyond; hatched where it is positive. Verdicts: {verdicts}{undecided}. "
        f"{curve} Strips: the limit laws on the same axis and colours ({'; '.join(limits)})."
    )


# --- data and page ---


def _write_csv(path: Path, pages: list[Page]) -> None:
    with path.open("w", newline="", encoding="utf-8") as handle:
        writer = csv.writer(handle)
        writer.writerow(COLUMNS)
        for page in pages:
            writer.writerows(page.rows)


_STYLE = """
:root { color-scheme: light; }
body { font: 16px/1.5 system-ui, sans-serif; color: #1a1a1a; background: #fff; max-width: 76rem;
       margin: 0 auto; padding: 1.5rem; }
h1 { font-size: 1.6rem; margin: 0 0 .5rem; } h2 { margin: 2.2rem 0 .3rem; font-size: 1.25rem; }
nav a { margin-right: 1rem; } p.lead { max-width: 46rem; }
.row { display: grid; grid-template-columns: repeat(auto-fit, minmax(20rem, 1fr)); gap: 1.5rem;
       margin-bottom: 1.8rem; }
figure { margin: 0; } figure img { width: 100%; height: auto; }
figcaption { font-size: .82rem; color: #333; } figcaption .files { white-space: nowrap; }
footer { margin-top: 3rem; border-top: 1px solid #ccc; font-size: .82rem; color: #444; }
"""


def _html(pages: list[Page], resolution: int) -> str:
    parts = [
        "<!doctype html>", '<html lang="en"><head><meta charset="utf-8">',
        '<meta name="viewport" content="width=device-width, initial-scale=1">',
        f"<title>Stability atlas of the rolling and sliding disk</title><style>{_STYLE}</style>",
        "</head><body>", "<h1>Stability atlas of the rolling and sliding disk</h1>",
        '<p class="lead">Which steady motions of a thin disk on a plane can be seen? Each diagram '
        "shows one family of steady motions of one body: where small disturbances decay (blue) and "
        "where they grow (vermilion, hatched), with the exact boundary in between. Numbers are "
        "dimensionless (m = R = g = 1). The equations are those of Przybylska &amp; "
        "Rauch-Wojciechowski, <cite>Regul. Chaotic Dyn.</cite> 21(2), 2016, 204–231; every result "
        "is recomputed. All boundaries: <a href=\"boundaries.csv\">boundaries.csv</a>.</p>",
        "<nav>" + "".join(f'<a href="#{f}">{f}</a>' for f in RANGES) + "</nav>",
    ]  # fmt: skip
    for family in RANGES:
        mine = [p for p in pages if p.family == family]
        parts += [f'<h2 id="{family}">{family.capitalize()}</h2>', f"<p>{_lead(family)}</p>"]
        for index in range(len(mine[0].pictures)):
            parts.append('<div class="row">')
            parts += [_figure(p, p.pictures[index], index == 0) for p in mine]
            parts.append("</div>")
    versions = ", ".join(f"{n} {version(n)}" for n in (*LIBRARIES, "matplotlib"))
    now = datetime.now(UTC).isoformat(timespec="seconds")
    parts.append(
        f"<footer><p>Made by <code>stability atlas --resolution {resolution}</code>, stability "
        f"{__version__}, {now}; {html.escape(versions)}. The NetCDF files hold the numbers behind "
        "each diagram with units, error bounds and provenance.</p></footer></body></html>"
    )
    return "\n".join(parts) + "\n"


def _lead(family: str) -> str:
    return {
        "rolling": "Upright, straight ahead: θ = π/2, φ̇ = 0, named by ω₃.",
        "spinning": "Upright, turning on the spot: θ = π/2, ω₃ = 0, named by φ̇.",
        "tumbling": "Inclined, its centre at rest: ω₃ = 0, φ̇² = g/(kR sin θ), named by θ.",
    }[family]


def _figure(page: Page, picture: Picture, diagram: bool) -> str:
    files = [f'<a href="{picture.stem}.{s}">{s.upper()}</a>' for s in ("png", "pdf")]
    if diagram:
        files.append(f'<a href="{page.family}-{page.body}.nc">NetCDF</a>')
    return (
        f'<figure><img src="{picture.stem}.png" alt="{html.escape(picture.alternative)}" '
        f'loading="lazy"><figcaption>{html.escape(picture.caption)} '
        f'<span class="files">{" · ".join(files)}</span></figcaption></figure>'
    )


def summary(page: Path) -> dict[str, Any]:
    """What an atlas holds, for JSON.

    Parameters
    ----------
    page
        Its `index.html`.

    Returns
    -------
    dict
    """
    names = sorted(p.name for p in page.parent.iterdir())
    kinds = {s: sum(n.endswith(s) for n in names) for s in (".png", ".pdf", ".nc", ".csv")}
    out: dict[str, Any] = json.loads(json.dumps({"page": str(page), "files": kinds}))
    return out
