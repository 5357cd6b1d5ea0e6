"""Linear questions of a scene: verdict, growth rate, boundary; its rungs are routes to spectra."""

from __future__ import annotations

import math
import time
from collections import ChainMap
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

from ..base.errors import ParameterError
from ..base.quantities import Kind
from ..base.verdict import Verdict
from ..bodies.families import named_by
from ..boundary.changes import boundaries
from ..spectra.result import Spectrum
from ..spectra.spectrum import spectrum
from .answer import Answer, single
from .inputs import SceneSubject, unit_of
from .ladder import Rung
from .questions import QUESTIONS, Estimate, Question, relative_error
from .rungs.track import LaunchProblem

DOUBLE, CERTIFIED, EXACT = "double precision", "certified", "exact roots"
SPAN = 8.0
"""Ratio of the ends of the axis, on which a boundary is sought, to the member's own value."""
POINTS = 201
"""Points of a scan for a boundary, where one is needed."""


@dataclass(frozen=True, eq=False)
class SteadyMotion:
    """A steady motion that a linear question is about, with the arguments of `spectrum`."""

    family: Any
    """Name of the family, or a family of a user's system."""
    at: Any
    """What names the member, in the user's unit."""
    arguments: dict[str, Any]
    """Body and contact law, or parameters by name."""
    between: tuple[float, float] = (0.0, math.pi)
    """Open interval of θ in which the body has members [rad]."""


def _spectrum(member: SteadyMotion, certify: bool) -> Spectrum:  # noqa: FBT001
    return spectrum(
        member.family, at=member.at, certify=certify, escalate=False, **member.arguments
    )


def _verdict(member: SteadyMotion, certify: bool) -> tuple[Estimate, str]:  # noqa: FBT001
    s = _spectrum(member, certify)
    error = math.inf if s.verdict is Verdict.UNDECIDED else 0.0
    return Estimate(s.verdict.word, error), s.reason


def _growth_rate(member: SteadyMotion, certify: bool) -> tuple[Estimate, str]:  # noqa: FBT001
    s = _spectrum(member, certify)
    return Estimate(float(s.abscissa), float(s.abscissa_error)), s.reason


def _boundary(member: SteadyMotion, certify: bool) -> tuple[Estimate, str]:  # noqa: FBT001, ARG001
    """The nearest value of `at` at which the verdict changes."""
    low, high = sorted((member.at / SPAN, member.at * SPAN))
    if named_by(member.family) is Kind.ANGLE:
        first, last = member.between
        inside = 1e-9 * (last - first)
        low, high = max(first + inside, low), min(last - inside, high)
    changes = boundaries(member.family, axis=("at", low, high, POINTS), **member.arguments)
    if not changes:
        error = 0.0 if changes.complete else math.inf
        return Estimate(
            None, error, f"no change of verdict from {low:.4g} to {high:.4g}"
        ), changes.how
    near = min(changes, key=lambda point: abs(point.value - member.at))
    return Estimate(float(near.value), float(near.error)), f"{near.crossing.value}; {changes.how}"


@dataclass(frozen=True)
class LinearQuestion:
    """One quantity of a steady motion that a scene may ask for."""

    name: str
    """Its name, in `quantities` of a scene and of its file."""
    find: Callable[[SteadyMotion, bool], tuple[Estimate, str]]
    """Function of (member, whether to certify) that finds it, with its reason in words."""
    rungs: tuple[str, ...]
    """Routes to it, cheapest first."""
    about: str
    """What it is, in words."""
    kind: Callable[[str], Kind | None] = lambda _family: None
    """Its kind at a member of a family; None for words."""
    of_body: bool = True
    """Whether only a body has it: a scene knows no spectrum of a user's system."""
    none: str = "none"
    """What it means where there is no value."""


