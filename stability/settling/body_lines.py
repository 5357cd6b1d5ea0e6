"""What the disk or a body settles on: its families of steady motions that one number names.

They are those of docs/explanation/bodies.md: rolling at each zero of the height's slope, spinning
where that slope vanishes upright, tumbling, and vertical spin at smooth poles.  Stable rolling of a
slipping disk drifts (`stability.drift`), so no motion settles on it.
tests/settling/test_settling.py continues launches from the state that counts as settled.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from contextlib import suppress
from dataclasses import replace
from functools import lru_cache, partial
from typing import Any

import casadi as ca
import numpy as np
from numpy.typing import NDArray

from ..algebra.upright import UPRIGHT
from ..base.errors import NoMemberError
from ..base.types import Floats
from ..bodies.contact_laws import Contact, Creep
from ..bodies.explicit import surface
from ..bodies.families import FAMILIES, SteadyFamily, lines_under, tumbling
from ..bodies.newton_euler import STATES
from ..bodies.round_body.equations import Resistances, round_system
from ..bodies.round_body.families import round_family, survives
from ..bodies.round_body.inclinations import levels
from ..bodies.round_body.pole_equations import AXIS, SLIP, TURN, pole_system, smooth_at
from ..bodies.round_body.shape import RoundShape
from ..bodies.round_body.si_law import shape_of
from ..bodies.round_body.thin import is_thin, unit_disk
from ..systems.system import System
from .line import FamilyLine, idle_under, signed
from .settling import Settling
from .surroundings import NOT_PROVED

THETA, AXIAL = STATES.index("theta"), STATES.index("omega3")
SPIN = TURN[2]
DRIFTS = "{} with slip drifts on its centre manifold (stability.drift): not settled"
ROOT = 60
"""Most iterations for the inclination of rolling."""


def body_settling(
    body: RoundShape, law: type[Contact], parameters: tuple[str, ...], resistance: Resistances = ()
) -> Settling:
    """The families that a body may settle on under a law, and those that it may depart from.

    They are built once for each body.

    Parameters
    ----------
    body, law, parameters, resistance
        As for `stability.bodies.round_body.models.angle_model.round_model`.

    Returns
    -------
    Settling
        With the families that lose nothing to the resistances.
    """
    records = _records(law)
    if not is_thin(shape_of(body)):  # only these have members in closed form
        records = tuple(f for f in records if f.level or f.upright or f.rests or f.pole)
    every: Any = body, law, parameters, resistance, records
    return _settling(*every)


def disk_settling(law: type[Contact], resistance: Resistances = ()) -> Settling:
    """The same for every disk; its second argument `p` has the inertia factor first."""
    return body_settling(unit_disk(), law, law.symbols(), resistance)


def _records(law: type[Contact]) -> tuple[SteadyFamily, ...]:
    """Families that motions may settle on, by name for equal distances."""
    poles = (f for f in FAMILIES.values() if f.pole)
    return (*sorted(lines_under(law.name), key=lambda record: record.name), *poles)


@lru_cache(maxsize=16)
def _settling(
    body: RoundShape,
    law: type[Contact],
    parameters: tuple[str, ...],
    resistance: Resistances,
    records: tuple[SteadyFamily, ...],
) -> Settling:
    line = partial(_line, body, law, parameters, resistance)
    lines: list[FamilyLine] = []
    # a law that sticks, and creep, have no equations at a pole
    smooth = [p for p in (1, -1) if not law.sticks and smooth_at(body, p)]
    smooth = [] if issubclass(law, Creep) else smooth
    for record in records:
        if record.pole:
            if survives(record.name, resistance, upright=False):
                lines += [_vertical(body, law, parameters, resistance, pole) for pole in smooth]
            continue
        places = levels(body) if record.level else [math.pi / 2]
        for theta in places:
            upright = record.level and theta == math.pi / 2
            if not survives(record.name, resistance, upright=upright):
                continue
            with suppress(NoMemberError):
                lines.append(line(record, theta, several=len(places) > 1))
    return Settling(tuple(lines))


def _line(  # noqa: PLR0913
    body: RoundShape,
    law: type[Contact],
    parameters: tuple[str, ...],
    resistance: Resistances,
    record: SteadyFamily,
    theta: float,
    *,
    several: bool = False,
) -> FamilyLine:
    """A family in the angles; `several` says that the body rolls at more than one inclination."""
    thin, name = is_thin(shape_of(body)), record.name
    family = round_family(
        body,
        name,
        law,
        parameters,
        physical=False,
        resistance=resistance,
        theta=theta if record.level else None,
    )
    call: dict[str, Any] = {"family": name}
    if several:
        family = replace(family, name=f"{name} near theta = {theta:.4g}")
        call["theta"] = theta
    system = round_system(
        body, law, parameters, physical=False, slip_states=True, resistance=resistance
    )
    leaning = record.level and family.held.get("theta") is not UPRIGHT
    y, sign, level = ca.SX.sym("y"), ca.SX.sym("sign"), ca.SX.sym("level")
    member = dict.fromkeys(system.states, 0.0) | {"theta": level if leaning else UPRIGHT}
    reason = NOT_PROVED if leaning else ""  # that inclination is not known exactly
    if thin:
        member = record.member(ca, y, system.p[0], sign)
        reason = DRIFTS.format(name) if record.drifts and not resistance else ""
    elif record.rests:
        member |= _tumbling(body, system.p, system.parameters, y, sign)
    return FamilyLine(
        family.name,
        system,
        system.states,
        family.at,
        member,
        y,
        ca.vertcat(sign, level, system.p) if leaning else ca.vertcat(sign, system.p),
        partial(_leaning, _level(body, theta)) if leaning else signed,
        _guards(body, system),
        idle=idle_under(law),
        reason=reason,
        family=None if thin and not resistance else family,
        call=call,
    )


def _guards(body: RoundShape, system: System) -> list[ca.SX]:
    """Contact, and the room that θ has; the exact π/2 has a sine and a cosine alone."""
    seen, theta = system.observables, system.x[0]
    if body.between == (0.0, math.pi):
        return [seen["normal_force"], seen["determinant"], ca.sin(theta)]
    room = [
        sign * ca.sin(theta) * math.cos(end) - sign * ca.cos(theta) * math.sin(end)
        for sign, end in zip((1, -1), body.between, strict=True)
    ]
    return [seen["normal_force"], seen["determinant"], *room]


def _tumbling(
    body: RoundShape, p: ca.SX, names: Sequence[str], y: ca.SX, sign: ca.SX
) -> dict[str, ca.SX]:
    """The rates of tumbling at an inclination."""
    shape = ca.vertsplit(p)[: len(body.shape)]
    axial, transverse = (
        p[names.index(n)] if n in names else ca.SX(getattr(body, n)(*shape))
        for n in ("axial", "transverse")
    )
    at = surface(y, ca.SX(body.height(y, *shape)), transverse, axial)
    square, share = tumbling(at.slope, at.outward, at.along, at.sine, at.cosine, transverse, axial)
    turning = sign * ca.sqrt(square)
    return {"phi_dot": turning, "omega3": turning * share}


def _leaning(level: Callable[..., float], states: Floats, p: Floats) -> tuple[Floats, None]:
    """The sign of φ̇, the inclination of rolling, and the parameters."""
    signs = signed(states, p)[0][:, 0]
    return np.column_stack([signs, [level(*q) for q in p.tolist()], p]), None


def _level(body: RoundShape, theta: float) -> Callable[..., float]:
    """(parameters of the system) → the zero of the height's slope near an inclination."""
    _, slope, bend = body.slopes()

    @lru_cache(maxsize=256)
    def by_newton(*p: float) -> float:
        shape, level = p[: len(body.shape)], theta
        for _ in range(ROOT):
            first, second = float(slope(level, *shape)), float(bend(level, *shape))
            step = first / second if second else math.nan
            level -= step
            if not abs(step) > 1e-15:
                return level
        return math.nan

    return by_newton


