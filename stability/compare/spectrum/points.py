"""Points of the disk's families at which routes to a spectrum are compared, and the truth there.

The truth is the characteristic polynomial of the graph itself in balls of many bits.  The package's
routes take another way: they use doubles, or the polynomials over Q that are package data.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property, lru_cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...algebra.exact.routh import hurwitz_sign, verdict_polynomial
from ...algebra.number_types import precision
from ...algebra.upright import Upright
from ...base.types import Floats
from ...base.verdict import CODES, Verdict, best
from ...bodies.contact_laws import Contact, law_named
from ...bodies.disk import Disk
from ...bodies.families import FAMILIES
from ...bodies.subject import disk_family
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
    """Description of the points, for a reader."""
    free_states: Floats | None = None
    """States in place of the family's, perhaps not steady, shape (N, n); None for the family's."""

    def __len__(self) -> int:
        return len(self.at)

    def __getitem__(self, index: Any) -> Points:
        """Some of the points, by a slice, a mask or an array of numbers."""
        arrays = {n: getattr(self, n) for n in ("k", "mu", "at", "lean", "free_states")}
        return replace(self, **{n: v[index] for n, v in arrays.items() if v is not None})

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
        if self.free_states is not None:
            return self.free_states
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

    Source: the graph's own characteristic polynomial in balls; tests/compare/test_compare.py
    compares it with mpmath.

    Examples
    --------
    >>> one = np.array([0.25])
    >>> found = truth(Points("rolling", "viscous", one, 4 * one, 8 * one))
    >>> found.eigenvalues.shape, int(found.codes[0]) == CODES[Verdict.STABLE]
    ((1, 4), True)
    """
    rows = [_point_truth(*_exact(points, i), points) for i in range(len(points))]
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


