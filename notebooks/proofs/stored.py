"""The polynomials that the package keeps as data, derived and written: `make derive`."""

from __future__ import annotations

import json
import re
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

import sympy

from stability.base.errors import FileError, StabilityError
from stability.bodies.contact_laws import LAWS
from stability.bodies.disk_polynomials import digest
from stability.bodies.families import families_under
from stability.derivation.characteristic import COS, LAM, MU, SIN
from stability.derivation.hurwitz import decisive
from stability.storage.files import atomic_write, together

from .body_polynomials import (
    BEND,
    I1,
    I3,
    PAIRS,
    PHI,
    PLACED,
    RHO,
    SPIN,
    STORED_LAWS,
    H,
    R,
    Z,
    characteristic,
    pair_polynomial,
)
from .disk_polynomials import derive

Expr = Any
"""A SymPy expression; SymPy states no types."""
VARIABLES = (I1, I3, H, BEND, R, Z, RHO, SIN, COS, PHI, SPIN, MU)
"""Variables of a body's polynomial; that of tumbling has no ω₃, that of rolling no r, z and ρ."""


def of_disk() -> dict[str, Any]:
    """Polynomials and conditions of the disk by family and law, for `bodies.disk_polynomials`."""
    cases: dict[str, Any] = {}
    for law in LAWS:
        for family in (record.name for record in families_under(law)):
            try:
                derived = derive(family, law)
            except StabilityError:  # not in the form needed: verdicts come from the graph
                continue
            names = derived.factors[0].gens[1:]
            used = [x for x in names if any(f.has(x) for f in derived.factors)]
            factors = [sympy.Poly(f.as_expr(), LAM).all_coeffs()[::-1] for f in derived.factors]
            found, _ = decisive(derived)
            cases[f"{family} {law}"] = {
                "variables": [str(x) for x in used],
                "zeros": int(derived.zeros),
                "even": bool(derived.even),
                "factors": [[terms(c, used) for c in factor] for factor in factors],
                "conditions": [
                    {"kind": c.kind, "terms": terms(c.polynomial.as_expr(), used)} for c in found
                ],
            }
    return {"format": 1, "cases": cases}


def of_bodies() -> dict[str, Any]:
    """Polynomials of every body by family and law, for `bodies.round_body.polynomials`.

    Each has `zeros`, `even`, and `coefficients` (terms of each, lowest power first).
    """
    cases: dict[str, Any] = {}
    for law in STORED_LAWS:
        for family in ("rolling", "tumbling"):
            found = characteristic(family, law)
            cases[f"{family} {law}"] = _record(found.zeros, found.coefficients[::-1])
    for family, law in PAIRS.items():
        poly = pair_polynomial(family, PLACED)
        zeros = min(n for (n,) in poly.monoms())
        cases[f"{family} {law}"] = _record(zeros, poly.all_coeffs()[::-1][zeros:])
    return {"format": 1, "cases": cases}


def _record(zeros: int, coefficients: Sequence[Expr]) -> dict[str, Any]:
    used = [v for v in VARIABLES if any(sympy.sympify(c).has(v) for c in coefficients)]
    return {
        "variables": [str(v) for v in used],
        "zeros": int(zeros),
        "even": all(c == 0 for c in coefficients[1::2]),
        "coefficients": [terms(c, used) for c in coefficients],
    }


def terms(expression: Expr, variables: Sequence[sympy.Symbol]) -> list[list[int]]:
    """A polynomial as lists of a coefficient and its exponents."""
    if expression == 0:
        return []
    poly = sympy.Poly(expression, *variables)
    return [[int(c), *map(int, powers)] for powers, c in poly.terms()]


def write(data: Path, module: Path, derived: Callable[[], dict[str, Any]]) -> list[str]:
    """Derive polynomials, compare them with the file, and write it, one case in each line.

    Parameters
    ----------
    data
        The file.
    module
        Source of the module that reads the file, which gets its digest.
    derived
        Function that derives them.

    Returns
    -------
    list of str
        Cases that differ from those of the file before.
    """
    found = derived()
    before = json.loads(data.read_bytes())["cases"] if data.exists() else {}
    names = [*before, *(key for key in found["cases"] if key not in before)]
    changed = [key for key in names if before.get(key) != found["cases"].get(key)]
    lines = [f"{json.dumps(key)}: {json.dumps(case)}" for key, case in found["cases"].items()]
    body = ",\n".join(lines)
    content = f'{{"format": 1, "cases": {{\n{body}\n}}}}\n'.encode()
    with together():
        with atomic_write(str(data), overwrite=True) as draft:
            draft.write_bytes(content)
        line = f'DIGEST = "{digest(content)}"'
        text = module.read_text(encoding="utf-8")
        text, count = re.subn(r'^DIGEST = "[0-9a-f]+"$', line, text, flags=re.MULTILINE)
        if count != 1:
            raise FileError(f"{module} has {count} lines for the digest; one is needed.")
        with atomic_write(str(module), overwrite=True) as draft:
            draft.write_text(text, encoding="utf-8")
    return changed


if __name__ == "__main__":
    bodies = Path(__file__).parents[2] / "stability" / "bodies"
    round_body = bodies / "round_body"
    for data, module, derived in (
        (bodies / "disk_polynomials.json", bodies / "disk_polynomials.py", of_disk),
        (round_body / "body_polynomials.json", round_body / "polynomials.py", of_bodies),
    ):
        print(f"{data.name} changed:", ", ".join(write(data, module, derived)) or "nothing")
