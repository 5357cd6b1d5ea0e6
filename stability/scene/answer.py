"""The answer to a scene: its value, the model that gave it, its error, and every rung tried."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np

from ..base.quantities import Kind
from ..base.types import Record, content
from ..base.version import __version__
from ..motion.result import Outcome

if TYPE_CHECKING:
    import xarray

from .inputs import about, label, unit_of
from .ladder import Climbed, Rung
from .questions import QUESTIONS, UNKNOWN, Estimate, relative_error
from .rungs.full import kept_until
from .rungs.track import Finish, LaunchProblem, Track
from .uncertain import Spread, apart

FORMAT = "stability scene 1"
"""Mark of the motion of a scene."""


@dataclass(frozen=True, eq=False)
class Answer(Record):
    """What a scene is answered, by which model, and how well that is known.

    Source: the ladder of docs/explanation/scenes.md; errors against the full model: tests/scene.

    Examples
    --------
    >>> import stability as st
    >>> scene = st.Scene(contact=st.Viscous(3000.0), start={"theta": 1.3, "omega3": 2.0},
    ...                  horizon=20.0, tolerance=1e-6)
    >>> answer = scene.answer()
    >>> answer.model, answer.estimate < 1e-6, answer.until
    ('creep-1', True, 20.0)
    """

    value: Any
    """Value of the quantity; values by name where several were asked for."""
    model: str
    """Name of the rung that gave it; `none` where no rung could."""
    estimate: Any
    """Estimated error of the value, dimensionless, over 1 or its size; by name where several were
    asked for."""
    rungs: tuple[Rung, ...]
    """Every rung, in the order of its cost, with the reason why it was chosen or not."""
    until: float
    """Time until which the answer holds within the tolerance for the inputs as given, in the user's
    unit; `spread` says how far uncertain inputs move it."""
    sentence: str
    """The answer in words."""
    tolerance: float
    """Error that was allowed."""
    cost: float = field(default=0.0, compare=False)
    """Time that the answer took, the choice included [s]."""
    notes: tuple[str, ...] = ()
    """What happened on the way."""
    spread: Spread | None = None
    """How far the uncertain inputs alone move the answer; None where none were given."""
    true_error: Any = None
    """Largest difference from the full model at a fine tolerance; only after `verify`."""
    apart: float | None = None
    """Largest difference of two laws at the end of the time that they share; None for one law."""
    parts: Mapping[str, Answer] = field(default_factory=dict)
    """The answer under each law, where the scene has several."""
    setting: tuple[str, ...] = ()
    """The question in words: the body and its law, the start, the horizon, with units."""
    measures: Mapping[str, tuple[str, float]] = field(default_factory=dict)
    """Unit of each state and number, and the value at which its error begins to be relative."""
    citation: str = ""
    """Keys of the works to cite, for `stability.citation`."""
    motion: tuple[LaunchProblem, Track] | None = field(default=None, repr=False, compare=False)
    """The dimensionless problem and its track; None where there is no motion."""

    @cached_property
    def path(self) -> xarray.Dataset | None:
        """The motion, with units and an error at each time; None where there is none."""
        if self.motion is None:
            return None
        return dataset(*self.motion, self.model).assign_attrs(citation=self.citation)

    @property
    def chosen(self) -> Rung | None:
        """The rung that gave the answer."""
        return next((r for r in self.rungs if r.chosen), None)

    def __getstate__(self) -> dict[str, Any]:
        """The fields and the path, without the problem: its equations have no pickle."""
        return {**self.__dict__, "path": self.path, "motion": None}

    def _content(self) -> tuple[Any, ...]:
        return (*super()._content(), content(self.path))

    def __repr__(self) -> str:
        return f"<Answer by {self.model}: {self.sentence}>"

    def _values(self) -> list[str]:
        """The numbers and words of the answer, a line for each quantity."""
        asked = self.value if isinstance(self.value, dict) else {"": self.value}
        if "" not in asked and all(isinstance(v, float) for v in asked.values()):
            asked = {"": asked}
        lines = []
        for name, value in asked.items():
            label = f"{name}: " if name else ""
            if isinstance(value, dict):
                text = ", ".join(f"{n} = {self._with_unit(n, v, name)}" for n, v in value.items())
            elif isinstance(value, float):
                text = self._with_unit(name or next(iter(self.measures), ""), value, name)
            elif value is None or isinstance(value, str):
                text = value or ("none" if math.isfinite(self._error(name)) else "not known")
            else:
                continue  # a path
            lines.append(f"  {label}{text}")
        return lines

    def _with_unit(self, name: str, value: float, quantity: str) -> str:
        """A number with its unit."""
        return f"{self.number(name, value, quantity)} {self.measures.get(name, ('',))[0]}".strip()

    def number(self, name: str, value: float, quantity: str, most: int = 9) -> str:
        """A number of the answer, to the first digit that its error reaches.

        Parameters
        ----------
        name, value
            A state or quantity, and its value in the user's unit.
        quantity
            Name of the quantity that it belongs to.
        most
            Most digits.
        """
        if name not in self.measures:
            return f"{value:.{most}g}"
        size = max(self.measures[name][1], abs(value))
        return supported(value, self._error(quantity) * size, most)

    def _error(self, quantity: str) -> float:
        """The estimated error of a quantity."""
        size = self.estimate[quantity] if isinstance(self.estimate, dict) else self.estimate
        return float(size)

    def report(self) -> str:
        """The answer in words and numbers, and its ladder.

        Returns
        -------
        str
        """
        return "\n".join([*self.setting, *([""] if self.setting else []), self._body()])

    def _body(self) -> str:
        """The report without the question."""
        if self.parts:
            texts = [f"{name}: {part._body()}" for name, part in self.parts.items()]
            return "\n\n".join([self.sentence, *texts])
        ladder = self.ladder()
        return "\n".join([self.sentence, *self._values(), *([f"\n{ladder}"] if ladder else [])])

    def ladder(self) -> str:
        """The ladder as plain text: a line for each rung, the notes, and the uncertain inputs.

        Returns
        -------
        str
        """
        wide = max([20, *(len(r.name) for r in self.rungs)]) + 1
        head = f"{'rung':<{wide + 1}}{'states':>6}{'cost':>12}{'error/tol':>11}  why"
        lines = [head] if self.rungs else []
        before: Mapping[str, float] = {}
        for r in self.rungs:
            cost = f"{1e3 * r.cost:.2f} ms" if r.cost else "-"
            size = f"{r.estimate:.2g}" if math.isfinite(r.estimate) else "-"
            mark = "*" if r.chosen else " "
            lines.append(f"{mark}{r.name:<{wide}}{r.dimension:>6}{cost:>12}{size:>11}  {r.why}")
            if r.indicators and r.indicators != before:  # the closed forms share theirs
                before = r.indicators
                values = ", ".join(f"{n} {v:.3g}" for n, v in r.indicators.items())
                lines.append(f"{'':<{wide + 31}} {values}")
        once = [f"{1e3 * r.built:.0f} ms for {r.name}" for r in self.rungs if r.built > 1e-3]
        lines += [f"  built once, not in the costs: {', '.join(once)}"] if once else []
        lines += [f"  {note}" for note in self.notes]
        if self.spread is not None:
            lines += ["", *self.spread.lines()]
        return "\n".join(lines)


def supported(value: float, error: float, most: int = 9) -> str:
    """A number to the first digit that its error reaches, or two digits where that has no bound.

    Examples
    --------
    >>> supported(0.000252, 2.2e-4), supported(1.23456, 2e-3), supported(2.0, 0.0)
    ('0.0003', '1.235', '2')
    """
    if not math.isfinite(error):
        return f"{value:.2g}"
    if value == 0 or error == 0:
        return f"{value:.{most}g}"
    place = math.floor(math.log10(error))
    count = math.floor(math.log10(abs(value))) - place + 1
    return f"{value:.{min(count, most)}g}" if count > 0 else f"{value:.{max(0, -place)}f}"


def single(values: Mapping[str, Any]) -> Any:
    """The value of the one quantity that was asked for; by name where there are several."""
    return next(iter(values.values())) if len(values) == 1 else values


def _measures(problem: LaunchProblem, names: Iterable[str]) -> dict[str, tuple[str, float]]:
    """The unit and the size of 1 of each state, and of each number that was asked for."""
    launches, measures = problem.launches, {}
    kinds = {n: QUESTIONS[n].kind for n in names}
    states = launches.model.states if {"final", "path"} & set(names) else ()
    sizes = launches.states_in_units(np.ones((1, len(launches.model.states))))[0]
    for name, size in zip(states, sizes.tolist(), strict=False):
        measures[name] = label(about(launches, name)), size
    for name, kind in kinds.items():
        if kind is not None:
            measures[name] = unit_of(launches, kind), float(launches.size(kind))
    return measures


def tell(problem: LaunchProblem, climbed: Climbed, horizon: float) -> Answer:
    """The answer that a climb gives, in the user's units, as `horizon` is."""
    if climbed.track is None:
        name, said = climbed.rungs[-1].name, climbed.rungs[-1].why
        return Answer(
            None,
            "none",
            math.inf,
            climbed.rungs,
            0.0,
            f"{name} cannot answer: {said}.",
            problem.tolerance,
        )
    track, clock = climbed.track, float(problem.launches.size(Kind.TIME))
    values = {n: in_units(problem, n, estimate) for n, estimate in climbed.estimates.items()}
    if "path" in values:
        values["path"] = dataset(problem, track, climbed.model)
    lost = track.finish is not None and track.finish.kind in UNKNOWN
    errors = {
        n: math.inf if lost else relative_error(estimate)
        for n, estimate in climbed.estimates.items()
    }
    until = horizon if track.finish is None else float(track.finish.time) * clock
    if not climbed.share <= 1:
        until = min(until, kept_until(problem, track) * clock)
    return Answer(
        single(values),
        climbed.model,
        single(errors),
        climbed.rungs,
        until,
        _sentence(problem, climbed, until),
        problem.tolerance,
        notes=track.notes,
        measures=_measures(problem, climbed.estimates),
        motion=(problem, track),
    )


