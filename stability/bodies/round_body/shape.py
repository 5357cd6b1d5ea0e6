"""The numbers of a body of revolution, as its equations and families read them."""

from __future__ import annotations

import math
from collections.abc import Callable, Collection, Mapping
from dataclasses import dataclass
from functools import lru_cache
from typing import Any

import casadi as ca
import numpy as np

from ...algebra.program import Program
from ...base.checks import broadcast, checked, real_numbers, whole_number
from ...base.errors import NameUnknownError, ParameterError, shown
from ...base.quantities import ONE
from ...base.types import Record
from ..newton_euler import STATES
from .height.expression import ShapeFunction

SCALES = ("mass", "gravity", "length")
"""Dimensional quantities of a body."""
MOMENTS = ("axial", "transverse")
"""Names of the moments of inertia that are given as numbers, as axes of maps."""
SAMPLES = 721
"""Inclinations at which convexity is checked."""
NEAR = 10.0 ** -np.arange(2, 9, 2)
"""Distances from upright at which a height is looked at [rad]."""
STEEPER = 1.2
"""Growth of a second derivative from each distance to the next that counts as that to infinity."""
TAKEN = (*SCALES, *MOMENTS, *STATES, "at", "x", "y", "axis", "body", "contact", "disk", "pole")
"""Names that no number of a body's shape can have."""


def single_pole(pole: Any) -> Any:
    """A pole as it was given, unless it holds several numbers, which name no pole.

    Parameters
    ----------
    pole
        None, 0, a number or a word.
    """
    if pole is not None and not isinstance(pole, (int, float, str)):
        raise ParameterError(f"pole is {shown(pole)}; give 0 or 'pi'.")
    return pole


def refuse_constants(body: Any, axes: Collection[str]) -> None:
    """Refuse an axis over a number with which height and moments of a body were computed.

    Parameters
    ----------
    body
        The body.
    axes
        Names of the axes.
    """
    for name in getattr(body, "constants", {}):
        if name in axes:
            raise NameUnknownError(
                f"{name} is no axis of {body.name}: its height and moments are computed for one "
                f"{name} and are no formulas in it; ask once for each {name}."
            )


def not_upright(body: RoundShape) -> str:
    """Why a body does not stand upright, at θ = π/2, as the end of a sentence.

    Parameters
    ----------
    body
        The body; of arrays the first shape counts.

    Examples
    --------
    >>> import stability as st
    >>> not_upright(st.EccentricSphere(0.1))
    'the slope of its height at theta = π/2 is 0.1, and must vanish there'
    """
    low, high = body.between
    right = math.pi / 2
    if not low < right < high:
        return f"its height holds between theta = {low:.6g} and {high:.6g}, without π/2 inside"
    away = NEAR.reshape(-1, *[1] * max((np.ndim(v) for v in body.shape.values()), default=0))
    below, above, at = (
        [np.asarray(v).reshape(len(theta), -1)[:, 0] for v in body.heights(theta)[1:]]
        for theta in (right - away, right + away, right + 0 * away)
    )  # each h' and h''
    bend = np.minimum(abs(below[1]), abs(above[1]))
    if (bend[1:] > STEEPER * bend[:-1]).all():
        return (
            "the second derivative of its height grows beyond bounds towards theta = π/2 "
            f"({bend[-1]:.2g} at a distance of {NEAR[-1]:g} rad), so that no motion there has a "
            "linearisation"
        )
    first, last = float(below[0][-1]), float(above[0][-1])
    if abs(first - last) > NEAR[-1] * 1e3 * (1 + bend[-1]):
        return f"the slope of its height jumps from {first:.3g} to {last:.3g} at theta = π/2"
    return f"the slope of its height at theta = π/2 is {float(at[0][0]):.3g}, and must vanish there"


def of_fit(name: str, error: float) -> str:
    """Of what a proof speaks where the height of a body is a fit; empty for a formula.

    Parameters
    ----------
    name
        Name of the body.
    error
        Relative error of the fit.

    Examples
    --------
    >>> of_fit("egg", 5e-11)
    'for the fitted height of egg: it, its slopes and the moments are off by 5e-11, an estimate'
    """
    if not error:
        return ""
    return (
        f"for the fitted height of {name}: it, its slopes and the moments are off by {error:.0e}, "
        "an estimate"
    )


