"""Verdicts and growth rates of members of any graph, most from their matrices' polynomials."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...base.errors import DomainError
from ...base.types import Floats
from ...jobs.checkpoint import Chunk
from ...spectra.deflation import Reduced, deflate
from ...spectra.eigenvalues import decide, eigenvalues
from ...spectra.problem import Problem
from ...systems.structure.identities import certain, symmetric
from ...systems.structure.structural_zeros import structure
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


class GraphCells:
    """The arrays of members by the graph.

    Parameters
    ----------
    problem
        Family with values in the user's units.
    modes
        Whether to keep all eigenvalues.
    """

    def __init__(self, problem: Problem, modes: bool) -> None:
        self.problem, self.modes = problem, modes
        family = problem.family
        self.zeros = structure(family).zeros  # established here, before the threads start
        self._certain = problem.derived or certain(family)
        declared = family.conservative and self._certain
        self._even = declared or (not problem.derived and symmetric(family))
        self.count = len(family.system.states) - self.zeros
        """Eigenvalues of a member without the structural zeros."""

    def __call__(self, a: Floats, q: Floats, rate: Floats, u: Floats) -> Chunk:
        """Flags, growth rates with bounds, and frequencies of members.

        Parameters
        ----------
        a, q, u
            Numbers that name the members, parameters and unknowns, one row for each.
        rate
            Unit of rate of each.
        """
        family, even = self.problem.family, self._even
        family.checked_states(a, u, q)
        watch = not self._certain
        reduced = deflate(family, a, q, u, self.problem.roundings, watch=watch)
        found = None if watch else quick_rates(reduced, even=even, modes=self.modes)
        if found is not None:
            return {
                "codes": found.codes,
                "abscissa": found.abscissa * rate,
                "error": found.error * rate,
                "frequency": found.frequency * rate,
                **({"values": found.values * rate[:, None]} if found.values is not None else {}),
            }
        values, radius, _ = eigenvalues(reduced, even=even)
        codes = decide(values, radius, even=even)
        if watch:
            self._restore(values, radius, codes, (a, q, u), reduced.supported)
        lead = values[:, -1]
        chunk: Chunk = {
            "codes": codes,
            "abscissa": lead.real * rate,
            "error": (radius + (values.real - lead.real[:, None])).max(axis=1) * rate,
            "frequency": np.abs(lead.imag) * rate,
        }
        if self.modes:
            chunk["values"] = values * rate[:, None]
        return chunk

    def _restore(
        self,
        values: Any,
        radius: Floats,
        codes: NDArray[np.int8],
        place: tuple[Floats, Floats, Floats],
        supported: NDArray[np.intp],
    ) -> None:
        """Restore the leading eigenvalue of members that have fewer zeros than typical ones."""
        for count in range(self.zeros):
            rows = np.flatnonzero(supported == count)
            if not len(rows):
                continue
            if self.modes:
                raise DomainError(
                    f"{self.problem.family.name} has {self.zeros} eigenvalues that are zero by "
                    f"structure at typical members but {count} somewhere on this map; leave out "
                    "modes, or map that part by itself."
                )
            a, q, u = (part[rows] for part in place)
            reduced = deflate(self.problem.family, a, q, u, self.problem.roundings, count)
            all_values, discs, _ = eigenvalues(reduced, even=False)
            codes[rows] = decide(all_values, discs, even=False)
            kept = values.shape[1]
            values[rows], radius[rows] = all_values[:, -kept:], discs[:, -kept:]
