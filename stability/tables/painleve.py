"""Table of Painlevé's limit of mu |vx|: of one body, or of the bodies of the package."""

from __future__ import annotations

import math
from typing import Any

from ..base.citation import cited
from ..base.quantities import Kind
from ..base.types import Progress
from .table import About, Column, Definition, Standing, Table, word


def _rows(body: Any = None, progress: Progress | None = None) -> list[dict[str, Any]]:
    from ..bodies.painleve import painleve_limit

    named = bodies() if body is None else [(_name(body), body, "")]
    rows = []
    for done, (name, outline, closed) in enumerate(named, start=1):
        limit = painleve_limit(outline)
        ends = (v if math.isfinite(v) else None for v in (limit.low, limit.high))
        low, high = ends
        rows.append(
            {"body": name, "limit": low, "at_most": high, "theta": limit.theta, "closed": closed}
        )
        if progress is not None:
            progress(done, len(named))
    return rows


def bodies() -> list[tuple[str, Any, str]]:
    """Bodies of the table: name, body, and the closed form of its limit if there is one."""
    import casadi as ca

    from ..bodies.round_body.body import Body
    from ..bodies.round_body.shapes.named import EccentricSphere, Spheroid, ThickDisk, Torus
    from ..bodies.round_body.shapes.profile import Egg

    disk = {
        k: Body(lambda theta: ca.sin(theta), axial=2 * k, transverse=k, name="disk")
        for k in (0.25, 0.5)
    }
    return [
        ("disk, k = 0.25", disk[0.25], "2 √(k(k+1))"),
        ("disk, k = 0.5", disk[0.5], "2 √(k(k+1))"),
        ("thick disk, t = 0.2", ThickDisk(0.2), "2 √(κ(κ+1))"),
        ("torus, b = 0.1", Torus(0.1), ""),
        ("torus, b = 0.3", Torus(0.3), ""),
        ("hollow torus, b = 0.1", Torus(0.1, solid=False), ""),
        ("spheroid, aspect 0.5", Spheroid(0.5), ""),
        ("spheroid, aspect 1.5", Spheroid(1.5), ""),
        ("eccentric sphere, e = 0.1", EccentricSphere(0.1), ""),
        ("eccentric sphere, e = 0.3", EccentricSphere(0.3), ""),
        ("egg, taper 0.2", Egg(0.2), ""),
    ]


def _name(body: Any) -> str:
    """Name of a body and its numbers, as far as it has these."""
    numbers = getattr(body, "given", None)
    if numbers is None:
        k = getattr(body, "k", None)
        return "disk" if k is None else f"disk, k = {k}"
    left = ("mass", "gravity", "length")
    return ", ".join([body.name, *(f"{n} = {v}" for n, v in numbers.items() if n not in left)])


def _notes(table: Table) -> list[str]:
    unbounded = any(row["limit"] is None or row["at_most"] is None for row in table.rows)
    return [
        "D = I1 + h′² - mu vx h h′ > 0 at every inclination exactly where mu |vx| is below the",
        "limit, which lies between the two numbers (proved in balls). mu is the viscous",
        "coefficient, vx the slip along x̂; mu |vx| has no unit.",
        *(["A ball has no limit: - is infinity."] if unbounded else []),
    ]


TABLE = Definition(
    "Painlevé's limit of mu |vx|, up to which the plane holds a body at every inclination",
    (
        word("body", "body, with its numbers"),
        Column("limit", "proved lower end of the limit", form="{:.17g}"),
        Column("at_most", "proved upper end of the limit", form="{:.17g}"),
        Column("theta", "inclination near which D vanishes first", Kind.ANGLE, r"\theta"),
        word("closed", "closed form of the limit, if there is one"),
    ),
    _rows,
    ("body", "progress"),
    _notes,
    about=About(
        "this package: the condition D > 0 of the general graph",
        "no value",
        "least value of (I1 + h′²)/(h |h′|), enclosed by bisection in balls",
        Standing.DERIVED,
    ),
    cites=cited(model=True, proofs=True),
    home=f"{__name__}:TABLE",
)
"""The table for the registry."""
