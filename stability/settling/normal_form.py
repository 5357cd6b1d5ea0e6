"""Coordinates about a member in which terms of second order vanish, and bounds of what is left.

With z = Z e and w = y - y_c - ℓ·e the field is z' = M z + …, w' = 0 + …  Near the member

    u = z + P(z, z) + w N z,   W = w + q(z, z) + w c·z

obey u' = M u + …, W' = … without terms of second order, but those that are nearly resonant: of
w z the change of the eigenvalues along the family stays.  P, N, q, c, ℓ, M and Z are doubles and
taken as exact.  What they leave is bounded, so that only the size of the tube depends on them.

Source: homological equation, V. I. Arnold, Geometrical Methods in the Theory of Ordinary
Differential Equations (1983), section 22; tests/settling/test_tube.py.

Derivatives are tapes of balls of doubles.  With ℓ a row that is given, e' = G and y' = g are read
at y = y_c + w + ℓ·e.  So the derivatives in e at fixed w follow the slow direction of the line.
The graph must be smooth wherever its third derivative has a finite enclosure: `smooth_field` keeps
out |x| and sign x, whose kinks leave no trace in a derivative.  Numbers that CasADi folds while it
differentiates are rounded once, which the bounds of roundings of each term cover.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache
from typing import Any, NamedTuple

import casadi as ca
import numpy as np

from ..algebra.kernels.double_balls import U
from ..algebra.kernels.tape import Tape, recorded
from ..algebra.number_types import Algebra
from ..algebra.program import Program
from ..base.types import Floats
from .box import eigen, real_basis
from .surroundings import Surroundings

ROOM = 2.0**-9
"""Largest |w|, over which the members' derivatives are enclosed."""
LOOSE = 256.0 * U
"""Bounds the roundings of a sum of products of four factors, over the sum of their sizes."""
WIDE = 1.0 + 2.0**-40
"""Rounds up what at most 8000 roundings made."""
NEAR = 2.0
"""Slowest rates below which a combination of eigenvalues is nearly resonant."""


class Form(NamedTuple):
    """The coordinates; the first axis counts members."""

    ell: Floats
    """ℓ, shape (N, m)."""
    z: Floats
    """Z, shape (N, m, m)."""
    p: Floats
    """P, shape (N, m, m, m), the first of the last three axes that of the result."""
    n: Floats
    """N, shape (N, m, m)."""
    q: Floats
    """q, shape (N, m, m)."""
    c: Floats
    """c, shape (N, m)."""


@dataclass(frozen=True, eq=False)
class NormalFormBounds:
    """Upper bounds; each has shape (N,) unless another one is given."""

    slowest: Floats
    """s: the symmetric part of M is -s at most; not positive where the member is not stable."""
    p: Floats
    """|P|."""
    n: Floats
    """|N|."""
    q: Floats
    """|q|."""
    c: Floats
    """|c|."""
    rows: Floats
    """Lengths of the rows of Z⁻¹, shape (N, m)."""
    z: Floats
    """Sizes of the entries of Z, shape (N, m, m)."""
    still: Floats
    """|Z A Z⁻¹ - M| at the member."""
    turn: Floats
    """Its slope in w."""
    turn_left: Floats
    """|L|, the part of that slope that N leaves."""
    turn_even: Floats
    """|L + Lᵀ|/2, which alone changes |u|."""
    turn_off: Floats
    """What the slope may differ from that, over ROOM."""
    bend: Floats
    """Half the second derivative of z', over ROOM."""
    left: Floats
    """The part of it that P leaves."""
    along: Floats
    """First derivative of w' at the member."""
    along_turn: Floats
    """Its slope in w."""
    along_left: Floats
    """The part of that slope that c leaves."""
    along_bend: Floats
    """Half the second derivative of w', over ROOM."""
    along_bend_left: Floats
    """The part of it that q leaves."""


