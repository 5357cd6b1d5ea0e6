"""Numbers of unstable eigenvalues in the cells of a map."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..base.verdict import CODES, DECAYING, Evidence, Verdict
from ..boundary.brackets import AxisScan
from ..boundary.every_crossing import unstable_at
from ..systems.sources.numeric import NumericSystem
from .cells import CHUNK, MOST_SETTLED, Cells

NONE = [CODES[v] for v in (*DECAYING, Verdict.NEUTRAL)]
"""Flags of cells without an unstable eigenvalue."""
OPEN = [CODES[v] for v in (Verdict.UNSTABLE, Verdict.UNDECIDED)]
"""Flags of cells whose unstable eigenvalues are counted."""


def unstable_variable(cells: Cells, *, certify: bool) -> dict[str, Any]:
    """The variable `unstable` of a map, as for `xarray.Dataset`.

    Parameters
    ----------
    cells
        The cells, with every verdict that is known.
    certify
        Whether each cell that discs leave open is counted in balls, or few.
    """
    counts = _counts(cells, certify=certify)
    numeric = isinstance(cells.problem.family.system, NumericSystem)
    how = Evidence.BY_FLOATS.word if numeric else "proved"
    comment = (
        f"{how}; zeros by structure do not count; -1 where the number is not known so, in "
        f"{int((counts < 0).sum())} of {counts.size} cells"
    )
    words = {"long_name": "number of unstable eigenvalues", "units": "1", "comment": comment}
    dims = cells.axes[1].name, cells.axes[0].name
    return {"unstable": (dims, counts.reshape(cells.shape), words)}


def _counts(cells: Cells, *, certify: bool) -> NDArray[np.int16]:
    """The number in each cell, flat; -1 where it is not proved."""
    codes = cells.codes.reshape(-1)
    counts = np.where(np.isin(codes, NONE), 0, -1).astype(np.int16)
    asked = np.flatnonzero(np.isin(codes, OPEN))
    for first in range(0, len(asked), CHUNK):
        some = asked[first : first + CHUNK]
        counts[some] = cells.unstable(some)
    across, up = cells.axes
    left = asked[counts[asked] < 0]
    if isinstance(cells.problem.family.system, NumericSystem):
        return counts
    for cell in left if certify or len(left) <= MOST_SETTLED else ():
        i, j = divmod(int(cell), across.count)
        swept = {across.name: across.values[j], up.name: up.values[i]}
        place = {n: float(v) for n, v in (dict(cells.problem.values) | swept).items()}
        value = place.pop(across.name)
        count = unstable_at(AxisScan(cells.problem, across.name, place), value)
        counts[cell] = -1 if count is None else count
    return counts
