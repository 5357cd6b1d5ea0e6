"""Whether the rates have a slope at a state: roots, powers and |x| at the edge of their range.

There the slope of such a function g(s) is infinite or has no value, and s often has the slope 0.
CasADi folds 0 · ∞ to 0, so the linearisation alone does not show it.  Each number of the graph
therefore answers two questions, from the instructions before it: may it move with the states to
first order, and may it lack a slope.  A root, power or arccos that has no value on one side of its
edge has a slope only if its argument stays on the other side.  Each number therefore also answers
whether the instructions prove its value at the state to be its least or largest nearby, as that of
x² or 1 - cos(x) at 0.  Where they do not, as for x v, there is no slope.

At a distance r, an s that does not move changes by o(r), and then |s|, √s, s^e with e ≥ 1/2 and
arccos(1 - s) by o(√r).  So does |s| of any s.  A product of two such numbers, or with a number that
is 0, is o(r) again: x |x| has the slope 0.  Every other number at an edge stays without a slope.
Arguments are at an edge if their double is.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import lru_cache
from typing import Any

import casadi as ca
import numpy as np
from numpy.typing import NDArray

from ...algebra.number_types import MORE, UNARY, Algebra, numpy_algebra
from ...algebra.program import Program, operations
from ...base.errors import ParameterError
from ...base.types import Floats
from ..equations import Equations

KINKED = (
    "have no slope there, as |x| or sqrt(x) at 0, or no value on one side, as x**1.5 or (x*v)**1.5 "
    "at 0 (a base is known to be no less than 0 if it is written as squares, sizes or roots); a "
    "spectrum needs rates that are differentiable at the member."
)
REMOVABLE = (
    "the rates have no value there, as sin(x)/x at 0 or max(x, 0) on its switch, and tend to one "
    "value from all sides; cancel a common factor, put the first terms of its series in place of "
    "the quotient, or take a member next to it."
)
EDGES: dict[str, tuple[tuple[float, ...], tuple[float, ...]]] = {
    "sqrt": ((0.0,), ()),
    "asin": ((-1.0,), (1.0,)),
    "acos": ((-1.0,), (1.0,)),
    "acosh": ((1.0,), ()),
}
"""Least and largest arguments: there a function has a value and no slope, beyond it no value."""
LEVEL: dict[str, tuple[float, ...]] = {"cos": (0.0,), "cosh": (0.0,)}
"""Arguments at which a function has the slope 0: its largest value or its least."""
FALLING = ("cos", "acos")
"""Functions that fall, cos above 0 and the other everywhere; sin and tan rise near 0, cosh above 0,
and the others everywhere."""
STEEP = 1.5
"""Largest argument at which sin and tan count as rising, half the largest for cos and cosh."""
_CODES = {
    ca.OP_SQRT,
    ca.OP_FABS,
    ca.OP_ASIN,
    ca.OP_ACOS,
    ca.OP_POW,
    ca.OP_CONSTPOW,
    ca.OP_ACOSH,
    ca.OP_HYPOT,
    ca.OP_ATAN2,
}
_PLAIN = numpy_algebra().functions


@dataclass(frozen=True)
class _Number:
    """A number of the graph at many states."""

    value: Any
    """The number in double precision."""
    moves: Any = np.False_
    """Whether its slope in the states may differ from 0."""
    kinked: Any = np.False_
    """Whether it may have no slope, and changes by o(√r)."""
    broken: Any = np.False_
    """Whether it may have no slope, and no product with 0 helps."""
    depends: bool = False
    """Whether any state is in it."""
    least: Any = np.True_
    """Whether no state nearby gives it a smaller value, by proof; so for a constant."""
    most: Any = np.True_
    """Whether none gives it a larger value."""

    def _with(
        self, other: Any, value: Any, mine: Any, others: Any, least: Any, most: Any
    ) -> _Number:
        """Of two numbers; mine and others: whether each one's change counts."""
        return _Number(
            value,
            (self.moves & mine) | (other.moves & others),
            (self.kinked & mine) | (other.kinked & others),
            self.broken | other.broken,
            self.depends or other.depends,
            least,
            most,
        )

    def __add__(self, other: Any) -> _Number:
        other, all_ = _number(other), np.True_
        ends = self.least & other.least, self.most & other.most
        return self._with(other, self.value + other.value, all_, all_, *ends)

    def __sub__(self, other: Any) -> _Number:
        return self + -_number(other)

    def __mul__(self, other: Any) -> _Number:
        square = self is other
        other = _number(other)
        mine, others = np.not_equal(other.value, 0), np.not_equal(self.value, 0)
        least = _product_least(self, other) | (square & ~others)
        ends = least, _product_least(self, -other)
        return self._with(other, self.value * other.value, mine, others, *ends)

    def __truediv__(self, other: Any) -> _Number:
        other = _number(other)
        inverse = replace(other, value=1 / other.value, least=other.most, most=other.least)
        ends = _product_least(self, inverse), _product_least(self, -inverse)
        moved = np.not_equal(self.value, 0)
        return self._with(other, self.value / other.value, np.True_, moved, *ends)

    def __rtruediv__(self, other: Any) -> _Number:
        return _number(other) / self

    def __neg__(self) -> _Number:
        return replace(self, value=-self.value, least=self.most, most=self.least)


