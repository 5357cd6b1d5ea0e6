"""`mechanics`: a mechanical system from its energies, forces and constraints."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import casadi as ca
import numpy as np
from flint import arb, arb_mat

from ..algebra.number_types import balls, precision
from ..algebra.program import Program
from ..base.checks import known
from ..base.errors import ParameterError, StabilityError, shown
from ..base.types import Floats
from .equations import Condition, eliminate
from .system import System
from .system_checks import expression, mapping, names, stranger

# --- identities by balls ---


BITS = 512
"""Working precision at the points."""
SMALL = 2.0**-200
"""Largest size of a value that counts as an identical zero."""
POINTS = 3
"""Number of points."""


def _point(size: int, number: int) -> list[arb]:
    """Incommensurable numbers between 0.4 and 1.2."""
    roots = [arb(2 + 5 * number + 3 * i).sqrt() for i in range(size)]
    return [((r - r.floor()) * 4 / 5 + arb(2) / 5).mid() for r in roots]


def _at_points(
    matrix: ca.SX, symbols: ca.SX, judge: Callable[[Any], Any], zeros: int = 0
) -> list[Any]:
    """What `judge` finds in the matrix of balls at each point where the matrix is finite.

    The first `zeros` symbols are zero at every point.
    """
    judged = []
    try:
        program = Program(ca.Function("identity", [symbols], [ca.densify(matrix)]))
        with precision(BITS):
            for number in range(POINTS):
                point = [arb(0)] * zeros + _point(symbols.numel(), number)[zeros:]
                values = program.dense(balls(), [point])
                rows = [[arb(v) for v in row] for row in values]
                if all(v.is_finite() for row in rows for v in row):
                    judged.append(judge(rows))
    except (StabilityError, ZeroDivisionError):  # an operation that balls do not have
        return []
    return judged


def _is_zero(value: Any) -> bool:
    return bool(value.contains(0)) and float(value.abs_upper()) < SMALL


def _vanishing(column: ca.SX, symbols: ca.SX) -> list[bool]:
    """Whether each entry of a column vanishes identically; no proof counts as no.

    Parameters
    ----------
    column
        Expressions in the symbols, shape (k, 1).
    symbols
        Every symbol of the expressions.

    Examples
    --------
    >>> x = ca.SX.sym("x")
    >>> _vanishing(ca.vertcat(ca.sin(x) ** 2 + ca.cos(x) ** 2 - 1, x), x)
    [True, False]
    """
    if not column.numel():
        return []
    zeros = _at_points(column, symbols, lambda rows: [_is_zero(row[0]) for row in rows])
    return [bool(zeros) and all(f[i] for f in zeros) for i in range(column.numel())]


def singular(matrix: ca.SX, symbols: ca.SX) -> bool:
    """Whether the determinant of a square matrix vanishes identically; no proof counts as no.

    Parameters
    ----------
    matrix
        Expressions in the symbols, shape (n, n).
    symbols
        Every symbol of the expressions.

    Examples
    --------
    >>> x = ca.SX.sym("x")
    >>> singular(ca.vertcat(ca.horzcat(x, 2 * x), ca.horzcat(1, 2)), x)
    True
    """
    if _plainly_regular(matrix, symbols):
        return False
    zeros = _at_points(matrix, symbols, lambda rows: _is_zero(arb_mat(rows).det()))
    return bool(zeros) and all(zeros)


def _plainly_regular(matrix: ca.SX, symbols: ca.SX) -> bool:
    """Whether doubles at one point already show that the matrix is regular there."""
    point = [float(v) for v in _point(symbols.numel(), 0)]
    value = np.array(ca.Function("at", [symbols], [ca.densify(matrix)])(point))
    if not (value.size and np.isfinite(value).all()):
        return False
    for axis in (0, 1):  # columns, then rows, of like size
        value = value / np.maximum(np.abs(value).max(axis=axis, keepdims=True), 1e-300)
    sizes = np.linalg.svd(value, compute_uv=False)
    return bool(sizes[-1] > 1e-8 * sizes[0])


def _pivots_of(matrix: ca.SX, symbols: ca.SX, states: int) -> list[tuple[int, int]] | None:
    """Pairs (row, column) that eliminate a square matrix; constant and sparse pivots first.

    A pivot that vanishes where all states are zero, as in many symmetric motions, comes last.

    Parameters
    ----------
    matrix
        Expressions in the symbols, shape (n, n).
    symbols
        Every symbol of the expressions.
    states
        Number of the first symbols that are states.

    Returns
    -------
    list of (int, int) or None
        None where the matrix is singular at the points.

    Examples
    --------
    >>> x = ca.SX.sym("x")
    >>> _pivots_of(ca.vertcat(ca.horzcat(x, 2), ca.horzcat(1, 0)), x, 1)
    [(0, 1), (1, 0)]
    """

    def plain(rows: Any) -> list[list[float]]:
        return [[float(v) for v in row] for row in rows]

    matrices = _at_points(matrix, symbols, plain)
    size = matrix.size1()
    if not matrices:
        return [(i, i) for i in range(size)]
    near = _at_points(matrix, symbols, plain, states)[:1]
    values = np.array([*near, *matrices])
    values /= np.maximum(np.abs(values).max(axis=(0, 2), keepdims=True), 1e-300)
    rows, columns = list(range(size)), list(range(size))
    order = []
    while rows:
        best = _best(values, rows, columns, bool(near))
        if best is None:
            return None
        row, column = best
        order.append(best)
        rows.remove(row)
        columns.remove(column)
        for other in rows:
            with np.errstate(all="ignore"):
                factor = values[:, other, column] / values[:, row, column]
                values[:, other] -= factor[:, None] * values[:, row]
    return order


def _best(
    values: Floats, rows: Sequence[int], columns: Sequence[int], near: bool
) -> tuple[int, int] | None:
    """The pivot that does not vanish at the first point, is constant, sparse, and large."""
    rest = np.abs(values[int(near) :, rows][:, :, columns]).min(axis=0) > 1e-9
    scores = {}
    for i, row in enumerate(rows):
        for j, column in enumerate(columns):
            if rest[i, j]:
                entry = values[int(near) :, row, column]
                fill = (rest[i].sum() - 1) * (rest[:, j].sum() - 1)
                sound = bool(abs(values[0, row, column]) > 1e-9)  # False for NaN
                scores[row, column] = (
                    not sound,
                    np.ptp(entry) > 1e-12,
                    fill,
                    -np.abs(entry).min(),
                )
    return min(scores, key=lambda place: scores[place]) if scores else None


# --- the model as given ---


@dataclass(frozen=True, eq=False)
class MechanicalModel:
    """Energies, forces and constraints of a mechanical system, with the names of its symbols."""

    q: ca.SX
    """Coordinates, shape (k, 1)."""
    u: ca.SX
    """Velocities, shape (n, 1)."""
    p: ca.SX
    """Parameters, shape (m, 1)."""
    coordinates: tuple[str, ...]
    """Names of the coordinates."""
    velocities: tuple[str, ...]
    """Names of the velocities."""
    parameters: tuple[str, ...]
    """Names of the parameters."""
    kinetic: ca.SX
    """Kinetic energy."""
    potential: ca.SX
    """Potential energy."""
    forces: ca.SX
    """Generalised forces on the velocities, shape (n, 1)."""
    q_dot: ca.SX
    """Rates of the coordinates, linear in the velocities, shape (k, 1)."""
    constraints: tuple[str, ...]
    """Names of the constraints, those on velocities first."""
    rates: ca.SX
    """What vanishes at the level of velocities, one entry for each constraint, shape (c, 1)."""
    positions: Mapping[str, ca.SX]
    """Holonomic constraints by name: what vanishes at the level of coordinates."""

    @property
    def symbols(self) -> ca.SX:
        """Every symbol, in a column."""
        return ca.vertcat(self.q, self.u, self.p)


def _symbols_of(what: str, value: Any) -> tuple[ca.SX, tuple[str, ...]]:
    """A column of symbols and their names, or a refusal."""
    column = ca.SX(0, 1) if value is None else value
    if not isinstance(column, ca.SX) or not (
        column.numel() == 0
        or (column.is_valid_input() and column.is_dense() and column.is_column())
    ):
        raise ParameterError(
            f"{what} is {shown(value)}; give one column of symbols, as SX.sym does."
        )
    labels = [s.name() for s in ca.vertsplit(column)] if column.numel() else []
    return column, names(f"the names of {what}", labels)


def _read_model(
    q: Any,
    u: Any,
    p: Any,
    *,
    kinetic: Any,
    potential: Any,
    forces: Any,
    q_dot: Any,
    velocity_constraints: Any,
    holonomic: Any,
) -> MechanicalModel:
    """The model, or a refusal that says what does not fit."""
    (q, at), (u, speeds), (p, parameters) = (
        _symbols_of(w, v) for w, v in (("q", q), ("u", u), ("p", p))
    )
    if not (q.numel() and u.numel()):
        raise ParameterError("q or u is empty; give at least one coordinate and one velocity.")
    names("q, u and p", [*at, *speeds, *parameters])
    place, everything = ca.vertcat(q, p), ca.vertcat(q, u, p)
    on_rates = _by_name("velocity_constraints", velocity_constraints, 1)
    on_places = _by_name("holonomic", holonomic, 1 + len(on_rates))
    labels = names("velocity_constraints and holonomic", [*on_rates, *on_places])
    for name, value in on_rates.items():
        within(f"velocity constraint {name}", value, everything, "q, u or p")
    for name, value in on_places.items():
        within(f"holonomic constraint {name}", value, place, "q or p")
    rates = _kinematics(q, u, q_dot, everything)
    moving = [*on_rates.values(), *(ca.jtimes(e, q, rates) for e in on_places.values())]
    column = ca.vertcat(*moving) if moving else ca.SX(0, 1)
    slopes = ca.jacobian(column, u)
    for i, name in enumerate(labels):
        if ca.depends_on(slopes[i, :], u):
            raise ParameterError(
                f"velocity constraint {name} is not linear in u; give an expression that is zero "
                "and linear in the velocities."
            )
    energy = within("kinetic", expression("kinetic", kinetic, 1, 1), everything, "q, u or p")
    height = within("potential", expression("potential", potential, 1, 1), place, "q or p")
    force = within("forces", _forces(forces, speeds), everything, "q, u or p")
    return MechanicalModel(
        q, u, p, at, speeds, parameters, energy, height, force, rates, labels, column, on_places
    )


def within(what: str, value: ca.SX, symbols: ca.SX, where: str) -> ca.SX:
    """The expression, or a refusal if it has another symbol."""
    symbol = stranger(value, symbols)
    if symbol is not None:
        raise ParameterError(
            f"{what} has the symbol {symbol}, which is not in {where}; list it there."
        )
    return value


def _by_name(what: str, value: Any, first: int) -> dict[str, ca.SX]:
    """Expressions by name; a column or a list takes numbers as names."""
    if isinstance(value, Mapping):
        return {n: expression(f"{what} {n}", e, 1, 1) for n, e in mapping(what, value).items()}
    if isinstance(value, (list, tuple)):
        entries = [expression(f"an entry of {what}", e, 1, 1) for e in value]
    else:
        column = expression(what, value)
        if column.numel() and column.size2() != 1:
            raise ParameterError(f"{what} has {column.size2()} columns; give one column.")
        entries = ca.vertsplit(column) if column.numel() else []
    return {str(first + i): e for i, e in enumerate(entries)}


def _forces(value: Any, speeds: Sequence[str]) -> ca.SX:
    """A column of generalised forces from a column, or from a mapping by the velocities' names."""
    if value is None:
        return ca.SX.zeros(len(speeds), 1)
    if not isinstance(value, Mapping):
        return expression("forces", value, len(speeds), 1)
    table = mapping("forces", value)
    for name in table:
        known("forces", name, speeds)
    return ca.vertcat(*[expression(f"force on {s}", table.get(s, 0.0), 1, 1) for s in speeds])


