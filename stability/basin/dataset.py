"""The arrays of a map or sample of launches, with units, flags and provenance."""

from __future__ import annotations

import os
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import numpy as np

from ..base.axis import Axis
from ..base.checks import flag
from ..base.errors import listed
from ..base.provenance import versions
from ..base.quantities import Kind
from ..base.version import __version__
from ..bodies.families import named_by
from ..integrators.selection import HEYOKA, works_of
from ..motion.result import CODES, Outcome, outcome_flags
from ..motion.starts import Starts
from ..storage.chunks import Arrays, Store, Variable
from ..storage.datasets import read_dataset
from ..storage.formats import ZARR
from .launches import Launches
from .outcomes import Outcomes, on_lanes

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
    second, names = sample.unit("time"), sample.settling.names
    member, units = (sample.subject.member[n] for n in ("long_name", "units"))
    flags = outcome_flags(sample.subject.outcomes)
    meanings = " ".join(["none", *(n.replace(" ", "_") for n in names)])
    codes = {"flag_values": list(range(len(names) + 1)), "flag_meanings": meanings}
    flags["flag_values"] = flags["flag_values"].tolist()

    def number(name: str, words: str, unit: str) -> Variable:
        return Variable(name, "float64", np.nan, {"long_name": words, "units": unit})

    return (
        Variable("outcome", "int8", MISSING, {"long_name": "what became of the launch"} | flags),
        number("end_time", "time of the event, of the proof of settling, or the last time", second),
        Variable(
            "family",
            "int8",
            MISSING,
            {"long_name": "family of the steady motion that is settled on"} | codes,
        ),
        number("member", f"steady motion that is settled on: {member}", units),
        number(
            "member_error",
            "error of member: a proved bound for the computed state, and the estimated effect of "
            "the integration's error",
            units,
        ),
        number(
            "error",
            "estimated effect of the integration's error, dimensionless: on member where settled, "
            "on the time of an event, on the final state where moving (the largest over the "
            "states, each over 1 or its own size)",
            "1",
        ),
        Variable("steps", "int32", MISSING, {"long_name": "steps of the integrator"}),
        Variable(
            "start_state",
            "float64",
            np.nan,
            {"long_name": "state at the start", "columns": " ".join(sample.model.states)},
            (("state", len(sample.model.states)),),
            coordinate=True,
        ),
    )


def arrays(outcomes: Outcomes, launches: Starts) -> dict[str, Any]:
    """Outcomes in the user's units.

    Parameters
    ----------
    outcomes
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
        np.copyto(unit, launches.size(named_by(name)), where=outcomes.family == i)
    settled = outcomes.outcome == CODES[Outcome.SETTLED]
    off = np.where(settled & np.isfinite(outcomes.error), outcomes.error, 0.0)
    return {
        "outcome": outcomes.outcome,
        "end_time": outcomes.time * launches.size(Kind.TIME),
        "family": (outcomes.family + 1).astype(np.int8),
        "member": outcomes.member * unit,
        "member_error": (outcomes.member_error + off) * unit,
        "error": outcomes.error,
        "steps": outcomes.steps.astype(np.int32),
        "start_state": launches.states_in_units(launches.starts),
    }


def blank(arrays: tuple[Variable, ...], count: int) -> Arrays:
    """Arrays of launches that ended their worker: *unresolved*.

    Parameters
    ----------
    arrays
        Those of a result.
    count
        Number of launches.
    """
    values = {"outcome": CODES[Outcome.UNRESOLVED], "family": 0, "steps": 0}
    return {
        v.name: np.full((count, *(n for _, n in v.more)), values.get(v.name, v.fill), v.dtype)
        for v in arrays
    }


def lost(kept: Store) -> tuple[int, ...]:
    """Numbers of the launches that ended their worker, row-major: *unresolved*, without a start.

    Parameters
    ----------
    kept
        The store of a call.  It is read chunk by chunk, and starts only where a chunk needs it.
    """
    there, layout = kept.dataset(), kept.layout
    numbers: list[int] = []
    for block in layout.blocks():
        where = dict(zip(layout.dims, layout.slices(block), strict=True))
        open_ = there.outcome.isel(where).values.ravel() == CODES[Outcome.UNRESOLVED]
        if open_.any():
            starts = there.start_state.isel(where).values
            bare = np.isnan(starts).all(axis=-1).ravel()
            numbers += [layout.number(block, int(i)) for i in np.flatnonzero(open_ & bare)]
    return tuple(sorted(numbers))


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
    coords: dict[str, Any] = {
        name: (a.name, a.values, launches.label(sample, a.name))
        for a in axes
        for name in ((a.name, "at") if a.name == getattr(launches, "own", "") else (a.name,))
    }
    for name, value in launches.held.items():
        coords[name] = ((), float(value), launches.label(sample, name))
    return coords


def attributes(launches: Launches, sample: Starts, more: Mapping[str, Any]) -> dict[str, Any]:
    """Provenance, without a date: two runs of one question give the same bytes.

    Parameters
    ----------
    launches, sample
        What is launched, and some of it.
    more
        Further attributes, such as the seed of a sample.
    """
    settings = launches.settings
    attrs: dict[str, Any] = {
        "format": FORMAT,
        "title": f"outcomes of launches: {sample.model.title}",
        "horizon": launches.horizon,
        "tolerance": settings.tolerance,
        "checked": int(settings.check),
        "settle": settings.settle,
        "software": f"stability {__version__}",
        "versions": versions(LIBRARIES),
        "source": sample.model.source,
        "Conventions": "CF-1.11",
    }
    attrs |= launches.attributes(sample)
    return attrs | dict(more)


def works(sample: Starts, *, linear: bool) -> str:
    """Keys of the works to cite: the model, the integrator of the lanes, and the linear verdict.

    Parameters
    ----------
    sample
        Some of the launches.
    linear
        Whether there is the linear verdict of the steady motions, whose changes are proved.
    """
    methods = works_of([HEYOKA] if on_lanes(sample) else ())
    return sample.subject.cited(eigenvalues=linear, proofs=linear, methods=methods)


def question(launches: Launches, sample: Starts, more: Mapping[str, Any]) -> dict[str, Any]:
    """Everything that the numbers depend on, for the fingerprint of a store."""
    return attributes(launches, sample, more) | {
        "graph": str(sample.model.rhs),
        "varied": list(launches.varied),
        "held": dict(launches.held),
        "flat": launches.settings.flat,
        "most": launches.settings.max_steps,
        "families": [f"{f.name} {f.held} {f.unknown}" for f in launches.families],
    }


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
    lazy = flag("lazy", lazy)
    return read_dataset(path, {FORMAT: "a store of launches"}, lazy=lazy, usual=ZARR)
