"""Families of steady motions: states held, states solved for, and the root-finder."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Any

import casadi as ca
import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..algebra.polynomial import ExactPolynomial
from ..algebra.program import entries
from ..algebra.upright import Upright
from ..base.checks import broadcast, instance, rows
from ..base.errors import (
    DomainError,
    NoMemberError,
    ParameterError,
    StabilityError,
    listed,
    listing,
    shown,
)
from ..base.types import Floats, Record, fields_of
from .closed_form import ClosedForm
from .equations import Equations
from .graph.family_graph import FamilyGraph, Frame
from .graph.ignorable import acting_on, hidden_pairs, ignorable, turned
from .graph.smoothness import KINKED, REMOVABLE, edged, gap, sloped
from .members import UNKNOWN, Anchor, FamilyRoots, check_states, find, given_noise, rate_noise
from .sources.numeric import NumericSystem, numeric_checked, numeric_search, numeric_states
from .system_checks import check_family


@dataclass(frozen=True, eq=False, repr=False)
class Family(Record):
    """A family of steady motions of a `System`, named by one or more parameters `at`.

    Every state is either named in `at`, held at a value, or solved for.  A member is a root of the
    rates of the states in `equations`; `member` checks that the other rates vanish too.  Ignorable
    states (`System.ignorable`, such as a heading) may be left out, and then need not rest.

    Parameters
    ----------
    system
        The equations of motion.
    name
        Name of the family in messages and files.
    at
        Names of the states (or of parameters of the system) that name a member.  Empty for the
        one member of a system without parameters that stands alone.
    held
        Values of the states that are the same along the family; `UPRIGHT` for the exact π/2.
    unknown
        First guesses of the states, and parameters, that are solved for.
    equations
        States whose rates must vanish, or observables that must, as many as there are unknowns.
    positive
        Unknowns that must be positive.
    typical
        Typical sizes by name of `at` and parameters (1 where left out).  The spectrum's structure
        is sampled near these sizes.
    conservative
        Whether the reduced characteristic polynomial is even in λ by structure.
    integrals
        Whether first integrals make a spectrally neutral member stable.
    drifts
        Whether a slow flow on the centre manifold carries a stable member to its threshold.
    exact
        The characteristic polynomial, or None.  Verdicts are proved from a known polynomial.
    anchor
        A known member from which the others are followed, in place of a first guess; or None.
    formulas
        Unknowns and characteristic polynomial in closed form, or None.

    Raises
    ------
    NameUnknownError, ParameterError
        If names do not fit the system.

    Source: physics of the disk's families in tests/bodies/test_families.py.

    Examples
    --------
    >>> import casadi as ca, stability as st
    >>> x, p = ca.SX.sym("x", 2), ca.SX.sym("p")
    >>> pendulum = st.System("pendulum", x, p, ca.vertcat(x[1], -p * ca.sin(x[0])),
    ...                   states=("angle", "rate"), parameters=("g",))
    >>> hanging = st.Family(pendulum, "hanging", at=("g",), held={"angle": 0, "rate": 0})
    >>> hanging.member([9.81], [])
    array([0., 0.])
    """

    system: Equations
    """The equations of motion."""
    name: str
    """Name of the family in messages and files."""
    at: tuple[str, ...]
    """Names of the states or parameters that name a member."""
    held: Mapping[str, float | Upright] = field(default_factory=dict)
    """Values of the states that do not change along the family."""
    unknown: Mapping[str, float] = field(default_factory=dict)
    """First guesses of the states solved for."""
    equations: tuple[str, ...] = ()
    """States whose rates must vanish, and observables that must vanish."""
    positive: tuple[str, ...] = ()
    """Unknowns that must be positive."""
    typical: Mapping[str, float] = field(default_factory=dict)
    """Typical sizes by name."""
    conservative: bool = False
    """Whether the reduced characteristic polynomial is even in λ."""
    integrals: bool = False
    """Whether first integrals make a neutral member stable."""
    drifts: bool = False
    """Whether a slow flow on the centre manifold carries a stable member to its threshold."""
    exact: ExactPolynomial | None = None
    """The characteristic polynomial, or None where it is not known."""
    anchor: Anchor | None = None
    """A known member, from which the others are followed; `System.steady` finds it."""
    formulas: ClosedForm | None = None
    """Unknowns and characteristic polynomial in closed form, or None."""

    __getstate__ = fields_of

    def meaning(self, name: str) -> str:
        """The name of a number; `at` is the one that names a member.

        Parameters
        ----------
        name
            A name as a caller gave it.
        """
        plain = name != "at" or len(self.at) != 1 or name in self.parameters
        return name if plain else self.at[0]

    def _content(self) -> tuple[Any, ...]:
        return (*super()._content(), tuple(self.unknown))  # their order is that of the guesses

    def __hash__(self) -> int:
        return self._hash

    @cached_property
    def _hash(self) -> int:
        # with one hash for two bodies, each look-up in a cache would compare all their content
        return hash(self._content())

    def __repr__(self) -> str:
        named = f", named by {', '.join(self.at)}" if self.at else ""
        return f"<Family {self.name} of {self.system.name}{named}>"

    def __post_init__(self) -> None:
        instance("system", self.system, Equations, "give a stability.System")
        check_family(self)
        if self.anchor is not None:
            instance("anchor", self.anchor, Anchor, "take the family from System.steady")
        check_states(self)
        if self.trimmed and isinstance(self.system, NumericSystem):
            raise ParameterError(self.system.no_graph)
        for state in self.left_out:
            other = acting_on(self.system, state, self.named)
            if other:
                raise ParameterError(
                    f"family {self.name} leaves {state} out, but the rate of {other} depends on "
                    f"it; leave {other} out too, or give {state}."
                )

    @property
    def parameters(self) -> tuple[str, ...]:
        """Names of the system's parameters that the family neither names nor solves for."""
        return tuple(n for n in self.system.parameters if n not in (*self.at, *self.unknown))

    @property
    def trimmed(self) -> tuple[str, ...]:
        """Names of the system's parameters that are solved for."""
        return tuple(n for n in self.unknown if n in self.system.parameters)

    @property
    def named(self) -> tuple[str, ...]:
        """Names of the states that are given: held, solved for, or in `at`."""
        names = *self.held, *self.unknown, *self.at
        return tuple(n for n in names if n in self.system.states)

    # --- states that may move ---

    @cached_property
    def left_out(self) -> tuple[str, ...]:
        """Ignorable states that the family does not name; each acts only on those before it.

        Their values do not matter, and their rates need not vanish.
        """
        names = {*self.held, *self.unknown, *self.at}
        if names.issuperset(self.system.states):
            return ()
        return tuple(n for n in ignorable(self.system) if n not in names)

    @cached_property
    def resting(self) -> tuple[int, ...]:
        """Positions of the states whose rates vanish at a steady motion."""
        return tuple(i for i, n in enumerate(self.system.states) if n not in self.left_out)

    @property
    def idle(self) -> tuple[str, ...]:
        """States that the linearisation does not act on: left out, or algebraic variables."""
        return (*self.left_out, *self.system.algebraic)

    @cached_property
    def kept(self) -> tuple[int, ...]:
        """Positions of the other states."""
        return tuple(i for i, n in enumerate(self.system.states) if n not in self.idle)

    @property
    def fixed(self) -> dict[str, float | Upright]:
        """Values of the states that the family fixes: those held, and 0 for those left out."""
        return {**self.held, **dict.fromkeys(self.left_out, 0.0)}

    @cached_property
    def judged(self) -> Equations:
        """The system, in which no state is turned that the family leaves out."""
        system = self.system
        if not self.left_out or set(turned(system)).isdisjoint(self.left_out):
            return system
        rates = [0 if n in self.left_out else system.rhs[i] for i, n in enumerate(system.states)]
        return replace(system, rhs=ca.vertcat(*rates), mass=None, forcing=None, unknowns=())

    # --- the graph at the family ---

    @cached_property
    def graph(self) -> FamilyGraph:
        """The system's graph read at this family; built at first use."""
        return FamilyGraph(self._frame())

    def _frame(self, *, decimals: bool = False) -> Frame:
        zero = hidden_pairs(self.system, self.left_out) if self.left_out else ()
        parts = self.judged, self.at, self.fixed, self.unknown, self.equations, zero
        return Frame(*parts, decimals)

    @property
    def closed(self) -> bool:
        """Whether the first guess solves the equations identically, without iteration."""
        return self.graph.closed

    @property
    def tangents(self) -> int:
        """Number of independent directions along the family in the state."""
        return len(self.moved)

    @cached_property
    def moved(self) -> tuple[int, ...]:
        """Places in `at` of the states along which other members have the same parameters."""
        states = tuple(i for i, name in enumerate(self.at) if name in self.system.states)
        return () if self.trimmed else states  # what is solved for changes with these states

    def member(
        self, at: ArrayLike, parameters: ArrayLike, guess: ArrayLike | None = None
    ) -> Floats:
        """States of the steady motions, by CasADi's root-finder where unknowns are solved for.

        Parameters
        ----------
        at
            Family parameters, last axis as named in `at`, shape (…, len(at)).
        parameters
            The system's other parameters, shape (…, m).
        guess
            First guess of the unknowns, shape (…, u); the family's guess when left out.

        Returns
        -------
        ndarray
            States, shape (…, n).

        Raises
        ------
        NoMemberError
            If there is no such motion, or the root-finder did not reach it.
        DomainError
            If the equations have no meaning there.
        """
        a, q, shape = self._inputs(at, parameters)
        return self.checked_states(a, self.solve(a, q, guess), q).reshape(*shape, -1)

    def checked_states(self, a: Floats, u: Floats, q: Floats) -> Floats:
        """States of members whose unknowns are known; members that are not steady are refused.

        Parameters
        ----------
        a, u, q
            Family parameters, unknowns (from `solve`) and parameters, shapes (N, ·).

        Returns
        -------
        ndarray
            Shape (N, n).

        Raises
        ------
        NoMemberError
            If a rate does not vanish.
        DomainError
            If the equations have no meaning there.
        """
        a, u, q = tables(self, a, q, u)
        if isinstance(self.system, NumericSystem):
            return numeric_checked(self, a, u, q)
        states = self.states(a, u, q)
        parameters = self._system_parameters(a, u, q)
        self.system.check(states, parameters)
        if not (fine := self._determined(a, u, q)).all():
            i = int(np.argmin(fine))
            raise DomainError(self._undetermined(a[i], q[i]))
        try:
            require_steady(self, a, u, q, states)
            # a factor zero folds away in the family's graph, which may hide an overflow
            self.system.rates(states, parameters, checked=True)
        except StabilityError:
            row = gap(self.system, states, parameters)
            if row is None:
                raise
            raise DomainError(f"{self._place(a[row], q[row])}: {REMOVABLE}") from None
        if self._has_kinks and not (fine := sloped(self.system, states, parameters)).all():
            i = int(np.argmin(fine))
            raise DomainError(self._kinked(a[i], q[i]))
        return states

    @cached_property
    def _has_kinks(self) -> bool:
        return edged(self.system)

    def _place(self, a: Floats, q: Floats) -> str:
        return f"{self.name} at {listing((*self.at, *self.parameters), (*a, *q))}"

    def _kinked(self, a: Floats, q: Floats) -> str:
        return f"{self._place(a, q)}: the rates of {self.system.name} {KINKED}"

    def _determined(self, a: Floats, u: Floats, q: Floats) -> NDArray[np.bool_]:
        """Whether algebraic equations determine their variables to first order."""
        if not self.system.algebraic:
            return np.ones(len(a), dtype=bool)
        arguments = [entries(a), entries(u), entries(q)]
        determinants = self.graph.determinant.arrays(arguments, a.shape[:1])[0][..., 0, 0]
        return np.asarray(np.isfinite(determinants) & (determinants != 0))

    def _undetermined(self, a: Floats, q: Floats) -> str:
        return (
            f"{self._place(a, q)}: the algebraic equations of {self.system.name} do not determine "
            f"{listed(self.system.algebraic)} to first order, since det ∂g/∂y is 0 there (an index "
            "above 1, or a singularity-induced point); take a member next to it."
        )

    def matrix(self, a: Floats, u: Floats, q: Floats) -> Floats:
        """Linearisation ∂f/∂x at members.

        Parameters
        ----------
        a, u, q
            Family parameters, unknowns (from `solve`) and parameters, shapes (N, ·).

        Returns
        -------
        ndarray
            Shape (N, n, n).
        """
        a, u, q = tables(self, a, q, u)
        out: Floats = self.graph.matrix.arrays([entries(a), entries(u), entries(q)], a.shape[:1])[0]
        return out

    def tangent(self, a: Floats, u: Floats, q: Floats) -> Floats:
        """Directions along the family in the state, by the implicit function theorem.

        Parameters
        ----------
        a, u, q
            As in `matrix`.

        Returns
        -------
        ndarray
            Shape (N, n, t) with t = `tangents`.
        """
        a, u, q = tables(self, a, q, u)
        arguments = [entries(a), entries(u), entries(q)]
        by_a, by_u, _, r_u, r_a = self.graph.tangent.arrays(arguments, a.shape[:1])
        if u.shape[1] and not self.closed:
            by_a = by_a - by_u @ np.linalg.solve(r_u, r_a)
        out: Floats = by_a[..., list(self.moved)]
        return out

    def solve(self, a: Floats, q: Floats, guess: ArrayLike | None = None) -> Floats:
        """The unknowns at each row of family parameters.

        Parameters
        ----------
        a, q
            Family parameters and parameters, shapes (N, ·).
        guess
            First guess of the unknowns, shape (…, u), or None.

        Returns
        -------
        ndarray
            Shape (N, u).

        Raises
        ------
        NoMemberError
            If the root-finder does not converge to an admissible root.
        """
        a, _, q = tables(self, a, q)
        roots = self.search(a, q, guess)
        if not roots.good.all():
            raise NoMemberError(roots.why(int(np.argmin(roots.good))))
        return roots.u

    def search(self, a: Floats, q: Floats, guess: ArrayLike | None = None) -> FamilyRoots:
        """The unknowns at each row, and the rows without a member.

        Parameters
        ----------
        a, q, guess
            As in `solve`.

        Returns
        -------
        FamilyRoots
        """
        a, _, q = tables(self, a, q)
        if isinstance(self.system, NumericSystem):
            return numeric_search(self, a, q, guess)
        possible, why = self._possible(a, q)
        first = np.array(list(self.unknown.values()))
        u = np.tile(first, (len(a), 1))
        if not possible.any() or not self.unknown or (self.closed and guess is None):
            return FamilyRoots(u, possible, why)
        if self.graph.finder is None:
            raise ParameterError(
                f"{self.name}: the equations {', '.join(self.equations)} leave the unknowns "
                f"{', '.join(self.unknown)} open for all numbers; give others, or hold "
                "what is free."
            )
        if guess is not None:
            first = rows("guess", guess, list(self.unknown)).reshape(-1, len(first))
            if len(first) not in (1, len(a)):
                raise ParameterError(f"guess has {len(first)} rows for {len(a)} members.")
        start = np.broadcast_to(first, u.shape)[possible]
        followed = self.anchor is not None and guess is None
        roots = find(self, a[possible], q[possible], None if followed else start)
        u[possible], good, place = roots.u, possible.copy(), np.cumsum(possible) - 1
        good[possible] = roots.good
        return FamilyRoots(
            u, good, lambda row: roots.why(place[row]) if possible[row] else why(row)
        )

    def members(self, a: Floats, q: Floats) -> FamilyRoots:
        """As `search`; a root at which the rates have no value or no slope is no member either.

        Parameters
        ----------
        a, q
            As in `solve`.

        Returns
        -------
        FamilyRoots
        """
        roots = self.search(a, q)
        if isinstance(self.system, NumericSystem):
            return roots
        good = roots.good.copy()
        a_, u_, q_ = a[good], roots.u[good], q[good]
        place = self.states(a_, u_, q_), self._system_parameters(a_, u_, q_)
        good[good] = self.system.valid(*place)
        valid = good.copy()
        determined = np.ones(len(a), dtype=bool)
        determined[roots.good] = self._determined(a_, u_, q_)
        good[roots.good] &= sloped(self.system, *place)
        good &= determined

        def why(row: int) -> str:
            if not determined[row]:
                return self._undetermined(a[row], q[row])
            if valid[row]:
                return self._kinked(a[row], q[row])
            place = listing((*self.at, *self.parameters), (*a[row], *q[row]))
            no = f"{self.name} has no member at {place}: a condition of {self.system.name} fails."
            return no if roots.good[row] else roots.why(row)

        return FamilyRoots(roots.u, good, why)

    def states(self, a: Floats, u: Floats, q: Floats) -> Floats:
        """States of members whose unknowns are known.

        Parameters
        ----------
        a, u, q
            Family parameters, unknowns (from `solve`) and parameters, shapes (N, ·).

        Returns
        -------
        ndarray
            Shape (N, n).
        """
        a, u, q = tables(self, a, q, u)
        if isinstance(self.system, NumericSystem):
            return numeric_states(self, a, u)
        arguments = [entries(a), entries(u), entries(q)]
        out: Floats = self.graph.state.arrays(arguments, a.shape[:1])[0][..., 0]
        return out

    def _possible(self, a: Floats, q: Floats) -> tuple[NDArray[np.bool_], Callable[[int], str]]:
        """Rows at which the equations have a meaning for some root, and why others have none."""
        conditions, program = self.graph.early
        none = [np.zeros(1)] * len(self.unknown)
        arguments = [entries(a), none, entries(q)]
        values = program.arrays(arguments, a.shape[:1]) if conditions else []
        fine = np.array([v.reshape(-1) > 0 for v in values]).reshape(-1, len(a))

        def why(row: int) -> str:
            which = int(np.argmin(fine[:, row]))
            reason = conditions[which].refusal(float(values[which][row].flat[0]))
            return f"{self.name} does not exist there: {reason}"

        return np.asarray(fine.all(axis=0)), why

    # --- inputs ---

    def _inputs(
        self, at: ArrayLike, parameters: ArrayLike
    ) -> tuple[Floats, Floats, tuple[int, ...]]:
        a = rows("at", at, self.at)
        q = rows("parameters", parameters, self.parameters)
        shape = broadcast(at=a.shape[:-1], parameters=q.shape[:-1])
        count = math.prod(shape)
        a = np.broadcast_to(a, (*shape, len(self.at))).reshape(count, len(self.at))
        q = np.broadcast_to(q, (*shape, len(self.parameters))).reshape(count, len(self.parameters))
        return a, q, shape

    def _system_parameters(self, a: Floats, u: Floats, q: Floats) -> Floats:
        blocks = (self.at, a), (self.unknown, u), (self.parameters, q)
        table = {n: v for names, block in blocks for n, v in zip(names, block.T, strict=True)}
        columns = [table[n] for n in self.system.parameters]
        return np.column_stack(columns) if columns else np.zeros((len(a), 0))


