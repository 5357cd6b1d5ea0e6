"""Proved verdicts and eigenvalue enclosures: rational arithmetic where it can be, balls elsewhere.

For the disk everything starts from the exact ratios of the given doubles, mu²gR and at²R/g, and
from the polynomials over Q of `stability.exact`.  With θ given as a double its sine is
transcendental (Lindemann), so no condition vanishes there and raising the precision ends; a lean of
exactly zero is the right angle.  A user's family goes through the same steps in balls.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from flint import acb, acb_poly, arb, ctx, fmpq, fmpq_poly

from .errors import DomainError
from .exact import Exact
from .families import Family
from .polynomial import characteristic, hurwitz_sign, precision, structure, verdict_polynomial
from .problem import Problem
from .verdict import Verdict, best

BITS = 128
"""Working precision of the first attempt."""
MOST_BITS = 8192
"""Where raising the precision ends: the verdict is then undecided."""
WANTED = 58
"""Bits of relative accuracy of each real and imaginary part, before rounding to double."""

Balls = list[Any]


@dataclass(frozen=True)
class Certificate:
    """A proved verdict and enclosures at one point."""

    verdict: Verdict
    """The verdict; undecided only where the budget of precision ended."""
    eigenvalues: tuple[complex, ...]
    """Sorted by real, then imaginary part, in the user's unit of rate; empty if undecided."""
    radius: tuple[float, ...]
    """Of the disc about each that holds the exact eigenvalue; 0 where it is exact."""
    abscissa_error: float
    """Proved bound on the error of the largest real part."""
    bits: int
    """Precision of the balls that decided; 0 for rational arithmetic."""

    @property
    def how(self) -> str:
        """How the verdict was proved, in words."""
        return f"balls of {self.bits} bits" if self.bits else "rational arithmetic"


def rational(value: float) -> Any:
    """The double as an exact rational.

    Parameters
    ----------
    value
        A finite double.

    Examples
    --------
    >>> rational(0.375)
    3/8
    """
    return fmpq(*float(value).as_integer_ratio())


def certify(question: Problem, values: Mapping[str, float]) -> Certificate:
    """A proved verdict with eigenvalue enclosures at one point.

    Parameters
    ----------
    question
        The question.
    values
        Double by name, taken as exact.

    Returns
    -------
    Certificate

    Raises
    ------
    DomainError
        If a user's family has eigenvalues that no precision within the budget separates.

    Examples
    --------
    >>> from stability.contact import Viscous
    >>> from stability.disk import Disk
    >>> from stability.problem import disk_problem
    >>> question = disk_problem("rolling", Disk(k=0.5), Viscous(0.3), 1.0)
    >>> found = certify(question, question.values)  # the boundary is omega3² = 1/(2k) = 1
    >>> found.verdict.word, found.how
    ('neutral', 'rational arithmetic')
    """
    decided, bits = _decided(question, values)
    if decided is Verdict.UNDECIDED:
        return Certificate(decided, (), (), np.inf, bits)
    precise = BITS
    while precise <= MOST_BITS:
        with precision(precise):
            roots = _roots(question, values)
            if roots is not None and all(map(_sharp, roots)):
                return _rounded(decided, roots, bits)
        precise *= 2
    raise DomainError(
        f"the eigenvalues of {question.family.name} cannot be separated within {MOST_BITS} bits; "
        "two of them coincide, or nearly: ask for the verdict alone, or at a neighbouring point."
    )


def verdict(question: Problem, values: Mapping[str, float]) -> Verdict:
    """The proved verdict alone.

    Parameters
    ----------
    question, values
        As in `certify`.

    Returns
    -------
    Verdict
    """
    return _decided(question, values)[0]


# --- verdicts ---


