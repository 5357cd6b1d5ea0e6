"""The report: the charts and the catalogue in one folder, with the numbers behind them and a page.

The folder keeps every finished cell, so a stopped run continues where it was.  Figures, tables and
page are written when a part is complete.
"""

from __future__ import annotations

import os
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from ..base.checks import flag
from ..base.errors import FileError
from ..jobs.measured_cells import JOURNAL, Cell, Journal, run
from ..jobs.pipeline import check_run, resumable
from ..storage.datasets import write_dataset
from ..storage.files import together, write_file
from ..storage.pieces import is_records
from ..storage.targets import check_folder, path_text, place, refusing
from ..storage.text import csv_text
from . import calls, scenes
from . import failures as catalogue
from .motion import chart as motion_chart
from .plan import (
    CALLS,
    FAILURES,
    METRICS,
    MOTION,
    PARTS,
    SCENES,
    SPECTRUM,
    Part,
    Plate,
    asked,
    done,
    planned,
)
from .spectrum import chart as spectrum_chart

if TYPE_CHECKING:
    import xarray

ALONE = (SPECTRUM, MOTION, CALLS, SCENES)
"""Timed parts: their cells run one at a time, so that none disturbs a timing."""


def report(
    out: str | os.PathLike[str],
    parts: Sequence[str] = tuple(PARTS),
    *,
    cases: str | Sequence[str] | None = None,
    methods: str | Sequence[str] | None = None,
    overwrite: bool = False,
    workers: int | None = None,
    progress: Callable[[int, int], None] | None = None,
) -> Path:
    """Make a report, or resume one that was stopped.

    Parameters
    ----------
    out
        Folder of the report.  A folder with a journal is resumed if package, libraries and machine
        are the same as at its start.
    parts
        Parts to make: `spectrum`, `motion`, `calls`, `scenes`, `failures`.  The page also shows
        other parts whose cells are all in the folder.
    cases
        Names of what is asked, all if left out: hardness classes and `boundary` of spectra,
        motions, scenes, hard cases of the catalogue.  A word of a name or of a heading chooses
        all that have it.
    methods
        Who is asked, all if left out: names of routes and integrators, or words of names.
    overwrite
        Whether a folder that holds other files may be written into.
    workers
        Processes for the catalogue; all cores when left out.  Timed charts take one.
    progress
        Called with (cells done, cells in all).

    Returns
    -------
    Path
        The page, `index.html` in the folder.

    Raises
    ------
    FileError
        If the folder cannot be used.
    NameUnknownError
        If there is no such part, case or method.
    ParameterError
        If none of the methods is asked any of the cases.
    KeyboardInterrupt
        On Ctrl-C; the folder keeps finished cells.

    Source: the truth of spectra is proved in balls, that of motions rests on two integrations in
    many digits (benchmarks/truths.py); tests/compare/test_compare.py.

    Examples
    --------
    >>> import stability as st
    >>> import tempfile
    >>> from pathlib import Path
    >>> try:
    ...     st.report(Path(tempfile.gettempdir()) / "report", ["spectra"])
    ... except st.StabilityError as error:
    ...     print("spectrum" in str(error))
    True
    """
    from .page import write

    check_run(workers, progress)
    plan = planned(parts, cases, methods)
    overwrite = flag("overwrite", overwrite)
    folder = _folder(out, overwrite)
    journal = Journal(folder)
    total, before = sum(len(group) for groups in plan.values() for group in groups), 0
    for name, groups in plan.items():

        def told(done: int, _: int, base: int = before) -> None:
            if progress is not None:
                progress(base + done, total)

        lanes = 1 if name in ALONE else workers or os.cpu_count() or 1
        run(groups, journal, workers=lanes, progress=told)
        before += sum(map(len, groups))
    wanted = set(plan)
    try:
        missing = resumable(folder, said="every cell is kept in", then="have what is missing drawn")
        with missing, together():
            others = {name: tasks() for name, tasks in PARTS.items() if name not in plan}
            plan |= {n: groups for n, groups in others.items() if done(groups, journal.pieces)}
            ready = []
            for name in (n for n in PARTS if n in plan):
                ready.append(piece := part(name, asked(plan[name], journal.pieces)))
                if name in wanted or not all((folder / file).exists() for file in piece.data):
                    _write(folder, piece)
            return write(folder, ready)
    except FileError:
        raise
    except (TypeError, KeyError, ValueError, AttributeError, IndexError) as error:
        raise FileError(
            f"{path_text(journal.path)} holds a cell that cannot be read "
            f"({type(error).__name__}); remove the file to begin again."
        ) from error


