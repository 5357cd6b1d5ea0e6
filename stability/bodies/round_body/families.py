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
from collections.abc import Callable, Collection, Mapping
from dataclasses import dataclass
from functools import lru_cache
from typing import Any

import numpy as np
from numpy.typing import ArrayLike
from scipy.optimize import brentq

from ...algebra.upright import UPRIGHT, Upright
from ...base.checks import known, one_number
from ...base.errors import NameUnknownError, NoMemberError, ParameterError, listed, shown
from ...base.types import Floats
from ...systems.family import Family
from ...systems.system import System
from ..contact import Contact
from ..contact_laws import law_class
from ..law_names import class_named
from .equations import Resistances, round_system
from .pole_equations import AXIS, SLIP, TURN, pole_system
from .polynomials import closed_form
from .shape import SAMPLES, SCALES, RoundShape
from .si_law import shape_of

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
    body: RoundShape, name: str, law: type[Contact], given: tuple[str, ...], *, physical: bool,
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
        near_numbers = _pairs(_typical(body, record))
        return _family(system, record, _pairs(still), (), (), near_numbers, law)  # type: ignore[arg-type]  # a class is hashable
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
            f"{float(_slope(body)(math.pi / 2)):.3g}, and must vanish there."
        )
    if record.level:
        at = level(body, theta)
        if at is None:
            held["theta"] = UPRIGHT
        else:
            # not the rate of theta_dot, which falls again where the lever is long
            unknown, equations = {"theta": at}, ["lever"]
    every = _pairs(held), _pairs(unknown), tuple(equations), _pairs(_typical(body, record))
    shaped = None if resistance else (shape_of(body), given, physical)
    return _family(system, record, *every, law, shaped)  # type: ignore[arg-type]  # a class is hashable


def _pairs(table: Mapping[str, Any]) -> tuple[tuple[str, Any], ...]:
    return tuple(table.items())


@lru_cache(maxsize=64)
def _family(  # noqa: PLR0913
    system: System, record: RoundFamily, held: Any, unknown: Any, equations: Any, typical: Any,
    law: Any, own: Any = None,
) -> Family:  # fmt: skip
    formulas = None
    if own is not None:
        shape, given, physical = own
        formulas = closed_form(system, record.name, shape, law, given, physical=physical)
    return Family(
        system, record.name, record.at, held=dict(held), unknown=dict(unknown),
        equations=equations, positive=record.positive, typical=dict(typical),
        integrals=law.conservative and not record.pole, formulas=formulas,
    )  # fmt: skip


def _near(pole: Any) -> int:
    """1 for θ = 0, -1 for θ = π."""
    if pole is None or (isinstance(pole, (int, float)) and pole == 0):
        return 1
    if pole == "pi" or (isinstance(pole, float) and abs(pole - math.pi) < 1e-9):
        return -1
    raise ParameterError(f"pole is {shown(pole)}; give 0 or 'pi'.")


def _typical(body: RoundShape, record: RoundFamily) -> dict[str, float]:
    """Sizes near which the family has members: the body's own numbers, and an inclination."""
    own = {n: float(v) for n, v in first_numbers(body).items() if n not in SCALES}
    found = {"theta": 1.0, "phi_dot": 1.9, "omega3": 1.3} | own
    if record.rests:
        ranges = tumbling_ranges(body)
        low, high = max(ranges, key=lambda r: r[1] - r[0], default=(1.0, 1.0))
        found["theta"] = (low + high) / 2
    return found


def first_numbers(body: RoundShape) -> dict[str, float]:
    """Every number of the body by name, of arrays the first."""
    return {n: float(np.asarray(v, dtype=float).flat[0]) for n, v in body.given.items()}


def tumbling_ranges(body: RoundShape) -> list[tuple[float, float]]:
    """Intervals of θ in which the body tumbles, at samples, for the first of its shapes [rad].

    Parameters
    ----------
    body
        The body.

    Examples
    --------
    >>> import stability as st
    >>> [(round(a, 2), round(b, 2)) for a, b in tumbling_ranges(st.EccentricSphere(0.3))]
    [(0.0, 1.98)]
    """
    low, high = body.between
    theta = low + (high - low) * (np.arange(SAMPLES) + 0.5) / SAMPLES
    first = first_numbers(body)
    shape = [first[n] for n in body.shape]
    h, slope = (np.asarray(body.array(f, theta, *shape)) for f in body.slopes()[:2])
    axial, transverse = (float(np.asarray(m, dtype=float).flat[0]) for m in body.moments())
    s, c = np.sin(theta), np.cos(theta)
    r, z = h * s + slope * c, h * c - slope * s
    with np.errstate(all="ignore"):
        there = slope * r * s * (transverse * r * c - axial * z * s) > 0
    if _upright(body):
        there &= np.abs(theta - math.pi / 2) > (high - low) / SAMPLES
    ends = np.flatnonzero(np.diff(np.concatenate([[0], there.astype(int), [0]])))
    step = (high - low) / SAMPLES / 2
    return [(float(theta[a] - step), float(theta[b - 1] + step))
            for a, b in ends.reshape(-1, 2)]  # fmt: skip


def _slope(body: RoundShape) -> Callable[[ArrayLike], Floats]:
    """Slope of the height at inclinations, for the first of the body's shapes."""
    numbers = first_numbers(body)
    first = [numbers[n] for n in body.shape]
    function = body.slopes()[1]
    return lambda theta: np.asarray(body.array(function, theta, *first))


def _upright(body: RoundShape) -> bool:
    """Whether the slope of the height vanishes at π/2, to double precision."""
    low, high = body.between
    if not low < math.pi / 2 < high:
        return False
    scale = float(np.asarray(body.height_at(math.pi / 2)).flat[0])
    return abs(float(_slope(body)(math.pi / 2))) <= CLOSE * scale


def levels(body: RoundShape) -> list[float]:
    """Inclinations at which the slope of the height vanishes; π/2 comes first where it is one.

    Parameters
    ----------
    body
        The body; of arrays the first entry counts.
    """
    return list(_levels(body))


@lru_cache(maxsize=256)
def _levels(body: RoundShape) -> tuple[float, ...]:
    """The same, found once for each body."""
    low, high = body.between
    grid = low + (high - low) * (np.arange(SAMPLES) + 0.5) / SAMPLES
    slope = _slope(body)
    slopes = slope(grid)
    upright = _upright(body)
    found = [math.pi / 2] * upright
    for a, b, f, g in zip(grid[:-1], grid[1:], slopes[:-1], slopes[1:], strict=True):
        if f * g < 0 and not (upright and a <= math.pi / 2 <= b):
            root = float(brentq(slope, a, b, xtol=1e-15))
            if abs(slope(root)) < 1e-3 * (abs(f) + abs(g)):  # a corner of the height has no zero
                found.append(root)
    return tuple(found)


def level(body: RoundShape, theta: float | None = None) -> float | None:
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
    kind = law_class(type(law) if isinstance(law, Contact) else law, motion=False)
    given: Collection[str] = (
        law.given
        if isinstance(law, Contact)
        else {kind.alternatives(p.name)[0]: None for p in kind.parameters}
    )  # one name a coefficient
    return round_family(
        body, name, kind, tuple(given), physical=not body.dimensionless, theta=theta, pole=pole
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
