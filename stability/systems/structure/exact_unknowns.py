"""The unknowns of a member as exact numbers: rational, or elements of one number field.

A number is recognised from its digits, and then proved: the exact numbers solve the equations, and
lie in balls that hold no other root.

Source: A. K. Lenstra, H. W. Lenstra, L. Lovász, Math. Ann. 261 (1982) 515-534, for the integer
relations; tests/systems/test_irrational_members.py.
"""

from __future__ import annotations

from collections.abc import Sequence
from contextlib import suppress
from typing import Any

from flint import arb, arb_poly, ctx, fmpq, fmpq_poly, fmpz, fmpz_mat

from ...algebra.exact.function_field import FunctionField
from ...algebra.exact.number_fields import EXACT, Algebraic, NotExact, NumberField, vanishes
from ...algebra.number_types import precision
from ..family import Family

MOST_DEGREE = 6
"""Largest degree of a number field that is recognised from digits."""


def exact_unknowns(
    family: Family, given: tuple[Sequence[Any], Sequence[Any]], root: list[Any], wide: list[Any]
) -> list[Any]:
    """The unknowns of a member as rationals or as elements of one number field.

    Parameters
    ----------
    family
        The family.
    given
        Family parameters and parameters, rationals.
    root
        Balls with the unknowns at the current precision.
    wide
        Wider balls around these, which hold no other root of the equations.

    Raises
    ------
    NotExact
        If no such numbers are found.
    """
    simple = [_simplest(ball) for ball in root]
    if None not in simple and _solve(family, given, simple):
        return simple
    if len(root) == 1:
        with suppress(NotExact):
            return [_of_equation(family, given, root[0])]
    if None not in simple:
        raise NotExact("rationals that do not solve the equations")
    found = _recognised(root, simple, wide)
    if not _solve(family, given, found):
        raise NotExact("unknowns beyond one number field")
    return found


def _solve(family: Family, given: tuple[Sequence[Any], Sequence[Any]], u: list[Any]) -> bool:
    """Whether numbers solve the equations exactly."""
    try:
        residual, _ = family.graph.residual.run(EXACT, [given[0], u, given[1]])
    except ZeroDivisionError:
        return False
    return all(vanishes(r) for r in residual)


def _of_equation(family: Family, given: tuple[Sequence[Any], Sequence[Any]], ball: Any) -> Any:
    """A single unknown as an element of its number field over Q, from its own equation."""
    field = FunctionField(["u"])
    a, q = ([field.number(v) for v in some] for some in given)
    residual, _ = family.graph.residual.run(EXACT, [a, field.symbols, q])
    terms = residual[0].num.to_dict()
    if any(any(exponents[1:]) for exponents in terms):
        raise NotExact("an equation that is not algebraic")
    coefficients = [fmpq(0)] * (1 + max(int(e[0]) for e in terms))
    for exponents, coefficient in terms.items():
        coefficients[int(exponents[0])] = coefficient
    _, factors = fmpq_poly(coefficients).numer().factor()
    near = [f for f, _ in factors if arb_poly(f.coeffs())(ball).contains(0)]
    if len(near) != 1:
        raise NotExact("a root that two factors share")
    return NumberField(fmpq_poly(near[0].coeffs()), ball).generator


# --- from digits ---


def _recognised(root: list[Any], simple: list[Any], wide: list[Any]) -> list[Any]:
    """The unknowns over the field of the first that is not rational."""
    first = simple.index(None)
    field = _field(root[first])
    powers = [root[first] ** k for k in range(field.modulus.degree())]
    out = []
    for ball, number, room in zip(root, simple, wide, strict=True):
        if number is not None:
            out.append(number)
            continue
        *terms, own = _relation([*powers, ball])
        if not own:
            raise NotExact("an unknown of another field")
        poly = fmpq_poly([fmpq(-c, own) for c in terms])
        if not room.contains(arb_poly(poly)(root[first])):
            raise NotExact("an unknown of another field")
        out.append(Algebraic(field, field.reduced(poly)))
    return out


def _field(ball: Any) -> NumberField:
    """The number field of a number that is known to many digits."""
    for degree in range(2, MOST_DEGREE + 1):
        with suppress(NotExact):
            relation = fmpq_poly(_relation([ball**k for k in range(degree + 1)]))
            _, factors = relation.numer().factor()
            for factor, _ in factors:
                if _one_root(factor, ball):
                    return NumberField(fmpq_poly(factor.coeffs()), ball)
    raise NotExact("no number field of small degree")


def _one_root(poly: Any, ball: Any) -> bool:
    """Whether a ball is proved to hold one root of an irreducible polynomial, no more."""
    coefficients = poly.coeffs()
    with precision(2 * ctx.prec):
        f, slope = arb_poly(coefficients), arb_poly(coefficients).derivative()
        ends = f(ball.lower()), f(ball.upper())
        return bool((ends[0] * ends[1] < 0) and not slope(ball).contains(0))


def _relation(numbers: Sequence[Any]) -> list[Any]:
    """Small integers with a vanishing sum of products, as far as the digits show (LLL)."""
    # an exact number has digits without end, for which the library has no memory
    bits = min(ctx.prec, *(int(v.rel_accuracy_bits()) for v in numbers)) - 8
    if bits < 1:
        raise NotExact("too few digits")
    rows = []
    for i, v in enumerate(numbers):
        scaled = (v.mid() * arb(fmpz(1) << bits)).mid().floor().mid()
        rows.append([int(i == j) for j in range(len(numbers))] + [int(scaled.fmpq().p)])
    short = [int(c) for c in fmpz_mat(rows).lll().tolist()[0]]
    if sum(abs(c).bit_length() for c in short) > bits // 2:
        raise NotExact("no small relation")
    return short[:-1]


def _simplest(ball: Any) -> Any:
    """The rational of least denominator in a ball, by continued fractions; None if it is large."""
    before, here = (0, 1), (1, 0)  # numerators and denominators (p, q) of the convergents
    rest = ball.mid().fmpq()
    for _ in range(ctx.prec):
        whole = int(rest.floor())
        before, here = here, (whole * here[0] + before[0], whole * here[1] + before[1])
        found = fmpq(*here)
        if ball.contains(arb(found)):
            return found if here[1].bit_length() < ctx.prec // 3 else None
        rest = rest - whole
        if rest == 0:
            return None
        rest = 1 / rest
    return None
