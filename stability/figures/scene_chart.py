"""The chart of a scene: cost against true error of every model, and which one answers."""

from __future__ import annotations

from .styled_figure import drawing, entry, fixed, key, note, settle  # isort: skip

import json
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch
from matplotlib.ticker import LogLocator, NullFormatter, NullLocator

from ..base.errors import ParameterError, shown
from ..base.looks import BLUE, GREEN, PURPLE, VERMILION
from ..bodies.quantities import SYSTEM, quantities_of
from .letters import SMALL, Letter, letters

if TYPE_CHECKING:
    import xarray

ASPECT = 1.1
"""Height of the figure over its width."""
LOWEST = 1e-16
"""Smallest error that is drawn."""
NEAR = 0.1
"""Least distance of two words at the right of the panel, over its height."""
LOOKS: dict[str, dict[str, Any]] = {
    "closed form": {"marker": "o", "color": BLUE, "ms": 5},
    "reduced model": {"marker": "p", "color": PURPLE, "ms": 5.6},
    "creep": {"marker": "^", "color": GREEN, "ms": 5.4},
    "full model": {"marker": "s", "color": "#000000", "ms": 4.8},
    "other law": {"marker": "D", "color": VERMILION, "ms": 4.4, "mfc": "white"},
}
"""Shape and colour of each kind of model."""
MARK = 5.4
"""Half the size of a mark with its ring, for the labels [pt]."""
RING: dict[str, Any] = {"marker": "o", "ms": 9.8, "mfc": "none", "mec": "#000000", "mew": 1.0}
"""Ring about the model that is chosen."""
WHOLE: dict[str, Any] = {"color": "#555555", "lw": 0.8, "marker": "|", "ms": 6, "mew": 0.9}
"""Line from the model that is chosen to the time of the answer."""
BAND, ALLOWED = "#F0E442", "#56565b"
"""Colours of the spread and of the tolerance."""


def scene_figure(dataset: xarray.Dataset) -> Figure:
    """Cost against true error, a mark for each model of a scene.

    Parameters
    ----------
    dataset
        From `stability.scene.chart.chart`.

    Returns
    -------
    Figure
        A journal column wide.  The model that is chosen has a ring; the tolerance is a line, the
        spread by the uncertain inputs a band; below stand parameters, start and horizon, and which
        models have no mark.

    Raises
    ------
    ParameterError
        If the dataset is no chart of a scene.
    """
    _check(dataset)
    with drawing(None, None, None, lambda width: ASPECT * width) as figure:
        axes = figure.subplots()
        _limits(axes, dataset)
        axes.set_xlabel("time of a run, with the estimate of its error [s]")
        axes.set_ylabel("true error of the states")
        _lines(axes, dataset)
        settle(figure)
        key(axes, _handles(dataset))
        note(axes, "\n".join(_note(dataset)))
        settle(figure)
        _marks(axes, dataset)
    return figure


def _check(dataset: Any) -> None:
    attributes = getattr(dataset, "attrs", {})
    if not str(attributes.get("format", "")).startswith("stability chart scene"):
        raise ParameterError(f"dataset is {shown(dataset)}; give what scene.chart.chart returns.")


