"""Families whose crossings of the imaginary axis are known in exact arithmetic.

The matrix has blocks with the polynomials λ - a(p) and λ² + b(p) λ + c(p), each repeated by its
power, carried by a similarity of integers with determinant one.  Coefficients are products of
linear factors and of p² - n: their zeros are known, and signs between them are of rationals.
"""

from __future__ import annotations

import math
import random
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from fractions import Fraction
from itertools import pairwise
from typing import Any

import casadi as ca
import numpy as np
from flint import fmpq, fmpq_poly

import stability as st

LOW, HIGH = -2, 2
"""Interval of the parameter."""
VALUES = [Fraction(i, 4) for i in range(-7, 8)]
"""Rational zeros; few, so that zeros of several coefficients coincide."""
SQUARES = (2, 3)
"""n of p² - n, whose zeros are irrational."""


@dataclass(frozen=True, order=True)
class Zero:
    """A zero p of a coefficient: a rational, or sign · √square."""

    near: float
    rational: Fraction | None
    square: int = 0

    def __call__(self, p: Fraction) -> int:
        """Sign of p minus the zero, exactly."""
        if self.rational is not None:
            return (p > self.rational) - (p < self.rational)
        if p * self.near <= 0:
            return 1 if self.near < 0 else -1
        beyond = 1 if p * p > self.square else -1
        return beyond if p > 0 else -beyond


@dataclass(frozen=True)
class Coefficient:
    """± ∏ (p - r)^m ∏ (p² - n), plus nothing."""

    sign: int
    linear: tuple[tuple[Fraction, int], ...]
    squares: tuple[int, ...]

    def __call__(self, p: Any, number: Callable[[Fraction], Any] = lambda r: r) -> Any:
        value: Any = self.sign
        for r, m in self.linear:
            for _ in range(m):
                value = value * (p - number(r))
        for n in self.squares:
            value = value * (p * p - n)
        return value

    def zeros(self) -> Iterator[Zero]:
        for r, _ in self.linear:
            yield Zero(float(r), r)
        for n in self.squares:
            for sign in (-1, 1):
                yield Zero(sign * math.sqrt(n), None, n)

    def vanishes(self, zero: Zero) -> bool:
        return zero in set(self.zeros())

    def near(self, zero: Zero) -> float:
        return float(self(zero.near, float))


@dataclass(frozen=True)
class Block:
    """λ + b, or λ² + b λ + c; to a power."""

    b: Coefficient
    c: Coefficient | None
    power: int

    def unstable(self, p: Fraction) -> int:
        b = self.b(p)
        if self.c is None:
            return self.power * (b < 0)
        c = self.c(p)
        return self.power * (1 if c < 0 else (1 + (c > 0)) * (b < 0))

    def zeros(self) -> set[Zero]:
        return set(self.b.zeros()) | set(self.c.zeros() if self.c else ())

    def on_axis(self, zero: Zero) -> list[float]:
        if self.c is None:
            return [0.0] * self.b.vanishes(zero) * self.power
        if self.c.vanishes(zero):
            return [0.0] * (1 + self.b.vanishes(zero)) * self.power
        size = self.c.near(zero)
        return [math.sqrt(size)] * self.power if size > 0 and self.b.vanishes(zero) else []

    def matrix(self, p: Any) -> Any:
        b = self.b(p, float)
        return [[-b]] if self.c is None else [[0, 1], [-self.c(p, float), -b]]

    def irreducible(self) -> bool:
        if self.c is None:
            return True
        x = fmpq_poly([0, 1])
        b, c = (k(x, lambda r: fmpq(r.numerator, r.denominator)) for k in (self.b, self.c))
        d = fmpq_poly([0]) + b * b - 4 * c
        _, parts = d.numer().factor()
        return any(m % 2 for _, m in parts)


@dataclass(frozen=True)
class Expected:
    zero: Zero
    below: int
    above: int
    rates: list[float]
    touching: list[float]


