"""Families of steady motions of a body of revolution, one record for each.

A steady motion keeps its energy, so under a law that dissipates wherever anything slips the force
vanishes: F = 0 and vA = 0.  Then the centre moves straight or rests.  With φ̇ = 0 the torque
h'·m g vanishes: *rolling* at a zero of h' with any ω₃.  With φ̇ ≠ 0 the centre rests, which fixes
ω₃ = φ̇ sinθ z/r, where r = h sinθ + h' cosθ and z = h cosθ - h' sinθ are the distances of the
contact point from the axis and, along the axis, from the centre.  Euler's equation then reads
φ̇² sinθ (I₁ r cosθ - I₃ z sinθ) = m g h' r: *tumbling*, named by θ, and *spinning*, where both
sides vanish upright.  At a pole there is *vertical* spin alone.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from functools import lru_cache
from typing import Any

import numpy as np
from scipy.optimize import brentq

from ...algebra.upright import UPRIGHT, Upright
from ...base.checks import known, one_number
from ...base.errors import NoMemberError, ParameterError, listed, shown
from ...systems.family import Family
from ...systems.system import System
from ..contact import Contact
from .body import SAMPLES, Body
from .equations import Resistances, round_system
from .pole_equations import AXIS, SLIP, TURN, pole_system

CLOSE = 1e-12
"""Largest slope of the height, over the height, that counts as zero at π/2 before the proof."""


@dataclass(frozen=True, eq=False)
class RoundFamily:
    """A family of steady motions of a body of revolution."""

    name: str
    """Name in calls and messages."""
    at: tuple[str, ...]
    """States that name a member."""
    motion: str
    """The motion in words."""
    held: Mapping[str, float | Upright]
    """Values of the states that are the same along the family."""
    unknown: Mapping[str, float]
    """First guesses of the states that are solved for."""
    rests: bool = False
    """Whether the centre of mass rests, which is an equation of its own."""
    level: bool = False
    """Whether theta is a zero of the height's slope, upright where the slope vanishes there."""
    upright: bool = False
    """Whether the family exists only where the slope of the height vanishes at π/2."""
    positive: tuple[str, ...] = ()
    """Unknowns that come out positive; the mirror image has the same spectrum."""
    law: str = ""
    """The one contact law under which the family exists; empty for every law."""
    turns: tuple[str, ...] = ("level", "vertical")
    """Parts of the angular velocity that members have; rolling upright has the level part alone."""
    pole: bool = False
    """Whether the axis is vertical: the family lives in the chart around a pole."""


_RECORDS = (
    RoundFamily(
        "rolling", ("omega3",), "rolling straight ahead at constant inclination",
        {"phi_dot": 0.0}, {}, level=True,
    ),
    RoundFamily(
        "spinning", ("phi_dot",), "upright, turning about the vertical on the spot",
        {"theta": UPRIGHT, "omega3": 0.0}, {}, upright=True, turns=("vertical",),
    ),
    RoundFamily(
        "tumbling", ("theta",), "inclined, its centre at rest", {},
        {"phi_dot": 1.0, "omega3": 0.0}, rests=True, positive=("phi_dot",),
    ),
    RoundFamily(
        "circling", ("theta", "phi_dot"),
        "inclined, its contact point running round a circle without slip",
        {}, {"omega3": 0.0}, law="rough",
    ),
    RoundFamily(
        "precession", ("theta", "phi_dot"),
        "inclined, its centre at rest or in uniform straight motion, without friction",
        {}, {"omega3": 0.0}, law="smooth",
    ),
    RoundFamily(
        "vertical", ("omega_Z",), "its axis vertical, turning about it on the spot",
        dict.fromkeys((*AXIS[:2], *TURN[:2]), 0.0), {}, pole=True, turns=("vertical",),
    ),
)  # fmt: skip
FAMILIES = {family.name: family for family in _RECORDS}
"""Every family of a body of revolution by name."""


