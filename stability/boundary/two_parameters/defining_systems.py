"""Points and curves over two parameters by defining equations joined to those of the members.

On a fold a member is no function of the parameters.  So the unknowns are the member, both
parameters, and vectors:

* a zero: A v = 0; a double zero: A h = v too;
* a cusp: F_u v = 0 and F_u h + F_uu v v = 0, so that u + v s + h s²/2 solves F = 0 to third order;
* a pair: A q = i ω q.

Vectors are scaled by c* q = 1.  Each system is square and regular at a generic point, so that
Krawczyk's test proves it.  With one equation less than unknowns it is a curve of folds or pairs.

Source: Yu. A. Kuznetsov, Elements of Applied Bifurcation Theory, §§ 8.7, 10.2 and 10.5;
W. Govaerts, Numerical Methods for Bifurcations of Dynamical Equilibria, ch. 4;
tests/boundary/test_defining_systems.py.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import cached_property
from typing import Any

import casadi as ca
import numpy as np
from flint import arb, arb_mat

from ...algebra.krawczyk import Values
from ...algebra.number_types import balls
from ...algebra.program import Program
from ...algebra.upright import Upright
from ...base.errors import StabilityError
from ...base.types import Floats
from ...spectra.problem import Problem
from ...systems.graph.constants import exact_numbers
from ..lyapunov_coefficient import derivatives

MOST_NEWTON = 25
"""Most steps of Newton's method."""
LONGEST = 0.3
"""Longest step of Newton's method in a parameter, over the width of its axis."""
CONVERGED = 1e-9
"""Last step of an accepted solution, over the scale of each unknown."""
REAL = 1e-9
"""Frequency, over the largest eigenvalue, up to which an eigenvalue counts as real."""


class MemberSheet:
    """The members of a user's family over two parameters, as points (unknowns, x, y).

    Parameters
    ----------
    problem
        Family with a number for every quantity but the axes.
    names
        Names of x and y.
    """

    def __init__(self, problem: Problem, names: tuple[str, str]) -> None:
        self.problem, self.family = problem, problem.family
        family, system = self.family, self.family.judged
        self.d = derivatives(system)
        self.kept = self.d.kept
        solved = () if family.closed else tuple(family.unknown)
        self.solved = [system.index(n) for n in solved]
        self.rows = [] if family.closed else [system.index(n) for n in family.equations]
        self.axes = [family.meaning(n) for n in names]
        every = [*system.states, *system.parameters]
        self.free = [every.index(n) for n in (*solved, *self.axes)]
        """Positions of unknowns, x and y among states and parameters."""
        table: dict[str, Any] = {
            family.meaning(n): arb(float(v)) for n, v in problem.values.items() if n not in names
        }
        for name, held in family.fixed.items():
            table[name] = arb.pi() / 2 if isinstance(held, Upright) else arb(held)
        if family.closed:
            table |= {n: arb(v) for n, v in family.unknown.items()}
        self._balls = [table.get(n, arb(0)) for n in every]
        self._floats = np.array([float(v.mid()) for v in self._balls])
        self.count = len(self.free)
        twin, rates = self.d.system, self.d.rates  # an equal system, whose symbols the rates hold
        states = twin.x
        slopes = ca.jacobian(rates, states)
        numbers = ca.SX(self.d.column)
        self.function = ca.Function(
            "member",
            [ca.vertcat(states, twin.p), numbers],
            [rates[self.rows], slopes[self.kept, self.kept], slopes[self.rows, self.solved]],
        )

    def points(self, z: Floats) -> Floats:
        """States and parameters of points, shape (N, ·)."""
        out = np.tile(self._floats, (len(z), 1))
        out[:, self.free] = z[:, : self.count]
        return out

    def balls(self, z: Values) -> tuple[Values, Values]:
        """States and parameters of one point in balls."""
        out = list(self._balls)
        for place, v in zip(self.free, z, strict=False):
            out[place] = v
        cut = len(self.family.system.states)
        return out[:cut], out[cut:]

    def matrices(self, z: Floats) -> tuple[Floats, Floats]:
        """A over the kept states and F_u at points."""
        _, whole, unknown_slopes = mapped(self.function, [self.points(z), self.numbers(len(z))])
        return whole, unknown_slopes

    def numbers(self, count: int) -> Floats:
        """The numbers of the graph, a row for each point."""
        return np.tile(np.array(self.d.values, dtype=float), (count, 1))

    def matrix(self, z: Values) -> Any:
        """A over the kept states in balls."""
        x, p = self.balls(z)
        n = len(x)
        slopes = self.d.first.run(balls(), [x, p])[1]
        return arb_mat([[arb(slopes[j * n + i]) for j in self.kept] for i in self.kept])


