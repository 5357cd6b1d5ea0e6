"""A function that labels launches, and the check of what it returns."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..base.errors import ParameterError, shown
from ..base.types import Floats

Ints = NDArray[np.int64]
Label = Callable[[Floats], Any]
"""Takes launches, shape (n, d), and returns whole numbers, shape (n,)."""


def asked(label: Label, points: Floats, chunk: int | None = None) -> Ints:
    """The labels of launches, in calls of at most `chunk` launches.

    Parameters
    ----------
    label
        The function.
    points
        Launches, shape (n, d).
    chunk
        Most launches of a call; None for one call.

    Returns
    -------
    ndarray
        Shape (n,).

    Raises
    ------
    ParameterError
        If the function returns anything but one whole number for each launch.

    Examples
    --------
    >>> asked(lambda p: p[:, 0] > 0.5, np.array([[0.2, 0.0], [0.7, 0.0]])).tolist()
    [0, 1]
    """
    size = max(len(points), 1) if chunk is None else chunk
    parts = [points[n : n + size] for n in range(0, len(points), size)]
    return np.concatenate([np.zeros(0, np.int64), *(_one_call(label, part) for part in parts)])


def _one_call(label: Label, points: Floats) -> Ints:
    labels = np.asarray(label(points))
    if labels.dtype.kind not in "iub" or labels.shape != (len(points),):
        raise ParameterError(
            f"label returned {shown(labels)} for {len(points)} launches; "
            "return one whole number for each, as an array of integers."
        )
    return labels.astype(np.int64)