def _vertical(
    body: RoundShape,
    law: type[Contact],
    parameters: tuple[str, ...],
    resistance: Resistances,
    pole: int,
) -> FamilyLine:
    """Spin about the vertical axis at a pole, in the chart around it with x̂ along X."""
    word = 0 if pole == 1 else "pi"
    family = round_family(
        body, "vertical", law, parameters, physical=False, pole=word, resistance=resistance
    )
    family = replace(family, name=f"vertical at theta = {word}")
    system = pole_system(body, law, parameters, physical=False, near=pole, resistance=resistance)
    across = (*AXIS[:2], *TURN[:2], *SLIP)
    return FamilyLine(
        family.name,
        system,
        (SPIN, *across),
        (SPIN,),
        dict.fromkeys(across, 0.0),
        ca.SX.sym("y"),
        system.p,
        partial(_at_pole, pole),
        (system.observables["normal_force"], *(c.value for c in system.conditions)),
        idle=idle_under(law),
        family=family,
        call={"family": "vertical", "pole": word},
        chart=_pole_chart,
        unchart=partial(_from_pole, pole),
    )


def _pole_chart(six: list[ca.SX]) -> list[ca.SX]:
    """ω_Z, then axis_X, axis_Y, ω_X, ω_Y and the slip."""
    theta, theta_dot, phi_dot, omega3, *slip = six
    sine, cosine = ca.sin(theta), ca.cos(theta)
    spin = omega3 - phi_dot * cosine
    return [phi_dot + spin * cosine, sine, ca.SX(0), spin * sine, theta_dot, *slip]


def _at_pole(pole: int, states: Floats, p: Floats) -> tuple[Floats, NDArray[np.bool_]]:
    """The parameters, and whether the pole is the nearer one."""
    return p, pole * np.cos(states[:, THETA]) > 0


def _from_pole(pole: int, y: Floats) -> Floats:
    """The six states of vertical spin."""
    six = np.zeros((len(y), len(STATES)))
    six[:, THETA], six[:, AXIAL] = (0.0 if pole == 1 else math.pi), pole * y[:, 0]
    return six
