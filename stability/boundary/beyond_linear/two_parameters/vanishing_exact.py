"""Every point of a rectangle at which a first Lyapunov coefficient vanishes, isolated over Q.

On a flutter boundary E and O of `onset_forms` have a common root z, and N(z) = 0.  The resultant of
E and O, and N at the root of their first subresultant, are two equations in both axes.  Square
roots in them are eliminated by norms, and one axis by resultants.  Every candidate is judged at the
member, so what the elimination adds is excluded again.

Source: B. L. van der Waerden, Algebra I, § 34 (resultants); tests/boundary/test_bautin.py.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import combinations
from typing import Any

from flint import acb, arb

from ....algebra.balls import precision
from ....algebra.exact.hurwitz_forms import Budget, by_power, factors
from ....algebra.exact.number_fields import NotExact, rational
from ....algebra.exact.root_balls import isolated as root_balls
from ....algebra.exact.triangular import occurring
from ....algebra.routh_balls import hurwitz_sign
from ....base.errors import NoMemberError, StabilityError
from ....derivation.general.bounds import real_roots
from ....derivation.general.elimination import Reading, evaluate
from ....spectra.problem import Problem
from ..krawczyk import NotProvedError, tested
from .onset_forms import OnsetForm, OnsetForms
from .plane_search import SEVERAL, Rectangle, box_of, meets
from .planes import PLANE, ExactPlane
from .point_records import PointKind, UnresolvedBox
from .polynomial_pairs import PolynomialPair, same_root
from .systems_of_two import subresultant
from .vanishing import Vanishing

KIND = PointKind.VANISHING
BITS = (256, 1024)
"""Precisions of the roots over Q, in turn."""
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

    Raises
    ------
    NotExact
        If the equations are not algebraic in the axes, or too large; the message says how large.
    """

    def __init__(self, problem: Problem, names: tuple[str, str], rectangle: Rectangle) -> None:
        family = problem.family
        self.rectangle, self.names = rectangle, names
        base = (*family.at, *family.parameters)
        self.values = {n: rational(float(problem.values[n])) for n in base if n not in names}
        self.reading = Reading(family, self.values, Budget(MOST_TERMS, SECONDS))
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
        found = {i: (s, self.reading.field.one) for i, s in self.reading.field.squares.items()}
        for index, equation in self.reading.triangular.kept:
            parts = by_power(equation, index)
            if set(parts) != {0, 2}:
                raise NotExact("an unknown that is no square root of a rational function")
            found[index] = -parts[0], parts[2]
        return found

    def _axes(self) -> tuple[tuple[int, int], tuple[str, str]]:
        """Index of the variable of each axis, and its function."""
        reading = self.reading
        places, turns = [], []
        used = set().union(*(self._used(f) for f in self.forms)) if self.forms else set()
        for axis, name in enumerate(self.names):
            own = reading.base.index(name)
            cosine = [
                i
                for i, (function, x, _) in reading.field.meaning.items()
                if function == "cos" and x.num == reading.field.generator(own) and x.den == 1
            ]
            turned = bool(cosine) and bool(
                used & {i for i in reading.field.meaning if own in reading.field.uses(i)}
            )
            if turned and own in used:
                raise NotExact("an axis and its sine occur together")
            if turned:
                ExactPlane([], ("cos", "cos")).ends(axis, *self.rectangle[axis])
            places.append(cosine[0] if turned else own)
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
        found: list[Vanishing] = []
        several = not self.reading.triangular.alone
        left = [UnresolvedBox(KIND, *self.rectangle, SEVERAL)] if several else []
        with precision(BITS[-1]):
            self.inner = tuple(self.plane.ends(i, *e) for i, e in enumerate(self.rectangle))
        for form in self.forms:
            judge = _Judge(self, form)
            for one in self._factors(judge.meeting):
                for other in self._factors(judge.first):
                    points, open_ = self._solved(judge, one, other)
                    found += points
                    left += open_
        return found, left

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
        self, judge: _Judge, one: _Equation, other: _Equation
    ) -> tuple[list[Vanishing], list[UnresolvedBox]]:
        common = one.factor.gcd(other.factor)  # a large polynomial may be left in one factor
        f, g = one.factor / common, other.factor / common
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
        sides = pair.sides
        simple = one.count % 2 == 1 and other.count % 2 == 1
        found: list[Vanishing] = []
        left: list[UnresolvedBox] = []
        for bits in BITS:
            with precision(bits):
                found, left = [], []
                for x, y in pair.near([self._inside(s, i) for i, s in enumerate(sides)]):
                    try:
                        point = judge.judged(pair, (x, y), simple=simple)
                    except NoMemberError:
                        left.append(self._open((x, y), NO_MEMBER))
                    except (NotProvedError, StabilityError, ArithmeticError):
                        if not self._without_value(f, sides, (x, y)):
                            left.append(self._open((x, y), OPEN))
                    else:
                        found += [] if point is None else [point]
            if not left:
                break
        return found, whole + left

    def _inside(self, side: Any, axis: int) -> list[Any]:
        low, high = self.inner[axis]
        return [r for r in map(arb, real_roots(side)) if not (r < low or r > high)]

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

    def _open(self, place: tuple[Any, Any], reason: str) -> UnresolvedBox:
        ends = [box_of(self.plane.back(i, v), self.rectangle[i]) for i, v in enumerate(place)]
        return UnresolvedBox(KIND, ends[0], ends[1], reason)


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
            found = subresultant(self.even, self.odd, 1)
            return found[0], found[1]
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
        known = self._member(axes)
        if search.reading.elsewhere(known) is not None:
            return None  # a member of another branch
        left = list(self._vanishing(known))
        if not left or evaluate(search.forms_of.characteristic[0], known) == 0:
            return None  # with an eigenvalue zero there is no coefficient
        image, box = tested(pair, [v.mid() for v in place])
        if not simple or not all(b.contains(v) for b, v in zip(box, place, strict=True)):
            raise NotProvedError
        axes = [search.plane.back(i, v) for i, v in enumerate(image)]
        known = self._member(axes)
        for poly in (self.meeting, self.first):
            for other in search.conjugates(poly):
                _apart(evaluate(other, known))
        high = _apart(evaluate(self.high, known))
        z = -evaluate(self.low, known) / high
        if _apart(z) > 0:
            return None  # opposite real eigenvalues
        mu = acb(0, (-z).sqrt())
        _apart(abs(_at(self.apart, known, mu)))
        scale = _apart(evaluate(search.forms_of.scale, known))
        return Vanishing(
            (axes[0], axes[1]), (-z).sqrt() / abs(scale), self._others(known, z, scale)
        )

    def _member(self, axes: Sequence[Any]) -> dict[int, Any]:
        search = self.search
        point = search.values | dict(zip(search.names, axes, strict=True))
        known = search.reading.member(point)
        if not all(v.is_finite() for v in known.values()):
            raise NotProvedError
        names = list(search.reading.base)
        for name in search.reading.family.positive:
            if not known[names.index(name)] > 0:
                raise NoMemberError(f"{name} is not proved to be positive.")
        return known

    def _vanishing(self, known: dict[int, Any]) -> Iterator[Any]:
        """Common roots z of E and O that may be negative, and at which N may vanish."""
        rows = [
            [arb(evaluate(c, known)) for c in row]
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

    def _others(self, known: dict[int, Any], z: Any, scale: Any) -> int:
        """Whether all other eigenvalues are stable."""
        p = [arb(evaluate(c, known)) for c in self.search.forms_of.characteristic]
        rest = [c * scale**k for k, c in enumerate(p)]
        square, out = -z / scale**2, []
        for k in range(len(rest) - 1, 1, -1):  # division by λ² + ω², highest power first
            out.append(rest[k])
            rest[k - 2] = rest[k - 2] - square * rest[k]
        quotient = [c / out[0] for c in out[::-1]]
        return hurwitz_sign(quotient) if len(quotient) > 1 else 1


def _apart(value: Any) -> Any:
    """A ball that is proved not to be zero."""
    ball = arb(value)
    if not ball.is_finite() or ball.contains(0):
        raise NotProvedError
    return ball


def _at(row: Sequence[Any], known: dict[int, Any], mu: Any) -> Any:
    return _sum([arb(evaluate(c, known)) for c in row], mu)


def _sum(row: Sequence[Any], x: Any) -> Any:
    total = acb(0)
    for c in reversed(row):
        total = total * x + c
    return total
