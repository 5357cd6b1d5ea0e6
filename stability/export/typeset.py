"""Graphs as formulas of LaTeX: a number type whose results are expressions.

A value that is used several times, and is long, gets a name and a line of its own.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field
from typing import Any

from ..algebra.number_types import MORE, UNARY, Algebra
from .symbols import FUNCTIONS

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
    """A number as a node; a node as it is.

    Parameters
    ----------
    value
        A number or a node.
    """
    return value if isinstance(value, Node) else Node("number", text=number(float(value)))


def number(value: float) -> str:
    r"""A double in LaTeX, with the digits that give it back.

    Parameters
    ----------
    value
        A finite double.

    Examples
    --------
    >>> number(2.0), number(0.25), number(1e-9)
    ('2', '0.25', '1\\cdot10^{-9}')
    """
    text = repr(value)
    if "e" not in text:
        return text.removesuffix(".0")
    digits, _, power = text.partition("e")
    return rf"{digits.removesuffix('.0')}\cdot10^{{{int(power)}}}"


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
        """Expressions of values, after those lines that they need.

        Parameters
        ----------
        values
            Nodes or numbers.
        """
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