def _sentence(problem: LaunchProblem, climb: Climbed, until: float) -> str:
    word = problem.launches.unit("time")
    unit = "" if word == "1" else f" {word}"
    end = None if climb.track is None else climb.track.finish
    size = f"{climb.share:.2g} of the tolerance {problem.tolerance:g}"
    if climb.share <= 1:
        text = f"{climb.model} answers, with an estimated error of {size}"
        if end is not None:
            return f"{text}, until {until:.6g}{unit}: {end.kind}, {_ending(end)}."
        return f"{text}, to the horizon."
    why = f" ({end.kind}: {_ending(end)})" if end is not None else ""
    short = "has no bound" if math.isinf(climb.share) else f"is {climb.share:.3g} times that"
    who = climb.model if climb.alone else "No rung"
    verb = "misses" if climb.alone else "keeps"
    return (
        f"{who} {verb} the tolerance {problem.tolerance:g}: the error of {climb.model} {short} at "
        f"the horizon{why}; the answer holds until {until:.4g}{unit}."
    )


def _ending(end: Finish) -> str:
    """An early end in words: that of its outcome, or the reason of the run."""
    reason = next((o.value for o in Outcome if o.word == end.kind), "")
    if end.kind in ("lift-off", "flat"):
        return str(reason).split(": ", 1)[1]
    return end.evidence


