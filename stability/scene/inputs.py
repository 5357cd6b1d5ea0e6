"""Inputs of a scene: the launch as numbers, and the launch with some inputs changed."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from ..base.checks import one_number
from ..base.errors import ParameterError, shown
from ..base.quantities import Kind, readable
from ..bodies.contact_laws import Contact, law_only
from ..bodies.disk import Disk
from ..bodies.model import Model, system_model
from ..bodies.newton_euler import STATES
from ..bodies.round_body.body import Body
from ..bodies.round_body.shape import SCALES
from ..bodies.thin_disk import disk_model
from ..integrators.flow import flow_of
from ..motion.gather import launches_of
from ..motion.round_starts import accepted
from ..motion.starts import Starts
from ..settling.fixed_axes import FixedSettling, fixed_model, fixed_states
from ..systems.system import System


def law_in(disk: Any, contact: Any, mu: float | None) -> Any:
    """The law of a scene; anything else than a word or a class is returned as it is.

    Parameters
    ----------
    disk, contact, mu
        As for `Scene`.

    Raises
    ------
    ParameterError
        If a number belongs to no law, or a law lacks its own.
    """
    if isinstance(disk, (Disk, Body)):
        return law_only(contact, {} if mu is None else {"mu": mu}, motion=True)
    if mu is not None:
        raise ParameterError("mu belongs to the disk; give a system's parameters in contact.")
    return contact


def laws_of(disk: Any, contact: Any) -> dict[str, Any]:
    """The contact laws of a scene by name; one without a name, or the parameters of a system.

    Parameters
    ----------
    disk
        The disk or a system.
    contact
        A law, laws by name, or parameters of a system.

    Raises
    ------
    ParameterError
        If a disk or body has no law, something that is no law, or a law that it does not have.
    """
    if isinstance(disk, System):
        return {"": contact}
    found = dict(contact) if isinstance(contact, Mapping) else {"": contact}
    for name in found if isinstance(contact, Mapping) else ():
        if not (isinstance(name, str) and name.strip() and name.isprintable()):
            raise ParameterError(f"contact names a law {shown(name)}; give each law a word.")
    for law in found.values():
        if not isinstance(law, Contact):
            raise ParameterError(
                f"contact is {shown(law)}; give a contact law, such as Viscous(0.3), or laws by "
                "name."
            )
        if isinstance(disk, Body):
            accepted(law)
    if not found:
        raise ParameterError("contact holds no law; give one at least.")
    return found


def weights_of(laws: Mapping[str, Any], weights: Any) -> dict[str, float]:
    """Weights of several laws, which add up to 1.

    Parameters
    ----------
    laws
        The laws by name.
    weights
        Weights by name, or an empty mapping for equal ones.

    Returns
    -------
    dict
        Empty for one law.

    Raises
    ------
    ParameterError
        If a weight is not above 0, or does not belong to a law.

    Examples
    --------
    >>> weights_of({"rough": None, "viscous": None}, {"rough": 1.0, "viscous": 3.0})
    {'rough': 0.25, 'viscous': 0.75}
    """
    if not isinstance(weights, Mapping):
        raise ParameterError(f"weights is {shown(weights)}; give weights by the names of laws.")
    if weights and (len(laws) < 2 or set(weights) != set(laws)):
        names = ", ".join(n for n in laws if n) or "no name, because there is one law"
        raise ParameterError(
            f"weights names {', '.join(map(str, weights))}; the laws have {names}: give one for "
            "each."
        )
    found = {n: one_number(f"weight of {n}", weights.get(n, 1.0)) for n in laws}
    for name, value in found.items():
        if not 0 < value < math.inf:
            raise ParameterError(f"weight of {name} is {value:g}; give a number above 0.")
    total = sum(found.values())
    return {n: v / total for n, v in found.items()} if len(laws) > 1 else {}


def names_of(disk: Any, laws: Mapping[str, Any]) -> tuple[str, ...]:
    """Names of the inputs that may be uncertain: states, and parameters of body and laws.

    Parameters
    ----------
    disk
        The disk or a system.
    laws
        The laws by name.
    """
    if isinstance(disk, System):
        return (*disk.states, *disk.parameters)
    own = [n for law in laws.values() for n in law.given]
    shape = ["k"] if isinstance(disk, Disk) else [n for n in disk.given if n not in SCALES]
    return tuple(dict.fromkeys((*STATES, *shape, *own)))


def known_to(disk: Any, law: Any, widths: Mapping[str, float]) -> dict[str, float]:
    """The half-widths of those uncertain inputs that one law has.

    Parameters
    ----------
    disk, law
        The disk or a system, and one law.
    widths
        Half-widths by name.
    """
    inputs = names_of(disk, {"": law})
    return {n: w for n, w in widths.items() if n in inputs}


def in_words(name: str, width: float, launches: Starts) -> str:
    """An uncertain input with its half-width and unit.

    Parameters
    ----------
    name, width
        The input and its half-width, relative for a parameter.
    launches
        The launch, for the units.
    """
    if name not in (*launches.model.states, *(STATES if launches.law else ())):
        return f"{name} ± {100 * width:g} %"
    unit = launches.unit(name)
    return f"{name} ± {width:g}" + ("" if unit == "1" else f" {readable(unit)}")


def label(model: Model, name: str, *, dimensionless: bool) -> str:
    """The unit of a state, a parameter or the time, for a reader; empty for a number without one.

    Parameters
    ----------
    model
        The model.
    name
        Name of the state or parameter, or `time`.
    dimensionless
        Whether the body's units are all 1.
    """
    found = model.attributes(name, dimensionless=dimensionless)
    unit = found.get("unit_in_words", found["units"])
    return "" if unit == "1" else readable(unit)


def unit_of(launches: Starts, kind: Kind) -> str:
    """The unit of a kind for a reader; a user's system states that of time alone.

    Parameters
    ----------
    launches
        The launch.
    kind
        Kind of a number that was asked for.
    """
    if launches.law is None:
        return label(launches.model, "time", dimensionless=True) if kind is Kind.TIME else ""
    unit = kind.label(dimensionless=launches.dimensionless)
    return "" if unit == "1" else readable(unit)


def setting(disk: Any, laws: Mapping[str, Any], start: Any, *asked: float) -> tuple[str, ...]:
    """The question of a scene in three lines, with units: the body and its law, start, horizon.

    Parameters
    ----------
    disk, start
        As for `Scene`.
    laws
        The laws by name, or the parameters of a system under an empty name.
    *asked
        Horizon and tolerance.
    """
    if isinstance(disk, System):
        model, plain = system_model(disk), True
        p = _named({} if laws[""] is None else laws[""], disk.parameters)
        told = [f"{n} = {_told(v)} {label(model, n, dimensionless=True)}" for n, v in p.items()]
        body = [f"system {disk.name}" + (f": {_listed(told)}" if told else "")]
    else:
        model, plain = disk_model(type(next(iter(laws.values())))), disk.dimensionless
        thin = isinstance(disk, Disk)
        size, name, letter = ("radius", "disk", "R") if thin else ("length", disk.name, "length")
        sizes = (("mass", Kind.MASS), (size, Kind.LENGTH), ("gravity", Kind.ACCELERATION))
        told = [f"{n} = {_told(getattr(disk, n))}{kind.suffix}" for n, kind in sizes]
        about = f"m = {letter} = g = 1, without units" if plain else _listed(told)
        shape = {"k": disk.k} if thin else {n: disk.given[n] for n in names_of(disk, {})[6:]}
        body = [_listed([f"{name}: {about}", *(f"{n} = {_told(v)}" for n, v in shape.items())])]
        body += ["; ".join(_of_law(name, law, plain=plain) for name, law in laws.items())]
    states = _named(start, model.states)
    moved = [
        f"{n} = {_told(v)} {label(model, n, dimensionless=plain)}"
        for n, v in states.items()
        if np.any(v)
    ]
    rest = [] if len(moved) == len(model.states) else ["all others 0" if moved else "all states 0"]
    unit = label(model, "time", dimensionless=plain)
    last = f"horizon {asked[0]:.9g} {unit}".strip()
    return *body, f"start: {_listed([*moved, *rest])}; {last}; tolerance {asked[1]:g}"


def _of_law(name: str, law: Contact, *, plain: bool) -> str:
    """A law with its parameters."""
    words = {k.si: k.label(dimensionless=plain) for k in Kind}
    units = {q.name: words.get(q.unit, q.unit) for q in law.parameters}
    told = [
        f"{n} = {_told(v)} {'' if units.get(n) == '1' else units.get(n, '')}"
        for n, v in law.given.items()
    ]
    own = f"law {name}: {law.name}" if name and name != law.name else f"law {law.name}"
    return ", ".join([own, *(t.strip() for t in told)])


def _listed(told: Sequence[str]) -> str:
    return ", ".join(t.strip() for t in told)


def _told(value: Any) -> str:
    """A number, also one in an array."""
    known = np.ravel(value)
    return f"{float(known[0]):.9g}" if known.size == 1 else shown(value)


def launched(
    disk: Any,
    contact: Any,
    start: Any,
    horizon: float,
    families: Any,
    moved: Mapping[str, float],
) -> Starts:
    """The launch of a scene, dimensionless, with some inputs changed.

    Parameters
    ----------
    disk, contact, start, horizon, families
        As for `Scene`, with one law.
    moved
        Changes by name: added to states, relative for parameters.

    Returns
    -------
    Starts
        One launch.
    """
    given, first = contact, start
    if isinstance(disk, System):
        if moved and contact is not None:
            p = _named(contact, disk.parameters)
            given = {n: v * (1 + moved.get(n, 0.0)) for n, v in p.items()}
        first = _moved(start, disk.states, moved) if moved else start
    elif moved:
        numbers = {n: v * (1 + moved.get(n, 0.0)) for n, v in contact.given.items()}
        disk, given = _changed(disk, moved), type(contact)(**numbers)
        first = _moved(start, STATES, moved)
    found = launches_of(disk, given, first, horizon, families=families or ())
    found = _along_fixed_axes(found)
    if found.count != 1:
        raise ParameterError(
            f"the scene has {found.count} launches; give one, and a scene for each."
        )
    return found


def _changed(disk: Disk | Body, moved: Mapping[str, float]) -> Disk | Body:
    """The disk or body with some of its numbers changed."""
    own: dict[str, Any] = {"k": disk.k} if isinstance(disk, Disk) else disk.given
    found: dict[str, Any] = {n: v * (1 + moved[n]) for n, v in own.items() if n in moved}
    if isinstance(disk, Body):
        shape = {n: found.pop(n, v) for n, v in disk.shape.items()}
        return replace(disk, shape=shape, **found)
    return replace(disk, **found)


def _along_fixed_axes(launches: Starts) -> Starts:
    """The launch of a body that is smooth at a pole, told along fixed axes."""
    model = launches.model
    if model.chart is None:
        return launches
    fixed = fixed_model(model)
    starts = fixed_states(model.chart, len(flow_of(fixed).system.states), launches.starts)
    settling = FixedSettling(launches.settling.lines, chart=model.chart)
    return replace(launches, model=fixed, starts=starts, settling=settling)


def _named(given: Any, names: Sequence[str]) -> dict[str, Any]:
    """Numbers by name, from a mapping or a sequence."""
    if isinstance(given, Mapping):
        return dict(given)
    return dict(zip(names, np.ravel(np.asarray(given, dtype=float)).tolist(), strict=False))


def _moved(start: Any, names: Sequence[str], moved: Mapping[str, float]) -> dict[str, Any]:
    """States by name, with changes added; a state that is left out is 0."""
    found = _named(start, names)
    changed = {n: moved[n] for n in names if n in moved}
    return found | {n: found.get(n, 0.0) + by for n, by in changed.items()}
