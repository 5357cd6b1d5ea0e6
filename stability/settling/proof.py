"""Proof that motions converge to one steady motion each: by the tube of a member, then by a box.

A tube belongs to a member that one number names, and all launches near it share it (`tube/`).
Where no tube is proved about a member, or none is known, a box about the state is tried (`box/`).
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ..base.errors import StabilityError
from ..base.types import Floats
from .box import LEAST, NEARER, Balls, Settled, attraction, boxes, nothing, tapes
from .surroundings import Surroundings
from .tube import in_tube

INSIDE = 0.98
"""Part of a tube's radius over the distance at which the next try is made."""


def settled(  # noqa: PLR0913
    around: Surroundings,
    y: Balls,
    given: Floats,
    e: Balls,
    *,
    alone: bool = False,
    plain: bool = False,
) -> Settled:
    """Which launches are proved to converge to one steady motion of a family.

    Parameters
    ----------
    around
        The family's surroundings.
    y, e
        Parameters of the nearest members and deviations, as balls that contain the true values,
        shapes (launches, n) and (launches, m).
    given
        Second argument of its programs, shape (launches, ·).
    alone
        Whether boxes are tried one by one in flint's balls.  One launch is then soonest done.
    plain
        Whether NumPy does the work although Numba is installed.

    Returns
    -------
    Settled

    Examples
    --------
    >>> import stability as st
    >>> from stability.settling.body_lines import disk_settling
    >>> spinning = disk_settling(st.Viscous).lines[1]
    >>> y, e = np.array([[2.5], [1.9]]), np.full((2, 5), 1e-5)
    >>> given = np.array([[1, 0.25, 0.3]] * 2)
    >>> settled(spinning.around, Balls(y, 0 * y), given, Balls(e, 0 * e)).proved
    array([ True, False])
    """
    found, left = nothing(len(given), around.along), np.ones(len(given), bool)
    try:
        tapes(around)
        if around.field is not None:
            left = ~_by_tubes(around, y, given, e, found)
        if left.any() and not alone:
            boxes(around, y, given, e, found, left, plain=plain)
            return found
    except StabilityError:  # a function without a kernel
        pass
    for i in np.flatnonzero(left):
        _alone(around, y, given, e, found, int(i))
    return found


def _by_tubes(
    around: Surroundings, y: Balls, given: Floats, e: Balls, found: Settled
) -> NDArray[np.bool_]:
    """Which launches are near a member with a tube; those in it are proved."""
    near = np.asarray(np.isfinite(np.hstack([y.mid, given, e.mid])).all(1), dtype=bool)
    if not near.any():
        return near
    balls = (y.mid[near, 0], y.rad[near, 0]), (e.mid[near], e.rad[near])
    told = in_tube(around, balls[0], given[near], balls[1])
    some = np.flatnonzero(near)
    fine = some[told.proved]
    found.proved[fine], found.limit[fine, 0] = True, told.limit[told.proved]
    for name, values in (("error", told.error), ("rate", told.rate), ("reach", told.half)):
        getattr(found, name)[fine] = values[told.proved]
    found.nearer[some] = np.where(told.known, np.clip(INSIDE * told.share, LEAST, INSIDE), NEARER)
    near[some] = told.known
    return near


def _alone(around: Surroundings, y: Balls, given: Floats, e: Balls, found: Settled, i: int) -> None:
    """Try the box of one launch in flint's balls."""
    from flint import arb

    own, off = (
        [arb(*v) for v in zip(b.mid[i].tolist(), b.rad[i].tolist(), strict=True)] for b in (y, e)
    )
    proof = attraction(around, given[i].tolist(), own, off)
    if proof is not None:
        found.proved[i], found.limit[i] = True, proof.limit
        found.error[i], found.rate[i], found.reach[i] = proof.error, proof.rate, proof.reach
