"""Launches in the tubes of members on a grid, which all launches with the same numbers share."""

from __future__ import annotations

from functools import lru_cache
from itertools import accumulate, pairwise
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ...base.types import Floats
from ..surroundings import Surroundings
from .derivatives import derivatives
from .normal_form import LOOSE, WIDE, norm, slow_rows
from .radius import INNER, OFF, STEP, Tubes, tubes

MOST = 40_000
"""Tubes that are kept for one family."""
BLOCK = 16
"""Neighbours that are made together where launches share their numbers."""
SHARED = 4
"""Most sets of numbers at which they count as shared, two signs of a body's turning included."""
TOGETHER = 512
"""Tubes that are made together."""


class InTube(NamedTuple):
    """What tubes say of launches; each has shape (launches,)."""

    known: NDArray[np.bool_]
    """Whether the member nearby has a tube."""
    proved: NDArray[np.bool_]
    """Whether the launch is in it."""
    limit: Floats
    """Parameter of a member near the one that it converges to."""
    error: Floats
    """Bound on the distance of the two."""
    rate: Floats
    """Least rate at which the deviation falls, in the tube's coordinates."""
    half: Floats
    """Half the diagonal of a box across the family that holds the tube."""
    share: Floats
    """Radius of the tube over the launch's distance, in the tube's coordinates."""


def in_tube(around: Surroundings, y: Any, given: Floats, e: Any) -> InTube:
    """Which launches are in a tube in which every motion converges to the family.

    Parameters
    ----------
    around
        Surroundings with a field.
    y, e
        Parameters of the nearest members and deviations as balls (mid, rad) that contain the true
        values, shapes (launches,) and (launches, m).
    given
        Second argument of the programs, shape (launches, ·).

    Returns
    -------
    InTube

    Raises
    ------
    StabilityError
        If the graph has a function without a kernel.
    """
    kept, (at, _), (off, _) = _kept(around), y, e
    with np.errstate(all="ignore"):  # nan is never proved
        slow = np.nan_to_num(kept.slow(at, given), posinf=0.0, neginf=0.0)
        node = np.rint((at - (slow * off).sum(1)) / STEP)
        for _ in range(2):
            own = kept.rows(node, given)
            found, along = _told(own, node * STEP, y, e)
            aside = np.abs(along) > OFF
            if not aside.any():
                return found
            node = np.where(aside, np.rint(node + along / STEP), node)
        return found


def _told(own: _Row, centre: Floats, y: Any, e: Any) -> tuple[InTube, Floats]:
    """What the tubes about centres say of launches, and W."""
    (at, r_at), (off, r_off) = y, e
    z = _times(own.z, off)
    r_z = _times(np.abs(own.z), r_off + LOOSE * np.abs(off)) * WIDE
    slack, size = norm(r_z), norm(np.abs(z) + r_z)
    w = (at - centre) - (own.ell * off).sum(1)
    r_w = np.abs(at) + np.abs(centre) + (np.abs(own.ell * off)).sum(1)
    r_w = (r_at + (np.abs(own.ell) * r_off).sum(1) + LOOSE * r_w) * WIDE
    along = w + _square(own.q, z) + w * (own.c * z).sum(1)
    r_along = r_w * (1 + own.c_size * size) + np.abs(w) * own.c_size * (slack + LOOSE * size)
    r_along = (r_along + own.q_size * size * (2 * slack + LOOSE * size)) * WIDE
    far = size * (1 + own.p_size * size + own.n_size * (np.abs(w) + r_w)) * WIDE
    limit = centre + along
    drift = np.where(far[:, None] <= own.inner, own.drift, np.inf).min(1)
    error = drift * far * WIDE + r_along + LOOSE * (1 + np.abs(limit))
    known = own.reach > 0
    proved = known & (far <= own.reach) & ((np.abs(along) + r_along) * WIDE <= OFF)
    share = own.reach / far
    return InTube(known, proved, limit, error * WIDE, own.rate, own.half, share), along


def _times(a: Floats, b: Floats) -> Floats:
    out: Floats = (a @ b[..., None])[..., 0]
    return out


def _square(a: Floats, b: Floats) -> Floats:
    out: Floats = (b[:, None] @ a @ b[..., None])[:, 0, 0]
    return out


class _Row(NamedTuple):
    """Tubes, launch by launch, as in `Tubes` and its `Form`."""

    ell: Floats
    z: Floats
    q: Floats
    c: Floats
    p_size: Floats
    n_size: Floats
    q_size: Floats
    c_size: Floats
    reach: Floats
    rate: Floats
    half: Floats
    inner: Floats
    drift: Floats


class _Kept:
    """Tubes of one family that were made before."""

    def __init__(self, around: Surroundings) -> None:
        self.around, self.known = around, dict[bytes, Floats]()

    def slow(self, y: Floats, given: Floats) -> Floats:
        """The row ℓ at members, launch by launch."""
        m = self.around.across
        first, _ = derivatives(self.around).first.run(np.vstack([y, given.T]))
        return slow_rows(first.T.reshape(-1, m + 1, m))

    def rows(self, node: Floats, given: Floats) -> _Row:
        """The tubes about `node` steps, launch by launch."""
        asked = np.column_stack([node, given]) + 0.0  # -0 has other bytes than 0
        unique, mine = asked, np.zeros(1, int)
        if len(asked) != 1:  # one launch needs no sorting
            unique, mine = np.unique(asked, axis=0, return_inverse=True)
        keys, known = [row.tobytes() for row in unique], self.known
        new = unique[[key not in known for key in keys]]
        if len(new):
            if len(np.unique(new[:, 1:], axis=0)) <= SHARED:  # others will come nearby
                new[:, 0] = np.floor(new[:, 0] / BLOCK) * BLOCK
                new = np.repeat(np.unique(new, axis=0), BLOCK, axis=0)
                new[:, 0] += np.tile(np.arange(BLOCK), len(new) // BLOCK)
            made = self._made(new)
            # other threads may replace the table meanwhile, so this one answers from its own
            known, others = known | made, self.known | made
            self.known = made if len(others) > MOST else others
        return _row(np.array([known[k] for k in keys])[mine.ravel()], self.around.across)

    def _made(self, asked: Floats) -> dict[bytes, Floats]:
        made = dict[bytes, Floats]()
        for low in range(0, len(asked), TOGETHER):
            some = asked[low : low + TOGETHER]
            found = _flat(tubes(self.around, some[:, 0] * STEP, some[:, 1:]))
            made.update(zip((row.tobytes() for row in some), found, strict=True))
        return made


@lru_cache(maxsize=32)
def _kept(around: Surroundings) -> _Kept:
    return _Kept(around)


def _flat(found: Tubes) -> Floats:
    n, form = len(found.p), found.form
    parts = [
        form.ell,
        form.z,
        form.q,
        form.c,
        found.p,
        found.n,
        found.q,
        found.c,
        found.reach,
        found.rate,
        found.half,
        found.inner,
        found.drift,
    ]
    return np.concatenate([v.reshape(n, -1) for v in parts], axis=1)


def _row(table: Floats, m: int) -> _Row:
    ends = accumulate([0, m, m * m, m * m, m, *[1] * 7, 1 + len(INNER), 1 + len(INNER)])
    ell, z, q, c, *sizes, inner, drift = (table[:, a:b] for a, b in pairwise(ends))
    shape = (-1, m, m)
    flat = (v[:, 0] for v in sizes)
    parts: list[Floats] = [ell, z.reshape(shape), q.reshape(shape), c, *flat, inner, drift]
    return _Row(*parts)
