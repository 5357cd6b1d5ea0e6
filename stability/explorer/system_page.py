"""The page of a family of a user's system."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any

import casadi as ca

from ..base.axis import Axis
from ..base.checks import known
from ..base.errors import ParameterError, StabilityError, absent, shown
from ..base.quantities import readable, time_unit
from ..bodies.model import system_model
from ..systems.family import Family
from ..systems.structure.structural_zeros import steady_where, structure
from ..systems.system import System
from .certificates import own_certificates
from .motion import motion_of
from .page import Contents
from .quantities import PageQuantity
from .subject import PageSubject
from .verdicts import derived_formulas

DECIMALS = (
    " Floats in the equations count as the decimals that were written, which "
    "st.conditions(family, decimals=True).numbers lists."
)
"""What the reader of a page learns of numbers that are not exact."""


def system_page(
    family: Family,
    at: Any,
    axes: Sequence[Axis | None],
    positive: Sequence[str],
    parameters: Mapping[str, Any],
    *,
    certify: bool,
) -> Contents:
    """The page of one family of a user's system."""
    family, values, zeros = _without_inputs(family, _values(family, at, parameters))
    names = [*family.at, *family.parameters]
    if len(names) < 2:
        raise ParameterError(
            f"{family.name} has {f'one quantity, {names[0]}' if names else 'no quantity'}; a "
            "diagram needs two: make a number of the system a parameter."
        )
    ranges = {axis.name: (axis.low, axis.high) for axis in axes if axis is not None}
    free = iter([n for n in names if n not in ranges])
    first, second = (next(free) if axis is None else axis.name for axis in axes)
    quantities = {
        n: _quantity(family, n, values[n], ranges.get(n), positive=n in positive) for n in names
    }
    formulas = derived_formulas(family, quantities, positive)
    if not isinstance(family.system, System):
        raise StabilityError(f"{family.name}: the page needs a family of a stability.System.")
    subject = PageSubject(
        key=family.name,
        family=family,
        title=f"{family.system.name}: {family.name}",
        quantities=quantities,
        axes=(first, second),
        formulas=formulas,
        model=family.name,
        call={
            "what": "system",
            "si": {},
            "at": family.at,
            "parameters": family.parameters,
            "given": family.system.parameters,
            "zeros": zeros,
            "system": family.system.name,
        },
    )
    if formulas.solver:  # an error says why there is no member to start from
        family.member(
            *([quantities[n].value for n in part] for part in (family.at, family.parameters))
        )
    where = f" where {', '.join(f'{n} = 0' for n in zeros)}" if zeros else ""
    return Contents(
        title=f"{family.name} of {family.system.name}",
        subjects=[subject],
        start=subject,
        motions={subject.model: motion_of(system_model(family.system), solid=False)},
        certificates={subject.key: own_certificates(subject)} if certify else {},
        families={},
        says="A family of a user's system, its conditions derived exactly by the package",
        computed_from=f"conditions that were derived exactly from the system's equations{where}",
        stated=_units(family),
        more=DECIMALS if formulas.numbers else "",
    )


def _quantity(
    family: Family, name: str, value: float, ends: tuple[float, float] | None, *, positive: bool
) -> PageQuantity:
    unit = family.system.units.get(name, "1")
    around = (0.0, 2 * value) if value > 0 else (2 * value, 0.0) if value < 0 else (-1.0, 1.0)
    low, high = ends or around
    least = 0.0 if positive else None
    return PageQuantity(
        name, name, "", "" if unit == "1" else readable(unit), low, high, value, least
    ).at(value)


def _units(family: Family) -> dict[str, str]:
    """Units of times, rates and observables of a system; empty where it states none."""
    units = family.system.units
    time = time_unit(units)
    known_ = {n: readable(u) for n, u in units.items() if u and u != "1"}
    return known_ | ({} if time == "1" else {"time": time, "growth rate": f"1/{time}"})


def _values(family: Family, at: Any, parameters: Mapping[str, Any]) -> dict[str, float]:
    """Every quantity of a family as a number, or an error that names what is missing."""
    names = (*family.at, *family.parameters)
    for name in parameters:
        known("parameter", name, names)
    values = dict(parameters)
    if at is not None:
        each = list(at) if isinstance(at, (list, tuple)) else [at]
        if len(each) != len(family.at):
            raise ParameterError(f"at is {shown(at)}; give {len(family.at)} numbers.")
        values |= dict(zip(family.at, each, strict=True))
    missing = [n for n in names if n not in values]
    if missing:
        raise ParameterError(f"{absent(missing)}; give each quantity the value shown at first.")
    return values


def _without_inputs(
    family: Family, values: Mapping[str, float]
) -> tuple[Family, dict[str, float], list[str]]:
    """The family without the inputs whose given 0 it needs to be steady, and their names.

    A reader of a page could move such an input to where no member is.
    """
    family.system.refuse_algebraic("a page")
    known_zero = steady_where(family, values)
    if known_zero is family:
        return family, dict(values), []
    needed = [
        n
        for n in family.parameters
        if values[n] == 0
        and not structure(
            replace(known_zero, typical={m: v for m, v in known_zero.typical.items() if m != n})
        ).steady
    ]
    system = family.system
    kept = [n for n in system.parameters if n not in needed]
    symbols = dict(zip(system.parameters, ca.vertsplit(system.p), strict=True))
    put = ca.vertcat(*(symbols[n] if n in kept else 0 for n in system.parameters))
    named = {**system.observables, **{str(i): c.value for i, c in enumerate(system.conditions)}}
    rates, *rest = ca.substitute([system.rhs, *named.values()], [system.p], [put])
    seen = dict(zip(named, rest, strict=True))
    smaller = System(
        system.name,
        system.x,
        ca.vertcat(*(symbols[n] for n in kept)),
        rates,
        states=system.states,
        parameters=tuple(kept),
        observables={n: seen[n] for n in system.observables},
        conditions=tuple(replace(c, value=seen[str(i)]) for i, c in enumerate(system.conditions)),
        units={n: u for n, u in system.units.items() if n not in needed},
    )
    sizes = {n: v for n, v in family.typical.items() if n not in needed}
    left = {n: v for n, v in values.items() if n not in needed}
    return replace(family, system=smaller, typical=sizes), left, needed
