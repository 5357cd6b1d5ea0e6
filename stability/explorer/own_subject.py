"""A family of a user's system, or of a body, for the page: conditions over Q, equations, words."""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial
from typing import Any

import casadi as ca

from ..algebra.number_types import Algebra
from ..algebra.program import Program
from ..algebra.upright import Upright
from ..base.axis import Axis
from ..base.checks import known
from ..base.errors import ParameterError, StabilityError, absent, shown
from ..base.quantities import readable, time_unit
from ..base.verdict import Verdict
from ..bodies.model import WORK, system_model
from ..derivation.conditions import Conditions, conditions
from ..maps.proved_boxes import prove_boxes
from ..spectra.arguments import prepare
from ..systems.family import Family
from ..systems.structure.structural_zeros import steady_where, structure
from ..systems.structure.zero_blocks import typical
from ..systems.system import System
from .certificates import packed
from .source.formulas import (
    FLOAT,
    Rule,
    Sign,
    Values,
    filled,
    polynomial_signs,
    shift_of,
    typeset,
    value_of,
)
from .source.solver import solver_of
from .source.source_text import graph, javascript
from .subject import Quantity, Subject

SECONDS = 30.0
"""Longest time of the derivation of the conditions [s]."""
LEVELS = 5
"""Halvings of a diagram in both directions for proved rectangles."""
SERIES = 2
"""Observables whose curves are drawn, next to the states; one named energy is the first."""
FUNCTION = re.compile(r"(sin|cos|sqrt)\((\w+)\)")
"""A variable that is a function of a quantity."""
SIZE = re.compile(r"sqrt\((\w+)\*\*2\)")
"""A variable that is the size of a quantity."""
ONE = "sqrt(1)"
"""A variable that is 1: the root of a graph at a point where it is a number."""

Axes = tuple[tuple[str, float, float], tuple[str, float, float]]


def own_subject(
    family: Family, values: Mapping[str, float], axes: Axes, positive: Sequence[str] = (),
    words: Mapping[str, str] | None = None, *, zeros: Sequence[str] = (),
) -> Subject:  # fmt: skip
    """A family of one's own, its conditions derived with every quantity as a variable.

    Parameters
    ----------
    family
        A family whose conditions are polynomials in its quantities and its unknowns.
    values
        Value of every quantity at first.
    axes
        (name, low, high) of the two axes at first.
    positive
        Quantities that are positive.
    words
        Family and law on the buttons, and the motion; the family's own name when left out.
    zeros
        Inputs that `without_inputs` has left out.

    Raises
    ------
    StabilityError
        If the conditions are too large, or too much of a member is solved for.
    """
    found = conditions(family, positive=positive, decimals=True, seconds=SECONDS)
    names = (*family.at, *family.parameters)
    if found.left_out:
        raise StabilityError(f"{family.name}: {found.left_out[0]}; the page needs every condition.")
    solver = solver_of(family)
    every = (*names, *(solver.unknown if solver else ()))
    read = [_reader(found, variable.name, every) for variable in found.variables]
    system, told = family.system, dict(words or {})
    x, p = system.x, system.p
    behind = {v.name: 2 * (v.name not in names) for v in found.variables}
    put = {v.name: (_in_braces(v.name, every), 1) for v in found.variables}
    symbols = (
        {n: q.symbol.removesuffix("/mR²") for n, q in system.quantities.items() if q.symbol}
        if told
        else {}
    )
    written = {n: (_written(n, symbols), 1) for n in put}
    deciding = [c for c in found.deciding if str(c.polynomial) != ONE]
    shifts = [shift_of([c.polynomial]) for c in deciding]
    even = any(f.even for f in found.factors) or found._extra_zeros > 0
    rules = tuple(Rule(c.kind, c.polynomial, behind, shift)
                  for c, shift in zip(deciding, shifts, strict=True))  # fmt: skip
    factors = [f for f in found.factors for _ in range(f.multiplicity)]
    return Subject(
        key=f"{told.get('family', family.name)} {told.get('law', '')}".strip(),
        family=told.get("family", family.name), law=told.get("law", ""),
        title=told.get("title", f"{system.name}: {family.name}"),
        quantities=tuple(
            _quantity(family, n, values[n], axes, symbols, positive=n in positive)
            for n in names),
        axes=(axes[0][0], axes[1][0]), even=tuple(f.even for f in factors), zeros=found.zeros,
        coefficients=partial(_coefficients, factors, read),
        rules=tuple(Sign(rule.kind, FLOAT) for rule in rules) if solver else rules,
        signs=partial(polynomial_signs, rules, partial(_variables, read)),
        texts=tuple((typeset(c.polynomial, written, shift), filled(c.polynomial, put, shift))
                    for c, shift in zip(deciding, shifts, strict=True)),
        states=system.states, member=javascript([len(every)], member_states(family, every)),
        members=partial(_members, family, every), solver=solver, proved=solver is None,
        jacobian=graph(Program(ca.Function("slopes", [x, p], [ca.jacobian(system.rhs, x)]))),
        model=told.get("motion", family.name), parameters=tuple(
            names.index(n) for n in system.parameters),
        call={"kind": "own", "at": family.at, "parameters": family.parameters,
              "given": system.parameters, "zeros": list(zeros), "system": system.name,
              "numbers": found.numbers},
        good=_good(family, even=even).word,
        symbols={n: symbols.get(n, n) for n in system.states},
    )  # fmt: skip


