"""Eigenvalues over arrays from the exact polynomials, nearly without an eigensolver.

A tile of a map is computed from coarse to fine: an eigensolver finds the roots of a few cells, and
every other cell starts from its neighbours' factors.  Cells that double precision leaves too
uncertain are computed again in extended precision where the machine has it, and then exactly.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..algebra.kernels.compiled import numba_found
from ..algebra.polynomial import Polynomial
from ..algebra.real_factors import Factors, Roots, enclose, settle, start
from ..base.types import Floats
from ..spectra.certificate import certify
from ..spectra.problem import Problem
from .compiled.loops import WANTED
from .compiled.rates import CompiledRates, in_range, tables
from .general.rates import Room, sorted_modes
from .verdicts import point, tabulated

STRIDE = 16
"""Distance between the cells of a tile at which the eigensolver starts."""
STEPS = 2
"""Corrections of a cell that starts between its neighbours, before the change is checked."""
LONG = np.longdouble
HAS_LONG = np.finfo(LONG).eps < 1e-18
"""Whether the machine's long double is longer than double."""


def steady_memory() -> None:
    """Let freed arrays of megabytes stay with the process, where the C library is glibc.

    One allocation of 31 MiB raises the threshold at which glibc gives memory back.  Without this,
    the arrays of a map are fetched from the system again and again.  Elsewhere nothing changes.
    """
    np.empty(31 * 2**20, dtype=np.uint8)


class Growth(NamedTuple):
    """Eigenvalues over the cells of a tile, flat."""

    abscissa: Floats
    """Largest real part, shape (N,), in the user's unit of rate."""
    error: Floats
    """Bound on its error, shape (N,)."""
    frequency: Floats
    """|Im| of the eigenvalue with the largest real part, shape (N,)."""
    values: NDArray[np.complex128] | None
    """All eigenvalues, sorted, shape (N, n); None unless asked for."""
    handed_on: int
    """Cells that went to exact arithmetic."""
    codes: NDArray[np.int8] | None = None
    """Flags of the verdicts that the bounds of compiled loops prove, shape (N,), 0 for others; None
    where other routes computed the rates."""


class _Coefficients:
    """Monic coefficients of a factor of odd degree, with bounds, over arrays."""

    def __init__(self, factor: tuple[Polynomial, ...], behind: Mapping[str, int]) -> None:
        self._parts = []
        for polynomial in factor:
            turned, order = polynomial.ordered()
            plus, minus = turned.parts
            most = max(plus.roundings(behind), minus.roundings(behind)) + 1
            self._parts.append((plus, minus, order, 1.02 * most))

    def __call__(self, at: list[Any], shape: tuple[int, ...]) -> tuple[list[Any], list[Any]]:
        """Monic coefficients and their errors, flat arrays, lowest first."""
        unit = np.finfo(np.result_type(*at)).eps / 2
        values, errors = [], []
        for plus, minus, order, roundings in self._parts:
            place = [at[i] for i in order]
            high, low = plus(*place), minus(*place)
            values.append(high - low)
            errors.append(roundings * unit * (high + low))
        lead, slack = values[-1], errors[-1] / np.abs(values[-1])
        flat = []
        for v, e in zip(values[:-1], errors[:-1], strict=True):
            monic = v / lead
            # 1.1 and the rounding of the quotient cover the quotient's own error
            off = 1.1 * (e / np.abs(lead) + np.abs(monic) * (slack + 2 * unit))
            flat.append([np.broadcast_to(x, shape).reshape(-1) for x in (monic, off)])
        return [f[0] for f in flat], [f[1] for f in flat]


