"""Names of the tables, and where each is."""

from __future__ import annotations

from importlib import import_module

from ...base.errors import NameUnknownError, shown
from ..formats.table import Definition

PLACES = {
    "families": "families",
    "conditions": "conditions",
    "drift": "drift",
    "hopf": "hopf",
    "launches": "launches",
    "theorems": "proofs.theorems",
    "bodies": "proofs.bodies",
    "painleve": "proofs.painleve",
    "benchmarks": "benchmarks.catalogue",
    "circular": "literature.circular",
    "thresholds": "literature.thresholds",
    "flatness": "literature.flatness",
    "completeness": "proofs.completeness",
    "list": "contents.listing",
}
"""Module of each table, by name; its `TABLE` is the `Definition`."""


def definition(name: str) -> Definition:
    """The definition of a table.

    Parameters
    ----------
    name
        A key of `PLACES`.

    Returns
    -------
    Definition

    Raises
    ------
    NameUnknownError
        If the table is unknown.

    Examples
    --------
    >>> definition("drift").takes
    ('k', 'mu', 'contact', 'disk', 'tilt')
    """
    if name not in PLACES:
        known = ", ".join((*PLACES, "codimension"))
        raise NameUnknownError(f"table is {shown(name)}; known are {known}.")
    root = __package__.rpartition(".")[0]
    found: Definition = import_module(f"{root}.{PLACES[name]}").TABLE
    return found
