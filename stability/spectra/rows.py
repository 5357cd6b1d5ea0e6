"""The members of one `spectrum` call, and their spectra in double precision, in pieces."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from ..base.errors import ParameterError
from ..systems.structure.structural_zeros import structure
from ..systems.structure.zero_blocks import semisimple
from .deflation import Place, Reduced, drift_powers, drifting
from .eigenvalues import Eigenpairs, decide, eigenvalues
from .problem import Problem, broadcast_shape

if TYPE_CHECKING:
    from ..systems.structure.member import Member

from ..base.types import Complexes, Floats

PIECE = 2**20
"""Largest number of linearisation entries in one piece, so that 80 MB are enough."""
MOST_VALUES = 10**8
"""Largest number of eigenvalues of one call, a result of 7 GB."""


class Rows:
    """The members of one call, and the number of zero eigenvalues left out of all their spectra.

    Parameters
    ----------
    problem
        Family with values in the user's units.
    exact
        Whether to prove the number of zeros at each member if it is not proved for the whole
        family.  If False, the eigenvalues left out are zero within their rounding.
    """

    def __init__(self, problem: Problem, *, exact: bool) -> None:
        from ..systems.structure.identities import certain, symmetric

        self.problem, self.exact = problem, exact
        family = problem.family
        count = math.prod(broadcast_shape(problem.values))
        size = len(family.system.states)
        if count * size > MOST_VALUES:
            raise ParameterError(
                f"{count} spectra of {size} states are asked for; at most {MOST_VALUES:.0e} "
                "eigenvalues are kept in memory at once. Ask in pieces, or take stability_map or "
                "stream_map, which keep less of each."
            )
        a, q, rate, self.shape = problem.arrays(problem.values)
        self._step = max(1, PIECE // size**2)
        u = self._joined(len(a), lambda piece: (family.solve(a[piece], q[piece]),))[0]
        self.place = Place(a, q, u, rate, tuple(problem.roundings))
        self.states: Floats = self._joined(
            len(a), lambda p: (family.checked_states(a[p], u[p], q[p]),)
        )[0]
        self.zeros = structure(family).zeros
        self.certain = problem.derived or certain(family)
        """Whether the number of zeros is proved at every member of the family."""
        declared = family.conservative and self.certain
        self.symmetric = declared or (not problem.derived and symmetric(family))
        """Whether the spectrum is proved symmetric under λ → -λ at every member."""
        self._members: dict[int, Member] = {}
        if not self.certain:
            self.zeros = min(self._proved_zeros() if exact else self._supported())

    def _joined(
        self, count: int, work: Callable[[slice], tuple[NDArray[Any], ...]]
    ) -> list[NDArray[Any]]:
        """Results of all pieces, joined array by array."""
        pieces = [work(slice(i, i + self._step)) for i in range(0, max(count, 1), self._step)]
        if len(pieces) == 1:
            return list(pieces[0])
        return [np.concatenate(parts) for parts in zip(*pieces, strict=True)]

    def _proved_zeros(self) -> Iterator[int]:
        from .certificate import structural_zeros

        return (
            structural_zeros(self.member(row))
            for row in map(int, np.unique(self.firsts(np.arange(len(self.place.a)))))
        )

    def _supported(self) -> NDArray[np.intp]:
        """Number of eigenvalues of each member that are zero within their rounding."""

        def piece(rows: slice) -> tuple[NDArray[np.intp]]:
            return (self._reduced(rows, watch=True).supported,)

        return self._joined(len(self.place.a), piece)[0]

    def _reduced(self, rows: slice, *, watch: bool) -> Reduced:
        return self.place[rows].reduced(self.problem.family, self.zeros, watch=watch)

    def spectra(self) -> tuple[Complexes, Floats, NDArray[np.int8], Eigenpairs | None]:
        """Eigenvalues, error discs and flag values of the verdicts, dimensionless.

        Returns
        -------
        values, radius, codes
            Shapes (N, m), (N, m), (N,).
        pairs
            Eigenvectors; None where the values came from a formula, or for members in several
            pieces, to save memory.
        """
        even = self.symmetric
        pairs = None

        def piece(rows: slice) -> tuple[NDArray[Any], ...]:
            nonlocal pairs
            watch = self.exact and not self.certain
            reduced = self._reduced(rows, watch=watch)
            if watch:  # the zeros are proved; with wrong null vectors nothing is known of the rest
                reduced.error[reduced.supported < self.zeros] = np.inf
            values, radius, pairs = eigenvalues(reduced, even=even)
            return values, radius, decide(values, radius, even=even)

        values, radius, codes = self._joined(len(self.place.a), piece)
        if self.powers is not None:
            drifting(codes, self.powers)
        return values, radius, codes, pairs if len(self.place.a) <= self._step else None

    @cached_property
    def powers(self) -> NDArray[np.int8] | None:
        """Proved powers of time with which zeros let a disturbance grow; None if semisimple."""
        family, place = self.problem.family, self.place
        if self.problem.derived or semisimple(family, self.zeros):
            return None

        def piece(rows: slice) -> tuple[NDArray[np.int8]]:
            a, q, u = place.a[rows], place.q[rows], place.u[rows]
            return (drift_powers(family, a, q, u, self.zeros, place.roundings),)

        return self._joined(len(place.a), piece)[0]

    @property
    def note(self) -> str:
        """A sentence if these members have fewer structural zeros than typical ones, or empty."""
        usual = structure(self.problem.family).zeros
        if self.zeros >= usual:
            return ""
        return (
            f"{usual} eigenvalue{'s' * (usual != 1)} vanish{'es' * (usual == 1)} at typical "
            f"members of {self.problem.family.name}, but only {self.zeros} here"
        )

    @cached_property
    def _columns(self) -> dict[str, Floats]:
        """Each number of the members by name, shape (N,)."""
        arrays = np.broadcast_arrays(*self.problem.values.values())
        return dict(zip(self.problem.values, (v.reshape(-1) for v in arrays), strict=True))

    def values(self, row: int) -> dict[str, float]:
        """The numbers of one member by name."""
        return {n: float(column[row]) for n, column in self._columns.items()}

    def firsts(self, rows: NDArray[np.intp]) -> NDArray[np.intp]:
        """First row with the same numbers, bit for bit, for each given row: one proof for all."""
        columns = [column[rows] for column in self._columns.values()]
        bits = np.column_stack([*columns, self.place.u[rows]]).view(np.int64)
        _, first, inverse = np.unique(bits, axis=0, return_index=True, return_inverse=True)
        return rows[first][inverse.reshape(-1)]

    def member(self, row: int) -> Member:
        """A member of a user's family in exact numbers, built once."""
        from .certificate import member_at

        if row not in self._members:
            values = self.values(row)
            self._members[row] = member_at(self.problem, values, self.place.u[row])
        return self._members[row]
