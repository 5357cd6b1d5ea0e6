"""Functions of the axis that vanish where an eigenvalue meets the imaginary axis, over a piece.

For each block of the linearisation these are the constant coefficient of its polynomial, and the
Hurwitz determinant, which vanishes where two eigenvalues are opposite (Orlando's formula).  Both
are enclosed as Taylor forms.  To keep the enclosures narrow, the matrix is first carried to a basis
that is nearly its own at the midpoint, and the determinant to one scalar, which is the Schur
complement of the rest.  Neither step moves a zero: each is a product with regular matrices.

Where a family has formulas there is no member to solve for and no matrix: the same two functions
are enclosed as Taylor forms of the formulas, for any height of a body that balls can evaluate.

Source: S. J. Berkowitz, Inf. Process. Lett. 18 (1984) 147-150, for the polynomial without
divisions; tests/boundary/test_interval_search.py, test_formula_boundaries.py.
"""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from flint import arb, arb_mat, arb_series

from ...algebra.exact.routh import expanded_determinant, hurwitz_matrix
from ...algebra.number_types import precision
from ...base.errors import NoMemberError, StabilityError
from ...spectra.verdict_routes import BITS
from ...systems.closed_form import ClosedForm
from ...systems.structure.enclosure import positive_unknowns
from ..brackets import AxisScan, Crossing
from .taylor import coefficient, linearisation, product, quotient, series_algebra, span, terms

SKEW = 1e7
"""Condition number of eigenvectors above which Schur vectors take their place."""

MOST_PIECES = 1200
"""Largest number of pieces for a system of few states."""
MOST_WORK = 400_000
"""Largest number of pieces times the cube of the number of states."""

Form = list[Any]


class NoValueError(ArithmeticError):
    """A quantity has no finite enclosure over a piece."""


@dataclass
class NarrowingBasis:
    """Regular matrices that carry the functions of one block to narrow ones."""

    left: Any
    right: Any
    scale: Any
    turns: list[tuple[Any, Any]] = field(default_factory=list)
    """Left and right factor of the Hurwitz matrix; filled at first use."""


def nonzero(ball: Any) -> bool:
    """Whether a ball is finite and does not hold zero."""
    return bool(ball.is_finite() and not ball.contains(0))


def finite(matrix: Any) -> bool:
    """Whether every entry of a matrix of balls is finite."""
    return all(v.is_finite() for v in matrix.entries())


def basis_of(matrix: Any) -> NarrowingBasis:
    """A basis in which a matrix is nearly diagonal, with its inverse divided by its size."""
    import scipy.linalg

    size = len(matrix)
    right = np.eye(size)
    scale = 1.0
    if np.isfinite(matrix).all() and np.abs(matrix).max() < 1e100:
        values, vectors = np.linalg.eig(matrix)
        real = np.where(values.imag < 0, vectors.imag, vectors.real)
        skew = np.linalg.cond(real) if np.isfinite(real).all() else np.inf
        right = real if skew < SKEW else scipy.linalg.schur(matrix, output="real")[1]
        largest = float(np.abs(values).max())
        scale = 2.0 ** round(math.log2(largest)) if largest > 1e-100 else 1.0
    exact = arb_mat(right.tolist())
    return NarrowingBasis(exact.inv() / arb(scale), exact, scale)


def polynomial(matrix: Sequence[Any], *, fold: bool) -> list[Form]:
    """det(λ - B) by powers of λ, lowest first, for a matrix of forms (Berkowitz)."""
    # Taylor forms of any graph over boxes, algebraic or not; by matrices of balls, in one product
    top, size = len(matrix) - 1, matrix[0].nrows()
    unit = [arb(1), *[arb(0)] * top]
    poly = [unit]
    for r in range(size):
        first = [unit, [-m[r, r] for m in matrix]]
        if r:
            inner = [arb_mat([[m[i, j] for j in range(r)] for i in range(r)]) for m in matrix]
            row = [arb_mat([[-m[r, j] for j in range(r)]]) for m in matrix]
            column = [arb_mat([[m[i, r]] for i in range(r)]) for m in matrix]
            for power in range(r):
                first.append([v[0, 0] for v in product(row, column, fold=fold)])
                if power < r - 1:
                    row = product(row, inner, fold=fold)
        longer = []
        for i in range(r + 2):
            total = [arb(0)] * (top + 1)
            for j in range(max(0, i - len(first) + 1), min(i, r) + 1):
                term = poly[j] if i == j else product(first[i - j], poly[j], fold=fold)
                total = [x + y for x, y in zip(total, term, strict=True)]
            longer.append(total)
        poly = longer
    return poly[::-1]


