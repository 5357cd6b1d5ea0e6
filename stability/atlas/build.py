"""The atlas: diagrams and loci of the families, and ends of launches, with data and a page.

Each figure is one job.  Jobs run in separate processes.  All files are written into a
temporary folder next to the target, and move to the target when the atlas is complete.
"""

from __future__ import annotations

import os
import shutil
from collections.abc import Callable, Iterator, Mapping, Sequence
from concurrent.futures import Executor
from contextlib import closing, contextmanager
from functools import partial
from pathlib import Path
from typing import Any, TypeVar

import numpy as np

from ..base.checks import flag, whole_number
from ..base.errors import FileError
from ..bodies.contact_laws import Rough, Smooth, Viscous
from ..bodies.disk import Disk
from ..bodies.families import FAMILIES
from ..bodies.quantities import QUANTITIES
from ..jobs.pipeline import Counted, check_run, here, ordered
from ..jobs.processes import processes
from ..storage.files import postponed, record
from ..storage.litter import clear, temporary
from ..storage.pieces import Pieces
from ..storage.targets import check_folder, path_text, refusing
from ..storage.text import csv_text
from .page import (
    BODIES,
    CODE_KINDS,
    DRAFT,
    FRICTION,
    LOCUS_FRICTION,
    Page,
    Picture,
    _diagram_caption,
    _html,
    _member,
    _zeros,
    drawn,
)

T = TypeVar("T")
Job = TypeVar("Job")
FINEST = 4000
"""Most points along the axis of a family."""
COLUMNS = (
    "body",
    "k",
    "family",
    "contact",
    "curve",
    "omega3 [√(g/R)]",
    "phi_dot [√(g/R)]",
    "theta [rad]",
    "mu [1/√(gR)]",
    "crossing",
    "frequency [√(g/R)]",
    "error [as error_along]",
    "error_along",
)
"""Columns of the CSV of boundaries; a family fills that of the number which names its members."""
LAUNCHED = ("rolling", "spinning")
"""Families near which launches start."""
MU = 0.3
"""Friction coefficient of the launches, over 1/√(gR)."""
AT, TILT = (0.1, 3.0), (0.01, 1.2)
"""Angular velocity of the steady motion [√(g/R)], and the tilt from it [rad]."""
TIME = 200.0
"""Last time [√(R/g)]."""
MOST_LAUNCHES, FEWEST_LAUNCHES = 64, 6
"""Most and fewest launches along the angular velocity."""
ALIKE = 0.95
"""Share of launches with one end above which a figure would show nothing."""
_Key = tuple[str, str, float | None] | None
"""A figure: body, family, and the friction coefficient of loci or None for the diagram; None for
the figures of launches."""
_Drawn = tuple[tuple[Picture, ...], tuple[tuple[Any, ...], ...]]
"""Figures, and the rows of the CSV that come with them."""


def atlas(
    out: str | os.PathLike[str],
    *,
    resolution: int = 400,
    draft: bool | None = None,
    overwrite: bool = False,
    workers: int | None = None,
    executor: Executor | None = None,
    progress: Callable[[int, int], None] | None = None,
) -> Path:
    """Write the atlas into a folder: figures (PNG, PDF), maps (NetCDF), boundaries (CSV), a page.

    Its parts are the three families, and the ends of launches near two of them.

    Parameters
    ----------
    out
        Folder to write.
    resolution
        Points along the axis of the family; three quarters as many along mu.
    draft
        Whether to write the diagrams alone, as PNG, without loci, launches and PDFs; below `DRAFT`
        points when left out.
    overwrite
        Whether files in an existing folder may be replaced; other files there stay unchanged.
    workers
        Number of processes; all processors when left out.  With 1 all jobs run in this process.
    executor
        Any `concurrent.futures.Executor` in place of the processes.  Its workers must see the same
        folders; `workers` is then its number of workers.
    progress
        Called with (figures done, figures in all).

    Returns
    -------
    Path
        The page, `index.html` in the folder.

    Raises
    ------
    FileError
        If the folder is not empty and `overwrite` is off, or if it cannot be written.
    ParameterError
        If the resolution is below 8 or above `FINEST`.
    """
    resolution = whole_number(
        "resolution", resolution, 8, FINEST, "`stability map --verdict-only` draws finer ones"
    )
    draft = resolution < DRAFT if draft is None else flag("draft", draft)
    frictions = () if draft else LOCUS_FRICTION
    check_run(workers, progress, executor)
    target = check_folder(out, empty=not flag("overwrite", overwrite))
    with _temporary_folder(target) as folder:
        pairs = [(body, family) for body in BODIES for family in drawn()]
        # the loci first, since each is soon done; then the diagrams, the longest first
        jobs: list[_Key] = [(*pair, mu) for mu in frictions for pair in pairs]
        jobs += [] if draft else [None]
        longest = sorted(pairs, key=lambda pair: not FAMILIES[pair[1]].by_angle)
        jobs += [(*pair, None) for pair in longest]
        counted = Counted(progress, len(jobs))
        made = figures(
            jobs,
            lambda job: partial(_job, job, str(folder), resolution, draft),
            counted,
            workers,
            executor,
        )
        pages = [_page(*pair, made, frictions) for pair in pairs]
        text = csv_text(COLUMNS, [row for page in pages for row in page.rows])
        (folder / "boundaries.csv").write_text(text, "utf-8")
        ends = () if draft else made[None][0]
        (folder / "index.html").write_text(_html(pages, ends, resolution, draft), encoding="utf-8")
        move(folder, target)
    return target / "index.html"