def _folder(out: Any, overwrite: bool) -> Path:
    target = place(out)
    with refusing(target, "used"):
        ours = is_records(target / JOURNAL)
    check_folder(target, empty=not (ours or overwrite))
    if (target / "index.html").is_dir():
        raise FileError(
            f"{path_text(target / 'index.html')} is a folder in the way; move it aside."
        )
    return target


# --- parts ---


def part(name: str, cells: Mapping[str, Cell]) -> Part:
    """Build a part from its cells."""
    made = {
        SPECTRUM: _spectrum,
        MOTION: _motion,
        CALLS: _calls,
        SCENES: _scenes,
        FAILURES: _failures,
    }
    return made[name](cells)


def _spectrum(cells: Mapping[str, Cell]) -> Part:
    chart = spectrum_chart.dataset(cells)
    plates: list[Plate] = []
    if chart.sizes["hardness"]:
        plates += _classes(chart)
    if "boundary" in chart.sizes:
        plates.append(_places(chart))
    data: dict[str, Callable[[], Any]] = {
        "spectrum.nc": lambda: chart,
        "spectrum.csv": lambda: spectrum_chart.spectrum_csv(cells),
        "boundaries.csv": lambda: spectrum_chart.boundary_csv(cells),
    }
    return Part(SPECTRUM, tuple(plates), data, chart)


def _classes(chart: xarray.Dataset) -> list[Plate]:
    """Figures of verdicts and of eigenvalues, which some routes have."""
    from .figures import answering, spectrum_figure, verdict_figure

    count = int(np.nanmax(chart["count"].values, initial=0))
    truth = f"Truth: {chart.attrs['truth']}."
    plates = [
        Plate(
            "spectrum-verdict",
            f"Verdicts in {chart.sizes['hardness']} classes of problems, {count} points at most: "
            "shares right, undecided and wrong. At the right: time per point, the median over the "
            f"classes, in a batch of {spectrum_chart.MANY} where the route takes arrays. Bold: the "
            f"package's. {truth}",
            lambda: verdict_figure(chart),
        )
    ]
    if answering(chart):
        plates.append(Plate(
            "spectrum-eigenvalues",
            "Eigenvalues, for routes without a wrong verdict: least time per point against the "
            "largest error over the points (its line ends at the median error), relative to the "
            "largest modulus, after the best matching. Named: routes on the Pareto front (broad "
            "line), the package's, and ad-1e-9 as a reference; other common routes are grey. "
            f"μ* is μ√(gR). {truth}",
            lambda: spectrum_figure(chart),
        ))  # fmt: skip
    return plates


def _places(chart: xarray.Dataset) -> Plate:
    """The figure of the places of boundaries."""
    from .figures import boundary_figure

    return Plate(
        "spectrum-boundary",
        "Places of boundaries. Above: time for one boundary against the largest relative error "
        f"on {chart.sizes['boundary']} boundaries (slow routes on every "
        f"{spectrum_chart.SPARSE}th), for routes that miss none; a line goes down to the median "
        "error. Below: all errors, boundary by boundary; smaller ones are drawn at 10⁻¹⁷. Common "
        "routes bisect on their verdict from 1 % off; the package calls boundaries() in the same "
        "bracket. A boundary is missed where a route gives both ends the same verdict. μ means "
        "μ√(gR).",
        lambda: boundary_figure(chart),
    )


DRAWN = ("path", "event")
"""Errors of motions that have a figure; those of all METRICS are in the files and the standings."""


TURNS = (
    "A line may turn back: for tight tolerances simulate() takes another integrator and fewer "
    "neighbours, and idas and cvodes repeat in small pieces where a loose run nearly lifts off."
)
"""Why less error may take less time, for the caption."""


