"""A small reader of the Julia that the package prints: its own grammar, and nothing of Python's.

It reads functions of straight lines: numbers, names, fields, places from 1, calls, tuples, arrays,
and + - * / ^ with Julia's precedence (a power binds tighter than a sign, and from the right).
"""

from __future__ import annotations

import math
import re
from typing import Any

TOKEN = re.compile(r"\s*(?:(\d+\.?\d*(?:[eE][-+]?\d+)?)|([^\W\d]\w*)|(.))")
FUNCTIONS: dict[str, Any] = {
    name: getattr(math, name)
    for name in (
        "sin",
        "cos",
        "tan",
        "sqrt",
        "exp",
        "log",
        "sinh",
        "cosh",
        "tanh",
        "asin",
        "acos",
        "hypot",
        "expm1",
        "log1p",
        "asinh",
        "acosh",
        "atanh",
    )
} | {
    "abs": abs,
    "sign": lambda x: math.copysign(1.0, x) if x else 0.0,
    "atan": lambda y, x=None: math.atan(y) if x is None else math.atan2(y, x),
    "reshape": lambda values, rows, columns: [  # column by column, as Julia stores
        [values[i + rows * j] for j in range(columns)] for i in range(rows)
    ],
}


class Reader:
    """Evaluates one expression; anything that it does not know is an error."""

    def __init__(self, text: str, names: dict[str, Any]) -> None:
        self.tokens = [m.groups() for m in TOKEN.finditer(text.strip())]
        self.names, self.at = names, 0

    def see(self) -> str:
        """The next sign, or empty for a number, a name or the end."""
        return self.tokens[self.at][2] or "" if self.at < len(self.tokens) else ""

    def take(self, sign: str) -> bool:
        if self.see() != sign:
            return False
        self.at += 1
        return True

    def expect(self, sign: str) -> None:
        assert self.take(sign), f"{sign!r} is missing at {self.tokens[self.at :][:3]}"

    def whole(self) -> Any:
        """The value of all of the text."""
        value = self.sum()
        assert self.at == len(self.tokens), f"left over: {self.tokens[self.at :]}"
        return value

    def sum(self) -> Any:
        value = self.product()
        while self.see() in ("+", "-") and self.see():
            value = value + self.product() if self.take("+") else self._less(value)
        return value

    def _less(self, value: Any) -> Any:
        self.expect("-")
        return value - self.product()

    def product(self) -> Any:
        value = self.signed()
        while self.see() in ("*", "/") and self.see():
            if self.take("*"):
                value = value * self.signed()
            else:
                self.expect("/")
                value = value / self.signed()
        return value

    def signed(self) -> Any:
        if self.take("-"):
            return -self.signed()
        return self.power()

    def power(self) -> Any:
        base = self.item()
        return base ** self.signed() if self.take("^") else base

    def item(self) -> Any:
        number, name, _ = self.tokens[self.at]
        if number is not None:
            self.at += 1
            return float(number) if re.search(r"[.eE]", number) else int(number)
        if name is not None:
            self.at += 1
            return self.named(name)
        if self.take("("):
            found, tuple_ = self.listed(")")
            return tuple(found) if tuple_ else found[0]
        self.expect("[")
        return self.listed("]")[0]

    def named(self, name: str) -> Any:
        if self.see() == "(" and name in FUNCTIONS:
            self.expect("(")
            return FUNCTIONS[name](*self.listed(")")[0])
        value = self.names[name]  # a name that no line before has given is an error
        while self.see() in (".", "[") and self.see():
            if self.take("."):
                value = value[self.tokens[self.at][1]]
                self.at += 1
            else:
                self.expect("[")
                place = self.sum()
                self.expect("]")
                assert isinstance(place, int) and 1 <= place <= len(value), (name, place)
                value = value[place - 1]
        return value

    def listed(self, end: str) -> tuple[list[Any], bool]:
        """Values up to a closing sign, and whether a comma stood there."""
        found, commas = [], False
        while not self.take(end):
            found.append(self.sum())
            if self.take(","):
                commas = True
            else:
                assert self.see() == end, self.tokens[self.at :][:3]
        return found, commas


def function_value(file: str, name: str, u: list[float], par: dict[str, float]) -> Any:
    """Value of one of a file's functions of (u, p), line by line."""
    match = re.search(rf"^function {name}\(u, p\)\n(.*?)^end$", file, re.DOTALL | re.MULTILINE)
    assert match, name
    names: dict[str, Any] = {"u": [float(v) for v in u], "p": par}
    *lines, last = [line.strip() for line in match[1].splitlines()]
    for line in lines:
        left, sign, right = line.partition(" = ")
        assert sign and re.fullmatch(r"\w+", left), line
        names[left] = Reader(right, names).whole()
    assert last.startswith("return "), last
    return Reader(last.removeprefix("return "), names).whole()
