"""Every flutter boundary of a user's family along an axis, with what begins there."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
from flint import arb

from ...algebra.balls import precision, upper
from ...base.axis import AxisLike
from ...base.citation import cited
from ...base.errors import ParameterError, StabilityError
from ...spectra.arguments import axis_of, prepare
from ...systems.family import Family
from ...systems.structure.linearity import linear
from ...systems.structure.structural_zeros import structure
from ..changes import MOST_SCAN, along
from ..crossings import BoundaryPoint, Crossing
from .crossings_proved import Pair, pair_near
from .derivatives import Line, derivatives
from .first_coefficient import Coefficients, coefficients, line_form, others, signed
from .krawczyk import NotProvedError
from .records import CycleBirth, HopfKind, HopfPoint, Onset

PRECISIONS = (192, 512, 1536)
"""Working precisions, in turn, until every sign that decides is proved."""
NEAR = 1e-5
"""Largest distance of the pair's unknowns from those of the family's member, over 1 plus size."""

LINEAR = (
    "the rates of the states that act on others are proved to be linear in them, so that the "
    "terms of order two and three vanish identically"
)
"""Reason where there is no first Lyapunov coefficient."""


def births(
    family: Family, axis: AxisLike, parameters: dict[str, Any]
) -> list[CycleBirth] | list[HopfPoint]:
    """Every flutter boundary along an axis, with the kind of its onset.

    Parameters
    ----------
    family
        A family of a user's system.
    axis, parameters
        As for `boundaries`.

    Raises
    ------
    ParameterError
        If the family is conservative, or eigenvalues vanish by structure for another reason than
        a line of steady motions or states on which nothing depends.
    """
    grid = axis_of(family, axis, "axis", MOST_SCAN)
    named = "at" in (*family.at, *family.parameters)  # then it is a parameter like any other
    at = None if named else parameters.pop("at", None)
    problem = prepare(family, (grid,), None, None, at, parameters)
    on_line = _accepted(family, grid.name)
    found = along(problem, grid.name, grid.low, grid.high, points=grid.count, log=grid.log)
    found.warn(grid.name)
    fixed = {n: float(v) for n, v in problem.values.items() if n != grid.name}
    pairs = (Crossing.FLUTTER, Crossing.STATIC_AND_FLUTTER)
    flutter = [b for b in found if b.crossing in pairs]
    line = Line(family, grid.name, fixed)
    works = cited(
        model=bool(family.system.quantities),
        proofs=True,
        theory=["fiedler2000" if on_line else "kuznetsov2004"],
    )
    if on_line:
        return [replace(_on_line(line, b), citation=works) for b in flutter]
    return [replace(birth(line, b), citation=works) for b in flutter]


NO_PAIR = (
    "no simple pair that crosses with speed is proved there, or the rates have no second derivative"
)
NO_COEFFICIENT = (
    "zero or twice the pair may be an eigenvalue too, or the rates have no third derivative there"
)
"""Why a first Lyapunov coefficient is not known."""


def zeros_left(family: Family) -> int:
    """Structural zeros that remain without the states on which nothing depends.

    Parameters
    ----------
    family
        A family of a user's system.
    """
    dropped = len(family.system.states) - len(derivatives(family.system).kept)
    return structure(family).zeros - dropped


def _accepted(family: Family, axis: str) -> bool:
    """Whether the family is a line of steady motions along the axis; others are refused."""
    if family.conservative or structure(family).even:
        raise ParameterError(
            f"{family.name} is conservative, where pairs stay on the imaginary axis; a first "
            "Lyapunov coefficient needs a family with damping."
        )
    left = zeros_left(family)
    if left == 0:
        return False
    lines = [n for n in family.at if n in family.system.states]
    if left == 1 and axis in lines:
        return True
    if left == 1 and lines:
        raise ParameterError(
            f"{family.name} is a line of steady motions along {', '.join(lines)}, and axis is "
            f"{axis!r}; make {' or '.join(lines)} the axis."
        )
    raise ParameterError(
        f"{family.name} has {left} eigenvalues that vanish by structure, beyond states on which "
        "nothing depends; accepted are families with none, or with one along a state in `at`."
    )


def birth(line: Line, point: BoundaryPoint) -> CycleBirth:
    """The first Lyapunov coefficient at a flutter boundary, with proved bounds.

    Parameters
    ----------
    line
        The line.
    point
        The boundary.
    """
    reason = ""
    for bits in PRECISIONS:
        with precision(bits):
            reason = NO_PAIR
            try:
                pair = _checked(line, point)
                reason = NO_COEFFICIENT
                found = coefficients(pair)
                reason = LINEAR if linear(line.family.system) else _open(found)
                if not reason or bits == PRECISIONS[-1] or found.others < 0:
                    return _record(point, pair, found, reason)
            except NotProvedError:
                continue
    nan = float("nan")
    return CycleBirth(
        point.value,
        point.error,
        Onset.UNDECIDED,
        point.stable_below,
        point.frequency,
        nan,
        nan,
        nan,
        nan,
        nan,
        reason,
    )


def _checked(line: Line, point: BoundaryPoint) -> Pair:
    """The pair of a boundary, which lies in its bracket."""
    pair = pair_near(line, point.value, point.frequency)
    rough = line.member(point.value)
    near = [
        abs(u - v) <= NEAR * (1 + abs(arb(v))) for u, v in zip(pair.unknowns, rough, strict=True)
    ]
    if not all(near):  # another member, which the verdicts are not about
        raise NotProvedError
    room = 2 * point.error + 1e-9 * abs(point.value)
    if not abs(pair.value - point.value) <= room:
        raise NotProvedError
    return pair


def _open(found: Coefficients) -> str:
    """Why the onset is undecided, or nothing."""
    if found.others < 0:
        return "another eigenvalue is unstable at the boundary"
    if not found.others:
        return "another eigenvalue is not proved to be stable at the boundary"
    if not signed(found.speed):
        return "the pair's speed is not proved to differ from zero"
    if not signed(found.first):
        return "the first Lyapunov coefficient is zero within its bound; higher orders decide"
    return ""


def _record(point: BoundaryPoint, pair: Pair, found: Coefficients, reason: str) -> CycleBirth:
    kind = Onset.SOFT if found.first < 0 else Onset.HARD
    if reason:
        kind = Onset.LINEAR if reason == LINEAR else Onset.UNDECIDED
    value, error = rounded(pair.value)
    frequency, speed, first = map(rounded, (pair.frequency, found.speed, found.first))
    return CycleBirth(
        value,
        error,
        kind,
        point.stable_below,
        *frequency,
        *speed,
        *first,
        reason,
    )


def rounded(ball: Any) -> tuple[float, float]:
    """The nearest double to a ball's midpoint, and a bound on its distance from the true number.

    Parameters
    ----------
    ball
        A real ball.
    """
    value = 0.0 if arb(ball).contains(0) else float(arb(ball).mid())
    return value, upper(abs(arb(ball) - arb(value)))


def _on_line(line: Line, point: BoundaryPoint) -> HopfPoint:
    for bits in PRECISIONS:
        with precision(bits):
            try:
                pair = _checked(line, point)
                form = line_form(pair)
                stable = others(pair, zeros=1) > 0
                signs = signed(form.speed) * signed(form.push) if stable else 0
            except NotProvedError:
                continue
            if not signs and bits < PRECISIONS[-1]:
                continue
            kind = HopfKind.HYPERBOLIC if signs > 0 else HopfKind.ELLIPTIC
            mode = np.array([complex(float(v.real.mid()), float(v.imag.mid())) for v in pair.mode])
            whole = np.zeros(len(line.family.system.states), dtype=complex)
            whole[line.d.kept] = mode
            return HopfPoint(
                rounded(pair.value)[0],
                kind if signs else HopfKind.DEGENERATE,
                point.stable_below,
                float(pair.frequency.mid()),
                float(form.speed.mid()),
                float(form.push.mid()),
                whole,
                1.0,
            )
    raise StabilityError(
        f"{line.family.name} at {line.axis} = {point.value:.10g}: {NO_PAIR}, so its normal form is "
        "not known."
    )
