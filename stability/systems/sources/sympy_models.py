"""Systems from SymPy: Kane's and Lagrange's methods, `mechanics.System`, matrices, rates.

Every source is brought to one form: matrix · unknowns = right-hand side, with constraints.  Speeds
that depend on others through linear constraints are eliminated, and so are coordinates where the
constraint is linear in them or the user gives their expression.  What is left is an ordinary
system on the motions that obey the constraints.  Its linearisation is that of SymPy's `linearize`.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from fractions import Fraction
from functools import reduce
from typing import Any

import casadi as ca

from ...algebra.number_types import MORE, UNARY
from ...algebra.switches import above, no_folding
from ...base.errors import NameUnknownError, ParameterError, listed, shown
from ..equations import Condition
from .exact_terms import (
    MINUS,
    ONE,
    ZERO,
    Probes,
    Term,
    graph,
    over,
    plus,
    power,
    solve,
    times,
)

# --- expressions as graphs ---


RECIPROCAL = {
    "sec": "cos",
    "csc": "sin",
    "cot": "tan",
    "sech": "cosh",
    "csch": "sinh",
    "coth": "tanh",
}
"""Functions that are one over a function of the graph."""
DIRECT: dict[str, Callable[[Any], Any]] = {n: getattr(ca, n) for n in (*UNARY, *MORE)} | {
    "Abs": ca.fabs,
    "sign": ca.sign,
    "Heaviside": above,
}
"""Functions of one number in SymPy that a graph has, by SymPy's name."""
TABLE = "tabulated"
"""Attribute of a SymPy function that is given by a table: what it is in a graph."""
ANGLE = "atan2"
"""The one function of two numbers."""
PIECES: dict[str, Callable[[Term, Term], Term]] = {
    "Max": lambda a, b: chosen(above(graph(plus(a, times(MINUS, b)))), a, b),
    "Min": lambda a, b: chosen(above(graph(plus(b, times(MINUS, a)))), a, b),
    "And": times,
    "Or": lambda a, b: plus(a, times(b, plus(ONE, times(MINUS, a)))),
}
"""Functions and conditions of two terms or more, two at a time."""
DIGITS = 25
"""Digits to which a number that is no fraction is computed before it becomes a double."""


class Translation:
    """SymPy expressions with known symbols, as terms of a graph; each expression is read once.

    Parameters
    ----------
    known
        Terms by SymPy symbol, function of time or derivative.

    Examples
    --------
    >>> import sympy
    >>> a = sympy.Symbol("a")
    >>> Translation({a: ca.SX.sym("a")})(sympy.sin(a) / 3)
    SX((sin(a)/3))
    """

    def __init__(self, terms: Mapping[Any, Term]) -> None:
        self._terms: dict[Any, Term] = dict(terms)
        self._rounded: dict[str, float] = {}

    @property
    def approximation(self) -> str:
        """Which numbers that are no fraction became the nearest double; empty where none did."""
        said = (f"{shown(n)[1:-1]} as {v!r}" for n, v in self._rounded.items())
        return f"for the equations with {listed(list(said))}" if self._rounded else ""

    def add(self, terms: Mapping[Any, Term]) -> None:
        """Further symbols, before an expression that holds them is read."""
        self._terms |= terms

    def __call__(self, expression: Any) -> Term:
        """The term of one expression.

        Raises
        ------
        ParameterError
            If the graph has no such number or function; the sentence names it.
        """
        stack = [expression]  # no recursion: expressions may be deeper than Python's stack
        while stack:
            part = stack[-1]
            if self._new(part) and _irrational(part):
                self._rounded[str(part)] = value = float(part.evalf(DIGITS))
                self._terms[part] = Fraction(value)
            open_ = [a for a in _parts(part) if a not in self._terms] if self._new(part) else []
            if open_:
                stack += open_
                continue
            stack.pop()
            if part not in self._terms:
                self._terms[part] = _term(part, [self._terms[a] for a in _parts(part)])
        return self._terms[expression]

    def _new(self, part: Any) -> bool:
        return part not in self._terms

    def rows(self, matrix: Any) -> list[list[Term]]:
        """The entries of a SymPy matrix as rows of terms."""
        return [[self(matrix[i, j]) for j in range(matrix.cols)] for i in range(matrix.rows)]


