"""Families of bodies of revolution in closed form, from polynomials that hold for every height.

The polynomials are derived from the graph with h, h′ and h′′ as symbols, by
notebooks/proofs/body_polynomials.py, and kept as package data.  A body's height and its two
derivatives are put in as graphs, so no eigenvalue problem and no root-finder is left.

Source: tests/bodies/test_closed_forms.py compares them with the linearisation of the graph.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from functools import lru_cache
from importlib.resources import files
from typing import Any

import casadi as ca

from ...algebra.number_types import Algebra, casadi_algebra
from ...algebra.polynomial import Polynomial
from ...algebra.program import Program, operations
from ...systems.closed_form import ClosedForm, ImplicitForm
from ...systems.system import System
from ..contact_laws import Contact, LinearViscous, Rough, Smooth, Viscous
from ..disk_polynomials import stored_cases
from ..explicit import ContactGeometry, surface
from ..families import tumbling
from .equations import conditions_along
from .height.expression import ShapeFunction
from .height.pole_height import height_of_angle
from .si_law import BodySymbols, Shape

DATA = "body_polynomials.json"
"""The file of derived polynomials, next to this module."""
DIGEST = "617236fe51c95b03a056857353da055d1d6ebb34d2ffdba8c9df3f33e9f57530"
"""SHA-256 of that file, written by `make derive`; a file with another digest is refused."""
FEW = 4
"""Most sines and cosines of a height that is read by sine and cosine of θ itself."""
OUTER = ("mu", "phi_dot", "omega3", "I3", "I1")
"""Variables of the polynomials that depend on more than the inclination, outermost first."""
KINDS = {Viscous: "viscous", LinearViscous: "viscous", Rough: "rough", Smooth: "smooth"}
"""The polynomial of each law: at a steady motion a drag is linear in the slip."""


@lru_cache(maxsize=1)
def _catalogue() -> dict[str, Any]:
    return stored_cases(files(__package__) / DATA, DIGEST)


def stored(name: str, law: type[Contact]) -> bool:
    """Whether the polynomial of a family under a law is among those that are kept.

    Parameters
    ----------
    name
        Name of the family.
    law
        Class of the law.
    """
    return f"{name} {KINDS.get(law, '')}" in _catalogue()


def closed_form(
    system: System,
    name: str,
    shape: Shape,
    law: type[Contact],
    parameters: Sequence[str],
    *,
    physical: bool,
    start: float | None = None,
) -> ClosedForm | None:
    """Unknowns and polynomial of a family; None where none is stored.

    Parameters
    ----------
    system
        The body's system, without resistances.
    name
        Name of the family.
    shape
        From `stability.bodies.round_body.si_law.shape_of`.
    law, parameters
        Class of the law, and names of its coefficients.
    physical
        Whether mass, gravity and length are parameters.
    start
        First guess of the inclination where that is solved for.
    """
    record = _catalogue().get(f"{name} {KINDS.get(law, '')}")
    return (
        None
        if record is None
        else _Formulas(system, name, record).of(
            shape, BodySymbols.of(shape, parameters, physical=physical), law, parameters, start
        )
    )


def _waves(height: ShapeFunction) -> int:
    """Number of sines and cosines in a height."""
    return sum(code in (ca.OP_SIN, ca.OP_COS) for code in operations(height.function))


class _Formulas:
    """The formulas of a family, as expressions in its parameters."""

    def __init__(self, system: System, name: str, record: Mapping[str, Any]) -> None:
        self.system, self.name, self.record = system, name, record
        self.theta, self.turn = ca.SX.sym("theta"), ca.SX.sym("phi_dot")
        self.constants: list[tuple[ca.SX, float]] = []

    def of(
        self,
        shape: Shape,
        numbers: BodySymbols,
        law: type[Contact],
        parameters: Sequence[str],
        start: float | None,
    ) -> ClosedForm:
        """The closed form of one body under one law."""
        table, theta = numbers.table, self.theta
        rate = table["gravity"] / table["length"]  # square of the unit of rates
        level = ca.SX(height_of_angle(shape[1], theta, numbers.shape_symbols))
        h = self._series(shape[1], numbers.shape_symbols) if _waves(shape[1]) > FEW else level
        body = surface(theta, h, *(self._as_symbol(table[n]) for n in ("transverse", "axial")))
        variables = {
            "I1": body.transverse,
            "I3": body.axial,
            "s": body.sine,
            "c": body.cosine,
            "r": body.outward,
            "z": body.along,
            "ρ": h + body.curve,
            "h": h,
            "h′′": body.curve,
        }
        turn = self.turn / ca.sqrt(rate)
        unknowns, positive = self._member(body, turn)
        variables |= {"mu": self._drag(table, parameters)} | unknowns
        powers = [self._value(terms, variables) for terms in self.record["coefficients"]]
        scaled = [
            p / ca.sqrt(rate) ** k if k % 2 else p / rate ** (k // 2) for k, p in enumerate(powers)
        ]
        if self.name == "rolling":
            solved = {"theta": theta}
            free = {"theta": theta, "omega3": self.turn}
        else:
            solved = {
                n: v * ca.sqrt(rate)
                for n, v in unknowns.items()
                if n != "phi_dot" or self.name == "tumbling"
            }
            free = {"theta": theta, "phi_dot": self.turn} | solved
        state = ca.vertcat(*[free.get(n, 0) for n in self.system.states])
        within = self._conditions(shape, law, parameters, numbers, h, state)
        members = ca.vertcat(within, *positive)
        places = {"tumbling": [theta], "rolling": [self.turn, theta]}
        at = places.get(self.name, [theta, self.turn])
        outputs = ca.cse([ca.vertcat(*scaled), ca.vertcat(*solved.values()), members])
        symbols = ca.vertcat(*[symbol for symbol, _ in self.constants])
        function = ca.Function("closed", [ca.vertcat(*at), numbers.p, symbols], outputs)
        values = tuple(value for _, value in self.constants)
        record = function.serialize(), self.record["zeros"], self.record["even"], values
        if start is None:
            return ClosedForm(*record)
        slope = ca.jacobian(level, theta)
        parts = ca.cse([slope, ca.jacobian(slope, theta)])
        equation = ca.Function("equation", [theta, numbers.p], [ca.densify(v) for v in parts])
        return ImplicitForm(*record, equation.serialize(), start, shape[4])

    def _conditions(  # noqa: PLR0913
        self,
        shape: Shape,
        law: type[Contact],
        parameters: Sequence[str],
        numbers: BodySymbols,
        h: ca.SX,
        state: ca.SX,
    ) -> ca.SX:
        """Numbers that the system's conditions ask to be positive, with the same reading of h."""
        x, p = self.system.x, self.system.p
        if _waves(shape[1]) > FEW:
            p, along = numbers.p, ca.substitute([h], [self.theta], [x[0]])[0]
            asked = conditions_along(shape, law, parameters, numbers, x, along)
        else:
            asked = ca.vertcat(*[c.value for c in self.system.conditions])
        here = [ca.densify(state), ca.densify(numbers.p)]
        return ca.SX(ca.substitute([asked], [x, p], here)[0])

    def _series(self, height: ShapeFunction, symbols: Sequence[ca.SX]) -> ca.SX:
        """A height of many waves as it is given: each of a wide interval is within [-1, 1].

        By the recurrence of `height_of_angle` enclosures grow with a power of the number of waves.
        """
        functions = casadi_algebra().functions
        kept = Algebra("kept", self._as_symbol, functions, lasting=False)
        [[series]] = Program(height.function).run(kept, [[self.theta], *([n] for n in symbols)])
        return ca.SX(series)

    def _as_symbol(self, number: Any) -> ca.SX:
        """A number of many digits as a symbol: CasADi would round its products."""
        if not ca.SX(number).is_constant():
            return ca.SX(number)
        self.constants.append((ca.SX.sym(f"c{len(self.constants)}"), float(number)))
        return self.constants[-1][0]

    def _member(self, body: ContactGeometry, turn: ca.SX) -> tuple[dict[str, ca.SX], list[ca.SX]]:
        """φ̇ and ω₃ without unit, and numbers that are positive at every member."""
        h, slope, _, r, z, s, c, i1, i3 = body
        if self.name == "rolling":
            return {"omega3": turn}, []
        if self.name == "circling":
            across = turn * (r * h + i3 * s)
            spin = (turn * turn * s * (z * h + i1 * c) - slope) / across
            return {"phi_dot": turn, "omega3": spin}, [turn * turn]
        if self.name == "precession":
            spin = (turn * turn * i1 * s * c - slope) / (turn * i3 * s)
            return {"phi_dot": turn, "omega3": spin}, [turn * turn]
        square, share = tumbling(slope, r, z, s, c, i1, i3)
        turn = ca.sqrt(square)
        return {"phi_dot": turn, "omega3": turn * share}, [square]

    def _value(self, terms: Sequence[Sequence[int]], variables: Mapping[str, Any]) -> ca.SX:
        """A coefficient, with what θ alone decides innermost: one row of a map computes it once."""
        rows = tuple((c, tuple(powers)) for c, *powers in terms)
        return ca.SX(Polynomial(tuple(self.record["variables"]), rows).factored(variables, OUTER))

    def _drag(self, table: Mapping[str, Any], parameters: Sequence[str]) -> Any:
        """The friction coefficient without unit."""
        if "c" in parameters:
            return table["c"] / table["mass"] * ca.sqrt(table["length"] / table["gravity"])
        return table["mu"] * ca.sqrt(table["gravity"] * table["length"]) if parameters else 0
