"""The largest tube about members: how far |u| may reach.

Within |z| ≤ r, |w| ≤ δ let a = 1 - |P| r - |N| δ > ½, so that |z| a ≤ |u|.  The terms that are left
obey |u' - M u - w L z| ≤ K |z| and |W'| ≤ K_w |z|.  Of w L u only the symmetric part of L changes
|u|.  With β = s - |L + Lᵀ| δ/2 - K/a > 0 a motion from |u| ≤ R = r a keeps |u| falling at the rate
β, so that it never reaches |z| = r, and W moves by at most D = K_w R/(a β).  Where
(|W| + D + |q| r²)/(1 - |c| r) ≤ δ, it never leaves |w| ≤ δ.  So it converges to the member y_c + W
within D.  The guards are positive on all of the tube.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ...base.types import Floats
from ..attraction import Surroundings
from .derivatives import Derivatives, derivatives
from .normal_form import ROOM, WIDE, Bounds, Form, normal_form

RADII = 0.16 * 0.75 ** np.arange(16)
"""Radii r that are tried, the largest first."""
STEP = 2.0**-13
"""Spacing of the members about which tubes are made."""
OFF = 0.75 * STEP
"""Largest |W| of a launch."""
INNER = 8.0 ** -np.arange(1, 5)
"""Radii of tubes within the largest one, over its radius: motions that start there drift less."""
TURNS = 8
"""Widenings of δ after which a radius is given up."""


@dataclass(frozen=True, eq=False)
class Tubes:
    """Tubes about members; the first axis counts them."""

    form: Form
    """Their coordinates."""
    p: Floats
    """|P|, shape (N,)."""
    n: Floats
    """|N|."""
    q: Floats
    """|q|."""
    c: Floats
    """|c|."""
    reach: Floats
    """Largest |u|; 0 where no tube is proved."""
    rate: Floats
    """β."""
    inner: Floats
    """Largest |u| of the largest tube and of those within it, shape (N, 1 + inner)."""
    drift: Floats
    """D over |u| in each of these."""
    half: Floats
    """Half the diagonal of a box across the family that holds the tube."""


def tubes(around: Surroundings, y: Floats, given: Floats) -> Tubes:
    """Tubes about members.

    Parameters
    ----------
    around
        Surroundings with a field.
    y, given
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
    form, bounds = normal_form(made, y, given)
    with np.errstate(all="ignore"):
        third, along, clear = _third(made, form, bounds, y, given)
        return _largest(form, bounds, third, along, clear)


def _third(
    made: Derivatives, form: Form, bounds: Bounds, y: Floats, given: Floats
) -> tuple[Floats, Floats, Floats]:
    """Bounds of the terms of third order of z' and w' for |z| ≤ r, and where guards are positive.

    Shapes (radii, N).
    """
    n, m, count = len(y), made.across, len(RADII)
    box = RADII[:, None, None] * bounds.rows * WIDE  # |e_i|, shape (radii, N, m)
    aside = (np.abs(form.ell) * box).sum(2) * WIDE + ROOM
    mid = np.zeros((1 + given.shape[1] + 3 * m, count, n))
    rad = np.zeros_like(mid)
    at = 1 + given.shape[1]
    mid[0], rad[0], mid[1:at] = y, aside * WIDE, given.T[:, None]
    rad[at : at + m] = rad[at + m : at + 2 * m] = np.moveaxis(box, 2, 0)
    mid[at + 2 * m :] = form.ell.T[:, None]
    flat = [v.reshape(len(v), -1) for v in (mid, rad)]
    centre, radius = (v.reshape(m + 1, count, n) for v in made.third.run(*flat))
    size = (np.abs(centre) + radius) * WIDE
    across = np.einsum("nij,jkn->ikn", bounds.z, size[:m]) * WIDE
    along = (size[m] + np.einsum("nj,jkn->kn", np.abs(form.ell), size[:m])) * WIDE
    guards = made.positive.run(*(v[: at + m] for v in flat))
    clear = (guards[0] > guards[1]).all(0).reshape(count, n)
    return np.sqrt(np.square(across).sum(0)) * WIDE, along, clear


def _largest(form: Form, b: Bounds, third: Floats, along: Floats, clear: Floats) -> Tubes:
    """The largest radius at which the inequality holds, member by member, and what is within."""
    count = len(b.p)
    best, t, t_w = np.zeros((3, count))
    reach, rate, drift = np.zeros((3, count))
    for r, own, own_w, fine in zip(RADII, third, along, clear, strict=True):
        if (best > 0).all():
            break
        radius = np.full(count, r)
        found = _tube(b, radius, own, own_w)
        take = (found[0] > 0) & (fine > 0) & (best == 0)
        for kept, new in zip((best, t, t_w, reach, rate, drift), (radius, own, own_w, *found),
                             strict=True):  # fmt: skip
            kept[take] = new[take]
    inner, drifts = [reach], [drift]
    for share in INNER:  # a term of third order falls with the cube of the radius
        cube = share**3 * WIDE
        r, _, d = _tube(b, share * best, t * cube, t_w * cube)
        inner.append(r)
        drifts.append(d)
    half = best * np.sqrt(np.square(b.rows).sum(1)) * WIDE
    return Tubes(form, b.p, b.n, b.q, b.c, reach, rate, np.stack(inner, 1), np.stack(drifts, 1),
                 half)  # fmt: skip


def _tube(b: Bounds, r: Floats, third: Floats, along: Floats) -> tuple[Floats, Floats, Floats]:
    """R, β and D/R of tubes with given radii; R is 0 where the inequality does not hold."""
    spread = 1 - b.c * r * WIDE
    delta = 1.05 * (OFF + b.q * r * r) / spread
    done = np.zeros(len(r), dtype=bool)
    own, beta, moved = np.full((3, len(r)), np.nan)
    for _ in range(TURNS):
        shrink = 1 - (b.p * r + b.n * delta) * WIDE
        own = r * shrink / WIDE
        k, k_w = _left_over(b, r, delta, third / r, along / r)
        beta = (b.slowest - (b.turn_even * delta + k / shrink) * WIDE) / WIDE
        moved = k_w / (shrink * beta) * WIDE
        needed = (OFF + moved * own + b.q * r * r) / spread * WIDE
        done = (needed <= delta) & (delta <= ROOM) & (beta > 0) & (shrink > 0.5)
        done &= (spread > 0.5) & (b.slowest > 0) & (delta > 0)
        if done.all():
            break
        delta = np.where(done, delta, 1.1 * needed)
    return np.where(done, own, 0.0), beta, moved


def _left_over(
    b: Bounds, r: Floats, delta: Floats, third: Floats, along: Floats
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
