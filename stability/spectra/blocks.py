"""A large member block by block: proved discs of its eigenvalues, and the verdict from them.

The strong components of the graph of the linearisation cut the matrix into diagonal blocks, and the
eigenvalues are those of the blocks.  The entries are known in balls; each block is enclosed in
double precision with proved bounds.  A small block that its discs leave open, or in a cluster, has
its own polynomial over Q.  Structural zeros are left out: blocks of one zero, or else by deflation.
"""

from __future__ import annotations

from collections.abc import Sequence
from contextlib import suppress
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from flint import acb, fmpq, fmpq_mat
from numpy.typing import NDArray

from ..algebra.eigenvalue_discs import eigenvalue_discs
from ..algebra.exact.number_fields import NotExact
from ..algebra.exact.roots import bounded_roots
from ..algebra.exact.routh import on_the_axis
from ..algebra.number_types import precision, upper
from ..base.types import Complexes, Floats
from ..base.verdict import BY_CODE, Verdict
from ..polynomials.identities import MOST_STATES, symmetric
from ..polynomials.member import Member
from ..systems.structure.places import components, mirrored
from .deflation import Reduced, deflated
from .eigenvalues import decide
from .eigenvalues import on_the_axis as moved_to_the_axis

BITS = 128
"""Precision of the balls of the entries."""
ROOT_BITS = 256
"""Precision of the roots of a small block's polynomial."""
SLACK = 1.01
"""Factor for the roundings of the bounds of a deflation."""


@dataclass(frozen=True)
class BlockProof:
    """What is proved of one block."""

    values: Complexes
    """Centres of the discs."""
    radius: Floats
    """Their radii, infinite where nothing is proved."""
    verdict: Verdict
    """Verdict of the block alone."""


class Blocks:
    """The blocks of a large member.

    Parameters
    ----------
    member
        The member, whose root is proved or needs no proof.
    zeros
        Number of eigenvalues that are zero by structure, each proved zero.
    """

    def __init__(self, member: Member, zeros: int) -> None:
        self.member = member
        with precision(BITS):
            whole = deflated(member, 0)
            places = components(_pattern(whole))
            still = [i for i in places if len(i) == 1 and not _pattern(whole)[i, i]]
            self.whole = len(still) == zeros
            if self.whole:
                left_out = {int(i[0]) for i in still}
                self.places = [i for i in places if not left_out.intersection(i.tolist())]
            else:
                whole = deflated(member, zeros)
                self.places = [np.arange(whole.matrix.shape[-1])]
        self.matrix, self.error = whole.matrix[0], SLACK * whole.error[0]
        self.parts = [self._part(i) for i in self.places]

    @property
    def verdict(self) -> Verdict:
        """The verdict of all blocks."""
        verdicts = {part.verdict for part in self.parts}
        order = (Verdict.UNSTABLE, Verdict.UNDECIDED, Verdict.NEUTRAL)
        return next((v for v in order if v in verdicts), Verdict.STABLE)

    @property
    def values(self) -> Complexes:
        """All centres, in the order of the blocks."""
        return np.concatenate([part.values for part in self.parts])

    @property
    def radius(self) -> Floats:
        """All radii, in the order of the blocks."""
        return np.concatenate([part.radius for part in self.parts])

    def _part(self, place: NDArray[np.intp]) -> BlockProof:
        matrix, error = (some[np.ix_(place, place)] for some in (self.matrix, self.error))
        values, radius, alone = eigenvalue_discs(matrix, error)
        even = mirrored((matrix != 0) | (error != 0))
        if even or (len(self.places) == 1 and symmetric(self.member.family)):
            even = True
            values, radius = moved_to_the_axis(values, radius)
        verdict = BY_CODE[int(decide(values[None], radius[None], even=even)[0])]
        clear = verdict is not Verdict.UNDECIDED and alone.all()
        small = self.whole and len(place) <= MOST_STATES
        if not clear and small and self._rational is not None:
            return _over_q([[self._rational[i][j] for j in place] for i in place])
        return BlockProof(values, radius, verdict)

    @cached_property
    def _rational(self) -> list[list[Any]] | None:
        """The linearisation over Q, or None."""
        member = self.member
        if member.enclosed_only:
            return None
        with suppress(NotExact):
            matrix = member.matrix()
            if all(isinstance(v, (int, fmpq)) for row in matrix for v in row):
                return matrix
        return None


def _pattern(reduced: Reduced) -> NDArray[np.bool_]:
    return np.asarray((reduced.matrix[0] != 0) | (reduced.error[0] != 0))


def _over_q(block: Sequence[Sequence[Any]]) -> BlockProof:
    """A block by its polynomial over Q."""
    polynomial = fmpq_mat(block).charpoly()
    values, radius = [], []
    with precision(ROOT_BITS):
        for root in bounded_roots(polynomial):
            values.append(complex(float(root.real.mid()), float(root.imag.mid())))
            radius.append(upper(abs(root - acb(values[-1].real, values[-1].imag))))
    return BlockProof(np.array(values), np.array(radius), on_the_axis([polynomial]))
