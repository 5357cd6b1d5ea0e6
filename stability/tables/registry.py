"""Names of the tables, `table`, which computes them, and the list of tables."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from importlib import import_module
from typing import Any

import numpy as np

from ..base.citation import gathered, joined
from ..base.errors import NameUnknownError, ParameterError, StabilityError, listed, shown
from ..base.types import Progress
from ..bodies.contact_laws import class_named, law_named
from ..bodies.disk import Disk
from ..systems.family import Family
from .table import Definition, Table, framed, word

PLACES = {
    "families": "families",
    "conditions": "conditions",
    "drift": "drift",
    "hopf": "hopf",
    "painleve": "painleve",
    "benchmarks": "benchmarks.catalogue",
    "thresholds": "thresholds",
    "peers": "peers",
    "toys": "toys",
    "list": "registry",
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
        names = ", ".join((*PLACES, "codimension"))
        raise NameUnknownError(f"table is {shown(name)}; known are {names}.")
    entry: Definition = found_at(f"{PLACES[name]}:TABLE")
    return entry


def found_at(place: str) -> Any:
    """What stands at `module:name` of this folder."""
    module, _, name = place.partition(":")
    return getattr(import_module(f"{__package__}.{module}"), name)


OF_FAMILY = {
    "conditions": ((), "system_conditions:condition_table"),
    "hopf": (("x",), "beyond_linear:birth_table"),
    "codimension": (("x", "y"), "beyond_linear:point_table"),
}
"""Axes that a table of one family takes, and the function that makes it."""
OF_POINTS = ("k", "mu", "contact", "disk", "at")
"""Options of the table of codimension two of a disk's family."""
LISTS = ("k", "mu", "tilt")
"""Options that are lists of numbers."""


def table(
    name: str,
    family: Family | str | None = None,
    *,
    k: float | Sequence[float] | None = None,
    mu: float | Sequence[float] | None = None,
    contact: str | None = None,
    disk: Disk | None = None,
    body: Any = None,
    tilt: float | Sequence[float] | None = None,
    at: float | None = None,
    systems: str | Sequence[str] | None = None,
    x: Sequence[Any] | None = None,
    y: Sequence[Any] | None = None,
    positive: Sequence[str] = (),
    decimals: bool = False,
    progress: Progress | None = None,
    **parameters: Any,
) -> Table:
    r"""A registered table, recomputed: as text, CSV, JSON, LaTeX, or a pandas DataFrame.

    The arguments are the options of `stability table`.

    Parameters
    ----------
    name
        Any of list (the tables themselves), families, conditions, drift, hopf, codimension,
        painleve, benchmarks, thresholds, peers or toys.
    family
        A `Family` of your own, for conditions, hopf and codimension; one of the disk's families by
        name, for codimension.
    k, mu
        Inertia factors [-] and friction coefficients, each one number or several: for conditions,
        drift and hopf; for codimension one number.
    contact
        Name of a contact law, for the same tables.
    disk
        Gives mass, radius and gravity to the same tables; with `k` left out of codimension, k too.
    body
        A body of revolution, for painleve; the bodies of the package if left out.
    tilt
        Tilts [rad], for drift.
    at
        The member, for codimension.
    systems
        Names of systems or words of names, for benchmarks; all if left out.
    x, y
        Axes (name, low, high, points): both for codimension; x for hopf of your own family.
    positive, decimals
        As in `stability.conditions`, for conditions of your own family.
    progress
        Called with (pieces done, pieces in all).
    **parameters
        Numbers for parameters of your own family.

    Returns
    -------
    Table
        Rows as records, and `to_text`, `to_csv`, `to_json`, `to_latex`, `to_pandas`, `write`.

    Raises
    ------
    NameUnknownError, ParameterError
        If there is no such table, or an argument does not belong to it.

    Source: recomputed; each table says how.

    Examples
    --------
    >>> import stability as st
    >>> hopf = st.table("hopf", k=0.5, mu=1.0)
    >>> [(row["family"], row["kind"]) for row in hopf]
    [('spinning', 'elliptic'), ('tumbling', 'hyperbolic')]
    >>> print(st.table("drift", k=0.25, mu=1, tilt=0.01).to_latex().splitlines()[-1])
    \end{table*}
    """
    arguments = {
        "k": k,
        "mu": mu,
        "contact": contact,
        "disk": disk,
        "body": body,
        "tilt": tilt,
        "at": at,
        "systems": systems,
    }
    arguments = {n: v for n, v in arguments.items() if v is not None}
    axes = {n: v for n, v in (("x", x), ("y", y)) if v is not None}
    exact: dict[str, Any] = {"positive": tuple(positive)} if positive else {}
    exact |= {"decimals": True} if decimals else {}
    if family is not None or name == "codimension":
        return _of_family(name, family, arguments, axes, exact, parameters)
    chosen = definition(name)
    for key in parameters:
        takes = listed([n for n in chosen.takes if n != "progress"] or ["nothing"])
        raise NameUnknownError(
            f"{shown(key)} is not an argument of the table {name}; it takes {takes}."
        )
    for key in (*axes, *exact):
        raise ParameterError(
            f"{key} belongs to `table` with a family of your own (--system); leave it out."
        )
    for key in arguments:
        if key not in chosen.takes:
            raise ParameterError(f"{key} belongs to {_takers(key)} only; leave it out.")
    options = _checked(name, arguments)
    if "progress" in chosen.takes:
        options["progress"] = progress
    scaled = options.get("disk")
    plain = scaled is None or scaled.dimensionless
    how = " (recomputed)" if chosen.about else ""
    with gathered() as works:
        rows = chosen.rows(**options)
        more = chosen.more(**options) if chosen.more else {}
    return Table(
        name,
        f"{chosen.heading}{how}",
        chosen.columns,
        rows,
        plain,
        more,
        definition=chosen,
        citation=joined([chosen.cites, *works]),
    )


