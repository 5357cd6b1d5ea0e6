"""A dynamical system as one CasADi graph: named states, parameters, rates, observables."""

from __future__ import annotations

import copy
import pickle
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Any, Self

import casadi as ca
import numpy as np
from casadi import global_pickle_context, global_unpickle_context
from casadi.casadi import _current_pickle_context  # type: ignore[attr-defined]
from numpy.typing import ArrayLike, NDArray

from ..algebra.program import Program, entries
from ..algebra.switches import by_signs
from ..base.checks import broadcast, instance, known, real_numbers, rows
from ..base.errors import DomainError, ParameterError, listed, listing, shown
from ..base.quantities import Quantity
from ..base.types import Record, content, fields_of
from .constant_matrix import ConstantMatrix
from .system_checks import (
    check_implicit,
    check_system,
    expression,
    mapping,
    names,
    singular_parts,
)
from .tabulated import interpolated


class Portable:
    """A frozen dataclass with expressions that pickles, also in a process pool, and copies.

    CasADi pickles an expression only within a context, in which expressions share their symbols.  A
    record opens a context of its own where none is open, so that `pickle` alone is enough.
    """

    __getstate__ = fields_of

    def __reduce_ex__(self, protocol: Any) -> Any:
        if _current_pickle_context():  # an outer record, or a caller, shares the symbols
            return object.__reduce_ex__(self, protocol)
        with global_pickle_context():
            return _read, (pickle.dumps(self, protocol),)

    def __copy__(self) -> Self:
        new = object.__new__(type(self))
        new.__dict__.update(self.__getstate__())
        return new

    def __deepcopy__(self, memo: dict[int, Any]) -> Self:
        new = object.__new__(type(self))
        memo[id(self)] = new
        new.__dict__.update(copy.deepcopy(self.__getstate__(), memo))
        return new


def _read(written: bytes) -> Any:
    with global_unpickle_context():
        return pickle.loads(written)


def not_finite(name: str, values: Mapping[str, Any], matrices: NDArray[np.float64]) -> DomainError:
    """The error of a graph with a value that is not finite; it names the first such place.

    Parameters
    ----------
    name
        Name of the system.
    values
        What the graph is computed from by name, arrays that broadcast to the leading shape.
    matrices
        Its values, matrices of shape (…, rows, columns).
    """
    fine = np.isfinite(matrices).all(axis=(-1, -2))
    first = int(np.argmin(fine))
    at = [np.broadcast_to(v, fine.shape).flat[first] for v in values.values()]
    return DomainError(
        f"{name} at {listing(values, at)}: values are not finite there, as at a pole or on a "
        "switch of a maximum or branch, or overflow double precision; give other states or "
        "parameters, nearer to 1."
    )


@dataclass(frozen=True, eq=False)
class Condition(Portable, Record):
    """A quantity that must be positive for the equations to have a meaning, and the reason.

    Source: this package; the end of a run at a condition: tests/motion/test_system_motion.py.

    Examples
    --------
    >>> import stability as st
    >>> import casadi as ca
    >>> g = ca.SX.sym("g")
    >>> st.Condition(g, "g is {value:g}, which must be positive").sentence
    'g is {value:g}, which must be positive'
    """

    value: ca.SX
    """Expression in the states and parameters; a state without a positive value is refused."""
    sentence: str
    """The reason as a sentence for the user, with `{value}` in place of the number."""

    def __post_init__(self) -> None:
        object.__setattr__(self, "value", expression("value of a condition", self.value, 1, 1))
        sentence = instance("sentence of a condition", self.sentence, str, "give a string")
        try:
            sentence.format(value=1.0)
        except (LookupError, ValueError, AttributeError, TypeError):
            raise ParameterError(
                f"sentence of a condition is {shown(sentence)}; the only thing in braces is "
                "{value}, with a format for numbers."
            ) from None

    def _content(self) -> tuple[object, ...]:
        graph = ca.Function("condition", ca.symvar(self.value), [self.value])
        return (type(self), self.sentence, graph.serialize())

    def refusal(self, value: float) -> str:
        """The reason with its value, one sentence."""
        number = real_numbers("value", value)
        if number.size != 1:
            raise ParameterError(f"value has shape {number.shape}; give one number.")
        return self.sentence.format(value=float(number.item())) + "."


