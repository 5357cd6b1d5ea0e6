"""Growth rates of polynomials λ² + a₀ over a grid, by a tape: what runs once for each cell.

A tape (`stability.algebra.kernels.tape`) gives the coefficients, bounds on their errors, and the
numbers that are positive at members.  A block of columns keeps what follows from x alone.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from ...algebra.kernels.double_balls import (
    DIFFERENCE,
    NEGATIVE,
    PRODUCT,
    RATIO,
    ROOT,
    SINES,
    SIZE,
    SUM,
)

INLINE = ("rate",)
"""Functions that are written into the loops over cells."""
LANES = 256
"""Cells of a row that run through the tape together."""
UNIT = 2.0**-53
"""Unit roundoff of a double."""


def run(tape: Any, w: Any, many: int) -> None:
    """Run a tape on rows of doubles.

    Parameters
    ----------
    tape
        Rows (operation, target, first, second), shape (instructions, 4).
    w
        Registers, shape (registers, lanes).
    many
        Lanes that are used.
    """
    for i in range(len(tape)):
        kind, x, y, z = tape[i, 0], w[tape[i, 1]], w[tape[i, 2]], w[tape[i, 3]]
        if kind == PRODUCT:
            for j in range(many):
                x[j] = y[j] * z[j]
        elif kind == SUM:
            for j in range(many):
                x[j] = y[j] + z[j]
        elif kind == DIFFERENCE:
            for j in range(many):
                x[j] = y[j] - z[j]
        elif kind == RATIO:
            for j in range(many):
                x[j] = y[j] / z[j]
        elif kind == NEGATIVE:
            for j in range(many):
                x[j] = -y[j]
        elif kind == ROOT:
            for j in range(many):
                x[j] = math.sqrt(y[j])
        elif kind == SINES:
            for j in range(many):
                x[j], z[j] = math.sin(y[j]), math.cos(y[j])
        elif kind == SIZE:
            for j in range(many):
                x[j] = abs(y[j])


def rate(c: Any, lead: Any, off: Any, slack: Any, wanted: Any) -> Any:
    """Abscissa, error and frequency of lead λ² + c; 1 if unstable, -1 if neutral, 0 if open.

    Formulas and proofs are those of `stability.maps.rates`.
    """
    a = c / lead
    least = abs(lead) - slack
    size = abs(a)
    error = 1.01 * ((off + size * slack) / (least if least > 0 else 0.0) + 2 * UNIT * size)
    root = math.sqrt(size)
    radius = error / root * (1 + 8 * UNIT) + 4 * UNIT * root
    grows = a < 0
    bound = radius + 8 * UNIT * root if grows else 0.0
    sure = (radius < root) & (bound <= wanted * root)
    return (
        root if grows else 0.0,
        bound,
        0.0 if grows else root,
        (1 if grows else -1) if sure else 0,
    )


def sweep(
    tape: Any,
    registers: Any,
    lines: Any,
    rows: Any,
    ends: Any,
    wanted: float,
    flags: Any,
    out: Any,
    codes: Any,
) -> None:
    """Growth rates and flags of a grid, flat.

    Parameters
    ----------
    tape
        Rows (operation, target, first, second).
    registers
        Values that are the same for all cells, shape (registers,).
    lines
        (registers, values) of what follows from x, values of shape (·, columns).
    rows
        (registers, values) of what changes with y, values of shape (·, rows).
    ends
        Registers of c, lead and their errors, then (number, error) of what is positive at members.
    wanted
        Error of the abscissa, relative to the largest modulus, beyond which a cell is left open.
    flags
        Flags of neutral, unstable and open cells, and of cells without a member.
    out, codes
        Abscissa, error, frequency and flags, each of shape (rows · columns,).
    """
    places, values = lines
    moving, points = rows
    abscissa, error, frequency = out
    columns, count = values.shape[1], points.shape[1]
    w = np.zeros((len(registers), LANES))
    for i in range(len(registers)):
        w[i] = registers[i]
    for low in range(0, columns, LANES):
        many = min(LANES, columns - low)
        for k in range(len(places)):
            w[places[k], :many] = values[k, low : low + many]
        for row in range(count):
            for k in range(len(moving)):
                w[moving[k]] = points[k, row]
            run(tape, w, many)
            c, lead, off, slack = w[ends[0]], w[ends[1]], w[ends[2]], w[ends[3]]
            at = row * columns + low
            for j in range(many):
                top, bound, turn, sign = rate(c[j], lead[j], off[j], slack[j], wanted)
                abscissa[at + j], frequency[at + j] = top, turn
                error[at + j] = bound if sign else math.inf
                codes[at + j] = flags[1] if sign > 0 else flags[0] if sign else flags[2]
            for k in range(4, len(ends), 2):
                number, doubt = w[ends[k]], w[ends[k + 1]]
                for j in range(many):
                    if not number[j] > doubt[j]:  # not proved to be a member's
                        none = number[j] < -doubt[j]
                        if none:
                            codes[at + j] = flags[3]
                        elif codes[at + j] != flags[3]:
                            codes[at + j] = flags[2]
                            error[at + j] = math.inf
                        if none:
                            abscissa[at + j] = error[at + j] = frequency[at + j] = math.nan