def figures(
    jobs: Sequence[Job],
    task: Callable[[Job], Callable[[], T]],
    counted: Counted,
    workers: int | None,
    executor: Executor | None,
    keep: Pieces[Job, T] | None = None,
) -> dict[Job, T]:
    """Draw the figures of an atlas, each job in a process."""
    counted.add(0)
    with closing(
        ordered(
            jobs,
            task,
            executor=executor,
            workers=min(workers or os.cpu_count() or 1, len(jobs)),
            start_pool=here if workers == 1 else processes,
            keep=keep,
            progress=counted,
        )
    ) as results:
        return dict(results)


@contextmanager
def _temporary_folder(target: Path) -> Iterator[Path]:
    """A temporary folder next to the target, removed afterwards in every case."""
    with refusing(target):
        parent = Path(os.path.realpath(target)).parent
        clear(parent, always=True)
        folder = parent / temporary()
        folder.mkdir(0o700)
    try:
        yield folder
    finally:
        shutil.rmtree(folder, ignore_errors=True)


def move(folder: Path, target: Path) -> None:
    """Rename the folder to the target, or move its files into a target that exists."""
    mask = os.umask(0)
    os.umask(mask)
    with refusing(target), postponed():
        for path in folder.iterdir():
            path.chmod(0o666 & ~mask)
        if not os.path.lexists(target):
            folder.chmod(0o777 & ~mask)
            folder.replace(target)  # one atomic step
        else:
            target.mkdir(exist_ok=True)
            for path in folder.iterdir():  # check all before the first move
                if (target / path.name).is_dir():
                    raise FileError(
                        f"{path_text(target / path.name)} is a folder in the way; move it aside."
                    )
            for path in sorted(folder.iterdir(), key=lambda p: p.name == "index.html"):
                path.replace(target / path.name)  # the page last: it links to the others
        record(target)


# --- one job ---


def _job(job: _Key, folder: str, resolution: int, draft: bool) -> _Drawn:
    """One figure: the loci at a friction coefficient, or the diagram where there is none.

    Without a body, all figures of launches.
    """
    from ..figures.canvas import FORMATS, save

    if job is None:
        return _basin_diagrams(Path(folder), resolution), ()
    body, family, mu = job
    if mu is None:
        figure, picture, rows = _diagram(Path(folder), body, family, resolution)
    else:
        figure, picture, rows = *_locus(body, family, mu, resolution), ()
    save(figure, Path(folder) / picture.stem, FORMATS[:1] if draft else FORMATS)
    return (picture,), rows


def _page(
    body: str, family: str, drawn: Mapping[_Key, _Drawn], frictions: tuple[float, ...]
) -> Page:
    """The figures of a body's family, the diagram first."""
    drawings = [drawn[body, family, mu] for mu in (None, *frictions)]
    return Page(body, family, tuple(p for (p,), _ in drawings), drawings[0][1])


