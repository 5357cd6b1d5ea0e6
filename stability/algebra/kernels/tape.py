"""Programs as tapes: one list of operations for balls of doubles, run on many points at once.

A tape is recorded by running a `Program` on symbols: equal operations are recorded once, and
registers are used again when their values are no longer needed.  One compiled kernel then runs
every tape, so that no system has to be compiled.

A calculation on power series is recorded number by number: each value is a list of the first Taylor
coefficients in one variable.  Sums, products, quotients, roots, sines and cosines of such lists are
sums and products of numbers, so that the same kernel runs them on balls of doubles: at a point, or
over a piece of the variable.

Source: R. E. Moore, Methods and Applications of Interval Analysis (1979), ch. 3;
tests/boundary/test_formula_boundaries.py compares with series of arbitrary precision.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...base.errors import StabilityError
from ...base.types import Floats
from ..number_types import Algebra
from . import double_balls
from .compiled import compiled, numba_found
from .double_balls import DIFFERENCE, NEGATIVE, PRODUCT, RATIO, ROOT, SINES, SIZE, SUM

LANES = 512
"""Points that run through a tape together: their registers stay in the processor's cache."""
MOST_FACTORS = 16
"""Largest whole exponent that is read as a product."""


@dataclass
class _Recording:
    """Operations in order, each with the values that it reads."""

    places: dict[tuple[Any, ...], int] = field(default_factory=dict)
    steps: list[tuple[int, int, int, int]] = field(default_factory=list)
    constants: dict[int, float] = field(default_factory=dict)
    count: int = 0

    def value(self) -> int:
        self.count += 1
        return self.count - 1

    def constant(self, number: float) -> _Value:
        key = ("constant", float(number), math.copysign(1.0, number))
        if key not in self.places:
            self.places[key] = self.value()
            self.constants[self.places[key]] = float(number)
        return _Value(self, self.places[key])

    def step(self, kind: int, a: _Value, b: _Value | None = None) -> _Value:
        second = -1 if b is None else b.place
        key = (kind, a.place, second)
        if key not in self.places:
            target = self.places[key] = self.value()
            other = self.value() if kind == SINES else second
            self.steps.append((kind, target, a.place, other))
        return _Value(self, self.places[key])


@dataclass(frozen=True, eq=False)
class _Value:
    """A symbol of a recording."""

    recording: _Recording
    place: int

    def _read(self, other: Any) -> _Value:
        return other if isinstance(other, _Value) else self.recording.constant(float(other))

    def __add__(self, other: Any) -> _Value:
        return self.recording.step(SUM, self, self._read(other))

    def __radd__(self, other: Any) -> _Value:
        return self._read(other) + self

    def __sub__(self, other: Any) -> _Value:
        return self.recording.step(DIFFERENCE, self, self._read(other))

    def __rsub__(self, other: Any) -> _Value:
        return self._read(other) - self

    def __mul__(self, other: Any) -> _Value:
        return self.recording.step(PRODUCT, self, self._read(other))

    def __rmul__(self, other: Any) -> _Value:
        return self._read(other) * self

    def __truediv__(self, other: Any) -> _Value:
        return self.recording.step(RATIO, self, self._read(other))

    def __rtruediv__(self, other: Any) -> _Value:
        return self._read(other) / self

    def __neg__(self) -> _Value:
        return self.recording.step(NEGATIVE, self)

    def sqrt(self) -> _Value:
        return self.recording.step(ROOT, self)

    def sin(self) -> _Value:
        return self.recording.step(SINES, self)

    def cos(self) -> _Value:
        return _Value(self.recording, self.sin().place + 1)

    def fabs(self) -> _Value:
        return self.recording.step(SIZE, self)

    def power(self, other: Any) -> _Value:
        exponent = self.recording.constants.get(self._read(other).place)
        if exponent is None or exponent != int(exponent) or abs(exponent) > MOST_FACTORS:
            raise StabilityError("a power whose exponent is no small whole number has no kernel.")
        made = self._read(1.0)
        for _ in range(abs(int(exponent))):
            made = made * self
        return made if exponent >= 0 else 1.0 / made


_FUNCTIONS: dict[str, Callable[..., Any]] = {
    "sqrt": _Value.sqrt,
    "sin": _Value.sin,
    "cos": _Value.cos,
    "fabs": _Value.fabs,
    "tan": lambda x: x.sin() / x.cos(),
    "pow": _Value.power,
}


