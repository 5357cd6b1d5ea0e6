"""Proved verdicts of bands of a map, by exact polynomials."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from ...algebra.exact.known_polynomial import TabulatedPolynomial
from ...base.axis import Axis
from ...base.errors import ParameterError
from ...base.types import Floats
from ...base.verdict import CODES, Verdict
from ...spectra.problem import Problem
from ..own.slice_verdicts import ELSEWHERE, SliceVerdicts, slice_verdicts
from ..verdict_tiles import Codes, GridVerdicts

Judge = GridVerdicts | SliceVerdicts
"""What gives the verdicts of a band."""
METHOD = (
    "verdicts from the exact stability conditions: whole tiles proved at once, cells next to the "
    "boundary by a floating-point filter with a proved bound, what it leaves open in rational "
    "arithmetic or balls"
)
"""Method in words."""


def judge_of(problem: Problem, axes: tuple[Axis, Axis]) -> Judge:
    """What gives the verdicts of a map.

    Parameters
    ----------
    problem
        Family with values in the user's units.
    axes
        x and y.

    Raises
    ------
    ParameterError
        If there are no exact polynomials.
    """
    if problem.plain:
        return _own_verdicts(problem, axes)
    if not isinstance(problem.exact, TabulatedPolynomial):
        raise ParameterError(
            f"{problem.family.name} under the {problem.law.name if problem.law else ''} law has no "
            "exact polynomials, by which verdicts are streamed; use growth=True, or stability_map."
        )
    return GridVerdicts(problem, axes[0].name, axes[1].name)


def _own_verdicts(problem: Problem, axes: tuple[Axis, Axis]) -> SliceVerdicts:
    """Verdicts of a user's family, which exist in every cell."""
    found = slice_verdicts(problem, axes)
    if found is None:
        raise ParameterError(
            f"{problem.family.name} has no polynomial over Q in {axes[0].name} and {axes[1].name} "
            "that proves its verdicts, by which verdicts are streamed; use growth=True, or "
            "stability_map."
        )
    if problem.may_drift:
        raise ParameterError(
            f"{problem.family.name} has zero eigenvalues that may form a Jordan block, which its "
            "polynomial does not show; use growth=True, or stability_map."
        )
    if not found.everywhere:
        raise ParameterError(
            f"{problem.family.name} is not proved to have a member in every cell of this map; use "
            "growth=True, or stability_map."
        )
    return found


def flags() -> dict[str, Any]:
    """Attributes of verdicts alone."""
    return {
        "flag_values": np.array(list(CODES.values()), dtype=np.int8),
        "flag_meanings": " ".join(v.word for v in CODES),
        "long_name": "spectral verdict",
    }


def band(judge: Callable[[], Judge], xs: Floats, ys: Floats) -> tuple[Codes, int]:
    """Flags of a band, and the number of its cells that went to exact arithmetic.

    Parameters
    ----------
    judge
        Gives this worker's judge.
    xs, ys
        Increasing values of the axes.
    """
    codes, left = judge()(xs, ys)
    codes[codes == ELSEWHERE] = CODES[Verdict.UNDECIDED]  # a sign that balls leave open
    return codes, left
