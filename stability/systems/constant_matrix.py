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
from ..base.types import Floats


class ConstantMatrix(Program):
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
        self.divisors = divisors
        self.name, self.inputs = "matrix", (0, 0, 0)
        self.shapes, self.size = ((len(divisors), len(divisors)),), len(self.values)

    @cached_property
    def places(self) -> tuple[tuple[tuple[int, int], ...], ...]:  # type: ignore[override]
        """(row, column) of each entry."""
        return (tuple(zip(self.rows.tolist(), self.columns.tolist(), strict=True)),)

    @property
    def content(self) -> tuple[bytes, ...]:
        """What makes two of them equal."""
        arrays = (self.rows, self.columns, self.values, self.divisors)
        return tuple(array.tobytes() for array in arrays)

    @cached_property
    def constant(self) -> tuple[Floats, Floats]:
        """The matrix in doubles, and a bound on the error of each entry."""
        value, error = np.zeros((2, *self.shapes[0]))
        divisors = self.divisors[self.rows]
        quotient = self.values / divisors
        value[self.rows, self.columns] = quotient
        rounding = UNIT * np.abs(quotient) + TINY
        error[self.rows, self.columns] = np.where(divisors == 1, 0.0, rounding)
        return value, error

    def run(self, algebra: Algebra, _: Sequence[Sequence[Any]]) -> list[list[Any]]:
        """The entries in a number type, in the order of `places`."""
        entries = list(map(algebra.constant, self.values.tolist()))
        for i in np.flatnonzero(self.divisors[self.rows] != 1):
            entries[i] = entries[i] / algebra.constant(float(self.divisors[self.rows[i]]))
        return [entries]

    def begun(self, algebra: Algebra, arguments: Sequence[Sequence[Any]], _: Varying) -> Begun:
        """All of it is done."""
        return Begun(lambda _f, kept, _a: kept, algebra.functions, self.run(algebra, arguments))

    def arrays(self, _: Sequence[Sequence[Any]], shape: tuple[int, ...]) -> list[Any]:
        """The matrix at points of a shape."""
        return [np.broadcast_to(self.constant[0], (*shape, *self.shapes[0])).copy()]
