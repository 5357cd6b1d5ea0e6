"""The arrays of a map or sample of launches, with units, flags and provenance."""

from __future__ import annotations

import json
import os
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import numpy as np

from ..base.axis import Axis
from ..base.checks import flag
from ..base.citation import cited
from ..base.errors import listed
from ..base.provenance import versions
from ..base.quantities import Kind
from ..base.types import Floats
from ..base.version import __version__
from ..bodies.contact_laws import Smooth
from ..bodies.disk import Disk
from ..bodies.families import FAMILIES, named_by
from ..bodies.quantities import round_quantities
from ..integrators.selection import HEYOKA, works_of
from ..jobs.chunks import Arrays, Store, Variable
from ..motion.result import CODES, Outcome, outcome_flags
from ..motion.starts import Starts
from ..storage.zarr_folder import opened_store
from ..systems.system import System
from .launches import TILT, Launches
from .outcomes import Judging, Outcomes, on_lanes

if TYPE_CHECKING:
    import xarray

FORMAT = "stability basins 1"
"""Mark of the datasets and stores of this module."""
MISSING = -1
"""Outcome of a launch that is not there yet: no flag value of an outcome."""
LIBRARIES = ("casadi", "heyoka", "numba", "numpy", "python-flint", "scipy")
"""Libraries on which the numbers depend."""
FEW = 5
"""Launches that are named in a sentence at most."""


def variables(sample: Starts) -> tuple[Variable, ...]:
    """The arrays of a result, the outcome first.

    Parameters
    ----------
    sample
        Some of the launches, for names and units.

    Returns
    -------
    tuple of Variable
    """
    body = sample.law is not None
    second, names = sample.unit("time"), sample.settling.names
    units = "1" if sample.dimensionless or not body else f"{Kind.ANGULAR_VELOCITY.si} "\
        f"(theta: {Kind.ANGLE.si})"  # fmt: skip
    known = (FAMILIES.get(n.split(" ")[0]) for n in names if body)
    own = list(dict.fromkeys(one.at[0] for one in known if one is not None))
    named = f"its {listed(own, 'or')}" if own else "the number that names it"
    flags = outcome_flags(disk=body)
    codes = np.arange(len(names) + 1, dtype=np.int8)
    meanings = " ".join(["none", *(n.replace(" ", "_") for n in names)])
    states = (("state", len(sample.model.states)),)
    number = dict.fromkeys(("units",), "1")
    return (
        Variable("outcome", "int8", MISSING, {
            "long_name": "what became of the launch",
            "flag_values": [int(v) for v in flags["flag_values"]],
            "flag_meanings": flags["flag_meanings"]}),
        Variable("end_time", "float64", np.nan, {
            "long_name": "time of the event, of the proof of settling, or the last time",
            "units": second}),
        Variable("family", "int8", MISSING, {
            "long_name": "family of the steady motion that is settled on",
            "flag_values": codes.tolist(), "flag_meanings": meanings}),
        Variable("member", "float64", np.nan, {
            "long_name": f"steady motion that is settled on: {named}", "units": units}),
        Variable("member_error", "float64", np.nan, {
            "long_name": "error of member: a proved bound for the computed state, and the "
            "estimated effect of the integration's error", "units": units}),
        Variable("error", "float64", np.nan, {
            "long_name": "estimated effect of the integration's error, dimensionless: on member "
            "where settled, on the time of an event, on the final state where moving (the largest "
            "over the states, each over 1 or its own size)"} | number),
        Variable("steps", "int32", MISSING, {"long_name": "steps of the integrator"}),
        Variable("start_state", "float64", np.nan, {
            "long_name": "state at the start", "columns": " ".join(sample.model.states)}, states,
            coordinate=True),
    )  # fmt: skip


