"""Convex bodies of revolution: a height as a function of the inclination, and two moments."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from ...base.checks import Number, broadcast, checked, known, one_number, positive, real_numbers
from ...base.errors import NameUnknownError, ParameterError, shown
from ...base.printing import html_table, in_short
from ...base.quantities import ONE, DefaultScale, Kind, refuse_partial_units
from ...systems.family import Family
from ...systems.system_checks import mapping, title
from .height.convexity import LEAST, Convexity, convexity
from .height.expression import expression
from .shape import MOMENTS, SAMPLES, SCALES, TAKEN, RoundShape, single_pole


@dataclass(frozen=True, eq=False, repr=False)
class Body(RoundShape):
    """A convex body of revolution that rolls and slides on a plane, by its support function.

    θ is the angle between the symmetry axis 3̂ and the vertical.  The height h(θ) of the centre of
    mass over the plane gives the whole surface: the contact point lies at a distance h'(θ) from the
    foot of the centre, and the meridian has the radius of curvature h + h''.  Lengths are over
    `length`, moments over mass times `length`².  With the defaults m = g = length = 1 every number
    is dimensionless (time in √(length/g), speed in √(g·length)).  With mass, gravity and length in
    SI units, all three, every number is SI.

    Parameters
    ----------
    height
        Function of θ, then of the numbers in `shape` by name, made of CasADi's functions, over
        `length` [-].
    axial, transverse
        Moments of inertia about the symmetry axis, and about any axis through the centre of mass
        across it, over mass times length² [-]: positive numbers, or functions of the numbers in
        `shape` by name.
    mass, gravity, length
        Mass, acceleration of free fall, and the length in which `height` is given, positive
        [kg, m/s², m].
    shape
        Numbers of the shape by name, any of which may be an axis of a map [-].
    name
        Name in messages and files.
    between
        Open interval of θ in which the height holds, within (0, π) [rad].
    limits
        Range (low, high] of numbers of the shape, for formulas that do not hold elsewhere.
    error
        Relative error of height, its two slopes and moments where they are computed, or a fit, and
        no formulas [-].  What is proved is proved of the fit, and says so with this number.
    constants
        Numbers by name of which height and moments were computed, for records; none is an axis.

    Raises
    ------
    ParameterError
        If a number is not in its range, if some of mass, gravity and length are given and not all,
        or if the height is that of no convex body.

    Source: docs/explanation/bodies.md derives the equations and the meaning of h; compared with an
    inertial formulation that knows the surface alone (tests/bodies/test_round_bodies.py).

    Examples
    --------
    >>> import math
    >>> import stability as st
    >>> import casadi as ca
    >>> ball = st.Body(lambda theta: 1.0, axial=0.4, transverse=0.4)
    >>> coin = st.Body(lambda theta, rim: ca.sin(theta) + rim, axial=0.5, transverse=0.25,
    ...             shape={"rim": 0.02}, name="coin")
    >>> round(float(coin.height_at(math.pi / 2)), 12)
    1.02
    """

    height: Callable[..., Any]
    """Height of the centre over `length`, as a function of θ and the numbers in `shape` [-]."""
    axial: Any
    """Moment of inertia about the symmetry axis over m·length², or a function for it [-]."""
    transverse: Any
    """Moment of inertia across the symmetry axis over m·length², or a function for it [-]."""
    mass: Number = ONE
    """Mass m [kg]."""
    gravity: Number = ONE
    """Acceleration of free fall g [m/s²]."""
    length: Number = ONE
    """Length in which the height is given [m]."""
    shape: Mapping[str, Any] = field(default_factory=dict)
    """Numbers of the shape by name [-]."""
    name: str = "body"
    """Name in messages and files."""
    between: tuple[float, float] = (0.0, math.pi)
    """Open interval of θ in which the height holds [rad]."""
    limits: Mapping[str, tuple[float, float]] = field(default_factory=dict)
    """Range (low, high] of numbers of the shape by name, beyond which the formulas do not hold."""
    error: float = 0.0
    """Relative error of height, its two slopes and moments where they are a fit; 0 for formulas."""
    constants: Mapping[str, float] = field(default_factory=dict)
    """Numbers by name of which height and moments were computed; no parameters, so no axes."""

    def __post_init__(self) -> None:
        for name in SCALES:
            value = getattr(self, name)
            if not isinstance(value, DefaultScale):
                object.__setattr__(self, name, positive(name, value))
        object.__setattr__(self, "name", title("the body", self.name))
        object.__setattr__(self, "error", self._share("error"))
        scales = {n: getattr(self, n) for n in ("mass", "length", "gravity")}
        refuse_partial_units(f"the {self.name}", scales)
        numbers = self._numbers()
        object.__setattr__(self, "shape", numbers)
        object.__setattr__(self, "limits", self._within_limits(numbers))
        table = mapping("constants", self.constants)
        constants = {n: one_number(n, v) for n, v in table.items()}
        object.__setattr__(self, "constants", constants)
        height = expression("height", self.height, ["theta", *numbers], 1)
        object.__setattr__(self, "height", replace(height, error=self.error))
        for name in MOMENTS:
            value = getattr(self, name)
            is_function = callable(value)
            value = expression(name, value, list(numbers)) if is_function else positive(name, value)
            object.__setattr__(self, name, value)
        object.__setattr__(self, "between", self._range())
        broadcast(**{n: np.shape(v) for n, v in self.given.items()})
        self._check_moments()
        self._check_convex()

    def __repr__(self) -> str:
        values = {**self.shape, **self.constants}
        shape = [f"{n} = {in_short(v)}" for n, v in values.items()]
        numbers = [*shape, *(f"{n} = {v}" for n, v in self._sizes().items())]
        return f"<Body {', '.join([self.name, *numbers])}>"

    def _repr_html_(self) -> str:
        moments = zip(MOMENTS, self.moments(), strict=True)
        rows = [(n, in_short(v)) for n, v in {**self.shape, **self.constants}.items()]
        rows += [(f"{n} moment of inertia over m·length²", in_short(v)) for n, v in moments]
        rows += list(self._sizes().items())
        return html_table(self.name, ["number", "value"], rows, "lengths are over length")

    def _sizes(self) -> dict[str, str]:
        """Mass, length and gravity with their units; one entry where all are 1."""
        if self.dimensionless:
            return {"mass = length = gravity": "1"}
        kinds = {"mass": Kind.MASS, "length": Kind.LENGTH, "gravity": Kind.ACCELERATION}
        return {n: f"{in_short(getattr(self, n))}{kind.suffix}" for n, kind in kinds.items()}

    # --- families ---

    def family(
        self, name: str, contact: Any = None, *, theta: float | None = None, pole: Any = None
    ) -> Family:
        """A family of the body's steady motions, for everything that takes a `Family`.

        The numbers of the body and of the law are parameters of the family, by name.

        Parameters
        ----------
        name
            `rolling`, `spinning`, `tumbling`, `vertical`, `circling` (rough) or `precession`
            (smooth).
        contact
            A contact law, its name or its class; its numbers do not matter.
        theta
            Inclination near that of rolling, where the body rolls at several [rad].
        pole
            0 or "pi", the inclination of vertical spin.

        Returns
        -------
        Family

        Raises
        ------
        StabilityError
            If the body has no such family under this law.

        Source: tests/bodies/test_round_families.py.

        Examples
        --------
        >>> import stability as st
        >>> upright = st.Torus(0.2).family("spinning", "rough")
        >>> upright.at, upright.parameters
        (('phi_dot',), ('tube',))
        >>> print(st.conditions(upright, positive=["tube"], tube=1).rule)
        Neutral where 41*phi_dot**2 - 8 > 0; unstable where it is negative.
        """
        from .families import body_family

        return body_family(self, name, contact, theta, single_pole(pole))

    @property
    def unproved(self) -> tuple[tuple[float, float], ...]:
        """Intervals of θ in which samples alone say that the body is convex; empty if proved.

        Everywhere else the height is above -1e-12, and the meridian's radius of curvature above
        -1e-9, of the largest height, by bounds on pieces.  Open intervals are corners of the
        height, points where its second derivative is infinite, and everything where more than 32
        shapes are given at once.

        Examples
        --------
        >>> import casadi as ca
        >>> import stability as st
        >>> st.Spheroid(0.5).unproved
        ()
        >>> can = st.Body(lambda t: ca.sin(t) + ca.fabs(ca.cos(t)), axial=0.5, transverse=0.5)
        >>> [(round(a, 4), round(b, 4)) for a, b in can.unproved]  # it stands upright on a line
        [(1.5708, 1.5708)]
        """
        return self._convexity().open

    # --- checks ---

    def _share(self, name: str) -> float:
        """A relative error: a number of at least 0."""
        value = one_number(name, getattr(self, name))
        if value < 0:
            raise ParameterError(f"{name} is {value:g}; it must not be negative.")
        return value

    def _numbers(self) -> dict[str, Any]:
        """The numbers of the shape by name."""
        if not isinstance(self.shape, Mapping):
            raise ParameterError(f"shape is {shown(self.shape)}; give numbers by name.")
        for name in self.shape:
            if not isinstance(name, str) or not name.isidentifier() or name in TAKEN:
                raise ParameterError(
                    f"shape names {shown(name)}; give a word that is none of {', '.join(TAKEN)}."
                )
        return {n: checked(n, v) for n, v in self.shape.items()}

    def having(self, numbers: Mapping[str, Any]) -> Body:
        """The same body with other values of some of its numbers, by name."""
        for name in numbers:
            known(f"number of {self.name}", name, self.given)
        shape = {n: numbers.get(n, v) for n, v in self.shape.items()}
        others: dict[str, Any] = {n: v for n, v in numbers.items() if n not in shape}
        return replace(self, shape=shape, **others)

    def _within_limits(self, numbers: Mapping[str, Any]) -> dict[str, tuple[float, float]]:
        """The limits, after a check that the numbers lie within them."""
        if not isinstance(self.limits, Mapping):
            raise ParameterError(f"limits is {shown(self.limits)}; give pairs (low, high) by name.")
        limits = {}
        for name, pair in self.limits.items():
            if name not in numbers:
                raise NameUnknownError(
                    f"limits names {shown(name)}; numbers of the shape are "
                    f"{', '.join(numbers) or 'none'}."
                )
            low, high = _rising_pair(f"the limit of {name}", pair, "two numbers (low, high)")
            bad = np.asarray(numbers[name])
            bad = bad[(bad <= low) | (bad > high)]
            if bad.size:
                end = f", {high:g}]" if math.isfinite(high) else ", ∞)"
                raise ParameterError(
                    f"{name} of the {self.name} is {bad.flat[0]:g}; it must lie in ({low:g}{end}."
                )
            limits[name] = (low, high)
        return limits

    def _range(self) -> tuple[float, float]:
        """The interval of θ in which the height holds."""
        accepted = "two angles in rising order between 0 and π"
        low, high = _rising_pair("between", self.between, accepted)
        if not (low >= 0 and high <= math.pi):
            raise ParameterError(f"between is {shown(self.between)}; give {accepted}.")
        return low, high

    def _check_moments(self) -> None:
        axial, transverse = (np.asarray(v) for v in self.moments())
        for name, value in (("axial", axial), ("transverse", transverse)):
            if not (np.isfinite(value) & (value > 0)).all():
                raise ParameterError(
                    f"{name} is {value.flat[0]:g}; a moment of inertia is a positive number."
                )
        bad = axial > 2 * transverse * (1 + 1e-12)
        if bad.any():
            pair = np.broadcast_arrays(axial, transverse)
            raise ParameterError(
                f"axial is {pair[0][bad].flat[0]:g} and transverse "
                f"{pair[1][bad].flat[0]:g}; no body has axial above twice transverse."
            )

    def _convexity(self) -> Convexity:
        """What is proved about the height."""
        arrays = np.broadcast_arrays(*self.shape.values()) if self.shape else []
        shapes = zip(*(v.ravel().tolist() for v in arrays), strict=True) if arrays else [()]
        height: Any = self.height
        return convexity(height, tuple(self.shape), tuple(dict.fromkeys(shapes)), self.between)

    def _check_convex(self) -> None:
        """Refuse a height that no convex body over the plane has: by proof, else at samples."""
        proof = self._convexity()
        if proof.wrong is not None:
            raise _not_convex(*proof.wrong)
        if not proof.open:
            return
        low, high = self.between
        theta = low + (high - low) * (np.arange(SAMPLES) + 0.5) / SAMPLES
        theta = theta.reshape(-1, *[1] * max((np.ndim(v) for v in self.shape.values()), default=0))
        with np.errstate(all="ignore"):
            h, _, bend = self.heights(theta)
        if not (np.isfinite(h).all() and np.isfinite(bend).all()):
            raise ParameterError("height has no finite value and curvature at every theta between.")
        where, radius = np.broadcast_to(theta, np.shape(h)), h + bend
        if (h <= 0).any():
            at = int(np.argmin(h))
            raise _not_convex("height", float(h.flat[at]), float(where.flat[at]))
        if (radius < LEAST * np.abs(h).max()).any():
            at = int(np.argmin(radius))
            raise _not_convex("radius", float(radius.flat[at]), float(where.flat[at]))


def _not_convex(what: str, value: float, theta: float) -> ParameterError:
    """The refusal of a height, or of its radius of curvature, at an inclination."""
    if what == "height":
        return ParameterError(
            f"height is {value:.3g} at theta = {theta:.3g}; the centre of mass must lie above the "
            "plane."
        )
    return ParameterError(
        f"height + height'' is {value:.3g} at theta = {theta:.3g}; it is the radius of curvature "
        "of the meridian, which is nowhere negative for a convex body."
    )


def _rising_pair(name: str, value: Any, remedy: str) -> tuple[float, float]:
    """Two numbers in rising order; the higher one may be infinite."""
    try:
        ends = real_numbers(name, value)
    except ParameterError:
        ends = np.empty(0)
    if ends.shape != (2,) or not -math.inf < ends[0] < ends[1]:
        raise ParameterError(f"{name} is {shown(value)}; give {remedy}.")
    return float(ends[0]), float(ends[1])
