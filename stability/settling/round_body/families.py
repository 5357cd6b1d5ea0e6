"""The families that a body of revolution may settle on under a law and resistances."""

from __future__ import annotations

import math
from dataclasses import replace

import casadi as ca

from ...algebra.upright import UPRIGHT
from ...base.errors import NoMemberError
from ...bodies.contact import Contact
from ...bodies.contact_laws import Creep
from ...bodies.round_body.body import Body
from ...bodies.round_body.equations import Resistances, round_system
from ...bodies.round_body.families import round_family, survives
from ...bodies.round_body.inclinations import levels
from ...bodies.round_body.pole_equations import pole_system, smooth_at
from ...systems.family import Family
from ..body_lines import Line, Vertical
from ..body_settling import BodySettling


def body_settling(
    body: Body, law: type[Contact], given: tuple[str, ...], resistance: Resistances = ()
) -> BodySettling:
    """The families that a body may settle on under a law, and those that it may depart from.

    Parameters
    ----------
    body, law, given, resistance
        As for `stability.bodies.round_body.models.angle_model.round_model`.

    Returns
    -------
    BodySettling
        With the families that lose nothing to the resistances.
    """
    system = round_system(body, law, given, physical=False, slip_states=True, resistance=resistance)
    theta, *own = (ca.SX.sym(n) for n in ("theta", *body.shape))
    height = ca.Function("height", [theta, *own], [f(theta, *own) for f in body.slopes()])
    shape = ca.vertsplit(system.p)[: len(own)]
    moments = ca.vertcat(*(
        system.p[system.parameters.index(n)] if n in system.parameters
        else ca.SX(getattr(body, n)(*shape))
        for n in ("axial", "transverse")
    ))  # fmt: skip
    lines: list[Line | Vertical] = [
        Line(
            family,
            system,
            law.conservative or law.sticks,
            height,
            moments,
            body.between,
            level,
            several=" near " in family.name,
        )  # fmt: skip
        for family, level in _families(body, law, given, resistance)
    ]
    for pole, word in ((1, 0), (-1, "pi")):
        if (
            not (law.sticks or issubclass(law, Creep))
            and smooth_at(body, pole)
            and survives("vertical", resistance, upright=False)
        ):
            family = round_family(
                body, "vertical", law, given, physical=False, pole=word, resistance=resistance
            )
            family = replace(family, name=f"vertical at theta = {word}")
            chart = pole_system(body, law, given, physical=False, near=pole, resistance=resistance)
            lines.append(Vertical(family, chart, law.conservative or law.sticks, pole))
    return BodySettling(tuple(lines))


def _families(
    body: Body, law: type[Contact], given: tuple[str, ...], resistance: Resistances
) -> list[tuple[Family, float | None]]:
    """The families that one number names, and the inclination of rolling where it leans."""
    found: list[tuple[Family, float | None]] = []
    places = levels(body)
    for theta in places:
        if not survives("rolling", resistance, upright=theta == math.pi / 2):
            continue
        family = round_family(
            body, "rolling", law, given, physical=False, theta=theta, resistance=resistance
        )
        if len(places) > 1:
            family = replace(family, name=f"rolling near theta = {theta:.4g}")
        upright = family.held.get("theta") is UPRIGHT
        found.append((family, None if upright else theta))
    for name in ("spinning", "tumbling"):
        if not survives(name, resistance, upright=False):
            continue
        try:
            one = round_family(body, name, law, given, physical=False, resistance=resistance)
            found.append((one, None))
        except NoMemberError:
            continue
    return found
