"""The thin disk as a body of revolution: h = sinθ, and what is known of its motions alone."""

from __future__ import annotations

import math
from dataclasses import replace
from functools import lru_cache, partial
from typing import Any

import casadi as ca
import numpy as np

from ...base.checks import instance
from ...base.types import Floats
from ..contact_laws import Contact
from ..disk import Disk
from ..model import Model
from ..momenta import momenta_model
from ..quantities import QUANTITIES, THIN
from .height.expression import ShapeFunction, expression
from .shape import Outline, RoundShape
from .si_law import Shape, shape_of


@lru_cache(maxsize=1)
def _height_and_moments() -> tuple[ShapeFunction, ShapeFunction, ShapeFunction]:
    return (
        expression("height", lambda theta, k: ca.sin(theta) + 0 * k, ["theta", "k"], 1),
        expression("axial", lambda k: 2 * k, ["k"]),
        expression("transverse", lambda k: k, ["k"]),
    )


def thin_body(disk: Disk) -> Outline:
    """The disk as a body of revolution, for everything that takes one.

    Parameters
    ----------
    disk
        The disk.

    Examples
    --------
    >>> thin_body(Disk(k=0.5)).moments()
    (1.0, 0.5)
    """
    return Outline(
        *_height_and_moments(),
        {"k": disk.k},
        THIN,
        (0.0, math.pi),
        disk.mass,
        disk.gravity,
        disk.radius,
    )


def round_shape(body: Any) -> RoundShape:
    """A body or disk as a body of revolution; anything else is refused.

    Parameters
    ----------
    body
        What the caller gave.
    """
    if isinstance(body, Disk):
        return thin_body(body)
    return instance("body", body, RoundShape, "give a stability.Body or a stability.Disk")


@lru_cache(maxsize=1)
def unit_disk() -> Outline:
    """The disk of which only the names of the numbers matter."""
    return thin_body(Disk())


@lru_cache(maxsize=1)
def _thin_shape() -> Shape:
    return shape_of(unit_disk())


def is_thin(shape: Shape) -> bool:
    """Whether a shape is that of `thin_body`."""
    return shape == _thin_shape()


def of_thin(model: Model, law: type[Contact]) -> Model:
    """The model of a thin disk, with what its motions alone have.

    Parameters
    ----------
    model
        The model of a body with the shape of `thin_body`.
    law
        Class of the law.
    """
    unresisted = model.system.parameters == ("k", *law.symbols())
    whole = len(model.names) == len(model.states) + 1 and not (law.sticks or law.holds)
    return replace(
        model,
        quantities={**model.quantities, **QUANTITIES},
        sound=_stands,
        short=partial(momenta_model, law) if whole and unresisted else None,
        # the proof of `_unique` knows no resistance: then each sample of sticking is looked at
        dry=replace(model.dry, unique=_unique) if model.dry and unresisted else model.dry,
        title=f"motion of a disk, {law.name} contact",
        source="equations of Przybylska & Rauch-Wojciechowski, Regul. Chaotic Dyn. 21 (2016) "
        "204-231, integrated",
    )


def _unique(p: Floats) -> bool:
    """Whether mu < 2√(k(k+1)), where docs/explanation/dry-friction.md proves it."""
    k, mu = p
    return bool(mu < 2 * math.sqrt(k * (k + 1)))


def _stands(states: Any) -> bool:
    return bool((np.sin(states[:, 0]) > 0).all())
