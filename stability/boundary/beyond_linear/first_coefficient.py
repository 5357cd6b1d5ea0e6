"""First Lyapunov coefficient of a crossing pair, or its normal form on a line of steady motions.

With A q = i ω q, |q| = 1, w A = i ω w, w q = 1, and B, C the second and third derivatives,

    l1 = Re [w C(q, q, q̄) - 2 w B(q, A⁻¹ B(q, q̄)) + w B(q̄, (2 i ω - A)⁻¹ B(q, q))] / (2 ω).

Source: Yu. A. Kuznetsov, Elements of Applied Bifurcation Theory, § 5.4 (projection on the critical
eigenspace); B. Fiedler, S. Liebscher & J. C. Alexander, J. Differential Equations 167 (2000) 16-35,
for lines; tests/boundary/test_hopf_any.py compares with normal forms in closed form.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from flint import acb, arb

from ...algebra.routh_balls import hurwitz_sign
from .crossings_proved import (
    Pair,
    bordered,
    direction,
    dot,
    eigenvalue_speed,
    shifted,
    solve,
)
from .krawczyk import NotProvedError

Balls = list[Any]


@dataclass(frozen=True)
class Coefficients:
    """What decides at a crossing pair, in balls."""

    speed: Any
    """d Re λ / d axis."""
    first: Any
    """l1."""
    others: int
    """1: every other eigenvalue is proved to be stable; -1: one is unstable; 0: open."""


def coefficients(pair: Pair) -> Coefficients:
    """The first Lyapunov coefficient at a crossing pair, and the speed of the crossing.

    Parameters
    ----------
    pair
        The pair, proved.

    Raises
    ------
    NotProvedError
        If zero or twice the pair is not proved to be no eigenvalue.
    """
    line, kept = pair.line, pair.line.d.kept
    x, p = pair.point
    matrix, w, q = pair.matrix, pair.frequency, pair.mode
    left = bordered(shifted(matrix, acb(0, 1) * w), q)
    conjugate = [v.conjugate() for v in q]

    def whole(v: Balls) -> Balls:
        out = [acb(0)] * len(x)
        for i, c in zip(kept, v, strict=True):
            out[i] = c
        return out

    def second(u: Balls, v: Balls) -> Balls:
        found = line.second(x, p, whole(u), whole(v))
        return [acb(found[i]) for i in kept]

    cubic = line.third(x, p, whole(q), whole(q), whole(conjugate))
    total = dot(left, [acb(cubic[i]) for i in kept])
    mean = solve(shifted(matrix, acb(0)), second(q, conjugate))
    total = total - 2 * dot(left, second(q, mean))
    double = solve(shifted(matrix, acb(0, 2) * w), [-v for v in second(q, q)])
    total = total + dot(left, second(conjugate, double))
    first = total.real / (2 * w)
    speed = eigenvalue_speed(pair, left, q).real
    return Coefficients(speed, first, others(pair))


def others(pair: Pair, zeros: int = 0) -> int:
    """Whether every eigenvalue but the pair and structural zeros is stable.

    Parameters
    ----------
    pair
        The pair.
    zeros
        Number of structural zeros over the kept states.

    Returns
    -------
    int
        1 stable, -1 one is unstable, 0 open.
    """
    rest = list(pair.matrix.charpoly().coeffs())
    square = pair.frequency**2
    out = []
    for k in range(len(rest) - 1, 1, -1):  # division by λ² + ω², highest power first
        out.append(rest[k])
        rest[k - 2] = rest[k - 2] - square * rest[k]
    quotient = out[::-1][zeros:]
    return hurwitz_sign(quotient) if len(quotient) > 1 else 1


@dataclass(frozen=True)
class LineForm:
    """Coefficients of a Hopf bifurcation without parameters, in balls."""

    speed: Any
    """Re μ' per unit of the axis."""
    push: Any
    """c for the mode of unit length."""


def line_form(pair: Pair) -> LineForm:
    """The normal form at a crossing pair along a line of steady motions.

    Parameters
    ----------
    pair
        The pair, proved; its axis is a state, so that the family is a line.

    Raises
    ------
    NotProvedError
        If zero is not proved to be a simple eigenvalue.
    """
    line, kept = pair.line, pair.line.d.kept
    x, p = pair.point
    along, _ = direction(line, x, p)
    tangent = [acb(along[i]) for i in kept]
    matrix, q = pair.matrix, pair.mode
    left = bordered(shifted(matrix, acb(0, 1) * pair.frequency), q)
    across = bordered(shifted(matrix, acb(0)), tangent)

    def whole(v: Balls) -> Balls:
        out = [acb(0)] * len(x)
        for i, c in zip(kept, v, strict=True):
            out[i] = c
        return out

    pushed = line.second(x, p, whole(q), whole([v.conjugate() for v in q]))
    push = dot(across, [acb(pushed[i]) for i in kept])
    return LineForm(eigenvalue_speed(pair, left, q).real, push.real)


def signed(ball: Any) -> int:
    """Sign of a ball; 0 where it holds zero or is not finite."""
    number = arb(ball)
    if not number.is_finite():
        raise NotProvedError
    return 1 if number > 0 else -1 if number < 0 else 0