def _decided(question: Problem, values: Mapping[str, float]) -> tuple[Verdict, int]:
    """The verdict, and the bits of the balls that decided it (0 for rational arithmetic)."""
    exact = question.exact
    if exact is None:
        return _raised(lambda: in_balls(question.family, *question.balls(values)))
    given = {name: rational(value) for name, value in values.items()}
    point = question.point(given, sine=None)
    if point is None:
        return _raised(lambda: _by_conditions(exact, question.point(given, sine=ball_sine)))
    signs = [polynomial(*point) for _, polynomial in exact.conditions]
    edge = "s" in exact.variables  # s is 1 then, the edge of the domain of the conditions
    if any(v < 0 for v in signs):
        return Verdict.UNSTABLE, 0
    if not edge and all(v > 0 for v in signs):
        return best(even=exact.even), 0
    return _on_the_axis([fmpq_poly(c) for c in exact.coefficients(point)]), 0


def _raised(attempt: Callable[[], Verdict | None]) -> tuple[Verdict, int]:
    bits = BITS
    while bits <= MOST_BITS:
        with precision(bits):
            found = attempt()
        if found is not None:
            return found, bits
        bits *= 2
    return Verdict.UNDECIDED, MOST_BITS


def _by_conditions(exact: Exact, point: Any) -> Verdict | None:
    signs = [arb(polynomial(*point)) for _, polynomial in exact.conditions]
    if any(v < 0 for v in signs):
        return Verdict.UNSTABLE
    if all(v > 0 for v in signs):
        return best(even=exact.even)
    return None


def in_balls(family: Family, a: Balls, q: Balls) -> Verdict | None:
    """The verdict everywhere in balls of parameters, by Routh's array at the current precision.

    Parameters
    ----------
    family
        The family.
    a, q
        Family parameters and parameters.

    Returns
    -------
    Verdict or None
        None where the balls do not decide.

    Raises
    ------
    NoMemberError
        If no root is proved to exist there.
    """
    even = family.conservative
    coefficients = characteristic(family, a, q)
    sign = hurwitz_sign(verdict_polynomial(coefficients, structure(family).zeros, even))
    return {1: best(even=even), -1: Verdict.UNSTABLE}.get(sign)


def ball_sine(given: Mapping[str, Any]) -> Any:
    """sinθ as a ball from θ, or from the lean π/2 - θ.

    Parameters
    ----------
    given
        Exact number by name.
    """
    return arb(given["lean"]).cos() if "lean" in given else arb(given["theta"]).sin()


def _on_the_axis(factors: Sequence[Any]) -> Verdict:
    """The verdict of a product of polynomials over Q, whatever lies on the imaginary axis."""
    neutral = False
    for factor in factors:
        zeros, symmetric, rest = split(factor)
        neutral = neutral or zeros > 0 or symmetric.degree() > 0
        if not _hurwitz(rest):
            return Verdict.UNSTABLE
        for square, _ in _squares(symmetric):
            if not (square.imag == 0 and square.real < 0):
                return Verdict.UNSTABLE
    return Verdict.NEUTRAL if neutral else Verdict.STABLE


def split(p: Any) -> tuple[int, Any, Any]:
    """A polynomial over Q as λ^zeros · symmetric · rest.

    Parameters
    ----------
    p
        An `fmpq_poly`, not zero.

    Returns
    -------
    zeros, symmetric, rest
        `symmetric` is even and holds the roots whose mirror images in the imaginary axis are roots
        too; `rest` has none of these.

    Examples
    --------
    >>> split(fmpq_poly([0, 1, 1, 1, 1]))  # λ (λ² + 1) (λ + 1)
    (1, x^2 + 1, x + 1)
    """
    coefficients = p.coeffs()
    zeros = next(i for i, c in enumerate(coefficients) if c != 0)
    kept = fmpq_poly(coefficients[zeros:])
    mirror = fmpq_poly([-c if i % 2 else c for i, c in enumerate(kept.coeffs())])
    common = kept.gcd(mirror)
    return zeros, common, kept / common


def _squares(symmetric: Any) -> list[Any]:
    if symmetric.degree() < 1:
        return []
    found: list[Any] = fmpq_poly(symmetric.coeffs()[::2]).numer().complex_roots()
    return found


