"""A scene: what is on the table, how well it is known, and how well it must be answered."""

from __future__ import annotations

import math
import os
import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import InitVar, dataclass, field, replace
from importlib import import_module
from typing import Any

import numpy as np

from ..base.checks import flag, known, one_number
from ..base.errors import DomainError, NameUnknownError, ParameterError, listed, shown
from ..base.types import Overwrite, Record
from ..motion.gather import moving
from ..motion.result import Settings
from ..motion.simulate import check_flat
from ..storage.origin import origin_of
from ..storage.targets import PICTURES, check_suffix, check_target
from .answer import Answer, held_against, single, tell
from .inputs import SceneSubject, launched, scene_subject, setting, weights_of
from .ladder import Climbed, climb
from .laws import compare, works_of
from .linear import EVERY, LINEAR, about_nearest
from .questions import QUESTIONS, UNKNOWN
from .rungs.full import truth_of
from .rungs.near_steady import CLOSED_FORMS
from .rungs.reduced import ReducedModel
from .rungs.track import MOST_SAMPLES, SPACING, LaunchProblem
from .uncertain import VAIN_WORDS, WASTED, Spread, spread

LOOSEST, TIGHTEST = 0.1, 1e-13
"""Range of a scene's tolerance."""
POINTS = 201
"""Samples of a path."""