class Plan:
    """A random family and its crossings."""

    def __init__(self, seed: int) -> None:
        self.draw = random.Random(seed)
        self.blocks = [self._block() for _ in range(self.draw.randint(1, 3))]
        if self.draw.random() < 0.5:  # unstable throughout
            self.blocks.append(Block(Coefficient(-1, (), ()), None, 1))

    def _coefficient(self, most: int) -> Coefficient:
        draw = self.draw
        count = draw.randint(0, most)
        linear = {draw.choice(VALUES): draw.choice([1, 1, 1, 2]) for _ in range(count)}
        squares = [n for n in SQUARES if draw.random() < 0.15]
        return Coefficient(draw.choice([-1, 1]), tuple(linear.items()), tuple(squares))

    def _block(self) -> Block:
        power = self.draw.choice([1, 1, 1, 2])
        while True:
            c = self._coefficient(2) if self.draw.random() < 0.7 else None
            block = Block(self._coefficient(2 if c else 3), c, power)
            if block.irreducible():
                return block

    def crossings(self) -> tuple[list[Expected], list[float]]:
        """Every crossing in the interval, and where eigenvalues touch the axis alone."""
        zeros = sorted(set().union(*(b.zeros() for b in self.blocks)))
        zeros = [z for z in zeros if LOW < z.near < HIGH]
        places = _between(zeros)
        crossings, touching = [], []
        for zero, (low, high) in zip(zeros, pairwise(places), strict=True):
            counts = [[b.unstable(p) for b in self.blocks] for p in (low, high)]
            rates: tuple[list[float], list[float]] = ([], [])
            for block, below, above in zip(self.blocks, *counts, strict=True):
                rates[below == above].extend(block.on_axis(zero))
            if counts[0] != counts[1]:
                crossings.append(
                    Expected(zero, sum(counts[0]), sum(counts[1]), sorted(rates[0]), rates[1])
                )
            elif rates[1]:
                touching.append(zero.near)
        return crossings, touching

    def family(self, route: str, pace: bool = False) -> tuple[st.Family, Callable[[float], float]]:
        """The family, and its axis as a function of the parameter of the plan.

        With `pace` a second parameter s multiplies all rates.
        """
        axis, s = ca.SX.sym("q"), ca.SX.sym("s")
        size = sum(len(b.matrix(0.0)) * b.power for b in self.blocks)
        x, y = ca.SX.sym("x", size), ca.SX.sym("y")
        p, value = {
            "rational": (axis, lambda r: r),
            "exponential": (ca.exp(axis) - 3, lambda r: math.log(r + 3)),
            "sine": (4 * ca.sin(axis), lambda r: math.asin(r / 4)),
            "pieces": (axis + ca.tanh(axis), _solved),
            "unknown": (y, lambda r: r + r**3),
        }[route]
        parts = [block.matrix(p) for block in self.blocks for _ in range(block.power)]
        matrix = ca.diagcat(*(ca.vertcat(*(ca.horzcat(*row) for row in m)) for m in parts))
        turn, back = _similarity(self.draw, size)
        rates = ca.DM(turn) @ matrix @ ca.DM(back) @ x
        names = [f"x{i}" for i in range(size)]
        held = dict.fromkeys(names, 0.0)
        if route == "unknown":
            whole = ca.vertcat(rates, axis - y - y**3)
            system = st.System(
                "planted", ca.vertcat(x, y), axis, whole, states=[*names, "y"], parameters=("q",)
            )
            return st.Family(
                system, "rest", at=("q",), held=held, unknown={"y": 0.0}, equations=("y",)
            ), value
        if pace:
            both = ca.vertcat(axis, s)
            system = st.System("planted", x, both, s * rates, states=names, parameters=("q", "s"))
        else:
            system = st.System("planted", x, axis, rates, states=names, parameters=("q",))
        return st.Family(system, "rest", at=("q",), held=held), value


def _solved(r: float) -> float:
    """The q with q + tanh q = r, by Newton's method."""
    q = r / 2
    for _ in range(50):
        q -= (q + math.tanh(q) - r) / (2 - math.tanh(q) ** 2)
    return q


def _between(zeros: Sequence[Zero]) -> list[Fraction]:
    """A rational in each gap, checked exactly."""
    ends = [float(LOW), *(z.near for z in zeros), float(HIGH)]
    places = [Fraction((a + b) / 2) for a, b in pairwise(ends)]
    for zero, (low, high) in zip(zeros, pairwise(places), strict=True):
        assert zero(low) < 0 < zero(high)
    return places


def _similarity(draw: random.Random, size: int) -> tuple[Any, Any]:
    """An integer matrix with determinant one, and its inverse."""
    turn, back = np.eye(size), np.eye(size)
    for _ in range(3 * size if size > 1 else 0):
        i, j = draw.sample(range(size), 2)
        k = draw.choice([-1, 1])
        turn[i] += k * turn[j]
        back[:, j] -= k * back[:, i]
    return turn, back