@dataclass(frozen=True, eq=False)
class Tape:
    """Operations on balls of doubles."""

    inputs: int
    """Number of inputs: the first registers."""
    steps: NDArray[np.int64]
    """Rows (operation, target, first, second)."""
    constants: dict[int, float]
    """Register of each constant, and its value."""
    outputs: tuple[int, ...]
    """Register of each output."""
    size: int
    """Number of registers."""

    def run(self, mid: Floats, rad: Floats | None = None, *, plain: bool = False) -> Any:
        """Balls of the outputs.

        Parameters
        ----------
        mid, rad
            Centres and radii of the inputs, shape (inputs, lanes); no radii for exact inputs.
        plain
            Whether NumPy runs the tape although Numba is installed.

        Returns
        -------
        mid, rad
            Shape (outputs, lanes).

        Examples
        --------
        >>> tape = recorded(lambda a, t: [t.functions["sqrt"](a[0]) / 3], 1)
        >>> mid, rad = tape.run(np.array([[4.0]]))
        >>> bool(abs(mid[0, 0] - 2 / 3) <= rad[0, 0] < 1e-15)
        True
        """
        kernel, lanes = compiled(double_balls, plain=plain), mid.shape[1]
        loops = (1,) if plain or not numba_found() else ()  # NumPy takes a row in one step
        balls = np.zeros((2, len(self.outputs), lanes))
        for low in range(0, lanes, LANES):
            part = slice(low, low + LANES)
            m, r = np.zeros((2, self.size, min(LANES, lanes - low)))
            m[: self.inputs] = mid[:, part]
            if rad is not None:
                r[: self.inputs] = rad[:, part]
            m[self._fixed[0]] = self._fixed[1]
            with np.errstate(all="ignore"):  # a radius that is nan holds everything
                kernel.follow(self.steps, *(v.reshape(-1, *loops, v.shape[1]) for v in (m, r)))
            balls[0, :, part], balls[1, :, part] = m[self._rows], r[self._rows]
        return balls[0], balls[1]

    @cached_property
    def _rows(self) -> NDArray[np.int64]:
        return np.array(self.outputs, dtype=np.int64)

    @cached_property
    def _fixed(self) -> tuple[NDArray[np.int64], Floats]:
        """Registers of the constants, and their values as a column."""
        places = np.array(list(self.constants), dtype=np.int64)
        return places, np.array(list(self.constants.values())).reshape(-1, 1)


def recorded(run: Callable[[list[Any], Algebra], Sequence[Any]], inputs: int) -> Tape:
    """The tape of the values of a calculation over any number type.

    For values with their slopes in an input, take `recorded_series`, which calls this.

    Parameters
    ----------
    run
        Function of the inputs and of the number type, such as a call of `Program.run`.
    inputs
        Number of inputs.

    Raises
    ------
    StabilityError
        If the calculation has a function without a kernel, such as exp.

    Examples
    --------
    >>> recorded(lambda a, t: [a[0] * a[1] + a[0] * a[1]], 2).steps.shape
    (2, 4)
    """
    recording = _Recording()
    variables = [_Value(recording, recording.value()) for _ in range(inputs)]
    algebra = Algebra("tape", recording.constant, _FUNCTIONS, lasting=False)
    try:
        outputs = run(variables, algebra)
    except KeyError as error:
        raise StabilityError(f"{error.args[0]} has no kernel.") from None
    read = [v if isinstance(v, _Value) else recording.constant(float(v)) for v in outputs]
    return _allocated(recording, inputs, [v.place for v in read])


def _allocated(recording: _Recording, inputs: int, outputs: list[int]) -> Tape:
    """The tape with registers in place of values; a register is free after its last reading."""
    last: dict[int, int] = {}
    for i, (kind, _, *places) in enumerate(recording.steps):
        last |= dict.fromkeys(places[:1] if kind == SINES else places, i)
    last |= dict.fromkeys(outputs, len(recording.steps))
    where = {place: i for i, place in enumerate([*range(inputs), *recording.constants])}
    first = size = len(where)
    free: list[int] = []
    rows = []
    for i, (kind, target, a, b) in enumerate(recording.steps):
        new = (target, b) if kind == SINES else (target,)
        for value in new:
            where[value] = free.pop() if free else size
            size = max(size, where[value] + 1)
        rows.append((kind, where[target], where[a], where.get(b, -1)))
        done = {v for v in (target, a, b) if v >= 0 and last.get(v, i) == i}
        free += [where[v] for v in done if where[v] >= first]
    steps = np.array(rows, dtype=np.int64).reshape(-1, 4)
    constants = {where[p]: v for p, v in recording.constants.items()}
    return Tape(inputs, steps, constants, tuple(where[p] for p in outputs), size)


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

    def over(arguments: list[Any], numbers: Algebra) -> list[Any]:
        series = [
            _Series([x, 1.0] if i == variable else [x], order) for i, x in enumerate(arguments)
        ]
        outputs = run(series, _algebra(numbers, order))  # `recorded` refuses what has no kernel
        read = [v if isinstance(v, _Series) else _Series([v], order) for v in outputs]
        return [v[k] for v in read for k in range(order + 1)]

    return recorded(over, inputs)
