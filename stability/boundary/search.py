"""Every value of an axis at which the verdict can change, isolated, with its verdicts.

They are roots of polynomials.  For the disk these are the conditions over Q of
`stability.bodies.disk_polynomials`, where every quantity but the axis is the exact ratio of its
double.  For a user's family whose graph is rational in the axis they come from its characteristic
polynomial.  Between neighbouring roots no eigenvalue meets the imaginary axis, so one exact verdict
holds on each piece.

Values found include single values, where the verdict differs from that on both sides.  Where an
eigenvalue reaches the imaginary axis while others keep the motion unstable, the verdict stays.
Where all unstable eigenvalues reach the axis together, as for undamped motions between damping and
driving, the member is neutral there and unstable on both sides.

Source: a polynomial p of degree n has, for every j, a zero within (C(n, j) |p(z) j!/p⁽ʲ⁾(z)|)^(1/j)
of z: the j-th elementary symmetric function of 1/(z - zeros) has C(n, j) terms;
tests/boundary/test_single_points.py; Orlando's formula (F. R. Gantmacher, The Theory of Matrices,
vol. 2, ch. XV § 7) for the resultant of even and odd part; tests/boundary/test_boundaries.py counts
the roots by another route.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from fractions import Fraction
from functools import cache, reduce
from itertools import combinations
from math import comb
from operator import mul
from typing import Any

import numpy as np
from flint import acb, acb_poly, arb, arb_poly, fmpq, fmpq_poly, fmpz

from ..algebra.exact.hurwitz_forms import by_power
from ..algebra.exact.number_fields import EXACT, NotExact, characteristic, rational, rational_root
from ..algebra.exact.rational_functions import (
    RING,
    Ratio,
    common_multiple,
    multivariate,
    primitive,
    univariate,
)
from ..algebra.exact.roots import (
    BITS,
    MOST_BITS,
    UnclearError,
    complex_roots,
    real_roots,
    sign_at,
    specialised,
)
from ..algebra.exact.routh import least_sign, on_the_axis
from ..algebra.number_types import MIXED, Algebra, precision
from ..algebra.polynomial import TabulatedPolynomial
from ..base.verdict import Verdict
from ..spectra.problem import Problem
from ..systems.family import Family

FREQUENCY_BITS = 128
"""Digits of the roots for a frequency in doubles."""


def frequency(polynomial: Sequence[Any], *, even: bool = False) -> float:
    """Frequency of the pair on (or next to) the imaginary axis, from the polynomial.

    Parameters
    ----------
    polynomial
        Coefficients as balls, lowest first, of a polynomial with a pair near the axis.
    even
        Whether the polynomial is q(λ²) with two roots in λ² that meet.  Every pair is then on the
        axis, and the frequency is that of two pairs that meet.

    Returns
    -------
    float
        |Im λ| of the root nearest the imaginary axis among those that are not real, or of the two
        nearest to each other; 0 if all are real.

    Examples
    --------
    >>> frequency([arb(4), arb(0), arb(1)]), frequency([arb(c) for c in (9, 0, 6, 0, 1)], even=True)
    (2.0, 1.7320508075688772)
    """
    # over Q, where roots of any multiplicity are isolated
    exact = [c.mid().fmpq() for c in map(arb, polynomial)]
    with precision(FREQUENCY_BITS):
        known = _meeting(fmpq_poly(exact[::2])) if even else _crossing(fmpq_poly(exact))
        return min(known, default=(math.inf, 0.0))[1]


def _crossing(polynomial: Any) -> Iterator[tuple[float, float]]:
    """(distance from the imaginary axis over |Im λ|, |Im λ|) of each root that is not real."""
    for root, _ in complex_roots(polynomial):
        if root.imag != 0:
            yield abs(float((root.real / root.imag).mid())), abs(float(root.imag.mid()))


def _meeting(squares: Any) -> Iterator[tuple[float, float]]:
    """(distance over size, √-y) of each two roots of a polynomial in λ² about some y < 0."""
    roots = [root for root, count in complex_roots(squares) for _ in range(count)]
    for y, z in combinations(roots, 2):
        middle = float(((y + z) / 2).real.mid())
        if middle < 0:
            yield float(abs(z - y).mid()) / -middle, math.sqrt(-middle)


MOST_WORK = 300_000
"""Most work on one polynomial, degree times states³/2 times bits of a coefficient: about ten
seconds."""

MOST_STATES = 12
"""States of the largest system whose characteristic polynomial is expanded."""


def characteristic_ratios(family: Family, a: Sequence[Any], q: Sequence[Any]) -> tuple[Any, Any]:
    """The characteristic polynomial of a family along an axis, exactly.

    Parameters
    ----------
    family
        A family without equations to solve, or whose guess solves them identically.
    a, q
        Family parameters and parameters: rationals, and ratios in the axis.

    Returns
    -------
    coefficients, denominator
        Coefficients of a multiple of det(λ - A) by powers of λ, lowest first, without common
        factor; and the polynomial in x at whose zeros an entry of A has no value.  All are
        `fmpq_poly` in x.

    Raises
    ------
    NotExact
        If the graph is not rational in the axis, or too large.
    """
    size = len(family.system.states)
    if size > MOST_STATES or (family.unknown and not family.closed):
        raise NotExact("no closed form")
    u = [rational(v) for v in family.unknown.values()]
    try:
        rows = family.graph.matrix.dense(EXACT, [list(a), u, list(q)])
    except ZeroDivisionError:
        raise NotExact("a denominator vanishes all along the axis") from None
    entries = {(i, j): Ratio.of(v) for i, row in enumerate(rows) for j, v in enumerate(row)}
    entries = {place: e for place, e in entries.items() if not e.top.is_zero()}
    common = common_multiple((e.bottom for e in entries.values()), RING.constant(1))
    below = univariate(common)
    tops = {place: univariate(e.top * (common / e.bottom)) for place, e in entries.items()}
    degree = max(1, below.degree(), *(e.degree() for e in tops.values()))
    bits = max(map(_bits, tops.values()), default=0)
    if degree * size * size * size // 2 * bits > MOST_WORK:
        raise NotExact("the polynomials are too large")
    # over Z, where products need no common denominators
    scale = reduce(fmpz.lcm, (p.denom() for p in tops.values()), below.denom())
    whole = {place: (p * scale).numer() for place, p in tops.items()}
    found = characteristic([[whole.get((i, j), 0) for j in range(size)] for i in range(size)])
    power, share = (below * scale).numer(), fmpq(1, scale**size)
    return primitive([fmpq_poly(c * power**j) * share for j, c in enumerate(found)]), below


def _bits(p: Any) -> int:
    longest = [max(int(c.p.height_bits()), int(c.q.height_bits())) for c in p.coeffs()]
    return max(longest, default=0)


class Conditions:
    """The disk's conditions along an axis: all positive, or some negative.

    Parameters
    ----------
    polynomials
        (kind, polynomial in x and perhaps s).
    sine
        Function that gives s at the working precision; None where there is no s.
    dissipative
        Whether the good verdict is stable rather than neutral.
    """

    def __init__(
        self,
        polynomials: Sequence[tuple[str, Any]],
        sine: Callable[[], Any] | None,
        *,
        dissipative: bool,
    ) -> None:
        self.critical = list(polynomials)
        self.poles = None
        self.sine, self.dissipative = sine, dissipative

    def sign(self, x: Any) -> int:
        """1 stable or neutral, -1 unstable, 0 on a boundary.

        Parameters
        ----------
        x
            A rational value of the variable.
        """
        return least_sign([sign_at(p, x, self.sine) for _, p in self.critical])


class Characteristic:
    """A characteristic polynomial along an axis, as a product of factors.

    Parameters
    ----------
    factors
        Coefficients of each by powers of λ, lowest first: `fmpq_poly` in x without common factor.
    poles
        Polynomial at whose zeros there is no linearisation, or None.
    """

    sine = None

    def __init__(self, factors: Sequence[Sequence[Any]], poles: Any) -> None:
        self.factors = [list(f) for f in factors]
        self.poles = poles
        self.parts = [_parts(f) for f in self.factors]
        self.dissipative = all(even.total_degree() == 0 for even, _ in self.parts)
        self.critical = [c for even, rest in self.parts for c in _critical(even, rest)]

    def verdict(self, x: Any) -> Verdict:
        """The verdict at a rational value."""
        return on_the_axis([fmpq_poly([c(x) for c in f]) for f in self.factors])

    def sign(self, x: Any) -> int:
        """1 stable or neutral, -1 unstable.

        Parameters
        ----------
        x
            A rational value of the axis.
        """
        return -1 if self.verdict(x) is Verdict.UNSTABLE else 1

    def frequency(self, x: Any) -> float:
        """|Im λ| of the pair that meets the imaginary axis, or of the two pairs that meet on it.

        Parameters
        ----------
        x
            A rational value next to the root.
        """
        known = [
            one
            for even, rest in self.parts
            for one in (*_crossing(specialised(rest, x)), *_meeting(specialised(even, x)))
        ]
        return min(known, default=(math.inf, 0.0))[1]


def _parts(factor: Sequence[Any]) -> tuple[Any, Any]:
    """q(y) of the factor's even part q(λ²), and the rest without mirrored roots, neither with λ."""
    first = next(i for i, c in enumerate(factor) if not c.is_zero())
    kept = factor[first:]
    lam = RING.gens()[1]
    whole, mirror = RING.constant(0), RING.constant(0)
    for i, c in enumerate(kept):
        term = multivariate(c) * lam**i
        whole, mirror = whole + term, mirror + (-term if i % 2 else term)
    common = whole.gcd(mirror)
    rest = whole / common
    halved = RING.from_dict({(i, j // 2): c for (i, j), c in common.terms()})
    return halved, rest


def _critical(even: Any, rest: Any) -> list[tuple[str, Any]]:
    """Polynomials that vanish where an eigenvalue meets the imaginary axis or infinity."""
    out: list[tuple[str, Any]] = []
    zero = RING.constant(0)
    for poly in (rest, even):
        degree, by = poly.degrees()[1], by_power(poly, 1)
        if degree >= 1:
            out += [("static", by.get(0, zero)), ("pole", by[degree])]
        if poly is rest and degree >= 2:
            halves = [zero, zero]
            for power, c in by.items():
                halves[power % 2] = halves[power % 2] + c * RING.gens()[1] ** (power // 2)
            out.append(("flutter", halves[0].resultant(halves[1], "s")))
    if even.degrees()[1] >= 2:
        plain = even / even.gcd(even.derivative("s"))
        if plain.degrees()[1] >= 2:
            out.append(("flutter", plain.discriminant("s")))
    return [(kind, p) for kind, p in out if not p.is_constant()]


POSITIVE = ("k", "mu", "c", "mass", "radius", "gravity")
"""Axes of the disk that are positive."""
KINDS = ("static", "flutter", "auxiliary")
"""Kinds of conditions, in the order in which they name a zero."""
SHORT = (8, 24)
"""Bits that are tried for a value between two roots."""
X, S = (Ratio(g) for g in RING.gens())


@dataclass(frozen=True)
class Mark:
    """A value of the axis at which the verdict may differ from the verdicts around it."""

    value: Any
    """Ball in the unit of the axis."""
    kind: str
    """static, flutter, edge (upright, where families meet) or pole (no linearisation)."""
    below: int
    """Verdict just below: 1 stable or neutral, -1 unstable."""
    above: int
    """Verdict just above."""
    root: Any
    """Ball of the polynomials' variable there."""


@dataclass(frozen=True)
class Search:
    """Every possible change of verdict along an axis."""

    marks: tuple[Mark, ...]
    """Marks in increasing order, both ends of the interval included."""
    source: Conditions | Characteristic
    """Polynomials that were searched."""
    angle: str = ""
    """theta or lean where the variable is the sine of that angle."""
    gaps: tuple[float, ...] = field(default=())
    """Values at which there is no member."""


def search(
    problem: Problem, axis: str, low: float | None, high: float | None, bits: int = BITS
) -> Search:
    """Every value of an axis at which the verdict can change, isolated.

    Parameters
    ----------
    problem
        Family with one number for every quantity but the axis.
    axis
        Name of the axis.
    low, high
        Ends of the interval, both included; None for no end.
    bits
        Working precision of the first attempt.

    Raises
    ------
    NotExact
        If the family's graph is not rational in the axis.
    UnclearError
        If the budget of precision ends.

    Examples
    --------
    >>> from stability.bodies.contact_laws import Viscous
    >>> from stability.bodies.disk import Disk
    >>> from stability.spectra.problem import disk_problem
    >>> found = search(disk_problem("spinning", Disk(), Viscous(0.97)), "at", 0.1, 5)
    >>> [(m.kind, round(float(m.value), 10)) for m in found.marks if m.below != m.above]
    [('static', 2.0), ('flutter', 2.0451355787)]
    """
    given = problem.rationals({n: v for n, v in problem.values.items() if n != axis})
    source, angle, edge = _source(problem, given, axis)
    ends = tuple(None if v is None else rational(v) for v in (low, high))
    positive = not problem.plain and axis in POSITIVE
    while bits <= MOST_BITS:
        with precision(bits):
            try:
                marks = _marks(source, angle, edge, ends, positive)
            except UnclearError:
                bits *= 2
                continue
            gap = axis == "phi_dot" and (low is None or high is None or low <= 0 <= high)
            return Search(tuple(marks), source, angle, (0.0,) if gap else ())
    raise UnclearError


def _source(
    problem: Problem, given: dict[str, Any], axis: str
) -> tuple[Conditions | Characteristic, str, bool]:
    exact, axes = problem.exact, given | {axis: X}
    if exact is None:
        if "lean" in given or axis == "lean":
            raise NotExact("π is in it")
        a, q, _ = problem.reduce(axes, _rational)
        factor, below = characteristic_ratios(problem.family, a, q)
        return Characteristic([factor], below), "", False
    angle, edge, over, sine = "", False, EXACT, None
    if isinstance(exact, TabulatedPolynomial):
        angle, edge = exact.angle(axis), exact.borders
        over, sine = _tabulated(exact, axes, angle)
    found = exact.conditions(axes, over)
    if found is not None:
        cleared = [(kind, _cleared(p)) for kind, p in found]
        if all(not p.is_zero() for _, p in cleared):
            dissipative = not problem.family.conservative
            return Conditions(cleared, sine, dissipative=dissipative), angle, edge and bool(angle)
    # a condition vanishes all along the axis, so that the polynomial itself is searched
    factors, below = zip(*map(_whole, exact.coefficients(axes, over)), strict=True)
    # a table's denominators are powers of positive axes
    poles = None if isinstance(exact, TabulatedPolynomial) else reduce(mul, below)
    return Characteristic(factors, poles), angle, False


def _tabulated(
    exact: TabulatedPolynomial, axes: Mapping[str, Any], angle: str
) -> tuple[Algebra, Callable[[], Any] | None]:
    """Sines along an axis: the variable itself for an angle; otherwise exact, or s in balls."""
    if angle:
        return _sines(X), None
    try:
        exact.point(axes, EXACT)
    except NotExact:
        return _sines(S), lambda: exact.sine(axes, MIXED)
    return EXACT, None


def _sines(value: Ratio) -> Algebra:
    return Algebra("sines", EXACT.constant, {"sin": lambda _: value, "cos": lambda _: value})


def _whole(factor: Sequence[Any]) -> tuple[list[Any], Any]:
    """Coefficients of a factor as polynomials without common factor, and their denominator."""
    ratios = [Ratio.of(c) for c in factor]
    common = common_multiple((r.bottom for r in ratios), RING.constant(1))
    whole = [univariate(r.top * (common / r.bottom)) for r in ratios]
    return primitive(whole), univariate(common)


def _rational(value: Any) -> Any:
    if isinstance(value, Ratio):
        raise NotExact("a square root of the axis is in it")
    return rational_root(value)


def _cleared(value: Any) -> Any:
    """A polynomial of the same sign; a denominator is a power of a positive axis."""
    r = Ratio.of(value)
    return r.top * r.bottom


def _marks(
    source: Conditions | Characteristic,
    angle: str,
    edge: bool,
    ends: tuple[Any, ...],
    positive: bool,
) -> list[Mark]:
    polynomials = [p for _, p in source.critical if not p.is_constant()]
    if source.poles is not None:
        polynomials.append(multivariate(source.poles))
    roots = real_roots(polynomials, source.sine)
    if angle or positive:
        roots = _clip(roots, polynomials, 1 if angle else None)
    samples = _samples(roots, angle, positive)

    @cache  # beyond the interval no verdict is asked for
    def sign(place: int) -> int:
        found = source.sign(samples[place])
        if not found:
            raise UnclearError
        return found

    simple = _simple(source)
    out: list[Mark] = []
    for i, root in enumerate(roots):
        for value, turned in _values(root, angle):
            place = _inside(value, ends, polynomials if not angle else None)
            if place is not None:
                below, above = (i + 1, i) if turned else (i, i + 1)
                kind = _kind(simple, samples[i], samples[i + 1], source.sine)
                out.append(Mark(place, kind, sign(below), sign(above), root))
    if edge and angle:
        upright = arb(0) if angle == "lean" else arb.pi() / 2
        place = _inside(upright, ends, None)
        if place is not None:
            last = sign(len(samples) - 1)
            out.append(Mark(place, "edge", last, last, arb(1)))
    out.sort(key=lambda m: m.value.mid())
    return out


def _clip(roots: list[Any], polynomials: Sequence[Any], top: int | None) -> list[Any]:
    """Roots inside the open interval (0, top), without those exactly at its ends."""
    out = []
    for root in roots:
        for end in (0, top):
            if end is not None and root.contains(end):
                if not any(specialised(p, fmpq(end)).is_zero() for p in polynomials):
                    raise UnclearError
                break
        else:
            if root > 0 and (top is None or root < top):
                out.append(root)
    return out


def _samples(roots: list[Any], angle: str, positive: bool) -> list[Any]:
    """A rational between any two roots, and one beyond the first and the last."""
    if angle:
        fence = [arb(0), *roots, arb(1)]
    elif roots:
        lowest = arb(0) if positive else roots[0] - 2 - abs(roots[0])
        fence = [lowest, *roots, roots[-1] + 2 + abs(roots[-1])]
    else:
        return [fmpq(1)]
    out = []
    for low, high in zip(fence[:-1], fence[1:], strict=True):
        middle = ((low.upper() + high.lower()) / 2).mid()
        if not low < middle < high:
            raise UnclearError
        out.append(_shortest(low, middle, high).fmpq())
    return out


def _shortest(low: Any, middle: Any, high: Any) -> Any:
    """The middle of a gap with as few digits as stay within, for the exact steps that follow."""
    for bits in SHORT:
        with precision(bits):
            near = (+middle).mid()
        if low < near < high:
            return near
    return middle


def _simple(source: Conditions | Characteristic) -> list[tuple[str, Any]]:
    """Kinds of zero, in the order in which they are named, with polynomials of simple roots."""
    known = [] if source.poles is None else [("pole", multivariate(source.poles))]
    for kind in KINDS:  # a zero eigenvalue goes before a pair
        known += [(kind, p) for name, p in source.critical if name == kind and not p.is_constant()]
    return [(kind, p / p.gcd(p.derivative("x"))) for kind, p in known]


def _kind(simple: Sequence[tuple[str, Any]], low: Any, high: Any, sine: Any) -> str:
    """Kind of the condition that vanishes between two neighbouring samples."""
    for kind, p in simple:
        if sign_at(p, low, sine) != sign_at(p, high, sine):
            return "flutter" if kind == "auxiliary" else kind
    return "pole"


def _values(root: Any, angle: str) -> list[tuple[Any, bool]]:
    """Values of the axis at a root, and whether the axis runs against the variable there."""
    if angle == "theta":
        value = root.asin()
        return [(value, False), (arb.pi() - value, True)]
    if angle == "lean":
        value = root.acos()
        return [(-value, False), (value, True)]
    return [(root, False)]


def _inside(value: Any, ends: tuple[Any, ...], polynomials: Sequence[Any] | None) -> Any | None:
    """The value if it lies in the closed interval, exact where it is an end; None if outside."""
    low, high = ends
    for end in ends:
        if end is None:
            continue
        exact = arb(end)
        if value.contains(end) and value != exact:
            if polynomials is None or not any(specialised(p, end).is_zero() for p in polynomials):
                raise UnclearError
            return exact
    if (low is not None and value < arb(low)) or (high is not None and value > arb(high)):
        return None
    return value


GUARD = 64
"""Bits beyond those of a root at which conditions are evaluated there."""


def single(found: Search, mark: Mark, proved: Callable[[float], Verdict]) -> Verdict:
    """The verdict at a mark on whose two sides it is the same.

    Parameters
    ----------
    found
        Result of `search`.
    mark
        One of its marks, not a pole.
    proved
        The proved verdict at a double.

    Returns
    -------
    Verdict
        The verdict of both sides where it is proved to hold there too; neutral where neutral is
        proved; otherwise undecided.
    """
    if mark.below > 0:
        # the limit of stable motions with an eigenvalue on the axis
        return Verdict.NEUTRAL
    # as precisely as the search had to be to separate this root from the next
    with precision(max(BITS, min(mark.root.rel_accuracy_bits(), MOST_BITS)) + GUARD):
        if _unstable(found.source, mark.root):
            return Verdict.UNSTABLE
    if isinstance(found.source, Conditions):
        # no condition is proved negative; omitted ones follow only where the others are positive
        neutral = proved(float(mark.value.mid())) is Verdict.NEUTRAL
        return Verdict.NEUTRAL if neutral else Verdict.UNDECIDED
    exact = _short_rational(found.source, mark.root)
    return Verdict.UNDECIDED if exact is None else found.source.verdict(exact)


def _unstable(source: Conditions | Characteristic, x: Any) -> bool:
    """Whether some eigenvalue with a positive real part is proved in a ball of the variable."""
    if isinstance(source, Conditions):
        sine = source.sine() if source.sine is not None else arb(0)
        return any(_at(p, x, sine) < 0 for _, p in source.critical)
    return any(grows([arb_poly(c)(x) for c in factor]) for factor in source.factors)


def _at(p: Any, x: Any, sine: Any) -> Any:
    return sum((arb(c) * x ** int(i) * sine ** int(j) for (i, j), c in p.terms()), arb(0))


def grows(coefficients: Sequence[Any]) -> bool:
    """Whether a polynomial of balls, lowest first, is proved to have a zero with Re > 0.

    Examples
    --------
    >>> grows([arb(-1), arb(0), arb(1)]), grows([arb(1), arb(1)])
    (True, False)
    """
    polynomial = acb_poly([acb(c) for c in coefficients])
    middle = np.array([float(c.mid()) for c in map(arb, coefficients)])
    if not np.isfinite(middle).all() or not middle[-1]:
        return False
    degree = len(coefficients) - 1
    for guess in np.roots(middle[::-1]):
        if guess.real > 0:
            taylor = list(polynomial(acb_poly([acb(complex(guess)), acb(1)])))
            for j in range(1, degree + 1):
                if taylor[j].contains(0):
                    continue
                ratio = comb(degree, j) * abs(taylor[0]) / abs(taylor[j])
                if ratio.upper().root(j) < float(guess.real):
                    return True
    return False


def _short_rational(source: Characteristic, x: Any) -> Any | None:
    """The root as a rational, where it is a short one."""
    with precision(BITS):
        middle = x.mid().fmpq()
    near = Fraction(int(middle.p), int(middle.q)).limit_denominator(10**18)
    exact = fmpq(near.numerator, near.denominator)
    if x.contains(exact) and any(specialised(p, exact).is_zero() for _, p in source.critical):
        return exact
    return None