def held_against(
    name: str, mine: tuple[LaunchProblem, Track], fine: tuple[LaunchProblem, Track]
) -> float:
    """The true error of a quantity of a track, against a finer one of the full model.

    A run that cannot be made finer is no truth of its own: then the error that it states counts.
    It is infinite where states are not those of the same time, or where the truth is not known.
    """
    coarse, truth = (QUESTIONS[name].find(*motion) for motion in (mine, fine))
    ends = [None if t.finish is None else t.finish.kind for _, t in (mine, fine)]
    if ends[1] in UNKNOWN or (ends[0] != ends[1] and not isinstance(coarse.value, str)):
        return math.inf
    far = apart(truth.value, coarse.value)
    return relative_error(truth) if far == 0 and truth.value is not None else far


def in_units(problem: LaunchProblem, name: str, estimate: Estimate) -> Any:
    """The value of a quantity in the user's units."""
    question = QUESTIONS[name]
    if estimate.value is None or isinstance(estimate.value, str):
        return estimate.value
    if question.name == "final":
        states = problem.launches.states_in_units(estimate.value[None])[0]
        return dict(zip(problem.launches.model.states, states.tolist(), strict=True))
    if question.name == "path":
        return None  # the dataset of the answer
    assert question.kind is not None
    return float(estimate.value) * float(problem.launches.size(question.kind))


def dataset(problem: LaunchProblem, track: Track, model: str) -> xarray.Dataset:
    """The track as a labelled dataset: states over time with units, and `error` at each time."""
    import xarray

    launches = problem.launches
    clock = float(launches.size(Kind.TIME))

    states = launches.states_in_units(track.states)
    names = launches.model.states
    variables: dict[str, Any] = {
        n: ("time", states[:, i], about(launches, n)) for i, n in enumerate(names)
    }
    variables["error"] = (
        "time",
        track.errors,
        {
            "long_name": "estimated error of the states, the largest, each over 1 or its own size",
            "units": "1",
        },
    )
    return xarray.Dataset(
        variables,
        {"time": ("time", track.times * clock, about(launches, "time"))},
        {
            "format": FORMAT,
            "title": f"{launches.model.title}, by the model {model}",
            "model": model,
            "tolerance": problem.tolerance,
            "source": launches.model.source,
            "stability_version": __version__,
            "Conventions": "CF-1.11",
        },
    )
