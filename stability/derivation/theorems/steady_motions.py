"""Theorem: for any law of friction the steady motions are rolling, spinning and tumbling."""

from __future__ import annotations

from functools import lru_cache

import sympy

from ..characteristic import COS, SIN, K, derive
from ..proof import Proof, Theorem
from .motion import (
    FORCE_X,
    FORCE_Y,
    NORMAL,
    PHI,
    SLIP_X,
    SLIP_Y,
    SPIN,
    STEADY,
    THETA_DOT,
    Motion,
    motion,
    rate,
    same,
    simplified,
)

AT_REST = {NORMAL: 1, SLIP_X: 0, SLIP_Y: 0}
UPRIGHT = {SIN: 1, COS: 0}
ROUGH = (2 * K + 1) * PHI * SPIN * SIN - COS * (K * PHI**2 * SIN - 1)
"""Zero on the rough disk's steady motions."""
SMOOTH = 2 * K * PHI * SPIN * SIN - COS * (K * PHI**2 * SIN - 1)
"""Zero on the smooth disk's steady motions."""
FILE = "tests/derivation/test_theorems.py"


def power_theorem(rows: Motion) -> bool:
    """Whether dE/dt is the force times the slip, for every force: rows times velocities.

    Parameters
    ----------
    rows
        The equations of motion.
    """
    velocity = (SLIP_X + THETA_DOT * SIN, SLIP_Y - SPIN, THETA_DOT * COS)
    turning = (-PHI * SIN, THETA_DOT, SPIN)
    work = sum(a * b for a, b in zip(rows.rows, (*velocity, *turning), strict=True))
    return same(rate(rows.energy) - FORCE_X * SLIP_X - FORCE_Y * SLIP_Y, work)


@lru_cache(maxsize=1)
def any_law() -> Theorem:
    """Completeness for every law that takes energy from every slip.

    Examples
    --------
    >>> any_law().proved
    True
    """
    proof, rows = Proof(), motion()
    steady = [r.subs(STEADY) for r in rows.rows]
    nx, ny, nz, e1, e2, e3 = steady
    free = {FORCE_X: 0, FORCE_Y: 0} | AT_REST
    proof.step(
        "dE/dt = F·vA for every force F at the contact",
        "identity: Newton times the centre's velocity plus Euler times the angular velocity",
        lambda: power_theorem(rows),
    )
    proof.step(
        "vA = 0 and F = 0: energy is constant, so F·vA = 0, which the law allows at vA = 0 "
        "alone, where F = 0",
        "step 1; the energy depends on the states alone",
        lambda: (
            rows.energy.free_symbols <= {SIN, COS, K, THETA_DOT, PHI, SPIN, SLIP_X, SLIP_Y}
            and proof.steps[0].proved
        ),
    )
    proof.step(
        "gn = 1: the normal force is the weight",
        "Newton along ẑ: 1 - gn = 0",
        lambda: same(nz, 1 - NORMAL),
    )
    proof.step("φ̇ω₃ = 0", "Newton along x̂: φ̇ω₃ = 0", lambda: same(nx.subs(free), PHI * SPIN))
    proof.step(
        "if φ̇ = 0: cosθ = 0, with ω₃ free: rolling",
        "Euler along 2̂: cosθ = 0",
        lambda: same(e2.subs(free).subs(PHI, 0), COS),
    )
    proof.step(
        "if φ̇ ≠ 0: ω₃ = 0, and cosθ = 0 (spinning) or kφ̇² sinθ = 1 (tumbling)",
        "Euler along 2̂: cosθ (1 - kφ̇² sinθ) = 0",
        lambda: same(e2.subs(free).subs(SPIN, 0), COS * (1 - K * PHI**2 * SIN)),
    )
    proof.step(
        "conversely each of the three is steady under every such law",
        "with F = 0 and gn = 1 all six rows vanish on each family",
        lambda: _converse(steady),
    )
    proof.step(
        "no equation is left that could exclude or add a member",
        "Newton along ŷ and Euler along 1̂ and 3̂ vanish for F = 0",
        lambda: all(r.subs(free) == 0 for r in (ny, e1, e3)),
    )
    proof.conclude("every steady motion is rolling, spinning or tumbling", "the steps above")
    return Theorem(
        "steady motions under any friction",
        ("The steady motions are exactly rolling (θ = π/2, φ̇ = 0), spinning (θ = π/2, ω₃ = 0) and "
         "tumbling (ω₃ = 0, kφ̇² sinθ = 1), with vA = 0 in each.",),
        ("0 < θ < π, k > 0",
         "the law of friction at gn = 1: F·vA < 0 where vA ≠ 0, F = 0 where vA = 0; nothing else",
         "steady: θ, θ̇ = 0, φ̇, ω₃ and vA are constant"),
        tuple(proof.steps),
        (f"{FILE}::test_no_other_steady_motion_is_found_under_several_laws",),
    )  # fmt: skip


def _converse(steady: list[sympy.Expr]) -> bool:
    families = (
        UPRIGHT | {PHI: 0}, UPRIGHT | {SPIN: 0}, {SPIN: 0, SIN: 1 / (K * PHI**2)},
    )  # fmt: skip
    free = {FORCE_X: 0, FORCE_Y: 0} | AT_REST
    return all(sympy.cancel(r.subs(free).subs(f)) == 0 for f in families for r in steady)


