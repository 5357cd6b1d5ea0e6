"""Launches: starts, parameters and times, checked and made dimensionless."""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..base.checks import checked
from ..base.errors import NameUnknownError, ParameterError, listed, shown
from ..base.quantities import Kind, Units
from ..base.types import Floats
from ..bodies.contact_laws import Contact
from ..bodies.model import FLAT, Model
from ..settling.settling import Nearest, Settling
from .result import Outcome

MOST_LAUNCHES, MOST_SAMPLES = 1_000_000, 20_000_000
"""Most launches of one call, and most samples (launches by times): all are held in memory."""
POINTS = 201
"""Samples of a run for which only a last time is given."""


Unfit = dict[int, str]
"""The end that a start has had already, by its number."""


@dataclass(frozen=True, eq=False, kw_only=True)
class MotionSubject(ABC):
    """What moves, as the datasets of its motions tell of it.

    Who checks the launches builds it, for a body or for a user's system; all others read it.
    """

    attributes: Mapping[str, Any]
    """Attributes of a dataset that name it."""
    cited: Callable[..., str]
    """As `stability.base.citation.cited`, with the works on its model."""
    outcomes: tuple[Outcome, ...]
    """What may become of a launch."""
    energy_error: str
    """Definition of the error of its energy account."""
    member: Mapping[str, str]
    """Name in words and units of the number that names a steady motion."""
    numbers: Mapping[str, Mapping[str, str]] = field(default_factory=dict)
    """Names in words and units of its parameters, where they have any."""
    settings: tuple[str, ...] = ()
    """Settings of a run that it has in addition to those of every motion."""
    slips: bool = False
    """Whether it slips, in a direction that events tell."""

    @abstractmethod
    def in_units(self, launches: Starts, series: dict[str, Floats]) -> dict[str, Floats]:
        """Series, shape (launch, time), in the user's units, in the order of a dataset."""

    @abstractmethod
    def energy_scale(self, launches: Starts, y: Floats, series: Mapping[str, Floats]) -> Floats:
        """The energy that the error of the account is over, shape (launch,), from y, (N, t, n)."""

    @abstractmethod
    def nearest(self, launches: Starts, near: Sequence[Nearest], variable: Any) -> dict[str, Any]:
        """The nearest steady motions: family, distance, member; `variable` makes one of a list."""


@dataclass(frozen=True, eq=False)
class Starts:
    """N launches of one model, dimensionless for a disk, with the user's units."""

    model: Model
    """The equations."""
    shape: tuple[int, ...]
    """The shape the user's arrays broadcast to."""
    starts: Floats
    """The states that are reported, shape (N, s)."""
    p: Floats
    """Parameters of the system, shape (N, m)."""
    times: Floats
    """Times as the user gave them, shape (t,)."""
    given: Mapping[str, Floats]
    """Parameters as the user gave them by name, shape (N,) or ()."""
    units: Units
    """The user's units of each launch, of shape (N,) or (); all 1 of a user's system."""
    dimensionless: bool
    """Whether all units are 1, or those of the user's own system."""
    energies: Floats
    """Energy at the start, shape (N,); 0 where none is counted."""
    settling: Settling
    """The steady motions that the launches may settle on."""
    subject: MotionSubject
    """What moves."""
    law: type[Contact] | None = None
    """The contact law; None for a user's system."""
    unfit: Unfit | None = None
    """Which starts are no launches, as marked by `gather`; None where all were checked."""
    name: str = ""
    """What the full model is called: its contact law, or the user's system."""

    @property
    def count(self) -> int:
        """Number N of launches."""
        return len(self.starts)

    @property
    def dry(self) -> bool:
        """Whether friction sticks."""
        return self.model.dry is not None

    def size(self, kind: Kind) -> Any:
        """A dimensionless 1 of a kind in the user's units, shape (N,) or ()."""
        return np.asarray(self.units.size(kind))

    @property
    def clock(self) -> Floats:
        """Unit of time of each launch, shape (N,)."""
        return np.broadcast_to(self.size(Kind.TIME), (self.count,))

    def flow_p(self, flat: float) -> Floats:
        """Parameters of the flow: those of the system, then for a body the sine of `flat`."""
        more = self.model.p.numel() - self.p.shape[1]
        return np.column_stack([self.p, np.full((self.count, more), math.sin(flat))])

    def flat(self, angle: float) -> NDArray[np.intp]:
        """Launches that start flat within an angle, as far as bodies fall flat."""
        if FLAT not in self.model.guards:
            return np.zeros(0, dtype=np.intp)
        theta = self.starts[:, 0]
        # a start within rounding of the border cannot be distinguished from one on it
        return np.flatnonzero(np.minimum(theta, np.pi - theta) <= angle * (1 + 1e-6))

    def some(self, rows: NDArray[np.intp]) -> Starts:
        """Some of the launches, which are all fit."""

        def part(value: Any) -> Any:
            return value[rows] if np.ndim(value) else value

        scales = {n: part(getattr(self.units, n)) for n in ("mass", "length", "gravity")}
        return replace(
            self,
            shape=(len(rows),),
            starts=self.starts[rows],
            p=self.p[rows],
            given={n: part(v) for n, v in self.given.items()},
            units=replace(self.units, **scales),
            energies=self.energies[rows],
            unfit=None,
        )

    def states_in_units(self, states: Floats, which: Any = slice(None)) -> Floats:
        """States in the user's units, shape (m, s), of which row i is of launch `which[i]`."""
        states = states.copy()
        if not self.dimensionless:
            for column, name in enumerate(self.model.states):
                scale = self.size(self.model.quantities[name].kind)
                states[:, column] *= scale[which] if scale.ndim else scale
        return states

    def unit(self, name: str) -> str:
        """The unit of a series or of time, as in a file."""
        return self.model.attributes(name, dimensionless=self.dimensionless)["units"]


