"""A user's family by name on the command line: `module:family`, or `folder/file.py:family`."""

from __future__ import annotations

import io
import os
import runpy
from collections.abc import Collection, Iterable, Mapping
from contextlib import redirect_stdout
from fractions import Fraction
from importlib import import_module
from typing import Any

from ..base.errors import NameUnknownError, ParameterError, shown
from ..base.exact_numbers import ratio_of_text, written
from ..base.quantities import readable
from ..base.user_code import imported


def family_named(place: str) -> Any:
    """The family at `module:name` or `file.py:name`; what the module prints is dropped.

    Parameters
    ----------
    place
        Module on Python's path or in this folder, or a file; then the name of a `Family`.

    Returns
    -------
    Family

    Raises
    ------
    NameUnknownError
        If there is no such module, or no family of that name in it.
    """
    from ..systems.family import Family

    module, name, table = contents("system", "family", place)
    if not isinstance(table.get(name), Family):
        names = sorted(n for n, v in table.items() if isinstance(v, Family)) or ["none"]
        raise NameUnknownError(
            f"{shown(name)} is no family of {module}; its families are {', '.join(names)}."
        )
    found: Any = table[name]
    return found


def contents(option: str, what: str, place: str) -> tuple[str, str, dict[str, Any]]:
    """Module, name, and all names of the module, from `module:name` or `file.py:name`.

    Parameters
    ----------
    option, what
        The option and what it names, for the messages.
    place
        The text.

    Raises
    ------
    NameUnknownError
        If the text is none of the two, or the module cannot be imported.
    """
    module, colon, name = place.rpartition(":")
    dotted = all(part.isidentifier() for part in module.split("."))
    if not colon or not name.isidentifier() or not (dotted or module.endswith(".py")):
        raise NameUnknownError(
            f"{option} is {shown(place)}; give `module:{what}` or `file.py:{what}`."
        )
    folder = os.path.dirname(module) if module.endswith(".py") else os.getcwd()

    def names_of() -> dict[str, Any]:
        with redirect_stdout(io.StringIO()):
            if module.endswith(".py"):
                return runpy.run_path(module)
            return vars(import_module(module))

    table = imported(
        option,
        place,
        names_of,
        folder or os.getcwd(),
        f"give a module on Python's path or a file, and a {what} in it",
    )
    return module, name, table


def system_with_families(place: str) -> tuple[Any, list[Any]]:
    """The system at `module:name` or `file.py:name`, and its families in the same module.

    Parameters
    ----------
    place
        Module on Python's path or in this folder, or a file; then the name of a `System`, or of a
        `Family`, whose system is meant.

    Returns
    -------
    system
        The system.
    families
        The families of it that the module names, each once.

    Raises
    ------
    NameUnknownError
        If there is no such module, or no system or family of that name in it.
    """
    from ..systems.equations import Equations
    from ..systems.family import Family

    module, name, table = contents("system", "name", place)
    found = table.get(name)
    system = found.system if isinstance(found, Family) else found
    if not isinstance(system, Equations):
        known = (n for n, v in table.items() if isinstance(v, Equations | Family))
        names = sorted(known) or ["none"]
        raise NameUnknownError(
            f"{shown(name)} is no system and no family of {module}; these are {', '.join(names)}."
        )
    own = [f for f in table.values() if isinstance(f, Family) and f.system == system]
    return system, list(dict.fromkeys(own))


def exact_numbers(
    option: str, texts: Iterable[str] | None, names: Collection[str], owner: str
) -> dict[str, Fraction]:
    """Numbers by name from texts NAME=NUMBER, exactly as they are written.

    Parameters
    ----------
    option
        The option that gives them, without dashes.
    texts
        The texts.
    names
        Names that are known.
    owner
        What has these names.
    """
    out: dict[str, Fraction] = {}
    for text in texts or ():
        name, equals, value = text.partition("=")
        if not equals:
            raise ParameterError(f"--{option} is {shown(text)}; give NAME=NUMBER.")
        if name in out:
            raise ParameterError(f"{name} is given twice; give it once.")
        if name not in names:
            known = ", ".join(names) or "none"
            raise NameUnknownError(f"--{option} names {shown(name)}; {owner} has {known}.")
        out[name] = ratio_of_text(name, value)
    return out


def doubles(given: Mapping[str, Fraction]) -> dict[str, Any]:
    """Numbers as their nearest doubles.

    Parameters
    ----------
    given
        Numbers by name.
    """
    return {n: float(v) for n, v in given.items()}


def place(family: Any, given: Mapping[str, Fraction]) -> str:
    """Numbers with names and units, as text.

    Parameters
    ----------
    family
        The family.
    given
        Numbers by name.
    """
    units = family.system.units
    named = {n: "" if units.get(n, "1") == "1" else f" {readable(units[n])}" for n in given}
    return ", ".join(f"{n} = {written(v)}{named[n]}" for n, v in given.items())
