"""Proved discs about the eigenvalues of one real matrix, in double precision.

With approximate eigenvectors X and R ≈ X⁻¹, let E = 1 - R X and G = R (A X - X Λ).  Then
X⁻¹ A X = Λ + H with H = (1 - E)⁻¹ G, and Gershgorin's theorem bounds the eigenvalues.  Every
rounding has an a priori bound, for any order in which a matrix product is summed, with or without
fused operations.  A X is computed from slices whose products are exact, so that G is the true
defect of the pairs and not the rounding noise of a long sum.

Source: S. M. Rump, Acta Numerica 19 (2010) 287-449; K. Ozaki, T. Ogita, S. Oishi, S. M. Rump,
Numer. Algorithms 59 (2012) 95-118 (slices); J. H. Wilkinson, The Algebraic Eigenvalue Problem
(1965), ch. 9 (a small disc by a similarity); tests/algebra/test_eigenvalue_discs.py.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..base.errors import DomainError
from ..base.types import Complexes, Floats
from .eigensolver import eigenpairs
from .kernels.pairs import two_product, two_sum
from .running_error import TINY, UNIT

MORE = 1.01
"""Factor for the roundings of sums and products of bounds, none of which is negative."""
LOST = 2.0**-1000
"""Above what underflow may lose in one operation on numbers of size 1."""
SLICES = 4
"""Slices of each factor of a product."""
SAFE = 1 + 1e-9
"""Factor that covers the roundings of a comparison."""


class Discs(NamedTuple):
    """Discs about the eigenvalues of one matrix."""

    values: Complexes
    """Centres, shape (n,)."""
    radius: Floats
    """Radii, shape (n,); all infinite where nothing is proved."""
    alone: NDArray[np.bool_]
    """Whether the disc meets no other, and so holds one eigenvalue.  The discs that meet are one
    cluster: each of them holds all its eigenvalues, as many as it has discs."""


def eigenvalue_discs(matrix: Floats, error: Floats) -> Discs:
    """Discs that hold the eigenvalues of every real matrix within an error of a matrix.

    Parameters
    ----------
    matrix, error
        The matrix, and a bound on the error of each entry, shape (n, n).

    Returns
    -------
    Discs

    Examples
    --------
    >>> discs = eigenvalue_discs(np.array([[0.0, 1.0], [-2.0, -3.0]]), np.zeros((2, 2)))
    >>> sorted(discs.values.real.round(12).tolist()), bool(discs.radius.max() < 1e-15)
    ([-2.0, -1.0], True)
    """
    n = len(matrix)
    nothing = Discs(np.zeros(n, dtype=complex), np.full(n, np.inf), np.zeros(n, dtype=bool))
    if not (np.isfinite(matrix).all() and np.isfinite(error).all()):
        return nothing
    if n == 1:
        return Discs(matrix[0].astype(complex), MORE * error[0], np.ones(1, dtype=bool))
    size = float(np.abs(matrix).max())
    if not 1e-200 < size < 1e200:
        return nothing
    with np.errstate(all="ignore"):  # what overflows proves nothing
        matrix, error, unit = _scaled(matrix, error, size)
        try:
            values, x = (part[0] for part in eigenpairs(matrix[None]))
            basis = basis_of(x, np.linalg.inv(x))
        except (np.linalg.LinAlgError, DomainError):
            return nothing
        if basis is None:
            return nothing
        discs = _gershgorin(values, *near_diagonal(basis, matrix, error, values))
        values, radius = unit * discs.values, unit * discs.radius + 2 * TINY
        fine = np.isfinite(values).all() and np.isfinite(radius).all()
        return Discs(values, radius, discs.alone) if fine else nothing


def _scaled(matrix: Floats, error: Floats, size: float) -> tuple[Floats, Floats, float]:
    """The matrix over a power of two, with rows and columns of like size by a similarity."""
    from scipy.linalg import matrix_balance

    unit = 2.0 ** np.frexp(size)[1]
    small = matrix / unit
    error = MORE * error / unit + LOST * ((error > 0) | (small * unit != matrix))
    matrix = small
    _, (scale, _) = matrix_balance(matrix, permute=False, separate=True)
    balanced = matrix / scale[:, None] * scale  # powers of two
    back = balanced / scale * scale[:, None]
    if not (np.isfinite(balanced).all() and (back == matrix).all()):
        return matrix, error, unit
    return balanced, error / scale[:, None] * scale + LOST * (error > 0), unit


def near_diagonal(
    basis: ProvedBasis, matrix: Floats, error: Floats, values: Complexes
) -> tuple[Complexes, Floats]:
    """H = X⁻¹ A X - Λ, and a bound on the error of each entry."""
    defect, doubt = _defect(matrix, values, basis.vectors)
    return basis.carried(defect, doubt + MORE * (error @ np.abs(basis.vectors)))


class ProvedBasis(NamedTuple):
    """Vectors that are proved to be a basis."""

    vectors: Complexes
    """The vectors as columns, shape (n, n)."""
    inverse: Complexes
    """An approximate inverse R."""
    flaw: Floats
    """Bounds on the row sums of |1 - R X|, less than 1/2."""

    def carried(self, product: Complexes, doubt: Floats) -> tuple[Complexes, Floats]:
        """X⁻¹ times a matrix, from this matrix and a bound on the error of each entry."""
        n = len(self.flaw)
        size = np.abs(self.inverse)
        near = self.inverse @ product
        bound = size @ (doubt + _rounding(n) * np.abs(product)) + n * LOST
        most = (np.abs(near) + bound).max(axis=0)  # of (1 - E)⁻¹ G, up to 1 / (1 - |E|)
        return near, MORE * (bound + self.flaw[:, None] * most / (1 - MORE * self.flaw.max()))

    def similar(self, matrix: Floats, error: Floats) -> tuple[Complexes, Floats]:
        """X⁻¹ A X, and a bound on the error of each entry."""
        n, size = len(matrix), np.abs(self.vectors)
        doubt = MORE * ((error + _rounding(n) * np.abs(matrix)) @ size) + n * LOST
        return self.carried(matrix @ self.vectors, doubt)


def basis_of(vectors: Complexes, inverse: Complexes) -> ProvedBasis | None:
    """Vectors as a basis; None where their inverse is not proved to be near."""
    n = len(vectors)
    off = np.abs(np.eye(n) - inverse @ vectors)
    off += _rounding(n) * (np.abs(inverse) @ np.abs(vectors)) + n * LOST
    flaw = MORE * off.sum(axis=1)
    return ProvedBasis(vectors, inverse, flaw) if flaw.max() < 0.5 else None


def _rounding(n: int) -> float:
    """√2 times that of 2 n products, for any order of the sum."""
    return 4 * (n + 2) * UNIT


def _defect(matrix: Floats, values: Complexes, x: Complexes) -> tuple[Complexes, Floats]:
    """A X - X Λ by sums of exact terms, and a bound on the error of each entry."""
    n = len(matrix)
    both = np.concatenate([x.real, x.imag], axis=1)
    bits = (53 - int(np.ceil(np.log2(2 * n)))) // 2
    left, right = list(_slices(matrix, bits)), list(_slices(both.T, bits))
    total, small = np.zeros_like(both), np.zeros_like(both)
    real, imag = np.tile(values.real, 2), np.concatenate([values.imag, -values.imag])
    swapped = np.concatenate([x.imag, x.real], axis=1)
    # (A - λ) x: real parts of the product, then its imaginary parts
    parts = [*two_product(-both, real), *two_product(swapped, imag)]
    parts += [a @ b.T for k, a in enumerate(left) if a.any() for b in right[: SLICES - k]]
    for term in parts:
        total, rest = two_sum(total, term)
        small = small + rest
    terms = len(parts)
    rows, columns = _above(matrix), _above(both.T)
    largest = np.abs(values).max()
    # what no product of slices has, and the sum of small terms (Ogita, Rump, Oishi 2005)
    cut = (SLICES + 2) * n * 2.0 ** (-SLICES * bits) + 4 * n * (terms * UNIT) ** 2
    bound = cut * rows[:, None] * columns + 8 * (terms * UNIT) ** 2 * largest * columns
    residual = total + small
    bound = MORE * (bound + 2 * UNIT * np.abs(residual)) + n * LOST
    return residual[:, :n] + 1j * residual[:, n:], bound[:, :n] + bound[:, n:]


def _above(rows: Floats) -> Floats:
    """The power of two above the largest entry of each row."""
    return np.asarray(np.ldexp(1.0, np.frexp(np.abs(rows).max(axis=1))[1]))


def _slices(rows: Floats, bits: int) -> Iterator[Floats]:
    """Slices of a few bits each, relative to the largest entry of a row, that sum up to it."""
    size = _above(rows)[:, None]
    for k in range(SLICES):
        shift = size * 2.0 ** (53 - bits - k * bits)
        part = (rows + shift) - shift
        rows = rows - part
        yield part


def _gershgorin(values: Complexes, near: Complexes, bound: Floats) -> Discs:
    """Discs of the rows of Λ + H, those that meet no other made small by a similarity."""
    shift = np.diag(near).copy()
    centre = values + shift
    inner = np.diag(bound) + 2 * UNIT * np.abs(centre)
    size = np.abs(near) + bound
    np.fill_diagonal(size, 0.0)
    row = MORE * size.sum(axis=1)
    radius = SAFE * (inner + row)
    gap = np.abs(centre[:, None] - centre)
    np.fill_diagonal(gap, np.inf)
    alone = (gap > SAFE * (radius[:, None] + radius)).all(axis=1)
    # coordinate i over 1/δ: its row shrinks by δ, its column in the other rows grows by 1/δ
    delta = np.minimum(4 * (size.T / gap).max(axis=1), 1.0)
    delta = np.where(delta > 0, delta, 2.0**-60)
    less = SAFE * (inner + delta * row)
    clear = gap > SAFE * (less[:, None] + radius + size.T / delta[:, None])
    radius = np.where(alone & clear.all(axis=1), less, radius)
    return _real(values, centre, radius) if alone.all() else _joined(centre, radius)


def _real(values: Complexes, centre: Complexes, radius: Floats) -> Discs:
    """Discs of the eigenvalues of a real matrix, each alone: on the real line, or in pairs."""
    radius = np.where(values.imag == 0, SAFE * (radius + np.abs(centre.imag)), radius)
    centre = np.where(values.imag == 0, centre.real, centre)
    order = np.lexsort((np.abs(values.imag), values.real))
    high, low = (order[sign * values.imag[order] > 0] for sign in (1, -1))
    if len(high) == len(low) and (values[low] == values[high].conj()).all():
        centre[low], radius[low] = centre[high].conj(), radius[high]  # of the conjugate disc
    return Discs(centre, radius, np.ones(len(values), dtype=bool))


def _joined(centre: Complexes, radius: Floats) -> Discs:
    """Discs that meet, each made as wide as its whole cluster."""
    from scipy.sparse.csgraph import connected_components

    gap = np.abs(centre[:, None] - centre)
    parts, wide = 0, radius
    while True:  # wider discs may meet further ones
        count, labels = connected_components(gap <= SAFE * (wide[:, None] + wide), directed=False)
        if count == parts:
            return Discs(centre, wide, np.bincount(labels)[labels] == 1)
        parts, same = count, labels[:, None] == labels
        alone = np.bincount(labels)[labels] == 1
        reach = np.where(same, gap + radius, 0.0).max(axis=1)
        wide = np.where(alone, radius, SAFE * reach)
