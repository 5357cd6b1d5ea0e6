"""Proof that a motion converges to one steady motion: its family along y, the deviation e across.

Near a family of steady motions ė = G(y, e) and ẏ = g(y, e), where G and g vanish at e = 0.  With
e = X z and J̃ an enclosure of X⁻¹ ∂G/∂e X on a box Y x E, |z| falls at the rate

    β = -max_i sup (J̃_ii + ½ Σ_{j≠i} |J̃_ij + J̃_ji|)

while the motion is in the box, and w = y - ℓᵀe obeys |ẇ| ≤ Γ |z|, Γ = sup |(∂g/∂e - ℓᵀ∂G/∂e) X|.
From |z| = r and w within η of y_c, y therefore stays within η + Γ r/β + |ℓᵀX| r of y_c.  Where that
is no more than the half-width δ of Y, and e = X z, |z| ≤ r, fits in E, the motion never leaves the
box: it converges to one steady motion, which lies within η + Γ r/β of y_c.  Each entry of y has its
own ℓ, η, Γ and δ.  The guards are positive on the box, so that no guard ends the motion.

A member that stands alone has no y, and need not be known exactly: where G(0) is within X ρ of zero
and β r > ρ, the box holds exactly one steady motion, within ρ/β of e = 0, and all motions of the
box converge to it (the contraction of all distances at the rate β).

Every bound is taken in ball arithmetic from the graph, with π/2 as an exact symbol;
tests/settling/test_settling.py derives the bound for the disk independently,
tests/motion/test_system_motion.py checks systems with known basins.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from ...algebra.eigensolver import eigenpairs, eigenvalues_alone
from ...algebra.number_types import balls
from ...base.types import Floats
from ..surroundings import Surroundings

BITS = 64
"""Precision of the balls: their width comes from the box, not from rounding."""
TURNS = 10
"""Widenings of the box after which the test gives up."""
WIDEN = 1.1
"""Factor on the half-width that is found to be needed."""
ROOM = 4
"""Extra room of the first box, over the size that a remainder needs."""


@dataclass(frozen=True)
class Attraction:
    """A box from which no motion escapes, and the steady motion that it converges to."""

    limit: tuple[float, ...]
    """Parameters y of a member near that steady motion."""
    error: float
    """Bound on the distance of the limit from that motion: of y, or of the states without y."""
    rate: float
    """Least rate at which the deviation falls, in the norm of the basis."""
    reach: float
    """Half the diagonal of the box across the family."""


def attraction(
    around: Surroundings, given: Sequence[float], y: Sequence[Any], e: Sequence[Any]
) -> Attraction | None:
    """A box around a state in which its motion is proved to converge to one steady motion.

    Parameters
    ----------
    around
        The family's surroundings.
    given
        Second argument of its programs.
    y, e
        Parameters of the nearest member and deviation, as balls that contain the true values.

    Returns
    -------
    Attraction or None
        None where the test fails.
    """
    from flint import ctx

    before, ctx.prec = ctx.prec, BITS
    try:
        return _attraction(around, given, y, e)
    finally:
        ctx.prec = before


def _attraction(
    around: Surroundings, given: Sequence[float], y: Sequence[Any], e: Sequence[Any]
) -> Attraction | None:
    m = around.across
    y1, e1 = [float(v.mid()) for v in y], np.array([float(v.mid()) for v in e])
    centre, slow = y1, np.zeros((len(y), m))
    a = np.zeros((m, m))
    for _ in range(3):
        both = around.slopes.arrays([centre, list(given), [0.0] * m], ())[0]
        a, along = both[:m], both[m:]
        if not np.isfinite(both).all() or np.linalg.matrix_rank(a) < m:
            return None
        slow = np.array([np.linalg.solve(a.T, row) for row in along]).reshape(len(y), m)
        centre = [c - float(row @ e1) for c, row in zip(y1, slow, strict=True)]
    if not (eigenvalues_alone(a).real < 0).all():
        return None
    for basis in (_modal(a), _lyapunov(a)):
        if basis is not None:
            found = _box(around, given, y, e, centre, slow, basis)
            if found is not None:
                return found
    return None


def _modal(a: Floats) -> Floats | None:
    """Real and imaginary parts of the eigenvectors, as columns of unit length."""
    values, vectors = eigenpairs(a)
    columns = []
    for value, vector in zip(values, vectors.T, strict=True):
        if value.imag == 0:
            columns.append(vector.real)
        elif value.imag > 0:
            columns += [vector.real, vector.imag]
    basis = np.array(columns).T
    return basis if basis.shape == a.shape and np.linalg.cond(basis) < 1e8 else None


def _lyapunov(a: Floats) -> Floats | None:
    """The basis in which the symmetric part of A is diagonal, from AᵀP + PA = -1."""
    from scipy.linalg import solve_continuous_lyapunov

    with np.errstate(all="ignore"):
        try:
            p = solve_continuous_lyapunov(a.T, -np.eye(len(a)))
            levels, q = np.linalg.eigh((p + p.T) / 2)
        except (ValueError, np.linalg.LinAlgError):
            return None
    if not (np.isfinite(levels).all() and levels[0] > 0):
        return None
    basis: Floats = q / np.sqrt(levels)
    return basis


def _box(
    around: Surroundings,
    given: Sequence[float],
    y: Sequence[Any],
    e: Sequence[Any],
    centre: list[float],
    slow: Floats,
    basis: Floats,
) -> Attraction | None:
    """The test of the module's docstring in one basis."""
    from flint import arb, arb_mat

    m, n = around.across, around.along
    x = arb_mat(basis.tolist())
    try:
        inverse = x.inv()
    except ZeroDivisionError:
        return None
    held, column = [arb(float(v)) for v in given], arb_mat([[v] for v in e])
    z = inverse * column
    r, rho = _length([z[i, 0] for i in range(m)]), arb(0)
    if around.remainder is not None:
        rest = around.remainder.dense(balls(), [[], held, [arb(0)] * m])
        off = inverse * arb_mat(rest)
        rho = _length([off[i, 0] for i in range(m)])
        r = (r + ROOM * rho / _slowest(basis, around, given) + arb(2) ** -BITS).abs_upper()
    across = [_length([x[i, j] for j in range(m)]) * r for i in range(m)]
    box = [arb(0, v.abs_upper()) for v in across]
    rows = [arb_mat([row.tolist()]) for row in slow]
    eta = [
        (v - (row * column)[0, 0] - arb(c)).abs_upper()
        for v, row, c in zip(y, rows, centre, strict=True)
    ]
    sideways = [_length([(row * x)[0, j] for j in range(m)]) * r for row in rows]
    delta = [
        (2 * (off + side) + arb(2) ** -60 * (1 + abs(arb(c)))).abs_upper()
        for off, side, c in zip(eta, sideways, centre, strict=True)
    ]
    for _ in range(TURNS):
        wide = [arb(c, d) for c, d in zip(centre, delta, strict=True)]
        arguments = [wide, held, box]
        if not all(v > 0 for v in around.positive.run(balls(), arguments)[0]):
            return None
        dense = around.slopes.dense(balls(), arguments)
        j = inverse * arb_mat(dense[:m]) * x
        beta = -_largest(j)
        if not (beta > 0 if around.remainder is None else beta * r > rho):
            return None
        error, needed = [], []
        for i in range(n):
            drift = (arb_mat([dense[m + i]]) - rows[i] * arb_mat(dense[:m])) * x
            error.append(eta[i] + _length([drift[0, k] for k in range(m)]) * r / beta)
            needed.append((error[i] + sideways[i]).abs_upper())
        if all(v <= d for v, d in zip(needed, delta, strict=True)):
            half = _length(across)
            if around.remainder is not None:
                size = _length([_length([x[i, k] for k in range(m)]) for i in range(m)])
                error = [size * rho / beta]
            return Attraction(
                tuple(centre),
                max((float(v.abs_upper()) for v in error), default=0.0),
                float(beta.mid()),
                float(half.mid()),
            )
        delta = [(WIDEN * v).abs_upper() for v in needed]
    return None


def _slowest(basis: Floats, around: Surroundings, given: Sequence[float]) -> float:
    """The rate at which deviations fall at the member itself, in double precision."""
    a = around.slopes.arrays([[], list(given), [0.0] * around.across], ())[0]
    j = np.linalg.solve(basis, a @ basis)
    return max(float(-np.linalg.eigvalsh((j + j.T) / 2).max()), 1e-300)


def _length(entries: list[Any]) -> Any:
    """An upper bound of the Euclidean length."""
    return sum((v * v for v in entries), 0 * entries[0]).abs_upper().sqrt().abs_upper()


def _largest(j: Any) -> Any:
    """Upper bound of the largest eigenvalue of the symmetric part, by Gershgorin's theorem."""
    n = j.nrows()
    rows = [j[i, i] + sum(abs(j[i, k] + j[k, i]) for k in range(n) if k != i) / 2 for i in range(n)]
    highest = rows[0]
    for value in rows[1:]:
        highest = highest.max(value)
    return highest.upper()
