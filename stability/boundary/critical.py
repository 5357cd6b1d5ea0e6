"""Polynomials that vanish where a verdict can change along an axis, and the verdicts between.

For the disk these are the conditions over Q of `stability.bodies.disk_polynomials`, where
every quantity but the axis is the exact ratio of its double.  For a user's family whose graph is
rational in the axis they come from its characteristic polynomial.  Between neighbouring roots no
eigenvalue meets the imaginary axis, so one exact verdict holds on each piece.

Source: Orlando's formula (F. R. Gantmacher, The Theory of Matrices, vol. 2, ch. XV § 7) for the
resultant of even and odd part; tests/boundary/test_boundaries.py counts the roots by another route.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from functools import reduce
from typing import Any

from flint import arb, fmpq, fmpq_poly, fmpz

from ..algebra.exact.number_fields import EXACT, NotExact, characteristic, rational
from ..algebra.exact.rational_functions import (
    RING,
    Ratio,
    common_multiple,
    multivariate,
    primitive,
    univariate,
)
from ..algebra.exact.roots import complex_roots, sign_at, specialised
from ..algebra.exact.routh import on_the_axis
from ..algebra.number_types import precision
from ..base.verdict import Verdict
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
        if even:
            return _meeting(fmpq_poly(exact[::2]))
        roots = [r for r, _ in fmpq_poly(exact).numer().complex_roots() if r.imag != 0]
        off = [(abs(float((r.real / r.imag).mid())), abs(float(r.imag.mid()))) for r in roots]
    return min(off)[1] if off else 0.0


def _meeting(squares: Any) -> float:
    """√-y where two roots y of a polynomial are nearest to each other."""
    roots = [r for r, count in squares.numer().complex_roots() for _ in range(count)]
    best = (math.inf, 0.0)
    for i, y in enumerate(roots):
        for z in roots[:i]:
            middle = float(((y + z) / 2).real.mid())
            if middle < 0:
                best = min(best, (float(abs(y - z).mid()) / -middle, math.sqrt(-middle)))
    return best[1]


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
        return _together([sign_at(p, x, self.sine) for _, p in self.critical])

    def sign_of_angle(self, sine: Callable[[], Any]) -> int:
        """The same as `sign` where the variable is the sine of the axis.

        Parameters
        ----------
        sine
            Function that gives the sine at the working precision; a transcendental number.
        """
        turned = [RING.from_dict({(j, i): c for (i, j), c in p.terms()}) for _, p in self.critical]
        return _together([sign_at(p, fmpq(0), sine) for p in turned])


def _together(signs: Sequence[int]) -> int:
    return -1 if -1 in signs else 0 if 0 in signs else 1


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
        """The verdict at a rational value.

        Parameters
        ----------
        x
            The value.
        """
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
        best = (float("inf"), 0.0)
        for even, rest in self.parts:
            for root, _ in complex_roots(specialised(rest, x)):
                if not root.imag == 0:
                    off = abs(float(root.real / root.imag))
                    best = min(best, (off, abs(float(root.imag))))
            squares = [
                root for root, count in complex_roots(specialised(even, x)) for _ in range(count)
            ]
            for i, y in enumerate(squares):
                for z in squares[:i]:
                    middle = float((y.real + z.real) / 2)
                    off = float(abs(y - z).mid()) / max(abs(middle), 1e-300)
                    if middle < 0:
                        best = min(best, (off, (-middle) ** 0.5))
        return best[1]


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
    degree = rest.degrees()[1]
    if degree >= 1:
        by_power = _by_power(rest)
        out += [("static", by_power[0]), ("pole", by_power[degree])]
    if degree >= 2:
        parts = [RING.constant(0), RING.constant(0)]
        for power, c in by_power.items():
            parts[power % 2] = parts[power % 2] + c * RING.gens()[1] ** (power // 2)
        out.append(("flutter", parts[0].resultant(parts[1], "s")))
    degree = even.degrees()[1]
    if degree >= 1:
        by_power = _by_power(even)
        out += [("static", by_power[0]), ("pole", by_power[degree])]
    if degree >= 2:
        plain = even / even.gcd(even.derivative("s"))
        if plain.degrees()[1] >= 2:
            out.append(("flutter", plain.discriminant("s")))
    return [(kind, p) for kind, p in out if not p.is_constant()]


def _by_power(p: Any) -> dict[int, Any]:
    """Coefficients by powers of the second variable, elements of the ring in x alone."""
    out: dict[int, dict[tuple[int, int], Any]] = {}
    for (i, j), c in p.terms():
        out.setdefault(int(j), {})[(int(i), 0)] = c
    return {j: RING.from_dict(terms) for j, terms in out.items()} | (
        {} if 0 in out else {0: RING.constant(0)}
    )
