"""What the places of zero entries prove of a spectrum: blocks, zeros and symmetry.

A coefficient of det(λ - A) is a sum over sets of disjoint cycles in the graph of the entries that
are not zero (F. Harary, SIAM Rev. 4 (1962) 202-210).  So sparsity proves zeros and symmetry for any
values, at any size, without one product.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...algebra.exact.number_fields import vanishes

Pattern = NDArray[np.bool_]
"""Whether each entry of a matrix may differ from zero."""


LARGE = 32
"""Number of states above which a matrix is taken block by block."""


def components(pattern: Pattern) -> list[NDArray[np.intp]]:
    """Indices of the diagonal blocks of the block triangular form.

    Parameters
    ----------
    pattern
        Whether each entry may differ from zero, shape (n, n).

    Examples
    --------
    >>> [c.tolist() for c in components(np.array([[1, 1], [0, 1]], dtype=bool))]
    [[1], [0]]
    """
    if pattern.all():
        return [np.arange(len(pattern))]
    from scipy.sparse.csgraph import connected_components

    _, labels = connected_components(pattern, directed=True, connection="strong")
    return [np.flatnonzero(labels == label) for label in np.unique(labels)]


def sparse_zeros(pattern: Pattern) -> int:
    """Number of eigenvalues that are zero for all values of the entries.

    Returns
    -------
    int
        n minus the largest number of states that disjoint cycles cover.

    Examples
    --------
    >>> sparse_zeros(np.array([[0, 1, 0], [0, 0, 1], [0, 1, 0]], dtype=bool))  # a chain into a pair
    1
    """
    from scipy.sparse import csr_array
    from scipy.sparse.csgraph import min_weight_full_bipartite_matching

    if not len(pattern):
        return 0
    cost = pattern.astype(float)
    outside = np.flatnonzero(~np.diag(pattern))
    cost[outside, outside] = 2.0  # a state outside every cycle
    rows, columns = min_weight_full_bipartite_matching(csr_array(cost))
    return int(cost[rows, columns].sum()) - len(pattern)


def mirrored(pattern: Pattern) -> bool:
    """Whether the spectrum is symmetric under λ → -λ for all values of the entries.

    This holds if every cycle is even: within each block a change of the signs of some states R then
    gives R A R = -A, as under a reversal of time.

    Examples
    --------
    >>> mirrored(np.array([[0, 1], [1, 0]], dtype=bool)), mirrored(np.eye(2, dtype=bool))
    (True, False)
    """
    return all(_two_sides(pattern[np.ix_(some, some)]) for some in components(pattern))


def _two_sides(block: Pattern) -> bool:
    """Whether signs ±1 of the states exist that differ wherever an entry is not zero."""
    either = block | block.T
    if np.diag(block).any():
        return False
    sign = np.zeros(len(block), dtype=int)
    sign[0], waiting = 1, [0]
    while waiting:
        here = waiting.pop()
        for there in np.flatnonzero(either[here]):
            if sign[there] == 0:
                sign[there] = -sign[here]
                waiting.append(int(there))
            elif sign[there] == sign[here]:
                return False
    return True


def nonzero(matrix: list[list[Any]], zero: Callable[[Any], bool] = vanishes) -> Pattern:
    """Whether each entry is not proved to be zero."""
    return np.array([[not zero(entry) for entry in row] for row in matrix])


def blocks_of(
    matrix: list[list[Any]], zero: Callable[[Any], bool] = vanishes
) -> list[list[list[Any]]]:
    """Diagonal blocks of the block triangular form: their polynomials multiply to the whole."""
    members = components(nonzero(matrix, zero))
    return [[[matrix[i][j] for j in some] for i in some] for some in members]
