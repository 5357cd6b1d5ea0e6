"""Proved verdicts and growth rates at scattered points, from a family's stored polynomials.

Any numbers may vary from point to point.  Coefficients and conditions carry a bound on each
rounding; exact arithmetic decides what the bounds leave open.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any

import numpy as np

from ..algebra.number_types import numpy_algebra
from ..algebra.polynomial import Polynomial, TabulatedPolynomial
from ..algebra.running_error import UNIT, RunningError
from ..base.verdict import CODES, Verdict, best
from ..spectra.certificate import verdict
from ..spectra.problem import Problem, broadcast_shape
from .rates import PROVED, Rates, monic, rates
from .tiles import Codes

NUMPY = numpy_algebra()


def codes_at(problem: Problem, values: Mapping[str, Any]) -> tuple[Codes, int]:
    """Verdict flags for broadcast values, each of them proved.

    Returns
    -------
    codes, exact
        Flags of the broadcast shape, and how many points went to exact arithmetic.
    """
    shape = broadcast_shape(values)
    codes = filtered(problem, values)
    flat = codes.reshape(-1)
    left = np.flatnonzero(flat == 0)
    for cell, numbers in _singly(values, shape, left):
        flat[cell] = CODES[verdict(problem, numbers)]
    return codes, len(left)


def filtered(problem: Problem, values: Mapping[str, Any]) -> Codes:
    """Verdict flags from the conditions in doubles, 0 where their bounds leave a sign open."""
    exact = _stored(problem)
    shape = broadcast_shape(values)
    good, bad = np.ones(shape, dtype=bool), np.zeros(shape, dtype=bool)
    with np.errstate(all="ignore"):
        place = _place(problem, values)
        for _, p in exact.known.conditions:
            value, error = _at(p, place, shape)
            good, bad = good & (value > error), bad | (value < -error)
    codes = good * np.int8(CODES[best(even=exact.known.even)])
    codes = np.asarray(codes + bad * np.int8(CODES[Verdict.UNSTABLE]), dtype=np.int8)
    if "lean" in values:  # upright another number is zero
        codes[np.broadcast_to(np.asarray(values["lean"]) == 0, shape)] = 0
    return codes


def rates_at(problem: Problem, values: Mapping[str, Any], *, modes: bool = False) -> Rates:
    """Growth rates for broadcast values, flat; certified where doubles are not enough."""
    exact, shape = _stored(problem), broadcast_shape(values)
    with np.errstate(all="ignore"):
        place = _place(problem, values)
        parts = [
            (
                monic(*zip(*(_at(c, place, shape) for c in factor), strict=True)),
                exact.known.even,
                1,
            )
            for factor in exact.known.factors
        ]
        flat = [(tuple([v.reshape(-1) for v in some] for some in c), e, n) for c, e, n in parts]
        count = flat[0][0][0][0].size
        growth = rates(flat, (1, count), modes=modes, wanted=PROVED)  # type: ignore[arg-type]
        growth.poor[:] |= growth.open
        scale, square = exact.scale(values)
        unit = np.broadcast_to(np.sqrt(square) if scale is None else scale, shape).reshape(-1)
        growth.scale(unit)
    for cell, numbers in _singly(values, shape, np.flatnonzero(growth.poor)):
        growth.prove(problem, cell, numbers)
    return growth


def _stored(problem: Problem) -> TabulatedPolynomial:
    assert isinstance(problem.exact, TabulatedPolynomial)
    return problem.exact


def _place(problem: Problem, values: Mapping[str, Any]) -> list[RunningError]:
    """Variables of the polynomials, with the roundings behind them."""
    exact = _stored(problem)
    behind = exact.roundings(dimensionless=problem.dimensionless)
    numbers = exact.point(values, NUMPY)
    return [
        RunningError(np.asarray(v, dtype=float), 1.01 * behind[n] * UNIT * np.abs(v))
        for n, v in zip(exact.known.variables, numbers, strict=True)
    ]


def _at(p: Polynomial, place: list[RunningError], shape: tuple[int, ...]) -> tuple[Any, Any]:
    """Value of a polynomial and a bound on its error, of the broadcast shape."""
    value = p(*place)
    if not isinstance(value, RunningError):
        value = RunningError(float(value), 0.0)
    return tuple(np.broadcast_to(v, shape) for v in (value.value, 1.01 * value.error))  # type: ignore[return-value]


def _singly(
    values: Mapping[str, Any], shape: tuple[int, ...], cells: Any
) -> Iterator[tuple[int, dict[str, float]]]:
    """Some cells, and the numbers of each."""
    flat = {n: np.broadcast_to(v, shape).reshape(-1) for n, v in values.items()}
    for cell in cells:
        yield int(cell), {n: float(v[cell]) for n, v in flat.items()}
