"""Growth rates and verdicts of many members from their polynomials' coefficients.

A grid of cells is computed from coarse to fine.  An eigensolver finds the roots of a few cells, and
every other cell starts from its neighbours' real factors.  Each root lies in a disc that is proved
to hold it, see `stability.algebra.real_factors`.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from functools import reduce
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..algebra.exact.number_fields import characteristic
from ..algebra.real_factors import Factors, Roots, enclose, settle, start
from ..algebra.running_error import TINY, UNIT
from ..base.types import Complexes, Floats
from ..base.verdict import CODES, Verdict
from ..spectra.certificate import certify
from ..spectra.problem import Problem
from ..storage.pieces import Chunk
from .tiles import Codes

STRIDE = 16
"""Distance between the cells of a grid at which the eigensolver starts."""
FEW = 1024
"""Cells of a grid below which the eigensolver starts from each of them."""
STEPS = 2
"""Corrections of a cell that starts between its neighbours, before the change is checked."""


BLOCK = 8192
"""Members in a block, so that the arrays stay in the cache."""


def coarse_to_fine(a: Sequence[Any], shape: tuple[int, int]) -> Factors:
    """Factors over a grid: every STRIDE-th cell by eigensolver, others from neighbours.

    Of a small grid the eigensolver takes every cell.
    """
    if len(a[0]) < FEW:
        return settle(a, start(a))
    coefficients = [c.reshape(shape) for c in a]
    count = len(a)
    whole = np.empty((count, *shape), dtype=a[0].dtype)
    step = STRIDE
    first = slice(None, None, step)
    some = [np.ascontiguousarray(c[first, first]).ravel() for c in coefficients]
    corner = whole[:, first, first]
    corner[...] = np.stack(settle(some, start(some)).arrays).reshape(corner.shape)
    while step > 1:
        half = step // 2
        even, odd, every = (
            slice(None, None, step),
            slice(half, None, step),
            slice(None, None, half),
        )
        steps = STEPS if half > 1 else 1
        # first the rows between known ones, then all columns between known ones
        for rows, columns, axis in ((odd, even, 1), (every, odd, 2)):
            coarse = whole[:, even, even] if axis == 1 else whole[:, every, even]
            target = whole[:, rows, columns]
            if target.size:
                near = _between(coarse, axis, target.shape[axis])
                part = [np.ascontiguousarray(c[rows, columns]).ravel() for c in coefficients]
                factors = settle(part, Factors.of(list(near.reshape(count, -1))), steps)
                target[...] = np.stack(factors.arrays).reshape(target.shape)
        step = half
    return Factors.of(list(whole.reshape(count, -1)))


def _between(values: Any, axis: int, count: int) -> Any:
    """Values half-way between neighbours along an axis, by cubic interpolation inside."""
    v = np.moveaxis(values, axis, 0)
    out = np.empty((count, *v.shape[1:]), dtype=v.dtype)
    pairs = len(v) - 1
    out[:pairs] = 0.5 * (v[:-1] + v[1:])
    if pairs > 2:
        out[1 : pairs - 1] = 0.5625 * (v[1:-2] + v[2:-1]) - 0.0625 * (v[:-3] + v[3:])
    out[pairs:] = v[-1]  # beyond the last known value
    return np.ascontiguousarray(np.moveaxis(out, 0, axis))


def most(values: Any) -> Floats:
    """The largest of each column, faster than NumPy's own reduction of few rows."""
    out: Floats = reduce(np.maximum, values)
    return out


WANTED = 1e-10
"""Error of the abscissa, relative to the largest modulus, beyond which a cell is computed again."""
PROVED = 1e-13
"""The same where certified eigenvalues are to be had."""


