"""Continuation: a family followed along its parameter from one member to the next."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from ..base.checks import instance, one_number, rows, whole_number
from ..base.errors import NoMemberError, ParameterError
from ..base.types import Floats
from .family import Family, columns

MOST_POINTS = 100_000
"""Largest number of members of a branch, since each one is solved for."""


class Branch(NamedTuple):
    """A run of members found by continuation along `at`."""

    at: Floats
    """Family parameter, shape (n,)."""
    state: Floats
    """State of each member, shape (n, states)."""
    complete: bool
    """Whether the whole interval was reached."""
    ended: str
    """A sentence that says where and why the branch ended."""


def branch(
    family: Family, start: float, stop: float, parameters: ArrayLike, *, points: int = 101,
    guess: ArrayLike | None = None, fixed: Sequence[float] = (),
) -> Branch:  # fmt: skip
    """Follow a family along its first `at`: tangent predictor, root-finder as corrector.

    Parameters
    ----------
    family
        The family.
    start, stop
        Interval of the first family parameter; either may be the larger.
    parameters
        The system's other parameters, shape (m,).
    points
        Number of members, evenly spaced.  Steps in between are halved where the corrector fails.
    guess
        First guess of the unknowns at `start`, shape (u,); the family's guess when left out.
    fixed
        Values of the further family parameters, if the family has more than one.

    Returns
    -------
    Branch
        Members up to `stop`, or up to the point where the branch ended.

    Raises
    ------
    ParameterError
        If there are fewer than two points.
    NoMemberError
        If there is no member at `start`.

    Examples
    --------
    >>> from stability.bodies.thin_disk.disk_families import disk_family
    >>> run = branch(disk_family("tumbling", "viscous"), 1.5, 0.1, [0.25, 0.3], points=5)
    >>> run.complete, float(run.state[0, 2].round(6))
    (True, 2.00251)
    """
    instance("family", family, Family, "give a stability.Family")
    points = whole_number("points", points, 2, MOST_POINTS, "follow a longer branch in pieces")
    lo, hi = one_number("start", start), one_number("stop", stop)
    rest = rows("fixed", fixed, family.at[1:])
    q = rows("parameters", parameters, family.parameters)
    for what, given in (("fixed", rest), ("parameters", q)):
        if given.ndim != 1:
            raise ParameterError(f"{what} has shape {given.shape}; give one axis of numbers.")
    q = q[None, :]
    values: list[float] = []
    unknowns: list[Floats] = []
    here = lo
    u = family.solve(np.array([[lo, *rest]]), q, guess)
    ended = f"the whole interval from {lo:g} to {hi:g} was reached"
    complete = True
    for target in np.linspace(lo, hi, points):
        try:
            u, here = _advance(family, here, float(target), u, q, rest), float(target)
        except NoMemberError as error:
            complete, ended = False, f"ended after {values[-1]:g}: {error}"
            break
        values.append(here)
        unknowns.append(u[0])
    at = np.array(values)
    a = np.hstack([at[:, None], np.tile(rest, (len(at), 1))])
    states = family.states(a, np.array(unknowns), np.tile(q, (len(at), 1)))
    return Branch(at, states, complete, ended)


def _advance(
    family: Family, here: float, target: float, u: Floats, q: Floats, rest: Floats
) -> Floats:
    """One continuation step, halved up to ten times where the corrector fails."""
    step, goal = target - here, target
    least = abs(target - here) / 1024
    while here != goal:
        a = np.array([[here, *rest]])
        _, _, _, r_u, r_a = family.graph.tangent.arrays([columns(a), columns(u), columns(q)], (1,))
        slope = -np.linalg.solve(r_u, r_a)[0, :, 0] if u.size and not family.closed else 0.0
        following = goal if abs(goal - here) <= abs(step) else here + step
        try:
            new = np.array([[following, *rest]])
            u = family.solve(new, q, u + slope * (following - here) if u.size else None)
            here = following
        except NoMemberError:
            step /= 2
            if abs(step) < least:
                raise
    return u
