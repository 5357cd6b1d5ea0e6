"""Formulas as JavaScript and as source of a shader."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

from ...algebra.number_types import Algebra
from ...algebra.program import Program
from ...algebra.straight_lines import Language, Line, Record
from ...base.errors import StabilityError


def _javascript_number(value: float) -> str:
    return repr(int(value)) if value == int(value) and abs(value) < 2**53 else repr(float(value))


def _shader_number(value: float) -> str:
    size = abs(value)
    if size > 3e38:
        raise StabilityError(f"{value:g} is beyond single precision; scale the polynomial.")
    return f"{value:.9g}" if any(c in f"{value:.9g}" for c in ".e") else f"{value:.9g}.0"


JAVASCRIPT = Language(
    "JavaScript",
    "{name} = {text}",
    _javascript_number,
    "Math.{name}({value})",
    "Math.pow({a}, {b})",
    renamed=(("fabs", "abs"),),
)
SHADER = Language(
    "GLSL",
    "float {name} = {text};",
    _shader_number,
    "{name}({value})",
    lacking=("expm1", "log1p"),
    renamed=(("fabs", "abs"),),
)


def javascript(inputs: Sequence[int], formula: Callable[..., Sequence[Any]]) -> str:
    r"""A formula as a JavaScript function of arrays.

    Parameters
    ----------
    inputs
        Number of entries of each argument.
    formula
        Function of the number type and, for each argument, its entries, to a flat list.

    Returns
    -------
    str
        Source of a function that returns an array.

    Examples
    --------
    >>> javascript([2], lambda algebra, x: [x[0] * x[1] + 1])
    '(a0) => {\nconst t0 = a0[0] * a0[1],t1 = t0 + 1;\nreturn [t1];\n}'
    """
    record = Record(JAVASCRIPT)
    given = [[Line(record, f"a{i}[{j}]") for j in range(n)] for i, n in enumerate(inputs)]
    found = ", ".join(record.text(v) for v in formula(record.algebra(), *given))
    names = ", ".join(f"a{i}" for i in range(len(inputs)))
    lines = [f"const {','.join(record.lines)};"] if record.lines else []
    return "\n".join([f"({names}) => {{", *lines, f"return [{found}];", "}"])


def graph(program: Program) -> str:
    """A graph as a JavaScript function; each output dense, row by row, one after the other.

    Examples
    --------
    >>> import casadi as ca
    >>> x = ca.SX.sym("x", 2)
    >>> graph(Program(ca.Function("f", [x], [x[0] / x[1]]))).splitlines()[1:3]
    ['const t0 = a0[0] / a0[1];', 'return [t0];']
    """

    def formula(algebra: Algebra, *inputs: Any) -> list[Any]:
        every = (program.dense(algebra, inputs, i) for i in range(len(program.shapes)))
        return [v for output in every for row in output for v in row]

    return javascript(program.inputs, formula)