def nearest_families(near: Sequence[Nearest], variable: Any, words: str) -> dict[str, Any]:
    """Families of the nearest steady motions, and the distances from them, in words."""
    return {
        "nearest_family": variable([n.family for n in near], long_name="nearest steady motion"),
        "nearest_distance": variable([n.distance for n in near], units="1", long_name=words),
    }


def place_in(shape: tuple[int, ...], row: int) -> str:
    """Index of a launch, as text; nothing for a single one."""
    return f" {[int(j) for j in np.unravel_index(row, shape)]}" if shape else ""


def counted(shape: tuple[int, ...], when: Floats) -> int:
    """The number of launches, refused where memory would not hold their samples."""
    count = math.prod(shape)
    if count == 0:
        raise ParameterError(
            f"start and the parameters have shape {shape}: give a launch at least."
        )
    if count > MOST_LAUNCHES or count * len(when) > MOST_SAMPLES:
        raise ParameterError(
            f"{count} launches at {len(when)} times are asked; give at most {MOST_LAUNCHES} "
            f"launches and {MOST_SAMPLES} samples in all, and call again for more."
        )
    return count


def by_name(
    what: str, values: Mapping[str, Any], names: Sequence[str], missing: float | None = None
) -> Floats:
    """Values by name as columns in the order of the names; `missing` for one that is left out."""
    for name in values:
        if name not in names:
            accepted = ", ".join(names) or "none"
            raise NameUnknownError(f"{what} names {shown(name)}; known are {accepted}.")
    lost = [n for n in names if n not in values]
    if lost and missing is None:
        raise ParameterError(f"{what} does not name {listed(lost)}; give {', '.join(names)}.")
    columns = [np.asarray(checked(f"{what} {n}", values.get(n, missing)), float) for n in names]
    try:
        return np.stack(np.broadcast_arrays(*columns), axis=-1) if columns else np.zeros(0)
    except ValueError:
        raise ParameterError(
            f"{what} has shapes {[c.shape for c in columns]}; make them fit."
        ) from None


def times_of(times: Any) -> Floats:
    """Times to report, rising from 0."""
    if times is None:
        raise ParameterError("times is missing; give a last time, or rising times.")
    when = np.asarray(checked("times", times), dtype=float)
    if when.ndim == 0:
        if when <= 0:
            raise ParameterError(f"times is {when:g}; give a last time above 0, or an array.")
        return np.linspace(0.0, float(when), POINTS)
    if when.ndim != 1:
        raise ParameterError(f"times has shape {when.shape}; give one axis of rising times.")
    if when[0] < 0:
        raise ParameterError(f"times begin at {when[0]:g}; the start is time 0 and comes first.")
    falls = np.flatnonzero(np.diff(when) <= 0)
    if falls.size:
        i = int(falls[0])
        raise ParameterError(
            f"times go from {when[i]:g} to {when[i + 1]:g}; they must rise from one to the next."
        )
    if when[-1] == 0:
        raise ParameterError("times end at 0; give a last time above 0.")
    return when