_EVERY = (
    LinearQuestion("verdict", _verdict, (DOUBLE, CERTIFIED), "whether the motion is stable"),
    LinearQuestion(
        "growth_rate",
        _growth_rate,
        (DOUBLE, CERTIFIED),
        "largest real part of an eigenvalue",
        lambda _family: Kind.GROWTH_RATE,
    ),
    LinearQuestion(
        "boundary",
        _boundary,
        (EXACT,),
        "nearest value of the number that names the motion at which the verdict changes",
        named_by,
    ),
)
LINEAR = {q.name: q for q in _EVERY}
"""Every quantity of a steady motion by name."""
EVERY: Mapping[str, Question | LinearQuestion] = ChainMap(LINEAR, QUESTIONS)  # type: ignore[arg-type]
"""Every question by name, those of a motion first."""


def about_nearest(
    problem: LaunchProblem,
    subject: SceneSubject,
    law: Any,
    names: tuple[str, ...],
    horizon: float,
    only: str | None,
) -> Answer:
    """The answer to linear questions about the steady motion nearest to the start.

    `only` is the name of the one rung to run, or None for the choice; `horizon` is that of the
    scene, in the user's unit.
    """
    near = problem.launches.settling.closest(problem.start, problem.p)
    if not math.isfinite(near.distance):
        raise ParameterError(f"{near.evidence}: a linear question needs a steady motion.")
    launches = problem.launches
    kinds = {n: kind for n in names if (kind := LINEAR[n].kind(near.family)) is not None}
    sizes = {n: float(launches.size(kind)) for n, kind in kinds.items()}
    at = near.at * float(launches.size(named_by(near.family)))
    call = next(v.call for v in launches.settling.lines if v.name == near.family)
    arguments = {"body": subject.moving, "contact": law} | dict(call)
    member = SteadyMotion(arguments.pop("family"), at, arguments, subject.between)
    quantities: dict[str, Estimate] = {}
    rungs: list[Rung] = []
    taken, said = [], []
    for name in names:
        climbed, (quantities[name], reason) = _climb(
            member, name, problem.tolerance, sizes.get(name, 1.0), only
        )
        rungs += climbed
        taken.append(next(r.name for r in climbed if r.chosen))
        said.append(f"{name}: {reason}" if len(names) > 1 else reason)
    values = {n: q.value for n, q in quantities.items()}
    errors = {n: relative_error(q, sizes.get(n, 1.0)) for n, q in quantities.items()}
    where = f"{near.family} at {member.at:.6g}, {near.distance:.2g} away"
    return Answer(
        single(values),
        ", ".join(dict.fromkeys(taken)),
        single(errors),
        tuple(rungs),
        horizon,
        f"{where}: {'; '.join(said)}.",
        problem.tolerance,
        measures={n: (unit_of(launches, kind), sizes[n]) for n, kind in kinds.items()},
    )


def _climb(
    member: SteadyMotion, name: str, tolerance: float, unit: float, only: str | None
) -> tuple[list[Rung], tuple[Estimate, str]]:
    """The rungs of one question up to the first that is fine enough, and what that has found."""
    order = LINEAR[name].rungs
    if only is not None and only not in order:
        raise ParameterError(f"only is {only!r}; the rungs of {name} are {', '.join(order)}.")
    rungs: list[Rung] = []
    answer: tuple[Estimate, str] | None = None
    for rung in order if only is None else (only,):
        if answer is not None:
            rungs.append(Rung(rung, 0, 0.0, 0.0, math.inf, False, f"{name}: not needed"))
            continue
        began = time.perf_counter()
        quantity, why = LINEAR[name].find(member, rung == CERTIFIED)
        share = relative_error(quantity, unit) / tolerance
        fine = "fine enough" if share <= 1 else "not decided within the tolerance"
        done = share <= 1 or rung == order[-1] or only is not None
        cost = time.perf_counter() - began
        rungs.append(Rung(rung, 0, cost, 0.0, share, done, f"{name}: {fine}"))
        if done:
            answer = quantity, why
    assert answer is not None
    return rungs, answer
