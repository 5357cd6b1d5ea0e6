"""Members of a family in ball arithmetic: proved roots, and the polynomial at these roots."""

from __future__ import annotations

from collections.abc import Sequence
from math import prod
from typing import Any

import numpy as np
from flint import arb, arb_mat, arb_poly, ctx

from ...algebra.krawczyk import contained, operator
from ...algebra.number_types import balls, precision
from ...algebra.program import Program
from ...base.errors import NoMemberError, StabilityError, listing
from ..family import Family
from .places import LARGE, components


def characteristic(family: Family, a: Sequence[Any], q: Sequence[Any]) -> list[Any]:
    """Coefficients of det(λ - A) at a member as balls, lowest first.

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
NARROW = 2.0**-40
"""Largest radius of a given number, relative to it, at which its ball counts as a point."""
INFLATIONS = 4
"""Largest number of boxes in one test; each next box is twice the last image."""


def matrix_polynomial(
    family: Family, a: Sequence[Any], u: Sequence[Any], q: Sequence[Any]
) -> list[Any]:
    """Characteristic polynomial of the linearisation with given unknowns, in balls.

    Values at one member: an expression of it is `polynomials.characteristic`.

    Returns
    -------
    list of arb
        Coefficients, lowest first.
    """
    rows = family.graph.matrix.dense(balls(), [list(a), list(u), list(q)])
    if len(rows) <= LARGE:
        whole: list[Any] = arb_mat(rows).charpoly().coeffs()
        return whole
    places = components(np.array([[not v == 0 for v in row] for row in rows]))
    blocks = [arb_mat([[rows[i][j] for j in some] for i in some]) for some in places]
    product: list[Any] = prod((block.charpoly() for block in blocks), start=arb_poly([1])).coeffs()
    return product


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
    root = _krawczyk(family, a, q, rough)
    # near a double root Newton's method may jump to another root
    if root is None or not all(
        ball.overlaps(arb(float(v), NEARBY * (1 + abs(float(v)))))
        for ball, v in zip(root, rough, strict=True)
    ):
        raise NoMemberError(
            f"{family.name} at {listing(family.at, [float(v) for v in a])}: no root is proved "
            f"within {ctx.prec} bits; the point may be singular."
        )
    return root


def positive_unknowns(
    family: Family, a: Sequence[Any], q: Sequence[Any], near: Sequence[float] | None = None
) -> list[Any]:
    """As `ball_unknowns`; one that must be positive, and is not proved to be, is refused."""
    root = ball_unknowns(family, a, q, near)
    for name, ball in zip(family.unknown, root, strict=True):
        if name in family.positive and not ball > 0:
            raise NoMemberError(f"{family.name}: {name} is not proved to be positive.")
    return root


Given = tuple[Sequence[Any], Sequence[Any]]
"""Family parameters and parameters as balls."""


def in_one_box(family: Family, middle: Given, over: Given, *ends: Given) -> bool:
    """Whether some members are in one box, which has one root for each of the numbers between.

    Parameters
    ----------
    family
        The family.
    middle, over, *ends
        Numbers about whose member the box is, balls over all numbers, and numbers of the members.
    """
    if not family.unknown or family.closed:
        return True
    try:
        near = [float(v.mid()) for v in ball_unknowns(family, *middle)]
        box = ball_unknowns(family, *over, near)
        with precision(2 * ctx.prec):  # narrower than the box, which may be as narrow as one root
            roots = [ball_unknowns(family, *end) for end in ends]
    except (StabilityError, ZeroDivisionError):
        return False
    return all(b.contains(v) for unknowns in roots for b, v in zip(box, unknowns, strict=True))


def _krawczyk(
    family: Family, a: Sequence[Any], q: Sequence[Any], rough: Sequence[float]
) -> list[Any] | None:
    """Krawczyk's test around a rough root: in a box relative to the root, then relative to 1 too.

    A root at 0 has no relative size.
    """
    numbers = [arb(v) for v in (*a, *q)]
    middle = [v.mid() for v in numbers]
    wide = any(v.rad() > NARROW * abs(m) for v, m in zip(numbers, middle, strict=True))
    place = (middle[: len(a)], middle[len(a) :]) if wide else (a, q)
    size, residual = len(rough), family.graph.residual
    x = arb_mat(size, 1, [arb(float(v)) for v in rough])
    half = arb(2) ** (-ctx.prec // 2)
    for _ in range(20):  # a Newton step doubles the digits, as the test below does: stop halfway
        r, r_u = _tables(residual, place[0], x, place[1])
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
        shift = inverse * _tables(residual, place[0], x, place[1])[0]
    if wide:
        root = _along_tangent(family, (numbers, len(a)), x, inverse)
        if root is not None:
            return root
        shift = inverse * _tables(residual, a, x, q)[0]
    for least in (0, 1):
        inside = contained(
            lambda box: _tables(residual, a, x + box, q)[1],
            shift,
            inverse,
            _spread(x, shift, least),
            INFLATIONS,
        )
        if inside is not None:
            return [v + w for v, w in zip(x.entries(), inside[0].entries(), strict=True)]
    return None


def _spread(x: Any, shift: Any, least: int) -> list[Any]:
    """Half-widths of the first box."""
    small = arb(2) ** (16 - ctx.prec)
    pairs = zip(x.entries(), shift.entries(), strict=True)
    return [(3 * s.abs_upper() + (least + abs(v)) * small).abs_upper() for v, s in pairs]


def _along_tangent(
    family: Family, over: tuple[list[Any], int], x: Any, inverse: Any
) -> list[Any] | None:
    """Krawczyk's test for all given numbers in wide balls, about the tangent at their middle.

    The distance of the root from the tangent is of second order in the balls' widths, and is
    bounded by the mean value theorem in these numbers.  The result holds no other root.
    """
    numbers, cut = over
    size = x.nrows()
    a, q = numbers[:cut], numbers[cut:]
    middle = [v.mid() for v in numbers]
    way = arb_mat(len(numbers), 1, [v - m for v, m in zip(numbers, middle, strict=True)])
    along = family.graph.along  # residual, slopes by the unknowns and by the given numbers
    here, _, by_given = _tables(along, middle[:cut], x, middle[cut:])
    turn = (-(inverse * by_given)).mid()
    line = x + turn * way
    _, slope, by_given = _tables(along, a, line, q)
    shift = inverse * here + (inverse * (slope * turn + by_given)) * way
    inside = contained(
        lambda box: _tables(family.graph.residual, a, line + box, q)[1],
        shift,
        inverse,
        _spread(x, shift, 1),
        INFLATIONS,
    )
    if inside is None:
        return None
    hull = line + inside[0]
    # the test says that one root is near the tangent; a regular slope, that one is in the hull
    _, slope = _tables(family.graph.residual, a, hull, q)
    box = arb_mat(size, 1, [arb(0, hull[i, 0].rad().abs_upper()) for i in range(size)])
    left = operator(inverse, slope, box, arb_mat(size, 1))
    if not all(box[i, 0].contains_interior(left[i, 0]) for i in range(size)):
        return None
    root: list[Any] = hull.entries()
    return root


def _tables(program: Program, a: Sequence[Any], x: Any, q: Sequence[Any]) -> list[Any]:
    """The outputs of a program of the family's graph, as matrices of balls."""
    values = program.run(balls(), [list(a), x.entries(), list(q)])
    out = []
    for shape, places, entries in zip(program.shapes, program.places, values, strict=True):
        table = arb_mat(*shape)
        for place, entry in zip(places, entries, strict=True):
            table[place] = entry
        out.append(table)
    return out
