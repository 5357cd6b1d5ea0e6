"""Signs of polynomials over a domain, with proofs: bounds of variables and polynomials known > 0.

A polynomial is positive where every coefficient is, after variables are replaced by positive ones.
A proof is a sentence that a reader can repeat.

Bounds are intervals of variables, with the rationals and roots inside them.  Negative terms may be
outweighed by squares: 2 a b ≤ a² + b².
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import combinations, product
from typing import Any

from flint import fmpq

from ..algebra.exact.function_field import occurring
from ..algebra.exact.hurwitz_forms import by_power, factors
from ..algebra.exact.rational_functions import univariate
from ..polynomials.characteristic import text

Poly = Any
"""An `fmpq_mpoly`."""


@dataclass(frozen=True)
class Bounds:
    """An interval of a variable; None means no bound."""

    low: Any = None
    """Lower bound, a rational."""
    high: Any = None
    """Upper bound, a rational."""
    at_low: bool = False
    """Whether the lower bound itself is allowed."""
    at_high: bool = False
    """Whether the upper bound itself is allowed."""

    @property
    def free(self) -> bool:
        """Whether there is no bound."""
        return self.low is None and self.high is None

    def holds(self, value: Any) -> bool:
        """Whether a rational or a whole ball lies inside."""
        inside = self.low is None or value > self.low or (self.at_low and value == self.low)
        below = self.high is None or value < self.high or (self.at_high and value == self.high)
        return bool(inside and below)

    def outside(self, value: Any) -> bool:
        """Whether a rational or a whole ball lies outside."""
        under = self.low is not None and (
            value < self.low or (value == self.low and not self.at_low)
        )
        over = self.high is not None and (
            value > self.high or (value == self.high and not self.at_high)
        )
        return bool(under or over)

    def narrowed(self, low: Any, high: Any, allowed: bool) -> Bounds:
        """The interval cut by another one, whose bounds are allowed or not."""
        bottom, at_low, top, at_high = self.low, self.at_low, self.high, self.at_high
        if low is not None and (bottom is None or low >= bottom):
            bottom, at_low = low, allowed and (at_low or low != bottom)
        if high is not None and (top is None or high <= top):
            top, at_high = high, allowed and (at_high or high != top)
        return Bounds(bottom, top, at_low, at_high)


def number_of(poly: Any) -> Any:
    """The value of a constant polynomial; None counts as zero."""
    if poly is None or poly == 0:
        return fmpq(0)
    return poly.leading_coefficient()


def real_roots(poly: Any) -> list[Any]:
    """Real roots of an `fmpq_poly` as balls, sorted; a rational root is exact."""
    roots: list[Any] = []
    for factor, _ in poly.numer().factor()[1]:
        if factor.degree() == 1:
            roots.append(fmpq(-int(factor[0]), int(factor[1])))
        elif factor.degree() > 1:
            roots += [r.real for r, _ in factor.complex_roots() if r.imag == 0]
    return sorted(roots, key=lambda r: r if isinstance(r, fmpq) else r.mid().fmpq())


def between(roots: Sequence[Any], low: Any, high: Any) -> Iterator[Any]:
    """Rationals between neighbouring roots and beyond the outer ones, within open bounds."""
    inner = [r if isinstance(r, fmpq) else r.mid().fmpq() for r in roots]
    inner = [r for r in inner if (low is None or r > low) and (high is None or r < high)]
    first = low if low is not None else (min(inner, default=fmpq(0)) - 1) * 2
    last = high if high is not None else (max(inner, default=fmpq(0)) + 1) * 2
    edges = [first, *inner, max(last, first + 1)] if high is None else [first, *inner, last]
    for a, b in zip(edges, edges[1:], strict=False):
        if a < b:
            yield short(a, b)


def short(low: Any, high: Any) -> Any:
    """The decimal of fewest digits well inside an interval.

    Examples
    --------
    >>> short(fmpq(1, 3), fmpq(1, 2))
    2/5
    """
    slack = (high - low) / 10
    middle, scale = (low + high) / 2, fmpq(1)
    while scale < high - low:
        scale *= 10
    while True:
        value = fmpq(int((middle / scale + fmpq(1, 2)).floor())) * scale
        if low + slack < value < high - slack:
            return value
        scale /= 10


MOST_NEGATIVE = 4
"""Negative terms beyond which no squares are sought."""
MOST_SQUARED = 40
"""Terms beyond which no squares are sought."""
Exponents = tuple[int, ...]
Terms = Mapping[Exponents, Any]
"""Rational coefficients by the exponents of their monomials."""


def outweighed(terms: Terms, never_negative: Callable[[Exponents], bool]) -> dict[Any, Any] | None:
    """What is left of a polynomial after every negative term is completed to a square, or None.

    A term -c·M with M² = A·B is outweighed by p·A + q·B where A, B ≥ 0 and c² ≤ 4 p q.  Where c²
    is less, with s = c²/(4 p q), the part (1 - s)/2 of both is left, since √s ≤ (1 + s)/2.

    Parameters
    ----------
    terms
        The polynomial.
    never_negative
        Whether the monomial of some exponents is nowhere negative.

    Returns
    -------
    dict or None
        Terms with positive coefficients: the polynomial is nowhere less than their sum.

    Source: tests/derivation/test_signs.py.

    Examples
    --------
    >>> from fractions import Fraction
    >>> one = Fraction(1)
    >>> outweighed({(4, 0): one, (2, 1): -2 * one, (0, 2): one, (0, 0): 3 * one},
    ...            lambda e: all(n % 2 == 0 for n in e))
    {(0, 0): Fraction(3, 1)}
    """
    negative = [e for e, c in terms.items() if c < 0 or not never_negative(e)]
    if not negative or len(negative) > MOST_NEGATIVE or len(terms) > MOST_SQUARED:
        return None
    return _completed(
        {e: c for e, c in terms.items() if e not in negative}, [(e, terms[e]) for e in negative]
    )


def _completed(
    good: dict[Exponents, Any], negative: list[tuple[Exponents, Any]]
) -> dict[Exponents, Any] | None:
    """The terms left after all negative ones are completed, by any choice of pairs."""
    if not negative:
        return good
    (middle, c), *others = negative
    for a, b in combinations(good, 2):
        if any(i + j != 2 * k for i, j, k in zip(a, b, middle, strict=True)):
            continue
        share = c * c / (4 * good[a] * good[b])
        if share > 1:
            continue
        left = {e: v * (1 - share) / 2 if e in (a, b) else v for e, v in good.items()}
        completed = _completed({e: v for e, v in left.items() if v}, others)
        if completed is not None:
            return completed
    return None


MOST_TERMS = 4000
"""Terms of a polynomial, after a substitution, beyond which no proof is sought."""


@dataclass(frozen=True)
class Sign:
    """The sign of a polynomial: a known sign times factors whose sign is open."""

    value: int
    """1 or -1; 0 for the polynomial zero."""
    open: tuple[Poly, ...]
    """Factors of odd power whose sign is not proved."""
    reasons: tuple[str, ...]
    """Proofs of the other factors."""
    nonzero: tuple[Poly, ...]
    """Factors of even power whose sign is not proved: they must not vanish."""


class Domain:
    """Variables with bounds, and polynomials known to be positive."""

    def __init__(self, ring: Any, names: Sequence[str]) -> None:
        self.ring, self.names = ring, list(names)
        self.bounds: dict[int, Bounds] = {}
        """Bounds by index of the variable."""
        self.facts: list[tuple[Poly, str]] = []
        """(polynomial that is positive, reason)."""
        self.natural: set[int] = set()
        """Variables whose closed bounds hold for every number: sines and cosines."""
        self.nonzero: list[Poly] = []
        """Polynomials that do not vanish."""
        self._waiting: list[tuple[Poly, str]] = []
        self._known: dict[str, str | None] = {}

    def text(self, poly: Poly) -> str:
        """A polynomial as text."""
        return text(poly, lambda i: self.names[i])

    # --- what is known ---

    def interval(self, index: int) -> str:
        """The bounds of a variable as text."""
        limits, name = self.bounds[index], self.names[index]
        below = "" if limits.low is None else f"{limits.low} <{'=' * limits.at_low} "
        above = "" if limits.high is None else f" <{'=' * limits.at_high} {limits.high}"
        if below and not above:
            return f"{name} >{'=' * limits.at_low} {limits.low}"
        return f"{below}{name}{above}"

    def bound(self, index: int, low: Any = None, high: Any = None, *, closed: bool = False) -> None:
        """Narrow the interval of a variable."""
        old = self.bounds.get(index, Bounds())
        self.bounds[index] = old.narrowed(low, high, closed)
        self._known.clear()

    def learn(self, poly: Poly, reason: str) -> None:
        """Take a polynomial as positive, factor by factor where the others have a proved sign."""
        for factor in self.sign(poly).open:
            self.exclude(factor)
        self._waiting.append((poly, reason))
        changed = True
        while changed:
            changed = False
            for entry in list(self._waiting):
                sign = self.sign(entry[0])
                if len(sign.open) > 1:
                    continue
                self._waiting.remove(entry)
                changed = True
                if sign.open:
                    self._take(sign.open[0] * sign.value, entry[1])

    def exclude(self, poly: Poly) -> None:
        """Take a polynomial as different from zero; a bound where it vanishes is not allowed."""
        self.nonzero.append(poly)
        if poly.total_degree() != 1 or len(occurring(poly)) != 1:
            return
        (index,) = occurring(poly)
        parts = by_power(poly, index)
        edge = -number_of(parts.get(0)) / number_of(parts[1])
        limits = self.bounds.get(index, Bounds())
        self.bounds[index] = Bounds(
            limits.low,
            limits.high,
            limits.at_low and limits.low != edge,
            limits.at_high and limits.high != edge,
        )
        self._known.clear()

    def _take(self, poly: Poly, reason: str) -> None:
        self._known.clear()
        variables = occurring(poly)
        if len(variables) == 1 and poly.total_degree() == 1:
            (index,) = variables
            parts = by_power(poly, index)
            edge = -number_of(parts.get(0)) / number_of(parts[1])
            if parts[1].leading_coefficient() > 0:
                self.bound(index, low=edge)
            else:
                self.bound(index, high=edge)
        self.facts.append((poly, reason))

    @property
    def assumed(self) -> list[tuple[Poly, str]]:
        """Polynomials taken as positive that are products of open factors."""
        return list(self._waiting)

    # --- proofs ---

    def sign(self, poly: Poly) -> Sign:
        """The sign of a polynomial, factor by factor."""
        if poly == 0:
            return Sign(0, (), (), ())
        constant, factorisation = factors(poly)
        sign = 1 if constant > 0 else -1
        open_: list[Poly] = []
        reasons: list[str] = []
        nonzero: list[Poly] = []
        for factor, power in factorisation:
            why = self.positive(factor)
            turned = None if why else self.positive(-factor)
            if why or turned:
                sign *= -1 if turned and power % 2 else 1
                sense = "> 0" if why else "< 0"
                reasons.append(f"{self.text(factor)} {sense}: {why or turned}")
            elif power % 2:
                open_.append(factor)
            elif factor in self.nonzero or -factor in self.nonzero:
                reasons.append(f"({self.text(factor)})**{power} > 0: an even power")
            else:
                nonzero.append(factor)
        return Sign(sign, tuple(open_), tuple(reasons), tuple(nonzero))

    def positive(self, poly: Poly) -> str | None:
        """A proof that a polynomial is positive in the whole domain, or None."""
        if poly.is_constant():
            return "a positive number" if number_of(poly) > 0 else None
        key = str(poly)
        if key not in self._known:
            self._known[key] = self._proof(poly)
        return self._known[key]

    def _proof(self, poly: Poly) -> str | None:
        for fact, reason in self.facts:
            ratio = _ratio(poly, fact)
            if ratio is not None and ratio > 0:
                return reason
        proof = self._inside(poly) or self._termwise(poly) or self._rootless(poly)
        return proof or self._as_squares(poly)

    def _inside(self, poly: Poly) -> str | None:
        """A bound of one variable says it."""
        if poly.total_degree() != 1 or len(occurring(poly)) != 1:
            return None
        (index,) = occurring(poly)
        parts = by_power(poly, index)
        slope, edge = number_of(parts[1]), -number_of(parts.get(0)) / number_of(parts[1])
        limits = self.bounds.get(index, Bounds())
        nearest, at = (limits.low, limits.at_low) if slope > 0 else (limits.high, limits.at_high)
        if nearest is None or (nearest - edge) * slope < 0 or (nearest == edge and at):
            return None
        return "in the domain"

    def implied(self, poly: Poly, assumed: Poly, name: str) -> str | None:
        """A proof that a polynomial is positive where another one is, or None.

        Parameters
        ----------
        poly
            The polynomial.
        assumed
            A polynomial that is positive, linear in some variable with a factor of proved sign.
        name
            What the proof calls the other one.
        """
        for index in sorted(occurring(assumed) & occurring(poly)):
            parts = by_power(assumed, index)
            if max(parts) != 1:
                continue
            for sign in (1, -1):
                lead, rest = parts[1] * sign, parts.get(0, self.ring.constant(0))
                # where the factor vanishes the rest would have to be positive
                if not (self.positive(lead) or (self._squares(lead) and self.positive(-rest))):
                    continue
                # lead · x = ±(v - rest) with v > 0; v takes the place of x in the ring
                v = self.ring.gens()[index]
                moved = _homogeneous(poly, index, (v - rest) * sign, lead)
                common = moved.gcd(lead ** int(poly.degrees()[index]))
                if self._squares(common):
                    moved = moved / common
                before = self.bounds.get(index)
                self.bounds[index] = Bounds(low=fmpq(0))
                proof = self._termwise(moved)
                if before is None:
                    del self.bounds[index]
                else:
                    self.bounds[index] = before
                if proof:
                    return f"follows from {name}, solved for {self.names[index]}: {proof}"
        return None

    def _squares(self, poly: Poly) -> bool:
        """Whether no term is negative: even powers, and variables that are not negative."""

        def even(index: int) -> bool:
            low = self.bounds.get(index, Bounds()).low
            return low is not None and bool(low >= 0)

        return all(
            c > 0 and all(int(e) % 2 == 0 or even(i) for i, e in enumerate(exponents))
            for exponents, c in poly.to_dict().items()
        )

    def _as_squares(self, poly: Poly) -> str | None:
        """Squares outweigh every negative term, and what is left is positive."""

        def never_negative(exponents: tuple[int, ...]) -> bool:
            return self._squares(self.ring.from_dict({exponents: 1}))

        terms = {tuple(map(int, e)): c for e, c in poly.to_dict().items()}
        left = outweighed(terms, never_negative)
        rest = self.ring.from_dict(left) if left else None
        why = None if rest is None else self._termwise(rest)
        if rest is None or why is None:
            return None
        return f"2*a*b <= a**2 + b**2 leaves at least {self.text(rest)} > 0: {why}"

    def _termwise(self, poly: Poly) -> str | None:
        """Every coefficient is positive: as it is, or with positive variables."""
        return self._with_even_powers(poly) or self._replaced(poly)

    def _with_even_powers(self, poly: Poly) -> str | None:
        """The same where only even powers of the variables of both signs occur."""
        before = dict(self.bounds)
        self.bounds = {i: b for i, b in before.items() if b.low is not None and b.low >= 0}
        try:
            return self._replaced(poly)
        finally:
            self.bounds = before

    def _replaced(self, poly: Poly) -> str | None:
        words = []
        degrees = [int(d) for d in poly.degrees()]  # before t = oo takes the highest ones away
        for index in sorted(occurring(poly)):
            limits = self.bounds.get(index, Bounds())
            t, name = self.ring.gens()[index], self.names[index]
            low, high = limits.low, limits.high
            if low is not None and high is not None:
                poly = _homogeneous(poly, index, low + high * t, 1 + t)
                words.append(f"{name} = {_between(low, high)}")
            elif high is not None:
                poly = poly.compose(*self._shifted(index, high - t))
                words.append(f"{name} = {high} - t")
            elif low is not None and low != 0:
                poly = poly.compose(*self._shifted(index, t + low))
                words.append(f"{name} = {low} + t")
            if len(poly) > MOST_TERMS:
                return None
        return self._every(poly, words, degrees)

    def _shifted(self, index: int, value: Poly) -> list[Poly]:
        return [value if i == index else g for i, g in enumerate(self.ring.gens())]

    def _every(self, poly: Poly, words: list[str], degrees: list[int]) -> str | None:
        """A sentence where no term is negative and on each allowed bound some term is left."""
        if poly == 0:
            return None
        terms = {tuple(map(int, e)): c for e, c in poly.to_dict().items()}
        limits = {i: self.bounds.get(i, Bounds()) for i, d in enumerate(degrees) if d}
        free = [i for i, b in limits.items() if b.free]
        if any(c < 0 or any(e[i] % 2 for i in free) for e, c in terms.items()):
            return None
        faces = [[(i, None), *self._faces(i, b, degrees[i])] for i, b in limits.items()]
        for face in product(*faces):
            if not any(
                all(d is None or e[i] == d for i, d in face) and not any(e[i] for i in free)
                for e in terms
            ):
                return None
        even = f", powers of {', '.join(self.names[i] for i in free)} are even" if free else ""
        after = f" after {', '.join(words)} with t > 0" if words else ""
        return f"every coefficient is positive{after}{even}"

    @staticmethod
    def _faces(index: int, limits: Bounds, degree: int) -> list[tuple[int, int]]:
        """Exponents of the new variable that are left on an allowed bound."""
        both = limits.low is not None and limits.high is not None
        if not both:
            return [(index, 0)] if limits.at_low or limits.at_high else []
        return [(index, 0)] * limits.at_low + [(index, degree)] * limits.at_high

    def _rootless(self, poly: Poly) -> str | None:
        """A polynomial in one variable without a root in its interval."""
        variables = occurring(poly)
        if len(variables) != 1:
            return None
        (index,) = variables
        limits = self.bounds.get(index, Bounds())
        single = univariate(poly, index)
        inside = limits.low if limits.low is not None else limits.high
        if limits.low is not None:
            inside = limits.low + (
                fmpq(1) if limits.high is None else (limits.high - limits.low) / 2
            )
        elif limits.high is not None:
            inside = limits.high - 1
        else:
            inside = fmpq(0)
        if not single(inside) > 0:
            return None
        if not all(limits.outside(root) for root in real_roots(single)):
            return None
        return f"positive at {self.names[index]} = {inside}, without a root in the interval"


def _between(low: Any, high: Any) -> str:
    """The substitution of a variable between two bounds, as text."""
    top = [str(low)] if low != 0 else []
    top += [f"{high}*t" if high != 1 else "t"] if high != 0 else []
    joined = " + ".join(top)
    return f"({joined})/(1 + t)" if len(top) > 1 else f"{joined}/(1 + t)"


def _ratio(p: Poly, q: Poly) -> Any:
    """p/q where it is a number, otherwise None."""
    if len(p) != len(q):
        return None
    ratio = p.leading_coefficient() / q.leading_coefficient()
    return ratio if p == q * ratio else None


def _homogeneous(poly: Poly, index: int, top: Poly, bottom: Poly) -> Poly:
    """The polynomial at top/bottom in place of a variable, times a power of bottom > 0."""
    parts = by_power(poly, index)
    degree = max(parts)
    out = poly - poly
    for power, part in parts.items():
        out = out + part * top**power * bottom ** (degree - power)
    return out
