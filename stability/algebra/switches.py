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


def by_signs(symbols: Sequence[ca.SX], values: Sequence[ca.SX]) -> list[ca.SX] | None:
    """Expressions without maxima, branches and comparisons; None where they have none of these.

    Parameters
    ----------
    symbols
        Columns of symbols.
    values
        Expressions of these.
    """
    graph = ca.Function("graph", list(symbols), [ca.densify(v) for v in values])
    codes = operations(graph)
    if SWITCHES.keys().isdisjoint(codes):
        return None
    inputs = [ca.vertsplit(ca.vec(s)) if s.numel() else [] for s in symbols]
    outputs = [ca.SX(*v.shape) for v in values]
    work: dict[int, Any] = {}
    with no_folding():
        for i, code in enumerate(codes):
            to, read = graph.instruction_output(i), graph.instruction_input(i)
            if code == ca.OP_INPUT:
                work[to[0]] = inputs[read[0]][read[1]]
            elif code == ca.OP_OUTPUT:
                outputs[to[0]][to[1]] = work[read[0]]
            elif code == ca.OP_CONST:
                work[to[0]] = ca.SX(graph.instruction_constant(i))
            elif code in SWITCHES:
                work[to[0]] = SWITCHES[code](*(work[r] for r in read))
            else:
                apply = ca.SX.unary if len(read) == 1 else ca.SX.binary
                work[to[0]] = apply(code, *(work[r] for r in read))
    return outputs
