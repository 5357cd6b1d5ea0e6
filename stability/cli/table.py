"""The command `table`."""

from __future__ import annotations

import argparse
from typing import Any

from ..base.errors import ParameterError, shown
from ..base.quantities import Kind
from ..storage.json_text import json_text
from .options import _axis, _bar


def _table(options: argparse.Namespace) -> None:
    from ..base.errors import NameUnknownError
    from ..tables.registry import TABLES, records
    from ..tables.render import text

    if options.name not in (*TABLES, "codimension"):
        known = ", ".join((*TABLES, "codimension"))
        raise NameUnknownError(f"table is {shown(options.name)}; known are {known}.")
    if options.system is not None or options.name == "codimension":
        _of_system(options)
        return
    for key in ("positive", "parameter", "decimals", "x", "y", "family"):
        if getattr(options, key):
            raise ParameterError(f"--{key} belongs to `table … --system`; leave it out.")
    settings = _table_settings(options)
    formulas: list[Any] = []
    with _bar("lines") as progress:
        if options.name in ("benchmarks", "conditions", "hopf", "launches", "theorems"):
            settings["progress"] = progress
        rows = [] if options.latex else records(options.name, **settings)
        if options.name == "conditions":
            from ..derivation.formulas import rows as formula_rows

            laws = settings.get("laws", ("smooth", "viscous", "rough"))
            formulas = formula_rows(laws, settings.get("k", (0.25, 0.5)), progress)
    if options.latex:
        from ..derivation.formulas import latex

        print("\n\n".join(latex(f) for f in formulas))
        return
    if options.json:
        from dataclasses import asdict

        body: dict[str, Any] = {
            "table": options.name,
            "heading": f"{TABLES[options.name]} (recomputed)",
            "rows": rows,
        }
        if formulas:
            body["formulas"] = [asdict(f) for f in formulas]
        print(json_text(body))
        return
    disk = settings.get("disk")
    plain = disk is None or disk.dimensionless
    if formulas:
        from ..tables.render import formula_lines

        print("\n".join(formula_lines(formulas)))
    print(text(options.name, rows, Kind.ANGULAR_VELOCITY.label(dimensionless=plain)))


DISK = ("k", "mu", "contact", "mass", "radius", "gravity", "tilt", "at", "time")
"""Options of tables of the disk."""


def _of_system(options: argparse.Namespace) -> None:
    """Print a table of a user's family, or points of codimension two of one of the disk's."""
    if options.name not in ("conditions", "hopf", "codimension"):
        raise ParameterError(
            "--system belongs to `table conditions`, `hopf` and `codimension`; leave it out."
        )
    if (options.system is None) == (options.family is None):
        raise ParameterError("give --system MODULE:FAMILY or --family, one of them.")
    if options.family is not None and options.name != "codimension":
        raise ParameterError("--family belongs to `table codimension`; leave it out.")
    for key in DISK if options.system is not None else ("tilt", "time"):
        if getattr(options, key) is not None:
            raise ParameterError(f"--{key} belongs to the disk; with --system leave it out.")
    if options.latex and options.json:
        raise ParameterError("--latex and --json are both given; give one of them.")
    if options.name == "conditions":
        _system_conditions(options)
        return
    for key in ("latex", "positive", "decimals"):
        if getattr(options, key):
            raise ParameterError(f"--{key} belongs to `table conditions`; leave it out.")
    (_system_hopf if options.name == "hopf" else _points)(options)


def _system_conditions(options: argparse.Namespace) -> None:
    from ..derivation.conditions import conditions
    from ..tables.system_conditions import printed
    from .system_option import family_named, numbers

    for key in ("x", "y"):
        if getattr(options, key) is not None:
            raise ParameterError(
                f"--{key} belongs to `table hopf` and `codimension`; leave it out."
            )
    family = family_named(options.system)
    positive = tuple(options.positive.split(",")) if options.positive else ()
    given: dict[str, Any] = {**numbers(options.parameter, family)}
    found = conditions(family, positive=positive, decimals=options.decimals, **given)
    form = "latex" if options.latex else "json" if options.json else "text"
    print(printed(found, form=form))


def _system_hopf(options: argparse.Namespace) -> None:
    from ..boundary.hopf import hopf
    from ..tables.beyond_linear import birth_json, birth_text
    from .system_option import doubles, family_named, numbers

    if options.x is None or options.y is not None:
        raise ParameterError("`table hopf --system` needs one axis, --x NAME:LO:HI:N.")
    family, axis = family_named(options.system), _axis(options.x, "--x")
    given = doubles(numbers(options.parameter, family))
    found = hopf(family, axis=axis, **given)
    text = birth_json(family.name, found) if options.json else birth_text(
        family.name, axis[0], found, family.system.units)  # fmt: skip
    print(text)


