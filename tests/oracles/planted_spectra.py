"""Pieces of a plan: matrices of expressions in the parameters whose eigenvalues are known.

A plan is a block-triangular matrix J, carried by a similarity S of integer polynomials with
determinant one.  Its flow is dx/dt = S J S⁻¹ (x - x*) + terms of higher order.
"""

from __future__ import annotations

import math
import random
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from typing import Any

import casadi as ca

Expr = Any  # ca.SX or float
Shape = tuple[Expr, ...]


class Draw(random.Random):
    """Random pieces of a plan."""

    def constant(self) -> float:
        """Few bits, so that sums and products of a plan are exact."""
        return self.choice([0.25, 0.5, 1.0, 1.5, 2.0, 3.0, 5.0, 0.125])

    def point(self) -> float:
        return self.choice([0.31, 0.5, 1.0, 2.0, -1.0, -0.5, 0.1, 3.0, 0.7, -2.0, 1.3])

    def tiny(self) -> float:
        return 2.0 ** -self.choice([10, 17, 27, 33, 40, 46, 50, 53, 56, 60, 66, 83, 100])

    def even(self, p: ca.SX) -> Expr:
        """Something positive for every p."""
        return self.choice([1.0, 1 + p * p, 2 + p, (1 + p) * (1 + p) + 0.5, 0.5 + p * p]) + 2.5

    def negative(self, p: ca.SX) -> Expr:
        return -self.constant() * self.even(p)


# --- real parts, by kind ----------------------------------------------------------------------


def hidden(draw: Draw, p: ca.SX) -> Expr:
    """Zero identically, which a look at the graph's instructions does not show."""
    c = draw.choice([1.0, 2.0, 0.5])
    return draw.choice(
        [
            ca.SX(0),
            ca.SX(0),
            (p + c) * (p + c) - p * p - 2 * c * p - c * c,
            (p - c) * (p + c) - (p * p - c * c),
            c * (p - 1) * (p + 1) + c - c * p * p,
        ]
    )


def accident(draw: Draw, p: ca.SX, p0: float) -> Expr:
    """Zero at p0 and nowhere near it."""
    c = draw.choice([-1, 1]) * draw.choice([1.0, 0.25, 2.0**-10, 2.0**-40, 1024.0])
    return draw.choice([c * (p - p0), c * (p - p0) * (p + 7), c * (p - p0) ** 2, c * (p - p0) ** 3])


def close(draw: Draw, p: ca.SX, p0: float) -> Expr:
    """Nearly zero at p0."""
    sign = draw.choice([-1, 1])
    if draw.random() < 0.5:
        return sign * draw.tiny() * (1 + p * p)
    other = draw.choice([math.nextafter(p0, 9), math.nextafter(p0, -9), p0 * (1 + 1e-12)])
    return sign * draw.choice([1.0, 0.5, 2.0**-20]) * (p - other)


def jumping(draw: Draw, p: ca.SX, p0: float) -> Expr:
    """Zero on one side of some point, or there only; not analytic in p."""
    c = draw.choice([-1, 1]) * draw.choice([0.125, 1.0, 0.5])
    a = draw.choice([0.0, 0.5, 1.0, p0])
    if draw.random() < 0.85:
        return c * draw.choice(
            [
                ca.fabs(p) - p,
                ca.fabs(p) + p,
                ca.sqrt(p * p) - p,
                ca.sqrt(p * p) + p,
                ca.fabs(p - a) - (p - a),
                ca.fabs(p - a) + (p - a),
                ca.sqrt((p - a) ** 2) - p + a,
                ca.sqrt((p - a) * (p - a)) * p - p * p + a * p,
                (p - ca.fabs(p)) * (p - ca.fabs(p)),
                ca.sqrt(p**4) - p * ca.fabs(p),
                ca.fabs(ca.fabs(p) - 1) + ca.fabs(p) - 1,
                p / ca.fabs(p) - 1,
                ca.sqrt((p - a) * (p - a)) - ca.fabs(p - a),
            ]
        )
    return c * draw.choice(
        [
            ca.fmax(p - a, 0),
            ca.fmin(p - a, 0),
            ca.if_else(p > a, 1.0, 0.0),
            ca.if_else(p == p0, 0.0, 1.0),
            ca.floor(p),
            ca.ceil(p) - 1,
            ca.fmod(p, 1.0) - p,
            ca.sign(p) - 1,
        ]
    )


