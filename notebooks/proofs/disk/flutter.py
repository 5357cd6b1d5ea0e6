"""The flutter boundaries of spinning and tumbling: conditions, and the drift on the boundary."""

from __future__ import annotations

from functools import lru_cache
from typing import Any

import sympy

from stability.derivation.characteristic import COS, SIN, K

from ..body_polynomials import (
    PHI,
    PHI_DDOT,
    SLIP_X,
    SLIP_Y,
    SPIN,
    SPIN_DOT,
    THETA_DOT,
)
from ..mechanics import same, same_linearisation, simplified
from ..proof import DISK_TESTS, Proof, Theorem
from .case import deciding, disk_case, energy, rows
from .settling import RESTING

Expr = Any
"""A SymPy expression; SymPy states no types."""


def premises(proof: Proof, family: str, kinds: set[str]) -> None:
    """Add the steps that reduce stability to the signs of the deciding polynomials."""

    def reduced() -> tuple[bool, str]:
        found = deciding(family)
        words = "; ".join(f"{o.name}: {o.proof}" for o in found.obligations)
        return set(found.conditions) == kinds and found.zeros == 1, words

    proof.step(
        "apart from the one structural zero: stable where every deciding polynomial "
        f"({', '.join(sorted(kinds))}) is positive, unstable where one is negative",
        "characteristic polynomial over Q from the graph; Liénard and Chipart; the other "
        "conditions are proved positive for k in (0, 1/2]",
        reduced,
    )
    proof.step(
        "linear viscous friction with c = mu has the same linearisation",
        "first derivatives of both forces at vA = 0, gn = 1",
        same_linearisation,
    )


def drift(proof: Proof, family: str, slope: Expr) -> None:
    """Add the steps that give the direction of the drift along the family at a flutter boundary."""
    proof.step(
        "an eigenvector of λ ≠ 0 has slip",
        "linearised about φ̇ ≠ 0, ω₃ = 0 with vA = 0: ω̇₃ = 0, φ̇ sinθ θ̇ = 0, k sinθ φ̈ = 0",
        needs_slip,
    )
    proof.step(
        "on a flutter boundary the oscillation drifts along the family to smaller "
        f"{'φ̇' if family == 'spinning' else 'θ'}",
        "dE/dt = -mu gn |vA|², averaged over the oscillation, is negative; the energy of "
        "the members rises along the family",
        lambda: _rises(family, slope),
    )


@lru_cache(maxsize=1)
def spinning_elliptic() -> Theorem:
    """The flutter boundary of the spinning disk, for every k."""
    proof = Proof()
    proof.step("M1 < mu*² < M2: the boundary φ̇² = 1/k + v* is one simple root, stable below it and "
               "unstable above", "theorem `the disk among the bodies of revolution`",
               lambda: disk_case().proved)  # fmt: skip
    drift(proof, "spinning", K * PHI)
    proof.conclude("the drift leads from unstable members, at larger φ̇, to stable ones",
                   "the steps above; the root is simple, so the pair crosses the axis with nonzero "
                   "speed (Orlando's formula)")  # fmt: skip
    return Theorem(
        "the flutter boundary of the spinning disk",
        ("M1 < mu*² < M2: the boundary of stable spinning is elliptic.",),
        ("0 < k ≤ 1/2; viscous or linear viscous friction",
         "elliptic or hyperbolic: by the direction of the drift along the family at leading order"),
        tuple(proof.steps),
        (f"{DISK_TESTS}::test_spinning_is_stable_exactly_where_the_theorem_says",),
    )  # fmt: skip


def needs_slip() -> bool:
    """Whether vA = 0 leaves no oscillation about a member with φ̇ ≠ 0, ω₃ = 0."""
    along_y, *about = rows()[1::2]  # Newton along ŷ, Euler along 1̂ and 3̂
    resting = [r.subs(RESTING) for r in (along_y, *about)]
    base = {THETA_DOT: 0, SPIN_DOT: 0, PHI_DDOT: 0, SPIN: 0}
    fast = (THETA_DOT, PHI_DDOT, SPIN_DOT)
    others = (PHI, SPIN, SIN, COS)
    slopes = sympy.Matrix([[r.diff(x).subs(base) for x in fast] for r in resting])
    rest = [r.diff(x).subs(base) for r in resting for x in others]
    determinant = simplified(slopes.det())
    _, factors = sympy.factor_list(determinant)
    return not any(rest) and determinant != 0 and {f for f, _ in factors} <= {K, SIN, PHI}


def _rises(family: str, slope: Expr) -> bool:
    """Whether the members' energy has this derivative, a product of positive quantities."""
    still = {THETA_DOT: 0, SLIP_X: 0, SLIP_Y: 0, SPIN: 0}
    level = energy().subs(still)
    if family == "spinning":
        found = level.subs({SIN: 1, COS: 0}).diff(PHI)
        return same(found, slope) and slope.free_symbols <= {K, PHI}
    found = level.subs(PHI**2, 1 / (K * SIN)).diff(SIN) * COS
    return same(found, slope) and slope.free_symbols <= {COS}