def _kinematics(q: ca.SX, u: ca.SX, q_dot: Any, symbols: ca.SX) -> ca.SX:
    """The rates of the coordinates, or a refusal where they do not determine the velocities."""
    if q_dot is None:
        if q.numel() != u.numel():
            raise ParameterError(
                f"q has {q.numel()} entries and u has {u.numel()}; give as many, or q_dot with the "
                "rate of each coordinate."
            )
        return u
    rates = within("q_dot", expression("q_dot", q_dot, q.numel(), 1), symbols, "q, u or p")
    slopes = ca.jacobian(rates, u)
    if ca.depends_on(slopes, u) or not all(_vanishing(rates - slopes @ u, symbols)):
        raise ParameterError("q_dot is not linear in u without a free term; give q_dot = N(q) u.")
    if singular(slopes.T @ slopes, symbols):
        raise ParameterError(
            "q_dot does not determine u: its slope in u has dependent columns at every state; give "
            "each velocity a coordinate that it moves."
        )
    if q.numel() > u.numel() and not _closes(slopes, rates, q, symbols):
        raise ParameterError(
            f"q has {q.numel()} entries, u has {u.numel()}, and q_dot is no motion on a surface of "
            "as many dimensions; give a velocity for each coordinate, and velocity_constraints."
        )
    return rates


