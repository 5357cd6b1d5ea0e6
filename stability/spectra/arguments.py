"""Arguments of spectra and maps, turned from names and numbers into a problem."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from types import MappingProxyType
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from ..base.axis import MOST_POINTS, Axis, AxisLike
from ..base.checks import checked, real_numbers
from ..base.errors import NameUnknownError, ParameterError, shown
from ..base.types import Floats
from ..bodies.contact_laws import (
    LAWS,
    Contact,
    Viscous,
    class_named,
    law_given,
    law_missing,
    law_only,
    refuse_misspelt,
)
from ..bodies.disk import Disk
from ..bodies.families import FAMILIES
from ..bodies.quantities import PHYSICAL
from ..bodies.round_body.body import Body
from ..bodies.subject import of_body
from ..systems.family import Family
from ..systems.structure.structural_zeros import steady_where
from ..systems.system import refuse_system
from .problem import Problem, check_axis, disk_problem, disk_roundings, system_problem

RESERVED = (
    "abscissa",
    "abscissa_error",
    "frequency",
    "verdict",
    "eigenvalues",
    "mode",
    "complex_part",
    "box",
    "end",
)
"""Variables and dimensions of every map; no axis may have such a name."""
NONE: Mapping[str, Any] = MappingProxyType({})
COLUMNS = ("axis", "error", "kind", "curve", "point")
"""A map has `boundary_axis` and so on for itself, and `boundary_NAME` for each of its two axes."""


def axis_of(family: Any, axis: Any, which: str, most: int = MOST_POINTS) -> Axis:
    """An axis as `Axis.of` reads it; `at` and the name of the quantity are two names for one.

    Parameters
    ----------
    family
        Name of a disk's family, whose axis is then `at`; or a `Family`, whose axis then has the
        name of its own quantity.
    axis, which, most
        As for `Axis.of`.

    Examples
    --------
    >>> axis_of("rolling", ("omega3", 1, 2, 3), "x").name
    'at'
    """
    refuse_system(family)
    grid = Axis.of(axis, which, most)
    if isinstance(family, Family):
        if not family.at:
            raise ParameterError(f"{family.name} has one member alone, and so no {which}.")
        own, name = "at", family.at[0]
        single = len(family.at) == 1 and "at" not in family.parameters
    else:
        record = FAMILIES.get(family) if isinstance(family, str) else None
        single = record is not None and len(record.at) == 1
        own, name = (record.at[0] if record else ""), "at"
    return replace(grid, name=name, alias=own) if single and grid.name == own else grid


def check_names(family: Any, names: Sequence[str], contact: Any) -> None:
    """Refuse an axis that no disk has, before anything else that is missing.

    Parameters
    ----------
    family
        Name of a family of the disk; nothing is checked for another one.
    names
        Names of the axes as they were given.
    contact
        A law, its name or class, or None for viscous.
    """
    record = FAMILIES.get(family) if isinstance(family, str) else None
    law: Any = Viscous if contact is None else contact
    law = class_named(law, motion=True) if isinstance(law, str) else law
    if record is None or not isinstance(law, (type, Contact)) or not hasattr(law, "parameters"):
        return
    member = ["at", *record.at, "lean"] if len(record.at) == 1 else [*record.at]
    member = member if record.by_angle else [n for n in member if n != "lean"]
    known = dict.fromkeys([*member, "k", *PHYSICAL, *(p.name for p in law.parameters)])
    for name in names:
        if name not in known:
            raise NameUnknownError(
                f"axis is {shown(name)}; known for {family} are {', '.join(known)}."
            )


def swept(
    family: str | Family,
    axes: Mapping[str, AxisLike],
    disk: Disk | None,
    body: Body | Disk | None,
    contact: Contact | type[Contact] | str | None,
    at: ArrayLike | None,
    parameters: Mapping[str, Any],
    *,
    exact: bool = False,
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
        As for `prepare`.
    most
        Most points of an axis.

    Raises
    ------
    StabilityError
        If the arguments do not fit together.
    """
    given = [*axes.values()]
    family, disk, contact, numbers = of_body(family, body, disk, contact, parameters, given)
    grids = tuple(axis_of(family, axis, word, most) for word, axis in axes.items())
    return prepare(family, grids, disk, contact, at, numbers, exact=exact), grids