def _parts(node: Any) -> tuple[Any, ...]:
    """Arguments that are read first; a rational exponent is no term."""
    if node.is_Pow:
        return tuple(node.args[:1] if node.exp.is_Rational else node.args)
    name = type(node).__name__
    if name == "Piecewise":
        return tuple(part for pair in node.args for part in pair.args)
    if name == "Heaviside":  # its value at 0 is none of a switch
        return tuple(node.args[:1])
    if node.is_Relational or node.is_Boolean or name in PIECES:
        return tuple(node.args)
    readable = node.is_Function and (name in (*DIRECT, *RECIPROCAL, ANGLE) or hasattr(node, TABLE))
    return tuple(node.args) if node.is_Add or node.is_Mul or readable else ()


def _switch(node: Any, parts: list[Term]) -> Term | None:
    """The term of a condition, or of an expression of several pieces; None for any other."""
    name = type(node).__name__
    if name in PIECES:
        return reduce(PIECES[name], parts)
    if name in ("BooleanTrue", "BooleanFalse"):
        return ONE if name == "BooleanTrue" else ZERO
    if name == "Not":
        return plus(ONE, times(MINUS, parts[0]))
    if node.is_Relational:
        less = plus(parts[1], times(MINUS, parts[0]))  # above zero where the left side is smaller
        equal = power(ca.sign(graph(less)), 2)
        falling = name in ("StrictLessThan", "LessThan")
        if name in ("Equality", "Unequality"):
            return equal if name == "Unequality" else 1 - equal
        return above(graph(less if falling else times(MINUS, less)))
    if name != "Piecewise":
        return None
    if type(node.args[-1].cond).__name__ != "BooleanTrue":
        raise ParameterError(
            f"the equations hold {shown(str(node))}, which has no value where no condition holds; "
            "end it with a piece whose condition is True."
        )
    value = parts[-2]
    for piece, where in zip(parts[-4::-2], parts[-3::-2], strict=True):
        value = chosen(where, piece, value)
    return value


def chosen(where: Term, yes: Term, no: Term) -> Term:
    """The first term where a condition is one, and the second where it is zero."""
    return plus(times(where, yes), times(plus(ONE, times(MINUS, where)), no))


def _term(node: Any, parts: list[Term]) -> Term:
    if (switch := _switch(node, parts)) is not None:
        return switch
    if node.is_Rational:
        return Fraction(int(node.p), int(node.q))
    if node.is_Float and node.is_finite:
        sign, mantissa, exponent, _ = node._mpf_
        return Fraction((-1) ** sign * int(mantissa)) * Fraction(2) ** exponent
    if node.is_Add:
        return reduce(plus, parts, ZERO)
    if node.is_Mul:
        return reduce(times, parts, ONE)
    if node.is_Pow:
        return _power(node, parts)
    if type(node).__name__ == ANGLE and len(parts) == 2:
        return _angle(node, *parts)
    if node.is_Function and len(parts) == 1:
        return _function(node, parts[0])
    raise _refusal(node)


