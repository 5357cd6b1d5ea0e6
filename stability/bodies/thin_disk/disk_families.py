"""The disk's families of steady motions: one record for each, which every table reads."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import lru_cache
from typing import TYPE_CHECKING, Any

from ...algebra.upright import UPRIGHT, Upright
from ...base.errors import NameUnknownError, listed
from ...base.quantities import Kind

# the command line reads the records for its help, so functions import the heavy modules
if TYPE_CHECKING:
    from ...systems.family import Family
    from ..contact import Contact

Interval = tuple[float, float]


@dataclass(frozen=True, eq=False)
class DiskFamily:
    """A family of steady motions of the disk: every fact about it that is not derived.

    Every state is in `at`, `held` or `unknown`; theta_dot and the slip are zero throughout.
    Spectra, boundaries, maps and motions follow from the equations of motion.  Where
    `disk_polynomials.json` has no polynomial of the family, they use its graph.

    Examples
    --------
    >>> round(FAMILIES["tumbling"].member(math, math.pi / 6, 0.5)["phi_dot"], 12)
    2.0
    """

    name: str
    """Name in calls, tables and files."""
    at: tuple[str, ...]
    """States that name a member; formulas are solved for the last one."""
    held: Mapping[str, float | Upright]
    """Values of the states that are the same along the family: angles, `UPRIGHT` for the exact
    π/2, or 0 for rates."""
    unknown: Mapping[str, float]
    """First guesses of the states that are solved for, dimensionless."""
    motion: str
    """The motion in words."""
    symbols: str = ""
    """The motion in symbols, for the page of the atlas."""
    equations: tuple[str, ...] = ("theta_dot",)
    """States whose rates must vanish, as many as there are unknowns."""
    positive: tuple[str, ...] = ()
    """Unknowns that come out positive; the mirror image has the same spectrum."""
    solution: Callable[[Any, Any, Any, Any], Any] | None = None
    """The unknown as a function of (functions, at, k, unit), as for `member`; None where it is
    always 0 or has no formula.  Without a formula no motion is launched near the family."""
    law: str = ""
    """The one contact law under which the family exists; empty if it exists under every law."""
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
    launch: str = ""
    """Normal force over m g at the start of a launch, as a formula; empty where `table launches`
    leaves the family out."""

    @property
    def line(self) -> bool:
        """Whether one number names a member and gives its states: motions may settle there."""
        known = self.solution is not None or not any(self.unknown.values())
        return len(self.at) == 1 and known

    @property
    def by_angle(self) -> bool:
        """Whether theta alone names a member, so that a lean may name it too."""
        return self.at == ("theta",)

    def unit(self, rate: float) -> float:
        """The unit of `at` where one number names a member: the unit of rate, or 1 for an angle."""
        return 1.0 if self.by_angle else rate

    def member(self, functions: Any, at: Any, k: Any, unit: Any = 1.0) -> dict[str, Any]:
        """The states of a member that one number names, over any number type.

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
        solved: dict[str, Any] = dict(self.unknown)
        if self.solution is not None:
            solved = dict.fromkeys(self.unknown, self.solution(functions, at, k, unit))
        return AT_REST | dict(self.held) | solved | {self.at[0]: at}


AT_REST = {"theta_dot": 0.0, "slip_x": 0.0, "slip_y": 0.0}
"""States that vanish in every family."""


def _tumbling(functions: Any, theta: Any, k: Any, unit: Any) -> Any:
    """Phi_dot of tumbling, from k phi_dot² sinθ = 1."""
    return unit / functions.sqrt(k * functions.sin(theta))


