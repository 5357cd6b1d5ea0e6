"""Meetings with the imaginary axis of a family with formulas: no member to solve for, no matrix.

Constant coefficient and Hurwitz determinant are enclosed as Taylor forms of the formulas
themselves, for any height of a body that balls can evaluate.

Source: tests/boundary/test_formula_boundaries.py.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

from flint import arb, arb_series

from ...algebra.balls import precision
from ...base.errors import NoMemberError
from ...systems.closed_form import ClosedForm
from ..brackets import BITS, AxisScan
from ..crossings import Crossing
from .blocks import NoValueError, nonzero
from .meetings import POINT_BITS, middle_of
from .taylor import coefficient, series_algebra, span, terms

ORDER = 6
"""Order of the Taylor forms."""

Form = list[Any]


@dataclass
class FormulaPiece:
    """A piece of the axis with the functions of its formulas."""

    low: float
    high: float
    forms: list[Form]
    """Functions as Taylor forms."""
    slopes: list[Form]
    """Their derivatives by t."""


class FormulaMeetings:
    """The functions along a line.

    Parameters
    ----------
    line
        The line.
    formulas
        Formulas of its family.
    """

    def __init__(self, line: AxisScan, formulas: ClosedForm) -> None:
        self.line, self.formulas = line, formulas
        self.blocks = [[0]]
        self._known: dict[tuple[float, int], list[int]] = {}

    # --- what a search asks of members: they are given by formulas ---

    def prepared(self, value: float) -> bool:  # noqa: ARG002
        """Nothing is prepared."""
        return True

    def prepare(self, values: Sequence[float]) -> None:
        """Nothing is prepared."""

    def root(self, value: float, bits: int = BITS) -> list[Any] | None:
        """An empty list where the formulas are those of a member, otherwise None."""
        return None if self._at(value, bits) is None else []

    def joined(self, piece: FormulaPiece) -> bool:  # noqa: ARG002
        """Formulas have one branch."""
        return True

    # --- a piece ---

    def piece(self, low: float, high: float) -> FormulaPiece:
        """Functions over a piece, at the working precision.

        Parameters
        ----------
        low, high
            Its ends.

        Raises
        ------
        NoMemberError
            If the formulas are not proved to be those of members all along it.
        NoValueError
            If they have no finite enclosure.
        """
        middle = arb(middle_of(low, high))
        half = max(arb(high) - middle, middle - arb(low))
        whole = arb(middle, half.abs_upper())
        inner, asked = self._series(middle)
        outer, numbers = self._series(whole)

        def form(a: Any, b: Any) -> Form:
            some = [coefficient(a, k) for k in range(ORDER)] + [coefficient(b, ORDER)]
            found = [c * half**k for k, c in enumerate(some)]
            if not all(c.is_finite() for c in found):
                raise NoValueError
            return found

        if not all(span(form(a, b)) > 0 for a, b in zip(asked, numbers, strict=True)):
            raise NoMemberError(f"{self.line.problem.family.name} has no member there.")
        forms = [form(a, b) for a, b in zip(inner, outer, strict=True)]
        slopes = [[k * c for k, c in enumerate(f)][1:] for f in forms]
        return FormulaPiece(low, high, forms, slopes)

    def _series(self, place: Any) -> tuple[list[Any], list[Any]]:
        """Functions, and numbers that are positive at members, as series about a ball."""
        with terms(ORDER + 1):
            given = self.line.exact() | {self.line.axis: arb_series([place, 1])}
            a, q, _ = self.line.problem.reduce(given, lambda v: v.sqrt())
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
        own: list[Crossing | None] = [Crossing.STATIC, None]
        return own if self.formulas.even else [*own, Crossing.FLUTTER]

    def zeros_in(self, piece: FormulaPiece) -> int | None:
        """Number of zeros of all functions on a piece, each simple; None if this is not proved.

        Parameters
        ----------
        piece
            The piece.
        """
        open_ = [i for i, f in enumerate(piece.forms) if not nonzero(span(f))]
        if not open_:
            return 0
        if not all(nonzero(span(piece.slopes[i])) for i in open_):
            return None
        ends = [self._signs(v) for v in (piece.low, piece.high)]
        signs = [(ends[0][i], ends[1][i]) for i in open_]
        if any(0 in pair for pair in signs):
            return None
        return sum(a != b for a, b in signs)

    def _signs(self, value: float) -> list[int]:
        """Proved signs of the functions at a point; 0 where open."""
        bits, out = BITS, [0]
        while 0 in out and bits <= POINT_BITS:
            found = self._at(value, bits)
            if found is None:
                return [0]
            out, bits = found, 2 * bits
        return out

    def _at(self, value: float, bits: int) -> list[int] | None:
        """Signs at a point, at one precision; None without a member."""
        key = value, bits
        if key not in self._known:
            with precision(bits):
                a, q = self.line.problem.balls(self.line.fixed | {self.line.axis: value})
                coefficients, _, positive = self.formulas(series_algebra(), a, q)
                if not all(v > 0 for v in positive):
                    return None
                found = self._functions(coefficients)
                self._known[key] = [int(f > 0) - int(f < 0) for f in found]
        return self._known[key]

    def clear(self, value: float) -> bool:
        """Whether no eigenvalue is on the imaginary axis at a point, proved.

        Parameters
        ----------
        value
            Value of the axis.
        """
        return 0 not in self._signs(value)


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
    return [coefficients[0], coefficients[-1], hurwitz(coefficients, len(coefficients) - 2)]


def hurwitz(coefficients: Sequence[Any], size: int) -> Any:
    """A Hurwitz determinant of a polynomial, without divisions.

    Parameters
    ----------
    coefficients
        By powers, lowest first, of any number type.
    size
        Order of the determinant.

    Examples
    --------
    >>> hurwitz([1, 2, 3, 4], 2)
    2
    """
    high = list(reversed(coefficients))

    def entry(i: int, j: int) -> Any:
        index = 2 * (j + 1) - (i + 1)
        return high[index] if 0 <= index < len(high) else None

    def minor(row: int, columns: tuple[int, ...]) -> Any:
        if not columns:
            return 1
        total: Any = 0
        for place, j in enumerate(columns):
            one = entry(row, j)
            if one is not None:
                term = one * known(row + 1, columns[:place] + columns[place + 1 :])
                total = total - term if place % 2 else total + term
        return total

    table: dict[Any, Any] = {}

    def known(row: int, columns: tuple[int, ...]) -> Any:
        if (row, columns) not in table:
            table[row, columns] = minor(row, columns)
        return table[row, columns]

    return known(0, tuple(range(size)))
