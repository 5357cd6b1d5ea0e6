"""The catalogue of failures: hard cases against methods, as a table of marks."""

from __future__ import annotations

import csv
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from ..base.errors import StabilityError
from ..jobs.measured_cells import CRASHED, DONE, LATE, REFUSED, Cell, Task
from ..storage.text import csv_text
from .marks import BY_WORD, HONEST, Judgement, Mark
from .motion import drivers
from .motion.cases import MOTION_CASES
from .spectrum.cases import CASES, DECADES, LADDERS
from .spectrum.routes import ROUTES

ROUTE_NAMES = tuple(ROUTES)
"""Columns of the linear part: routes that people use, then those of the package."""
_LEADING = (
    "rk4",
    "rk45-default",
    "rk45",
    "rough-model",
    "smooth-model",
    "regularised",
    "dop853",
    "lsoda",
    "radau",
    "bdf",
    "cvodes",
    "idas",
    "heyoka",
    "unchecked",
    "simulate",
    "simulate-fine",
)
DRIVER_NAMES = (*_LEADING, *(name for name in drivers.DRIVERS if name not in _LEADING))
"""Columns of the part on motion."""
STEPS = ("right", "undecided", "wrong")
"""What a verdict at one distance from a boundary may be."""
LIMIT = 4.0
"""Time limit of a cell [s]."""
LINEAR, MOTION = "linear", "motion"


@dataclass(frozen=True)
class Entry:
    """One cell of the catalogue."""

    part: str
    """Part of the catalogue: `linear` or `motion`."""
    group: str
    """Heading of the case."""
    case: str
    """Name of the case."""
    method: str
    """Name of the route or driver."""
    mark: Mark | None
    """The mark; None where the case does not apply to the method."""
    digits: float
    """Digits, or decades of distance, that are left; NaN if none."""
    note: str
    """Short remark on the answer, or the message of a failure."""
    steps: str = ""
    """Initials of right, undecided and wrong for each of `DECADES`, of a case at a boundary."""


def _cases(part: str) -> Mapping[str, Any]:
    """The cases of a part by name."""
    return CASES if part == LINEAR else MOTION_CASES


def _methods(part: str) -> Sequence[str]:
    """Names of the methods of a part."""
    return ROUTE_NAMES if part == LINEAR else DRIVER_NAMES


def tasks() -> list[list[Task]]:
    """Tasks of the catalogue, grouped by method: one process for each group."""
    groups = [
        [
            Task(f"failure/{part}/{case}/{method}", weigh, (part, case, method), LIMIT)
            for case in _cases(part)
        ]
        for part in (LINEAR, MOTION)
        for method in _methods(part)
    ]
    return sorted(groups, key=_slow, reverse=True)


def _slow(group: list[Task]) -> bool:
    """Whether a group takes long, so that it starts first."""
    method = group[0].arguments[-1]
    return method.startswith(("mpmath", "rk45")) or method in ("bdf", "radau")


def weigh(part: str, case: str, method: str) -> dict[str, Any] | None:
    """Judge one cell by the names of part, case and method; the result fits JSON."""
    asked: Any = ROUTES[method]() if part == LINEAR else drivers.driver(method)
    judgement = _cases(part)[case]().judge(asked)
    return None if judgement is None else vars(judgement) | {"mark": judgement.mark.word}


def attempt(judge: Callable[[], Judgement | None]) -> Judgement | None:
    """A judgement in this process; an exception becomes a mark.

    Parameters
    ----------
    judge
        Function that returns the judgement.

    Returns
    -------
    Judgement or None

    Examples
    --------
    >>> attempt(lambda: 1 / 0).mark.word
    'crashed'
    """
    try:
        return judge()
    except StabilityError as error:
        return Judgement(Mark.REFUSED, note=str(error))
    except Exception as error:
        return Judgement(Mark.CRASHED, note=f"{type(error).__name__}: {error}")


def entries(cells: Mapping[str, Cell]) -> list[Entry]:
    """The catalogue's cells, case by case."""
    answers = []
    for part in (LINEAR, MOTION):
        for case in _cases(part).values():
            for method in _methods(part):
                cell = cells.get(f"failure/{part}/{case.name}/{method}")
                if cell is not None:
                    answers.append(Entry(part, case.group, case.name, method, *_read(cell)))
    return answers


def _read(cell: Cell) -> tuple[Mark | None, float, str, str]:
    nan = float("nan")
    if cell.status == DONE:
        if cell.value is None:
            return None, nan, "", ""
        letters = "".join(word[0] for word in cell.value.get("steps", ()))
        return BY_WORD[cell.value["mark"]], cell.value["digits"], cell.value["note"], letters
    mark = {REFUSED: Mark.REFUSED, CRASHED: Mark.CRASHED, LATE: Mark.LATE}[cell.status]
    return mark, nan, cell.message, ""


