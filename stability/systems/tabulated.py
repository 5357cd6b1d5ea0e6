"""Functions given by tables: straight lines, splines and interpolants as expressions of a graph.

A piecewise polynomial is a sum over its pieces, each a polynomial in τ = t/h.  Here h is the width
of the piece, and t is how far the argument has come through it: no less than 0, no more than h.
So the function is continuous, however the coefficients are rounded, and has a value at every knot.

A spline of degree 2 or more is given by its values and slopes at the knots, as doubles: the cubic
of Hermite, and from degree 4 on τ² (1 - τ)² times the rest.  So its slope is continuous too.
"""

from __future__ import annotations

import re
import sys
from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction
from functools import reduce
from itertools import pairwise
from operator import add
from typing import Any

import casadi as ca
import numpy as np
from numpy.typing import ArrayLike

from ..algebra.switches import no_folding
from ..base.checks import checked, real_numbers
from ..base.errors import ParameterError, shown
from ..base.types import Floats

SOURCES = (
    "give arrays x and y, a CasADi interpolant of one input, or SciPy's CubicSpline, "
    "PchipInterpolator, Akima1DInterpolator, PPoly, BSpline, UnivariateSpline or a linear interp1d"
)
INTERPOLANTS = ("LinearInterpolant", "BSplineInterpolant")
"""CasADi's classes of interpolants."""
ROUNDED = 1e-10
"""Difference of values, or of slopes, on the two sides of a knot that counts as rounding, over the
largest of the table."""


@dataclass(frozen=True)
class Tabulated:
    """A function of one number from a table, for graphs of CasADi and expressions of SymPy.

    `tabulated` makes it.  Called with numbers it returns numbers, NaN outside the table.

    Examples
    --------
    >>> stiffness = tabulated([0, 1, 3], [2, 4, 3])
    >>> stiffness
    <Tabulated of 3 points from 0 to 3, straight between them>
    >>> stiffness([0.5, 1, 4]).tolist()
    [3.0, 4.0, nan]
    """

    knots: tuple[float, ...]
    """Ends of the pieces, in increasing order."""
    start: float
    """Value at the first knot."""
    pieces: tuple[tuple[Fraction, ...], ...]
    """Coefficients of τ, τ², … of each piece, without its value at τ = 0."""
    extrapolates: bool
    """Whether the outer pieces go on beyond the table; elsewhere there is no value."""
    kinks: tuple[float, ...]
    """Knots at which the slope jumps."""

    def __repr__(self) -> str:
        straight = max(map(len, self.pieces)) == 1
        how = "straight between them" if straight else f"{len(self.kinks) or 'no'} kinks"
        on = ", extrapolated" * self.extrapolates
        ends = f"{self.knots[0]:g} to {self.knots[-1]:g}"
        return f"<Tabulated of {len(self.knots)} points from {ends}, {how}{on}>"

    def __call__(self, x: Any) -> Any:
        """The value at an argument.

        Parameters
        ----------
        x
            An SX scalar, an MX, a SymPy expression, or numbers of any shape.

        Returns
        -------
        SX, MX, SymPy expression, float or ndarray
            Of the kind and shape of `x`.

        Raises
        ------
        ParameterError
            If `x` is none of these.
        """
        if isinstance(x, ca.SX):
            if x.numel() != 1:
                raise ParameterError(f"x is {shown(x)}; give one expression.")
            with no_folding():
                return self._expression(x) + self._outside(x)
        if "sympy" in sys.modules and isinstance(x, sys.modules["sympy"].Basic):
            kind: Any = type("table", (sys.modules["sympy"].Function,), {"tabulated": self})
            return kind(x)  # System.from_sympy writes the table in its place
        symbol = ca.SX.sym("x")
        function = ca.Function("table", [symbol], [self(symbol)])
        if isinstance(x, ca.MX):
            return function(x)
        numbers = real_numbers("x", x)
        values = np.array(function(numbers.reshape(1, -1))).reshape(numbers.shape)
        return values if numbers.ndim else float(values)

    def _expression(self, x: ca.SX) -> ca.SX:
        """The value, by |x|, sums and products with doubles."""

        def plus(value: Any, number: Fraction) -> Any:
            return reduce(add, doubles(number), value)

        beyond = [x - knot for knot in self.knots]
        past = [0.5 * (u + ca.fabs(u)) for u in beyond[1:-1]]
        total = ca.SX(self.start)
        for k, coefficients in enumerate(self.pieces):
            t = past[k - 1] if k else beyond[0]
            t = t - past[k] if k < len(past) else t
            width = doubles(Fraction(self.knots[k + 1]) - Fraction(self.knots[k]))
            # where the width is no double, the difference of two terms is exact
            tau = t / (width[0] if len(width) == 1 else beyond[k] - beyond[k + 1])
            value = sum(number * tau for number in doubles(coefficients[-1]))
            for c in coefficients[-2::-1]:
                value = tau * plus(value, c)
            total = total + value
        return total

    def _outside(self, x: ca.SX) -> ca.SX:
        """Zero between the ends of the table, and no value elsewhere."""
        if self.extrapolates:
            return ca.SX(0)
        sides = x < self.knots[0], x > self.knots[-1]
        low, high = (ca.SX.binary(ca.OP_IF_ELSE_ZERO, side, ca.SX(np.nan)) for side in sides)
        return low + high


