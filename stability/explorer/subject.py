"""One family under one law, as the page needs it: formulas, states, motion, words."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Any

from ..algebra.number_types import Algebra
from ..algebra.source.straight_lines import Line, Record
from ..base.checks import checked
from ..base.errors import ParameterError, shown
from ..base.quantities import Kind
from .source.formulas import Coefficients, Conditions, Rule, Sign, Values
from .source.shader import Seen, look
from .source.solver import Solver
from .source.source_text import JAVASCRIPT, javascript


@dataclass(frozen=True)
class Quantity:
    """A number that the reader of the page may change."""

    name: str
    """Name in calls."""
    symbol: str
    """Symbol on the page."""
    label: str
    """The quantity in words."""
    unit: str
    """Unit, or what it is measured in; empty for a plain number."""
    low: float
    """Lower end of its slider and axis."""
    high: float
    """Upper end."""
    value: float
    """Value at first."""
    least: float | None = None
    """Largest number that is too small, or None."""
    most: float | None = None
    """Largest number that is accepted, or None."""
    marks: tuple[tuple[float, str], ...] = ()
    """Values with a name."""
    kind: Kind = Kind.NUMBER
    """Kind, which gives it a unit where the body has SI units."""

    def told(self) -> dict[str, Any]:
        """The record in the page."""
        return vars(self) | {"kind": self.kind.name}

    def checked(self, value: Any) -> float:
        """A number that the quantity may have, or an error that says which it may."""
        number = checked(self.name, value)
        if not isinstance(number, float):
            raise ParameterError(f"{self.name} is {shown(value)}; give one number.")
        low = self.least is not None and number <= self.least
        if low or (self.most is not None and number >= self.most):
            ends = [f"above {self.least:g}" if self.least is not None else "",
                    f"below {self.most:.6g}" if self.most is not None else ""]  # fmt: skip
            raise ParameterError(
                f"{self.name} is {number:g}; give a number {' and '.join(e for e in ends if e)}."
            )
        return number


@dataclass(frozen=True)
class Subject:
    """One family under one contact law."""

    key: str
    """Name in the link of a view."""
    family: str
    """Name of the family."""
    law: str
    """Name of the law; empty for a system of one's own."""
    title: str
    """The motion in words."""
    quantities: tuple[Quantity, ...]
    """What names a point, in the order of every function."""
    axes: tuple[str, str]
    """Quantities on the axes at first."""
    even: tuple[bool, ...]
    """Whether each factor has even powers of λ alone."""
    zeros: int
    """Number of eigenvalues that vanish by structure."""
    coefficients: Coefficients
    """Coefficients of each factor in λ, lowest first."""
    rules: tuple[Rule | Sign, ...]
    """What decides by its sign."""
    signs: Conditions
    """(value, size) of each rule; the share of the rule times the size bounds the error."""
    texts: tuple[tuple[str, str], ...]
    """Each rule as HTML, with symbols and with {name} for numbers."""
    states: tuple[str, ...]
    """Names of the states of the spectrum."""
    member: str
    """JavaScript: quantities → states."""
    jacobian: str
    """JavaScript: states, parameters → ∂ẋ/∂x, row by row."""
    model: str
    """Key of the motion's equations; empty where a launch is not offered."""
    call: Mapping[str, Any]
    """How Python is asked for the same: kind, family, law, names."""
    pose: str = ""
    """JavaScript: states, parameters, pose → rates of the pose; empty for a system of one's own."""
    parameters: tuple[int, ...] = ()
    """Indices of the quantities that are parameters of the equations, in their order."""
    good: str = ""
    """Verdict where every rule is positive; from the factors when left out."""
    symbols: Mapping[str, str] = field(default_factory=dict)
    """Symbols of the states."""

    bounds: Conditions | None = None
    """(value, error bound) of each rule where that is no share of the size; None where it is."""
    members: Callable[[Algebra, Values], list[Any]] | None = None
    """Numbers that are positive where the family has a member; None where it always has one."""
    frame: str = ""
    """JavaScript: states, parameters, pose → place of the body (`source.frames`)."""
    still: tuple[float, ...] = ()
    """The pose at time zero."""
    start: str = ""
    """JavaScript: quantities, tilt → start of a launch; empty where a state takes the tilt."""
    meridian: Mapping[str, Any] = field(default_factory=dict)
    """Surface of a body of revolution; empty for the thin disk."""
    proved: bool = True
    """Whether the signs have a bound on their errors."""
    note: str = ""
    """What the letters of the conditions are."""
    solver: Solver | None = None
    """How unknowns are found, which follow the quantities in every formula; None without any."""

    def told(self) -> dict[str, Any]:
        """The record in the page."""
        solver, bounds = self.solver, self.bounds
        count = len(self.quantities) + len(solver.unknown if solver else ())

        def seen(algebra: Algebra, q: Values) -> Seen:
            more: list[Any] = []
            if solver:
                q, more = solver.polished(algebra, q)
            found = self.members(algebra, q) if self.members else []
            return self.coefficients(algebra, q), self.signs(algebra, q), [*found, *more]

        return {
            "key": self.key, "family": self.family, "law": self.law, "title": self.title,
            "quantities": [q.told() for q in self.quantities],
            "axes": self.axes, "even": self.even, "zeros": self.zeros,
            "degrees": self._degrees(count),
            "coefficients": javascript(
                [count], lambda f, q: [c for factor in self.coefficients(f, q) for c in factor]
            ),
            "conditions": javascript(
                [count], lambda f, q: [v for pair in self.signs(f, q) for v in pair]
            ),
            "bounds": javascript(
                [count], lambda f, q: [v for pair in bounds(f, q) for v in pair]
            ) if bounds else "",
            "rules": [
                {"kind": rule.kind, "text": text, "filled": put, "share": rule.share}
                for rule, (text, put) in zip(self.rules, self.texts, strict=True)
            ],
            "shader": look(count, seen, self.even), "states": self.states,
            "member": self.member, "jacobian": self.jacobian, "model": self.model,
            "call": dict(self.call), "pose": self.pose, "parameters": self.parameters,
            "good": self.good or ("neutral" if any(self.even) else "stable"),
            "symbols": dict(self.symbols), "frame": self.frame, "still": self.still,
            "members": javascript([count], self.members) if self.members else "",
            "start": self.start, "meridian": dict(self.meridian), "proved": self.proved,
            "note": self.note, "solver": solver.told() if solver else None,
        }  # fmt: skip

    def _degrees(self, count: int) -> list[int]:
        record = Record(JAVASCRIPT)
        found = self.coefficients(
            record.algebra(), [Line(record, f"a0[{i}]") for i in range(count)]
        )
        return [len(factor) - 1 for factor in found]
