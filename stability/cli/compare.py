"""The commands `chart`, `failures` and `report`: a thin layer on `stability.compare.report`."""

from __future__ import annotations

import argparse
from collections import Counter, defaultdict
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from ..base.errors import NameUnknownError, ParameterError, listed, shown
from .options import answer, overwriting, values, whole
from .terminal import progress_bar

if TYPE_CHECKING:
    from ..jobs.measured_cells import Task

CHARTS = ("spectrum", "motion")
"""Subjects of a chart."""


@dataclass(frozen=True)
class Command:
    """One of the three commands."""

    EXAMPLES: tuple[str, ...]
    """Examples of the help."""
    parts: tuple[str, ...] | None
    """Parts of the report that it makes: those of `PARTS` if empty; of None one of `CHARTS`."""

    def add_arguments(self, parser: argparse.ArgumentParser) -> None:
        """Add the options of the command."""
        if self.parts is None:
            parser.add_argument("what", metavar="WHAT", help=listed(CHARTS, "or"))
        out = (
            "folder to write; finished cells are kept there, and a run that was stopped is resumed"
        )
        parser.add_argument("--out", required=True, metavar="DIR", help=out)
        workers = "processes for the catalogue (default: all cores); charts are timed, and take one"
        parser.add_argument("--workers", type=whole, metavar="N", help=workers)
        charted = "hardness classes, `boundary`, or motions"
        of = charted if self.parts is None else "hard cases"
        cases = (
            f"{of}, comma-separated; a word of a name or of a heading chooses all that have it "
            "(default: all)"
        )
        methods = "routes or integrators, in the same way (default: all)"
        values(parser, str, {"--cases": ("NAMES", cases), "--methods": ("NAMES", methods)})
        overwriting(parser, "write into a folder that holds other files", same=False)

    def run(self, options: argparse.Namespace) -> None:
        """Write a chart, the catalogue or the whole report, and print a summary."""
        parts = (options.what,) if self.parts is None else self.parts
        if self.parts is None and options.what not in CHARTS:
            raise NameUnknownError(
                f"chart is {shown(options.what)}; known are {', '.join(CHARTS)}."
            )
        if options.workers is not None and options.workers < 1:
            raise ParameterError(f"--workers is {options.workers}; give a whole number above 0.")
        choice = {"cases": options.cases, "methods": options.methods}
        with progress_bar("cells") as progress:
            from ..compare.plan import PARTS, planned
            from ..compare.report import report

            parts = parts or tuple(PARTS)
            page = report(
                options.out,
                parts,
                **choice,
                overwrite=options.force,
                workers=options.workers,
                progress=progress,
            )
            record = summary(page.parent, planned(parts, **choice))
        answer(options, record, [*lines(record), f"open {page}"])


CHART = Command(("stability chart spectrum --out chart",), None)
CATALOGUE = Command(("stability failures --out failures",), ("failures",))
REPORT = Command(("stability report --out report",), ())


def summary(folder: Path, plan: Mapping[str, Sequence[Sequence[Task]]]) -> dict[str, Any]:
    """Contents of the folder of a report, for JSON: page, machine, files and results of each part.

    Results of a chart are the standings of the package's default routes; of scenes the model that
    answers and the cheapest that could; of failures the marks of each method, and the cells in
    which a default route misleads.
    """
    from ..base.provenance import machine
    from ..compare import failures as catalogue
    from ..compare.plan import CALLS, FAILURES, SCENES, asked, standings
    from ..compare.report import part
    from ..compare.scenes import choice
    from ..jobs.measured_cells import Journal

    cells = Journal(folder).pieces
    out: dict[str, Any] = {"page": str(folder / "index.html"), "machine": machine()}
    for name, groups in plan.items():
        piece = part(name, asked(groups, cells))
        files = [str(folder / f) for f in piece.data]
        files += [str(folder / f"{plate.stem}.png") for plate in piece.plates]
        if name == SCENES:
            choices = {n: choice(data) for n, data in piece.chart.items()}
            out[name] = {
                "files": files,
                "models": {
                    n: {"chosen": mine, "cheapest": best, "factor": ratio}
                    for n, (mine, best, ratio) in choices.items()
                },
            }
            continue
        if name == CALLS:
            out[name] = {"files": files, "rows": piece.chart}
            continue
        if name != FAILURES:
            out[name] = {"files": files, "standings": [vars(s) for s in standings(piece)]}
            continue
        marks: defaultdict[str, Counter[str]] = defaultdict(Counter)
        for e in piece.chart:
            if e.mark is not None:
                marks[e.method][e.mark.word] += 1
        bad = [[e.case, e.method, e.note] for e in catalogue.misleading(piece.chart)]
        out[name] = {"files": files, "marks": marks, "misleading": bad}
    return out


def lines(contents: dict[str, Any]) -> list[str]:
    """A summary as lines of text."""
    from ..compare.plan import RouteStanding, nearest

    out = []
    for name in CHARTS:
        if name in contents:
            best = nearest([RouteStanding(**row) for row in contents[name]["standings"]]).values()
            if not best:  # no default route was asked
                continue
            behind = sorted((s for s in best if not s.on_front), key=lambda s: -s.factor)
            front = len(best) - len(behind)
            out.append(
                f"{name}: a default route is on the Pareto front in {front} of {len(best)} panels"
            )
            out += [f"  {s.panel}: {s.route} takes {s.factor:.3g} times {s.rival}" for s in behind]
    for row in contents.get("calls", {}).get("rows", ()):
        error = "no answer" if row["error"] is None else f"error {row['error']:.1e}"
        out.append(
            f"{row['question']} {row['size']}, {row['way']}: {row['time [s]']:.2g} s, {error}"
        )
    for name, models in contents.get("scenes", {}).get("models", {}).items():
        text = f"scene {name}: {models['chosen']} answers"
        out.append(f"{text}, at {models['factor']:.3g} times the time of {models['cheapest']}")
    if "failures" in contents:
        for method, marks in contents["failures"]["marks"].items():
            text = ", ".join(f"{n} {word}" for word, n in sorted(marks.items()))
            out.append(f"{method:<15} {text}")
        bad = contents["failures"]["misleading"]
        out.append(
            f"default routes that mislead: {len(bad)}"
            + "".join(f"; {case}, {method}: {note}" for case, method, note in bad)
        )
    return out