def _power(node: Any, parts: list[Term]) -> Term:
    base, exponent = parts[0], node.exp
    if exponent.is_Integer:
        if abs(int(exponent)) > 64 and not isinstance(base, Fraction):
            return ca.power(base, float(exponent))
        return power(base, int(exponent))
    if isinstance(base, Fraction) and (exponent.is_Rational or isinstance(parts[1], Fraction)):
        raise _inexact(node)
    if exponent.is_Rational and exponent.q == 2:
        return power(ca.sqrt(base), int(exponent.p))
    if exponent.is_Rational:  # a third is no double: the logarithm keeps the power exact
        return ca.exp(times(Fraction(int(exponent.p), int(exponent.q)), ca.log(base)))
    if isinstance(base, Fraction) and Fraction(float(base)) != base:
        raise _inexact(node)
    if isinstance(parts[1], Fraction) and Fraction(float(parts[1])) != parts[1]:
        return ca.exp(times(parts[1], ca.log(base)))
    return ca.power(graph(base), graph(parts[1]))


def _function(node: Any, part: Term) -> Term:
    name = type(node).__name__
    if hasattr(node, TABLE):
        return getattr(node, TABLE)(graph(part))
    if name not in DIRECT and name not in RECIPROCAL:
        raise _refusal(node)
    if isinstance(part, Fraction):
        raise _inexact(node)
    if name in RECIPROCAL:
        return over(ONE, DIRECT[RECIPROCAL[name]](part))
    return DIRECT[name](part)


def _angle(node: Any, y: Term, x: Term) -> Term:
    """The angle of (x, y); that of (c x, c y) with c > 0 is the same, so a fraction stays exact."""
    for part in (y, x):
        if isinstance(part, Fraction):
            scale = Fraction(part.denominator)
            y, x = times(scale, y), times(scale, x)
    if any(isinstance(v, Fraction) and Fraction(float(v)) != v for v in (y, x)) or (
        isinstance(y, Fraction) and isinstance(x, Fraction)
    ):
        raise _inexact(node)
    return ca.atan2(graph(y), graph(x))


def _irrational(node: Any) -> bool:
    """Whether an expression is a real number that is no fraction, such as π or a root.

    Sums and products are read part by part: 3π is three times the double.
    """
    if node.is_Boolean or node.is_Relational:
        return False
    read = node.is_Rational or node.is_Float or node.is_Add or node.is_Mul
    return bool(node.is_number and not read and node.is_finite and node.is_extended_real)


def _inexact(node: Any) -> ParameterError:
    return ParameterError(
        f"the equations hold the number {shown(str(node))}, which no double is exactly; put a "
        "symbol in its place and give its value as a parameter."
    )


def _refusal(node: Any) -> ParameterError:
    if node.is_number and not node.is_Function:
        return ParameterError(
            f"the equations hold {shown(str(node))}, which is no finite real number; SymPy divided "
            "by zero or left the real numbers."
        )
    if node.is_Derivative:
        return ParameterError(
            f"the equations hold {shown(str(node))}, which is neither a state nor the rate of one; "
            "solve for it, or leave it out."
        )
    if node.is_Symbol:
        return ParameterError(
            f"the equations hold the symbol {shown(str(node))}, which is neither a state nor a "
            "parameter; time itself is none, so the equations must not name it."
        )
    return ParameterError(
        f"the equations use SymPy's {type(node).__name__}; a graph has + - * /, powers, abs, sqrt, "
        "exp, log, sin, sinh and their like, and the inverses, atan2 too: write it by these, or "
        "give the rates to System.from_function as a plain Python function, for spectra without "
        "proofs."
    )


# --- models in one form ---


FORMS = (
    "a KanesMethod, a LagrangesMethod, a mechanics.System, a tuple (mass matrix, forcing, q, u), "
    "or a mapping from states to rates"
)


@dataclass(frozen=True)
class SymbolicEquations:
    """A model's equations: matrix · (rates, accelerations, multipliers) = forcing."""

    q: tuple[Any, ...]
    """Coordinates."""
    u: tuple[Any, ...]
    """Speeds: functions of time, or derivatives of coordinates."""
    matrix: Any
    """Square SymPy matrix over the derivatives of q and u, then the multipliers."""
    forcing: Any
    """SymPy column."""
    blocks: tuple[int, ...]
    """Number of rows of each block: kinematics, dynamics, constraints of the accelerations."""
    zero: tuple[Any, ...] = ()
    """Symbols that are zero: auxiliary speeds."""
    configuration: tuple[Any, ...] = ()
    """Expressions in q that vanish."""
    velocity: tuple[Any, ...] = ()
    """Expressions linear in u that vanish."""
    dependent: tuple[Any, ...] = ()
    """Coordinates and speeds that the model itself calls dependent."""
    multipliers: int = 0
    """Number of constraint forces among the unknowns."""