def vanishing(draw: Draw, p: ca.SX, p0: float) -> Expr:
    """Products and powers whose size differs by many orders over p."""
    c = draw.choice([-1, 1]) * draw.choice([1.0, 2.0**-66, 2.0**-20, 2.0**20])
    a = draw.choice([0.0, 1.0, p0])
    return c * draw.choice([p**9, (p - a) ** 9, (p - a) ** 4, p**40, p, p * p - p, (p - a) * p])


def function(draw: Draw, p: ca.SX, p0: float) -> Expr:
    """Transcendental in p: identically zero, zero at a point, flat, or neither."""
    c = draw.choice([-1, 1]) * draw.choice([1.0, 0.5, 2.0**-30])
    return c * draw.choice(
        [
            ca.sin(p) ** 2 + ca.cos(p) ** 2 - 1,
            ca.sin(2 * p) - 2 * ca.sin(p) * ca.cos(p),
            ca.exp(p) * ca.exp(-p) - 1,
            ca.tan(p) * ca.cos(p) - ca.sin(p),
            ca.log(ca.exp(p)) - p,
            ca.sqrt(p * p) - p,
            ca.sqrt((p + 5) * (p + 5)) - p - 5,
            ca.sin(p),
            ca.cos(p) - 1,
            ca.exp(p) - 1,
            ca.log(1 + p * p),
            ca.sin(p) - math.sin(p0),
            ca.exp(p) - math.exp(p0),
            ca.exp(-200 * p * p),
            ca.exp(-20 * p * p),
            ca.exp(-1 / (p * p + 1e-3)),
            ca.sqrt(4 + p) - 2,
            p * ca.sin(p),
        ]
    )


REAL: dict[str, Callable[[Draw, ca.SX, float], Expr]] = {
    "hidden": lambda draw, p, _: hidden(draw, p),
    "accident": accident,
    "close": close,
    "jumping": jumping,
    "vanishing": vanishing,
    "function": function,
}
KINDS: dict[str, tuple[str, ...]] = {
    "zeros": ("hidden", "hidden", "accident", "close"),
    "graphs": ("jumping", "jumping", "jumping", "hidden"),
    "factors": ("vanishing", "vanishing", "accident", "hidden"),
    "functions": ("function", "function", "hidden"),
}


# --- matrices ---------------------------------------------------------------------------------


@dataclass
class Plan:
    """Diagonal blocks with their eigenvalues: ("re", a), ("pair", a, b) or ("square", a)."""

    blocks: list[ca.SX] = field(default_factory=list)
    shapes: list[Shape] = field(default_factory=list)

    @property
    def size(self) -> int:
        return sum(b.shape[0] for b in self.blocks)

    def real(self, a: Expr) -> None:
        self.blocks.append(ca.SX(a))
        self.shapes.append(("re", ca.SX(a)))

    def pair(self, a: Expr, b: Expr) -> None:
        self.blocks.append(ca.blockcat([[ca.SX(a), -ca.SX(b)], [ca.SX(b), ca.SX(a)]]))
        self.shapes.append(("pair", ca.SX(a), ca.SX(b)))

    def square(self, c: Expr) -> None:
        """λ² = c: a centre, a saddle or a Jordan block of zeros."""
        self.blocks.append(ca.blockcat([[ca.SX(0), ca.SX(1)], [ca.SX(c), ca.SX(0)]]))
        self.shapes.append(("square", ca.SX(c)))

    def jordan(self, a: Expr, size: int) -> None:
        block = a * ca.SX.eye(size)
        for i in range(size - 1):
            block[i, i + 1] = 1
        self.blocks.append(block)
        self.shapes.extend([("re", ca.SX(a))] * size)

    def quadruple(self, a: Expr, b: Expr) -> None:
        self.pair(a, b)
        self.pair(-a, b)

    def matrix(self, draw: Draw, couple: float) -> ca.SX:
        n = self.size
        j = ca.SX.zeros(n, n)
        order = list(range(len(self.blocks)))
        draw.shuffle(order)
        at = 0
        for k in order:
            b = self.blocks[k]
            m = b.shape[0]
            j[at : at + m, at : at + m] = b
            for row in range(at, at + m):
                for column in range(at + m, n):
                    if draw.random() < couple:
                        j[row, column] = draw.choice([-2, -1, 1, 2])
            at += m
        return j


