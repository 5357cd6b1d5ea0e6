"""Theorem: continuations of a motion under dry friction from rest, and the end of sliding at D = 0.

The slip's acceleration A is affine in the contact force F.  A continuation from rest is sticking
(A = 0) or a slip against the force, A = -λF with λ > 0 and |F| = mu gn.
"""

from __future__ import annotations

from functools import lru_cache
from typing import Any

import sympy

from stability.derivation.characteristic import COS, MU, SIN, K

from ..body_polynomials import (
    FORCE_X,
    FORCE_Y,
    NORMAL,
    PHI_DDOT,
    SLIP_X,
    SLIP_X_DOT,
    SLIP_Y,
    SLIP_Y_DOT,
    SPIN_DOT,
    THETA_DDOT,
)
from ..mechanics import simplified
from ..proof import DISK_TESTS, Proof, Theorem
from .case import rows

Expr = Any
"""A SymPy expression; SymPy states no types."""
LAM, U, V = sympy.symbols("lambda u v")
"""λ; cos a and sin a of the direction a of slip."""
BX, BZ = sympy.symbols("b_x b_z")
BASE = K + COS**2
KAPPA = MU * SIN * COS / BASE
ACROSS, ALONG = (K + 1) / BASE + LAM, 1 + 1 / (2 * K) + LAM
Q = ACROSS * V**2 + ALONG * U**2 - KAPPA * ALONG * U
FLOW_D = BASE - MU * SIN * COS * U
AGAINST = {FORCE_X: -MU * NORMAL * U, FORCE_Y: -MU * NORMAL * V}
"""Friction against a slip in the direction a."""


@lru_cache(maxsize=1)
def dry_friction() -> Theorem:
    """Continuations from rest, and when D runs to zero in slip."""
    proof = Proof()
    proof.step(
        "A = (bx + s c gn/k + (1 + s²/k) Fx, by + (1 + 1/(2k)) Fy), gn = -(k bz + s c Fx)/"
        "(k + c²), with b a function of the state alone",
        "the graph's equations solved for the accelerations, at any slip",
        _affine,
    )
    proof.step(
        "with gn eliminated: A = b′ + W F, W = diag((k+1)/(k+c²), 1 + 1/(2k))",
        "identity",
        _without_normal,
    )
    proof.step(
        "in slip gn D = -k bz, D = k + c² - mu s c cos a",
        "Fx = -mu gn cos a in the equation for gn",
        _normal_in_slip,
    )
    proof.step(
        "continuations: the sticking force with ψ(0) ≤ 0, and each root λ > 0 of ψ(λ) = "
        "|F| - mu gn, F = -(W + λ)⁻¹ b′; at a root dψ/dλ = -|F| Q/(XY), "
        "Q = X sin²a + Y cos²a - κ Y cos a, X = (k+1)/(k+c²) + λ, Y = 1 + 1/(2k) + λ, "
        "κ = mu s c/(k+c²)",
        "identity, with F = -mu gn (cos a, sin a)",
        _slope_of_psi,
    )
    proof.step("ψ(∞) = mu k bz/(k + c²)", "F → 0 as λ → ∞", _far)
    proof.step(
        "bz < 0: a continuation in contact exists for every mu; their number is odd for "
        "bz < 0 and even for bz > 0 where no root is double and ψ(0) ≠ 0",
        "signs of ψ at both ends, intermediate values; gn = |F|/mu > 0 at a root",
        lambda: all(step.proved for step in proof.steps),
    )
    proof.step(
        "mu < 2√(k(k+1)): |κ| < 1", "(k + c²)² - 4k(k+1) s²c² = ((2k+1)c² - k)², a square", _kappa
    )
    proof.step(
        "then Q > 0 for λ ≥ 0",
        "with r = Y/X, Q/X as a quadratic polynomial of cos a: by its ends r (1 ± κ) for "
        "r ≤ 1; by its vertex, at least 2 - r, for 1 < r ≤ 2; for r > 2 by "
        "κ² < 4(r-1)/r², whose least value is at λ = 0",
        _q_is_positive,
    )
    proof.step(
        "where h = 0: dh/da = -mu gn Q/(1 - κ cos a)",
        "identity, with f = λ mu gn eliminated",
        _slope_of_h,
    )
    proof.step(
        "dD/dt times D tends to mu N sin²a (k - (2k+1)c²)/(2k |vA|) as D → 0, N = gn D",
        "terms with gn of dD/dt; mu s c cos a = k + c² at D = 0",
        _end,
    )
    proof.conclude(
        "the statements hold",
        "for bz < 0, mu < 2√(k(k+1)): ψ falls through each root, "
        "so exactly one continuation; the direction of slip is a saddle of "
        "(ln |vA|, a), as f > 0 > dh/da, whose unstable manifold is one motion",
    )
    return Theorem(
        "dry friction",
        ("From rest with bz < 0 (pressed contact) a continuation in contact exists for every mu; "
         "if mu < 2√(k(k+1)) there is exactly one, up to the marginal |F| = mu gn; where it is a "
         "slip, one motion alone leaves rest in its direction.",
         "The number of continuations in contact is odd for bz < 0 and even for bz > 0, up to "
         "double roots and marginal sticking.",
         "In slip with N = gn D > 0, D dD/dt tends to mu N sin²a (k - (2k+1)c²)/(2k |vA|) as "
         "D → 0: with sin a ≠ 0, D runs to zero, like a square root of the time left, if "
         "c² > k/(2k+1), and is pushed away if c² < k/(2k+1)."),
        ("0 < k ≤ 1/2, mu > 0, 0 < θ < π; Coulomb friction with one mu for rest and slip",
         "bz: vertical acceleration of the contact point without contact force; a: direction of "
         "slip; f, h: its acceleration along and across a"),
        tuple(proof.steps),
        (f"{DISK_TESTS}::test_the_number_of_continuations_from_rest_is_as_stated",
         f"{DISK_TESTS}::test_d_runs_to_zero_in_slip_exactly_where_stated"),
    )  # fmt: skip


