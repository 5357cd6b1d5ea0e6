"""Numeric systems: a plain Python function of numbers, without a graph and so without proofs."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any, NamedTuple

import casadi as ca
import numpy as np
from numpy.typing import ArrayLike

from ...algebra.running_error import UNIT
from ...base.checks import rows
from ...base.errors import DomainError, ParameterError, shown
from ...base.types import Floats, content
from ..equations import Equations
from ..system_checks import check_names

LEVELS = 12
"""Number of step sizes, each half of the one before."""
STEP = 0.05
"""First step over 1 or the state's size."""
SAFETY = 8.0
"""Factor on the estimated error of a derivative."""
SECOND = 0.71
"""First step of the second estimate over that of the first."""
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
    """Equations of motion as a Python function of arrays: spectra without proofs, and no more.

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
        own = (self.name, self.states, self.parameters, self.units, self.__dict__["_call"])
        return (type(self), content(own))

    @property
    def no_graph(self) -> str:
        """The sentence of every refusal."""
        return (
            f"{self.name} is a numeric system: a Python function gives numbers and no graph, so "
            "nothing about it can be proved; ask for its spectrum without certify, or write the "
            "equations in CasADi or SymPy."
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
        found = np.array([self.call(a, b) for a, b in zip(xs, ps, strict=True)])
        return found.reshape(*shape, -1)

    def linearise(self, x: ArrayLike, p: ArrayLike) -> Floats:
        """The Jacobian by finite differences, as for `Equations.linearise`, at one state."""
        xs, ps = rows("x", x, self.states), rows("p", p, self.parameters)
        if xs.ndim > 1 or ps.ndim > 1:
            raise ParameterError("a numeric system is linearised at one state at a time.")
        return self.derivative(xs, ps).value

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
                given = np.asarray(function(x.copy(), p.copy()))
                if np.iscomplexobj(given):
                    raise TypeError("its rates are complex")
                found = given.astype(float).reshape(-1)
        except Exception as error:  # a user's code may raise anything
            raise ParameterError(
                f"the function of {self.name} fails at x = {shown(x.tolist())} "
                f"({type(error).__name__}: {error}); give f(x, p) → rates."
            ) from None
        if len(found) != len(self.states):
            raise ParameterError(
                f"the function of {self.name} returns {len(found)} rates for {len(self.states)} "
                "states; give one each."
            )
        if not np.isfinite(found).all():
            raise DomainError(
                f"{self.name}: the rates at x = {shown(x.tolist())} are not finite; give another "
                "state."
            )
        return found

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
        columns = [self._column(x, p, j, here) for j in range(len(x))]
        return Derivative(*(np.stack(part, axis=1) for part in zip(*columns, strict=True)))

    def _column(self, x: Floats, p: Floats, j: int, here: Floats) -> tuple[Floats, Floats]:
        first, doubt = self._ridders(x, p, j, here, STEP)
        second, other = self._ridders(x, p, j, here, STEP * SECOND)
        apart = np.abs(first - second)
        value = np.where(doubt <= other, first, second)
        return value, SAFETY * np.maximum(np.maximum(doubt, other), apart)

    def _ridders(
        self, x: Floats, p: Floats, j: int, here: Floats, share: float
    ) -> tuple[Floats, Floats]:
        step = share * max(1.0, abs(float(x[j])))
        best, doubt = np.zeros_like(here), np.full_like(here, np.inf)
        row: list[Floats] = []
        bends: list[Floats] = []
        noises: list[Floats] = []
        for _ in range(LEVELS):
            high, low = x.copy(), x.copy()
            high[j], low[j] = x[j] + step, x[j] - step
            up, down = self.call(high, p), self.call(low, p)
            width = high[j] - low[j]
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
            step /= 2
        self._smooth(bends, noises, j)
        return best, doubt

    def _smooth(self, bends: list[Floats], noises: list[Floats], j: int) -> None:
        """Refuse a kink: the second difference over the step stays where it should halve."""
        last = np.array(bends[-4:])
        above = (last > 8 * np.array(noises[-4:])).all(axis=0)
        ratio = (last[1:] > KINK * last[:-1]) & (KINK * last[1:] < last[:-1])
        kept = ratio.all(axis=0)  # above: noise outweighs the curvature
        if (above & kept).any():
            raise DomainError(
                f"the function of {self.name} has a kink along {self.states[j]} at this "
                "state, so it has no linearisation there; give a smooth function or another state."
            )
