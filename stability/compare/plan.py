"""What a report asks and has: its parts, their tasks, and where routes stand in them."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from ..base.checks import chosen
from ..base.errors import NameUnknownError, ParameterError, shown
from ..jobs.measured_cells import Cell, Task
from . import calls, scenes
from . import failures as catalogue
from .motion import chart as motion_chart
from .motion.reference_motions import scene
from .spectrum import chart as spectrum_chart

if TYPE_CHECKING:
    from matplotlib.figure import Figure

SPECTRUM, MOTION, FAILURES, SCENES = "spectrum", "motion", "failures", "scenes"
CALLS = "calls"
PARTS: dict[str, Callable[[], list[list[Task]]]] = {
    SPECTRUM: spectrum_chart.tasks,
    MOTION: motion_chart.tasks,
    CALLS: calls.tasks,
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

    Returns
    -------
    dict
        Cells by key.
    """
    return {t.key: cells[t.key] for group in groups for t in group if t.key in cells}


def done(groups: Sequence[Sequence[Task]], cells: Mapping[str, Cell]) -> bool:
    """Whether the cells of all these tasks have ended."""
    return all(task.key in cells for group in groups for task in group)


# --- what is shown ---


METRICS = {
    "path": "the whole path",
    "final": "the last state",
    "audit": "the energy account",
    "event": "the time of the end or of the events",
}
"""Errors of motions, in words."""

QUANTITIES = {
    "eigenvalues": "eigenvalues",
    "abscissa": "the abscissa",
    "verdict": "verdicts",
    "boundary": "places of boundaries",
}
"""Quantities of the spectrum chart, in words."""


@dataclass(frozen=True)
class Plate:
    """One figure of a report."""

    stem: str
    """File name without suffix."""
    caption: str
    """Caption under the figure."""
    draw: Callable[[], Figure]
    """Function that draws the figure."""


@dataclass(frozen=True)
class Part:
    """One complete part of a report."""

    name: str
    """`spectrum`, `motion`, `calls`, `scenes` or `failures`."""
    plates: tuple[Plate, ...]
    """Figures of the part."""
    data: Mapping[str, Callable[[], Any]]
    """Files with its numbers: what each holds, by name."""
    chart: Any
    """Dataset of a chart, rows of calls, entries of the catalogue, or charts of scenes by name."""


# --- what the charts say ---


@dataclass(frozen=True)
class RouteStanding:
    """Standing of a default route of the package in a panel."""

    panel: str
    """Quantity and hardness class, or error and scene."""
    route: str
    """Name of the route."""
    on_front: bool
    """Whether it is on the Pareto front."""
    factor: float
    """Time over that of the fastest route that is at least as accurate."""
    rival: str
    """Name of that fastest route."""


def standings(part: Part) -> list[RouteStanding]:
    """Standing of the package's default routes in every panel of a chart."""
    rows = []
    defaults = catalogue.defaults()
    panels: list[tuple[str, Any]] = []
    if part.name == SPECTRUM:
        for quantity, text in QUANTITIES.items():
            kinds = part.chart.hardness.values.tolist()
            if quantity == "boundary":
                kinds = [""] if "boundary" in part.chart.sizes else []
            for kind in kinds:
                place = spectrum_chart.standing(part.chart, quantity, kind)
                panels.append((f"{text}, {kind}".rstrip(", "), place))
    else:
        for which in part.chart.scene.values.tolist():
            for metric, text in METRICS.items():
                if metric != "event" or scene(which).ends or scene(which).events:
                    place = motion_chart.standing(part.chart, which, metric)
                    panels.append((f"{text}, {which}", place))
    for panel, places in panels:
        for route, place in places.items():
            if route in defaults:
                rows.append(RouteStanding(panel, route, place.on_front, place.factor, place.rival))
    return rows


def nearest(rows: Sequence[RouteStanding]) -> dict[str, RouteStanding]:
    """The default route in each panel that is on the front, or nearest to it.

    Returns
    -------
    dict
        By panel.
    """
    best: dict[str, RouteStanding] = {}
    for row in rows:
        if row.panel not in best or row.factor < best[row.panel].factor:
            best[row.panel] = row
    return best
