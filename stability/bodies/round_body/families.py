"""Families of steady motions of a body of revolution as a `Family` under a contact law."""

from __future__ import annotations

import math
from collections.abc import Collection
from functools import lru_cache
from typing import Any

from ...algebra.upright import UPRIGHT
from ...base.checks import known
from ...base.errors import NameUnknownError, NoMemberError, ParameterError, listed, shown
from ...systems.family import Family
from ...systems.system import System
from ..contact_laws import Contact, class_named, law_class
from ..families import FAMILIES, Held, SteadyFamily
from .equations import Resistances, round_system
from .inclinations import first_numbers, level, sizes, stands_upright, start, stays_level
from .pole_equations import SLIP, pole_system, refuse_rough_pole
from .polynomials import closed_form, stored
from .shape import RoundShape, not_upright, sharp
from .si_law import shape_of


def survives(name: str, resistance: Resistances, *, upright: bool) -> bool:
    """Whether members of a family lose no energy to resistances, so that they are steady.

    Parameters
    ----------
    name
        A key of `FAMILIES`.
    resistance
        Classes of the resistances.
    upright
        Whether members that roll are upright, so that they do not turn about the vertical.
    """
    record = FAMILIES[name]
    turns = ("level",) if record.level and upright else record.turns
    return not any(set(turns) & set(r.against) for r in resistance)


def round_family(
    body: RoundShape,
    name: str,
    law: type[Contact],
    parameters: tuple[str, ...],
    *,
    physical: bool,
    theta: float | None = None,
    pole: Any = None,
    resistance: Resistances = (),
) -> Family:
    """A family of steady motions of a body under a contact law; built once.

    Parameters
    ----------
    body
        The body.
    name
        A key of `FAMILIES`.
    law
        Class of the law.
    parameters
        Names of the law's parameters.
    physical
        Whether mass, gravity and length are parameters of the system.
    theta
        Inclination near that of rolling, where the body rolls at several [rad].
    pole
        0 or "pi": the inclination of vertical spin; 0 when left out.
    resistance
        Classes of the resistances to rolling and turning.

    Returns
    -------
    Family

    Raises
    ------
    StabilityError
        If the body has no such family under this law.

    Source: the module's text; tests/bodies/test_round_families.py searches for other motions.
    """
    record = FAMILIES[known("family", name, FAMILIES)]
    if record.law and record.law != law.name:
        names = [f.name for f in FAMILIES.values() if f.law in ("", law.name)]
        raise NoMemberError(
            f"{name} is a family of the {record.law} contact; steady motions under the {law.name} "
            f"law are {listed(names)}."
        )
    if theta is not None and not record.level:
        raise ParameterError(f"theta chooses where a body rolls; leave it out for {name}.")
    if pole is not None and not record.pole:
        raise ParameterError(f"pole belongs to vertical spin; leave it out for {name}.")
    if record.pole:
        near = _pole_sign(pole)
        system = pole_system(
            body, law, parameters, physical=physical, near=near, resistance=resistance
        )
        still = dict(record.held) | {n: 0.0 for n in SLIP if n in system.states}
        near_numbers = _pairs(_typical(body, record, law, parameters))
        return _family(system, record, _pairs(still), (), (), near_numbers, law)  # type: ignore[arg-type]  # a class is hashable
    system = round_system(body, law, parameters, physical=physical, resistance=resistance)
    typical = _typical(body, record, law, parameters)
    held: dict[str, Any] = {"theta_dot": 0.0} | dict(record.held)
    held |= {n: 0.0 for n in ("slip_x", "slip_y") if n in system.states}
    unknown, edge = dict(record.unknown), sharp(body)
    if edge:
        held |= record.held_by_disk
        unknown = record.disk_unknown
    equations = ["theta_dot"] * bool(unknown)
    if record.rests and not edge:
        # under a law with slip in the state, slip_x changes unless the centre rests
        equations.append("slip_x" if law.slips else "rim_speed")
    if record.upright and not stands_upright(body):
        raise _not_upright(body, name)
    if record.level:
        at = level(body, theta)
        if at is None:
            held["theta"] = UPRIGHT
        else:
            # not the rate of theta_dot, which falls again where the lever is long
            first = start(body, at, theta) if stored(name, law) else at
            if not stays_level(body, typical, at):
                typical |= {n: v for n, v in first_numbers(body).items() if n in typical}
            unknown, equations = {"theta": first}, ["lever"]
    every = _pairs(held), _pairs(unknown), tuple(equations), _pairs(typical)
    upright = record.level and not unknown  # rational in every number: read from the graph
    shaped = None if resistance or upright or edge else (shape_of(body), parameters, physical)
    return _family(system, record, *every, law, shaped)  # type: ignore[arg-type]  # a class is hashable