def arrays(found: Outcomes, launches: Starts) -> dict[str, Any]:
    """Outcomes in the user's units.

    Parameters
    ----------
    found
        Outcomes, dimensionless for a body.
    launches
        The launches.

    Returns
    -------
    dict
        An array for each name in `variables`.
    """
    names = launches.settling.names
    unit = np.ones(launches.count)  # where none is settled on there is no member
    for i, name in enumerate(names):
        np.copyto(unit, launches.size(named_by(name)), where=found.family == i)
    settled = found.outcome == CODES[Outcome.SETTLED]
    off = np.where(settled & np.isfinite(found.error), found.error, 0.0)
    return {
        "outcome": found.outcome,
        "end_time": found.time * launches.size(Kind.TIME),
        "family": (found.family + 1).astype(np.int8),
        "member": found.member * unit,
        "member_error": (found.member_error + off) * unit,
        "error": found.error,
        "steps": found.steps.astype(np.int32),
        "start_state": given_states(launches),
    }


def given_states(launches: Starts) -> Floats:
    """The states at the starts in the user's units, shape (N, s)."""
    states = launches.starts.copy()
    if launches.law is not None and not launches.dimensionless:
        for column, name in enumerate(launches.model.states):
            states[:, column] *= launches.size(launches.model.quantities[name].kind)
    return states


def blank(count: int, states: int) -> Arrays:
    """Arrays of launches that ended their worker: *unresolved*.

    Parameters
    ----------
    count
        Number of launches.
    states
        Number of states of each.
    """
    nan = np.full(count, np.nan)
    return {
        "outcome": np.full(count, CODES[Outcome.UNRESOLVED], dtype=np.int8),
        "end_time": nan, "family": np.zeros(count, dtype=np.int8), "member": nan,
        "member_error": nan, "error": nan, "steps": np.zeros(count, dtype=np.int32),
        "start_state": np.full((count, states), np.nan),
    }  # fmt: skip


def lost(kept: Store) -> tuple[int, ...]:
    """Numbers of the launches that ended their worker, row-major: *unresolved*, without a start.

    Parameters
    ----------
    kept
        The store of a call.  It is read chunk by chunk, and starts only where a chunk needs it.
    """
    there, layout = kept.dataset(), kept.layout
    found: list[int] = []
    for block in layout.blocks():
        where = dict(zip(layout.dims, layout.slices(block), strict=True))
        open_ = there.outcome.isel(where).values.ravel() == CODES[Outcome.UNRESOLVED]
        if open_.any():
            starts = there.start_state.isel(where).values
            bare = np.isnan(starts).all(axis=-1).ravel()
            found += [layout.number(block, int(i)) for i in np.flatnonzero(open_ & bare)]
    return tuple(sorted(found))


def told_of_lost(numbers: tuple[int, ...]) -> str:
    """A sentence about launches that ended their worker; empty without one.

    Examples
    --------
    >>> told_of_lost((17,))
    'launch 17 ended its worker and is unresolved'
    >>> told_of_lost((3, 17))
    'launches 3 and 17 ended their workers and are unresolved'
    """
    if not numbers:
        return ""
    if len(numbers) == 1:
        return f"launch {numbers[0]} ended its worker and is unresolved"
    some = listed([str(n) for n in numbers[:FEW]])
    if len(numbers) > FEW:
        some = f"{', '.join(map(str, numbers[:FEW]))} and {len(numbers) - FEW} more"
    return f"launches {some} ended their workers and are unresolved"


def coordinates(launches: Launches, sample: Starts, axes: tuple[Axis, ...]) -> dict[str, Any]:
    """The values along the axes, and the numbers that are held.

    Parameters
    ----------
    launches
        What is launched.
    sample
        Some of the launches, for names and units.
    axes
        The axes of a map, the slowest first; none for a sample.
    """
    found: dict[str, Any] = {
        a.name: (a.name, a.values, label(launches, sample, a.name)) for a in axes
    }
    for name, value in launches.held.items():
        found[name] = ((), float(value), label(launches, sample, name))
    return found


def label(launches: Launches, sample: Starts, name: str) -> dict[str, str]:
    """Name in words and units of a number that varies or is held."""
    if name == TILT:
        return {"long_name": "tilt from the steady motion", "units": Kind.ANGLE.si}
    if isinstance(launches.thing, System):
        return sample.model.attributes(name, dimensionless=True)
    if name == launches.own and name not in sample.model.quantities:  # of no state of the angles
        own = round_quantities("", Smooth, (), (name,))[name]
        return own.attributes(dimensionless=sample.dimensionless)
    return sample.model.attributes(name, dimensionless=sample.dimensionless)