def _good(family: Family, *, even: bool) -> Verdict:
    good = typical(family, even=even)
    if good is Verdict.UNDECIDED:
        raise StabilityError(
            f"{family.name}: nothing proves whether its zero eigenvalues form a Jordan block, so "
            "that the page cannot tell stable from drifting; ask stability.spectrum."
        )
    return good


@dataclass(frozen=True)
class _Reader:
    """How a variable of the polynomials follows from the quantities."""

    index: int
    """Index of the quantity; -1 for the number 1."""
    function: str = ""
    """Its function; empty for the quantity itself."""

    def __call__(self, algebra: Algebra, q: Values) -> Any:
        """Value of the variable."""
        if self.index < 0:
            return 1.0
        value = q[self.index]
        return algebra.functions[self.function](value) if self.function else value


def _reader(found: Conditions, variable: str, names: Sequence[str]) -> _Reader:
    if variable in names:
        return _Reader(names.index(variable))
    match, size = FUNCTION.fullmatch(variable), SIZE.fullmatch(variable)
    if match and match[2] in names:
        return _Reader(names.index(match[2]), match[1])
    if size and size[1] in names:
        return _Reader(names.index(size[1]), "fabs")
    if variable == ONE:
        return _Reader(-1)
    family = found.family
    raise StabilityError(
        f"{family.name}: {variable} in its conditions is a function of several quantities; the "
        "page draws families whose conditions are polynomials in quantities, in their sines, "
        "cosines and roots, and in the states that are solved for."
    )


def _in_braces(variable: str, names: Sequence[str]) -> str:
    match, size = FUNCTION.fullmatch(variable), SIZE.fullmatch(variable)
    if match and match[2] in names:
        return f"({match[1]} {{{match[2]}}})"
    return f"|{{{size[1]}}}|" if size else "1" if variable == ONE else f"{{{variable}}}"


def _written(variable: str, symbols: Mapping[str, str]) -> str:
    size = SIZE.fullmatch(variable)
    known_ = "1" if variable == ONE else f"|{symbols.get(size[1], size[1])}|" if size else variable
    return symbols.get(variable, known_)


def _variables(read: Sequence[_Reader], algebra: Algebra, q: Values) -> list[Any]:
    return [one(algebra, q) for one in read]


def _coefficients(
    factors: Sequence[Any], read: Sequence[_Reader], algebra: Algebra, q: Values
) -> list[list[Any]]:
    point = _variables(read, algebra, q)
    out = []
    for factor in factors:
        shift = shift_of(factor.coefficients)
        out.append([value_of(c, shift, point) for c in factor.coefficients])
    return out


def _quantity(
    family: Family, name: str, value: float, axes: Axes, symbols: Mapping[str, str], *,
    positive: bool,
) -> Quantity:  # fmt: skip
    unit = family.system.units.get(name, "1")
    low, high = next(
        ((a, b) for n, a, b in axes if n == name),
        (0.0, 2 * value) if value > 0 else (2 * value, 0.0) if value < 0 else (-1.0, 1.0),
    )
    known_ = family.system.quantities.get(name) if name in symbols else None
    return Quantity(
        name, symbols.get(name, name), known_.long_name if known_ else "",
        "" if unit == "1" else readable(unit), low, high, value, 0.0 if positive else None,
    )  # fmt: skip


def member_states(family: Family, names: Sequence[str]) -> Callable[..., list[Any]]:
    """States of a member as a function of the number type and the quantities.

    Parameters
    ----------
    family
        A family whose members are known in closed form.
    names
        Its quantities, and its unknowns where they are solved for.
    """
    if not family.closed and set(family.unknown) - set(names):
        raise StabilityError(
            f"{family.name}: {', '.join(family.unknown)} of its members is solved for; of a body "
            "the page draws families whose members are known in closed form."
        )
    fixed = {**family.fixed, **family.unknown}

    def states(algebra: Algebra, q: Values) -> list[Any]:  # noqa: ARG001
        given = dict(zip(names, q, strict=True))
        found = [given.get(n, fixed.get(n)) for n in family.system.states]
        return [math.pi / 2 if isinstance(v, Upright) else v for v in found]

    return states


def _members(family: Family, names: Sequence[str], algebra: Algebra, q: Values) -> list[Any]:
    """Values of the system's conditions at a member, positive where it exists."""
    system: Any = family.system
    if not system.conditions:
        return []
    values = [c.value for c in system.conditions]
    program = Program(ca.Function("exists", [system.x, system.p], values))
    given = dict(zip(names, q, strict=True))
    states = member_states(family, names)(algebra, q)
    found = program.run(algebra, [states, [given[n] for n in system.parameters]])
    return [v[0] if v else 0.0 for v in found]


