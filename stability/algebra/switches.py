"""Graphs of several pieces: maxima, branches and comparisons by the sign of a difference.

Within a piece the sign is 1 or -1, so that every number type reads the graph, and its slopes are
those of the piece.  On a switch the sign of 0 has no value: a verdict there is refused, and a
search leaves the switch open, with the verdicts on its two sides.  A piece that is not taken is
multiplied by zero, so it must be finite.

Source: tests/algebra/test_switches.py.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from typing import Any

import casadi as ca
import numpy as np

from ..base.errors import shown
from .program import operations


@contextmanager
def no_folding() -> Iterator[None]:
    """A context in which CasADi does not join constants, such as 0.1 · (3 · x), in doubles."""
    before = ca.GlobalOptions.getSimplificationOnTheFly()
    ca.GlobalOptions.setSimplificationOnTheFly(False)
    try:
        yield
    finally:
        ca.GlobalOptions.setSimplificationOnTheFly(before)


def above(value: Any) -> Any:
    """One where an expression is above zero, and zero where it is below."""
    return (1 + ca.sign(value)) / 2


def chosen(where: Any, yes: Any, no: Any) -> Any:
    """The first expression where a condition is one, and the second where it is zero.

    Examples
    --------
    >>> x = ca.SX.sym("x")
    >>> larger = ca.Function("larger", [x], [chosen(above(x - 2), x, 2)])
    >>> float(larger(5)), float(larger(-5))
    (5.0, 2.0)
    """
    return where * yes + (1 - where) * no


SWITCHES: dict[int, Callable[..., Any]] = {
    ca.OP_FMAX: lambda a, b: chosen(above(a - b), a, b),
    ca.OP_FMIN: lambda a, b: chosen(above(b - a), a, b),
    ca.OP_LT: lambda a, b: above(b - a),
    ca.OP_LE: lambda a, b: above(b - a),
    ca.OP_EQ: lambda a, b: 1 - ca.sign(a - b) ** 2,
    ca.OP_NE: lambda a, b: ca.sign(a - b) ** 2,
    ca.OP_NOT: lambda a: 1 - a,
    ca.OP_AND: lambda a, b: a * b,
    ca.OP_OR: lambda a, b: a + b - a * b,
    ca.OP_IF_ELSE_ZERO: lambda where, value: where * value,
}
"""Operations of CasADi that have no slope on a switch, by the sign of a difference."""
NEAR_END = 2.0**-40
"""Distance, relative to the larger end of a table, at which an argument counts as at the end."""
TRUTHS = {ca.OP_LT, ca.OP_LE, ca.OP_EQ, ca.OP_NE, ca.OP_NOT, ca.OP_AND, ca.OP_OR}
"""Operations whose value is 1 or 0."""


def by_signs(
    symbols: Sequence[ca.SX],
    values: Sequence[ca.SX],
    called: Callable[[ca.Function, list[ca.SX]], ca.SX] | None = None,
    limits: list[tuple[ca.SX, str]] | None = None,
) -> list[ca.SX] | None:
    """Expressions without maxima, branches and comparisons; None where they have none of these.

    Parameters
    ----------
    symbols
        Columns of symbols.
    values
        Expressions of these.
    called
        The value of a function that they call, such as an interpolant, at its arguments.
    limits
        List that takes what must be positive where a branch beyond has no value, and what is said
        where it is not.
    """
    graph = ca.Function("graph", list(symbols), [ca.densify(v) for v in values])
    codes = operations(graph)
    calls = ca.OP_CALL in codes
    if SWITCHES.keys().isdisjoint(codes) and not calls:
        return None
    inputs = [ca.vertsplit(ca.vec(s)) if s.numel() else [] for s in symbols]
    outputs = [ca.SX(*v.shape) for v in values]
    work: dict[int, Any] = {}
    functions = iter(_calls(values) if calls else ())
    smaller: dict[int, tuple[ca.SX, ca.SX]] = {}
    ends: list[tuple[ca.SX, ca.SX]] = []
    truths: set[int] = set()
    with no_folding():
        for i, code in enumerate(codes):
            to, read = graph.instruction_output(i), graph.instruction_input(i)
            if code == ca.OP_OUTPUT:
                outputs[to[0]][to[1]] = work[read[0]]
                continue
            if code == ca.OP_INPUT:
                found = inputs[read[0]][read[1]]
            elif code == ca.OP_CONST:
                found = ca.SX(graph.instruction_constant(i))
            elif code == ca.OP_CALL and called:
                found = called(next(functions), [work[r] for r in read])
            elif code == ca.OP_IF_ELSE_ZERO and read[0] in smaller and _is(work[read[1]], np.nan):
                ends.append(smaller[read[0]])
                found = ca.SX(0)
            elif code in SWITCHES:
                found = _switch(code, [work[r] for r in read], [r in truths for r in read])
            else:
                apply = ca.SX.unary if len(read) == 1 else ca.SX.binary
                found = apply(code, *(work[r] for r in read))
            smaller.pop(to[0], None)
            truths.discard(to[0])
            if code == ca.OP_LT:
                smaller[to[0]] = work[read[0]], work[read[1]]
            if code in TRUTHS or (code == ca.OP_ASSIGN and read[0] in truths):
                truths.add(to[0])
            work[to[0]] = found
        if limits is not None:
            limits += _limits(ends)
    return (by_signs(symbols, outputs, called, limits) if calls else None) or outputs


def _switch(code: int, pair: list[ca.SX], truths: list[bool]) -> ca.SX:
    """The value of a maximum, branch or comparison."""
    if code in (ca.OP_EQ, ca.OP_NE) and any(truths):
        truth, other = pair if truths[0] else pair[::-1]
        if other.is_constant():  # whether a condition holds is asked by its number
            equal = {0.0: 1 - truth, 1.0: truth}.get(float(other), ca.SX(0))
            return equal if code == ca.OP_EQ else 1 - equal
    if code in (ca.OP_FMAX, ca.OP_FMIN):
        least = -np.inf if code == ca.OP_FMAX else np.inf
        for one, other in (pair, pair[::-1]):
            if _is(one, least):
                return other
    value: ca.SX = SWITCHES[code](*pair)
    return value


def _calls(values: Sequence[ca.SX]) -> Iterator[ca.Function]:
    """The functions that expressions call, in the order of CasADi's instructions."""
    seen: set[int] = set()
    waiting: list[tuple[Any, bool]] = [
        (node, False) for v in reversed(values) for node in reversed(ca.densify(v).nonzeros())
    ]
    while waiting:
        node, ready = waiting.pop()
        if ready and node.is_call():
            yield node.which_function()
        elif not ready and node.element_hash() not in seen:
            seen.add(node.element_hash())
            waiting.append((node, True))
            waiting += [(node.dep(i), False) for i in reversed(range(node.n_dep()))]


