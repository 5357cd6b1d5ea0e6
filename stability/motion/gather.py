"""Launches of what moves, a body or a user's system; parameters and starts of a system, checked."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import lru_cache
from typing import Any

import casadi as ca
import numpy as np
from numpy.typing import ArrayLike

from ..algebra.program import Program, entries
from ..base.checks import broadcast, rows
from ..base.citation import cited
from ..base.errors import DomainError, ParameterError, listed, shown
from ..base.quantities import Units
from ..base.types import Floats
from ..bodies.disk import Disk
from ..bodies.model import Model, system_model
from ..bodies.round_body.body import Body
from ..settling.settling import Nearest
from ..settling.system_lines import system_settling
from ..systems.family import Family
from ..systems.sources.numeric import NumericSystem
from ..systems.system import System
from .result import OF_BODY, Outcome
from .round_starts import gather_round
from .starts import MotionSubject, Starts, by_name, counted, nearest_families, place_in, times_of

Moving = Disk | Body | System
"""What moves."""
OUTSIDE = "outside"
"""End of a start at which a condition of the system fails."""
NO_RESISTANCE = "resistance belongs to a disk or a body; put it into the equations of a system."
"""Why a system has no resistance."""
SAMPLES = 8
"""Starts near which a family is asked for members."""
LARGEST = 1e100
"""Largest state and rate of a start: the norms of step control overflow only far above."""


def moving(first: Any, body: Any = None, *, numeric: bool = False) -> Moving:
    """What moves: the first argument of a call, or `body`, or else the uniform disk.

    Parameters
    ----------
    first, body
        As for `simulate`.
    numeric
        Whether a numeric system is accepted.

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
        if not numeric:
            raise ParameterError(first.no_graph)
        return first  # type: ignore[return-value]  # it has the face that motions ask for
    if first is not None and not isinstance(first, (Disk, Body, System)):
        raise ParameterError(f"disk is {shown(first)}; give a stability.Disk, a Body or a System.")
    return Disk() if first is None else first


def launches_of(
    mover: Moving, contact: Any, start: Any, times: ArrayLike | None, **more: Any
) -> Starts:
    """The launches of a call, checked and dimensionless.

    Parameters
    ----------
    mover
        What moves.
    contact, start, times
        As for `simulate`.
    **more
        `numbers`, the parameters by name, `families`, `resistance` and `pose`, as for `simulate`;
        and `mark`, whether a start that does not exist is marked, in place of an error.

    Raises
    ------
    StabilityError
        In one sentence, if something is not accepted.
    """
    gather: Any = gather_system if isinstance(mover, System | NumericSystem) else gather_round
    starts: Starts = gather(mover, contact, start, times, **more)
    return starts


def gather_system(
    system: System,
    parameters: Any,
    start: Any,
    times: ArrayLike | None,
    *,
    numbers: Mapping[str, Any] | None = None,
    families: Any = (),
    resistance: Any = None,
    pose: bool = False,
    mark: bool = False,
) -> Starts:
    """As `launches_of`, of a user's system; its parameters are a mapping, an array, or None."""
    if resistance is not None:
        raise ParameterError(NO_RESISTANCE)
    if pose:
        raise ParameterError("pose is True, and only a disk has one; leave it out.")
    if start is None:
        raise ParameterError(
            f"start is missing; give the states by name or in order: {', '.join(system.states)}."
        )
    if numbers and parameters is not None:
        raise ParameterError(
            f"{shown(next(iter(numbers)))} is given by name, and others in the second argument; "
            "give all in one place."
        )
    model = system_model(system)
    p = _table("parameters", numbers or parameters, system.parameters)
    x = _table("start", start, system.states)
    when = times_of(times)
    shape = broadcast(start=x.shape[:-1], parameters=p.shape[:-1])
    count = counted(shape, when)
    starts = np.broadcast_to(x, (*shape, x.shape[-1])).reshape(count, -1).copy()
    values = np.broadcast_to(p, (*shape, p.shape[-1])).reshape(count, -1).copy()
    rates, failed = _rates(system, starts, values)
    if failed and not mark:
        row, error = next(iter(failed.items()))
        raise DomainError(f"start{place_in(shape, row)}: {error}")
    largest = max(np.abs(starts).max(initial=0.0), np.abs(rates).max(initial=0.0))
    if largest > LARGEST:
        raise ParameterError(
            f"a state or rate of the start is {largest:.3g}, above {LARGEST:g}; give units in "
            "which numbers are nearer to 1."
        )
    energies = np.zeros(count)
    if model.accounted and not failed:
        energies = np.asarray(system.observe(starts, values)["energy"]).reshape(count)
    columns = {
        name: values[0, i] if not p.ndim > 1 else values[:, i]
        for i, name in enumerate(system.parameters)
    }
    return Starts(
        model,
        shape,
        starts,
        values,
        when,
        {n: np.asarray(v) for n, v in columns.items()},
        Units(),
        True,
        energies,
        system_settling(_families(system, families, starts, values)),
        _subject(model),
        unfit=dict.fromkeys(failed, OUTSIDE) or None,
        name=system.name,
    )


