"""Numeric systems: a plain Python function of numbers, without a graph and so without proofs.

Members of their families come from Newton's method with slopes by differences, each from the
family's first guess.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any, NamedTuple

import casadi as ca
import numpy as np
from numpy.typing import ArrayLike

from ...algebra.running_error import UNIT
from ...algebra.upright import Upright
from ...base.checks import rows
from ...base.errors import (
    DomainError,
    NoMemberError,
    ParameterError,
    StabilityError,
    listing,
    shown,
)
from ...base.types import Floats, content
from ..equations import Equations
from ..members import FamilyRoots
from ..system_checks import check_names

LEVELS = 12
"""Number of step sizes, each half of the one before."""
STEP = 0.05
"""First step over 1 or the state's size."""
SAFETY = 8.0
"""Factor on the estimated error of a derivative."""
SECOND = 0.71
"""First step of the second estimate over that of the first."""
NEWTON_STEP = 6e-6
"""Step of the slopes in Newton's method over 1 or the state's size: the third root of rounding."""
MOST_STEPS = 50
"""Largest number of Newton steps."""
STEADY = 1e-10
"""Largest rate that counts as zero, in units of the linearisation."""
KINK = 0.7
"""Least ratio of neighbouring second differences over their steps, where there is a kink."""

Rates = Callable[[Floats, Floats], Any]


class Derivative(NamedTuple):
    """A numerical derivative."""

    value: Floats
    """∂f/∂x, shape (n, n)."""
    error: Floats
    """Estimated error of each entry; an estimate, not a bound."""


