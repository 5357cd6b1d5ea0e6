"""`System`: equations of motion as a user brings them, and what is asked of them first."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Self

from ..algebra.upright import Upright
from ..base.errors import ParameterError
from .equations import Condition, Equations
from .equilibria import Equilibria, equilibria
from .family import Family
from .graph.ignorable import ignorable


@dataclass(frozen=True, eq=False, repr=False)
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
        Rates f(x, p), a column as long as x.
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
    algebraic
        States y without a rate: their entries of rhs are algebraic equations g(x, y, p) = 0, which
        must determine them to first order (det ∂g/∂y ≠ 0, index 1).  Spectra, boundaries and maps
        are those of the finite eigenvalues of the pencil; each y counts as one structural zero.

    Raises
    ------
    ParameterError
        If names and expressions do not match, or an expression holds another symbol.

    Source: CasADi's automatic differentiation; tests/systems/test_random_systems.py.

    Examples
    --------
    >>> import stability as st
    >>> import casadi as ca
    >>> x, p = ca.SX.sym("x", 2), ca.SX.sym("p")
    >>> pendulum = st.System("pendulum", x, p, ca.vertcat(x[1], -p * ca.sin(x[0])),
    ...                   states=("angle", "rate"), parameters=("g",))
    >>> pendulum.rates([0.5, 0.0], [9.81])
    array([ 0.        , -4.70316453])

    A source E feeds a load of constant power through a coil: L ẋ = E - R x - y, 0 = x y - P.

    >>> x, y, P = (ca.SX.sym(n) for n in "xyP")
    >>> feeder = st.System("feeder", ca.vertcat(x, y), P, ca.vertcat(2 - x - y, x * y - P),
    ...                    states=("current", "voltage"), parameters=("P",), algebraic=("voltage",))
    >>> high = feeder.steady("P", guess={"current": 1.5, "voltage": 0.5, "P": 0.75})
    >>> st.spectrum(high, at=0.75).eigenvalues.round(12)  # -R + P/x²
    array([-0.66666667+0.j])
    """

    @property
    def ignorable(self) -> tuple[str, ...]:
        """Names of the states that no other motion depends on, such as a heading or a place.

        The rates of all other states, and all conditions, are proved not to depend on them.  Among
        themselves they form chains (a place depends on a heading), or a group that others turn and
        whose sum of squares is constant by an identity: a quaternion, a row of a rotation matrix.
        A family may leave them out: their values then do not matter, their rates need not vanish,
        and each gives one structural zero.  A state that is constant by its equation counts as a
        parameter, and is not among them.

        Source: derivation in `stability.systems.graph.ignorable`; tests/systems/test_ignorable.py.

        Examples
        --------
        >>> import stability as st
        >>> import casadi as ca
        >>> x, p = ca.SX.sym("x", 3), ca.SX.sym("p", 0)
        >>> cart = st.System("cart", x, p, ca.vertcat(x[1] * ca.cos(x[2]), -x[1], x[1]),
        ...               states=("place", "speed", "heading"))
        >>> cart.ignorable
        ('place', 'heading')
        """
        return tuple(n for n in self.states if n in ignorable(self))

    @classmethod
    def from_sympy(
        cls,
        model: Any,
        *,
        name: str = "model",
        parameters: Sequence[Any] | None = None,
        dependent: Sequence[Any] | Mapping[Any, Any] = (),
        cyclic: Sequence[Any] = (),
        observables: Mapping[str, Any] | None = None,
        conditions: Sequence[Condition] = (),
        units: Mapping[str, str] | None = None,
    ) -> Self:
        """A system from SymPy: its mechanics, matrices, or rates, with every rational kept exact.

        A number that is no fraction, such as π or a root of 2, becomes the nearest double; the
        system's `approximation` then says so, and with it every reason and file.

        Coordinates and speeds become states under their own names; the rate of a coordinate q is
        `q_dot`.  All other symbols are parameters, and so are other functions of time, which are
        then constant inputs.  Dependent speeds are eliminated and become observables.  So are
        dependent coordinates where the constraint is linear in them or `dependent` has their
        expression; otherwise they stay states, and states off the constraint are refused.

        Parameters
        ----------
        model
            A `KanesMethod`, `LagrangesMethod` or `mechanics.System` with its equations formed; a
            tuple (mass matrix, forcing, q, u); or a mapping from each state to its rate.
        name
            Name of the system.
        parameters
            Symbols (or their names) in the order of the system's parameters; sorted by name when
            left out.
        dependent
            Dependent coordinates and speeds, for Lagrange's method; or a mapping from dependent
            coordinates to their expressions in the others.
        cyclic
            Coordinates to leave out, such as the angle of a rolling wheel; no other rate holds
            them, and in a steady motion they grow.
        observables
            SymPy expressions by name.
        conditions, units
            As in the constructor.

        Returns
        -------
        System

        Raises
        ------
        ParameterError, NameUnknownError
            If the model is no such thing, uses a function that a graph does not have, or has a
            symbol that is not in `parameters`.

        Source: SymPy's own linearisations, compared in tests/systems/test_from_sympy.py.

        Examples
        --------
        >>> import stability as st
        >>> import sympy
        >>> q, v, k = sympy.symbols("q v k")
        >>> swing = st.System.from_sympy({q: v, v: -k * sympy.sin(q) / 3}, name="swing")
        >>> swing.linearise([0, 0], [3])
        array([[ 0.,  1.],
               [-1.,  0.]])
        """
        from .sources.sympy_models import sympy_model

        arguments = sympy_model(
            model,
            parameters=parameters,
            dependent=dependent,
            cyclic=cyclic,
            observables=observables,
        )
        arguments["conditions"] = (*arguments.get("conditions", ()), *conditions)
        return cls(name=name, units=units or {}, **arguments)

    @classmethod
    def from_function(
        cls,
        function: Any,
        *,
        name: str | None = None,
        states: Sequence[str] | None = None,
        parameters: Sequence[str] | None = None,
        conditions: Sequence[Condition] = (),
        units: Mapping[str, str] | None = None,
    ) -> Equations:
        """A system from a CasADi function, live or from a file, or from a plain Python function.

        A Python function makes a *numeric* system, which is no `System`.  Spectra, boundaries and
        maps of its families are by floats, with an estimated error of a numerical derivative, and
        say so; `simulate` integrates it.  Everything that needs the graph refuses it.

        Parameters
        ----------
        function
            A `casadi.Function` (SX or MX) of (x) or (x, p) that returns the rates and any named
            observables; the path of a file that its `save` wrote; or a Python function
            f(x, p) → rates.
        name
            Name of the system; that of the function when left out.
        states, parameters
            Names of the entries of x and p; from the names of a CasADi function's inputs when left
            out.  A Python function needs the names of its states.
        conditions, units
            As in the constructor; a Python function takes no conditions.

        Returns
        -------
        System or NumericSystem

        Raises
        ------
        ParameterError, FileError
            If the function does not fit, or the file is none of a CasADi function.

        Examples
        --------
        >>> import casadi as ca, stability as st
        >>> x, g = ca.SX.sym("x", 2), ca.SX.sym("g")
        >>> rates = ca.vertcat(x[1], -g * ca.sin(x[0]))
        >>> f = ca.Function("swing", [x, g], [rates], ["x", "g"], ["rates"])
        >>> st.System.from_function(f).states, st.System.from_function(f).parameters
        (('x_0', 'x_1'), ('g',))
        >>> swing = st.System.from_function(lambda x, p: [x[1], -x[0] - x[1]], name="damped",
        ...                              states=("q", "v"))
        >>> rest = st.Family(swing, "rest", at=("q",), held={"v": 0.0})
        >>> st.spectrum(rest, at=0.0).verdict.word
        'stable'
        """
        from .sources.casadi_functions import casadi_function, is_python
        from .sources.numeric import NumericSystem

        if is_python(function):
            if conditions:
                raise ParameterError(
                    "conditions are expressions, and a Python function has none; leave them out."
                )
            title = getattr(function, "__name__", "function") if name is None else name
            return NumericSystem(str(title), function, states or (), parameters or (), units)
        arguments = casadi_function(function, states=states, parameters=parameters)
        if name is not None:
            arguments["name"] = name
        return cls(conditions=tuple(conditions), units=units or {}, **arguments)

    def steady(
        self,
        at: Sequence[str] | str,
        *,
        held: Mapping[str, float | Upright] | None = None,
        unknown: Sequence[str] | str = (),
        guess: Mapping[str, float] | None = None,
        equations: Sequence[str] | None = None,
        positive: Sequence[str] = (),
        name: str | None = None,
        **parameters: Any,
    ) -> Family:
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
        unknown
            Names of parameters that are solved for too: the thrust that holds a speed.  Name as
            many states more in `at` or `held`.
        guess
            Values near one member: of parameters and states, by name.  A state that is left out
            counts as 0.  An ignorable state, such as a place, is left out: it may move.
        equations
            States whose rates must vanish, or observables that must, as many as there are
            unknowns; independent rates, and residuals of constraints on places, when left out.
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
        ...     print(str(error).split("reaches: ")[1].split(";")[0])
        it stopped at a fold at p = 0, where this branch turns
        """
        from .steady import steady

        return steady(
            self,
            at,
            held=held,
            unknown=unknown,
            guess=guess,
            equations=equations,
            positive=positive,
            name=name,
            **parameters,
        )

    def equilibria(
        self, box: Mapping[str, tuple[float, float] | float], **parameters: float
    ) -> Equilibria:
        """Every steady state in a box, each proved, and whether these are proved to be all.

        The box is cut into parts.  Each part is proved in interval arithmetic to hold no steady
        state, or one.  Parts without a proof stay open: around double equilibria (folds and branch
        points), and where the rates have no slope.  The result then says where, and a
        `StabilityWarning` repeats this.

        Parameters
        ----------
        box
            Low and high end of each state, both included; or one number, at which a state is held.
            An ignorable state, such as a place, is left out: it may move.
        **parameters
            Value of each parameter.

        Returns
        -------
        Equilibria
            A sequence of states by name, with `.states`, `.errors`, `.verdicts`, `.complete` and
            `.unresolved`, and `.families(at=…)` through each.

        Raises
        ------
        NameUnknownError, ParameterError
            If names or numbers do not fit the system, or the rates leave states open for all
            numbers, as where a sum of states is conserved.

        Warns
        -----
        StabilityWarning
            If the search was not complete.

        Source: planted equilibria of random systems in tests/systems/test_equilibria.py.

        Examples
        --------
        >>> import casadi as ca, stability as st
        >>> x, y, k = (ca.SX.sym(n) for n in "xyk")
        >>> switch = st.System("switch", ca.vertcat(x, y), k,
        ...                    ca.vertcat(k / (1 + y**2) - x, k / (1 + x**2) - y),
        ...                    states=("x", "y"), parameters=("k",))
        >>> found = switch.equilibria({"x": (0, 5), "y": (0, 5)}, k=2.5)
        >>> found.states.round(6).tolist(), found.complete
        ([[0.5, 2.0], [1.114747, 1.114747], [2.0, 0.5]], True)
        >>> [v.word for v in found.verdicts]
        ['stable', 'unstable', 'stable']
        """
        return equilibria(self, box, parameters)
