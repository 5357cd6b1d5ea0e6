"""Continuation: a family followed along its parameter from one member to the next."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from .checks import checked
from .errors import NoMemberError, ParameterError, shown
from .families import Family, Floats, columns


class Branch(NamedTuple):
    """A run of members found by continuation along `at`."""

    at: Floats
    """Family parameter, shape (n,)."""
    state: Floats
    """State at each, shape (n, states)."""
    complete: bool
    """Whether the whole interval was reached."""
    ended: str
    """A sentence that says where and why it ended."""


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
        Number of members asked for, evenly spaced; steps in between are halved where the
        corrector needs it.
    guess
        Unknowns at `start`, shape (u,); the family's own guess when left out.
    fixed
        Values of the further family parameters, if the family has more than one.

    Returns
    -------
    Branch
        As far as it goes; it says where and why it ended.

    Raises
    ------
    ParameterError
        If there are fewer than two points.
    NoMemberError
        If there is no member at `start`.

    Examples
    --------
    >>> from stability.steady import disk_family
    >>> run = branch(disk_family("tumbling", "viscous"), 1.5, 0.1, [0.25, 0.3], points=5)
    >>> run.complete, float(run.state[0, 2].round(6))
    (True, 2.00251)
    """
    if not isinstance(family, Family):
        raise ParameterError(f"family is {shown(family)}; give a stability.Family.")
    if isinstance(points, bool) or not isinstance(points, int):
        raise ParameterError(f"points is {shown(points)}; a whole number is needed.")
    for what, given, names in (
        ("parameters", parameters, family.parameters), ("fixed", fixed, family.at[1:]),
    ):  # fmt: skip
        if np.size(given) != len(names) or (np.size(given) and np.ndim(checked(what, given)) != 1):
            raise ParameterError(f"{what} must hold {len(names)} values ({', '.join(names)}).")
    if points < 2:
        raise ParameterError(f"points is {points}; a branch needs at least 2.")
    lo, hi = float(checked("start", start)), float(checked("stop", stop))
    rest = np.asarray(fixed, dtype=float)
    q = np.atleast_2d(np.asarray(parameters, dtype=float))
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
