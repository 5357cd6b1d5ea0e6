"""Roots of many real polynomials of one degree, each in a disc that is proved to hold it.

Weierstrass' correction improves all roots of a polynomial at once.  A cell starts from the roots of
a cell near it, some cells from the eigensolver.  The discs |z - z_i| <= n |w_i| around any n
different numbers, with Weierstrass' corrections w_i, hold all roots, and as many in each connected
part as it has discs.

Sources: K. Dvorčuk, Apl. Mat. 14 (1969) 207-223 (the correction); D. Braess & K. P. Hadeler, Numer.
Math. 21 (1973) 161-165 (the discs); tests/maps/test_own_maps.py.
"""

from __future__ import annotations

from functools import reduce
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ...algebra.eigensolver import eigenvalues_alone
from ...algebra.running_error import UNIT
from ...base.types import Complexes, Floats

BLOCK = 4096
"""Numbers of one root in a block, so that the arrays stay in the cache."""
STRIDE = 32
"""Distance between the cells of a row of cells at which the eigensolver starts."""
STEPS = 3
"""Corrections of a cell that starts from a cell near it."""

MORE = 3
"""Most further corrections of cells whose discs are large."""
TINY = 1e-290
"""Added to the square of a modulus: above what an underflow may lose."""
GOOD = 1e-13
"""Radius of a disc, relative to the largest root, beyond which corrections are tried."""


class Discs(NamedTuple):
    """Approximate roots and radii, the root as first axis."""

    roots: Complexes
    """Shape (n, N)."""
    radius: Floats
    """Shape (n, N); infinite where nothing is proved."""
    apart: NDArray[np.bool_]
    """Whether no two discs of a polynomial meet, shape (N,): each then holds one root."""


def discs(a: Floats, error: Floats) -> Discs:
    """Roots of monic polynomials, with discs that hold the exact roots.

    Parameters
    ----------
    a, error
        Coefficients of powers 0 … n - 1 and bounds on their errors, shapes (n, N).  Neighbours in
        the last axis are near each other where that is possible.

    Returns
    -------
    Discs
        Real roots have no imaginary part where the discs do not meet.
    """
    n, count = a.shape
    with np.errstate(all="ignore"):
        if n == 1:
            return Discs(-a.astype(complex), error, np.ones(count, dtype=bool))
        roots = np.empty((n, count), dtype=complex)
        radius, apart = np.empty((n, count)), np.empty(count, dtype=bool)
        roots[:, ::STRIDE] = _started(a[:, ::STRIDE])
        step = STRIDE
        while step > 1:
            half = step // 2
            target = roots[:, half::step]
            some = np.ascontiguousarray(a[:, half::step])
            target[...] = _improved(some, roots[:, ::step][:, : target.shape[1]], STEPS)
            step = half
        _enclose(a, error, (roots, radius, apart), np.arange(count))
        left = np.flatnonzero(~apart)
        if len(left):  # the neighbour's roots may be of another kind: both real, or a pair
            own = np.ascontiguousarray(a[:, left])
            roots[:, left] = _improved(own, _started(own), STEPS)
            _enclose(a, error, (roots, radius, apart), left)
        for _ in range(MORE):  # convergence is quadratic
            left = np.flatnonzero(apart & (most(radius) > GOOD * most(_size(roots))))
            if not len(left):
                break
            before = roots[:, left], radius[:, left]
            own = np.ascontiguousarray(a[:, left])
            roots[:, left] = _improved(own, before[0], 1)
            _enclose(a, error, (roots, radius, apart), left)
            if (most(radius[:, left]) > 0.5 * most(before[1])).all():
                break
        real = apart & (np.abs(roots.imag) <= radius)  # its mirror image is in the same disc
        roots.imag[real] = 0.0
    return Discs(roots, radius, apart)


def _started(a: Floats) -> Complexes:
    """Eigenvalues of the companion matrices."""
    n, count = a.shape
    companion = np.zeros((count, n, n))
    companion[:, np.arange(1, n), np.arange(n - 1)] = 1.0
    companion[:, :, n - 1] = -a.T
    companion[~np.isfinite(companion).all(axis=(1, 2))] = 0.0
    return np.ascontiguousarray(eigenvalues_alone(companion).T.astype(complex))


def _improved(a: Floats, near: Complexes, steps: int) -> Complexes:
    """Roots after some corrections, block by block."""
    out = np.empty(near.shape, dtype=complex)
    for first in range(0, near.shape[1], BLOCK):
        rows = slice(first, first + BLOCK)
        coefficients, z = a[:, rows].astype(complex), near[:, rows].copy()
        for _ in range(steps):
            z -= _value(coefficients, z) / _others(z)[0]
        out[:, rows] = z
    return out


def _value(a: Any, z: Any) -> Any:
    """Values of monic polynomials at each of their numbers."""
    value = z + a[-1]
    for c in a[-2::-1]:
        value *= z
        value += c
    return value


def _others(z: Complexes, watch: bool = False) -> tuple[Complexes, Floats]:
    """Product of the distances to all other roots, and square of the least distance."""
    product = np.empty_like(z)
    least: Any = np.full(z.shape[1], np.inf)
    seen = np.zeros(len(z), dtype=bool)
    for i in range(len(z)):
        for j in range(i):
            gap = z[i] - z[j]
            if watch:
                np.minimum(least, gap.real**2 + gap.imag**2, out=least)
            for place, sign in ((i, 1.0), (j, -1.0)):
                if seen[place]:
                    product[place] *= gap
                else:
                    product[place], seen[place] = gap, True
                if sign < 0:
                    np.negative(product[place], out=product[place])
    return product, least


def _enclose(
    a: Floats, error: Floats, out: tuple[Complexes, Floats, NDArray[np.bool_]], index: Any
) -> None:
    """Radii of the discs of some polynomials, and whether these are apart."""
    roots, radius, apart = out
    n = len(a)
    # a complex product and sum are within 4 units, in Horner's scheme and among the distances
    unit, slack = 8.0 * (n + 2) * UNIT, 1 + 16.0 * (n + 1) * UNIT
    whole = len(index) == len(apart)
    for first in range(0, len(index), BLOCK):
        rows = slice(first, first + BLOCK)
        some: Any = rows if whole else index[rows]
        coefficients, z = a[:, some], roots[:, some]
        value = _size(_value(coefficients.astype(complex), z))
        others, least = _others(z, watch=True)
        size = _size(z)
        bounds = unit * np.abs(coefficients)
        bounds += error[:, some]
        rough = unit * size
        rough += bounds[-1]
        for c in bounds[-2::-1]:
            rough *= size
            rough += c
        rough *= 1.001
        rough += value
        rough *= n * slack
        rough /= np.maximum(_size(others) - 2 * TINY**0.5, 0.0)
        worst = most(rough)
        if not np.isfinite(worst).all():
            rough[~np.isfinite(rough)] = np.inf
            worst = most(rough)
        radius[:, some] = rough
        apart[some] = least > (2.000001 * worst) ** 2


def _size(z: Complexes) -> Floats:
    """Moduli within two roundings, too large by √TINY at most, never too small by an underflow."""
    square = z.real * z.real
    square += z.imag * z.imag
    square += TINY
    out: Floats = np.sqrt(square, out=square)
    return out


def most(values: Any) -> Floats:
    """The largest of each column, faster than NumPy's own reduction of few rows."""
    out: Floats = reduce(np.maximum, values)
    return out
