"""Members of a family as witnesses: values of the variables, whether they are inside the domain."""

from __future__ import annotations

import random
from collections.abc import Iterator, Mapping, Sequence
from typing import Any

import numpy as np
from flint import arb, fmpq

from ...algebra.exact.hurwitz_forms import Budget
from ...algebra.exact.number_fields import NotExact
from ...algebra.exact.triangular import occurring
from ...algebra.number_types import precision
from ...base.errors import DomainError, NoMemberError
from ...systems.family import Family
from ...systems.graph.smoothness import sloped
from ...systems.structure.structural_zeros import sampled
from .bounds import Bounds, between, real_roots, univariate
from .elimination import Reading, Whole, evaluate
from .signs import Domain

Poly = Any
"""An `fmpq_mpoly`."""
TRIALS = 60
"""Random members at which signs are sought."""
FACTORS = tuple(
    fmpq(p, q)
    for p, q in (
        (1, 1),
        (2, 1),
        (1, 2),
        (4, 1),
        (1, 4),
        (10, 1),
        (1, 10),
        (3, 2),
        (2, 3),
        (30, 1),
        (1, 30),
    )
)
"""Multiples of typical sizes for these members."""
WITNESS_BITS = 160
"""Precision of the balls at these members."""


class Members:
    """Values of the variables at members, and the search for members with given signs.

    Parameters
    ----------
    reading, whole, domain
        The family's Jacobian, its characteristic polynomial, what is known of the variables.
    """

    def __init__(self, reading: Reading, whole: Whole, domain: Domain) -> None:
        self.reading, self.whole, self.domain = reading, whole, domain

    def witness(self, rows: list[dict[str, Any]], budget: Budget) -> None:
        """Members with proved signs of the conditions that are open.

        Parameters
        ----------
        rows
            Fields of conditions; `witnesses` and `status` are set.
        budget
            The search ends when the time is over.
        """
        waiting = [r for r in rows if r["status"] == "open"]
        found: dict[int, dict[int, Any]] = {id(r): {} for r in waiting}
        chance = random.Random(0)  # the same members each time
        points = [self._near(chance, trial) for trial in range(TRIALS)]
        for point in points:
            left = [r for r in waiting if len(found[id(r)]) < 2]
            if not left or budget.spent > budget.seconds:
                break
            self._signs(point, left, found)
        for row in waiting:
            others = (p for point in points[:4] for p in self._beside(row["rest"], point))
            for point in others:
                if len(found[id(row)]) == 2 or budget.spent > budget.seconds:
                    break
                self._signs(point, [row], found)
        for row in waiting:
            both = found[id(row)]
            row["witnesses"] = tuple(sorted(both.items(), reverse=True))
            row["status"] = "changes" if len(both) == 2 else "open"

    def _signs(
        self, point: dict[str, Any], rows: list[dict[str, Any]], found: dict[int, dict[int, Any]]
    ) -> None:
        """Record the signs at a member, where there is one inside the domain."""
        try:
            with precision(WITNESS_BITS):
                values = self.values(point)
                if not self.check(values):
                    return
                known = dict(enumerate(values))
                for row in rows:
                    value = evaluate(row["rest"], known)
                    sign = 1 if value > 0 else -1 if value < 0 else 0
                    if sign:
                        found[id(row)].setdefault(sign, point)
        except (NoMemberError, DomainError, ZeroDivisionError, NotExact):
            return

    def _near(self, chance: random.Random, trial: int) -> dict[str, Any]:
        family = self.reading.family
        point = dict(self.reading.values)
        for name in (*family.at, *family.parameters):
            if name in point:
                continue
            size = fmpq(*float(family.typical.get(name, 1.0)).as_integer_ratio())
            place = self.whole.names.index(name) if name in self.whole.names else -1
            limits = self.domain.bounds.get(place, Bounds())
            value = size if not trial else size * FACTORS[chance.randrange(len(FACTORS))]
            if limits.free and trial % 3 == 2:
                value = value * chance.choice((1, -1))
            if limits.low is not None and limits.high is not None:
                share = fmpq(chance.randrange(1, 16), 16)
                value = limits.low + (limits.high - limits.low) * share
            elif limits.low is not None and value <= limits.low:
                value = limits.low + abs(value)
            elif limits.high is not None and value >= limits.high:
                value = limits.high - abs(value)
            point[name] = value
        return point

    def _beside(self, poly: Poly, point: Mapping[str, Any]) -> Iterator[dict[str, Any]]:
        """Points on each side of a root in one parameter, the others as they are."""
        names = self.whole.names
        here = {i: point[n] for i, n in enumerate(names) if n in point}
        for index in occurring(poly):
            if index not in here or not occurring(poly) <= set(here):
                continue
            gens = self.whole.ring.gens()
            others = [
                g if i == index else self.whole.ring.constant(here.get(i, 0))
                for i, g in enumerate(gens)
            ]
            along = poly.compose(*others)
            if along.is_constant():
                continue
            limits = self.domain.bounds.get(index, Bounds())
            roots = real_roots(univariate(along, index))
            for value in between(roots, limits.low, limits.high):
                yield {**point, names[index]: value}

    def values(self, point: Mapping[str, Any]) -> list[Any]:
        """Values of the variables at a member, from its family parameters and parameters.

        Parameters
        ----------
        point
            Rationals by name.

        Raises
        ------
        DomainError
            If the member lies on another branch than the conditions.
        """
        known = self.reading.member(point)
        off = self.reading.elsewhere(known)
        if off is not None:
            raise DomainError(
                f"{self.reading.name(off)} is {_short(known[off])} at this member, which lies on "
                f"another branch of {self.reading.family.name} than the conditions."
            )
        exact = {n: v for n, v in point.items() if isinstance(v, fmpq)}
        return [
            exact.get(n, known[i])
            for n, i in zip(self.whole.names, self.whole.indices, strict=True)
        ]

    def check(self, values: Sequence[Any]) -> bool:
        """Refuse a point outside the domain, or off this branch of the family.

        Parameters
        ----------
        values
            Rationals or balls, one for each variable.

        Returns
        -------
        bool
            Whether the point is proved to lie inside; a ball may leave it open.
        """
        known = dict(enumerate(values))
        sure = True
        for index, limits in self.domain.bounds.items():
            if limits.outside(known[index]):
                raise DomainError(
                    f"{self.whole.names[index]} is {_short(known[index])}, outside the domain of "
                    f"the conditions: {self.domain.interval(index)}."
                )
            sure = sure and (index in self.domain.natural or limits.holds(known[index]))
        for poly, reason in (*self.domain.facts, *self.domain.assumed):
            value = evaluate(poly, known)
            if value <= 0:
                raise DomainError(
                    f"{self.domain.text(poly)} is {_short(value)}; the conditions hold where it "
                    f"is positive: {reason}."
                )
            sure = sure and bool(value > 0)
        for index, poly in self.whole.relations:
            if not arb(evaluate(poly, known)).contains(0):
                raise DomainError(
                    f"{self.domain.text(poly)} is not 0, so this is no member of the branch of "
                    f"the conditions; {self.whole.names[index]} does not obey its equation."
                )
        for poly in (*self.whole.nonzero, *self.domain.nonzero):
            value = arb(evaluate(poly, known))
            if value == 0:
                raise DomainError(f"{self.domain.text(poly)} is 0, which the conditions leave out.")
            sure = sure and not value.contains(0)
        return sure


def _short(value: Any) -> str:
    number = float(arb(value).mid())
    return f"{number:.6g}"


def sloped_somewhere(family: Family, given: Mapping[str, Any]) -> bool:
    """Whether the rates have a slope at a typical member; True where no such member is found.

    Parameters
    ----------
    family
        The family.
    given
        Parameters that have a number.
    """
    names = (*family.at, *family.parameters)
    known = {n: float(v) for n, v in zip(names, sampled(family, 0), strict=True)}
    known |= {n: float(v) for n, v in given.items()}
    a, q = (np.array([[known[n] for n in part]]) for part in (family.at, family.parameters))
    found = family.search(a, q)
    if not found.good.all():
        return True
    point = np.array([[known[n] for n in family.system.parameters]]).reshape(1, -1)
    return bool(sloped(family.system, family.states(a, found.u, q), point)[0])
