"""Number types, polynomials, bounds.

A CasADi graph is read in any number type: doubles with error bounds, balls, exact numbers, SymPy.
May import `base` only.
To add a number type: an `Algebra` in `number_types.py`, which is a table of functions by name; then
`Program.run` reads every graph in it.
To add an eigensolver: a function of matrices, given to `eigensolver` in `eigensolver.py`.
"""

from typing import Any


def __getattr__(name: str) -> Any:
    """What was in the module of this name until version 0.4."""
    from ..old_paths import found

    return found(
        name, "stability.algebra", ("algebra.program", "algebra.number_types", "algebra.upright")
    )
