"""Members of a family in ball arithmetic: roots proved to exist, and what the graph gives there."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from flint import arb, arb_mat, ctx

from ..algebra.number_types import balls
from ..base.errors import NoMemberError
from .family import Family, listing


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
"""Largest distance of a proved root from the one in double precision, over 1 or its size."""
INFLATIONS = 4
"""How often a box is widened to what its image was."""


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
        Unknowns to start from, where they are known to double precision.

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
    # next to a double root Newton's method may leave for another one
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
    """The test around a rough root: in a box of its own size first, then in one of size 1.

    A root at 0 has no size of its own.
    """
    size = len(rough)
    x = arb_mat(size, 1, [arb(float(v)) for v in rough])
    half = arb(2) ** (-ctx.prec // 2)
    for _ in range(20):  # Newton doubles the digits, and so does the test below: stop halfway
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
    else:  # the operator belongs to the last point, not to the one before it
        shift = inverse * _residual(family, a, x, q)[0]
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
            # a root that does not move with the others is wide because they are
            moved = [(2 * (image[i, 0] - x[i, 0])).abs_upper() for i in range(size)]
            spread = [max(s, m) for s, m in zip(spread, moved, strict=True)]
    return None


def _residual(family: Family, a: Sequence[Any], x: Any, q: Sequence[Any]) -> tuple[Any, Any]:
    size = x.nrows()
    u = [x[i, 0] for i in range(size)]
    r, r_u = family.graph.residual.run(balls(), [list(a), u, list(q)])
    dense = family.graph.place(r_u)
    return arb_mat(size, 1, r), arb_mat(dense)