def _closes(slopes: ca.SX, rates: ca.SX, q: ca.SX, symbols: ca.SX) -> bool:
    """Whether brackets of the columns stay within their span (Frobenius)."""
    bracket = _brackets(slopes, rates, q)
    gram = slopes.T @ slopes
    rest = bracket - slopes @ ca.solve(gram, slopes.T @ bracket)
    return all(_vanishing(ca.vec(rest), symbols))


def _brackets(slopes: ca.SX, rates: ca.SX, q: ca.SX) -> ca.SX:
    """(∂q̇/∂q) N - Ṅ: brackets of the columns of N with q̇ = N u."""
    turned = ca.jtimes(ca.vec(ca.densify(slopes)), q, rates)
    return ca.jacobian(rates, q) @ slopes - ca.reshape(turned, *slopes.shape)


# --- the equations with multipliers ---


@dataclass(frozen=True, eq=False)
class Balance:
    """mass · (accelerations, multipliers) = forcing, and the order of its elimination."""

    mass: ca.SX
    """[[M, -Aᵀ], [A, 0]]: rows of the velocities, then of the constraints."""
    forcing: ca.SX
    """Right-hand side."""
    energy: ca.SX
    """Kinetic plus potential energy (Jacobi's energy)."""
    power: ca.SX
    """Energy that the forces take in a unit of time."""
    order: tuple[tuple[int, int], ...]
    """Pivots (row, column)."""