@lru_cache(maxsize=1)
def dry_rough_smooth() -> Theorem:
    """Steady motions of the disk under Coulomb's law, without slip, and without friction.

    Examples
    --------
    >>> dry_rough_smooth().proved
    True
    """
    proof, rows = Proof(), motion()
    nx, ny, nz, e1, e2, e3 = (r.subs(STEADY) for r in rows.rows)
    held = {FORCE_X: PHI * SPIN, FORCE_Y: 0} | AT_REST
    proof.step(
        "a steady motion with vA = 0 needs F = (φ̇ω₃, 0) and gn = 1",
        "Newton along x̂, ŷ, ẑ and Euler along 3̂ with vA = 0",
        lambda: (
            same(nx.subs(AT_REST), PHI * SPIN - FORCE_X)
            and same(nz, 1 - NORMAL)
            and same(ny.subs(AT_REST), -FORCE_Y)
            and same(e3.subs(AT_REST), -FORCE_Y)
        ),
    )
    proof.step(
        "rough: the steady motions are (2k+1)φ̇ω₃ sinθ = cosθ (kφ̇² sinθ - 1)",
        "Euler along 2̂ with this force; Euler along 1̂ vanishes",
        lambda: same(e2.subs(held), ROUGH) and simplified(e1.subs(held)) == 0,
    )
    proof.step(
        "this surface is smooth in (θ, φ̇, ω₃)",
        "its derivative by ω₃ is (2k+1)φ̇ sinθ ≠ 0 where φ̇ ≠ 0; where φ̇ = 0, cosθ = 0 and its "
        "derivative by θ is -1",
        _surface,
    )
    proof.step(
        "it holds rolling, spinning and tumbling",
        "substitution of each family",
        lambda: all(
            simplified(ROUGH.subs(f)) == 0
            for f in (UPRIGHT | {PHI: 0}, UPRIGHT | {SPIN: 0}, {SPIN: 0, SIN: 1 / (K * PHI**2)})
        ),
    )
    proof.step(
        "its two dimensions are the two structural zeros of the rough disk",
        "multiplicity of λ in det(λ - A) over Q(k, s, φ̇), from the graph",
        _rough_zeros,
    )
    proof.step(
        "Coulomb: the steady motions are those of the rough disk with |φ̇ω₃| ≤ mu",
        "in slip F·vA = -mu gn |vA| < 0, so none slides (dE/dt = F·vA ≠ 0); at rest the "
        "force of step 1 must satisfy |F| ≤ mu gn",
        lambda: power_theorem(rows),
    )
    proof.step(
        "smooth: the steady motions are 2kφ̇ω₃ sinθ = cosθ (kφ̇² sinθ - 1), "
        "the slip that of a centre without horizontal velocity",
        "Euler along 2̂ with F = 0 and slip (0, ω₃); all rows vanish",
        lambda: same(e2.subs({FORCE_X: 0, NORMAL: 1}), SMOOTH) and _smooth_rest(),
    )
    proof.conclude("the statements hold", "the steps above")
    return Theorem(
        "steady motions of the rough, dry and smooth disk",
        ("Rough: exactly (2k+1)φ̇ω₃ sinθ = cosθ (kφ̇² sinθ - 1), a smooth surface that holds "
         "rolling, spinning and tumbling; its two dimensions are the two structural zeros.",
         "Coulomb: exactly those of the rough disk with |φ̇ω₃| ≤ mu.",
         "Smooth, centre without horizontal velocity: exactly 2kφ̇ω₃ sinθ = "
         "cosθ (kφ̇² sinθ - 1)."),
        ("0 < θ < π, 0 < k ≤ 1/2, mu > 0",
         "steady: θ, θ̇ = 0, φ̇, ω₃ and vA are constant"),
        tuple(proof.steps),
        (f"{FILE}::test_rough_and_smooth_motions_off_the_surface_are_not_steady",
         f"{FILE}::test_dry_friction_holds_a_steady_motion_exactly_inside_the_cone"),
    )  # fmt: skip


def _surface() -> bool:
    by_spin = ROUGH.diff(SPIN)
    by_theta = COS * ROUGH.diff(SIN) - SIN * ROUGH.diff(COS)
    return (
        same(by_spin, (2 * K + 1) * PHI * SIN)
        and same(ROUGH.subs(PHI, 0), COS)
        and same(by_theta.subs({PHI: 0}), -SIN)
        and same(by_theta.subs(UPRIGHT | {PHI: 0}), -1)
    )


def _rough_zeros() -> tuple[bool, str]:
    zeros = {f: derive(f, "rough").zeros for f in ("circling", "rolling", "spinning", "tumbling")}
    words = ", ".join(f"{name} {count}" for name, count in zeros.items())
    return set(zeros.values()) == {2}, words


def _smooth_rest() -> bool:
    nx, ny, _, e1, _, e3 = (r.subs(STEADY) for r in motion().rows)
    still = {FORCE_X: 0, FORCE_Y: 0, NORMAL: 1, SLIP_X: 0, SLIP_Y: SPIN}
    return all(simplified(r.subs(still)) == 0 for r in (nx, ny, e1, e3))
