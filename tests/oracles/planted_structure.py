"""Small rational systems with planted multiple eigenvalues, and their verdicts over Q.

A block is a table of functions of p.  The same functions give the CasADi graph and the exact
matrix of fractions, whose characteristic polynomial (Faddeev and LeVerrier) is judged by Sturm
chains.  No code is shared with the package.
"""

from __future__ import annotations

import math
import random
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from fractions import Fraction
from typing import Any

import casadi as ca
from exact_oracle import Rationals, nullity, sides
from flint import fmpq, fmpq_poly

import stability as st

Entry = Callable[[Any], Any]
Block = list[list[Entry]]
SIZES = (0.25, 0.5, 1.0, 1.5, 3.0)


@dataclass
class Planted:
    """One system: its family, its exact matrix, and what is asked."""

    family: st.Family
    matrix: Callable[[Fraction], list[list[Fraction]]]
    asked: list[float]
    chosen: list[str]
    extra: dict[str, float]


def number(p: Any, value: float) -> Any:
    """A double among the numbers of p: a fraction and a double would give a double."""
    return Fraction(value) if isinstance(p, Fraction) else value


def constant(value: float) -> Entry:
    return lambda p: p * 0 + number(p, value)


def table(rows: Sequence[Sequence[Entry | float]]) -> Block:
    return [[e if callable(e) else constant(e) for e in row] for row in rows]


class Drawn(random.Random):
    """Blocks of a planted matrix."""

    def real_part(self, p0: float) -> Entry:
        """A function of p: positive, negative, zero for all p, or zero at p0 only."""
        size = self.choice(SIZES) * self.choice([-1, -1, 1])
        tiny = self.choice([-1, 1]) * 2.0 ** -self.choice([30, 60, 200])
        off: Entry = lambda p: p - number(p, p0)  # noqa: E731
        return self.choice(
            [
                constant(size),
                constant(size),
                constant(0.0),
                lambda p: number(p, tiny) * (1 + p * p),  # a number alone would be rounded away
                lambda p: -1 - p * p,
                off,
                lambda p: off(p) * off(p),
                lambda p: -off(p) * off(p),
                lambda p: (p + 1) * (p - 1) - p * p + 1,  # zero, and the graph does not show it
            ]
        )

    def block(self, p0: float) -> tuple[str, Block]:
        kind = self.choice(
            [
                "real",
                "jordan",
                "pair",
                "pairs",
                "centre",
                "quadruple",
                "mirror",
                "gain and loss",
                "zeros",
                "gyroscope",
            ]
        )
        a, b, c = self.real_part(p0), constant(self.choice(SIZES)), self.choice(SIZES)
        minus: Entry = lambda p: -a(p)  # noqa: E731
        down: Entry = lambda p: -b(p)  # noqa: E731
        square = self.choice(
            [constant(-c), constant(-c), lambda p: number(p, p0) - p, lambda p: p - number(p, p0)]
        )
        found: dict[str, Sequence[Sequence[Entry | float]]] = {
            "real": [[a]],
            "jordan": [[a, 1.0, 0.0], [0.0, a, 1.0], [0.0, 0.0, a]][: self.choice([2, 3])],
            "pair": [[a, down], [b, a]],
            # twice the same pair, with or without a Jordan block
            "pairs": [
                [a, down, c := self.choice([0.0, 1.0]), 0.0],
                [b, a, 0.0, c],
                [0.0, 0.0, a, down],
                [0.0, 0.0, b, a],
            ],
            "centre": [[0.0, 1.0], [square, 0.0]],
            "quadruple": [
                [a, down, 0.0, 0.0],
                [b, a, 0.0, 0.0],
                [0.0, 0.0, minus, down],
                [0.0, 0.0, b, minus],
            ],
            "mirror": [[a, 0.0], [0.0, minus]],  # a row of zeros in Routh's array
            "gain and loss": [
                [0.0, 1.0, 0.0, 0.0],
                [-2.0, minus, c, 0.0],
                [0.0, 0.0, 0.0, 1.0],
                [c, 0.0, -2.0, b],
            ],
            "zeros": [[0.0, self.choice([0.0, 1.0])], [0.0, 0.0]],
            "gyroscope": [
                [0.0, 0.0, 1.0, 0.0],
                [0.0, 0.0, 0.0, 1.0],
                [square, 0.0, 0.0, b],
                [0.0, square, down, 0.0],
            ],
        }
        rows = found[kind]
        return kind, table([row[: len(rows)] for row in rows])


