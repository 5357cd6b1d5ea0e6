"""Members of a family in ball arithmetic: proved roots, and the polynomial at these roots."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from flint import arb, arb_mat, ctx

from ...algebra.number_types import balls
from ...base.errors import NoMemberError
from ..family import Family, listing


def characteristic(family: Family, a: Sequence[Any], q: Sequence[Any]) -> list[Any]:
    """Coefficients of det(λ - A) at a member as balls, lowest first.

    Parameters
    ----------
    family
        The family.
    a, q
        Family parameters and parameters as balls (or exact numbers).

    Returns
    -------
    list of arb
        n + 1 coefficients, structural zeros included.

    Raises
    ------
    NoMemberError
        If no root is proved to exist there.
    """
    return matrix_polynomial(family, a, ball_unknowns(family, a, q), q)


NEARBY = 1e-6
"""Largest distance of a proved root from the double-precision root, over 1 plus its size."""
INFLATIONS = 4
"""Largest number of boxes in one test; each next box is twice the last image."""


def matrix_polynomial(
    family: Family, a: Sequence[Any], u: Sequence[Any], q: Sequence[Any]
) -> list[Any]:
    """Characteristic polynomial of the linearisation with given unknowns, in balls.

    Parameters
    ----------
    family
        The family.
    a, u, q
        Family parameters, unknowns and parameters as balls.

    Returns
    -------
    list of arb
        Coefficients, lowest first.
    """
    matrix = arb_mat(family.graph.matrix.dense(balls(), [list(a), list(u), list(q)]))
    out: list[Any] = matrix.charpoly().coeffs()
    return out


def ball_unknowns(
    family: Family, a: Sequence[Any], q: Sequence[Any], near: Sequence[float] | None = None
) -> list[Any]:
    """The unknowns as balls in which a root is proved to lie (Krawczyk's test).

    Parameters
    ----------
    family
        The family.
    a, q
        Family parameters and parameters as balls.
    near
        Unknowns to double precision; found by the family's root-finder when left out.

    Returns
    -------
    list of arb

    Raises
    ------
    NoMemberError
        If the test fails.

    Source: R. Krawczyk, Computing 4 (1969) 187-201.
    """
    if not family.unknown or family.closed:
        return [arb(v) for v in family.unknown.values()]
    rough = near
    if rough is None:
        point = ([float(v.mid()) for v in a], [float(v.mid()) for v in q])
        rough = family.solve(*(np.array([part]).reshape(1, -1) for part in point))[0]
    found = _krawczyk(family, a, q, rough)
    # near a double root Newton's method may jump to another root
    if found is None or not all(
        ball.overlaps(arb(float(v), NEARBY * (1 + abs(float(v)))))
        for ball, v in zip(found, rough, strict=True)
    ):
        raise NoMemberError(
            f"{family.name} at {listing(family.at, [float(v) for v in a])}: no root is proved "
            f"within {ctx.prec} bits; the point may be singular."
        )
    return found


def _krawczyk(
    family: Family, a: Sequence[Any], q: Sequence[Any], rough: Sequence[float]
) -> list[Any] | None:
    """Krawczyk's test around a rough root: in a box relative to the root, then relative to 1 too.

    A root at 0 has no relative size.
    """
    size = len(rough)
    x = arb_mat(size, 1, [arb(float(v)) for v in rough])
    half = arb(2) ** (-ctx.prec // 2)
    for _ in range(20):  # a Newton step doubles the digits, as the test below does: stop halfway
        r, r_u = _residual(family, a, x, q)
        try:
            inverse = r_u.mid().inv().mid()
        except ZeroDivisionError:
            raise NoMemberError(
                f"{family.name} at {listing(family.at, [float(v) for v in a])}: the equations are "
                "singular there, so no isolated root is proved."
            ) from None
        shift = inverse * r
        if all(abs(shift[i, 0]) <= half * abs(x[i, 0]) for i in range(size)):
            break
        x = (x - shift).mid()
    else:  # the operator needs the residual at the last point, not at the point before
        shift = _shift(family, a, x, q, inverse)
    one = arb_mat(size, size, [int(i == j) for i in range(size) for j in range(size)])
    for least in (0, 1):
        small = arb(2) ** (16 - ctx.prec)
        spread = [
            (3 * shift[i, 0].abs_upper() + (least + abs(x[i, 0])) * small).abs_upper()
            for i in range(size)
        ]
        for _ in range(INFLATIONS):
            box = arb_mat(size, 1, [x[i, 0] + arb(0, spread[i]) for i in range(size)])
            _, slope = _residual(family, a, box, q)
            image = x - shift + (one - inverse * slope) * (box - x)
            if all(box[i, 0].contains_interior(image[i, 0]) for i in range(size)):
                return [image[i, 0] for i in range(size)]
            # an unknown's image may be wide only because the other unknowns are wide
            moved = [(2 * (image[i, 0] - x[i, 0])).abs_upper() for i in range(size)]
            spread = [max(s, m) for s, m in zip(spread, moved, strict=True)]
    return None


def _shift(family: Family, a: Sequence[Any], x: Any, q: Sequence[Any], inverse: Any) -> Any:
    """A Newton step from a point, for all given numbers in their balls.

    By the mean value theorem in these numbers, since equations share terms that cancel in the step.
    Where the theorem does not apply, or is wider, the balls are put into the equations themselves.
    """
    size = x.nrows()
    plain = inverse * _residual(family, a, x, q)[0]
    given = [*a, *q]
    middle = [arb(v).mid() for v in given]
    here = _residual(family, middle[: len(a)], x, middle[len(a) :])[0]
    u = [x[i, 0] for i in range(size)]
    slopes = arb_mat(family.graph.along.dense(balls(), [list(a), u, list(q)], 2))
    way = arb_mat(len(given), 1, [v - m for v, m in zip(given, middle, strict=True)])
    mean = inverse * here + (inverse * slopes) * way
    pairs = zip(plain.entries(), mean.entries(), strict=True)
    return arb_mat(size, 1, [m if m.rad() < p.rad() else p for p, m in pairs])


def _residual(family: Family, a: Sequence[Any], x: Any, q: Sequence[Any]) -> tuple[Any, Any]:
    size = x.nrows()
    u = [x[i, 0] for i in range(size)]
    r, r_u = family.graph.residual.run(balls(), [list(a), u, list(q)])
    dense = family.graph.place(r_u)
    return arb_mat(size, 1, r), arb_mat(dense)
