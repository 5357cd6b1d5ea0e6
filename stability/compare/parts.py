"""Parts of the report, and where routes stand in it."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from . import failures as catalogue
from .motion import dataset as motion_data
from .motion.reference_motions import scene
from .plan import SPECTRUM
from .spectrum import dataset as spectral_data

if TYPE_CHECKING:
    from matplotlib.figure import Figure


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
    """`spectrum`, `motion`, `scenes` or `failures`."""
    plates: tuple[Plate, ...]
    """Figures of the part."""
    data: tuple[str, ...]
    """Names of the files with its numbers."""
    chart: Any
    """Dataset of a chart, entries of the catalogue, or charts of scenes by name."""


# --- what the charts say ---


@dataclass(frozen=True)
class Standing:
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


def standings(one: Part) -> list[Standing]:
    """Standing of the package's default routes in every panel of a chart.

    Parameters
    ----------
    one
        The part: spectrum or motion.

    Returns
    -------
    list of Standing
    """
    found = []
    defaults = {name for name, default in catalogue.own_methods().items() if default}
    panels: list[tuple[str, Any]] = []
    if one.name == SPECTRUM:
        for quantity, text in QUANTITIES.items():
            kinds = one.chart.hardness.values.tolist()
            if quantity == "boundary":
                kinds = [""] if "boundary" in one.chart.sizes else []
            for kind in kinds:
                place = spectral_data.standing(one.chart, quantity, kind)
                panels.append((f"{text}, {kind}".rstrip(", "), place))
    else:
        for which in one.chart.scene.values.tolist():
            for metric, text in METRICS.items():
                if metric != "event" or scene(which).ends or scene(which).events:
                    place = motion_data.standing(one.chart, which, metric)
                    panels.append((f"{text}, {which}", place))
    for panel, places in panels:
        for route, place in places.items():
            if route in defaults:
                found.append(Standing(panel, route, place.on_front, place.factor, place.rival))
    return found


def nearest(found: Sequence[Standing]) -> dict[str, Standing]:
    """The default route in each panel that is on the front, or nearest to it.

    Parameters
    ----------
    found
        From `standings`.

    Returns
    -------
    dict
        By panel.
    """
    best: dict[str, Standing] = {}
    for one in found:
        if one.panel not in best or one.factor < best[one.panel].factor:
            best[one.panel] = one
    return best
