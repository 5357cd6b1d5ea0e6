"""Bodies of `random_bodies` by their heights, in the terms of the package: a line each.

A lens, a cap that rolls on its rim, and a superellipsoid are in no list of the package.  Where a
body changes from one part of its surface to another, it has a height for each part.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from typing import Any

import casadi as ca
import numpy as np
from convex_body import ConvexBody

import stability as st

Given = Mapping[str, float]
Height = Callable[..., Any]
Part = tuple[Height, float, float]
"""A height, and the ends of the interval of inclinations in which it holds."""


def _lens(g: Given, theta: float) -> Part:
    edge = g["angle"]
    if theta < edge:
        return (lambda t, radius, angle: radius - radius * ca.cos(angle) * ca.cos(t)), 0.0, edge
    if theta > math.pi - edge:
        return (
            (lambda t, radius, angle: radius + radius * ca.cos(angle) * ca.cos(t)),
            math.pi - edge,
            math.pi,
        )
    return (lambda t, radius, angle: radius * ca.sin(angle) * ca.sin(t)), edge, math.pi - edge


def _cap(g: Given, theta: float) -> Part:
    edge = g["angle"]
    if theta < edge:
        dome = lambda t, radius, angle, centre: radius + centre * ca.cos(t)  # noqa: ARG005, E731
        return dome, 0.0, edge
    return (
        (
            lambda t, radius, angle, centre: (
                radius * ca.sin(angle) * ca.sin(t) + (radius * ca.cos(angle) + centre) * ca.cos(t)
            )
        ),
        edge,
        math.pi,
    )


def superellipse(across: Any, along: Any, power: Any, theta: Any, side: float) -> Any:
    """The height of a superellipsoid, side 1 where cos theta is positive, -1 where it is not."""
    q = power / (power - 1)
    return ((across * ca.sin(theta)) ** q + (side * along * ca.cos(theta)) ** q) ** (1 / q)


def _superellipsoid(g: Given, theta: float) -> Part:
    """With its numbers put in: others near them roll at no inclination of the part."""
    side = math.copysign(1.0, math.cos(theta))
    low, high = (0.4, 1.2) if side > 0 else (math.pi - 1.2, math.pi - 0.4)
    return (lambda t: superellipse(**g, theta=t, side=side)), low, high


def _thick(_: Given, theta: float) -> Part:
    side = math.copysign(1.0, math.cos(theta))
    low, high = (0.0, math.pi / 2) if side > 0 else (math.pi / 2, math.pi)
    return (lambda t, radius, half: radius * ca.sin(t) + side * half * ca.cos(t)), low, high


def _egg(g: Given, _: float) -> Part:
    """The series of the package for this meridian, about another centre of mass."""
    blunt, long, centre = g["blunt"], g["long"], g["centre"]

    def meridian(u: Any) -> tuple[Any, Any]:
        s, c = -np.cos(u), np.sin(u)
        rho = 1 + blunt * s + long * s**2
        return rho * c, rho * s

    series = st.from_profile(meridian, tolerance=1e-16)
    uniform = float(series.height_at(0.0)) - (1 - blunt + long)  # z of the centre of volume
    move = centre - uniform
    return (lambda t: series.height(t) + move * ca.cos(t)), 0.0, math.pi


NUMBERS = ("egg", "superellipsoid")
"""Bodies whose parameters are numbers in the height, and not of the shape."""
HEIGHTS: dict[str, Callable[[Given, float], Part]] = {
    "torus": lambda _g, _t: ((lambda t, rim, tube: rim * ca.sin(t) + tube), 0.0, math.pi),
    "eccentric sphere": lambda _g, _t: (
        (lambda t, offset, radius: radius - offset * ca.cos(t)),
        0.0,
        math.pi,
    ),
    "spheroid": lambda _g, _t: (
        (lambda t, across, along: ca.sqrt((across * ca.sin(t)) ** 2 + (along * ca.cos(t)) ** 2)),
        0.0,
        math.pi,
    ),
    "thick disk": _thick,
    "egg": _egg,
    "lens": _lens,
    "cap": _cap,
    "superellipsoid": _superellipsoid,
}


def by_height(body: ConvexBody, theta: float) -> st.Body:
    """The same body by its height, in the interval of inclinations around one."""
    height, low, high = HEIGHTS[body.name](body.parameters, theta)
    return st.Body(
        height,
        axial=body.axial / body.mass,
        transverse=body.transverse / body.mass,
        mass=body.mass,
        gravity=body.gravity,
        length=1.0,
        between=(low, high),
        name=body.name,
        shape={} if body.name in NUMBERS else dict(body.parameters),
    )


def numbers_at(body: st.Body, theta: float) -> dict[str, float]:
    """Values of the symbols of `proofs.body_polynomials` at an inclination."""
    h, slope, bend = (float(body.height_at(theta, n)) for n in range(3))
    s, c = math.sin(theta), math.cos(theta)
    axial, transverse = body.moments()
    return {
        "h": h,
        "h′": slope,
        "h′′": bend,
        "ρ": h + bend,
        "I1": transverse,
        "I3": axial,
        "s": s,
        "c": c,
        "r": h * s + slope * c,
        "z": h * c - slope * s,
    }
