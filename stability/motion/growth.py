"""Growth of small errors along a path, by the linearised motion.

A method with large steps can damp what the equations let grow.  Two of its runs near a saddle
then stay together where the motions part, so that their distance shows no growth.  Here errors grow
as the Jacobian says: between two samples by the exponential of its mean, which damps nothing, and
over a step of a fine run by Magnus' method of order four.  Order matters where a motion jumps: its
errors are large and nearly along the motion there, and cancel on the next slow branch.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..base.types import Floats
from ..integrators.flow import Flow
from ..integrators.scipy_methods import GAUSS, Trail

DEGREE, NORM = 9, 0.5
"""Degree of the Taylor polynomial of an exponential, and the norm below which it is exact."""
LARGEST = 1e100
"""Growth that counts as without bound; its square does not overflow."""
WORK = 4e7
"""Most intervals of a path, times the cube of the number of states; further ones are joined."""


@dataclass(frozen=True)
class Growth:
    """Growth of errors of size one in each interval of a path; at least 1."""

    largest: float
    """Largest size at any time."""
    last: float
    """Size at the end."""


NONE = Growth(1.0, 1.0)
"""No growth."""


def growth(flow: Flow, p: Floats, times: Floats, states: Floats, enough: float = 0.0) -> Growth:
    """Growth of errors along a path, by the mean of the Jacobian between its samples.

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
    Growth
        The size of an error is the largest over the states, each over 1 or the state's own size.  A
        state that is zero all along has no error: a symmetry keeps it there.

    Source: tests/motion/test_growth.py compares it with closed forms.

    Examples
    --------
    >>> from stability.integrators.flow import flow
    >>> f, times = flow("viscous"), np.linspace(0.0, 10.0, 65)
    >>> rolling = np.tile(f.pack(np.array([np.pi / 2, 0, 0, 1.2, 0, 0])), (65, 1))
    >>> bool(1 <= growth(f, np.array([0.25, 0.3, 1e-6]), times, rolling).largest < 1e3)
    True
    """
    y = states[:, : flow.compared]
    live = (y != 0).any(axis=0)
    if len(y) < 2 or not live.any():
        return NONE
    matrices = _jacobians(flow, p, states)
    if not np.isfinite(matrices).all():
        return Growth(np.inf, np.inf)
    sizes = np.maximum(1.0, np.abs(y))
    scaled = matrices * sizes[:, None, :] / sizes[:, :, None]
    exponents = np.diff(times)[:, None, None] * (scaled[1:] + scaled[:-1]) / 2
    diagonal = np.arange(flow.compared)
    exponents[:, diagonal, diagonal] -= np.diff(np.log(sizes), axis=0)
    bound = float(np.sqrt(len(times) * flow.compared) * np.exp(min(_upper(exponents), 700.0)))
    if bound <= enough:
        return Growth(bound, bound)
    return _grown(exponents, np.ones((len(exponents), flow.compared)), live)


def growth_along(flow: Flow, p: Floats, trail: Trail) -> Growth:
    """As `growth`, along the steps of a fine run and of higher order.

    Parameters
    ----------
    flow, p
        The flow and its parameters, shape (m,).
    trail
        The steps, with the state at the points of Gauss of each.
    """
    times, states, inner = (np.array(part) for part in zip(*trail, strict=True))
    y = states[:, : flow.compared]
    live = (y != 0).any(axis=0)
    if len(y) < 2 or not live.any():
        return NONE
    sizes = np.maximum(1.0, np.abs(y))
    first, second = (
        _jacobians(flow, p, inner[1:, :, i]) * sizes[:-1, None, :] / sizes[:-1, :, None]
        for i in (0, 1)
    )
    if not (np.isfinite(first).all() and np.isfinite(second).all()):
        return Growth(np.inf, np.inf)
    h = np.diff(times)[:, None, None]
    apart = (GAUSS[1] - GAUSS[0]) / 4
    exponents = h * (first + second) / 2 - apart * h**2 * (first @ second - second @ first)
    return _grown(exponents, sizes[:-1] / sizes[1:], live)


def _jacobians(flow: Flow, p: Floats, states: Floats) -> Floats:
    ask, count = flow.quick.jacobian, flow.compared
    return np.array([ask(p, state)[:count, :count] for state in states])


def _upper(exponents: Floats) -> float:
    """Most growth by the logarithmic norm of largest entries, as a logarithm."""
    diagonal = np.diagonal(exponents, axis1=1, axis2=2)
    rows = np.abs(exponents).sum(axis=2) - np.abs(diagonal) + diagonal
    return float(np.maximum(rows.max(axis=1), 0.0).sum())


def _grown(exponents: Floats, after: Floats, live: Floats) -> Growth:
    """Roots of a variance that grows by each exponential, with ones added after each.

    Each exponential is followed by a change of the states' sizes.
    """
    step = int(np.ceil(len(exponents) * live.size**3 / WORK))
    every = np.arange(0, len(exponents), step)
    exponents = np.add.reduceat(exponents, every)
    resized = np.multiply.reduceat(after, every)
    ones = np.diag(live.astype(float))
    variance, largest, size = ones, 1.0, 1.0
    with np.errstate(all="ignore"):
        for matrix in resized[:, :, None] * exponentials(exponents):
            variance = matrix @ variance @ matrix.T + ones
            size = float(np.sqrt(np.diagonal(variance).max()))
            if not size < LARGEST:
                return Growth(np.inf, np.inf)
            largest = max(largest, size)
    return Growth(largest, size)


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
