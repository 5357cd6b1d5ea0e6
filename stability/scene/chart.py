"""Cost against true error: every rung of a scene, and other laws as models of its law."""

from __future__ import annotations

import json
import math
import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

import numpy as np

from ..base.errors import ParameterError, StabilityError, shown
from ..base.provenance import machine, today
from ..base.quantities import Units
from ..base.version import __version__
from ..bodies.contact_laws import Contact, Coulomb, LinearViscous, Rough, Smooth, Viscous
from .ladder import Climbed, climb
from .linear import LINEAR
from .rungs.creep import applies
from .rungs.drifting import DRIFT
from .rungs.full import truth_of
from .rungs.near_steady import CLOSED_FORMS, LINEARISED
from .rungs.track import LaunchProblem, Track, relative

if TYPE_CHECKING:
    import xarray

FORMAT = "stability chart scene 1"
"""Attribute `format` of a chart."""
KINDS = ("closed form", "reduced model", "creep", "full model", "other law")
"""Kinds of models."""
FINEST = 1e-14
"""Smallest tolerance of an order of creep."""
LOOSEST = 0.1
"""Largest error of an order of creep that is charted."""
JUST_ABOVE = 1.5
"""Tolerance over the error of an order of creep, so that this order is the lowest fine one."""
STIFF, DRY = 100.0, 0.3
"""Friction of a viscous law [√(1/(gR))] and of dry friction [-] where the scene states none."""
LEAST, MOST, BUDGET, LONG = 5, 20, 1.0, 4.0
"""Turns of repeats: least, most; time after which none begins, and none of the least [s]."""


@dataclass(frozen=True, eq=False)
class Row:
    """One model of a chart."""

    name: str
    """Its name."""
    kind: str
    """One of `KINDS`."""
    dimension: int = 0
    """Number of states that are integrated; 0 for a closed form."""
    call: Callable[[], Any] | None = None
    """Function that runs it; None for a model that does not apply."""
    first: float = 0.0
    """Time of its first run, what it compiles included [s]."""
    estimate: float = math.nan
    """Its own estimate of its error."""
    error: float = math.nan
    """Its true error; infinite where it ends in another way than the truth."""
    why: str = ""
    """Why it has no error, or an infinite one."""


def other_laws(units: Units, truth: Contact) -> dict[str, Contact]:
    """The laws of the package that may serve as models of another, by name.

    Parameters
    ----------
    units
        The units of the body.
    truth
        The law that is taken for the truth.

    Returns
    -------
    dict
        Viscous laws with the friction of the truth where it is viscous; a friction that is not
        known from the truth stands in the name [s/m; dry friction: -].

    Examples
    --------
    >>> list(other_laws(Units(), Viscous(300.0)))
    ['smooth', 'linear-viscous', 'rough', 'coulomb, mu = 0.3']
    """
    speed, weight = (float(np.ravel(v)[0]) for v in (units.speed, units.force))
    mu, word = STIFF / speed, f", mu = {STIFF / speed:.3g}"
    if isinstance(truth, Viscous | LinearViscous):
        parameters, word = truth.given, ""
        mu = float(
            np.ravel(parameters["mu"])[0]
            if "mu" in parameters
            else np.ravel(parameters["c"])[0] / weight
        )
    every: dict[str, Contact] = {
        "smooth": Smooth(),
        f"viscous{word}": Viscous(mu),
        "linear-viscous": LinearViscous(mu=mu),
        "rough": Rough(),
        f"coulomb, mu = {DRY:g}": Coulomb(DRY),
    }
    if word:  # next to a viscous law with an assumed friction, a second says nothing
        del every["linear-viscous"]
    return {n: law for n, law in every.items() if type(law) is not type(truth)}


