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
    """Module, name, and all names of the module, from `module:name` or `file.py:name`."""
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