def _not_upright(body: RoundShape, name: str) -> NoMemberError:
    return NoMemberError(f"{body.name} has no {name}: {not_upright(body)}.")


def _pairs(table: Held) -> tuple[tuple[str, Any], ...]:
    return tuple(table.items())


@lru_cache(maxsize=64)
def _family(  # noqa: PLR0913
    system: System,
    record: SteadyFamily,
    held: Any,
    unknown: Any,
    equations: Any,
    typical: Any,
    law: Any,
    shaped: Any = None,
) -> Family:
    formulas = None
    if shaped is not None:
        shape, parameters, physical = shaped
        formulas = closed_form(
            system,
            record.name,
            shape,
            law,
            parameters,
            physical=physical,
            start=dict(unknown).get("theta"),
        )
    return Family(
        system,
        record.name,
        record.at,
        held=dict(held),
        unknown=dict(unknown),
        equations=equations,
        positive=record.positive,
        typical=dict(typical),
        integrals=law.conservative and not record.pole,
        formulas=formulas,
    )


def _pole_sign(pole: Any) -> int:
    """1 for θ = 0, -1 for θ = π."""
    if pole is None or (isinstance(pole, (int, float)) and pole == 0):
        return 1
    if (isinstance(pole, str) and pole == "pi") or (
        isinstance(pole, float) and abs(pole - math.pi) < 1e-9
    ):
        return -1
    raise ParameterError(f"pole is {shown(pole)}; give 0 or 'pi'.")


def _typical(
    body: RoundShape, record: SteadyFamily, law: type[Contact], parameters: tuple[str, ...]
) -> dict[str, float]:
    """Numbers and an inclination near which the family has members."""
    # slip that creeps decays fast
    friction = dict.fromkeys(parameters, 30.0 if law.holds else 0.7)
    return friction | {"phi_dot": 1.9, "omega3": 1.3} | sizes(body, rests=record.rests)


def body_family(
    body: RoundShape, name: str, contact: Any, theta: float | None, pole: Any = None
) -> Family:
    """A family of a body under a law, its class or its name, as `Body.family` describes.

    Parameters
    ----------
    body, name, contact, theta, pole
        As for `Body.family`.
    """
    if not isinstance(name, str) or name not in FAMILIES:
        raise unknown_family(name, body)
    law: Any = class_named(contact, motion=False) if isinstance(contact, str) else contact
    kind = law_class(law, motion=False)
    parameters: Collection[str] = (
        law.given
        if isinstance(law, Contact)
        else {kind.alternatives(p.name)[0]: None for p in kind.parameters}
    )  # one name a coefficient
    return round_family(
        body, name, kind, tuple(parameters), physical=not body.dimensionless, theta=theta, pole=pole
    )


def unknown_family(family: Any, body: RoundShape) -> NameUnknownError:
    """The refusal of a family by a name that no body has.

    Parameters
    ----------
    family
        What was given.
    body
        The body.
    """
    return NameUnknownError(
        f"family is {shown(family)}; known for {body.name} are {', '.join(FAMILIES)}."
    )


def place_of(body: RoundShape, family: str, theta: float | None, pole: Any) -> float | None:
    """Inclination of a family that one number names; None for tumbling, whose number it is.

    Parameters
    ----------
    body
        The body.
    family
        `rolling`, `spinning`, `tumbling` or `vertical`.
    theta, pole
        As for `round_family`.

    Raises
    ------
    StabilityError
        If the body has no such family.
    """
    record = FAMILIES[family]
    if theta is not None and not record.level:
        raise ParameterError(f"theta chooses where a body rolls; leave it out for {family}.")
    if pole is not None and not record.pole:
        raise ParameterError(f"pole belongs to vertical spin; leave it out for {family}.")
    if record.pole:
        near = _pole_sign(pole)
        refuse_rough_pole(body, (near,))
        return 0.0 if near == 1 else math.pi
    if record.upright and not stands_upright(body):
        raise _not_upright(body, family)
    if record.level:
        at = level(body, theta)
        return math.pi / 2 if at is None else at
    return math.pi / 2 if record.upright else None
