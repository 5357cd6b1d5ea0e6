"""A member's eigenvalues on the imaginary axis, by exact algebra where balls cannot decide.

Balls never prove that two eigenvalues coincide, or that one lies on the axis next to others.  The
unknowns of an irrational member obey their equations exactly.  One algebraic unknown spans a number
field, in which every sign is decided.  Otherwise unknowns, and sines or other functions of these,
are indeterminates reduced by the equations: an expression that reduces to zero is zero at the
member, one whose ball excludes zero has the ball's sign, and any other leaves the verdict open.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from flint import arb, arb_poly

from ...algebra.exact.function_field import MOST_TERMS, Expression
from ...algebra.exact.hurwitz_forms import Budget, TooLarge
from ...algebra.exact.number_fields import EXACT, Algebraic, NotExact, rational
from ...algebra.exact.routh import Ground, on_the_axis_over
from ...algebra.exact.triangular import RecordingField, Triangular
from ...algebra.number_types import balls, precision
from ...base.verdict import Verdict
from .identities import MOST_STATES, exact_matrix, whole_polynomial
from .multiplicity import ROOT_BITS, Member

SMALL = 2.0 ** (-ROOT_BITS // 4)
"""Size below which a ball around zero is taken for a zero of an equation's factor."""

MOST_SECONDS = 20.0
"""Longest work with expressions at one member; the verdict is then left open."""


def exact_verdict(member: Member, zeros: int) -> Verdict | None:
    """The verdict of a member without some zero eigenvalues, over the member's own field.

    Parameters
    ----------
    member
        The member.
    zeros
        Number of eigenvalues, proved zero, that are left out.

    Returns
    -------
    Verdict or None
        None where no proof is found.
    """
    large = member.algebraic is None and len(member.family.system.states) > MOST_STATES
    if large or member.enclosed_only or not member.has_value():
        return None
    for reading in READINGS:
        try:
            matrix, ground = reading(member)
            known = member.algebraic if reading is _over_number_field else None
            coefficients = known or whole_polynomial(matrix)
            nonzero = next(i for i, c in enumerate(coefficients) if ground.sign(c))
            # a zero that is proved here alone may be structural, and would have to be left out
            if zeros <= nonzero == member.zeros():
                return on_the_axis_over(ground, coefficients[zeros:])
        except (NotExact, TooLarge, ZeroDivisionError):
            continue
    return None


def _over_number_field(member: Member) -> tuple[list[list[Any]], Ground]:
    """The linearisation over Q, or over Q[u]/(g)."""
    if member.algebraic is None and member.rational is None:
        raise NotExact("no single algebraic unknown")

    def sign(value: Any) -> int:
        if not isinstance(value, Algebraic):
            return int(value > 0) - int(value < 0)
        with precision(ROOT_BITS):
            return 0 if value.poly == 0 else _sign(arb_poly(value.poly)(value.field.root))

    matrix = exact_matrix(member.family, member.a, member.unknowns(), member.q)
    return matrix, Ground(sign, lambda value: value)


def _over_expressions(member: Member) -> tuple[list[list[Any]], Ground]:
    """The linearisation with unknowns and functions as indeterminates, modulo their equations."""
    family = member.family
    field = RecordingField([*family.unknown], Budget(MOST_TERMS, MOST_SECONDS))
    given = [[field.number(v) for v in some] for some in (member.a, member.q)]
    place = [given[0], field.symbols, given[1]]
    matrix = exact_matrix(family, *place)
    equations = family.graph.residual.run(EXACT, place)[0] if member.near is not None else []
    value = _values(member, field)

    def vanishes(poly: Any) -> bool | None:
        ball = value(poly)
        if not ball.contains(0):
            return False if ball.is_finite() else None
        return True if ball.abs_upper() < SMALL else None

    unknowns = set(range(len(family.unknown)))
    free = {i for i in field.meaning if field.uses(i) & unknowns}
    polynomials = [r.num for r in equations if isinstance(r, Expression) and r.num != 0]
    relations = Triangular(field, polynomials, unknowns | free, vanishes)

    def tidy(entry: Any) -> Any:
        if not isinstance(entry, Expression):
            return entry
        entry = relations.value(entry)
        return field.quotient(*relations.reduce([entry.num, entry.den]))

    def sign(entry: Any) -> int:
        if not isinstance(entry, Expression):
            return int(entry > 0) - int(entry < 0)
        entry = tidy(entry)
        return 0 if entry.num == 0 else _sign(value(entry.num) / value(entry.den))

    return [[tidy(entry) for entry in row] for row in matrix], Ground(sign, tidy)


READINGS = _over_number_field, _over_expressions
"""Linearisations of a member in exact numbers with signs, the cheaper first."""


def _sign(ball: Any) -> int:
    if ball > 0 or ball < 0:
        return 1 if ball > 0 else -1
    raise NotExact("a sign that the balls leave open")


def _values(member: Member, field: RecordingField) -> Callable[[Any], Any]:
    """The function from a polynomial in indeterminates to its ball at the member."""
    with precision(ROOT_BITS):
        guesses = [rational(v) for v in member.family.unknown.values()]
        known: dict[int, Any] = dict(enumerate(member.root or member.balls(guesses)))

    def value(poly: Any) -> Any:
        with precision(ROOT_BITS):
            total = arb(0)
            for exponents, c in poly.to_dict().items():
                term = arb(c)
                for index, power in enumerate(exponents):
                    for _ in range(int(power)):  # a power of a ball around 0 is nan
                        term = term * at(index)
                total = total + term
            return total

    def at(index: int) -> Any:
        if index not in known:
            name, x, over = field.meaning[index]
            argument = value(x.num) / value(x.den)
            known[index] = balls().functions[name](argument)
            if name == "sqrt" and over is not None and not over.is_constant():
                known[index] = known[index] * value(over).sgn()
        return known[index]

    return value
