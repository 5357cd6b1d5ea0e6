"""Roots of many real polynomials at once, in real arithmetic, with proved error bounds.

A polynomial is stored as ∏ (x² + p x + q), times x - r where its degree is odd.  Weierstrass'
correction, written for quadratics, improves all factors at once.  The correction converges
quadratically for real and for complex pairs.  The error bound is Gershgorin's theorem for the
companion of the factors; the bound holds for any factors.

Sources: K. Dvorčuk, Apl. Mat. 14 (1969) 207-223 (factors of Weierstrass' method); A. Neumaier, J.
Comput. Appl. Math. 156 (2003) 389-401 (Gershgorin discs of approximate roots);
tests/maps/test_maps.py.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import reduce
from itertools import combinations
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from .eigensolver import eigenvalues_alone

Array = NDArray[Any]

BLOCK = 8192
"""Rows in one block, so that its arrays stay in the cache."""
NOTHING = 1e-290
"""Size below which a factor counts as zero, and a change as none."""
FEW = 4
"""Largest number of corrections of rows that have not settled from their first factors."""
MORE = 8
"""The same of rows that start again."""


class Factors(NamedTuple):
    """Linear and quadratic factors of monic polynomials, one row each."""

    r: Array | None
    """Root of the linear factor, shape (N,); None where the degree is even."""
    pairs: list[tuple[Array, Array]]
    """(p, q) of each quadratic x² + p x + q, shapes (N,)."""

    @property
    def arrays(self) -> list[Array]:
        """The root, then p and q of each quadratic."""
        first = [] if self.r is None else [self.r]
        return first + [v for pair in self.pairs for v in pair]

    @classmethod
    def of(cls, arrays: Sequence[Array]) -> Factors:
        """The factors from their arrays, or from one of shape (n, N)."""
        odd = len(arrays) % 2
        pairs = zip(arrays[odd::2], arrays[odd + 1 :: 2], strict=True)
        return cls(arrays[0] if odd else None, list(pairs))

    def take(self, index: Any) -> Factors:
        """The factors of some rows."""
        return Factors.of([v[index] for v in self.arrays])

    def astype(self, kind: Any) -> Factors:
        """The factors in another floating-point type."""
        return Factors.of([v.astype(kind) for v in self.arrays])

    def put(self, index: Any, other: Factors) -> None:
        """Overwrite some rows."""
        for mine, theirs in zip(self.arrays, other.arrays, strict=True):
            mine[index] = theirs


class Roots(NamedTuple):
    """Roots of many polynomials, with discs that hold the exact roots."""

    real: list[Array]
    """Real parts, one array for each root."""
    imag: list[Array]
    """Imaginary parts."""
    radius: list[Array]
    """Radius of the disc of each root; infinite where nothing is proved."""


def start(a: Sequence[Array]) -> Factors:
    """Factors from the eigenvalues of the companion matrix.

    Parameters
    ----------
    a
        Monic coefficients a[0] … a[n-1], shapes (N,), finite.
    """
    n, count = len(a), len(a[0])
    companion = np.zeros((count, n, n))
    companion[:, np.arange(1, n), np.arange(n - 1)] = 1.0
    for i, c in enumerate(a):
        companion[:, i, n - 1] = -c
    # a row that overflowed has no factors: it passes on, and nothing is proved of it
    companion[~np.isfinite(companion).all(axis=(1, 2))] = 0.0
    roots = eigenvalues_alone(companion)
    # sorted by whether real, then size: real roots first, conjugates next to each other
    order = np.lexsort((roots.imag, roots.real, np.abs(roots.imag), roots.imag != 0), axis=-1)
    roots = np.take_along_axis(roots, order, -1)
    arrays = [roots[:, 0].real] if n % 2 else []
    for i in range(n % 2, n, 2):
        u, v = roots[:, i], roots[:, i + 1]
        arrays += [-(u + v).real, (u * v).real]
    return Factors.of(arrays).astype(a[0].dtype)


def improve(a: Sequence[Array], factors: Factors, *, watch: bool = True) -> tuple[Factors, Any]:
    """One correction of all factors at once.

    Parameters
    ----------
    a
        Monic coefficients, lowest first.
    factors
        Factors so far.
    watch
        Whether to compute the change.

    Returns
    -------
    factors, change
        New factors, and the square of the largest relative change of a row (0 if not watched).
    """
    r, arrays = factors.r, []
    change: Any = 0.0
    if r is not None:
        value = r + a[-1]
        for c in reversed(a[:-1]):
            value = value * r + c
        others: Array | float = 1.0
        for p, q in factors.pairs:
            others = others * ((r + p) * r + q)
        dr = -value / others
        arrays.append(r + dr)
        if watch:
            change = dr * dr / np.maximum(r * r, NOTHING)
    for i, (p, q) in enumerate(factors.pairs):
        # the polynomial modulo x² + p x + q is alpha x + beta
        high: Any = 1.0
        low = a[-1] - p
        for c in reversed(a[1:-1]):
            high, low = low, c - p * low - q * high
        alpha, beta = low, a[0] - q * high
        # the other factors modulo x² + p x + q are gamma x + delta
        gamma: Any = 0.0 if r is None else 1.0
        delta: Any = 1.0 if r is None else -r
        for j, (u, v) in enumerate(factors.pairs):
            if j != i:
                e, f = u - p, v - q  # (x² + u x + v) mod (x² + p x + q)
                gamma, delta = gamma * f + delta * e - gamma * e * p, delta * f - gamma * e * q
        m = delta - gamma * p
        det = delta * m + gamma * gamma * q
        dp = (alpha * delta - beta * gamma) / det
        dq = (m * beta + gamma * q * alpha) / det
        arrays += [p + dp, q + dq]
        if watch:  # p is of the size of the root of q at least where it matters
            size = np.maximum(np.abs(q) + p * p, NOTHING)
            change = np.maximum(change, dq * dq / np.maximum(q * q, NOTHING) + dp * dp / size)
    return Factors.of(arrays), change


def settle(a: Sequence[Array], factors: Factors, steps: int = 0) -> Factors:
    """Factors improved until they no longer change, or until the budget of corrections ends.

    Parameters
    ----------
    a
        Monic coefficients, lowest first.
    factors
        First factors; rows that do not settle from them start again from `start`.
    steps
        Corrections of every row before the first test for settled rows.

    Returns
    -------
    Factors
        Without any bound on their error; `enclose` gives bounds.
    """
    enough = 8 * np.finfo(a[0].dtype).eps
    change: Array = np.empty(0)
    if steps:
        factors, change = _blocks(a, factors, steps)
    # convergence is quadratic: the error left is the square of the last change
    left = np.arange(len(a[0])) if not steps else np.flatnonzero(~(change < enough))
    for fresh in (False, True):
        if not len(left):
            break
        some = [c[left] for c in a]
        part = start(some) if fresh else factors.take(left)
        place = np.arange(len(left))
        for _ in range(MORE if fresh else FEW):
            part, change = improve([c[place] for c in some], part)
            open_rows = ~(change < enough)
            factors.put(left[place], part)
            place, part = place[open_rows], part.take(open_rows)
            if not len(place):
                break
        left = left[place]
    return factors


def _blocks(a: Sequence[Array], factors: Factors, steps: int) -> tuple[Factors, Array]:
    """Some corrections of every row, block by block, in place."""
    n = len(a[0])
    change = np.empty(n, a[0].dtype)
    for first in range(0, n, BLOCK):
        rows = slice(first, first + BLOCK)
        some, part = [c[rows] for c in a], factors.take(rows)
        for step in range(steps):
            part, change[rows] = improve(some, part, watch=step == steps - 1)
        factors.put(rows, part)
    return factors, change


class _Pair(NamedTuple):
    """The two roots of each quadratic x² + p x + q."""

    real: tuple[Array, Array]
    imag: Array
    modulus: tuple[Array, ...]
    """Modulus of each root; one array for both where all rows are complex."""
    apart: Array
    """Square of the distance between the two roots."""
    slip: Array
    """Bound on the rounding error of the roots."""


def _pair_of_roots(p: Array, q: Array, unit: float) -> _Pair:
    half = -0.5 * p
    square = half * half
    disc = square - q
    size = np.abs(disc)
    root = np.sqrt(size)
    slip = unit * ((square + np.abs(q)) / root + np.abs(half) + root)
    common = np.sqrt(np.abs(q))
    real = disc > 0
    if not real.any():
        return _Pair((half, half), root, (common,), 4 * size, slip)
    big = half + np.copysign(root, half)
    first = np.where(real, big, half)
    second = np.where(real, q / np.where(big == 0, 1.0, big), half)
    modulus = np.where(real, np.abs(first), common), np.where(real, np.abs(second), common)
    return _Pair((first, second), np.where(real, 0.0, root), modulus, 4 * size, slip)


def enclose(a: Sequence[Array], error: Sequence[Array], factors: Factors) -> Roots:
    """Roots with discs that hold the exact roots of every polynomial within the error.

    Parameters
    ----------
    a, error
        Monic coefficients and bounds on their errors, lowest first.
    factors
        Approximate factors.
    """
    unit = np.finfo(a[0].dtype).eps
    # δ = (coefficients) - (product of factors), with the rounding of the product
    r = factors.r
    product: list[Any] = [1.0] if r is None else [-r, 1.0]
    size: list[Any] = [1.0] if r is None else [np.abs(r), 1.0]
    for p, q in factors.pairs:
        product = _times(product, p, q)
        size = _times(size, np.abs(p), np.abs(q))
    steps = 2 * len(factors.pairs) + 1  # in units of two roundings: product and sum, twice a pair
    off = [
        np.abs(c - m) + e + steps * unit * s
        for c, m, e, s in zip(a, product, error, size, strict=False)
    ]
    pairs = [_pair_of_roots(p, q, unit) for p, q in factors.pairs]
    spread, closest = _distances(r, pairs)
    alone = [] if r is None else [np.abs(r)]
    modulus = alone + [m + pair.slip for pair in pairs for m in pair.modulus]
    slips: list[Any] = [0.0] * len(alone) + [pair.slip for pair in pairs for _ in pair.modulus]
    weights = []
    for size_, spread_, slip_ in zip(modulus, spread, slips, strict=True):
        value = off[-1]
        for o in reversed(off[:-1]):
            value = value * size_ + o
        # 1.2 covers the rounding of the distances where the discs are clear, see below
        weights.append(1.2 * value / np.sqrt(spread_) + slip_)
    n = len(a)
    heaviest = reduce(np.maximum, weights)
    # discs of diag(λ) - w 1ᵀ, scaled by 1/10 in one place: its disc is clear of the others.  Each
    # weight bounds the error of its root, so that of a distance is at most 1/(6 n) of it
    clear = closest > (max(2 * (n + 10), 12 * n) * heaviest) ** 2
    clear &= reduce(np.maximum, spread) < np.inf  # no weight is small by an overflow
    factor = np.where(clear, 1 + (n - 1) / 10, np.inf)
    radius = [factor * w for w in weights]
    roots = Roots([], [], [])
    if r is not None:
        roots = Roots([r], [np.zeros_like(r)], radius[:1])
    place = len(alone)
    for pair in pairs:
        count = len(pair.modulus)
        for s, turn in enumerate((pair.imag, -pair.imag)):
            roots.real.append(pair.real[s])
            roots.imag.append(turn)
            roots.radius.append(radius[place + min(s, count - 1)])
        place += count
    return roots


def _distances(r: Array | None, pairs: list[_Pair]) -> tuple[list[Any], Any]:
    """Square of the product of distances from each root to all others, and of the least distance.

    A pair that is complex in every row counts for both its roots.
    """
    alone: list[Any] = [] if r is None else [1.0]
    each = [[pair.apart for _ in pair.modulus] for pair in pairs]
    closest = reduce(np.minimum, [pair.apart for pair in pairs])
    for pair, spread in zip(pairs, each, strict=True) if r is not None else ():
        turn = pair.imag * pair.imag
        for s in range(len(spread)):
            gap = (pair.real[s] - r) ** 2 + turn
            closest = np.minimum(closest, gap)
            alone[0] = alone[0] * (gap * gap if len(spread) == 1 else gap)
            spread[s] = spread[s] * gap
    for i, j in combinations(range(len(pairs)), 2):
        (left, right), (first, second) = (pairs[i], pairs[j]), (each[i], each[j])
        near, far = (left.imag - right.imag) ** 2, (left.imag + right.imag) ** 2
        if len(first) == len(second) == 1:
            along = (left.real[0] - right.real[0]) ** 2
            gap = along + near  # never larger than along + far
            closest = np.minimum(closest, gap)
            both = gap * (along + far)
            first[0], second[0] = first[0] * both, second[0] * both
            continue
        of_first, of_second = (2 * v if len(v) == 1 else v for v in (first, second))
        for s in range(2):
            for t in range(2):
                gap = (left.real[s] - right.real[t]) ** 2 + (near if s == t else far)
                closest = np.minimum(closest, gap)
                of_first[s] = of_first[s] * gap
                of_second[t] = of_second[t] * gap
        first[:], second[:] = of_first[: len(first)], of_second[: len(second)]
    return alone + [v for spread in each for v in spread], closest


def _times(poly: list[Any], p: Any, q: Any) -> list[Any]:
    """A monic polynomial times x² + p x + q; nothing multiplies by the leading 1."""
    n = len(poly)
    out: list[Any] = [0.0] * (n + 2)
    for i, c in enumerate(poly):
        leading = i == n - 1
        out[i] = out[i] + (q if leading else c * q)
        out[i + 1] = out[i + 1] + (p if leading else c * p)
        out[i + 2] = out[i + 2] + c
    return out
