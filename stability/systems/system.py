"""`System`: equations of motion as a user brings them, and what is asked of them first."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from ..algebra.upright import Upright
from .equations import Equations
from .family import Family


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

    def steady(
        self, at: Sequence[str] | str, *, held: Mapping[str, float | Upright] | None = None,
        guess: Mapping[str, float] | None = None, equations: Sequence[str] | None = None,
        positive: Sequence[str] = (), name: str | None = None, **parameters: Any,
    ) -> Family:  # fmt: skip
        """The family through the steady motion nearest to a guess.

        Every state that is not named in `at` or `held` is solved for.  The family remembers the
        first member.  Others are followed from there along the straight line to the parameters
        that are asked, and all lie on one smooth sheet: a member beyond a fold is refused.

        Parameters
        ----------
        at
            Names of the parameters or states that name a member.
        held
            Values of the states that are the same along the family.
        guess
            Values near one member: of parameters and states, by name.  A state that is left out
            counts as 0.  A state on which nothing depends is held there.
        equations
            States whose rates must vanish, as many as there are unknowns; independent rates that
            are not identically zero when left out.
        positive
            Unknowns that must be positive.
        name
            Name of the family in messages and files.
        **parameters
            Values of parameters at the guess, if they are not in `guess`; further keywords of
            `Family`.

        Returns
        -------
        Family

        Raises
        ------
        NameUnknownError, ParameterError
            If names or numbers do not fit the system, or its rates leave unknowns open.
        NoMemberError
            If no first guess leads to a steady motion.

        Source: closed forms in tests/systems/test_steady.py.

        Examples
        --------
        >>> import casadi as ca, stability as st
        >>> x, p = ca.SX.sym("x"), ca.SX.sym("p")
        >>> fold = st.System("fold", x, p, p - x**2, states=("x",), parameters=("p",))
        >>> upper = fold.steady("p", guess={"x": 1.5, "p": 2.0}, name="upper")
        >>> upper.member([4.0], []).round(12)
        array([2.])
        >>> try:
        ...     upper.member([-1.0], [])
        ... except st.StabilityError as error:
        ...     print(str(error)[-39:])
        reaches: it stopped at a fold at p = 0.
        """
        from .steady import steady

        return steady(
            self, at, held=held, guess=guess, equations=equations, positive=positive, name=name,
            **parameters,
        )  # fmt: skip
