"""The families of steady motions of the disk and of every body of revolution: one record for each.

A steady motion keeps its energy, so under a law that dissipates wherever anything slips the force
vanishes: F = 0 and vA = 0.  Then the centre moves straight or rests.  With φ̇ = 0 the torque
h'·m g vanishes: *rolling* at a zero of h' with any ω₃.  With φ̇ ≠ 0 the centre rests, which fixes
ω₃ = φ̇ sinθ z/r, where r = h sinθ + h' cosθ and z = h cosθ - h' sinθ are the distances of the
contact point from the axis and, along the axis, from the centre.  Euler's equation then reads
φ̇² sinθ (I₁ r cosθ - I₃ z sinθ) = m g h' r: *tumbling*, named by θ, and *spinning*, where both
sides vanish upright.  At a pole there is *vertical* spin alone.  The disk, h = sinθ with z = 0, has
an edge in place of poles: it does not spin on them, and turns about its axis in no family that
tumbles.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Any

from ..algebra.upright import UPRIGHT, Upright
from ..base.errors import ParameterError, listed
from ..base.quantities import Kind

# the command line reads the records for its help, so nothing heavy is imported here

Interval = tuple[float, float]
Held = Mapping[str, float | Upright]


@dataclass(frozen=True, eq=False)
class SteadyFamily:
    """A family of steady motions: every fact about it that is not derived.

    Every state is in `at`, `held` or `unknown`; theta_dot and the slip are zero throughout.
    Spectra, boundaries, maps and motions follow from the equations of motion.

    Examples
    --------
    >>> round(FAMILIES["tumbling"].member(math, math.pi / 6, 0.5)["phi_dot"], 12)
    2.0
    """

    name: str
    """Name in calls, tables and files."""
    at: tuple[str, ...]
    """States that name a member; formulas are solved for the last one."""
    held: Held
    """Values of the states that are the same along the family: angles, `UPRIGHT` for the exact
    π/2, or 0 for rates."""
    unknown: Mapping[str, float]
    """First guesses of the states that are solved for, dimensionless."""
    motion: str
    """The motion in words."""
    law: str = ""
    """The one contact law under which the family exists; empty if it exists under every law."""
    positive: tuple[str, ...] = ()
    """Unknowns that come out positive; the mirror image has the same spectrum."""
    rests: bool = False
    """Whether the centre of mass rests, which is an equation of its own."""
    level: bool = False
    """Whether theta is a zero of the height's slope, upright where the slope vanishes there."""
    upright: bool = False
    """Whether the family exists only where the slope of the height vanishes at π/2."""
    pole: bool = False
    """Whether the axis is vertical: the family lives in the chart around a smooth pole."""
    turns: tuple[str, ...] = ("level", "vertical")
    """Parts of the angular velocity that members have; rolling upright has the level part alone."""

    # --- of the disk ---

    disk: str = ""
    """The motion of a disk in words, where these say more."""
    symbols: str = ""
    """The motion of a disk in symbols, for the page of the atlas."""
    held_by_disk: Held = field(default_factory=dict)
    """Values of further states that are the same along the family of a disk."""
    solution: Callable[[Any, Any, Any, Any], Any] | None = None
    """The unknown of a disk as a function of (functions, at, k, unit), as for `member`; None where
    it is always 0 or has no formula.  Without a formula no motion is launched near the family."""
    drifts: bool = False
    """Whether slip carries a stable member along the family, so that no motion settles on it."""
    searched: Interval | None = None
    """Dimensionless interval of `at` in `table conditions`; None where the table leaves it out."""
    drawn: Interval | None = None
    """Dimensionless interval of `at` in the atlas; None where the atlas leaves it out."""
    flutter: Interval | None = None
    """Dimensionless interval of `at` that `hopf` scans where no conditions are stored; None where
    a flutter boundary is not a Hopf bifurcation without parameters."""
    sampled: Interval | None = None
    """Dimensionless interval of `at` of the random members in the comparison of methods."""

    def __post_init__(self) -> None:
        if self.law and (self.drawn or self.sampled):
            raise ParameterError(
                f"{self.name} exists under the {self.law} law alone, and drawn and sampled belong "
                "to families under every law; leave them out."
            )

    @property
    def disk_motion(self) -> str:
        """The motion of a disk in words."""
        return self.disk or self.motion

    @property
    def disk_held(self) -> dict[str, float | Upright]:
        """Values of the states that are the same along the family of a disk."""
        level: Held = {"theta": UPRIGHT} if self.level else {}
        return {**level, **self.held, **self.held_by_disk}

    @property
    def disk_unknown(self) -> dict[str, float]:
        """First guesses of the states that are solved for, for a disk."""
        return {n: v for n, v in self.unknown.items() if n not in self.held_by_disk}

    @property
    def line(self) -> bool:
        """Whether one number names a member of a disk and gives its states: motions may settle."""
        solved = self.solution is not None or not any(self.disk_unknown.values())
        return len(self.at) == 1 and solved and not self.pole

    @property
    def by_angle(self) -> bool:
        """Whether theta alone names a member, so that a lean may name it too."""
        return self.at == ("theta",)

    def unit(self, rate: float) -> float:
        """The unit of `at` where one number names a member: the unit of rate, or 1 for an angle."""
        return 1.0 if self.by_angle else rate

    def member(self, functions: Any, at: Any, k: Any, unit: Any = 1.0) -> dict[str, Any]:
        """The states of a disk's member that one number names, over any number type.

        Parameters
        ----------
        functions
            sin, sqrt, … of the number type as attributes: `math`, `numpy`, `casadi`, `mpmath`.
        at
            Value of the state that names the member.
        k
            Inertia factor.
        unit
            Unit of rate, negative for a member with negative phi_dot.

        Returns
        -------
        dict
            The six states by name, in these units; `UPRIGHT` where theta is exactly π/2.
        """
        solved: dict[str, Any] = self.disk_unknown
        if self.solution is not None:
            solved = dict.fromkeys(solved, self.solution(functions, at, k, unit))
        return AT_REST | self.disk_held | solved | {self.at[0]: at}


