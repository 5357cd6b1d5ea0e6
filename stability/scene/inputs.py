"""The subject of a scene, resolved once; the launch as numbers, also with some inputs changed."""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any, ClassVar

import numpy as np

from ..base.checks import one_number
from ..base.errors import ParameterError, listed, shown
from ..base.quantities import Kind, readable
from ..bodies.contact_laws import Contact, law_only
from ..bodies.disk import Disk
from ..bodies.model import system_model
from ..bodies.newton_euler import STATES
from ..bodies.quantities import QUANTITIES
from ..bodies.resistance import Resistance, resistances
from ..bodies.round_body.body import Body
from ..bodies.round_body.shape import SCALES
from ..bodies.round_body.thin import round_shape
from ..integrators.flow import flow_of
from ..motion.gather import NO_RESISTANCE, launches_of
from ..motion.round_starts import accepted
from ..motion.starts import Starts
from ..settling.fixed_axes import FixedSettling, fixed_model, fixed_states
from ..systems.system import System


@dataclass(frozen=True, eq=False)
class SceneSubject(ABC):
    """What a scene is about: everything in which a body and a user's system differ."""

    moving: Any
    """The disk, another body, or the system."""
    contact: Any
    """The law, laws by name, or the parameters of a system."""
    laws: Mapping[str, Any]
    """Laws by name; a single one, and the parameters of a system, under an empty name."""
    states: tuple[str, ...]
    """Names of the states of a start."""
    needed: str
    """States that a start must name, in words."""
    rungs: tuple[str, ...] = ()
    """Names of rungs that no reduced model may have."""
    between: tuple[float, float] = (0.0, math.pi)
    """Open interval of θ in which a body has steady motions [rad]."""
    against: tuple[Resistance, ...] = ()
    """Resistances of a body to rolling and turning, the same under each law."""

    touches: ClassVar[bool]
    """Whether it touches a plane, so that its contact, tilt and linear motion can be asked for."""

    @abstractmethod
    def inputs(self, *laws: Any) -> tuple[str, ...]:
        """Names of the inputs that may be uncertain, under some of its laws; all if left out."""

    @abstractmethod
    def changed(self, law: Any, start: Any, moved: Mapping[str, float]) -> tuple[Any, ...]:
        """What moves, its law, its start and its resistances, with some inputs changed."""

    @abstractmethod
    def in_words(self) -> list[str]:
        """What moves and its laws, a line each."""

    @abstractmethod
    def attributes(self, name: str) -> dict[str, str]:
        """Name in words and units of a state or of the time."""

    def known(self, widths: Mapping[str, float], law: Any) -> dict[str, float]:
        """The half-widths of those uncertain inputs that one law has."""
        inputs = self.inputs(law)
        return {n: w for n, w in widths.items() if n in inputs}

    def width_in_words(self, name: str, width: float) -> str:
        """An uncertain input with its half-width, relative for a parameter, and its unit."""
        if name not in self.states:
            return f"{name} ± {100 * width:g} %"
        unit = self.attributes(name)["units"]
        return f"{name} ± {width:g}" + ("" if unit == "1" else f" {readable(unit)}")

    def with_unit(self, name: str, value: Any) -> str:
        """A state or a parameter with its value and unit."""
        return f"{name} = {_digits(value)} {label(self.attributes(name))}".strip()


