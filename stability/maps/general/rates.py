"""Growth rates and verdicts of many members from their polynomials' coefficients.

Each root lies in a disc that is proved to hold it.  Weierstrass' correction improves all roots of a
polynomial at once.  A cell starts from the roots of a cell near it, some cells from the
eigensolver.  The discs |z - z_i| <= n |w_i| around any n different numbers, with Weierstrass'
corrections w_i, hold all roots, and as many in each connected part as it has discs.

Sources: K. Dvorčuk, Apl. Mat. 14 (1969) 207-223 (the correction); D. Braess & K. P. Hadeler, Numer.
Math. 21 (1973) 161-165 (the discs); tests/maps/test_own_maps.py.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Sequence
from functools import reduce
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ...algebra.eigensolver import eigenvalues_alone
from ...algebra.exact.number_fields import characteristic
from ...algebra.running_error import TINY, UNIT
from ...base.axis import Axis
from ...base.types import Complexes, Floats
from ...base.verdict import CODES, NO_MEMBER, Verdict
from ...storage.pieces import Chunk
from ..tiles import Codes
from .slice_verdicts import ELSEWHERE

BLOCK = 4096
"""Numbers of one root, and polynomials, in a block, so that the arrays stay in the cache."""
STRIDE = 32
"""Distance between the cells of a row of cells at which the eigensolver starts."""
STEPS = 3
"""Corrections of a cell that starts from a cell near it."""

MORE = 3
"""Most further corrections of cells whose discs are large."""
SMALLEST_SQUARE = 1e-290
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
        rough /= np.maximum(_size(others) - 2 * SMALLEST_SQUARE**0.5, 0.0)
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
    square += SMALLEST_SQUARE
    out: Floats = np.sqrt(square, out=square)
    return out


def most(values: Any) -> Floats:
    """The largest of each column, faster than NumPy's own reduction of few rows."""
    out: Floats = reduce(np.maximum, values)
    return out


WANTED = 1e-10
"""Error of the abscissa, relative to the largest modulus, beyond which a cell is computed again."""
SAMPLE = 16
"""Cells along each axis on which discs are tried before a map."""
MOST_POOR = 0.25
"""Share of these cells beyond which the graph takes all cells."""
MOST_STATES = 12
"""Largest degree of a polynomial whose roots are found here."""


class Rates(NamedTuple):
    """Quantities of the eigenvalues of many members."""

    abscissa: Floats
    """Largest real part, shape (N,)."""
    error: Floats
    """Bound on its error, shape (N,)."""
    frequency: Floats
    """|Im| of the eigenvalue with the largest real part, shape (N,)."""
    codes: NDArray[np.int8]
    """Verdict flags, 0 where the discs do not decide, shape (N,)."""
    values: Complexes | None
    """All eigenvalues, sorted, shape (N, n); None unless asked for."""
    poor: NDArray[np.bool_]
    """Where the discs meet or are large, shape (N,)."""


def of_eigenvalues(values: Complexes, radius: Floats, codes: Codes) -> Rates:
    """Quantities of sorted eigenvalues with discs."""
    lead = values[:, -1]
    error = (radius + (values.real - lead.real[:, None])).max(axis=1)
    poor = np.zeros(len(values), dtype=bool)
    return Rates(lead.real, error, np.abs(lead.imag), codes, values, poor)


def arrays_of(found: Any, *, modes: bool, unit: Floats | None = None) -> Chunk:
    """The arrays of a chunk of a map but its flags, times a unit of rate of each member."""
    names = ("abscissa", "error", "frequency", *(["values"] * modes))
    arrays = {name: getattr(found, name) for name in names}
    if unit is None:
        return arrays
    return {n: v * (unit if v.ndim == 1 else unit[:, None]) for n, v in arrays.items()}


LEFT = "left"
"""Key in a chunk, in addition to its arrays: number of cells sent to exact arithmetic."""
Room = tuple[Any, ...]
"""Arrays for abscissa, bound on its error, |imaginary part| and flags, each flat."""


class Bands(ABC):
    """The cells of a map by a polynomial, many rows at a time."""

    modes: bool
    """Whether to keep all eigenvalues."""
    how: str
    """Method in words."""
    growth: bool
    """Whether the discs are good enough for growth rates."""
    swept = False
    """Whether compiled loops run over the cells, so that many rows at once need no more memory."""
    complete = False
    """Whether no cell is left to the graph."""

    @abstractmethod
    def band(self, xs: Floats, ys: Floats, room: Room | None = None) -> Chunk:
        """The arrays of a grid, flat; the error is infinite in cells that are left to the graph.

        Compiled loops may fill the arrays of `room`.
        """


