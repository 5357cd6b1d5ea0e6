"""Theorem: every bounded motion under viscous friction converges to one steady motion."""

from __future__ import annotations

from functools import lru_cache
from typing import Any

import sympy

from stability.derivation.characteristic import COS, MU, SIN, K

from ..body_polynomials import (
    FORCE_X,
    FORCE_Y,
    NORMAL,
    PHI,
    PHI_DDOT,
    SLIP_X,
    SLIP_Y,
    SPEEDS,
    SPIN,
    SPIN_DOT,
    THETA_DDOT,
    THETA_DOT,
)
from ..mechanics import NO_SLIP, force, power_theorem, rate, same, simplified
from ..proof import DISK_TESTS, Proof, Theorem
from .case import UPRIGHT, determinant, disk_case, energy, rows

LAWS = ("viscous", "linear-viscous")
RESTING = NO_SLIP | {FORCE_X: 0, FORCE_Y: 0}
"""vA = 0 on an interval, so that the force of friction is zero there too."""
FLOW_D = K + COS**2 - MU * SLIP_X * SIN * COS
"""D of viscous friction."""


@lru_cache(maxsize=1)
def settling() -> Theorem:
    """Every bounded motion settles: LaSalle's principle with each premise checked."""
    proof = Proof()
    nx, ny, nz, e1, e2, e3 = (r.subs(RESTING) for r in rows())
    proof.step(
        "dE/dt = -mu gn |vA|² (viscous), -c |vA|² (linear viscous): zero only for vA = 0",
        "identity dE/dt = F·vA for every force, with the force of each law",
        _losses,
    )
    proof.step(
        "the rates are analytic where sinθ > 0 and D > 0",
        "determinant of the equations: 2k² sinθ D, with D = k + cos²θ - mu vx sinθ cosθ "
        "(viscous), k + cos²θ (linear viscous)",
        _determinants,
    )
    proof.step(
        "where sinθ ≥ ε the energy bounds every speed, as it never rises",
        "kinetic energy: a quadratic form of the speeds whose leading minors are positive",
        _bounded_speeds,
    )
    proof.step(
        "vA = 0 on an interval: ω₃ is constant and φ̇θ̇ = 0 there",
        "Euler along 3̂: 2kω̇₃ = 0; Newton along ŷ: φ̇θ̇ sinθ = ω̇₃",
        lambda: same(e3, 2 * K * SPIN_DOT) and same(ny, PHI * THETA_DOT * SIN - SPIN_DOT),
    )
    proof.step(
        "if also θ̇ ≠ 0: φ̇ = 0, and ω₃ = 0",
        "Euler along 1̂ with φ̇ = φ̈ = 0: 2kω₃θ̇ = 0",
        lambda: same(e1.subs({PHI: 0, PHI_DDOT: 0}), 2 * K * SPIN * THETA_DOT),
    )
    proof.step(
        "then θ̈ = -cosθ/(1+k) and θ̇² cosθ = sinθ cosθ/(1+k)",
        "Newton along x̂ and ẑ and Euler along 2̂ with φ̇ = ω₃ = 0, solved",
        lambda: _nutation(nx, nz, e2),
    )
    proof.step(
        "a contradiction: where cosθ ≠ 0, θ̇² = sinθ/(1+k) gives θ̈ = cosθ/(2(1+k)), and "
        "cosθ = 0 throughout needs θ̇ = 0",
        "derivative of θ̇² - sinθ/(1+k); the two values of θ̈ differ by 3cosθ/(2(1+k))",
        _contradiction,
    )
    proof.step(
        "so θ̇ = 0 on the interval, and the motion there is steady",
        "Euler along 1̂ with θ̇ = θ̈ = 0: k φ̈ sinθ = 0; ω₃ is constant",
        lambda: same(e1.subs(THETA_DOT, 0), -K * SIN * PHI_DDOT),
    )
    proof.step(
        "every steady motion is rolling, spinning or tumbling",
        "theorem `the disk among the bodies of revolution`",
        lambda: disk_case().proved,
    )
    proof.step(
        "each level of energy holds at most 2 + 2 + 4 steady motions",
        "energies (1+2k)ω₃²/2 + 1, kφ̇²/2 + 1 and 3 sinθ/2: at most two values of ω₃, two of "
        "φ̇, and two of θ with two signs of φ̇",
        _levels,
    )
    proof.conclude(
        "the motion converges to one steady motion",
        "LaSalle: its limit set is not empty, connected, invariant, with one energy and "
        "vA = 0. So it consists of steady motions of one energy. There are finitely many, and "
        "so it is one of them",
    )
    return Theorem(
        "every bounded motion settles",
        ("Under viscous or linear viscous friction, a motion for all t > 0 along which sinθ ≥ ε, "
         "gn ≥ ε and D ≥ ε for some ε > 0 converges to one steady motion: rolling, spinning or "
         "tumbling.",
         "No bounded motion ends on a cycle or in chaos."),
        ("0 < k ≤ 1/2, mu > 0 (or c > 0)",
         "convergence of θ, θ̇, φ̇, ω₃ and vA; nothing is said of how long it takes",
         "LaSalle's invariance principle (J. P. LaSalle, IRE Trans. Circuit Theory 7 (1960) 520) "
         "is cited, its premises are checked"),
        tuple(proof.steps),
        (f"{DISK_TESTS}::test_bounded_launches_end_settled",
         f"{DISK_TESTS}::test_many_bounded_launches_end_settled",
         f"{DISK_TESTS}::test_no_slip_on_an_interval_without_rest_is_found"),
    )  # fmt: skip


