"""A system's graph read at a family: state, rates, Jacobian, equations, tangent.

CasADi's Jacobian of a large graph is larger by the number of states, before a family folds most of
it to zero.  Here each number carries its slopes along the states, and a slope that folds to zero at
the family is never built.

A graph that has eliminated a dense mass matrix of n rows holds n³/3 products, and its slopes n
times as many.  Balls lose a digit with each pivot of it.  For a large implicit system M(x) z = F(x)
M, F and the slopes of F - M z stay small graphs.  Then z = M⁻¹ F, and the slopes of z are
M⁻¹ ∂(F - M z) with z held.

Source: tests/systems/test_implicit.py.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import casadi as ca
import numpy as np

from ...algebra.linear_systems import solution
from ...algebra.number_types import MORE, UNARY, Algebra
from ...algebra.program import Program
from ...algebra.upright import Upright
from ...base.errors import StabilityError
from ..equations import Equations
from .algebraic import without_algebraic
from .constants import Constants, exact_numbers, rounded

# --- slopes on the way ---


Slopes = dict[int, Any]


class Sloped:
    """A number with its nonzero slopes along the states, by index."""

    __slots__ = ("slopes", "value")

    def __init__(self, value: Any, slopes: Slopes) -> None:
        self.value, self.slopes = value, slopes

    def __add__(self, other: Any) -> Sloped:
        value, slopes = _split(other)
        return Sloped(self.value + value, _joined(self.slopes, slopes))

    __radd__ = __add__

    def __neg__(self) -> Sloped:
        return Sloped(-self.value, {j: -s for j, s in self.slopes.items()})

    def __sub__(self, other: Any) -> Sloped:
        value, slopes = _split(other)
        return Sloped(self.value - value, _joined(self.slopes, {j: -s for j, s in slopes.items()}))

    def __rsub__(self, other: Any) -> Sloped:
        return Sloped(other, {}) - self

    def __mul__(self, other: Any) -> Sloped:
        value, slopes = _split(other)
        product = _joined(_scaled(self.slopes, value), _scaled(slopes, self.value))
        return Sloped(self.value * value, product)

    __rmul__ = __mul__

    def __truediv__(self, other: Any) -> Sloped:
        value, slopes = _split(other)
        quotient = self.value / value
        above = _joined(self.slopes, _scaled(slopes, -quotient) if slopes else {})
        return Sloped(quotient, {j: s / value for j, s in above.items()})

    def __rtruediv__(self, other: Any) -> Sloped:
        return Sloped(other, {}) / self


def _split(number: Any) -> tuple[Any, Slopes]:
    return (number.value, number.slopes) if isinstance(number, Sloped) else (number, {})


def _zero(value: Any) -> bool:
    return bool(value.is_zero()) if hasattr(value, "is_zero") else value == 0


def _scaled(slopes: Slopes, factor: Any) -> Slopes:
    if not slopes or _zero(factor):
        return {}
    products = ((j, s * factor) for j, s in slopes.items())
    return {j: s for j, s in products if not _zero(s)}


def _joined(first: Slopes, second: Slopes) -> Slopes:
    if not second:
        return first
    out = dict(first)
    for j, s in second.items():
        total = out[j] + s if j in out else s
        if _zero(total):
            out.pop(j, None)
        else:
            out[j] = total
    return out


BY_VALUE: dict[str, Callable[[Any], Any]] = {
    "tan": lambda y: 1 + y * y,
    "sqrt": lambda y: 1 / (2 * y),
    "exp": lambda y: y,
    "tanh": lambda y: 1 - y * y,
}
"""Derivatives that the value y of the function gives."""


def by_argument(f: Mapping[str, Callable[..., Any]]) -> dict[str, Callable[[Any], Any]]:
    """Derivatives of the other functions, from the argument x."""
    return {
        "sin": f["cos"],
        "cos": lambda x: -f["sin"](x),
        "log": lambda x: 1 / x,
        "asin": lambda x: 1 / f["sqrt"](1 - x * x),
        "acos": lambda x: -1 / f["sqrt"](1 - x * x),
        "atan": lambda x: 1 / (1 + x * x),
        "sinh": f["cosh"],
        "cosh": f["sinh"],
        "expm1": f["exp"],
        "log1p": lambda x: 1 / (x + 1),
        "asinh": lambda x: 1 / f["sqrt"](x * x + 1),
        "acosh": lambda x: 1 / f["sqrt"](x * x - 1),
        "atanh": lambda x: 1 / (-(x * x) + 1),
    }


def sloped_algebra(plain: Algebra) -> Algebra:
    """Numbers of an algebra with slopes."""
    f = plain.functions

    slopes_by_argument = by_argument(f)

    def lifted(name: str) -> Callable[[Any], Any]:
        def apply(number: Any) -> Any:
            x, slopes = _split(number)
            y = f[name](x)
            if not slopes:
                return y
            slope = BY_VALUE[name](y) if name in BY_VALUE else slopes_by_argument[name](x)
            return Sloped(y, _scaled(slopes, slope))

        return apply

    def power(base: Any, exponent: Any) -> Any:
        (x, by_x), (n, by_n) = _split(base), _split(exponent)
        y = f["pow"](x, n)
        slopes = _scaled(by_x, n * f["pow"](x, n - 1)) if by_x else {}
        if by_n:
            slopes = _joined(slopes, _scaled(by_n, y * f["log"](x)))
        return Sloped(y, slopes)

    def fabs(number: Any) -> Any:
        x, slopes = _split(number)
        if slopes:
            raise StabilityError(
                "the graph takes the absolute value of a state, which has no slope at zero; only "
                "smooth elementary functions are read."
            )
        return f["fabs"](x)

    table: dict[str, Callable[..., Any]] = {n: lifted(n) for n in (*UNARY, *MORE) if n in f}
    return Algebra(f"sloped {plain.name}", plain.constant, table | {"pow": power, "fabs": fabs})


def rates_and_slopes(
    program: Program, algebra: Algebra, states: Sequence[Any], parameters: Sequence[Any]
) -> tuple[list[Any], list[Slopes]]:
    """Rates and their slopes along the states, at states and parameters of any number type.

    Returns
    -------
    values, slopes
        For each rate its value, and its nonzero slopes by index of the state.

    Examples
    --------
    >>> import casadi as ca
    >>> from stability.algebra.number_types import casadi_algebra
    >>> x, p = ca.SX.sym("x", 2), ca.SX.sym("p")
    >>> rates = Program(ca.Function("f", [x, p], [ca.vertcat(x[1], -p * ca.sin(x[0]))]))
    >>> rates_and_slopes(rates, casadi_algebra(), [ca.SX(0), ca.SX(0)], [p])
    ([SX(0), SX(0)], [{1: 1}, {0: SX((-p))}])
    """
    sloped = [Sloped(value, {j: 1}) for j, value in enumerate(states)]
    rates = program.run(sloped_algebra(algebra), [sloped, parameters])[0]
    values, slopes = zip(*map(_split, rates), strict=True) if rates else ((), ())
    return list(values), list(slopes)


def _table(slopes: Sequence[Slopes], columns: int) -> ca.SX:
    """Slopes as a sparse matrix."""
    table = ca.SX(len(slopes), columns)
    for i, row in enumerate(slopes):
        for j, value in row.items():
            table[i, j] = value
    return ca.sparsify(table)


# --- the implicit form ---


AGREES = 1e-6
"""Relative difference up to which rates and the solution of the implicit form are the same."""


def solvable(system: Equations) -> bool:
    """Whether the implicit form gives every rate that it names, tried at a point of doubles.

    Parameters
    ----------
    system
        A system; one that is built from its mass matrix passes wherever its graph has values.
    """
    if system.mass is None or system.forcing is None:
        return False
    point = [
        [0.1 + 0.37 * ((5 * i) % 7) for i in range(len(names))]
        for names in (system.states, system.parameters)
    ]
    sides = ca.Function("sides", [system.x, system.p], [system.mass, system.forcing, system.rhs])
    mass, forcing, rates = (np.array(v) for v in sides(*point))
    if not all(np.isfinite(v).all() for v in (mass, forcing, rates)):
        return False
    try:
        z = np.linalg.solve(mass, forcing)[:, 0]
    except np.linalg.LinAlgError:
        return False
    pairs = [(z[j], rates[i, 0]) for i, j in solved_rates(system).items()]
    return bool(pairs) and all(abs(v - r) <= AGREES * (1 + np.abs(z).max()) for v, r in pairs)


def solved_rates(system: Equations) -> dict[int, int]:
    """Index of the unknown of the implicit form by index of the state whose rate it is."""
    places = {name: j for j, name in enumerate(system.unknowns)}
    return {i: places[f"d_{n}"] for i, n in enumerate(system.states) if f"d_{n}" in places}


@dataclass(frozen=True)
class Asked:
    """One output: some rates, or some of their slopes; or an output of another program."""

    rows: Sequence[int] = ()
    """Indices of states."""
    columns: Sequence[int] | None = None
    """Indices in (states, parameters) of the slopes' variables; None for the rates themselves."""
    other: Program | None = None
    """The other program, of one output."""


