"""A problem along axes: what varies, what is held, and names that an axis cannot have."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from ..base.axis import MOST_POINTS, Axis, AxisLike
from ..base.errors import DomainError, NameUnknownError, ParameterError, shown
from ..base.types import Floats
from ..bodies.contact_laws import Contact
from ..bodies.disk import Disk
from ..bodies.quantities import PHYSICAL
from ..bodies.round_body.body import Body
from ..bodies.subject import NONE, Subject, refuse_unknown, subject_of
from ..systems.family import Family
from ..systems.sources.numeric import NumericSystem
from ..systems.structure.structural_zeros import steady_where
from .problem import Problem, disk_roundings, problem_of, through_switches

RESERVED = (
    "abscissa",
    "abscissa_error",
    "frequency",
    "verdict",
    "equilibria",
    "stable_equilibria",
    "eigenvalues",
    "mode",
    "complex_part",
    "box",
    "end",
)
"""Variables and dimensions of every map; no axis may have such a name."""
COLUMNS = ("axis", "error", "kind", "curve", "point")
"""A map has `boundary_axis` and so on for itself, and `boundary_NAME` for each of its two axes."""


def swept(
    family: str | Family,
    axes: Mapping[str, AxisLike | Axis],
    disk: Disk | None = None,
    body: Body | Disk | None = None,
    contact: Contact | type[Contact] | str | None = None,
    at: ArrayLike | None = None,
    parameters: Mapping[str, Any] = NONE,
    *,
    exact: bool = False,
    linear: bool = False,
    most: int = MOST_POINTS,
) -> tuple[Problem, tuple[Axis, ...]]:
    """The problem of a call with axes, and the axes.

    Parameters
    ----------
    family, disk, body, contact, at, parameters
        As for `stability_map`.
    axes
        Axes as the caller gave them, by the names of the arguments.
    exact
        Whether numbers that are exact by their type stay so; otherwise they are rounded, with a
        warning.
    linear
        Whether the linearisation alone is asked, which may go through switches.
    most
        Most points of an axis.

    Raises
    ------
    StabilityError
        If the arguments do not fit together.
    """
    grids = [
        axis if isinstance(axis, Axis) else Axis.of(axis, word, most) for word, axis in axes.items()
    ]
    subject = subject_of(
        family,
        at=at,
        disk=disk,
        body=body,
        contact=contact,
        parameters=parameters,
        axes=[grid.name for grid in grids],
    )
    if not subject.family.at and subject.disk is None:
        raise ParameterError(f"{subject.family.name} has one member alone, and so no axis.")
    grids = [_called(grid, subject) for grid in grids]
    try:
        return along_axes(subject, grids, exact=exact), tuple(grids)
    except DomainError:
        if not linear or (smooth := through_switches(subject)) is subject:
            raise
    return along_axes(smooth, grids, exact=exact), tuple(grids)


def _called(grid: Axis, subject: Subject) -> Axis:
    """An axis by its key; of the number that names members, with its other name as a second."""
    key, family = subject.key(grid.name), subject.family
    names = {"at", *family.at} - {key}
    single = len(family.at) == 1 and key in ("at", *family.at) and not names & {*family.parameters}
    return replace(grid, name=key, alias=names.pop() if single and names else "")


def along_axes(subject: Subject, axes: Sequence[Axis], *, exact: bool = False) -> Problem:
    """The problem of a subject along axes, with every other value given.

    Parameters
    ----------
    subject
        What the question is asked about.
    axes
        The axes, by their keys.
    exact
        As for `swept`.

    Raises
    ------
    StabilityError
        If an axis is unknown, or a value is missing or given twice.
    """
    names = [g.name for g in axes]
    if len(set(names)) < len(names):
        raise ParameterError(f"both axes are {shown(names[0])}; give two different ones.")
    if set(names[1:]) & set(subject.alternatives(names[0])):
        raise ParameterError(
            f"the axes are {' and '.join(sorted(names))}, which are two names for one "
            "coefficient; take one."
        )
    values = {**subject.numbers, **subject.member}
    for grid in axes:
        _check_name(subject, grid.name, alone=len(names) == 1)
        if grid.name in values:
            raise ParameterError(
                f"{_word(subject, grid.name)} is given as {shown(values[grid.name])}, and "
                f"as an axis from {grid.low:g} to {grid.high:g}; give it once."
            )
        subject.check_axis(grid.name, grid.low, grid.high)
    problem = problem_of(subject)
    for key in subject.keys:
        if key not in (*values, *names):
            raise ParameterError(f"{key} is missing; make it an axis or give its value.")
    for name, value in problem.values.items():
        if np.ndim(value) and name not in names:
            raise ParameterError(f"{name} is an array; what is not an axis must be one number.")
    others = {n for name in names for n in subject.alternatives(name)}
    held = {n: v for n, v in problem.values.items() if n not in others}
    axis_values = {g.name: g.values for g in axes}
    ratios = {n: r for n, r in problem.ratios.items() if n not in names}
    if problem.plain and not isinstance(problem.family.system, NumericSystem):
        problem = replace(problem, family=steady_where(problem.family, held))
    middles = {n: _middle(v) for n, v in axis_values.items()}
    problem = replace(problem, values=held | middles, ratios=ratios)
    problem = problem if exact else problem.rounded()
    if problem.law and problem.dimensionless and set(names) & set(PHYSICAL):  # SI numbers then
        roundings = disk_roundings(problem.family.at, problem.law, si=True)
        problem = replace(problem, dimensionless=False, roundings=roundings)
    _check_members(problem, axis_values)
    return problem


def _word(subject: Subject, key: str) -> str:
    """The name of a number, with that of the member's own where it is `at`."""
    meaning = subject.family.meaning(key)
    return key if meaning == key else f"{key} ({meaning})"


def _check_name(subject: Subject, name: str, *, alone: bool) -> None:
    """Refuse an axis that the family does not have, or whose name the map needs."""
    refuse_unknown(name, subject.family.name, subject.names)
    taken = not name or name in RESERVED or name.startswith(("boundary_", "box_", "point_"))
    if taken or "/" in name or (name in COLUMNS and not alone):
        raise NameUnknownError(
            f"axis is {shown(name)}, a name that the map needs for itself; rename the parameter."
        )


def _middle(values: Floats) -> float:
    """A typical value of an axis: the mean, or the middle value where the mean overflows."""
    with np.errstate(over="ignore"):
        mean = float(values.mean())
    return mean if np.isfinite(mean) else float(values[len(values) // 2])


def _check_members(problem: Problem, axis_values: Mapping[str, Floats]) -> None:
    """Refuse early if a corner has no member; a map of one's own system may have such cells."""
    corners = np.meshgrid(*[v[[0, -1]] for v in axis_values.values()])
    values = dict(problem.values) | {
        n: c.ravel() for n, c in zip(axis_values, corners, strict=True)
    }
    a, q, _, _ = problem.arrays(values)
    if problem.plain and len(axis_values) == 2:
        members = problem.family.members(a, q)
        problem.family.checked_states(a[members.good], members.u[members.good], q[members.good])
    else:
        problem.family.member(a, q)
