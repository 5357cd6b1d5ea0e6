"""How far uncertain inputs move an answer, by the model that gave it."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from itertools import chain
from typing import Any

import numpy as np

from ..base.errors import DomainError
from ..motion.result import Outcome
from .ladder import Climbed
from .questions import QUESTIONS
from .rungs.sensitivities import nearby
from .rungs.track import LaunchProblem, Refused, Track, relative

VAIN_WORDS = "a tenth of what the uncertain inputs allow to know"
"""Why a tolerance is raised."""
VAIN = 0.5
"""Share of that at which a tolerance is called wasted."""
WASTED = 0.1
"""Share of the spread below which a finer model or tolerance is wasted."""
CHEAP = 0.02
"""Expected time of sensitivities that is always spent, also where displaced runs cost less [s]."""
SENSITIVITY, DISPLACED = "sensitivity from the graph", "displaced runs"
"""The two routes to how far an input moves the answer."""
GAVE_UP = Outcome.UNRESOLVED.word
"""Outcome of a run of which no more is known."""


@dataclass(frozen=True)
class Spread:
    """How far each uncertain input moves the answer, the others held."""

    inputs: Mapping[str, float]
    """Half-width of each input: relative for a parameter, absolute for a state."""
    moves: Mapping[str, Mapping[str, float]]
    """Largest change of each quantity, over 1 or its size, by quantity and input."""
    outcomes: Mapping[str, tuple[str, ...]]
    """Outcomes at the two ends of each input."""
    outcome: str
    """Outcome of the scene itself."""
    contrary: tuple[str, ...]
    """Inputs within whose uncertainty the outcome changes."""
    tolerance: float
    """Tolerance of the scene."""
    labels: Mapping[str, str]
    """Each input with its half-width and unit, in words."""
    routes: Mapping[str, str] = field(default_factory=dict)
    """How the numbers of each input were found: `sensitivity from the graph`, or `displaced runs`
    and why."""
    enough: str = ""
    """A cheaper model whose error is below a tenth of what the inputs move; empty for none."""

    @property
    def size(self) -> float:
        """The root of the sum of squares of all changes, the largest over the quantities."""
        every = [
            math.sqrt(sum(v**2 for v in moved.values() if math.isfinite(v)))
            for moved in self.moves.values()
        ]
        return max(every, default=0.0)

    @property
    def wasted(self) -> bool:
        """Whether the tolerance is finer than a tenth of what the inputs allow to know."""
        return self.tolerance < VAIN * WASTED * self.size

    @property
    def doubt(self) -> str:
        """Within which uncertainties the outcome changes, in words."""
        return (
            "the outcome is not determined by what is known: it changes within the uncertainty of "
            f"{' and of '.join(self.contrary)}"
        )

    def lines(self) -> list[str]:
        """The spread in words, one line for each fact."""
        lines = [
            f"  {self.labels[source]} moves {name} by {size:.2g}, over 1 or its size"
            for name, moved in self.moves.items()
            for source, size in moved.items()
            if math.isfinite(size)
        ]
        lines += [
            f"  {name}: not known, because runs are {GAVE_UP}"
            if GAVE_UP in {self.outcome, *chain(*self.outcomes.values())}
            else f"  {name}: {QUESTIONS[name].none}, at both ends of every uncertain input too"
            for name, moved in self.moves.items()
            if not moved
        ]
        ways = dict.fromkeys(self.routes.values())
        for way in ways:
            lines.append(f"  {', '.join(n for n, v in self.routes.items() if v == way)}: {way}")
        for source, words in self.outcomes.items():
            for sign, word in zip("-+", words, strict=True):
                if word != self.outcome:
                    label = self.labels[source].replace("±", sign)
                    lines.append(f"  {label} gives {word} in place of {self.outcome}")
        if self.contrary:
            lines.append(f"  {self.doubt}")
        elif self.wasted:
            lines.append(
                f"  a tolerance of {self.tolerance:g} is wasted: the inputs alone move the answer "
                f"by {self.size:.2g}, and {WASTED * self.size:.2g} is enough"
            )
        if self.enough and not self.contrary:
            lines.append(
                f"  the model is finer than is of use: the error of {self.enough} is below "
                f"{WASTED * self.size:.2g}, a tenth of what the inputs move"
            )
        return lines


Ask = Callable[[LaunchProblem], Climbed]
"""Function that answers another problem by the ladder."""
Move = Callable[[str, float], LaunchProblem]
"""(input, change) → the problem with it."""


def spread(
    inputs: Mapping[str, float],
    problem: LaunchProblem,
    climbed: Climbed,
    move: Move,
    ask: Ask,
    labels: Mapping[str, str],
) -> Spread:
    """How far each input moves the answer: by sensitivities, or by displaced runs.

    `inputs` are half-widths by name; `move` changes one, and `ask` answers the displaced problem.
    """
    case = _Case(problem, climbed)
    moves: dict[str, dict[str, float]] = {name: {} for name in case.base}
    outcomes, routes = {}, {}
    pairs = {name: _displaced(move, name, width) for name, width in inputs.items()}
    straight = case.straight(pairs)
    for name in inputs:
        ends = straight[name]
        routes[name] = SENSITIVITY
        if isinstance(ends, str):
            routes[name] = f"{DISPLACED}, because {ends}"
            ends = case.asked(pairs[name], ask)
        for quantity, (middle, *others) in ends.values.items():
            if middle is None and not any(other is not None for other in others):
                continue  # no value, with which nothing is moved
            moves[quantity][name] = max(apart(middle, other) for other in others)
        outcomes[name] = ends.words
    contrary = tuple(n for n, words in outcomes.items() if {*words} - {case.word, GAVE_UP})
    if case.word == GAVE_UP:
        contrary = ()
    record = Spread(
        dict(inputs), moves, outcomes, case.word, contrary, problem.tolerance, labels, routes
    )
    return replace(record, enough=_enough(climbed, record.size / problem.tolerance))


def _displaced(
    move: Move, name: str, width: float
) -> tuple[LaunchProblem | None, LaunchProblem | None]:
    """The problem at both ends of an input; None where the disk has no contact there."""
    ends: list[LaunchProblem | None] = []
    for sign in (-1.0, 1.0):
        try:
            ends.append(move(name, sign * width))
        except DomainError:
            ends.append(None)
    return ends[0], ends[1]


def _enough(climbed: Climbed, size: float) -> str:
    """A cheaper model whose error is below a tenth of the spread; empty where there is none."""
    chosen = next((r for r in climbed.rungs if r.chosen), None)
    if chosen is None or climbed.alone:
        return ""
    cheaper = climbed.rungs[: climbed.rungs.index(chosen)]
    return next((r.name for r in cheaper if r.estimate <= WASTED * size), "")


@dataclass(frozen=True, eq=False)
class _Ends:
    """What is found at both ends of an input."""

    values: dict[str, tuple[Any, Any, Any]]
    """Each quantity of the scene itself, and at both ends."""
    words: tuple[str, str]
    """Outcomes at both ends."""


class _Case:
    """The answer of a scene, of which inputs are displaced."""

    def __init__(self, problem: LaunchProblem, climbed: Climbed) -> None:
        assert climbed.track is not None
        self.problem, self.climbed, self.track = problem, climbed, climbed.track
        names = [n for n in climbed.estimates if n != "path" or len(climbed.estimates) == 1]
        values = {n: climbed.estimates[n].value for n in names}
        self.base = {n: v for n, v in values.items() if not isinstance(v, str)}
        self.word = _word(problem, climbed.track)

    def straight(
        self, pairs: Mapping[str, tuple[LaunchProblem | None, LaunchProblem | None]]
    ) -> dict[str, _Ends | str]:
        """Both ends of each input by sensitivities, or why they do not give them."""
        whole = {n: (a, b) for n, (a, b) in pairs.items() if a is not None and b is not None}
        out: dict[str, _Ends | str] = dict.fromkeys(pairs, "an end has no contact at the start")
        why = self._unable()
        if why or not whole:
            return out | dict.fromkeys(whole, why)
        chosen = next(r for r in self.climbed.rungs if r.chosen)
        seconds = max(CHEAP, 2 * len(whole) * chosen.price)
        exact = self.climbed.model == self.problem.launches.name
        tracks = nearby(
            self.problem, self.track, list(whole.values()), exact=exact, seconds=seconds
        )
        if isinstance(tracks, Refused):
            return out | dict.fromkeys(whole, tracks.why)
        base, ends = tracks
        for name, pair in zip(whole, ends, strict=True):
            out[name] = pair.why if isinstance(pair, Refused) else self._read(base, pair)
        return out

    def _unable(self) -> str:
        """Why no sensitivity is asked for; empty where one is."""
        if not self.climbed.share <= 1:
            return "the answer itself is not within the tolerance"
        end = self.track.finish
        if end is not None and not math.isfinite(end.error):
            return "the time of the end has no bound"
        return ""

    def _read(self, base: Track, pair: Any) -> _Ends | str:
        """The quantities of two displaced tracks, on the same elements as the middle."""
        values = {}
        for name in self.base:
            every = [(self.problem, base), *pair]
            estimates = [QUESTIONS[name].find(*motion) for motion in every]
            if len({estimate.value is None for estimate in estimates}) > 1:
                return f"{name} may appear or vanish"
            values[name] = tuple(estimate.value for estimate in estimates)
        words = _word(*pair[0]), _word(*pair[1])
        if set(words) != {self.word}:
            return "the outcome may change"
        return _Ends(values, words)

    def asked(self, pair: tuple[LaunchProblem | None, LaunchProblem | None], ask: Ask) -> _Ends:
        """Both ends of an input by displaced runs."""
        by_name, words = [], []
        for other in pair:
            climbed = None if other is None else ask(other)
            if other is None or climbed is None or climbed.track is None:
                by_name.append(dict.fromkeys(self.base))
                words.append("no contact at the start" if other is None else "no answer")
                continue
            by_name.append({n: climbed.estimates[n].value for n in self.base})
            words.append(_word(other, climbed.track))
        values = {n: (v, by_name[0][n], by_name[1][n]) for n, v in self.base.items()}
        return _Ends(values, (words[0], words[1]))


def _word(problem: LaunchProblem, track: Track) -> str:
    """The outcome of a track as a word."""
    return str(QUESTIONS["outcome"].find(problem, track).value)


def apart(value: Any, other: Any) -> float:
    """Distance of two values of a quantity, over 1 or their size.

    Values are numbers, arrays of states along the last axis, words or None.  The distance is
    infinite where one is missing, or two words differ.

    Examples
    --------
    >>> apart(2.0, 2.5), apart("moving", "moving"), apart(1.0, None)
    (0.25, 0.0, inf)
    """
    if value is None or other is None:
        return 0.0 if value is other else math.inf
    if isinstance(value, str):
        return 0.0 if value == other else math.inf
    if isinstance(value, float):
        return float(abs(value - other) / max(1.0, abs(value)))
    a, b = np.asarray(value, dtype=float), np.asarray(other, dtype=float)
    count = min(len(a), len(b)) if a.ndim > 1 else len(a)
    return float(np.max(relative(b[:count] - a[:count], a[:count])))
