"""A CasADi graph read in another algebra: NumPy arrays, python-flint balls, SymPy, CasADi itself.

An SX `Function` is a straight list of scalar instructions.  `Program` holds the list and runs the
instructions over any number type with + - * / and the functions of the graph, so the equations of
motion are written once.  `Program` shares nothing with CasADi's own evaluator and has no lock:
many threads may run one `Program` at once.

The list becomes Python functions without a loop or a look-up.  What reads nothing but constants,
and inputs that do not vary, is computed by a function of its own.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import count
from typing import Any
from weakref import WeakKeyDictionary

import casadi as ca
import numpy as np
from flint import ctx

from ..base.errors import StabilityError
from ..base.types import Floats
from .kernels.tape import LANES, Tape, recorded
from .number_types import (
    BY_OTHERS,
    MORE,
    UNARY,
    Algebra,
    function_of,
    heyoka,
    heyoka_algebra,
    numpy_algebra,
)

Step = tuple[int | None, str | float | tuple[int, int], tuple[int, ...]]
"""(register, what is written there, registers that it reads).  No register: a line of the outputs.
Words are Python source, a float is a constant, a pair an entry of an input."""
Varying = frozenset[tuple[int, int]] | None
"""(input, entry) of what varies; None for every entry."""
Parts = tuple[Callable[..., list[Any]], Callable[..., list[list[Any]]]]
"""What is fixed, of (functions, constants, inputs); the outputs, of (functions, fixed, inputs)."""


def split(name: str, steps: Sequence[Step], sizes: Sequence[int], varying: Varying) -> Parts:
    """Two functions: what is fixed, and the outputs by it.

    Examples
    --------
    >>> steps = [(0, (0, 0), ()), (1, 2.0, ()), (1, "{0} + {0}", (1,)), (0, "{0} * {1}", (0, 1)),
    ...     (None, "o0[0] = {}", (0,))]
    >>> fixed, run = split("f", steps, [1], None)
    >>> kept = fixed({}, [2.0], ())
    >>> kept, run({}, kept, [[3.0]])
    ([2.0, 4.0], [[12.0]])
    """
    still: list[str] = []
    moving = [f"    o{i} = [0] * {size}" for i, size in enumerate(sizes)]
    places: dict[int, int | None] = {}  # among what is fixed, of registers that hold it
    constants = 0
    for register, words, source in steps:
        fixed = all(places[r] is not None for r in source)
        if isinstance(words, float):
            line, constants = f"c[{constants}]", constants + 1
        elif isinstance(words, tuple):
            line = "a[{}][{}]".format(*words)
            fixed = varying is not None and words not in varying
        else:
            line = words.format(*(_read(r, places) for r in source))
        if register is None:
            moving.append(f"    {line}")
        elif fixed:
            still.append(f"    put({line})")
            places[register] = len(still) - 1
        else:
            moving.append(f"    w{register} = {line}")
            places[register] = None
    outputs = ", ".join(f"o{i}" for i in range(len(sizes)))
    text = _function("fixed(f, c, a)", ["    k = []", "    put = k.append", *still], "k")
    text += _function("run(f, k, a)", moving, f"[{outputs}]")
    space: dict[str, Any] = {"function_of": function_of}
    exec(compile(text, f"<graph {name}>", "exec"), space)
    return space["fixed"], space["run"]


def _read(register: int, places: dict[int, int | None]) -> str:
    place = places[register]
    return f"w{register}" if place is None else f"k[{place}]"


def _function(head: str, lines: Sequence[str], result: str) -> str:
    """A function that knows the functions of the number type that it uses."""
    body = "\n".join(lines)
    names = [f"    f_{n} = f[{n!r}]" for n in (*UNARY, "pow", "fabs") if f"f_{n}(" in body]
    names += [f"    f_{n} = function_of(f, {n!r})" for n in BY_OTHERS if f"f_{n}(" in body]
    if "f_sign(" in body:  # the slope of |x|: no value at 0, unless the number type has one
        names.append("    f_sign = f.get('sign') or (lambda x: x / f['fabs'](x))")
    start = "\n".join([f"def {head}:", *names])
    return f"{start}\n{body}\n    return {result}\n"


_SYMBOLS = {
    ca.OP_ADD: "{0} + {1}",
    ca.OP_SUB: "{0} - {1}",
    ca.OP_MUL: "{0} * {1}",
    ca.OP_DIV: "{0} / {1}",
    ca.OP_NEG: "-{0}",
    ca.OP_SQ: "{0} * {0}",
    ca.OP_TWICE: "{0} + {0}",
    ca.OP_INV: "1 / {0}",
    ca.OP_ASSIGN: "{0}",
    ca.OP_POW: "f_pow({0}, {1})",
    ca.OP_CONSTPOW: "f_pow({0}, {1})",
    ca.OP_FABS: "f_fabs({0})",
    ca.OP_SIGN: "f_sign({0})",
}
"""Each operation of CasADi as Python source."""
_SYMBOLS |= {getattr(ca, f"OP_{name.upper()}"): f"f_{name}({{0}})" for name in (*UNARY, *MORE)}
_SYMBOLS |= {ca.OP_HYPOT: "f_hypot({0}, {1})", ca.OP_ATAN2: "f_atan2({0}, {1})"}

_SIGNS = {"LT": "<", "LE": "<=", "EQ": "==", "NE": "!=", "NOT": "not", "AND": "and", "OR": "or"}
_WORDS = {getattr(ca, f"OP_{n}"): f"a branch or comparison ({s})" for n, s in _SIGNS.items()}
_WORDS[ca.OP_IF_ELSE_ZERO] = "a branch (if_else)"
"""Operations that no number type reads, in words; others by CasADi's name."""


