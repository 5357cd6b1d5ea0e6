"""Functions of the axis that vanish where an eigenvalue meets the imaginary axis, over a piece.

For each block of the linearisation these are the constant coefficient of its polynomial, and the
Hurwitz determinant, which vanishes where two eigenvalues are opposite (Orlando's formula).  Both
are enclosed as Taylor forms.  To keep the enclosures narrow, the matrix is first carried to a basis
that is nearly its own at the midpoint, and the determinant to one scalar, which is the Schur
complement of the rest.  Neither step moves a zero: each is a product with regular matrices.

Source: tests/boundary/test_interval_search.py.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from flint import arb, arb_mat, arb_series

from ...algebra.balls import precision
from ...algebra.number_types import balls
from ...base.errors import NoMemberError, StabilityError
from ...systems.structure.enclosure import ball_unknowns
from ..brackets import BITS, AxisScan
from .blocks import Basis, Form, NoValueError, basis_of, determinant, finite, nonzero, polynomial
from .taylor import coefficient, series_algebra, span, terms

ORDER = 4
"""Order of the Taylor forms."""
POINT_BITS = 512
"""Precision at which the sign of a function at a point that is still open counts as zero."""
WIDER = 2.0**-16
"""Share by which the piece of the unknowns is wider, so that roots at its ends lie inside."""


@dataclass
class Piece:
    """A piece of the axis with what was enclosed there."""

    low: float
    high: float
    order: int
    matrices: list[list[Any]]
    """For each order the Taylor coefficient of the linearisation, scaled to the piece."""
    slopes: list[Any]
    """Value and derivative over all of the piece; empty where there is no derivative."""
    box: list[Any]
    """The unknowns over the piece, each the only root of the equations nearby."""
    bases: list[Basis]
    """One for each block."""


def middle_of(low: float, high: float) -> float:
    """The point of a piece about which its forms are taken."""
    return low + (high - low) / 2


class Meetings:
    """The functions along a line.

    Parameters
    ----------
    line
        The line.
    zeros
        Number of structural zeros, proved for all members.
    """

    def __init__(self, line: AxisScan, zeros: int) -> None:
        self.line, self.zeros = line, zeros
        self.family = line.problem.family
        self.even = self.family.conservative
        self.blocks = self._split()
        self._roots: dict[tuple[float, int], list[Any] | None] = {}
        self._rough: dict[float, list[float] | None] = {}

    def _split(self) -> list[list[int]]:
        """Diagonal blocks of the block triangular form; one where zeros or evenness join them."""
        from scipy.sparse.csgraph import connected_components

        graph, size = self.family.graph.matrix, len(self.family.system.states)
        if self.zeros or self.even:
            return [list(range(size))]
        pattern = np.zeros((size, size), dtype=bool)
        for i, j in graph.places[0]:
            pattern[i, j] = True
        _, labels = connected_components(pattern, directed=True, connection="strong")
        return [[int(i) for i in np.flatnonzero(labels == k)] for k in np.unique(labels)]

    # --- members ---

    def _given(self, value: Any) -> tuple[list[Any], list[Any]]:
        fixed = self.line.exact()
        a, q, _ = self.line.problem.reduce(fixed | {self.line.axis: value}, lambda v: v.sqrt())
        return a, q

    def prepared(self, value: float) -> bool:
        """Whether `root` need not follow the member from the family's known one.

        Parameters
        ----------
        value
            Value of the axis.
        """
        return value in self._rough

    def prepare(self, values: Sequence[float]) -> None:
        """Double-precision unknowns at many points, followed all at once, for `root`.

        Parameters
        ----------
        values
            Values of the axis.
        """
        new = [v for v in dict.fromkeys(values) if v not in self._rough]
        if not new or self.family.anchor is None or self.family.closed:
            return
        with precision(BITS):
            given = [self._given(arb(v)) for v in new]
        a, q = (
            np.array([[float(v.mid()) for v in pair[i]] for pair in given]).reshape(len(new), -1)
            for i in (0, 1)
        )
        found = self.family.search(a, q)
        for value, good, u in zip(new, found.good, found.u, strict=True):
            self._rough[value] = u.tolist() if good else None

    def root(self, value: float, bits: int = BITS) -> list[Any] | None:
        """The unknowns of the member that the family's root-finder gives; None without a member.

        Parameters
        ----------
        value
            Value of the axis.
        bits
            Working precision.
        """
        key = value, bits
        if key not in self._roots:
            self.prepare([value])
            near = self._rough.get(value)
            if near is None and value in self._rough:
                return None
            with precision(bits):
                try:
                    self._roots[key] = self._unknowns(arb(value), near)
                except (StabilityError, ZeroDivisionError):
                    self._roots[key] = None
        return self._roots[key]

    def _unknowns(self, place: Any, near: Sequence[float] | None) -> list[Any]:
        a, q = self._given(place)
        found = ball_unknowns(self.family, a, q, near)
        for name, ball in zip(self.family.unknown, found, strict=True):
            if name in self.family.positive and not ball > 0:
                raise NoMemberError(f"{self.family.name}: {name} is not proved to be positive.")
        return found

    def _matrices(self, place: Any, start: list[Any], count: int) -> list[Any]:
        """Taylor coefficients of the linearisation at a point, or at every point of a ball."""
        with terms(count):
            a, q = self._given(arb_series([place, 1]))
            u = self._series(a, q, start, count)
            entries = self.family.graph.matrix.run(series_algebra(), [a, u, q])[0]
        size = len(self.family.system.states)
        out = []
        for k in range(count):
            table = [[arb(0)] * size for _ in range(size)]
            for (i, j), entry in zip(self.family.graph.matrix.places[0], entries, strict=True):
                table[i][j] = coefficient(entry, k)
            out.append(arb_mat(table))
        return out

    def _series(self, a: Any, q: Any, start: list[Any], count: int) -> list[Any]:
        """The unknowns as power series, coefficient by coefficient (implicit function theorem)."""
        family = self.family
        if not family.unknown or family.closed or count == 1:
            return start
        plain = [[coefficient(v, 0) for v in some] for some in (a, q)]
        _, stored = family.graph.residual.run(balls(), [plain[0], start, plain[1]])
        slope = arb_mat(family.graph.place(stored))
        found = [[u] for u in start]
        for k in range(1, count):
            u = [arb_series([*c, 0]) for c in found]
            rates, _ = family.graph.residual.run(series_algebra(), [a, u, q])
            right = arb_mat(len(start), 1, [-coefficient(r, k) for r in rates])
            solved = slope.solve(right, algorithm="precond")
            for i, c in enumerate(found):
                c.append(solved[i, 0])
        return [arb_series(c) for c in found]

    # --- a piece ---

    def piece(self, low: float, high: float) -> Piece:
        """Everything enclosed over a piece, at the working precision.

        Parameters
        ----------
        low, high
            Its ends.

        Raises
        ------
        NoMemberError
            If no root is proved at the midpoint, or over the piece.
        NoValueError
            If the linearisation has no finite enclosure.
        """
        point = middle_of(low, high)
        middle = arb(point)
        half = max(arb(high) - middle, middle - arb(low))  # the form may reach beyond one end
        here = self.root(point)
        if here is None:
            raise NoMemberError(f"{self.family.name} has no member at {point}.")
        whole = arb(middle, half.abs_upper())
        wide = arb(middle, (half * (1 + WIDER)).abs_upper())
        box = self._unknowns(wide, [float(v.mid()) for v in here])
        over = self._matrices(whole, box, ORDER + 1)
        if not finite(over[0]):
            raise NoValueError
        order = ORDER if all(map(finite, over)) else 0
        forms = [*(self._matrices(middle, here, order) if order else []), over[order]]
        scaled = [m * half**k for k, m in enumerate(forms)]
        slopes = [over[0], over[1] * half] if order else []
        if not finite(scaled[0]):
            raise NoValueError
        return Piece(low, high, order, scaled, slopes, box, self._bases(scaled[0]))

    def _bases(self, matrix: Any) -> list[Basis]:
        size = matrix.nrows()
        table = np.array([[float(matrix[i, j].mid()) for j in range(size)] for i in range(size)])
        return [basis_of(table[np.ix_(block, block)]) for block in self.blocks]

    def functions(
        self, matrices: Sequence[Any], bases: Sequence[Basis], *, fold: bool
    ) -> list[Form]:
        """The functions as forms: static and flutter for each block.

        Parameters
        ----------
        matrices
            Taylor coefficients of the linearisation.
        bases
            One for each block.
        fold
            As in `taylor.product`.
        """
        out = []
        for block, basis in zip(self.blocks, bases, strict=True):
            part = [
                basis.left * arb_mat([[m[i, j] for j in block] for i in block]) * basis.right
                for m in matrices
            ]
            poly = polynomial(part, fold=fold)[self.zeros :]
            if self.even:
                for power in range(2, len(poly), 2):
                    poly[power - 1] = [c * (power // 2) for c in poly[power]]
            if len(poly) > 1:
                out.append(poly[0])
            if len(poly) > 2:
                out.append(determinant(poly, basis, fold=fold))
        return out

    def zeros_in(self, piece: Piece) -> int | None:
        """Number of zeros of all functions on a piece, each simple; None if this is not proved.

        Parameters
        ----------
        piece
            The piece.
        """
        values = self.functions(piece.matrices, piece.bases, fold=True)
        open_ = [i for i, f in enumerate(values) if not nonzero(span(f))]
        if not open_:
            return 0
        if not piece.slopes:
            return None
        slopes = self.functions(piece.slopes, piece.bases, fold=False)
        if not all(nonzero(slopes[i][1]) for i in open_):
            return None
        ends = [self._signs(v, piece.bases) for v in (piece.low, piece.high)]
        signs = [(ends[0][i], ends[1][i]) for i in open_]
        if any(0 in pair for pair in signs):
            return None
        return sum(a != b for a, b in signs)

    def _signs(self, value: float, bases: Sequence[Basis] | None) -> list[int]:
        """Proved signs of the functions at a point; 0 where open."""
        bits, out = BITS, [0]
        while 0 in out and bits <= POINT_BITS:
            root = self.root(value, bits)
            if root is None:
                return [0] * 2 * len(self.blocks)
            with precision(bits):
                matrix = self._matrices(arb(value), root, 1)
                if not finite(matrix[0]):
                    return [0] * 2 * len(self.blocks)
                found = self.functions(matrix, bases or self._bases(matrix[0]), fold=True)
                out = [int(f[0] > 0) - int(f[0] < 0) for f in found]
            bits *= 2
        return out

    def clear(self, value: float) -> bool:
        """Whether no eigenvalue is on the imaginary axis at a point, proved.

        Parameters
        ----------
        value
            Value of the axis.
        """
        try:
            return 0 not in self._signs(value, None)
        except ArithmeticError:
            return False

    def joined(self, piece: Piece) -> bool:
        """Whether the family's own members at both ends lie on the branch of a piece.

        Parameters
        ----------
        piece
            The piece.
        """
        if not self.family.unknown or self.family.closed:
            return True
        for value in (piece.low, piece.high):
            root = self.root(value, 2 * BITS)
            if root is None or not all(
                wide.contains(ball) for wide, ball in zip(piece.box, root, strict=True)
            ):
                return False
        return True
