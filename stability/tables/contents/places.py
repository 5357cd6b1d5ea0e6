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
    "painleve": "painleve",
    "benchmarks": "benchmarks.catalogue",
    "thresholds": "thresholds",
    "list": "contents.listing",
}
"""Module of each table, by name; its `TABLE` is the `Definition`."""
NOTEBOOKS = {
    "theorems": "theorems_disk",
    "bodies": "theorems_steady and theorems_stability",
    "completeness": "theorems_steady",
}
"""Notebooks that prove what tables of earlier versions printed, by the table's name."""


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
        If the table is unknown, or has become a notebook.

    Examples
    --------
    >>> definition("drift").takes
    ('k', 'mu', 'contact', 'disk', 'tilt')
    """
    if name in NOTEBOOKS:
        raise NameUnknownError(
            f"table {name} is proved and printed by {NOTEBOOKS[name]} now, in the notebooks of the "
            "project and of its documentation."
        )
    if name not in PLACES:
        known = ", ".join((*PLACES, "codimension"))
        raise NameUnknownError(f"table is {shown(name)}; known are {known}.")
    root = __package__.rpartition(".")[0]
    found: Definition = import_module(f"{root}.{PLACES[name]}").TABLE
    return found