def tables(family: Any, a: Any, q: Any, u: Any = None) -> tuple[Floats, Floats, Floats]:
    """Family parameters, unknowns and parameters as tables (N, ·); fitting arrays stay unchanged.

    Parameters
    ----------
    family
        The `Family`.
    a, q, u
        Family parameters, parameters, and unknowns or None.

    Returns
    -------
    a, u, q

    Raises
    ------
    ParameterError
        If an entry is no number, or the count of columns or rows does not fit.
    """
    wanted = family.at, tuple(family.unknown), family.parameters
    if u is None and type(a) is np.ndarray:
        u = np.zeros((a.shape[0] if a.ndim else 1, len(wanted[1])))
    arrays = a, u, q
    if all(
        type(t) is np.ndarray
        and t.dtype == float
        and t.ndim == 2
        and t.shape == (a.shape[0], len(its))
        and np.isfinite(t).all()
        for t, its in zip(arrays, wanted, strict=True)
    ):
        return a, u, q
    first = rows("a", a, family.at).reshape(-1, len(family.at))
    columns = [first]
    for what, table, its in zip("uq", arrays[1:], wanted[1:], strict=True):
        empty = not its or (what == "u" and u is None)
        numbers = np.zeros((len(first), len(its))) if empty else rows(what, table, its)
        columns.append(numbers.reshape(-1, len(its)) if its else numbers)
    if len({len(t) for t in columns}) > 1:
        listed = ", ".join(str(t.shape) for t in columns)
        raise ParameterError(f"a, u and q have shapes {listed}; give as many rows of each.")
    return columns[0], columns[1], columns[2]


