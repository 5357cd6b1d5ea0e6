"""A user's family by name on the command line: `module:family`, or `folder/file.py:family`."""

from __future__ import annotations

import io
import os
import runpy
from contextlib import redirect_stdout
from importlib import import_module
from typing import Any

from ..base.errors import NameUnknownError, ParameterError, shown
from ..base.user_code import imported
from .options import _number


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

    module, colon, name = place.rpartition(":")
    dotted = all(part.isidentifier() for part in module.split("."))
    if not colon or not name.isidentifier() or not (dotted or module.endswith(".py")):
        raise NameUnknownError(
            f"system is {shown(place)}; give `module:family` or `file.py:family`."
        )
    folder = os.path.dirname(module) if module.endswith(".py") else os.getcwd()

    def names_of() -> dict[str, Any]:
        with redirect_stdout(io.StringIO()):
            if module.endswith(".py"):
                return runpy.run_path(module)
            return vars(import_module(module))

    table = imported(
        "system", place, names_of, folder or os.getcwd(),
        "give a module on Python's path or a file, and a family in it",
    )  # fmt: skip
    if not isinstance(table.get(name), Family):
        names = sorted(n for n, v in table.items() if isinstance(v, Family)) or ["none"]
        raise NameUnknownError(
            f"{shown(name)} is no family of {module}; its families are {', '.join(names)}."
        )
    return table[name]


def numbers(texts: Any) -> dict[str, float]:
    """Parameters by name from texts NAME=NUMBER.

    Parameters
    ----------
    texts
        Texts, or None.
    """
    out: dict[str, float] = {}
    for text in texts or ():
        name, equals, value = text.partition("=")
        if not equals:
            raise ParameterError(f"--parameter is {shown(text)}; give NAME=NUMBER.")
        if name in out:
            raise ParameterError(f"{name} is given twice; give it once.")
        out[name] = _number(value, name)
    return out