def mapped(function: ca.Function, rows: Sequence[Floats]) -> list[Floats]:
    """The outputs of a function at rows of its inputs, shapes (N, ·, ·)."""
    count = len(rows[0])
    outputs = function.map(count)(*[r.T for r in rows])
    shapes = [function.size_out(i) for i in range(function.n_out())]
    return [
        np.array(v).reshape(shape[0], count, shape[1]).transpose(1, 0, 2)
        if 0 not in shape
        else np.zeros((count, *shape))
        for v, shape in zip(
            outputs if isinstance(outputs, tuple) else (outputs,), shapes, strict=True
        )
    ]


class DefiningSystem:
    """The equations of one kind of point, or of a curve, over a sheet.

    Parameters
    ----------
    sheet
        The members.
    zero
        What a vanishing eigenvalue does: "" none is asked for, "simple", "double" or "cusp".
    pairs
        Number of pairs.
    """

    def __init__(self, sheet: MemberSheet, zero: str = "", pairs: int = 0) -> None:
        self.sheet, self.zero, self.pairs = sheet, zero, pairs
        system, rates = sheet.d.system, sheet.d.rates
        self._x = system.x
        self._vectors: list[ca.SX] = []
        self._phases: list[ca.SX] = []
        self._rows: list[ca.SX] = [rates[sheet.rows]]
        self.linear: tuple[slice, slice] | None = None
        """The vector h and its equations, which are linear in it."""
        if zero:
            self._add_zero(rates)
        for _ in range(pairs):
            self._add_pair(rates)
        column = ca.vertcat(*self._rows)
        every = ca.vertcat(system.x, system.p)
        w, c = ca.vertcat(*self._vectors), ca.vertcat(*self._phases)
        unknowns = ca.vertcat(*[every[i] for i in sheet.free], w)
        outputs = [ca.densify(column), ca.densify(ca.jacobian(column, unknowns))]
        inputs = [every, w, c, ca.SX(sheet.d.column)]
        self.function = ca.Function("defining", inputs, outputs)
        self.size = unknowns.numel()

    # --- equations ---

    def _vector(self, size: int) -> ca.SX:
        self._vectors.append(ca.SX.sym(f"w{len(self._vectors)}", size))
        return self._vectors[-1]

    def _whole(self, part: ca.SX, places: Sequence[int]) -> ca.SX:
        out = ca.SX(self._x.numel(), 1)
        for k, i in enumerate(places):
            out[i] = part[k]
        return out

    def _along(self, f: ca.SX, v: ca.SX) -> ca.SX:
        return ca.jtimes(f, self._x, v)

    def _add_zero(self, rates: ca.SX) -> None:
        sheet = self.sheet
        cusp = self.zero == "cusp"
        columns, rows = (sheet.solved, sheet.rows) if cusp else (sheet.kept, sheet.kept)
        v, c = self._vector(len(columns)), ca.SX.sym("c", len(columns))
        self._phases.append(c)
        first = self._along(rates, self._whole(v, columns))
        self._rows += [first[rows], ca.dot(c, v) - 1]
        if self.zero == "simple":
            return
        h = self._vector(len(columns))
        next_ = self._along(rates, self._whole(h, columns))[rows]
        bend = self._along(first, self._whole(v, columns))[rows] if cusp else -v
        self._rows += [next_ + bend, ca.dot(c, h)]
        first_, size = sheet.count + len(columns), len(columns)
        height = len(sheet.rows) + size + 1
        self.linear = slice(first_, first_ + size), slice(height, height + size + 1)

    def _add_pair(self, rates: ca.SX) -> None:
        kept = self.sheet.kept
        n = len(kept)
        a, b, w = self._vector(n), self._vector(n), self._vector(1)
        r, s = ca.SX.sym("r", n), ca.SX.sym("s", n)
        self._phases += [r, s]

        def slope(v: ca.SX) -> ca.SX:
            return self._along(rates, self._whole(v, kept))[kept]

        def phase(x: ca.SX, y: ca.SX) -> list[ca.SX]:
            return [ca.dot(r, x) + ca.dot(s, y), ca.dot(r, y) - ca.dot(s, x)]

        first, last = phase(a, b)
        self._rows += [slope(a) + w * b, slope(b) - w * a, first - 1, last]

    # --- values ---

    def at(self, z: Floats, c: Floats) -> tuple[Floats, Floats]:
        """Values and slopes at rows of unknowns and phases, shapes (N, ·) and (N, ·, ·)."""
        sheet = self.sheet
        inputs = [sheet.points(z), z[:, sheet.count :], c, sheet.numbers(len(z))]
        values, slopes = mapped(self.function, inputs)
        return values[..., 0], slopes

    @cached_property
    def _program(self) -> Program:
        """The equations in any number type.

        Raises
        ------
        StabilityError
            If a number of the derivatives was rounded.
        """
        outputs = self.function(*self.function.sx_in())
        if not exact_numbers(*outputs):
            raise StabilityError("a number of the derivatives is not exact in double precision.")
        return Program(self.function, self.sheet.d.values)

    def in_balls(self, c: Floats) -> Callable[[Values], tuple[Values, list[Values]]]:
        """The equations as a function of balls, with the phases of one row."""
        phases = [arb(float(v)) for v in c]

        def system(z: Values) -> tuple[Values, list[Values]]:
            x, p = self.sheet.balls(z)
            inputs = [[*x, *p], list(z[self.sheet.count :]), phases]
            values, slopes = self._program.run(balls(), inputs)
            n = len(values)
            return values, [[arb(slopes[j * n + i]) for j in range(self.size)] for i in range(n)]

        return system

    # --- first guesses ---

    def starts(self, points: Floats) -> tuple[Floats, Floats]:
        """Unknowns and phases to start from at points of the sheet; some points have none."""
        whole, unknown_slopes = self.sheet.matrices(points)
        starts = [
            self._start(p, a, f) for p, a, f in zip(points, whole, unknown_slopes, strict=True)
        ]
        rows = [r for r in starts if r is not None]
        if not rows:
            return np.zeros((0, self.size)), np.zeros((0, 0))
        z, c = (np.array([r[i] for r in rows]) for i in (0, 1))
        if self.linear is not None:
            columns, lines = self.linear
            values, slopes = self.at(z, c)
            block = slopes[:, lines, columns]
            fine = np.isfinite(block).all(axis=(1, 2)) & np.isfinite(values).all(axis=1)
            z, c, block, values = z[fine], c[fine], block[fine], values[fine]
            z[:, columns] -= (np.linalg.pinv(block, rcond=1e-10) @ values[:, lines, None])[..., 0]
        return z, c

    def _start(self, point: Floats, a: Floats, f: Floats) -> tuple[Floats, Floats] | None:
        parts, phases = [point[: self.sheet.count]], []
        block = f if self.zero == "cusp" else a
        if not (np.isfinite(a).all() and np.isfinite(f).all() and block.size):
            return None
        if self.zero:
            v = np.linalg.svd(block)[2][-1]
            parts += [v] if self.zero == "simple" else [v, 0 * v]
            phases.append(v)
        if self.pairs:
            values, modes = np.linalg.eig(a)
            up = np.flatnonzero(values.imag > REAL * np.abs(values).max())
            up = up[np.argsort(np.abs(values[up].real))][: self.pairs]
            if len(up) < self.pairs:
                return None
            for k in up:
                q = modes[:, k] / np.linalg.norm(modes[:, k])
                parts += [q.real, q.imag, np.array([values[k].imag])]
                phases += [q.real, q.imag]
        z = np.concatenate(parts)
        return np.concatenate([z, np.zeros(self.size - len(z))]), np.concatenate(phases)

    def first_steps(self, z: Floats, c: Floats, scale: Floats) -> Floats:
        """Lengths of the first steps of Newton's method in member and parameters, shape (N,)."""
        with np.errstate(all="ignore"):
            values, slopes = self.at(z, c)
            fine = np.isfinite(slopes).all(axis=(1, 2)) & np.isfinite(values).all(axis=1)
            out = np.full(len(z), np.inf)
            steps = _steps(slopes[fine] * scale, values[fine])
            out[fine] = np.linalg.norm(steps[:, : self.sheet.count], axis=1)
        return out

    def solved(self, z: Floats, c: Floats, scale: Floats) -> tuple[Floats, Floats]:
        """Solutions by Newton's method, with their phases; of a curve, the nearest points.

        Parameters
        ----------
        z, c
            Unknowns and phases of each row.
        scale
            Typical size of each unknown.
        """
        count = self.sheet.count
        with np.errstate(all="ignore"):
            for _ in range(MOST_NEWTON):
                if not len(z):
                    break
                values, slopes = self.at(z, c)
                fine = np.isfinite(slopes).all(axis=(1, 2)) & np.isfinite(values).all(axis=1)
                z, c, values, slopes = z[fine], c[fine], values[fine], slopes[fine]
                step = _steps(slopes * scale, values)
                large = np.abs(step[:, count - 2 : count]).max(axis=1, initial=0)
                step *= np.minimum(1, LONGEST / np.maximum(large, 1e-300))[:, None]
                z = z - step * scale
                size = np.abs(step).max(axis=1, initial=0)
                near = np.isfinite(size) & (size < 1e8)
                z, c, size = z[near], c[near], size[near]
                if (size <= 1e-14).all():
                    break
        done = size <= CONVERGED if len(z) else np.zeros(0, dtype=bool)
        return z[done], c[done]


def _steps(slopes: Floats, values: Floats) -> Floats:
    """Newton steps; the shortest ones where there are more unknowns than equations."""
    if slopes.shape[1] == slopes.shape[2]:
        try:
            out: Floats = np.asarray(np.linalg.solve(slopes, values[..., None])[..., 0])
        except np.linalg.LinAlgError:  # one singular matrix among many
            pass
        else:
            return out
    return np.asarray((np.linalg.pinv(slopes, rcond=1e-13) @ values[..., None])[..., 0])