def scene_caption(dataset: xarray.Dataset) -> str:
    """What a chart of a scene shows, in sentences.

    Parameters
    ----------
    dataset
        From `stability.scene.chart.chart`.

    Returns
    -------
    str
        Law, start, horizon; what is plotted; what is not, and why.

    Raises
    ------
    ParameterError
        If the dataset is no chart of a scene.
    """
    _check(dataset)
    attrs, unit = dataset.attrs, dataset.attrs["time_unit"]
    held, start = (
        ", ".join(f"{n} = {v:.4g}" for n, v in json.loads(attrs[key]).items() if v)
        for key in ("parameters", "start")
    )
    horizon = f"{attrs['horizon']:g} {'' if unit == '1' else unit}".rstrip()
    held += ", SI units" if unit == "s" else ""
    parts = [
        f"Models of the motion by the law {attrs['law']} ({held}), from {start or 'rest'}, horizon "
        f"{horizon}, tolerance {float(dataset.tolerance):g}.",
        f"Time: the least of {dataset.sizes['repeat']} or fewer repeats. Error: the "
        f"{dataset.true_error.attrs['long_name']}; the truth is {attrs['truth']}, with an error of "
        f"about {float(dataset.truth_error):.1g}.",
    ]
    if np.isfinite(dataset.spread):
        parts.append(f"Inputs are uncertain by {attrs['uncertain']}.")
    ends = _named(dataset, np.isinf(dataset.true_error.values))
    if ends:
        parts.append(f"They end in another way: {', '.join(ends)}.")
    out = _named(dataset, np.isnan(dataset.true_error.values))
    if out:
        parts.append(f"Without an answer here: {', '.join(out)}.")
    parts.append(f"Stability {attrs['stability_version']}, {attrs['created'][:10]}.")
    return " ".join(parts)


def _note(dataset: xarray.Dataset) -> list[str]:
    """What is fixed in a chart, where it starts, and which models have no mark."""
    attributes, plain = dataset.attrs, dataset.attrs["time_unit"] == "1"
    law, start = str(attributes["law"]), json.loads(attributes["start"])
    quantities = quantities_of(SYSTEM + law) if attributes["title"].startswith(OF_DISK) else {}
    parameters = fixed(
        json.loads(attributes["parameters"]),
        quantities,
        {},
        dimensionless=plain,
        law=law if quantities else "",
    )
    moving = fixed({n: v for n, v in start.items() if v}, quantities, {}, dimensionless=plain)
    last = fixed(
        {"time": attributes["horizon"]},
        quantities,
        {"time": attributes["time_unit"]},
        dimensionless=plain,
    )
    lines = [parameters or law, f"start: {moving or 'rest'}, horizon {last.partition(' = ')[2]}"]
    for words, where in (("end in another way", np.isinf), ("no answer", np.isnan)):
        if names := _named(dataset, where(dataset.true_error.values)):
            lines.append(f"{words}: {', '.join(names)}")
    return lines


OF_DISK = "models of motion of a disk, "
"""Start of the title of a chart of a disk."""


def _named(dataset: xarray.Dataset, where: Any) -> list[str]:
    """Labels of some models."""
    return [_label(row) for row in _rows(dataset, where)]


def _rows(dataset: xarray.Dataset, where: Any) -> list[Any]:
    return [dataset.isel(model=i) for i in np.flatnonzero(where)]


def _label(row: xarray.Dataset) -> str:
    """Name of a model in the figure."""
    name, kind = str(row.model.values), str(row.kind.values)
    if kind == "creep" and name == "rough":
        return "rough, creep-0"
    law, comma, rest = name.partition(", mu = ")
    return f"{law} (μ = {rest})" if comma else name


def _limits(axes: Axes, dataset: xarray.Dataset) -> None:
    """Log axes that hold every mark, the tolerance and the spread."""
    times, errors = _spots(dataset)
    levels = [float(v) for v in (dataset.tolerance, dataset.spread) if np.isfinite(v)]
    high = max([*errors, *levels])
    low = max(min([*errors, *levels]), LOWEST)
    times = [*times, float(dataset.answer_cost)]
    axes.set(xscale="log", yscale="log", ylim=(low / 12, high * 12),
             xlim=(min(times) / 2.2, max(times) * 3))  # fmt: skip  # most labels are at the right
    decades = np.log10(axes.get_xlim()[1] / axes.get_xlim()[0])
    axes.xaxis.set_major_locator(LogLocator(10, (1.0,) if decades > 2 else (1.0, 2.0, 5.0)))
    axes.xaxis.set_minor_locator(NullLocator())
    if decades <= 2:
        axes.xaxis.set_major_formatter(lambda value, _: f"{value:g}")
    axes.yaxis.set_minor_locator(LogLocator(10, (1.0,), numticks=40))
    axes.yaxis.set_minor_formatter(NullFormatter())
    axes.grid(True, linewidth=0.3, color="#dddddd")
    axes.set_axisbelow(True)