def similarity(draw: Draw, n: int, p: ca.SX, steps: int, poly: bool) -> tuple[ca.SX, ca.SX]:
    """S and S⁻¹ with entries that are integer polynomials in p."""
    s, inverse = ca.SX.eye(n), ca.SX.eye(n)
    for _ in range(steps if n > 1 else 0):
        i, j = draw.sample(range(n), 2)
        c: Expr = draw.choice([-1, 1, 2, -2, *([p] if poly else [])])
        s[i, :] += c * s[j, :]
        inverse[:, j] -= c * inverse[:, i]
    return s, inverse


def bend(draw: Draw, d: ca.SX, amount: int) -> ca.SX:
    """Terms of second order and higher in d, so that they leave the linearisation alone."""
    n = d.numel()
    terms = ca.SX.zeros(n)
    for _ in range(amount):
        i, j, k = (draw.randrange(n) for _ in range(3))
        terms[i] += draw.constant() * d[j] * draw.choice([d[k], d[k] * d[j], ca.sin(d[k])])
    return terms


def flow(draw: Draw, plan: Plan, d: ca.SX, p: ca.SX) -> ca.SX:
    """S J S⁻¹ d + terms of higher order, nested or multiplied out."""
    n = plan.size
    j = plan.matrix(draw, draw.choice([0, 0, 0.3]))
    s, inverse = similarity(draw, n, p, draw.choice([0, 0, 1, 2, n]), draw.random() < 0.3)
    linear = s @ (j @ (inverse @ d)) if draw.random() < 0.5 else (s @ j @ inverse) @ d
    if draw.random() < 0.15:
        linear = linear * draw.choice([2.0**-66, 2.0**-20, 2.0**20])
        plan.shapes = []
    return linear + bend(draw, d, draw.choice([0, 0, 1, 3]))


def background(draw: Draw, plan: Plan, p: ca.SX, size: int) -> None:
    """Fill with what is safely stable, now and then with what is not."""
    while plan.size < size:
        room = size - plan.size
        roll = draw.random()
        if room >= 2 and roll < 0.3:
            plan.pair(draw.negative(p), draw.constant())
        elif room >= 2 and roll < 0.4:
            plan.jordan(draw.negative(p), 2)
        elif roll < 0.44:
            plan.real(draw.constant() * draw.even(p))
        else:
            plan.real(draw.negative(p))


def names(n: int) -> tuple[str, ...]:
    return tuple("abcdefgh"[:n])


def scaled(shapes: Sequence[Shape], by: ca.SX) -> list[Shape]:
    """The eigenvalues of a matrix that is multiplied by a positive number."""
    return [
        (kind, *(v * by * by if kind == "square" else v * by for v in values))
        for kind, *values in shapes
    ]


def typical(draw: Draw, p0: float) -> dict[str, float]:
    """Nothing, or a size of p: the asked point, its mirror image, or somewhere else."""
    return draw.choice(
        [{}, {}, {"p": p0}, {"p": -p0}, {"p": draw.point()}, {"p": 10.0}, {"p": 1e-9}, {"p": 1e3}]
    )


def flags(draw: Draw) -> dict[str, bool]:
    return {name: draw.random() < 0.05 for name in ("integrals", "drifts")}


def nearby(draw: Draw, p0: float) -> list[float]:
    return [p0, draw.choice([-p0, draw.point(), p0 * (1 + 1e-9), math.nextafter(p0, 9), 0.0])]