def require_steady(family: Any, a: Floats, u: Floats, q: Floats, states: Floats) -> None:
    """Refuse members at which a rate does not vanish within its rounding.

    Parameters
    ----------
    family
        A `Family`.
    a, u, q
        Family parameters, unknowns and parameters, shapes (N, ·).
    states
        States of the members, shape (N, n).

    Raises
    ------
    NoMemberError
        If a rate does not vanish, or has no value.
    """
    arguments = [list(block.T) for block in (a, u, q)]
    rates = family.graph.rates.arrays(arguments, a.shape[:1])[0][..., 0]
    rates[:, [family.system.index(n) for n in family.left_out]] = 0.0
    if not rates.any():
        return
    with np.errstate(all="ignore"):
        matrix = family.matrix(a, u, q)
        size = np.abs(matrix).max(axis=(1, 2))
        scale = 1 + size * (1 + np.abs(u).max(axis=1, initial=0))
    if not (np.isfinite(rates).all() and np.isfinite(scale).all()):
        raise NoMemberError(
            f"{family.name}: the rates have no value there, such as the sign of 0, or overflow "
            "double precision; give values nearer to 1."
        )
    if (np.abs(rates) <= given_noise(states, matrix)).all():  # nothing else has to be counted
        return
    bound = rate_noise(family.graph, a, u, q, states, matrix)
    bound = np.where(np.isfinite(bound), bound, UNKNOWN * scale[:, None])
    over = ~(np.abs(rates) <= bound)
    if over.any():
        row = int(np.argmax(over.any(axis=1)))
        which = int(np.argmax(np.where(over[row], np.abs(rates[row]), -1.0)))
        state = family.system.states[which]
        off = f"{state} still changes at"
        if state in family.system.algebraic:
            off = f"the algebraic equation of {state} is off by"
        raise NoMemberError(
            f"{family.name} at {listing(family.at, a[row])} is not steady: "
            f"{off} {abs(rates[row, which]):.3g}, and "
            f"rounding accounts for {bound[row, which]:.1g} of that at most; "
            f"{_remedy(family.system, state)}."
        )


def _remedy(system: Any, state: str) -> str:
    if state in ignorable(system):
        return "it is ignorable, so leave it out of the family"
    what = state if state in system.algebraic else "its rate"
    return f"add {what} to the family's equations, or give what is held to all its digits"


A_FAMILY = "give a stability.Family: system.steady(at, guess={…}), disk_family(…), body.family(…)"
"""What a call accepts that needs a family, in its refusal."""


def refuse_system(family: Any) -> None:
    """Refuse equations of motion where one of their families of steady motions is needed.

    Parameters
    ----------
    family
        What the user gave as a family.
    """
    if isinstance(family, Equations):
        raise ParameterError(
            f"family is the system {shown(family.name)}; give a family of its steady motions: "
            "system.steady(at, guess={…}) finds one, stability.Family names one."
        )
