"""Systems, families and bodies in a module of the user, at `module:name` or `file.py:name`."""

from __future__ import annotations

import io
import os
import runpy
from contextlib import redirect_stdout
from importlib import import_module
from typing import Any

from ..base.errors import NameUnknownError, shown
from ..base.user_code import imported


def family_named(place: str) -> Any:
    """The family of that place."""
    from ..systems.family import Family

    return named_in("system", place, "family", "its families", (Family,))[0]


def system_with_families(place: str) -> tuple[Any, list[Any]]:
    """The system of that place, or that of the family there, and its families in the module."""
    from ..systems.equations import Equations
    from ..systems.family import Family

    words = "system and no family", "these"
    value, table = named_in("system", place, *words, (Equations, Family))
    system = value.system if isinstance(value, Family) else value
    families = [f for f in table.values() if isinstance(f, Family) and f.system == system]
    return system, list(dict.fromkeys(families))


def named_in(
    option: str, place: str, what: str, choices: str, kinds: tuple[type, ...], *, made: bool = False
) -> tuple[Any, dict[str, Any]]:
    """What a module of the user calls by a name, and all its names; what it prints is dropped.

    Parameters
    ----------
    option
        The option that names the place.
    place
        Module on Python's path or in this folder, or a file; then a name in it.
    what, choices
        What it must be, and all of these, in words.
    kinds
        Classes that it may have.
    made
        Whether it may be a function that makes one.

    Raises
    ------
    NameUnknownError
        If there is no such module, or nothing of that kind and name in it.
    """
    module, colon, name = place.rpartition(":")
    word = what.split()[0]
    dotted = all(part.isidentifier() for part in module.split("."))
    if not colon or not name.isidentifier() or not (dotted or module.endswith(".py")):
        raise NameUnknownError(
            f"{option} is {shown(place)}; give `module:{word}` or `file.py:{word}`."
        )
    folder = os.path.dirname(module) if module.endswith(".py") else os.getcwd()

    def names_of() -> dict[str, Any]:
        with redirect_stdout(io.StringIO()):
            if module.endswith(".py"):
                return runpy.run_path(module)
            return vars(import_module(module))

    remedy = f"give a module on Python's path or a file, and a {word} in it"
    table = imported(option, place, names_of, folder or os.getcwd(), remedy)
    value = table.get(name)
    if not isinstance(value, kinds) and not (
        made and callable(value) and not isinstance(value, type)
    ):
        names = sorted(n for n, v in table.items() if isinstance(v, kinds)) or ["none"]
        raise NameUnknownError(
            f"{shown(name)} is no {what} of {module}; {choices} are {', '.join(names)}."
        )
    return value, table