def determinant(poly: Sequence[Form], basis: NarrowingBasis, *, fold: bool) -> Form:
    """A function with the zeros of the Hurwitz determinant of order n - 1."""
    size = len(poly) - 2
    table = [arb_mat(hurwitz_matrix(order, size, arb(0))) for order in zip(*poly, strict=True)]
    if not basis.turns:
        basis.turns.append(_turns(table[0]))
    left, right = basis.turns[0]
    table = [left * m * right for m in table]
    rows = [[[m[i, j] for m in table] for j in range(size)] for i in range(size)]
    for step in range(size - 1):
        pivot = rows[step]
        for other in rows[step + 1 :]:
            share = quotient(other[step], pivot[step], fold=fold)
            for j in range(step + 1, size):
                less = product(share, pivot[j], fold=fold)
                other[j] = [x - y for x, y in zip(other[j], less, strict=True)]
    return rows[-1][-1]


def _turns(matrix: Any) -> tuple[Any, Any]:
    """Regular factors that make a matrix nearly the identity but for its last diagonal entry."""
    size = matrix.nrows()
    table = np.array([[float(matrix[i, j].mid()) for j in range(size)] for i in range(size)])
    if not np.isfinite(table).all():
        raise NoValueError
    left, sizes, right = np.linalg.svd(table)
    sizes[-1] = sizes[0]
    if not (sizes > 0).all():
        raise NoValueError
    rows = arb_mat((left.T / sizes[:, None]).tolist())
    columns = arb_mat(right.T.tolist())
    if rows.det().contains(0) or columns.det().contains(0):
        raise NoValueError
    return rows, columns


MATRIX_ORDER = 4
"""Order of the Taylor forms."""
POINT_BITS = 512
"""Precision at which the sign of a function at a point that is still open counts as zero."""
WIDER = 2.0**-16
"""Share by which the piece of the unknowns is wider, so that roots at its ends lie inside."""


@dataclass
class EnclosedPiece:
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
    bases: list[NarrowingBasis]
    """One for each block."""


def middle_of(low: float, high: float) -> float:
    """The point of a piece about which its forms are taken."""
    return low + (high - low) / 2