class MassGraphs:
    """M, F and the slopes of F - M z at a family, as graphs.

    Parameters
    ----------
    system
        The system.
    values
        Values of states and parameters by name: symbols, or numbers as symbols.
    algebra
        CasADi's expressions, which fold zeros alone.
    program
        Function from outputs in the family's symbols, and more inputs, to a `Program`.
    hidden
        Slopes (rate, state) that are proved zero.
    """

    def __init__(
        self,
        system: Equations,
        values: Mapping[str, Any],
        algebra: Algebra,
        program: Callable[..., Program],
        hidden: Sequence[tuple[int, int]],
    ) -> None:
        assert system.mass is not None and system.forcing is not None
        self.solved = solved_rates(system)
        self.own = [i for i in range(len(system.states)) if i not in self.solved]
        size, states = system.mass.size1(), len(system.states)
        arguments = [[values[n] for n in names] for names in (system.states, system.parameters)]
        bare = Program(
            ca.Function(
                "sides", [system.x, system.p], [ca.densify(system.mass), ca.densify(system.forcing)]
            )
        )
        mass, forcing = bare.run(algebra, arguments)
        self.mass = ca.sparsify(ca.reshape(ca.vertcat(*map(ca.SX, mass)), size, size))
        self.forcing = ca.vertcat(*map(ca.SX, forcing))
        z = ca.SX.sym("z", size)
        self.rest = bool(self.forcing.is_zero())
        """Whether F vanishes identically, so that z does."""
        column = ca.vertcat(*[system.rhs[i] for i in self.own], system.forcing - system.mass @ z)
        core = Program(
            ca.Function("core", [ca.vertcat(system.x, system.p), z], [ca.densify(column)])
        )
        inner = [ca.SX(0)] * size if self.rest else ca.vertsplit(z)
        free, slopes = rates_and_slopes(core, algebra, [v for g in arguments for v in g], inner)
        self.free = ca.vertcat(*map(ca.SX, free[: len(self.own)])) if self.own else ca.SX(0, 1)
        self.table = _table(slopes, states + len(system.parameters))
        self._z, self._program = z, program
        self._pattern = self._patterns(states, hidden)

    def _patterns(self, states: int, hidden: Sequence[tuple[int, int]]) -> tuple[Any, Any]:
        """Whether each rate, and each slope, may differ from zero."""
        from scipy.sparse import bmat
        from scipy.sparse.csgraph import connected_components

        mass = np.array(ca.DM(self.mass.sparsity(), 1)) != 0
        size, count = len(mass), len(self.own)
        _, labels = connected_components(bmat([[None, mass], [mass.T, None]]), directed=False)
        joined = labels[size:, None] == labels[None, :size]  # which equations move an unknown
        moved = np.array(ca.DM(self.table.sparsity(), 1)) != 0
        pushed = np.array([not self.forcing[i].is_zero() for i in range(size)])
        rates = np.array([False] * states)
        slopes = np.zeros((states, moved.shape[1]), dtype=bool)
        for k, i in enumerate(self.own):
            rates[i], slopes[i] = not self.free[k].is_zero(), moved[k]
        for i, j in self.solved.items():
            rates[i] = (joined[j] & pushed).any()
            slopes[i] = (joined[j][:, None] & moved[count:]).any(axis=0)
        for i, j in hidden:
            slopes[i, j] = False
        return rates, slopes

    @property
    def still(self) -> list[bool]:
        """Whether each rate vanishes identically."""
        return [not bool(v) for v in self._pattern[0]]

    def program(self, *outputs: Asked) -> Program:
        """Rates and slopes as a program."""
        return _Solved(self, outputs)

    def equations(
        self, rows: Sequence[int], inputs: Sequence[ca.SX], numbers: tuple[ca.SX, Sequence[float]]
    ) -> ca.Function:
        """Some rates as a function of (unknowns, given) in doubles, for a root-finder.

        Parameters
        ----------
        rows
            Indices of states.
        inputs
            Symbols of the unknowns and of (family parameters, parameters).
        numbers
            Symbols of the graph's numbers, and their values.
        """
        column, values = numbers
        sides = [self.mass, self.forcing, self.free]
        if values:
            sides = ca.substitute(sides, [column], [ca.DM(values)])
        parts = ca.Function("sides", list(inputs), sides)
        symbols = [ca.MX.sym("unknowns", inputs[0].numel()), ca.MX.sym("given", inputs[1].numel())]
        mass, forcing, free = parts(*symbols)
        z = ca.solve(mass, forcing)
        places = {i: free[k] for k, i in enumerate(self.own)}
        places |= {i: z[j] for i, j in self.solved.items()}
        return ca.Function("residual", symbols, [ca.vertcat(*[places[i] for i in rows])])

    def shape(self, asked: Asked) -> tuple[int, int]:
        """Shape of an output."""
        if asked.other is not None:
            return asked.other.shapes[0]
        return len(asked.rows), 1 if asked.columns is None else len(asked.columns)

    def places(self, asked: Asked) -> tuple[tuple[int, int], ...]:
        """(row, column) of each stored entry of an output."""
        rates, slopes = self._pattern
        if asked.other is not None:
            return asked.other.places[0]
        if asked.columns is None:  # rates are a dense column
            return tuple((i, 0) for i in range(len(asked.rows)))
        return tuple(
            (i, j)
            for j, column in enumerate(asked.columns)
            for i, row in enumerate(asked.rows)
            if slopes[row, column]
        )

    @cached_property
    def _sides(self) -> Program:
        return self._program("sides", self.mass, self.forcing, self.free)

    @cached_property
    def _slopes(self) -> Program:
        return self._program("slopes", self.table, more=[self._z])

    def run(
        self, algebra: Algebra, arguments: Sequence[Sequence[Any]], *, slopes: bool
    ) -> tuple[dict[int, Any], dict[tuple[int, int], Any]]:
        """Every rate, and every slope where asked, by index."""
        mass, forcing, free = (self._sides.dense(algebra, arguments, k) for k in range(3))
        z = [[algebra.constant(0.0)]] * len(mass)
        if not self.rest:
            z = solution(algebra, mass, forcing)
        rates = {i: row[0] for i, row in zip(self.own, free, strict=True)}
        rates |= {i: z[j][0] for i, j in self.solved.items()}
        if not slopes:
            return rates, {}
        table = self._slopes.dense(algebra, [*arguments, [row[0] for row in z]])
        moved = solution(algebra, mass, table[len(self.own) :])
        rows = dict(zip(self.own, table, strict=False)) | {
            i: moved[j] for i, j in self.solved.items()
        }
        return rates, {(i, j): v for i, row in rows.items() for j, v in enumerate(row)}