class RoundShape(Record):
    """A body's numbers; `Body` adds their meaning, checks, and families."""

    height: Callable[..., Any]
    axial: Any
    transverse: Any
    shape: Mapping[str, Any]
    name: str
    between: tuple[float, float]
    mass: Any
    gravity: Any
    length: Any

    @property
    def given(self) -> dict[str, Any]:
        """Every number of the body by name: scales, shape, and moments that are numbers."""
        moments = {n: getattr(self, n) for n in MOMENTS}
        moments = {n: v for n, v in moments.items() if not isinstance(v, ShapeFunction)}
        return {n: getattr(self, n) for n in SCALES} | dict(self.shape) | moments

    @property
    def dimensionless(self) -> bool:
        """Whether m = g = length = 1, so that numbers have no unit."""
        return all(np.all(np.asarray(getattr(self, n)) == 1) for n in SCALES)

    def moments(self) -> tuple[Any, Any]:
        """Axial and transverse moment of inertia over m·length² [-]."""
        moments = []
        for name in MOMENTS:
            value = getattr(self, name)
            if isinstance(value, ShapeFunction):
                value = self.array(value.function, *self.shape.values())
            moments.append(value)
        return moments[0], moments[1]

    def height_at(self, theta: Any, slope: int = 0) -> Any:
        """Height over `length` at inclinations, or a slope of it.

        Parameters
        ----------
        theta
            Inclinations, any shape that broadcasts with the numbers of the shape [rad].
        slope
            0 for h, 1 for h', 2 for h''.
        """
        order = whole_number("slope", slope, 0, 2, "h'' is the highest")
        return self.heights(checked("theta", theta))[order]

    @staticmethod
    def array(function: ca.Function, *values: Any) -> Any:
        """Values of a CasADi function at arrays that broadcast; a float where none is an array."""
        arrays = (
            np.broadcast_arrays(*[np.asarray(v, dtype=float) for v in values]) if values else []
        )
        if not arrays:
            return float(function.call([])[0])
        outputs = function(*[a.reshape(1, -1) for a in arrays]).full()
        return outputs.reshape(arrays[0].shape) if arrays[0].ndim else float(outputs[0, 0])

    def slopes(self) -> list[ca.Function]:
        """h, h' and h'' as functions of θ and the numbers of the shape."""
        return _slopes(self.height, tuple(self.shape))

    def heights(self, theta: Any) -> list[Any]:
        """h, h' and h'' at inclinations, in NumPy: CasADi builds a map for each array.

        Parameters
        ----------
        theta
            Inclinations that broadcast with the numbers of the shape [rad].
        """
        numbers = {n: np.asarray(v, dtype=float) for n, v in self.shape.items()}
        arrays = {"theta": real_numbers("theta", theta)} | numbers
        shape = broadcast(**{n: v.shape for n, v in arrays.items()})
        values = [v if v.ndim else np.float64(v) for v in arrays.values()]
        outputs = _program(self.height, tuple(self.shape)).arrays([[v] for v in values], shape)
        return [v[..., 0, 0] if shape else float(v[0, 0]) for v in outputs]


@dataclass(frozen=True, eq=False)
class Outline(RoundShape):
    """A body's numbers without checks."""

    height: Callable[..., Any]
    axial: Any
    transverse: Any
    shape: Mapping[str, Any]
    name: str
    between: tuple[float, float]
    mass: Any = ONE
    gravity: Any = ONE
    length: Any = ONE


def sharp(body: RoundShape) -> bool:
    """Whether the body is a disk without thickness, h = sinθ, which turns on its edge."""
    return _sharp(body.height, tuple(body.shape))


@lru_cache(maxsize=64)
def _sharp(height: Callable[..., Any], names: tuple[str, ...]) -> bool:
    theta, *symbols = (ca.SX.sym(n) for n in ("theta", *names))
    return bool(ca.is_equal(ca.SX(height(theta, *symbols)), ca.sin(theta), 1))


@lru_cache(maxsize=64)
def _slopes(height: Callable[..., Any], names: tuple[str, ...]) -> list[ca.Function]:
    """h, h' and h'' of a height, built once."""
    theta, *symbols = (ca.SX.sym(n) for n in ("theta", *names))
    values = [ca.SX(height(theta, *symbols))]
    for _ in range(2):
        values.append(ca.jacobian(values[-1], theta))
    return [ca.Function("h", [theta, *symbols], [ca.densify(v)]) for v in values]


@lru_cache(maxsize=64)
def _program(height: Callable[..., Any], names: tuple[str, ...]) -> Program:
    """h, h' and h'' of a height as one list of instructions."""
    symbols = [ca.SX.sym(n) for n in ("theta", *names)]
    values = [f(*symbols) for f in _slopes(height, names)]
    return Program(ca.Function("slopes", symbols, ca.cse(values)))
