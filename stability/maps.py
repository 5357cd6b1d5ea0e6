"""Parameter grids: abscissa and verdict over two axes, with the boundaries between verdicts."""

from __future__ import annotations

import os
from collections.abc import Callable, Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .boxes import MOST_LEVELS, prove_boxes
from .cells import Cells, Parts
from .changes import along
from .checks import MOST_WORKERS, callback, flag, whole_number
from .contact import LAWS, Contact, LinearViscous, Viscous
from .crossings import Boundaries
from .curves import trace
from .disk import Disk
from .errors import NameUnknownError, ParameterError, shown
from .families import Family
from .grid import Grid
from .problem import PHYSICAL, Problem, check_axis, disk_roundings, disk_units
from .query import problem as make_problem
from .steady import AT

if TYPE_CHECKING:
    import xarray

Floats = NDArray[np.float64]
Progress = Callable[[int, int], None]
Axis = tuple[str, float, float, int] | tuple[str, float, float, int, str]

MOST_CELLS = 100_000_000
"""Largest map in memory."""
MOST_SCAN = 1_000_000
"""Most points of a scan for boundaries along an axis."""

RESERVED = ("abscissa", "abscissa_error", "frequency", "verdict", "eigenvalues", "mode",
            "complex_part", "box", "end")  # fmt: skip
"""Variables and dimensions of every map, which no axis may be called."""


def stability_map(
    family: str | Family,
    *,
    x: Axis,
    y: Axis,
    disk: Disk | None = None,
    contact: Contact | type[Contact] | None = None,
    at: ArrayLike | None = None,
    certify: bool = False,
    levels: int | None = None,
    boundaries: bool = True,
    modes: bool = False,
    workers: int | None = None,
    progress: Progress | None = None,
    checkpoint: str | os.PathLike[str] | None = None,
    **parameters: ArrayLike,
) -> xarray.Dataset:
    """Abscissa, verdict and the boundaries between verdicts over two parameters.

    Parameters
    ----------
    family
        Name of a disk's family, or a `Family`.
    x, y
        Axes as (name, low, high, n) or (name, low, high, n, "log"): any two of `at`, `k`, `mu`,
        `mass`, `radius`, `gravity`; `lean` for tumbling, `theta`, `phi_dot` for circling and
        precession; for a `Family`, its own names.
    disk, contact, at
        The rest, as for `spectrum`.  An axis takes the place of the value given here; where `mu` is
        an axis, contact may be left out (viscous) or be the class of a law.
    certify
        Whether whole boxes of the map are proved too, with the boundary enclosed in a strip of
        narrow ones, and every cell that double precision leaves open is decided in balls.
    levels
        How often the map may be halved for that; as fine as the cells when left out.
    boundaries
        Whether to find the boundary curves.
    modes
        Whether to keep all eigenvalues (complex, dimension `mode`).
    workers
        Threads; all processors when left out.
    progress
        Called with (cells done, cells in all) now and then.
    checkpoint
        Folder in which finished cells are kept, so that the same call goes on where an interrupted
        one stopped; it may be removed afterwards.
    **parameters
        For a `Family`: its fixed parameters by name.

    Returns
    -------
    xarray.Dataset
        Dimensions and coordinates named like the axes, y first.  Variables: `abscissa`,
        `abscissa_error` (a bound), `frequency` (of the eigenvalue with the largest real part),
        `verdict` (CF flags); along `boundary_point`: `boundary_X` for each axis X,
        `boundary_error`, `boundary_axis` (along which the error is meant), `boundary_kind`,
        `boundary_frequency`, `boundary_curve` (which polyline); if certified, along `box`: `box_X`
        (low and high end) and `box_verdict` (proved on all of the box, 0 in the strip).
        Attributes hold units, versions, parameters, method and tolerances.

    Raises
    ------
    StabilityError
        One sentence that says what is wrong and what is accepted.

    Source: every number has an independent oracle in tests/test_maps.py.

    Examples
    --------
    >>> import stability as st
    >>> m = st.stability_map("spinning", x=("at", 1, 4, 7), y=("mu", 0.1, 2, 5))
    >>> m.abscissa.dims, m.abscissa.shape
    (('mu', 'at'), (5, 7))
    """
    certify, boundaries = flag("certify", certify), flag("boundaries", boundaries)
    modes = flag("modes", modes)
    if levels is not None and not certify:
        raise ParameterError("levels goes with certify=True; leave it out or certify.")
    if levels is not None:
        levels = whole_number("levels", levels, 0, MOST_LEVELS)
    check_run(workers, progress)
    axes = Grid.of(x, "x"), Grid.of(y, "y")
    if (total := axes[0].count * axes[1].count) > MOST_CELLS:
        raise ParameterError(
            f"the map has {total:.3g} cells, at most {MOST_CELLS:.0e} are kept in memory; take "
            "fewer points, or stream_map (`--verdict-only`), which writes a file."
        )
    question = prepare(family, axes, disk, contact, at, parameters)
    cells = Cells(question, axes, modes)
    parts = Parts(checkpoint, cells.key()) if checkpoint is not None else None
    cells.fill(workers or os.cpu_count() or 1, progress, parts)
    from .dataset import assemble

    boxes = None
    if certify:
        finest = (max(g.count for g in axes) - 1).bit_length()
        boxes = prove_boxes(question, axes, min(finest, 12) if levels is None else levels)
        cells.settle()
    curves = trace(question, axes, cells.codes, cells.abscissa, progress) if boundaries else None
    return assemble(question, axes, cells, curves, boxes)