def _spots(dataset: xarray.Dataset) -> tuple[Any, Any]:
    """Times and errors of the models that have a mark."""
    drawn = np.isfinite(dataset.true_error.values) & np.isfinite(dataset.cost.values)
    errors = np.maximum(dataset.true_error.values[drawn], LOWEST)
    return dataset.cost.values[drawn], errors


def _lines(axes: Axes, dataset: xarray.Dataset) -> None:
    """The tolerance and the spread, with words at the right of the panel."""
    tolerance, spread = float(dataset.tolerance), float(dataset.spread)
    axes.axhline(tolerance, color=ALLOWED, linewidth=1.0, linestyle=(0, (4, 2)), zorder=1.6)
    words = [(tolerance, f"tolerance\n{tolerance:.3g}", ALLOWED)]
    if np.isfinite(spread) and spread > 0:
        axes.axhspan(axes.get_ylim()[0], spread, facecolor=BAND, alpha=0.28, linewidth=0, zorder=0)
        words.append((spread, f"spread\n{spread:.2g}", "#6b6200"))
    places = _apart([float(axes.transScale.transform((1, v))[1]) for v, _, _ in words], axes)
    for place, (value, word, colour) in zip(places, words, strict=True):
        axes.annotate(
            word,
            (1.0, value),
            (1.02, place),
            xycoords=axes.get_yaxis_transform(),
            textcoords="axes fraction",
            fontsize=SMALL,
            color=colour,
            va="center",
            linespacing=1.0,
            annotation_clip=False,
        )


def _apart(heights: Sequence[float], axes: Axes) -> list[float]:
    """Places of words over the height of the panel, moved apart where they would overlap."""
    low, high = (float(axes.transScale.transform((1, v))[1]) for v in axes.get_ylim())
    places = [(h - low) / (high - low) for h in heights]
    if len(places) > 1 and abs(places[0] - places[1]) < NEAR:
        middle, up = sum(places) / 2, 1 if places[0] >= places[1] else -1
        places = [middle + up * NEAR / 2, middle - up * NEAR / 2]
    return places


def _marks(axes: Axes, dataset: xarray.Dataset) -> None:
    """A mark and a label for each model; a line through the orders of creep."""
    finite = np.isfinite(dataset.true_error.values) & np.isfinite(dataset.cost.values)
    creep = dataset.isel(model=finite & (dataset.kind.values == "creep"))
    axes.plot(
        creep.cost.values,
        np.maximum(creep.true_error.values, LOWEST),
        linewidth=0.7,
        color=LOOKS["creep"]["color"],
        alpha=0.5,
        zorder=2,
    )
    written = []
    for row in _rows(dataset, finite):
        x, y = float(row.cost), max(float(row.true_error), LOWEST)
        look = LOOKS[str(row.kind.values)]
        text = _label(row)
        if bool(row.chosen):
            axes.plot([x, float(dataset.answer_cost)], [y, y], zorder=2.5, markevery=[1], **WHOLE)
            axes.plot([x], [y], linestyle="", zorder=4, **RING)
            text += ", chosen"
        axes.plot([x], [y], linestyle="", zorder=3.5, mew=1.0, **look)
        written.append(Letter(x, y, text, look["color"]))
    letters(axes, written, MARK)


def _handles(dataset: xarray.Dataset) -> list[Any]:
    """The key: kinds that have a mark, the ring, the time of the answer, the band."""
    finite = np.isfinite(dataset.true_error.values)
    there = set(dataset.kind.values[finite].tolist())
    handles: list[Any] = [
        entry(kind, linestyle="", mew=1.0, **look) for kind, look in LOOKS.items() if kind in there
    ]
    handles.append(entry("chosen for the answer", linestyle="", **RING | {"ms": 7.5}))
    handles.append(Line2D([0], [0], label="time of the whole answer", **WHOLE))
    if np.isfinite(dataset.spread):
        handles.append(Patch(facecolor=BAND, alpha=0.28, label="below the spread by inputs"))
    return handles
