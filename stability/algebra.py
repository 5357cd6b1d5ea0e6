"""A CasADi graph read in another algebra: NumPy arrays, python-flint balls, SymPy, CasADi itself.

An SX `Function` is a straight list of scalar instructions.  `Program` holds that list and runs it
over any number type with + - * / and the few functions the graph uses, so the equations of motion
stay written once.  Nothing here is shared with CasADi's own evaluator, and nothing is locked: a
`Program` may run in many threads at once.
"""

from __future__ import annotations

import operator
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import lru_cache
from typing import Any

import casadi as ca
import numpy as np

from .errors import StabilityError


class Upright:
    """The exact right angle π/2 as a symbol: its sine is 1, its cosine 0, and no more is known.

    No double is π/2, so a motion with the disk upright is read from the graph with this in place
    of theta; the terms with cosθ then vanish from the graph itself.

    Examples
    --------
    >>> UPRIGHT.sin(), UPRIGHT.cos()
    (1, 0)
    """

    def sin(self) -> int:
        """The sine, exactly."""
        return 1

    def cos(self) -> int:
        """The cosine, exactly."""
        return 0

    def __repr__(self) -> str:
        return "UPRIGHT"


UPRIGHT = Upright()
"""The one right angle."""


@dataclass(frozen=True)
class Algebra:
    """A number type: how it holds a constant, and its functions beyond + - * /."""

    name: str
    """What it is called."""
    constant: Callable[[float], Any]
    """The double as a number of this type, exactly."""
    functions: dict[str, Callable[..., Any]]
    """sin, cos, tan, sqrt, exp, log, … by name."""


_UNARY = ("sin", "cos", "tan", "sqrt", "exp", "log", "asin", "acos", "atan", "sinh", "cosh", "tanh")


def numpy_algebra() -> Algebra:
    """Double-precision arrays, elementwise.

    Examples
    --------
    >>> numpy_algebra().functions["sqrt"](4.0)
    np.float64(2.0)
    """
    other = {"asin": np.arcsin, "acos": np.arccos, "atan": np.arctan, "pow": np.power}
    other |= {"fabs": np.abs}
    table = {name: getattr(np, name) for name in _UNARY if name not in other}
    return Algebra("numpy", float, table | other)


def ball_algebra() -> Algebra:
    """Real balls of python-flint at the precision of its context: every result encloses the truth.

    Examples
    --------
    >>> ball_algebra().functions["sqrt"](ball_algebra().constant(4.0))
    2.00000000000000
    """
    from flint import arb

    table: dict[str, Callable[..., Any]] = {name: operator.methodcaller(name) for name in _UNARY}
    table["pow"] = lambda x, y: x**y
    table["fabs"] = abs
    return Algebra("ball", arb, table)


def sympy_algebra() -> Algebra:
    """SymPy expressions, with every constant an exact rational.

    Examples
    --------
    >>> sympy_algebra().constant(0.25)
    1/4
    """
    import sympy

    table = {name: getattr(sympy, name) for name in _UNARY}
    return Algebra("sympy", sympy.Rational, table | {"pow": sympy.Pow, "fabs": sympy.Abs})


def casadi_algebra() -> Algebra:
    """CasADi's own SX, which folds constants: the way to read a graph at an exact symbol.

    Examples
    --------
    >>> casadi_algebra().constant(0.25)
    SX(0.25)
    """
    table = {name: getattr(ca, name) for name in _UNARY}
    return Algebra("casadi", ca.SX, table | {"pow": ca.power, "fabs": ca.fabs})


_BINARY: dict[int, Callable[[Any, Any], Any]] = {
    ca.OP_ADD: operator.add,
    ca.OP_SUB: operator.sub,
    ca.OP_MUL: operator.mul,
    ca.OP_DIV: operator.truediv,
}
_PLAIN: dict[int, Callable[[Any], Any]] = {
    ca.OP_NEG: operator.neg,
    ca.OP_SQ: lambda x: x * x,
    ca.OP_TWICE: lambda x: x + x,
    ca.OP_INV: lambda x: 1 / x,
    ca.OP_ASSIGN: lambda x: x,
}
_NAMED: dict[int, str] = {getattr(ca, f"OP_{name.upper()}"): name for name in _UNARY}
_NAMED |= {ca.OP_FABS: "fabs"}


