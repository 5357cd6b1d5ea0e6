"""Formulas as JavaScript and as source of a shader, and growth rates in it.

To add a language: a `Language`.  The abscissa of a polynomial is the least shift to the left after
which it is a Hurwitz polynomial.  Routh's array decides this with real arithmetic alone, so that
bisection is cheap and cannot fail.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

from ..algebra.exact.routh import routh
from ..algebra.number_types import Algebra
from ..algebra.program import Program
from ..algebra.straight_lines import Language, Line, Record
from ..base.errors import StabilityError


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


Seen = tuple[list[list[Any]], list[tuple[Any, Any]], list[Any]]
"""Coefficients of each factor, (value, size) of each condition, numbers positive at members."""
HALVINGS = 24
"""Bisections of the abscissa: as many as a single-precision number has digits."""


def look(
    quantities: int,
    formula: Callable[..., Seen],
    even: Sequence[bool],
) -> str:
    """Source of a shader's function: growth rate, least condition over its size, least of members.

    Parameters
    ----------
    quantities
        Number of quantities that name a point.
    formula
        Function of the number type and the quantities to the coefficients of each factor in λ,
        lowest first, to (value, size) of each condition, and to numbers that are positive where
        the family has a member.
    even
        Whether each factor has even powers alone.

    Returns
    -------
    str
        Functions in GLSL.

    Examples
    --------
    >>> text = look(2, lambda f, q: ([[q[0], q[1], 1.0]], [(q[1], 1.0)], []), [False])
    >>> "abscissa2(" in text, "vec3 look(float q0, float q1)" in text
    (True, True)
    """
    record = Record(SHADER)
    names = [Line(record, f"q{i}") for i in range(quantities)]
    factors, conditions, members = formula(record.algebra(), names)
    body = [*record.lines, "float growth = -1e30;", "float sign = 1.0;", "float member = 1.0;"]
    needed: dict[str, str] = {}
    for factor, is_even in zip(factors, even, strict=True):
        name, source = _abscissa(len(factor) - 1, even=is_even)
        needed[name] = source
        given = ", ".join(record.text(c) for c in factor)
        body.append(f"growth = max(growth, {name}({given}));")
    for value, size in conditions:
        body.append(f"sign = min(sign, ({record.text(value)}) / ({record.text(size)}));")
    body += [f"member = min(member, {record.text(value)});" for value in members]
    parameters = ", ".join(f"float q{i}" for i in range(quantities))
    lines = [*needed.values(), f"vec3 look({parameters}) {{", *body]
    return "\n".join([*lines, "return vec3(growth, sign, member);", "}"])


def _abscissa(degree: int, *, even: bool) -> tuple[str, str]:
    """Name and source of the largest real part of the roots, from the coefficients."""
    given = ", ".join(f"float c{i}" for i in range(degree + 1))
    if degree == 1:
        return "abscissa1", f"float abscissa1({given}) {{ return -c0 / c1; }}"
    if degree == 2 and even:
        text = f"float even2({given}) {{ return sqrt(max(0.0, -c0 / c2)); }}"
        return "even2", text
    lines = [f"float i = 1.0 / c{degree};", "float r = 0.0;"]
    for power in range(degree):
        lines.append(f"r = max(r, pow(abs(c{power} * i), 1.0 / {degree - power}.0));")
    lines += ["r *= 2.0;", "if (!(r > 0.0)) return 0.0;", "float w = i;"]
    for power in reversed(range(degree)):
        lines += ["w /= r;", f"float a{power} = c{power} * w;"]
    monic = ", ".join(f"a{i}" for i in range(degree))
    lines += [
        f"float low = {'-1e-7' if even else '-1.0'}, high = 1.0;",
        f"for (int n = 0; n < {HALVINGS}; n++) {{",
        "float m = 0.5 * (low + high);",
        f"if (hurwitz{degree}({monic}, m)) high = m; else low = m;",
        "}",
        "return r * high;" if not even else "return r * max(0.0, low);",
    ]
    name = f"{'even' if even else 'abscissa'}{degree}"
    body = "\n".join(lines)
    return name, f"{_hurwitz(degree)}\nfloat {name}({given}) {{\n{body}\n}}"


def _hurwitz(degree: int) -> str:
    """Whether a monic polynomial has every root to the left of a shift."""
    record = Record(SHADER)
    shift = Line(record, "s")
    shifted: list[Any] = [Line(record, f"a{i}") for i in range(degree)] + [1.0]
    for start in range(degree):  # Taylor's shift by repeated synthetic division
        for i in range(degree - 1, start - 1, -1):
            shifted[i] = shifted[i] + shifted[i + 1] * shift
    parameters = ", ".join(f"float a{i}" for i in range(degree))
    asked = " && ".join(f"{record.text(v)} > 0.0" for v in routh(shifted) if isinstance(v, Line))
    body = "\n".join([*record.lines, f"return {asked};"])
    return f"bool hurwitz{degree}({parameters}, float s) {{\n{body}\n}}"
