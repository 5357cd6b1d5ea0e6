"""The largest tube about members: how far |u| may reach.

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
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ...base.types import Floats
from ..surroundings import Surroundings
from .derivatives import Derivatives, derivatives
from .normal_form import ROOM, WIDE, Bounds, Form, normal_form

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
        return _largest(made, form, bounds, y, given)


def _third(
    made: Derivatives, form: Form, bounds: Bounds, y: Floats, given: Floats, r: Floats
) -> tuple[Floats, Floats, NDArray[np.bool_]]:
    """Bounds of the terms of third order of z' and w' for |z| ≤ r, and where guards are positive.

    Each has shape (N,).
    """
    m, at = made.across, 1 + given.shape[1]
    box = r[:, None] * bounds.rows * WIDE  # |e_i|
    aside = (np.abs(form.ell) * box).sum(1) * WIDE + ROOM
    mid = np.zeros((at + 3 * m, len(y)))
    rad = np.zeros_like(mid)
    mid[0], rad[0], mid[1:at], mid[at + 2 * m :] = y, aside * WIDE, given.T, form.ell.T
    rad[at : at + m] = rad[at + m : at + 2 * m] = box.T
    centre, radius = (v.T for v in made.third.run(mid, rad))
    size = (np.abs(centre) + radius) * WIDE
    across = (bounds.z @ size[:, :m, None])[..., 0] * WIDE
    along = (size[:, m] + (np.abs(form.ell) * size[:, :m]).sum(1)) * WIDE
    guards = made.positive.run(mid[: at + m], rad[: at + m])
    clear: NDArray[np.bool_] = np.asarray((guards[0] > guards[1]).all(0), dtype=bool)
    return np.sqrt(np.square(across).sum(1)) * WIDE, along, clear


def _largest(made: Derivatives, form: Form, b: Bounds, y: Floats, given: Floats) -> Tubes:
    """Nearly the largest radius at which the inequality holds, and what is within."""
    count = len(y)
    best, t, t_w, reach, rate, drift = np.zeros((6, count))
    low, high = np.zeros(count), np.ones(count)  # of log(MOST/r) over log(MOST/LEAST)
    for _ in range(HALVINGS):
        middle = (low + high) / 2
        r = MOST * (LEAST / MOST) ** middle
        third, along, clear = _third(made, form, b, y, given, r)
        found = _tube(b, r, third, along)
        good = clear & (found[0] > 0)
        for kept, new in zip(
            (best, t, t_w, reach, rate, drift), (r, third, along, *found), strict=True
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
    return Tubes(
        form, b.p, b.n, b.q, b.c, reach, rate, np.stack(inner, 1), np.stack(drifts, 1), half
    )


def _tube(b: Bounds, r: Floats, third: Floats, along: Floats) -> tuple[Floats, Floats, Floats]:
    """R, β and D/R of tubes with given radii; R is 0 where the inequality does not hold."""
    spread = 1 - b.c * r * WIDE
    delta = 1.05 * (OFF + b.q * r * r) / spread
    done = np.zeros(len(r), dtype=bool)
    own, beta, moved, none = np.zeros((4, len(r)))
    for _ in range(TURNS):
        shrink = 1 - (b.p * r + b.n * delta) * WIDE
        own = r * shrink / WIDE
        k, k_w = _left_over(b, r, delta, third / r, along / r)
        k_0, k_w0 = _left_over(b, none, delta, none, none)
        own_rate = b.slowest - b.turn_even * delta * WIDE
        beta, beta_0 = ((own_rate - v / shrink * WIDE) / WIDE for v in (k, k_0))
        moved = k_w0 * (1 / beta_0 + 1 / beta) / 2
        moved = (moved + (k_w - k_w0 / WIDE) * (1 / (6 * beta_0) + 1 / (3 * beta))) * WIDE
        moved = moved / shrink * WIDE  # D over R
        needed = (OFF + moved * own + b.q * r * r) / spread * WIDE
        done = (needed <= delta) & (delta <= ROOM) & (beta > 0) & (shrink > 0.5)
        done &= (spread > 0.5) & (b.slowest > 0) & (delta > 0)
        lost = ~((beta > 0) & (needed <= ROOM))
        if (done | lost).all():
            break
        # what is lost stays so: with more turns than it needs alone it might come back
        delta = np.where(done | lost, delta, 1.1 * needed)
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