def _is(value: ca.SX, number: float) -> bool:
    return bool(value.is_constant() and np.array_equal(float(value), number, equal_nan=True))


def _limits(pairs: Sequence[tuple[ca.SX, ca.SX]]) -> list[tuple[ca.SX, str]]:
    """What is positive where the first of two expressions is not smaller, also where it is equal.

    An argument that lies nearer to an end than 2⁻⁴⁰ of the larger end counts as being at the end.
    """
    largest: dict[int, float] = {}
    for end, other in (two for pair in pairs for two in (pair, pair[::-1])):
        if end.is_constant():
            key = other.element_hash()
            largest[key] = max(largest.get(key, 0.0), abs(float(end)))
    found = []
    for low, high in pairs:
        sides = [low, high]
        for i, way in ((0, 1), (1, -1)):
            if sides[i].is_constant():
                room = NEAR_END * largest[sides[1 - i].element_hash()]
                sides[i] = ca.SX(float(np.nextafter(float(sides[i]) + way * room, way * np.inf)))
        names = (shown(str(v))[1:-1].replace("{", "{{").replace("}", "}}") for v in (low, high))
        said = "{} is less than {}, where a table ends or a branch has no value"
        found.append((sides[0] - sides[1], said.format(*names)))
    return found


def one_sided(
    symbols: Sequence[ca.SX],
    values: Sequence[ca.SX],
    side: Callable[[int, float], Any],
) -> list[ca.SX]:
    """Expressions in which |s - c| and the sign of s - c, of a symbol s, are those of one side.

    Parameters
    ----------
    symbols
        Columns of symbols.
    values
        Expressions of these, written by signs.
    side
        Function from the index of s among all symbols, and c, to 1 or -1, a symbol in their place,
        or None where both sides stay.

    Examples
    --------
    >>> x = ca.SX.sym("x")
    >>> one_sided([x], [x + ca.fabs(x - 2)], lambda _, c: -1)
    [SX((x+(-(x-2))))]
    """
    free = ca.vertcat(*symbols)
    graph = ca.Function("graph", [free], [ca.densify(v) for v in values])
    codes = operations(graph)
    if {ca.OP_FABS, ca.OP_SIGN}.isdisjoint(codes):
        return list(values)
    outputs = [ca.SX(*v.shape) for v in values]
    work: dict[int, ca.SX] = {}
    lines: dict[int, tuple[int, float, int]] = {}  # way (s - c) by register: s, c, way
    with no_folding():
        for i, code in enumerate(codes):
            to, read = graph.instruction_output(i), graph.instruction_input(i)
            if code == ca.OP_OUTPUT:
                outputs[to[0]][to[1]] = work[read[0]]
                continue
            line = None
            if code == ca.OP_INPUT:
                found, line = free[read[1]], (read[1], 0.0, 1)
            elif code == ca.OP_CONST:
                found = ca.SX(graph.instruction_constant(i))
            else:
                parts = [work[r] for r in read]
                on = lines.get(read[0]) if code in (ca.OP_FABS, ca.OP_SIGN) else None
                way = None if on is None else side(on[0], on[1])
                if on is None or way is None:
                    found, line = (
                        _combined(code, parts),
                        _line(code, parts, [lines.get(r) for r in read]),
                    )
                else:
                    found = ca.SX(way * on[2])
                    if code == ca.OP_FABS:
                        found = {1: parts[0], -1: -parts[0]}.get(way * on[2], found * parts[0])
            work[to[0]] = found
            lines.pop(to[0], None)
            if line:
                lines[to[0]] = line
    return outputs


