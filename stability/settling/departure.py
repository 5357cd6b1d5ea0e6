"""Departure of a motion from an unstable steady motion near which it began.

The phase of an oscillation changes the distance from a steady motion even where nothing grows.
Growth is therefore measured in modal coordinates of the linearisation without its structural zeros,
where the size of each mode does not depend on the phase.
"""

from __future__ import annotations

import numpy as np

from ..algebra.eigensolver import eigenpairs
from ..base.errors import StabilityError
from ..base.types import Complexes, Floats
from ..base.verdict import CODES, Verdict
from ..bodies.subject import subject_of
from ..spectra.deflation import lowered
from ..spectra.problem import problem_of
from ..spectra.spectrum import Rows
from ..systems.family import Family
from .line import FamilyLine, Near
from .settling import Settling

GROWTH = 10.0
"""Ratio of the sizes at the end and at the start from which a motion counts as departed."""
WORST_CONDITION = 1e8
"""Condition number of the modes beyond which they measure no growth."""


def departures(
    settling: Settling, starts: Floats, ends: Floats, p: Floats, within: float, errors: Floats
) -> list[str]:
    """Whether each motion has departed from the steady motion nearest to its start, in words.

    It has where that member is unstable, its verdict given by a bound, and where the distance from
    the family at the end, less its error, is larger than `within` and `GROWTH` times that at the
    start, and where the modes together have grown as much.

    Parameters
    ----------
    settling
        The families.
    starts, ends
        States, shape (N, n).
    p
        Parameters of the system, shape (N, m).
    within
        Distance that can count as settled.
    errors
        Estimated errors of the distances at the end, shape (N,).

    Returns
    -------
    list of str
        A sentence without its full stop for each; empty where it has not departed.

    Source: tests/motion/test_unresolved_and_departing.py.
    """
    said = [""] * len(starts)
    if not any(line.family for line in settling.lines):
        return said
    before = settling.many(starts, p, -1.0)
    for number, line in enumerate(settling.lines):
        family, mine = line.family, before.family == number
        if family is None or not mine.any():
            continue
        both = before.states[mine], settling.read(ends[mine])
        first = Near(*(part[mine] for part in before.near[number]))
        last = line.near(both[1], p[mine])
        near, far = first.distance, last.distance
        gone = np.isfinite(far) & (far - errors[mine] > np.maximum(within, GROWTH * near))
        if not gone.any():
            continue
        rows = np.flatnonzero(mine)[gone]
        at = np.array([line.at(y, q) for y, q in zip(first.y[gone], p[rows], strict=True)])
        off, later = (
            _in_states(line, line.deviations(x, member)[gone])
            for x, member in zip(both, (first, last), strict=True)
        )
        departed = _grown(family, at.reshape(len(rows), -1), p[rows], off, later, errors[rows])
        sizes = zip(rows, at, near[gone], far[gone], departed, strict=True)
        for row, values, start, end, sure in sizes:
            if sure:
                where = line.worded(family.at, values)
                said[row] = (
                    f"departs from {family.name}, unstable{f' at {where}' if where else ''}: "
                    f"{start:.3g} away at the start, {end:.3g} at the end"
                )
    return said


def _in_states(line: FamilyLine, off: Floats) -> Floats:
    """Deviations in the states of the family's equations."""
    assert line.family is not None
    deviations = dict(zip(line.across, off.T, strict=True))
    still = np.zeros(len(off))
    return np.column_stack([deviations.get(n, still) for n in line.family.system.states])


def _grown(
    family: Family, a: Floats, p: Floats, before: Floats, after: Floats, errors: Floats
) -> list[bool]:
    """Whether the members with values of `at` are unstable, and their modes have grown."""
    parameters = family.system.parameters
    numbers = {n: p[:, parameters.index(n)] for n in family.parameters}
    numbers |= dict(zip(family.at, a.T, strict=True))
    try:
        rows = Rows(problem_of(subject_of(family, parameters=numbers)), exact=False)
        codes = np.broadcast_to(rows.spectra()[2], len(a))
        reduced = rows.place.reduced(family, rows.zeros)
        modes = np.broadcast_to(eigenpairs(reduced.matrix)[1], (len(a), *reduced.matrix.shape[1:]))
    except StabilityError:
        return [False] * len(a)
    pairs = zip(lowered(before, reduced.steps), lowered(after, reduced.steps), strict=True)
    return [
        bool(code == CODES[Verdict.UNSTABLE]) and _in_modes(*pair, x, error)
        for code, pair, x, error in zip(codes, pairs, modes, errors, strict=True)
    ]


def _in_modes(before: Floats, after: Floats, modes: Complexes, error: float) -> bool:
    """Whether the modal coordinates of a deviation have grown by more than `GROWTH`."""
    if np.linalg.cond(modes) > WORST_CONDITION:
        return False
    inverse = np.linalg.inv(modes)
    doubt = error * float(np.linalg.norm(inverse, 2))
    first, last = (float(np.hypot.reduce(np.abs(inverse @ off))) for off in (before, after))
    return last - doubt > GROWTH * first