def _losses() -> bool:
    power = FORCE_X * SLIP_X + FORCE_Y * SLIP_Y
    loss = dict(zip(LAWS, (MU * NORMAL, MU), strict=True))
    found = [
        same(power.subs({FORCE_X: force(law)[0], FORCE_Y: force(law)[1]}),
             -loss[law] * (SLIP_X**2 + SLIP_Y**2))
        for law in LAWS
    ]  # fmt: skip
    return power_theorem() and all(found)


def _determinants() -> bool:
    viscous, linear = (determinant(law) for law in LAWS)
    wanted = 2 * K**2 * SIN * FLOW_D
    return (same(viscous, wanted) or same(viscous, -wanted)) and (
        same(linear, wanted.subs(SLIP_X, 0)) or same(linear, -wanted.subs(SLIP_X, 0))
    )


def _bounded_speeds() -> tuple[bool, str]:
    """Sylvester's criterion for the kinetic energy, which must be quadratic in the speeds."""
    kinetic = sympy.expand(energy() - SIN)
    poly = sympy.Poly(kinetic, *SPEEDS)
    quadratic = all(sum(powers) == 2 for powers in poly.monoms())
    form = sympy.hessian(kinetic, SPEEDS)
    minors = [simplified(form[:n, :n].det()) for n in range(1, 6)]
    words = ", ".join(str(m) for m in minors)
    return quadratic and all(_is_positive(m) for m in minors), words


def _is_positive(minor: Any) -> bool:
    """Whether s^n (a + b s²) is positive for k > 0 and 0 < s² ≤ 1, by its values at both ends."""
    if minor == 0:
        return False
    y = sympy.Symbol("y")  # sin²θ
    poly = sympy.Poly(sympy.expand(minor.subs(SIN, sympy.sqrt(y))), y)
    while poly.eval(0) == 0:
        poly = sympy.Poly(sympy.cancel(poly.as_expr() / y), y)
    ends = (sympy.Poly(poly.eval(value), K) for value in (0, 1))
    return poly.degree() <= 1 and all(c > 0 for end in ends for c in end.coeffs())


def _nutation(nx: Any, nz: Any, e2: Any) -> bool:
    bare = {PHI: 0, SPIN: 0}
    normal = sympy.solve(nz.subs(bare), NORMAL)[0]
    rest = e2.subs(bare).subs(NORMAL, normal)
    # c (θ̇² c) from Newton along x̂ is -c θ̈ s: this leaves (1 + k) θ̈ + c = 0
    combined = rest + SIN * nx.subs(bare)
    first = same(combined, (1 + K) * THETA_DDOT + COS)
    square = nx.subs(bare).subs(THETA_DDOT, -COS / (1 + K))
    return first and same((1 + K) * square, (1 + K) * COS * THETA_DOT**2 - SIN * COS)


def _contradiction() -> bool:
    slope = rate(THETA_DOT**2 - SIN / (1 + K))
    claimed = COS / (2 * (1 + K))
    vanishes = same(slope.subs(THETA_DDOT, claimed) * (1 + K), 0)
    gap = sympy.cancel((claimed + COS / (1 + K)) - 3 * COS / (2 * (1 + K)))
    return vanishes and gap == 0 and same(rate(COS), -SIN * THETA_DOT)


def _levels() -> bool:
    still = {THETA_DOT: 0, SLIP_X: 0, SLIP_Y: 0}
    level = energy().subs(still)
    rolling = level.subs(UPRIGHT | {PHI: 0})
    spinning = level.subs(UPRIGHT | {SPIN: 0})
    tumbling = level.subs(SPIN, 0).subs(PHI**2, 1 / (K * SIN))
    return (
        same(rolling, (1 + 2 * K) * SPIN**2 / 2 + 1)
        and same(spinning, K * PHI**2 / 2 + 1)
        and same(tumbling, sympy.Rational(3, 2) * SIN)
    )