def _implicit(model: Any, chosen: Sequence[Any]) -> SymbolicEquations:
    """The equations of a SymPy model."""
    from sympy import Matrix, MatrixBase
    from sympy.physics import mechanics

    if isinstance(model, mechanics.System):
        method = model.eom_method
        if method is None:
            raise ParameterError(
                "the mechanics.System has no equations yet; call its form_eoms() first."
            )
        dependent = (*model.q_dep, *model.u_dep)
        return _implicit(method, (*chosen, *(d for d in dependent if d not in chosen)))
    if isinstance(model, mechanics.KanesMethod):
        return _kane(model)
    if isinstance(model, mechanics.LagrangesMethod):
        return _lagrange(model, chosen)
    if isinstance(model, tuple) and len(model) == 4:
        try:
            mass, forcing = Matrix(model[0]), Matrix(model[1])
            q, u = (tuple(s if isinstance(s, MatrixBase) else list(s)) for s in model[2:])
        except (TypeError, ValueError, NotImplementedError):
            raise ParameterError(f"model is {shown(model)}; give {FORMS}.") from None
        return _matrices(mass, forcing, q, u)
    raise ParameterError(f"model is {shown(model)}; give {FORMS}.")


def _kane(model: Any) -> SymbolicEquations:
    try:
        matrix, forcing = model.mass_matrix_full, model.forcing_full
    except ValueError:
        raise ParameterError(
            "the KanesMethod has no equations yet; call its kanes_equations(bodies, loads) first."
        ) from None
    q, u, aux = tuple(model.q), tuple(model.u), tuple(model._uaux)
    depends = len(model._udep)
    velocity = tuple(model._k_nh * model.u + model._f_nh) if depends else ()
    return SymbolicEquations(
        q,
        u,
        matrix,
        forcing,
        (len(q), len(u) - depends, depends),
        zero=(*aux, *(a.diff() for a in aux)),
        configuration=tuple(model._f_h),
        velocity=velocity,
        dependent=(*model._qdep, *model._udep),
    )


def _lagrange(model: Any, chosen: Sequence[Any]) -> SymbolicEquations:
    if model.eom is None:
        raise ParameterError(
            "the LagrangesMethod has no equations yet; call its form_lagranges_equations() first."
        )
    q, u = tuple(model.q), tuple(model.u)
    constraints = tuple(model.coneqs)
    speed = dict(zip(q, u, strict=True))
    named = dict.fromkeys((*chosen, *(speed[c] for c in chosen if c in speed)))
    if len([s for s in named if s in u]) != len(constraints):
        raise ParameterError(
            f"the model has {len(constraints)} constraint{'s' * (len(constraints) != 1)}; name as "
            "many dependent coordinates (or rates) in dependent, such as dependent=[q1]."
        )
    return SymbolicEquations(
        q,
        u,
        model.mass_matrix_full,
        model.forcing_full,
        (len(q), len(q), len(constraints)),
        configuration=tuple(model._hol_coneqs),
        velocity=constraints,
        dependent=tuple(s for s in named if s in (*q, *u)),
        multipliers=len(constraints),
    )