def unknowns(model: MechanicalModel) -> tuple[str, ...]:
    """Names of accelerations and multipliers."""
    rates = [f"d_{s}" for s in model.velocities]
    return (*rates, *[f"multiplier_{c}" for c in model.constraints])


def _balance(model: MechanicalModel, solved: Mapping[int, int]) -> Balance:
    """The equations of motion of a model.

    Parameters
    ----------
    model
        Energies, forces, constraints.
    solved
        Velocity for which each constraint is solved, by index; empty for the natural order.

    Source: J. Neimark & N. Fufaev, Dynamics of Nonholonomic Systems (1972), ch. III;
    tests/systems/test_mechanics.py compares with SymPy and with closed forms.
    """
    q, u, rates = model.q, model.u, model.q_dot
    slopes = ca.jacobian(rates, u)
    momenta = ca.gradient(model.kinetic, u)
    across = ca.gradient(model.kinetic - model.potential, q)
    forcing = model.forces + slopes.T @ across - ca.jtimes(momenta, q, rates)
    turning = ca.sparsify(_brackets(slopes, rates, q))
    if turning.nnz():  # N (NᵀN)⁻¹: the Gram matrix is positive wherever q̇ determines u
        gram = slopes.T @ slopes
        coordinates, _ = eliminate(gram, momenta, [(i, i) for i in range(u.numel())])
        forcing -= turning.T @ (slopes @ ca.vertcat(*coordinates))
    mass = ca.jacobian(momenta, u)
    held = ca.jacobian(model.rates, u)
    count = len(model.constraints)
    whole = ca.blockcat([[mass, -held.T], [held, ca.SX(count, count)]])
    _refuse_singular(model, mass, whole, solved)
    if solved:
        _refuse_pivots(model, solved, held[list(solved), list(solved.values())])
    right = ca.vertcat(forcing, -ca.jtimes(model.rates, q, rates))
    free = [i for i in range(u.numel()) if i not in solved.values()]
    natural = [(i, i) for i in range(u.numel() + count)]
    first = [(u.numel() + c, j) for c, j in solved.items()]
    order = [*first, *[(j, c) for c, j in first], *[(i, i) for i in free]] if solved else natural
    energy = ca.dot(momenta, u) - model.kinetic + model.potential
    power = -ca.dot(model.forces, u)
    return Balance(whole, right, energy, power, tuple(order))


def _refuse_singular(model: MechanicalModel, mass: ca.SX, whole: ca.SX, solved: Any) -> None:
    if not solved and singular(mass, model.symbols):
        raise ParameterError(
            "kinetic gives a mass matrix that is singular at every state; give each velocity a "
            "mass, or name by pivots or independent the velocities that the constraints determine."
        )
    if singular(whole, model.symbols):
        raise ParameterError(
            "mass matrix and constraints together are singular at every state; leave out "
            "constraints that follow from others, and give each free velocity a mass."
        )


