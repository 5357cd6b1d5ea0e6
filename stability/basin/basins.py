"""Which launch ends where: maps over starts and parameters, and random samples of launches."""

from __future__ import annotations

import math
import os
import warnings
from collections.abc import Callable, Mapping, Sequence
from concurrent.futures import Executor
from contextlib import ExitStack, suppress
from dataclasses import dataclass, replace
from functools import cached_property, partial
from inspect import signature
from types import SimpleNamespace
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike

from ..base.axis import Axis, AxisLike
from ..base.checks import whole_number
from ..base.errors import ParameterError, StabilityError, StabilityWarning, shown, warned
from ..base.types import Floats, Overwrite, Progress, fields_of
from ..base.verdict import CODES
from ..bodies.disk import Disk
from ..bodies.families import at_name
from ..bodies.resistance import Resistance
from ..bodies.round_body.body import Body
from ..boundary.changes import boundaries
from ..jobs.dask import check_pool, pool_of
from ..jobs.filling import fill, kept_on_stop
from ..jobs.pipeline import Counted, shared
from ..motion.gather import moving
from ..motion.result import Settings
from ..motion.starts import Starts
from ..spectra.spectrum import spectrum
from ..storage.chunks import Arrays, Block, Layout, Memory, Store, Variable, even_chunk
from ..storage.formats import ZARR, format_named
from ..storage.targets import place
from ..systems.family import Family
from ..systems.system import System
from .dataset import (
    arrays,
    attributes,
    blank,
    coordinates,
    lost,
    question,
    told_of_lost,
    variables,
    works,
)
from .launch_labels import LaunchLabels
from .launches import Launches, Steady, SystemLaunches, prepare, with_equilibria
from .outcomes import outcomes
from .refinement import refine
from .statistics.samples import DistributionLike, Independent, check_distribution, sample

if TYPE_CHECKING:
    import xarray


TILE, LARGE, PIECES = 4096, 16384, 64
"""Launches of a chunk, about: at least, at most, and so that a map has this many chunks.  The last
launches of a chunk run alone, so that large ones cost less."""
MOST_LEVELS = 20
"""Most halvings of a map's steps."""
MOST = 1_000_000_000
"""Most launches of a call."""
LINEAR = "linear_verdict"
"""Name of the coordinate."""
DIGITS = 12
"""Significant digits of a change of verdict, so that any machine writes the same bytes."""


@dataclass(frozen=True)
class Plan:
    """The launches of a call, cut into chunks."""

    launches: Launches
    """What is launched."""
    layout: Layout
    """The grid of chunks."""
    axes: tuple[Axis, ...] = ()
    """Axes of a map, the slowest first; none for a sample."""
    distribution: Any = None
    """Distribution of a sample; None for a map."""
    seed: int = 0
    """Seed of a sample."""

    __getstate__ = fields_of

    @cached_property
    def first(self) -> Starts:
        """One of the launches, for names and units."""
        return self.starts((0,) * len(self.layout.shape), slice(0, 1))

    @cached_property
    def arrays(self) -> tuple[Variable, ...]:
        """The arrays of the result, with the numbers of a sample that vary."""
        varied = self.launches.varied if self.distribution is not None else ()
        return variables(self.first) + tuple(
            Variable(n, "float64", np.nan, self.launches.label(self.first, n), coordinate=True)
            for n in varied
        )

    def points(self, block: Block, part: slice) -> dict[str, Floats]:
        """Values of the numbers that vary, for a part of the launches of a chunk."""
        where = self.layout.slices(block)
        if self.distribution is not None:
            first, stop, _ = part.indices(self.layout.count(block))
            first += where[0].start
            table = sample(self.distribution, first, where[0].start + stop - first, self.seed)
            return dict(zip(self.launches.varied, table.T, strict=True))
        values = [a.values[s] for a, s in zip(self.axes, where, strict=True)]
        grid = np.meshgrid(*values, indexing="ij")
        return {a.name: v.ravel()[part] for a, v in zip(self.axes, grid, strict=True)}

    def starts(self, block: Block, part: slice) -> Starts:
        """The launches of a part of a chunk, checked."""
        return self.launches.starts(self.points(block, part))


def _work(shared_plan: Callable[[], Plan], block: Block, part: slice) -> Arrays:
    """The arrays of a part of a chunk, for any thread or process."""
    plan = shared_plan()
    launches = plan.starts(block, part)
    columns = arrays(outcomes(launches, plan.launches.settings), launches)
    return columns | (plan.points(block, part) if plan.distribution is not None else {})