def _takers(key: str) -> str:
    """The tables that take an option, in words."""
    names = [f"`{name}`" for name in PLACES if key in definition(name).takes]
    names += ["`codimension`"] * (key in OF_POINTS)
    return listed([f"`table {names[0][1:]}", *names[1:]]) if names else "other tables"


def _checked(name: str, arguments: Mapping[str, Any]) -> dict[str, Any]:
    """Options of a table of the disk as arguments of the function of its rows."""
    options: dict[str, Any] = dict(arguments)
    for key in LISTS:
        if key in options:
            options[key] = [float(v) for v in np.atleast_1d(options[key])]
    if "contact" in options:
        law = options.pop("contact")
        class_named(law)
        if "mu" in options:
            law_named(law, options["mu"][0])
        options |= {"laws": [law]} if name == "conditions" else {"law": law}
    if "k" in options:
        Disk(k=options["k"])
    return options


# --- of one family ---


def _of_family(
    name: str,
    family: Family | str | None,
    arguments: Mapping[str, Any],
    axes: Mapping[str, Any],
    exact: Mapping[str, Any],
    parameters: Mapping[str, Any],
) -> Table:
    """A table of a family of the user's own, or of codimension two of one of the disk's."""
    if name not in OF_FAMILY:
        raise ParameterError(
            f"a family (--system) belongs to `table` {listed([*OF_FAMILY])}; leave it out."
        )
    if family is None:
        raise ParameterError("`table codimension` needs a family; give it as family.")
    wanted, place = OF_FAMILY[name]
    if set(axes) != set(wanted):
        needs = " and ".join(wanted) or "no axis"
        raise ParameterError(
            f"`table {name}` of a family takes {needs}: (name, low, high, points)."
        )
    if exact and name != "conditions":
        raise ParameterError(f"{next(iter(exact))} belongs to `table conditions`; leave it out.")
    numbers = {**arguments, **parameters}
    if not isinstance(family, Family):
        if name != "codimension":
            raise ParameterError(
                "a family by name belongs to `table codimension`; give a Family, such as "
                "disk_family(name, contact) or body.family(name, contact)."
            )
        numbers = _of_disk(numbers, [axis[0] for axis in axes.values()])
    else:
        for key in arguments:
            if key not in (*family.at, *family.parameters):
                raise ParameterError(
                    f"{key} belongs to the disk; with a family of your own leave it out."
                )
    made: Table = found_at(place)(family, *map(tuple, axes.values()), **exact, **numbers)
    return made


def _of_disk(arguments: Mapping[str, Any], swept: Sequence[str]) -> dict[str, Any]:
    """Arguments of a disk's family, one number each."""
    numbers = {"contact": "viscous", **arguments}
    for key in numbers:
        if key not in OF_POINTS:
            raise ParameterError(f"{key} is no option of `table codimension`; leave it out.")
    for key in ("k", "mu", "at"):
        values = np.atleast_1d(numbers.get(key, 0.0))
        if len(values) > 1:
            raise ParameterError(f"{key} has {len(values)} numbers; give one.")
        if key in numbers and key in swept:
            raise ParameterError(f"{key} is given as a number and as an axis; give it once.")
        if key in numbers:
            numbers[key] = float(values[0])
    disk = numbers.get("disk") or Disk()
    return numbers | {"disk": replace(disk, k=numbers.pop("k", disk.k))}


# --- the list of tables ---


def every_table() -> list[dict[str, str]]:
    """One row for each table.

    Raises
    ------
    StabilityError
        If a table does not say where it is from.

    Examples
    --------
    >>> [row["name"] for row in every_table()][:3]
    ['families', 'conditions', 'drift']
    """
    from .beyond_linear import POINTS

    every = {name: definition(name) for name in PLACES if name != "list"} | {"codimension": POINTS}
    rows = []
    for name, entry in every.items():
        if entry.about is None:
            raise StabilityError(f"the table {name} has no source; give its Definition `about`.")
        shows = entry.heading.format(name="a family").removesuffix(" (recomputed)")
        rows.append(
            {
                "name": name,
                "shows": shows,
                "source": entry.about.source,
                "published": entry.about.published,
                "recomputed": entry.about.recomputed,
                "difference": entry.about.difference,
                "status": str(entry.about.standing.value),
            }
        )
    return rows


def _list_text(table: Table) -> str:
    lines: list[str] = []
    for row in table.rows:
        lines += ["", f"{row['name']}: {row['shows']}"]
        lines += [f"    {c.name:<11} {row[c.name]}" for c in table.columns[2:]]
    return framed(table, lines[1:])


TABLE = Definition(
    "the tables, and whether each is reproduced or recomputed",
    (
        word("name", "name of the table"),
        word("shows", "what the table shows", share=0.15),
        word("source", "where equations, statements or values are from", share=0.17),
        word("published", "what of the source was at hand as printed", share=0.13),
        word("recomputed", "what the package computes, and by which route", share=0.15),
        word("difference", "largest difference from the known values", share=0.11),
        word("status", "whether the table is reproduced", "below"),
    ),
    every_table,
    notes=lambda table: [f"{len(table.rows)} tables; `stability table NAME` computes one."],
    text=_list_text,
    home=f"{__name__}:TABLE",
)
"""The table for the registry."""