def round_family(
    body: Body, name: str, law: type[Contact], given: tuple[str, ...], *, physical: bool,
    theta: float | None = None, pole: Any = None, resistance: Resistances = (),
) -> Family:  # fmt: skip
    """A family of steady motions of a body under a contact law; built once.

    Parameters
    ----------
    body
        The body.
    name
        A key of `FAMILIES`.
    law
        Class of the law.
    given
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
        own = [f.name for f in _RECORDS if f.law in ("", law.name)]
        raise NoMemberError(
            f"{name} is a family of the {record.law} contact; steady motions under the {law.name} "
            f"law are {listed(own)}."
        )
    if theta is not None and not record.level:
        raise ParameterError(f"theta chooses where a body rolls; leave it out for {name}.")
    if pole is not None and not record.pole:
        raise ParameterError(f"pole belongs to vertical spin; leave it out for {name}.")
    if record.pole:
        near = _near(pole)
        system = pole_system(body, law, given, physical=physical, near=near, resistance=resistance)
        still = dict(record.held) | {n: 0.0 for n in SLIP if n in system.states}
        return _family(system, record, _pairs(still), (), (), law)  # type: ignore[arg-type]  # a class is hashable
    system = round_system(body, law, given, physical=physical, resistance=resistance)
    held: dict[str, Any] = {"theta_dot": 0.0} | dict(record.held)
    held |= {n: 0.0 for n in ("slip_x", "slip_y") if n in system.states}
    unknown = dict(record.unknown)
    equations = ["theta_dot"] * bool(unknown)
    if record.rests:  # under a law with slip in the state, slip_x changes unless the centre rests
        equations.append("slip_x" if law.slips else "rim_speed")
    if record.upright and not _upright(body):
        raise NoMemberError(
            f"{body.name} has no {name}: the slope of its height at theta = π/2 is "
            f"{_slope(body, math.pi / 2):.3g}, and must vanish there."
        )
    if record.level:
        at = level(body, theta)
        if at is None:
            held["theta"] = UPRIGHT
        else:
            unknown, equations = {"theta": at}, ["theta_dot"]
    return _family(system, record, _pairs(held), _pairs(unknown), tuple(equations), law)  # type: ignore[arg-type]  # a class is hashable


def _pairs(table: Mapping[str, Any]) -> tuple[tuple[str, Any], ...]:
    return tuple(table.items())


@lru_cache(maxsize=64)
def _family(  # noqa: PLR0913
    system: System, record: RoundFamily, held: Any, unknown: Any, equations: Any, law: Any
) -> Family:
    typical = {"theta": 1.0, "phi_dot": 1.9, "omega3": 1.3, "axial": 0.5, "transverse": 0.3}
    return Family(
        system, record.name, record.at, held=dict(held), unknown=dict(unknown),
        equations=equations, positive=record.positive, typical=typical,
        integrals=law.conservative and not record.pole,
    )  # fmt: skip


def _near(pole: Any) -> int:
    """1 for θ = 0, -1 for θ = π."""
    if pole is None or (isinstance(pole, (int, float)) and pole == 0):
        return 1
    if pole == "pi" or (isinstance(pole, float) and abs(pole - math.pi) < 1e-9):
        return -1
    raise ParameterError(f"pole is {shown(pole)}; give 0 or 'pi'.")


def _slope(body: Body, theta: float) -> float:
    """Slope of the height at an inclination, for the first of the body's shapes."""
    return float(np.asarray(body.height_at(theta, 1)).flat[0])


def _upright(body: Body) -> bool:
    """Whether the slope of the height vanishes at π/2, to double precision."""
    low, high = body.between
    if not low < math.pi / 2 < high:
        return False
    scale = float(np.asarray(body.height_at(math.pi / 2)).flat[0])
    return abs(_slope(body, math.pi / 2)) <= CLOSE * scale


def levels(body: Body) -> list[float]:
    """Inclinations at which the slope of the height vanishes; π/2 comes first where it is one.

    Parameters
    ----------
    body
        The body; of arrays the first entry counts.
    """
    low, high = body.between
    grid = low + (high - low) * (np.arange(SAMPLES) + 0.5) / SAMPLES
    slopes = [_slope(body, float(t)) for t in grid]
    found = [math.pi / 2] * _upright(body)
    for a, b, f, g in zip(grid[:-1], grid[1:], slopes[:-1], slopes[1:], strict=True):
        if f * g < 0 and not (_upright(body) and a <= math.pi / 2 <= b):
            found.append(float(brentq(lambda t: _slope(body, t), a, b, xtol=1e-15)))
    return found


def level(body: Body, theta: float | None = None) -> float | None:
    """Inclination at which the slope of the height vanishes; None for exactly upright.

    Parameters
    ----------
    body
        The body; of arrays the first entry counts.
    theta
        A number near the one that is meant, where there are several [rad].

    Raises
    ------
    NoMemberError
        If there is none, or there are several and none is meant.
    """
    low, high = body.between
    found = levels(body)
    if not found:
        raise NoMemberError(
            f"{body.name} rolls nowhere: the slope of its height has no zero between "
            f"{low:.6g} and {high:.6g}."
        )
    if theta is not None:
        wanted = one_number("theta", theta)
        best = min(found, key=lambda t: abs(t - wanted))
    elif found[0] == math.pi / 2 or len(found) == 1:
        best = found[0]
    else:
        angles = ", ".join(f"{t:.6g}" for t in found)
        raise NoMemberError(
            f"{body.name} rolls at theta = {angles}; give theta=, a number near one of them."
        )
    return None if best == math.pi / 2 and _upright(body) else best
