"""A scene: what is on the table, how well it is known, and how well it must be answered."""

from __future__ import annotations

import math
import time
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from importlib import import_module
from typing import Any

import numpy as np

from ..base.checks import one_number
from ..base.errors import DomainError, NameUnknownError, ParameterError, shown
from ..bodies.contact import Contact
from ..bodies.disk import Disk
from ..motion.starts import Starts, gather
from ..motion.system_starts import gather_system
from ..storage.files import atomic_write
from ..storage.targets import PICTURES, check_suffix, check_target
from ..systems.system import System
from .answer import Answer, dataset, in_units
from .ladder import Climbed, climb
from .laws import compare
from .questions import QUESTIONS
from .rungs.full import full
from .rungs.reduced import ReducedModel
from .rungs.track import MOST_SAMPLES, SPACING, Problem, relative
from .uncertain import Spread, spread

LOOSEST, TIGHTEST = 0.1, 1e-13
"""Range of a scene's tolerance."""
TRUTH = 1e-3
"""Tolerance of the full model in `verify`, over that of the scene."""
POINTS = 201
"""Samples of a path."""


@dataclass(frozen=True, eq=False)
class Scene:
    """A launch, the law that is taken for the truth, and what is asked of the motion.

    Parameters
    ----------
    disk
        The disk, dimensionless or SI; or a `System` of the user.
    contact
        The law that is taken for the truth.  A mapping of names to laws where none is certain.  For
        a system its parameters by name.
    start
        States by name, or six numbers, as for `simulate`.
    horizon
        Last time of interest [s, or √(R/g)].
    tolerance
        Error allowed: in each state over 1 or its size, in a time over 1 or its size, from 1e-13 to
        0.1.
    quantities
        Names: `final`, `path`, `outcome`, `settling_time`, `lift_off_time`, `largest_tilt`.
    uncertain
        Half-width of uncertain inputs by name: of k and of the law's parameters relative to their
        values, of the states in their own units.
    models
        Reduced models of a user's system, cheapest first.
    families
        Families of a user's system, near which its motion may be linear.

    Raises
    ------
    StabilityError
        In one sentence, if something is not accepted.

    Source: tests/scene holds every rung against the full model and high-precision motions.

    Examples
    --------
    >>> import stability as st
    >>> scene = Scene(start={"theta": 1.5706, "omega3": 1.2}, contact=st.Viscous(300.0),
    ...               horizon=1000.0, tolerance=1e-6)
    >>> scene.answer().model
    'linearised'
    """

    disk: Any = field(default_factory=Disk)
    """The disk, or a user's system."""
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
    models: Sequence[ReducedModel] = ()
    """Reduced models of a user's system."""
    families: Any = ()
    """Families of a user's system."""

    def __post_init__(self) -> None:
        tolerance = one_number("tolerance", self.tolerance)
        if not TIGHTEST <= tolerance <= LOOSEST:
            raise ParameterError(
                f"tolerance is {tolerance:g}; give one from {TIGHTEST:g} to {LOOSEST:g}."
            )
        horizon = one_number("horizon", self.horizon)
        if not 0 < horizon < math.inf:
            raise ParameterError(f"horizon is {horizon:g}; give a last time above 0.")
        names = (self.quantities,) if isinstance(self.quantities, str) else tuple(self.quantities)
        unknown = [n for n in names if n not in QUESTIONS]
        if unknown or not names:
            what = shown(unknown[0]) if unknown else "empty"
            raise NameUnknownError(f"quantities is {what}; known are {', '.join(QUESTIONS)}.")
        if self.start is None:
            raise ParameterError("start is missing; give the states by name, theta at least.")
        for name, value in (("tolerance", tolerance), ("horizon", horizon), ("quantities", names)):
            object.__setattr__(self, name, value)
        object.__setattr__(self, "uncertain", self._widths())
        self._refuse()

    def _widths(self) -> dict[str, float]:
        if not isinstance(self.uncertain, Mapping):
            raise ParameterError(
                f"uncertain is {shown(self.uncertain)}; give half-widths by name, such as "
                '{"mu": 0.2, "theta": 1e-3}.'
            )
        found = {}
        for name, width in self.uncertain.items():
            if name not in self._inputs():
                raise NameUnknownError(
                    f"uncertain names {shown(name)}; known are {', '.join(self._inputs())}."
                )
            size = one_number(f"uncertain {name}", width)
            if not 0 < size < math.inf:
                raise ParameterError(f"uncertain {name} is {size:g}; give a half-width above 0.")
            found[name] = size
        return found

    def _refuse(self) -> None:
        """Refuse what no model could take; a start without contact is an answer, not an error."""
        if isinstance(self.disk, System):
            return
        if self.models:
            raise ParameterError("models belong to a stability.System; leave them out.")
        for law in self._laws().values():
            if not isinstance(law, Contact):
                raise ParameterError(
                    f"contact is {shown(law)}; give a contact law, such as Viscous(0.3), or laws "
                    "by name."
                )

    def _laws(self) -> dict[str, Any]:
        several = isinstance(self.contact, Mapping) and not isinstance(self.disk, System)
        return dict(self.contact) if several else {"": self.contact}

    def _inputs(self) -> tuple[str, ...]:
        """Names of the inputs that may be uncertain."""
        from ..bodies.thin_disk.disk_equations import STATES

        if isinstance(self.disk, System):
            return (*self.disk.states, *self.disk.parameters)
        laws = [law for law in self._laws().values() if isinstance(law, Contact)]
        own = [n for law in laws for n in law.given]
        return tuple(dict.fromkeys((*STATES, "k", *own)))

    def _gathered(self, contact: Any, moved: Mapping[str, float]) -> Starts:
        """The launch, with some inputs changed."""
        disk, start, law = self.disk, self.start, contact
        if isinstance(disk, System):
            x, p = _table(start, disk.states), _table(law, disk.parameters)
            for name, by in moved.items():
                if name in x:
                    x[name] += by
                else:
                    p[name] *= 1 + by
            return gather_system(disk, p or None, x, self.horizon, self.families)
        if moved:
            start = _moved_start(start, moved)
            k = {"k": disk.k * (1 + moved["k"])} if "k" in moved else {}
            disk = replace(disk, **k)
            given = {n: v * (1 + moved.get(n, 0.0)) for n, v in law.given.items()}
            law = type(law)(**given)
        return gather(disk, law, start, self.horizon)

    def _problem(self, contact: Any, moved: Mapping[str, float] | None = None,
                 tolerance: float | None = None) -> Problem:  # fmt: skip
        launches = self._gathered(contact, moved or {})
        if launches.count != 1:
            raise ParameterError(
                f"the scene has {launches.count} launches; give one, and a scene for each."
            )
        last = self.horizon / float(launches.scales["time"])
        size = self.tolerance if tolerance is None else tolerance
        bare = Problem(launches, size, np.array([0.0, last]))
        count = POINTS if "path" in self.quantities else 2
        if any(QUESTIONS[n].whole for n in self.quantities):
            count = max(POINTS, int(last * bare.pace / SPACING))
            if count > MOST_SAMPLES:
                raise ParameterError(
                    f"the motion turns about {last * bare.pace:.3g} times up to the horizon, too "
                    "many for a whole path; ask for final, or for an earlier horizon."
                )
        return replace(bare, times=np.linspace(0.0, last, count))

    def answer(self, *, only: str | None = None) -> Answer:
        """The answer of the least model that is fine enough.

        Parameters
        ----------
        only
            Name of the one rung to run, whatever its error; the choice of the ladder if left out.

        Returns
        -------
        Answer
            With the model, its estimated error, and every rung of the ladder.
        """
        laws = self._laws()
        if len(laws) > 1:
            began, names = time.perf_counter(), tuple(dict.fromkeys((*self.quantities, "path")))
            parts = {
                name: replace(self, contact=law, quantities=names).answer()
                for name, law in laws.items()
            }
            told = compare(parts, self.quantities, self.horizon, self.tolerance)
            return replace(told, cost=time.perf_counter() - began)
        [law] = laws.values()
        began = time.perf_counter()
        try:
            problem = self._problem(law)
        except DomainError as error:
            return Answer(None, "none", math.inf, (), 0.0, f"No rung can answer: {error}",
                          self.tolerance, time.perf_counter() - began)  # fmt: skip
        found = climb(problem, self.quantities, tuple(self.models), only)
        told = self._told(problem, found)
        if self.uncertain:
            told = replace(told, spread=self._spread(law, found, problem))
        return replace(told, cost=time.perf_counter() - began)

    def _told(self, problem: Problem, found: Climbed) -> Answer:
        track, clock = found.track, float(problem.launches.scales["time"])
        values = {n: in_units(problem, n, one) for n, one in found.found.items()}
        errors = {n: one.error for n, one in found.found.items()}
        until = self.horizon if track.finish is None else track.finish.time * clock
        enough = next(r.estimate for r in found.rungs if r.chosen) <= 1
        if not enough:
            until = min(until, _held(problem) * clock)
        path = dataset(problem, track, found.model)
        if "path" in values:
            values["path"] = path
        one = len(values) == 1
        return Answer(
            next(iter(values.values())) if one else values, found.model,
            next(iter(errors.values())) if one else errors, found.rungs, until,
            self._sentence(problem, found, until, enough=enough), self.tolerance,
            notes=track.notes, path=path,
        )  # fmt: skip

    def _sentence(self, problem: Problem, found: Climbed, until: float, *, enough: bool) -> str:
        unit = "" if problem.launches.dimensionless else " s"
        chosen = next(r for r in found.rungs if r.chosen)
        text = f"{found.model} answers within {chosen.estimate:.2g} of the tolerance"
        end = found.track.finish
        if end is not None and enough:
            return f"{text}, until {until:.6g}{unit}: {end.kind}, {end.evidence}."
        if not enough:
            return (
                f"No rung answers within {self.tolerance:g}: the error of {found.model} is "
                f"{chosen.estimate:.3g} times that at the horizon; the answer holds until "
                f"{until:.4g}{unit}."
            )
        return f"{text}, to the horizon."

    def _spread(self, law: Any, found: Climbed, problem: Problem) -> Spread:
        base = {n: one.value for n, one in found.found.items() if not isinstance(one.value, str)}
        word = QUESTIONS["outcome"].find(problem, found.track).value

        def ask(name: str, by: float) -> tuple[dict[str, Any], str]:
            try:
                other = self._problem(law, {name: by})
            except DomainError:
                return dict.fromkeys(base), "no contact at the start"
            told = climb(other, self.quantities, tuple(self.models))
            values = {n: told.found[n].value for n in base}
            return values, str(QUESTIONS["outcome"].find(other, told.track).value)

        return spread(self.uncertain, base, word, ask, self.tolerance, _distance)

    def verify(self) -> Answer:
        """The answer, held against the full model at a much finer tolerance.

        Returns
        -------
        Answer
            With `true_error`: the largest difference at the samples, and by quantity.
        """
        told = self.answer()
        if told.model == "none" or told.parts:
            return told
        [law] = self._laws().values()
        problem = self._problem(law)
        fine = replace(problem, tolerance=max(1e-14, TRUTH * self.tolerance))
        truth = full(fine)
        mine = climb(problem, self.quantities, tuple(self.models))
        errors = {}
        for name, one in mine.found.items():
            other = QUESTIONS[name].find(fine, truth)
            errors[name] = _distance(name, other.value, one.value)
        whole = next(iter(errors.values())) if len(errors) == 1 else errors
        return replace(told, true_error=whole)

    def plot(self, path: Any = None, *, overwrite: bool = False, **options: Any) -> Any:
        """Draw cost against true error of every model of the scene.

        Parameters
        ----------
        path
            File to write, PNG, PDF or SVG; none is written if left out.
        overwrite
            Whether an existing file may be replaced.
        **options
            As for `stability.scene.chart.chart`: laws, progress.

        Returns
        -------
        matplotlib.figure.Figure
        """
        from .chart import chart

        if path is not None:
            path = check_target(check_suffix(path, PICTURES), overwrite=overwrite)
        # by name: figures are another room of the same floor, as a backend of plots
        figure = import_module("stability.figures.scene_chart").scene_figure(chart(self, **options))
        if path is not None:
            save = import_module("stability.figures.canvas").save_figure
            with atomic_write(path, overwrite=overwrite) as draft:
                save(figure, draft)
        return figure


