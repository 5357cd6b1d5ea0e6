"""Random bodies, contact laws and states, well inside what the equations are for.

A scene has normal force above a fifth of the weight, compliance (`Response`) above a fifth, and a
contact that neither jumps between an edge and a face nor lies where a face is flat.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

import body_profiles as bodies
import numpy as np
from convex_body import LAWS, ConvexBody, Law, response_at
from jets import Array

Build = Callable[[np.random.Generator, dict[str, float]], ConvexBody]


@dataclass(frozen=True)
class BodyScene:
    """A body, its contact law, and a state in the disk's coordinates."""

    body: ConvexBody
    law: Law
    state: Array
    """(theta, theta_dot, phi_dot, omega3, slip_x, slip_y)"""


def _torus(rng: np.random.Generator, inertia: dict[str, float]) -> ConvexBody:
    return bodies.torus(rng.uniform(0.6, 1.2), rng.uniform(0.05, 0.5), **inertia)


def _sphere(rng: np.random.Generator, inertia: dict[str, float]) -> ConvexBody:
    return bodies.eccentric_sphere(rng.uniform(-0.5, 0.5), **inertia, radius=rng.uniform(0.8, 1.2))


def _spheroid(rng: np.random.Generator, inertia: dict[str, float]) -> ConvexBody:
    return bodies.spheroid(rng.uniform(0.7, 1.3), rng.uniform(0.7, 1.3), **inertia)


def _thick(rng: np.random.Generator, inertia: dict[str, float]) -> ConvexBody:
    return bodies.thick_disk(rng.uniform(0.7, 1.2), rng.uniform(0.02, 0.5), **inertia)


def _egg(rng: np.random.Generator, inertia: dict[str, float]) -> ConvexBody:
    shape = rng.uniform(-0.15, 0.15), rng.uniform(-0.1, 0.2), rng.uniform(-0.1, 0.1)
    return bodies.egg(*shape, **inertia)


def _lens(rng: np.random.Generator, inertia: dict[str, float]) -> ConvexBody:
    return bodies.lens(rng.uniform(1.0, 2.0), rng.uniform(0.4, 1.1), **inertia)


def _cap(rng: np.random.Generator, inertia: dict[str, float]) -> ConvexBody:
    angle = rng.uniform(0.6, 1.5)
    return bodies.cap(1.2, angle, -0.6 * (1 + math.cos(angle)) + 0.1, **inertia)


def _super(rng: np.random.Generator, inertia: dict[str, float]) -> ConvexBody:
    shape = rng.uniform(0.8, 1.2), rng.uniform(0.6, 1.2), rng.uniform(2.2, 4.0)
    return bodies.superellipsoid(*shape, **inertia)


BODIES: Mapping[str, Build] = {
    "torus": _torus,
    "eccentric sphere": _sphere,
    "spheroid": _spheroid,
    "thick disk": _thick,
    "egg": _egg,
    "lens": _lens,
    "cap": _cap,
    "superellipsoid": _super,
}


def allowed(body: ConvexBody, theta: float) -> bool:
    """Whether the contact is well conditioned at this inclination, and the body tilted."""
    given, s, c = body.parameters, math.sin(theta), abs(math.cos(theta))
    if s < 0.25:
        return False
    if body.name == "thick disk":
        return c > 0.1
    if body.name == "superellipsoid":
        return s > 0.4 and c > 0.4
    if body.name == "lens":
        return abs(s - math.sin(given["angle"])) > 0.05
    if body.name == "cap":
        return abs(theta - given["angle"]) > 0.05
    return True


def random_body(
    rng: np.random.Generator, name: str | None = None, units: bool = True
) -> ConvexBody:
    """A body of a kind in `BODIES`, or of any; mass and gravity are 1 unless `units`."""
    transverse = rng.uniform(0.15, 0.7)
    mass, gravity = rng.uniform(0.5, 2.0, 2) if units else (1.0, 1.0)
    inertia = {
        "axial": float(mass * transverse * rng.uniform(0.4, 1.9)),
        "transverse": float(mass * transverse),
        "mass": float(mass),
        "gravity": float(gravity),
    }
    return BODIES[name or str(rng.choice(list(BODIES)))](rng, inertia)


def random_scene(
    rng: np.random.Generator, name: str | None = None, law: str | None = None, units: bool = True
) -> BodyScene:
    """A random scene; body and law by name, or any."""
    while True:
        body = random_body(rng, name, units)
        kind = law or str(rng.choice(LAWS))
        contact = Law(kind, 0.0 if kind in ("smooth", "rough") else float(rng.uniform(0.05, 1.0)))
        state = rng.normal(size=6) * [0, 0.8, 0.8, 1.5, 0.5, 0.5]
        state[0] = rng.uniform(0.25, math.pi - 0.25)
        if kind == "rough":
            state[4:] = 0
        if kind == "coulomb" and np.hypot(*state[4:]) < 0.1 or not allowed(body, state[0]):
            continue
        response = response_at(body, contact, state)
        if response.compliance > 0.2 and response.force[2] > 0.2 * body.mass * body.gravity:
            return BodyScene(body, contact, state)


def scenes(seed: int, count: int, **chosen: Any) -> list[BodyScene]:
    """So many random scenes."""
    rng = np.random.default_rng(seed)
    return [random_scene(rng, **chosen) for _ in range(count)]