def doubles(value: Fraction) -> list[float]:
    """Doubles whose sum is a sum or product of doubles.

    Raises
    ------
    ParameterError
        If there are none, as for a product below 1e-323.

    Examples
    --------
    >>> doubles(Fraction(0.1) + 3)
    [3.1, -8.326672684688674e-17]
    """
    parts: list[float] = []
    while value or not parts:
        try:
            parts.append(float(value))
        except OverflowError:
            parts.append(0.0)
        if value and not parts[-1]:
            raise ParameterError(
                "products of the table's numbers leave the range of doubles; give it in other "
                "units, with numbers nearer to 1."
            )
        value -= Fraction(parts[-1])
    return parts


def tabulated(table: Any, values: ArrayLike | None = None) -> Tabulated:
    """A function from a table, to be used in the equations of a system.

    Its graph is exact in the doubles of the table, so verdicts and boundaries are proved as for any
    other equation.  At a knot in a state where the slope jumps there is no verdict, as on every
    switch.  A jump of the slope below 1e-10 of the largest slope counts as rounding.

    Parameters
    ----------
    table
        Arguments in increasing order, for straight lines between the points; a CasADi interpolant
        of one input, 'linear' or 'bspline'; or an object of `scipy.interpolate`: `CubicSpline`,
        `PchipInterpolator`, `Akima1DInterpolator`, `PPoly`, `BSpline` (as `make_interp_spline`
        returns it), `UnivariateSpline`, linear `interp1d`.
    values
        Values at the arguments, where `table` is an array.

    Returns
    -------
    Tabulated
        A callable.  Outside the table a system refuses it in one sentence, unless the object
        extrapolates, as a `CubicSpline` does unless it is told not to.

    Raises
    ------
    ParameterError
        If the table is none of these, or jumps.

    Source: SciPy's own values and slopes, and planted boundaries: tests/systems/test_tabulated.py.

    Examples
    --------
    >>> import casadi as ca, stability as st
    >>> from scipy.interpolate import CubicSpline
    >>> damping = st.tabulated(CubicSpline([0, 1, 2, 3], [1.0, 0.5, -0.5, -2.0]))
    >>> x, p = ca.SX.sym("x", 2), ca.SX.sym("p")
    >>> rates = ca.vertcat(x[1], -x[0] - damping(p) * x[1])
    >>> wing = st.System("wing", x, p, rates, states=("y", "v"), parameters=("speed",))
    >>> rest = st.Family(wing, "rest", at=("speed",), held={"y": 0, "v": 0})
    >>> [edge] = st.boundaries(rest, axis=("speed", 0, 3, 9))
    >>> round(edge.value, 12), edge.crossing.word
    (1.561552812809, 'flutter')
    """
    if values is not None:
        return _lines(table, values, extrapolates=False)
    if isinstance(table, Tabulated):
        return table
    if isinstance(table, ca.Function):
        return _interpolant(table)
    if type(table).__module__.startswith("scipy.interpolate"):
        return _of_scipy(table)
    raise ParameterError(f"table is {shown(table)}; {SOURCES}.")


