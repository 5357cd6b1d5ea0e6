"""Derivatives of the field about a line of steady motions, as tapes of balls of doubles.

With ℓ a row that is given, e' = G and y' = g are read at y = y_c + w + ℓ·e.  So the derivatives in
e at fixed w follow the slow direction of the line.

The graph must be smooth wherever its third derivative has a finite enclosure: `smooth_field` keeps
out |x| and sign x, whose kinks leave no trace in a derivative.  Numbers that CasADi folds while it
differentiates are rounded once, which the bounds of roundings of each term cover.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache
from typing import Any

import casadi as ca
import numpy as np

from ...algebra.kernels.tape import Tape, recorded
from ...algebra.number_types import Algebra
from ...algebra.program import Program
from ...base.types import Floats
from ..surroundings import Surroundings


@dataclass(frozen=True, eq=False)
class Derivatives:
    """Tapes of the derivatives of (G, g), m + 1 rows."""

    across: int
    """Entries of e, m."""
    first: Tape
    """(y, given) → ∂/∂e at e = 0, row by row."""
    second: Tape
    """(y, given) → ∂²/∂e∂y, then ∂²/∂e² at e = 0, row by row."""
    third: Tape
    """(y, given, e, d, ℓ) → the third derivative along (d, ℓ·d), over 6."""
    positive: Tape
    """(y, given, e) → the guards."""


@lru_cache(maxsize=32)
def derivatives(around: Surroundings) -> Derivatives:
    """Tapes of a family's surroundings.

    Parameters
    ----------
    around
        Surroundings with a field, along which one number names a member.

    Returns
    -------
    Derivatives

    Raises
    ------
    StabilityError
        If the graph has a function without a kernel.
    """
    field = around.field
    assert field is not None and around.along == 1
    m, count = around.across, around.slopes.inputs[1]
    y, given, e = ca.SX.sym("y"), ca.SX.sym("given", count), ca.SX.sym("e", m)
    constants = field.symbols
    rows = field.function(y, given, e, *constants)
    slope = ca.jacobian(rows, e)
    mixed = ca.jacobian(ca.reshape(slope.T, -1, 1), y)
    bend = ca.jacobian(ca.reshape(slope.T, -1, 1), e)
    none = ca.DM.zeros(m)
    there = [ca.substitute(v, e, none) for v in (slope, mixed, bend)]
    d, ell = ca.SX.sym("d", m), ca.SX.sym("ell", m)
    seeds = ca.vertcat(ca.dot(ell, d), d)
    third = rows
    for _ in range(3):
        third = ca.jtimes(third, ca.vertcat(y, e), seeds)

    def tape(inputs: list[ca.SX], output: ca.SX) -> Tape:
        made = ca.Function("derivative", [*inputs, *constants], [ca.densify(output)])
        return _tape(Program(made, field.constants), [v.numel() for v in inputs])

    second = ca.vertcat(there[1], ca.reshape(there[2].T, -1, 1))
    flat = ca.reshape(there[0].T, -1, 1)
    return Derivatives(
        m,
        tape([y, given], flat),
        tape([y, given], second),
        tape([y, given, e, d, ell], third / 6),
        _guards(around),
    )


def _tape(program: Program, sizes: list[int]) -> Tape:
    def run(a: list[Any], number: Algebra) -> list[Any]:
        return [v for [v] in program.dense(number, _cut(a, sizes))]

    return recorded(run, sum(sizes))


def _guards(around: Surroundings) -> Tape:
    sizes = list(around.positive.inputs[:3])

    def run(a: list[Any], number: Algebra) -> list[Any]:
        found: list[Any] = around.positive.run(number, _cut(a, sizes))[0]
        return found

    return recorded(run, sum(sizes))


def _cut(a: list[Any], sizes: list[int]) -> list[list[Any]]:
    ends = np.cumsum([0, *sizes])
    return [a[low:high] for low, high in zip(ends[:-1], ends[1:], strict=True)]


def at_members(made: Derivatives, y: Floats, room: float, given: Floats) -> tuple[Floats, ...]:
    """First, mixed and second derivatives at e = 0 with their radii, over y ± room.

    Parameters
    ----------
    made
        The tapes.
    y, room
        Members, shape (N,), and the half-width about each.
    given
        Second argument of the programs, shape (N, ·).

    Returns
    -------
    first, its radius, mixed, its radius, second, its radius
        Shapes (N, m + 1, m), (N, m + 1, m) and (N, m + 1, m, m).
    """
    m, n = made.across, len(y)
    mid = np.vstack([y, given.T])
    rad = np.zeros_like(mid)
    rad[0] = room
    flat = [v.T for v in made.first.run(mid, rad)]
    curved = [v.T for v in made.second.run(mid, rad)]
    cut, size = (m + 1) * m, (n, m + 1, m)
    out = [v.reshape(size) for v in flat]
    out += [v[:, :cut].reshape(size) for v in curved]
    out += [v[:, cut:].reshape(*size, m) for v in curved]
    return tuple(out)
