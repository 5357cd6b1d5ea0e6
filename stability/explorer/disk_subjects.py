"""The disk's families for the page: stored polynomials, equations of motion, words."""

from __future__ import annotations

import math
from collections.abc import Mapping
from functools import partial
from types import SimpleNamespace
from typing import Any

import casadi as ca

from ..algebra.number_types import Algebra
from ..algebra.program import Program
from ..algebra.upright import UPRIGHT
from ..base.quantities import Kind
from ..bodies.contact_laws import LAWS, MOTION_LAWS
from ..bodies.families import FAMILIES, SteadyFamily
from ..bodies.thin_disk.disk_equations import STATES, disk_system
from ..bodies.thin_disk.disk_model import POSE, disk_model, pose_rates
from ..bodies.thin_disk.disk_polynomials import PLAIN, DiskPolynomial, exact_polynomial
from ..bodies.thin_disk.disk_quantities import QUANTITIES
from .source.formulas import Rule, Values, filled, polynomial_signs, typeset
from .source.frames import frame_of_angles
from .source.source_text import graph, javascript
from .subject import Quantity, Subject

FAMILY_NAMES = tuple(f.name for f in FAMILIES.values() if f.drawn)
"""Families of the page, which one number names."""
WORDS = {
    "smooth": "no friction", "viscous": "viscous friction, −μ\u00a0N\u00a0v",
    "linear-viscous": "linear viscous friction, −c\u00a0v", "rough": "no slip",
}  # fmt: skip
"""Each law in words."""
STARTS = {"rolling": 1.2, "spinning": 2.2, "tumbling": 0.9}
"""Member that is shown at first, dimensionless."""
FRICTION = 0.02, 3.0
"""Range of mu* on the page."""
INERTIA = 0.05, 0.5
"""Range of k on the page."""
FLAT = math.sin(1e-6)
"""Sine of the angle that counts as flat, as in `simulate`."""
BODIES = ((0.25, "uniform disk"), (0.3125, "ring, inner radius R/2"), (0.5, "hoop"))
"""Values of k with a name."""


def disk_subject(name: str, law: str) -> Subject:
    """One of the disk's families under a stored law.

    Parameters
    ----------
    name
        rolling, spinning or tumbling.
    law
        A key of `stability.bodies.contact_laws.LAWS`.

    Examples
    --------
    >>> disk_subject("rolling", "viscous").texts
    (('2<i>k</i><i>ω₃</i><sup>2</sup> − 1', '2 · {k} · {at}<sup>2</sup> − 1'),)
    """
    record, exact = FAMILIES[name], DiskPolynomial(exact_polynomial(name, law))
    contact = MOTION_LAWS[law]
    names = ("at", *contact.symbols(), "k")
    system = disk_system(law)
    symbol = QUANTITIES[record.at[0]].symbol
    written = {"k": ("k", 1), "M": ("μ", 2), "z": (symbol, 2), "s": ("sin θ", 1)}
    if law == "linear-viscous":
        written["M"] = ("c", 2)
    put = {"k": ("{k}", 1), "M": ("{mu}", 2), "z": ("{at}", 2), "s": ("(sin {at})", 1)}
    x, p, pose = system.x, system.p, ca.SX.sym("pose", len(POSE))
    rates = pose_rates(x, system.observables["slip"], pose)
    known = exact.known
    rules = tuple(Rule(kind, rule, PLAIN) for kind, rule in known.conditions)
    frame = frame_of_angles(x[0], pose, ca.sin(x[0]), ca.cos(x[0]))
    return Subject(
        key=f"{name} {law}", family=name, law=law, title=record.disk_motion,
        quantities=tuple(_quantities(record, law, names)),
        axes=("at", "mu" if "mu" in names else "k"),
        even=(known.even,) * len(known.factors), zeros=known.zeros,
        coefficients=partial(_coefficients, exact, names),
        rules=rules, signs=partial(polynomial_signs, rules, partial(_variables, exact, names)),
        texts=tuple((typeset(r, written), filled(r, put)) for _, r in known.conditions),
        states=system.states,
        member=javascript([len(names)], partial(_member, record, names, len(system.states))),
        jacobian=graph(Program(ca.Function("slopes", [x, p], [ca.jacobian(system.rhs, x)]))),
        model=law, pose=graph(Program(ca.Function("pose", [x, p, pose], [rates]))),
        frame=graph(Program(ca.Function("frame", [x, p, pose], [frame]))), still=(0.0,) * len(POSE),
        call={"kind": "disk", "family": name, "law": law, "state": record.at[0],
              "class": LAWS[law].__name__, "si": {"mu": "c"} if law == "linear-viscous" else {}},
        parameters=tuple(names.index(n) for n in system.parameters),
        symbols={n: QUANTITIES[n].symbol for n in STATES},
    )  # fmt: skip