def planted(seed: int, *, irrational: bool = False) -> Planted:
    """The system that a seed names.

    Parameters
    ----------
    seed
        Its number.
    irrational
        Whether every rate has the factor √r with r = 2: signs stay, rational numbers go.
    """
    draw = Drawn(f"structure {seed}")
    p0 = draw.choice([0.0, 0.5, 1.0, -1.0, 2.0])
    chosen: list[str] = []
    blocks: list[Block] = []
    while not blocks or (sum(map(len, blocks)) < 5 and draw.random() < 0.7):
        kind, block = draw.block(p0)
        if sum(map(len, blocks)) + len(block) <= 7:
            chosen.append(kind)
            blocks.append(block)
    n = sum(map(len, blocks))
    couple = {(i, j): draw.choice([0, 0, 0, 1, -1]) for i in range(n) for j in range(i + 1, n)}
    steps = [
        (*draw.sample(range(n), 2), draw.choice([-1, 1, 2])) if n > 1 else (0, 0, 0)
        for _ in range(draw.choice([0, 0, 1, 2, n]))
    ]

    def entries(p: Any) -> list[list[Any]]:
        zero = p * 0
        rows = [[zero] * n for _ in range(n)]
        at = 0
        for block in blocks:
            for i, row in enumerate(block):
                for j, e in enumerate(row):
                    rows[at + i][at + j] = e(p)
                for j in range(at + len(block), n):
                    rows[at + i][j] = zero + couple[at + i, j]
            at += len(block)
        for i, j, c in steps if n > 1 else []:  # S A S⁻¹ with S = 1 + c eᵢ eⱼᵀ
            rows[i] = [x + c * y for x, y in zip(rows[i], rows[j], strict=True)]
            for row in rows:
                row[j] = row[j] - c * row[i]
        return rows

    x, p, r = ca.SX.sym("x", n), ca.SX.sym("p"), ca.SX.sym("r")
    matrix = entries(p)
    rates = ca.vertcat(
        *[sum((matrix[i][j] * x[j] for j in range(n)), ca.SX(0)) + x[i] ** 3 for i in range(n)]
    )
    states = tuple("abcdefg"[:n])
    names = ("p", "r") if irrational else ("p",)
    if irrational:
        rates = rates * ca.sqrt(r)
    system = st.System("planted", x, ca.vertcat(p, r) if irrational else p, rates, states, names)
    family = st.Family(system, "rest", at=("p",), held=dict.fromkeys(states, 0.0))
    next_to = math.nextafter(p0, 9) if p0 else 2.0**-60
    near = [p0, next_to, p0 - 2.0**-40, p0 + 0.75, draw.choice([-3.0, 0.1, 1.7])]
    return Planted(family, entries, near, chosen, {"r": 2.0} if irrational else {})


def polynomial(rows: list[list[Fraction]]) -> list[Fraction]:
    """det(λ - A), lowest first, by Faddeev and LeVerrier.

    Examples
    --------
    >>> [int(c) for c in polynomial([[Fraction(1), Fraction(2)], [Fraction(3), Fraction(4)]])]
    [-2, -5, 1]
    """
    n = len(rows)
    out, work = [Fraction(1)], [[Fraction(0)] * n for _ in range(n)]
    full = [[(m, a) for m, a in enumerate(row) if a] for row in rows]
    for k in range(1, n + 1):
        work = [
            [x + (out[-1] if i == j else 0) for j, x in enumerate(row)]
            for i, row in enumerate(work)
        ]
        work = [
            [sum((a * work[m][j] for m, a in some if work[m][j]), Fraction(0)) for j in range(n)]
            for some in full
        ]
        out.append(-sum((work[i][i] for i in range(n)), Fraction(0)) / k)
    return out[::-1]


def verdict_of(coefficients: Sequence[Fraction], dropped: int, kernel: int) -> str:
    """The verdict without some zeros, by Sturm chains along the imaginary axis.

    It is *drifting* where the kernel has fewer dimensions than zeros were left out.
    """
    rest = list(coefficients[dropped:])
    zeros = next(i for i, c in enumerate(rest) if c != 0)
    poly = fmpq_poly([fmpq(c.numerator, c.denominator) for c in rest[zeros:]])
    _, on, right = sides(poly) if poly.degree() else (0, 0, 0)
    if right or on or zeros:
        return "unstable" if right else "neutral"
    return "drifting" if dropped > kernel else "stable"


def kernel_of(rows: Sequence[Sequence[Fraction]]) -> int:
    """Dimension of the kernel."""
    return nullity([[fmpq(e.numerator, e.denominator) for e in row] for row in rows], Rationals())


def zeros_of(one: Planted) -> int:
    """Zeros for all p: those at two numbers that no draw makes special."""
    counts = []
    for p in (Fraction(10007, 7919), Fraction(-4099, 1013)):
        coefficients = polynomial(one.matrix(p))
        counts.append(next(i for i, c in enumerate(coefficients) if c != 0))
    return min(counts)