class DerivedBands(Bands):
    """The same by a polynomial or formulas of a family, which leave some cells to the graph."""

    @abstractmethod
    def judged(self, xs: Floats, ys: Floats) -> tuple[Codes, int, Rates]:
        """Flags, `ELSEWHERE` where none is proved, cells decided over Q, and growth rates, flat."""

    def band(self, xs: Floats, ys: Floats, room: Room | None = None) -> Chunk:  # noqa: ARG002
        """As for every band."""
        codes, exact, found = self.judged(xs, ys)
        found.error[(found.poor & (codes != NO_MEMBER)) | (codes == ELSEWHERE)] = np.inf
        return {LEFT: np.array([exact]), "codes": codes, **arrays_of(found, modes=self.modes)}


def sample(axes: tuple[Axis, Axis]) -> list[Floats]:
    """A few values of each axis."""
    return [g.values[:: max(1, g.count // SAMPLE)] for g in axes]


Coefficients = tuple[Floats, Floats]
"""Coefficients of a monic polynomial below its leading one, and bounds on their errors, (n, N)."""


def rates(factors: Sequence[tuple[Coefficients, bool, int]], *, modes: bool) -> Rates:
    """Eigenvalues from the coefficients of factors.

    Parameters
    ----------
    factors
        (coefficients, whether even, multiplicity) of each factor of a polynomial.
    modes
        Whether to return all eigenvalues.
    """
    if len(factors) == 1 and factors[0][1] and factors[0][0][0].shape[0] == 2 and not modes:
        return _of_square(*factors[0][0])
    with np.errstate(all="ignore"):
        parts = [
            (_mirrored(discs(a[::2], e[::2])) if even else discs(a, e), even, count)
            for (a, e), even, count in factors
        ]
        real = [part.roots.real for part, _, _ in parts]
        # on the imaginary axis by symmetry, without an error of the real part
        spread = [
            np.where(r == 0, 0.0, part.radius) if even else part.radius
            for r, (part, even, _) in zip(real, parts, strict=True)
        ]
        x, r = np.concatenate(real), np.concatenate(spread)
        z = np.concatenate([part.roots for part, _, _ in parts])
        apart = np.logical_and.reduce([part.apart for part, _, _ in parts])
        top = most(x)
        low, high = most(x - r), most(x + r)
        error = np.maximum(high - top, top - low)
        error += np.where(error > 0, 4 * UNIT * np.abs(top), 0.0)
        lead = most(np.where(x == top, np.abs(z.imag), 0.0))
        largest = most(np.abs(x) + np.abs(z.imag))
        even = any(even for _, even, _ in parts)
        sure = (high <= 0) if even else (high < 0)
        codes = np.where(sure, np.int8(CODES[Verdict.NEUTRAL if even else Verdict.STABLE]), 0)
        codes = np.where(low > 0, np.int8(CODES[Verdict.UNSTABLE]), codes)
        codes = np.where(apart, codes, 0).astype(np.int8)
        values = None
        if modes:
            every = [p.roots for p, _, count in parts for _ in range(count)]
            values = sorted_modes(np.concatenate(every))
        poor = ~(apart & (error <= WANTED * largest))
    return Rates(top, error, lead, codes, values, poor)


def sorted_modes(values: Complexes) -> Complexes:
    """The eigenvalues of each member by real and imaginary part, from those by mode."""
    spectrum = np.ascontiguousarray(values.T)
    order = np.lexsort((spectrum.imag, spectrum.real), axis=-1)
    return np.take_along_axis(spectrum, order, -1)


def _of_square(a: Floats, error: Floats) -> Rates:
    """The same for λ² + a₀, in a third of the time: λ² = y is real, |√y - √z| ≤ |y - z|/√y."""
    with np.errstate(all="ignore"):
        y, off = -a[0], error[0]
        size = np.sqrt(np.abs(y))
        radius = off / size * (1 + 8 * UNIT) + 4 * UNIT * size
        grows = y > 0
        apart = radius < size  # so that off < |y|: the sign of y is sure
        top, lead = np.where(grows, size, 0.0), np.where(grows, 0.0, size)
        bound = np.where(np.isfinite(radius), radius + 8 * UNIT * size, np.inf)
        bound = np.where(grows, bound, 0.0)
        sign = np.where(grows, np.int8(CODES[Verdict.UNSTABLE]), np.int8(CODES[Verdict.NEUTRAL]))
        codes = np.where(apart, sign, np.int8(0))
        poor = ~(apart & (bound <= WANTED * size))
    return Rates(top, bound, lead, codes, None, poor)


def _mirrored(squares: Discs) -> Discs:
    """±√y for the roots y = λ² of an even factor: |λ - λ'| |λ + λ'| = |y - y'|."""
    y, r = squares.roots, squares.radius
    real = y.imag == 0
    size = np.sqrt(np.abs(y))
    root = np.where(real & (y.real < 0), 1j * size, np.sqrt(y))
    radius = r / size * (1 + 8 * UNIT) + 4 * UNIT * size
    radius[~np.isfinite(radius)] = np.inf
    # the sign of a real y must be sure, or its roots are neither real nor imaginary
    apart = squares.apart & (~real | (np.abs(y.real) > r)).all(axis=0)
    apart &= (radius < size).all(axis=0)
    return Discs(np.concatenate([root, -root]), np.concatenate([radius, radius]), apart)


def monic(values: Sequence[Floats], errors: Sequence[Floats]) -> Coefficients:
    """Coefficients divided by the leading one, with bounds on their errors.

    Parameters
    ----------
    values, errors
        Coefficients by powers and bounds on their errors, arrays of one shape.
    """
    lead, off = np.abs(values[-1]), errors[-1]
    least = np.maximum(lead - off, 0.0)
    out, bounds = [], []
    for v, e in zip(values[:-1], errors[:-1], strict=True):
        quotient = v / values[-1]
        out.append(quotient)
        size = np.abs(quotient)
        bounds.append(1.01 * ((e + size * off) / least + 2 * UNIT * size))
    return np.array(out), np.array(bounds)


def of_matrices(matrix: Floats, error: Floats) -> Coefficients:
    """Coefficients of det(λ - A), each with a bound on its error.

    Parameters
    ----------
    matrix, error
        Matrices and bounds on the errors of their entries, shapes (N, n, n).
    """
    count, n = matrix.shape[:2]
    out, bounds = np.empty((n, count)), np.empty((n, count))
    used = (matrix != 0).any(axis=0) | (error != 0).any(axis=0)
    for first in range(0, count, BLOCK):
        rows = slice(first, first + BLOCK)
        out[:, rows], bounds[:, rows] = _of_block(matrix[rows], error[rows], used)
    return out, bounds


def _of_block(matrix: Floats, error: Floats, used: NDArray[np.bool_]) -> Coefficients:
    n = matrix.shape[-1]
    entries: list[list[Any]] = [
        [np.ascontiguousarray(matrix[:, i, j]) if used[i, j] else 0 for j in range(n)]
        for i in range(n)
    ]
    sizes: list[list[Any]] = [
        [np.abs(matrix[:, i, j]) + error[:, i, j] if used[i, j] else 0 for j in range(n)]
        for i in range(n)
    ]
    values, largest = characteristic(entries), _sizes(sizes)
    # entries off by a share ε of their size change a product of k of them by at most k ε
    share: Any = 0.0
    for i in range(n):
        for j in range(n):
            if used[i, j]:
                w = sizes[i][j]
                share = np.maximum(share, np.where(w > 0, error[:, i, j] / w, 0.0))
    out, bounds = np.empty((n, len(matrix))), np.empty((n, len(matrix)))
    # roundings on the way to a coefficient: at stage s, s for each of its entries of A but one, and
    # s + 2 for the sum over the stage; the entries of all stages are at most n
    rounding = (1.5 * n * n + 2.5 * n + 2) * UNIT
    for k in range(n):
        out[k] = values[k]
        bounds[k] = 1.01 * (rounding + 1.01 * (n - k) * share) * largest[k] + TINY * n**4
    return out, bounds


def _sizes(matrix: list[list[Any]]) -> list[Any]:
    """The steps of `characteristic` with sizes: nothing cancels, so that it bounds every sum."""
    poly: list[Any] = [1.0]
    for n in range(len(matrix)):
        row, column = matrix[n][:n], [matrix[i][n] for i in range(n)]
        band: list[Any] = [1.0, matrix[n][n]]
        for _ in range(n):
            band.append(_dot(row, column))
            column = [_dot(matrix[i][:n], column) for i in range(n)]
        poly = [_dot(band[i::-1], poly) for i in range(n + 2)]
    return poly[::-1]


def _dot(left: Sequence[Any], right: Sequence[Any]) -> Any:
    """A sum of products; the integer 0 means nothing."""
    terms = [
        v * w
        for v, w in zip(left, right, strict=False)
        if not (isinstance(v, int) or isinstance(w, int))
    ]
    return sum(terms[1:], start=terms[0]) if terms else 0
