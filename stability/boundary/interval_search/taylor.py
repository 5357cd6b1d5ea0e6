"""Taylor forms in one variable: coefficients at the midpoint, and a remainder over the piece.

A form of order K on a piece [m - h, m + h] is a list of K + 1 balls (or matrices of balls).  With
t = (p - m)/h from -1 to 1, the function lies in c₀ + c₁ t + … + c_K t^K, where c_K is a ball that
holds the K-th Taylor coefficient at every p of the piece.

Source: R. E. Moore, Methods and Applications of Interval Analysis (1979), ch. 3;
tests/boundary/test_interval_search.py.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from functools import lru_cache
from typing import Any

from flint import arb, arb_mat, arb_series, ctx

from ...algebra.number_types import UNARY, Algebra, ball_angle, ball_power, balls
from ...base.errors import StabilityError
from ...systems.family import Family
from ...systems.graph.family_graph import by_argument

UNIT = arb(0, 1)
"""Every t of a piece."""
HALF = arb(0.5, 0.5)
"""Every even power of t."""


@contextmanager
def terms(count: int) -> Iterator[None]:
    """A context in which power series have a given number of terms; within `precision` only.

    Raises
    ------
    ZeroDivisionError
        If a series is divided by one whose first coefficient may be zero, as balls are.
    """
    before = ctx.cap
    ctx.cap = count
    try:
        yield
    except StabilityError:
        raise
    except ValueError as error:  # of FLINT, where balls would give NaN
        raise ZeroDivisionError(str(error)) from None
    finally:
        ctx.cap = before


def coefficient(value: Any, index: int) -> Any:
    """A Taylor coefficient of a series or of a number."""
    if isinstance(value, arb_series):
        return value[index]
    return arb(value) if index == 0 else arb(0)


# --- functions of series ---


def _composed(x: Any, outer: Callable[[Any, int], list[Any]]) -> Any:
    """f(x) for a series x, from the Taylor coefficients of f at its constant term."""
    rest = arb_series([0, *[x[k] for k in range(1, ctx.cap)]])
    out = arb_series([0])
    for c in reversed(outer(x[0], ctx.cap)):
        out = out * rest + c
    return out


def _hyperbolic(first: str, second: str) -> Callable[[Any], Any]:
    def outer(at: Any, count: int) -> list[Any]:
        values = getattr(at, first)(), getattr(at, second)()
        out, factorial = [], arb(1)
        for k in range(count):
            factorial = factorial * max(k, 1)
            out.append(values[k % 2] / factorial)
        return out

    return lambda x: _composed(x, outer) if isinstance(x, arb_series) else getattr(x, first)()


def _tanh(x: Any) -> Any:
    def outer(at: Any, count: int) -> list[Any]:
        out = [at.tanh(), 1 / at.cosh() ** 2]
        for k in range(1, count):  # y' = 1 - y²
            out.append(-sum((out[i] * out[k - i] for i in range(k + 1)), arb(0)) / (k + 1))
        return out[:count]

    return _composed(x, outer) if isinstance(x, arb_series) else arb(x).tanh()


def _fabs(x: Any) -> Any:
    if not isinstance(x, arb_series):
        return abs(arb(x))
    if x[0] > 0:
        return x
    if x[0] < 0:
        return -x
    return arb_series([abs(x[0]), *[arb("nan")] * (ctx.cap - 1)])


def _power(x: Any, y: Any) -> Any:
    if not isinstance(x, arb_series) and not isinstance(y, arb_series):
        return ball_power(arb(x), arb(y))
    if not isinstance(y, arb_series):
        twice = 2 * arb(y)
        if twice.is_integer() and abs(twice) < 128:
            count = int(float(twice))
            base = x.sqrt() if count % 2 else x
            power = base ** (abs(count) if count % 2 else abs(count) // 2)
            return power if count >= 0 else 1 / power
    return (y * _plain("log")(x)).exp()


def _plain(name: str) -> Callable[[Any], Any]:
    def plain(x: Any) -> Any:
        return getattr(x if isinstance(x, arb_series) else arb(x), name)()

    return plain


LACKING = ("expm1", "log1p", "asinh", "acosh", "atanh")
"""Functions that power series lack, found from their derivatives."""


def _by_slope(name: str, slope: Callable[[Any], Any]) -> Callable[[Any], Any]:
    def integrated(x: Any) -> Any:
        if not isinstance(x, arb_series):
            return getattr(arb(x), name)()
        return (slope(x) * x.derivative()).integral() + getattr(x[0], name)()

    return integrated


def _angle(y: Any, x: Any) -> Any:
    """The angle of (x, y): its slope is (x dy - y dx)/(x² + y²)."""
    if not isinstance(x, arb_series) and not isinstance(y, arb_series):
        return ball_angle(y, x)
    y, x = (v if isinstance(v, arb_series) else arb_series([v]) for v in (y, x))
    turn = (x * y.derivative() - y * x.derivative()) / (x * x + y * y)
    return turn.integral() + ball_angle(y[0], x[0])


@lru_cache(maxsize=1)
def series_algebra() -> Algebra:
    """Power series with balls as coefficients, as long as `terms` says.

    Examples
    --------
    >>> with terms(2):
    ...     y = series_algebra().functions["tanh"](arb_series([0, 1]))
    >>> float(y[0]), float(y[1])
    (0.0, 1.0)
    """
    table: dict[str, Callable[..., Any]] = {n: _plain(n) for n in UNARY}
    slopes = by_argument(table)
    table |= {n: _by_slope(n, slopes[n]) for n in LACKING} | {"atan2": _angle}
    table |= {"sinh": _hyperbolic("sinh", "cosh"), "cosh": _hyperbolic("cosh", "sinh")}
    return Algebra("series", arb, table | {"tanh": _tanh, "pow": _power, "fabs": _fabs})


# --- a family ---


def linearisation(
    family: Family, a: Sequence[Any], q: Sequence[Any], start: Sequence[Any], count: int
) -> list[Any]:
    """Taylor coefficients of a linearisation; within `terms` only.

    Parameters
    ----------
    family
        The family.
    a, q
        Family parameters and parameters as series.
    start
        The unknowns at the constant terms, as balls.
    count
        Number of coefficients.
    """
    entries = entries_of(family, a, q, start, count)
    size = len(family.system.states)
    out = []
    for k in range(count):
        table = [[arb(0)] * size for _ in range(size)]
        for (i, j), entry in zip(family.graph.matrix.places[0], entries, strict=True):
            table[i][j] = coefficient(entry, k)
        out.append(arb_mat(table))
    return out


def entries_of(
    family: Family, a: Sequence[Any], q: Sequence[Any], start: Sequence[Any], count: int
) -> list[Any]:
    """As `linearisation`, the entries that are not zero for all members, as series or numbers."""
    u = _unknowns(family, a, q, start, count)
    entries: list[Any] = family.graph.matrix.run(series_algebra(), [a, u, q])[0]
    return entries


def _unknowns(
    family: Family, a: Sequence[Any], q: Sequence[Any], start: Sequence[Any], count: int
) -> Sequence[Any]:
    """The unknowns as power series, coefficient by coefficient (implicit function theorem)."""
    if not family.unknown or family.closed or count == 1:
        return start
    plain = [[coefficient(v, 0) for v in some] for some in (a, q)]
    _, stored = family.graph.residual.run(balls(), [plain[0], start, plain[1]])
    slope = arb_mat(family.graph.place(stored))
    series = [[u] for u in start]
    for k in range(1, count):
        u = [arb_series([*c, 0]) for c in series]
        rates, _ = family.graph.residual.run(series_algebra(), [a, u, q])
        right = arb_mat(len(series), 1, [-coefficient(r, k) for r in rates])
        solved = slope.solve(right, algorithm="precond")
        for i, c in enumerate(series):
            c.append(solved[i, 0])
    return [arb_series(c) for c in series]


# --- forms ---


def product(p: Sequence[Any], q: Sequence[Any], *, fold: bool) -> list[Any]:
    """Product of two forms of the same order.

    Parameters
    ----------
    p, q
        Coefficients: balls, or matrices of balls.
    fold
        Whether higher powers join the last coefficient.  Without this the lists are truncated
        series at one unknown point of the piece.
    """
    top = len(p) - 1
    out = []
    for k in range(top + 1):
        total = p[0] * q[k]
        for i in range(1, k + 1):
            total = total + p[i] * q[k - i]
        out.append(total)
    for k in range(top + 1, 2 * top + 1) if fold else ():
        total = p[k - top] * q[top]
        for i in range(k - top + 1, top + 1):
            total = total + p[i] * q[k - i]
        out[top] = out[top] + total * (HALF if (k - top) % 2 == 0 else UNIT)
    return out


def quotient(p: Sequence[Any], q: Sequence[Any], *, fold: bool) -> list[Any]:
    """Quotient of two forms of balls of the same order.

    Parameters
    ----------
    p, q
        Coefficients; no value of q is zero, otherwise the result is not finite.
    fold
        As for `product`.
    """
    inverse = [1 / q[0]]
    for k in range(1, len(q)):
        total = sum((q[i] * inverse[k - i] for i in range(1, k + 1)), arb(0))
        inverse.append(-total * inverse[0])
    if fold and len(q) > 1:
        # 1/q = s + (1 - q s)/q, where s is the truncated series
        short = [*inverse[:-1], arb(0)]
        left = product(q, short, fold=True)
        rest = [1 - left[0], *[-c for c in left[1:]]]
        # its first coefficients vanish by construction: what remains is of the last order
        tail = rest[-1] / span(q)
        inverse = [*inverse[:-1], tail]
    return product(p, inverse, fold=fold)


def span(form: Sequence[Any]) -> Any:
    """A ball that holds every value of a form of balls over its piece."""
    total = form[0]
    for k, c in enumerate(form[1:], 1):
        total = total + c * (HALF if k % 2 == 0 else UNIT)
    return total