def chart(
    scene: Any,
    laws: Mapping[str, Contact] | None = None,
    progress: Callable[[int, int], None] | None = None,
) -> xarray.Dataset:
    """Cost and true error of every model of a scene.

    Parameters
    ----------
    scene
        The `Scene`; of several laws the first is taken for the truth.
    laws
        Laws by name, charted as models of the truth; if left out the scene's further laws, or those
        of `other_laws`.
    progress
        Called with (models done, models in all).

    Returns
    -------
    xarray.Dataset
        Over (model | repeat): `seconds` of each repeat, `cost`, the least of them, `true_error`,
        `estimate`, `chosen`, `kind`, `why`; `tolerance`, `spread` by the uncertain inputs,
        `truth_error` and `answer_cost` are single numbers.  NaN marks a model that does not apply.

    Raises
    ------
    StabilityError
        In one sentence, if something is not accepted.

    Source: the truth is the full model at a tolerance 1000 times finer, as in `Scene.verify`, with
    which tests/scene/test_chart.py compares.

    Examples
    --------
    >>> import stability as st
    >>> scene = st.Scene(start={"theta": 1.5706, "omega3": 2.2}, contact=st.Viscous(0.3),
    ...                  horizon=20.0, tolerance=1e-6)
    >>> data = chart(scene, laws={"rough": st.Rough()})
    >>> data.model.values[data.chosen.values].tolist()
    ['linearised']
    """
    scene, laws = _single_law(scene, laws)
    if scene.quantities[0] in LINEAR:
        raise ParameterError("a linear question has no chart; ask for a quantity of the motion.")
    problem = scene._problem(scene.contact)
    others = _others(scene, problem, laws)
    if progress is not None and not callable(progress):
        raise ParameterError(f"progress is {shown(progress)}; give a function of (done, total).")
    _, truth = truth_of(problem)
    steps: list[Callable[[], Iterator[Row]]] = [
        lambda: _closed(scene, problem, truth),
        lambda: _reduced_rows(scene, problem, truth),
        lambda: _creep(scene, problem, truth),
        lambda: _full(scene, problem, truth),
        *(lambda n=n, law=law: _law(scene, problem, truth, n, law) for n, law in others.items()),
    ]
    rows: list[Row] = []
    for done, step in enumerate(steps, 1):
        rows += step()
        if progress is not None:
            progress(done, len(steps))
    return _dataset(scene, problem, truth, rows)


def _single_law(scene: Any, laws: Any) -> tuple[Any, Any]:
    """A scene of one law, the first of several, and the laws to hold against it."""
    (_, truth), *rest = scene.subject.laws.items()
    if not rest:
        return scene, laws
    bare = replace(scene, contact=truth, uncertain={}, weights={})
    widths = scene.subject.known(scene.uncertain, truth)
    return replace(bare, uncertain=widths), dict(rest) if laws is None else laws


def _others(scene: Any, problem: LaunchProblem, laws: Any) -> dict[str, Contact]:
    """The other laws, checked."""
    if laws is None:
        return other_laws(problem.launches.units, scene.contact) if problem.touches else {}
    if not isinstance(laws, Mapping):
        raise ParameterError(
            f'laws is {shown(laws)}; give contact laws by name, such as {{"rough": Rough()}}.'
        )
    if laws and not problem.touches:
        raise ParameterError("laws belong to a disk or a body; leave them out for a system.")
    for name, law in laws.items():
        if not isinstance(name, str) or not isinstance(law, Contact):
            raise ParameterError(
                f"laws has {shown(name)}: {shown(law)}; give a name and a contact law."
            )
    return dict(laws)


# --- rows ---


def _timed(calls: Sequence[Callable[[], Any]], firsts: Sequence[float]) -> list[list[float]]:
    """Times of repeats of calls, in turns, so that a busy machine hits all alike.

    `firsts` are the times of the first calls, which compile and are not counted.
    """
    times: list[list[float]] = [[] for _ in calls]
    began = time.perf_counter()
    for turn in range(MOST):
        spent = time.perf_counter() - began
        if spent > LONG or (turn >= LEAST and spent > BUDGET):
            break
        for call, first, mine in zip(calls, firsts, times, strict=True):
            if not mine or first < LONG / 2:
                start = time.perf_counter()
                call()
                mine.append(time.perf_counter() - start)
    return times