def check_run(workers: Any, progress: Any) -> None:
    """Refuse a number of workers or a progress function that cannot be.

    Parameters
    ----------
    workers
        A whole number of at least 1, or None.
    progress
        A function of two numbers, or None.

    Raises
    ------
    ParameterError
        With the value.
    """
    if workers is not None:
        whole_number("workers", workers, most=MOST_WORKERS)
    callback(progress)


def boundaries(
    family: str | Family,
    *,
    axis: Axis,
    disk: Disk | None = None,
    contact: Contact | None = None,
    at: ArrayLike | None = None,
    **parameters: ArrayLike,
) -> Boundaries:
    """Every change of verdict along one axis, proved, with what crosses there.

    For the disk, and for a user's family whose graph is rational in the axis, every real root of
    every condition is isolated exactly, so that the result is complete.  Any other family is
    scanned; the result then says what it could not exclude, and a `StabilityWarning` repeats it.

    Parameters
    ----------
    family, disk, contact, at, **parameters
        As for `stability_map`, everything but the axis a single number; where the axis is one of
        circling's theta and phi_dot, `at` is the other.
    axis
        (name, low, high, n) or (name, low, high, n, "log"); both ends belong to it.  n is the
        number of points of the scan, where there is one.

    Returns
    -------
    Boundaries
        A sequence of `BoundaryPoint` in increasing order, with `.complete` (whether these are
        proved to be all) and `.unresolved` (pieces of the axis, each with a reason).

    Raises
    ------
    StabilityError
        One sentence that says what is wrong and what is accepted.

    Warns
    -----
    StabilityWarning
        If the search was not complete.

    Source: published thresholds in tests/test_published.py; all roots counted by another route in
    tests/test_boundaries.py.

    Examples
    --------
    >>> import stability as st
    >>> found = st.boundaries("spinning", axis=("at", 0.1, 5, 9), contact=st.Viscous(0.97))
    >>> [(round(b.value, 10), b.crossing.word) for b in found], found.complete
    ([(2.0, 'static'), (2.0451355787, 'flutter')], True)
    """
    grid = Grid.of(axis, "axis", most=MOST_SCAN)
    question = prepare(family, (grid,), disk, contact, at, dict(parameters))
    found = along(question, grid.name, grid.low, grid.high, points=grid.count, log=grid.log)
    found.warn(grid.name)
    return found