AT_REST = {"theta_dot": 0.0, "slip_x": 0.0, "slip_y": 0.0}
"""States that vanish in every family."""


def tumbling(  # noqa: PLR0913
    slope: Any, r: Any, z: Any, sine: Any, cosine: Any, transverse: Any, axial: Any
) -> tuple[Any, Any]:
    """φ̇² over g/length, and ω₃/φ̇, of tumbling; the module's text has the symbols.

    Examples
    --------
    >>> tumbling(0.6, 1.0, 0.0, 0.8, 0.6, 0.25, 0.5)  # a disk: 1/(k sinθ), 0
    (5.0, 0.0)
    """
    return slope * r / (sine * (transverse * r * cosine - axial * z * sine)), sine * z / r


def _tumbling(functions: Any, theta: Any, k: Any, unit: Any) -> Any:
    """Phi_dot of a tumbling disk, from k phi_dot² sinθ = 1."""
    return unit / functions.sqrt(k * functions.sin(theta))


_RECORDS = (
    SteadyFamily(
        "rolling",
        ("omega3",),
        held={"phi_dot": 0.0},
        unknown={},
        level=True,
        motion="rolling straight ahead at constant inclination",
        disk="upright, rolling straight ahead",
        symbols="Upright, straight ahead: θ = π/2, φ̇ = 0, named by ω₃.",
        drifts=True,
        searched=(0.02, 50.0),
        drawn=(0.02, 3.0),
        sampled=(0.2, 4.0),
    ),
    SteadyFamily(
        "spinning",
        ("phi_dot",),
        held={"theta": UPRIGHT, "omega3": 0.0},
        unknown={},
        upright=True,
        motion="upright, turning about the vertical on the spot",
        turns=("vertical",),
        disk="upright, turning about its vertical diameter on the spot",
        symbols="Upright, turning on the spot: θ = π/2, ω₃ = 0, named by φ̇.",
        searched=(0.02, 50.0),
        drawn=(0.02, 5.0),
        flutter=(0.01, 100.0),
        sampled=(0.2, 6.0),
    ),
    SteadyFamily(
        "tumbling",
        ("theta",),
        held={},
        unknown={"phi_dot": 1.0, "omega3": 0.0},
        rests=True,
        motion="inclined, its centre at rest",
        positive=("phi_dot",),
        disk="inclined, its centre at rest, axial angular velocity zero",
        symbols="Inclined, its centre at rest: ω₃ = 0, φ̇² = g/(kR sin θ), named by θ.",
        held_by_disk={"omega3": 0.0},
        solution=_tumbling,
        searched=(1e-3, math.pi / 2),
        drawn=(0.02, math.pi / 2),
        flutter=(0.001, 1.5707),
        sampled=(0.1, 1.5),
    ),
    SteadyFamily(
        "circling",
        ("theta", "phi_dot"),
        held={},
        unknown={"omega3": 0.0},
        law="rough",
        motion="inclined, its contact point running round a circle without slip",
    ),
    SteadyFamily(
        "precession",
        ("theta", "phi_dot"),
        held={},
        unknown={"omega3": 0.0},
        law="smooth",
        motion="inclined, its centre at rest or in uniform straight motion, without friction",
    ),
    SteadyFamily(
        "vertical",
        ("omega_Z",),
        unknown={},
        pole=True,
        turns=("vertical",),
        held=dict.fromkeys(("axis_X", "axis_Y", "omega_X", "omega_Y"), 0.0),
        motion="its axis vertical, turning about it on the spot",
    ),
)
FAMILIES = {family.name: family for family in _RECORDS}
"""Every family by name.  A new one is one more record: docs/howto/family.md."""


def record_of(family: Any) -> SteadyFamily | None:
    """The record of a family by its name; None for anything else."""
    return FAMILIES.get(family) if isinstance(family, str) else None


def at_name(family: Any) -> str:
    """Name of the number that names members of a family by its name; `at` where none alone does.

    Parameters
    ----------
    family
        What the caller gave.

    Examples
    --------
    >>> at_name("rolling"), at_name("vertical"), at_name("precession")
    ('omega3', 'omega_Z', 'at')
    """
    record = record_of(family)
    return record.at[0] if record is not None and len(record.at) == 1 else "at"


def named_by(family: str) -> Kind:
    """Kind of the number that names a member of a family, by its name."""
    record = FAMILIES.get(family.partition(" ")[0])
    return Kind.ANGLE if record is not None and record.by_angle else Kind.ANGULAR_VELOCITY


def families_of_disk() -> dict[str, SteadyFamily]:
    """The families that a disk has, by name."""
    return {name: family for name, family in FAMILIES.items() if not family.pole}


def families_under(law: str) -> list[SteadyFamily]:
    """The families of the disk that exist under a contact law, by its name."""
    return [f for f in families_of_disk().values() if f.law in ("", law)]


def lines_under(law: str) -> list[SteadyFamily]:
    """The families under a law on which a disk may settle, by the name of the law."""
    return [f for f in families_under(law) if f.line]


def leaning() -> str:
    """Names of the families whose members a lean names, in words."""
    return listed([f.name for f in FAMILIES.values() if f.by_angle])