class _Solved(Program):
    """Rates and slopes of an implicit form, with the face of a `Program`."""

    tape = None
    """None: it solves linear systems, for which no kernel runs."""

    def __init__(self, form: MassGraphs, outputs: Sequence[Asked]) -> None:
        self._form, self._outputs, self.name = form, outputs, "implicit"
        self.places = tuple(map(form.places, outputs))
        self.shapes = tuple(map(form.shape, outputs))
        self.size = form.mass.numel() + form.table.nnz()

    def run(self, algebra: Algebra, arguments: Sequence[Sequence[Any]]) -> list[list[Any]]:
        """As `Program.run`."""
        sloped = any(output.columns is not None for output in self._outputs)
        rates, slopes = self._form.run(algebra, arguments, slopes=sloped)
        out = []
        for output, places in zip(self._outputs, self.places, strict=True):
            if output.other is not None:
                out.append(output.other.run(algebra, arguments)[0])
            elif output.columns is None:
                out.append([rates[i] for i in output.rows])
            else:
                out.append([slopes[output.rows[i], output.columns[j]] for i, j in places])
        return out


# --- the graph at a family ---


FINDER = {"abstol": 1e-300, "abstolStep": 1e-14, "max_iter": 200, "error_on_fail": False}
"""Options for CasADi's root-finder, to the last digit; `Family` checks the root afterwards."""
LARGE = 40_000
"""Instructions times states above which slopes are folded on the way."""


