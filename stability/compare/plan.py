"""What a report asks: its parts, their tasks, and a choice of cases and methods."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence

from ..base.checks import chosen
from ..base.errors import NameUnknownError, ParameterError, shown
from ..jobs.measured_cells import Cell, Task
from . import failures as catalogue
from . import scenes
from .motion import measure as works
from .spectrum import measure as spectral

SPECTRUM, MOTION, FAILURES, SCENES = "spectrum", "motion", "failures", "scenes"
PARTS: dict[str, Callable[[], list[list[Task]]]] = {
    SPECTRUM: spectral.tasks,
    MOTION: works.tasks,
    SCENES: scenes.tasks,
    FAILURES: catalogue.tasks,
}
"""Parts of a report, each with the function that returns its tasks."""
BOUNDARY = "boundary"
"""Case of the spectrum chart next to its hardness classes."""
MANY = 20
"""Methods that a refusal has room for."""


def planned(
    parts: Sequence[str], cases: str | Sequence[str] | None, methods: str | Sequence[str] | None
) -> dict[str, list[list[Task]]]:
    """The tasks of each part that is wanted.

    Parameters
    ----------
    parts, cases, methods
        As in `report`.

    Returns
    -------
    dict
        Groups of tasks by part; parts without a task are left out.
    """
    if isinstance(parts, str) or not isinstance(parts, Sequence) or not parts:
        raise NameUnknownError(f"parts is {shown(parts)}; give a list of {', '.join(PARTS)}.")
    for name in parts:
        if not isinstance(name, str) or name not in PARTS:
            raise NameUnknownError(f"part is {shown(name)}; known are {', '.join(PARTS)}.")
    plan = {name: PARTS[name]() for name in PARTS if name in parts}
    pairs = [_pair(task) for groups in plan.values() for group in groups for task in group]
    headings = {case: catalogue.heading(case) for case, _ in pairs}
    which = headings if cases is None else chosen("case", cases, headings)
    every = dict.fromkeys(method for _, method in pairs if method)
    # a refusal has no room for the names of the whole catalogue: their first words do too
    names = {name: name.partition("-")[0] if len(every) > MANY else "" for name in every}
    who = ("", *names) if methods is None else chosen("method", methods, names)
    wanted = {pair for pair in pairs if pair[0] in which and pair[1] in who}
    if not wanted:
        raise ParameterError(
            f"case is {shown(cases)} and method is {shown(methods)}; none of these methods is "
            "asked any of these cases."
        )
    left = {
        name: [few for group in groups if (few := [t for t in group if _pair(t) in wanted])]
        for name, groups in plan.items()
    }
    return {name: groups for name, groups in left.items() if groups}


def _pair(task: Task) -> tuple[str, str]:
    """Names of a task's case and method; a scene has no method."""
    if task.key.startswith(f"{SCENES}/"):
        return task.arguments[0], ""
    case, method = (BOUNDARY, *task.arguments)[-2:]
    return case, method


def asked(groups: Sequence[Sequence[Task]], cells: Mapping[str, Cell]) -> dict[str, Cell]:
    """The cells of some tasks that have ended.

    Parameters
    ----------
    groups
        Groups of tasks.
    cells
        Cells by key.

    Returns
    -------
    dict
        Cells by key.
    """
    return {t.key: cells[t.key] for group in groups for t in group if t.key in cells}


def done(groups: Sequence[Sequence[Task]], cells: Mapping[str, Cell]) -> bool:
    """Whether the cells of all these tasks have ended.

    Parameters
    ----------
    groups
        Groups of tasks.
    cells
        Cells by key.
    """
    return all(task.key in cells for group in groups for task in group)