def choice(model: MechanicalModel, independent: Any, pivots: Any) -> dict[int, int]:
    """The velocity for which each constraint is solved, in the order of elimination.

    Parameters
    ----------
    model
        The model.
    independent
        Names of the independent velocities, or None.
    pivots
        Names of velocities by the constraints' names, or None.

    Returns
    -------
    dict
        Index of the velocity by the constraint's index; empty for the natural order.
    """
    table = _stated(model, pivots)
    if independent is None:
        return table
    kept = names("independent", independent)
    for name in kept:
        known("independent", name, model.velocities)
    wanted = len(model.velocities) - len(model.constraints)
    if len(kept) != wanted:
        raise ParameterError(
            f"independent names {len(kept)} velocities; give {wanted}, the number of velocities "
            "less that of constraints."
        )
    rest = [i for i, s in enumerate(model.velocities) if s not in kept]
    if pivots is not None:
        if sorted(table.values()) != rest:
            raise ParameterError(
                f"pivots is {shown(pivots)}; give each velocity outside independent one constraint."
            )
        return table
    order = _pivots_of(
        ca.jacobian(model.rates, model.u)[:, rest],
        model.symbols,
        len(model.coordinates) + len(model.velocities),
    )
    if order is None:
        raise ParameterError(
            "the constraints do not determine the velocities outside independent at any state; "
            "give another choice of independent."
        )
    return {row: rest[column] for row, column in order}


def _stated(model: MechanicalModel, pivots: Any) -> dict[int, int]:
    if pivots is None:
        return {}
    table = mapping("pivots", pivots)
    if sorted(table) != sorted(model.constraints):
        raise ParameterError(
            f"pivots is {shown(pivots)}; name each constraint once: {', '.join(model.constraints)}."
        )
    speeds = [known(f"pivot of {c}", s, model.velocities) for c, s in table.items()]
    names("pivots", speeds)
    return {
        model.constraints.index(c): model.velocities.index(s)
        for c, s in zip(table, speeds, strict=True)
    }


def _dependent(model: MechanicalModel, solved: Mapping[int, int]) -> tuple[ca.SX, ca.SX]:
    """The dependent velocities, and what they are in terms of the independent ones."""
    places = list(solved.values())
    symbols = model.u[places]
    rows = model.rates[list(solved)]
    without = ca.substitute(rows, symbols, ca.SX.zeros(len(places), 1))
    order = [(i, i) for i in range(len(places))]
    values, _ = eliminate(ca.jacobian(rows, symbols), -without, order)
    return symbols, ca.vertcat(*values)


def _refuse_pivots(model: MechanicalModel, solved: Mapping[int, int], slopes: ca.SX) -> None:
    """Refuse an order in which a pivot vanishes identically."""
    for size, (constraint, speed) in enumerate(solved.items(), 1):
        if singular(slopes[:size, :size], model.symbols):
            raise ParameterError(
                f"constraint {model.constraints[constraint]} cannot be solved for "
                f"{model.velocities[speed]} in the order of pivots: its pivot vanishes at every "
                "state; give another velocity or order."
            )


def _guarded(
    model: MechanicalModel, solved: Mapping[int, int], pivots: Sequence[ca.SX]
) -> tuple[dict[str, ca.SX], list[Condition]]:
    """The pivots that are not constant, as observables, and as conditions."""
    speeds, constraints = model.velocities, model.constraints
    count = len(constraints)
    if solved:
        free = [s for i, s in enumerate(speeds) if i not in solved.values()]
        ties = [constraints[c] for c in solved]
        held, masses = dict(zip(ties, pivots[:count], strict=True)), pivots[2 * count :]
    else:
        free, ties = list(speeds), list(constraints)
        held, masses = dict(zip(ties, pivots[len(speeds) :], strict=True)), pivots[: len(speeds)]
    lacking = "does not determine a force or velocity of its own: its pivot"
    lacking += ", squared," * bool(solved)
    firm = [
        (n, v, f"the mass matrix is not positive: its pivot for {n}")
        for n, v in zip(free, masses, strict=True)
    ]
    tied = [(n, v**2 if solved else v, f"constraint {n} {lacking}") for n, v in held.items()]
    seen, conditions = {}, []
    entries = [*tied, *firm] if solved else [*firm, *tied]  # as eliminated: the cause comes first
    for name, value, reason in entries:
        if value.is_constant():
            if not float(value) > 0:
                raise ParameterError(f"{reason} is {float(value):.3g}; give a positive one.")
            continue
        seen[f"pivot_{name}"] = value
        sentence = reason.replace("{", "{{").replace("}", "}}") + " is {value:.3g}"
        conditions.append(Condition(value, sentence))
    return seen, conditions


