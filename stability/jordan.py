"""Whether structural zeros are semisimple: where they are not, the linear flow grows like t.

A has `zeros` eigenvalues that vanish by structure, and the others do not vanish.  They are
semisimple exactly where rank A = n - zeros.  A larger rank is proved where the singular value that
would have to vanish exceeds the bound on what rounding makes of it; a smaller one is impossible.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from .families import Family
from .reduction import tracked_matrix
from .tracked import UNIT

Floats = NDArray[np.float64]


def grows(
    family: Family, a: Floats, q: Floats, u: Floats, zeros: int, roundings: Sequence[int] | None
) -> NDArray[np.bool_]:
    """Where the structural zeros are proved not to be semisimple.

    Parameters
    ----------
    family
        The family.
    a, q, u
        Family parameters, parameters and unknowns, shapes (N, ·).
    zeros
        How many eigenvalues vanish by structure.
    roundings
        As for `stability.reduction.reduce`.

    Returns
    -------
    ndarray of bool
        Shape (N,); False means that it is not proved.

    Source: G. W. Stewart & J. Sun, Matrix Perturbation Theory (1990), for Weyl's inequality.

    Examples
    --------
    >>> import casadi as ca, stability as st
    >>> x = ca.SX.sym("x", 3)
    >>> free = st.System("free", x, ca.SX(0, 1), ca.vertcat(x[1], 0, -x[2]),
    ...                  states=("x", "v", "z"), parameters=())
    >>> rest = st.Family(free, "rest", at=("x",), held={"v": 0.0, "z": 0.0})
    >>> st.spectrum(rest, at=1.0).nonlinear.word
    'grows like t in the linear flow'
    """
    if zeros < 2:
        return np.zeros(len(a), dtype=bool)
    with np.errstate(all="ignore"):
        matrix, error = tracked_matrix(family, a, q, u, roundings)
        for axis in (2, 1):  # rows and columns of like size, by powers of two: exact, same rank
            size = np.abs(matrix).max(axis=axis, keepdims=True)
            scale = np.exp2(-np.round(np.log2(np.where(size > 0, size, 1.0))))
            matrix, error = matrix * scale, error * scale
        sound = np.isfinite(matrix).all(axis=(1, 2)) & np.isfinite(error).all(axis=(1, 2))
        proved = np.zeros(len(a), dtype=bool)
        if sound.any():
            n = matrix.shape[-1]
            sizes = np.linalg.svd(matrix[sound], compute_uv=False)
            noise = np.sqrt((error[sound] ** 2).sum(axis=(1, 2))) + 8 * n * UNIT * sizes[:, 0]
            proved[sound] = sizes[:, n - zeros] > 2 * noise
    return proved