def _matrices(mass: Any, forcing: Any, q: tuple[Any, ...], u: tuple[Any, ...]) -> SymbolicEquations:
    from sympy import diag, eye

    n, m = len(q), len(u)
    size = mass.rows
    fits = mass.rows == mass.cols == forcing.rows and forcing.cols == 1
    if fits and size == n + m:
        return SymbolicEquations(q, u, mass, forcing, (n, m, 0))
    if fits and size == m == n:
        return SymbolicEquations(q, u, diag(eye(n), mass), type(forcing)([*u, *forcing]), (n, m, 0))
    raise ParameterError(
        f"the mass matrix is {mass.rows} x {mass.cols} and the forcing {forcing.rows} x "
        f"{forcing.cols} for {n} coordinates and {m} speeds; give {n + m} rows, or {m} where each "
        "speed is the rate of its coordinate."
    )


# --- the system ---


CLOSE = 1e-6
"""Largest value of a configuration constraint at a state that still counts as on the constraint."""


def sympy_model(
    model: Any,
    *,
    parameters: Any = None,
    dependent: Any = (),
    cyclic: Any = (),
    observables: Any = None,
) -> dict[str, Any]:
    """The arguments of a `System` from a SymPy model.

    Returns
    -------
    dict
        x, p, rhs, states, parameters, observables, conditions, and the implicit form.

    Raises
    ------
    ParameterError, NameUnknownError
        If the model is not one of these, or holds what a graph does not have.
    """
    solved = _dependent(dependent)
    with no_folding():
        if isinstance(model, Mapping):
            arguments = _explicit(model, parameters, observables or {})
        else:
            form = _implicit(model, tuple(solved))
            arguments = _Reader(form, solved, parameters, observables or {}).system()
    return _without(arguments, cyclic)


def _dependent(table: Any) -> dict[Any, Any]:
    """Dependent coordinates and speeds, each with its expression or None."""
    from sympy import sympify

    if isinstance(table, Mapping):
        return {k: None if v is None else sympify(v) for k, v in table.items()}
    if isinstance(table, (list, tuple)):
        return dict.fromkeys(table)
    raise ParameterError(
        f"dependent is {shown(table)}; give a list of coordinates and speeds, or a mapping from a "
        "coordinate to its expression."
    )


# --- names ---


def _label(symbol: Any) -> str:
    """The name of a SymPy symbol, function of time, or derivative: q, q_dot, q_ddot."""
    if symbol.is_Derivative:
        return f"{_label(symbol.expr)}_{'d' * int(symbol.derivative_count)}ot"
    return str(symbol.name if symbol.is_Symbol else symbol.func.__name__)


def _free(expressions: Sequence[Any], states: Sequence[Any]) -> list[Any]:
    """Symbols and inputs in expressions, apart from states and time, sorted by name."""
    from sympy.core.function import AppliedUndef
    from sympy.physics.vector import dynamicsymbols

    symbols: set[Any] = set()
    for atom in expressions:
        symbols |= atom.free_symbols | atom.atoms(AppliedUndef)
    symbols -= {dynamicsymbols._t, *states}
    for atom in symbols:
        if states and atom.is_Function and atom.has(*states):
            raise ParameterError(
                f"the equations hold {shown(str(atom))}, an unknown function of a state; write its "
                "expression, or give a symbol where it is a parameter."
            )
    return sorted(symbols, key=lambda s: (_label(s), str(s)))


def _parameters(wanted: Any, free: Sequence[Any]) -> list[Any]:
    """The parameters in the user's order, or sorted by name."""
    if wanted is None:
        return list(free)
    if isinstance(wanted, (str, Mapping)) or not hasattr(wanted, "__iter__"):
        raise ParameterError(f"parameters is {shown(wanted)}; give a list of SymPy symbols.")
    by_name = {_label(s): s for s in free}
    chosen = [_symbol(s, by_name) for s in wanted]
    for symbol in free:
        if symbol not in chosen:
            raise NameUnknownError(
                f"the equations hold the symbol {shown(_label(symbol))}, which is neither a state "
                "nor listed in parameters."
            )
    return chosen