_RECORDS = (
    DiskFamily(
        "rolling", ("omega3",), held={"theta": UPRIGHT}, unknown={"phi_dot": 0.0},
        motion="upright, rolling straight ahead",
        symbols="Upright, straight ahead: θ = π/2, φ̇ = 0, named by ω₃.",
        drifts=True,
        searched=(0.02, 50.0), drawn=(0.02, 3.0), sampled=(0.2, 4.0),
        launch="k/(k + c²)",
    ),
    DiskFamily(
        "spinning", ("phi_dot",), held={"theta": UPRIGHT}, unknown={"omega3": 0.0},
        motion="upright, turning about its vertical diameter on the spot",
        symbols="Upright, turning on the spot: θ = π/2, ω₃ = 0, named by φ̇.",
        searched=(0.02, 50.0), drawn=(0.02, 5.0), flutter=(0.01, 100.0), sampled=(0.2, 6.0),
        launch="k (1 + phi_dot² s c²)/(k + c²)",
    ),
    DiskFamily(
        "tumbling", ("theta",), held={"omega3": 0.0}, unknown={"phi_dot": 1.0},
        motion="inclined, its centre at rest, axial angular velocity zero",
        symbols="Inclined, its centre at rest: ω₃ = 0, φ̇² = g/(kR sin θ), named by θ.",
        positive=("phi_dot",), solution=_tumbling,
        searched=(1e-3, math.pi / 2), drawn=(0.02, math.pi / 2), flutter=(0.001, 1.5707),
        sampled=(0.1, 1.5),
    ),
    DiskFamily(
        "circling", ("theta", "phi_dot"), held={}, unknown={"omega3": 0.0}, law="rough",
        motion="inclined, its contact point running round a circle without slip",
    ),
    DiskFamily(
        "precession", ("theta", "phi_dot"), held={}, unknown={"omega3": 0.0}, law="smooth",
        motion="inclined, its centre at rest or in uniform straight motion, without friction",
    ),
)  # fmt: skip
FAMILIES = {family.name: family for family in _RECORDS}
"""Every family of the disk by name.  A new one is one more record:
docs/explanation/architecture.md."""


def named_by(family: str) -> Kind:
    """Kind of the number that names a member of a family of the disk or of a body, by its name."""
    record = FAMILIES.get(family.partition(" ")[0])
    return Kind.ANGLE if record is not None and record.by_angle else Kind.ANGULAR_VELOCITY


def families_under(law: str) -> list[DiskFamily]:
    """The families that exist under a contact law, by its name."""
    return [f for f in FAMILIES.values() if f.law in ("", law)]


def lines_under(law: str) -> list[DiskFamily]:
    """The families under a law on which a motion may settle, by the name of the law."""
    return [f for f in families_under(law) if f.line]


def leaning() -> str:
    """Names of the families whose members a lean names, in words."""
    return listed([f.name for f in FAMILIES.values() if f.by_angle])


def disk_family(name: str, law: str | Contact | type[Contact] | None = None) -> Family:
    """One of the disk's families under a contact law; dimensionless, built once.

    In each family the rate of theta_dot must vanish.  This equation is solved for phi_dot (rolling,
    tumbling) or omega3 (spinning, circling, precession).  Rolling and spinning satisfy it
    identically.

    Parameters
    ----------
    name
        A key of `FAMILIES`.
    law
        A contact law, its name or its class; its numbers stay parameters of the family.

    Returns
    -------
    Family
        The family, as `spectrum` and the others take it.

    Raises
    ------
    NameUnknownError, ParameterError
        If there is no such family under this law, or the law is missing.

    Source: Przybylska & Rauch-Wojciechowski 2016, Section 2; notebooks/theorems_disk.py proves
    that no law of friction has further steady motions.

    Examples
    --------
    >>> import stability as st
    >>> import math
    >>> st.disk_family("tumbling", "viscous").member([math.pi / 6], [0.5, 1.0]).round(12)[2]
    np.float64(2.0)
    """
    from ...base.checks import known
    from ..contact import Contact
    from ..contact_laws import LAWS, law_class, stored

    record = FAMILIES[known("family", name, FAMILIES)]
    law = type(law) if isinstance(law, Contact) else law
    if law is not None and not isinstance(law, type):
        known("contact", law, LAWS)
    contact = law_class(law, motion=False)
    word = contact.name
    if record.law and (record.law != word or not stored(contact)):
        own = families_under(word if stored(contact) else "")
        raise NameUnknownError(
            f"{name} is a family of the {record.law} disk; steady motions under the {word} law are "
            f"{listed([f.name for f in own])}."
        )
    return _disk_family(record, contact)  # type: ignore[arg-type]  # a class is hashable


@lru_cache(maxsize=32)
def _disk_family(record: DiskFamily, law: type[Contact]) -> Family:
    from ...systems.family import Family
    from ..contact_laws import stored
    from .disk_equations import disk_system

    system = disk_system(law)
    at_rest = {n: v for n, v in AT_REST.items() if n in system.states}
    return Family(
        system, record.name, record.at,
        held=dict(record.held) | at_rest, unknown=record.unknown, equations=record.equations,
        positive=record.positive,
        typical={"theta": 1.0, "phi_dot": 1.9, "omega3": 1.3, "k": 0.3}
        | dict.fromkeys(law.symbols(), 30.0 if law.holds else 0.7),
        conservative=law.conservative, integrals=law.conservative and stored(law),
        drifts=record.drifts and stored(law) and bool(law.parameters),
    )  # fmt: skip
