"""Growth of small errors along a path, by the linearised motion.

A method with large steps can damp what the equations let grow.  Two of its runs near a saddle
then stay together where the motions part, so that their distance shows no growth.  Here errors grow
as the Jacobian says: between two samples by the exponential of its mean, which damps nothing.
"""

from __future__ import annotations

import numpy as np

from ..base.types import Floats
from ..integrators.flow import Flow

DEGREE, NORM = 9, 0.5
"""Degree of the Taylor polynomial of an exponential, and the norm below which it is exact."""
LARGEST = 1e100
"""Growth that counts as without bound; its square does not overflow."""
WORK = 4e7
"""Most intervals of a path, times the cube of the number of states; further ones are joined."""


def growth(flow: Flow, p: Floats, times: Floats, states: Floats, enough: float = 0.0) -> float:
    """Largest size, at any time, of errors of size one in each interval of a path before it.

    Parameters
    ----------
    flow
        The flow.
    p
        Its parameters, shape (m,).
    times, states
        A path, shapes (t,) and (t, n).
    enough
        Growth below which an upper bound of it is enough.

    Returns
    -------
    float
        At least 1.  The size of an error is the largest over the states, each over 1 or the state's
        own size.  A state that is zero all along has no error: a symmetry keeps it there.

    Source: tests/settling/test_growth.py compares it with closed forms.

    Examples
    --------
    >>> from stability.integrators.flow import flow
    >>> f, times = flow("viscous"), np.linspace(0.0, 10.0, 65)
    >>> rolling = np.tile(f.pack(np.array([np.pi / 2, 0, 0, 1.2, 0, 0])), (65, 1))
    >>> bool(1 <= growth(f, np.array([0.25, 0.3, 1e-6]), times, rolling) < 1e3)
    True
    """
    count = flow.compared
    y = states[:, :count]
    live = (y != 0).any(axis=0)
    if len(y) < 2 or not live.any():
        return 1.0
    ask = flow.quick.jacobian
    matrices = np.array([ask(p, state)[:count, :count] for state in states])
    if not np.isfinite(matrices).all():
        return np.inf
    sizes = np.maximum(1.0, np.abs(y))
    scaled = matrices * sizes[:, None, :] / sizes[:, :, None]
    exponents = np.diff(times)[:, None, None] * (scaled[1:] + scaled[:-1]) / 2
    diagonal = np.arange(count)
    exponents[:, diagonal, diagonal] -= np.diff(np.log(sizes), axis=0)
    bound = np.sqrt(len(times) * count) * np.exp(min(_upper(exponents), 700.0))
    if bound <= enough:
        return float(bound)
    step = int(np.ceil(len(exponents) * count**3 / WORK))
    return _largest(np.add.reduceat(exponents, np.arange(0, len(exponents), step)), live)


def _upper(exponents: Floats) -> float:
    """Most growth by the logarithmic norm of largest entries, as a logarithm."""
    diagonal = np.diagonal(exponents, axis1=1, axis2=2)
    rows = np.abs(exponents).sum(axis=2) - np.abs(diagonal) + diagonal
    return float(np.maximum(rows.max(axis=1), 0.0).sum())


def _largest(exponents: Floats, live: Floats) -> float:
    """Largest root of a variance that grows by each exponential, with ones added after each."""
    ones = np.diag(live.astype(float))
    variance, largest = ones, 1.0
    with np.errstate(all="ignore"):
        for matrix in exponentials(exponents):
            variance = matrix @ variance @ matrix.T + ones
            size = float(np.sqrt(np.diagonal(variance).max()))
            if not size < LARGEST:
                return np.inf
            largest = max(largest, size)
    return largest


def exponentials(matrices: Floats) -> Floats:
    """The exponential of each matrix, by scaling and squaring.

    Parameters
    ----------
    matrices
        Shape (N, n, n).

    Returns
    -------
    ndarray
        Shape (N, n, n).

    Examples
    --------
    >>> exponentials(np.array([[[0.0, 1.0], [0.0, 0.0]]])).tolist()
    [[[1.0, 1.0], [0.0, 1.0]]]
    """
    norm = float(np.abs(matrices).sum(axis=2).max(initial=NORM))
    halvings = int(np.ceil(np.log2(norm / NORM)))
    small, one = matrices / 2.0**halvings, np.eye(matrices.shape[-1])
    found = np.broadcast_to(one, matrices.shape)
    for k in range(DEGREE, 0, -1):
        found = one + small @ found / k
    for _ in range(halvings):
        found = found @ found
    return found
