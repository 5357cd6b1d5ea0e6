"""Verdicts over arrays from the exact conditions: a floating-point filter with a proved bound.

Each condition P is split as P⁺ - P⁻ with positive coefficients in positive variables, so that each
part is computed with a relative error of at most N roundings.  If P⁺ > ρ P⁻ or P⁻ > ρ P⁺ with ρ
just above one, the sign of P is proved.  Other points go to exact arithmetic.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..algebra.exact.known_polynomial import Exact, TabulatedPolynomial
from ..algebra.number_types import numpy_algebra
from ..algebra.polynomial import Polynomial
from ..algebra.running_error import UNIT
from ..base.verdict import CODES, Verdict, best
from ..bodies.disk_polynomials import INPUT
from ..spectra.certificate import verdict
from ..spectra.problem import Problem

Codes = NDArray[np.int8]

NUMPY = numpy_algebra()
RANGE = 280.0
"""Decimal exponents that a monomial may use, so that nothing over- or underflows."""


class VerdictKernel:
    """Proved verdicts over arrays.

    Parameters
    ----------
    exact
        Polynomial and conditions of a family and law.
    behind
        Number of roundings in each variable, by name; those of the disk when left out.

    Examples
    --------
    >>> from stability.bodies.disk_polynomials import exact_polynomial
    >>> kernel = VerdictKernel(exact_polynomial("rolling", "viscous"))
    >>> kernel([0.25, 1.0, np.array([1.9, 2.0, 2.1])]).tolist()  # unstable, open, stable
    [2, 0, 1]
    """

    def __init__(self, exact: Exact, behind: Mapping[str, int] = INPUT) -> None:
        self.exact = exact
        self.good = CODES[best(even=exact.even)]
        self.bad = CODES[Verdict.UNSTABLE]
        self._parts = [_Split(p, behind) for _, p in exact.conditions]

    def __call__(self, point: list[Any]) -> Codes:
        """Verdict flags at a point for broadcast arrays; 0 where the filter does not decide.

        Parameters
        ----------
        point
            Arrays or floats for each of `exact.variables`, positive.

        Returns
        -------
        ndarray
            int8, of the broadcast shape, in C order.
        """
        shape = np.broadcast_shapes(*(np.shape(v) for v in point))
        with np.errstate(all="ignore"):
            signs = [part.signs(point) for part in self._parts]
            codes = np.ascontiguousarray(np.broadcast_to(self._codes(signs), shape))
        sure = self.in_range(point)
        if sure is not True:
            codes = np.where(sure, codes, np.int8(0))
        return codes

    def _codes(self, signs: list[tuple[Any, Any]]) -> Codes:
        good: Any = np.True_
        bad: Any = np.False_
        for above, below in signs:
            good, bad = good & above, bad | below
        good, bad = np.asarray(good).view(np.int8), np.asarray(bad).view(np.int8)
        codes: Codes = good * np.int8(self.good) + bad * np.int8(self.bad)
        return codes

    def in_range(self, point: list[Any]) -> Any:
        """Where no monomial can over- or underflow; True for everywhere.

        Parameters
        ----------
        point
            Arrays or floats, as for a call.
        """
        powers = [
            max(p.degrees[i] for p in self._parts) if self._parts else 0 for i in range(len(point))
        ]
        with np.errstate(all="ignore"):
            reach = [
                d * max(abs(np.log10(np.min(v))), abs(np.log10(np.max(v))))
                for d, v in zip(powers, point, strict=True)
            ]
            if sum(reach) <= RANGE:
                return True
            total: Any = sum(d * np.abs(np.log10(v)) for d, v in zip(powers, point, strict=True))
        return total <= RANGE


class _Split:
    """P⁺ and P⁻ of a polynomial, with their Horner schemes nested for broadcast arrays."""

    def __init__(self, polynomial: Polynomial, behind: Mapping[str, int]) -> None:
        self.degrees = polynomial.degrees
        turned, self._order = polynomial.ordered()
        self._plus, self._minus = turned.parts
        most = max(self._plus.roundings(behind), self._minus.roundings(behind))
        error = 1.01 * (most + 3) * UNIT
        self.ratio = (1 + error) / (1 - error) * (1 + 8 * UNIT)

    def signs(self, point: list[Any]) -> tuple[Any, Any]:
        """Where the polynomial is positive, and where it is negative, proved."""
        place = [point[i] for i in self._order]
        plus, minus = self._plus(*place), self._minus(*place)
        return plus > self.ratio * minus, minus > self.ratio * plus


class FilteredVerdicts:
    """The whole verdict route of a problem: the filter, then exact arithmetic where it is open.

    Parameters
    ----------
    problem
        Problem of a family with a tabulated polynomial.
    """

    def __init__(self, problem: Problem) -> None:
        self.problem = problem
        exact = tabulated(problem)
        behind = exact.roundings(dimensionless=problem.dimensionless)
        self.kernel = VerdictKernel(exact.known, behind)

    def codes(self, values: Mapping[str, Any]) -> tuple[Codes, int]:
        """Verdict flags for broadcast values, each of them proved.

        Parameters
        ----------
        values
            Float or array by name, in the user's units.

        Returns
        -------
        codes, handed_on
            Flags of the broadcast shape, and how many points went to exact arithmetic.
        """
        shape = np.broadcast_shapes(*(np.shape(v) for v in values.values()))
        codes = self.kernel(point(self.problem, values))
        codes = np.ascontiguousarray(np.broadcast_to(codes, shape))
        if not codes.flags.writeable:
            codes = codes.copy()
        if "lean" in values:
            codes[np.broadcast_to(np.asarray(values["lean"]) == 0, shape)] = 0
        flat = codes.reshape(-1)
        open_cells = np.flatnonzero(flat == 0)
        if len(open_cells):
            places = np.unravel_index(open_cells, shape) if shape else ((),)
            for count, cell in enumerate(open_cells):
                where = tuple(p[count] for p in places) if shape else ()
                one = {n: float(_at(v, shape, where)) for n, v in values.items()}
                flat[cell] = CODES[verdict(self.problem, one)]
        return codes, len(open_cells)


def tabulated(problem: Problem) -> TabulatedPolynomial:
    """The tabulated polynomials of a problem, on which a map's kernels rest."""
    assert isinstance(problem.exact, TabulatedPolynomial)
    return problem.exact


def _at(value: Any, shape: tuple[int, ...], where: tuple[Any, ...]) -> Any:
    return np.broadcast_to(value, shape)[where]


def point(problem: Problem, values: Mapping[str, Any]) -> list[Any]:
    """Variables of the exact polynomial in double precision, for broadcast values.

    Parameters
    ----------
    problem
        Family with values in the user's units.
    values
        Float or array by name.

    Returns
    -------
    list
        Arrays or floats in the order of `exact.variables`.
    """
    with np.errstate(all="ignore"):  # the filter leaves open what overflows
        found = tabulated(problem).point(values, NUMPY)
    return [v if np.ndim(v) else float(v) for v in found]