class NumericSystem(Equations):
    """Equations of motion as a Python function of arrays: answers by floats, without proofs.

    Parameters
    ----------
    name
        Name of the system.
    function
        f(x, p) → rates, arrays of shape (n,), (m,) and (n,).
    states, parameters
        Names of the entries of x and p.
    units
        SI unit by name.
    """

    def __init__(
        self,
        name: str,
        function: Rates,
        states: Sequence[str],
        parameters: Sequence[str] = (),
        units: Mapping[str, str] | None = None,
    ) -> None:
        checked = check_names(name, states, parameters, units or {})
        for what, value in (checked | {"_call": function}).items():
            object.__setattr__(self, what, value)
        for what in ("observables", "quantities"):
            object.__setattr__(self, what, {})

    def __getstate__(self) -> dict[str, Any]:
        return dict(self.__dict__)

    def _content(self) -> tuple[Any, ...]:
        parts = (self.name, self.states, self.parameters, self.units, self.__dict__["_call"])
        return (type(self), content(parts))

    @property
    def no_graph(self) -> str:
        """The sentence of every refusal."""
        return (
            f"{self.name} is a numeric system: a Python function gives numbers and no graph, so "
            "nothing about it can be proved; ask for spectrum, boundaries, stability_map or "
            "simulate by floats, or write the equations in CasADi or SymPy for more."
        )

    @property
    def x(self) -> ca.SX:
        """There is none."""
        raise ParameterError(self.no_graph)

    @property
    def p(self) -> ca.SX:
        """There is none."""
        raise ParameterError(self.no_graph)

    @property
    def rhs(self) -> ca.SX:
        """There is none."""
        raise ParameterError(self.no_graph)

    @property
    def ignorable(self) -> tuple[str, ...]:
        """They are found from a graph, and there is none."""
        raise ParameterError(self.no_graph)

    def steady(self, *_: Any, **__: Any) -> Any:
        """A family is found from a graph, and there is none."""
        raise ParameterError(self.no_graph)

    def equilibria(self, *_: Any, **__: Any) -> Any:
        """A box is searched by a graph, and there is none."""
        raise ParameterError(self.no_graph)

    def check(self, x: ArrayLike, p: ArrayLike) -> None:
        """Nothing to check before the call."""

    def rates(self, x: ArrayLike, p: ArrayLike, *, checked: bool = False) -> Floats:  # noqa: ARG002
        """Rates of the states, as for `Equations.rates`; one call for each row."""
        xs, ps = rows("x", x, self.states), rows("p", p, self.parameters)
        shape = np.broadcast_shapes(xs.shape[:-1], ps.shape[:-1])
        xs = np.broadcast_to(xs, (*shape, xs.shape[-1])).reshape(-1, xs.shape[-1])
        ps = np.broadcast_to(ps, (*shape, ps.shape[-1])).reshape(len(xs), ps.shape[-1])
        values = np.array([self.call(a, b) for a, b in zip(xs, ps, strict=True)])
        return values.reshape(*shape, -1)

    def linearise(self, x: ArrayLike, p: ArrayLike) -> Floats:
        """The Jacobian by finite differences, as for `Equations.linearise`, at one state."""
        xs, ps = rows("x", x, self.states), rows("p", p, self.parameters)
        if xs.ndim > 1 or ps.ndim > 1:
            raise ParameterError("a numeric system is linearised at one state at a time.")
        return self.derivative(xs, ps).value

    def slopes(self, x: Floats, p: Floats) -> Floats:
        """∂f/∂x by central differences of one step, to about ten digits, shape (n, n)."""
        up, down, width = self._both_sides(x, p, NEWTON_STEP * np.maximum(1.0, np.abs(x))[None])
        slopes: Floats = ((up - down) / width)[0].T
        return slopes

    def call(self, x: Floats, p: Floats) -> Floats:
        """The user's function at one state, checked.

        Parameters
        ----------
        x, p
            State and parameters, shapes (n,) and (m,).
        """
        function: Rates = self.__dict__["_call"]
        try:
            with np.errstate(all="ignore"):
                returned = np.asarray(function(x.copy(), p.copy()))
                if np.iscomplexobj(returned):
                    raise TypeError("its rates are complex")
                values = returned.astype(float).reshape(-1)
        except Exception as error:  # a user's code may raise anything
            raise ParameterError(
                f"the function of {self.name} fails at x = {shown(x.tolist())} "
                f"({type(error).__name__}: {error}); give f(x, p) → rates."
            ) from None
        if len(values) != len(self.states):
            raise ParameterError(
                f"the function of {self.name} returns {len(values)} rates for {len(self.states)} "
                "states; give one each."
            )
        if not np.isfinite(values).all():
            raise DomainError(
                f"{self.name}: the rates at x = {shown(x.tolist())} are not finite; give another "
                "state."
            )
        return values

    def derivative(self, x: Floats, p: Floats) -> Derivative:
        """∂f/∂x by central differences, extrapolated to step zero, with an estimate of its error.

        Two estimates from different steps must agree; their difference enters the error.

        Parameters
        ----------
        x, p
            State and parameters, shapes (n,) and (m,).

        Raises
        ------
        DomainError
            If a second difference does not shrink with the step: the function has a kink there.

        Source: C. J. F. Ridders, Adv. Eng. Software 4 (1982) 75-76.

        Examples
        --------
        >>> swing = NumericSystem("swing", lambda x, p: [x[1], -p[0] * np.sin(x[0])], ("q", "v"),
        ...                       ("g",))
        >>> swing.derivative(np.zeros(2), np.array([9.81])).value.round(9)
        array([[ 0.  ,  1.  ],
               [-9.81,  0.  ]])
        """
        here = self.call(x, p)
        # one table for both estimates and all columns: axes are (estimate, column, rate)
        shares = np.array([STEP, STEP * SECOND])[:, None]
        steps = shares * np.maximum(1.0, np.abs(x))
        best = np.zeros((*steps.shape, len(here)))
        doubt = np.full_like(best, np.inf)
        row: list[Floats] = []
        bends, noises = [], []
        for level in range(LEVELS):
            up, down, width = self._both_sides(x, p, steps / 2**level)
            size = np.maximum(np.maximum(np.abs(up), np.abs(down)), np.abs(here))
            noise = 8 * UNIT * size / width
            new = [(up - down) / width]
            bends.append(np.abs(up - 2 * here + down) / width)
            noises.append(noise)
            for k, old in enumerate(row, 1):
                new.append(new[k - 1] + (new[k - 1] - old) / (4.0**k - 1))
                spread = np.maximum(np.abs(new[k] - new[k - 1]), np.abs(new[k] - old)) + noise
                better = spread < doubt
                best, doubt = np.where(better, new[k], best), np.where(better, spread, doubt)
            row = new
        self._smooth(np.array(bends[-4:]), np.array(noises[-4:]))
        error = np.maximum(doubt.max(axis=0), np.abs(best[0] - best[1]))
        value = np.where(doubt[0] <= doubt[1], best[0], best[1])
        return Derivative(value.T, SAFETY * error.T)

    def _both_sides(self, x: Floats, p: Floats, steps: Floats) -> tuple[Floats, Floats, Floats]:
        """Rates above and below, shape (estimate, column, rate), and the widths between."""
        high, low = (x + sign * steps[..., None] * np.eye(len(x)) for sign in (1.0, -1.0))
        width = np.diagonal(high - low, axis1=1, axis2=2)[..., None]
        up, down = (
            np.array([[self.call(y, p) for y in some] for some in side]) for side in (high, low)
        )
        return up, down, width

    def _smooth(self, bends: Floats, noises: Floats) -> None:
        """Refuse a kink: the second difference over the step stays where it should halve."""
        above = (bends > 8 * noises).all(axis=0)  # below, noise outweighs the curvature
        ratio = (bends[1:] > KINK * bends[:-1]) & (KINK * bends[1:] < bends[:-1])
        kinks = np.argwhere(above & ratio.all(axis=0))
        if len(kinks):
            raise DomainError(
                f"the function of {self.name} has a kink along {self.states[kinks[0, 1]]} at this "
                "state, so it has no linearisation there; give a smooth function or another state."
            )


