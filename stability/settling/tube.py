"""A tube about a line of steady motions in which every motion is proved to converge to the line.

The coordinates u and W are those of `normal_form.py`; the largest tube says how far |u| may reach.

Within |z| ≤ r, |w| ≤ δ let a = 1 - |P| r - |N| δ > ½, so that |z| a ≤ |u|.  The terms that are left
obey |u' - M u - w L z| ≤ K |z| and |W'| ≤ K_w |z|.  Of w L u only the symmetric part of L changes
|u|.  With β = s - |L + Lᵀ| δ/2 - K/a > 0 a motion from |u| ≤ R = r a keeps |u| falling at the rate
β, so that it never reaches |z| = r.

K, K_w, and the rate fall with |u|: at |u| = x R they are at most K⁰ + (K - K⁰) x, and so on, and at
least β⁰ - (β⁰ - β) x, since they are sums of powers.  W moves by at most ∫ K_w d|u|/(a β), so by

    D = r (K_w⁰ (1/β⁰ + 1/β)/2 + (K_w - K_w⁰) (1/(6 β⁰) + 1/(3 β))),

as 1/β is at most (1 - x)/β⁰ + x/β.  Where (|W| + D + |q| r²)/(1 - |c| r) ≤ δ, the motion never
leaves |w| ≤ δ.  So it converges to the member y_c + W within D.  The guards are positive on all of
the tube.

Tubes belong to members on a grid, which all launches with the same numbers share.
"""

from __future__ import annotations

from functools import lru_cache
from itertools import accumulate, pairwise
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..base.types import Floats
from .box import NEARER, NEAREST, Settled
from .normal_form import (
    LOOSE,
    ROOM,
    WIDE,
    DerivativeTapes,
    Form,
    NormalFormBounds,
    derivatives,
    norm,
    normal_form,
    slow_rows,
)
from .surroundings import Surroundings

INSIDE = 0.98
"""Part of a tube's radius over the distance at which the next try is made."""
LEAST, MOST = 1e-3, 0.16
"""Radii r between which the largest one is sought, by halving their logarithm."""
HALVINGS = 7
"""Halvings."""
STEP = 2.0**-11
"""Spacing of the members about which tubes are made."""
OFF = 0.75 * STEP
"""Largest |W| of a launch."""
INNER = 8.0 ** -np.arange(1, 5)
"""Radii of tubes within the largest one, over its radius: motions that start there drift less."""
TURNS = 8
"""Widenings of δ after which a radius is given up."""
MOST_NODES = 40_000
"""Tubes that are kept for one family."""
BLOCK = 16
"""Neighbours that are made together where launches share their numbers."""
SHARED = 4
"""Most sets of numbers at which they count as shared, two signs of a body's turning included."""
TOGETHER = 512
"""Tubes that are made together."""


class Tubes(NamedTuple):
    """Tubes about members; the first axis counts them, or the launches near them."""

    ell: Floats
    """ℓ of their coordinates, as in `Form`."""
    z: Floats
    """Z."""
    q: Floats
    """q."""
    c: Floats
    """c."""
    p_size: Floats
    """|P|, shape (N,)."""
    n_size: Floats
    """|N|."""
    q_size: Floats
    """|q|."""
    c_size: Floats
    """|c|."""
    reach: Floats
    """Largest |u|; 0 where no tube is proved."""
    rate: Floats
    """β."""
    half: Floats
    """Half the diagonal of a box across the family that holds the tube."""
    inner: Floats
    """Largest |u| of the largest tube and of those within it, shape (N, 1 + inner)."""
    drift: Floats
    """D over |u| in each of these."""


def tubes(around: Surroundings, y: Floats, arguments: Floats) -> Tubes:
    """Tubes about members.

    Parameters
    ----------
    around
        Surroundings with a field.
    y, arguments
        Members, shape (N,), and the second argument of the programs, shape (N, ·).

    Returns
    -------
    Tubes

    Raises
    ------
    StabilityError
        If the graph has a function without a kernel.
    """
    made = derivatives(around)
    form, bounds = normal_form(made, y, arguments)
    with np.errstate(all="ignore"):
        return _largest(made, form, bounds, y, arguments)