def basins(
    disk: Disk | Body | System | None = None,
    contact: Any = None,
    *,
    x: AxisLike | None = None,
    y: AxisLike | None = None,
    more: Sequence[AxisLike] = (),
    distribution: DistributionLike | None = None,
    count: int | None = None,
    seed: int = 0,
    held: Mapping[str, float] | None = None,
    family: str = "",
    theta: float | None = None,
    pole: Any = None,
    horizon: float,
    body: Body | Disk | None = None,
    resistance: Resistance | Sequence[Resistance] | None = None,
    families: Family | Sequence[Family] = (),
    box: Mapping[str, tuple[float, float]] | None = None,
    tolerance: float = Settings.tolerance,
    check: bool = Settings.check,
    settle: float = Settings.settle,
    flat: float = Settings.flat,
    max_steps: int = Settings.max_steps,
    max_seconds: float = Settings.max_seconds,
    levels: int = 0,
    store: str | os.PathLike[str] | None = None,
    overwrite: Overwrite = False,
    chunk: int | None = None,
    executor: Executor | str | None = None,
    workers: int | None = None,
    progress: Progress | None = None,
    **parameters: ArrayLike,
) -> xarray.Dataset:
    """Outcomes of launches over two or more numbers, or of a random sample of launches.

    Parameters
    ----------
    disk
        A `Disk`, a `Body` or a `System`; the dimensionless uniform disk when left out.
    contact
        As for `simulate`; None for a system.
    x, y, more
        Axes of a map as (name, low, high, n) or (name, low, high, n, "log"): states at the start
        (`theta`, `phi_dot`, …), numbers of the body (`k`) or of the law (`mu`), a system's states
        and parameters.  With `family` also `tilt` and the number that names its members.
    distribution, count, seed
        A random sample in place of axes: distributions by name (`Uniform`, `Normal`, `LogUniform`),
        or a `Ball`; the number of launches; and the seed.  Launch i of a seed is always the same,
        for names in the same order.
    held
        Other numbers by name.  States of a disk that are not named are 0; a system needs them all.
    family
        Family of the disk or body (rolling, spinning, tumbling; of a body also vertical): launches
        start near its member, with the axis tilted by `tilt` [rad], as by `launch`.
    theta, pole
        Of a body with `family`, as for `launch`: where it rolls if at several inclinations; the
        pole of vertical spin, 0 or "pi".
    horizon
        Last time [s]; for the dimensionless disk in units of √(R/g).
    body
        A `Body` or a `Disk`, in place of the first argument.
    resistance
        As for `simulate`, one number each; with it there is no linear verdict of `family`.
    families
        Families on which a system may settle; a disk and a body have their own.
    box
        Ends of a system's states, as for `System.equilibria`: the equilibria in it are found first,
        and launches may settle on them.  Where the axes are all states and `families` is left out,
        it is the box of the axes.
    tolerance
        Error allowed in one step, relative.
    check
        Whether each launch is run again at a tolerance 100 times looser, from a slightly changed
        start.  The difference is its `error`.  Where the two end differently, `simulate` with all
        its neighbours decides.
    settle
        Largest distance from a steady motion, dimensionless, at which a proof of settling is tried.
        A launch ends where the proof succeeds.
    flat
        Angle from 0 or π that counts as flat [rad].
    max_steps, max_seconds
        As for `simulate`.
    levels
        Halvings of the steps of a map where neighbours differ, for the borders between outcomes.
    store
        Folder of a Zarr store.  It holds every chunk that is finished, and the same call continues
        an interrupted one.  Without it the result is in memory.
    overwrite
        Whether a store that was made with other arguments may be replaced; "same": it may not, as
        False.  A store that the same call began is continued.
    chunk
        Launches of a chunk, about; a worker computes and writes one at a time.  4096 when left
        out, up to 16384 for more than 262144 launches.
    executor
        `threads`, `processes`, `dask` (a scheduler and workers on this machine), the address of a
        running scheduler, or any `concurrent.futures.Executor`.
    workers
        Number of workers; one for each core when left out.
    progress
        Called with (launches done, launches in all).
    **parameters
        Numbers of a law that is named (`contact="viscous", mu=0.3`), or of a system.

    Returns
    -------
    xarray.Dataset
        `outcome` (CF flags), `end_time`, `family` (CF flags), `member` and `member_error`, `error`,
        `steps` and `start_state` over the axes, or over `launch` for a sample.  Axes, held numbers
        and those of a sample are coordinates.  A start without contact has ended at time 0: *flat*,
        *no-contact* or *lift-off*.  With `levels`, the borders along `border_point`: `border_X` for
        each axis X, `border_curve` (which line), and the outcomes on both sides; they are computed
        after the map, and are added to the store when all are there.  Attributes hold units,
        settings and versions, and no date: the same call gives the same bytes.  A launch that ended
        its worker is *unresolved*, without a start; `lost` in the attributes has the numbers of
        such launches, row-major, and a `StabilityWarning` says them.

    Raises
    ------
    StabilityError
        In one sentence, if something is not accepted.

    Source: tests/basin/test_basins.py compares outcomes with `simulate`, and borders with an
    integrator that shares no code.

    Examples
    --------
    >>> import stability as st
    >>> outcomes = st.basins(contact="viscous", mu=0.3, family="spinning",
    ...                   x=("phi_dot", 1.0, 3.0, 3), y=("tilt", 0.1, 0.2, 2), horizon=200.0)
    >>> outcomes.outcome.dims, outcomes.outcome.values.tolist()
    (('tilt', 'phi_dot'), [[1, 1, 1], [1, 1, 1]])
    """
    plan = _plan(SimpleNamespace(**locals()))  # every argument by its name
    check_pool(executor, workers, progress)
    levels = whole_number("levels", levels, 0, MOST_LEVELS)
    if levels and len(plan.axes) != 2:
        raise ParameterError("levels refines a map over x and y alone; leave it out.")
    kept = run(plan, store, overwrite, executor, workers, progress, levels)
    numbers = lost(kept)
    if numbers:
        warned(f"{told_of_lost(numbers)}.")
    return kept.dataset().assign_attrs({"lost": list(numbers)} if numbers else {})


