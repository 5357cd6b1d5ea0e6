"""Names, units and provenance of the numbers of a spectrum or of a map."""

from __future__ import annotations

import json
from collections.abc import Mapping
from datetime import UTC, datetime
from typing import Any

import numpy as np

from ..base.provenance import versions
from ..base.quantities import Kind, rate_unit, written
from ..base.verdict import CODES
from ..base.version import __version__
from ..bodies.quantities import SYSTEM

FORMAT = "stability map 1"
"""Attribute `format` of a file of a map, or of a spectrum."""
LIBRARIES = ("casadi", "numpy", "scipy", "python-flint", "xarray")


def axis_attributes(asked: Any, name: str) -> dict[str, str]:
    """Long name, unit and quantity of a parameter of a `Problem` or a `Spectrum`."""
    system, meaning = asked.family.system, asked.family.meaning(name)
    quantity = system.quantities.get(meaning)
    attributes = {"units": system.units.get(meaning, "1"), "long_name": meaning}
    if quantity is not None:
        attributes = quantity.attributes(dimensionless=asked.dimensionless)
    return attributes | {"quantity": meaning}


def rate_attributes(asked: Any) -> dict[str, str]:
    """Unit of rates of a `Problem` or a `Spectrum`."""
    system = asked.family.system
    if not system.quantities:
        return {"units": rate_unit(system.units)}
    return Kind.GROWTH_RATE.attributes(dimensionless=asked.dimensionless)


def verdict_attributes() -> dict[str, Any]:
    """Flags of the verdicts and their sentences."""
    return {
        "flag_values": np.array(list(CODES.values()), dtype=np.int8),
        "flag_meanings": " ".join(v.word for v in CODES),
        "long_name": "spectral verdict",
        "comment": "; ".join(str(v.value) for v in CODES),
    }


def _units(asked: Any, fixed: Mapping[str, Any]) -> dict[str, Any]:
    """Units of the fixed numbers, and the quantities of a body."""
    system = asked.family.system
    if asked.law:  # the numbers of a `Disk`, whose units its fields say
        return {"dimensionless": int(asked.dimensionless)}
    parameter_units = {n: system.units[n] for n in sorted(fixed) if n in system.units}
    units: dict[str, Any] = (
        {"parameter_units": json.dumps(parameter_units)} if parameter_units else {}
    )
    if system.quantities:
        units["dimensionless"] = int(asked.dimensionless)
        units["quantities"] = written(
            {n: q for n, q in system.quantities.items() if n in asked.values}
        )
    return units


def of_package(asked: Any) -> bool:
    """Whether the equations are those of the package, for the disk or a body of revolution."""
    return bool(asked.family.system.quantities)


def origin(asked: Any, fixed: Mapping[str, Any], *, citation: str, **more: Any) -> dict[str, Any]:
    """Origin of a result: family, numbers, source, versions, the time.

    Parameters
    ----------
    asked
        A `Problem` or a `Spectrum`.
    fixed
        Numbers by name, in the user's units.
    citation
        Keys of the works to cite.
    **more
        Further entries, before the source.

    Returns
    -------
    dict
        Strings and numbers that fit in a file's attributes.
    """
    family = asked.family
    return {
        "format": FORMAT,
        "title": f"{family.name} of {family.system.name}: spectral stability",
        "family": family.name,
        "system": family.system.name,
        **({"approximation": fit} if (fit := family.system.approximation) else {}),
        **({"contact": asked.law.name, "law": asked.law.formula} if asked.law else {}),
        "at": ", ".join(family.at),
        "parameters": json.dumps({n: float(v) for n, v in fixed.items()}, sort_keys=True),
        **_units(asked, fixed),
        **more,
        "source": "equations of Przybylska & Rauch-Wojciechowski, Regul. Chaotic Dyn. 21 (2016) "
        "204-231, linearisation recomputed"
        if family.system.name.startswith(SYSTEM)
        else "equations of a body of revolution by its height, linearised"
        if family.system.quantities
        else "user's system",
        "citation": citation,
        "software": f"stability {__version__}",
        "versions": versions(LIBRARIES),
        "created": datetime.now(UTC).isoformat(timespec="seconds"),
        "Conventions": "CF-1.11",
    }
