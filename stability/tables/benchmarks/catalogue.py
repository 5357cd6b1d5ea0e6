"""Every system of the table, and the table itself."""

from __future__ import annotations

from collections.abc import Sequence

from ...base.checks import chosen
from ...base.citation import cited
from ...base.types import Progress
from ..table import About, Standing
from .bicycle import linear_bicycle, nonlinear_bicycle
from .oscillators import (
    axon,
    nerve,
    rotor,
    saddle,
    stick_slip,
    swinging,
    triangular_points,
    ziegler,
)
from .row import BenchmarkRow, Case, of_known_values, rows_of
from .spinning import gyropendulum, lagrange, liquid, sphere, tippe, vortices
from .wheels import hunting, sympy_disc, turning

CASES: dict[str, Case] = {
    "nonlinear bicycle": nonlinear_bicycle,
    "linear bicycle": linear_bicycle,
    "tippe top": tippe,
    "railway wheelset": hunting,
    "Watt governor": swinging,
    "Ziegler column": ziegler,
    "Lagrange top": lagrange,
    "triangular points": triangular_points,
    "Chaplygin sleigh": turning,
    "mass on a belt": stick_slip,
    "Jeffcott rotor": rotor,
    "rotating saddle": saddle,
    "SymPy's rolling disc": sympy_disc,
    "gyropendulum": gyropendulum,
    "Routh's sphere": sphere,
    "body in a liquid": liquid,
    "vortices about a vortex": vortices,
    "FitzHugh-Nagumo nerve": nerve,
    "Hodgkin-Huxley axon": axon,
}
"""The function of each system's rows, by name."""


def benchmark_rows(
    systems: str | Sequence[str] | None = None, progress: Progress | None = None
) -> list[BenchmarkRow]:
    """Every known value, recomputed.

    Parameters
    ----------
    systems
        Names from `CASES`, or words of names; every system when left out.
    progress
        Called with (systems done, systems in all).

    Raises
    ------
    NameUnknownError
        If a system is unknown.

    Source: each row names its own; tests/tables/test_benchmarks.py.

    Examples
    --------
    >>> for row in benchmark_rows(["Jeffcott rotor"]):
    ...     print(row.recomputed, row.below, row.above, row.status)
    250.0 stable unstable agrees to all digits
    """
    words = {name: name.split()[-1] for name in CASES}  # a refusal has room for these
    names = list(words) if systems is None else chosen("system", systems, words)
    return rows_of([CASES[name] for name in names], progress)


TABLE = of_known_values(
    "systems with known answers: known value, recomputed value, certified verdicts",
    benchmark_rows,
    ("systems", "progress"),
    about=About(
        "a paper, course or code for each system, named in its rows",
        "values of the rows that are marked `published`",
        "every value by this package, from the system's equations",
        Standing.PARTLY,
        largest=4e-10,
    ),
    cites=cited(eigenvalues=True, proofs=True),
    home=f"{__name__}:TABLE",
)
"""The table for the registry."""
