"""Eigenvalues with error discs, and the verdict they allow, for any family of any system.

Each eigenvalue carries a bound on its own error, from running error analysis of the graph and
Gershgorin's theorem after diagonalisation; a verdict is given only where those bounds decide.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..algebra.eigensolver import eigenpairs
from ..algebra.running_error import TINY, UNIT
from ..base.errors import DomainError
from ..base.types import Complexes, Floats
from ..base.verdict import CODES, Verdict
from .deflation import Reduced

NOT_STEADY = -2
"""In place of bits where a rate is proved not to vanish at the root of the equations."""
POOR = 8
"""Residual over its own rounding error from which vectors are refined."""
SPARE = 2.0**-20
"""Share of a radius that is less than the roundings which are counted but not made."""


def in_words(bits: int) -> str:
    """What arithmetic a proof took.

    Parameters
    ----------
    bits
        Precision of the balls, 0 for rational arithmetic.
    """
    return f"balls of {bits} bits" if bits else "rational arithmetic"


# --- eigenvalues and their error ---


class Eigenpairs(NamedTuple):
    """Eigenvalues and eigenvectors of matrices, in any order and without bounds."""

    values: Complexes
    """Shape (N, m)."""
    vectors: Complexes
    """As columns, shape (N, m, m)."""


class Enclosed(NamedTuple):
    """Eigenvalues with error discs, and the vectors that they were found with."""

    values: Complexes
    """Sorted by real, then imaginary part, shape (N, m)."""
    radius: Floats
    """Bound on the error of each, shape (N, m)."""
    pairs: Eigenpairs | None
    """From the eigensolver; None where the values came from a formula."""


def eigenvalues(reduced: Reduced, *, even: bool) -> Enclosed:
    """Eigenvalues with error bounds, sorted by real, then imaginary part.

    Parameters
    ----------
    reduced
        From `reduce`.
    even
        Whether the characteristic polynomial is even by structure; then λ² is computed, and real
        and imaginary parts come out as exact as the structure has them.

    Returns
    -------
    Enclosed
        The exact eigenvalues lie in the union of the discs, and a connected part of the union made
        of j discs holds j of them (Gershgorin); for an even polynomial the same holds of each λ
        separately.

    Raises
    ------
    DomainError
        If the linearisation is not finite.
    """
    if not reduced.matrix.shape[-1]:
        raise DomainError("every eigenvalue is zero by structure; there is no spectrum to judge.")
    if not np.isfinite(reduced.matrix).all():
        raise DomainError(
            "the linearisation overflows double precision; give values nearer to 1 "
            "(dimensionless mu, at and 1/k below 1e100)."
        )
    with np.errstate(all="ignore"):  # what overflows comes out as a disc without bound
        found = _even(reduced) if even else _general(reduced.matrix, reduced.error)
        values, radius, pairs = found
        radius = np.where(np.isfinite(radius), radius, np.inf)
    if not np.isfinite(values).all():
        raise DomainError("the eigenvalues overflow double precision; give values nearer to 1.")
    order = np.lexsort((values.imag, values.real), axis=-1)
    return Enclosed(
        np.take_along_axis(values, order, -1), np.take_along_axis(radius, order, -1), pairs
    )


def _general(matrix: Floats, error: Floats) -> Enclosed:
    """The eigensolver's eigenvalues, with Gershgorin discs of X⁻¹(B + E)X - Λ.

    The residual BX - XΛ is computed, so the solver's own error is measured, not assumed.
    Where it is large (LAPACK's balancing can do that to a matrix with a tiny entry) X is refined
    once.
    """
    values, x = eigenpairs(matrix)
    radius, excess = _discs(matrix, error, values, x)
    poor = np.flatnonzero(excess > POOR)
    if len(poor):
        better = _refined(matrix[poor], values[poor], x[poor])
        discs, _ = _discs(matrix[poor], error[poor], *better)
        gain = discs.max(axis=-1) < radius[poor].max(axis=-1)
        values[poor[gain]], radius[poor[gain]] = better[0][gain], discs[gain]
        x[poor[gain]] = better[1][gain]
    return Enclosed(values, radius, Eigenpairs(values, x))


def _discs(matrix: Floats, error: Floats, values: Complexes, x: Complexes) -> tuple[Floats, Floats]:
    """Gershgorin radii, and how far the residual stands above its own rounding error."""
    size = matrix.shape[-1]
    with np.errstate(all="ignore"):
        y: Complexes = _inverse(x)
        ax, ay = np.abs(x), np.abs(y)
        residual = np.abs(matrix @ x - x * values[:, None, :])
        # rounding of that residual: each entry is a sum of `size` products and one more
        terms = np.abs(matrix) @ ax + ax * np.abs(values)[:, None, :]
        rough = (size + 3) * (UNIT * terms + TINY) + error @ ax
        sums = (ay @ (residual + rough)).sum(axis=-1) + size * TINY
        flaw = np.abs(y @ x - np.eye(size)).sum(axis=-1).max(axis=-1)
        flaw += size * UNIT * (ay @ ax).sum(axis=-1).max(axis=-1)
        radius = sums / np.where(flaw < 0.5, 1 - flaw, 0.0)[:, None]
        excess = residual.max(axis=(1, 2)) / rough.max(axis=(1, 2))
        # a flaw of y mixes the rows: a bad vector reaches the discs of the good ones
        mixed = flaw[:, None] * radius.max(axis=-1, keepdims=True)
        radius = np.where((mixed > SPARE * radius) | (excess > POOR)[:, None], sums + mixed, radius)
    radius[~np.isfinite(radius)] = np.inf
    return radius, excess


def _refined(matrix: Floats, values: Complexes, x: Complexes) -> tuple[Complexes, Complexes]:
    """One step of Newton's method on all eigenpairs at once.

    Source: T. Ogita & K. Aishima, Japan J. Indust. Appl. Math. 35 (2018) 1007-1035, in its plain
    form for a matrix without symmetry.
    """
    with np.errstate(all="ignore"):
        near = _inverse(x) @ (matrix @ x)
        new = np.einsum("ijj->ij", near).copy()
        gap = new[:, None, :] - new[:, :, None]
        np.einsum("ijj->ij", gap)[...] = 1.0
        shift = near / gap
        np.einsum("ijj->ij", shift)[...] = 0.0
        vectors = x + x @ shift
    new = np.where(values.imag == 0, new.real, new)
    return new, vectors


def _inverse(x: Complexes) -> Complexes:
    try:
        return np.asarray(np.linalg.inv(x), dtype=complex)
    except np.linalg.LinAlgError:  # some row is exactly defective: that row has no bound
        out = np.full_like(x, np.nan)
        for index in range(len(x)):
            try:
                out[index] = np.linalg.inv(x[index])
            except np.linalg.LinAlgError:
                continue
        return out


def _even(reduced: Reduced) -> Enclosed:
    """Eigenvalues of a matrix whose characteristic polynomial is even by structure."""
    if reduced.matrix.shape[-1] == 2:
        return _one_square(reduced.matrix, reduced.error)
    # With λ also -λ̄ is an eigenvalue.  A disc that meets the imaginary axis is put symmetric to it;
    # if it then keeps clear of all others it holds one eigenvalue, which is its own mirror image.
    values, radius, pairs = _general(reduced.matrix, reduced.error)
    near = np.abs(values.real) <= radius
    radius = np.where(near, radius + np.abs(values.real), radius)
    return Enclosed(np.where(near, 1j * values.imag, values), radius, pairs)


def _one_square(matrix: Floats, error: Floats) -> Enclosed:
    """±√z with z = λ² = (tr B²)/2, since the trace of the 2 × 2 matrix is zero by structure."""
    square = matrix @ matrix
    z = 0.5 * (square[:, 0, 0] + square[:, 1, 1])
    a, e = np.abs(matrix), error
    slack = a @ e + e @ a + e @ e + 4 * UNIT * (a @ a) + 8 * TINY
    bound = 0.5 * (slack[:, 0, 0] + slack[:, 1, 1]) + UNIT * np.abs(z)
    root = np.sqrt(z.astype(complex))
    size = np.maximum(np.abs(root), 1e-300)
    # |√z - √z'| ≤ min(r/|√z|, √r): the bound of a simple root, and the one at zero
    spread = np.minimum(bound / size, np.sqrt(bound))
    both: Floats = np.stack([spread, spread], axis=-1)
    return Enclosed(np.stack([root, -root], axis=-1), both, None)


# --- verdict ---


def decide(values: Complexes, radius: Floats, *, even: bool) -> NDArray[np.int8]:
    """Verdicts from eigenvalues and their discs, as flag values.

    Parameters
    ----------
    values, radius
        From `eigenvalues`, shapes (N, m).
    even
        Whether the polynomial is even by structure.

    Returns
    -------
    ndarray
        Shape (N,).
    """
    with np.errstate(all="ignore"):
        return _decide_even(values, radius) if even else _decide(values, radius)


def _decide(values: Complexes, radius: Floats) -> NDArray[np.int8]:
    real = values.real
    stable = (real + radius < 0).all(axis=1)
    right = real - radius > 0
    # Discs wholly in Re > 0 that no other disc touches hold as many eigenvalues as there are discs.
    distance = np.abs(values[:, :, None] - values[:, None, :])
    touching = distance <= radius[:, :, None] + radius[:, None, :]
    mixed = (touching & right[:, :, None] & ~right[:, None, :]).any(axis=(1, 2))
    unstable = right.any(axis=1) & ~mixed
    codes = np.zeros(len(values), dtype=np.int8)
    codes[stable] = CODES[Verdict.STABLE]
    codes[unstable] = CODES[Verdict.UNSTABLE]
    return codes


def _decide_even(values: Complexes, radius: Floats) -> NDArray[np.int8]:
    """By λ²: on the imaginary axis with a disc that keeps clear of zero and of every other disc."""
    distance = np.abs(values[:, :, None] - values[:, None, :])
    reach = radius[:, :, None] + radius[:, None, :]
    np.einsum("ijj->ij", distance)[...] = np.inf
    alone = (distance > reach).all(axis=(1, 2))
    # An isolated λ² whose disc meets the real axis is real, since the polynomial in λ² is real.
    neutral = alone & (np.abs(values.real) <= radius).all(axis=1)
    unstable = alone & (values.real - radius > 0).any(axis=1)
    codes = np.zeros(len(values), dtype=np.int8)
    codes[neutral] = CODES[Verdict.NEUTRAL]
    codes[unstable] = CODES[Verdict.UNSTABLE]
    return codes
