"""A family of the disk for the page: its stored polynomials."""

from __future__ import annotations

from collections.abc import Mapping
from types import SimpleNamespace
from typing import Any

from ...algebra.number_types import Algebra
from ...base.verdict import best
from ...bodies.disk_polynomials import PLAIN, DiskPolynomial, exact_polynomial
from ...bodies.families import FAMILIES
from ...systems.family import Family
from ..quantity import Quantity
from ..source.formulas import Formulas, Rule, Values, filled, share_of, sized, typeset


def stored_formulas(family: Family, law: str, quantities: Mapping[str, Quantity]) -> Formulas:
    """What decides the verdict of a family of the disk."""
    record, exact = FAMILIES[family.name], DiskPolynomial(exact_polynomial(family.name, law))
    known, [at] = exact.known, family.at
    written, put = {}, {}
    for variable, name, power in (("k", "k", 1), ("M", "mu", 2), ("z", at, 2), ("s", at, 1)):
        if name in quantities:  # each variable is a power of a quantity, or its sine
            one = quantities[name]
            sine = variable == "s"
            written[variable] = (f"sin {one.symbol}" if sine else one.symbol, power)
            put[variable] = (f"(sin {{{one.name}}})" if sine else f"{{{one.name}}}", power)

    def given(q: Values) -> dict[str, Any]:
        # with the units of the dimensionless disk, the member as `at`
        names = ("at" if n == at else n for n in quantities)
        return {"mass": 1, "radius": 1, "gravity": 1} | dict(zip(names, q, strict=True))

    def point(algebra: Algebra, q: Values) -> list[Any]:
        return exact.point(given(q), algebra)

    def coefficients(algebra: Algebra, q: Values) -> list[list[Any]]:
        scale, _ = exact.scale(given(q))  # with λ = σ · scale the power i has scale^(n - i)
        found = []
        for factor in known.coefficients(point(algebra, q)):
            powers: list[Any] = [1.0]
            for _ in factor[1:]:
                powers.append(powers[-1] if scale is None else scale * powers[-1])
            found.append([c * s for c, s in zip(factor, reversed(powers), strict=True)])
        return found

    def signs(algebra: Algebra, q: Values) -> list[tuple[Any, Any]]:
        at = point(algebra, q)
        return [sized(p, 0, algebra, at) for _, p in known.conditions]

    def unknown(algebra: Algebra, q: Values) -> dict[str, Any]:
        values, functions = given(q), SimpleNamespace(**algebra.functions)
        states = record.member(functions, values["at"], values["k"])
        return {n: states[n] for n in family.unknown}

    return Formulas(
        names=tuple(quantities),
        even=(known.even,) * len(known.factors),
        zeros=known.zeros,
        coefficients=coefficients,
        signs=signs,
        rules=tuple(
            Rule(kind, share_of(p, PLAIN), typeset(p, written), filled(p, put))
            for kind, p in known.conditions
        ),
        unknown=unknown,
        good=best(even=known.even),
    )
