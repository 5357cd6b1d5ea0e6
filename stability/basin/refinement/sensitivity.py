"""How sensitive a refined border is, as arrays and attributes of a dataset."""

from __future__ import annotations

from typing import Any

import numpy as np

from ...base.axis import Axis
from ...base.errors import ParameterError
from ...motion.result import Outcome
from ..borders import Borders, between
from ..launch_labels import FAMILIES
from ..statistics.box_counting import HALVINGS, SPAN, box_dimension, sensitive

BLOCK = "border_block"
"""Dimension of the blocks along a border."""
LEAST = HALVINGS + 1
"""Fewest halvings that tell a sensitive block: those of a local exponent, and one more."""
UNFINISHED = {o.code for o in (Outcome.MOVING, Outcome.UNDETERMINED, Outcome.UNRESOLVED)}
"""Outcomes of launches whose end is not known."""


def blocks(found: Borders, axes: tuple[Axis, Axis]) -> tuple[dict[str, Any], dict[str, Any]]:
    """The blocks of a map that hold a border, and which are sensitive.

    Parameters
    ----------
    found
        Borders of its labels.
    axes
        x and y.

    Returns
    -------
    dict, dict
        Along `border_block`: `border_block_X`, its low and high edge along each axis X,
        `border_block_exponent` and `border_sensitive`; and attributes that say what this means.
        No array where the borders have too few halvings, which the attribute says.  A block is
        open where only launches that still move at the horizon make it look sensitive.
    """
    span = min(SPAN, found.levels)
    if span < LEAST:
        few = f"not sought: sensitive parts need {LEAST} halvings, and {found.levels} are complete"
        return {}, {"border_sensitive_note": few}
    open_ = [c for c in np.unique(found.labels) if c // FAMILIES in UNFINISHED]
    local = sensitive(found, span=span, unfinished=open_)
    arrays: dict[str, Any] = {}
    for axis, index in zip(axes, local.blocks.T, strict=True):
        ends = [between(axis, (index + i) << span, found.levels) for i in (0, 1)]
        arrays[f"border_block_{axis.name}"] = (
            (BLOCK, "edge"),
            np.stack(ends, axis=-1),
            {"long_name": f"{axis.name} at the low and high edge of the block"},
        )
    arrays["border_block_exponent"] = (
        BLOCK,
        local.block_exponent,
        {"long_name": "local uncertainty exponent between the last widths", "units": "1"},
    )
    arrays["border_sensitive"] = (
        BLOCK,
        np.where(local.strips, 2, local.block_exponent < local.bound).astype(np.int8),
        {
            "long_name": "whether the block is sensitive",
            "flag_values": [0, 1, 2],
            "flag_meanings": "smooth sensitive open",
        },
    )
    return arrays, {"border_sensitive_note": local.note}


def exponent(found: Borders) -> dict[str, Any]:
    """The uncertainty exponent of a border and its confidence interval, as attributes.

    Parameters
    ----------
    found
        Borders.

    Returns
    -------
    dict
        `border_exponent`, `border_exponent_interval`, `border_exponent_level`, and
        `border_exponent_note`: how it was found, or why there is none.
    """
    try:
        known = box_dimension(found)
    except ParameterError as error:
        return {"border_exponent_note": f"none: {error}"}
    low, high = known.interval
    first, last = known.levels
    return {
        "border_exponent": float(known.exponent),
        "border_exponent_interval": [float(2 - high), float(2 - low)],
        "border_exponent_level": known.level,
        "border_exponent_note": "2 - D, with D the slope of the number of unlike neighbours (two "
        "launches side by side with different ends) over their distance, halvings "
        f"{first} to {last}; all borders together{_moving(found)}",
    }


def _moving(found: Borders) -> str:
    """The share of borders next to launches whose end is not known, for the note."""
    open_ = np.isin(found.pair_labels // FAMILIES, list(UNFINISHED)).any(axis=1)
    if not open_.any():
        return ""
    return (
        f"; {100 * open_.mean():.0f} % of the finest pairs hold a launch whose end is not known, "
        "and a longer horizon may change the exponent"
    )