def _invariant(
    model: MechanicalModel, outputs: Mapping[str, ca.SX], left: Sequence[str]
) -> dict[str, bool]:
    """Whether each output is the same for every value of the coordinates that are left out."""
    places = model.q[[model.coordinates.index(n) for n in left]]
    along = ca.SX.sym("along", places.numel())  # any direction: each slope has its own factor
    slopes = ca.cse(ca.jtimes(ca.vertcat(*outputs.values()), places, along))
    return dict(zip(outputs, _vanishing(slopes, ca.vertcat(model.symbols, along)), strict=True))


# --- the system ---


def mechanics(
    q: ca.SX,
    u: ca.SX,
    p: ca.SX | None = None,
    *,
    kinetic: Any,
    potential: Any = 0.0,
    forces: Any = None,
    velocity_constraints: Any = (),
    holonomic: Any = (),
    q_dot: Any = None,
    independent: Sequence[str] | None = None,
    pivots: Mapping[str, str] | None = None,
    ignorable: Sequence[str] = (),
    observables: Mapping[str, Any] | None = None,
    conditions: Sequence[Condition] = (),
    units: Mapping[str, str] | None = None,
    name: str = "mechanical system",
) -> System:
    """A system from its kinetic and potential energy, forces and constraints.

    States are the coordinates and the velocities, with the names of their symbols.

    *Families of constrained systems.*  Without `independent` every velocity is a state, and each
    constraint adds one eigenvalue 0, a holonomic one two: motions that break the constraint are
    motions of the graph too.  A family then holds the dependent velocities and coordinates at
    values that keep the constraints.  With `independent` the constraints on velocities are solved,
    and these zeros are gone; a constraint that can be integrated, such as a holonomic one, leaves
    one zero, since its value is constant.  A coordinate that no equation contains, such as a place
    on a level plane, is never steady: name it in `ignorable`.

    Numbers within expressions are combined in double precision when CasADi builds the graph.
    Dimensions given as parameters `p` stay exact, and with them zeros by structure.

    Parameters
    ----------
    q
        Coordinates: a column of SX symbols, shape (k, 1).
    u
        Velocities: a column of SX symbols, shape (n, 1).  They are the rates of q, or
        quasi-velocities with `q_dot`.
    p
        Parameters: a column of SX symbols, or None.
    kinetic
        Kinetic energy in q, u, p, without any constraint inserted.
    potential
        Potential energy in q, p.
    forces
        Generalised forces on the velocities in q, u, p: a column, shape (n, 1), or expressions by
        the velocities' names.  Their power is forces · u.
    velocity_constraints
        Expressions in q, u, p that vanish, linear in u: a column, a list, or by name.  Without
        names they are numbered from 1, holonomic ones after those on velocities.
    holonomic
        Expressions in q, p that vanish: as above.
    q_dot
        Rates of the coordinates, N(q, p) u, shape (k, 1); q̇ = u when left out.
    independent
        Names of the velocities that stay as states, as many as velocities less constraints; the
        others are solved from the constraints, and become observables.
    pivots
        For each constraint, by name, the velocity for which it is solved, in the order of
        elimination.  When left out: with `independent`, constant pivots first; otherwise the mass
        matrix is eliminated in natural order, then the multipliers.  These pivots are positive
        wherever the mass matrix is positive definite and the constraints are independent.
    ignorable
        Names of coordinates that no equation contains: the state goes without them.  This is proved
        to 200 bits at three points, not taken from the user.  Observables of the list below that
        contain one are left out.
    observables
        More observables: expressions in q, u, p by name.
    conditions
        More quantities that must be positive.
    units
        SI unit by the name of state, parameter or observable.
    name
        Name of the system in messages and files.

    Returns
    -------
    System
        With the observables `energy` (kinetic + potential; Jacobi's energy where the kinetic energy
        is not quadratic in u), `power` (energy that forces and moving constraints take in a unit of
        time), and, for each constraint c, `multiplier_c` (the force of the constraint is its
        gradient in u times this), `residual_c` and, for a holonomic one, `residual_rate_c`;
        `pivot_c` and `pivot_u` for pivots that are not constant (squared where a constraint is
        solved for a velocity); with `independent` each dependent velocity v and its rate `d_v`.
        Each `pivot` is a condition, so that a pivot that vanishes is refused.

    Raises
    ------
    ParameterError, NameUnknownError
        If an expression has another symbol, a constraint is not linear in u, the mass matrix is
        singular at every state, shapes or names do not fit, or a coordinate is not ignorable.

    Source: Lagrange's equations with multipliers, and their form in quasi-velocities (Boltzmann and
    Hamel); J. Neimark & N. Fufaev, Dynamics of Nonholonomic Systems (1972), ch. III.

    Examples
    --------
    >>> import casadi as ca
    >>> import stability as st
    >>> q, u, p = ca.SX.sym("angle"), ca.SX.sym("rate"), ca.SX.sym("g")
    >>> pendulum = st.mechanics(q, u, p, kinetic=u**2 / 2, potential=-p * ca.cos(q))
    >>> pendulum.rates([0.5, 0.0], [9.81])
    array([ 0.        , -4.70316453])

    A sleigh: the blade does not move across; u are velocities in its frame.

    >>> q, u = ca.SX.sym("q", 3), ca.vertcat(*map(ca.SX.sym, ("v", "across", "w")))
    >>> c, s = ca.cos(q[2]), ca.sin(q[2])
    >>> sleigh = st.mechanics(
    ...     q, u, kinetic=(u[0] ** 2 + (u[1] + u[2]) ** 2 + u[2] ** 2) / 2,
    ...     q_dot=ca.vertcat(c * u[0] - s * u[1], s * u[0] + c * u[1], u[2]),
    ...     velocity_constraints={"blade": u[1]}, independent=("v", "w"),
    ...     ignorable=("q_0", "q_1", "q_2"))
    >>> sleigh.states, sleigh.rates([1.0, 2.0], [])  # v' = w², 2 w' = -v w
    (('v', 'w'), array([ 4., -1.]))
    """
    model = _read_model(
        q,
        u,
        p,
        kinetic=kinetic,
        potential=potential,
        forces=forces,
        q_dot=q_dot,
        velocity_constraints=velocity_constraints,
        holonomic=holonomic,
    )
    solved = choice(model, independent, pivots)
    limits = _limits(model, conditions)
    graph = _graph(model, solved, _observed(model, observables), limits)
    states = [*model.coordinates, *model.velocities]
    if independent is not None and solved:
        gone = [model.velocities[i] for i in solved.values()]
        states = [s for s in states if s not in gone]
        graph = _reduced(model, graph, solved, gone)
    left = names("ignorable", ignorable)
    for coordinate in left:
        known("ignorable", coordinate, model.coordinates)
    if left:
        states = [s for s in states if s not in left]
        graph = _without(model, graph.shared(), states, left, len(limits))
    graph = graph.shared()
    table = dict(
        zip((*model.coordinates, *model.velocities), ca.vertsplit(ca.vertcat(q, u)), strict=True)
    )
    gone_too = [s for s in table if s not in states and s not in graph.seen]
    kept_units = {n: unit for n, unit in mapping("units", units or {}).items() if n not in gone_too}
    return System(
        name,
        ca.vertcat(*[table[s] for s in states]),
        model.p,
        ca.vertcat(*[graph.rates[s] for s in states]),
        tuple(states),
        model.parameters,
        graph.seen,
        graph.conditions,
        kept_units,
        graph.mass,
        graph.forcing,
        unknowns(model),
    )