def _symbol(wanted: Any, by_name: Mapping[str, Any]) -> Any:
    from sympy import Symbol

    if isinstance(wanted, str):
        return by_name.get(wanted, Symbol(wanted))
    if getattr(wanted, "is_Symbol", False) or getattr(wanted, "is_Function", False):
        return wanted
    raise ParameterError(f"parameters holds {shown(wanted)}; give SymPy symbols or their names.")


def _column(symbols: Sequence[Any]) -> ca.SX:
    return ca.vertcat(*[ca.SX.sym(_label(s)) for s in symbols]) if symbols else ca.SX(0, 1)


def _symbol_terms(symbols: Sequence[Any], column: ca.SX) -> dict[Any, Term]:
    return {s: column[i] for i, s in enumerate(symbols)}


def _without(arguments: dict[str, Any], cyclic: Any) -> dict[str, Any]:
    """The system without coordinates that no other rate holds."""
    if isinstance(cyclic, str) or not hasattr(cyclic, "__iter__"):
        raise ParameterError(f"cyclic is {shown(cyclic)}; give a list of coordinates.")
    gone = [s if isinstance(s, str) else _label(s) for s in cyclic]
    for name in gone:
        if name not in arguments["states"]:
            raise NameUnknownError(
                f"cyclic names {shown(name)}; states are {', '.join(arguments['states'])}."
            )
    kept = [i for i, n in enumerate(arguments["states"]) if n not in gone]
    rates = arguments["rhs"][kept]
    others = ca.vertcat(rates, *(c.value for c in arguments.get("conditions", ())))
    for i, name in enumerate(arguments["states"]):
        if name in gone and ca.depends_on(others, arguments["x"][i]):
            raise ParameterError(
                f"{name} is no cyclic coordinate: the equations of the others hold it; leave it "
                "out of cyclic, or simplify the equations."
            )
    x = arguments["x"]
    seen = {
        n: e
        for n, e in arguments["observables"].items()
        if not any(ca.depends_on(e, x[i]) for i in range(x.numel()) if i not in kept)
    }
    left = arguments | {"rhs": rates, "x": x[kept], "observables": seen}
    left["states"] = tuple(arguments["states"][i] for i in kept)
    if gone:  # the implicit form holds the rates of the states that are gone
        left = {k: v for k, v in left.items() if k not in ("mass", "forcing", "unknowns")}
    return left


# --- building the graph ---


def _explicit(
    model: Mapping[Any, Any], parameters: Any, observables: Mapping[str, Any]
) -> dict[str, Any]:
    from sympy import sympify

    if not model:
        raise ParameterError(f"model is an empty mapping; give {FORMS}.")
    states, rates = list(model), [sympify(r) for r in model.values()]
    for state in states:
        if not (getattr(state, "is_Symbol", False) or getattr(state, "is_Function", False)):
            raise ParameterError(f"{shown(state)} is no SymPy symbol; give {FORMS}.")
    seen = _expressions(observables)
    symbols = _parameters(parameters, _free([*rates, *seen.values()], states))
    x, p = _column(states), _column(symbols)
    read = Translation(_symbol_terms(states, x) | _symbol_terms(symbols, p))
    return {
        "x": x,
        "p": p,
        "rhs": ca.vertcat(*[graph(read(r)) for r in rates]),
        "states": tuple(map(_label, states)),
        "parameters": tuple(map(_label, symbols)),
        "observables": {n: graph(read(e)) for n, e in seen.items()},
        "approximation": read.approximation,
    }


def _expressions(observables: Any) -> dict[str, Any]:
    from sympy import Expr, sympify

    if not isinstance(observables, Mapping):
        raise ParameterError(f"observables is {shown(observables)}; give a mapping by names.")
    parsed = {n: sympify(e) for n, e in observables.items()}
    for name, value in parsed.items():
        if not isinstance(value, Expr):
            raise ParameterError(f"observable {name} is {shown(value)}; give a SymPy expression.")
    return parsed


