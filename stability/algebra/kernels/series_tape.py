"""Tapes of Taylor coefficients: a calculation on power series, recorded number by number.

Each value of the calculation is a list of the first Taylor coefficients in one variable.  Sums,
products, quotients, roots, sines and cosines of such lists are sums and products of numbers, so
that the same kernel runs them on balls of doubles: at a point, or over a piece of the variable.

Source: R. E. Moore, Methods and Applications of Interval Analysis (1979), ch. 3;
tests/boundary/test_formula_boundaries.py compares with series of arbitrary precision.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

from ...base.errors import StabilityError
from ..number_types import Algebra
from .tape import MOST_FACTORS, Tape, recorded


@dataclass(frozen=True, eq=False)
class _Series:
    """The first Taylor coefficients of a value; those that are left out are zero."""

    terms: list[Any]
    order: int

    def _read(self, other: Any) -> _Series:
        return _Series([other], self.order) if not isinstance(other, _Series) else other

    def _of(self, terms: Sequence[Any]) -> _Series:
        return _Series(list(terms), self.order)

    def __getitem__(self, index: int) -> Any:
        return self.terms[index] if index < len(self.terms) else 0.0

    def __add__(self, other: Any) -> _Series:
        o = self._read(other)
        a, b = sorted((self.terms, o.terms), key=len)
        return self._of([x + y for x, y in zip(a, b, strict=False)] + b[len(a) :])

    __radd__ = __add__

    def __sub__(self, other: Any) -> _Series:
        less = -self._read(other)
        return self + less

    def __rsub__(self, other: Any) -> _Series:
        return self._read(other) - self

    def __neg__(self) -> _Series:
        return self._of([-x for x in self.terms])

    def __mul__(self, other: Any) -> _Series:
        o = self._read(other)
        count = min(len(self.terms) + len(o.terms) - 1, self.order + 1)
        return self._of([_folded(self, o, k, 0) for k in range(count)])

    __rmul__ = __mul__

    def __truediv__(self, other: Any) -> _Series:
        o = self._read(other)
        if len(o.terms) == 1:
            return self._of([x / o[0] for x in self.terms])
        out = self._of([])
        for k in range(self.order + 1):  # c b = a, power by power
            rest = _folded(o, out, k, 1) if k else 0.0
            out.terms.append((self[k] - rest) / o[0])
        return out

    def __rtruediv__(self, other: Any) -> _Series:
        return self._read(other) / self

    def root(self, sqrt: Callable[[Any], Any]) -> _Series:
        first = sqrt(self[0])
        out = self._of([first])
        for k in range(1, self.order + 1 if len(self.terms) > 1 else 1):
            squares = [out[j] * out[k - j] for j in range(1, k)]
            rest = sum(squares[1:], squares[0]) if squares else 0.0
            out.terms.append((self[k] - rest) / (2.0 * first))
        return out

    def waves(
        self, sin: Callable[[Any], Any], cos: Callable[[Any], Any]
    ) -> tuple[_Series, _Series]:
        """Sine and cosine: s' = c x' and c' = -s x'."""
        s, c = self._of([sin(self[0])]), self._of([cos(self[0])])
        slope = self._of([k * x for k, x in enumerate(self.terms)][1:])
        for k in range(1, self.order + 1 if slope.terms else 1):
            up, down = _folded(slope, c, k - 1, 0), _folded(slope, s, k - 1, 0)
            s.terms.append(up / float(k))
            c.terms.append(-down / float(k))
        return s, c

    def power(self, exponent: Any) -> _Series:
        whole = exponent[0] if isinstance(exponent, _Series) else exponent
        if not isinstance(whole, float) or whole != int(whole) or abs(whole) > MOST_FACTORS:
            raise StabilityError("a power whose exponent is no small whole number has no kernel.")
        out = self._of([1.0])
        for _ in range(abs(int(whole))):
            out = out * self
        return out if whole >= 0 else 1.0 / out


def _folded(a: _Series, b: _Series, k: int, first: int) -> Any:
    """Σ a_j b_(k-j) over the terms that are there, j from `first` on."""
    last = min(k, len(a.terms) - 1)
    terms = [a[j] * b[k - j] for j in range(max(first, k - len(b.terms) + 1), last + 1)]
    return sum(terms[1:], terms[0]) if terms else 0.0


def _algebra(numbers: Algebra, order: int) -> Algebra:
    """Power series over the symbols of a tape."""
    sin, cos, sqrt = (numbers.functions[n] for n in ("sin", "cos", "sqrt"))

    def read(x: Any) -> _Series:
        return x if isinstance(x, _Series) else _Series([x], order)

    table: dict[str, Callable[..., Any]] = {
        "sqrt": lambda x: read(x).root(sqrt),
        "sin": lambda x: read(x).waves(sin, cos)[0],
        "cos": lambda x: read(x).waves(sin, cos)[1],
        "pow": lambda x, y: read(x).power(y),
    }
    return Algebra("series tape", float, table, lasting=False)


def recorded_series(
    run: Callable[[list[Any], Algebra], Sequence[Any]], inputs: int, variable: int, order: int
) -> Tape:
    """The tape of the Taylor coefficients of a calculation in one of its inputs.

    `tape.recorded` records the values of a calculation; here the calculation runs on power series,
    whose coefficients that function records as its values.  At order 0 both hold the same values.

    Parameters
    ----------
    run
        Function of the inputs and of the number type, such as a call of `Program.run`.
    inputs
        Number of inputs.
    variable
        Number of the input in which series are taken.
    order
        Order of the last coefficient.

    Returns
    -------
    Tape
        For each value of the calculation its coefficients, lowest first.

    Raises
    ------
    StabilityError
        If the calculation has a function that is not read here, such as exp or |x|.

    Examples
    --------
    >>> import numpy as np
    >>> tape = recorded_series(lambda a, t: [a[0] * t.functions["sin"](a[0])], 1, 0, 2)
    >>> mid, rad = tape.run(np.array([[0.5]]))
    >>> bool(abs(mid[2, 0] - (np.cos(0.5) - 0.25 * np.sin(0.5))) <= rad[2, 0] < 1e-14)
    True
    """

    def over(own: list[Any], numbers: Algebra) -> list[Any]:
        given = [_Series([x, 1.0] if i == variable else [x], order) for i, x in enumerate(own)]
        found = run(given, _algebra(numbers, order))  # `recorded` refuses what has no kernel
        read = [v if isinstance(v, _Series) else _Series([v], order) for v in found]
        return [v[k] for v in read for k in range(order + 1)]

    return recorded(over, inputs)