def operations(function: ca.Function) -> list[int]:
    """CasADi's code of each instruction of a function, in order.

    Examples
    --------
    >>> x = ca.SX.sym("x")
    >>> ca.OP_SIN in operations(ca.Function("f", [x], [ca.sin(x)]))
    True
    """
    return [function.instruction_id(i) for i in range(function.n_instructions())]


def _in_words(code: int) -> str:
    names = {getattr(ca, name): name[3:].lower() for name in dir(ca) if name.startswith("OP_")}
    return _WORDS.get(code, names.get(code, f"CasADi operation {code}"))


FEW = 4
"""Largest number of points that are taken one by one: an operation on a short array costs seven
times one on a number."""
LONG = 20
"""Fewest instructions for each point for which this is worth its own time."""
LONGER = 500
"""Fewest instructions that few points run by a kernel: an operation on arrays costs 1 to 5 µs."""
UNCOMPILED = 64
"""Runs of a process by NumPy before the kernel is compiled: to load it takes as long as these."""
RUNS = count()
"""Number of the next run."""


def entries(points: Floats) -> list[Any]:
    """The entries of an input at points, one array for each.

    Parameters
    ----------
    points
        Shape (…, n).

    Examples
    --------
    >>> [v.tolist() for v in entries(np.array([[1.0, 2.0], [3.0, 4.0]]))]
    [[1.0, 3.0], [2.0, 4.0]]
    """
    return list(points.transpose(points.ndim - 1, *range(points.ndim - 1)))


def lanes(block: Sequence[Any], shape: tuple[int, ...]) -> list[list[Any]]:
    """The entries of an input at each point of a shape, as numbers.

    Parameters
    ----------
    block
        Entries, arrays that broadcast to `shape`.
    shape
        The shape.

    Examples
    --------
    >>> [[float(v) for v in point] for point in lanes([np.array([1.0, 2.0]), 3.0], (2,))]
    [[1.0, 3.0], [2.0, 3.0]]
    """
    arrays = [np.asarray(v, dtype=float) for v in block]
    spread = [(v if v.shape == shape else np.broadcast_to(v, shape)).ravel() for v in arrays]
    return [[v[i] for v in spread] for i in range(math.prod(shape))]


@dataclass(frozen=True)
class Begun:
    """A program of which a part is done."""

    run: Callable[..., list[list[Any]]]
    """The rest, of (functions of a number type, what is kept, inputs)."""
    functions: dict[str, Callable[..., Any]]
    """Functions of the number type that has begun."""
    kept: list[Any]
    """What follows from the inputs that stay."""

    def __call__(self, arguments: Sequence[Sequence[Any]]) -> list[list[Any]]:
        """The outputs; inputs that stay may be anything."""
        return self.run(self.functions, self.kept, arguments)