def _third(
    made: DerivativeTapes,
    form: Form,
    bounds: NormalFormBounds,
    y: Floats,
    arguments: Floats,
    r: Floats,
) -> tuple[Floats, Floats, NDArray[np.bool_]]:
    """Bounds of the terms of third order of z' and w' for |z| ≤ r, and where guards are positive.

    Each has shape (N,).
    """
    m, at = made.across, 1 + arguments.shape[1]
    box = r[:, None] * bounds.rows * WIDE  # |e_i|
    aside = (np.abs(form.ell) * box).sum(1) * WIDE + ROOM
    mid = np.zeros((at + 3 * m, len(y)))
    rad = np.zeros_like(mid)
    mid[0], rad[0], mid[1:at], mid[at + 2 * m :] = y, aside * WIDE, arguments.T, form.ell.T
    rad[at : at + m] = rad[at + m : at + 2 * m] = box.T
    centre, radius = (v.T for v in made.third.run(mid, rad))
    size = (np.abs(centre) + radius) * WIDE
    across = (bounds.z @ size[:, :m, None])[..., 0] * WIDE
    along = (size[:, m] + (np.abs(form.ell) * size[:, :m]).sum(1)) * WIDE
    guards = made.positive.run(mid[: at + m], rad[: at + m])
    clear: NDArray[np.bool_] = np.asarray((guards[0] > guards[1]).all(0), dtype=bool)
    return np.sqrt(np.square(across).sum(1)) * WIDE, along, clear


def _largest(
    made: DerivativeTapes, form: Form, b: NormalFormBounds, y: Floats, arguments: Floats
) -> Tubes:
    """Nearly the largest radius at which the inequality holds, and what is within."""
    count = len(y)
    best, t, t_w, reach, rate, drift = np.zeros((6, count))
    low, high = np.zeros(count), np.ones(count)  # of log(MOST/r) over log(MOST/LEAST)
    for _ in range(HALVINGS):
        middle = (low + high) / 2
        r = MOST * (LEAST / MOST) ** middle
        third, along, clear = _third(made, form, b, y, arguments, r)
        tube = _tube(b, r, third, along)
        good = clear & (tube[0] > 0)
        for kept, new in zip(
            (best, t, t_w, reach, rate, drift), (r, third, along, *tube), strict=True
        ):
            kept[good] = new[good]
        low, high = np.where(good, low, middle), np.where(good, middle, high)
    inner, drifts = [reach], [drift]
    for share in INNER:  # a term of third order falls with the cube of the radius
        cube = share**3 * WIDE
        r, _, d = _tube(b, share * best, t * cube, t_w * cube)
        inner.append(r)
        drifts.append(d)
    half = best * np.sqrt(np.square(b.rows).sum(1)) * WIDE
    sizes = b.p, b.n, b.q, b.c, reach, rate, half
    return Tubes(form.ell, form.z, form.q, form.c, *sizes, np.stack(inner, 1), np.stack(drifts, 1))


def _tube(
    b: NormalFormBounds, r: Floats, third: Floats, along: Floats
) -> tuple[Floats, Floats, Floats]:
    """R, β and D/R of tubes with given radii; R is 0 where the inequality does not hold."""
    spread = 1 - b.c * r * WIDE
    delta = 1.05 * (OFF + b.q * r * r) / spread
    done = np.zeros(len(r), dtype=bool)
    reach, beta, moved, none = np.zeros((4, len(r)))
    for _ in range(TURNS):
        shrink = 1 - (b.p * r + b.n * delta) * WIDE
        reach = r * shrink / WIDE
        k, k_w = _left_over(b, r, delta, third / r, along / r)
        k_0, k_w0 = _left_over(b, none, delta, none, none)
        own_rate = b.slowest - b.turn_even * delta * WIDE
        beta, beta_0 = ((own_rate - v / shrink * WIDE) / WIDE for v in (k, k_0))
        moved = k_w0 * (1 / beta_0 + 1 / beta) / 2
        moved = (moved + (k_w - k_w0 / WIDE) * (1 / (6 * beta_0) + 1 / (3 * beta))) * WIDE
        moved = moved / shrink * WIDE  # D over R
        needed = (OFF + moved * reach + b.q * r * r) / spread * WIDE
        done = (needed <= delta) & (delta <= ROOM) & (beta > 0) & (shrink > 0.5)
        done &= (spread > 0.5) & (b.slowest > 0) & (delta > 0)
        lost = ~((beta > 0) & (needed <= ROOM))
        if (done | lost).all():
            break
        # what is lost stays so: with more turns than it needs alone it might come back
        delta = np.where(done | lost, delta, 1.1 * needed)
    return np.where(done, reach, 0.0), beta, moved


