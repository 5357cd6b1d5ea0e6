"""Linear questions of a scene: verdict, growth rate, boundary; its rungs are routes to spectra."""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

from ..base.errors import ParameterError
from ..base.quantities import Kind
from ..base.verdict import Verdict
from ..bodies.disk import Disk
from ..bodies.families import named_by
from ..boundary.changes import boundaries
from ..spectra.spectrum import spectrum
from .answer import Answer
from .inputs import unit_of
from .ladder import Rung
from .questions import Found, relative_error
from .rungs.track import Problem

DOUBLE, CERTIFIED, EXACT = "double precision", "certified", "exact roots"
SPAN = 8.0
"""Ratio of the ends of the axis, on which a boundary is sought, to the member's own value."""
POINTS = 201
"""Points of a scan for a boundary, where one is needed."""


@dataclass(frozen=True, eq=False)
class Member:
    """A steady motion that a linear question is about, with the arguments of `spectrum`."""

    family: Any
    """Name of the family, or a family of a user's system."""
    at: Any
    """What names the member, in the user's unit."""
    arguments: dict[str, Any]
    """Body and contact law, or parameters by name."""
    between: tuple[float, float] = (0.0, math.pi)
    """Open interval of θ in which the body has members [rad]."""


@dataclass(frozen=True, eq=False)
class Told:
    """Answer to a linear question."""

    model: str
    """Name of the rung that was taken."""
    found: dict[str, Found]
    """Each quantity."""
    rungs: tuple[Rung, ...]
    """All rungs, in order."""
    sentence: str
    """The reason for the verdict, in words."""


def _verdict(member: Member, certify: bool) -> tuple[Found, str]:  # noqa: FBT001
    s = spectrum(member.family, at=member.at, certify=certify, escalate=False, **member.arguments)
    error = math.inf if s.verdict is Verdict.UNDECIDED else 0.0
    return Found(s.verdict.word, error), s.reason


def _growth_rate(member: Member, certify: bool) -> tuple[Found, str]:  # noqa: FBT001
    s = spectrum(member.family, at=member.at, certify=certify, escalate=False, **member.arguments)
    return Found(float(s.abscissa), float(s.abscissa_error)), s.reason


def _boundary(member: Member, certify: bool) -> tuple[Found, str]:  # noqa: FBT001, ARG001
    """The nearest value of `at` at which the verdict changes."""
    low, high = sorted((member.at / SPAN, member.at * SPAN))
    if named_by(member.family) is Kind.ANGLE:
        first, last = member.between
        inside = 1e-9 * (last - first)
        low, high = max(first + inside, low), min(last - inside, high)
    found = boundaries(member.family, axis=("at", low, high, POINTS), **member.arguments)
    if not found:
        error = 0.0 if found.complete else math.inf
        return Found(None, error, f"no change of verdict from {low:.4g} to {high:.4g}"), found.how
    near = min(found, key=lambda point: abs(point.value - member.at))
    return Found(float(near.value), float(near.error)), f"{near.crossing.value}; {found.how}"


LINEAR: dict[str, tuple[Callable[[Member, bool], tuple[Found, str]], tuple[str, ...]]] = {
    "verdict": (_verdict, (DOUBLE, CERTIFIED)),
    "growth_rate": (_growth_rate, (DOUBLE, CERTIFIED)),
    "boundary": (_boundary, (EXACT,)),
}
"""Every linear quantity: the function that finds it, and its rungs, cheapest first."""


def about_nearest(
    problem: Problem,
    disk: Any,
    law: Any,
    names: tuple[str, ...],
    tolerance: float,
    horizon: float,
    only: str | None,
) -> Answer:
    """The answer to linear questions about the steady motion nearest to the start.

    Parameters
    ----------
    problem
        The problem.
    disk, law
        The disk or body, and its contact law.
    names, tolerance, only
        As for `answer`.
    horizon
        Horizon of the scene.
    """
    near = problem.launches.settling.closest(problem.start, problem.p)
    if not math.isfinite(near.distance):
        raise ParameterError(f"{near.evidence}: a linear question needs a steady motion.")
    launches = problem.launches
    kinds = {"growth_rate": Kind.GROWTH_RATE, "boundary": named_by(near.family)}
    sizes = {n: float(launches.size(kind)) for n, kind in kinds.items()}
    thin = isinstance(disk, Disk)
    arguments: dict[str, Any] = {"disk" if thin else "body": disk, "contact": law}
    arguments |= next(v.call for v in launches.settling.lines if v.name == near.family)
    between = (0.0, math.pi) if thin else disk.between
    family = arguments.pop("family")
    member = Member(family, near.at * sizes["boundary"], arguments, between)
    told = answer(member, names, tolerance, only, sizes)
    values = {n: f.value for n, f in told.found.items()}
    errors = {n: relative_error(f, sizes.get(n, 1.0)) for n, f in told.found.items()}
    one = len(values) == 1
    sentence = f"{near.family} at {member.at:.6g}, {near.distance:.2g} away: {told.sentence}."
    return Answer(
        next(iter(values.values())) if one else values,
        told.model,
        next(iter(errors.values())) if one else errors,
        told.rungs,
        horizon,
        sentence,
        tolerance,
        measures={n: (unit_of(launches, kinds[n]), sizes[n]) for n in names if n in kinds},
    )


def answer(
    member: Member,
    names: tuple[str, ...],
    tolerance: float,
    only: str | None,
    sizes: Mapping[str, float],
) -> Told:
    """The answer to linear questions about one steady motion.

    Parameters
    ----------
    member
        The steady motion.
    names
        Keys of `LINEAR`.
    tolerance
        Error allowed in a growth rate or a boundary, over 1 or its size.
    only
        Name of the one rung to run; None for the choice.
    sizes
        A dimensionless 1 of each number in the user's units.

    Returns
    -------
    Told
    """
    rungs, found, taken, said = [], {}, [], []
    for name in names:
        find, order = LINEAR[name]
        if only is not None and only not in order:
            raise ParameterError(f"only is {only!r}; the rungs of {name} are {', '.join(order)}.")
        done = False
        for rung in order if only is None else (only,):
            if done:
                rungs.append(Rung(rung, 0, 0.0, 0.0, math.inf, False, f"{name}: not needed"))
                continue
            began = time.perf_counter()
            one, why = find(member, rung == CERTIFIED)
            share = relative_error(one, sizes.get(name, 1.0)) / tolerance
            done = share <= 1 or rung == order[-1] or only is not None
            cost = time.perf_counter() - began
            reason = (
                f"{name}: {'fine enough' if share <= 1 else 'not decided within the tolerance'}"
            )
            rungs.append(Rung(rung, 0, cost, 0.0, share, done, reason))
            if done:
                found[name] = one
                taken.append(rung)
                said.append(f"{name}: {why}" if len(names) > 1 else why)
    return Told(", ".join(dict.fromkeys(taken)), found, tuple(rungs), "; ".join(said))
