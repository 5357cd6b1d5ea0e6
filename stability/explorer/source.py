"""Formulas as JavaScript, and growth rates in it.

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


def _javascript_number(value: float) -> str:
    return repr(int(value)) if value == int(value) and abs(value) < 2**53 else repr(float(value))


JAVASCRIPT = Language(
    "JavaScript",
    "{name} = {text}",
    _javascript_number,
    "Math.{name}({value})",
    "Math.pow({a}, {b})",
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
    arguments = [[Line(record, f"a{i}[{j}]") for j in range(n)] for i, n in enumerate(inputs)]
    outputs = ", ".join(record.text(v) for v in formula(record.algebra(), *arguments))
    names = ", ".join(f"a{i}" for i in range(len(inputs)))
    lines = [f"const {','.join(record.lines)};"] if record.lines else []
    return "\n".join([f"({names}) => {{", *lines, f"return [{outputs}];", "}"])


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
"""Coefficients of each factor, (value, error) of each condition, numbers positive at members."""
HALVINGS = 52
"""Bisections of the abscissa: as many as a number in double precision has digits."""


def look(quantities: int, formula: Callable[..., Seen], even: Sequence[bool]) -> str:
    """A JavaScript function of a point for a picture of many: growth rate, sign, least of members.

    The sign is the least condition over its error: below -1 the motion is unstable, above 1 it is
    not, and in between double precision does not decide.

    Parameters
    ----------
    quantities
        Number of quantities that name a point.
    formula
        Function of the number type and the quantities to the coefficients of each factor in λ,
        lowest first, to (value, error) of each condition, and to numbers that are positive where
        the family has a member.
    even
        Whether each factor has even powers alone.

    Returns
    -------
    str
        An expression whose value is the function of an array.

    Examples
    --------
    >>> text = look(2, lambda f, q: ([[q[0], q[1], 1.0]], [(q[1], 1.0)], []), [False])
    >>> "abscissa2(" in text, "(a0) => {" in text
    (True, True)
    """
    record = Record(JAVASCRIPT)
    names = [Line(record, f"a0[{i}]") for i in range(quantities)]
    factors, conditions, members = formula(record.algebra(), names)
    needed: dict[str, str] = {}
    rates = []
    for factor, is_even in zip(factors, even, strict=True):
        name, source = _abscissa(len(factor) - 1, even=is_even)
        needed[name] = source
        rates.append(f"{name}({', '.join(record.text(c) for c in factor)})")
    signs = [f"({record.text(v)}) / ({record.text(e)})" for v, e in conditions]
    there = [record.text(v) for v in members]
    least = (f"Math.min({', '.join(texts)})" for texts in (["Infinity", *signs], ["1", *there]))
    lines = [f"const {','.join(record.lines)};"] if record.lines else []
    outputs = ", ".join([f"Math.max({', '.join(['-Infinity', *rates])})", *least])
    body = ["return (a0) => {", *lines, f"return [{outputs}];", "}; })()"]
    return "\n".join(["(() => {", *needed.values(), *body])


def _abscissa(degree: int, *, even: bool) -> tuple[str, str]:
    """Name and source of the largest real part of the roots, from the coefficients."""
    arguments = ", ".join(f"c{i}" for i in range(degree + 1))
    if degree == 1:
        return "abscissa1", f"function abscissa1({arguments}) {{ return -c0 / c1; }}"
    if degree == 2 and even:
        text = f"function even2({arguments}) {{ return Math.sqrt(Math.max(0, -c0 / c2)); }}"
        return "even2", text
    lines = [f"const i = 1 / c{degree};"]
    sizes = (
        f"Math.pow(Math.abs(c{power} * i), {1 / (degree - power)!r})" for power in range(degree)
    )
    lines += [f"const r = 2 * Math.max({', '.join(sizes)});", "if (!(r > 0)) return 0;"]
    above = "i"
    for power in reversed(range(degree)):
        lines += [f"const w{power} = {above} / r, a{power} = c{power} * w{power};"]
        above = f"w{power}"
    monic = ", ".join(f"a{i}" for i in range(degree))
    lines += [
        f"let low = {'-1e-16' if even else '-1'}, high = 1;",
        f"for (let n = 0; n < {HALVINGS}; n++) {{",
        "const m = 0.5 * (low + high);",
        f"if (hurwitz{degree}({monic}, m)) high = m; else low = m;",
        "}",
        "return r * high;" if not even else "return r * Math.max(0, low);",
    ]
    name = f"{'even' if even else 'abscissa'}{degree}"
    body = "\n".join(lines)
    return name, f"{_hurwitz(degree)}\nfunction {name}({arguments}) {{\n{body}\n}}"


def _hurwitz(degree: int) -> str:
    """Whether a monic polynomial has every root to the left of a shift."""
    record = Record(JAVASCRIPT)
    shift = Line(record, "s")
    shifted: list[Any] = [Line(record, f"a{i}") for i in range(degree)] + [1.0]
    for start in range(degree):  # Taylor's shift by repeated synthetic division
        for i in range(degree - 1, start - 1, -1):
            shifted[i] = shifted[i] + shifted[i + 1] * shift
    parameters = ", ".join(f"a{i}" for i in range(degree))
    asked = " && ".join(f"{record.text(v)} > 0" for v in routh(shifted) if isinstance(v, Line))
    body = f"const {','.join(record.lines)};\nreturn {asked};"
    return f"function hurwitz{degree}({parameters}, s) {{\n{body}\n}}"
