"""Many states at once: the nearest family of each, and whether it is proved to settle there.

Distances come first, by array operations alone, so that a state far from every family costs less
than a microsecond.  Only states within the limit, near a family that attracts, meet the proof.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from ...algebra.kernels.double_balls import U
from ...base.errors import StabilityError
from ...base.types import Floats
from ..attraction import Surroundings, attraction
from .kernel import Balls, Settled, nothing, settled_many

RIGHT_ANGLE = Balls(np.array([np.pi / 2]), np.array([U]))
"""π/2."""


class Place(Protocol):
    """A family near which states are placed."""

    @property
    def name(self) -> str:
        """Name of the family."""
        ...

    @property
    def attracting(self) -> Surroundings | None:
        """Surroundings of the family; None where no motion is proved to settle on it."""
        ...

    def place(self, states: Floats, p: Floats, *, plain: bool) -> tuple[Balls, Balls, Floats]:
        """Members' y, deviations e and second arguments of the programs, launch by launch.

        Entries are nan or infinite where the family has no member for a state.
        """
        ...


class Quick(Protocol):
    """A family that also says in double precision how far states are from it."""

    def near(self, states: Floats, p: Floats) -> tuple[Floats, Floats]:
        """Members' y, shape (launches, n), and distances, infinite where there is no member."""
        ...


@dataclass(frozen=True, eq=False)
class NearestMany:
    """The steady motions nearest to many states, and which of the states have settled."""

    names: tuple[str, ...]
    """Names of the families."""
    family: NDArray[np.int64]
    """Number of the nearest family among `names`, shape (launches,); -1 where there is none."""
    at: Floats
    """Parameters y of the nearest members, shape (launches, n), n the most of any family."""
    distance: Floats
    """Distances from them, shape (launches,)."""
    settled: Settled
    """Proofs; `limit` has the shape of `at`."""


def nearest_many(
    places: Sequence[Place], states: Floats, p: Floats, within: float | Floats, *,
    plain: bool = False,
) -> NearestMany:  # fmt: skip
    """The nearest family of each state, and whether its motion is proved to converge there.

    Parameters
    ----------
    places
        The families.
    states, p
        States, shape (launches, s), taken as exact; parameters, shape (launches, ·) or (·,).
    within
        Largest distance that counts as settled, shape () or (launches,).
    plain
        Whether NumPy does the work although Numba is installed.

    Returns
    -------
    NearestMany
    """
    p = np.broadcast_to(p, (len(states), np.shape(p)[-1]))
    count = len(states)
    with np.errstate(all="ignore"):  # a family without a member there is infinitely far
        near = [_near(one, states, p, plain=plain) for one in places]
    apart = np.nan_to_num(np.reshape([far for _, far in near], (len(places), count)), nan=np.inf)
    best = np.argmin(apart, axis=0) if places else np.zeros(count, int)
    distance = apart.min(axis=0, initial=np.inf)
    family = np.where(np.isfinite(distance), best, -1)
    most = max((y.shape[1] for y, _ in near), default=0)
    at = np.full((count, most), np.nan)
    whole = nothing(count, most)
    for i, (one, (members, _)) in enumerate(zip(places, near, strict=True)):
        here, n = family == i, members.shape[1]
        at[here, :n] = members[here]
        some = np.flatnonzero(here & (distance <= within))
        around = one.attracting if len(some) else None
        if around is None:
            continue
        with np.errstate(all="ignore"):
            y, e, given = one.place(states[some], p[some], plain=plain)
        found = _settled(around, y, given, e, plain=plain)
        whole.limit[some, :n] = found.limit
        for name in ("proved", "error", "rate", "reach", "nearer"):
            getattr(whole, name)[some] = getattr(found, name)
    return NearestMany(tuple(one.name for one in places), family, at, distance, whole)


def _near(one: Place, states: Floats, p: Floats, *, plain: bool) -> tuple[Floats, Floats]:
    """Members' y and distances from a family; only states that come near meet the balls."""
    near: Callable[[Floats, Floats], tuple[Floats, Floats]] | None = getattr(one, "near", None)
    if near is not None:  # `Quick`; a test of the protocol would cost more than the distances
        return near(states, p)
    y, e, _ = one.place(states, p, plain=plain)
    return y.mid, np.sqrt(np.square(e.mid).sum(1))


def _settled(around: Surroundings, y: Balls, given: Floats, e: Balls, *, plain: bool) -> Settled:
    """By the kernel; one by one in balls where the graph has a function without a kernel."""
    try:
        return settled_many(around, y, given, e, plain=plain)
    except StabilityError:
        from flint import arb

    found = nothing(len(given), around.along)
    exact = [[[arb(*v) for v in zip(*row, strict=True)] for row in zip(*b, strict=True)]
             for b in (y, e)]  # fmt: skip
    for i, (own, off) in enumerate(zip(*exact, strict=True)):
        one = attraction(around, given[i].tolist(), own, off)
        if one is not None:
            found.proved[i], found.limit[i] = True, one.limit
            found.error[i], found.rate[i], found.reach[i] = one.error, one.rate, one.reach
    return found