def _row(
    scene: Any, problem: LaunchProblem, truth: Track, kind: str, only: str, *, name: str = ""
) -> Row:
    """A model, run alone."""

    def call() -> Climbed:  # a copy of the problem, which keeps what it has computed
        return climb(replace(problem), scene.quantities, tuple(scene.models), only)

    began = time.perf_counter()
    climbed = call()
    first = time.perf_counter() - began
    if climbed.track is None:
        refused = climbed.rungs[-1]
        return Row(name or only, kind, refused.dimension, why=refused.why)
    rung = next(r for r in climbed.rungs if r.name == climbed.model)
    error, why = true_error(climbed.track, truth)
    estimate = math.nan if name else climbed.track.error  # of the states, as the true error
    return Row(name or climbed.model, kind, rung.dimension, call, first, estimate, error, why)


def true_error(mine: Track, truth: Track) -> tuple[float, str]:
    """The largest relative error of a track's states at the samples, for tracks `mine` and `truth`.

    Infinite, with the reason in words, where the two end in different ways.
    """
    ends = [None if t.finish is None else t.finish.kind for t in (mine, truth)]
    if ends[0] != ends[1]:
        endings = [
            "the motion lasts" if t.finish is None else f"{t.finish.kind} at {t.finish.time:.4g}"
            for t in (mine, truth)
        ]
        return math.inf, f"{endings[0]}; truly, {endings[1]}"
    if mine.finish is not None and truth.finish is not None:
        late = abs(mine.finish.time - truth.finish.time) / max(1.0, truth.finish.time)
    else:
        late = 0.0
    both = min(np.sum(t.times < t.times[-1]) for t in (mine, truth))
    far = np.concatenate(
        [
            relative(a - b, b)
            for a, b in (
                (mine.states[:both], truth.states[:both]),
                (mine.states[-1:], truth.states[-1:]),
            )
        ]
    )
    return max(late, float(far.max())), ""


def _closed(scene: Any, problem: LaunchProblem, truth: Track) -> Iterator[Row]:
    """The closed forms near a steady motion, and the drift where there is one."""
    for name in (LINEARISED,) if problem.launches.dry else (*CLOSED_FORMS, DRIFT):
        row = _row(scene, problem, truth, KINDS[0], name)
        if name != DRIFT or row.call is not None:
            yield row


def _reduced_rows(scene: Any, problem: LaunchProblem, truth: Track) -> Iterator[Row]:
    """The reduced models of a user's system."""
    for model in scene.models:
        yield _row(scene, problem, truth, KINDS[1], model.name)


def _creep(scene: Any, problem: LaunchProblem, truth: Track) -> Iterator[Row]:
    """Orders of creep: lower ones, each at its own error, the lowest fine one, and the next."""
    kind = KINDS[2]
    if not applies(problem):
        return
    climbed = climb(problem, scene.quantities, (), "creep")
    sizes = {r.name: r.estimate * problem.tolerance for r in climbed.rungs}
    if climbed.track is None:
        yield Row("creep", kind, climbed.rungs[-1].dimension, why=climbed.rungs[-1].why)
        return
    done = {climbed.model}
    for size in (e for n, e in sizes.items() if n != climbed.model and e <= LOOSEST):
        coarse = replace(problem, tolerance=max(JUST_ABOVE * size, problem.tolerance))
        row = _row(scene, coarse, truth, kind, "creep")
        if row.name not in done:
            done.add(row.name)
            yield row
    row = _row(scene, problem, truth, kind, "creep")
    yield row
    if row.estimate > FINEST * 1e2:
        fine = replace(problem, tolerance=max(FINEST, row.estimate / 10))
        further = _row(scene, fine, truth, kind, "creep")
        if further.name not in done:
            yield further


def _full(scene: Any, problem: LaunchProblem, truth: Track) -> Iterator[Row]:
    """The full model at the tolerance of the scene."""
    yield _row(scene, problem, truth, KINDS[3], problem.launches.name)


def _law(
    scene: Any, problem: LaunchProblem, truth: Track, name: str, law: Contact
) -> Iterator[Row]:
    """Another law in place of the truth."""
    first, comma, rest = name.partition(",")
    title = f"{first} law{comma}{rest}"
    try:
        other = replace(scene, contact=law, uncertain={})._problem(law)
    except StabilityError as error:
        yield Row(title, KINDS[4], why=str(error).rstrip("."))
        return
    if other.launches.model.states != problem.launches.model.states:
        yield Row(title, KINDS[4], why="its motion has other states than that of the truth")
        return
    other = replace(other, times=problem.times)
    yield _row(scene, other, truth, KINDS[4], other.launches.name, name=title)


