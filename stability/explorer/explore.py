"""`explore`: a stability diagram alive, as a page of its own or in a notebook."""

from __future__ import annotations

import os
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from ..base.checks import flag
from ..base.errors import NameUnknownError, ParameterError, listed, shown
from ..base.version import __version__
from ..bodies.contact import Contact
from ..bodies.contact_laws import LAWS, Viscous
from ..bodies.disk import Disk
from ..bodies.law_names import law_given
from ..storage.files import atomic_write
from ..storage.targets import check_suffix, check_target
from ..systems.family import Family
from .certificates import certificate
from .disk_subjects import FAMILY_NAMES, WORDS, disk_motion, disk_subject
from .page import page

ENDINGS = (".html",)
"""Endings of the file."""
CERTIFIED = (0.25, 0.5)
"""Values of k at which the diagrams over friction carry proved rectangles."""
MOTIONS = {"rolling": "Rolling", "spinning": "Spinning", "tumbling": "Tumbling"}
LAW_NAMES = {
    "smooth": "Smooth", "viscous": "Viscous", "linear-viscous": "Linear", "rough": "Rough",
}  # fmt: skip
"""Words on the buttons."""


def explore(
    family: str | Family = "spinning",
    *,
    at: float | None = None,
    contact: Contact | type[Contact] | str | None = None,
    disk: Disk | None = None,
    out: str | os.PathLike[str] | None = None,
    certify: bool = True,
    overwrite: bool = False,
    **parameters: Any,
) -> Any:
    """A stability diagram to explore: a page in one file, or a widget in a notebook.

    The page shows every disk family under every stored law, or one family of a user's system.  A
    reader moves the point and the parameters, and sees eigenvalues, verdict and proof, modes and
    launches, all computed in the page.

    Parameters
    ----------
    family
        rolling, spinning or tumbling: what is shown at first; or a `Family` of your own whose
        stability conditions are polynomials in its parameters.
    at
        Member that is shown at first; for the disk omega3, phi_dot [√(g/R)] or theta [rad].
    contact
        Contact law that is shown at first: a law, its class or its name; viscous when left out.
    disk
        The body that is shown at first, with m = R = g = 1: only its k is used.
    out
        File to write, ending in `.html`; a widget is returned when left out.
    certify
        Whether the page carries rectangles on which verdicts are proved.
    overwrite
        Whether an existing file may be replaced.
    **parameters
        Parameters of a law that is named, such as `mu` [1/√(gR)]; of a family of your own, values
        by name.

    Returns
    -------
    Path or widget
        The file, or an object that a notebook shows.

    Raises
    ------
    StabilityError
        In one sentence, if a name, a number or the file is not accepted, or a package is missing
        that the widget needs.

    Source: verdicts, eigenvalues and motions of the page are compared with those of the package in
    tests/explorer.

    Examples
    --------
    >>> import tempfile, stability as st
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     path = st.explore("spinning", mu=0.3, out=Path(folder) / "page.html")
    ...     path.stat().st_size < 1_500_000
    True
    """
    certify, overwrite = flag("certify", certify), flag("overwrite", overwrite)
    if out is not None:
        check_suffix(out, ENDINGS)
        check_target(out, overwrite=overwrite)
    if isinstance(family, Family):
        from .own_subject import own_page

        if contact is not None or disk is not None:
            given = "contact" if contact is not None else "disk"
            raise ParameterError(f"{given} belongs to the disk; leave it out of your own family.")
        data = own_page(family, at, parameters, certify=certify)
        title = f"{family.name} of {family.system.name}"
    else:
        data, title = _disk_page(family, at, contact, disk, parameters, certify), "Stability of a disk"
    if out is None:
        from .widget import widget

        return widget(data)
    with atomic_write(out, overwrite=overwrite) as draft:
        draft.write_text(page(data, title), encoding="utf-8")
    return Path(out)


def _disk_page(
    family: Any, at: Any, contact: Any, disk: Disk | None, parameters: Mapping[str, Any],
    certify: bool,
) -> dict[str, Any]:  # fmt: skip
    """Data of the page of the disk."""
    if family not in FAMILY_NAMES:
        raise NameUnknownError(
            f"family is {shown(family)}; give {listed(FAMILY_NAMES, 'or')}, or a Family of your own."
        )
    numbers = dict(parameters)
    law, values = _law(contact, numbers)
    values |= {"k": _k(disk)}
    if at is not None:
        values["at"] = at
    subjects = [disk_subject(name, one) for name in FAMILY_NAMES for one in LAWS]
    start = next(s for s in subjects if s.key == f"{family} {law}")
    for quantity in start.quantities:
        if quantity.name in values:
            values[quantity.name] = quantity.checked(values[quantity.name])
    planes: dict[str, list[Any]] = {}
    for subject in subjects if certify else ():
        over_k = "k" in subject.axes
        slices = [{}] if over_k else [{"k": k} for k in sorted({*CERTIFIED, values["k"]})]
        planes[subject.key] = [certificate(subject, held) for held in slices]
    return {
        "format": 1, "version": __version__, "solid": True,
        "start": {"subject": start.key, "values": values},
        "subjects": [s.told() for s in subjects], "motions": {n: disk_motion(n) for n in LAWS},
        "certificates": planes, "foot": _foot(),
        "names": {"families": MOTIONS, "laws": LAW_NAMES, "says": _says()},
    }  # fmt: skip


def _says() -> dict[str, str]:
    return {law: f"A thin disk, ring or hoop on a plane; {words}." for law, words in WORDS.items()}


def _foot() -> str:
    return (
        f"Made by stability {__version__}. Everything on this page is computed in it, from the "
        "exact polynomials and the equations of motion of the package; dimensionless numbers, "
        "m = R = g = 1."
    )


def _law(contact: Any, numbers: dict[str, Any]) -> tuple[str, dict[str, Any]]:
    """Name of the law and its dimensionless number."""
    if contact is None and not numbers:
        return Viscous.name, {}
    if isinstance(contact, str) and contact in LAWS and not numbers:
        return contact, {}
    if isinstance(contact, type) and contact in LAWS.values() and not numbers:
        return contact.name, {}
    law = law_given(contact, numbers)
    if numbers:
        raise NameUnknownError(f"{next(iter(numbers))} is no parameter of the {law.name} law.")
    if LAWS.get(law.name) is not type(law):
        raise NameUnknownError(
            f"contact is {shown(contact)}; the page draws {listed(list(LAWS), 'or')}."
        )
    return law.name, {"mu": float(v) for v in law.given.values()}


def _k(disk: Disk | None) -> float:
    """Inertia factor of one dimensionless disk."""
    if disk is None:
        return float(Disk().k)  # type: ignore[arg-type]  # one number
    if not isinstance(disk, Disk):
        raise ParameterError(f"disk is {shown(disk)}; give a stability.Disk.")
    scales = (disk.mass, disk.radius, disk.gravity)
    if any(not isinstance(v, float) for v in (*scales, disk.k)):
        raise ParameterError("disk holds arrays; give one body, the page varies k itself.")
    if any(v != 1.0 for v in scales):
        raise ParameterError(
            "disk has a mass, radius or gravity other than 1; the page is dimensionless: give "
            "Disk(k=...) and mu in units of 1/√(gR)."
        )
    return float(disk.k)