class GrowthKernel:
    """Eigenvalues over rectangular tiles of a map.

    Parameters
    ----------
    problem
        Problem of a family with a tabulated polynomial.
    modes
        Whether to return all eigenvalues.
    quick
        Whether to use compiled loops where Numba is installed; they return no modes.
    """

    def __init__(self, problem: Problem, *, modes: bool = False, quick: bool = False) -> None:
        self.problem, self.modes, self.exact = problem, modes, tabulated(problem)
        known, behind = self.exact.known, self.exact.roundings(dimensionless=problem.dimensionless)
        self.even = known.even
        one = Polynomial(known.variables, ((1, (0,) * len(known.variables)),))
        self._factors = [_Coefficients(f, behind) for f in known.factors]
        even_terms = known.factors[0][::2] if self.even else ()  # of c₀ + c₂ λ²
        self._squared = [_Coefficients((c, one), behind) for c in even_terms]
        tables_ = tables(self.exact, behind) if quick and not modes and numba_found() else None
        self._loops = None if tables_ is None else CompiledRates(tables_)

    @property
    def compiled(self) -> bool:
        """Whether compiled loops compute the tiles."""
        return self._loops is not None

    def __call__(
        self, values: Mapping[str, Any], *, scattered: bool = False, out: Room | None = None
    ) -> Growth:
        """Eigenvalues for broadcast values over a tile.

        Parameters
        ----------
        values
            Float or array by name, broadcasting to two dimensions (rows, columns), or one.
        scattered
            Whether neighbours are unrelated, so that every cell starts from the eigensolver.
        out
            Contiguous arrays that compiled loops fill; new ones when left out.

        Returns
        -------
        Growth
            Flat, in the order of the tile.
        """
        given = np.broadcast_shapes(*(np.shape(v) for v in values.values()))
        rows, columns = (1,) * (2 - len(given)) + given
        shape = rows, columns
        with np.errstate(all="ignore"):
            quick, codes = None if scattered else self._quick(values, shape, out), None
            if quick is not None:
                found, poor, factors, codes = quick
            else:
                roots, factors = self._roots(values, shape, [] if scattered else None)
                found = self._rated(values, shape, roots)
                poor = np.flatnonzero(_poor(found))
                factors = [f and f.take(poor) for f in factors]
            if HAS_LONG and len(poor) and not self.even:
                part = _some(values, shape, poor, LONG)
                row = 1, len(poor)
                known = [f and f.astype(LONG) for f in factors]
                again = self._rated(part, row, self._roots(part, row, known)[0])
                found.put(poor, again)
                poor = poor[_poor(again)]
        if len(poor):
            found.prove(self.problem, _some(values, shape, poor, float), poor)
        spectrum = None if found.values is None else sorted_modes(found.values)
        return Growth(found.top, found.error, found.turn, spectrum, len(poor), codes)

    def _quick(
        self, values: Mapping[str, Any], shape: tuple[int, int], out: Room | None = None
    ) -> Any:
        """Quantities by compiled loops, open cells, the factors of these, and flags."""
        if self._loops is None or not all(in_range(v) for v in values.values()):
            return None
        found = self._loops(point(self.problem, values), self._unit(values), shape, out)
        if found is None:
            return None
        if HAS_LONG and len(found.poor):
            long = {n: np.atleast_2d(np.asarray(v, dtype=LONG)) for n, v in values.items()}
            found = self._loops.refine(
                found, point(self.problem, long), self._unit(values), shape[1]
            )
        degrees = [len(f) - 1 for f in self.exact.known.factors]
        factors = [Factors.unstack(found.factors) if n > 1 else None for n in degrees]
        top, error, turn = found.rates
        codes = None if "lean" in values else found.codes  # at lean 0 another polynomial decides
        return _All(top, error, turn, None, None), found.poor, factors, codes

    def _unit(self, values: Mapping[str, Any]) -> Any:
        """Unit of σ in the user's unit of rate, as it broadcasts."""
        scale, square = self.exact.scale(values)
        return np.sqrt(square) if scale is None else scale

    def _roots(
        self, values: Mapping[str, Any], shape: tuple[int, int], known: list[Factors | None] | None
    ) -> tuple[list[Roots], list[Factors | None]]:
        """Roots of each factor over Q, and its real factors where it has a quadratic one."""
        at = point(self.problem, values)
        if self.even:
            return [self._squares(at, shape)], [None]
        out: list[Roots] = []
        kept: list[Factors | None] = []
        for place, coefficients in enumerate(self._factors):
            a, error = coefficients(at, shape)
            if len(a) == 1:
                zero = np.zeros_like(a[0])
                out.append(Roots([-a[0]], [zero], [error[0]]))
                kept.append(None)
                continue
            near = known[place] if known else None  # `known` is [] for scattered points
            if near is not None:
                factors = settle(a, near, 2)
            elif known is not None:
                factors = settle(a, start(a), 1)
            else:
                factors = _coarse_to_fine(a, shape)
            out.append(enclose(a, error, factors))
            kept.append(factors)
        return out, kept

    def _squares(self, at: list[Any], shape: tuple[int, ...]) -> Roots:
        """±√z with z = λ², for a law whose polynomial is linear in λ²."""
        low, high = ((v[0], e[0]) for v, e in (c(at, shape) for c in self._squared))
        z = -low[0] / high[0]
        slack = low[1] / np.abs(low[0]) + high[1] / np.abs(high[0])
        unit = np.finfo(float).eps
        root = np.sqrt(np.abs(z))
        # |√z - √z'| ≤ min(relative error of z, √ of its error)
        off = np.minimum(root * (slack + unit), np.sqrt(np.abs(z) * slack) + unit * root)
        off = np.where(low[0] == 0, np.sqrt(low[1] / np.abs(high[0])), off)
        real, imag = np.where(z > 0, root, 0.0), np.where(z > 0, 0.0, root)
        return Roots([real, -real], [imag, -imag], [off, off])

    def _rated(self, values: Mapping[str, Any], shape: tuple[int, ...], roots: list[Roots]) -> _All:
        """Quantities of the eigenvalues, in the user's unit of rate, as doubles."""
        unit = self._unit(values)
        unit = np.broadcast_to(unit, shape).reshape(-1) if np.ndim(unit) else unit
        real = [x for found in roots for x in found.real]
        imag = [x for found in roots for x in found.imag]
        radius = [x for found in roots for x in found.radius]
        top = np.maximum.reduce(real)
        # every disc is clear of the others, so each holds one eigenvalue
        high, own, turn = top, np.asarray(np.inf), np.asarray(0.0)
        largest: Any = 0.0
        seen: set[tuple[int, int]] = set()
        for x, y, r in zip(real, imag, radius, strict=True):
            if (id(x), id(r)) in seen:  # the conjugate of an earlier root
                continue
            seen.add((id(x), id(r)))
            first = x == top
            size = np.abs(y)
            high = np.maximum(high, x + r)
            own = np.where(first, np.minimum(own, r), own)
            turn = np.where(first, np.maximum(turn, size), turn)
            largest = np.maximum(largest, np.abs(x) + size)
        error = np.maximum(high - top, own)
        if self.even:  # neutral where λ² is negative beyond doubt
            error = np.where((top == 0) & (turn > radius[0]), 0.0, error)
        # roundings of the unit, of the product with it, and of the sums above
        error = error + np.where(error == 0, 0.0, 6e-16 * np.abs(top) + 1e-18 * largest)
        some = None
        if self.modes:
            some = np.stack([unit * x + 1j * (unit * y) for x, y in zip(real, imag, strict=True)])
            some = some.astype(complex, copy=False)
        doubles = [
            np.asarray(unit * v).astype(float, copy=False) for v in (top, error, turn, largest)
        ]
        return _All(doubles[0], doubles[1], doubles[2], doubles[3], some)


