"""Launches of what moves, a body or a user's system; parameters and starts of a system, checked."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from ..base.checks import broadcast, checked, rows
from ..base.errors import DomainError, NameUnknownError, ParameterError, listed, shown
from ..base.quantities import Units
from ..base.types import Floats
from ..bodies.disk import Disk
from ..bodies.model import system_model
from ..bodies.round_body.body import Body
from ..settling.system_lines import system_settling
from ..systems.family import Family
from ..systems.sources.numeric import NumericSystem
from ..systems.system import System
from .round_starts import gather_round
from .starts import Starts, Unfit, counted, times_of

Moving = Disk | Body | System
"""What moves."""
OUTSIDE = "outside"
"""End of a start at which a condition of the system fails."""
SAMPLES = 8
"""Starts near which a family is asked for members."""
LARGEST = 1e100
"""Largest state and rate of a start: the norms of step control overflow only far above."""


def moving(first: Any, body: Any = None) -> Moving:
    """What moves: the first argument of a call, or `body`, or else the uniform disk.

    Parameters
    ----------
    first, body
        As for `simulate`.

    Raises
    ------
    ParameterError
        If both are given, or it is none.
    """
    if body is not None:
        if first is not None:
            raise ParameterError("body is given, and disk too; give one of them.")
        if not isinstance(body, (Body, Disk)):
            raise ParameterError(
                f"body is {shown(body)}; give a stability.Body or a stability.Disk."
            )
        return body
    if isinstance(first, NumericSystem):
        raise ParameterError(first.no_graph)
    if first is not None and not isinstance(first, (Disk, Body, System)):
        raise ParameterError(f"disk is {shown(first)}; give a stability.Disk, a Body or a System.")
    return Disk() if first is None else first


def launches_of(
    thing: Moving,
    contact: Any,
    start: Any,
    times: ArrayLike,
    *,
    families: Any = (),
    resistance: Any = None,
    pose: bool = False,
    mark: bool = False,
) -> Starts:
    """The launches of a call, checked and dimensionless.

    Parameters
    ----------
    thing
        What moves.
    contact, start, times, families, resistance, pose
        As for `simulate`.
    mark
        Whether a start that does not exist is marked, in place of an error.

    Raises
    ------
    StabilityError
        In one sentence, if something is not accepted.
    """
    if isinstance(thing, System):
        if resistance is not None:
            raise ParameterError(
                "resistance belongs to a disk or a body; put it into the equations of a system."
            )
        if pose:
            raise ParameterError("pose is True, and only a disk has one; leave it out.")
        return gather_system(thing, contact, start, times, families, mark=mark)
    if not isinstance(families, Sequence) or families:
        raise ParameterError("families belong to a stability.System; leave them out.")
    return gather_round(thing, contact, start, times, resistance=resistance, pose=pose, mark=mark)


def gather_system(
    system: System,
    parameters: Any,
    start: Any,
    times: ArrayLike,
    families: Any = (),
    *,
    mark: bool = False,
) -> Starts:
    """Check the arguments of `simulate` for a user's system.

    Parameters
    ----------
    system
        The system.
    parameters, start
        Values by name, or arrays with the names along the last axis; None for no parameters.
    times
        As for `simulate`.
    families
        Families on which the system may settle.
    mark
        Whether a start at which the equations have no meaning is marked, in place of an error.

    Returns
    -------
    Starts

    Raises
    ------
    StabilityError
        In one sentence, if something is not accepted.
    """
    model = system_model(system)
    p = _table("parameters", parameters, system.parameters)
    x = _table("start", start, system.states)
    when = times_of(times)
    shape = broadcast(start=x.shape[:-1], parameters=p.shape[:-1])
    count = counted(shape, when)
    starts = np.broadcast_to(x, (*shape, x.shape[-1])).reshape(count, -1).copy()
    values = np.broadcast_to(p, (*shape, p.shape[-1])).reshape(count, -1).copy()
    unfit: Unfit = {}
    try:
        rates = system.rates(starts, values)
    except DomainError:
        if not mark:
            _refuse(system, shape, starts, values)
            raise
        unfit = _unfit(system, starts, values)
        fit = np.array([i not in unfit for i in range(count)])
        rates = system.rates(starts[fit], values[fit]) if fit.any() else np.zeros(1)
    largest = max(np.abs(starts).max(initial=0.0), np.abs(rates).max(initial=0.0))
    if largest > LARGEST:
        raise ParameterError(
            f"a state or rate of the start is {largest:.3g}, above {LARGEST:g}; give units in "
            "which numbers are nearer to 1."
        )
    energies = np.zeros(count)
    if model.accounted and not unfit:
        energies = np.asarray(system.observe(starts, values)["energy"]).reshape(count)
    given = {
        name: values[0, i] if not p.ndim > 1 else values[:, i]
        for i, name in enumerate(system.parameters)
    }
    return Starts(
        model,
        shape,
        starts,
        values,
        when,
        {n: np.asarray(v) for n, v in given.items()},
        Units(),
        True,
        energies,
        system_settling(_families(system, families, starts, values)),
        unfit=unfit or None,
        name=system.name,
    )


def _unfit(system: System, starts: Floats, values: Floats) -> Unfit:
    """Starts at which the equations have no meaning."""
    found: Unfit = {}
    for row, (x, p) in enumerate(zip(starts, values, strict=True)):
        try:
            system.rates(x, p)
        except DomainError:
            found[row] = OUTSIDE
    return found


def _refuse(system: System, shape: tuple[int, ...], starts: Floats, values: Floats) -> None:
    """Say which start has no meaning."""
    for row, (x, p) in enumerate(zip(starts, values, strict=True)):
        try:
            system.rates(x, p)
        except DomainError as error:
            where = f" {[int(j) for j in np.unravel_index(row, shape)]}" if shape else ""
            raise DomainError(f"start{where}: {error}") from None


def _table(what: str, given: Any, names: tuple[str, ...]) -> Floats:
    """Values along the last axis, in the order of their names."""
    if given is None and not names:
        return np.zeros(0)
    if not isinstance(given, Mapping):
        if isinstance(given, (str, bytes)) or not np.iterable(given):
            every = ", ".join(names) or "none, an empty mapping"
            raise ParameterError(f"{what} is {shown(given)}; give by name or in order: {every}.")
        return rows(what, given, list(names))
    for name in given:
        if name not in names:
            known = ", ".join(names) or "none"
            raise NameUnknownError(f"{what} names {shown(name)}; known are {known}.")
    missing = [n for n in names if n not in given]
    if missing:
        raise ParameterError(f"{what} does not name {listed(missing)}; give {', '.join(names)}.")
    columns = [np.asarray(checked(f"{what} {n}", given[n]), dtype=float) for n in names]
    try:
        return np.stack(np.broadcast_arrays(*columns), axis=-1) if columns else np.zeros(0)
    except ValueError:
        raise ParameterError(
            f"{what} has shapes {[c.shape for c in columns]}; make them fit."
        ) from None


def _families(system: System, families: Any, starts: Floats, values: Floats) -> tuple[Family, ...]:
    given = (families,) if isinstance(families, Family) else families
    if not isinstance(given, Sequence) or not all(isinstance(f, Family) for f in given):
        raise ParameterError(f"families is {shown(families)}; give a list of stability.Family.")
    for family in given:
        if family.system != system:
            raise ParameterError(
                f"family {family.name} is one of {family.system.name}, another system; give "
                f"families of {system.name}."
            )
    double = {f.name for f in given if sum(g.name == f.name for g in given) > 1}
    if double:
        raise ParameterError(f"two families are called {min(double)}; give each its own name.")
    for family in given:
        along = [n for n in family.at if n in system.states]
        if along and not family.unknown and not _steady_nearby(family, starts, values):
            held = ", ".join(f"'{n}': …" for n in system.states)
            named = tuple(n for n in family.at if n not in along)
            raise ParameterError(
                f"family {family.name} is not steady where {listed(along)} changes a little, so "
                f"that nothing settles along it; name one motion by "
                f"stability.Family(system, '{family.name}', at={named}, held={{{held}}})."
            )
    return tuple(given)


def _steady_nearby(family: Family, starts: Floats, values: Floats) -> bool:
    """Whether the family has a member at states near some starts, other than by chance."""
    near = starts[:SAMPLES] * 1.0173 + 0.0137
    line, p = system_settling((family,)).lines[0], values[:SAMPLES]
    return bool(np.isfinite(line.near(near, p).distance).any())