def prepare(
    family: str | Family,
    axes: Sequence[Grid],
    disk: Disk | None,
    contact: Contact | type[Contact] | None,
    at: ArrayLike | None,
    parameters: Mapping[str, ArrayLike],
) -> Problem:
    """The question of a map, with its axes checked and every other value given.

    Parameters
    ----------
    family, disk, contact, at, parameters
        As for `stability_map`.
    axes
        The axes.

    Returns
    -------
    Problem

    Raises
    ------
    StabilityError
        If an axis is unknown, or a value is missing or given twice.
    """
    names = [g.name for g in axes]
    given = at
    if len(set(names)) < len(names):
        raise ParameterError(f"both axes are {shown(names[0])}; give two different ones.")
    if isinstance(family, Family):
        question = make_problem(family, at, disk, contact, dict(parameters))  # type: ignore[arg-type]
        known: tuple[str, ...] = (*family.at, *family.parameters)
    else:
        tilted = 0.0 if "lean" in names else None  # the axis takes its place
        at = _pair(family, names, at)
        question = make_problem(family, at, disk, _law(contact, axes), dict(parameters), tilted)
        keys = ("at",) if len(question.family.at) == 1 else question.family.at
        keys = ("lean",) if tilted is not None else keys
        known = (*keys, *(n for n in question.names if n not in keys))
        if isinstance(question.law, LinearViscous):
            known = tuple(dict.fromkeys((*known, "c", "mu")))
            if {"c", "mu"} <= set(names):
                raise ParameterError(
                    "the axes are c and mu, which are two names for one coefficient; take one."
                )
    for name in names:
        if name not in known:
            raise NameUnknownError(
                f"axis is {shown(name)}; known for {question.family.name} are {', '.join(known)}."
            )
        if not name or name in RESERVED or name.startswith(("boundary_", "box_")) or "/" in name:
            raise NameUnknownError(
                f"axis is {shown(name)}, a name that the map needs for itself; rename the "
                "parameter."
            )
    axis_values = {g.name: g.values for g in axes}
    for name, values in axis_values.items():
        check_axis(question, name, values)
    keys = tuple(n for n in known if n in ("at", "lean", *question.family.at))
    for key in keys:
        if key in question.values and key in names and at is not None and at is given:
            raise ParameterError(f"{key} is given as a value and as an axis; give it once.")
        if key not in question.values and key not in names:
            raise ParameterError(f"{key} is missing; make it an axis or give its value.")
    for name, value in question.values.items():
        if np.ndim(value) and name not in names:
            raise ParameterError(f"{name} is an array; what is not an axis must be one number.")
    kept = dict(question.values)
    if "c" in names or "mu" in names:  # two names for one coefficient: the axis takes its place
        kept = {n: v for n, v in kept.items() if n not in ("c", "mu")}
    merged = kept | {n: v.mean() for n, v in axis_values.items()}
    from dataclasses import replace

    question = replace(question, values=merged)
    if question.dimensionless and set(names) & set(PHYSICAL):  # then the numbers are SI after all
        parts = question.family.at
        question = replace(
            question,
            dimensionless=False,
            units=disk_units(["at"] if len(parts) == 1 else parts, parts, si=True),
            roundings=disk_roundings(parts, question.law, si=True),  # type: ignore[arg-type]
        )
    _check_members(question, axis_values)
    return question


def _pair(family: Any, names: Sequence[str], at: ArrayLike | None) -> Any:
    """Both parts of a circling member where one is the axis and `at` is the other."""
    parts = AT.get(family, ()) if isinstance(family, str) else ()
    swept = [p for p in parts if p in names]
    if len(parts) != 2 or len(swept) != 1 or at is None or np.ndim(at):
        return at
    return [1.0, at] if swept == [parts[0]] else [at, 1.0]


def _law(contact: Any, axes: Sequence[Grid]) -> Contact:
    swept = next((g for g in axes if g.name in ("mu", "c")), None)
    if contact is None and swept is None:
        raise ParameterError(
            "contact is missing; give Smooth(), Viscous(mu), LinearViscous(c) or Rough(), or make "
            "mu an axis."
        )
    if contact is None:
        contact = Viscous
    if isinstance(contact, Contact):
        return contact
    if not isinstance(contact, type) or contact not in LAWS.values():
        raise NameUnknownError(f"contact is {shown(contact)}; known are {', '.join(LAWS)}.")
    law: type[Contact] = contact
    if law.coefficient is None:
        return law()
    if swept is None:
        raise ParameterError(f"mu is missing; give {law.__name__}(mu) or make mu an axis.")
    return law(1.0)  # type: ignore[call-arg]  # the axis takes its place


def _check_members(question: Problem, axis_values: Mapping[str, Floats]) -> None:
    """Refuse early where the corners of the map have no member."""
    corners = np.meshgrid(*[v[[0, -1]] for v in axis_values.values()])
    values = dict(question.values) | {
        n: c.ravel() for n, c in zip(axis_values, corners, strict=True)
    }
    a, q, _, _ = question.arrays(values)
    question.family.member(a, q)