class Program:
    """The instruction list of a CasADi SX function, to be run over any number type.

    Parameters
    ----------
    function
        An SX `casadi.Function`; an MX one is expanded.

    Raises
    ------
    StabilityError
        If the graph has an operation outside + - * / and the elementary functions.

    Examples
    --------
    >>> x = ca.SX.sym("x", 2)
    >>> program = Program(ca.Function("f", [x], [x[0] / x[1], ca.sin(x[0])]))
    >>> program.run(numpy_algebra(), [[1.0, 4.0]])
    [[0.25], [np.float64(0.8414709848078965)]]
    """

    def __init__(self, function: ca.Function) -> None:
        function = function if function.is_a("SXFunction") else function.expand()
        self.name: str = function.name()
        self.inputs = tuple(function.nnz_in(i) for i in range(function.n_in()))
        self.shapes = tuple(function.size_out(i) for i in range(function.n_out()))
        """Shape of each output."""
        self.places = tuple(
            tuple(zip(*function.sparsity_out(i).get_triplet(), strict=True))
            for i in range(function.n_out())
        )
        """(row, column) of each stored entry of each output; the others are zero by structure."""
        self._work = function.sz_w()
        self._steps = [self._step(function, i) for i in range(function.n_instructions())]

    @staticmethod
    def _step(function: ca.Function, index: int) -> tuple[int, Any, tuple[int, ...], Any]:
        code = function.instruction_id(index)
        source = tuple(function.instruction_input(index))
        target = tuple(function.instruction_output(index))
        if code == ca.OP_CONST:
            return 0, function.instruction_constant(index), (), target[0]
        if code == ca.OP_INPUT:
            return 1, None, source, target[0]
        if code == ca.OP_OUTPUT:
            return 2, None, source, target
        if code in _BINARY:
            return 3, _BINARY[code], source, target[0]
        if code in _PLAIN:
            return 4, _PLAIN[code], source[:1], target[0]
        if code in _NAMED:
            return 5, _NAMED[code], source[:1], target[0]
        if code in (ca.OP_POW, ca.OP_CONSTPOW):
            return 6, "pow", source, target[0]
        raise StabilityError(
            f"the graph {function.name()} uses CasADi operation {code} "
            "(a branch, comparison or special function); only smooth elementary functions are read."
        )

    def run(self, algebra: Algebra, arguments: Sequence[Sequence[Any]]) -> list[list[Any]]:
        """Run the instructions.

        Parameters
        ----------
        algebra
            The number type.
        arguments
            For each input of the function, its entries in column order.

        Returns
        -------
        list of list
            For each output, its stored entries in column order (see `places`).
        """
        work: list[Any] = [None] * max(self._work, 1)
        outputs: list[list[Any]] = [[0] * len(places) for places in self.places]
        functions = algebra.functions
        for kind, what, source, target in self._steps:
            if kind == 3:
                work[target] = what(work[source[0]], work[source[1]])
            elif kind == 4:
                work[target] = what(work[source[0]])
            elif kind == 1:
                work[target] = arguments[source[0]][source[1]]
            elif kind == 2:
                outputs[target[0]][target[1]] = work[source[0]]
            elif kind == 0:
                work[target] = algebra.constant(what)
            elif kind == 5:
                value = work[source[0]]
                exact = isinstance(value, Upright)
                work[target] = getattr(value, what)() if exact else functions[what](value)
            else:
                work[target] = functions[what](work[source[0]], work[source[1]])
        return outputs

    def dense(
        self, algebra: Algebra, arguments: Sequence[Sequence[Any]], output: int = 0
    ) -> list[list[Any]]:
        """Run, and return one output as rows of entries, zeros written out.

        Parameters
        ----------
        algebra, arguments
            As in `run`.
        output
            Which output.

        Returns
        -------
        list of list
            Rows.
        """
        rows, columns = self.shapes[output]
        zero = algebra.constant(0.0)
        table = [[zero] * columns for _ in range(rows)]
        values = self.run(algebra, arguments)[output]
        for (row, column), value in zip(self.places[output], values, strict=True):
            table[row][column] = value
        return table

    def arrays(self, arguments: Sequence[Sequence[Any]], shape: tuple[int, ...]) -> list[Any]:
        """Run on NumPy arrays of one shape.

        Parameters
        ----------
        arguments
            For each input its entries, arrays that broadcast to `shape`.
        shape
            Leading shape of the results.

        Returns
        -------
        list of ndarray
            For each output an array of shape `shape + (rows, columns)`.
        """
        with np.errstate(all="ignore"):  # callers check what they get
            values = self.run(_NUMPY, arguments)
        results = []
        for (rows, columns), places, entries in zip(self.shapes, self.places, values, strict=True):
            array = np.zeros((*shape, rows, columns))
            for (row, column), entry in zip(places, entries, strict=True):
                array[..., row, column] = entry
            results.append(array)
        return results


_NUMPY = numpy_algebra()


@lru_cache(maxsize=1)
def balls() -> Algebra:
    """The ball algebra, imported at first use."""
    return ball_algebra()