@dataclass(frozen=True, eq=False)
class _Graph:
    """The expressions of a system, while its states are chosen."""

    mass: ca.SX
    forcing: ca.SX
    rates: dict[str, ca.SX]
    seen: dict[str, ca.SX]
    conditions: tuple[Condition, ...]

    def replaced(self, symbols: ca.SX, values: ca.SX) -> _Graph:
        """The same with values in place of symbols."""
        return self._renewed(ca.substitute(self._entries(), [symbols], [values]))

    def shared(self) -> _Graph:
        """The same with each expression that occurs twice computed once."""
        return self._renewed(ca.cse(self._entries()))

    def _entries(self) -> list[ca.SX]:
        limits = [c.value for c in self.conditions]
        return [self.mass, self.forcing, *self.rates.values(), *self.seen.values(), *limits]

    def _renewed(self, expressions: list[ca.SX]) -> _Graph:
        rates = dict(zip(self.rates, expressions[2:], strict=False))
        seen = dict(zip(self.seen, expressions[2 + len(rates) :], strict=False))
        rest = expressions[2 + len(rates) + len(seen) :]
        conditions = [replace(c, value=v) for c, v in zip(self.conditions, rest, strict=True)]
        return _Graph(expressions[0], expressions[1], rates, seen, tuple(conditions))