def normal_form(
    made: DerivativeTapes, y: Floats, arguments: Floats
) -> tuple[Form, NormalFormBounds]:
    """The coordinates about members, and their bounds.

    Parameters
    ----------
    made
        Derivatives of the field.
    y, arguments
        Members, shape (N,), and the second argument of the programs, shape (N, ·).

    Returns
    -------
    form, bounds
    """
    with np.errstate(all="ignore"):  # nan is never proved
        exact = at_members(made, y, 0.0, arguments)
        about = at_members(made, y, ROOM, arguments)
        _, values, vectors, rate = eigen(exact[0][:, :-1])
        values, basis = values.astype(complex), real_basis(values, vectors)
        z = _inverse(basis)
        ell = slow_rows(exact[0])
        s = _shear(z, ell)
        parts = _Parts(s, basis, exact, about)
        form = _removed(values, parts, rate, ell, z)
        return form, parts.bounds(_block(values), rate, form)


def _inverse(a: Floats) -> Floats:
    out = np.full(a.shape, np.nan)
    good = np.isfinite(a).all((1, 2)) & (np.linalg.det(a) != 0)
    out[good] = np.linalg.inv(a[good])
    return out


def slow_rows(slopes: Floats) -> Floats:
    """ℓ with ℓ ∂G/∂e = ∂g/∂e, from the slopes at members.

    Parameters
    ----------
    slopes
        ∂G/∂e, then ∂g/∂e, shape (N, m + 1, m).
    """
    out: Floats = (slopes[:, -1:] @ _inverse(slopes[:, :-1]))[:, 0]
    return out


def _shear(z: Floats, ell: Floats) -> Floats:
    """The matrix that takes (e, y) to (z, w), shape (N, m + 1, m + 1)."""
    n, m = ell.shape
    s = np.zeros((n, m + 1, m + 1))
    s[:, :m, :m], s[:, m, :m], s[:, m, m] = z, -ell, 1.0
    return s


def _block(values: Any) -> Floats:
    """M: a block [[σ, -ω], [ω, σ]] for each pair σ ± iω of eigenvalues."""
    n, m = values.shape
    out = np.zeros((n, m, m))
    at = np.arange(m)
    out[:, at, at] = values.real
    first = values.imag[:, :-1] > 0
    turn = np.where(first, values.imag[:, :-1], 0.0)
    out[:, at[:-1], at[1:]], out[:, at[1:], at[:-1]] = -turn, turn
    return out


def _complex(values: Any) -> Any:
    """T: complex modal coordinates of real ones, ζ = T z; a pair has ζ = (a ± ib)/2."""
    n, m = values.shape
    out = np.zeros((n, m, m), dtype=complex)
    at = np.arange(m)
    up, down = values.imag > 0, values.imag < 0
    out[:, at, at] = np.where(up, 0.5, np.where(down, -0.5j, 1.0))
    out[:, at[:-1], at[1:]] = np.where(up[:, :-1], 0.5j, 0.0)
    out[:, at[1:], at[:-1]] = np.where(down[:, 1:], 0.5, 0.0)
    return out


def _removed(values: Any, parts: _Parts, rate: Floats, ell: Floats, z: Floats) -> Form:
    """The form in double precision: the homological equation in complex coordinates."""
    real = _complex(values)
    back = np.linalg.inv(real)
    shape = (len(values), values.shape[1], values.shape[1], values.shape[1])
    inside = (real @ parts.bend0[:, :-1].reshape(*shape[:2], -1)).reshape(shape)
    pairs = values[:, :, None] + values[:, None, :]
    p = _quotient(-0.5 * _both_sides(inside, back), pairs[:, None] - values[:, :, None, None], rate)
    p = _both_sides((back @ p.reshape(*shape[:2], -1)).reshape(shape), real)
    apart = values[:, None, :] - values[:, :, None]
    n = back @ _quotient(-(real @ parts.turn0[:, :-1] @ back), apart, rate) @ real
    q = _both_sides(-0.5 * _both_sides(parts.bend0[:, -1:], back) / pairs[:, None], real)[:, 0]
    c = ((-(parts.turn0[:, -1:] @ back)[:, 0] / values)[:, None] @ real)[:, 0]
    return Form(ell, z, *(np.ascontiguousarray(v.real) for v in (p, n, q, c)))


def _quotient(above: Any, gap: Any, rate: Floats) -> Any:
    """Terms over their combinations of eigenvalues; 0 where these are nearly resonant."""
    clear = np.abs(gap) > NEAR * rate.reshape(-1, *[1] * (gap.ndim - 1))
    return np.where(clear, above / np.where(clear, gap, 1.0), 0.0)


