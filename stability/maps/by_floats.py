"""The cells of a map of a numeric system: eigenvalues by floats, with estimated errors."""

from __future__ import annotations

from contextlib import suppress
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ..base.errors import StabilityError
from ..base.types import Floats
from ..base.verdict import CODES, Verdict
from ..spectra.deflation import Reduced
from ..spectra.eigenvalues import decide, eigenvalues, unstable_in_discs
from ..spectra.numeric import numeric_linearised
from ..spectra.problem import Problem
from ..storage.pieces import Chunk
from .rates import arrays_of, of_eigenvalues

FLOATS = (
    "eigenvalues of numerical derivatives of a Python function (LAPACK), by floats, not proved: "
    "error discs by Gershgorin's theorem from the estimated errors of the derivatives"
)
"""Method in words."""


@dataclass(frozen=True)
class NumericCells:
    """The arrays of members by floats, with the face of `GraphCells`."""

    problem: Problem
    """A problem of a numeric system."""
    modes: bool
    """Whether to store all eigenvalues."""

    zeros = 0
    """A numeric system has no structural zeros."""

    @property
    def count(self) -> int:
        """Eigenvalues of a member."""
        return len(self.problem.family.system.states)

    def __call__(self, a: Floats, q: Floats, rate: Floats, u: Floats, columns: int = 0) -> Chunk:  # noqa: ARG002
        """As `GraphCells`; at a kink of the function a cell stays undecided, without numbers."""
        size, family = self.count, self.problem.family
        values = np.full((len(a), size), np.nan, dtype=complex)
        radius = np.full((len(a), size), np.inf)
        codes = np.full(len(a), CODES[Verdict.UNDECIDED], dtype=np.int8)
        members: dict[int, Reduced] = {}
        for i in range(len(a)):
            with suppress(StabilityError):
                members[i] = numeric_linearised(family, *(v[i : i + 1] for v in (a, q, u)))
        if members:
            rows, parts = list(members), members.values()
            matrix, error = (np.concatenate([p[k] for p in parts]) for k in (0, 1))
            whole = Reduced(matrix, error, [], np.zeros(len(rows), dtype=np.intp))
            values[rows], radius[rows], _ = eigenvalues(whole, even=False)
            codes[rows] = decide(values[rows], radius[rows], even=False)
        return {
            "codes": codes,
            **arrays_of(of_eigenvalues(values, radius, codes), modes=self.modes, unit=rate),
        }

    def unstable(self, a: Floats, q: Floats, u: Floats) -> NDArray[np.int16]:
        """Number of unstable eigenvalues of members, -1 where discs leave it open."""
        reduced = numeric_linearised(self.problem.family, a, q, u)
        values, radius, _ = eigenvalues(reduced, even=False)
        return unstable_in_discs(values, radius, even=False)