def _motion(cells: Mapping[str, Cell]) -> Part:
    from .figures import first_call_figure, motion_figure, panels_of

    chart = motion_chart.dataset(cells)
    plates = [
        Plate(
            f"motion-{m}",
            f"Work against precision, error of {METRICS[m]}: least time of repeated runs against "
            "error at each tolerance (steps for rk4, ε for regularised), without the first call. "
            "In colour: integrators on the Pareto front (broad line) with a digit or more, "
            f"simulate() and SciPy's RK45; others are grey. {TURNS} Over a panel: who gave a wrong "
            f"outcome or none. Truth: {chart.attrs['truth']}.",
            lambda m=m: motion_figure(chart, m),  # type: ignore[misc]
        )
        for m in DRAWN if m in METRICS and panels_of(chart, m)
    ]  # fmt: skip
    first = Plate(
        "motion-first",
        "What the first call costs: a run in a fresh process at the loosest tolerance (graphs "
        "built, code compiled, imports apart), and the least repeat at the middle tolerance. "
        "Circles: medians over the motions; lines: least to most.",
        lambda: first_call_figure(chart),
    )
    plates += [first] * bool(chart.sizes["scene"])
    data: dict[str, Callable[[], Any]] = {
        "motion.nc": lambda: chart,
        "motion.csv": lambda: motion_chart.motion_csv(cells),
    }
    return Part(MOTION, tuple(plates), data, chart)


def _calls(cells: Mapping[str, Cell]) -> Part:
    from .figures import calls_figure

    rows = calls.rows(cells)
    plate = Plate(
        "calls",
        "Whole calls with their defaults, next to what a user would write instead: time of a "
        "repeat against the largest error, larger marks for larger questions. Maps and spectra: "
        "growth rates and eigenvalues; boundaries: the place; simulate: the whole path. The "
        "package's calls prove or check what they return; the others do not.",
        lambda: calls_figure(rows),
    )
    columns = [*rows[0]] if rows else []
    data = {"calls.csv": lambda: csv_text(columns, [[*row.values()] for row in rows])}
    return Part(CALLS, (plate,) if rows else (), data, rows)


def _scenes(cells: Mapping[str, Cell]) -> Part:
    from ..figures.scene_chart import scene_caption, scene_figure

    charts = scenes.datasets(cells)
    plates = [
        Plate(
            f"scenes-{name}", f"{scenes.SCENES[name][0]} {scene_caption(data)}",
            lambda data=data: scene_figure(data),  # type: ignore[misc]
        )
        for name, data in charts.items()
    ]  # fmt: skip
    data = {"scenes.csv": lambda: csv_text(scenes.COLUMNS, scenes.rows(charts))}
    return Part(SCENES, tuple(plates), data, charts)


STRAW = (
    " sympy-solved divides by zero on motions without slip; it is shown since the step is a common "
    "one, and sympy takes the same equations without it."
)
"""Why a method that nearly always crashes is there."""


def _failures(cells: Mapping[str, Cell]) -> Part:
    from .figures import failure_figure, ladder_figure

    answers = catalogue.entries(cells)
    plates = [
        Plate(
            f"failures-{name}",
            f"{heading}: answers of every method to hard cases, by group, with the number of "
            "cases. Bold: the package's. The table below has every case."
            f"{STRAW if name == catalogue.LINEAR else ''}",
            lambda mine=mine: failure_figure(mine),  # type: ignore[misc]
        )
        for name, heading in catalogue.HEADINGS.items()
        if (mine := [e for e in answers if e.part == name])
    ]  # fmt: skip
    if edges := len(catalogue.asked_edges(answers)):
        plates.append(Plate(
            "failures-ladder",
            "Verdicts on both sides of boundaries, at relative distances 10⁻¹ to 10⁻¹⁵: shares of "
            f"the {edges} boundaries for which each route is right, undecided or wrong; blank "
            f"where it crashed. Bold: the package's.{STRAW}",
            lambda: ladder_figure(answers),
        ))  # fmt: skip
    data = {
        "failures.md": lambda: catalogue.as_markdown(answers),
        "failures.csv": lambda: catalogue.as_csv(answers),
    }
    return Part(FAILURES, tuple(plates), data, answers)


# --- files ---


def _write(folder: Path, piece: Part) -> None:
    from ..figures import canvas

    for plate in piece.plates:
        figure = plate.draw()
        for suffix in canvas.FORMATS:
            canvas.save_figure(figure, folder / f"{plate.stem}{suffix}")
    for name, make in piece.data.items():
        content = make()
        if isinstance(content, str):
            write_file(folder / name, content, overwrite=True)
        else:
            write_dataset(content, folder / name, overwrite=True)