def ladder(answers: Sequence[Entry]) -> dict[str, list[dict[str, int]]]:
    """Number of boundaries with each mark, by route and distance from the boundary.

    Returns
    -------
    dict
        By route: a list along `DECADES` of counts by word.  Boundaries without an answer are not
        counted.
    """
    words = {word[0]: word for word in STEPS}
    counted = {}
    for method in ROUTE_NAMES:
        mine = [e for e in answers if e.part == LINEAR and e.method == method]
        counts = [dict.fromkeys(STEPS, 0) for _ in DECADES]
        for answer in mine:
            for count, letter in zip(counts, answer.steps, strict=False):
                count[words[letter]] += 1
        if mine:
            counted[method] = counts
    return counted


def asked_edges(answers: Sequence[Entry]) -> set[str]:
    """Names of the boundaries whose both sides were asked."""
    return {e.case for e in answers} & {case.name for case in LADDERS}


def own_methods() -> dict[str, bool]:
    """The package's methods, and whether each is a default.

    Returns
    -------
    dict
        Flag by name, for the package's methods alone.
    """
    routes = {r.name: r.default for r in ROUTES.values() if r.own}
    return routes | {d.name: d.default for d in drivers.DRIVERS.values() if d.own}


def defaults() -> set[str]:
    """The methods that the package uses by default."""
    return {name for name, default in own_methods().items() if default}


def misleading(answers: Sequence[Entry]) -> list[Entry]:
    """Cells in which a default method of the package has a misleading mark.

    Returns
    -------
    list of Entry
        Empty unless a default method misleads.
    """
    usual = defaults()
    return [e for e in answers if e.method in usual and e.mark and e.mark not in HONEST]


HEADINGS = {LINEAR: "Linear analysis", MOTION: "Motion"}
"""Heading of each part."""


def by_case(answers: Sequence[Entry], part: str) -> tuple[list[str], dict[str, list[Entry]]]:
    """The methods of a part, and the cells of each of its cases."""
    rows: dict[str, list[Entry]] = {}
    for entry in answers:
        if entry.part == part:
            rows.setdefault(entry.case, []).append(entry)
    return list(dict.fromkeys(e.method for row in rows.values() for e in row)), rows


# --- as text ---


def as_csv(answers: Sequence[Entry]) -> str:
    """The catalogue as CSV: one line for each cell."""
    rows = []
    for e in answers:
        digits = "" if e.digits != e.digits else f"{e.digits:g}"
        mark = "" if e.mark is None else e.mark.word
        rows.append((e.part, e.group, e.case, e.method, mark, digits, e.note, e.steps))
    return csv_text(("part", "group", "case", "method", "mark", "digits", "note", "steps"), rows)


def from_csv(text: str) -> list[Entry]:
    """The catalogue from its CSV.

    Examples
    --------
    >>> one = Entry("linear", "edges", "a", "ad", Mark.WRONG, 3.0, "right to 1e-3, …", "rrrw")
    >>> from_csv(as_csv([one])) == [one]
    True
    """
    return [
        Entry(
            r["part"],
            r["group"],
            r["case"],
            r["method"],
            BY_WORD.get(r["mark"]),
            float(r["digits"] or "nan"),
            r["note"],
            r["steps"],
        )
        for r in csv.DictReader(text.splitlines())
    ]


def as_markdown(answers: Sequence[Entry]) -> str:
    """The catalogue as Markdown: for each part a table of marks, then one of its cases."""
    lines = ["# Where methods fail", "", "Marks:", ""]
    lines += [f"* {mark.value}" for mark in Mark]
    lines += [
        "",
        "Numbers are digits, or for a boundary the decades of distance, that are left.",
        "",
    ]
    for part, heading in HEADINGS.items():
        methods, rows = by_case(answers, part)
        if not rows:
            continue
        lines += [f"## {heading}", "", f"| case | {' | '.join(methods)} |"]
        lines.append("|" + " --- |" * (len(methods) + 1))
        for case, row in rows.items():
            words = {e.method: _word(e) for e in row}
            lines.append(f"| {case} | " + " | ".join(words[m] for m in methods) + " |")
        lines += ["", "| case | what happens | how the truth is known |", "| --- | --- | --- |"]
        lines += [
            f"| {case} | {what} | {how} |"
            for case, (what, how) in texts(part).items()
            if case in rows
        ]
        lines.append("")
    return "\n".join(lines)


def texts(part: str) -> dict[str, tuple[str, str]]:
    """Physics of each case, and how its truth is known.

    Returns
    -------
    dict
        (physics, source of the truth) by name of the case.

    Examples
    --------
    >>> texts("motion")["lifts off"][0]
    'gn reaches zero at t = 16.1165'
    """
    made = {name: case() for name, case in _cases(part).items()}
    return {name: (case.physics, case.source) for name, case in made.items()}


def heading(case: str) -> str:
    """Heading of a hard case's group; empty for what is no hard case.

    Examples
    --------
    >>> heading("lifts off")
    'lift-off and other events'
    """
    record: Any = CASES.get(case) or MOTION_CASES.get(case)
    return record.group if record else ""


def _word(entry: Entry) -> str:
    if entry.mark is None:
        return ""
    if entry.mark in (Mark.DEGRADED, Mark.WRONG) and entry.digits == entry.digits:
        return f"{entry.mark.word} ({entry.digits:.0f})"
    return entry.mark.word