def _left_over(
    b: NormalFormBounds, r: Floats, delta: Floats, third: Floats, along: Floats
) -> tuple[Floats, Floats]:
    """K and K_w: bounds of what is left of u' and W' over |z|, for |z| ≤ r and |w| ≤ δ."""
    inner = b.p * r + b.n * delta  # |u - z| over |z|
    rest = (b.still + b.turn * delta + b.bend * r + third) * WIDE  # |z' - M z| over |z|
    slow = (b.along + b.along_turn * delta + b.along_bend * r + along) * WIDE  # |w'| over |z|
    k = b.still + (b.turn_off + b.turn_left * inner) * delta + b.left * r + third
    k = (k + (2 * b.p * r + b.n * delta) * rest + b.n * slow * r) * WIDE
    k_w = b.along + (b.along_left + b.c * rest) * delta + b.along_bend_left * r + along
    k_w = (k_w + 2 * b.q * r * rest + b.c * r * slow) * WIDE
    return k, k_w


def in_tube(
    around: Surroundings, y: Any, arguments: Floats, e: Any
) -> tuple[NDArray[np.bool_], Settled]:
    """Which launches are in a tube in which every motion converges to the family.

    Parameters
    ----------
    around
        Surroundings with a field.
    y, e
        Parameters of the nearest members and deviations as balls (mid, rad) that contain the true
        values, shapes (launches,) and (launches, m).
    arguments
        Second argument of the programs, shape (launches, ·).

    Returns
    -------
    has_tube, proofs
        Whether the members nearby have a tube, shape (launches,), and which launches are in one.

    Raises
    ------
    StabilityError
        If the graph has a function without a kernel.
    """
    kept, (at, _), (off, _) = _tube_store(around), y, e
    with np.errstate(all="ignore"):  # nan is never proved
        slow = np.nan_to_num(kept.slow(at, arguments), posinf=0.0, neginf=0.0)
        node = np.rint((at - (slow * off).sum(1)) / STEP)
        for _ in range(2):
            tubes = kept.rows(node, arguments)
            proofs, along = _proofs(tubes, node * STEP, y, e)
            aside = np.abs(along) > OFF
            if not aside.any():
                break
            node = np.where(aside, np.rint(node + along / STEP), node)
        return tubes.reach > 0, proofs


