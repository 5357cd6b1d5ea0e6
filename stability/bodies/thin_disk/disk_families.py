"""The disk's families of steady motions as a `Family` under a contact law."""

from __future__ import annotations

from functools import lru_cache

from ...base.checks import known
from ...base.errors import NameUnknownError, listed
from ...systems.family import Family
from ..contact import Contact
from ..contact_laws import LAWS, law_class, stored
from ..families import AT_REST, FAMILIES, SteadyFamily, families_of_disk, families_under
from .disk_equations import disk_system


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
    record = FAMILIES[known("family", name, families_of_disk())]
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
def _disk_family(record: SteadyFamily, law: type[Contact]) -> Family:
    system = disk_system(law)
    at_rest = {n: v for n, v in AT_REST.items() if n in system.states}
    return Family(
        system,
        record.name,
        record.at,
        held=record.disk_held | at_rest,
        unknown=record.disk_unknown,
        equations=("theta_dot",) * bool(record.disk_unknown),
        positive=record.positive,
        typical={"theta": 1.0, "phi_dot": 1.9, "omega3": 1.3, "k": 0.3}
        | dict.fromkeys(law.symbols(), 30.0 if law.holds else 0.7),
        conservative=law.conservative,
        integrals=law.conservative and stored(law),
        drifts=record.drifts and stored(law) and bool(law.parameters),
    )
