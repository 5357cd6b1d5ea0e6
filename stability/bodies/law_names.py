"""Contact laws by name, as on the command line: a stored law, or `module:Class` of a user's law."""

from __future__ import annotations

import os
from collections.abc import Collection, Mapping
from importlib import import_module
from typing import Any

from ..base.errors import NameUnknownError, ParameterError, meant, shown
from ..base.user_code import imported
from .contact import Contact
from .contact_laws import MOTION_LAWS, Viscous, as_called, law_class
from .dry_friction import RegularisedCoulomb


def law_named(
    name: str,
    mu: float | None,
    *,
    needed: bool = True,
    motion: bool = False,
    epsilon: float | None = None,
    others: Mapping[str, float] | None = None,
) -> Contact:
    """The contact law of that name, with its parameters.

    Parameters
    ----------
    name
        A key of `MOTION_LAWS`, or `module:Class` for a user's law.
    mu
        Friction coefficient [s/m, dry friction: -], or None for a law without one.  For
        `linear-viscous` it gives c = mu m g, with the same linearisation.
    needed
        Whether a missing coefficient is an error; otherwise its value is 1.
    motion
        Whether the law is for a motion; dry friction is accepted only then.
    epsilon
        Slip speed of `coulomb-regularised` [m/s].
    others
        Parameters of a user's law by name.

    Returns
    -------
    Contact

    Raises
    ------
    NameUnknownError
        If the law is unknown, or is refused by `law_class`.
    ParameterError
        If a parameter is missing or not positive, or the law does not have it.

    Examples
    --------
    >>> law_named("viscous", 0.3).mu
    0.3
    """
    law = class_named(name, motion=motion)
    given = {"mu": mu, "epsilon": epsilon} | dict(others or {})
    given = {n: v for n, v in given.items() if v is not None}
    for n in given:
        if n not in [p.name for p in law.parameters]:
            if n == "mu":
                raise ParameterError(
                    f"mu is given but the {law.name} law has no coefficient; leave it out."
                )
            where = "; it belongs to coulomb-regularised" if n == "epsilon" else ""
            raise ParameterError(f"{n} is given but the {law.name} law has none{where}.")
    for p in law.parameters:
        if not set(law.alternatives(p.name)) & set(given):
            _supply(law, p.name, given, needed=needed)
    return law(**given)


def law_given(
    contact: Any, given: dict[str, Any], *, motion: bool = False, swept: Collection[str] = ()
) -> Any:
    """The contact law of a call: an instance as it is, or a word or class with numbers by name.

    Parameters
    ----------
    contact
        What the caller gave; None counts as viscous where `mu` is given or swept.
    given
        Numbers by name; those of the law are taken out.
    motion
        As for `law_named`.
    swept
        Parameters of an axis, whose value is set later.

    Returns
    -------
    Contact
        Anything else that was given is returned as it is.

    Raises
    ------
    NameUnknownError, ParameterError
        As for `law_named`.

    Examples
    --------
    >>> law_given("viscous", {"mu": 0.3}).mu
    0.3
    """
    if contact is None and "mu" in (*given, *swept):
        contact = Viscous
    if not isinstance(contact, (str, type)):
        return contact
    law = (
        class_named(contact, motion=motion)
        if isinstance(contact, str)
        else law_class(contact, motion=motion)
    )
    own: dict[str, Any] = {}
    for p in law.parameters:
        if p.name in swept and p.name in given:
            raise ParameterError(f"{p.name} is given as a value and as an axis; give it once.")
        if p.name in given:
            own[p.name] = given.pop(p.name)
        elif p.name in swept and not set(law.alternatives(p.name)) & set(own):
            own[p.name] = 1.0  # the axis replaces this value
    for p in law.parameters:
        if not set(law.alternatives(p.name)) & set(own):
            refuse_misspelt(law, given)
            word = "mu" if "mu" in law.alternatives(p.name) else p.name
            named = f", or contact={law.name!r} with {word}=NUMBER" * (law in MOTION_LAWS.values())
            axis = f", or make {word} an axis" * bool(swept)
            raise ParameterError(f"{word} is missing; give {as_called(law, word)}{named}{axis}.")
    return law(**own)


def refuse_misspelt(law: type[Contact], given: Collection[str]) -> None:
    """Refuse a name that the law does not have, before a parameter that it has is missing.

    Parameters
    ----------
    law
        The law.
    given
        Names that the caller gave.
    """
    names = [n for p in law.parameters for n in (p.name, *law.alternatives(p.name))]
    for name in given:
        near = meant(name, names)
        if near and near != name:
            raise NameUnknownError(f"{shown(name)} is not an argument here; {near} is.")


def law_only(contact: Any, given: dict[str, Any], *, motion: bool = False) -> Any:
    """The contact law of a call that takes no other numbers by name.

    Parameters
    ----------
    contact, given, motion
        As for `law_given`.

    Returns
    -------
    Contact
        Anything else that was given is returned as it is.

    Raises
    ------
    NameUnknownError, ParameterError
        As for `law_given`, or if a number belongs to no law.

    Examples
    --------
    >>> law_only("rough", {}).name
    'rough'
    """
    law = law_given(contact, given, motion=motion)
    for name in given:
        refuse_misspelt(Viscous, given)
        raise ParameterError(
            f"{shown(name)} is not an argument here; the disk's numbers go in disk=Disk(...), and "
            "in contact=Viscous(mu) or contact='viscous' with mu=NUMBER."
        )
    return law


def class_named(name: str, *, motion: bool = False) -> type[Contact]:
    """The class of a contact law by its name; arguments as in `law_named`."""
    own = isinstance(name, str) and ":" in name
    return law_class(_imported(name) if own else name, motion=motion)


def _supply(law: type[Contact], name: str, given: dict[str, Any], *, needed: bool) -> None:
    """Set a coefficient that is not needed to 1, or refuse one that is missing."""
    if name == "epsilon" and law is RegularisedCoulomb:
        raise ParameterError(
            "epsilon is missing; coulomb-regularised needs the slip speed below which its "
            "force gives way (--epsilon)."
        )
    name = "mu" if "mu" in law.alternatives(name) else name
    if needed:
        option = "--mu" if name == "mu" else f"--set {name}=VALUE"
        raise ParameterError(
            f"{name} is missing; the {law.name} law needs a positive coefficient ({option})."
        )
    given[name] = 1.0


def _imported(place: str) -> Any:
    """The class at `module:Class`, found from the working directory too."""
    module, _, name = place.partition(":")
    if not all(part.isidentifier() for part in (*module.split("."), name)):
        raise NameUnknownError(f"contact is {shown(place)}; give `module:Class`.")
    found = imported(
        "contact",
        place,
        lambda: getattr(import_module(module), name),
        os.getcwd(),
        "give a module on Python's path or in this folder, and a class in it",
    )
    if not (isinstance(found, type) and issubclass(found, Contact) and found.name):
        raise NameUnknownError(
            f"contact is {shown(place)}, which is not a subclass of Contact with a name of its own."
        )
    return found
