"""The inequality of `stability.settling.box` in balls of doubles: a kernel for `compiled`.

Z is an exact basis of doubles, z = Z e, and X an approximate inverse.  With F = Z X - 1 and
f ≥ |F|, Z⁻¹ = X (1 + F)⁻¹, |(1 + F)⁻¹| ≤ κ = 1/(1 - f), and |(1 + F)⁻¹ - 1| ≤ f κ.  So

    |row of Z⁻¹| ≤ κ |row of X|,   |v Z⁻¹| ≤ κ |v X|,
    entry (i, j) of Z J Z⁻¹ within f κ Σ_k |(Z J X)_ik| of that of Z J X.

Every bound is rounded up as in `stability.algebra.kernels.double_balls`, by WIDE in place of UP.
A length is the root of a sum of squares, to which TINY is added before the root, since squares may
underflow.  Arrays end with an axis of launches.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from ..algebra.kernels.double_balls import TINY, U, product

WIDE = 1.0 + 2.0**-40
"""Rounds up what at most 8000 roundings made: sums over m² entries, m ≤ 60."""


def length(m: Any, r: Any) -> Any:
    """Upper bound of the Euclidean length of a vector of balls, shape (entries, lanes)."""
    s = np.zeros_like(m[0])
    for i in range(m.shape[0]):
        v = np.abs(m[i]) + r[i]
        s = s + v * v
    return np.sqrt(s * WIDE + TINY) * WIDE


def product_right(b: Any, rb: Any, a: Any, c: Any, rc: Any) -> None:
    """Product of a matrix of balls with an exact one, as `product`."""
    for i in range(b.shape[0]):
        for j in range(a.shape[1]):
            s = np.zeros_like(b[0, 0])
            r = np.zeros_like(s)
            for k in range(a.shape[0]):
                s = s + b[i, k] * a[k, j]
                r = r + np.abs(a[k, j]) * (rb[i, k] + 64.0 * U * np.abs(b[i, k]))
            c[i, j] = s
            rc[i, j] = r * WIDE + TINY


def start(z: Any, x: Any, slow: Any, y: Any, ry: Any, e: Any, re: Any, centre: Any) -> Any:
    """Facts of a launch that no widening of its box changes.

    Parameters
    ----------
    z, x
        Basis and its approximate inverse, shape (m, m, lanes).
    slow
        Rows ℓ, shape (n, m, lanes).
    y, ry, e, re
        Parameters of the nearest member and deviation, as balls; e of shape (m, 1, lanes).
    centre
        Centres y_c, shape (n, lanes).

    Returns
    -------
    f, kappa, r, eta, rows, sideways
        f and κ as above, |Z e|, η, and upper bounds of the lengths of the rows of Z⁻¹ and ℓ Z⁻¹.
    """
    m, n, lanes = z.shape[0], slow.shape[0], z.shape[2]
    mid, rad = np.zeros((m, m, lanes)), np.zeros((m, m, lanes))
    product(z, x, np.zeros((m, m, lanes)), mid, rad)
    f = np.zeros(lanes)
    for i in range(m):
        mid[i, i] = mid[i, i] - 1.0
        for j in range(m):
            f = f + (np.abs(mid[i, j]) * WIDE + rad[i, j])
    f = f * WIDE
    gap = 1.0 - f
    kappa = WIDE / (0.5 * (gap + np.abs(gap)))
    along, off = np.zeros((m, 1, lanes)), np.zeros((m, 1, lanes))
    product(z, e, re, along, off)
    r = length(along[:, 0], off[:, 0])
    none = np.zeros((m, lanes))
    rows, eta, sideways = np.zeros((m, lanes)), np.zeros((n, lanes)), np.zeros((n, lanes))
    for i in range(m):
        rows[i] = length(x[i], none) * kappa * WIDE
    if n > 0:
        moved, over = np.zeros((n, 1, lanes)), np.zeros((n, 1, lanes))
        product(slow, e, re, moved, over)
        turned, wide = np.zeros((n, m, lanes)), np.zeros((n, m, lanes))
        product_right(slow, np.zeros((n, m, lanes)), x, turned, wide)
        for i in range(n):
            near = y[i] - moved[i, 0]
            far = near - centre[i]
            eta[i] = (np.abs(far) + U * np.abs(near) + ry[i] + over[i, 0]) * WIDE + TINY
            sideways[i] = length(turned[i], wide[i]) * kappa * WIDE
    return f, kappa, r, eta, rows, sideways


def turn(z: Any, x: Any, slow: Any, j: Any, rj: Any, f: Any, kappa: Any, r: Any, eta: Any) -> Any:
    """The rate β and the bound η + Γ r/β of a box.

    Parameters
    ----------
    z, x, slow, f, kappa, r, eta
        As for `start`.
    j, rj
        Slopes ∂G/∂e, then ∂g/∂e, on the box, shape (m + n, m, lanes).

    Returns
    -------
    beta, error
        A lower bound, shape (lanes,), and upper bounds, shape (n, lanes).
    """
    m, n, lanes = z.shape[0], slow.shape[0], z.shape[2]
    part, over = np.zeros((m, m, lanes)), np.zeros((m, m, lanes))
    w, rw = np.zeros((m, m, lanes)), np.zeros((m, m, lanes))
    product(z, j[:m], rj[:m], part, over)
    product_right(part, over, x, w, rw)
    loose = np.zeros((m, lanes))
    for i in range(m):
        for k in range(m):
            loose[i] = loose[i] + (np.abs(w[i, k]) + rw[i, k])
        loose[i] = loose[i] * (f * kappa) * WIDE + TINY
    highest = np.full(lanes, -np.inf)
    for i in range(m):
        s = rw[i, i] + loose[i]
        for k in range(m):
            if k != i:
                both = np.abs(w[i, k] + w[k, i]) + rw[i, k] + rw[k, i]
                s = s + 0.5 * (both + loose[i] + loose[k])
        s = s * WIDE + TINY
        top = w[i, i] + s
        highest = np.maximum(highest, top + 4.0 * U * (np.abs(w[i, i]) + s))
    beta = -highest
    error = np.zeros((n, lanes))
    if n > 0:
        moved, wide = np.zeros((n, m, lanes)), np.zeros((n, m, lanes))
        product(slow, j[:m], rj[:m], moved, wide)
        for i in range(n):
            for k in range(m):
                moved[i, k] = j[m + i, k] - moved[i, k]
                wide[i, k] = (rj[m + i, k] + wide[i, k] + U * np.abs(moved[i, k])) * WIDE + TINY
        drift, more = np.zeros((n, m, lanes)), np.zeros((n, m, lanes))
        product_right(moved, wide, x, drift, more)
        for i in range(n):
            push = length(drift[i], more[i]) * kappa * WIDE
            error[i] = (eta[i] + push * r / beta) * WIDE + TINY
    return beta, error
