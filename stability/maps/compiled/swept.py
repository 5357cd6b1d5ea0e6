"""Growth rates of large maps from polynomials c₂ λ² + c₀, by compiled loops over the cells."""

from __future__ import annotations

from functools import lru_cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...algebra.kernels import double_balls
from ...algebra.kernels.compiled import compiled
from ...algebra.kernels.tape import Tape, recorded
from ...algebra.number_types import Algebra, numpy_algebra
from ...algebra.program import Program
from ...base.types import Floats
from . import squares


@lru_cache(maxsize=64)
def _tape(bounded: Program, moving: frozenset[tuple[int, int]], count: int) -> Tape:
    """What is left of a program that has begun: its inputs are what is kept, and what moves."""

    def entries(numbers: list[Any], algebra: Algebra) -> list[Any]:
        blocks: list[list[Any]] = [[None] * size for size in bounded.inputs]
        for (i, j), value in zip(sorted(moving), numbers[count:], strict=True):
            blocks[i][j] = value
        nothing = [[np.float64(np.nan)] * size for size in bounded.inputs]
        rest = bounded.begun(numpy_algebra(), nothing, moving).run
        columns = rest(algebra.functions, numbers[:count], blocks)
        return [entry for values in columns for entry in values]

    return recorded(entries, count + len(moving))


def swept(
    bounded: Program,
    places: list[list[Any]],
    moving: frozenset[tuple[int, int]],
    wanted: float,
    flags: tuple[int, ...],
) -> tuple[tuple[Floats, Floats, Floats], NDArray[np.int8]]:
    """Flags and growth rates over a grid, flat.

    Parameters
    ----------
    bounded
        Coefficients, unknowns and numbers that are positive at members; then bounds on their
        errors.
    places
        Family parameters and parameters: numbers, or arrays of shape (1, columns) or (rows, 1).
    moving
        (input, entry) of those of shape (rows, 1).
    wanted
        Error of the abscissa, relative to the largest modulus, beyond which a cell is left open.
    flags
        Flags of neutral and unstable cells, of cells that are left open, and of none.

    Returns
    -------
    rates, codes
        Abscissa, error and frequency, and the flags.
    """
    columns = max(
        np.size(v)
        for i, some in enumerate(places)
        for j, v in enumerate(some)
        if (i, j) not in moving
    )
    with np.errstate(all="ignore"):
        fixed = bounded.begun(numpy_algebra(), places, moving).kept
    tape = _tape(bounded, moving, len(fixed))
    points = np.array([np.ravel(places[i][j]) for i, j in sorted(moving)])
    registers = np.zeros(tape.size)
    registers[list(tape.constants)] = list(tape.constants.values())
    read = set(tape.steps[:, 2:].ravel().tolist()) | set(tape.outputs)
    lines = [k for k, v in enumerate(fixed) if k in read and np.size(v) > 1]
    for k, v in enumerate(fixed):
        if k in read and np.size(v) == 1:
            registers[k] = np.ravel(v)[0]
    values = np.array([np.ravel(fixed[k]) for k in lines]).reshape(len(lines), columns)
    counts = np.cumsum([0, *(len(some) for some in bounded.places)])
    ends = [tape.outputs[a:b] for a, b in zip(counts, counts[1:], strict=False)]
    (c, _, lead), (off, _, slack) = ends[0], ends[3]
    positive = [place for pair in zip(ends[2], ends[5], strict=True) for place in pair]
    cells = columns * points.shape[1]
    out = np.empty(cells), np.empty(cells), np.empty(cells)
    codes = np.empty(cells, dtype=np.int8)
    compiled(double_balls, squares).sweep(
        tape.steps,
        registers,
        (np.array(lines, dtype=np.int64), values),
        (np.arange(len(fixed), len(fixed) + len(points)), points),
        np.array([c, lead, off, slack, *positive]),
        wanted,
        np.array(flags, dtype=np.int8),
        out,
        codes,
    )
    return out, codes
