"""Formulas of LaTeX read back as numbers: a small reader that shares no code with the package."""

from __future__ import annotations

import math
import re

FUNCTIONS = {
    "sin": math.sin,
    "cos": math.cos,
    "tan": math.tan,
    "exp": math.exp,
    "log": math.log,
    "arcsin": math.asin,
    "arccos": math.acos,
    "arctan": math.atan,
    "sinh": math.sinh,
    "cosh": math.cosh,
    "tanh": math.tanh,
}
TOKEN = re.compile(r"\\left|\\right|\\[a-zA-Z]+|\\.|\d+(?:\.\d+)?|.", re.DOTALL)


def balanced(text: str) -> bool:
    r"""Whether braces, \left and \right, and environments close in order."""
    stack: list[str] = []
    for found in re.finditer(
        r"\\begin\{(\w+\*?)\}|\\end\{(\w+\*?)\}|\\left|\\right|\\.|[{}]", text
    ):
        word = found[0]
        if found[1] or word in ("\\left", "{"):
            stack.append(found[1] or word)
        elif found[2] or word in ("\\right", "}"):
            wanted = found[2] or {"\\right": "\\left", "}": "{"}[word]
            if not stack or stack.pop() != wanted:
                return False
    return not stack


def value(text: str, names: dict[str, float]) -> float:
    """The value of an expression; names maps symbols, as they are printed, to numbers."""
    reader = Reader(text, names)
    found = reader.sum()
    assert reader.rest() == "", reader.rest()
    return found


class Reader:
    """A reader of sums, products, fractions, powers, roots and functions."""

    def __init__(self, text: str, names: dict[str, float]) -> None:
        text = text.replace(r"\bigl(", r"\left(").replace(r"\bigr)", r"\right)")
        for space in (r"\quad", r"\,", "&", "\\\\\n", "\n", "{}"):
            text = text.replace(space, " ")
        self.text, self.at = text, 0
        self.names = sorted(names.items(), key=lambda pair: -len(pair[0]))

    def rest(self) -> str:
        return self.text[self.at :].strip()

    def see(self, word: str) -> bool:
        while self.at < len(self.text) and self.text[self.at] == " ":
            self.at += 1
        return self.text.startswith(word, self.at)

    def take(self, word: str) -> bool:
        if self.see(word):
            self.at += len(word)
            return True
        return False

    def need(self, word: str) -> None:
        assert self.take(word), f"{word} is missing at {self.rest()[:40]}"

    def sum(self) -> float:
        total = -self.product() if self.take("-") else self.product()
        while True:
            if self.take("+"):
                total += self.product()
            elif self.take("-"):
                total -= self.product()
            else:
                return total

    def product(self) -> float:
        total = self.power()
        while self.rest() and not any(
            self.see(w) for w in ("+", "-", "}", "\\right", ",", ">", "<", "=")
        ):
            self.take("\\cdot")
            total *= self.power()
        return total

    def power(self) -> float:
        base = self.atom()
        if self.take("^"):
            return base ** self.braced()
        return base

    def braced(self) -> float:
        self.need("{")
        found = self.sum()
        self.need("}")
        return found

    def atom(self) -> float:
        for name, number in self.names:
            if self.see(name):
                after = self.text[self.at + len(name) : self.at + len(name) + 1]
                if not (name[-1].isalpha() and name[0] == "\\" and after.isalpha()):
                    self.at += len(name)
                    return number
        if self.take("\\frac") or self.take("\\tfrac"):
            top = self.braced()
            return top / self.braced()
        if self.take("\\sqrt"):
            return math.sqrt(self.braced())
        if self.take("\\pi"):
            return math.pi
        for word, function in sorted(FUNCTIONS.items(), reverse=True):  # sinh before sin
            if self.take(f"\\{word}"):
                power = self.braced() if self.take("^") else 1
                return function(self.atom()) ** power
        if self.take("\\left("):
            found = self.sum()
            self.need("\\right)")
            return found
        if self.take("e^"):
            return math.exp(self.braced())
        if self.see("{"):
            return self.braced()
        digits = re.match(r"\d+(?:\.\d+)?", self.rest())
        assert digits, f"nothing is read at {self.rest()[:40]}"
        self.see("")
        self.at += len(digits[0])
        return float(digits[0])


def displays(text: str) -> list[tuple[str, str, str]]:
    """(left, sign, right) of every equation of every align*; lines that go on are joined."""
    found = []
    for body in re.findall(r"\\begin\{align\*\}\n(.*?)\n\\end\{align\*\}", text, re.DOTALL):
        joined = body.replace(" \\\\\n&\\quad{}", " ")
        for line in joined.split(" \\\\\n"):
            left, sign, right = re.split(r" ([=<>]) ", line, maxsplit=1)
            found.append((left.lstrip("&").strip(), sign, right))
    return found
