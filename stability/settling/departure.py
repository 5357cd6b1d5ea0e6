"""Departure of a user's system from an unstable steady motion near which it began."""

from __future__ import annotations

import numpy as np

from ..base.errors import StabilityError
from ..base.types import Floats
from ..base.verdict import CODES, Verdict
from ..spectra.problem import system_problem
from ..spectra.rows import Rows
from ..systems.family import Family
from .body_settling import BodySettling
from .nearest import Nearest
from .system_settling import SystemSettling, in_words

GROWTH = 10.0
"""Ratio of the distances at the end and at the start from which a motion counts as departed."""


def departures(
    settling: SystemSettling | BodySettling, starts: Floats, ends: Floats, p: Floats, within: float,
    errors: Floats,
) -> list[str]:  # fmt: skip
    """Whether each motion has departed from the steady motion nearest to its start, in words.

    It has where that member is unstable, its verdict given by a bound, and where the distance from
    the family at the end, less its error, is larger than `within` and `GROWTH` times that at the
    start.

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
    gone: dict[str, list[tuple[int, Nearest, float]]] = {}
    for i, (start, end, own) in enumerate(zip(starts, ends, p, strict=True)):
        near = settling.closest(start, own)
        if near.member is None:
            continue
        far = float(settling.distances(end[None], own, near)[0])
        if np.isfinite(far) and far - errors[i] > max(within, GROWTH * near.distance):
            gone.setdefault(near.family, []).append((i, near, far))
    for family in settling.families:
        mine = gone.get(family.name, [])
        if not mine:
            continue
        rows = [i for i, _, _ in mine]
        a = np.vstack([settling.at_of(family, starts[i], p[i]) for i in rows])
        unstable = _unstable(family, a, p[rows])
        for (i, near, far), at, sure in zip(mine, a, unstable, strict=True):
            if sure:
                said[i] = (
                    f"departs from {family.name}, unstable at {in_words(family, family.at, at)}: "
                    f"{near.distance:.3g} away at the start, {far:.3g} at the end"
                )
    return said


def _unstable(family: Family, a: Floats, p: Floats) -> list[bool]:
    """Whether the members with values of `at` are unstable."""
    parameters = family.system.parameters
    given = {n: p[:, parameters.index(n)] for n in family.parameters}
    given |= dict(zip(family.at, a.T, strict=True))
    try:
        codes = Rows(system_problem(family, None, given), exact=False).spectra()[2]
    except StabilityError:
        return [False] * len(a)
    return [bool(c == CODES[Verdict.UNSTABLE]) for c in np.broadcast_to(codes, len(a))]
