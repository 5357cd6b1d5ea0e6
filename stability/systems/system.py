"""`System`: equations of motion as a user brings them, and what is asked of them first."""

from __future__ import annotations

from dataclasses import dataclass

from .equations import Equations
from .ignorable import ignorable


@dataclass(frozen=True, eq=False)
class System(Equations):
    """Equations of motion ẋ = f(x, p) as a CasADi SX graph, with its observables.

    Any smooth system works like the disk: give plain CasADi expressions, then name a family of
    steady motions with `stability.systems.family.Family`.

    Parameters
    ----------
    name
        Name of the system in messages and files.
    x, p
        SX symbols, columns.
    rhs
        f(x, p), a column as long as x.
    states, parameters
        One name for each entry of x and p.
    observables
        Expressions in x and p by name.
    conditions
        Quantities that must be positive.
    units
        SI unit by the name of state, parameter or observable, for labels.
    mass, forcing, unknowns
        The implicit form mass · unknowns = forcing from which rhs was solved, or None.

    Raises
    ------
    ParameterError
        If names and expressions do not match, or an expression holds another symbol.

    Examples
    --------
    >>> import casadi as ca
    >>> x, p = ca.SX.sym("x", 2), ca.SX.sym("p")
    >>> pendulum = System("pendulum", x, p, ca.vertcat(x[1], -p * ca.sin(x[0])),
    ...                   states=("angle", "rate"), parameters=("g",))
    >>> pendulum.rates([0.5, 0.0], [9.81])
    array([ 0.        , -4.70316453])
    """

    @property
    def ignorable(self) -> tuple[str, ...]:
        """Names of the states that no other motion depends on, such as a heading or a place.

        The rates of all other states, and all conditions, are proved not to depend on them.  Among
        themselves they form chains (a place depends on a heading) without a cycle.  A family may
        leave them out: their values then do not matter, their rates need not vanish, and each
        gives one structural zero, by proof.  A state that is constant by its equation counts as a
        parameter, and is not among them.

        Source: derivation in `stability.systems.ignorable`; tests/systems/test_ignorable.py.

        Examples
        --------
        >>> import casadi as ca
        >>> x, p = ca.SX.sym("x", 3), ca.SX.sym("p", 0)
        >>> cart = System("cart", x, p, ca.vertcat(x[1] * ca.cos(x[2]), -x[1], x[1]),
        ...               states=("place", "speed", "heading"))
        >>> cart.ignorable
        ('place', 'heading')
        """
        return tuple(n for n in self.states if n in ignorable(self))