class Program:
    """The instruction list of a CasADi SX function, to be run over any number type.

    Parameters
    ----------
    function
        An SX `casadi.Function`; an MX one is expanded.
    constants
        Values of the entries of the last input, which `run` then does not take.  The graph kept
        these numbers as symbols, so that CasADi rounds no sum or product of two of them.

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

    def __init__(self, function: ca.Function, constants: Sequence[float] | None = None) -> None:
        self._given = constants
        function = function if function.is_a("SXFunction") else function.expand()
        self.name: str = function.name()
        taken = function.n_in() - (constants is not None)
        self.inputs = tuple(function.numel_in(i) for i in range(taken))
        """Number of entries of each input that `run` takes."""
        self.shapes = tuple(function.size_out(i) for i in range(function.n_out()))
        """Shape of each output."""
        self.places = tuple(
            tuple(zip(*function.sparsity_out(i).get_triplet(), strict=True))
            for i in range(function.n_out())
        )
        """(row, column) of each stored entry of each output; others are zero by structure."""
        self.size: int = function.n_instructions()
        """Number of instructions."""
        self._sizes = [len(some) for some in self.places]
        self._steps = list(self._read_steps(function, taken))
        self._constants = [float(words) for _, words, _ in self._steps if isinstance(words, float)]
        # several number types go by one name
        self._held = WeakKeyDictionary[Algebra, dict[tuple[int, int], list[Any]]]()
        self._parts: dict[Varying, Parts] = {}

    def _read_steps(self, function: ca.Function, taken: int) -> Iterator[Step]:
        for index in range(function.n_instructions()):
            code = function.instruction_id(index)
            source = tuple(function.instruction_input(index))
            target = function.instruction_output(index)
            if code == ca.OP_CONST:
                yield target[0], float(function.instruction_constant(index)), ()
            elif code == ca.OP_INPUT and source[0] >= taken:
                yield target[0], float(self._given[source[1]]), ()  # type: ignore[index]
            elif code == ca.OP_INPUT:
                yield target[0], (source[0], source[1]), ()
            elif code == ca.OP_OUTPUT:
                yield None, f"o{target[0]}[{target[1]}] = {{}}", source
            elif code in _SYMBOLS:
                yield target[0], _SYMBOLS[code], source
            else:
                functions = ", ".join((*UNARY, *BY_OTHERS))
                raise StabilityError(
                    f"an expression of the system uses {_in_words(code)}, which is not read; only "
                    f"smooth elementary functions are: + - * /, powers, fabs, {functions}."
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
        fixed, run = self._parts_of(None)
        held = self._held.setdefault(algebra, {}) if algebra.lasting else {}
        kept = held.get(key := (ctx.prec, ctx.cap))  # of one precision, and one length of series
        if kept is None:
            kept = held[key] = fixed(algebra.functions, self._in(algebra), ())
        return run(algebra.functions, kept, arguments)

    def begun(
        self, algebra: Algebra, arguments: Sequence[Sequence[Any]], varying: Varying
    ) -> Begun:
        """Compute once what follows from some inputs alone, for many values of the others.

        Parameters
        ----------
        algebra
            The number type.
        arguments
            As in `run`; entries that vary may be anything.
        varying
            (input, entry) of each entry that later calls give.

        Examples
        --------
        >>> x = ca.SX.sym("x", 2)
        >>> program = Program(ca.Function("f", [x], [ca.sin(x[0]) + x[1]]))
        >>> then = program.begun(numpy_algebra(), [[0.0, None]], frozenset({(0, 1)}))
        >>> then([[None, 2.0]])
        [[np.float64(2.0)]]
        """
        fixed, run = self._parts_of(varying)
        kept = fixed(algebra.functions, self._in(algebra), arguments)
        return Begun(run, algebra.functions, kept)

    @property
    def constant(self) -> tuple[Floats, Floats] | None:
        """The one output and a bound on its error, where no input changes it."""
        return None

    def _parts_of(self, varying: Varying) -> Parts:
        if varying not in self._parts:
            self._parts[varying] = split(self.name, self._steps, self._sizes, varying)
        return self._parts[varying]

    def _in(self, algebra: Algebra) -> list[Any]:
        return [algebra.constant(value) for value in self._constants]

    def dense(
        self,
        algebra: Algebra,
        arguments: Sequence[Sequence[Any]],
        output: int = 0,
        *,
        zero: Any = None,
    ) -> list[list[Any]]:
        """One output as rows of entries, with zeros written out.

        Parameters
        ----------
        algebra, arguments
            As for `run`.
        output
            Index of the output.
        zero
            Entry where the graph holds none; the algebra's 0 when left out.

        Returns
        -------
        list of list
            Rows of the output.
        """
        rows, columns = self.shapes[output]
        zero = algebra.constant(0.0) if zero is None else zero
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
            Entries of each input, arrays that broadcast to `shape`.
        shape
            Leading shape of the results.

        Returns
        -------
        list of ndarray
            For each output an array of shape `shape + (rows, columns)`.
        """
        if shape and 0 < (count := math.prod(shape)) <= FEW and self.size >= LONG * count:
            points = zip(*(lanes(block, shape) for block in arguments), strict=True)
            results = [self.arrays(point, ()) for point in points]
            return [np.array(v).reshape(*shape, *v[0].shape) for v in zip(*results, strict=True)]
        with np.errstate(all="ignore"):  # callers check the results
            values = self.run(_NUMPY, arguments)
        return self._in_place(values, shape)

    def _in_place(self, values: Iterable[list[Any]], shape: tuple[int, ...]) -> list[Any]:
        """The outputs as arrays, zeros written out."""
        results = []
        for (rows, columns), places, entries in zip(self.shapes, self.places, values, strict=True):
            array = np.zeros((*shape, rows, columns))
            for (row, column), entry in zip(places, entries, strict=True):
                array[..., row, column] = entry
            results.append(array)
        return results

    @cached_property
    def tape(self) -> Tape | None:
        """All stored entries of the outputs as a tape; None where a function has no kernel."""
        parts = np.cumsum((0, *self.inputs))

        def entries(inputs: list[Any], algebra: Algebra) -> list[Any]:
            blocks = [inputs[a:b] for a, b in zip(parts, parts[1:], strict=False)]
            return [entry for values in self.run(algebra, blocks) for entry in values]

        try:
            return recorded(entries, int(parts[-1]))
        except StabilityError:
            return None

    def quick(self, arguments: Sequence[Sequence[Any]], shape: tuple[int, ...]) -> list[Any]:
        """As `arrays`; a long list runs on few points by one kernel, up to a few roundings."""
        points = [[(v, 0.0) for v in block] for block in arguments]
        outputs = self.enclosed(points, shape)
        if outputs is None:
            return self.arrays(arguments, shape)
        return self._in_place(([mid for mid, _ in some] for some in outputs), shape)

    def enclosed(
        self, arguments: Sequence[Sequence[tuple[Any, Any]]], shape: tuple[int, ...]
    ) -> list[list[tuple[Floats, Floats]]] | None:
        """Balls of doubles of the outputs by one kernel, for a long list and few points.

        Parameters
        ----------
        arguments
            Centre and radius of each entry of each input.
        shape
            Leading shape.

        Returns
        -------
        list of list of (centre, radius)
            For each output, its stored entries; None for a short list or many points, or where a
            function has no kernel.
        """
        if self.size < LONGER or math.prod(shape) > LANES or self.tape is None:
            return None
        balls = np.zeros((2, sum(self.inputs), *shape))
        for i, pair in enumerate(pair for block in arguments for pair in block):
            balls[:, i] = np.broadcast_arrays(*pair, np.empty(shape))[:2]
        points = balls.reshape(2, balls.shape[1], math.prod(shape))
        mid, rad = self.tape.run(*points, plain=next(RUNS) < UNCOMPILED)
        pairs = iter(zip(mid.reshape(len(mid), *shape), rad.reshape(len(rad), *shape), strict=True))
        return [[next(pairs) for _ in some] for some in self.places]

    def many(self, points: Floats) -> Floats:
        """Values at many points: by machine code where heyoka is installed, 20 to 100 times faster.

        The code is built at the first call, in a few tenths of a second.

        Parameters
        ----------
        points
            Entries of all inputs, one input after the other, shape (inputs, N).

        Returns
        -------
        ndarray
            Entries of all outputs in column order, zeros written out, shape (outputs, N).

        Examples
        --------
        >>> x = ca.SX.sym("x", 2)
        >>> Program(ca.Function("f", [x], [x[0] / x[1]])).many(np.array([[1.0, 3.0], [4.0, 2.0]]))
        array([[0.25, 1.5 ]])
        """
        return self._machine(np.ascontiguousarray(points))

    @cached_property
    def _machine(self) -> Callable[[Floats], Floats]:
        """The function of `many`."""
        parts = np.cumsum((0, *self.inputs))

        def split(rows: Any) -> list[list[Any]]:
            return [list(rows[a:b]) for a, b in zip(parts, parts[1:], strict=False)]

        def interpreted(points: Floats) -> Floats:
            outputs = self.arrays(split(points), points.shape[1:])
            rows = [v.swapaxes(1, 2).reshape(len(v), -1).T for v in outputs]
            return np.concatenate(rows)

        try:
            hy = heyoka()
            algebra, names = heyoka_algebra(), [hy.expression(f"a{i}") for i in range(parts[-1])]
            zero, entries = algebra.constant(0.0), []
            for (rows, columns), places, values in zip(
                self.shapes, self.places, self.run(algebra, split(names)), strict=True
            ):
                table = dict(zip(places, values, strict=True))
                entries += [table.get((i, j), zero) for j in range(columns) for i in range(rows)]
            made: Callable[[Floats], Floats] = hy.cfunc(entries, names)
        except (ImportError, KeyError):  # not installed, or a function that heyoka does not have
            return interpreted
        return made


_NUMPY = numpy_algebra()
