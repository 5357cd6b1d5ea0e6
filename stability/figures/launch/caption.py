"""Caption of the figure of one motion."""

from __future__ import annotations

from ..styled_figure import fixed  # isort: skip

import json
from collections.abc import Mapping
from typing import TYPE_CHECKING

import numpy as np

from ...base.quantities import Kind, Quantity, readable
from ...bodies.newton_euler import STATES
from ...bodies.quantities import SYSTEM, quantities_of
from ...motion.result import BY_CODE
from .single_run import one_launch, system_states

if TYPE_CHECKING:
    import xarray


def caption(dataset: xarray.Dataset) -> str:
    """The computation and its outcome, in two sentences.

    Parameters
    ----------
    dataset
        From `simulate`, one launch.

    Returns
    -------
    str
        Body, contact law, span of time, method, tolerance; outcome and evidence.

    Raises
    ------
    ParameterError
        If the dataset holds several launches or lacks a series.

    Examples
    --------
    >>> import stability as st
    >>> run = st.simulate(st.Disk(), st.Smooth(), {"theta": 1.0}, 5.0)
    >>> caption(run).split("  ")[1].split(",")[0]
    'Outcome: flat'
    """
    if names := system_states(dataset):
        return _of_system(dataset, names)
    needed = (*STATES, "outcome", "evidence", "end_time", "energy_error", "method")
    motion = one_launch(dataset, needed)
    data, plain = motion.data, bool(dataset.attrs.get("dimensionless", 0))
    law = str(dataset.attrs.get("contact", ""))
    second = f" {Kind.TIME.label(dimensionless=plain)}"
    given = [
        f"{q.symbol} = {float(data[name]):.4g}{'' if plain else q.kind.suffix}"
        for name, q in _quantities(dataset).items()
        if name in data.coords and not data[name].ndim
    ]
    units = {n: "" if plain else f" {readable(data[n].attrs['units'])}" for n in STATES}
    start = [f"{name} = {float(data[name][0]):.4g}{units[name]}" for name in STATES]
    return (
        f"Motion of {_body_of(dataset)} with {law} contact "
        f"({', '.join(given)}{', dimensionless' if plain else ''}) from {', '.join(start)} at time "
        f"{motion.times[0]:.4g} to {motion.times[-1]:.4g}{second}, by {data.method.item()} at "
        f"tolerance {tolerance_of(dataset):.3g}; the energy audit closes to "
        f"{float(data.energy_error):.1g} of the initial energy.  "
        f"Outcome: {BY_CODE[int(data.outcome)].word}, at time {float(data.end_time):.4g}{second} "
        f"({data.evidence.item()})."
    )


def _body_of(dataset: xarray.Dataset) -> str:
    name = str(dataset.attrs.get("body", "disk"))
    return f"{'an' if name[0] in 'aeiou' else 'a'} {name}"


def _quantities(dataset: xarray.Dataset) -> Mapping[str, Quantity]:
    """The quantities of a motion; those that a body adds to the disk's are named as it names them.

    The number of a launch is none of them.
    """
    known = quantities_of(SYSTEM + str(dataset.attrs.get("contact", "")))
    if "body" not in dataset.attrs:
        return known
    own = {
        str(n): Quantity(str(n), str(n), str(n), Kind.NUMBER)
        for n in dataset.coords
        if n not in known and n not in ("time", "number", "length")
    }
    if not dataset.attrs.get("dimensionless", 0):
        own |= {"length": Quantity("length", "L", "length", Kind.LENGTH)}
    return own | dict(known)


def _of_system(dataset: xarray.Dataset, names: tuple[str, ...]) -> str:
    """The caption of a user's system."""
    motion = one_launch(dataset, names)
    data = motion.data

    def value(name: str) -> str:
        unit = str(data[name].attrs.get("units", "1"))
        number = f"{name} = {float(data[name].values.flat[0]):.4g}"
        return number if unit == "1" else f"{number} {readable(unit)}"

    second = f" {u}" if (u := data.time.attrs["units"]) != "1" else ""
    given = ", ".join(value(n) for n in json.loads(dataset.attrs.get("parameters", "{}")))
    account = ""
    if "energy_error" in data:
        account = f"; the energy audit closes to {float(data.energy_error):.1g} of the energy"
    return (
        f"Motion of {dataset.attrs['system']}{f' ({given})' if given else ''} from "
        f"{', '.join(map(value, names))} at time {motion.times[0]:.4g} to "
        f"{motion.times[-1]:.4g}{second}, by {data.method.item()} at tolerance "
        f"{tolerance_of(dataset):.3g}{account}.  Outcome: {BY_CODE[int(data.outcome)].word}, at "
        f"time {float(data.end_time):.4g}{second} ({data.evidence.item()})."
    )


def tolerance_of(dataset: xarray.Dataset) -> float:
    """The tolerance that the integrator was given."""
    return float(dataset.attrs.get("tolerance_used", dataset.attrs.get("tolerance", np.nan)))


def fixed_of(dataset: xarray.Dataset) -> str:
    """The parameters of a motion, for the note of its figure."""
    if system_states(dataset):
        names = json.loads(dataset.attrs.get("parameters", "{}"))
        values = {n: dataset[n].values.flat[0] for n in names if n in dataset}
        return fixed(values, {}, {n: str(dataset[n].attrs.get("units", "1")) for n in values})
    law = str(dataset.attrs.get("contact", ""))
    known = _quantities(dataset)
    values = {n: dataset[n].item() for n in known if n in dataset.coords and not dataset[n].ndim}
    values.pop("time", None)
    return fixed(
        values, known, {}, law=law, dimensionless=bool(dataset.attrs.get("dimensionless", 0))
    )