def _diagram(
    here: Path, body: str, family: str, resolution: int
) -> tuple[Any, Picture, tuple[tuple[Any, ...], ...]]:
    from ..boundary.changes import boundaries
    from ..figures.diagram import colour_scale, plot_map
    from ..figures.shading import Strip
    from ..maps.files import write_map
    from ..maps.stability_map import stability_map
    from ..spectra.spectrum import spectrum

    make, name, inertia = BODIES[body]
    disk, stem = make(), f"{family}-{body}"
    low, high = drawn()[family]
    x, y = ("at", low, high, resolution), ("mu", *FRICTION, 3 * resolution // 4, "log")
    row = {
        key: stability_map(family, x=x, y=y, disk=maker(), workers=1)
        for key, (maker, _, _) in BODIES.items()
    }
    dataset, scale = row[body], colour_scale(*row.values())
    write_map(dataset, here / f"{stem}.nc", overwrite=True)
    quantity = FAMILIES[family].at[0]
    rows = _curve_rows((body, disk.k, family, "viscous"), quantity, dataset)
    strips, limits = [], []
    for law in (Rough(), Smooth()):
        points = boundaries(family, axis=("at", low, high, 301), disk=disk, contact=law)
        at = np.linspace(low, high, 2 * resolution)
        spectra = spectrum(family, at=at, disk=disk, contact=law)
        changes = tuple(p.value for p in points)
        strips.append(Strip(law.name, at, spectra.abscissa, changes, spectra.codes))
        start = (body, disk.k, family, law.name)
        rows += [
            (
                *start,
                *(i, *at_cells(quantity, p.value), "", p.crossing.word),
                *(p.frequency, p.error, quantity),
            )
            for i, p in enumerate(points)
        ]
        where = ", ".join(f"{p.value:.4g}" for p in points)
        limits.append(f"{law.name}: " + (f"changes at {where}" if where else "neutral throughout"))
    caption = _diagram_caption(family, name, inertia, dataset, limits, strips, scale)
    picture = Picture(stem, *caption, f"Stability diagram of {family} of the {name}")
    title = f"{family}: {name}"
    figure = plot_map(dataset, above=strips[0], below=strips[1], scale=scale, title=title)
    return figure, picture, tuple(rows)


def _locus(body: str, family: str, mu: float, resolution: int) -> tuple[Any, Picture]:
    from ..boundary.changes import boundaries
    from ..figures.loci import plot_locus
    from ..spectra.spectrum import spectrum

    make, name, inertia = BODIES[body]
    disk = make()
    low, high = drawn()[family]
    at = np.linspace(low, high, 2 * resolution)
    law = Viscous(mu)
    spectra = spectrum(family, at=at, disk=disk, contact=law)
    points = boundaries(family, axis=("at", low, high, 301), disk=disk, contact=law)
    stem = f"locus-{family}-{body}-mu{mu:g}".replace(".", "_")
    title = rf"{family}: {name}, $\mu = {mu:g}$"
    zeros = zeros_of_rates(spectra)
    figure = plot_locus(spectra, thresholds=points, zeros=zeros, title=title)
    quantity = QUANTITIES[FAMILIES[family].at[0]].long_name
    changes = "; ".join(f"{p.crossing.word} boundary at {p.value:.6g}" for p in points)
    dotted = f"dotted: {changes}" if changes else "no change of verdict"
    caption = f"{_member(family, name, inertia)}, μ = {mu:g}/√(gR); {dotted}."
    exact = (
        f"Eigenvalues under viscous friction, against the {quantity}: growth rate above (linear "
        f"near zero, logarithmic beyond), frequency below, in √(g/R), at {len(at)} points; "
        f"without the {_zeros(spectra.structural_zeros)}. One colour and number for each "
        "mode, followed by eigenvector overlap and named by the states that lead it on average"
        f"{_lines(spectra, zeros)}."
    )
    picture = Picture(
        stem, caption, exact, f"Eigenvalue loci of {family} of the {name} at mu = {mu:g}"
    )
    return figure, picture


def _lines(spectra: Any, zeros: list[float]) -> str:
    """The caption's words on split pairs, shared modes and circles, where these are drawn."""
    from ..figures.modes import mode_groups, tracked

    values, radius = tracked(spectra)
    groups = [list(columns) for columns in mode_groups(values) if len(columns) > 1]
    close = 1e-9 * np.abs(values).max()
    apart = any(np.ptp(values[:, columns].real, axis=1).max() > close for columns in groups)
    more = any(len(columns) > 2 for columns in groups)
    said = "; where a pair splits into two real eigenvalues, both have its line" * apart
    said += "; eigenvalues that exchange partners share a mode" * more
    where = ", ".join(f"{v:.10g}" for v in zeros)
    return said + f"; circles: a growth rate crosses zero, at {where}" * bool(where)


def zeros_of_rates(spectra: Any) -> list[float]:
    """Where a growth rate of a sweep of `at` passes through zero, to the last digits of a double.

    The sweep is fine enough to part the zeros.  Each is one of the constant term or of the Hurwitz
    determinant, whose signs at its neighbours are proved.
    """
    from ..boundary.brackets import AxisScan, zeros
    from ..figures.modes import changes_of_sign, crossings, swept, tracked
    from ..spectra.problem import disk_problem

    values, radius = tracked(spectra)
    _, at = swept(spectra)
    fixed = {n: float(v) for n, v in spectra.values.items() if np.size(v) == 1}
    line = AxisScan(disk_problem(spectra.family.name, Disk(), spectra.law), "at", fixed)
    roots = []
    for low, high, _ in changes_of_sign(at, values.real, radius):
        roots += zeros(line, low, high)
    return crossings(at, values.real, radius, roots)


def _curve_rows(start: tuple[Any, ...], quantity: str, dataset: Any) -> list[tuple[Any, ...]]:
    """Rows of the boundary curves of a map, after the words and numbers that all of them share."""
    names = ("curve", "at", "mu", "kind", "frequency", "error", "axis")
    columns = [dataset[f"boundary_{name}"].values.tolist() for name in names]
    rows = []
    for curve, at, mu, kind, frequency, error, axis in zip(*columns, strict=True):
        crossing = CODE_KINDS[kind].word
        along = (quantity, "mu")[axis]
        cells = at_cells(quantity, at)
        rows.append((*start, curve, *cells, mu, crossing, frequency, error, along))
    return rows


def at_cells(quantity: str, at: float) -> tuple[float | None, ...]:
    """The cells of the columns of `at`, which is named by its quantity.

    Examples
    --------
    >>> at_cells("theta", 0.5)
    (None, None, 0.5)
    """
    return tuple(at if name.startswith(quantity) else None for name in COLUMNS[5:8])


def launches_along(resolution: int) -> tuple[int, int]:
    """Launches along the angular velocity and along the tilt.

    Examples
    --------
    >>> launches_along(400), launches_along(16)
    ((64, 46), (6, 4))
    """
    count = min(max(FEWEST_LAUNCHES, resolution // 6), MOST_LAUNCHES)
    return count, round(5 * count / 7)


def _basin_diagrams(folder: Path, resolution: int) -> tuple[Picture, ...]:
    """Draw every body and family as PNG, with the numbers next to it, in one process.

    A process compiles the integrators once, which takes as long as four of these maps.
    """
    from ..figures.canvas import FORMATS, save

    pictures = []
    for family in LAUNCHED:
        for body in BODIES:
            figure, picture = _basin_diagram(folder, body, family, resolution)
            if figure is not None:
                save(figure, folder / picture.stem, FORMATS[:1])
            pictures.append(picture)
    return tuple(pictures)


def _basin_diagram(folder: Path, body: str, family: str, resolution: int) -> tuple[Any, Picture]:
    """The figure of one body and family; none where nearly all launches end in one way."""
    from ..basin.basins import basins
    from ..bodies.contact_laws import Viscous
    from ..figures.basins import basins_caption, plot_basins
    from ..figures.fates import fates
    from ..storage.datasets import write_dataset

    make, name, inertia = BODIES[body]
    along, across = launches_along(resolution)
    dataset = basins(
        make(),
        Viscous(MU),
        family=family,
        x=("at", *AT, along),
        y=("tilt", *TILT, across),
        horizon=TIME,
        workers=1,
    )
    stem = f"basins-{family}-{body}"
    write_dataset(dataset, folder / f"{stem}.nc", overwrite=True)
    start = f"Launches near {_member(family, name, inertia).lower()}, μ = {MU:g}/√(gR)"
    counts = {f.label: int(f.where.sum()) for f in fates(dataset)}
    if max(counts.values()) > ALIKE * dataset.outcome.size:
        ends = ", ".join(f"{count} {label}" for label, count in counts.items())
        said = f"{start}: no figure, since of {dataset.outcome.size} nearly all end alike: {ends}."
        return None, Picture(stem, said, "", "")
    figure = plot_basins(dataset, title=f"launches near {family}: {name}")
    exact = basins_caption(dataset).replace("  ", " ")
    return figure, Picture(stem, f"{start}.", exact, f"Ends of launches near {family}: {name}")