def interpolated(function: ca.Function, arguments: Sequence[ca.SX]) -> ca.SX:
    """The value of an interpolant that a graph calls, or a refusal of any other function."""
    if function.class_name() not in INTERPOLANTS:
        raise ParameterError(
            f"the function {function.name()} is no graph of smooth elementary functions: it is an "
            "integrator, a root-finder or outside code; rewrite that part, or give a Python "
            "function, of which nothing can be proved."
        )
    with no_folding():
        value: ca.SX = _interpolant(function)(*arguments)
    return value


def _lines(x: Any, y: Any, *, extrapolates: bool) -> Tabulated:
    """Straight lines between points."""
    knots, values = (np.atleast_1d(checked(what, v)) for what, v in (("x", x), ("y", y)))
    if values.shape != knots.shape or knots.ndim != 1:
        raise ParameterError(
            f"x and y have shapes {knots.shape} and {values.shape}; give one value of y for each x."
        )
    _increasing(knots)
    y_exact = [Fraction(float(v)) for v in values]
    steps = tuple((b - a,) for a, b in pairwise(y_exact))
    widths = [Fraction(float(b)) - Fraction(float(a)) for a, b in pairwise(knots)]
    slopes = [step / width for (step,), width in zip(steps, widths, strict=True)]
    kinks = [float(knots[k]) for k, (m, n) in enumerate(pairwise(slopes), 1) if m != n]
    return Tabulated(tuple(map(float, knots)), float(values[0]), steps, extrapolates, tuple(kinks))


def _increasing(knots: Floats) -> None:
    if len(knots) < 2 or not (np.diff(knots) > 0).all():
        raise ParameterError(
            f"x is {shown(knots)}; give at least two numbers, each larger than the one before."
        )


def _interpolant(function: ca.Function) -> Tabulated:
    """The table within a CasADi interpolant, which its C code prints to the last digit."""
    kind = function.class_name()
    single = function.n_in() == function.numel_in(0) == function.numel_out(0) == 1
    if kind not in INTERPOLANTS or not single:
        raise ParameterError(
            f"the function {function.name()} is no interpolant with its values, from one number to "
            "one; give one table for each, or a Python function, of which nothing can be proved."
        )
    code = ca.CodeGenerator("table")
    code.add(function)
    printed = re.findall(r"static const casadi_real \w+\[\d+\] =\s*\{([^}]*)\}", code.dump())
    first, second = (np.array([float(v) for v in text.split(",")]) for text in printed)
    if kind == "LinearInterpolant":  # values, then arguments; it goes on beyond its ends
        return _lines(second, first, extrapolates=True)
    from scipy.interpolate import BSpline

    # knots, then coefficients; it is 0 beyond its ends
    return _of_scipy(BSpline(first, second, len(first) - len(second) - 1, extrapolate=False))


def _of_scipy(table: Any) -> Tabulated:
    from scipy.interpolate import BSpline, PPoly, UnivariateSpline, interp1d

    if isinstance(table, interp1d) and table._kind == "linear":
        return _lines(table.x, table.y, extrapolates=str(table.fill_value) == "extrapolate")
    if isinstance(table, UnivariateSpline):
        table = BSpline(*table._eval_args, extrapolate=table.ext == 0)
    low, high = -np.inf, np.inf
    if isinstance(table, BSpline):
        low, high = table.t[table.k], table.t[-table.k - 1]
    if not isinstance(table, BSpline | PPoly) or np.ndim(table.c) != 1 + isinstance(table, PPoly):
        raise ParameterError(f"table is {shown(table)}, no function of one number; {SOURCES}.")
    if table.extrapolate == "periodic":
        raise ParameterError(
            "the table repeats itself beyond its ends, and a graph has no remainder; make it with "
            "extrapolate=False."
        )
    extrapolates = bool(table.extrapolate)
    if isinstance(table, BSpline):
        table = PPoly.from_spline(table)
    inside = (np.diff(table.x) > 0) & (table.x[:-1] >= low) & (table.x[1:] <= high)
    knots = np.append(table.x[:-1][inside], table.x[1:][inside][-1:])
    _increasing(knots)
    checked("the table's coefficients", table.c)
    return _piecewise(knots, table.c[::-1, inside].T, extrapolates=extrapolates)


