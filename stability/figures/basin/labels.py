"""Words of a basin diagram: labels of its axes and scales, and the numbers that it holds."""

from __future__ import annotations

from ..styled_figure import fixed, wide  # isort: skip

import json
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import numpy as np

from ...base.quantities import Kind, Quantity, axis_label, in_latex, readable, unit_of
from ...bodies.contact_laws import MOTION_LAWS
from ...bodies.families import FAMILIES
from ...bodies.quantities import disk_quantities, round_quantities
from ...bodies.round_body.pole_equations import TURN
from ...bodies.round_body.shape import MOMENTS, SCALES

if TYPE_CHECKING:
    import xarray


def even_ratios(values: Any) -> bool:
    """Whether values are on a logarithmic axis.

    Examples
    --------
    >>> even_ratios(np.geomspace(0.1, 10, 5)), even_ratios(np.linspace(0.1, 10, 5))
    (True, False)
    """
    if len(values) < 3 or values[0] * values[-1] <= 0 or (values == 0).any():
        return False
    ratios = values[1:] / values[:-1]
    return bool(np.ptp(ratios) < 1e-9 * abs(ratios[0] - 1))


def _quantities(dataset: xarray.Dataset) -> Mapping[str, Quantity]:
    """Quantities by name; none of a user's system, whose `theta` may be anything."""
    told = dataset.attrs
    if "system" in told:
        return {}
    law = MOTION_LAWS.get(str(told["contact"]))
    known = dict(disk_quantities(law))
    body = str(told.get("body", "disk"))
    if law is not None and body != "disk":
        own = {*json.loads(told.get("parameters", "{}")), *map(str, dataset.coords)}
        shape = own - set(known) - {*MOMENTS, *SCALES, *TURN}
        known |= round_quantities(body, law, sorted(shape), sorted({*own, *TURN}))
    return known | {"tilt": Quantity("tilt", "", "tilt from the steady motion", Kind.ANGLE)}


def label(dataset: xarray.Dataset, name: str) -> str:
    """A number in words, with its symbol and unit.

    Parameters
    ----------
    dataset
        What `basins` returns.
    name
        Name of a coordinate or variable.
    """
    if name == "end_time":  # its long name says what an end is
        return axis_label(
            Quantity(name, "", "time of the end", Kind.TIME), name, unit_of(dataset[name].attrs)
        )
    return axis_label(_quantities(dataset).get(name), name, unit_of(dataset[name].attrs))


def member_label(dataset: xarray.Dataset, family: str, room: float) -> str:
    """What names the members of a family, with its unit; the family alone where it is not known.

    Parameters
    ----------
    dataset
        What `basins` returns.
    family
        Name of the family, which may be followed by its place: vertical at theta = 0.
    room
        Width [pt]; a longer label is left without the family, which colour and hatching tell.
    """
    record = FAMILIES.get(family.split(" ")[0])
    if record is None or "system" in dataset.attrs:
        return family
    own = _quantities(dataset)[record.at[0]]
    unit = in_latex(own.kind.label(dimensionless=bool(dataset.attrs.get("dimensionless", 0))))
    bare = own.typeset + f" [{unit}]" * bool(unit)
    whole = f"{family} {bare}"
    return whole if wide(whole) <= room else bare


def fixed_numbers(dataset: xarray.Dataset) -> str:
    """The numbers that the axes do not show.

    Parameters
    ----------
    dataset
        What `basins` returns.
    """
    told = dataset.attrs
    held = {str(n): float(c) for n, c in dataset.coords.items() if c.ndim == 0}
    values = json.loads(told.get("parameters", "{}")) | held
    units = {n: unit_of(dataset[n].attrs) for n in held}
    plain = bool(told.get("dimensionless", 0))
    known = _quantities(dataset)
    law = str(told.get("contact", ""))
    text = fixed(values, known, units, law=law, dimensionless=plain)
    if str(told.get("body", "disk")) != "disk":
        text = f"{told['body']}, {text}"
    unit = unit_of(dataset.end_time.attrs)
    if known:
        unit = known["time"].kind.label(dimensionless=plain)
    # a root in mathematics would be taller than a line of the note
    last = f"$t$ = {float(told['horizon']):g} {readable(unit)}".removesuffix(" 1")
    near = f"launched near {told['launched_near']}, " if "launched_near" in told else ""
    return f"{near}{text}, until {last}" if text else f"{near}until {last}"