class Rates(NamedTuple):
    """Quantities of the eigenvalues of many members."""

    abscissa: Floats
    """Largest real part, shape (N,)."""
    error: Floats
    """Bound on its error, shape (N,)."""
    frequency: Floats
    """|Im| of the eigenvalue with the largest real part, shape (N,)."""
    codes: NDArray[np.int8]
    """Verdict flags, 0 where the discs do not decide, shape (N,)."""
    values: Complexes | None
    """All eigenvalues, sorted, shape (N, n); None unless asked for."""
    poor: NDArray[np.bool_]
    """Where the discs meet or are large, shape (N,)."""
    factors: Sequence[Factors | None] = ()
    """Real factors of each factor of the polynomial."""

    def put(self, index: Any, other: Rates) -> None:
        """Overwrite some members."""
        pairs: Any = zip(self[:6], other[:6], strict=True)
        for mine, theirs in pairs:
            if mine is not None:
                mine[index] = theirs

    @property
    def open(self) -> Any:
        """Where the sign of the abscissa is not proved."""
        return (np.abs(self.abscissa) <= self.error) & (self.error > 0)

    def scale(self, unit: Floats) -> None:
        """Take a unit of rate of each member."""
        if (unit == 1).all():
            return
        self.abscissa[:] *= unit
        self.frequency[:] *= unit
        self.error[:] = unit * self.error + 8 * UNIT * np.abs(self.abscissa)
        if self.values is not None:
            self.values[:] *= unit[:, None]

    def prove(self, problem: Problem, index: int, values: Mapping[str, float]) -> None:
        """Replace a member by certified eigenvalues."""
        certificate = certify(problem, values)
        if certificate.eigenvalues:
            lead = certificate.eigenvalues[-1]
            self.abscissa[index], self.frequency[index] = lead.real, abs(lead.imag)
            self.error[index] = certificate.abscissa_error
            if self.values is not None:
                self.values[index] = certificate.eigenvalues


def of_eigenvalues(values: Complexes, radius: Floats, codes: Codes) -> Rates:
    """Quantities of sorted eigenvalues with discs."""
    lead = values[:, -1]
    error = (radius + (values.real - lead.real[:, None])).max(axis=1)
    poor = np.zeros(len(values), dtype=bool)
    return Rates(lead.real, error, np.abs(lead.imag), codes, values, poor)


def arrays_of(growth: Any, *, modes: bool, unit: Floats | None = None) -> Chunk:
    """The arrays of a chunk of a map but its flags, times a unit of rate of each member."""
    names = ("abscissa", "error", "frequency", *(["values"] * modes))
    arrays = {name: getattr(growth, name) for name in names}
    if unit is None:
        return arrays
    return {n: v * (unit if v.ndim == 1 else unit[:, None]) for n, v in arrays.items()}


Coefficients = tuple[Any, Any]
"""Coefficients of a monic polynomial below its leading one, and bounds on their errors: rows of an
array, or a list of flat arrays."""


def rates(
    factors: Sequence[tuple[Coefficients, bool, int]],
    shape: tuple[int, int],
    *,
    modes: bool,
    wanted: float = WANTED,
    near: Sequence[Factors | None] = (),
) -> Rates:
    """Eigenvalues from the coefficients of factors.

    Parameters
    ----------
    factors
        (coefficients, whether even, multiplicity) of each factor of a polynomial.
    shape
        Rows and columns of the grid of members.
    modes
        Whether to return all eigenvalues.
    wanted
        Error of the abscissa, relative to the largest modulus, beyond which a cell is poor.
    near
        Real factors of each factor to start from.
    """
    (a, e), even, _ = factors[0]
    if len(factors) == 1 and even and len(a) == 2 and not modes:
        return _of_square(a, e, wanted)
    count = len(a[0])
    kept = [
        _factored(a[:: 1 + even], shape, near[place] if near else None)
        for place, ((a, _), even, _) in enumerate(factors)
    ]
    top, error, lead = (np.empty(count, dtype=a[0].dtype) for _ in range(3))
    codes, poor = np.empty(count, dtype=np.int8), np.empty(count, dtype=bool)
    size = sum(len(a) * number for (a, _), _, number in factors)
    values = np.empty((count, size), dtype=complex) if modes else None
    growth = Rates(top, error, lead, codes, values, poor, kept)
    for first in range(0, count, BLOCK):
        rows = slice(first, first + BLOCK)
        with np.errstate(all="ignore"):
            parts = []
            for ((a, e), even, _), seed in zip(factors, kept, strict=True):
                step = 1 + even
                near_, off = ([v[rows] for v in some[::step]] for some in (a, e))
                roots = _enclosed(near_, off, seed and seed.take(rows))
                parts.append(_mirrored(roots) if even else roots)
            _fill(growth, rows, parts, factors, wanted)
    return growth