# --- dataset ---


def _dataset(scene: Any, problem: LaunchProblem, truth: Track, rows: list[Row]) -> xarray.Dataset:
    import xarray

    answer, bare = scene.answer(), replace(scene, uncertain={})
    runs = [r for r in rows if r.call is not None]
    calls = [r.call for r in runs if r.call is not None]
    times = _timed([*calls, bare.answer], [*(r.first for r in runs), bare.answer().cost])
    seconds = np.full((len(rows), max(map(len, times))), np.nan)
    for row, mine in zip(runs, times, strict=False):
        seconds[rows.index(row), : len(mine)] = mine
    least = [min(t[~np.isnan(t)], default=math.nan) for t in seconds]
    chosen = [r.name == answer.model and r.kind != KINDS[4] for r in rows]
    spread = math.nan if answer.spread is None else answer.spread.size

    def numbers(of: Callable[[Row], Any], **attributes: str) -> Any:
        return ("model", [of(r) for r in rows], attributes)

    data: dict[str, Any] = {
        "seconds": (
            ("model", "repeat"),
            seconds,
            {"long_name": "time of each repeat, the estimate of the error included", "units": "s"},
        ),
        "cost": ("model", least, {"long_name": "least time of the repeats", "units": "s"}),
        "true_error": numbers(lambda r: r.error, units="1", long_name=_what(scene)),
        "estimate": numbers(
            lambda r: r.estimate,
            units="1",
            long_name="the model's own estimate of its error; not known for another law",
        ),
        "dimension": numbers(
            lambda r: r.dimension, units="1", long_name="number of states that are integrated"
        ),
        "chosen": ("model", chosen, {"long_name": "whether the scene is answered by it"}),
        "why": numbers(lambda r: r.why, long_name="why it has no error, or an infinite one"),
        "tolerance": ((), scene.tolerance, {"long_name": "error allowed", "units": "1"}),
        "spread": (
            (),
            spread,
            {"long_name": "how far the uncertain inputs alone move the answer", "units": "1"},
        ),
        "truth_error": (
            (),
            float(truth.errors[-1]),
            {"long_name": "estimated error of the truth", "units": "1"},
        ),
        "answer_cost": (
            (),
            min(times[-1]),
            {"long_name": "time of the answer, choice and labels included", "units": "s"},
        ),
    }
    coordinates = {"model": [r.name for r in rows], "kind": ("model", [r.kind for r in rows])}
    return xarray.Dataset(data, coordinates, _attributes(scene, problem, answer))


def _what(scene: Any) -> str:
    where = "along the path" if "path" in scene.quantities else "at the samples up to the horizon"
    return f"largest error of the states {where}, each over 1 or its own size"


def _attributes(scene: Any, problem: LaunchProblem, answer: Any) -> dict[str, Any]:
    launches = problem.launches
    states = zip(launches.model.states, launches.states_in_units(launches.starts)[0], strict=True)
    numbers = {n: float(np.ravel(v)[0]) for n, v in launches.given.items()}
    if launches.dimensionless:  # units of the body
        numbers = {
            n: v for n, v in numbers.items() if n not in ("mass", "radius", "length", "gravity")
        }
    return {
        "format": FORMAT,
        "title": f"models of {launches.model.title}: cost against true error",
        "law": problem.launches.name,
        "horizon": scene.horizon,
        "time_unit": launches.unit("time"),
        "quantities": ", ".join(scene.quantities),
        "uncertain": ", ".join(
            scene.subject.width_in_words(n, v) for n, v in scene.uncertain.items()
        ),
        "parameters": json.dumps(numbers),
        "start": json.dumps({n: float(v) for n, v in states}),
        "sentence": answer.sentence,
        "truth": "the full model at a tolerance 1000 times finer",
        "citation": answer.citation,
        "machine": json.dumps(machine()),
        "created": today(),
        "source": launches.model.source,
        "stability_version": __version__,
        "Conventions": "CF-1.11",
    }
