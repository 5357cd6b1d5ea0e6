"""The constant matrix of a linear system as a program, without a graph."""

from __future__ import annotations

from collections.abc import Sequence
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..algebra.number_types import Algebra
from ..algebra.program import Begun, Program, Varying
from ..algebra.running_error import TINY, UNIT
from ..base.types import Floats, Record


class Coefficients(Record):
    """A square matrix of doubles, each row over a double, by its entries that are not zero.

    Parameters
    ----------
    rows, columns, values
        Places and numerators of the entries.
    divisors
        Denominator of each row.
    """

    def __init__(
        self,
        rows: NDArray[np.intp],
        columns: NDArray[np.intp],
        values: Floats,
        divisors: Floats,
    ) -> None:
        kept = values != 0
        self.rows, self.columns, self.values = rows[kept], columns[kept], values[kept]
        self.divisors, self.size = divisors, len(divisors)

    def _content(self) -> tuple[Any, ...]:
        arrays = (self.rows, self.columns, self.values, self.divisors)
        return (type(self), *(array.tobytes() for array in arrays))

    @cached_property
    def doubles(self) -> tuple[Floats, Floats]:
        """The matrix in doubles, and a bound on the error of each entry."""
        value, error = np.zeros((2, self.size, self.size))
        divisors = self.divisors[self.rows]
        quotient = self.values / divisors
        value[self.rows, self.columns] = quotient
        rounding = UNIT * np.abs(quotient) + TINY
        error[self.rows, self.columns] = np.where(divisors == 1, 0.0, rounding)
        return value, error


class ConstantMatrix(Program):
    """A program whose output no input changes.

    Parameters
    ----------
    coefficients
        The matrix.
    inputs
        Number of entries of each input.
    """

    def __init__(self, coefficients: Coefficients, inputs: tuple[int, ...]) -> None:
        self.name, self.inputs, self._coefficients = "matrix", inputs, coefficients
        self.shapes = ((coefficients.size, coefficients.size),)
        self.size = len(coefficients.values)

    @cached_property
    def places(self) -> tuple[tuple[tuple[int, int], ...], ...]:  # type: ignore[override]
        """(row, column) of each entry."""
        known = self._coefficients
        return (tuple(zip(known.rows.tolist(), known.columns.tolist(), strict=True)),)

    @property
    def constant(self) -> tuple[Floats, Floats]:
        """The matrix in doubles, and a bound on the error of each entry."""
        return self._coefficients.doubles

    def run(self, algebra: Algebra, _: Sequence[Sequence[Any]]) -> list[list[Any]]:
        """The entries in a number type, in the order of `places`."""
        known = self._coefficients
        entries = list(map(algebra.constant, known.values.tolist()))
        for i in np.flatnonzero(known.divisors[known.rows] != 1):
            entries[i] = entries[i] / algebra.constant(float(known.divisors[known.rows[i]]))
        return [entries]

    def begun(self, algebra: Algebra, arguments: Sequence[Sequence[Any]], _: Varying) -> Begun:
        """All of it is done."""
        return Begun(lambda _f, kept, _a: kept, algebra.functions, self.run(algebra, arguments))

    def arrays(self, _: Sequence[Sequence[Any]], shape: tuple[int, ...]) -> list[Any]:
        """The matrix at points of a shape."""
        value = self.constant[0]
        return [np.broadcast_to(value, (*shape, *value.shape)).copy()]