def _hurwitz(p: Any) -> bool:
    """Routh's array over Q, for a polynomial without mirrored roots."""
    rows = list(reversed(p.coeffs()))
    here, following = rows[::2], rows[1::2]
    while following:
        if following[0] / here[0] <= 0:
            return False
        ratio = here[0] / following[0]
        padded = [*following[1:], fmpq(0)][: len(here) - 1]
        here, following = (
            following,
            [x - ratio * y for x, y in zip(here[1:], padded, strict=True)],
        )
    return True


# --- enclosures ---


def _roots(question: Problem, values: Mapping[str, float]) -> Balls | None:
    """Every eigenvalue that is not zero by structure, as a complex ball; None if not isolated."""
    exact = question.exact
    if exact is None:
        family = question.family
        reduced = characteristic(family, *question.balls(values))[structure(family).zeros :]
        return _isolated(reduced, family.conservative)
    given = {name: rational(value) for name, value in values.items()}
    scale, square = question.scale(given)
    unit = arb(square).sqrt() if scale is None else arb(scale)
    point = question.point(given, sine=None)
    place: Any = point or question.point(given, sine=ball_sine)
    out: Balls = []
    for factor in exact.coefficients(place):
        found = _isolated(factor, exact.even) if point is None else _exact_roots(fmpq_poly(factor))
        if found is None:
            return None
        out += [root * unit for root in found]
    return out


def _exact_roots(p: Any) -> Balls:
    zeros, symmetric, rest = split(p)
    out = [acb(0)] * zeros
    for square, count in _squares(symmetric):
        out += _both(square) * count
    if rest.degree() > 0:
        out += [root for root, count in rest.numer().complex_roots() for _ in range(count)]
    return out


def _both(square: Any) -> Balls:
    """±√y, exactly real or imaginary where y is real."""
    if square.imag == 0 and square.real < 0:
        root = acb(0, (-square.real).sqrt())
    else:
        root = acb(square.real.sqrt()) if square.imag == 0 else square.sqrt()
    return [root, -root]


def _isolated(coefficients: Balls, even: bool) -> Balls | None:
    """Roots of a polynomial whose coefficients are balls; None where they are not separated."""
    balls = [arb(c) for c in (coefficients[::2] if even else coefficients)]
    if balls[-1].contains(0):
        return None
    try:
        found = acb_poly(balls).roots(tol=arb(2) ** (-3 * ctx.prec // 4))
    except ValueError:
        return None
    # an isolated root whose ball meets the real axis is real, since the coefficients are
    real = [acb(r.real) if r.imag.contains(0) else r for r in found]
    if even:
        return [root for square in real for root in _both(square)] if _clear(real) else None
    upper = [r for r in real if r.imag > 0]
    return [r for r in real if r.imag == 0] + [w for r in upper for w in (r, r.conjugate())]


def _clear(squares: Balls) -> bool:
    return not any(y.contains(0) for y in squares)


def _sharp(root: Any) -> bool:
    return all(part == 0 or part.rel_accuracy_bits() >= WANTED for part in (root.real, root.imag))


def _rounded(decided: Verdict, roots: Balls, bits: int) -> Certificate:
    """Doubles, and how far the exact eigenvalues are from them at most."""
    entries = []
    for root in roots:
        value = complex(float(root.real.mid()), float(root.imag.mid()))
        off = abs(root - acb(value.real, value.imag))
        entries.append((value.real + 0.0, value.imag + 0.0, upper(off), root))
    entries.sort(key=lambda entry: entry[:2])
    # in balls: several eigenvalues may share the double that their real parts round to
    beyond = [root.real - arb(max(entry[0] for entry in entries)) for root in roots]
    high = max(upper(b) if b > 0 or b.contains(0) else 0.0 for b in beyond)
    low = min(upper(-b) if b < 0 or b.contains(0) else 0.0 for b in beyond)
    return Certificate(
        decided, tuple(complex(e[0], e[1]) for e in entries), tuple(e[2] for e in entries),
        max(high, low), bits,
    )  # fmt: skip


def upper(ball: Any) -> float:
    """A double that is not below a ball; 0 for an exact zero.

    Parameters
    ----------
    ball
        A nonnegative real ball.
    """
    if ball == 0:
        return 0.0
    return float(np.nextafter(float(ball.abs_upper()), np.inf))
