"""Checks of the CasADi expressions and names of a user's system."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import casadi as ca
import numpy as np

from ..algebra.polynomial import ExactPolynomial
from ..algebra.upright import Upright
from ..base.checks import checked, flag, instance, known, one_number, rows
from ..base.errors import NameUnknownError, ParameterError, absent, listed, shown
from ..base.types import Floats


def expression(what: str, value: Any, rows: int | None = None, columns: int | None = None) -> ca.SX:
    """An SX expression of a shape, or a refusal; numbers and DM become constants."""
    if isinstance(value, ca.SX):
        matrix = value
    else:
        try:  # as doubles first: some NumPy types crash CasADi
            matrix = ca.SX(
                ca.DM(
                    np.asarray(checked(what, value.full() if isinstance(value, ca.DM) else value))
                )
            )
        except Exception:  # CasADi raises several exception classes
            raise ParameterError(
                f"{what} is {shown(value)}; give a CasADi SX expression."
            ) from None
    for size, wanted in ((matrix.size1(), rows), (matrix.size2(), columns)):
        if wanted is not None and size != wanted:
            raise ParameterError(
                f"{what} has shape {matrix.size1()} x {matrix.size2()}; give {rows} x {columns}."
            )
    return matrix


def names(what: str, value: Any) -> tuple[str, ...]:
    """A tuple of different names, or a refusal."""
    if isinstance(value, str) or not isinstance(value, (tuple, list)):
        raise ParameterError(f"{what} is {shown(value)}; give a tuple of names.")
    for name in value:
        if not isinstance(name, str) or not name.isprintable() or not name.strip():
            raise ParameterError(f"{what} holds {shown(name)}; give names, each a plain string.")
    twice = [n for i, n in enumerate(value) if n in value[:i]]
    if twice:
        raise ParameterError(
            f"{what} names {shown(twice[0])} twice; give each one name of its own."
        )
    return tuple(map(str, value))


def title(what: str, value: Any) -> str:
    """A name that fits in a message and a file, or a refusal; `what` says of what."""
    text = instance(f"name of {what}", value, str, "give a string")
    if not text.isprintable() or not text.strip() or len(text) > 100:
        raise ParameterError(
            f"name of {what} is {shown(value)}; give 1 to 100 printable characters."
        )
    return str(text)


def mapping(what: str, value: Any) -> dict[str, Any]:
    """A mapping by names, or a refusal."""
    if not isinstance(value, Mapping) or not all(isinstance(n, str) for n in value):
        raise ParameterError(f"{what} is {shown(value)}; give a mapping by names.")
    return dict(value)


def check_names(name: Any, states: Any, parameters: Any, units: Any) -> dict[str, Any]:
    """Name, states, parameters and units of a system without a graph, or a refusal."""
    arguments: dict[str, Any] = {
        "name": title("the system", name),
        "units": mapping("units", units),
    }
    arguments |= {"states": names("states", states), "parameters": names("parameters", parameters)}
    _apart(arguments["states"], arguments["parameters"])
    _check_units(arguments["units"], (*arguments["states"], *arguments["parameters"]))
    if not arguments["states"]:
        raise ParameterError("states is empty; give the name of each state.")
    return arguments


def _apart(states: tuple[str, ...], parameters: tuple[str, ...]) -> None:
    both = set(states) & set(parameters)
    if both:
        raise ParameterError(f"{shown(min(both))} is a state and a parameter; give two names.")


def _check_units(units: Mapping[str, str], named: tuple[str, ...]) -> None:
    """Refuse a unit of nothing; `time` is no quantity of a system, and has a unit all the same."""
    for name in units:
        if name not in (*named, "time"):
            raise NameUnknownError(
                f"units names {shown(name)}; known are {', '.join([*named, 'time'])}."
            )


def check_system(system: Any) -> None:
    """Refuse a system whose parts do not fit together.

    Raises
    ------
    ParameterError
        If a part does not fit; the message names the part and accepted values.
    """
    title("the system", system.name)
    for what in ("x", "p", "rhs"):
        value = getattr(system, what)
        if not isinstance(value, ca.SX):
            raise ParameterError(
                f"{what} is a {type(value).__name__}; give a CasADi SX expression, or a "
                "Function of MX to System.from_function."
            )
    _check_symbols("x", system.x, system.states)
    _check_symbols("p", system.p, system.parameters)
    _apart(system.states, system.parameters)
    _check_units(system.units, (*system.states, *system.parameters, *system.observables))
    if system.rhs.numel() != system.x.numel():
        raise ParameterError(
            f"rhs has {system.rhs.numel()} entries for {system.x.numel()} states; give one each."
        )
    expression("rhs", system.rhs, system.x.numel(), 1)
    for state in system.algebraic:
        known("algebraic", state, system.states)
    if system.algebraic and system.mass is not None:
        raise ParameterError("algebraic belongs to explicit rates; leave out mass and forcing.")
    places = [system.states.index(n) for n in system.algebraic]
    if places and ca.sprank(ca.jacobian(system.rhs, system.x)[places, places]) < len(places):
        raise ParameterError(
            f"the algebraic equations of {system.name} leave some of {listed(system.algebraic)} "
            "open for all numbers (index above 1); differentiate them, or name other variables in "
            "algebraic."
        )
    symbols = ca.vertcat(system.x, system.p)
    limits = [("a condition", c.value) for c in system.conditions]
    for name, value in [("rhs", system.rhs), *system.observables.items(), *limits]:
        symbol = stranger(value, symbols)
        if symbol is not None:
            raise ParameterError(
                f"{name} contains the symbol {symbol}, which is neither a state nor a parameter; "
                "list it in x or p."
            )


def _check_symbols(what: str, symbols: ca.SX, labels: tuple[str, ...]) -> None:
    if symbols.numel() != len(labels):
        raise ParameterError(
            f"{what} has {symbols.numel()} entries but the names are {shown(list(labels))}; "
            "give each entry one name of its own."
        )
    if symbols.numel() and not (symbols.is_valid_input() and symbols.is_dense()):
        raise ParameterError(f"{what} is {shown(symbols)}; give symbols, as SX.sym makes them.")
    if symbols.numel() and symbols.size2() != 1:
        raise ParameterError(f"{what} has {symbols.size2()} columns; give one column of symbols.")


def stranger(value: ca.SX, symbols: ca.SX) -> ca.SX | None:
    """The first symbol of an expression that is none of these; None where there is none."""
    return next((s for s in ca.symvar(value) if not ca.depends_on(symbols, s)), None)


def check_family(family: Any) -> None:
    """Refuse wrong parts of a family, and store the others as plain tuples, dicts and floats.

    Raises
    ------
    ParameterError, NameUnknownError
        If a part does not fit; the message names the part and accepted values.
    """
    title("the family", family.name)

    def keep(what: str, value: Any) -> None:
        object.__setattr__(family, what, value)

    for what in ("at", "equations", "positive"):
        keep(what, names(what, getattr(family, what)))
    if not family.at and family.system.parameters:
        raise ParameterError("at is empty; give the names of what distinguishes the members.")
    held = mapping("held", family.held)
    for name, value in held.items():
        if not isinstance(value, Upright):
            held[name] = one_number(f"held {name}", value)
    keep("held", held)
    for what in ("unknown", "typical"):
        numbers = mapping(what, getattr(family, what))
        keep(what, {n: one_number(f"{what} {n}", v) for n, v in numbers.items()})
    for name in family.positive:
        known("positive", name, tuple(family.unknown))
    for what in ("conservative", "integrals", "drifts"):
        keep(what, flag(what, getattr(family, what)))
    if not isinstance(family.exact, ExactPolynomial | None):
        raise ParameterError(
            f"exact is {shown(family.exact)}; give an object of a subclass of "
            "stability.ExactPolynomial."
        )


def singular_parts(
    mass: ca.SX, forcing: ca.SX, unknowns: tuple[str, ...], rates: Mapping[str, Any]
) -> tuple[tuple[str, ...], ca.SX, ca.SX, tuple[str, ...], dict[str, Any]]:
    """Algebraic states by zero columns of a mass matrix, and the rest without its zero rows.

    Returns
    -------
    algebraic, mass, forcing, unknowns, rates
        Each algebraic state has a zero row's forcing in place of a rate.
    """
    kept = ca.sparsify(mass).sparsity()
    rows, columns = (sorted({*range(len(unknowns))} - {*some}) for some in kept.get_triplet())
    gone = [j for j in columns if unknowns[j].startswith("d_")]
    if not gone or len(columns) == len(unknowns):
        return (), mass, forcing, unknowns, dict(rates)
    if len(rows) != len(gone):
        raise ParameterError(
            f"mass has {len(gone)} zero columns, for {listed([unknowns[j] for j in gone])}, and "
            f"{len(rows)} zero rows; give one algebraic equation for each."
        )
    algebraic = tuple(unknowns[j][2:] for j in gone)
    here, there = ([i for i in range(len(unknowns)) if i not in some] for some in (rows, gone))
    more = {n: forcing[i] for n, i in zip(algebraic, rows, strict=True)}
    names_left = tuple(unknowns[j] for j in there)
    return algebraic, mass[here, there], forcing[here], names_left, {**rates, **more}


def check_implicit(
    mass: ca.SX, unknowns: tuple[str, ...], rates: Mapping[str, Any], pivots: Any, states: Any
) -> list[tuple[int, int]]:
    """The pivots of mass · unknowns = forcing, or a refusal.

    Parameters
    ----------
    mass
        Square matrix, as many rows as unknowns.
    unknowns
        Names of the unknowns.
    rates
        Rates of the states that are not among the unknowns.
    pivots
        Pairs (row, column), or None for the natural order.
    states
        Names of the states.
    """
    for state in names("states", states):
        if state not in rates and f"d_{state}" not in unknowns:
            raise NameUnknownError(
                f"state {shown(state)} has no rate; name it in rates, or d_{state} in unknowns."
            )
    order = [(i, i) for i in range(len(unknowns))] if pivots is None else pivots
    every = list(range(len(unknowns)))
    try:
        pairs = [(int(row), int(column)) for row, column in order]
    except Exception:
        raise ParameterError(f"pivots is {shown(pivots)}; give pairs (row, column).") from None
    if sorted(r for r, _ in pairs) != every or sorted(c for _, c in pairs) != every:
        raise ParameterError(
            f"pivots is {shown(pivots)}; name each row and each column from 0 to "
            f"{len(unknowns) - 1} once."
        )
    if ca.SX(mass).nnz() == 0:
        raise ParameterError("mass is zero; give a matrix that can be solved.")
    return pairs


def numbers_of(
    family: Any, fixed: Any, parameters: Any, named: Mapping[str, float]
) -> tuple[Floats, Floats]:
    """Further family parameters and parameters of a branch, as arrays of one axis.

    Parameters
    ----------
    family
        The family.
    fixed, parameters
        Numbers in order, or by name.
    named
        Numbers by name that the call gives as keywords, in place of these.
    """
    for name in named:
        known("parameter", name, (*family.at[1:], *family.parameters))
    arrays = []
    for what, values, names in (
        ("fixed", fixed, family.at[1:]),
        ("parameters", parameters, family.parameters),
    ):
        table = values if isinstance(values, Mapping) else {}
        by_name = {n: v for n, v in named.items() if n in names}
        if by_name and len(values):
            raise ParameterError(
                f"{next(iter(by_name))} is given by name and in {what}; give it once."
            )
        table = table or by_name
        for name in table:
            known(what, name, names)
        missing = [n for n in names if n not in table] if table else []
        if missing:
            raise ParameterError(f"{absent(missing)}; give {', '.join(names)}.")
        array = rows(what, [table[n] for n in names] if table else values, names)
        if array.ndim != 1:
            raise ParameterError(f"{what} has shape {array.shape}; give one axis of numbers.")
        arrays.append(array)
    return arrays[0], arrays[1]