def _line(code: int, parts: list[ca.SX], lines: list[Any]) -> tuple[int, float, int] | None:
    """The symbol, number and way of a difference of a symbol and a number; None of any other."""
    if code == ca.OP_NEG and lines[0]:
        return lines[0][0], lines[0][1], -lines[0][2]
    if code not in (ca.OP_ADD, ca.OP_SUB):
        return None
    for i in (0, 1):
        if (line := lines[i]) and parts[1 - i].is_constant():
            symbol, place, way = line
            number = float(parts[1 - i])
            if code == ca.OP_SUB:
                number, way = (number, -way) if i else (-number, way)
            if not (place and number):  # a sum of two numbers might be no double
                return symbol, place - way * number + 0.0, way  # 0 in place of -0
    return None


def _combined(code: int, parts: list[ca.SX]) -> ca.SX:
    """An operation, without terms that are zero since a side is chosen."""
    zero = [part.is_zero() for part in parts]
    if code == ca.OP_ADD and any(zero):
        return parts[0] if zero[1] else parts[1]
    if code == ca.OP_ADD and parts[1].n_dep() == 1 and parts[1].op() == ca.OP_NEG:
        if ca.is_equal(parts[1].dep(0), parts[0]):
            return ca.SX(0)
    if code == ca.OP_SUB and any(zero):
        return parts[0] if zero[1] else -parts[1]
    if (code == ca.OP_MUL and any(zero)) or (code in (ca.OP_DIV, ca.OP_NEG) and zero[0]):
        return ca.SX(0)
    return (ca.SX.unary if len(parts) == 1 else ca.SX.binary)(code, *parts)