def _factored(a: Sequence[Any], shape: tuple[int, int], near: Factors | None) -> Factors | None:
    """Real factors of monic polynomials over a grid; None where they are linear."""
    if len(a) <= 2:
        return Factors.of(a[::-1]) if len(a) == 2 else None
    with np.errstate(all="ignore"):
        return coarse_to_fine(a, shape) if near is None else settle(a, near, 2)


def _enclosed(a: Sequence[Any], error: Sequence[Any], factors: Factors | None) -> Roots:
    if factors is None:
        return Roots([-a[0]], [np.zeros_like(a[0])], [error[0]])
    return enclose(a, error, factors)


def _fill(growth: Rates, rows: slice, parts: Any, factors: Any, wanted: float) -> None:
    """Rates of some members from the roots of each factor."""
    unit = np.finfo(growth.abscissa.dtype).eps
    members = [
        # on the imaginary axis by symmetry, without an error of the real part
        (x, np.abs(y), np.where((x == 0) & (r < np.inf), 0.0, r) if even else r)
        for part, (_, even, _) in zip(parts, factors, strict=True)
        for x, y, r in _without_conjugates(part)
    ]
    top = most([x for x, _, _ in members])
    low, high = most([x - r for x, _, r in members]), most([x + r for x, _, r in members])
    error = np.maximum(high - top, top - low)
    growth.abscissa[rows] = top
    growth.error[rows] = error + np.where(error > 0, 2 * unit * np.abs(top), 0.0)
    growth.frequency[rows] = most([np.where(x == top, y, 0.0) for x, y, _ in members])
    even = any(even for _, even, _ in factors)
    sure = (high <= 0) if even else (high < 0)
    codes = sure * np.int8(CODES[Verdict.NEUTRAL if even else Verdict.STABLE])
    growth.codes[rows] = codes + (low > 0) * np.int8(CODES[Verdict.UNSTABLE])
    largest = most([np.abs(x) + y for x, y, _ in members])
    growth.poor[rows] = ~(growth.error[rows] <= wanted * largest)
    if growth.values is not None:
        spectrum = [
            x + 1j * y
            for part, (_, _, count) in zip(parts, factors, strict=True)
            for x, y in zip(part.real, part.imag, strict=True)
            for _ in range(count)
        ]
        growth.values[rows] = sorted_modes(np.stack(spectrum).astype(complex))


def _without_conjugates(roots: Roots) -> list[tuple[Any, Any, Any]]:
    """Roots with their radii; a root whose arrays are those of an earlier one is its conjugate."""
    some: dict[tuple[int, int], tuple[Any, Any, Any]] = {}
    for x, y, r in zip(*roots, strict=True):
        some.setdefault((id(x), id(r)), (x, y, r))
    return list(some.values())


def sorted_modes(values: Complexes) -> Complexes:
    """The eigenvalues of each member by real and imaginary part, from those by mode."""
    spectrum = np.ascontiguousarray(values.T)
    order = np.lexsort((spectrum.imag, spectrum.real), axis=-1)
    return np.take_along_axis(spectrum, order, -1)


def _of_square(a: Sequence[Any], error: Sequence[Any], wanted: float) -> Rates:
    """The same for λ² + a₀, in a third of the time: λ² = y is real, |√y - √z| ≤ |y - z|/√y."""
    with np.errstate(all="ignore"):
        y, off = -a[0], error[0]
        size = np.sqrt(np.abs(y))
        radius = off / size * (1 + 8 * UNIT) + 4 * UNIT * size
        grows = y > 0
        apart = radius < size  # so that off < |y|: the sign of y is sure
        top, lead = np.where(grows, size, 0.0), np.where(grows, 0.0, size)
        bound = np.where(np.isfinite(radius), radius + 8 * UNIT * size, np.inf)
        bound = np.where(grows, bound, 0.0)
        sign = np.where(grows, np.int8(CODES[Verdict.UNSTABLE]), np.int8(CODES[Verdict.NEUTRAL]))
        codes = np.where(apart, sign, np.int8(0))
        poor = ~(apart & (bound <= wanted * size))
    return Rates(top, bound, lead, codes, None, poor)


