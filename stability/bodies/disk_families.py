"""The disk's steady motions: rolling, spinning, tumbling, circling (rough), precession (smooth)."""

from __future__ import annotations

from functools import lru_cache

from ..algebra.number_types import UPRIGHT, Upright
from ..base.checks import known
from ..base.errors import NameUnknownError
from ..systems.family import Family
from .contact import Contact
from .contact_laws import LAWS, law_class, stored
from .disk_equations import disk_system

ONLY = {"circling": "rough", "precession": "smooth"}
"""The law of each family of one law alone; both have two parameters."""
FAMILIES = ("rolling", "spinning", "tumbling", *ONLY)
"""Names of the disk's families."""

AT = {
    "rolling": ("omega3",),
    "spinning": ("phi_dot",),
    "tumbling": ("theta",),
    "circling": ("theta", "phi_dot"),
    "precession": ("theta", "phi_dot"),
}
"""What names a member of each family."""


def disk_family(name: str, law: str | type[Contact]) -> Family:
    """One of the disk's families under a contact law; dimensionless, built once.

    In each the rate of theta_dot is the equation to solve: for phi_dot (rolling, tumbling) or
    omega3 (spinning, circling, precession).  Rolling and spinning turn out to solve it identically.

    Parameters
    ----------
    name
        One of `FAMILIES`.
    law
        A key of `stability.bodies.contact_laws.LAWS`, or the class of a law.

    Returns
    -------
    Family

    Raises
    ------
    NameUnknownError
        If there is no such family under this law.

    Source: Przybylska & Rauch-Wojciechowski 2016, Section 2; that the viscous law has no further
    steady motions is proved in `stability.derivation.completeness`.

    Examples
    --------
    >>> import math
    >>> disk_family("tumbling", "viscous").member([math.pi / 6], [0.5, 1.0]).round(12)[2]
    np.float64(2.0)
    """
    known("family", name, FAMILIES)
    if isinstance(law, str) or not isinstance(law, type):
        known("contact", law, LAWS)
    contact = law_class(law, motion=False)
    word = contact.name
    if ONLY.get(name, word) != word or (name in ONLY and not stored(contact)):
        own = [n for n in ONLY if ONLY[n] == word and stored(contact)]
        others = [n for n in FAMILIES if n not in ONLY or n in own]
        raise NameUnknownError(
            f"{name} is a family of the {ONLY[name]} disk; steady motions under the {word} law are "
            f"{', '.join(others[:-1])} and {others[-1]}."
        )
    return _disk_family(str(name), contact)  # type: ignore[arg-type]  # a class is hashable


@lru_cache(maxsize=32)
def _disk_family(name: str, law: type[Contact]) -> Family:
    system = disk_system(law)
    rest: dict[str, float | Upright] = {"theta_dot": 0.0}
    if law.slips:
        rest |= {"slip_x": 0.0, "slip_y": 0.0}
    given: dict[str, tuple[dict[str, float | Upright], dict[str, float]]] = {
        "rolling": ({"theta": UPRIGHT}, {"phi_dot": 0.0}),
        "spinning": ({"theta": UPRIGHT}, {"omega3": 0.0}),
        "tumbling": ({"omega3": 0.0}, {"phi_dot": 1.0}),
        "circling": ({}, {"omega3": 0.0}),
        "precession": ({}, {"omega3": 0.0}),
    }
    held, unknown = given[name]
    return Family(
        system, name, AT[name],
        held=held | rest, unknown=unknown, equations=("theta_dot",),
        positive=("phi_dot",) if name == "tumbling" else (),
        typical={"theta": 1.0, "phi_dot": 1.9, "omega3": 1.3, "k": 0.3}
        | dict.fromkeys(law.symbols(), 0.7),
        conservative=law.conservative, integrals=law.conservative and stored(law),
        drifts=name == "rolling" and stored(law) and bool(law.parameters),
    )  # fmt: skip