@dataclass(frozen=True, eq=False)
class Frame:
    """A system with the parts that a family fixes."""

    system: Equations
    """The equations of motion."""
    at: Sequence[str]
    """Names of the family parameters."""
    held: Mapping[str, float | Upright]
    """Values of the states that do not change along the family."""
    unknown: Mapping[str, float]
    """First guesses of the states solved for."""
    equations: Sequence[str]
    """States whose rates must vanish, and observables that must vanish."""
    zero: Sequence[tuple[int, int]] = ()
    """Entries of the linearisation that are proved zero, for any entry of the graph."""
    decimals: bool = False
    """Whether a double that is the nearest one to a short decimal is read as the decimal."""


class FamilyGraph:
    """Programs of a family, each with inputs (family parameters, unknowns, parameters).

    Parameters
    ----------
    frame
        A system with the parts that the family fixes.
    """

    def __init__(self, frame: Frame) -> None:
        self._frame = frame
        self._system = system = frame.system
        self._zero = frame.zero
        others = [n for n in system.parameters if n not in (*frame.at, *frame.unknown)]
        a, u, q = ([ca.SX.sym(n) for n in names] for names in (frame.at, frame.unknown, others))
        self._inputs = [ca.vertcat(*s) if s else ca.SX(0, 1) for s in (a, u, q)]
        self._size = len(u)
        self._constants = Constants(decimals=frame.decimals)
        fixed: dict[str, Any] = dict(zip([*frame.at, *others], [*a, *q], strict=True))
        fixed |= {
            n: v if isinstance(v, Upright) else self._constants(v) for n, v in frame.held.items()
        }
        guessed = fixed | {n: self._constants(v) for n, v in frame.unknown.items()}
        table = fixed | dict(zip(frame.unknown, u, strict=True))
        if self._at_the_origin():
            self._constant(table)
            return
        self._seen = [n for n in frame.equations if n not in system.states]
        table_of_rows = [*system.states, *self._seen]
        rows = [table_of_rows.index(n) for n in frame.equations]
        if self._solvable():
            self._solved_for(frame, table, guessed, rows, others)
            self._conditions(table)
            return
        values, slopes = self._read(table)
        residual = self._vanishing(values, table, rows)
        at_guess = self._read(guessed) if u else (values, slopes)
        self.closed = bool(u) and all(at_guess[0][i].is_zero() for i in rows)
        """Whether the first guess solves the equations identically."""
        if self.closed:
            values, slopes = at_guess
        self.rates = self._program("rates", values[: len(system.states)])
        if system.algebraic:
            slopes, determinant = self._without_algebraic(slopes)
            self.determinant = self._program("determinant", determinant)
            """Program of det ∂g/∂y, without its constant factors."""
        self.matrix: Program = self._program("matrix", slopes)
        self._equations(residual, self._numbers(guessed if self.closed else table, system.states))
        self._conditions(table)

    def _without_algebraic(self, slopes: ca.SX) -> tuple[ca.SX, ca.SX]:
        """The linearisation with all numbers as symbols and no column of algebraic variables."""
        inputs = [*self._inputs, self._constants.column]
        graph = Program(ca.Function("slopes", inputs, [slopes]))
        symbols = [ca.vertsplit(s) if s.numel() else [] for s in inputs]
        opened = ca.SX(*slopes.shape)
        values = graph.run(self._constants.algebra(strict=True), symbols)[0]
        for place, value in zip(graph.places[0], values, strict=True):
            opened[place] = value
        places = [self._system.index(n) for n in self._system.algebraic]
        return without_algebraic(ca.sparsify(opened), places, self._constants.column)

    def _constant(self, table: Mapping[str, Any]) -> None:
        """The programs of a linear system at its origin."""
        system = self._system
        assert system.coefficients is not None
        self.closed = False
        self.rates = self._program("rates", ca.SX(len(system.states), 1))
        self.matrix = system.coefficients
        self._equations(ca.SX(0, 1), self._numbers(table, system.states))
        self._conditions(table)

    def _at_the_origin(self) -> bool:
        """Whether a linear system without a graph is asked for at its origin."""
        frame = self._frame
        held = not any(isinstance(v, Upright) or v != 0 for v in frame.held.values())
        return frame.system.coefficients is not None and held and not (frame.at or frame.unknown)

    def _vanishing(self, values: ca.SX, table: Mapping[str, Any], rows: Sequence[int]) -> ca.SX:
        """What vanishes at a member: these rates, but F in place of M⁻¹ F where all of it does.

        The roots are the same where M is regular, as it is wherever the rates have values; a graph
        of F is much smaller than one that has eliminated M, and so are its enclosures.
        """
        system = self._system
        sides = {i: values[i] for i in rows}
        if rows and system.mass is not None and system.forcing is not None:
            solved = solved_rates(system)
            if len(solved) == system.mass.size1() and set(solved) <= set(rows):
                forcing = self._forcing(system.forcing, table)
                if exact_numbers(system.mass, system.forcing, forcing) and solvable(system):
                    sides |= {i: forcing[j] for i, j in solved.items()}
        return ca.vertcat(*sides.values()) if sides else ca.SX(0, 1)

    def _forcing(self, forcing: ca.SX, table: Mapping[str, Any]) -> ca.SX:
        """The forcing with these values for the symbols, zeros folded."""
        system = self._system
        bare = Program(ca.Function("forcing", [system.x, system.p], [ca.densify(forcing)]))
        arguments = [[table[n] for n in names] for names in (system.states, system.parameters)]
        for strict in (False, True):
            values = bare.run(self._constants.algebra(strict=strict), arguments)[0]
            folded = ca.vertcat(*map(ca.SX, values))
            if exact_numbers(folded):
                break
        return folded

    @property
    def numbers(self) -> tuple[list[float], tuple[float, ...]]:
        """Doubles that are read as they are, and doubles that are read as decimals."""
        return self._constants.values, self._constants.read

    def __reduce__(self) -> tuple[type[FamilyGraph], tuple[Frame]]:
        return FamilyGraph, (self._frame,)  # built again: compiled programs have no pickle

    def _program(self, name: str, *outputs: Any, more: Sequence[ca.SX] = ()) -> Program:
        inputs = [*self._inputs, *more, self._constants.column]
        return Program(ca.Function(name, inputs, list(outputs)), self._constants.values)

    @property
    def _large(self) -> bool:
        return self._bare.size * len(self._system.states) > LARGE

    @cached_property
    def _bare(self) -> Program:
        system = self._system
        values = ca.vertcat(system.rhs, *[system.observables[n] for n in self._seen])
        return Program(ca.Function("rates", [system.x, system.p], [ca.densify(values)]))

    @cached_property
    def _opened(self) -> tuple[ca.SX, ca.SX, list[tuple[str, Any]]]:
        """Rates (then observables), Jacobian of the rates, functions with their arguments.

        Numbers are symbols.
        """
        system, bare = self._system, self._bare
        entries = [ca.vertsplit(s) if s.numel() else [] for s in (system.x, system.p)]
        met: list[tuple[str, Any]] = []
        rhs = ca.vertcat(*bare.run(self._constants.algebra(met), entries)[0])
        # constants are symbols, so nothing is rounded
        return rhs, ca.jacobian(rhs[: len(system.states)], system.x), met

    def _read(self, values: Mapping[str, Any]) -> tuple[ca.SX, ca.SX]:
        """Rates (then observables) and Jacobian with these values for the symbols, zeros folded."""
        system = self._system
        if self._large:
            return self._read_large(values)
        rhs, slopes_of, met = self._opened
        numbers = self._constants.column
        inputs = [system.x, system.p, numbers]
        arguments = [[values[n] for n in names] for names in (system.states, system.parameters)]
        arguments.append(ca.vertsplit(numbers))
        plain = False
        if not any(isinstance(v, Upright) for v in arguments[0]):
            # CasADi's own evaluation is the same, and faster, where it rounds no number
            asked = ca.vertcat(*[x for _, x in met]) if met else ca.SX(0, 1)
            whole = ca.Function("graph", inputs, [rhs, slopes_of, asked])
            f, jac, met_values = whole(*[ca.vertcat(*a) if a else ca.SX(0, 1) for a in arguments])
            pairs = zip(met, ca.vertsplit(met_values) if met else [], strict=True)
            plain = not any(rounded(n, x) for (n, _), x in pairs)
            if plain and exact_numbers(f, jac):
                return ca.densify(f), ca.sparsify(jac)
        graph = Program(ca.Function("graph", inputs, [rhs, slopes_of]))
        if not plain:
            f, jac = self._run(graph, arguments, self._constants.algebra())
        if plain or not exact_numbers(f, jac):
            f, jac = self._run(graph, arguments, self._constants.algebra(strict=True))
        return f, jac

    def _run(self, graph: Program, arguments: list[Any], algebra: Algebra) -> tuple[ca.SX, ca.SX]:
        """Rates and Jacobian by an algebra of CasADi's expressions."""
        rates, slopes = graph.run(algebra, arguments)
        n = len(self._system.states)
        f, jac = ca.SX(n + len(self._seen), 1), ca.SX(n, n)
        for (i, _), value in zip(graph.places[0], rates, strict=True):
            f[i] = value
        for (i, j), value in zip(graph.places[1], slopes, strict=True):
            jac[i, j] = value
        for i, j in self._zero:
            jac[i, j] = 0
        return f, ca.sparsify(jac)

    def _read_large(self, values: Mapping[str, Any]) -> tuple[ca.SX, ca.SX]:
        """As `_read`, with each slope folded on the way."""
        system, n = self._system, len(self._system.states)
        blocks = [[values[n] for n in names] for names in (system.states, system.parameters)]
        for strict in (False, True):
            algebra = self._constants.algebra(strict=strict)
            rates, slopes = rates_and_slopes(self._bare, algebra, *blocks)
            f, jac = ca.vertcat(*map(ca.SX, rates)), _table(slopes[:n], n)
            if exact_numbers(f, jac):
                break
        return f, jac

    # --- an implicit form, solved for in the number type ---

    def _solvable(self) -> bool:
        system = self._system
        if self._seen or system.mass is None or system.forcing is None:
            return False
        # CasADi joins the numbers of M where it eliminates
        rounded = system.eliminated and system.mass.is_constant() and not exact_numbers(system.rhs)
        if not (self._large or rounded):
            return False
        # a mass matrix with a rounded third is not that of rates which keep thirds exact
        exact = rounded or exact_numbers(system.mass, system.forcing)
        return exact and solvable(system)

    def _form(self, values: Mapping[str, Any]) -> MassGraphs:
        """The implicit form with these values, zeros folded."""
        for strict in (False, True):
            algebra = self._constants.algebra(strict=strict)
            form = MassGraphs(self._system, values, algebra, self._program, self._zero)
            if exact_numbers(form.mass, form.forcing, form.free, form.table):
                break
        return form

    def _solved_for(
        self,
        frame: Frame,
        table: Mapping[str, Any],
        guessed: Mapping[str, Any],
        rows: Sequence[int],
        others: Sequence[str],
    ) -> None:
        """Rates, Jacobian and equations of a large system with a mass matrix."""
        system, (a, u, _) = self._system, self._inputs
        names = [*system.states, *system.parameters]
        form = self._form(table)
        best = self._form(guessed) if self._size else form
        self.closed = bool(self._size) and all(best.still[i] for i in rows)
        every = range(len(system.states))
        member = best if self.closed else form
        self.rates = member.program(Asked(every))
        self.matrix = member.program(Asked(every, every))
        state = self._numbers(guessed if self.closed else table, system.states)
        self.state = self._program("state", state)
        of_a, of_u, of_q = (
            [names.index(n) for n in some] for some in (frame.at, frame.unknown, others)
        )
        values, by_u = Asked(rows), Asked(rows, of_u)
        moved = [Asked(other=self._program("state", ca.jacobian(state, s))) for s in (a, u)]
        self.residual = form.program(values, by_u)
        self.tangent = form.program(*moved, values, by_u, Asked(rows, of_a))
        self.along = form.program(values, by_u, Asked(rows, [*of_a, *of_q]))
        pattern = np.zeros((len(rows), len(rows)))
        for place in self.residual.places[1]:
            pattern[place] = 1
        numbers = self._constants.column, self._constants.values
        self._solve_for(
            ca.veccat(form.mass, form.forcing, form.free),
            ca.sparsify(ca.DM(pattern)),
            lambda symbols: form.equations(rows, (u, symbols), numbers),
        )

    @staticmethod
    def _numbers(values: Mapping[str, Any], names: Sequence[str]) -> ca.SX:
        """Values as a column, with the nearest double for the right angle."""
        column = [values[n] for n in names]
        column = [ca.SX(np.pi / 2) if isinstance(v, Upright) else ca.SX(v) for v in column]
        return ca.vertcat(*column) if column else ca.SX(0, 1)

    def _equations(self, residual: ca.SX, state: ca.SX) -> None:
        """State, equations, their derivatives, and CasADi's root-finder for them."""
        a, u, q = self._inputs
        self._unsolved = residual
        by_u = ca.jacobian(residual, u)
        dense = ca.densify(residual)
        self.state = self._program("state", state)
        self.residual = self._program("residual", dense, by_u)
        self.tangent = self._program(
            "tangent",
            ca.jacobian(state, a),
            ca.jacobian(state, u),
            dense,
            by_u,
            ca.jacobian(residual, a),
        )
        numbers = ca.DM(self._constants.values)
        plain = ca.substitute(residual, self._constants.column, numbers) if u.numel() else residual
        self._solve_for(
            residual, by_u, lambda inputs: ca.Function("residual", [u, inputs], [plain])
        )

    def _solve_for(
        self, sides: ca.SX, slopes: Any, problem: Callable[[ca.SX], ca.Function]
    ) -> None:
        """CasADi's root-finder for the equations, and the numbers in them."""
        inputs = ca.vertcat(self._inputs[0], self._inputs[2])
        self.used = [i for i in range(inputs.numel()) if ca.depends_on(sides, inputs[i])]
        """Indices in (family parameters, parameters) of those in the equations."""
        if self._size:
            regular = ca.sprank(slopes) == self._size  # not singular for all numbers
            self.finder = (
                ca.rootfinder("root", "fast_newton", problem(inputs), FINDER) if regular else None
            )

    @cached_property
    def along(self) -> Program:
        """Equations, and their slopes by the unknowns and by (family parameters, parameters)."""
        residual, (a, u, q) = self._unsolved, self._inputs
        return self._program(
            "along",
            ca.densify(residual),
            ca.jacobian(residual, u),
            ca.jacobian(residual, ca.vertcat(a, q)),
        )

    def _conditions(self, table: Mapping[str, Any]) -> None:
        """The conditions without unknowns, to be checked before solving."""
        system, unknowns = self._system, self._inputs[1]
        symbols = ca.vertcat(system.x, system.p)
        place = ca.vertcat(
            self._numbers(table, system.states), self._numbers(table, system.parameters)
        )
        values = [ca.substitute(c.value, symbols, place) for c in system.conditions]
        free = [i for i, v in enumerate(values) if not self._size or not ca.depends_on(v, unknowns)]
        self.early = (
            [system.conditions[i] for i in free],
            self._program("early", *[values[i] for i in free]),
        )

    def place(self, entries: list[Any]) -> list[list[Any]]:
        """Rows of the unknowns' Jacobian from its stored entries."""
        dense: list[list[Any]] = [[0] * self._size for _ in range(self._size)]
        for (i, j), value in zip(self.residual.places[1], entries, strict=True):
            dense[i][j] = value
        return dense