def own_motion(family: Family) -> Mapping[str, Any]:
    """Equations, conditions and observables of a launch of a user's system."""
    if not isinstance(family.system, System):
        raise StabilityError(f"{family.name}: the page needs a family of a stability.System.")
    model = system_model(family.system)
    count = len(family.system.states)
    kept = count + (WORK in model.names)
    x, rhs = model.x[:kept], model.rhs[:kept]
    series = dict(sorted(model.series.items(), key=lambda s: s[0] != "energy")[:SERIES])
    guards = list(model.guards.values()) or [ca.SX(1)]
    rates = ca.Function("rates", [x, model.p], [rhs])
    guard = ca.Function("guards", [x, model.p], [ca.vertcat(*guards)])
    seen = ca.Function("seen", [x, model.p], [ca.vertcat(*series.values(), ca.SX(0, 1))])
    return {
        "names": model.names[:kept], "states": count, "guards": list(model.guards) or ["none"],
        "rates": graph(Program(rates)), "guard": graph(Program(guard)),
        "observe": graph(Program(seen)), "observed": list(series), "more": [],
        "words": dict.fromkeys(model.guards, "a condition of the system reaches zero"),
        "outcomes": dict.fromkeys(model.guards, "domain-end"),
    }  # fmt: skip


def own_units(family: Family) -> dict[str, str]:
    """Units of times, rates and observables of a system; empty where it states none."""
    units = family.system.units
    time = time_unit(units)
    known_ = {n: readable(u) for n, u in units.items() if u and u != "1"}
    return known_ | ({} if time == "1" else {"time": time, "growth rate": f"1/{time}"})


def own_certificate(family: Family, subject: Subject, values: Mapping[str, float]) -> Any:
    """What is proved over the first axes of a family of one's own."""
    known_ = {q.name: q for q in subject.quantities}
    axes = [Axis(n, known_[n].low, known_[n].high, (1 << LEVELS) + 1, log=False)
            for n in subject.axes]  # fmt: skip
    held = {n: v for n, v in values.items() if n not in subject.axes}
    at = [held[n] for n in family.at if n in held]
    given = {n: v for n, v in held.items() if n not in family.at}
    problem = prepare(family, axes, None, None, at[0] if len(at) == 1 else None, given)
    boxes = prove_boxes(problem, (axes[0], axes[1]), LEVELS)
    return {
        "axes": [[a.name, a.low, a.high] for a in axes], "held": held, "levels": LEVELS,
        "proved": boxes.proved, "tree": packed(boxes, axes[0], axes[1]),
    }  # fmt: skip


def given_values(family: Family, at: Any, parameters: Mapping[str, Any]) -> dict[str, float]:
    """Every quantity of a family as a number, or an error that names what is missing."""
    names = (*family.at, *family.parameters)
    for name in parameters:
        known("parameter", name, names)
    values = dict(parameters)
    if at is not None:
        each = list(at) if isinstance(at, (list, tuple)) else [at]
        if len(each) != len(family.at):
            raise ParameterError(f"at is {shown(at)}; give {len(family.at)} numbers.")
        values |= dict(zip(family.at, each, strict=True))
    missing = [n for n in names if n not in values]
    if missing:
        raise ParameterError(f"{absent(missing)}; give each quantity the value shown at first.")
    return values


def without_inputs(
    family: Family, values: Mapping[str, float]
) -> tuple[Family, dict[str, float], list[str]]:
    """The family without the inputs whose given 0 it needs to be steady, and their names.

    A reader of a page could move such an input to where no member is.
    """
    known_zero = steady_where(family, values)
    if known_zero is family:
        return family, dict(values), []
    needed = [
        n for n in family.parameters
        if values[n] == 0 and not structure(replace(
            known_zero, typical={m: v for m, v in known_zero.typical.items() if m != n})).steady
    ]  # fmt: skip
    system = family.system
    kept = [n for n in system.parameters if n not in needed]
    symbols = dict(zip(system.parameters, ca.vertsplit(system.p), strict=True))
    put = ca.vertcat(*(symbols[n] if n in kept else 0 for n in system.parameters))
    named = {**system.observables, **{str(i): c.value for i, c in enumerate(system.conditions)}}
    rates, *rest = ca.substitute([system.rhs, *named.values()], [system.p], [put])
    seen = dict(zip(named, rest, strict=True))
    smaller = System(
        system.name, system.x, ca.vertcat(*(symbols[n] for n in kept)), rates,
        states=system.states, parameters=tuple(kept),
        observables={n: seen[n] for n in system.observables},
        conditions=tuple(replace(c, value=seen[str(i)]) for i, c in enumerate(system.conditions)),
        units={n: u for n, u in system.units.items() if n not in needed},
    )  # fmt: skip
    sizes = {n: v for n, v in family.typical.items() if n not in needed}
    left = {n: v for n, v in values.items() if n not in needed}
    return replace(family, system=smaller, typical=sizes), left, needed