@lru_cache(maxsize=1)
def solved() -> dict[Expr, Expr]:
    """Accelerations of the slip, and gn as a function of the force, from the graph."""
    nx, ny, nz, *euler = rows()
    angles = sympy.solve(euler, [PHI_DDOT, THETA_DDOT, SPIN_DOT], dict=True)
    known = angles[0]
    slip = {
        SLIP_X_DOT: sympy.solve(nx.subs(known), SLIP_X_DOT)[0],
        SLIP_Y_DOT: sympy.solve(ny.subs(known), SLIP_Y_DOT)[0],
    }
    return slip | {NORMAL: sympy.solve(nz.subs(known), NORMAL)[0]}


def _zero(expression: Expr) -> bool:
    """Whether a rational function vanishes, given s² + c² = 1 and u² + v² = 1."""
    top = sympy.fraction(sympy.together(expression))[0]
    top = sympy.rem(sympy.Poly(sympy.expand(top), V), sympy.Poly(V**2 + U**2 - 1, V)).as_expr()
    return bool(simplified(top) == 0)


def _affine() -> bool:
    found = solved()
    ax, ay, normal = found[SLIP_X_DOT], found[SLIP_Y_DOT], found[NORMAL]
    free = {FORCE_X: 0, FORCE_Y: 0}
    linear = (
        _zero(ax - ax.subs(free | {NORMAL: 0}) - SIN * COS * NORMAL / K
              - (1 + SIN**2 / K) * FORCE_X),
        _zero(ay - ay.subs(free | {NORMAL: 0}) - (1 + 1 / (2 * K)) * FORCE_Y),
        _zero(normal - normal.subs(free) + SIN * COS * FORCE_X / BASE),
    )  # fmt: skip
    return all(linear)


def _without_normal() -> bool:
    normal = -(K * BZ + SIN * COS * FORCE_X) / BASE
    ax = BX + SIN * COS * normal / K + (1 + SIN**2 / K) * FORCE_X
    stated = BX - SIN * COS * BZ / BASE + (K + 1) / BASE * FORCE_X
    return _zero(ax - stated)


def _normal_in_slip() -> bool:
    equation = BASE * NORMAL + K * BZ + SIN * COS * AGAINST[FORCE_X]
    return _zero(equation - (NORMAL * FLOW_D + K * BZ))


def _slope_of_psi() -> bool:
    """dF/dλ = -(W + λ)⁻¹ F, as (W + λ) F is constant; then d|F|/dλ - mu dgn/dλ."""
    size = MU * NORMAL
    change_x, change_y = size * U / ACROSS, size * V / ALONG
    change_of_size = -(U * change_x + V * change_y)
    change_of_normal = -SIN * COS * change_x / BASE
    slope = change_of_size - MU * change_of_normal
    constant = (
        _zero(change_x * ACROSS + AGAINST[FORCE_X]), _zero(change_y * ALONG + AGAINST[FORCE_Y])
    )  # fmt: skip
    return all(constant) and _zero(slope + size * Q / (ACROSS * ALONG))


def _far() -> bool:
    force_x = -(BX - SIN * COS * BZ / BASE) / ACROSS
    normal = -(K * BZ + SIN * COS * force_x) / BASE
    whole = sympy.cancel(sympy.together(normal))
    top, bottom = (sympy.Poly(e, LAM) for e in sympy.fraction(whole))
    same = top.degree() == bottom.degree() > 0
    return same and _zero(top.LC() / bottom.LC() + K * BZ / BASE)