def _table(given: Any, names: Sequence[str]) -> dict[str, float]:
    """Numbers by name, from a mapping or a sequence."""
    if given is None:
        return {}
    if isinstance(given, Mapping):
        return {n: float(v) for n, v in given.items()}
    return dict(zip(names, np.asarray(given, dtype=float).tolist(), strict=False))


def _moved_start(start: Any, moved: Mapping[str, float]) -> Any:
    from ..bodies.thin_disk.disk_equations import STATES

    if isinstance(start, Mapping):
        return {n: start.get(n, 0.0) + moved.get(n, 0.0) for n in {**start, **moved} if n in STATES}
    six = np.array(start, dtype=float)
    for i, name in enumerate(STATES[: len(six)]):
        six[i] += moved.get(name, 0.0)
    return six


def _distance(name: str, value: Any, other: Any) -> float:  # noqa: ARG001
    """Relative distance of two values of a quantity; infinite where one is missing or differs."""
    if value is None or other is None:
        return 0.0 if value is other else math.inf
    if isinstance(value, str):
        return 0.0 if value == other else math.inf
    if isinstance(value, float):
        return float(abs(value - other) / max(1.0, abs(value)))
    a, b = np.asarray(value, dtype=float), np.asarray(other, dtype=float)
    count = min(len(a), len(b)) if a.ndim > 1 else None
    a, b = (a, b) if count is None else (a[:count], b[:count])
    return float(np.max(relative(b - a, a)))


def _held(problem: Problem) -> float:
    """The time up to which the full model keeps the tolerance, by halving the horizon."""
    last = problem.last
    for _ in range(12):
        last /= 2
        short = replace(problem, times=np.array([0.0, last]))
        track = full(short)
        if track.finish is None and track.errors[-1] <= problem.tolerance:
            return last
    return 0.0