def prepare(
    family: str | Family,
    axes: Sequence[Axis],
    disk: Disk | None,
    contact: Contact | type[Contact] | str | None,
    at: ArrayLike | None,
    parameters: Mapping[str, ArrayLike],
    *,
    exact: bool = False,
) -> Problem:
    """The problem of a map, with its axes checked and every other value given.

    Parameters
    ----------
    family, disk, contact, at, parameters
        As for `stability_map`.
    axes
        The axes of the map.
    exact
        Whether numbers that are exact by their type stay so; otherwise they are rounded, with a
        warning.

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
        at, parameters = _beyond_axes(family, names, at, parameters)
        problem = problem_of(family, at, disk, contact, dict(parameters))
        known: tuple[str, ...] = (*family.at, *family.parameters)
    else:
        tilted = 0.0 if "lean" in names else None  # the axis replaces this value
        check_names(family, names, contact)
        given_by_name = dict(parameters)
        given = at_by_name(family, at, given_by_name, names)
        at = _pair(family, names, given)
        law_ = _law(contact, axes, given_by_name)
        problem = problem_of(family, at, disk, law_, given_by_name, tilted)
        keys = ("at",) if len(problem.family.at) == 1 else problem.family.at
        keys = ("lean",) if tilted is not None else keys
        known = (*keys, *(n for n in problem.names if n not in keys))
        assert problem.law is not None
        known = tuple(dict.fromkeys((*known, *(p.name for p in problem.law.parameters))))
        same = set(problem.law.alternatives(names[0]))
        if set(names[1:]) & same:
            raise ParameterError(
                f"the axes are {' and '.join(sorted(names))}, which are two names for one "
                "coefficient; take one."
            )
    for name in names:
        if name not in known:
            raise NameUnknownError(
                f"axis is {shown(name)}; known for {problem.family.name} are {', '.join(known)}."
            )
        if (
            not name
            or name in RESERVED
            or name.startswith(("boundary_", "box_", "point_"))
            or "/" in name
        ):
            raise _taken(name)
        if len(names) == 2 and name in COLUMNS:
            raise _taken(name)
    for grid in axes if isinstance(family, Family) else ():
        if grid.name in problem.values:
            raise _twice(grid, problem.values[grid.name])
    axis_values = {g.name: g.values for g in axes}
    for name, values in axis_values.items():
        check_axis(problem, name, values)
    keys = tuple(n for n in known if n in ("at", "lean", *problem.family.at))
    for key in keys:
        if key in problem.values and key in names and at is not None and at is given:
            raise _twice(axes[names.index(key)], problem.values[key])
        if key not in problem.values and key not in names:
            raise ParameterError(f"{key} is missing; make it an axis or give its value.")
    for name, value in problem.values.items():
        if np.ndim(value) and name not in names:
            raise ParameterError(f"{name} is an array; what is not an axis must be one number.")
    kept = dict(problem.values)
    for name in names if problem.law else ():  # the axis takes the other's place
        assert problem.law
        kept = {n: v for n, v in kept.items() if n not in problem.law.alternatives(name)}
    merged = kept | {n: _middle(v) for n, v in axis_values.items()}
    ratios = {n: r for n, r in problem.ratios.items() if n not in names}
    if problem.plain:
        problem = replace(problem, family=steady_where(problem.family, kept))
    problem = replace(problem, values=merged, ratios=ratios)
    problem = problem if exact else problem.rounded()
    law = problem.law
    if law and problem.dimensionless and set(names) & set(PHYSICAL):  # the numbers are SI then
        roundings = disk_roundings(problem.family.at, law, si=True)
        problem = replace(problem, dimensionless=False, roundings=roundings)
    _check_members(problem, axis_values)
    return problem


def _twice(axis: Axis, value: Any) -> ParameterError:
    return ParameterError(
        f"{axis.name} is given as {shown(value)}, and as an axis from {axis.low:g} to "
        f"{axis.high:g}; give it once."
    )


def _taken(name: str) -> NameUnknownError:
    return NameUnknownError(
        f"axis is {shown(name)}, a name that the map needs for itself; rename the parameter."
    )


def at_by_name(family: Any, at: Any, parameters: dict[str, Any], swept: Sequence[str] = ()) -> Any:
    """What names a member of a family of the disk: `at`, or numbers by their own names.

    Parameters
    ----------
    family, at
        What the caller gave.
    parameters
        Numbers by name; those that name the member are taken out.
    swept
        Names of axes, which are numbers of the member too.

    Returns
    -------
    array_like or None
        None where nothing names the member, or not all of it.

    Raises
    ------
    ParameterError
        If a number is given twice, or shapes do not fit.

    Examples
    --------
    >>> given = {"omega3": 1.2, "mu": 0.3}
    >>> at_by_name("rolling", None, given), given
    (1.2, {'mu': 0.3})
    """
    names = FAMILIES[family].at if isinstance(family, str) and family in FAMILIES else ()
    mine = [n for n in names if n in parameters]
    if not mine:
        return at
    if at is not None:
        raise ParameterError(f"{mine[0]} is given as at and by name; give it once.")
    for name in mine:
        axis = next((a for a in swept if a in (name, "at", "lean")), None)
        if axis:
            other = "and as an axis" if axis == name else f"and {axis} too"
            raise ParameterError(f"{name} is given by name, {other}; give it once.")
    if {*mine, *swept} < set(names):
        return None
    parts = [checked(n, parameters.pop(n)) for n in mine]
    try:
        return parts[0] if len(parts) == 1 else np.stack(np.broadcast_arrays(*parts), axis=-1)
    except ValueError:
        shapes = ", ".join(str(np.shape(v)) for v in parts)
        raise ParameterError(f"{' and '.join(mine)} have shapes {shapes}; make them fit.") from None


def _beyond_axes(
    family: Family, names: Sequence[str], at: Any, parameters: Mapping[str, ArrayLike]
) -> tuple[Any, Mapping[str, ArrayLike]]:
    """Where axes take some of the names of a member, `at` holds the others, by name."""
    open_ = [n for n in family.at if n not in names]
    if at is None or len(open_) == len(family.at):
        return at, parameters
    given = real_numbers("at", at)
    values = list(at) if given.ndim else [at]
    if len(values) == len(family.at):
        return at, parameters
    if len(values) != len(open_):
        raise ParameterError(
            f"at holds {len(values)} numbers; a member of {family.name} is named by "
            f"{', '.join(family.at)}, and beyond the axis at holds "
            + (f"{len(open_)} ({', '.join(open_)})." if open_ else "none, so leave it out.")
        )
    twice = [n for n in open_ if n in parameters]
    if twice:
        raise ParameterError(f"{twice[0]} is given as at and by name; give it once.")
    return None, {**parameters, **dict(zip(open_, values, strict=True))}


def _pair(family: Any, names: Sequence[str], at: ArrayLike | None) -> Any:
    """Both numbers of a member that two numbers name, if one is the axis and `at` the other."""
    known = FAMILIES.get(family) if isinstance(family, str) else None
    parts = known.at if known else ()
    swept = [p for p in parts if p in names]
    if len(parts) != 2 or len(swept) != 1 or at is None or np.ndim(at):
        return at
    return [1.0, at] if swept == [parts[0]] else [at, 1.0]


def _law(contact: Any, axes: Sequence[Axis], parameters: dict[str, Any]) -> Contact:
    found = law_given(contact, parameters, swept=[g.name for g in axes])
    if found is None:
        refuse_misspelt(Viscous, parameters)
        raise law_missing(LAWS, ", or make mu an axis")
    if not isinstance(found, Contact):
        raise NameUnknownError(f"contact is {shown(found)}; known are {', '.join(LAWS)}.")
    return found


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
        found = problem.family.members(a, q)
        problem.family.checked_states(a[found.good], found.u[found.good], q[found.good])
    else:
        problem.family.member(a, q)


def opened(family: Family, given: Mapping[str, Any]) -> dict[str, Any]:
    """The parameters by name, with those of a mapping called `parameters`."""
    inner = given.get("parameters")
    if "parameters" in (*family.at, *family.parameters) or not isinstance(inner, Mapping):
        return dict(given)
    out = {name: value for name, value in given.items() if name != "parameters"}
    for name, value in inner.items():
        if not isinstance(name, str):
            raise ParameterError(f"parameters names {shown(name)}; give names, each a string.")
        if name in out:
            raise ParameterError(f"{name} is given by name and in parameters; give it once.")
        out[name] = value
    return out


def problem_of(
    family: str | Family,
    at: ArrayLike | None = None,
    disk: Disk | None = None,
    contact: Contact | type[Contact] | str | None = None,
    parameters: Mapping[str, Any] = NONE,
    lean: ArrayLike | None = None,
    *,
    body: Body | Disk | None = None,
) -> Problem:
    """The problem of the arguments of `spectrum`.

    Parameters
    ----------
    family
        Name of a family of a disk or body, or a `Family`.
    at
        Family parameter, or None where it is an axis or `lean` is given.
    disk, body, contact
        Body and law, for families by name.
    parameters
        Numbers by name.  One that has the name of an argument, such as `at` or `axis`, is given in
        a mapping called `parameters`.
    lean
        Angle π/2 - theta [rad] instead of `at`, where theta alone names a member.

    Returns
    -------
    Problem

    Raises
    ------
    StabilityError
        If the arguments do not fit together.
    """
    family, disk, contact, parameters = of_body(family, body, disk, contact, parameters)
    refuse_system(family)
    if isinstance(family, Family):
        words = {"lean": lean, "disk": disk, "contact": contact}
        for word in (w for w, v in words.items() if v is not None and w in family.parameters):
            raise ParameterError(
                f"{word} is an argument of the disk here; give the parameter {word} of "
                f"{family.name} as parameters={{{word!r}: …}}."
            )
        if lean is not None:
            raise ParameterError(f"lean belongs to families of the disk; {family.name} takes at.")
        if disk is not None or contact is not None:
            raise ParameterError(
                f"disk and contact belong to the disk's families; {family.name} takes "
                f"{', '.join(family.parameters) or 'no parameters'}."
            )
        return system_problem(family, at, opened(family, parameters))
    at = at_by_name(family, at, parameters, ("lean",) if lean is not None else ())
    law: Any = law_only(contact, parameters)
    if law is None:
        raise law_missing(LAWS)
    return disk_problem(family, Disk() if disk is None else disk, law, at, lean)
