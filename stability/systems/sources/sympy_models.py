"""Systems from SymPy: Kane's and Lagrange's methods, `mechanics.System`, matrices, rates.

Every source is brought to one form: matrix · unknowns = right-hand side, with constraints.  Speeds
that depend on others through linear constraints are eliminated, and so are coordinates where the
constraint is linear in them or the user gives their expression.  What is left is an ordinary
system on the motions that obey the constraints.  Its linearisation is that of SymPy's `linearize`.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import casadi as ca

from ...base.errors import NameUnknownError, ParameterError, shown
from ..condition import Condition
from .exact_terms import MINUS, ZERO, Probes, Term, graph, no_folding, solve, times
from .sympy_expressions import Translation
from .sympy_forms import FORMS, Implicit, implicit

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

    Parameters
    ----------
    model, parameters, dependent, cyclic, observables
        As for `stability.systems.system.System.from_sympy`.

    Returns
    -------
    dict
        x, p, rhs, states, parameters, observables, conditions, and the implicit form.

    Raises
    ------
    ParameterError, NameUnknownError
        If the model is not one of these, or holds what a graph does not have.
    """
    given = _dependent(dependent)
    with no_folding():
        if isinstance(model, Mapping):
            found = _explicit(model, parameters, observables or {})
        else:
            form = implicit(model, tuple(given))
            found = _Reader(form, given, parameters, observables or {}).system()
    return _without(found, cyclic)


def _dependent(given: Any) -> dict[Any, Any]:
    """Dependent coordinates and speeds, each with its expression or None."""
    from sympy import sympify

    if isinstance(given, Mapping):
        return {k: None if v is None else sympify(v) for k, v in given.items()}
    if isinstance(given, (list, tuple)):
        return dict.fromkeys(given)
    raise ParameterError(
        f"dependent is {shown(given)}; give a list of coordinates and speeds, or a mapping from a "
        "coordinate to its expression."
    )


# --- names ---


def label(symbol: Any) -> str:
    """The name of a SymPy symbol, function of time, or derivative: q, q_dot, q_ddot.

    Parameters
    ----------
    symbol
        The symbol.
    """
    if symbol.is_Derivative:
        return f"{label(symbol.expr)}_{'d' * int(symbol.derivative_count)}ot"
    return str(symbol.name if symbol.is_Symbol else symbol.func.__name__)


def _free(expressions: Sequence[Any], known: Sequence[Any]) -> list[Any]:
    """Symbols and inputs in expressions, apart from states and time, sorted by name."""
    from sympy.core.function import AppliedUndef
    from sympy.physics.vector import dynamicsymbols

    found: set[Any] = set()
    for one in expressions:
        found |= one.free_symbols | one.atoms(AppliedUndef)
    found -= {dynamicsymbols._t, *known}
    for one in found:
        if known and one.is_Function and one.has(*known):
            raise ParameterError(
                f"the equations hold {shown(str(one))}, an unknown function of a state; write its "
                "expression, or give a symbol where it is a parameter."
            )
    return sorted(found, key=lambda s: (label(s), str(s)))


def _parameters(given: Any, free: Sequence[Any]) -> list[Any]:
    """The parameters in the user's order, or sorted by name."""
    if given is None:
        return list(free)
    if isinstance(given, (str, Mapping)) or not hasattr(given, "__iter__"):
        raise ParameterError(f"parameters is {shown(given)}; give a list of SymPy symbols.")
    by_name = {label(s): s for s in free}
    chosen = [_symbol(s, by_name) for s in given]
    for symbol in free:
        if symbol not in chosen:
            raise NameUnknownError(
                f"the equations hold the symbol {shown(label(symbol))}, which is neither a state "
                "nor listed in parameters."
            )
    return chosen


def _symbol(given: Any, by_name: Mapping[str, Any]) -> Any:
    from sympy import Symbol

    if isinstance(given, str):
        return by_name.get(given, Symbol(given))
    if getattr(given, "is_Symbol", False) or getattr(given, "is_Function", False):
        return given
    raise ParameterError(f"parameters holds {shown(given)}; give SymPy symbols or their names.")


def _column(symbols: Sequence[Any]) -> ca.SX:
    return ca.vertcat(*[ca.SX.sym(label(s)) for s in symbols]) if symbols else ca.SX(0, 1)


def _known(symbols: Sequence[Any], column: ca.SX) -> dict[Any, Term]:
    return {s: column[i] for i, s in enumerate(symbols)}


def _without(found: dict[str, Any], cyclic: Any) -> dict[str, Any]:
    """The system without coordinates that no other rate holds."""
    if isinstance(cyclic, str) or not hasattr(cyclic, "__iter__"):
        raise ParameterError(f"cyclic is {shown(cyclic)}; give a list of coordinates.")
    gone = [s if isinstance(s, str) else label(s) for s in cyclic]
    for name in gone:
        if name not in found["states"]:
            raise NameUnknownError(
                f"cyclic names {shown(name)}; states are {', '.join(found['states'])}."
            )
    kept = [i for i, n in enumerate(found["states"]) if n not in gone]
    rates = found["rhs"][kept]
    others = ca.vertcat(rates, *(c.value for c in found.get("conditions", ())))
    for i, name in enumerate(found["states"]):
        if name in gone and ca.depends_on(others, found["x"][i]):
            raise ParameterError(
                f"{name} is no cyclic coordinate: the equations of the others hold it; leave it "
                "out of cyclic, or simplify the equations."
            )
    x = found["x"]
    seen = {
        n: e
        for n, e in found["observables"].items()
        if not any(ca.depends_on(e, x[i]) for i in range(x.numel()) if i not in kept)
    }
    left = found | {"rhs": rates, "x": x[kept], "observables": seen}
    left["states"] = tuple(found["states"][i] for i in kept)
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
    own = _parameters(parameters, _free([*rates, *seen.values()], states))
    x, p = _column(states), _column(own)
    read = Translation(_known(states, x) | _known(own, p))
    return {
        "x": x,
        "p": p,
        "rhs": ca.vertcat(*[graph(read(r)) for r in rates]),
        "states": tuple(map(label, states)),
        "parameters": tuple(map(label, own)),
        "observables": {n: graph(read(e)) for n, e in seen.items()},
    }