def _point_truth(a: list[Any], q: list[Any], points: Points) -> tuple[Any, ...]:
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

    Examples
    --------
    >>> edge("rolling", "smooth", 0.25, None, 0.5, 1.5)
    1.0
    """
    from ...boundary.changes import boundaries

    changes = boundaries(
        family, axis=("at", low, high, 60), disk=Disk(k=k), contact=law_named(law, mu)
    )
    if len(changes) != 1:
        raise ArithmeticError(f"{family}, {law}, k = {k}, mu = {mu}: {len(changes)} boundaries")
    return changes[0].value


# --- hardness classes ---


SEED, COUNT = 20161, 16
EDGES: tuple[tuple[str, str, float, float | None, float, float], ...] = (
    ("rolling", "viscous", 0.25, 0.3, 1.0, 2.0),
    ("rolling", "viscous", 0.5, 300.0, 0.5, 2.0),
    ("spinning", "viscous", 0.25, 0.3, 1.0, 3.0),
    ("spinning", "viscous", 0.3125, 0.9, 2.0, 9.0),
    ("tumbling", "viscous", 0.25, 3.0, 0.3, 1.5),
    ("tumbling", "viscous", 0.5, 0.1, 0.01, 0.1),
    ("tumbling", "viscous", 0.5, 0.003, 1e-6, 1e-3),
    ("tumbling", "viscous", 0.375, 0.9, 0.7, 1.0),
    ("tumbling", "viscous", 0.3125, 10.0, 0.001, 0.1),
    ("rolling", "linear-viscous", 0.3125, 2.0, 0.5, 3.0),
    ("rolling", "rough", 0.25, None, 0.3, 1.0),
    ("rolling", "smooth", 0.3, None, 0.3, 2.0),
    ("spinning", "rough", 0.25, None, 0.3, 2.0),
    ("spinning", "smooth", 0.375, None, 0.5, 3.0),
)
"""Boundaries of the verdict along `at`: family, law, k, mu, and values on either side."""
DEGREES = (0.1, 0.3, 1.0, 2.0, 5.0)
"""Inclinations of a hoop that is nearly flat [degrees]."""


def close_to(
    where: tuple[str, str, float, float | None, float, float], distances: Sequence[float]
) -> Points:
    """Points on both sides of a boundary, at relative distances.

    Returns
    -------
    Points
        For each distance, the point below the boundary, then the point above.
    """
    family, law, k, mu, low, high = where
    value = edge(family, law, k, mu, low, high)
    at = np.array([value * (1 + side * d) for d in distances for side in (-1, 1)])
    return _points(family, law, k, mu, at)


def _points(family: str, law: str, k: Any, mu: Any, at: Any) -> Points:
    at = np.asarray(at, dtype=float)

    def full(value: Any) -> Floats:
        return np.broadcast_to(np.asarray(value, dtype=float), at.shape).copy()

    return Points(family, law, full(k), None if mu is None else full(mu), at)


def _random(least: float, most: float) -> list[Points]:
    """Members of the viscous families, mu* log-uniform between two numbers."""
    rng = np.random.default_rng(SEED)
    ranges = {name: family.sampled for name, family in FAMILIES.items() if family.sampled}
    return [
        _points(
            family,
            "viscous",
            rng.uniform(0.05, 0.5, COUNT),
            10 ** rng.uniform(math.log10(least), math.log10(most), COUNT),
            rng.uniform(low, high, COUNT),
        )
        for family, (low, high) in ranges.items()
    ]


def _flat_hoop() -> list[Points]:
    theta, mu = np.meshgrid(np.radians(DEGREES), [0.01, 0.1, 1.0, 10.0])
    return [_points("tumbling", "viscous", 0.5, mu.ravel(), theta.ravel())]


def coalescence(family: str, k: float, mu: float, low: float, high: float) -> float:
    """The double next to the value of `at` at which two eigenvalues of a viscous family meet.

    Examples
    --------
    >>> 0.5 < coalescence("spinning", 0.25, 4.0, 0.5, 1.0) < 1.0
    True
    """

    def real(at: float) -> int:
        values = _points(family, "viscous", k, mu, [at]).truth.eigenvalues
        return int((values.imag == 0).sum())

    ends = real(low), real(high)
    while (middle := (low + high) / 2) not in (low, high):
        if real(middle) == ends[0]:
            low = middle
        else:
            high = middle
    return low


MEETINGS = (
    ("rolling", 0.25, 1.0, 0.2, 1.0),
    ("rolling", 0.5, 3.0, 0.05, 0.6),
    ("spinning", 0.25, 4.0, 0.5, 1.0),
    ("tumbling", 0.25, 4.0, 0.3, 0.6),
)
"""Where eigenvalues coalesce along `at`: family, k, mu and values on either side."""


def _meeting() -> list[Points]:
    groups = []
    for family, k, mu, low, high in MEETINGS:
        at = coalescence(family, k, mu, low, high)
        near = [at, math.nextafter(at, math.inf), *(at * (1 + s) for s in (1e-14, 1e-12, 1e-10))]
        groups.append(_points(family, "viscous", k, mu, near))
    return groups


def _conservative() -> list[Points]:
    return [
        close_to(e, (1e-2, 1e-5, 1e-8, 1e-11, 1e-15)) for e in EDGES if e[1] in ("rough", "smooth")
    ]


def _viscous() -> list[Any]:
    return [e for e in EDGES if e[3] is not None]


@lru_cache(maxsize=1)
def _makers() -> Mapping[str, tuple[str, Callable[[], list[Points]]]]:
    return {
        "open": ("anywhere: random k, μ* in 0.1…10", lambda: _random(0.1, 10.0)),
        "near": (
            "near a boundary: relative distance 10⁻³…10⁻⁷",
            lambda: [close_to(e, (1e-3, 1e-5, 1e-7)) for e in _viscous()],
        ),
        "very-near": (
            "very near a boundary: relative distance 10⁻⁹…10⁻¹⁵",
            lambda: [close_to(e, (1e-9, 1e-12, 1e-15)) for e in _viscous()],
        ),
        "large-mu": ("large friction: μ* in 10³…10⁸", lambda: _random(1e3, 1e8)),
        "small-mu": (
            "small friction: μ* in 10⁻¹⁰…10⁻³",
            lambda: _random(1e-10, 1e-3),
        ),
        "flat-hoop": ("tumbling hoop at 0.1°…5° from flat", _flat_hoop),
        "meeting": ("two eigenvalues coalesce (defective), to 1 ulp…10⁻¹⁰", _meeting),
        "conservative": ("smooth and rough: 10⁻²…10⁻¹⁵ next to a Jordan block", _conservative),
    }


def classes() -> dict[str, str]:
    """Title of each hardness class, in order of display.

    Examples
    --------
    >>> list(classes())[:2]
    ['open', 'near']
    """
    return {name: title for name, (title, _) in _makers().items()}


@lru_cache(maxsize=8)
def points_of(name: str) -> tuple[Points, ...]:
    """The points of a hardness class, in groups of one family and law."""
    return tuple(_makers()[name][1]())