# --- members of a family ---


def numeric_search(
    family: Any, a: Floats, q: Floats, guess: ArrayLike | None = None
) -> FamilyRoots:
    """The unknowns at each row, as `Family.search`, and the rows without a steady motion.

    Parameters
    ----------
    family
        A `Family` of a numeric system.
    a, q, guess
        As for `Family.search`.
    """
    first = np.array([list(family.unknown.values())] if guess is None else guess, dtype=float)
    u = np.zeros((len(a), len(family.unknown)))
    good, why = np.zeros(len(a), dtype=bool), [""] * len(a)
    for row, start in enumerate(np.broadcast_to(first, u.shape)):
        numbers = a[row : row + 1], q[row : row + 1]
        try:
            u[row] = _solved(family, numbers, start)
            numeric_checked(family, numbers[0], u[row : row + 1], numbers[1])
            good[row] = True
        except StabilityError as error:
            why[row] = str(error)
    return FamilyRoots(u, good, lambda row: why[row])


def numeric_states(family: Any, a: Floats, u: Floats) -> Floats:
    """States of members, as `Family.states`."""
    values: dict[str, Any] = dict(zip(family.at, a.T, strict=True))
    values |= dict(zip(family.unknown, u.T, strict=True))
    values |= {n: np.pi / 2 if isinstance(v, Upright) else v for n, v in family.held.items()}
    return np.column_stack([np.broadcast_to(values[n], len(a)) for n in family.system.states])


def numeric_checked(family: Any, a: Floats, u: Floats, q: Floats) -> Floats:
    """States of members, as `Family.checked_states`.

    Raises
    ------
    NoMemberError
        If a rate does not vanish.
    """
    system: NumericSystem = family.system
    states, parameters = numeric_states(family, a, u), family._system_parameters(a, u, q)
    for row, (x, p) in enumerate(zip(states, parameters, strict=True)):
        rates = np.abs(system.call(x, p))
        if not rates.any():
            continue
        scale = 1 + np.abs(system.slopes(x, p)).max() * (1 + np.abs(x).max())
        if not (rates <= STEADY * scale).all():
            worst = int(rates.argmax())
            raise NoMemberError(
                f"{family.name} is not steady: {system.states[worst]} still changes at "
                f"{rates[worst]:.2g} at {_place(family, a[row], q[row])}; add its rate to the "
                "family's equations, or give what is held to all its digits."
            )
    return states


def _place(family: Any, a: Floats, q: Floats) -> str:
    return listing((*family.at, *family.parameters), (*a, *q))


def newton_step(family: Any, x: Floats, p: Floats, slopes: Floats) -> Floats:
    """Newton's step of the unknowns at a state, shape (u,)."""
    system: NumericSystem = family.system
    where, rows_ = ([system.index(n) for n in some] for some in (family.unknown, family.equations))
    step = np.linalg.solve(slopes[np.ix_(rows_, where)], system.call(x, p)[rows_])
    return np.asarray(-step)


def _solved(family: Any, numbers: tuple[Floats, Floats], first: Floats) -> Floats:
    """Newton's method on the unknowns of one member."""
    u, p = first.copy(), family._system_parameters(numbers[0], first[None], numbers[1])[0]
    before = np.inf
    for _ in range(MOST_STEPS):
        x = numeric_states(family, numbers[0], u[None])[0]
        try:
            step = newton_step(family, x, p, family.system.slopes(x, p))
        except np.linalg.LinAlgError:
            break
        size = float(np.abs(step).max(initial=0.0))
        done = size <= 1e-13 * (1 + np.abs(u).max(initial=0.0))
        if done or before / 2 <= size <= 1e-9:
            if all(u[list(family.unknown).index(n)] > 0 for n in family.positive):
                return u
            break
        u, before = u + step, size
    raise NoMemberError(
        f"{family.name} has no member that Newton's method reaches at "
        f"{_place(family, numbers[0][0], numbers[1][0])}; choose another point or another guess."
    )