@dataclass(frozen=True, eq=False, repr=False)
class Equations(Portable, Record):
    """The record of equations of motion that families read; `System` is its public name.

    Parameters and errors are those of `stability.systems.system.System`.
    """

    name: str
    """Name of the system in messages and files."""
    x: ca.SX
    """State symbols, shape (n,)."""
    p: ca.SX
    """Parameter symbols, shape (m,)."""
    rhs: ca.SX
    """Rates of the states, shape (n,)."""
    states: tuple[str, ...]
    """State names, in order."""
    parameters: tuple[str, ...] = ()
    """Parameter names, in order."""
    observables: Mapping[str, ca.SX] = field(default_factory=dict)
    """Expressions in x and p by name."""
    conditions: tuple[Condition, ...] = ()
    """Quantities that must be positive."""
    units: Mapping[str, str] = field(default_factory=dict)
    """SI unit by name."""
    mass: ca.SX | None = None
    """Mass matrix of the implicit form, or None."""
    forcing: ca.SX | None = None
    """Right-hand side of the implicit form, or None."""
    unknowns: tuple[str, ...] = ()
    """Names of the implicit form's unknowns: accelerations and contact forces."""
    quantities: Mapping[str, Quantity] = field(default_factory=dict)
    """Names in words, symbols and kinds of a body's numbers, by name; empty for a user's system."""
    eliminated: bool = False
    """Whether the rates are those of mass and forcing, solved by CasADi, which rounds numbers."""
    algebraic: tuple[str, ...] = ()
    """States without a rate: their entry of rhs is an algebraic equation, which must vanish."""
    approximation: str = ""
    """Of what every proof speaks where the equations hold a fit; empty where they hold none."""

    def __repr__(self) -> str:
        said = [_counted("state", self.states), _counted("parameter", self.parameters)]
        return f"<{type(self).__name__} {self.name}: {', '.join(said)}>"

    def __post_init__(self) -> None:
        for what in ("states", "parameters", "unknowns", "algebraic"):
            object.__setattr__(self, what, names(what, getattr(self, what)))
        for what in ("observables", "units", "quantities"):
            object.__setattr__(self, what, mapping(what, getattr(self, what)))
        for name, unit in self.units.items():
            if not isinstance(unit, str):
                raise ParameterError(f"the unit of {name} is {shown(unit)}; give a text.")
        for name, quantity in self.quantities.items():
            if not isinstance(quantity, Quantity):
                raise ParameterError(f"quantity {name} is {shown(quantity)}; give a Quantity.")
        if not isinstance(self.approximation, str):
            raise ParameterError(f"approximation is {shown(self.approximation)}; give a text.")
        seen = {n: expression(f"observable {n}", e) for n, e in self.observables.items()}
        object.__setattr__(self, "observables", seen)
        if (self.mass is None) != (self.forcing is None):
            raise ParameterError("mass and forcing belong together; give both or none.")
        if self.mass is not None:
            size = len(self.unknowns)
            object.__setattr__(self, "mass", expression("mass", self.mass, size, size))
            object.__setattr__(self, "forcing", expression("forcing", self.forcing, size, 1))
        conditions = self.conditions
        if not isinstance(conditions, (tuple, list)) or not all(
            isinstance(c, Condition) for c in conditions
        ):
            raise ParameterError(
                f"conditions is {shown(conditions)}; give a tuple of stability.Condition."
            )
        object.__setattr__(self, "conditions", tuple(conditions))
        check_system(self)
        if not self.quantities:  # a body's equations have no switches
            self._write_by_signs()

    def _write_by_signs(self) -> None:
        """Write maxima, branches and comparisons by the sign of a difference."""
        implicit = {n: v for n in ("mass", "forcing") if (v := getattr(self, n)) is not None}
        limits = [c.value for c in self.conditions]
        parts = [self.rhs, *self.observables.values(), *limits, *implicit.values()]
        ends: list[tuple[ca.SX, str]] = []
        if (written := by_signs([self.x, self.p], parts, interpolated, ends)) is None:
            return
        rest = iter(written)
        object.__setattr__(self, "rhs", next(rest))
        object.__setattr__(self, "observables", {n: next(rest) for n in self.observables})
        conditions = [replace(c, value=next(rest)) for c in self.conditions]
        conditions += [Condition(*end) for end in ends]
        object.__setattr__(self, "conditions", tuple(dict.fromkeys(conditions)))
        for name in implicit:
            object.__setattr__(self, name, next(rest))

    @classmethod
    def from_mass_matrix(
        cls,
        name: str,
        x: ca.SX,
        p: ca.SX,
        mass: ca.SX,
        forcing: ca.SX,
        *,
        unknowns: Sequence[str],
        rates: Mapping[str, Any],
        pivots: Sequence[tuple[int, int]] | None = None,
        observables: Any = None,
        **others: Any,
    ) -> Self:
        """A system from mass · u = forcing, where u holds accelerations and constraint forces.

        Parameters
        ----------
        name, x, p
            As in the constructor.
        mass, forcing
            Square matrix and column in x and p.
        unknowns
            Names of u: `d_STATE` for the rate of a state; other names are forces, or any variables
            of algebraic equations that are linear in them (index 1).  A rate whose column of mass
            is zero does not exist: its state is algebraic, and as many rows of mass must be zero,
            whose forcing then vanishes (index 1, nonlinear).
        rates
            Rates of the states that are not among the unknowns, expressions by state name.
        pivots
            (row, column) of each elimination step, with a nonzero pivot at every valid state;
            natural order when left out.
        observables
            Function (solution by name, pivot values) → mapping of expressions, or None.
        **others
            `states`, `parameters`, `conditions`, `units` as in the constructor.

        Returns
        -------
        Equations, or the class that was called.

        Examples
        --------
        >>> import casadi as ca, stability as st
        >>> x, m = ca.SX.sym("x", 2), ca.SX.sym("m")
        >>> s = st.System.from_mass_matrix("spring", x, m, m, -x[0], unknowns=("d_v",),
        ...     rates={"q": x[1]}, states=("q", "v"), parameters=("m",))
        >>> s.rates([1.0, 0.0], [4.0])
        array([ 0.  , -0.25])
        """
        for word in others:
            known("keyword", word, ("states", "parameters", "conditions", "units"))
        sought = names("unknowns", unknowns)
        speeds = {
            n: expression(f"rate of {n}", e, 1, 1) for n, e in mapping("rates", rates).items()
        }
        matrix = expression("mass", mass, len(sought), len(sought))
        right = expression("forcing", forcing, len(sought), 1)
        states = others.get("states", ())
        algebraic, matrix, right, sought, speeds = singular_parts(matrix, right, sought, speeds)
        order = check_implicit(matrix, sought, speeds, pivots, states)
        solution, values = eliminate(matrix, right, order)
        solved = dict(zip(sought, solution, strict=True))
        rhs = ca.vertcat(*[speeds[s] if s in speeds else solved[f"d_{s}"] for s in states])
        if observables is not None and not callable(observables):
            raise ParameterError(f"observables is {shown(observables)}; give a function or None.")
        extra = observables(solved, values) if observables else {}
        conditions = others.pop("conditions", ())
        if callable(conditions):
            conditions = conditions(extra)
        return cls(
            name,
            x,
            p,
            ca.SX(rhs),
            observables=extra,
            conditions=conditions,
            mass=None if algebraic else matrix,
            forcing=None if algebraic else right,
            unknowns=sought,
            algebraic=algebraic,
            eliminated=True,
            **others,
        )

    def refuse_algebraic(self, question: str) -> None:
        """Refuse a question that takes every entry of rhs for a rate."""
        if self.algebraic:
            raise ParameterError(
                f"{self.name} has algebraic equations, for {listed(self.algebraic)}, and "
                f"{question} takes rates alone; solve them for their variables, or ask for "
                "spectrum, boundaries or stability_map."
            )

    @property
    def coefficients(self) -> ConstantMatrix | None:
        """The constant matrix of a linear system, which needs no graph; None of any other."""
        return None

    @cached_property
    def jacobian(self) -> ca.SX:
        """∂f/∂x by automatic differentiation, shape (n, n)."""
        return ca.jacobian(self.rhs, self.x)

    @cached_property
    def function(self) -> ca.Function:
        """CasADi function (x, p) → (rates, observables…); build one in each process."""
        outputs = [self.rhs, *self.observables.values()]
        taken = ("x", "p", "rates")
        names = ["rates", *(f"{n}_seen" if n in taken else n for n in self.observables)]
        word = "f" + "".join(c for c in self.name if c.isascii() and c.isalnum())  # CasADi's names
        return ca.Function(word, [self.x, self.p], outputs, ["x", "p"], names)

    def qualified(self, sentence: str) -> str:
        """A sentence about a proof, with what it speaks of where the equations hold a fit."""
        return "; ".join(filter(None, [sentence, self.approximation]))

    @cached_property
    def _graph(self) -> str:
        """The whole graph as a text: its instructions, names and the bits of its numbers."""
        expressions = [self.rhs, *self.observables.values(), *(c.value for c in self.conditions)]
        expressions += [e for e in (self.mass, self.forcing) if e is not None]
        return str(ca.Function("all", [self.x, self.p], expressions).serialize())

    def _content(self) -> tuple[Any, ...]:
        words = [c.sentence for c in self.conditions]
        parts = (
            self.name,
            self.states,
            self.parameters,
            tuple(self.observables),
            words,
            self.units,
            self.unknowns,
            self.quantities,
            self.approximation,
            self.algebraic,
            self.mass is None,
        )
        return (type(self), content(parts), self._graph)

    def __hash__(self) -> int:  # the graph is read only where names are the same
        return hash((type(self), self.name, self.states, self.parameters))

    @cached_property
    def _program(self) -> Program:
        return Program(self.function)

    @cached_property
    def _jacobian_program(self) -> Program:
        return Program(ca.Function("jacobian", [self.x, self.p], [self.jacobian]))

    @cached_property
    def condition_program(self) -> Program:
        """The conditions as a program in (x, p), one output each."""
        values = [c.value for c in self.conditions]
        return Program(ca.Function("conditions", [self.x, self.p], values))

    def _arguments(self, x: ArrayLike, p: ArrayLike) -> tuple[list[Any], tuple[int, ...]]:
        xs, ps = rows("x", x, self.states), rows("p", p, self.parameters)
        shape = broadcast(x=xs.shape[:-1], p=ps.shape[:-1])
        return [entries(xs), entries(ps)], shape

    def check(self, x: ArrayLike, p: ArrayLike) -> None:
        """Refuse a state at which the equations have no meaning, with the reason.

        Parameters
        ----------
        x, p
            States and parameters, shapes (…, n) and (…, m).

        Raises
        ------
        DomainError
            If a condition fails; the message names the condition and its value.
        """
        arguments, shape = self._arguments(x, p)
        values = self.condition_program.quick(arguments, shape) if self.conditions else []
        for condition, value in zip(self.conditions, values, strict=True):
            bad = ~(value > 0)
            if bad.any():
                raise DomainError(condition.refusal(float(value[bad].flat[0])))

    def valid(self, x: ArrayLike, p: ArrayLike, above: float = 0.0) -> NDArray[np.bool_]:
        """Whether the equations have a meaning, state by state.

        Parameters
        ----------
        x, p
            As in `check`.
        above
            Value that each condition must exceed.

        Returns
        -------
        ndarray of bool
            Of the leading shape.
        """
        arguments, shape = self._arguments(x, p)
        values = self.condition_program.quick(arguments, shape) if self.conditions else []
        fine = [np.ones(shape, dtype=bool), *(value.reshape(shape) > above for value in values)]
        return np.asarray(np.all(fine, axis=0))

    def rates(self, x: ArrayLike, p: ArrayLike, *, checked: bool = False) -> NDArray[np.float64]:
        """Rates of the states.

        Parameters
        ----------
        x, p
            States, dimensionless for the disk, and parameters, shapes (…, n) and (…, m).
        checked
            Whether `check` has let these states through.

        Returns
        -------
        ndarray
            f(x, p), shape (…, n).

        Raises
        ------
        DomainError
            Where the equations have no meaning.
        """
        if not checked:
            self.check(x, p)
        arguments, shape = self._arguments(x, p)
        return self._finite(self._program.arrays(arguments, shape)[0], arguments)[..., 0]

    def linearise(self, x: ArrayLike, p: ArrayLike) -> NDArray[np.float64]:
        """The Jacobian ∂f/∂x by automatic differentiation at any state.

        Parameters
        ----------
        x, p
            As in `rates`.

        Returns
        -------
        ndarray
            Shape (…, n, n).

        Raises
        ------
        DomainError
            Where the equations have no meaning.
        """
        self.check(x, p)
        arguments, shape = self._arguments(x, p)
        return self._finite(self._jacobian_program.arrays(arguments, shape)[0], arguments)

    def observe(self, x: ArrayLike, p: ArrayLike) -> dict[str, NDArray[np.float64]]:
        """Every observable at states.

        Parameters
        ----------
        x, p
            As in `rates`.

        Returns
        -------
        dict
            Arrays of the leading shape by name.

        Raises
        ------
        DomainError
            Where the equations have no meaning.
        """
        self.check(x, p)
        arguments, shape = self._arguments(x, p)
        values = [self._finite(v, arguments) for v in self._program.arrays(arguments, shape)[1:]]
        return {
            name: value[..., 0, 0] if value.shape[-2:] == (1, 1) else value[..., 0]
            for name, value in zip(self.observables, values, strict=True)
        }

    def _finite(self, values: Any, arguments: list[Any]) -> NDArray[np.float64]:
        array: NDArray[np.float64] = np.asarray(values)
        if not np.isfinite(array).all():
            named = zip((*self.states, *self.parameters), sum(arguments, []), strict=True)
            raise not_finite(self.name, dict(named), array)
        return array

    def index(self, state: str) -> int:
        """Position of a state by name.

        Parameters
        ----------
        state
            One of `states`.

        Raises
        ------
        NameUnknownError
            If there is no such state.
        """
        return self.states.index(known("state", state, self.states))