def _observed(model: MechanicalModel, observables: Any) -> dict[str, ca.SX]:
    """The user's observables, checked."""
    table = {} if observables is None else mapping("observables", observables)
    return {
        n: within(f"observable {n}", expression(f"observable {n}", e), model.symbols, "q, u or p")
        for n, e in table.items()
    }


def _limits(model: MechanicalModel, conditions: Any) -> list[Condition]:
    """The user's conditions, checked."""
    if not isinstance(conditions, (tuple, list)) or not all(
        isinstance(c, Condition) for c in conditions
    ):
        raise ParameterError(f"conditions is {shown(conditions)}; give a tuple of Condition.")
    for condition in conditions:
        within("a condition", condition.value, model.symbols, "q, u or p")
    return list(conditions)


def _graph(
    model: MechanicalModel,
    solved: Mapping[int, int],
    observed: dict[str, ca.SX],
    limits: list[Condition],
) -> _Graph:
    """Rates, observables and conditions with every velocity as a state."""
    parts = _balance(model, solved)
    solution, pivots = eliminate(parts.mass, parts.forcing, parts.order)
    rates = dict(zip(model.coordinates, ca.vertsplit(model.q_dot), strict=True))
    rates |= dict(zip(model.velocities, solution, strict=False))
    multipliers = solution[len(model.velocities) :]
    moving = ca.substitute(model.rates, model.u, ca.SX.zeros(*model.u.shape))
    lost = parts.power + sum(m * b for m, b in zip(multipliers, ca.vertsplit(moving), strict=True))
    seen = {"energy": parts.energy, "power": ca.SX(lost)}
    for i, (label, multiplier) in enumerate(zip(model.constraints, multipliers, strict=True)):
        seen[f"multiplier_{label}"] = multiplier
        seen[f"residual_{label}"] = model.positions.get(label, model.rates[i])
        if label in model.positions:
            seen[f"residual_rate_{label}"] = model.rates[i]
    pivotal, guards = _guarded(model, solved, pivots)
    names("observables", [*seen, *pivotal, *observed])
    return _Graph(
        parts.mass, parts.forcing, rates, seen | pivotal | observed, tuple([*guards, *limits])
    )


def _reduced(
    model: MechanicalModel, graph: _Graph, solved: Mapping[int, int], gone: list[str]
) -> _Graph:
    """The same in independent velocities; the others become observables."""
    symbols, values = _dependent(model, solved)
    extra = {s: symbols[i] for i, s in enumerate(gone)}
    extra |= {f"d_{s}": graph.rates[s] for s in gone}
    names("observables", [*graph.seen, *extra])
    return replace(graph, seen=graph.seen | extra).replaced(symbols, values)


def _without(
    model: MechanicalModel, graph: _Graph, states: list[str], left: tuple[str, ...], limits: int
) -> _Graph:
    """The same without coordinates that no equation contains, or a refusal.

    The last `limits` conditions are the user's.  A pivot may change with these coordinates where
    the rates do not: the elimination is then that at zero.
    """
    vital = {f"rate of {s}": graph.rates[s] for s in states}
    conditions = graph.conditions[len(graph.conditions) - limits :]
    vital |= {f"condition {i + 1}": c.value for i, c in enumerate(conditions)}
    same = _invariant(model, vital | graph.seen, left)
    for what in vital:
        if not same[what]:
            raise ParameterError(
                f"the {what} changes with {', '.join(left)}, so not all of these are ignorable; "
                "leave out what the equations contain."
            )
    seen = {n: e for n, e in graph.seen.items() if same[n] or n.startswith("pivot_")}
    places = model.q[[model.coordinates.index(n) for n in left]]
    kept = replace(graph, seen=seen, rates={s: graph.rates[s] for s in states})
    return kept.replaced(places, ca.SX.zeros(*places.shape))