def _product_least(factor: _Number, other: _Number) -> Any:
    """Whether a product is least at the state, by the signs and ends of its factors."""
    a, b = factor.value, other.value
    above = (a >= 0) & factor.least & (b >= 0) & other.least
    below = (a <= 0) & factor.most & (b <= 0) & other.most
    return above | below | _scaled_least(factor, other) | _scaled_least(other, factor)


def _scaled_least(factor: _Number, other: _Number) -> Any:
    """Whether a product is least because one factor keeps its sign, and is constant or scales 0."""
    a, b = factor.value, other.value
    fixed = factor.least & factor.most
    end = ((a > 0) & other.least) | ((a < 0) & other.most) | (np.equal(a, 0) & fixed)
    return (fixed | np.equal(b, 0)) & end


def _number(value: Any) -> _Number:
    return value if isinstance(value, _Number) else _Number(np.float64(value))


def _function(name: str) -> Callable[[Any], _Number]:
    def apply(x: Any) -> _Number:
        x = _number(x)
        flat = np.isin(x.value, LEVEL.get(name, ()))
        low, high = (np.isin(x.value, ends) for ends in EDGES.get(name, ((), ())))
        edge, out = x.depends & (low | high), (low & ~x.least) | (high & ~x.most)
        number = _at_edge(x, edge, x.moves & ~flat, x.kinked & ~flat, _PLAIN[name](x.value))
        rises = (np.abs(x.value) < STEEP) | (name not in ("sin", "tan"))
        rises &= ((x.value > 0) & (x.value < 2 * STEEP)) | (name not in LEVEL)
        least, most = x.least & rises, x.most & rises
        least, most = (most, least) if name in FALLING else (least, most)
        least, most = least | (flat & (name == "cosh")), most | (flat & (name == "cos"))
        fixed = x.least & x.most
        return replace(
            number, broken=number.broken | (x.depends & out), least=least | fixed, most=most | fixed
        )

    return apply


def _at_edge(x: _Number, edge: Any, moves: Any, kinked: Any, value: Any) -> _Number:
    """A function with an edge: √s of an s that moves is broken, of another it has a kink."""
    rests = ~np.asarray(x.moves | x.kinked)
    broken = x.broken | (edge & ~rests)
    return _Number(value, moves & ~edge, kinked | (edge & rests), broken, x.depends)


def _fabs(x: Any) -> _Number:
    x = _number(x)
    zero = np.equal(x.value, 0)
    edge = zero & (x.moves | x.kinked)
    least = zero | np.where(x.value > 0, x.least, x.most)
    most = np.where(zero, x.least & x.most, np.where(x.value > 0, x.most, x.least))
    return _Number(
        np.abs(x.value), x.moves & ~edge, x.kinked | edge, x.broken, x.depends, least, most
    )


def _power(x: Any, exponent: Any) -> _Number:
    """A power with an exponent that does not move: below 1/2 it is steeper than any root.

    One that is not whole has no value where its base is below 0.
    """
    x, e = _number(x), _number(exponent)
    whole = np.equal(e.value, np.round(e.value))
    even = whole & np.equal(e.value % 2, 0)
    zero = np.equal(x.value, 0)
    level = ~(zero & (e.value > 1))
    edge = x.depends & zero & ~whole & (e.value < 1)
    number = _at_edge(x, edge, x.moves & level, x.kinked & level, _PLAIN["pow"](x.value, e.value))
    steep = (edge & (e.value < 0.5)) | (zero & e.depends)
    steep = steep | (x.depends & zero & ~whole & ~x.least)
    rises, fixed = (e.value > 0) & (x.value >= 0) & (not e.depends), x.least & x.most
    least = (rises & x.least) | (zero & even & (e.value > 0)) | fixed
    return _Number(
        number.value,
        number.moves | e.moves,
        number.kinked | e.kinked,
        number.broken | e.broken | steep,
        x.depends or e.depends,
        least & (not e.depends),
        ((rises & x.most) | fixed) & (not e.depends),
    )


def _sign(x: Any) -> _Number:
    return _Number(
        np.sign(_number(x).value)
    )  # constant nearby; its own kink is a jump, where the rates have no value


def _angle(y: Any, x: Any) -> _Number:
    """The angle of (x, y), which jumps by a turn at y = 0 ≥ x."""
    y, x = _number(y), _number(x)
    jumps = np.equal(y.value, 0) & np.less_equal(x.value, 0)
    ends = x.least & x.most & y.least & y.most
    value, moved = _PLAIN["atan2"](y.value, x.value), np.not_equal(y.value, 0)
    number = y._with(x, value, np.True_, moved, ends, ends)
    return _Number(
        number.value, number.moves, number.kinked, number.broken | jumps, number.depends, ends, ends
    )


_TABLE: dict[str, Callable[..., Any]] = {name: _function(name) for name in (*UNARY, *MORE)}
_TABLE |= {"pow": _power, "fabs": _fabs, "sign": _sign, "atan2": _angle}
_ALGEBRA = Algebra("slopes", _number, _TABLE)


