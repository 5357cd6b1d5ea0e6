"""From a characteristic polynomial to the signs that decide, each with its status and proof."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from fractions import Fraction
from math import gcd, lcm
from typing import Any

from flint import fmpq

from ...algebra.exact.hurwitz_forms import Budget, by_power, hurwitz_determinants, subdiscriminants
from ...algebra.exact.number_fields import NotExact
from ...algebra.exact.triangular import occurring, remainder
from ...algebra.polynomial import Polynomial
from .bounds import Bounds
from .elimination import Reading, Whole
from .members import Members
from .signs import Domain

Poly = Any
"""An `fmpq_mpoly`."""
LONGEST = 20_000
"""Product of the terms of two conditions beyond which neither is derived from the other."""
KINDS = {"sin": "sine", "cos": "cosine", "sqrt": "root"}
"""Kind of a variable by its function."""


def domain_of(reading: Reading, whole: Whole, intervals: Mapping[str, Any]) -> Domain:
    """What is known of the variables: the user's intervals, the system's conditions, squares.

    Parameters
    ----------
    reading, whole
        The family's Jacobian and its characteristic polynomial.
    intervals
        Open intervals by name.
    """
    domain = Domain(whole.ring, [*whole.names, "λ"])
    places = {old: new for new, old in enumerate(whole.indices)}
    given = dict(intervals)
    for name in reading.family.positive:
        given.setdefault(name, (fmpq(0), None))
    for name, (low, high) in given.items():
        if name in whole.names:
            domain.bound(whole.names.index(name), low, high)
    for old, new in places.items():
        function = reading.field.meaning.get(old, ("", None, None))
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
    """Conditions of every factor, and what is needed to check members.

    Parameters
    ----------
    reading, whole, domain
        The family's Jacobian, its characteristic polynomial, what is known of the variables.
    structural
        Number of zeros by structure.
    """

    def __init__(self, reading: Reading, whole: Whole, domain: Domain, structural: int) -> None:
        self.reading, self.whole, self.domain = reading, whole, domain
        self.structural = structural
        self.members = Members(reading, whole, domain)
        """Members as witnesses."""
        self.left_out: list[str] = []
        """What was too large."""
        self.factors = [self._oriented(c, n) for c, n in whole.factors]
        """(coefficients, whether even, multiplicity) of each factor."""

    def _oriented(self, coefficients: Sequence[Poly], count: int) -> tuple[Any, bool, int]:
        lead = self.domain.sign(coefficients[-1])
        turned = -1 if lead.known < 0 and not lead.open else 1
        even = len(coefficients) % 2 == 1 and all(c == 0 for c in coefficients[1::2])
        return tuple(c * turned for c in coefficients), even, count

    def polynomial(self, poly: Poly, together: Sequence[Poly] = ()) -> Polynomial:
        """A polynomial with integer coefficients, times a positive number.

        Parameters
        ----------
        poly
            The polynomial.
        together
            Polynomials that get the same factor.
        """
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
                    _even(coefficients, budget) if even else self._smallest(coefficients, budget)
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

    def _smallest(self, a: Sequence[Poly], budget: Budget) -> list[tuple[str, str, Poly, int]]:
        """The conditions of Liénard and Chipart, of the set with fewer open signs and terms."""
        n = len(a) - 1
        minors = hurwitz_determinants(a, budget) if n > 1 else []
        found = [
            (f"Hurwitz determinant {k}", "flutter" if k == n - 1 else "auxiliary", minors[k - 1], k)
            for k in range(n - 1, 1, -2)
        ]
        sets = []
        for powers in ({0, *range(2, n, 2)}, {0, *range(1, n, 2)}):
            if n % 2 == 0:
                powers.add(n - 1)  # the first determinant
            sets.append([*(_coefficient(a, k) for k in sorted(powers)), *found])
        return min(sets, key=self._cost)

    def _cost(self, named: Sequence[tuple[str, str, Poly, int]]) -> tuple[int, int]:
        signs = [self.domain.sign(self.reduced(p)) for _, _, p, _ in named]
        return sum(bool(s.open) for s in signs), sum(len(f) for s in signs for f in s.open)

    def _monic(
        self, named: Sequence[tuple[str, str, Poly, int]], a: Sequence[Poly]
    ) -> Iterator[tuple[str, str, Poly]]:
        """Conditions times the leading coefficient, where its sign is open and the power odd."""
        lead_open = not self.certain(a[-1])
        for name, kind, poly, power in named:
            yield name, kind, self.reduced(poly * a[-1] if lead_open and power % 2 else poly)

    def _row(self, place: int, name: str, kind: str, poly: Poly) -> dict[str, Any]:
        sign = self.domain.sign(poly)
        rest = self.whole.ring.constant(sign.known or 0)
        for f in sign.open:
            rest = rest * f
        for f in sign.nonzero:
            rest = rest * f * f
        status = "positive" if sign.known > 0 else "negative" if sign.known else "zero"
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
        reading, family = self.reading, self.reading.family
        out = []
        for name, index in zip(self.whole.names, self.whole.indices, strict=True):
            if index in reading.field.meaning:
                function, x, _ = reading.field.meaning[index]
                kind = KINDS.get(function, "function")
                out.append((name, kind, f"{function} of {reading.text(x)}"))
            elif name in family.unknown:
                out.append((name, "unknown", f"unknown of family {family.name}"))
            elif name in family.system.states:
                out.append((name, "state", f"state that names a member of {family.name}"))
            else:
                out.append((name, "parameter", f"parameter of {family.system.name}"))
        return out

    def _said(self, row: dict[str, Any]) -> dict[str, Any]:
        rest, all_ = row.pop("rest"), row.pop("all")
        names = (*self.reading.family.at, *self.reading.family.parameters)
        row["witnesses"] = tuple(
            ({n: Fraction(int(p[n].p), int(p[n].q)) for n in names}, sign)
            for sign, p in row["witnesses"]
        )
        return row | {"polynomial": self.polynomial(rest), "whole": self.polynomial(all_)}


def _coefficient(a: Sequence[Poly], power: int) -> tuple[str, str, Poly, int]:
    if power == 0:
        return "constant term", "static", a[0], 1
    return f"coefficient of λ^{power}", "auxiliary", a[power], 1


def _plain(a: Sequence[Poly]) -> list[tuple[str, str, Poly, int]]:
    """Every coefficient: necessary conditions only."""
    return [_coefficient(a, k) for k in range(len(a) - 1) if a[k] != 0]


def _even(a: Sequence[Poly], budget: Budget) -> list[tuple[str, str, Poly, int]]:
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


def closed_forms(reading: Reading) -> tuple[tuple[str, str], ...]:
    """Closed forms; a function whose name is only a number is left out where nothing names it.

    Parameters
    ----------
    reading
        The family's Jacobian.
    """
    found = [(i, reading.text(v)) for i, v in reading.triangular.solved.items()]
    named = {i: reading.name(i) for i, _ in found}
    texts = " ".join(text for _, text in found)
    kept = [i for i, name in named.items() if i < len(reading.base) or "(" in name or name in texts]
    return tuple((named[i], text) for i, text in found if i in kept)
