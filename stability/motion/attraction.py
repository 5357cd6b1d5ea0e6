"""Proof that a motion converges to one steady motion: its family along y, the deviation e across.

Near a family of steady motions ė = G(y, e) and ẏ = g(y, e), where G and g vanish at e = 0.  With
e = X z and J̃ an enclosure of X⁻¹ ∂G/∂e X on a box Y x E, |z| falls at the rate

    β = -max_i sup (J̃_ii + ½ Σ_{j≠i} |J̃_ij + J̃_ji|)

while the motion is in the box, and w = y - ℓᵀe obeys |ẇ| ≤ Γ |z|, Γ = sup |(∂g/∂e - ℓᵀ∂G/∂e) X|.
From |z| = r and w within η of y_c, y therefore stays within η + Γ r/β + |ℓᵀX| r of y_c.  Where that
is no more than the half-width δ of Y, and e = X z, |z| ≤ r, fits in E, the motion never leaves the
box: it converges to one steady motion, which lies within η + Γ r/β of y_c.  Contact lasts, since
gn, D and sinθ are positive on the box.

Every bound is taken in ball arithmetic from the graph, with π/2 as an exact symbol;
tests/test_settling.py derives the bound afresh.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache
from typing import Any

import casadi as ca
import numpy as np

from ..algebra.eigensolver import eigenpairs, eigenvalues_alone
from ..algebra.number_types import Upright, balls, casadi_algebra
from ..algebra.program import Program
from ..base.types import Floats
from ..bodies.contact import Contact
from ..bodies.disk_equations import disk_system

BITS = 64
"""Precision of the balls: what they are wide by is the box, not rounding."""
TURNS = 10
"""Widenings of the box after which the test gives up."""
WIDEN = 1.1
"""Factor on the half-width that was found to be needed."""
ACROSS = {"spinning": [0, 1, 3, 4, 5], "tumbling": [1, 2, 3, 4, 5]}
"""States whose deviations are e, by family."""


@dataclass(frozen=True)
class Attraction:
    """A box from which no motion escapes, and the steady motion that it converges to."""

    limit: float
    """Parameter of a member near that steady motion."""
    error: float
    """Bound on the distance between both parameters."""
    rate: float
    """The deviation falls at this rate at least, in the norm of the basis."""
    reach: float
    """Length of the diagonal of the box across the family, halved."""


class Tilted(Upright):
    """The exact angle π/2 + e."""

    def __init__(self, e: Any) -> None:
        self.e = e

    def sin(self) -> Any:
        """Cos e."""
        return ca.cos(self.e)

    def cos(self) -> Any:
        """−sin e."""
        return -ca.sin(self.e)


@lru_cache(maxsize=16)
def rates(law: type[Contact], family: str) -> tuple[Program, Program]:
    """Programs (y, sign, p, e) → ∂G/∂e and ∂g/∂e, and → gn, D and sinθ.

    Parameters
    ----------
    law
        A contact law with the slip in its state.
    family
        spinning or tumbling.

    Returns
    -------
    tuple of Program
    """
    system = disk_system(law)
    y, sign, e = ca.SX.sym("y"), ca.SX.sym("sign"), ca.SX.sym("e", 5)
    parts = [e[i] for i in range(5)]
    x: list[Any]
    member = sign / ca.sqrt(system.p[0] * ca.sin(y))
    if family == "spinning":
        x = [Tilted(parts[0]), parts[1], y, *parts[2:]]
    else:
        x = [y, parts[0], member + parts[1], *parts[2:]]
    seen = system.observables
    positive = ca.vertcat(seen["normal_force"], seen["determinant"], ca.sin(system.x[0]))
    graph = Program(ca.Function("graph", [system.x, system.p], [system.rhs, positive]))
    values = graph.run(casadi_algebra(), [x, ca.vertsplit(system.p)])
    rhs = dict(zip((row for row, _ in graph.places[0]), values[0], strict=True))
    if family == "spinning":
        across, along = [rhs[i] for i in ACROSS[family]], rhs[2]
    else:
        across, along = [rhs[i] for i in ACROSS[family]], parts[0]
        across[1] = across[1] - ca.jacobian(member, y) * parts[0]  # the member moves with theta
    slope = ca.densify(ca.jacobian(ca.vertcat(*across, along), e))
    inputs = [y, sign, system.p, e]
    return (
        Program(ca.Function("slopes", inputs, [slope])),
        Program(ca.Function("positive", inputs, [ca.densify(ca.vertcat(*values[1]))])),
    )


def attraction(
    law: type[Contact], family: str, p: Floats, sign: float, y: Any, e: list[Any]
) -> Attraction | None:
    """A box around a state in which its motion is proved to converge to one steady motion.

    Parameters
    ----------
    law, family
        As for `rates`.
    p
        Parameters of the law's system.
    sign
        Sign of φ̇.
    y, e
        Parameter of the nearest member and deviation, as balls that hold the true ones.

    Returns
    -------
    Attraction or None
        None where the test fails.
    """
    from flint import ctx

    before, ctx.prec = ctx.prec, BITS
    try:
        return _attraction(law, family, p, sign, y, e)
    finally:
        ctx.prec = before


def _attraction(
    law: type[Contact], family: str, p: Floats, sign: float, y: Any, e: list[Any]
) -> Attraction | None:
    program = rates(law, family)[0]  # type: ignore[arg-type]  # a class is hashable
    y1, e1 = float(y.mid()), np.array([float(v.mid()) for v in e])
    centre, slow = y1, np.zeros(5)
    a = np.zeros((5, 5))
    for _ in range(3):
        arguments = [[centre], [sign], list(p), [0.0] * 5]
        both = program.arrays(arguments, ())[0]
        a, along = both[:5], both[5]
        if not np.isfinite(both).all() or np.linalg.matrix_rank(a) < 5:
            return None
        slow = np.linalg.solve(a.T, along)
        centre = y1 - float(slow @ e1)
    if not (eigenvalues_alone(a).real < 0).all():
        return None
    for basis in (_modal(a), _lyapunov(a)):
        if basis is not None:
            found = _box(law, family, p, sign, y, e, centre, slow, basis)
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
    law: type[Contact], family: str, p: Floats, sign: float, y: Any, e: list[Any], centre: float,
    slow: Floats, basis: Floats,
) -> Attraction | None:  # fmt: skip
    """The test of the module's docstring in one basis."""
    from flint import arb, arb_mat

    slopes, positive = rates(law, family)  # type: ignore[arg-type]  # a class is hashable
    x = arb_mat(basis.tolist())
    try:
        inverse = x.inv()
    except ZeroDivisionError:
        return None
    row = arb_mat([slow.tolist()])
    z = inverse * arb_mat([[v] for v in e])
    r = _length([z[i, 0] for i in range(5)])
    offset = y - (row * arb_mat([[v] for v in e]))[0, 0] - arb(centre)
    eta = offset.abs_upper()
    across = [_length([x[i, j] for j in range(5)]) * r for i in range(5)]
    sideways = _length([(row * x)[0, j] for j in range(5)]) * r
    box = [arb(0, v.abs_upper()) for v in across]
    held = [arb(float(v)) for v in p]
    delta = (2 * (eta + sideways) + arb(2) ** -60 * (1 + abs(arb(centre)))).abs_upper()
    for _ in range(TURNS):
        arguments = [[arb(centre, delta)], [arb(sign)], held, box]
        if not all(v > 0 for v in positive.run(balls(), arguments)[0]):
            return None
        dense = slopes.dense(balls(), arguments)
        j = inverse * arb_mat(dense[:5]) * x
        beta = -_largest(j)
        if not beta > 0:
            return None
        drift = (arb_mat([dense[5]]) - row * arb_mat(dense[:5])) * x
        error = eta + _length([drift[0, i] for i in range(5)]) * r / beta
        needed = (error + sideways).abs_upper()
        if needed <= delta:
            half = _length(across)
            return Attraction(
                centre, float(error.abs_upper()), float(beta.mid()), float(half.mid())
            )
        delta = (WIDEN * needed).abs_upper()
    return None


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