@lru_cache(maxsize=64)
def _rates(system: Equations) -> tuple[Program, bool] | None:
    """The rates of a system, and whether a function in them may lack a slope."""
    if system.coefficients is not None:
        return None
    try:
        rates = ca.Function("rates", [system.x, system.p], [ca.densify(system.rhs)])
    except ParameterError:
        return None  # a numeric system has no graph
    return Program(rates), not _CODES.isdisjoint(operations(rates))


def _program(system: Equations) -> Program | None:
    """The rates of a system, or None where no function may lack a slope."""
    program = _rates(system)
    return program[0] if program and program[1] else None


NEAR = (1e-3, 1e-4)
"""Distances from a gap, relative to 1 or to the state, at which rates are compared."""


def gap(system: Equations, x: Floats, p: Floats) -> int | None:
    """The first row whose rates have no value but, as far as values nearby show, a limit."""
    graph = _rates(system)
    if graph is None:
        return None

    def rates(x: Floats, p: Floats) -> Floats:
        values: Floats = graph[0].arrays([list(x.T), list(p.T)], x.shape[:1])[0][..., 0]
        return values

    with np.errstate(all="ignore"):
        rows = np.flatnonzero(~np.isfinite(rates(x, p)).all(axis=1))
        if not len(rows):
            return None
        row, n = int(rows[0]), x.shape[1]
        ways = np.vstack([np.eye(n), -np.eye(n), np.random.default_rng(5).normal(size=(8, n))])
        spread = []
        for share in NEAR:
            around = x[row] + share * (1 + np.abs(x[row])) * ways
            values = rates(around, np.tile(p[row], (len(ways), 1)))
            # along an axis on which the quotient stays 0/0 nothing is seen
            values = values[np.isfinite(values).all(axis=1)]
            if len(values) < len(ways) // 2:
                return None
            spread.append(float((np.ptp(values, axis=0) / (1 + np.abs(values).max(axis=0))).max()))
    return row if spread[1] <= spread[0] / 3 <= 0.1 else None


def edged(system: Equations) -> bool:
    """Whether a function of a system's rates may lack a slope somewhere."""
    return _program(system) is not None


def _at_edges(program: Program, x: Floats, p: Floats) -> NDArray[np.bool_]:
    """Rows at which the double of some argument is at an edge, in the order of the instructions."""
    edges = np.zeros(len(x), dtype=bool)

    def watched(name: str) -> Callable[..., Any]:
        ends = (
            [0.0] if name in ("fabs", "pow") else [e for pair in EDGES.get(name, ()) for e in pair]
        )

        def apply(*arguments: Any) -> Any:
            if name == "atan2":
                hit = np.equal(arguments[0], 0) & np.less_equal(arguments[1], 0)
            else:
                hit = np.isin(arguments[0], ends)
            np.logical_or(edges, hit, out=edges)
            return _PLAIN[name](*arguments)

        return apply

    table = {name: _PLAIN[name] for name in (*UNARY, *MORE)}  # others are written by these
    table |= {name: watched(name) for name in (*EDGES, "fabs", "pow", "atan2")}
    algebra = Algebra("edges", np.float64, table)
    with np.errstate(all="ignore"):
        program.run(algebra, [list(x.T), list(p.T)])
    return edges


def sloped(system: Equations, x: Floats, p: Floats) -> NDArray[np.bool_]:
    """Whether the rates of a system have a slope at states, which |x| has not at 0.

    Parameters
    ----------
    system
        The equations of motion.
    x, p
        States and parameters, shapes (N, n) and (N, m).

    Returns
    -------
    ndarray of bool
        Shape (N,); True says that no function of the graph is at its edge in double precision, or
        that no rate depends on it to first order.

    Examples
    --------
    >>> import stability as st
    >>> v, c = ca.SX.sym("v"), ca.SX.sym("c")
    >>> drag = st.System("drag", v, c, -c * v * ca.fabs(v), states=("v",), parameters=("c",))
    >>> dry = st.System("dry", v, c, -c * ca.fabs(v), states=("v",), parameters=("c",))
    >>> [bool(sloped(s, np.zeros((1, 1)), np.ones((1, 1)))[0]) for s in (drag, dry)]
    [True, False]
    """
    fine = np.ones(len(x), dtype=bool)
    program = _program(system)
    if program is None:
        return fine
    edge = _at_edges(program, x, p)
    if not edge.all():  # elsewhere no number of the graph can lack a slope
        if edge.any():
            fine[edge] = sloped(system, x[edge], p[edge])
        return fine
    moving = np.ones(len(x), dtype=bool)
    no = np.zeros(len(x), dtype=bool)
    states = [_Number(column, moving, depends=True, least=no, most=no) for column in x.T]
    with np.errstate(all="ignore"):  # a value that is not finite is refused as such
        rates = program.run(_ALGEBRA, [states, [_Number(column) for column in p.T]])[0]
    for rate in map(_number, rates):
        fine &= ~(rate.kinked | rate.broken)
    return fine