def _both_sides(tensor: Any, matrix: Any) -> Any:
    """T(B·, B·) of tensors (N, a, m, m), by matrices (N, m, m)."""
    inner = np.swapaxes(matrix, 1, 2)[:, None]
    return inner @ tensor @ matrix[:, None]


class _Parts:
    """Derivatives in the coordinates (z, w).

    Arrays end with `0` at the members themselves; those with `off` and `wide` bound what is not
    exact in these, there and over ROOM.
    """

    def __init__(
        self, s: Floats, x: Floats, exact: tuple[Floats, ...], about: tuple[Floats, ...]
    ) -> None:
        self.s, self.x = s, x
        a, ra, mixed, _, bend, _ = exact
        _, _, wide, rwide, bent, rbent = about
        turned = np.abs(wide - mixed) * WIDE + rwide
        changed = np.abs(bent - bend) * WIDE + rbent
        self.first0, self.first_off = self._through(a, ra)
        self.turn0, self.turn_wide = self._through(mixed, turned)
        self.bend0, self.bend_wide = self._bilinear(
            *_followed(bend, changed, mixed, turned, -s[:, -1, :-1])
        )

    def _through(self, a: Floats, ra: Floats) -> tuple[Floats, Floats]:
        """S a X, and a bound of what is not exact in it."""
        s, x = np.abs(self.s), np.abs(self.x)
        off = (s @ (ra + LOOSE * np.abs(a)) @ x) * WIDE
        return self.s @ a @ self.x, off

    def _bilinear(self, b: Floats, rb: Floats) -> tuple[Floats, Floats]:
        """S b(X·, X·), and a bound of what is not exact in it."""

        def transformed(s: Floats, tensor: Floats, x: Floats) -> Floats:
            mixed = (s @ tensor.reshape(*tensor.shape[:2], -1)).reshape(tensor.shape)
            product: Floats = _both_sides(mixed, x)
            return product

        off = transformed(np.abs(self.s), rb + LOOSE * np.abs(b), np.abs(self.x)) * WIDE
        return transformed(self.s, b, self.x), off

    def bounds(self, block: Floats, rate: Floats, form: Form) -> NormalFormBounds:
        """What is left, with the inverse of Z enclosed as X (1 + F)⁻¹, F = Z X - 1."""
        (_, z, p, n, q, c), m = form, form.z.shape[1]
        eye = np.eye(m)
        f = np.abs(z @ self.x - eye) + LOOSE * (np.abs(z) @ np.abs(self.x) + eye)
        f = f.sum((1, 2)) * WIDE
        kappa = np.where(f < 0.5, WIDE / (1 - f), np.nan)
        rows = np.sqrt(np.square(self.x).sum(2) + 2.0**-500) * kappa[:, None] * WIDE
        a, off = self.first0, self.first_off
        slack = f * kappa * WIDE  # |(1 + F)⁻¹ - 1|
        still = norm(np.abs(a[:, :m] - block) * WIDE + off[:, :m]) * kappa + norm(block) * slack
        turn = norm(np.abs(self.turn0[:, :m]) + self.turn_wide[:, :m]) * kappa
        residual = self.turn0[:, :m] + n @ block - block @ n
        off_own = (
            LOOSE
            * (np.abs(self.turn0[:, :m]) + np.abs(n) @ np.abs(block) + np.abs(block) @ np.abs(n))
            + self.turn_wide[:, :m]
        )
        turn_off = (norm(off_own) + turn * slack) * WIDE
        turn_left, turn_even = norm(residual), norm(0.5 * (residual + np.swapaxes(residual, 1, 2)))
        half = 0.5 * kappa * kappa * WIDE
        size = _bilinear_norm(self.bend0[:, :m]) + norm(self.bend_wide[:, :m])
        size_along = _bilinear_norm(self.bend0[:, m:]) + norm(self.bend_wide[:, m])
        twice = (2 + slack) * slack * 0.5 * WIDE
        bend, along_bend = size * half, size_along * half
        left, sizes = _left(self.bend0[:, :m], p, block, block)
        left = norm(np.abs(left) * WIDE + LOOSE * sizes + 0.5 * self.bend_wide[:, :m])
        left = left + size * (twice + half - 0.5)
        rest, sizes = _left(self.bend0[:, m:], q[:, None], block, np.zeros((1, 1, 1)))
        rest = norm(np.abs(rest) * WIDE + LOOSE * sizes + 0.5 * self.bend_wide[:, m:])
        rest = rest + along_bend * 2 * (twice + half - 0.5)
        row, sizes = (c[:, None] @ block)[:, 0], (np.abs(c[:, None]) @ np.abs(block))[:, 0]
        of_c = np.abs(self.turn0[:, m] + row) * WIDE + LOOSE * (np.abs(self.turn0[:, m]) + sizes)
        line = norm(np.abs(self.turn0[:, m]) + self.turn_wide[:, m])
        return NormalFormBounds(
            rate,
            _bilinear_norm(p),
            norm(n),
            _bilinear_norm(q[:, None]),
            norm(c),
            rows,
            np.abs(z),
            still * WIDE,
            turn * WIDE,
            turn_left,
            turn_even,
            turn_off,
            bend * WIDE,
            left * WIDE,
            norm(np.abs(a[:, m]) + off[:, m]) * kappa,
            line * kappa,
            norm(of_c + self.turn_wide[:, m]) * WIDE + line * slack,
            along_bend * WIDE,
            rest * WIDE,
        )