@dataclass(frozen=True, eq=False, kw_only=True)
class BodySubject(SceneSubject):
    """A disk or another body on a plane, under one contact law or several."""

    numbers: Mapping[str, Any]
    """Numbers of its shape and its moments by name."""
    name: str
    """What it is called."""
    length: tuple[str, str]
    """Name of its unit of length, and the letter of that."""

    touches = True

    def inputs(self, *laws: Any) -> tuple[str, ...]:
        """States, numbers of the body, parameters of the laws, coefficients of resistances."""
        names = [n for law in laws or self.laws.values() for n in law.given]
        names += [r.coefficient for r in self.against]
        return tuple(dict.fromkeys((*self.states, *self.numbers, *names)))

    def changed(self, law: Any, start: Any, moved: Mapping[str, float]) -> tuple[Any, ...]:
        """Numbers and coefficients change by a share, states by a number."""

        def by_share(numbers: Mapping[str, Any]) -> dict[str, Any]:
            return {n: v * (1 + moved.get(n, 0.0)) for n, v in numbers.items()}

        body = self.moving.having(by_share(self.numbers))
        against = (replace(r, **by_share({r.coefficient: r.value})) for r in self.against)
        start = _moved(start, self.states, moved)
        return body, type(law)(**by_share(law.given)), start, tuple(against)

    def in_words(self) -> list[str]:
        """The body with its numbers, and its laws."""
        size, letter = self.length
        sizes = (("mass", Kind.MASS), (size, Kind.LENGTH), ("gravity", Kind.ACCELERATION))
        about = f"m = {letter} = g = 1, without units"
        if not self.moving.dimensionless:
            about = ", ".join(
                f"{n} = {_digits(getattr(self.moving, n))}{kind.suffix}" for n, kind in sizes
            )
        shape = (f"{n} = {_digits(v)}" for n, v in self.numbers.items())
        laws = (self._law(name, law) for name, law in self.laws.items())
        lines = [", ".join([f"{self.name}: {about}", *shape]), "; ".join(laws)]
        plain = self.moving.dimensionless
        lines += [
            f"{r.name}, {r.coefficient} = {_digits(r.value)}" + ("" if plain else f" {r.unit}")
            for r in self.against
        ]
        return lines

    def _law(self, name: str, law: Contact) -> str:
        """A law with its parameters."""
        words = {k.si: k.label(dimensionless=self.moving.dimensionless) for k in Kind}
        units = {q.name: words.get(q.unit, q.unit) for q in law.parameters}
        parameters = [
            f"{n} = {_digits(v)} {'' if units.get(n) == '1' else units.get(n, '')}".strip()
            for n, v in law.given.items()
        ]
        text = f"law {name}: {law.name}" if name and name != law.name else f"law {law.name}"
        text += f" ({law.formula})" if law.formula else ""
        return ", ".join([text, *parameters])

    def attributes(self, name: str) -> dict[str, str]:
        """Name in words and units of a state or of the time."""
        return QUANTITIES[name].attributes(dimensionless=self.moving.dimensionless)


@dataclass(frozen=True, eq=False)
class SystemSubject(SceneSubject):
    """A user's system with its parameters."""

    touches = False

    def inputs(self, *laws: Any) -> tuple[str, ...]:  # noqa: ARG002
        """States and parameters."""
        return (*self.states, *self.moving.parameters)

    @property
    def parameters(self) -> dict[str, Any]:
        """Its parameters by name."""
        return {} if self.contact is None else _named(self.contact, self.moving.parameters)

    def changed(self, law: Any, start: Any, moved: Mapping[str, float]) -> tuple[Any, ...]:  # noqa: ARG002
        """The system, its parameters and its start: parameters change by a share."""
        parameters = {n: v * (1 + moved.get(n, 0.0)) for n, v in self.parameters.items()}
        return self.moving, parameters, _moved(start, self.states, moved), ()

    def in_words(self) -> list[str]:
        """The system with its parameters."""
        parameters = ", ".join(self.with_unit(n, v) for n, v in self.parameters.items())
        return [f"system {self.moving.name}" + (f": {parameters}" if parameters else "")]

    def attributes(self, name: str) -> dict[str, str]:
        """Name in words and units of a state, a parameter or the time."""
        return system_model(self.moving).attributes(name, dimensionless=True)


def scene_subject(
    moving: Disk | Body | System, contact: Any, mu: float | None = None, resistance: Any = None
) -> SceneSubject:
    """The subject of a scene.

    Parameters
    ----------
    moving
        The disk, another body, or a system.
    contact, mu, resistance
        As for `Scene`.

    Raises
    ------
    ParameterError
        If a number belongs to no law, a law lacks its own, or a body has no law that it can have.
    """
    if isinstance(moving, System):
        if mu is not None:
            raise ParameterError("mu belongs to the disk; give a system's parameters in contact.")
        if resistance is not None:
            raise ParameterError(NO_RESISTANCE)
        names = moving.states
        laws, needed = {"": contact}, listed(list(names))
        return SystemSubject(moving, contact, laws, names, needed, rungs=(moving.name,))
    contact = law_only(contact, {} if mu is None else {"mu": mu}, motion=True)
    body = round_shape(moving)
    thin = body is not moving
    return BodySubject(
        moving,
        contact,
        _laws(contact),
        STATES,
        "theta at least",
        between=body.between,
        numbers={n: v for n, v in body.given.items() if n not in SCALES},
        name=body.name,
        length=("radius", "R") if thin else ("length", "length"),
        against=resistances(resistance),
    )


