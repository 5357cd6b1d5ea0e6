"""A pair of eigenvalues on the imaginary axis, proved: member, frequency and mode together.

The equations are those of the member, A v = i ω v, and a condition that fixes the size and phase of
v.  They are regular where the pair is simple and crosses with speed, also where other eigenvalues
vanish by structure.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from flint import acb, acb_mat, arb, arb_mat

from .derivatives import Line
from .krawczyk import NotProvedError, Values, polished, proved

Balls = list[Any]


@dataclass(frozen=True)
class Pair:
    """A crossing pair, in balls."""

    line: Line
    """The line along which it crosses."""
    value: Any
    """Value of the axis."""
    unknowns: Balls
    """The member's unknowns."""
    frequency: Any
    """ω."""
    mode: Balls
    """Eigenvector over the kept states, complex, of unit length."""
    box: Balls
    """All unknowns of the equations, to start a search nearby."""

    @property
    def point(self) -> tuple[Balls, Balls]:
        """States and parameters."""
        return self.line.point(self.value, self.unknowns)

    @property
    def matrix(self) -> Any:
        """Linearisation over the kept states."""
        kept = self.line.d.kept
        _, slopes, _ = self.line.first(*self.point)
        return arb_mat([[slopes[i][j] for j in kept] for i in kept])


class PairEquations:
    """The equations of a pair: unknowns are the axis, the member's unknowns, Re v, Im v and ω.

    Parameters
    ----------
    line
        The line.
    phase
        c of the condition c* v = 1, complex doubles over the kept states.
    """

    def __init__(self, line: Line, phase: Any) -> None:
        self.line = line
        self.phase = [(arb(float(c.real)), arb(float(c.imag))) for c in phase]
        self.count = len(line.solved)

    def cut(self, z: Values) -> tuple[Any, Values, Values, Values, Any]:
        """The unknowns in parts."""
        m, n = self.count, len(self.line.d.kept)
        return z[0], z[1 : 1 + m], z[1 + m : 1 + m + n], z[1 + m + n : 1 + m + 2 * n], z[-1]

    def whole(self, part: Values) -> Values:
        """A vector over the kept states as one over all."""
        out = [arb(0)] * len(self.line.family.system.states)
        for i, v in zip(self.line.d.kept, part, strict=True):
            out[i] = v
        return out

    def __call__(self, z: Values) -> tuple[Values, list[Values]]:
        """Values and rows of slopes of the equations."""
        line, kept = self.line, self.line.d.kept
        value, unknowns, vr, vi, w = self.cut(z)
        x, p = line.point(value, unknowns)
        rates, slopes, by_axis = line.first(x, p)
        n, m, size = len(kept), self.count, len(z)
        values: Values = []
        rows: list[Values] = []
        for i in line.rows:
            values.append(rates[i])
            rows.append([by_axis[i], *[slopes[i][j] for j in line.solved]] + [arb(0)] * (2 * n + 1))
        for part, other, sign, start in ((vr, vi, 1, 0), (vi, vr, -1, n)):
            full = self.whole(part)
            turns = [line.turned(x, p, full)]
            turns += [line.second(x, p, full, line.unit(j)) for j in line.solved]
            for k, i in enumerate(kept):
                total = sum((slopes[i][j] * v for j, v in zip(kept, part, strict=True)), arb(0))
                values.append(total + sign * w * other[k])
                row = [arb(0)] * size
                row[: 1 + m] = [arb(t[i]) for t in turns]
                for c, j in enumerate(kept):
                    row[1 + m + start + c] = slopes[i][j]
                row[1 + m + n - start + k] += sign * w
                row[-1] = sign * other[k]
                rows.append(row)
        phase = self.phase
        triples = list(zip(phase, vr, vi, strict=True))
        values.append(sum((a * r + b * s for (a, b), r, s in triples), arb(-1)))
        values.append(sum((a * s - b * r for (a, b), r, s in triples), arb(0)))
        empty = [arb(0)] * (1 + m)
        rows.append([*empty, *[a for a, _ in phase], *[b for _, b in phase], arb(0)])
        rows.append([*empty, *[-b for _, b in phase], *[a for a, _ in phase], arb(0)])
        return values, rows


def guess(line: Line, value: float, frequency: float) -> tuple[PairEquations, list[float]]:
    """Equations of a pair and a first guess in double precision.

    Parameters
    ----------
    line
        The line.
    value, frequency
        Approximate value of the axis and |Im λ|.
    """
    family = line.family
    given = {n: float(arb(v).mid()) for n, v in line.fixed.items()} | {line.axis: value}
    a = np.array([[given[n] for n in family.at]])
    q = np.array([[given[n] for n in family.parameters]]).reshape(1, -1)
    u = family.solve(a, q)
    kept = line.d.kept
    matrix = family.matrix(a, u, q)[0][np.ix_(kept, kept)]
    values, vectors = np.linalg.eig(matrix)
    best = int(np.argmin(np.abs(values - 1j * frequency)))
    mode = vectors[:, best] / np.linalg.norm(vectors[:, best])
    unknowns = line.member(value)
    return PairEquations(line, mode), [
        value,
        *unknowns,
        *map(float, mode.real),
        *map(float, mode.imag),
        float(values[best].imag),
    ]