def eliminate(
    mass: ca.SX, forcing: ca.SX, pivots: Sequence[tuple[int, int]]
) -> tuple[list[ca.SX], list[ca.SX]]:
    """Solve mass · u = forcing symbolically, with stated pivots.

    The order of the pivots decides the divisors.  An order whose pivots never vanish in the domain
    leaves no removable singularity, such as the factor 1/cosθ that a computer algebra system may
    leave.

    Parameters
    ----------
    mass
        Square SX matrix.
    forcing
        SX column.
    pivots
        (row, column) of each step; each row and column once.

    Returns
    -------
    solution, values
        u as a list of expressions, and the value of each pivot in order.

    Examples
    --------
    >>> u, pivots = eliminate(ca.SX([[0.0, 2.0], [4.0, 0.0]]), ca.SX([2.0, 4.0]), [(0, 1), (1, 0)])
    >>> u
    [SX(1), SX(1)]
    """
    size = mass.size1()
    rows = [[mass[i, j] for j in range(size)] for i in range(size)]
    right = [forcing[i] for i in range(size)]
    used: list[int] = []
    values = []
    for row, column in pivots:
        used.append(row)
        pivot = rows[row][column]
        values.append(pivot)
        for other in range(size):
            if other in used or rows[other][column].is_zero():
                continue
            factor = rows[other][column] / pivot
            for j in range(size):
                rows[other][j] = rows[other][j] - factor * rows[row][j]
            rows[other][column] = ca.SX(0)
            right[other] = right[other] - factor * right[row]
    solution: dict[int, ca.SX] = {}
    for row, column in reversed(pivots):
        total = right[row]
        for j, value in solution.items():
            total = total - rows[row][j] * value
        solution[column] = total / rows[row][column]
    return [solution[j] for j in range(size)], values


def _counted(word: str, labels: tuple[str, ...]) -> str:
    """How many names of a kind there are, and the first of them."""
    named = ", ".join(labels[:8]) + ", …" * (len(labels) > 8)
    return f"{len(labels)} {word}{'s' * (len(labels) != 1)}" + f" ({named})" * bool(labels)
