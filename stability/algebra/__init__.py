"""Numbers that a graph is read in, and polynomials in them.  Imports `base`."""

from typing import Any


def __getattr__(name: str) -> Any:
    """What was in the module of this name until version 0.4."""
    if name.startswith("__"):
        raise AttributeError(name)
    from ..old_paths import found

    return found(name, "stability.algebra", ("algebra.program", "algebra.number_types"))