def _quantities(record: SteadyFamily, law: str, names: tuple[str, ...]) -> list[Quantity]:
    state = QUANTITIES[record.at[0]]
    low, high = record.drawn or (0.02, 3.0)
    angle, linear = record.by_angle, law == "linear-viscous"
    found = {
        "at": Quantity(
            "at", state.symbol, state.long_name, "rad" if angle else "√(g/R)", low,
            round(high, 2) if angle else high, STARTS[record.name], 0.0 if angle else None,
            math.pi if angle else None, kind=state.kind,
        ),
        "mu": Quantity(
            "mu", "c" if linear else "μ", "friction coefficient",
            "m √(g/R)" if linear else "1/√(gR)",
            *FRICTION, 0.3, 0.0, kind=Kind.DRAG if linear else Kind.INVERSE_VELOCITY,
        ),
        "k": Quantity(
            "k", "k", "inertia factor", "m R²", *INERTIA, 0.25, 0.0, 0.5 + 1e-12, BODIES
        ),
    }  # fmt: skip
    return [found[n] for n in names]


def _given(names: tuple[str, ...], q: Values) -> dict[str, Any]:
    """Quantities by name, with the units of the dimensionless disk."""
    return {"mass": 1, "radius": 1, "gravity": 1} | dict(zip(names, q, strict=True))


def _variables(
    exact: DiskPolynomial, names: tuple[str, ...], algebra: Algebra, q: Values
) -> list[Any]:
    return exact.point(_given(names, q), algebra)


def _coefficients(
    exact: DiskPolynomial, names: tuple[str, ...], algebra: Algebra, q: Values
) -> list[list[Any]]:
    """Coefficients in λ: with λ = σ · scale the power i has the factor scale^(n - i)."""
    scale, _ = exact.scale(_given(names, q))
    found = []
    for factor in exact.known.coefficients(_variables(exact, names, algebra, q)):
        powers: list[Any] = [1.0]
        for _ in factor[1:]:
            powers.append(powers[-1] if scale is None else scale * powers[-1])
        found.append([c * s for c, s in zip(factor, reversed(powers), strict=True)])
    return found


def _member(
    record: SteadyFamily, names: tuple[str, ...], count: int, algebra: Algebra, q: Values
) -> list[Any]:
    given = dict(zip(names, q, strict=True))
    functions = SimpleNamespace(**algebra.functions)
    found = record.member(functions, given["at"], given["k"])
    return [math.pi / 2 if found[n] is UPRIGHT else found[n] for n in STATES[:count]]


def disk_motion(law: str) -> Mapping[str, Any]:
    """Equations, guards and observables of a launch under a law.

    Parameters
    ----------
    law
        A key of `stability.bodies.contact_laws.LAWS`.

    Returns
    -------
    dict
        Record of the page.
    """
    model = disk_model(law, pose=True)
    observed = {"energy": model.series["energy"], "normal force": model.series["normal_force"]}
    count = len(model.system.states)
    guards = ca.Function("guards", [model.x, model.p], [ca.vertcat(*model.guards.values())])
    seen = ca.Function("seen", [model.x, model.p], [ca.vertcat(*observed.values())])
    rates = ca.Function("rates", [model.x, model.p], [model.rhs])
    first, theta = model.names.index("phi"), model.x[0]
    place = frame_of_angles(theta, model.x[first : first + len(POSE)], ca.sin(theta), ca.cos(theta))
    return {
        "names": model.names, "states": count, "guards": list(model.guards),
        "rates": graph(Program(rates)), "guard": graph(Program(guards)),
        "observe": graph(Program(seen)), "observed": list(observed), "more": [FLAT],
        "frame": graph(Program(ca.Function("frame", [model.x, model.p], [place]))),
        "work": model.names.index("work"), "outcomes": {g: g for g in model.guards},
    }  # fmt: skip
