"""From a characteristic polynomial to the signs that decide, each with its status and proof.

Members of the family are witnesses: values of the variables, inside the domain or not.
"""

from __future__ import annotations

import random
from collections.abc import Iterator, Mapping, Sequence
from fractions import Fraction
from math import gcd, lcm
from typing import Any

import numpy as np
from flint import arb, fmpq

from ..algebra.exact.function_field import evaluate, occurring
from ..algebra.exact.hurwitz_forms import Budget, by_power, hurwitz_determinants, subdiscriminants
from ..algebra.exact.number_fields import NotExact
from ..algebra.exact.rational_functions import univariate
from ..algebra.exact.routh import is_even
from ..algebra.exact.triangular import remainder
from ..algebra.number_types import precision
from ..algebra.polynomial import Polynomial
from ..base.errors import DomainError, NoMemberError
from ..polynomials.characteristic import CharacteristicPolynomial
from ..systems.family import Family
from ..systems.graph.smoothness import sloped
from ..systems.structure.structural_zeros import sampled
from .signs import Bounds, Domain, between, real_roots

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
    """Values of the variables at members, and the search for members with given signs."""

    def __init__(self, polynomial: CharacteristicPolynomial, domain: Domain) -> None:
        self.polynomial, self.whole, self.domain = polynomial, polynomial.factored, domain

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
        signs: dict[int, dict[int, Any]] = {id(r): {} for r in waiting}
        chance = random.Random(0)  # the same members each time
        points = [self._trial_point(chance, trial) for trial in range(TRIALS)]
        for point in points:
            left = [r for r in waiting if len(signs[id(r)]) < 2]
            if not left or budget.spent > budget.seconds:
                break
            self._record_signs(point, left, signs)
        for row in waiting:
            others = (p for point in points[:4] for p in self._beside(row["rest"], point))
            for point in others:
                if len(signs[id(row)]) == 2 or budget.spent > budget.seconds:
                    break
                self._record_signs(point, [row], signs)
        for row in waiting:
            both = signs[id(row)]
            row["witnesses"] = tuple(sorted(both.items(), reverse=True))
            row["status"] = "changes" if len(both) == 2 else "open"

    def _record_signs(
        self, point: dict[str, Any], rows: list[dict[str, Any]], signs: dict[int, dict[int, Any]]
    ) -> None:
        """Record the signs at a member, where there is one inside the domain."""
        try:
            with precision(WITNESS_BITS):
                values = self.values(point)
                if not self.check(values):
                    return
                numbers = dict(enumerate(values))
                for row in rows:
                    value = evaluate(row["rest"], numbers)
                    sign = 1 if value > 0 else -1 if value < 0 else 0
                    if sign:
                        signs[id(row)].setdefault(sign, point)
        except (NoMemberError, DomainError, ZeroDivisionError, NotExact):
            return

    def _trial_point(self, chance: random.Random, trial: int) -> dict[str, Any]:
        family = self.polynomial.family
        point = dict(self.polynomial.values)
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

        Raises
        ------
        DomainError
            If the member lies on another branch than the conditions.
        """
        numbers = self.polynomial.member(point)
        off = self.polynomial.elsewhere(numbers)
        if off is not None:
            raise DomainError(
                f"{self.polynomial.name(off)} is {_short(numbers[off])} at this member, which lies "
                f"on another branch of {self.polynomial.family.name} than the conditions."
            )
        exact = {n: v for n, v in point.items() if isinstance(v, fmpq)}
        return [
            exact.get(n, numbers[i])
            for n, i in zip(self.whole.names, self.whole.indices, strict=True)
        ]

    def check(self, values: Sequence[Any]) -> bool:
        """Refuse a point outside the domain, or off this branch of the family.

        Returns
        -------
        bool
            Whether the point is proved to lie inside; a ball may leave it open.
        """
        numbers = dict(enumerate(values))
        sure = True
        for index, limits in self.domain.bounds.items():
            if limits.outside(numbers[index]):
                raise DomainError(
                    f"{self.whole.names[index]} is {_short(numbers[index])}, outside the domain of "
                    f"the conditions: {self.domain.interval(index)}."
                )
            sure = sure and (index in self.domain.natural or limits.holds(numbers[index]))
        for poly, reason in (*self.domain.facts, *self.domain.assumed):
            value = evaluate(poly, numbers)
            if value <= 0:
                raise DomainError(
                    f"{self.domain.text(poly)} is {_short(value)}; the conditions hold where it "
                    f"is positive: {reason}."
                )
            sure = sure and bool(value > 0)
        for index, poly in self.whole.relations:
            if not arb(evaluate(poly, numbers)).contains(0):
                raise DomainError(
                    f"{self.domain.text(poly)} is not 0, so this is no member of the branch of "
                    f"the conditions; {self.whole.names[index]} does not obey its equation."
                )
        for poly in (*self.whole.nonzero, *self.domain.nonzero):
            value = arb(evaluate(poly, numbers))
            if value == 0:
                raise DomainError(f"{self.domain.text(poly)} is 0, which the conditions leave out.")
            sure = sure and not value.contains(0)
        return sure


def _short(value: Any) -> str:
    number = float(arb(value).mid())
    return f"{number:.6g}"


def sloped_somewhere(family: Family, values: Mapping[str, Any]) -> bool:
    """Whether the rates have a slope at a typical member; True where no such member is found."""
    names = (*family.at, *family.parameters)
    numbers = {n: float(v) for n, v in zip(names, sampled(family, 0), strict=True)}
    numbers |= {n: float(v) for n, v in values.items()}
    a, q = (np.array([[numbers[n] for n in part]]) for part in (family.at, family.parameters))
    members = family.search(a, q)
    if not members.good.all():
        return True
    numbers |= dict(zip(family.unknown, members.u[0].tolist(), strict=True))
    point = np.array([[numbers[n] for n in family.system.parameters]]).reshape(1, -1)
    return bool(sloped(family.system, family.states(a, members.u, q), point)[0])


LONGEST = 20_000
"""Product of the terms of two conditions beyond which neither is derived from the other."""
KINDS = {"sin": "sine", "cos": "cosine", "sqrt": "root"}
"""Kind of a variable by its function."""


def domain_of(polynomial: CharacteristicPolynomial, intervals: Mapping[str, Any]) -> Domain:
    """What is known of the variables: the user's intervals, the system's conditions, squares."""
    whole = polynomial.factored
    domain = Domain(whole.ring, [*whole.names, "λ"])
    places = {old: new for new, old in enumerate(whole.indices)}
    limits = dict(intervals)
    for name in polynomial.family.positive:
        limits.setdefault(name, (fmpq(0), None))
    for name, (low, high) in limits.items():
        if name in whole.names:
            domain.bound(whole.names.index(name), low, high)
    for old, new in places.items():
        function = polynomial.field.meaning.get(old, ("", None, None))
        if function[0] in ("sin", "cos"):
            domain.bound(new, fmpq(-1), fmpq(1), closed=True)
            if domain.bounds[new] == Bounds(fmpq(-1), fmpq(1), at_low=True, at_high=True):
                domain.natural.add(new)
        elif function[0] == "sqrt" and (function[2] is None or function[2].is_constant()):
            domain.bound(new, fmpq(0), closed=whole.ring.gens()[new] not in whole.nonzero)
        elif function[0] in ("exp", "cosh"):
            domain.bound(new, fmpq(0))
    for poly in whole.nonzero:
        domain.exclude(poly)
    for poly, sentence in whole.required:
        if not poly.is_constant():
            domain.learn(poly, f"the system requires it ({sentence.split('{')[0].strip()} …)")
    for index, poly in whole.relations:
        _square(domain, index, poly)
    return domain


def _square(domain: Domain, index: int, poly: Poly) -> None:
    """x² lead + rest = 0 with x ≠ 0 tells the sign of -rest · lead."""
    parts = by_power(poly, index)
    x = domain.ring.gens()[index]
    bounds = domain.bounds.get(index, Bounds())
    apart = x in domain.nonzero or not bounds.free and bounds.outside(fmpq(0))
    if set(parts) == {0, 2} and apart:
        name = domain.names[index]
        domain.learn(-parts[0] * parts[2], f"from {name}**2, where {name} is not zero")


class Deduction:
    """Conditions of every factor, and what is needed to check members."""

    def __init__(
        self, polynomial: CharacteristicPolynomial, domain: Domain, structural: int
    ) -> None:
        self.polynomial, self.whole, self.domain = polynomial, polynomial.factored, domain
        self.structural = structural
        self.members = Members(polynomial, domain)
        """Members as witnesses."""
        self.left_out: list[str] = []
        """What was too large."""
        self.factors = [self._oriented(c, n) for c, n in self.whole.factors]
        """(coefficients, whether even, multiplicity) of each factor."""

    def _oriented(self, coefficients: Sequence[Poly], count: int) -> tuple[Any, bool, int]:
        lead = self.domain.sign(coefficients[-1])
        turned = -1 if lead.value < 0 and not lead.open else 1
        even = is_even(coefficients)
        return tuple(c * turned for c in coefficients), even, count

    def shown(self, poly: Poly, together: Sequence[Poly] = ()) -> Polynomial:
        """A polynomial with integer coefficients, times a positive number."""
        names = self.whole.names
        numbers = [c for p in (poly, *together) for c in p.coeffs()]
        scale = Fraction(lcm(*(int(c.q) for c in numbers)) if numbers else 1)
        content = gcd(*(int(c.p) * (scale.numerator // int(c.q)) for c in numbers)) or 1
        scale /= content
        terms = tuple(
            (
                int(c.p) * scale.numerator // (int(c.q) * scale.denominator),
                tuple(map(int, e))[: len(names)],
            )
            for e, c in poly.to_dict().items()
        )
        return Polynomial(names, terms)

    def reduced(self, poly: Poly) -> Poly:
        """A polynomial modulo the relations, times a positive one."""
        for index, relation in self.whole.relations:
            poly, lead, count = remainder(poly, relation, index)
            if count % 2:
                poly = poly * lead
        return poly

    def certain(self, poly: Poly) -> bool:
        """Whether a polynomial has a proved sign."""
        return not self.domain.sign(poly).open

    # --- the conditions of a factor ---

    def conditions(self, budget: Budget) -> list[dict[str, Any]]:
        """Fields of `SignCondition` for every factor."""
        rows: list[dict[str, Any]] = []
        for place, (coefficients, even, _) in enumerate(self.factors):
            try:
                named = (
                    even_conditions(coefficients, budget)
                    if even
                    else self._smallest(coefficients, budget)
                )
            except NotExact as reason:
                n = len(coefficients) - 1
                self.left_out.append(
                    f"the Hurwitz determinants of a factor of degree {n} in λ are too large: "
                    f"{reason}"
                )
                named = _plain(coefficients)
            rows += [self._row(place, *entry) for entry in self._monic(named, coefficients)]
        self._follow(rows, budget)
        self.members.witness(rows, budget)
        return [self._said(row) for row in rows]

    def _smallest(self, a: Sequence[Poly], budget: Budget) -> list[Named]:
        """The conditions of Liénard and Chipart, of the set with fewer open signs and terms."""
        minors = hurwitz_determinants(a, budget) if len(a) > 2 else []
        return min(hurwitz_conditions(a, minors), key=self._cost)

    def _cost(self, named: Sequence[Named]) -> tuple[int, int]:
        signs = [self.domain.sign(self.reduced(p)) for _, _, p, _ in named]
        return sum(bool(s.open) for s in signs), sum(len(f) for s in signs for f in s.open)

    def _monic(self, named: Sequence[Named], a: Sequence[Poly]) -> Iterator[tuple[str, str, Poly]]:
        """Conditions times the leading coefficient, where its sign is open and the power odd."""
        lead_open = not self.certain(a[-1])
        for name, kind, poly, power in named:
            yield name, kind, self.reduced(poly * a[-1] if lead_open and power % 2 else poly)

    def _row(self, place: int, name: str, kind: str, poly: Poly) -> dict[str, Any]:
        sign = self.domain.sign(poly)
        rest = self.whole.ring.constant(sign.value or 0)
        for f in sign.open:
            rest = rest * f
        for f in sign.nonzero:
            rest = rest * f * f
        status = "positive" if sign.value > 0 else "negative" if sign.value else "zero"
        if sign.open or sign.nonzero:
            status = "open"
        return {
            "name": name,
            "factor": place,
            "kind": kind,
            "status": status,
            "rest": rest,
            "all": poly,
            "proof": "; ".join(sign.reasons),
            "witnesses": (),
        }

    def _follow(self, rows: list[dict[str, Any]], budget: Budget) -> None:
        """Mark conditions that follow from another one of the same list."""
        asked = [r for r in rows if r["status"] == "open"]
        for row in sorted(asked, key=lambda r: (r["kind"] != "auxiliary", -len(r["rest"]))):
            for other in asked:
                size = len(row["rest"]) * len(other["rest"])
                if other is row or other["status"] != "open" or size > LONGEST:
                    continue
                if budget.spent > budget.seconds:
                    return
                same = other["rest"] == row["rest"]
                name = f"`{other['name']}`"
                proof = (
                    f"is the same as {name}"
                    if same
                    else self.domain.implied(row["rest"], other["rest"], name)
                )
                if proof and not (same and row["kind"] == "flutter" != other["kind"]):
                    row |= {"status": "follows", "proof": proof}
                    break

    # --- in words ---

    def assumptions(self) -> list[str]:
        """What is known of the variables, as text."""
        inside = [
            self.domain.interval(i) for i, b in sorted(self.domain.bounds.items()) if not b.free
        ]
        more = [
            f"{self.domain.text(p)} > 0"
            for p, _ in (*self.domain.facts, *self.domain.assumed)
            if p.total_degree() > 1 or len(occurring(p)) > 1
        ]
        return [*inside, *dict.fromkeys(more)]

    def variables(self) -> list[tuple[str, str, str]]:
        """(name, kind, meaning) of each variable."""
        polynomial, family = self.polynomial, self.polynomial.family
        out = []
        for name, index in zip(self.whole.names, self.whole.indices, strict=True):
            if index in polynomial.field.meaning:
                function, x, _ = polynomial.field.meaning[index]
                kind = KINDS.get(function, "function")
                out.append((name, kind, f"{function} of {polynomial.text(x)}"))
            elif name in family.unknown:
                out.append((name, "unknown", f"unknown of family {family.name}"))
            elif name in family.system.states:
                out.append((name, "state", f"state that names a member of {family.name}"))
            else:
                out.append((name, "parameter", f"parameter of {family.system.name}"))
        return out

    def _said(self, row: dict[str, Any]) -> dict[str, Any]:
        rest, all_ = row.pop("rest"), row.pop("all")
        names = (*self.polynomial.family.at, *self.polynomial.family.parameters)
        row["witnesses"] = tuple(
            ({n: Fraction(int(p[n].p), int(p[n].q)) for n in names}, sign)
            for sign, p in row["witnesses"]
        )
        return row | {"polynomial": self.shown(rest), "whole": self.shown(all_)}


Named = tuple[str, str, Poly, int]
"""Name, kind and polynomial of a condition, and the power of the leading coefficient in it."""


def _coefficient(a: Sequence[Poly], power: int) -> Named:
    if power == 0:
        return "constant term", "static", a[0], 1
    return f"coefficient of λ^{power}", "auxiliary", a[power], 1


def _plain(a: Sequence[Poly]) -> list[Named]:
    """Every coefficient: necessary conditions only."""
    return [_coefficient(a, k) for k in range(len(a) - 1) if a[k] != 0]


def hurwitz_conditions(a: Sequence[Poly], minors: Sequence[Poly]) -> list[list[Named]]:
    """Both sets of Liénard and Chipart: every second coefficient, every second determinant.

    Parameters
    ----------
    a
        Coefficients by powers of λ, lowest first.
    minors
        Hurwitz determinants of order 1 … n - 1.
    """
    n = len(a) - 1
    determinants = [
        (f"Hurwitz determinant {k}", "flutter" if k == n - 1 else "auxiliary", minors[k - 1], k)
        for k in range(n - 1, 1, -2)
    ]
    sets = []
    for powers in ({0, *range(2, n, 2)}, {0, *range(1, n, 2)}):
        if n % 2 == 0:
            powers.add(n - 1)  # the first determinant
        sets.append([*(_coefficient(a, k) for k in sorted(powers)), *determinants])
    return sets


def even_conditions(a: Sequence[Poly], budget: Budget) -> list[Named]:
    """q(λ²) has negative real roots λ² alone: coefficients and subdiscriminants."""
    q = a[::2]
    named = [_coefficient(a, 2 * k) for k in range(len(q) - 1)]
    m = len(q) - 1
    if m > 1:
        minors = subdiscriminants(q, budget)
        kept = minors[-1:] if m < 4 else minors
        named += [
            (
                "discriminant in λ²" if d is minors[-1] else f"subdiscriminant {k} in λ²",
                "flutter" if d is minors[-1] else "auxiliary",
                d,
                2,
            )
            for k, d in enumerate(kept, start=m - len(kept) + 1)
        ]
    return named


def closed_forms(polynomial: CharacteristicPolynomial) -> tuple[tuple[str, str], ...]:
    """Closed forms; a function whose name is only a number is left out where nothing names it."""
    forms = [(i, polynomial.text(v)) for i, v in polynomial.triangular.solved.items()]
    named = {i: polynomial.name(i) for i, _ in forms}
    texts, count = " ".join(text for _, text in forms), len(polynomial.base)
    kept = [i for i, name in named.items() if i < count or "(" in name or name in texts]
    return tuple((named[i], text) for i, text in forms if i in kept)
