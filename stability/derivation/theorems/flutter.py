"""Premises that spinning and tumbling share: the conditions from the graph, and the drift."""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache
from typing import Any

import sympy

from ..characteristic import COS, SIN, K, derive
from ..hurwitz import Obligation, decisive
from ..proof import Proof
from .motion import (
    NORMAL,
    PHI,
    PHI_DDOT,
    SLIP_X,
    SLIP_Y,
    SPIN,
    SPIN_DOT,
    THETA_DOT,
    force,
    motion,
    same,
    simplified,
)
from .settling import RESTING

Expr = Any
"""A SymPy expression; SymPy states no types."""


@dataclass(frozen=True)
class Deciding:
    """The polynomials that decide a family under viscous friction."""

    conditions: dict[str, Expr]
    """Polynomial by kind, positive where stable."""
    obligations: tuple[Obligation, ...]
    """Proofs of the other conditions of Liénard and Chipart."""
    zeros: int
    """Structural zeros."""


@lru_cache(maxsize=4)
def deciding(family: str) -> Deciding:
    """The deciding conditions of a family under viscous friction, derived from the graph.

    Parameters
    ----------
    family
        Name of the family.

    Examples
    --------
    >>> deciding("rolling").conditions["flutter"]
    2*k*z - 1
    """
    derived = derive(family, "viscous")
    found, proved = decisive(derived)
    by_kind = {c.kind: c.polynomial.as_expr() for c in found}
    if len(by_kind) < len(found):
        raise ValueError(f"{family} has two conditions of one kind")
    return Deciding(by_kind, tuple(proved), derived.zeros)


def premises(proof: Proof, family: str, kinds: set[str]) -> None:
    """Add the steps that reduce stability to the signs of the deciding polynomials.

    Parameters
    ----------
    proof
        The proof so far.
    family
        Name of the family.
    kinds
        The deciding conditions that the proof goes on with.
    """

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


def same_linearisation() -> bool:
    """Whether both viscous laws have one linearisation where vA = 0 and gn = 1."""
    rest = {SLIP_X: 0, SLIP_Y: 0, NORMAL: 1}
    pairs = zip(force("viscous"), force("linear-viscous"), strict=True)
    return all(
        (a - b).subs(rest) == 0 and (a - b).diff(x).subs(rest) == 0
        for a, b in pairs
        for x in (SLIP_X, SLIP_Y, NORMAL)
    )


def drift(proof: Proof, family: str, energy: Expr) -> None:
    """Add the steps that give the direction of the drift along the family at a flutter boundary.

    Parameters
    ----------
    proof
        The proof so far.
    family
        Name of the family.
    energy
        Derivative of the members' energy by what names them, positive factors left out.
    """
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
        lambda: _rises(family, energy),
    )


def needs_slip() -> bool:
    """Whether vA = 0 leaves no oscillation about a member with φ̇ ≠ 0, ω₃ = 0."""
    rows = [r.subs(RESTING) for r in (motion().newton[1], motion().euler[0], motion().euler[2])]
    base = {THETA_DOT: 0, SPIN_DOT: 0, PHI_DDOT: 0, SPIN: 0}
    fast = (THETA_DOT, PHI_DDOT, SPIN_DOT)
    others = (PHI, SPIN, SIN, COS)
    slopes = sympy.Matrix([[r.diff(x).subs(base) for x in fast] for r in rows])
    rest = [r.diff(x).subs(base) for r in rows for x in others]
    determinant = simplified(slopes.det())
    _, factors = sympy.factor_list(determinant)
    return not any(rest) and determinant != 0 and {f for f, _ in factors} <= {K, SIN, PHI}


def _rises(family: str, slope: Expr) -> bool:
    """Whether the members' energy has this derivative, a product of positive quantities."""
    still = {THETA_DOT: 0, SLIP_X: 0, SLIP_Y: 0, SPIN: 0}
    energy = motion().energy.subs(still)
    if family == "spinning":
        found = energy.subs({SIN: 1, COS: 0}).diff(PHI)
        return same(found, slope) and slope.free_symbols <= {K, PHI}
    found = energy.subs(PHI**2, 1 / (K * SIN)).diff(SIN) * COS
    return same(found, slope) and slope.free_symbols <= {COS}