def _proofs(tubes: Tubes, centre: Floats, y: Any, e: Any) -> tuple[Settled, Floats]:
    """Which launches are in the tubes about centres, and W."""
    (at, r_at), (off, r_off) = y, e
    z = _times(tubes.z, off)
    r_z = _times(np.abs(tubes.z), r_off + LOOSE * np.abs(off)) * WIDE
    slack, size = norm(r_z), norm(np.abs(z) + r_z)
    w = (at - centre) - (tubes.ell * off).sum(1)
    r_w = np.abs(at) + np.abs(centre) + (np.abs(tubes.ell * off)).sum(1)
    r_w = (r_at + (np.abs(tubes.ell) * r_off).sum(1) + LOOSE * r_w) * WIDE
    along = w + _square(tubes.q, z) + w * (tubes.c * z).sum(1)
    r_along = r_w * (1 + tubes.c_size * size) + np.abs(w) * tubes.c_size * (slack + LOOSE * size)
    r_along = (r_along + tubes.q_size * size * (2 * slack + LOOSE * size)) * WIDE
    far = size * (1 + tubes.p_size * size + tubes.n_size * (np.abs(w) + r_w)) * WIDE
    limit = centre + along
    drift = np.where(far[:, None] <= tubes.inner, tubes.drift, np.inf).min(1)
    error = drift * far * WIDE + r_along + LOOSE * (1 + np.abs(limit))
    has_tube = tubes.reach > 0
    proved = has_tube & (far <= tubes.reach) & ((np.abs(along) + r_along) * WIDE <= OFF)
    share = np.where(has_tube, np.clip(INSIDE * (tubes.reach / far), NEAREST, INSIDE), NEARER)
    parts = (limit, error * WIDE, tubes.rate, tubes.half)
    at, error, rate, half = (np.where(proved, v, np.nan) for v in parts)
    return Settled(proved, at[:, None], error, rate, half, share), along


def _times(a: Floats, b: Floats) -> Floats:
    out: Floats = (a @ b[..., None])[..., 0]
    return out


def _square(a: Floats, b: Floats) -> Floats:
    out: Floats = (b[:, None] @ a @ b[..., None])[:, 0, 0]
    return out


class _TubeStore:
    """Tubes of one family that were made before."""

    def __init__(self, around: Surroundings) -> None:
        self.around, self.stored = around, dict[bytes, Floats]()

    def slow(self, y: Floats, arguments: Floats) -> Floats:
        """The row ℓ at members, launch by launch."""
        m = self.around.across
        first, _ = derivatives(self.around).first.run(np.vstack([y, arguments.T]))
        return slow_rows(first.T.reshape(-1, m + 1, m))

    def rows(self, node: Floats, arguments: Floats) -> Tubes:
        """The tubes about `node` steps, launch by launch."""
        asked = np.column_stack([node, arguments]) + 0.0  # -0 has other bytes than 0
        unique, mine = asked, np.zeros(1, int)
        if len(asked) != 1:  # one launch needs no sorting
            unique, mine = np.unique(asked, axis=0, return_inverse=True)
        keys, stored = [row.tobytes() for row in unique], self.stored
        new = unique[[key not in stored for key in keys]]
        if len(new):
            if len(np.unique(new[:, 1:], axis=0)) <= SHARED:  # others will come nearby
                new[:, 0] = np.floor(new[:, 0] / BLOCK) * BLOCK
                new = np.repeat(np.unique(new, axis=0), BLOCK, axis=0)
                new[:, 0] += np.tile(np.arange(BLOCK), len(new) // BLOCK)
            made = self._made(new)
            # other threads may replace the table meanwhile, so this one answers from its own
            stored, others = stored | made, self.stored | made
            self.stored = made if len(others) > MOST_NODES else others
        return _read(np.array([stored[k] for k in keys])[mine.ravel()], self.around.across)

    def _made(self, asked: Floats) -> dict[bytes, Floats]:
        made = dict[bytes, Floats]()
        for low in range(0, len(asked), TOGETHER):
            some = asked[low : low + TOGETHER]
            parts = tubes(self.around, some[:, 0] * STEP, some[:, 1:])
            table = np.concatenate([v.reshape(len(some), -1) for v in parts], axis=1)
            made.update(zip((row.tobytes() for row in some), table, strict=True))
        return made


@lru_cache(maxsize=32)
def _tube_store(around: Surroundings) -> _TubeStore:
    return _TubeStore(around)


def _read(table: Floats, m: int) -> Tubes:
    """Tubes from the rows of a table, in which each field is flat."""
    ends = accumulate([0, m, m * m, m * m, m, *[1] * 7, 1 + len(INNER), 1 + len(INNER)])
    ell, z, q, c, *sizes, inner, drift = (table[:, a:b] for a, b in pairwise(ends))
    shape = (-1, m, m)
    parts = [ell, z.reshape(shape), q.reshape(shape), c, *(v[:, 0] for v in sizes), inner, drift]
    return Tubes(*parts)
