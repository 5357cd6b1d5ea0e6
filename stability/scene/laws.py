"""Several laws of which none is certain: where their motions part, when, and by how much."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from itertools import combinations
from typing import Any

import numpy as np

from ..base.citation import cited, joined
from ..base.quantities import Kind
from ..base.types import Floats
from ..integrators.selection import works_of as integrators_cited
from .answer import Answer, single
from .inputs import SceneSubject
from .rungs.track import LaunchProblem, Track, relative
from .uncertain import apart as distance

SHOWN = 5
"""Pairs of laws that the sentence names."""


def compare(
    parts: Mapping[str, Answer],
    quantities: Sequence[str],
    horizon: float,
    tolerance: float,
    weights: Mapping[str, float],
) -> Answer:
    """The answers under each law, and where they part.

    Values and estimates are by law.  `apart` is the largest difference between two laws at the end
    of the time that they share, of a linear question that of its values, and infinite where a law
    has no answer.  The answer holds until two laws differ by more than the tolerance, or one answer
    no longer holds.
    """
    answered = {n: a for n, a in parts.items() if a.motion is not None}
    sentences, apart, until, same = [], 0.0, horizon, []
    plain = all(a.motion[0].launches.dimensionless for a in answered.values() if a.motion)
    unit = "" if plain else " s"
    for first, second in combinations(answered, 2):
        when, far = _parted(answered[first], answered[second], tolerance)
        apart = max(apart, far)
        if when is not None:
            until = min(until, when)
            sentences.append(
                f"{first} and {second} differ from {when:.4g}{unit} on, by {far:.3g} at the end"
            )
        else:
            same.append(f"{first} and {second} agree within the tolerance {tolerance:g}")
    lost = [f"{n}: {a.sentence.rstrip('.')}" for n, a in parts.items() if a.model == "none"]
    words = [*same, *sentences][:SHOWN]
    if not answered:  # linear questions
        words = [f"{n}: {a.sentence.rstrip('.')}" for n, a in parts.items() if a.model != "none"]
        apart = max((_different(*two) for two in combinations(parts.values(), 2)), default=0.0)
    elif len(answered) > 1 and not sentences:
        words = [f"all laws agree within the tolerance {tolerance:g}"]
    if lost:  # nothing is known of how far such a law is from the others
        apart = math.inf
    until = min([until, *(a.until for a in parts.values())])
    values = {n: _asked(a, quantities) for n, a in parts.items()}
    lost += _weighed(values, quantities, weights)
    return Answer(
        values,
        ", ".join(a.model for a in parts.values()),
        {n: a.estimate for n, a in parts.items()},
        (),
        until,
        "; ".join([*words, *lost]) + ".",
        tolerance,
        parts=parts,
        apart=apart,
    )


def _weighed(
    values: Mapping[str, Any], quantities: Sequence[str], weights: Mapping[str, float]
) -> list[str]:
    """The weight of each word, and the mean and deviation of each number, in words."""
    said = []
    for name in quantities:
        each = {n: v.get(name) if len(quantities) > 1 and v else v for n, v in values.items()}
        if all(isinstance(v, str) for v in each.values()):
            words: dict[str, float] = {}
            for n, v in each.items():
                words[v] = words.get(v, 0.0) + weights[n]
            listing = ", ".join(f"{v} {w:.0%}" for v, w in words.items())
            said.append(f"{name} by weight: {listing}")
        elif all(isinstance(v, float) for v in each.values()):
            mean = sum(weights[n] * v for n, v in each.items())
            spread = math.sqrt(sum(weights[n] * (v - mean) ** 2 for n, v in each.items()))
            said.append(f"{name} by weight: {mean:.4g} ± {spread:.2g}")
    return said


def _different(first: Answer, second: Answer) -> float:
    """The largest difference of the values of two linear answers, over 1 or their size."""
    pairs = [[a.value if isinstance(a.value, dict) else {"": a.value} for a in (first, second)]]
    return max((distance(a[n], b[n]) for a, b in pairs for n in a if n in b), default=0.0)


def _asked(answer: Answer, quantities: Sequence[str]) -> Any:
    """The value of what was asked for, without the path where it was not."""
    if not isinstance(answer.value, dict) or "path" in quantities:
        return answer.value
    return single({n: v for n, v in answer.value.items() if n != "path"})


def _parted(first: Answer, second: Answer, tolerance: float) -> tuple[float | None, float]:
    """Time from which two motions differ by more than the tolerance, and how far at the end.

    The time is None where they never do.  Two motions that end at different times part at the
    earlier end.
    """
    assert first.motion is not None
    assert second.motion is not None
    alike = first.motion[0].launches.model.states == second.motion[0].launches.model.states
    (s, a), (t, b) = (
        _states(*motion, angles=not alike) for motion in (first.motion, second.motion)
    )
    both = min(len(a), len(b))
    same = np.isclose(s[:both], t[:both], rtol=1e-9, atol=0)
    both = int(np.argmin(same)) if not same.all() else both
    far = relative(a[:both] - b[:both], a[:both])
    beyond = np.flatnonzero(far > tolerance)
    if beyond.size:
        return float(s[beyond[0]]), float(far[-1])
    if len(s) != len(t) or both < len(s):
        return float(min(s[-1], t[-1])), float(far[-1]) if both else math.inf
    return None, float(far[-1])


def _states(problem: LaunchProblem, track: Track, *, angles: bool) -> tuple[Floats, Floats]:
    """Times in the user's unit, and the dimensionless states that all laws share: no slip.

    `angles` says whether a motion along fixed axes is told in the angles, as under another law.
    """
    states = problem.launches.settling.read(track.states) if angles else track.states
    return track.times * float(problem.launches.size(Kind.TIME)), states[:, :-2]


def works_of(subject: SceneSubject, answer: Answer) -> str:
    """Keys of the works to cite: of the model, and of the rung that answered."""
    if answer.parts:
        return joined(part.citation for part in answer.parts.values())
    law = getattr(next(iter(subject.laws.values()), None), "name", None)
    return cited(
        "creep-1" if answer.model.startswith("creep") else law,
        model=subject.touches,
        methods=integrators_cited(answer.motion[1].methods if answer.motion else ()),
        eigenvalues=answer.model == "double precision",
        proofs=answer.model in ("certified", "exact roots"),
    )
