"""Points of the disk's families at which routes to a spectrum are compared, and the truth there.

The truth is the characteristic polynomial of the graph itself in balls of many bits.  The package's
routes take another way: they use doubles, or the polynomials over Q that are package data.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field
from functools import cached_property, lru_cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...algebra.exact.routh import hurwitz_sign, verdict_polynomial
from ...algebra.number_types import precision
from ...algebra.upright import Upright
from ...base.types import Floats
from ...base.verdict import CODES, Verdict, best
from ...bodies.contact import Contact
from ...bodies.disk import Disk
from ...bodies.families import FAMILIES
from ...bodies.law_names import law_named
from ...bodies.thin_disk import disk_family
from ...spectra.problem import Problem, disk_problem
from ...systems.family import Family
from ...systems.structure.enclosure import characteristic
from ...systems.structure.structural_zeros import structure

BITS = 1024
"""First working precision of the truth [bits]."""
SHARP = 90
"""Required accuracy of the abscissa [bits]."""
MOST_BITS = 16384
"""Highest working precision [bits]."""


@dataclass(frozen=True, eq=False)
class Points:
    """N members of one family under one law; m = R = g = 1."""

    family: str
    """Name of the family."""
    law: str
    """A key of `stability.bodies.contact_laws.LAWS`."""
    k: Floats
    """Inertia factor, shape (N,)."""
    mu: Floats | None
    """Friction coefficient, shape (N,); None for the laws without."""
    at: Floats
    """Parameter that names the member, shape (N,)."""
    lean: Floats | None = None
    """For tumbling, in place of `at`: π/2 - theta exactly, shape (N,)."""
    label: str = ""
    """Description of the points."""
    given: Floats | None = None
    """States in place of the family's, perhaps not steady, shape (N, n); None for the family's."""

    def __len__(self) -> int:
        return len(self.at)

    def __getitem__(self, index: Any) -> Points:
        """Some of the points, by a slice, a mask or an array of numbers."""
        mu, lean, given = (
            None if v is None else v[index] for v in (self.mu, self.lean, self.given)
        )
        return Points(
            self.family, self.law, self.k[index], mu, self.at[index], lean, self.label, given
        )

    @property
    def member(self) -> Family:
        """The family."""
        return disk_family(self.family, self.law)

    @property
    def zeros(self) -> int:
        """Number of structural zeros of the spectrum."""
        return structure(self.member).zeros

    @property
    def even(self) -> bool:
        """Whether the law is conservative."""
        return self.member.conservative

    @cached_property
    def states(self) -> Floats:
        """The states as people write them, with the double nearest π/2; shape (N, n)."""
        if self.given is not None:
            return self.given
        names = self.member.system.states
        x = np.zeros((len(self), len(names)))
        member = FAMILIES[self.family].member(np, self.at, self.k)
        for column, name in enumerate(names):
            value = member[name]
            x[:, column] = np.pi / 2 if isinstance(value, Upright) else value
        return x

    @cached_property
    def parameters(self) -> Floats:
        """k, and mu where the law has one; shape (N, m)."""
        return np.column_stack([self.k] if self.mu is None else [self.k, self.mu])

    def contact(self) -> Contact:
        """The law with all its coefficients."""
        return law_named(self.law, self.mu)  # type: ignore[arg-type]  # arrays broadcast

    def problem(self) -> Problem:
        """The problem of all points at once."""
        at = None if self.lean is not None else self.at
        return disk_problem(self.family, Disk(k=self.k), self.contact(), at, self.lean)

    def singles(self) -> Iterator[Points]:
        """The points one by one."""
        for i in range(len(self)):
            yield self[i : i + 1]

    @cached_property
    def truth(self) -> Truth:
        """Eigenvalues and verdicts, proved."""
        return truth(self)


@dataclass(frozen=True, eq=False)
class Truth:
    """Proved values at points."""

    eigenvalues: NDArray[np.complex128]
    """Rounded to double, shape (N, n), structural zeros removed."""
    rest: NDArray[np.complex128]
    """The exact eigenvalues less the rounded ones, as doubles; shape (N, n)."""
    abscissa: Floats
    """Largest real part, rounded; shape (N,)."""
    abscissa_rest: Floats
    """The exact abscissa less the rounded one, shape (N,)."""
    codes: NDArray[np.int8] = field(repr=False)
    """Verdict flags, shape (N,)."""


def truth(points: Points) -> Truth:
    """Proved eigenvalues and verdicts at points.

    Parameters
    ----------
    points
        The points.

    Returns
    -------
    Truth

    Source: the graph's own characteristic polynomial in balls; tests/compare/test_compare.py
    compares it with mpmath.

    Examples
    --------
    >>> one = np.array([0.25])
    >>> found = truth(Points("rolling", "viscous", one, 4 * one, 8 * one))
    >>> found.eigenvalues.shape, int(found.codes[0]) == CODES[Verdict.STABLE]
    ((1, 4), True)
    """
    rows = [_one(*_exact(points, i), points) for i in range(len(points))]
    return Truth(*(np.array(column) for column in zip(*rows, strict=True)))


def _exact(points: Points, i: int) -> tuple[list[Any], list[Any]]:
    """Family parameter and parameters of a point as rationals."""
    from flint import fmpq

    def exact(value: float) -> Any:
        return fmpq(*float(value).as_integer_ratio())

    q = [exact(points.k[i])] + ([] if points.mu is None else [exact(points.mu[i])])
    if points.lean is not None:
        return [("lean", exact(points.lean[i]))], q
    return [exact(points.at[i])], q


def _one(a: list[Any], q: list[Any], points: Points) -> tuple[Any, ...]:
    family, zeros, even = points.member, points.zeros, points.even
    bits = BITS
    while bits <= MOST_BITS:
        with precision(bits):
            coefficients = characteristic(family, _balls(a), _balls(q))
            sign = hurwitz_sign(verdict_polynomial(coefficients, zeros, even))
            roots = _roots(coefficients[zeros:], even)
            if roots is not None and (sign or bits > 2 * BITS) and _sharp(roots, sign, even):
                verdict = {1: best(even=even), -1: Verdict.UNSTABLE}.get(sign, Verdict.NEUTRAL)
                return (*_split(roots), CODES[verdict])
        bits *= 2
    raise ArithmeticError(f"the truth of {points.family} at {a}, {q} needs more than {bits} bits")


def _sharp(roots: list[Any], sign: int, even: bool) -> bool:
    """Whether the abscissa is accurate enough, or may be zero (conservative law, boundary)."""
    if even or sign == 0:
        return True
    top = max((root.real for root in roots), key=lambda part: part.mid())
    return bool(top.rel_accuracy_bits() > SHARP)


def _balls(values: list[Any]) -> list[Any]:
    from flint import arb

    return [arb.pi() / 2 - arb(v[1]) if isinstance(v, tuple) else arb(v) for v in values]


def _roots(coefficients: list[Any], even: bool) -> list[Any] | None:
    """Roots as balls, to a quarter of the working bits; None if they cannot be isolated.

    A constant term whose ball holds zero counts as zero, and gives a further zero root: a point on
    a boundary.
    """
    from flint import acb, acb_poly, arb, ctx

    kept = list(coefficients[::2] if even else coefficients)
    extra = 0
    while arb(kept[0]).contains(0):
        kept, extra = kept[1:], extra + 1
    try:
        roots = acb_poly(kept).roots(tol=arb(2) ** (-ctx.prec // 4)) if len(kept) > 1 else []
    except ValueError:
        return None
    roots = [*roots, *[acb(0)] * extra]
    if even:
        roots = [w for square in roots for w in (square.sqrt(), -square.sqrt())]
    return roots


def _split(roots: list[Any]) -> tuple[Any, Any, float, float]:
    """Each root as a double and its rest, sorted; the largest real part in the same form."""
    from flint import acb, arb

    def part(ball: Any) -> tuple[float, float]:
        if ball.contains(0):
            return 0.0, 0.0
        high = float(ball.mid())
        return high, float((ball - arb(high)).mid())

    pairs = []
    for root in roots:
        ball = acb(root)
        (re, re_rest), (im, im_rest) = part(ball.real), part(ball.imag)
        pairs.append((complex(re, im), complex(re_rest, im_rest)))
    pairs.sort(key=lambda pair: (pair[0].real, pair[0].imag))
    top = max(pairs, key=lambda pair: (pair[0].real, pair[1].real))
    return [p[0] for p in pairs], [p[1] for p in pairs], top[0].real, top[1].real


@lru_cache(maxsize=64)
def edge(family: str, law: str, k: float, mu: float | None, low: float, high: float) -> float:
    """The double next to the one boundary along `at` between two values.

    Parameters
    ----------
    family, law, k, mu
        Family, law, inertia factor and friction coefficient, or None.
    low, high
        Ends, between which the verdict changes once.

    Returns
    -------
    float

    Examples
    --------
    >>> edge("rolling", "smooth", 0.25, None, 0.5, 1.5)
    1.0
    """
    from ...boundary.changes import boundaries

    found = boundaries(
        family, axis=("at", low, high, 60), disk=Disk(k=k), contact=law_named(law, mu)
    )
    if len(found) != 1:
        raise ArithmeticError(f"{family}, {law}, k = {k}, mu = {mu}: {len(found)} boundaries")
    return found[0].value