def _piecewise(knots: Floats, rows: Floats, *, extrapolates: bool) -> Tabulated:
    """Polynomials in t, lowest power first, joined at the knots up to rounding."""
    exact = [[Fraction(float(c)) for c in row] for row in rows]
    widths = [Fraction(float(b)) - Fraction(float(a)) for a, b in pairwise(knots)]
    if not any(any(p[2:]) for p in exact):
        values = [p[0] for p in exact] + [_at(exact[-1], widths[-1])]
        _joined(knots, values, exact, widths)
        return _lines(knots, [float(v) for v in values], extrapolates=extrapolates)
    ends = [_at(p, h) for p, h in zip(exact, widths, strict=True)]
    steep = [_at(_slope(p), h) for p, h in zip(exact, widths, strict=True)]
    values = [p[0] for p in exact] + [Fraction(float(ends[-1]))]
    _joined(knots, values, exact, widths)
    largest = max(max(abs(p[1]) for p in exact), max(map(abs, steep)))
    kinks, pieces = [], []
    for k, (p, h) in enumerate(zip(exact, widths, strict=True)):
        last = Fraction(float(steep[k]))
        if k + 1 < len(exact):
            off = abs(steep[k] - exact[k + 1][1]) > ROUNDED * largest
            kinks += [float(knots[k + 1])] * off
            last = last if off else exact[k + 1][1]
        pieces.append(_hermite(values[k + 1] - values[k], h * p[1], h * last, p, h))
    start = float(values[0])
    return Tabulated(tuple(map(float, knots)), start, tuple(pieces), extrapolates, tuple(kinks))


def _joined(
    knots: Floats, values: Sequence[Fraction], pieces: Sequence[Any], widths: Sequence[Fraction]
) -> None:
    """Refuse a table that jumps."""
    largest = max(map(abs, values))
    for k, (p, h) in enumerate(zip(pieces, widths, strict=True)):
        if abs(_at(p, h) - values[k + 1]) > ROUNDED * largest:
            raise ParameterError(
                f"the table jumps at {knots[k + 1]:g}; give one table for each side, joined by "
                "if_else."
            )


def _hermite(
    step: Fraction, first: Fraction, last: Fraction, p: Sequence[Fraction], h: Fraction
) -> tuple[Fraction, ...]:
    """Coefficients of τ, τ², … from the step of the value and the slopes at the ends."""
    coefficients = [first, 3 * step - 2 * first - last, first + last - 2 * step]
    rest = [c * h**j for j, c in enumerate(p)]
    coefficients += [Fraction(0)] * (len(rest) - 4)
    for j in range(len(rest) - 1, 3, -1):  # division by τ² (1 - τ)² = τ⁴ - 2τ³ + τ²
        c = Fraction(float(rest[j]))
        for place, factor in ((j, Fraction(1)), (j - 1, Fraction(-2)), (j - 2, Fraction(1))):
            rest[place] -= c * factor
            coefficients[place - 1] += c * factor
    return tuple(coefficients)


def _at(p: Sequence[Fraction], t: Fraction) -> Fraction:
    return sum((c * t**j for j, c in enumerate(p)), Fraction(0))


def _slope(p: Sequence[Fraction]) -> list[Fraction]:
    return [j * c for j, c in enumerate(p)][1:] or [Fraction(0)]