def planned(*arguments: Any, **named: Any) -> Plan:
    """The plan of a call of `basins`, from the same arguments and with the same errors.

    Parameters
    ----------
    *arguments, **named
        As for `basins`; where and how the launches run does not matter.

    Returns
    -------
    Plan
    """
    call = signature(basins).bind(*arguments, **named)
    call.apply_defaults()
    return _plan(SimpleNamespace(**call.arguments))


def _plan(asked: SimpleNamespace) -> Plan:
    """The plan of a call of `basins`, whose arguments are checked here."""
    mover, family, distribution = moving(asked.disk, asked.body), asked.family, asked.distribution
    axes: tuple[Axis, ...] = ()
    if distribution is None:
        axes = _axes(asked.x, asked.y, asked.more, family)
        names, shape = tuple(a.name for a in axes), tuple(a.count for a in axes)
    else:
        if asked.x is not None or asked.y is not None or asked.more:
            raise ParameterError("a sample has no axes; give a distribution, or x and y.")
        if asked.count is None:
            raise ParameterError("count is missing; give the number of launches of the sample.")
        if isinstance(distribution, Mapping):
            distribution = Independent({_named(n, family): d for n, d in distribution.items()})
        check_distribution(distribution)
        names = tuple(distribution.names)
        shape = (whole_number("count", asked.count, most=MOST),)
    if math.prod(shape) > MOST:
        raise ParameterError(f"{math.prod(shape):.3g} launches are asked; give at most {MOST:.0e}.")
    held = asked.held
    if isinstance(held, Mapping):
        held = {_named(n, family): v for n, v in held.items()}
    runs = "tolerance", "check", "settle", "flat", "max_steps", "max_seconds"
    launches = prepare(
        mover,
        asked.contact,
        names,
        held,
        asked.horizon,
        Settings(**{n: getattr(asked, n) for n in runs}),
        family=family,
        families=asked.families,
        box=asked.box,
        parameters=asked.parameters,
        theta=asked.theta,
        pole=asked.pole,
        resistance=asked.resistance,
    )
    if isinstance(launches, SystemLaunches) and not launches.families and asked.box is None:
        box = {a.name: (a.low, a.high) for a in axes}
        if set(box) == set(launches.system.states):
            with suppress(StabilityError):  # nothing asks for the equilibria by name
                launches = with_equilibria(launches, box)
    size = min(max(TILE, math.prod(shape) // PIECES), LARGE)
    size = size if asked.chunk is None else whole_number("chunk", asked.chunk, most=MOST)
    seed = whole_number("seed", asked.seed, least=0)
    layout = Layout(names if axes else ("launch",), shape, even_chunk(shape, size))
    if axes:
        launches.check_edges(axes)
    return Plan(launches, layout, axes, distribution, seed)


def _axes(x: Any, y: Any, more: Sequence[Any], family: str) -> tuple[Axis, ...]:
    """The axes of a map, the slowest first."""
    if x is None or y is None:
        raise ParameterError("x and y are missing; give two axes, or a distribution and count.")
    if not isinstance(more, (tuple, list)):
        raise ParameterError(f"more is {shown(more)}; give a list of further axes.")
    axes = []
    for axis, which in zip([*more, y, x], [*("more",) * len(more), "y", "x"], strict=True):
        parsed = Axis.of(axis, which)
        axes.append(replace(parsed, name=_named(parsed.name, family)))
    return tuple(axes)


def _named(name: Any, family: Any) -> Any:
    """A name; `at` is the number that names the members of a family."""
    return at_name(family) if isinstance(name, str) and name == "at" else name


def run(
    plan: Plan,
    store: Any,
    overwrite: Overwrite,
    executor: Any,
    workers: int | None,
    progress: Progress | None,
    levels: int = 0,
    later: int = 0,
) -> Store:
    """Fill the store of a plan, and refine the borders of its map.

    Parameters
    ----------
    plan
        The launches.
    store, overwrite, executor, workers, progress, levels
        As for `basins`.
    later
        Launches that are expected along borders, for the progress of the map.

    Returns
    -------
    Store
        The full store.
    """
    kept = store_of(plan, store, overwrite)
    with ExitStack() as stack:
        with kept_on_stop(kept, Counted(None, plan.layout.total)):  # workers may take seconds
            pool, number = stack.enter_context(pool_of(executor, workers))
            work = partial(_work, shared(plan, pool))
        report = progress and (lambda done, total: progress(done, total + later))
        fill(
            kept,
            work,
            blank=partial(blank, plan.arrays),
            executor=pool,
            workers=number,
            progress=report,
        )
        if levels:
            axes = plan.axes[1], plan.axes[0]
            order = replace(plan.launches, varied=tuple(a.name for a in axes))
            labels = LaunchLabels(order)
            refine(kept, labels, axes, levels, pool, number, progress)
    return kept


def store_of(plan: Plan, store: Any = None, overwrite: Overwrite = False) -> Store:
    """The store of a plan, in memory or in a folder: made, or as it is there.

    Parameters
    ----------
    plan
        The launches.
    store, overwrite
        As for `basins`.
    """
    some = plan.first
    more = (
        {} if plan.distribution is None else {"sample": repr(plan.distribution), "seed": plan.seed}
    )
    coords = coordinates(plan.launches, some, plan.axes)
    coords |= _linear_verdict(plan.launches, plan.axes)
    attrs = attributes(plan.launches, some, more)
    attrs["citation"] = works(some, linear=LINEAR in coords)
    if store is None:
        return Memory(plan.layout, plan.arrays, coords, attrs)
    about = question(plan.launches, some, more)
    about["axes"] = [[a.name, a.low, a.high, a.count, a.log] for a in plan.axes]
    chunks: Any = format_named(place(store), ZARR, "chunks").chunks
    kept: Store = chunks(store, plan.layout, plan.arrays, coords, attrs, about, overwrite=overwrite)
    return kept


def _linear_verdict(launches: Launches, axes: tuple[Axis, ...]) -> dict[str, Any]:
    """Verdict of the steady motions near which launches start, along the axis that names these.

    Verdicts are proved, so that any machine finds the same ones.

    Examples
    --------
    >>> import stability as st
    >>> outcomes = st.basins(contact="viscous", mu=0.3, family="spinning", horizon=1.0,
    ...                   x=("at", 1.0, 3.0, 2), y=("tilt", 0.1, 0.2, 2))
    >>> outcomes.linear_verdict.dims, outcomes.linear_verdict.values.tolist()
    (('phi_dot',), [2, 1])
    >>> outcomes.linear_verdict.attrs["changes"], outcomes.linear_verdict.attrs["zones"]
    ([2.0], [2, 1])
    """
    near = launches.steady(axes)
    if near is None:
        return {}
    try:
        spectra = spectrum(near.family, at=near.axis.values, certify=True, **near.call)
        changes, zones = _zones(near)
    except StabilityError:  # dry friction is not smooth at a member
        return {}
    attributes: dict[str, Any] = {
        "long_name": f"linear verdict of {near.words}",
        "flag_values": [int(c) for c in CODES.values()],
        "flag_meanings": " ".join(v.word for v in CODES),
    }
    if zones:
        attributes |= {"changes": changes, "zones": zones}
    return {LINEAR: (near.axis.name, np.asarray(spectra.codes, dtype=np.int8), attributes)}


def _zones(near: Steady) -> tuple[list[float], list[int]]:
    """Changes of verdict and the verdicts between them; none where a piece stays open."""
    axis = near.axis
    with warnings.catch_warnings():  # an open piece leaves out the zones, and nothing else
        warnings.simplefilter("ignore", StabilityWarning)
        crossings = boundaries(
            near.family, axis=("at", axis.low, axis.high, axis.count), **near.call
        )
    if not crossings.complete or not len(crossings):
        return [], []
    changes = [float(f"{p.value:.{DIGITS}g}") for p in crossings]
    ends = np.array([axis.low, *changes, axis.high])
    middles = (ends[1:] + ends[:-1]) / 2
    between = spectrum(near.family, at=middles, certify=True, **near.call)
    return changes, [int(c) for c in between.codes]
