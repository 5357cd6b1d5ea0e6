"""Growth rates of members of any graph from the polynomials of their matrices."""

from __future__ import annotations

import numpy as np

from ...base.types import Floats
from ...spectra.deflation import Reduced
from ...spectra.eigenvalues import decide, eigenvalues
from .rates import Rates, of_matrices, rates

SAMPLE = 128
"""Members on which the discs are tried."""
FEWEST = 1024
"""Number of members below which the eigensolver alone is as good."""
MOST_POOR = 0.25
"""Share of the sample beyond which the eigensolver takes all members."""
MOST_STATES = 8
"""Largest matrix whose polynomial is formed in doubles."""


def quick_rates(reduced: Reduced, *, even: bool, modes: bool) -> Rates | None:
    """Growth rates and verdicts of many members; None where the eigensolver is as good.

    Parameters
    ----------
    reduced
        Linearisations without structural zeros.
    even
        Whether their polynomial is even by structure.
    modes
        Whether to return all eigenvalues.

    Returns
    -------
    Rates or None
        Members whose discs are large or meet have the eigensolver's values and Gershgorin's discs.
    """
    matrix, error = reduced.matrix, reduced.error
    count, n = matrix.shape[:2]
    if not 2 <= n <= MOST_STATES or count < FEWEST or not np.isfinite(matrix).all():
        return None
    step = -(-count // SAMPLE)
    if _of(matrix[::step], error[::step], even=even, modes=False).poor.mean() > MOST_POOR:
        return None
    found = _of(matrix, error, even=even, modes=modes)
    left = np.flatnonzero(found.poor | (found.codes == 0))
    if len(left):
        part = Reduced(matrix[left], error[left], [], reduced.supported[left])
        values, radius, _ = eigenvalues(part, even=even)
        lead = values[:, -1]
        found.codes[left] = decide(values, radius, even=even)
        found.abscissa[left], found.frequency[left] = lead.real, np.abs(lead.imag)
        found.error[left] = (radius + (values.real - lead.real[:, None])).max(axis=1)
        if found.values is not None:
            found.values[left] = values
    return found


def _of(matrix: Floats, error: Floats, *, even: bool, modes: bool) -> Rates:
    with np.errstate(all="ignore"):
        return rates([(of_matrices(matrix, error), even, 1)], modes=modes)