def _laws(contact: Any) -> dict[str, Contact]:
    """The contact laws of a body by name; one without a name."""
    laws = dict(contact) if isinstance(contact, Mapping) else {"": contact}
    for name in laws if isinstance(contact, Mapping) else ():
        if not (isinstance(name, str) and name.strip() and name.isprintable()):
            raise ParameterError(f"contact names a law {shown(name)}; give each law a word.")
    for law in laws.values():
        if not isinstance(law, Contact):
            raise ParameterError(
                f"contact is {shown(law)}; give a contact law, such as Viscous(0.3), or laws by "
                "name."
            )
        accepted(law)
    if not laws:
        raise ParameterError("contact holds no law; give one at least.")
    return laws


def weights_of(laws: Mapping[str, Any], weights: Any) -> dict[str, float]:
    """Weights of several laws, which add up to 1; empty for one law.

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
    shares = {n: one_number(f"weight of {n}", weights.get(n, 1.0)) for n in laws}
    for name, value in shares.items():
        if not 0 < value < math.inf:
            raise ParameterError(f"weight of {name} is {value:g}; give a number above 0.")
    total = sum(shares.values())
    return {n: v / total for n, v in shares.items()} if len(laws) > 1 else {}


def label(attributes: Mapping[str, str]) -> str:
    """The unit of a labelled array for a reader; empty for a number without one."""
    unit = attributes.get("unit_in_words", attributes["units"])
    return "" if unit == "1" else readable(unit)


def about(launches: Starts, name: str) -> dict[str, str]:
    """Name in words and units of a state or of the time, as in a dataset."""
    return launches.model.attributes(name, dimensionless=launches.dimensionless)


def unit_of(launches: Starts, kind: Kind) -> str:
    """The unit of a kind for a reader; a user's system is asked for numbers in that of time."""
    if kind is Kind.TIME:
        return label(about(launches, "time"))
    unit = kind.label(dimensionless=launches.dimensionless)
    return "" if unit == "1" else readable(unit)


def setting(subject: SceneSubject, start: Any, horizon: float, tolerance: float) -> tuple[str, ...]:
    """The question of a scene in some lines, with units: what moves, its laws, start, horizon."""
    states = _named(start, subject.states)
    moved = [subject.with_unit(n, v) for n, v in states.items() if np.any(v)]
    if len(moved) < len(subject.states):
        moved.append("all others 0" if moved else "all states 0")
    last = f"horizon {horizon:.9g} {label(subject.attributes('time'))}".strip()
    return *subject.in_words(), f"start: {', '.join(moved)}; {last}; tolerance {tolerance:g}"


def _digits(value: Any) -> str:
    """A number, also one in an array."""
    numbers = np.ravel(value)
    return f"{float(numbers[0]):.9g}" if numbers.size == 1 else shown(value)


def launched(
    subject: SceneSubject,
    law: Any,
    start: Any,
    horizon: float,
    families: Any,
    moved: Mapping[str, float],
) -> Starts:
    """The launch of a scene under one law, dimensionless, with some inputs changed.

    States change by a number, parameters by a share of their value.
    """
    moving, against = subject.moving, subject.against
    if moved:
        moving, law, start, against = subject.changed(law, start, moved)
    families, resistance = families or (), against or None
    launches = _along_fixed_axes(
        launches_of(moving, law, start, horizon, families=families, resistance=resistance)
    )
    if launches.count != 1:
        raise ParameterError(
            f"the scene has {launches.count} launches; give one, and a scene for each."
        )
    return launches


def _along_fixed_axes(launches: Starts) -> Starts:
    """The launch of a body that is smooth at a pole, by its states along fixed axes."""
    model = launches.model
    if model.chart is None:
        return launches
    fixed = fixed_model(model)
    starts = fixed_states(model.chart, len(flow_of(fixed).system.states), launches.starts)
    settling = FixedSettling(launches.settling.lines, chart=model.chart)
    return replace(launches, model=fixed, starts=starts, settling=settling)


def _named(values: Any, names: Sequence[str]) -> dict[str, Any]:
    """Numbers by name, from a mapping or a sequence."""
    if isinstance(values, Mapping):
        return dict(values)
    return dict(zip(names, np.ravel(np.asarray(values, dtype=float)).tolist(), strict=False))


def _moved(start: Any, names: Sequence[str], moved: Mapping[str, float]) -> dict[str, Any]:
    """States by name, with changes added; a state that is left out is 0."""
    states = _named(start, names)
    changed = {n: moved[n] for n in names if n in moved}
    return states | {n: states.get(n, 0.0) + by for n, by in changed.items()}
