"""Slow drift along a family under a small disturbance, such as rolling resistance or air drag.

The undisturbed system has a family of steady motions x(y), and the disturbance enters with a small
coefficient ε.  Where the eigenvalues that are not zero by structure lie on the left, motions stay
near the family and y obeys dy/dt = ε ℓ·∂f/∂ε / (ℓ·dx/dy) + O(ε²), with the left null vector ℓ of
the linearisation (Fenichel, J. Differ. Equ. 31 (1979) 53-98).  The graph gives every factor.
tests/boundary/test_slow_flow.py compares with integrated motions and finds the order in ε.
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Any

import casadi as ca
import numpy as np
from numpy.typing import ArrayLike
from scipy.integrate import quad

from ..algebra.program import Program
from ..base.checks import one_number, real_numbers
from ..base.citation import cited
from ..base.errors import NameUnknownError, NoMemberError, ParameterError, shown
from ..base.types import Floats, Record, fields_of
from ..bodies.contact_laws import Contact
from ..bodies.resistance import Resistance, resistances
from ..bodies.round_body.body import Body
from ..bodies.subject import subject_of
from ..spectra.problem import problem_of
from ..systems.equations import Condition, Equations
from ..systems.family import Family
from ..systems.structure.structural_zeros import structure
from ..systems.system import System

APART = 1e-7
"""Least ratio of the least nonzero singular value to the largest."""
ASIDE = 1e-6
"""Largest share of a drift across the family."""
STEPS = 6
"""Halvings of the distance to an end, for the exponent there."""


@dataclass(frozen=True, eq=False)
class SlowFlow(Record):
    """The drift dy/dt along a family, of first order in a small coefficient.

    Source: averaging to first order; simulations: tests/boundary/test_slow_flow.py.

    Examples
    --------
    >>> import stability as st
    >>> flow = st.slow_flow("rolling", body=st.Spheroid(0.5), contact=st.Viscous(0.3),
    ...                     resistance=st.RollingResistance(0.01))
    >>> [round(float(r), 6) for r in flow.rate([1.0, 2.0])]
    [-0.007143, -0.014286]
    """

    family: Family
    """The family without the disturbance."""
    disturbed: Equations
    """The equations with the coefficient as a parameter."""
    small: str
    """Name of the coefficient."""
    value: float
    """Value of the coefficient, with which the rates are multiplied."""
    numbers: dict[str, Any] = field(default_factory=dict)
    """The other parameters by name: numbers, or arrays of one for each member."""

    __getstate__ = fields_of

    @property
    def citation(self) -> str:
        """Keys of the works to cite, for `stability.citation`."""
        system = self.disturbed
        return cited(system=system.name, model=bool(system.quantities), theory=["fenichel1979"])

    @cached_property
    def _slope(self) -> Program:
        system = self.disturbed
        place = system.parameters.index(self.small)
        slope = ca.densify(ca.jacobian(system.rhs, system.p[place]))
        return Program(ca.Function("by_small", [system.x, system.p], [slope]))

    def push(self, x: Floats, table: dict[str, Any]) -> Floats:
        """Change of the rates with the coefficient at states (N, n) and parameters by name."""
        p = [table[n] for n in self.disturbed.parameters]
        out: Floats = self._slope.arrays([list(x.T), p], (len(x),))[0][..., 0]
        return out

    def rate(self, at: ArrayLike) -> Any:
        """Rate of drift of the numbers that name a member.

        Parameters
        ----------
        at
            Numbers that name members, any shape; for a family of several numbers these stand along
            the last axis.

        Returns
        -------
        ndarray or float
            dy/dt in units of `at` per second, shape of `at`.

        Raises
        ------
        NoMemberError
            If there is no member, its null vectors are not separated from the other directions, or
            the disturbance drives the motion across the family.
        """
        members, count = real_numbers("at", at), len(self.family.at)
        if not members.size:
            raise ParameterError("at is an empty array; at least one number is needed.")
        if count > 1 and members.shape[-1:] != (count,):
            raise ParameterError(
                f"at has shape {members.shape}; give {' and '.join(self.family.at)} along its last "
                "axis."
            )
        a = members.reshape(-1, count)
        table: dict[str, Any] = dict(zip(self.family.at, a.T, strict=True))
        sizes = self.numbers | {self.small: 0.0}
        table |= {n: np.broadcast_to(np.ravel(v), len(a)) for n, v in sizes.items()}
        q = np.array([table[n] for n in self.family.parameters]).reshape(-1, len(a)).T
        u = self.family.solve(a, q)
        x = self.family.states(a, u, q)
        matrix, tangent = self.family.matrix(a, u, q), self.family.tangent(a, u, q)[..., :count]
        push = self.push(x, table)
        rates = self.value * self._rates(a, matrix, tangent, push).reshape(members.shape)
        return rates if members.ndim else float(rates)

    def _rates(self, at: Floats, matrix: Floats, tangent: Floats, push: Floats) -> Floats:
        """dy/dt over the coefficient at members, shape of `at`."""
        zeros = structure(self.family).zeros
        left, sizes, right = np.linalg.svd(matrix)
        n = sizes.shape[-1]

        def refuse(bad: Any, why: str) -> None:
            if bad.any():
                names = zip(self.family.at, at[np.argmax(bad)], strict=True)
                member = ", ".join(f"{name} = {value:.6g}" for name, value in names)
                raise NoMemberError(f"{self.family.name} at {member} {why}")

        if zeros < n:
            refuse(
                sizes[:, n - zeros - 1] < APART * sizes[:, 0],
                "has a further eigenvalue near zero, so no drift is slow next to it.",
            )
        basis = right[:, n - zeros :].transpose(0, 2, 1)
        across = left[:, :, n - zeros :].transpose(0, 2, 1)
        pair = across @ basis
        refuse(
            np.linalg.cond(pair) > 1 / APART,
            "has zero eigenvalues in a Jordan block; none drifts.",
        )
        drift = (basis @ np.linalg.solve(pair, across @ push[..., None]))[..., 0]
        rates = (np.linalg.pinv(tangent) @ drift[..., None])[..., 0]
        off = np.linalg.norm(drift - (tangent @ rates[..., None])[..., 0], axis=-1)
        size, noise = np.linalg.norm(drift, axis=-1), 1e-13 * (1 + sizes[:, 0])
        refuse(
            off > np.maximum(ASIDE * size, noise),
            f"is driven across the family by {self.small}, not along it.",
        )
        return np.where((size > noise)[:, None], rates, 0.0)

    def time(self, start: float, end: float) -> float:
        """Time of the drift from one member to another, of first order in the coefficient.

        Parameters
        ----------
        start, end
            Numbers that name the members; the drift must lead from one to the other.

        Returns
        -------
        float
            Time [s].

        Raises
        ------
        ParameterError
            If the drift leads the other way, or vanishes in between.
        """
        self._one_number()
        start, end = one_number("start", start), one_number("end", end)
        rates = np.asarray(self.rate(np.linspace(start, end, 33)))
        if (rates * (end - start) <= 0).any():
            raise ParameterError(
                f"the drift at {self.family.at[0]} = {start:g} does not lead to {end:g}: its rate "
                f"goes from {rates[0]:.3g} to {rates[-1]:.3g}."
            )
        value, _ = quad(lambda y: 1 / self.rate(y), start, end, epsabs=0, epsrel=1e-10, limit=200)
        return float(value)

    def exponent(self, end: float, near: float) -> float:
        """Exponent p with which the rate vanishes at an end of the family, like |y - end|^p.

        Below 1 the end is reached in finite time, at 1 exponentially, above 1 algebraically.

        Parameters
        ----------
        end
            Value of the number that names a member, at which the drift ends.
        near
            A value on the side from which it is approached; the distance is halved from there.

        Returns
        -------
        float
            The exponent between the two nearest values.
        """
        self._one_number()
        end, near = one_number("end", end), one_number("near", near)
        if end == near:
            raise ParameterError(f"near is {near:g}, the end itself; give a number to one side.")
        gaps = (near - end) * 0.5 ** np.arange(STEPS)
        rates = np.abs(self.rate(end + gaps))
        if not (np.isfinite(rates) & (rates > 0)).all():
            raise ParameterError(
                f"the drift between {self.family.at[0]} = {end:g} and {near:g} has the rates "
                f"{', '.join(f'{r:.3g}' for r in rates[-2:])} near its end; an exponent needs "
                "rates other than 0."
            )
        return float(np.log2(rates[-2] / rates[-1]))

    def _one_number(self) -> None:
        """Refuse what has no meaning in a family of several numbers."""
        if len(self.family.at) != 1:
            raise ParameterError(
                f"{self.family.name} is named by {' and '.join(self.family.at)}; a drift has no "
                "single path there. Integrate its rate."
            )


def slow_flow(
    family: str | Family,
    *,
    body: Body | None = None,
    contact: Contact | str | None = None,
    resistance: Resistance | None = None,
    small: str | None = None,
    **parameters: Any,
) -> SlowFlow:
    """Slow drift along a family under a small disturbance.

    Parameters
    ----------
    family
        Name of a family of `body`, or a `Family` of a system that has the coefficient `small`.
    body, contact
        Body of revolution and contact law, for a family by name.
    resistance
        The disturbance of a body: one of `RollingResistance`, `PivotingResistance`, `AirTorque`.
    small
        For a `Family`: name of the coefficient that is 0 for the family; its value is one of the
        parameters.
    **parameters
        Further numbers by name.

    Returns
    -------
    SlowFlow
        The rate of drift at each member.

    Raises
    ------
    StabilityError
        If the arguments do not fit together.

    Source: the module's text; tests/boundary/test_slow_flow.py.

    Examples
    --------
    >>> import stability as st
    >>> tyre = st.Torus(0.2)
    >>> flow = st.slow_flow("rolling", body=tyre, contact="viscous", mu=1.0,
    ...                     resistance=st.AirTorque(0.001))
    >>> round(flow.time(2.0, 1.0) / flow.time(4.0, 2.0), 9)  # each halving takes as long
    1.0
    """
    arguments = dict(parameters)
    if isinstance(family, Family):
        if body is not None or resistance is not None or small is None:
            raise ParameterError(
                f"a Family needs small=, the name of its small parameter, and neither body nor "
                f"resistance; small is {shown(small)}."
            )
        if not isinstance(small, str) or small not in family.parameters:
            raise NameUnknownError(
                f"small is {shown(small)}; parameters of {family.name} are "
                f"{', '.join(family.parameters) or 'none'}."
            )
        value = one_number(small, arguments.pop(small, 1.0))
    else:
        against = _single_resistance(resistance)
        if small is not None:
            raise ParameterError(
                f"small is {shown(small)}; the small parameter of a body is {against.coefficient}, "
                "that of its resistance: leave small out."
            )
        small, value = against.coefficient, one_number(against.coefficient, against.value)
        none = type(against)(0.0)  # type: ignore[call-arg]  # every resistance has one field
        if body is None:
            raise ParameterError("body is missing; give a stability.Body.")
        arguments["resistance"] = none
    asked = subject_of(family, body=body, contact=contact, parameters=arguments)
    family = asked.family
    still = _still(family, small)
    arguments = {n: v for n, v in {**asked.numbers, **asked.member}.items() if n != small}
    problem = problem_of(subject_of(still, parameters=arguments))
    numbers = {n: one_number(n, v) for n, v in problem.values.items()}
    missing = [n for n in still.parameters if n not in numbers]
    if missing:
        raise NameUnknownError(f"{', '.join(missing)} of {family.name} is missing.")
    return SlowFlow(still, family.system, small, value, numbers)


def _single_resistance(argument: Any) -> Resistance:
    """The one resistance of a call."""
    laws = resistances(argument)
    if len(laws) != 1:
        what = f"names {len(laws)} of them" if laws else "is missing"
        raise ParameterError(f"resistance {what}; give one, such as RollingResistance(rho).")
    return laws[0]


def _still(family: Family, small: str) -> Family:
    """The family of the equations in which the coefficient is 0."""
    system = family.system
    system.refuse_algebraic("a slow flow")
    place = system.parameters.index(small)
    zero = [system.p[place]], [ca.SX(0)]

    def at_zero(value: Any) -> Any:
        return ca.substitute([value], *zero)[0]

    kept = [i for i in range(len(system.parameters)) if i != place]
    p = system.p[kept] if kept else ca.SX(0, 1)
    quiet = System(
        system.name,
        system.x,
        p,
        at_zero(system.rhs),
        states=system.states,
        parameters=tuple(system.parameters[i] for i in kept),
        observables={n: at_zero(v) for n, v in system.observables.items()},
        conditions=tuple(Condition(at_zero(c.value), c.sentence) for c in system.conditions),
        units={n: u for n, u in system.units.items() if n != small},
    )
    typical = {n: v for n, v in family.typical.items() if n != small}
    return replace(family, system=quiet, typical=typical, exact=None, formulas=None)