class Meetings(ABC):
    """The functions along a line, and what a search over pieces asks of them."""

    line: AxisScan
    """The line."""
    blocks: list[list[int]]
    """States of each block of the linearisation."""
    count: int
    """Number of functions at most."""
    every: bool = False
    """Whether meetings count where another eigenvalue stays unstable."""

    @property
    def most(self) -> int:
        """Largest number of pieces."""
        return min(MOST_PIECES, MOST_WORK // max(map(len, self.blocks)) ** 3)

    def prepared(self, value: float) -> bool:  # noqa: ARG002
        """Whether `root` need not follow the member from the family's known one."""
        return True

    def prepare(self, values: Sequence[float]) -> None:  # noqa: B027
        """Double-precision unknowns at many points, followed all at once, for `root`."""

    @abstractmethod
    def root(self, value: float, bits: int = BITS) -> list[Any] | None:
        """The unknowns of the member; None without a member."""

    @abstractmethod
    def piece(self, low: float, high: float) -> Any:
        """Everything enclosed over a piece, at the working precision.

        Raises
        ------
        NoMemberError
            If no member is proved all along it.
        NoValueError
            If there is no finite enclosure.
        """

    def joined(self, piece: Any) -> bool:  # noqa: ARG002
        """Whether the members at both ends lie on the branch of a piece."""
        return True

    @abstractmethod
    def forms(self, piece: Any) -> list[Form]:
        """The functions over a piece."""

    @abstractmethod
    def monotone(self, piece: Any, places: Sequence[int]) -> bool:
        """Whether some functions are proved to be monotone over a piece."""

    @abstractmethod
    def values(self, value: float, bits: int, piece: Any) -> list[Any] | None:
        """The functions at a point, perhaps in the bases of a piece; None without a member."""

    def zeros_in(self, piece: Any) -> int | None:
        """Number of zeros of all functions on a piece, each simple; None if this is not proved."""
        open_ = [i for i, f in enumerate(self.forms(piece)) if not nonzero(span(f))]
        if not open_:
            return 0
        if not self.monotone(piece, open_):
            return None
        ends = [self._point_signs(value, piece) for value in (piece.low, piece.high)]
        signs = [(ends[0][i], ends[1][i]) for i in open_]
        return None if any(0 in pair for pair in signs) else sum(a != b for a, b in signs)

    def divisible(self, low: float, high: float) -> bool:  # noqa: ARG002
        """Whether narrower pieces may be proved where one is not."""
        return True

    def near(self, piece: Any) -> tuple[float, Crossing] | None:  # noqa: ARG002
        """The single meeting of a piece to double precision, where it is known."""
        return None

    def _point_signs(self, value: float, piece: Any = None) -> list[int]:
        """Proved signs of the functions at a point; 0 where open."""
        bits, out = BITS, [0]
        while 0 in out and bits <= POINT_BITS:
            values = self.values(value, bits, piece)
            if values is None:
                return [0] * self.count
            out = [int(f > 0) - int(f < 0) for f in values]
            bits *= 2
        return out

    def clear(self, value: float) -> bool:
        """Whether no eigenvalue is on the imaginary axis at a point, proved."""
        try:
            return 0 not in self._point_signs(value)
        except ArithmeticError:
            return False


def around(low: float, high: float) -> tuple[Any, Any, Any]:
    """Middle, half-width and ball of a piece; the ball may reach beyond one end."""
    middle = arb(middle_of(low, high))
    half = max(arb(high) - middle, middle - arb(low))
    return middle, half, arb(middle, half.abs_upper())


class GraphMeetings(Meetings):
    """The functions of the graph's linearisation along a line.

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
        self.count = 2 * len(self.blocks)
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

    def prepared(self, value: float) -> bool:
        """Whether it was followed with others."""
        return value in self._rough

    def prepare(self, values: Sequence[float]) -> None:
        """Follow the members at new points, all at once."""
        new = [v for v in dict.fromkeys(values) if v not in self._rough]
        if not new or self.family.anchor is None or self.family.closed:
            return
        self._rough.update(zip(new, self.line.followed(new), strict=True))

    def root(self, value: float, bits: int = BITS) -> list[Any] | None:
        """The unknowns of the member that the root-finder gives, proved and kept."""
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
        return positive_unknowns(self.family, *self.line.numbers_at(place), near)

    def _matrices(self, place: Any, start: list[Any], count: int) -> list[Any]:
        """Taylor coefficients of the linearisation at a point, or at every point of a ball."""
        with terms(count):
            a, q = self.line.numbers_at(arb_series([place, 1]))
            return linearisation(self.family, a, q, start, count)

    # --- a piece ---

    def members(self, low: float, high: float) -> tuple[list[Any], list[Any]]:
        """The unknowns at the middle of a piece, and over it, each the only root nearby.

        Raises
        ------
        NoMemberError
            If no member is proved.
        """
        point = middle_of(low, high)
        middle, half, _ = around(low, high)
        here = self.root(point)
        if here is None:
            raise NoMemberError(f"{self.family.name} has no member at {point}.")
        wide = arb(middle, (half * (1 + WIDER)).abs_upper())
        return here, self._unknowns(wide, [float(v.mid()) for v in here])

    def piece(self, low: float, high: float) -> EnclosedPiece:
        """Members and linearisations over a piece."""
        middle, half, whole = around(low, high)
        here, box = self.members(low, high)
        over = self._matrices(whole, box, MATRIX_ORDER + 1)
        if not finite(over[0]):
            raise NoValueError
        order = MATRIX_ORDER if all(map(finite, over)) else 0
        forms = [*(self._matrices(middle, here, order) if order else []), over[order]]
        scaled = [m * half**k for k, m in enumerate(forms)]
        slopes = [over[0], over[1] * half] if order else []
        if not finite(scaled[0]):
            raise NoValueError
        return EnclosedPiece(low, high, order, scaled, slopes, box, self._bases(scaled[0]))

    def _bases(self, matrix: Any) -> list[NarrowingBasis]:
        size = matrix.nrows()
        table = np.array([[float(matrix[i, j].mid()) for j in range(size)] for i in range(size)])
        return [basis_of(table[np.ix_(block, block)]) for block in self.blocks]

    def functions(
        self, matrices: Sequence[Any], bases: Sequence[NarrowingBasis], *, fold: bool
    ) -> list[Form]:
        """The functions as forms: static and flutter for each block."""
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

    def forms(self, piece: EnclosedPiece) -> list[Form]:
        """Both functions of each block."""
        return self.functions(piece.matrices, piece.bases, fold=True)

    def monotone(self, piece: EnclosedPiece, places: Sequence[int]) -> bool:
        """By the slopes over all of the piece."""
        if not piece.slopes:
            return False
        slopes = self.functions(piece.slopes, piece.bases, fold=False)
        return all(nonzero(slopes[i][1]) for i in places)

    def values(self, value: float, bits: int, piece: EnclosedPiece | None) -> list[Any] | None:
        """Both functions of each block."""
        root = self.root(value, bits)
        if root is None:
            return None
        with precision(bits):
            matrix = self._matrices(arb(value), root, 1)
            if not finite(matrix[0]):
                return None
            bases = piece.bases if piece else self._bases(matrix[0])
            return [f[0] for f in self.functions(matrix, bases, fold=True)]

    def joined(self, piece: Any) -> bool:
        """Whether the members at both ends lie in the box of the piece."""
        if not self.family.unknown or self.family.closed:
            return True
        for value in (piece.low, piece.high):
            root = self.root(value, 2 * BITS)
            if root is None or not all(
                wide.contains(ball) for wide, ball in zip(piece.box, root, strict=True)
            ):
                return False
        return True


FORMULA_ORDER = 6
"""Order of the Taylor forms."""


@dataclass
class FormulaPiece:
    """A piece of the axis with the functions of its formulas."""

    low: float
    high: float
    forms: list[Form]
    """Functions as Taylor forms."""


class FormulaMeetings(Meetings):
    """The functions of a family's formulas along a line."""

    def __init__(self, line: AxisScan, formulas: ClosedForm) -> None:
        self.line, self.formulas = line, formulas
        self.blocks = [[0]]
        self.count = len(self.kinds)
        self._known: dict[tuple[float, int], list[Any]] = {}

    def root(self, value: float, bits: int = BITS) -> list[Any] | None:
        """An empty list where the formulas are those of a member."""
        return None if self.values(value, bits, None) is None else []

    def piece(self, low: float, high: float) -> FormulaPiece:
        """The functions over a piece where its formulas are those of members."""
        middle, half, whole = around(low, high)
        inner, asked = self._series(middle)
        outer, numbers = self._series(whole)

        def form(a: Any, b: Any) -> Form:
            some = [coefficient(a, k) for k in range(FORMULA_ORDER)] + [
                coefficient(b, FORMULA_ORDER)
            ]
            coefficients = [c * half**k for k, c in enumerate(some)]
            if not all(c.is_finite() for c in coefficients):
                raise NoValueError
            return coefficients

        if not all(span(form(a, b)) > 0 for a, b in zip(asked, numbers, strict=True)):
            raise NoMemberError(f"{self.line.problem.family.name} has no member there.")
        return FormulaPiece(low, high, [form(a, b) for a, b in zip(inner, outer, strict=True)])

    def _series(self, place: Any) -> tuple[list[Any], list[Any]]:
        """Functions, and numbers that are positive at members, as series about a ball."""
        with terms(FORMULA_ORDER + 1):
            a, q = self.line.numbers_at(arb_series([place, 1]))
            try:
                coefficients, _, positive = self.formulas(series_algebra(), a, q)
            except ValueError:  # a series divides by one whose first term may vanish
                raise NoValueError from None
            return self._functions(coefficients), positive

    def _functions(self, coefficients: Sequence[Any]) -> list[Any]:
        """Numbers that vanish where an eigenvalue meets the imaginary axis, or infinity."""
        if self.formulas.even and len(coefficients) > 3:
            raise NoValueError
        return watched(coefficients, even=self.formulas.even)

    @property
    def kinds(self) -> list[Crossing | None]:
        """What each of these numbers means; None for infinity."""
        kinds: list[Crossing | None] = [Crossing.STATIC, None]
        return kinds if self.formulas.even else [*kinds, Crossing.FLUTTER]

    def forms(self, piece: FormulaPiece) -> list[Form]:
        """The functions of the polynomial."""
        return piece.forms

    def monotone(self, piece: FormulaPiece, places: Sequence[int]) -> bool:
        """By the derivatives of the forms."""
        slopes = ([k * c for k, c in enumerate(piece.forms[i])][1:] for i in places)
        return all(nonzero(span(slope)) for slope in slopes)

    def values(
        self,
        value: float,
        bits: int,
        piece: FormulaPiece | None,  # noqa: ARG002
    ) -> list[Any] | None:
        """The functions of the polynomial, kept."""
        key = value, bits
        if key not in self._known:
            with precision(bits):
                a, q = self.line.numbers_at(value)
                coefficients, _, positive = self.formulas(series_algebra(), a, q)
                if not all(v > 0 for v in positive):
                    return None
                self._known[key] = self._functions(coefficients)
        return self._known[key]


def watched(coefficients: Sequence[Any], *, even: bool) -> list[Any]:
    """Functions of a polynomial that vanish where a root meets the imaginary axis, or infinity.

    Parameters
    ----------
    coefficients
        By powers, lowest first, of any number type.
    even
        Whether those of odd powers vanish; the polynomial is then linear in λ².
    """
    if even:
        return list(coefficients[::2])
    rows = hurwitz_matrix(coefficients, len(coefficients) - 2, None)
    return [coefficients[0], coefficients[-1], expanded_determinant(rows)]