@dataclass
class _Reader:
    """One model on its way into a graph."""

    form: SymbolicEquations
    stated: Mapping[Any, Any]
    parameters: Any
    observables: Any
    seen: dict[str, Term] = field(default_factory=dict)
    conditions: list[Condition] = field(default_factory=list)

    def system(self) -> dict[str, Any]:
        """Everything that the constructor of a system takes."""
        form = self.form
        every = (*form.q, *form.u)
        for symbol in self.stated:
            if symbol not in every:
                raise NameUnknownError(
                    f"dependent names {shown(str(symbol))}, no coordinate or speed of the model."
                )
        self.known = dict.fromkeys((*form.dependent, *self.stated))
        q_dep, u_dep = ([s for s in some if s in self.known] for some in (form.q, form.u))
        read = self._symbols(q_dep, u_dep)
        self._coordinates(q_dep, read)
        self._speeds(u_dep, read)
        return self._solved(read)

    def _symbols(self, q_dep: list[Any], u_dep: list[Any]) -> Translation:
        """States and parameters; dependent coordinates without an expression stay states."""
        form, seen = self.form, _expressions(self.observables)
        self._linear = self._by_constraints(q_dep)
        gone = {s for s in q_dep if self.stated.get(s) is not None or s in self._linear}
        self.states = [s for s in (*form.q, *form.u) if s not in gone and s not in u_dep]
        moving = (*form.q, *form.u, *form.zero)
        written = [
            *form.matrix,
            *form.forcing,
            *form.configuration,
            *form.velocity,
            *seen.values(),
            *(e for e in self.stated.values() if e is not None),
        ]
        parameters = _parameters(self.parameters, _free(written, moving))
        self.names = tuple(map(_label, self.states)), tuple(map(_label, parameters))
        self.x, self.p = _column(self.states), _column(parameters)
        self.probes = Probes(self.x, self.p)
        self.expressions = seen
        zeros = dict.fromkeys(form.zero, ZERO)
        return Translation(
            _symbol_terms(self.states, self.x) | _symbol_terms(parameters, self.p) | zeros
        )

    def _by_constraints(self, q_dep: list[Any]) -> tuple[Any, ...]:
        """Dependent coordinates that linear constraints determine."""
        from sympy import Matrix

        form = self.form
        open_ = [s for s in q_dep if self.stated.get(s) is None]
        if not open_ or len(open_) != len(form.configuration):
            return ()
        slopes = Matrix(form.configuration).jacobian(Matrix(open_))
        return () if slopes.has(*open_) else tuple(open_)

    def _coordinates(self, q_dep: list[Any], read: Translation) -> None:
        """Dependent coordinates as expressions; a constraint that stays is watched."""
        constraints = self.form.configuration
        stated = {s: e for s, e in self.stated.items() if s in q_dep and e is not None}
        if stated and any(e.has(*q_dep) for e in stated.values()):
            raise ParameterError(
                "an expression in dependent holds a dependent coordinate; give expressions in the "
                "independent ones."
            )
        read.add({s: read(e) for s, e in stated.items()})
        if self._linear:
            read.add(self._linear_solution(constraints, self._linear, read))
        elif stated:
            self._agree(constraints, stated)
        if len(stated) < len(constraints) and not self._linear:
            for number, constraint in enumerate(constraints, 1):
                self._watch(f"constraint_{number}", read(constraint))

    def _linear_solution(
        self, constraints: Sequence[Any], sought: Sequence[Any], read: Translation
    ) -> dict[Any, Term]:
        """Symbols from equations that are linear in them."""
        from sympy import Matrix

        equations, unknowns = Matrix(constraints), Matrix(sought)
        matrix = read.rows(equations.jacobian(unknowns))
        rest = equations.xreplace(dict.fromkeys(sought, 0))
        right = [times(MINUS, read(r)) for r in rest]
        block = list(range(len(sought)))
        solution, _ = solve(matrix, right, [(block, block)], self.probes)
        return dict(zip(sought, solution, strict=True))

    def _watch(self, name: str, value: Term) -> None:
        self.seen[name] = value
        square = graph(value) ** 2
        self.conditions.append(
            Condition(
                CLOSE**2 - square,
                f"the configuration constraint {name} is not met at this state: it is above "
                f"{CLOSE:g} in size; give coordinates that solve it",
            )
        )

    def _agree(self, constraints: Sequence[Any], stated: Mapping[Any, Any]) -> None:
        """Refuse expressions that do not solve the constraints, at two random points."""
        import random

        made = random.Random(7)
        for row in constraints:
            left = row.xreplace(dict(stated))
            symbols = _free([left], ())
            for _ in range(2):
                place = {s: round(made.uniform(0.1, 0.4), 6) for s in symbols if s in self.form.q}
                place |= {s: round(made.uniform(1, 2), 6) for s in symbols if s not in place}
                value = abs(left.xreplace({s: _rational(v) for s, v in place.items()}).evalf(30))
                if not (value.is_number and value < 1e-20):
                    raise ParameterError(
                        f"the expressions in dependent leave the constraint {shown(str(row))} at "
                        f"{shown(str(value))}, not at zero; give expressions that solve it."
                    )

    def _speeds(self, u_dep: list[Any], read: Translation) -> None:
        """Dependent speeds from the constraints, which are linear in them."""
        velocity = self.form.velocity
        if len(u_dep) != len(velocity):
            raise ParameterError(
                f"{len(u_dep)} speeds are dependent, but the model has {len(velocity)} constraints "
                "of velocity; name as many in dependent."
            )
        if u_dep:
            speeds = self._linear_solution(velocity, u_dep, read)
            read.add(speeds)
            self.seen |= {_label(s): v for s, v in speeds.items()}

    def _solved(self, read: Translation) -> dict[str, Any]:
        form = self.form
        q, u = len(form.q), len(form.u)
        unknowns = [f"d_{_label(s)}" for s in (*form.q, *form.u)]
        unknowns += [f"lambda_{i + 1}" for i in range(form.multipliers)]
        matrix, right = read.rows(form.matrix), [read(f) for f in form.forcing]
        kinematic, dynamic, bound = form.blocks
        start = kinematic + dynamic
        stages = [(range(kinematic), range(q))]
        if form.multipliers:  # the mass matrix first: its Schur complement is definite
            stages += [(range(q, start), range(q, q + u))]
            stages += [(range(start, start + bound), range(q + u, q + u + bound))]
        else:  # with the dependent accelerations gone, the mass matrix is definite
            stages += [(range(start, start + bound), range(q + dynamic, q + u))]
            stages += [(range(q, start), range(q, q + dynamic))]
        solution, _ = solve(matrix, right, stages, self.probes)
        solved = dict(zip(unknowns, solution, strict=True))
        for number in range(1, form.multipliers + 1):  # SymPy's matrix has the other sign
            self.seen[f"lam{number}"] = times(MINUS, solved[f"lambda_{number}"])
        self.seen |= {n: read(e) for n, e in self.expressions.items()}
        return {
            "x": self.x,
            "p": self.p,
            "states": self.names[0],
            "parameters": self.names[1],
            "rhs": ca.vertcat(*[graph(solved[f"d_{n}"]) for n in self.names[0]]),
            "observables": {n: graph(v) for n, v in self.seen.items()},
            "conditions": tuple(self.conditions),
            "mass": ca.vertcat(*[ca.horzcat(*map(graph, row)) for row in matrix]),
            "forcing": ca.vertcat(*map(graph, right)),
            "unknowns": tuple(unknowns),
            "approximation": read.approximation,
        }


def _rational(value: float) -> Any:
    from sympy import Rational

    return Rational(str(value))
