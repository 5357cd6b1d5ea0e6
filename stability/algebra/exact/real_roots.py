"""Proved real roots of polynomials along an axis: isolated over Q, or at a given sine.

Source: F. Johansson, IEEE Trans. Comput. 66 (2017) 1281-1292 (Arb, whose isolation is used).
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

from flint import arb, arb_poly, fmpq_poly

from ..balls import precision
from .isolation import halved_roots
from .rational_functions import univariate
from .root_balls import isolated

BITS = 256
"""Working precision of the first attempt."""
MOST_BITS = 16384
"""Largest working precision."""
WIDE = 2000
"""Binary digits of a coefficient above which real roots are isolated by halving."""


class UnclearError(ArithmeticError):
    """The precision does not separate two numbers."""


def complex_roots(p: Any) -> list[Any]:
    """Isolated roots with multiplicities of an `fmpq_poly`; an empty list for a constant.

    Parameters
    ----------
    p
        The polynomial, not zero.
    """
    if p.degree() < 1:
        return []
    found: list[Any] = p.numer().complex_roots()
    return found


def specialised(p: Any, x: Any) -> Any:
    """An element of the ring at one x, as a polynomial in its second variable.

    Parameters
    ----------
    p
        Element of `RING`, in x and s.
    x
        Value of the axis, a rational.
    """
    out: dict[int, Any] = {}
    for (_, j), c in p.subs({"x": x}).terms():
        out[int(j)] = c
    return fmpq_poly([out.get(i, 0) for i in range(max(out, default=-1) + 1)])


def sign_at(p: Any, x: Any, sine: Callable[[], Any] | None) -> int:
    """Sign of a polynomial at a rational x and the given sine.

    Parameters
    ----------
    p
        Polynomial in x and s.
    x
        Value of the axis, a rational.
    sine
        Function that returns the ball of s at the working precision; None without s.  The sine
        is transcendental, so that only a polynomial that vanishes for every s is zero.

    Raises
    ------
    UnclearError
        If the budget of precision ends.
    """
    value = specialised(p, x)
    if value.degree() < 1:
        exact = value[0]
        return int(exact > 0) - int(exact < 0)
    assert sine is not None
    bits = BITS
    while bits <= MOST_BITS:
        with precision(bits):
            ball = arb_poly(value)(sine())
            if not ball.contains(0):
                return 1 if ball > 0 else -1
        bits *= 2
    raise UnclearError


def real_roots(polynomials: Sequence[Any], sine: Callable[[], Any] | None) -> list[Any]:
    """Every distinct real root in x of some polynomials, in balls that do not overlap.

    Parameters
    ----------
    polynomials
        Polynomials in x and perhaps s, none zero.
    sine
        As for `sign_at`.

    Returns
    -------
    list of arb
        In increasing order, at the working precision.

    Raises
    ------
    UnclearError
        If the working precision does not separate the roots.

    Examples
    --------
    >>> from stability.algebra.exact.rational_functions import RING
    >>> x = RING.gens()[0]
    >>> [float(r) for r in real_roots([x**2 - 4, (x - 2) ** 2 * (x**2 + 1)], None)]
    [-2.0, 2.0]
    """
    apart: list[Any] = []  # squarefree, no two with a common root
    for p in polynomials:
        slope = p.derivative("x")
        if slope.is_zero():
            continue
        rest = p / p.gcd(slope)
        for other in apart:
            rest = rest / rest.gcd(other)
        if not rest.derivative("x").is_zero():
            apart.append(rest)
    found: list[Any] = []
    for p in apart:  # one by one: nearly equal roots of two polynomials are slow to separate
        if p.degrees()[1] == 0:
            found += _rational_roots(univariate(p).numer())
        else:
            assert sine is not None
            found += _ball_roots(p, sine())
    found.sort(key=lambda r: r.mid())
    if any(not low < high for low, high in zip(found[:-1], found[1:], strict=True)):
        raise UnclearError
    return found


def _rational_roots(p: Any) -> list[Any]:
    """Real roots of a squarefree polynomial over Z."""
    if max(abs(int(c)).bit_length() for c in p.coeffs()) > WIDE:
        return halved_roots(p)
    return [r.real for r, _ in p.complex_roots() if r.imag == 0]


def _ball_roots(product: Any, sine: Any) -> list[Any]:
    """Real roots of a squarefree polynomial whose coefficients are polynomials in the sine."""
    rows: dict[int, list[Any]] = {}
    for (i, j), c in product.terms():
        row = rows.setdefault(int(i), [])
        row += [arb(0)] * (int(j) + 1 - len(row))
        row[int(j)] = arb(c)
    coefficients = [arb_poly(rows.get(i, []))(sine) for i in range(max(rows) + 1)]
    roots = isolated(coefficients, even=False)
    if roots is None:
        raise UnclearError
    return [r.real for r in roots if r.imag == 0]
