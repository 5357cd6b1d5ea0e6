"""Systems of polynomial equations brought to triangular form, on the branch of given samples.

Unknowns that occur linearly are solved for.  Of the others each keeps one equation, by which
powers of this unknown are reduced.  An equation that factors keeps the factor that vanishes at the
samples, so the result holds on one branch; the polynomials that must not vanish are recorded.

Source: W.-T. Wu, J. Autom. Reason. 2 (1986) 221-252 (characteristic sets by pseudo-division).
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np

from .function_field import Expression, FunctionField, occurring
from .hurwitz_forms import by_power, factors
from .number_fields import NotExact

MOST_STEPS = 200
"""Most steps of elimination."""


def inserted(field: FunctionField, poly: Any, index: int, value: Expression) -> Expression:
    """A polynomial with an expression in place of one indeterminate."""
    parts = by_power(poly, index) if poly != 0 else {}
    degree = max(parts, default=0)
    if degree == 0:
        return field.quotient(poly, field.one)
    top = field.ring.constant(0)
    for power, part in parts.items():
        top = top + field.reduced(part * value.num**power * value.den ** (degree - power))
    return field.quotient(top, value.den**degree)


def remainder(
    poly: Any, divisor: Any, index: int, reduced: Callable[[Any], Any] = lambda p: p
) -> tuple[Any, Any, int]:
    """Pseudo-remainder in one variable.

    Parameters
    ----------
    poly, divisor
        Polynomials.
    index
        Index of the variable.
    reduced
        Function that brings a polynomial to its normal form.

    Returns
    -------
    rest, lead, count
        lead^count · poly is rest modulo the divisor.
    """
    x = divisor.context().gens()[index]
    below = by_power(divisor, index)
    degree = max(below)
    lead, tail = below[degree], divisor - below[degree] * x**degree
    count = 0
    while poly != 0:
        parts = by_power(poly, index)
        high = max(parts)
        if high < degree:
            break
        shifted = parts[high] * x ** (high - degree)
        rest = poly - parts[high] * x**high
        if lead.is_constant():
            poly = reduced(rest - shifted * tail / lead.leading_coefficient())
        else:
            poly, count = reduced(rest * lead - shifted * tail), count + 1
    return poly, lead, count


class Triangular:
    """Equations in triangular form.

    Parameters
    ----------
    field
        The field of the equations.
    equations
        Polynomials that vanish.
    unknowns
        Indices of the indeterminates that depend on the equations.
    vanishes
        Function from a polynomial to True (zero at every sample), False (at none) or None.
    """

    def __init__(
        self,
        field: FunctionField,
        equations: Sequence[Any],
        unknowns: set[int],
        vanishes: Callable[[Any], bool | None],
    ) -> None:
        self.field, self.unknowns, self._vanishes = field, unknowns, vanishes
        self.solved: dict[int, Expression] = {}
        """Unknowns in closed form, by index."""
        self.kept: list[tuple[int, Any]] = []
        """(index of the unknown, its equation), in the order of reduction."""
        self.nonzero: list[Any] = []
        """Polynomials that do not vanish on this branch."""
        self.crossed: list[Any] = []
        """Those that vanish where another branch crosses this one, which goes on through there."""
        self.alone = True
        """Whether no factor of an equation was left aside whose zeros may be other branches."""
        self._steps = 0
        self._open = list(equations)
        for index in [i for i in field.squares if i in unknowns]:
            self._open.append(field.generator(index) ** 2 - field.squares.pop(index))
        for _ in range(MOST_STEPS):
            if not self._step():
                return
        raise NotExact("the elimination does not end")

    def _step(self) -> bool:
        self._open = [f for f in map(self.field.reduced, self._open) if f != 0]
        self._open = [self._branch(place) for place in range(len(self._open))]
        self._steps += 1
        return bool(self._open) and (self._linear() or self._lower())

    def _branch(self, place: int) -> Any:
        """The factors of an equation that vanish at the samples."""
        out = self.field.one
        for factor, _ in factors(self._open[place])[1]:
            state = self._vanishes(factor)
            if state is False:
                if factor not in self.nonzero and not factor.is_constant():
                    self.crossed.append(factor)
                self._exclude(factor)
                self.alone = self.alone and self._without_members(place, factor)
            elif state:
                out = out * factor
            else:
                raise NotExact("the samples lie on several branches")
        if out.is_constant():
            raise NotExact("the equations contradict each other")
        return out

    def _without_members(self, place: int, factor: Any) -> bool:
        """Whether the equations have no regular root where a factor of one of them is zero.

        There the slopes of this equation are those of the factor, times a number: with too few
        unknowns in some of the equations they are singular.
        """
        if not occurring(factor) & self.unknowns:
            return True
        if self._steps:  # equations that were multiplied have the same roots on this branch alone
            return False
        from scipy.sparse import csr_array
        from scipy.sparse.csgraph import structural_rank

        equations = [*self._open[:place], factor, *self._open[place + 1 :]]
        pattern = np.array([[i in occurring(f) for i in sorted(self.unknowns)] for f in equations])
        return bool(structural_rank(csr_array(pattern)) < len(equations))

    def _exclude(self, poly: Any) -> None:
        if not poly.is_constant() and poly not in self.nonzero:
            self.nonzero.append(poly)

    def _divide(self, poly: Any) -> None:
        """Exclude a polynomial whose zeros end the branch, or make it singular."""
        self._exclude(poly)
        self.crossed = [f for f in self.crossed if f != poly]

    def _inserted(self, polynomials: list[Any], index: int, value: Expression) -> list[Any]:
        return [f for f in polynomials if index not in occurring(f)] + [
            g
            for f in polynomials
            if index in occurring(f)
            for g in [inserted(self.field, f, index, value).num]
            if not g.is_constant()
        ]

    def _linear(self) -> bool:
        """Solve one equation that is linear in an unknown."""
        best: tuple[Any, ...] | None = None
        for place, equation in enumerate(self._open):
            for index in occurring(equation) & self.unknowns:
                parts = by_power(equation, index)
                if max(parts) > 1:
                    continue
                lead = parts[1]
                cost = (not lead.is_constant(), len(equation), -index)
                if (best is None or cost < best[0]) and self._vanishes(lead) is False:
                    best = (cost, place, index, parts)
        if best is None:
            return False
        _, place, index, parts = best
        del self._open[place]
        self._divide(parts[1])
        tail = parts.get(0, self.field.ring.constant(0))
        self._solve(index, self.field.quotient(-tail, parts[1]))
        return True

    def _solve(self, index: int, value: Expression) -> None:
        self._open = [inserted(self.field, f, index, value).num for f in self._open]
        self.kept = [(i, inserted(self.field, f, index, value).num) for i, f in self.kept]
        crossed = self._inserted(self.crossed, index, value)
        others = [f for f in self.nonzero if f not in self.crossed]
        self.nonzero = self._inserted(self.nonzero, index, value)
        self.crossed = [f for f in crossed if f not in self._inserted(others, index, value)]
        for other, solution in self.solved.items():
            top = inserted(self.field, solution.num, index, value)
            bottom = inserted(self.field, solution.den, index, value)
            self.solved[other] = top / bottom
        self.solved[index] = value

    def _lower(self) -> bool:
        """Reduce the equations of one unknown by the one of least degree, or keep the last one."""
        taken = {i for i, _ in self.kept}
        candidates = set().union(*map(occurring, self._open)) & self.unknowns - taken
        if not candidates:
            raise NotExact("an equation is left without an unknown")

        def effort(index: int) -> tuple[int, int, int]:
            having = [f for f in self._open if index in occurring(f)]
            return len(having), min(f.degrees()[index] for f in having), -index

        index = min(candidates, key=effort)
        having = sorted(
            (f for f in self._open if index in occurring(f)),
            key=lambda f: (f.degrees()[index], len(f)),
        )
        divisor = having[0]
        others = [f for f in self._open if f is not divisor]
        degree = divisor.degrees()[index]
        lead = by_power(divisor, index)[degree]
        if self._vanishes(lead) is not False:
            raise NotExact("a leading coefficient vanishes")
        self._divide(lead)
        if len(having) == 1:
            self.kept.append((index, divisor))
            self._open = others
            return True
        self._open = [divisor] + [
            remainder(f, divisor, index, self.field.reduced)[0]
            if f.degrees()[index] >= degree
            else f
            for f in others
        ]
        return True

    def value(self, expression: Expression) -> Expression:
        """An expression with the solved unknowns inserted."""
        for index, solution in self.solved.items():
            if index in occurring(expression.num) | occurring(expression.den):
                top = inserted(self.field, expression.num, index, solution)
                bottom = inserted(self.field, expression.den, index, solution)
                expression = top / bottom
        return expression

    def settle(self) -> None:
        """Reduce squares by kept equations from now on, where these are pure and monic."""
        for index, equation in list(self.kept):
            parts = by_power(equation, index)
            if set(parts) <= {0, 2} and parts[2].is_constant():
                self.field.squares[index] = -parts.get(0, 0) / parts[2].leading_coefficient()
                # the equation itself stays in `kept` for those who print it

    def reduce(self, polynomials: Sequence[Any]) -> list[Any]:
        """Polynomials modulo the kept equations, all times the same nonzero polynomial."""
        out = [self.field.reduced(p) for p in polynomials]
        for index, equation in self.kept:
            remainders = [remainder(p, equation, index, self.field.reduced) for p in out]
            most = max((count for _, _, count in remainders), default=0)
            out = [self.field.reduced(p * lead ** (most - count)) for p, lead, count in remainders]
        return out
