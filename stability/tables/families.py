"""Table of the families with their conditions."""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

from ..bodies.contact_laws import LAWS
from ..bodies.disk import Disk
from ..bodies.thin_disk.disk_families import FAMILIES, disk_family
from ..systems.structure.structural_zeros import structure
from .conditions import scan


@dataclass(frozen=True)
class FamilyRow:
    """A family of steady motions."""

    family: str
    """Name of the family."""
    at: str
    """Quantities that name a member."""
    motion: str
    """The motion in words."""
    condition: str
    """Condition for a member, derived from the graph; dimensionless (m = R = g = 1)."""
    structural_zeros: dict[str, int]
    """Number of structural zeros by contact law."""
    thresholds: dict[str, list[float]]
    """Squares of `at` (`at` itself for an angle) where the smooth and rough verdicts change,
    for k = 1/4."""


@lru_cache(maxsize=8)
def condition(name: str) -> str:
    """The condition for a family, solved by SymPy from the graph's own equation.

    Parameters
    ----------
    name
        A key of `FAMILIES`.

    Returns
    -------
    str

    Examples
    --------
    >>> condition("tumbling")
    'phi_dot**2 = 1/(k*sin(theta))'
    """
    import sympy

    from ..algebra.number_types import sympy_algebra

    record = FAMILIES[name]
    family = disk_family(name, record.law or "viscous")
    if family.closed:
        return f"none: every {family.at[0]}"
    symbols = {n: sympy.Symbol(n, positive=True) for n in (*family.at, *family.unknown, "k", "mu")}
    arguments = [
        [symbols[n] for n in names] for names in (family.at, family.unknown, family.parameters)
    ]
    _, _, residual, *_ = family.graph.tangent.run(sympy_algebra(), arguments)
    [unknown] = family.unknown
    numerator = sympy.fraction(sympy.together(sympy.simplify(residual[0])))[0]
    if unknown in family.positive:  # solve for its square, since the sign is free
        square = sympy.Symbol("square", positive=True)
        [root] = sympy.solve(
            sympy.expand(numerator).subs(symbols[unknown], sympy.sqrt(square)), square
        )
        return f"{unknown}**2 = {sympy.simplify(root)}"
    roots = sympy.solve(numerator, symbols[unknown])
    if record.solution is not None:  # other roots belong to other families
        wanted = record.solution(sympy, symbols[family.at[0]], symbols["k"], 1)
        roots = [root for root in roots if sympy.simplify(root - wanted) == 0]
    [root] = roots
    return f"{unknown} = {sympy.simplify(root)}"


def families() -> list[FamilyRow]:
    """The families of steady motions with their conditions, derived from the graph.

    Returns
    -------
    list of FamilyRow
        One row for each family; thresholds are computed for the uniform disk.

    Source: equations of Przybylska & Rauch-Wojciechowski 2016; recomputed.

    Examples
    --------
    >>> [row.family for row in families()]
    ['rolling', 'spinning', 'tumbling', 'circling', 'precession']
    """
    rows = []
    for name, record in FAMILIES.items():
        laws = [record.law] if record.law else list(LAWS)
        zeros = {law: structure(disk_family(name, law)).zeros for law in laws}
        thresholds: dict[str, list[float]] = {}
        if record.searched:
            for law in (n for n in ("smooth", "rough") if n in laws):
                points = scan(record, Disk(), LAWS[law]())
                power = 1 if record.by_angle else 2
                thresholds[law] = [p.value**power for p in points]
        rows.append(
            FamilyRow(name, ", ".join(record.at), record.motion, condition(name), zeros, thresholds)
        )
    return rows