def _points(options: argparse.Namespace) -> None:
    from ..boundary.beyond_linear.two_parameters.points import codimension_two
    from ..tables.beyond_linear import point_json, point_text
    from .system_option import doubles, family_named, numbers

    if options.x is None or options.y is None:
        raise ParameterError("`table codimension` needs two axes, --x and --y NAME:LO:HI:N.")
    x, y = _axis(options.x, "--x"), _axis(options.y, "--y")
    if options.system is not None:
        family = family_named(options.system)
        given = doubles(numbers(options.parameter, family))
        found, name = codimension_two(family, x=x, y=y, **given), family.name
    else:
        found, name = (
            codimension_two(options.family, x=x, y=y, **_of_disk(options, x, y)),
            (options.family),
        )
    print(point_json(name, found) if options.json else point_text(name, found))


def _of_disk(options: argparse.Namespace, x: Any, y: Any) -> dict[str, Any]:
    """Arguments of a disk's family from options of the table, one number each."""
    from ..bodies.disk import Disk
    from ..bodies.law_names import class_named, law_named

    if options.parameter is not None:
        raise ParameterError("--parameter belongs to --system; leave it out.")
    for key in ("k", "mu", "at"):
        value = getattr(options, key)
        if value is not None and len(value) > 1:
            raise ParameterError(f"--{key} has {len(value)} numbers; give one.")
        if value is not None and key in (x[0], y[0]):
            raise ParameterError(f"{key} is given as --{key} and as an axis; give it once.")
    scales = {n: getattr(options, n) for n in ("mass", "radius", "gravity")}
    body = {n: v for n, v in scales.items() if v is not None}
    body |= {"k": options.k[0]} if options.k is not None else {}
    name = options.contact or "viscous"
    swept = "mu" in (x[0], y[0])
    law = class_named(name) if swept else law_named(
        name, None if options.mu is None else options.mu[0])  # fmt: skip
    at = None if options.at is None else options.at[0]
    return {"disk": Disk(**body), "contact": law, "at": at}


def _table_settings(options: argparse.Namespace) -> dict[str, Any]:
    """Options of a table as arguments of its function; options of other tables are refused."""
    from ..bodies.disk import Disk
    from ..bodies.law_names import law_named

    name = options.name
    settings: dict[str, Any] = {}
    if options.latex and (name != "conditions" or options.json):
        raise ParameterError("--latex belongs to `table conditions`, without --json.")
    _table_launch(options, settings)
    if name not in ("conditions", "drift", "hopf", "launches"):
        for key in ("k", "mu", "contact", "mass", "radius", "gravity"):
            if getattr(options, key) is not None:
                raise ParameterError(
                    f"--{key} belongs to `table conditions`, `drift`, `hopf` and `launches` only; "
                    "leave it out."
                )
        return settings
    for key in ("k", "mu"):
        if getattr(options, key) is not None:
            settings[key] = getattr(options, key)
    if options.contact is not None:
        law_named(options.contact, None if options.mu is None else options.mu[0], needed=False)
        key = "laws" if name == "conditions" else "law"
        settings[key] = [options.contact] if name == "conditions" else options.contact
    scales = {n: getattr(options, n) for n in ("mass", "radius", "gravity")}
    settings["disk"] = Disk(**{n: v for n, v in scales.items() if v is not None})
    if "k" in settings:
        Disk(k=settings["k"])
    return settings


def _table_launch(options: argparse.Namespace, settings: dict[str, Any]) -> None:
    """Add the options of `table drift` and `table launches` to the settings."""
    name = options.name
    if options.tilt is not None:
        if name not in ("drift", "launches"):
            raise ParameterError(
                "--tilt belongs to `table drift` and `launches` only; leave it out."
            )
        if name == "launches" and len(options.tilt) > 1:
            raise ParameterError(f"--tilt is {options.tilt}; `table launches` takes one tilt.")
        settings["tilt"] = options.tilt[0] if name == "launches" else options.tilt
    for key in ("at", "time"):
        if getattr(options, key) is not None:
            if name != "launches":
                raise ParameterError(f"--{key} belongs to `table launches` only; leave it out.")
            settings[key] = getattr(options, key)
