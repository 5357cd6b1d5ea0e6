"""The first Lyapunov coefficient as a polynomial, over the field of a family's linearisation.

With A' = d A of polynomial entries, μ = d λ, p(μ) = det(μ - A') and an irreducible factor of p with
even part E and odd part O, pairs on the imaginary axis are common roots z = μ² < 0 of E and O.  The
mode q is a column of adj(μ - A'), the left mode w a row.  Inverses are adjugates over determinants,
and a division by w q is a product with its conjugate.  So the coefficient, times a real number that
is not zero at a simple pair without resonance, is a polynomial N in z.

Source: Yu. A. Kuznetsov, Elements of Applied Bifurcation Theory, § 5.4; as `lyapunov_coefficient`.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import combinations_with_replacement
from typing import Any

from ...algebra.exact.hurwitz_forms import by_power, factors
from ...algebra.exact.number_fields import EXACT, NotExact, characteristic, exact_upright, rational
from ...algebra.exact.triangular import remainder
from ...algebra.upright import UPRIGHT, Upright
from ...derivation.elimination import Reading
from ..lyapunov_coefficient import Derivatives, derivatives

Poly = Any
"""An `fmpq_mpoly` of the reading's ring; λ of the reading is μ here."""
Column = list[Poly]


@dataclass(frozen=True, eq=False)
class OnsetForm:
    """What decides about pairs of one factor of the characteristic polynomial."""

    even: Column
    """Coefficients of E by powers of z, lowest first."""
    odd: Column
    """Those of O."""
    coefficient: Column
    """Those of N."""
    apart: Column
    """Coefficients, by powers of μ, of a polynomial that is not zero where N has its meaning."""


class OnsetForms:
    """The forms of a family.

    Raises
    ------
    NotExact
        If the derivatives are not algebraic, or the polynomials are too large.
    """

    def __init__(self, reading: Reading) -> None:
        self.reading, self.field = reading, reading.field
        self.d: Derivatives = derivatives(reading.family.system)
        self.kept = self.d.kept
        self.mu = self.field.generator(reading.lam)
        self.zero = self.field.ring.constant(0)
        rates, slopes, _ = self.d.first.run(exact_upright(), self._point)
        n = len(rates)
        self.matrix, self.scale = self._cleared(
            {(i, j): slopes[j * n + i] for i in self.kept for j in self.kept}
        )

    @cached_property
    def _point(self) -> list[list[Any]]:
        """States and parameters as expressions."""
        reading, family, system = self.reading, self.reading.family, self.reading.family.system
        table: dict[str, Any] = dict(zip(reading.base, self.field.symbols, strict=False))
        table |= {n: self.field.number(v) for n, v in reading.values.items()}
        if family.closed:
            table |= {n: self.field.number(rational(v)) for n, v in family.unknown.items()}
        for name, value in family.held.items():
            table[name] = (
                UPRIGHT if isinstance(value, Upright) else self.field.number(rational(value))
            )
        return [[table[n] for n in names] for names in (system.states, system.parameters)]

    # --- derivatives ---

    def _cleared(self, entries: dict[Any, Any]) -> tuple[dict[Any, Poly], Poly]:
        """Entries times a common denominator, and the denominator."""
        reading = self.reading
        values = {k: reading.triangular.value(reading.element(v)) for k, v in entries.items()}
        common = self.field.one
        for v in values.values():
            common = common * (v.den / common.gcd(v.den))
        return {k: v.num * (common / v.den) for k, v in values.items() if v.num != 0}, common

    def _unit(self, index: int) -> list[Any]:
        return [EXACT.constant(float(i == index)) for i in range(len(self._point[0]))]

    @cached_property
    def tensors(self) -> dict[int, tuple[dict[Any, Poly], Poly]]:
        """Second and third derivatives by order."""
        return {order: self._tensor(order) for order in (2, 3)}

    @property
    def denominators(self) -> list[Poly]:
        """Common denominators of the second and third derivatives."""
        return [common for _, common in self.tensors.values()]

    def _tensor(self, order: int) -> tuple[dict[Any, Poly], Poly]:
        """Derivatives (i, j, …) of the rates, j … in order, over a common denominator."""
        program = self.d.second if order == 2 else self.d.third
        entries: dict[Any, Any] = {}
        for places in combinations_with_replacement(self.kept, order):
            found = program.run(exact_upright(), [*self._point, *map(self._unit, places)])[0]
            entries |= {(i, *places): found[i] for i in self.kept if not _nothing(found[i])}
        return self._cleared(entries)

    # --- the ring ---

    def _conjugate(self, p: Poly) -> Poly:
        """μ -> -μ."""
        out = self.zero
        for power, part in by_power(p, self.reading.lam).items() if p != 0 else ():
            out = out + (-part if power % 2 else part) * self.mu**power
        return out

    def _row(self, p: Poly) -> Column:
        """Coefficients by powers of μ."""
        parts = by_power(p, self.reading.lam) if p != 0 else {}
        return [parts.get(k, self.zero) for k in range(max(parts, default=0) + 1)]

    @cached_property
    def _adjugate(self) -> list[dict[tuple[int, int], Poly]]:
        """adj(μ - A') by powers of μ (Faddeev)."""
        p, size = self.characteristic, len(self.kept)
        out = [{(i, i): self.field.one for i in self.kept}]
        for k in range(size - 1, 0, -1):
            following: dict[tuple[int, int], Poly] = {}
            for i in self.kept:
                for j in self.kept:
                    total = p[k] if i == j else self.zero
                    for m in self.kept:
                        if (i, m) in self.matrix and (m, j) in out[-1]:
                            total = total + self.matrix[i, m] * out[-1][m, j]
                    if total != 0:
                        following[i, j] = self.field.reduced(total)
            out.append(following)
        return out[::-1]

    @cached_property
    def characteristic(self) -> Column:
        """Coefficients of p(μ), lowest first."""
        rows = [
            [
                self.reading.element(
                    self.field.quotient(self.matrix.get((i, j), self.zero), self.field.one)
                )
                for j in self.kept
            ]
            for i in self.kept
        ]
        return [self.reading.element(c).num for c in characteristic(rows)]

    def __iter__(self) -> Iterator[OnsetForm]:
        """The form of each factor that may have a pair."""
        whole = self._sum(self.characteristic)
        for factor, count in factors(whole)[1]:
            row = self._row(factor)
            if len(row) < 3:
                continue
            if count > 1:
                raise NotExact("a factor of the characteristic polynomial is repeated")
            if all(c == 0 for c in row[1::2]):
                raise NotExact("pairs stay on the imaginary axis")
            yield _Projection(self, factor, row).form()

    def _sum(self, row: Column) -> Poly:
        total = self.zero
        for k, c in enumerate(row):
            total = total + c * self.mu**k
        return total