def _expressions(observables: Any) -> dict[str, Any]:
    from sympy import Expr, sympify

    if not isinstance(observables, Mapping):
        raise ParameterError(f"observables is {shown(observables)}; give a mapping by names.")
    found = {n: sympify(e) for n, e in observables.items()}
    for name, one in found.items():
        if not isinstance(one, Expr):
            raise ParameterError(f"observable {name} is {shown(one)}; give a SymPy expression.")
    return found


@dataclass
class _Reader:
    """One model on its way into a graph."""

    form: Implicit
    given: Mapping[Any, Any]
    parameters: Any
    observables: Any
    seen: dict[str, Term] = field(default_factory=dict)
    conditions: list[Condition] = field(default_factory=list)

    def system(self) -> dict[str, Any]:
        """Everything that the constructor of a system takes."""
        form = self.form
        every = (*form.q, *form.u)
        for one in self.given:
            if one not in every:
                raise NameUnknownError(
                    f"dependent names {shown(str(one))}, no coordinate or speed of the model."
                )
        self.known = dict.fromkeys((*form.dependent, *self.given))
        q_dep, u_dep = ([s for s in some if s in self.known] for some in (form.q, form.u))
        read = self._symbols(q_dep, u_dep)
        self._coordinates(q_dep, read)
        self._speeds(u_dep, read)
        return self._solved(read)

    def _symbols(self, q_dep: list[Any], u_dep: list[Any]) -> Translation:
        """States and parameters; dependent coordinates without an expression stay states."""
        form, seen = self.form, _expressions(self.observables)
        self._linear = self._by_constraints(q_dep)
        gone = {s for s in q_dep if self.given.get(s) is not None or s in self._linear}
        self.states = [s for s in (*form.q, *form.u) if s not in gone and s not in u_dep]
        known = (*form.q, *form.u, *form.zero)
        written = [
            *form.matrix,
            *form.forcing,
            *form.configuration,
            *form.velocity,
            *seen.values(),
            *(e for e in self.given.values() if e is not None),
        ]
        own = _parameters(self.parameters, _free(written, known))
        self.names = tuple(map(label, self.states)), tuple(map(label, own))
        self.x, self.p = _column(self.states), _column(own)
        self.probes = Probes(self.x, self.p)
        self.expressions = seen
        zeros = dict.fromkeys(form.zero, ZERO)
        return Translation(_known(self.states, self.x) | _known(own, self.p) | zeros)

    def _by_constraints(self, q_dep: list[Any]) -> tuple[Any, ...]:
        """Dependent coordinates that linear constraints determine."""
        from sympy import Matrix

        form = self.form
        open_ = [s for s in q_dep if self.given.get(s) is None]
        if not open_ or len(open_) != len(form.configuration):
            return ()
        slopes = Matrix(form.configuration).jacobian(Matrix(open_))
        return () if slopes.has(*open_) else tuple(open_)

    def _coordinates(self, q_dep: list[Any], read: Translation) -> None:
        """Dependent coordinates as expressions; a constraint that stays is watched."""
        constraints = self.form.configuration
        stated = {s: e for s, e in self.given.items() if s in q_dep and e is not None}
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
            for number, one in enumerate(constraints, 1):
                self._watch(f"constraint_{number}", read(one))

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
        found, _ = solve(matrix, right, [(block, block)], self.probes)
        return dict(zip(sought, found, strict=True))

    def _watch(self, name: str, value: Term) -> None:
        self.seen[name] = value
        square = graph(value) ** 2
        self.conditions.append(
            Condition(
                CLOSE**2 - square,
                f"the configuration constraint {name} is not zero at this state, its square is "
                f"above {CLOSE**2:g} by {{value:.3g}}",
            )
        )

    def _agree(self, constraints: Sequence[Any], stated: Mapping[Any, Any]) -> None:
        """Refuse expressions that do not solve the constraints, at two random points."""
        import random

        made = random.Random(7)
        for one in constraints:
            left = one.xreplace(dict(stated))
            symbols = _free([left], ())
            for _ in range(2):
                place = {s: round(made.uniform(0.1, 0.4), 6) for s in symbols if s in self.form.q}
                place |= {s: round(made.uniform(1, 2), 6) for s in symbols if s not in place}
                value = abs(left.xreplace({s: _rational(v) for s, v in place.items()}).evalf(30))
                if not (value.is_number and value < 1e-20):
                    raise ParameterError(
                        f"the expressions in dependent leave the constraint {shown(str(one))} at "
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
            found = self._linear_solution(velocity, u_dep, read)
            read.add(found)
            self.seen |= {label(s): v for s, v in found.items()}

    def _solved(self, read: Translation) -> dict[str, Any]:
        form = self.form
        q, u = len(form.q), len(form.u)
        unknowns = [f"d_{label(s)}" for s in (*form.q, *form.u)]
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
        found, _ = solve(matrix, right, stages, self.probes)
        solved = dict(zip(unknowns, found, strict=True))
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
        }


def _rational(value: float) -> Any:
    from sympy import Rational

    return Rational(str(value))