def _rates(system: System, starts: Floats, values: Floats) -> tuple[Floats, dict[int, DomainError]]:
    """Rates at the starts, and why the equations have no meaning at others."""
    failed: dict[int, DomainError] = {}
    try:
        return system.rates(starts, values), failed
    except DomainError:
        for row, (x, p) in enumerate(zip(starts, values, strict=True)):
            try:
                system.rates(x, p)
            except DomainError as error:
                failed[row] = error
    fit = np.array([row not in failed for row in range(len(starts))])
    return system.rates(starts[fit], values[fit]) if fit.any() else np.zeros(1), failed


@dataclass(frozen=True, eq=False, kw_only=True)
class _SystemSubject(MotionSubject):
    """A user's system, whose numbers are in its own units and whose energy may have any zero."""

    def in_units(self, launches: Starts, series: dict[str, Floats]) -> dict[str, Floats]:
        """As it is; an observable that has no value at a sample is refused."""
        for name, values in series.items():
            if not np.isfinite(values).all():
                raise DomainError(
                    f"{launches.model.system.name}: {name} has no value somewhere on the way; give "
                    "the system a condition that ends the run before, or leave the observable out."
                )
        return series

    def energy_scale(self, launches: Starts, y: Floats, series: Mapping[str, Floats]) -> Floats:
        """The largest Σ |x ∂E/∂x| or energy lost."""
        x = y[..., : len(launches.model.states)]
        blocks = [entries(x), entries(launches.p[:, None, :])]
        slopes = _energy_slopes(launches.model).arrays(blocks, x.shape[:-1])[0][..., 0]
        share = np.abs(x * slopes).sum(axis=-1)
        scale = np.maximum(share, np.abs(series["dissipated"])).max(axis=-1)
        return np.where(scale > 0, scale, 1.0)

    def nearest(self, launches: Starts, near: Sequence[Nearest], variable: Any) -> dict[str, Any]:
        """Only where all launches have a member."""
        if any(n.member is None for n in near):
            return {}
        variables = nearest_families(near, variable, "distance from it, in units of the states")
        states = launches.model.states
        label = {"long_name": "states of the steady motion", "columns": " ".join(states)}
        member = np.array([n.member for n in near]).reshape(*launches.shape, -1)
        dims = variables["nearest_family"][0]
        return variables | {"nearest_member": ((*dims, "state"), member, label)}


@lru_cache(maxsize=64)
def _energy_slopes(model: Model) -> Program:
    """The gradient of the energy."""
    system = model.system
    slopes = ca.densify(ca.jacobian(model.series["energy"], system.x)).T
    return Program(ca.Function("slopes", [system.x, system.p], [slopes]))


def _subject(model: Model) -> _SystemSubject:
    system = model.system
    return _SystemSubject(
        attributes={"system": system.name, "states": json.dumps(model.states)},
        cited=cited,
        outcomes=tuple(o for o in Outcome if o not in OF_BODY),
        energy_error="largest |audit| over the largest sum of |x dE/dx| of the states, or the "
        "energy lost",
        member={"long_name": "the number that names it", "units": "1"},
        numbers={n: model.attributes(n, dimensionless=True) for n in system.parameters},
    )


def _table(what: str, values: Any, names: tuple[str, ...]) -> Floats:
    """Values along the last axis, in the order of their names."""
    if values is None and not names:
        return np.zeros(0)
    if not isinstance(values, Mapping):
        if isinstance(values, (str, bytes)) or not np.iterable(values):
            every = ", ".join(names) or "none, an empty mapping"
            raise ParameterError(f"{what} is {shown(values)}; give by name or in order: {every}.")
        return rows(what, values, list(names))
    return by_name(what, values, names)


def _families(system: System, families: Any, starts: Floats, values: Floats) -> tuple[Family, ...]:
    sequence = (families,) if isinstance(families, Family) else families
    if not isinstance(sequence, Sequence) or not all(isinstance(f, Family) for f in sequence):
        raise ParameterError(f"families is {shown(families)}; give a list of stability.Family.")
    for family in sequence:
        if family.system != system:
            raise ParameterError(
                f"family {family.name} is one of {family.system.name}, another system; give "
                f"families of {system.name}."
            )
    double = {f.name for f in sequence if sum(g.name == f.name for g in sequence) > 1}
    if double:
        raise ParameterError(f"two families are called {min(double)}; give each its own name.")
    for family in sequence:
        along = [n for n in family.at if n in system.states]
        if along and not family.unknown and not _steady_nearby(family, starts, values):
            held = ", ".join(f"'{n}': …" for n in system.states)
            named = tuple(n for n in family.at if n not in along)
            raise ParameterError(
                f"family {family.name} is not steady where {listed(along)} changes a little, so "
                f"that nothing settles along it; name one motion by "
                f"stability.Family(system, '{family.name}', at={named}, held={{{held}}})."
            )
    return tuple(sequence)


def _steady_nearby(family: Family, starts: Floats, values: Floats) -> bool:
    """Whether the family has a member at states near some starts, other than by chance."""
    near = starts[:SAMPLES] * 1.0173 + 0.0137
    line, p = system_settling((family,)).lines[0], values[:SAMPLES]
    return bool(np.isfinite(line.near(near, p).distance).any())
