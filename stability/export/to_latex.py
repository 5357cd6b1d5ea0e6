"""Equations of motion, Jacobian, characteristic polynomial and conditions in LaTeX."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import casadi as ca

from ..algebra.number_types import MORE, UNARY, Algebra
from ..algebra.polynomial import Polynomial
from ..algebra.program import Program
from ..algebra.upright import Upright
from ..base.errors import ParameterError, shown
from ..bodies.contact_laws import Contact
from ..bodies.disk import Disk
from ..bodies.round_body.body import Body
from ..bodies.subject import family_by_name
from ..derivation.conditions import Conditions, conditions
from ..derivation.latex import FUNCTIONS, escaped, polynomial_rows, scientific, symbols
from ..systems.equations import Equations
from ..systems.family import Family
from ..systems.sources.numeric import NumericSystem

HEAD = r"""\documentclass{article}
\usepackage{amsmath}
\usepackage[margin=15mm,landscape]{geometry}
\allowdisplaybreaks
\begin{document}
"""
"""The document around the formulas: amsmath and geometry, of every LaTeX."""


def latex(
    subject: Equations | Family | Conditions | str,
    *,
    contact: Contact | type[Contact] | str | None = None,
    body: Body | Disk | None = None,
    positive: Sequence[str] = (),
    standalone: bool = True,
    **parameters: Any,
) -> str:
    r"""Equations of motion, Jacobian, characteristic polynomial and conditions in LaTeX.

    Long expressions that occur more than once get names w_1, w_2, … with a line each, so that the
    formulas are those of the graph, term by term.

    Parameters
    ----------
    subject
        A `System` (its equations of motion, and the Jacobian of its rates); a `Family` (the same at
        its steady motions, then the characteristic polynomial and the conditions of stability,
        derived exactly), or its name; or `Conditions` that were derived before (these alone).
    contact, body
        With a family by its name, as for `stability.conditions`.
    positive
        Positive variables of the conditions, as for `stability.conditions`.
    standalone
        Whether the text is a document of its own; otherwise it is a part for one with amsmath.
    **parameters
        Numbers for parameters, in the conditions of a family.

    Returns
    -------
    str
        A document, or the part within one.

    Raises
    ------
    ParameterError
        If the subject is something else, or has no graph.

    Source: the graph itself; tests/export/test_latex.py reads the formulas back.

    Examples
    --------
    >>> import casadi as ca, stability as st
    >>> x, p = ca.SX.sym("x", 2), ca.SX.sym("p")
    >>> pendulum = st.System("pendulum", x, p, ca.vertcat(x[1], -p * ca.sin(x[0])),
    ...                      states=("theta", "omega"), parameters=("g",))
    >>> print(st.export.latex(pendulum, standalone=False).splitlines()[3])
    \dot{\omega} &= -g\,\sin\left(\theta\right)
    """
    subject = family_by_name(subject, body, contact, parameters, "subject")
    if isinstance(subject, Conditions):
        parts = _of_conditions(subject)
    elif isinstance(subject, Family):
        _graph_of(subject.system)
        found = conditions(subject, positive=positive, **parameters)
        parts = [*_of_family(subject), *_of_conditions(found)]
    elif isinstance(subject, Equations):
        parts = _of_system(_graph_of(subject))
    else:
        raise ParameterError(
            f"subject is {shown(subject)}; give a System, a Family or its name, or Conditions."
        )
    text = "\n".join(parts) + "\n"
    return f"{HEAD}{text}\\end{{document}}\n" if standalone else text


def _graph_of(system: Equations) -> Equations:
    if isinstance(system, NumericSystem):
        raise ParameterError(
            f"{system.name} is a Python function without formulas; give a System with a graph."
        )
    system.refuse_algebraic("latex")
    return system


def _of_system(system: Equations) -> list[str]:
    """Rates and Jacobian of a system."""
    names = symbols((*system.states, *system.parameters))
    both = ca.cse([ca.densify(system.rhs), ca.jacobian(system.rhs, system.x)])
    graph = ca.Function("system", [system.x, system.p], both)
    rates, slopes, sheet, places = _read(graph, [system.states, system.parameters], names)
    title = rf"\section*{{Equations of motion: {escaped(system.name)}}}"
    left = [_rate(names[n]) for n in system.states]
    return [
        title,
        *_lines(sheet.lines, list(zip(left, rates, strict=True))),
        r"\section*{Jacobian}",
        *_lines([], _entries(slopes, places, system.states, names)),
    ]


def _of_family(family: Family) -> list[str]:
    """Equations of motion, the steady motion, and the Jacobian at it."""
    system = family.system
    others = family.parameters
    names = symbols((*system.states, *system.parameters, *family.at, *others))
    state = [rf"{names[n]} = {_held(v)}" for n, v in family.held.items()]
    state += [rf"{names[n]}\text{{ solved for}}" for n in family.unknown]
    left_out = [rf"{names[n]}\text{{ of any value}}" for n in family.left_out]
    at = ", ".join(names[n] for n in family.at)
    text = rf"\section*{{Steady motions: {escaped(family.name)}}}"
    given = r",\quad ".join([*state, *left_out])
    said = [rf"\[ {given},\quad \text{{named by }} {at} \]"] if given else []
    program = family.graph.matrix
    inputs = [
        [Node("symbol", text=names[n]) for n in group]
        for group in (family.at, family.unknown, others)
    ]
    values = program.run(algebra(), inputs)[0]
    sheet = Sheet("v")
    slopes = sheet.typeset(values)
    entries = _entries(slopes, program.places[0], system.states, names)
    return [
        *_of_system(system),
        text,
        *said,
        r"\section*{Jacobian at the steady motions}",
        *_lines(sheet.lines, entries),
    ]


def _rate(symbol: str) -> str:
    """The rate of a state."""
    return symbol.replace(r"\dot", r"\ddot", 1) if symbol[:4] == r"\dot" else rf"\dot{{{symbol}}}"


def _held(value: float | Upright) -> str:
    return r"\tfrac{\pi}{2}" if isinstance(value, Upright) else number(float(value))


def _read(
    graph: ca.Function, groups: Sequence[Sequence[str]], names: Mapping[str, str]
) -> tuple[list[str], list[str], Sheet, Sequence[tuple[int, int]]]:
    """Rates and slopes of a graph as expressions, which share their names."""
    program = Program(graph)
    inputs = [[Node("symbol", text=names[n]) for n in group] for group in groups]
    rates, slopes = program.run(algebra(), inputs)
    sheet = Sheet("w")
    every = sheet.typeset([*rates, *slopes])
    return every[: len(rates)], every[len(rates) :], sheet, program.places[1]


def _entries(
    slopes: Sequence[str],
    places: Sequence[tuple[int, int]],
    states: Sequence[str],
    names: Mapping[str, str],
) -> list[tuple[str, str]]:
    """Entries of a Jacobian that are not zero."""
    return [
        (rf"\frac{{\partial {_rate(names[states[i]])}}}{{\partial {names[states[j]]}}}", text)
        for (i, j), text in zip(places, slopes, strict=True)
        if text != "0"
    ]


def _lines(named: Sequence[tuple[str, str]], rows: Sequence[tuple[str, str]]) -> list[str]:
    """An aligned display: names first, then the rows."""
    return _display([f"{left} &= {right}" for left, right in (*named, *rows)])


def _display(rows: Sequence[str]) -> list[str]:
    return [r"\begin{align*}", " \\\\\n".join(rows), r"\end{align*}"] if rows else []


# --- polynomials and conditions ---


def _of_conditions(found: Conditions) -> list[str]:
    """The characteristic polynomial by its factors, and the sign conditions."""
    every = [v.name for v in found.variables]
    names = symbols(
        (*every, *(v for c in found.conditions for v in c.polynomial.variables), "lambda")
    )
    lam = names["lambda"]
    out = [r"\section*{Characteristic polynomial}"]
    powers = [_power(lam, found.zeros)] if found.zeros else []
    for i, factor in enumerate(found.factors, start=1):
        power = f"^{{{factor.multiplicity}}}" if factor.multiplicity > 1 else ""
        powers.append(rf"p_{{{i}}}({lam}){power}")
    out.append(rf"\[ {' '.join(powers)} = 0 \]")
    for i, factor in enumerate(found.factors, start=1):
        terms = [(n, c) for n, c in enumerate(factor.coefficients) if c.terms]
        rows = [(rf"p_{{{i},{n}}}", polynomial(c, names)) for n, c in terms]
        whole = "+".join(rf"p_{{{i},{n}}}{_power(lam, n)}" for n, _ in reversed(terms))
        out += _lines([(rf"p_{{{i}}}({lam})", whole)], rows)
    if found.relations:
        vanishing = [f"&{polynomial(p, names)} = 0" for _, p in found.relations]
        out += ["with", *_display(vanishing)]
    out.append(r"\section*{Conditions of stability}")
    if found.branch:
        out.append(rf"\noindent On {escaped(found.branch)}:")
    for one in found.conditions:
        out.append(rf"\noindent {escaped(one.name)} of $p_{{{one.factor + 1}}}$: {one.status}")
        sign = {"negative": "<", "zero": "="}.get(one.status, ">")
        out += _display([f"&{polynomial(one.polynomial, names)} {sign} 0"])
    return out


def _power(symbol: str, n: int) -> str:
    return "" if n == 0 else rf"\,{symbol}" if n == 1 else rf"\,{symbol}^{{{n}}}"


def polynomial(p: Polynomial, names: Mapping[str, str]) -> str:
    r"""A polynomial in LaTeX, its highest terms first, broken into lines of an `align*`.

    Examples
    --------
    >>> p = Polynomial(("k", "z"), ((2, (1, 1)), (-1, (0, 0))))
    >>> print(polynomial(p, {"k": "k", "z": "z"}))
    2\,k\,z - 1
    """
    terms = sorted(p.terms, key=lambda t: (-sum(t[1]), t[1]))
    rows = polynomial_rows(
        [("-" if c < 0 else "+", str(abs(c)), e) for c, e in terms], p.variables, names
    )
    return " \\\\\n&\\quad{}".join(rows)


# --- graphs as formulas ---


LONG_SHARED, LONG = 24, 100
"""Characters of LaTeX above which an expression that is used again, or any, gets a name."""
SUM, PRODUCT, POWER, ATOM = range(4)
"""How tightly an expression binds."""
ARC = {"asin": "arcsin", "acos": "arccos", "atan": "arctan"}
"""Names of inverse functions in LaTeX."""


@dataclass(eq=False)
class Node:
    """An operation on other nodes; `+ - * /` build the next one."""

    kind: str
    """add, sub, mul, div, neg, pow, call, number or symbol."""
    parts: tuple[Node, ...] = ()
    """What it works on."""
    text: str = ""
    """Symbol, function, or number."""
    uses: int = field(default=0)
    """How often the result is read."""

    def __add__(self, other: Any) -> Node:
        return Node("add", (self, node(other)))

    def __sub__(self, other: Any) -> Node:
        return Node("sub", (self, node(other)))

    def __mul__(self, other: Any) -> Node:
        return Node("mul", (self, node(other)))

    def __truediv__(self, other: Any) -> Node:
        return Node("div", (self, node(other)))

    def __rtruediv__(self, other: Any) -> Node:
        return node(other) / self

    def __neg__(self) -> Node:
        return Node("neg", (self,))


def node(value: Any) -> Node:
    """A number as a node; a node as it is."""
    return value if isinstance(value, Node) else Node("number", text=number(float(value)))


def number(value: float) -> str:
    r"""A double in LaTeX, with the digits that give it back.

    Examples
    --------
    >>> number(2.0), number(0.25), number(1e-9)
    ('2', '0.25', '1\\cdot10^{-9}')
    """
    return scientific(repr(value).removesuffix(".0"))


def algebra() -> Algebra:
    """The number type for `Program.run`.

    Examples
    --------
    >>> algebra().constant(0.5).text
    '0.5'
    """
    table: dict[str, Any] = {name: _call(name) for name in (*UNARY, *MORE)}
    table |= {name: _call(name) for name in ("fabs", "sign", "atan2", "hypot")}
    table["pow"] = lambda base, exponent: Node("pow", (node(base), node(exponent)))
    return Algebra("latex", node, table)


def _call(name: str) -> Any:
    return lambda *given: Node("call", tuple(node(g) for g in given), name)


@dataclass
class Sheet:
    r"""Lines of a set of formulas, with names for long expressions.

    Examples
    --------
    >>> x = Node("symbol", text="x")
    >>> Sheet("w").typeset([x * x + x / 2])
    ['x^{2}+\\frac{x}{2}']
    """

    letter: str
    """Letter of the names."""
    lines: list[tuple[str, str]] = field(default_factory=list)
    """(name, expression) of what got a name, in order."""
    _done: dict[int, tuple[str, int]] = field(default_factory=dict)

    def typeset(self, values: Sequence[Any]) -> list[str]:
        """Expressions of values, after those lines that they need."""
        nodes = [node(v) for v in values]
        order = _ordered(nodes)
        for one in order:
            for part in one.parts:
                part.uses += 1
        top = {id(n) for n in nodes}
        for one in order:
            text, rank = self._written(one)
            shared = one.uses > 1 and len(text) > LONG_SHARED
            if one.kind not in ("symbol", "number") and (
                shared or (len(text) > LONG and id(one) not in top)
            ):
                name = f"{self.letter}_{{{len(self.lines) + 1}}}"
                self.lines.append((name, text))
                text, rank = name, ATOM
            self._done[id(one)] = text, rank
        return [self._done[id(n)][0] for n in nodes]

    def _part(self, one: Node, least: int) -> str:
        """A part, in brackets where it binds less than it must."""
        text, rank = self._done[id(one)]
        return text if rank >= least else rf"\left({text}\right)"

    def _written(self, one: Node) -> tuple[str, int]:
        if one.kind in ("symbol", "number"):
            negative = one.text.startswith("-") or r"\cdot" in one.text
            return one.text, SUM if negative else ATOM
        if one.kind == "call":
            return self._called(one)
        a, b = one.parts[0], one.parts[-1]
        if one.kind == "add" and a is b:
            return rf"2\,{self._part(a, PRODUCT)}", PRODUCT
        if one.kind == "add" and b.kind == "number" and b.text.startswith("-"):
            return f"{self._part(a, SUM)}{b.text}", SUM
        if one.kind == "add":
            return f"{self._part(a, SUM)}+{self._part(b, PRODUCT)}", SUM
        if one.kind == "sub":
            return f"{self._part(a, SUM)}-{self._part(b, PRODUCT)}", SUM
        if one.kind == "neg":
            return f"-{self._part(a, PRODUCT)}", SUM
        if one.kind == "div":
            return rf"\frac{{{self._part(a, SUM)}}}{{{self._part(b, SUM)}}}", PRODUCT
        if one.kind == "pow" or (one.kind == "mul" and a is b):
            exponent = self._part(b, SUM) if one.kind == "pow" else "2"
            base = self._part(a, ATOM)
            return f"{{{base}}}^{{{exponent}}}" if "^" in base else f"{base}^{{{exponent}}}", POWER
        left, right = self._part(a, PRODUCT), self._part(b, PRODUCT)
        apart = r"\cdot " if right[0].isdigit() else r"\,"
        return f"{left}{apart}{right}", PRODUCT

    def _called(self, one: Node) -> tuple[str, int]:
        given = ",".join(self._part(part, SUM) for part in one.parts)
        if one.text == "sqrt":
            return rf"\sqrt{{{given}}}", ATOM
        if one.text == "fabs":
            return rf"\left|{given}\right|", ATOM
        name = ARC.get(one.text, one.text)
        known = one.text in (*FUNCTIONS, *ARC)
        head = f"\\{name}" if known else rf"\operatorname{{{name}}}"
        return rf"{head}\left({given}\right)", ATOM


def _ordered(nodes: Iterable[Node]) -> list[Node]:
    """Every node below these, parts first, without recursion."""
    seen: set[int] = set()
    order: list[Node] = []
    stack = [(n, False) for n in reversed(list(nodes))]
    while stack:
        one, ready = stack.pop()
        if ready:
            order.append(one)
        elif id(one) not in seen:
            seen.add(id(one))
            stack.append((one, True))
            stack += [(p, False) for p in reversed(one.parts)]
    return order