@dataclass(frozen=True, eq=False)
class Scene(Record):
    """A launch, the law that is taken for the truth, and what is asked of the motion.

    Parameters
    ----------
    disk
        The disk, dimensionless or SI; a `Body` with its own units; or a `System` of the user.
    contact
        The law that is taken for the truth, or its name or class, with its coefficient as `mu`.  A
        mapping of names to laws where none is certain.  For a system its parameters by name.
    start
        States by name, or six numbers, as for `simulate`.
    horizon
        Last time of interest [s, or √(R/g)].
    tolerance
        Error allowed, from 1e-13 to 0.1: in each state and time over 1 or its size, for a disk
        where m = R = g = 1, for a system in its own units.  Where its states are far below 1, write
        them in units in which they are near 1, or divide the tolerance by the size that counts.
    quantities
        Names: `final`, `path`, `outcome`, `settling_time`, `lift_off_time`, `fall_time` (time at
        which a disk lies within `flat` of flat), `largest_tilt`; or, of
        the steady motion nearest to the start, `verdict`, `growth_rate` and `boundary` (the nearest
        value of its own parameter at which the verdict changes).
    uncertain
        Half-width of uncertain inputs by name: of k or the body's numbers, of the law's parameters
        and of coefficients of resistances relative to their values, of the states in their own
        units.
    raise_tolerance
        Whether a tolerance finer than a tenth of what the uncertain inputs allow to know is raised
        to it.
    weights
        Weight of each of several laws by name, above 0; equal if left out.
    models
        Reduced models of a user's system, cheapest first.
    families
        Families of a user's system, near which its motion may be linear.
    resistance
        `RollingResistance`, `PivotingResistance` or `AirTorque`, or several of these, of a body or
        disk, under every law.
    flat
        Angle from the plane at which a body counts as flat, up to 0.1 rad.
    max_seconds
        Computing time after which a run of the full model gives up [s].
    mu
        Coefficient of a law that is given by its name or class.
    body
        A `Body`, or a `Disk`, in place of the first argument.

    Raises
    ------
    StabilityError
        In one sentence, if something is not accepted.

    Source: tests/scene holds every rung against the full model and high-precision motions.

    Examples
    --------
    >>> import stability as st
    >>> scene = st.Scene(start={"theta": 1.5706, "omega3": 1.2}, contact=st.Viscous(300.0),
    ...               horizon=1000.0, tolerance=1e-6)
    >>> scene.answer().model
    'linearised'
    """

    disk: Any = None
    """The disk, another body, or a user's system."""
    contact: Any = None
    """The law, laws by name, or parameters of a system."""
    start: Any = None
    """The states at time 0."""
    horizon: float = 0.0
    """Last time of interest."""
    tolerance: float = 1e-6
    """Error allowed."""
    quantities: Sequence[str] = ("final",)
    """Names of what is asked."""
    uncertain: Mapping[str, float] = field(default_factory=dict)
    """Half-width of each uncertain input."""
    raise_tolerance: bool = False
    """Whether a tolerance that the uncertain inputs make vain is raised."""
    weights: Mapping[str, float] = field(default_factory=dict)
    """Weight of each of several laws."""
    models: Sequence[ReducedModel] = ()
    """Reduced models of a user's system."""
    families: Any = ()
    """Families of a user's system."""
    resistance: Any = None
    """Resistances to rolling and turning."""
    flat: float = Settings.flat
    """Angle that counts as flat [rad]."""
    max_seconds: float = Settings.max_seconds
    """Computing time of a run [s]."""
    subject: SceneSubject = field(init=False, repr=False, compare=False)
    """What moves, and its laws, resolved once."""
    mu: InitVar[float | None] = None
    body: InitVar[Any] = None

    def __post_init__(self, mu: float | None, body: Any) -> None:
        subject = scene_subject(moving(self.disk, body), self.contact, mu, self.resistance)
        object.__setattr__(self, "subject", subject)
        object.__setattr__(self, "disk", subject.moving)
        object.__setattr__(self, "contact", subject.contact)
        tolerance = one_number("tolerance", self.tolerance)
        if not TIGHTEST <= tolerance <= LOOSEST:
            accepted = f"give one from {TIGHTEST:g} to {LOOSEST:g}"
            raise ParameterError(f"tolerance is {tolerance:g}; {accepted}.")
        horizon = one_number("horizon", self.horizon)
        if not 0 < horizon < math.inf:
            raise ParameterError(f"horizon is {horizon:g}; give a last time above 0.")
        if self.start is None:
            raise ParameterError(f"start is missing; give the states by name, {subject.needed}.")
        runs = Settings(flat=self.flat, max_seconds=self.max_seconds)
        runs.refuse()
        for name, value in (
            ("flat", runs.flat),
            ("max_seconds", runs.max_seconds),
            ("tolerance", tolerance),
            ("horizon", horizon),
            ("quantities", self._asked()),
            ("weights", weights_of(subject.laws, self.weights)),
            ("raise_tolerance", flag("raise_tolerance", self.raise_tolerance)),
            ("uncertain", self._widths(subject.inputs())),
            ("models", self._reduced()),
        ):
            object.__setattr__(self, name, value)

    def _asked(self) -> tuple[str, ...]:
        """Names of the quantities, checked."""
        quantities = self.quantities
        names = (quantities,) if isinstance(quantities, str) else quantities
        every = [n for n, q in EVERY.items() if self.subject.touches or not q.of_body]
        if not isinstance(names, Sequence) or not len(names):
            what = shown(quantities) if not isinstance(names, Sequence) else "empty"
            raise ParameterError(f"quantities is {what}; known are {', '.join(every)}.")
        for name in names:
            if not isinstance(name, str) or name not in EVERY:
                known("quantities", name, every)
        linear = [n for n in names if n in LINEAR]
        if linear and len(linear) < len(names):
            raise ParameterError(
                f"quantities is {listed(names)}, of a motion and of its linear part; ask for one "
                "kind in one scene."
            )
        for name in names:
            if name not in every:
                raise ParameterError(
                    f"quantities names {name}, which only a disk has; for a user's system ask for "
                    f"{listed(every, 'or')}."
                )
        return tuple(names)

    def _widths(self, inputs: Sequence[str]) -> dict[str, float]:
        """Half-widths of the uncertain inputs, checked."""
        if not isinstance(self.uncertain, Mapping):
            example = {inputs[-1]: 0.2, inputs[0]: 1e-3}
            raise ParameterError(
                f"uncertain is {shown(self.uncertain)}; give half-widths by name, such as "
                f"{example}."
            )
        widths = {}
        for name, width in self.uncertain.items():
            if name not in inputs:
                raise NameUnknownError(
                    f"uncertain names {shown(name)}; known are {', '.join(inputs)}."
                )
            size = one_number(f"uncertain {name}", width)
            if not 0 < size < math.inf:
                raise ParameterError(f"uncertain {name} is {size:g}; give a half-width above 0.")
            if size >= 1 and name not in self.subject.states:
                raise ParameterError(
                    f"uncertain {name} is {size:g}, which means {100 * size:g} %; give a share of "
                    "its value below 1, such as 0.2."
                )
            widths[name] = size
        return widths

    def _reduced(self) -> tuple[ReducedModel, ...]:
        """The reduced models, checked."""
        models = (self.models,) if isinstance(self.models, ReducedModel) else self.models
        if not isinstance(models, Sequence) or not all(isinstance(m, ReducedModel) for m in models):
            raise ParameterError(
                f"models is {shown(self.models)}; give a list of stability.ReducedModel."
            )
        for word, value in (("models", models), ("families", self.families)):
            empty = value is None or (isinstance(value, (tuple, list)) and not value)
            if self.subject.touches and not empty:
                raise ParameterError(
                    f"{word} belong to a stability.System; leave them out for a disk."
                )
        names = [*(m.name for m in models), *CLOSED_FORMS, *self.subject.rungs]
        double = [n for n in names if names.count(n) > 1]
        if double:
            raise ParameterError(f"two rungs are called {double[0]!r}; give each its own name.")
        return tuple(models)

    def _problem(self, law: Any, moved: Mapping[str, float] | None = None) -> LaunchProblem:
        """The dimensionless problem under one law, with some inputs changed."""
        launches = launched(self.subject, law, self.start, self.horizon, self.families, moved or {})
        if not moved:
            check_flat(launches, Settings(flat=self.flat))
        last = self.horizon / float(launches.units.time)
        bare = LaunchProblem(
            launches,
            self.tolerance,
            np.array([0.0, last]),
            flat=self.flat,
            max_seconds=self.max_seconds,
        )
        count = POINTS if "path" in self.quantities else 2
        if any(n in QUESTIONS and QUESTIONS[n].whole for n in self.quantities):
            turns = last * bare.pace
            if not turns / SPACING <= MOST_SAMPLES:
                about = f"about {turns:.3g}" if turns < math.inf else "more than 1e308"
                raise ParameterError(
                    f"the motion turns {about} times up to the horizon, too many to look at each; "
                    "ask for final, or for an earlier horizon."
                )
            count = max(POINTS, int(turns / SPACING))
        return replace(bare, times=np.linspace(0.0, last, count))

    def answer(self, *, only: str | None = None) -> Answer:
        """The answer of the least model that is fine enough.

        Parameters
        ----------
        only
            Name of the one rung to run, with any error: `steady`, `linearised`, `second-order`,
            `creep`, `rough`, `creep-1` …, the name of the law or of a reduced model; of a linear
            question `double precision`, `certified` or `exact roots`.  The choice of the ladder if
            left out.

        Returns
        -------
        Answer
            With the model, its estimated error, and every rung of the ladder.

        Raises
        ------
        StabilityError
            In one sentence, if something is not accepted.
        """
        began, laws = time.perf_counter(), list(self.subject.laws.values())
        if len(laws) > 1:
            return self._finished(self._compared(lambda alone: alone.answer(only=only)), began)
        return self._finished(self._answered(laws[0], only), began)

    def _finished(self, answer: Answer, began: float) -> Answer:
        """An answer with its question, its works and its cost."""
        return replace(
            answer,
            setting=setting(self.subject, self.start, self.horizon, self.tolerance),
            citation=works_of(self.subject, answer),
            cost=time.perf_counter() - began,
        )

    def _compared(self, answer: Callable[[Scene], Answer]) -> Answer:
        """The answers under several laws."""
        names = self.quantities
        if names[0] not in LINEAR:
            names = tuple(dict.fromkeys((*names, "path")))
        parts = {}
        for name, law in self.subject.laws.items():
            widths = self.subject.known(self.uncertain, law)
            alone = replace(self, contact=law, quantities=names, uncertain=widths, weights={})
            parts[name] = answer(alone)
        return compare(parts, self.quantities, self.horizon, self.tolerance, self.weights)

    def _answered(self, law: Any, only: str | None) -> Answer:
        """The answer under one law."""
        try:
            problem = self._problem(law)
        except DomainError as error:
            said = f"No rung can answer: {error}"
            return Answer(None, "none", math.inf, (), 0.0, said, self.tolerance)
        if self.quantities[0] in LINEAR:
            names = tuple(self.quantities)
            return about_nearest(problem, self.subject, law, names, self.horizon, only)
        climbed = climb(problem, self.quantities, tuple(self.models), only, measured=True)
        answer = tell(problem, climbed, self.horizon)
        if self.uncertain and climbed.track is not None:
            moved = self._spread(law, climbed, problem, only)
            doubt = f" But {moved.doubt}." if moved.contrary else ""
            answer = replace(answer, spread=moved, sentence=answer.sentence + doubt)
            if self.raise_tolerance and moved.wasted and only is None:
                enough = min(LOOSEST, WASTED * moved.size)
                coarse = replace(self, tolerance=enough, raise_tolerance=False)
                again = coarse._answered(law, only)
                why = f"the tolerance is raised from {self.tolerance:g} to {enough:.2g}"
                return replace(again, notes=(f"{why}: {VAIN_WORDS}", *again.notes))
        return answer

    def _spread(
        self, law: Any, climbed: Climbed, problem: LaunchProblem, only: str | None
    ) -> Spread:
        def move(name: str, by: float) -> LaunchProblem:
            return self._problem(law, {name: by})

        def ask(other: LaunchProblem) -> Climbed:
            return climb(other, self.quantities, tuple(self.models), only)

        labels = {n: self.subject.width_in_words(n, w) for n, w in self.uncertain.items()}
        return spread(self.uncertain, problem, climbed, move, ask, labels)

    def verify(self) -> Answer:
        """The answer, held against the full model at a much finer tolerance.

        Returns
        -------
        Answer
            With `true_error`: the difference of the values, over 1 or their size, by quantity where
            several were asked for; None for a linear question, whose rungs prove their errors.
        """
        if len(self.subject.laws) > 1:
            began = time.perf_counter()
            answer = self._finished(self._compared(Scene.verify), began)
            return replace(answer, true_error={n: a.true_error for n, a in answer.parts.items()})
        answer = self.answer()
        if answer.motion is None:
            return answer
        problem, track = answer.motion
        if track.finish is not None and track.finish.kind in UNKNOWN:  # no finer run knows more
            errors = dict.fromkeys(self.quantities, math.inf)
        else:
            truth = truth_of(problem)
            errors = {n: held_against(n, answer.motion, truth) for n in self.quantities}
        return replace(answer, true_error=single(errors))

    def plot(self, path: Any = None, *, overwrite: Overwrite = False, **options: Any) -> Any:
        """Draw cost against true error of every model of the scene.

        Parameters
        ----------
        path
            File to write, PNG, PDF or SVG; none is written if left out.
        overwrite
            Whether an existing file may be replaced; "same": if the same call wrote it.
        **options
            As for `stability.scene.chart.chart`: laws, progress.

        Returns
        -------
        matplotlib.figure.Figure
        """
        from .chart import chart

        asked = {"scene": self, "laws": options.get("laws")}
        if path is not None:
            path = check_suffix(path, PICTURES)
            check_target(path, overwrite=overwrite, origin=origin_of("Scene.plot", asked))
        # by name: figures are another room of the same floor, as a backend of plots
        dataset = chart(self, **options)
        figure = import_module("stability.figures.scene_chart").scene_figure(dataset)
        figure.remember("Scene.plot", asked, dataset.attrs["citation"])
        if path is not None:
            save = import_module("stability.figures.canvas").save_figure
            save(figure, path, overwrite=overwrite)
        return figure

    @classmethod
    def from_toml(cls, path: str | os.PathLike[str]) -> Scene:
        """The scene that a TOML file states.

        Parameters
        ----------
        path
            The file; `examples/scenes` shows its tables.

        Raises
        ------
        StabilityError
            In one sentence, if the file cannot be read, or states what is not accepted.

        Examples
        --------
        >>> import pathlib, stability as st
        >>> folder = pathlib.Path(st.__file__).parents[1] / "examples" / "scenes"
        >>> st.Scene.from_toml(folder / "spun-coin.toml").answer().model
        'linearised'
        """
        from .toml_file import read

        return cls(**read(path))
