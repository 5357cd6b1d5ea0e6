"""One family with its numbers, under one law, as the page needs it."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any

import casadi as ca

from ..algebra.number_types import Algebra
from ..algebra.program import Program
from ..algebra.straight_lines import Line, Record
from ..base.verdict import Nonlinear
from ..systems.family import Family
from .formulas import PageFormulas, Values
from .quantities import PageQuantity
from .source import JAVASCRIPT, Seen, graph, javascript, look


@dataclass(frozen=True)
class PageSubject:
    """A family on the page; of the disk, of a body and of a user's system it differs by data."""

    key: str
    """Name in the link of a view."""
    family: Family
    """The family."""
    title: str
    """The motion in words."""
    quantities: Mapping[str, PageQuantity]
    """What names a member, by name in the family and in the order of every function."""
    axes: tuple[str, str]
    """Quantities on the axes at first, by their names in calls."""
    formulas: PageFormulas
    """What decides the verdict."""
    model: str
    """Key of the motion's equations."""
    call: Mapping[str, Any]
    """How Python is asked for the same: kind, family, law, names."""
    button: str = ""
    """Key of the family's button; the family's name when left out."""
    law: str = ""
    """Name of the law; empty for a system of one's own."""
    symbols: Mapping[str, str] = field(default_factory=dict)
    """Symbols of the states that have one."""
    body: Mapping[str, Any] = field(default_factory=dict)
    """How the body moves and looks (`motion.body_of`); empty where there is none to draw."""

    @property
    def called(self) -> dict[str, PageQuantity]:
        """What names a member, by its name in calls."""
        return {q.name: q for q in self.quantities.values()}

    @property
    def drift(self) -> str:
        """What nonlinear terms do to a stable member along the family, in words; empty for none."""
        if not self.family.drifts:
            return ""
        return str((Nonlinear.DRIFTS if self.body else Nonlinear.CARRIED).value)

    @cached_property
    def record(self) -> dict[str, Any]:
        """The record in the page."""
        formulas, system, names = self.formulas, self.family.system, list(self.quantities)
        solver, count = formulas.solver, len(formulas.names)

        def source(formula: Any) -> str:
            return javascript([count], formula) if formula else ""

        def paired(formula: Any) -> str:
            return source(formula and (lambda f, q: [v for pair in formula(f, q) for v in pair]))

        def seen(algebra: Algebra, q: Values) -> Seen:
            more: list[Any] = []
            if solver:
                q, more = solver.polished(algebra, q)
            members = formulas.members(algebra, q) if formulas.members else []
            shares = [rule.share for rule in formulas.rules]
            signs = formulas.signs(algebra, q)
            errors = [(v, share * size) for (v, size), share in zip(signs, shares, strict=True)]
            return formulas.coefficients(algebra, q), errors, [*members, *more]

        slopes = ca.Function("slopes", [system.x, system.p], [ca.jacobian(system.rhs, system.x)])
        return {
            "key": self.key,
            "family": self.button or self.family.name,
            "law": self.law,
            "title": self.title,
            "quantities": [q.told() for q in self.quantities.values()],
            "axes": self.axes,
            "even": formulas.even,
            "zeros": formulas.zeros,
            "degrees": self._degrees(count),
            "coefficients": source(
                lambda f, q: [c for factor in formulas.coefficients(f, q) for c in factor]
            ),
            "conditions": paired(formulas.signs),
            "bounds": paired(formulas.bounds),
            "rules": [vars(rule) for rule in formulas.rules],
            "look": look(count, seen, formulas.even),
            "states": system.states,
            "member": source(lambda f, q: formulas.states(self.family, f, q)),
            "jacobian": graph(Program(slopes)),
            "model": self.model,
            "call": dict(self.call),
            "parameters": [names.index(n) for n in system.parameters],
            "good": formulas.good.word,
            "symbols": {n: self.symbols.get(n) or n for n in system.states},
            "members": source(formulas.members),
            "proved": formulas.proved,
            "note": formulas.note,
            "drift": self.drift,
            "solver": solver.told() if solver else None,
            "pose": "",
            "frame": "",
            "still": [],
            "start": "",
            "meridian": {},
            **self.body,
        }

    def _degrees(self, count: int) -> list[int]:
        lines = Record(JAVASCRIPT)
        factors = self.formulas.coefficients(
            lines.algebra(), [Line(lines, f"a0[{i}]") for i in range(count)]
        )
        return [len(factor) - 1 for factor in factors]