def _followed(
    bend: Floats, rbend: Floats, mixed: Floats, rmixed: Floats, ell: Floats
) -> tuple[Floats, Floats]:
    """Second derivatives in e at fixed w: ∂²/∂e² + ℓ ∂²/∂e∂y, made symmetric."""
    added = mixed[:, :, :, None] * ell[:, None, None, :]
    size = (np.abs(mixed) + rmixed)[:, :, :, None] * np.abs(ell)[:, None, None, :]
    moved = rmixed[:, :, :, None] * np.abs(ell)[:, None, None, :]
    moved = moved + np.swapaxes(moved, 2, 3)
    out = bend + added + np.swapaxes(added, 2, 3)
    off = rbend + moved + LOOSE * (np.abs(bend) + size + np.swapaxes(size, 2, 3))
    return out, off * WIDE


def _left(bend: Floats, p: Floats, m: Floats, matrix: Floats) -> tuple[Floats, Floats]:
    """½ B - O P + P(M·, ·) + P(·, M·), and the sizes of its terms; O is M for P, and 0 for q."""
    across, flat = np.swapaxes(m, 1, 2)[:, None], p.reshape(len(p), p.shape[1], -1)
    out = 0.5 * bend + across @ p + p @ m[:, None] - (matrix @ flat).reshape(p.shape)
    size = 0.5 * np.abs(bend) + np.abs(across) @ np.abs(p) + np.abs(p) @ np.abs(m)[:, None]
    return out, size + (np.abs(matrix) @ np.abs(flat)).reshape(p.shape)


def norm(a: Floats) -> Floats:
    """Upper bounds of Frobenius norms of all but the first axis.

    Parameters
    ----------
    a
        Shape (N, …).
    """
    flat = a.reshape(len(a), -1)
    norms: Floats = np.sqrt(np.square(flat).sum(1)) * WIDE + 2.0**-500
    return norms


def _bilinear_norm(t: Floats) -> Floats:
    """Upper bounds of |T(z, z')| over |z| |z'| for tensors (N, a, m, m).

    |T(z, z')|² ≤ |z|² z'ᵀ G z' with G = Σ TᵀT, and no eigenvalue of G is above (tr G⁴)^¼.
    """
    flat = t.reshape(len(t), -1, t.shape[-1])
    g = np.swapaxes(flat, 1, 2) @ flat
    square = g @ g
    norms: Floats = np.sqrt(np.sqrt(np.sqrt(np.square(square).sum((1, 2)))))
    return norms * (1 + 2.0**-28) + 2.0**-100


