"""Coefficients of the cells of a block by Horner schemes, in doubles and in pairs of doubles.

A block of `SIDE` cells has a page, on which each quantity of a cell has its line.  A loop runs over
two or three lines, and so in vector instructions.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from .factors import EPS, renewed, two_product, two_sum

SIDE = 128
"""Cells of a block."""
SET, PLUS, ADD, COPY, TIMES, SCALE, PRODUCT = range(7)
"""Steps of a scheme on a line: set to a number, add a number, add the line below, copy the line
below, multiply by a variable; a number times a variable, the line below times a variable."""

DIVIDED = EPS
"""Relative error of x·(1/y), 2 units of 2⁻⁵³: (1 + d)(1 + d') with |d|, |d'| ≤ 2⁻⁵³."""

U = np.uintp
"""Type of an index that cannot be negative, so that it needs no test."""

# lines of a page, in cells
VARIABLE = 0  # up to four, then their low parts
LOW_VARIABLE, LOW = 4 * SIDE, 5 * SIDE  # from a variable or a level to its low part
UNIT = 8 * SIDE  # of the rate
LEVEL = 9 * SIDE  # of a scheme, up to five, then their low parts
HIGH, HIGH_LOW = 19 * SIDE, 20 * SIDE
LEAD, LEAD_ERROR = 21 * SIDE, 22 * SIDE
A = 23 * SIDE  # coefficients, up to five
E = 28 * SIDE  # their errors
F = 33 * SIDE  # factors
CHANGE = 38 * SIDE
REAL = 39 * SIDE  # of up to six roots
IMAG = 45 * SIDE
RADIUS = 51 * SIDE
TOP, ERROR, TURN, LARGEST = 57 * SIDE, 58 * SIDE, 59 * SIDE, 60 * SIDE
PAGE = 61 * SIDE


def copy(x: int, y: int, w: Any) -> None:
    """Write one line to another one."""
    for j in range(SIDE):
        w[U(y + j)] = w[U(x + j)]


def scheme(steps: Any, numbers: Any, first: int, last: int, w: Any) -> int:
    """Run a Horner scheme in doubles; the line of its value."""
    x = LEVEL
    for k in range(first, last):
        what, number = steps[k, 0], numbers[k]
        x, z = LEVEL + steps[k, 1] * SIDE, VARIABLE + steps[k, 2] * SIDE
        y = x - SIDE
        if what == SCALE:
            for j in range(SIDE):
                w[U(x + j)] = number * w[U(z + j)]
        elif what == SET:
            for j in range(SIDE):
                w[U(x + j)] = number
        elif what == PLUS:
            for j in range(SIDE):
                w[U(x + j)] += number
        elif what == ADD:
            for j in range(SIDE):
                w[U(x + j)] += w[U(y + j)]
        elif what == PRODUCT:
            for j in range(SIDE):
                w[U(x + j)] = w[U(y + j)] * w[U(z + j)]
        elif what == COPY:
            copy(y, x, w)
        else:
            for j in range(SIDE):
                w[U(x + j)] *= w[U(z + j)]
    return x


def long_scheme(steps: Any, numbers: Any, first: int, last: int, w: Any) -> int:
    """The same in pairs of doubles, all positive: each step is right to 2⁻¹⁰⁰ of its value.

    Results go to fixed lines first, so that no test of overlap hinders vector instructions.
    """
    x = LEVEL
    for k in range(first, last):
        what, number = steps[k, 0], numbers[k]
        x, z = LEVEL + steps[k, 1] * SIDE, VARIABLE + steps[k, 2] * SIDE
        if what == SET:
            for j in range(SIDE):
                w[TOP + j], w[ERROR + j] = number, 0.0
        elif what == PLUS:
            for j in range(SIDE):
                s, t = two_sum(w[U(x + j)], number)
                w[TOP + j], w[ERROR + j] = renewed(s, t + w[U(x + LOW + j)])
        elif what == ADD:
            y = x - SIDE
            for j in range(SIDE):
                s, t = two_sum(w[U(x + j)], w[U(y + j)])
                w[TOP + j], w[ERROR + j] = renewed(s, t + (w[U(x + LOW + j)] + w[U(y + LOW + j)]))
        elif what == COPY:
            copy(x - SIDE, TOP, w)
            copy(x - SIDE + LOW, ERROR, w)
        elif what == SCALE:
            for j in range(SIDE):
                s, t = two_product(number, w[U(z + j)])
                w[TOP + j], w[ERROR + j] = renewed(s, t + number * w[U(z + LOW_VARIABLE + j)])
        else:
            y = x - SIDE if what == PRODUCT else x
            for j in range(SIDE):
                p, q = w[U(y + j)], w[U(z + j)]
                s, t = two_product(p, q)
                rest = p * w[U(z + LOW_VARIABLE + j)] + w[U(y + LOW + j)] * q
                w[TOP + j], w[ERROR + j] = renewed(s, t + rest)
        copy(TOP, x, w)
        copy(ERROR, x + LOW, w)
    return x


def steady_lead(steps: Any, parts: Any, row: int, where: Any) -> bool:
    """Whether the leading coefficient on this row is the same in all columns of a tile."""
    for k in range(parts[row, 0], parts[row, 2]):
        if steps[k, 0] >= TIMES and where[steps[k, 2], 2]:
            return False
    return True


def constant(steps: Any, first: int, last: int) -> bool:
    """Whether a scheme is a number alone: set on one line, and copied to others."""
    for k in range(first + 1, last):
        if steps[k, 0] != COPY:
            return False
    return bool(steps[first, 0] == SET)


def coefficients(
    steps: Any, numbers: Any, parts: Any, bounds: Any, first: int, count: int, led: bool, w: Any
) -> None:
    """Monic coefficients of a factor, and their errors, from its row `first` on.

    `led`: the lines of the leading coefficient hold its inverse already.
    """
    for i in range(count - 1 if led else count, -1, -1):
        k = first + i
        high = scheme(steps, numbers, parts[k, 0], parts[k, 1], w)
        value, off = (LEAD, LEAD_ERROR) if i == count else (A + i * SIDE, E + i * SIDE)
        if constant(steps, parts[k, 1], parts[k, 2]):  # such as 0, where no term is negative
            y = numbers[parts[k, 1]]
            for j in range(SIDE):
                x = w[U(high + j)]
                w[U(value + j)], w[U(off + j)] = x - y, bounds[k] * (x + y)
            continue
        copy(high, HIGH, w)
        low = scheme(steps, numbers, parts[k, 1], parts[k, 2], w)
        for j in range(SIDE):
            x, y = w[HIGH + j], w[U(low + j)]
            w[U(value + j)], w[U(off + j)] = x - y, bounds[k] * (x + y)
    if not led:
        invert(DIVIDED, w)
    monic(count, w)


def long_coefficients(
    steps: Any, numbers: Any, parts: Any, bounds: Any, first: int, count: int, w: Any
) -> None:
    """The same from pairs of doubles, with the error of variables in long double."""
    for i in range(count, -1, -1):
        k = first + i
        high = long_scheme(steps, numbers, parts[k, 0], parts[k, 1], w)
        copy(high, HIGH, w)
        copy(high + LOW, HIGH_LOW, w)
        low = long_scheme(steps, numbers, parts[k, 1], parts[k, 2], w)
        value, off = (LEAD, LEAD_ERROR) if i == count else (A + i * SIDE, E + i * SIDE)
        for j in range(SIDE):
            x, y = w[HIGH + j], w[U(low + j)]
            s, t = two_sum(x, -y)
            w[U(value + j)] = s + (t + (w[HIGH_LOW + j] - w[U(low + LOW + j)]))
            w[U(off + j)] = 2.0**-11 * bounds[k] * (x + y)
    invert(DIVIDED + EPS, w)  # value and lead are rounded to doubles: a unit each
    monic(count, w)


def invert(rounding: float, w: Any) -> None:
    """The inverse of the leading coefficient, and the relative error of a product with it."""
    for j in range(SIDE):
        one = 1.0 / w[LEAD + j]
        w[LEAD + j], w[LEAD_ERROR + j] = one, w[LEAD_ERROR + j] * abs(one) + rounding


def monic(count: int, w: Any) -> None:
    """Divide coefficients by the leading one, which is inverted once: divisions take most time.

    From x with error X, L with error δ|L|, and v = x·(1/L) with two roundings, within ρ|x/L|, the
    true quotient is within (X/|L| + |v| (δ + ρ)) of v, to first order.  ρ is the rounding that
    `invert` gets, with the roundings of x and L where their errors leave them out.  1.1 covers
    higher orders, δ < 0.05, and the roundings of the errors themselves.
    """
    for i in range(count):
        x, off = A + i * SIDE, E + i * SIDE
        for j in range(SIDE):
            one = w[LEAD + j]
            value, slack = w[U(x + j)] * one, w[U(off + j)] * abs(one)
            w[U(off + j)] = 1.1 * (slack + abs(value) * w[LEAD_ERROR + j])
            w[U(x + j)] = value