def _mirrored(squares: Roots) -> Roots:
    """±√y for the roots y = λ² of an even factor: |λ - λ'| |λ + λ'| = |y - y'|."""
    out = Roots([], [], [])
    for y, turn, r in zip(*squares, strict=True):
        square = y + 1j * turn
        size, root = np.sqrt(np.abs(square)), np.sqrt(square)
        radius = r / size * (1 + 8 * UNIT) + 4 * UNIT * size
        # the sign of a real y must be sure, or its roots are neither real nor imaginary
        sure = (radius < size) & ((turn != 0) | (np.abs(y) > r))
        radius = np.where(sure, radius, np.inf)
        for sign in (1, -1):
            out.real.append(sign * root.real)
            out.imag.append(sign * root.imag)
            out.radius.append(radius)
    return out


def monic(values: Sequence[Floats], errors: Sequence[Floats]) -> Coefficients:
    """Coefficients divided by the leading one, with bounds on their errors.

    Parameters
    ----------
    values, errors
        Coefficients by powers and bounds on their errors, arrays of one shape.
    """
    unit = np.finfo(np.asarray(values[0]).dtype).eps
    inverse, off = 1 / values[-1], errors[-1]
    least = 1.01 / np.maximum(np.abs(values[-1]) - off, 0.0)
    out, bounds = [], []
    for v, e in zip(values[:-1], errors[:-1], strict=True):
        quotient = v * inverse  # two roundings, each of half a unit
        size = np.abs(quotient)
        out.append(quotient)
        bounds.append((e + size * off) * least + 1.01 * unit * size)
    return out, bounds


def of_matrices(matrix: Floats, error: Floats) -> Coefficients:
    """Coefficients of det(λ - A), each with a bound on its error: values at cells, of any graph.

    Parameters
    ----------
    matrix, error
        Matrices and bounds on the errors of their entries, shapes (N, n, n).
    """
    count, n = matrix.shape[:2]
    out, bounds = np.empty((n, count)), np.empty((n, count))
    used = (matrix != 0).any(axis=0) | (error != 0).any(axis=0)
    for first in range(0, count, BLOCK):
        rows = slice(first, first + BLOCK)
        out[:, rows], bounds[:, rows] = _of_block(matrix[rows], error[rows], used)
    return out, bounds


def _of_block(matrix: Floats, error: Floats, used: NDArray[np.bool_]) -> Coefficients:
    n = matrix.shape[-1]
    entries: list[list[Any]] = [
        [np.ascontiguousarray(matrix[:, i, j]) if used[i, j] else 0 for j in range(n)]
        for i in range(n)
    ]
    sizes: list[list[Any]] = [
        [np.abs(matrix[:, i, j]) + error[:, i, j] if used[i, j] else 0 for j in range(n)]
        for i in range(n)
    ]
    values, largest = characteristic(entries), _sizes(sizes)
    # entries off by a share ε of their size change a product of k of them by at most k ε
    share: Any = 0.0
    for i, j in np.argwhere((error != 0).any(axis=0)).tolist():
        w = sizes[i][j]
        share = np.maximum(share, np.where(w > 0, error[:, i, j] / w, 0.0))
    out, bounds = np.empty((n, len(matrix))), np.empty((n, len(matrix)))
    # roundings on the way to a coefficient: at stage s, s for each of its entries of A but one, and
    # s + 2 for the sum over the stage; the entries of all stages are at most n
    rounding = (1.5 * n * n + 2.5 * n + 2) * UNIT
    for k in range(n):
        out[k] = values[k]
        bounds[k] = 1.01 * (rounding + 1.01 * (n - k) * share) * largest[k] + TINY * n**4
    return out, bounds


def _sizes(matrix: list[list[Any]]) -> list[Any]:
    """The steps of `characteristic` with sizes: nothing cancels, so that it bounds every sum."""
    poly: list[Any] = [1.0]
    for n in range(len(matrix)):
        row, column = matrix[n][:n], [matrix[i][n] for i in range(n)]
        band: list[Any] = [1.0, matrix[n][n]]
        for _ in range(n):
            band.append(_dot(row, column))
            column = [_dot(matrix[i][:n], column) for i in range(n)]
        poly = [_dot(band[i::-1], poly) for i in range(n + 2)]
    return poly[::-1]


def _dot(left: Sequence[Any], right: Sequence[Any]) -> Any:
    """A sum of products; the integer 0 means nothing."""
    terms = [
        v * w
        for v, w in zip(left, right, strict=False)
        if not (isinstance(v, int) or isinstance(w, int))
    ]
    return sum(terms[1:], start=terms[0]) if terms else 0