def pair_near(line: Line, value: float, frequency: float) -> Pair:
    """The crossing pair near a value of the axis, proved at the working precision.

    Parameters
    ----------
    line
        The line.
    value, frequency
        Approximate value of the axis and |Im λ|.

    Raises
    ------
    NotProvedError
        If the test fails: the pair is not simple, does not cross with speed, or is not there.
    """
    equations, start = guess(line, value, frequency)
    return pair_of(equations, proved(equations, polished(equations, start)))


def pair_of(equations: PairEquations, box: Values) -> Pair:
    """A pair from a proved solution of its equations, with the mode scaled to unit length."""
    value, unknowns, vr, vi, w = equations.cut(box)
    if not w > 0:
        raise NotProvedError
    mode = [acb(r, s) for r, s in zip(vr, vi, strict=True)]
    length = sum((r * r + s * s for r, s in zip(vr, vi, strict=True)), arb(0)).sqrt()
    mode = [v / length for v in mode]
    return Pair(equations.line, value, unknowns, w, mode, box)


# --- linear algebra next to an eigenvalue ---


def bordered(matrix: Any, right: Balls, *, by: Balls | None = None) -> Balls:
    """The left null vector of a singular matrix, scaled so that its product with `right` is 1.

    Parameters
    ----------
    matrix
        Complex matrix whose kernel is spanned by `right`.
    right
        Null vector.
    by
        Vector outside the matrix's range; a numeric left null vector when left out.

    Raises
    ------
    NotProvedError
        If the kernel is not proved to be one-dimensional, or the eigenvalue to be simple.
    """
    n = len(right)
    table = np.array(
        [
            [complex(matrix[i, j].real.mid(), matrix[i, j].imag.mid()) for j in range(n)]
            for i in range(n)
        ]
    )
    if not np.isfinite(table).all():
        raise NotProvedError
    column = by or [acb(float(c.real), float(c.imag)) for c in np.linalg.svd(table)[0][:, -1]]
    rows = [[matrix[j, i] for j in range(n)] + [right[i].conjugate()] for i in range(n)]
    rows.append([*column, acb(0)])
    try:
        solved = acb_mat(rows).solve(acb_mat(n + 1, 1, [acb(0)] * n + [acb(1)]))
    except ZeroDivisionError:
        raise NotProvedError from None
    left = [solved[i, 0] for i in range(n)]
    size = dot(left, right)
    if size.contains(0):
        raise NotProvedError
    return [v / size for v in left]


def dot(x: Balls, y: Balls) -> Any:
    """Σ xᵢ yᵢ, without conjugation."""
    return sum((s * t for s, t in zip(x, y, strict=True)), acb(0))


def shifted(matrix: Any, number: Any) -> Any:
    """A - number, complex."""
    n = matrix.nrows()
    return acb_mat(
        [[acb(matrix[i, j]) - (number if i == j else 0) for j in range(n)] for i in range(n)]
    )


def solve(matrix: Any, right: Balls) -> Balls:
    """Solution of a regular complex system."""
    try:
        found = matrix.solve(acb_mat(len(right), 1, [acb(v) for v in right]))
    except ZeroDivisionError:
        raise NotProvedError from None
    return [found[i, 0] for i in range(len(right))]


def direction(line: Line, x: Balls, p: Balls) -> tuple[Balls, list[Balls]]:
    """dx/d axis along the family over all states, and the Jacobian.

    Parameters
    ----------
    line
        The line.
    x, p
        A member.
    """
    _, slopes, by_axis = line.first(x, p)
    out = [arb(0)] * len(x)
    if line.by_state:
        out[line.place] = arb(1)
    if line.solved:
        rows = arb_mat([[slopes[i][j] for j in line.solved] for i in line.rows])
        try:
            turn = rows.solve(arb_mat(len(line.rows), 1, [-by_axis[i] for i in line.rows]))
        except ZeroDivisionError:
            raise NotProvedError from None
        for k, j in enumerate(line.solved):
            out[j] = out[j] + turn[k, 0]
    return out, slopes


def eigenvalue_speed(pair: Pair, left: Balls, v: Sequence[Any]) -> Any:
    """dλ/d axis = w (dA/d axis) v for a simple eigenvalue with w v = 1."""
    line, kept = pair.line, pair.line.d.kept
    x, p = pair.point
    along, _ = direction(line, x, p)
    full = [acb(0)] * len(x)
    for i, c in zip(kept, v, strict=True):
        full[i] = c
    turned = line.turned(x, p, full)
    if line.by_state:  # the axis itself is in `turned` already
        along = list(along)
        along[line.place] = arb(0)
    more = line.second(x, p, full, along)
    return dot(left, [acb(turned[i]) + acb(more[i]) for i in kept])