class _All(NamedTuple):
    """Quantities of the eigenvalues of many cells."""

    top: Floats
    error: Floats
    turn: Floats
    largest: Floats | None
    """Largest modulus of an eigenvalue, to judge the error by; None where that is done."""
    values: Any
    """All eigenvalues, with the mode as first axis, or None."""

    def put(self, index: Any, other: _All) -> None:
        for mine, theirs in zip(self, other, strict=True):
            if mine is not None:
                mine[..., index] = theirs

    def prove(self, problem: Problem, values: Mapping[str, Any], index: Any) -> None:
        """Replace some cells by certified eigenvalues."""
        for place, row in enumerate(index):
            one = {n: float(np.broadcast_to(v, index.shape)[place]) for n, v in values.items()}
            certificate = certify(problem, one)
            if certificate.eigenvalues:
                lead = certificate.eigenvalues[-1]
                self.top[row], self.turn[row] = lead.real, abs(lead.imag)
                self.error[row] = certificate.abscissa_error
                if self.values is not None:
                    self.values[:, row] = certificate.eigenvalues


def _poor(found: _All) -> Any:
    """Where the error is beyond `WANTED`, or the sign of the abscissa is open."""
    assert found.largest is not None
    sure = found.error <= WANTED * found.largest
    return ~(sure & ((np.abs(found.top) > found.error) | (found.error == 0)))


def _some(values: Mapping[str, Any], shape: tuple[int, ...], index: Any, kind: Any) -> Any:
    return {
        n: np.broadcast_to(np.asarray(v), shape).reshape(-1)[index].astype(kind)
        for n, v in values.items()
    }


def _coarse_to_fine(a: list[Any], shape: tuple[int, int]) -> Factors:
    """Factors over a grid: every STRIDE-th cell by eigensolver, others from neighbours."""
    coefficients = [c.reshape(shape) for c in a]
    count = len(a)
    whole = np.empty((count, *shape), dtype=a[0].dtype)
    step = STRIDE
    first = slice(None, None, step)
    some = [np.ascontiguousarray(c[first, first]).ravel() for c in coefficients]
    corner = whole[:, first, first]
    corner[...] = settle(some, start(some)).stack().reshape(corner.shape)
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
            known = whole[:, even, even] if axis == 1 else whole[:, every, even]
            target = whole[:, rows, columns]
            if target.size:
                near = _between(known, axis, target.shape[axis])
                part = [np.ascontiguousarray(c[rows, columns]).ravel() for c in coefficients]
                found = settle(part, Factors.unstack(near.reshape(count, -1)), steps)
                target[...] = found.stack().reshape(target.shape)
        step = half
    return Factors.unstack(whole.reshape(count, -1))


def _between(known: Any, axis: int, count: int) -> Any:
    """Values half-way between neighbours along an axis, by cubic interpolation inside."""
    v = np.moveaxis(known, axis, 0)
    out = np.empty((count, *v.shape[1:]), dtype=v.dtype)
    pairs = len(v) - 1
    out[:pairs] = 0.5 * (v[:-1] + v[1:])
    if pairs > 2:
        out[1 : pairs - 1] = 0.5625 * (v[1:-2] + v[2:-1]) - 0.0625 * (v[:-3] + v[3:])
    out[pairs:] = v[-1]  # beyond the last known value
    return np.ascontiguousarray(np.moveaxis(out, 0, axis))
