"""Growth rates of a grid, row by row and block by block: what runs once for each cell.

Factors of a cell start from those of the rows before, by extrapolation.

Coefficients are polynomials in the scaled numbers of both axes: what follows from y is computed
once a row, the rest by Horner's scheme.  A block of `SIDE` cells has a page, on which each quantity
of a cell has its line.  A loop runs over two or three lines, and so in vector instructions.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from ...algebra.kernels.pairs import DOUBLED, doubled, step
from .factors import (
    CHANGE,
    EPS,
    ERROR,
    HIGH,
    IMAG,
    LARGEST,
    LEAD,
    LEAD_ERROR,
    PAGE,
    PLACE,
    RADIUS,
    REAL,
    SIDE,
    TOP,
    TURN,
    UNIT,
    A,
    E,
    F,
    U,
    correct_cubic,
    correct_quartic,
    correct_quintic,
    cubic_discs,
    larger,
    quartic_discs,
    quintic_discs,
    smaller,
)

DIVIDED = EPS
"""Relative error of x·(1/y), 2 units of 2⁻⁵³: (1 + d)(1 + d') with |d|, |d'| ≤ 2⁻⁵³."""


def copy(x: int, y: int, w: Any) -> None:
    """Write one line to another one."""
    for j in range(SIDE):
        w[U(y + j)] = w[U(x + j)]


def along(high: Any, degrees: Any, y: float, out: Any, sizes: Any) -> None:
    """Coefficients by powers of x on a row, and the sums of the sizes of their terms."""
    for k in range(len(high)):
        for i in range(degrees[k] + 1):
            value, size = 0.0, 0.0
            for j in range(high.shape[2] - 1, -1, -1):
                value, size = value * y + high[k, i, j], size * abs(y) + abs(high[k, i, j])
            out[k, i], sizes[k, i] = value, size


def coefficients(
    row: Any, sizes: Any, degrees: Any, bounds: Any, first: int, count: int, led: bool, w: Any
) -> None:
    """Monic coefficients of a factor, and their errors, from its coefficient `first` on.

    `led`: the lines of the leading coefficient hold its inverse already.
    """
    for i in range(count - 1 if led else count, -1, -1):
        k = first + i
        value, off = (LEAD, LEAD_ERROR) if i == count else (A + i * SIDE, E + i * SIDE)
        last, unit, least = degrees[k], bounds[k, 0], bounds[k, 1]
        for j in range(SIDE):
            w[U(value + j)], w[U(off + j)] = row[k, last], sizes[k, last]
        for n in range(last - 1, -1, -1):
            more, size = row[k, n], sizes[k, n]
            for j in range(SIDE):
                t = w[PLACE + j]
                w[U(value + j)] = w[U(value + j)] * t + more
                w[U(off + j)] = w[U(off + j)] * abs(t) + size
        for j in range(SIDE):
            w[U(off + j)] = unit * w[U(off + j)] + least
    if not led:
        invert(DIVIDED, w)
    monic(count, w)


def invert(rounding: float, w: Any) -> None:
    """The inverse of the leading coefficient, and the relative error of a product with it."""
    for j in range(SIDE):
        inverse = 1.0 / w[LEAD + j]
        w[LEAD + j], w[LEAD_ERROR + j] = inverse, w[LEAD_ERROR + j] * abs(inverse) + rounding


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
            inverse = w[LEAD + j]
            value, slack = w[U(x + j)] * inverse, w[U(off + j)] * abs(inverse)
            w[U(off + j)] = 1.1 * (slack + abs(value) * w[LEAD_ERROR + j])
            w[U(x + j)] = value


STRIDE = 16
"""Distance between the cells of a first row that get their factors one after the other."""
MORE = 4
"""Largest number of corrections of a block."""
LONGER = 40
"""Largest number of corrections of a cell that starts from another one."""
ROUNDS = 200
"""Largest number of rounds of a cell that starts from nothing."""
ENOUGH = 8 * EPS
"""Square of a change that leaves no error."""


def correct(degree: int, w: Any) -> int:
    """One correction of the factors of a block; the number of cells that still change."""
    if degree == 3:
        for j in range(SIDE):
            correct_cubic(j, w)
    elif degree == 4:
        for j in range(SIDE):
            correct_quartic(j, w)
    else:
        for j in range(SIDE):
            correct_quintic(j, w)
    open_cells = 0
    for j in range(SIDE):
        open_cells += 0 if w[CHANGE + j] < ENOUGH else 1
    return open_cells


def begin(degree: int, j: int, z: Any, w: Any) -> None:
    """Factors of a cell from all its roots at once (Durand and Kerner), which `z` holds."""
    size = 0.0
    for i in range(degree):
        size = larger(size, abs(w[A + i * SIDE + j]) ** (1.0 / (degree - i)))
    for i in range(degree):
        z[i] = size * complex(0.4, 0.9) ** (i + 1)
    for _ in range(ROUNDS):
        change = 0.0
        for i in range(degree):
            value, others = z[i] + w[A + (degree - 1) * SIDE + j], complex(1.0, 0.0)
            for k in range(degree - 2, -1, -1):
                value = value * z[i] + w[A + k * SIDE + j]
            for k in range(degree):
                if k != i:
                    others *= z[i] - z[k]
            step = value / others
            z[i] -= step
            change = larger(change, abs(step) / abs(z[i]))
        if change < 1e-5:
            break
    join(degree, j, z, w)


def join(degree: int, j: int, z: Any, w: Any) -> None:
    """Real factors of a cell from approximate roots: a real root if odd, and pairs of others."""
    odd = degree % 2
    if odd:
        real = 0
        for i in range(degree):
            real = i if abs(z[i].imag) < abs(z[real].imag) else real
        w[F + j] = z[real].real
        z[real] = z[0]
    for k in range(odd, degree, 2):
        # the root farthest from the real line, then the root nearest to its conjugate
        far = k
        for i in range(k, degree):
            far = i if abs(z[i].imag) > abs(z[far].imag) else far
        root, z[far] = z[far], z[k]
        near = k + 1
        for i in range(k + 1, degree):
            mirrored = root.conjugate()
            near = i if abs(z[i] - mirrored) < abs(z[near] - mirrored) else near
        partner, z[near] = z[near], z[k + 1]
        w[F + k * SIDE + j] = -(root + partner).real
        w[F + (k + 1) * SIDE + j] = (root * partner).real


def rescue(degree: int, j: int, near: Any, z: Any, w: Any) -> None:
    """Factors of a cell whose prediction failed: from the cell before it, or from nothing."""
    for i in range(degree):
        if not abs(w[A + i * SIDE + j]) < math.inf:  # a cell without a member
            return
    for attempt in range(2):
        if attempt == 0:
            for f in range(degree):
                w[F + f * SIDE + j] = near[f]
        else:
            begin(degree, j, z, w)
        for _ in range(LONGER if attempt else 2 * MORE):
            if degree == 3:
                correct_cubic(j, w)
            elif degree == 4:
                correct_quartic(j, w)
            else:
                correct_quintic(j, w)
            if w[CHANGE + j] < ENOUGH:
                return


def discs(degree: int, slot: int, w: Any) -> None:
    """Roots of a factor and the radii of their discs, from the lines of this slot on."""
    if degree == 1:
        to = slot * SIDE
        for j in range(SIDE):
            w[REAL + to + j], w[IMAG + to + j], w[RADIUS + to + j] = -w[A + j], 0.0, w[E + j]
    elif degree == 3:
        for j in range(SIDE):
            cubic_discs(j, w)
    elif degree == 4:
        for j in range(SIDE):
            quartic_discs(j, w)
    else:
        for j in range(SIDE):
            quintic_discs(j, w)


def rate(roots: int, w: Any) -> None:
    """Largest real part of a block, its error and |imaginary part|, and the largest modulus."""
    copy(REAL, TOP, w)
    for s in range(1, roots):
        for j in range(SIDE):
            w[TOP + j] = larger(w[U(REAL + s * SIDE + j)], w[TOP + j])
    for j in range(SIDE):
        w[HIGH + j], w[ERROR + j], w[TURN + j], w[LARGEST + j] = w[TOP + j], math.inf, 0.0, 0.0
    # every disc is clear of the others, so each holds one eigenvalue
    for s in range(roots):
        to = s * SIDE
        for j in range(SIDE):
            x, y, r = w[U(REAL + to + j)], w[U(IMAG + to + j)], w[U(RADIUS + to + j)]
            first = x == w[TOP + j]
            w[HIGH + j] = larger(x + r, w[HIGH + j])
            w[ERROR + j] = smaller(r if first else math.inf, w[ERROR + j])
            w[TURN + j] = larger(y if first else 0.0, w[TURN + j])
            w[LARGEST + j] = larger(abs(x) + y, w[LARGEST + j])
    for j in range(SIDE):
        # roundings of the unit, of the product with it, and of the sums above
        rounding = 6e-16 * abs(w[TOP + j]) + 1e-18 * w[LARGEST + j]
        w[ERROR + j] = larger(w[HIGH + j] - w[TOP + j], w[ERROR + j]) + rounding


def judge_squares(flags: Any, w: Any) -> int:
    """The same for ±√z, λ² = z = -a₀/a₁, neutral where z < 0, in one loop: lines take time."""
    sure = 0
    for j in range(SIDE):
        z, unit = -w[A + j], w[UNIT + j]
        size = abs(z)
        slack, root = w[E + j] / size, math.sqrt(size)
        # |√z - √z'| ≤ √|z| times the relative error of z; where the sign of z is open, again
        error = root * (slack + EPS) if slack < 1 else math.inf
        top, turn = (root, 0.0) if z > 0 else (0.0, root)
        still = (top == 0) & (turn > error)
        error = unit * (0.0 if still else error + (6e-16 * top + 1e-18 * root))
        top, largest = unit * top, unit * root
        good = (error <= flags[2] * largest) & ((top > error) | (error == 0))
        w[TOP + j], w[ERROR + j], w[TURN + j] = top, error, unit * turn
        w[CHANGE + j] = (flags[1] if z > 0 else flags[0]) if good else 0.0
        sure += 1 if good else 0
    return sure


def predict(
    row: int, column: int, many: int, degree: int, past: Any, near: Any, z: Any, w: Any
) -> None:
    """Factors of a block from the rows before; in the first row, from cells a stride apart."""
    if row == 0:
        last = 0
        for anchor in range(0, SIDE + STRIDE - 1, STRIDE):
            j = min(anchor, SIDE - 1)
            rescue(degree, j, near, z, w)
            for f in range(degree):
                near[f] = w[F + f * SIDE + j]
                begun = w[F + f * SIDE + last]
                for k in range(last + 1, j):
                    w[F + f * SIDE + k] = begun + (near[f] - begun) * ((k - last) / (j - last))
            last = j
        return
    before = min(row, 4)
    first, second, third, fourth = (
        (1.0, 0.0, 0.0, 0.0)
        if before == 1
        else (2.0, -1.0, 0.0, 0.0)
        if before == 2
        else (3.0, -3.0, 1.0, 0.0)
        if before == 3
        else (4.0, -6.0, 4.0, -1.0)
    )
    a, b, c, d = (row - 1) % 4, (row - 2) % 4, (row - 3) % 4, (row - 4) % 4
    for f in range(degree):
        to = F + f * SIDE
        for j in range(many):
            k = column + j
            w[to + j] = (
                first * past[a, f, k]
                + second * past[b, f, k]
                + (third * past[c, f, k] + fourth * past[d, f, k])
            )
        for j in range(many, SIDE):
            w[to + j] = w[to + many - 1]


def settle(
    row: int, column: int, many: int, degree: int, past: Any, near: Any, z: Any, w: Any
) -> None:
    """Factors of a block, corrected until they no longer change, and kept for the next rows."""
    predict(row, column, many, degree, past, near, z, w)
    left, now = SIDE, row % 4
    for _ in range(MORE):
        left = correct(degree, w)
        if left == 0:
            break
    if left:
        for j in range(SIDE):
            if not w[CHANGE + j] < ENOUGH:
                for f in range(degree):
                    before = past[now, f, column - 1] if column else math.nan
                    near[f] = w[F + f * SIDE + j - 1] if j else before
                rescue(degree, j, near, z, w)
                if j < many:  # factors may be other ones than before
                    for f in range(degree):
                        for h in range(4):
                            past[h, f, column + j] = w[F + f * SIDE + j]
    for f in range(degree):
        for j in range(many):
            past[now, f, column + j] = w[F + f * SIDE + j]
        near[f] = w[F + f * SIDE + many - 1]


def judge(even: bool, roots: int, flags: Any, w: Any) -> int:
    """Rates of a block in the user's unit; flags, 0 where a bound is not good, on a line."""
    if even:
        return judge_squares(flags, w)
    rate(roots, w)
    sure = 0
    for j in range(SIDE):
        unit = w[UNIT + j]
        top, error, largest = unit * w[TOP + j], unit * w[ERROR + j], unit * w[LARGEST + j]
        good = (error <= flags[2] * largest) & (abs(top) > error)
        w[TOP + j], w[ERROR + j], w[TURN + j] = top, error, unit * w[TURN + j]
        w[CHANGE + j] = (flags[1] if top > 0 else flags[0]) if good else 0.0
        sure += 1 if good else 0
    return sure


def leave(cell: int, j: int, count: int, poor: Any, kept: Any, w: Any) -> int:
    """List a cell that is to be computed again, with its factors, if its bound is not good."""
    if w[CHANGE + j] == 0:
        poor[count] = cell
        for f in range(len(kept)):
            kept[f, count] = w[F + f * SIDE + j]
        return count + 1
    return count


def store(
    at: int,
    many: int,
    sure: int,
    count: int,
    out: Any,
    codes: Any,
    poor: Any,
    kept: Any,
    w: Any,
) -> int:
    """Write the cells of a block from `at` on, and list those that are to be computed again."""
    for q in range(3):
        for j in range(many):
            out[q][U(at + j)] = w[U(TOP + q * SIDE + j)]
    for j in range(many):
        codes[U(at + j)] = w[U(CHANGE + j)]
    for j in range(many if sure < SIDE else 0):
        count = leave(at + j, j, count, poor, kept, w)
    return count


def sweep(
    table: Any,
    xs: Any,
    ys: Any,
    scale: Any,
    even: bool,
    flags: Any,
    out: Any,
    codes: Any,
    poor: Any,
    kept: Any,
) -> int:
    """Growth rates and flags of a grid; the number of cells that are to be computed again.

    Parameters
    ----------
    table
        Coefficients (·, powers of x, powers of y), the degree in x of each, (relative, absolute)
        bound on the error of each, and (first coefficient, degree) of each factor.
    xs, ys
        Scaled numbers of the axes.
    scale
        Units of the rate, flat, and the steps of a row and a column in them.
    even
        Whether the polynomial is linear in λ².
    flags
        Flags of stable and unstable cells, and the error of the abscissa, relative to the largest
        modulus, beyond which a cell is computed again.
    out, codes
        Abscissa, error, frequency and flags, each of shape (rows · columns,).
    poor, kept
        Cells that are to be computed again, and their factors, shapes (·,) and (degree, ·).
    """
    high, degrees, bounds, factors = table
    units, down, across = scale
    rows, columns = len(ys), len(xs)
    degree = factors[0, 1]
    past = np.zeros((4, degree, columns))
    near, z = np.full(degree, math.nan), np.zeros(degree, dtype=np.complex128)
    w, count = np.zeros(PAGE), 0
    line, sizes = np.zeros(high.shape[:2]), np.zeros(high.shape[:2])
    steady = len(factors) == 1 and degrees[factors[0, 0] + degree] == 0
    for row in range(rows):
        along(high, degrees, ys[row], line, sizes)
        for column in range(0, columns, SIDE):
            many = min(SIDE, columns - column)
            for j in range(SIDE):  # the last cell is repeated
                at = column + min(j, many - 1)
                w[PLACE + j], w[UNIT + j] = xs[at], units[row * down + at * across]
            slot = 0
            for k in range(len(factors)):
                first, n = factors[k]
                coefficients(line, sizes, degrees, bounds, first, n, steady and column > 0, w)
                if n > 1:
                    settle(row, column, many, n, past, near, z, w)
                if not even:
                    discs(n, slot, w)
                slot += n
            sure, at = judge(even, slot, flags, w), row * columns + column
            count = store(at, many, sure, count, out, codes, poor, kept, w)
    return count


def sweep_cells(
    a: Any, e: Any, columns: int, flags: Any, out: Any, codes: Any, poor: Any, kept: Any
) -> int:
    """The same from monic coefficients of every cell and bounds on their errors, one row each."""
    degree = len(a)
    past = np.zeros((4, degree, columns))
    near, z = np.full(degree, math.nan), np.zeros(degree, dtype=np.complex128)
    w, count = np.zeros(PAGE), 0
    w[UNIT : UNIT + SIDE] = 1.0
    for row in range(a.shape[1] // columns):
        for column in range(0, columns, SIDE):
            many, at = min(SIDE, columns - column), row * columns + column
            for i in range(degree):
                for j in range(SIDE):  # the last cell is repeated
                    cell = at + min(j, many - 1)
                    w[U(A + i * SIDE + j)], w[U(E + i * SIDE + j)] = a[i, cell], e[i, cell]
            settle(row, column, many, degree, past, near, z, w)
            discs(degree, 0, w)
            sure = judge(False, degree, flags, w)
            count = store(at, many, sure, count, out, codes, poor, kept, w)
    return count


def refine(
    table: Any,
    rest: Any,
    xs: Any,
    ys: Any,
    scale: Any,
    even: bool,
    flags: Any,
    out: Any,
    codes: Any,
    cells: Any,
    starts: Any,
    poor: Any,
    kept: Any,
) -> int:
    """The same for some cells, in increasing order, with coefficients in pairs of doubles.

    `rest` is what rounding to doubles left of the coefficients, and the scaled numbers are pairs of
    doubles too, shapes (2, ·).  `starts` are factors near those of the cells.
    """
    high, degrees, bounds, factors = table
    units, down, across = scale
    degree, columns = factors[0, 1], xs.shape[1]
    w, count, last = np.zeros(PAGE), 0, -1
    first = np.zeros((high.shape[0], high.shape[1], 3))
    value, off = np.zeros((len(high), SIDE)), np.zeros((len(high), SIDE))
    for start in range(0, len(cells), SIDE):
        many = min(SIDE, len(cells) - start)
        for j in range(SIDE):
            cell = start + min(j, many - 1)
            row, column = cells[cell] // columns, cells[cell] % columns
            if row != last:
                last = row
                for k in range(len(high)):
                    for i in range(degrees[k] + 1):
                        first[k, i] = doubled(high[k, i], rest[k, i], ys[0, row], ys[1, row])
            for k in range(len(high)):
                upper, lower, size = 0.0, 0.0, 0.0
                for i in range(degrees[k], -1, -1):
                    upper, lower = step(
                        upper, lower, xs[0, column], xs[1, column], first[k, i, 0], first[k, i, 1]
                    )
                    size = size * abs(xs[0, column]) + first[k, i, 2]
                value[k, j], off[k, j] = upper + lower, DOUBLED * size + bounds[k, 1]
            w[UNIT + j] = units[row * down + column * across]
            for f in range(degree):
                w[F + f * SIDE + j] = starts[f, cell]
        slot = 0
        for k in range(len(factors)):
            begin_, n = factors[k]
            for i in range(n + 1):
                to, at = (LEAD, LEAD_ERROR) if i == n else (A + i * SIDE, E + i * SIDE)
                for j in range(SIDE):
                    w[U(to + j)], w[U(at + j)] = value[begin_ + i, j], off[begin_ + i, j]
            invert(DIVIDED + EPS, w)  # value and lead are rounded to doubles: a unit each
            monic(n, w)
            for _ in range(2 if n > 1 else 0):
                correct(n, w)
            if not even:
                discs(n, slot, w)
            slot += n
        judge(even, slot, flags, w)
        for j in range(many):
            for q in range(3):
                out[q][cells[start + j]] = w[TOP + q * SIDE + j]
            codes[cells[start + j]] = w[CHANGE + j]
            count = leave(cells[start + j], j, count, poor, kept, w)
    return count