class _Projection:
    """The projection on the pairs of one factor, modulo its even or odd part: the monic one."""

    def __init__(self, forms: OnsetForms, factor: Poly, row: Column) -> None:
        self.forms, self.factor, self.row = forms, factor, row
        lead = row[-1]
        if not lead.is_constant():
            raise NotExact("a factor that is not monic")
        self.row = [c / lead.leading_coefficient() for c in row]
        half = self.row[::2] if len(row) % 2 else self.row[1::2]
        self.modulus = forms.zero
        for k, c in enumerate(half):
            self.modulus = self.modulus + c * forms.mu ** (2 * k)

    def reduced(self, p: Poly) -> Poly:
        """Normal form in the field and modulo the monic part."""
        forms = self.forms
        if p == 0:
            return p
        p = forms.reading.triangular.reduce([p])[0] if not forms.reading.triangular.kept else p
        found, _, _ = remainder(p, self.modulus, forms.reading.lam, forms.field.reduced)
        forms.reading.budget.watch(found)
        return found

    def times(self, *some: Poly) -> Poly:
        """A product."""
        out = some[0]
        for p in some[1:]:
            out = self.reduced(self.forms.reading.budget.product(out, p)) if out != 0 else out
        return out

    def _powers(self, factor: int) -> list[Poly]:
        """Powers of f μ, from the zeroth on."""
        out = [self.forms.field.one]
        for _ in self.forms.kept:
            out.append(self.reduced(out[-1] * self.forms.mu * factor))
        return out

    def _at(self, row: Column, factor: int) -> Poly:
        """A polynomial in μ at f μ."""
        total = self.forms.zero
        for c, power in zip(row, self._powers(factor), strict=False):
            total = total + self.times(power, c)
        return self.reduced(total)

    def _modes(self) -> tuple[dict[int, Poly], dict[int, Poly], Poly]:
        """A column and a row of adj(μ - A'), and their common entry."""
        forms, best = self.forms, None
        lam = forms.reading.lam
        for i in forms.kept:
            for j in forms.kept:
                entry = self._entry(i, j)
                if entry == 0 or remainder(entry, self.factor, lam, forms.field.reduced)[0] == 0:
                    continue
                column = {k: self.reduced(self._entry(k, j)) for k in forms.kept}
                row = {k: self.reduced(self._entry(i, k)) for k in forms.kept}
                cost = sum(map(len, (*column.values(), *row.values())))
                if best is None or cost < best[0]:
                    best = cost, column, row, self.reduced(entry)
        if best is None:
            raise NotExact("no column of the adjugate is a mode")
        return best[1:]

    def _entry(self, i: int, j: int) -> Poly:
        return self.forms._sum([part.get((i, j), self.forms.zero) for part in self.forms._adjugate])

    def form(self) -> OnsetForm:
        """The form."""
        forms = self.forms
        q, w, common = self._modes()
        conjugate = {k: forms._conjugate(v) for k, v in q.items()}
        (b, over_b), (c, over_c) = forms.tensors[2], forms.tensors[3]
        p = forms.characteristic
        slope = self._at([k * v for k, v in enumerate(p)][1:], 1)
        double = self._at(p, 2)
        size = self.times(double, forms._conjugate(double))
        turn = self.times(forms._conjugate(double), p[0])
        # C(q, q, q̄), B(q, A⁻¹ B(q, q̄)) and B(q̄, (2μ - A)⁻¹ B(q, q)), over p(0) |p(2μ)|²
        cubic = self._applied(c, q, q, conjugate)
        mean = self._solved(self._applied(b, q, conjugate), 0)
        twice = self._solved(self._applied(b, q, q), 2)
        both = self._applied(b, q, mean), self._applied(b, conjugate, twice)
        first = self.times(self._dot(w, cubic), size, p[0], over_b, over_b)
        second = self.times(self._dot(w, both[0]), size, over_c, forms.scale)
        third = self.times(self._dot(w, both[1]), turn, over_c, forms.scale)
        total = self.times(
            first + 2 * second + third, forms._conjugate(slope), forms._conjugate(common)
        )
        row = forms._row(total)
        apart = self.times(slope, common, p[0], double, over_b, over_c, forms.scale)
        return OnsetForm(self.row[::2], self.row[1::2], row[::2], forms._row(apart))

    def _dot(self, w: dict[int, Poly], v: dict[int, Poly]) -> Poly:
        total = self.forms.zero
        for k, c in v.items():
            total = total + self.times(w[k], c)
        return total

    def _applied(self, tensor: dict[Any, Poly], *vectors: dict[int, Poly]) -> dict[int, Poly]:
        """A symmetric tensor of derivatives at vectors."""
        out = dict.fromkeys(self.forms.kept, self.forms.zero)
        products: dict[tuple[int, ...], Poly] = {}
        for (i, *places), value in tensor.items():
            key = tuple(places)
            if key not in products:
                total = self.forms.zero
                for order in _orders(key):
                    total = total + self.times(*(v[k] for v, k in zip(vectors, order, strict=True)))
                products[key] = total
            out[i] = out[i] + self.times(products[key], value)
        return out

    def _solved(self, v: dict[int, Poly], factor: int) -> dict[int, Poly]:
        """adj(f μ - A') v."""
        forms, out = self.forms, {}
        powers = self._powers(factor) if factor else [forms.field.one]
        for i in forms.kept:
            total = forms.zero
            for power, part in zip(powers, forms._adjugate, strict=False):
                inner = forms.zero
                for j in forms.kept:
                    if (i, j) in part and v[j] != 0:
                        inner = inner + self.times(v[j], part[i, j])
                total = total + self.times(inner, power)
            out[i] = total
        return out


def _orders(places: Sequence[int]) -> set[tuple[int, ...]]:
    """Every different order of some places."""
    if len(places) < 2:
        return {tuple(places)}
    return {
        (first, *rest)
        for k, first in enumerate(places)
        for rest in _orders((*places[:k], *places[k + 1 :]))
    }


def _nothing(value: Any) -> bool:
    return bool(value == 0)
