"""Rational functions of one axis over Q: exact + - * /, and characteristic polynomials in them.

The second variable of the ring is λ (or σ) in a characteristic polynomial, and the sine of a given
angle in the disk's conditions: that sine is transcendental (Lindemann), so it is as free as a
variable.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import lru_cache
from typing import Any

from flint import fmpq, fmpq_mpoly_ctx, fmpq_poly

from .algebra import Algebra
from .families import Family

RING = fmpq_mpoly_ctx.get(("x", "s"), "lex")
"""Q[x, s]: x is the axis."""
MOST_DEGREE = 48
"""Degree in x beyond which a graph is not read in rational functions."""
MOST_WORK = 300_000
"""Degree of what has to be solved, times states, times bits of a coefficient, beyond which it is
not: about ten seconds."""
MOST_STATES = 12
"""States of the largest system whose characteristic polynomial is expanded."""


class NotRationalError(ArithmeticError):
    """The graph is no rational function of the axis, or too long a one."""


class Ratio:
    """A quotient of two polynomials in x and s over Q, in lowest terms.

    Parameters
    ----------
    top, bottom
        Elements of `RING`; bottom is not zero.

    Examples
    --------
    >>> x = Ratio(RING.gens()[0])
    >>> print((x * x - 1) / (x - 1))
    x + 1
    """

    __slots__ = ("bottom", "top")

    def __init__(self, top: Any, bottom: Any = 1) -> None:
        bottom = RING.constant(1) if isinstance(bottom, int) else bottom
        if not bottom.is_constant():
            common = top.gcd(bottom)
            top, bottom = top / common, bottom / common
        self.top, self.bottom = top, bottom

    @staticmethod
    def of(value: Any) -> Ratio:
        """A number as a ratio.

        Parameters
        ----------
        value
            A ratio, a rational or an integer.
        """
        return value if isinstance(value, Ratio) else Ratio(RING.constant(fmpq(value)))

    def _checked(self) -> Ratio:
        if self.top.degrees()[0] > MOST_DEGREE or self.bottom.degrees()[0] > MOST_DEGREE:
            raise NotRationalError("the degree is too high")
        return self

    def __add__(self, other: Any) -> Ratio:
        o = Ratio.of(other)
        return Ratio(self.top * o.bottom + o.top * self.bottom, self.bottom * o.bottom)._checked()

    def __mul__(self, other: Any) -> Ratio:
        o = Ratio.of(other)
        return Ratio(self.top * o.top, self.bottom * o.bottom)._checked()

    def __neg__(self) -> Ratio:
        return Ratio(-self.top, self.bottom)

    def __sub__(self, other: Any) -> Ratio:
        return self + -Ratio.of(other)

    def __rsub__(self, other: Any) -> Ratio:
        return Ratio.of(other) - self

    def __truediv__(self, other: Any) -> Ratio:
        o = Ratio.of(other)
        if o.top.is_zero():
            raise ZeroDivisionError
        return self * Ratio(o.bottom, o.top)

    def __rtruediv__(self, other: Any) -> Ratio:
        return Ratio.of(other) / self

    def __pow__(self, power: int) -> Ratio:
        if power < 0:
            return 1 / self**-power
        if power > MOST_DEGREE:
            raise NotRationalError("the degree is too high")
        return Ratio(self.top**power, self.bottom**power)._checked()

    __radd__, __rmul__ = __add__, __mul__

    def __str__(self) -> str:
        return f"{self.top}" if self.bottom.is_one() else f"({self.top})/({self.bottom})"


@lru_cache(maxsize=1)
def rational_algebra() -> Algebra:
    """Rationals and ratios; of the functions only values that are rational are known.

    Examples
    --------
    >>> rational_algebra().functions["cos"](fmpq(0)), rational_algebra().functions["sqrt"](fmpq(4))
    (1, 2)
    """

    def known(name: str, place: int, value: int) -> Any:
        def function(x: Any) -> Any:
            if isinstance(x, Ratio) and x.top.is_constant() and x.bottom.is_constant():
                x = x.top.leading_coefficient() / x.bottom.leading_coefficient()
            if isinstance(x, Ratio) or x != place:
                raise NotRationalError(f"{name} is not rational there")
            return fmpq(value)

        return function

    table = {n: known(n, 0, 0) for n in ("sin", "tan", "asin", "atan", "sinh", "tanh")}
    table |= {n: known(n, 0, 1) for n in ("cos", "exp", "cosh")}
    table |= {"log": known("log", 1, 0), "acos": known("acos", 1, 0)}
    table |= {"sqrt": _root, "pow": _power, "fabs": _size}
    return Algebra("rational", _exactly, table)


def _exactly(value: float) -> Any:
    try:
        return fmpq(*float(value).as_integer_ratio())
    except (ValueError, OverflowError):  # a constant that is not finite
        raise NotRationalError("a constant is not finite") from None


def _root(x: Any) -> Any:
    if isinstance(x, Ratio) or x < 0:
        raise NotRationalError("sqrt is not rational there")
    top, bottom = x.p.isqrt(), x.q.isqrt()
    if top * top != x.p or bottom * bottom != x.q:
        raise NotRationalError("sqrt is not rational there")
    return fmpq(top, bottom)


def _power(x: Any, power: Any) -> Any:
    if isinstance(power, Ratio) or power.q != 1 or abs(power.p) > MOST_DEGREE:
        raise NotRationalError("a power is not rational there")
    return x ** int(power.p)


def _size(x: Any) -> Any:
    if isinstance(x, Ratio):
        raise NotRationalError("fabs is not rational there")
    return abs(x)


def univariate(p: Any) -> Any:
    """A polynomial of the ring without s as an `fmpq_poly` in x.

    Parameters
    ----------
    p
        An element of `RING`.

    Examples
    --------
    >>> univariate(RING.gens()[0] ** 2 - 2)
    x^2 + (-2)
    """
    out: dict[int, Any] = {}
    for (power, other), c in p.terms():
        if other:
            raise NotRationalError("a second variable is in it")
        out[int(power)] = c
    return fmpq_poly([out.get(i, 0) for i in range(max(out, default=-1) + 1)])


def multivariate(p: Any) -> Any:
    """An `fmpq_poly` in x as an element of the ring.

    Parameters
    ----------
    p
        The polynomial.
    """
    return RING.from_dict({(i, 0): c for i, c in enumerate(p.coeffs()) if c != 0})


def characteristic_ratios(family: Family, a: Sequence[Any], q: Sequence[Any]) -> tuple[Any, Any]:
    """The characteristic polynomial of a family along an axis, exactly.

    Parameters
    ----------
    family
        A family without equations to solve, or whose guess solves them identically.
    a, q
        Family parameters and parameters: rationals, and ratios in the axis.

    Returns
    -------
    coefficients, denominator
        Of a positive multiple (up to sign) of det(λ - A) by powers of λ, lowest first, without
        common factor; and the polynomial in x at whose zeros an entry of A has no value.  All are
        `fmpq_poly` in x.

    Raises
    ------
    NotRationalError
        If the graph is not rational in the axis, or too large.
    """
    size = len(family.system.states)
    if size > MOST_STATES or (family.unknown and not family.closed):
        raise NotRationalError("no closed form")
    u = [_exactly(float(v)) for v in family.unknown.values()]
    try:
        rows = family.graph.matrix.dense(rational_algebra(), [list(a), u, list(q)])
    except ZeroDivisionError:
        raise NotRationalError("a denominator vanishes all along the axis") from None
    entries = [[Ratio.of(v) for v in row] for row in rows]
    common = RING.constant(1)
    for row in entries:
        for e in row:
            common = common * (e.bottom / common.gcd(e.bottom))
    below = univariate(common)
    matrix = [[univariate(e.top * (common / e.bottom)) for e in row] for row in entries]
    degree = max(1, below.degree(), *(e.degree() for row in matrix for e in row))
    bits = max(_bits(e) for row in matrix for e in row)
    if degree * size * size * size // 2 * bits > MOST_WORK:
        raise NotRationalError("the polynomials are too large")
    scaled = [c * below**j for j, c in enumerate(_faddeev(matrix))]
    content = scaled[-1]
    for c in scaled:
        content = content.gcd(c)
    return [c / content for c in scaled], below


def _bits(p: Any) -> int:
    longest = [max(int(c.p.height_bits()), int(c.q.height_bits())) for c in p.coeffs()]
    return max(longest, default=0)


def _faddeev(matrix: list[list[Any]]) -> list[Any]:
    """det(λ - B) by powers of λ (Faddeev-LeVerrier), for a matrix of polynomials."""
    n = len(matrix)
    zero, one = fmpq_poly([0]), fmpq_poly([1])
    out = [zero] * n + [one]
    work = [[zero] * n for _ in range(n)]
    for k in range(1, n + 1):
        for i in range(n):
            work[i][i] = work[i][i] + out[n - k + 1]
        work = [
            [_dot(row, [work[m][j] for m in range(n)], zero) for j in range(n)] for row in matrix
        ]
        trace = zero
        for i in range(n):
            trace = trace + work[i][i]
        out[n - k] = trace * fmpq(-1, k)
    return out


def _dot(row: Sequence[Any], column: Sequence[Any], zero: Any) -> Any:
    total = zero
    for x, y in zip(row, column, strict=True):
        if not x.is_zero() and not y.is_zero():
            total = total + x * y
    return total