def attributes(
    launches: Launches, sample: Starts, horizon: float, judging: Judging, more: Mapping[str, Any]
) -> dict[str, Any]:
    """Provenance, without a date: two runs of one question give the same bytes.

    Parameters
    ----------
    launches, sample, horizon, judging
        What is launched, some of it, until when, and how.
    more
        Further attributes, such as the seed of a sample.
    """
    found: dict[str, Any] = {
        "format": FORMAT,
        "title": f"outcomes of launches: {sample.model.title}",
        "horizon": horizon,
        "tolerance": judging.tolerance,
        "checked": int(judging.check),
        "settle": judging.settle,
        "software": f"stability {__version__}",
        "versions": versions(LIBRARIES),
        "source": sample.model.source,
        "Conventions": "CF-1.11",
    }
    if isinstance(launches.thing, System):
        found["system"] = launches.thing.name
    else:
        assert launches.contact is not None
        swept = set(launches.varied) | set(launches.held)
        thing = launches.thing
        numbers = thing.given if not isinstance(thing, Disk) else {
            n: getattr(thing, n) for n in ("k", "mass", "radius", "gravity")}  # fmt: skip
        fixed = {n: float(v) for n, v in {**numbers, **launches.contact.given}.items()
                 if n not in swept and np.ndim(v) == 0}  # fmt: skip
        found |= {
            "body": "disk" if isinstance(thing, Disk) else thing.name,
            "contact": launches.contact.name, "flat": judging.flat,
            "dimensionless": int(sample.dimensionless),
            "parameters": json.dumps(fixed, sort_keys=True),
        }  # fmt: skip
        if launches.family:
            found["launched_near"] = launches.near
    return found | dict(more)


def works(launches: Launches, sample: Starts, *, linear: bool) -> str:
    """Keys of the works to cite: the model, the integrator of the lanes, and the linear verdict.

    Parameters
    ----------
    launches, sample
        What is launched, and some of it.
    linear
        Whether there is the linear verdict of the steady motions, whose changes are proved.
    """
    return cited(
        launches.contact.name if launches.contact is not None else None,
        model=launches.contact is not None, eigenvalues=linear, proofs=linear,
        methods=works_of([HEYOKA] if on_lanes(sample) else ()),
    )  # fmt: skip


def question(
    launches: Launches, sample: Starts, horizon: float, judging: Judging, more: Mapping[str, Any]
) -> dict[str, Any]:
    """Everything that the numbers depend on, for the fingerprint of a store."""
    return attributes(launches, sample, horizon, judging, more) | {
        "graph": str(sample.model.rhs), "varied": list(launches.varied),
        "held": dict(launches.held), "flat": judging.flat, "most": judging.most,
        "families": [f"{f.name} {f.held} {f.unknown}" for f in launches.families],
    }  # fmt: skip


def read_basins(path: str | os.PathLike[str], *, lazy: bool = False) -> xarray.Dataset:
    """Read a complete store of launches that `basins` wrote, every chunk by its checksum.

    Parameters
    ----------
    path
        Folder of the store.
    lazy
        Whether to leave the data in the folder until it is used; a damaged chunk is refused then.

    Returns
    -------
    xarray.Dataset
        As `basins` returned it.

    Raises
    ------
    FileError
        If there is no such store, or it is damaged or not complete; the same call of `basins`
        computes what is missing or damaged.

    Source: Zarr core specification, version 3, with checksums of this package:
    tests/faults/test_damaged_stores.py.

    Examples
    --------
    >>> import tempfile, stability as st
    >>> from pathlib import Path
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     found = st.basins(contact="viscous", mu=0.3, x=("omega3", 1, 3, 2),
    ...                       y=("theta", 1.2, 1.5, 2), horizon=5.0, store=Path(folder) / "a.zarr")
    ...     st.read_basins(Path(folder) / "a.zarr").outcome.shape
    (2, 2)
    """
    return opened_store(path, FORMAT, "a store of launches", lazy=flag("lazy", lazy))