def _kappa() -> bool:
    square = BASE**2 - 4 * K * (K + 1) * SIN**2 * COS**2
    return _zero(square - ((2 * K + 1) * COS**2 - K) ** 2)


def _q_is_positive() -> tuple[bool, str]:
    done, words = _large_ratio()
    return done and _small_ratio(), words


def _small_ratio() -> bool:
    """Q/X = 1 - u² + r u² - κ r u: its ends, its vertex, and that on the border of (-1, 1)."""
    r, kappa = sympy.symbols("r kappa")
    form = 1 - U**2 + r * U**2 - kappa * r * U
    stated = _zero((Q / ACROSS).subs(V**2, 1 - U**2)
                   - form.subs({r: ALONG / ACROSS, kappa: KAPPA}))  # fmt: skip
    ends = all(sympy.expand(form.subs(U, e) - r * (1 - e * kappa)) == 0 for e in (1, -1))
    vertex = kappa * r / (2 * (r - 1))
    least = 1 - kappa**2 * r**2 / (4 * (r - 1))
    flat = sympy.cancel(sympy.diff(form, U).subs(U, vertex)) == 0
    lowest = sympy.cancel(form.subs(U, vertex) - least) == 0
    border = sympy.cancel(least.subs(kappa, 2 * (r - 1) / r) - (2 - r)) == 0
    return stated and ends and flat and lowest and border


def _large_ratio() -> tuple[bool, str]:
    """κ² < 4(r-1)/r² for r > 2: r falls with λ, the bound falls with r, and it holds at λ = 0."""
    r, y, w = sympy.symbols("r y w")
    falls = sympy.cancel(sympy.diff(4 * (r - 1) / r**2, r) - 4 * (2 - r) / r**3) == 0
    slope = sympy.diff(ALONG / ACROSS, LAM) * ACROSS**2
    ratio = _zero(slope - (ACROSS - ALONG))
    # at λ = 0 r is ρ, linear in y = c²; mu² = 4k(k+1) is the largest; ρ > 2 means y > least
    rho = (2 * K + 1) * (K + y) / (2 * K * (K + 1))
    same = _zero((ALONG / ACROSS).subs(LAM, 0) - rho.subs(y, COS**2))
    least = K * (2 * K + 3) / (2 * K + 1)
    above = sympy.cancel(rho.subs(y, least) - 2) == 0
    gap = 4 * (rho - 1) / rho**2 - 4 * K * (K + 1) * y * (1 - y) / (K + y) ** 2
    top, bottom = sympy.fraction(sympy.cancel(gap.subs(y, least + w)))
    signs = all(c > 0 for e in (top, bottom) for c in sympy.Poly(sympy.expand(e), K, w).coeffs())
    words = "κ² < 4(ρ-1)/ρ²: every coefficient is positive with c² = k(2k+3)/(2k+1) + w"
    return bool(falls and ratio and same and above and signs), words


def _slope_of_h() -> bool:
    """Along a: gn = -k bz/D(a); b from A = λ mu gn (cos a, sin a) at h = 0."""
    normal_slope = -NORMAL * MU * SIN * COS * V / FLOW_D
    pull = SIN * COS / K - MU * U * (1 + SIN**2 / K)
    drag = -MU * (1 + 1 / (2 * K)) * V
    f = LAM * MU * NORMAL
    ax_slope = normal_slope * pull + NORMAL * MU * V * (1 + SIN**2 / K)
    ay_slope = normal_slope * drag - NORMAL * MU * (1 + 1 / (2 * K)) * U
    # h = ay cos a - ax sin a, with ax = f cos a, ay = f sin a
    slope = ay_slope * U - f * V * V - ax_slope * V - f * U * U
    return _zero(slope + MU * NORMAL * Q / (1 - KAPPA * U))


def _end() -> bool:
    """The part of D dD/dt with gn, where slip turns at the rate (vx v̇y - vy v̇x)/|vA|²."""
    speed = sympy.Symbol("speed")
    found = solved()
    ax, ay = (sympy.diff(sympy.expand(found[n].subs(AGAINST)), NORMAL)
              for n in (SLIP_X_DOT, SLIP_Y_DOT))  # fmt: skip
    turning = (U * ay - V * ax) / speed
    found_rate = sympy.diff(-MU * SIN * COS * U, U) * (-V) * turning  # times gn D = N
    stated = MU * V**2 * (K - (2 * K + 1) * COS**2) / (2 * K * speed)
    at_end = {U: BASE / (MU * SIN * COS)}
    gap = sympy.cancel(sympy.together((found_rate - stated) / V**2)).subs(at_end)
    alone = not (ax.has(SLIP_X) or ay.has(SLIP_Y))
    return alone and _zero(gap)
