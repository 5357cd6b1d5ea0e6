"""Bautin points: where the first Lyapunov coefficient of a flutter boundary vanishes.

Over Q every point of a rectangle is isolated.  On a flutter boundary E and O of an `OnsetForm` have
a common root z, and N(z) = 0.  The resultant of E and O, and N at the root of their first
subresultant, are two equations in both axes.  Square roots in them are eliminated by norms, and one
axis by resultants.  Every candidate is judged at the member, so what the elimination adds is
excluded again.

The first Lyapunov coefficient is a polynomial N over the field of a family's linearisation.  With
A' = d A of polynomial entries, μ = d λ, p(μ) = det(μ - A') and an irreducible factor of p with even
part E and odd part O, pairs on the imaginary axis are common roots z = μ² < 0 of E and O.  The mode
q is a column of adj(μ - A'), the left mode w a row.  Inverses are adjugates over determinants, and
a division by w q is a product with its conjugate.  So the coefficient, times a real number that is
not zero at a simple pair without resonance, is a polynomial N in z.

Source: B. L. van der Waerden, Algebra I, § 34 (resultants); tests/boundary/test_bautin.py; Yu. A.
Kuznetsov, Elements of Applied Bifurcation Theory, § 5.4; as `lyapunov_coefficient`.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import combinations, combinations_with_replacement, permutations
from typing import Any

from flint import acb, arb

from ...algebra.exact.function_field import evaluate, occurring
from ...algebra.exact.hurwitz_forms import Budget, by_power, coefficient_row, factors
from ...algebra.exact.number_fields import EXACT, NotExact, characteristic, exact_upright, rational
from ...algebra.exact.rational_functions import common_multiple
from ...algebra.exact.roots import isolated as root_balls
from ...algebra.exact.routh import divided, hurwitz_sign
from ...algebra.exact.triangular import remainder
from ...algebra.krawczyk import NotProvedError, tested
from ...algebra.number_types import precision
from ...base.errors import NoMemberError, StabilityError
from ...derivation.signs import real_roots
from ...polynomials.characteristic import CharacteristicPolynomial
from ...spectra.problem import Problem
from ..lyapunov_coefficient import (
    DerivativePrograms,
    derivatives,
)
from .plane_search import (
    EXACT_BITS,
    SEVERAL,
    PlanePoint,
    PolynomialPair,
    Rectangle,
    judged_places,
    meets,
)
from .planes import PLANE, ExactPlane, subresultant
from .point_records import PointKind, UnresolvedBox

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

    def __init__(self, reading: CharacteristicPolynomial) -> None:
        self.reading, self.field = reading, reading.field
        self.d: DerivativePrograms = derivatives(reading.family.judged)
        self.kept = self.d.kept
        self.mu = self.field.generator(reading.lam)
        self.zero = self.field.ring.constant(0)
        self.matrix, self.scale = self._cleared(
            {(i, j): reading.matrix[i][j] for i in self.kept for j in self.kept}
        )

    # --- derivatives ---

    def _cleared(self, entries: dict[Any, Any]) -> tuple[dict[Any, Poly], Poly]:
        """Entries times a common denominator, and the denominator."""
        reading = self.reading
        values = {k: reading.triangular.value(reading.element(v)) for k, v in entries.items()}
        common = common_multiple((v.den for v in values.values()), self.field.one)
        return {k: v.num * (common / v.den) for k, v in values.items() if v.num != 0}, common

    def _unit(self, index: int) -> list[Any]:
        return [EXACT.constant(float(i == index)) for i in range(len(self.reading.place[0]))]

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
            values = program.run(exact_upright(), [*self.reading.place, *map(self._unit, places)])[
                0
            ]
            entries |= {(i, *places): values[i] for i in self.kept if values[i] != 0}
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
        return coefficient_row(p, self.reading.lam)

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
        rest, _, _ = remainder(p, self.modulus, forms.reading.lam, forms.field.reduced)
        forms.reading.budget.watch(rest)
        return rest

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
                for order in set(permutations(key)):
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


@dataclass(frozen=True)
class Vanishing:
    """A proved zero of the coefficient on a flutter boundary."""

    place: tuple[Any, Any]
    """Balls of x and y."""
    frequency: Any
    """ω."""
    others: int
    """As in `lyapunov_coefficient.others`, next to the point."""


def same_root(polys: tuple[Any, Any], image: Any, place: Any) -> bool:
    """Whether two real roots are one: that of the first polynomial in a ball, of the other one.

    Parameters
    ----------
    polys
        Two polynomials over Q.
    image
        Ball of a root of the second one.
    place
        Ball of a root of the first one, and of no other.
    """
    common = [r for r in map(arb, real_roots(polys[0].gcd(polys[1]))) if r.overlaps(place)]
    return len(common) == 1 and all(
        sum(r.overlaps(common[0]) or r.overlaps(ball) for r in map(arb, real_roots(p))) == 1
        for p, ball in zip(polys, (place, image), strict=True)
    )


KIND = PointKind.VANISHING
MOST_TERMS = 20_000
"""Largest number of terms of a polynomial."""
SECONDS = 20.0
"""Longest time before the elimination [s]."""
MOST_DEGREE = 700
"""Largest degree of a resultant."""
MOST_SIGNS = 3
"""Most square roots in one polynomial."""
ALONG = "the coefficient vanishes along a whole curve, or this is not excluded"
NO_MEMBER = "no member is proved there"
OPEN = (
    "the coefficient vanishes there without a proved change of sign, or other eigenvalues meet on "
    "the imaginary axis"
)


@dataclass(frozen=True)
class _Equation:
    """A factor of a norm over Q, with the polynomial of this norm."""

    factor: Any
    """In Q[x, y]."""
    count: int
    """Its multiplicity."""
    poly: Any
    """In the ring of the reading."""


class ExactSearch:
    """Points of a family's plane at which a first Lyapunov coefficient vanishes.

    Parameters
    ----------
    problem
        A user's family of isolated steady motions, with values.
    names
        Names of x and y.
    rectangle
        Ends of x and y.
    seconds
        Longest time before the elimination [s].

    Raises
    ------
    NotExact
        If the equations are not algebraic in the axes, or too large; the message says how large.
    """

    def __init__(
        self,
        problem: Problem,
        names: tuple[str, str],
        rectangle: Rectangle,
        seconds: float = SECONDS,
    ) -> None:
        family = problem.family
        self.rectangle, self.names = rectangle, names
        base = (*family.at, *family.parameters)
        self.values = {n: rational(float(problem.values[n])) for n in base if n not in names}
        self.reading = CharacteristicPolynomial(family, self.values, Budget(MOST_TERMS, seconds))
        self.forms_of = OnsetForms(self.reading)
        some = list(self.forms_of)
        self.forms = [f for f in some if any(c != 0 for c in f.coefficient)]
        self.flat = len(self.forms) < len(some)
        """Whether a coefficient is zero on all of a boundary, as where rates are linear."""
        self.roots = self._roots()
        self.places, turns = self._axes()
        self.plane = ExactPlane([], turns)

    # --- variables ---

    def _roots(self) -> dict[int, tuple[Any, Any]]:
        """(numerator, denominator) of the square of each variable that is a square root."""
        squares = {i: (s, self.reading.field.one) for i, s in self.reading.field.squares.items()}
        for index, equation in self.reading.triangular.kept:
            parts = by_power(equation, index)
            if set(parts) != {0, 2}:
                raise NotExact("an unknown that is no square root of a rational function")
            squares[index] = -parts[0], parts[2]
        return squares

    def _axes(self) -> tuple[tuple[int, int], tuple[str, str]]:
        """Index of the variable of each axis, and its function."""
        reading = self.reading
        places, turns = [], []
        used = set().union(*(self._used(f) for f in self.forms)) if self.forms else set()
        for axis, name in enumerate(self.names):
            index = reading.base.index(name)
            cosine = [
                i
                for i, (function, x, _) in reading.field.meaning.items()
                if function == "cos" and x.num == reading.field.generator(index) and x.den == 1
            ]
            turned = bool(cosine) and bool(
                used & {i for i in reading.field.meaning if index in reading.field.uses(i)}
            )
            if turned and index in used:
                raise NotExact("an axis and its sine occur together")
            if turned:
                ExactPlane([], ("cos", "cos")).ends(axis, *self.rectangle[axis])
            places.append(cosine[0] if turned else index)
            turns.append("cos" if turned else "")
        left = used - {*places, *self.roots, reading.lam}
        if left:
            raise NotExact(f"{reading.name(min(left))} remains")
        return (places[0], places[1]), (turns[0], turns[1])

    def _used(self, form: OnsetForm) -> set[int]:
        out: set[int] = set().union(*map(occurring, (*form.even, *form.odd, *form.coefficient)))
        while (
            more := {j for i in out & set(self.roots) for p in self.roots[i] for j in occurring(p)}
            - out
        ):
            out |= more
        return out

    def norm(self, poly: Any) -> Any:
        """A polynomial in Q[x, y] that vanishes wherever one in square roots does."""
        for index in sorted(self.roots, reverse=True):
            if poly == 0 or index not in occurring(poly):
                continue
            top, bottom = self.roots[index]
            parts = by_power(poly, index)
            even, odd = self.reading.field.ring.constant(0), self.reading.field.ring.constant(0)
            degree = max(parts) // 2
            for power, part in parts.items():
                half = power // 2
                term = part * top**half * bottom ** (degree - half)
                even, odd = (even, odd + term) if power % 2 else (even + term, odd)
            product = self.reading.budget.product
            poly = (
                odd * top if even == 0 else product(even, even) * bottom - product(odd, odd) * top
            )
            self.reading.budget.watch(poly)
        x, y = self.places
        terms: dict[tuple[int, int], Any] = {}
        for e, c in poly.to_dict().items():
            terms[int(e[x]), int(e[y])] = c
        return PLANE.from_dict(terms)

    def conjugates(self, poly: Any) -> Iterator[Any]:
        """A polynomial with other signs of its square roots, where more than its sign changes."""
        present = [i for i in self.roots if i in occurring(poly)]
        if len(present) > MOST_SIGNS:
            raise NotProvedError
        for count in range(1, len(present) + 1):
            for some in combinations(present, count):
                terms = {
                    e: -c if sum(e[i] for i in some) % 2 else c for e, c in poly.to_dict().items()
                }
                other = self.reading.field.ring.from_dict(terms)
                if other not in (poly, -poly):
                    yield other

    # --- equations ---

    def run(self) -> tuple[list[Vanishing], list[UnresolvedBox]]:
        """Every point in the closed rectangle, and what stays open."""
        vanishing: list[Vanishing] = []
        several = not self.reading.triangular.alone
        left = [UnresolvedBox(KIND, *self.rectangle, SEVERAL)] if several else []
        with precision(EXACT_BITS[-1]):
            self.inner = tuple(self.plane.ends(i, *e) for i, e in enumerate(self.rectangle))
        for form in self.forms:
            judge = _Judge(self, form)
            for meeting in self._factors(judge.meeting):
                for first in self._factors(judge.first):
                    points, open_ = self._solved(judge, meeting, first)
                    vanishing += points
                    left += open_
        return vanishing, left

    def _factors(self, poly: Any) -> list[_Equation]:
        """Factors of a norm, without those that vanish where the coefficient has no value."""
        if poly == 0:
            raise NotExact("an equation holds in all of the plane")
        out = []
        for factor, count in factors(self.norm(poly))[1]:
            if not any(divmod(p, factor)[1] == 0 for p in self._absent):
                out.append(_Equation(factor, count, poly))
        return out

    @cached_property
    def _absent(self) -> list[Any]:
        """Polynomials that vanish only where the coefficient has no value.

        There a derivative or a member has none, or an eigenvalue is zero.
        """
        forms = self.forms_of
        some = [forms.scale, *forms.denominators, forms.characteristic[0]]
        some += [bottom for top, bottom in self.roots.values() if top.is_constant()]
        return [p for p in map(self.norm, some) if not p.is_constant()]

    def _solved(
        self, judge: _Judge, meeting: _Equation, first: _Equation
    ) -> tuple[list[Vanishing], list[UnresolvedBox]]:
        common = meeting.factor.gcd(first.factor)  # a large polynomial may be left in one factor
        f, g = meeting.factor / common, first.factor / common
        along = not common.is_constant() and meets(common, self.inner)
        whole = [UnresolvedBox(KIND, *self.rectangle, ALONG)] if along else []
        if any(p.is_constant() or not meets(p, self.inner) for p in (f, g)):
            return [], whole
        degree = sum(f.degrees()[i] * g.degrees()[1 - i] for i in (0, 1))
        if degree > MOST_DEGREE:
            raise NotExact(
                f"the resultant of polynomials of {len(f)} and {len(g)} terms has degree {degree}, "
                f"more than {MOST_DEGREE}"
            )
        pair = PolynomialPair(f, g)
        simple = meeting.count % 2 == 1 and first.count % 2 == 1

        def judged(place: PlanePoint) -> tuple[Vanishing | None, str]:
            try:
                return judge.judged(pair, place, simple=simple), ""
            except NoMemberError:
                return None, NO_MEMBER
            except (NotProvedError, StabilityError, ArithmeticError):
                return None, "" if self._without_value(f, pair.sides, place) else OPEN

        points, left = judged_places(self.plane, KIND, self.rectangle, pair, judged)
        return points, whole + left

    def _without_value(self, f: Any, sides: Sequence[Any], place: tuple[Any, Any]) -> bool:
        """Whether an eigenvalue is proved to vanish at a candidate on a boundary f = 0."""
        for h, _ in factors(self.norm(self.forms_of.characteristic[0]))[1]:
            try:
                image, box = tested(PolynomialPair(f, h), [v.mid() for v in place])
            except NotProvedError:
                continue
            if not all(b.contains(v) for b, v in zip(box, place, strict=True)):
                continue
            pairs = zip(sides, PolynomialPair(f, h).sides, strict=True)
            if all(map(same_root, pairs, image, place)):
                return True
        return False


class _Judge:
    """What a candidate of one form is, at the family's member."""

    def __init__(self, search: ExactSearch, form: OnsetForm) -> None:
        self.search = search
        reduce = search.reading.triangular.reduce
        both = reduce([*form.even, *form.odd])
        self.even, self.odd = both[: len(form.even)], both[len(form.even) :]
        self.coefficient, self.apart = reduce(form.coefficient), reduce(form.apart)
        size = len(form.even) - 1  # of z in E, which is not below that in O
        self.low, self.high = self._root(size)
        self.meeting = search.reading.field.reduced(subresultant(self.even, self.odd, 0)[0])
        total, most = search.forms_of.zero, len(self.coefficient) - 1
        for k, c in enumerate(self.coefficient):
            total = total + c * (-self.low) ** k * self.high ** (most - k)
        self.first = search.reading.field.reduced(total)

    def _root(self, size: int) -> tuple[Any, Any]:
        """The common root as -low/high."""
        if size > 1:
            linear = subresultant(self.even, self.odd, 1)
            return linear[0], linear[1]
        row = self.odd if len(self.odd) == 2 else self.even
        return row[0], row[1]

    def judged(
        self, pair: PolynomialPair, place: tuple[Any, Any], *, simple: bool
    ) -> Vanishing | None:
        """The point at a candidate; None where the coefficient does not vanish there.

        Raises
        ------
        NotProvedError
            If this is not decided.
        """
        search = self.search
        axes = [search.plane.back(i, v) for i, v in enumerate(place)]
        values = self._member(axes)
        if search.reading.elsewhere(values) is not None:
            return None  # a member of another branch
        left = list(self._vanishing(values))
        if not left or evaluate(search.forms_of.characteristic[0], values) == 0:
            return None  # with an eigenvalue zero there is no coefficient
        image, box = tested(pair, [v.mid() for v in place])
        if not simple or not all(b.contains(v) for b, v in zip(box, place, strict=True)):
            raise NotProvedError
        axes = [search.plane.back(i, v) for i, v in enumerate(image)]
        values = self._member(axes)
        for poly in (self.meeting, self.first):
            for other in search.conjugates(poly):
                _apart(evaluate(other, values))
        high = _apart(evaluate(self.high, values))
        z = -evaluate(self.low, values) / high
        if _apart(z) > 0:
            return None  # opposite real eigenvalues
        mu = acb(0, (-z).sqrt())
        _apart(abs(_at(self.apart, values, mu)))
        scale = _apart(evaluate(search.forms_of.scale, values))
        return Vanishing(
            (axes[0], axes[1]), (-z).sqrt() / abs(scale), self._others(values, z, scale)
        )

    def _member(self, axes: Sequence[Any]) -> dict[int, Any]:
        search = self.search
        point = search.values | dict(zip(search.names, axes, strict=True))
        values = search.reading.member(point)
        if not all(v.is_finite() for v in values.values()):
            raise NotProvedError
        names = list(search.reading.base)
        for name in search.reading.family.positive:
            if not values[names.index(name)] > 0:
                raise NoMemberError(f"{name} is not proved to be positive.")
        return values

    def _vanishing(self, values: dict[int, Any]) -> Iterator[Any]:
        """Common roots z of E and O that may be negative, and at which N may vanish."""
        rows = [
            [arb(evaluate(c, values)) for c in row]
            for row in (self.even, self.odd, self.coefficient)
        ]
        monic = rows[0] if len(rows[0]) > len(rows[1]) else rows[1]
        roots = [acb(-monic[0] / monic[1])] if len(monic) == 2 else root_balls(monic, even=False)
        if roots is None:
            raise NotProvedError
        for z in roots:
            if not (z.imag.contains(0) and not z.real > 0):
                continue
            if all(abs(_sum(row, z)).contains(0) for row in rows):
                yield z

    def _others(self, values: dict[int, Any], z: Any, scale: Any) -> int:
        """Whether all other eigenvalues are stable."""
        p = [arb(evaluate(c, values)) for c in self.search.forms_of.characteristic]
        rest = [c * scale**k for k, c in enumerate(p)]
        quotient = divided(rest, [-z / scale**2, arb(0), arb(1)])
        return hurwitz_sign([c / quotient[-1] for c in quotient])


def _apart(value: Any) -> Any:
    """A ball that is proved not to be zero."""
    ball = arb(value)
    if not ball.is_finite() or ball.contains(0):
        raise NotProvedError
    return ball


def _at(row: Sequence[Any], values: dict[int, Any], mu: Any) -> Any:
    return _sum([arb(evaluate(c, values)) for c in row], mu)


def _sum(row: Sequence[Any], x: Any) -> Any:
    total = acb(0)
    for c in reversed(row):
        total = total * x + c
    return total
