"""Departure of a user's system from an unstable steady motion near which it began.

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
from ..spectra.deflation import lowered
from ..spectra.problem import system_problem
from ..spectra.rows import Rows
from ..systems.family import Family
from .body_settling import BodySettling
from .nearest import Nearest
from .system_settling import SystemSettling, in_words, length

GROWTH = 10.0
"""Ratio of the sizes at the end and at the start from which a motion counts as departed."""
WORST_CONDITION = 1e8
"""Condition number of the modes beyond which they measure no growth."""


def departures(
    settling: SystemSettling | BodySettling, starts: Floats, ends: Floats, p: Floats, within: float,
    errors: Floats,
) -> list[str]:  # fmt: skip
    """Whether each motion has departed from the steady motion nearest to its start, in words.

    It has where that member is unstable, its verdict given by a bound, and where the distance from
    the family at the end, less its error, is larger than `within` and `GROWTH` times that at the
    start, and where the modes together have grown as much.

    Parameters
    ----------
    settling
        The families of the system, or of the body.
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
    gone: dict[str, list[tuple[int, Nearest, Floats]]] = {}
    families = {family.name: family for family in settling.families}
    for i, (start, end, own) in enumerate(zip(starts, ends, p, strict=True)):
        near = settling.closest(start, own)
        if near.member is None:
            continue
        off = settling.deviation(families[near.family], end, own)
        if off is not None and length(off) - errors[i] > max(within, GROWTH * near.distance):
            gone.setdefault(near.family, []).append((i, near, off))
    for name, mine in gone.items():
        family, rows = families[name], [i for i, _, _ in mine]
        before = np.array([settling.deviation(family, starts[i], p[i]) for i in rows])
        after = np.array([off for _, _, off in mine])
        a = np.vstack([settling.at_of(family, starts[i], p[i]) for i in rows])
        departed = _grown(family, a, p[rows], before, after, errors[rows])
        for (i, near, off), at, sure in zip(mine, a, departed, strict=True):
            if sure:
                where = in_words(family, family.at, at)
                said[i] = (
                    f"departs from {family.name}, unstable{f' at {where}' if where else ''}: "
                    f"{near.distance:.3g} away at the start, {length(off):.3g} at the end"
                )
    return said


def _grown(
    family: Family, a: Floats, p: Floats, before: Floats, after: Floats, errors: Floats
) -> list[bool]:
    """Whether the members with values of `at` are unstable, and their modes have grown."""
    parameters = family.system.parameters
    given = {n: p[:, parameters.index(n)] for n in family.parameters}
    given |= dict(zip(family.at, a.T, strict=True))
    try:
        rows = Rows(system_problem(family, None, given), exact=False)
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
    first, last = (float(length(np.abs(inverse @ off))) for off in (before, after))
    return last - doubt > GROWTH * first
