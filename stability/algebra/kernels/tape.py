"""Programs as tapes: one list of operations for balls of doubles, run on many points at once.

A tape is recorded by running a `Program` on symbols: equal operations are recorded once, and
registers are used again when their values are no longer needed.  One compiled kernel then runs
every tape, so that no system has to be compiled.
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

    known: dict[tuple[Any, ...], int] = field(default_factory=dict)
    steps: list[tuple[int, int, int, int]] = field(default_factory=list)
    constants: dict[int, float] = field(default_factory=dict)
    count: int = 0

    def value(self) -> int:
        self.count += 1
        return self.count - 1

    def constant(self, number: float) -> _Value:
        key = ("constant", float(number), math.copysign(1.0, number))
        if key not in self.known:
            self.known[key] = self.value()
            self.constants[self.known[key]] = float(number)
        return _Value(self, self.known[key])

    def step(self, kind: int, a: _Value, b: _Value | None = None) -> _Value:
        second = -1 if b is None else b.place
        key = (kind, a.place, second)
        if key not in self.known:
            target = self.known[key] = self.value()
            other = self.value() if kind == SINES else second
            self.steps.append((kind, target, a.place, other))
        return _Value(self, self.known[key])


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
        found = np.zeros((2, len(self.outputs), lanes))
        for low in range(0, lanes, LANES):
            part = slice(low, low + LANES)
            m, r = np.zeros((2, self.size, min(LANES, lanes - low)))
            m[: self.inputs] = mid[:, part]
            if rad is not None:
                r[: self.inputs] = rad[:, part]
            m[self._fixed[0]] = self._fixed[1]
            with np.errstate(all="ignore"):  # a radius that is nan holds everything
                kernel.follow(self.steps, *(v.reshape(-1, *loops, v.shape[1]) for v in (m, r)))
            found[0, :, part], found[1, :, part] = m[self._rows], r[self._rows]
        return found[0], found[1]

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

    For values with their slopes in an input, take `series_tape.recorded_series`, which calls this.

    Parameters
    ----------
    run
        Function of the inputs and of the number type, such as a call of `Program.run`.
    inputs
        Number of inputs.

    Returns
    -------
    Tape

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
    own = [_Value(recording, recording.value()) for _ in range(inputs)]
    algebra = Algebra("tape", recording.constant, _FUNCTIONS, lasting=False)
    try:
        found = run(own, algebra)
    except KeyError as error:
        raise StabilityError(f"{error.args[0]} has no kernel.") from None
    read = [v if isinstance(v, _Value) else recording.constant(float(v)) for v in found]
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