@dataclass(frozen=True, eq=False)
class DerivativeTapes:
    """Tapes of the derivatives of (G, g), m + 1 rows."""

    across: int
    """Entries of e, m."""
    first: Tape
    """(y, given) → ∂/∂e at e = 0, row by row."""
    second: Tape
    """(y, given) → ∂²/∂e∂y, then ∂²/∂e² at e = 0, row by row."""
    third: Tape
    """(y, given, e, d, ℓ) → the third derivative along (d, ℓ·d), over 6."""
    positive: Tape
    """(y, given, e) → the guards."""


@lru_cache(maxsize=32)
def derivatives(around: Surroundings) -> DerivativeTapes:
    """Tapes of a family's surroundings.

    Parameters
    ----------
    around
        Surroundings with a field, along which one number names a member.

    Returns
    -------
    DerivativeTapes

    Raises
    ------
    StabilityError
        If the graph has a function without a kernel.
    """
    field = around.field
    assert field is not None and around.along == 1
    m, count = around.across, around.slopes.inputs[1]
    y, arguments, e = ca.SX.sym("y"), ca.SX.sym("given", count), ca.SX.sym("e", m)
    constants = field.symbols
    rows = field.function(y, arguments, e, *constants)
    slope = ca.jacobian(rows, e)
    mixed = ca.jacobian(ca.reshape(slope.T, -1, 1), y)
    bend = ca.jacobian(ca.reshape(slope.T, -1, 1), e)
    none = ca.DM.zeros(m)
    there = [ca.substitute(v, e, none) for v in (slope, mixed, bend)]
    d, ell = ca.SX.sym("d", m), ca.SX.sym("ell", m)
    seeds = ca.vertcat(ca.dot(ell, d), d)
    third = rows
    for _ in range(3):
        third = ca.jtimes(third, ca.vertcat(y, e), seeds)

    def tape(inputs: list[ca.SX], output: ca.SX) -> Tape:
        made = ca.Function("derivative", [*inputs, *constants], [ca.densify(output)])
        return _tape(Program(made, field.constants), [v.numel() for v in inputs])

    second = ca.vertcat(there[1], ca.reshape(there[2].T, -1, 1))
    flat = ca.reshape(there[0].T, -1, 1)
    return DerivativeTapes(
        m,
        tape([y, arguments], flat),
        tape([y, arguments], second),
        tape([y, arguments, e, d, ell], third / 6),
        _guards(around),
    )


def _tape(program: Program, sizes: list[int]) -> Tape:
    def run(a: list[Any], number: Algebra) -> list[Any]:
        return [v for [v] in program.dense(number, _cut(a, sizes))]

    return recorded(run, sum(sizes))


def _guards(around: Surroundings) -> Tape:
    sizes = list(around.positive.inputs[:3])

    def run(a: list[Any], number: Algebra) -> list[Any]:
        values: list[Any] = around.positive.run(number, _cut(a, sizes))[0]
        return values

    return recorded(run, sum(sizes))


def _cut(a: list[Any], sizes: list[int]) -> list[list[Any]]:
    ends = np.cumsum([0, *sizes])
    return [a[low:high] for low, high in zip(ends[:-1], ends[1:], strict=True)]


def at_members(
    made: DerivativeTapes, y: Floats, room: float, arguments: Floats
) -> tuple[Floats, ...]:
    """First, mixed and second derivatives at e = 0 with their radii, over y ± room.

    Parameters
    ----------
    made
        The tapes.
    y, room
        Members, shape (N,), and the half-width about each.
    arguments
        Second argument of the programs, shape (N, ·).

    Returns
    -------
    first, its radius, mixed, its radius, second, its radius
        Shapes (N, m + 1, m), (N, m + 1, m) and (N, m + 1, m, m).
    """
    m, n = made.across, len(y)
    mid = np.vstack([y, arguments.T])
    rad = np.zeros_like(mid)
    rad[0] = room
    flat = [v.T for v in made.first.run(mid, rad)]
    curved = [v.T for v in made.second.run(mid, rad)]
    cut, size = (m + 1) * m, (n, m + 1, m)
    out = [v.reshape(size) for v in flat]
    out += [v[:, :cut].reshape(size) for v in curved]
    out += [v[:, cut:].reshape(*size, m) for v in curved]
    return tuple(out)
