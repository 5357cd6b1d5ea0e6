"""The thin disk as the body of height sinθ: its equations, and the general theorems at this height.

m = R = g = 1, I1 = k, I3 = 2k.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import lru_cache, partial
from math import prod
from typing import Any

import casadi as ca
import sympy

from stability.algebra.number_types import sympy_algebra
from stability.algebra.program import Program
from stability.bodies.thin_disk import disk_system
from stability.derivation.characteristic import COS, LAM, MU, SIN, K, M
from stability.derivation.characteristic import SQUARE as RATE_SQUARE
from stability.derivation.hurwitz import Obligation, decisive

from .. import rolling, spinning, steady_motions
from ..body_polynomials import (
    AXIAL,
    BEND,
    FORCE_X,
    FORCE_Y,
    I1,
    I3,
    KNOWN,
    NORMAL,
    PAIRS,
    PHI,
    RADIUS,
    RHO,
    SLIP_X,
    SLIP_Y,
    SLOPE,
    SPEEDS,
    SPIN,
    SQUARE,
    STORED_LAWS,
    H,
    R,
    Z,
    characteristic,
    equations,
    folded,
)
from ..disk_polynomials import derive
from ..mechanics import StatedForce, force, same, simplified, vanishes
from ..proof import DISK_TESTS, Proof, Theorem
from ..signs import sign
from ..spinning import EXCESS

Expr = Any
"""A SymPy expression; SymPy states no types."""
HEIGHT = {H: SIN, SLOPE: COS, BEND: -SIN}
DISK = HEIGHT | {I1: K, I3: 2 * K, R: 1, Z: 0, RHO: 0}
"""Every symbol of the general graph for the disk."""
UPRIGHT = {SIN: 1, COS: 0}
ROUGH = (2 * K + 1) * PHI * SPIN * SIN - COS * (K * PHI**2 * SIN - 1)
"""Zero on the rough disk's steady motions."""
SMOOTH = 2 * K * PHI * SPIN * SIN - COS * (K * PHI**2 * SIN - 1)
"""Zero on the smooth disk's steady motions."""
M1 = 4 * K / (2 * K + 1) ** 2
"""Limit of mu*² for fast spinning."""
M2 = 24 * K / ((2 * K + 1) * (4 * K + 3))
"""Limit of mu*² for spinning just above the static boundary."""


def of_disk(expression: Expr) -> Expr:
    """A general expression for the disk."""
    return sympy.sympify(expression).subs(DISK, simultaneous=True)


@lru_cache(maxsize=1)
def rows() -> tuple[Expr, ...]:
    """Newton along x̂, ŷ, ẑ and Euler along 1̂, 2̂, 3̂ of the disk, for any contact force."""
    return tuple(of_disk(row) for row in equations(StatedForce).rows)


@lru_cache(maxsize=1)
def energy() -> Expr:
    """Energy of the disk, a polynomial in the speeds and s."""
    return folded(of_disk(equations(StatedForce).energy))


@lru_cache(maxsize=4)
def determinant(law: str) -> Expr:
    """Determinant of the disk's equations for the accelerations and the normal force."""
    return simplified(of_disk(equations(law).by_unknown).det(method="berkowitz"))


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


@lru_cache(maxsize=1)
def flutter() -> tuple[Expr, Expr, Expr]:
    """(a2, a1, a0) of the flutter condition of spinning in v = φ̇² - 1/k, from the disk's graph."""
    condition = deciding("spinning").conditions["flutter"]
    poly = sympy.Poly(sympy.expand(condition.subs(RATE_SQUARE, EXCESS + 1 / K)), EXCESS)
    a2, a1, a0 = (sympy.factor(c) for c in poly.all_coeffs())
    return a2, a1, a0


# --- the general theorems at h = sinθ ---


@lru_cache(maxsize=1)
def disk_case() -> Theorem:
    """What the theorems on every body say of the disk."""
    proof = Proof()
    proof.step("the disk's own graph has the rows and the energy of the general graph at h = sinθ",
               "identities, for any contact force", _same_graph)  # fmt: skip
    proof.step("r = 1, z = 0 and ρ = h + h′′ = 0, and I1 ≠ I3: the assumptions of the general "
               "theorems hold for 0 < θ < π", "identities",
               lambda: vanishes(RADIUS.subs(HEIGHT) - 1) and vanishes(AXIAL.subs(HEIGHT))
               and vanishes((H + BEND).subs(HEIGHT)))  # fmt: skip
    proof.step("rolling: θ = π/2, φ̇ = 0; spinning: θ = π/2, ω₃ = 0; tumbling: ω₃ = 0, "
               "kφ̇² sinθ = 1", "h′ = cosθ; ω₃ = φ̇ sinθ z/r = 0; φ̇² of tumbling",
               lambda: HEIGHT[SLOPE] == COS and of_disk(PHI * SIN * Z / R) == 0
               and vanishes(of_disk(SQUARE) - 1 / (K * SIN)))  # fmt: skip
    proof.step("both viscous laws are such laws: F·vA = -mu |vA|² at gn = 1",
               "their formulas", _viscous_laws)  # fmt: skip
    proof.step("without slip: (2k+1)φ̇ω₃ sinθ = cosθ (kφ̇² sinθ - 1), with F = φ̇ω₃; without "
               "friction: 2kφ̇ω₃ sinθ = cosθ (kφ̇² sinθ - 1)", "the surfaces at h = sinθ",
               lambda: same(of_disk(steady_motions.SURFACE), ROUGH)
               and same(of_disk(steady_motions.MOMENT), SMOOTH)
               and same(of_disk(steady_motions.RIM), SPIN))  # fmt: skip
    steady = [(f, law) for f in ("rolling", "spinning", "tumbling") for law in STORED_LAWS]
    for family, law in (*steady, ("circling", "rough")):
        proof.step(f"{family}, {law}: the disk's characteristic polynomial is the general one",
                   "identity up to a factor without λ; the disk's is derived from its own graph",
                   partial(_same_polynomial, family, law))  # fmt: skip
    proof.step("rolling: ω₃² > 1/(2k) under viscous friction, 1/(2(2k+1)) without slip, 1/(4k) "
               "without friction", "zeros of the general conditions",
               lambda: _zero(rolling.FLUTTER, SPIN, 1 / (2 * K))
               and _zero(rolling.WITHOUT_SLIP, SPIN, 1 / (2 * (2 * K + 1)))
               and _zero(rolling.WITHOUT_FRICTION, SPIN, 1 / (4 * K)))  # fmt: skip
    proof.step("spinning: q1 = 1/k under viscous friction, M1 = 4k/(2k+1)² and "
               "M2 = 24k/((2k+1)(4k+3))", "the general limits, as lengths are over h(π/2) = 1",
               lambda: all(vanishes(of_disk(a) - b) for a, b in (
                   (spinning.EDGE, 1 / K), (spinning.M1, M1), (spinning.M2, M2))))  # fmt: skip
    proof.step("spinning: the general flutter polynomial is that of the disk, a2 v² + a1 v + a0",
               "identity up to a positive factor, v = φ̇² - 1/k", _same_flutter)  # fmt: skip
    proof.step("the general theorems that are used are proved", "their own steps",
               lambda: all(t().proved for t in (
                   steady_motions.steady_motions, steady_motions.rough_and_smooth,
                   rolling.rolling_conservative, rolling.rolling_viscous,
                   spinning.spinning_conservative, spinning.spinning_viscous)))  # fmt: skip
    return Theorem(
        "the disk among the bodies of revolution",
        ("Under any friction the steady motions are exactly rolling (θ = π/2, φ̇ = 0), spinning "
         "(θ = π/2, ω₃ = 0) and tumbling (ω₃ = 0, kφ̇² sinθ = 1), with vA = 0 in each.",
         "Rough: exactly (2k+1)φ̇ω₃ sinθ = cosθ (kφ̇² sinθ - 1), a smooth surface that holds "
         "rolling, spinning and tumbling; its two dimensions are the two structural zeros.",
         "Coulomb: exactly those of the rough disk with |φ̇ω₃| ≤ mu.",
         "Smooth, centre without horizontal velocity: exactly 2kφ̇ω₃ sinθ = "
         "cosθ (kφ̇² sinθ - 1).",
         "Spinning: let M1 = 4k/(2k+1)² and M2 = 24k/((2k+1)(4k+3)); mu*² = mu² g R, and φ̇ is in "
         "√(g/R).",
         "mu*² ≤ M1: spinning is stable for every φ̇² > 1/k.",
         "M1 < mu*² < M2: stable exactly for 1/k < φ̇² < 1/k + v*, unstable above, with v* the one "
         "positive root, simple, of a2 v² + a1 v + a0.",
         "mu*² ≥ M2: unstable for every φ̇.",
         "φ̇² < 1/k: unstable for every mu."),
        ("0 < θ < π, 0 < k ≤ 1/2, mu > 0",
         "under any friction: the law at gn = 1 has F·vA < 0 where vA ≠ 0, F = 0 where vA = 0; "
         "nothing else; both viscous laws are such",
         "spinning: viscous or linear viscous friction; stable: every eigenvalue but the "
         "structural zero has a negative real part"),
        tuple(proof.steps),
        (f"{DISK_TESTS}::test_no_other_steady_motion_is_found_under_several_laws",
         f"{DISK_TESTS}::test_rough_and_smooth_motions_off_the_surface_are_not_steady",
         f"{DISK_TESTS}::test_dry_friction_holds_a_steady_motion_exactly_inside_the_cone",
         f"{DISK_TESTS}::test_spinning_is_stable_exactly_where_the_theorem_says"),
    )  # fmt: skip


def _same_graph() -> bool:
    system = disk_system(StatedForce)
    assert system.mass is not None and system.forcing is not None
    out = [system.mass, system.forcing, system.observables["energy"]]
    program = Program(ca.Function("implicit", [system.x, system.p], out))
    algebra = sympy_algebra()
    functions = dict(algebra.functions) | {"sin": lambda _: SIN, "cos": lambda _: COS}
    algebra = replace(algebra, functions=functions)
    given = [[sympy.Symbol("theta"), *SPEEDS], [K, FORCE_X, FORCE_Y]]
    mass, forcing, own = (sympy.Matrix(program.dense(algebra, given, i)) for i in range(3))
    unknowns = sympy.Matrix([KNOWN[name] for name in system.unknowns])
    pairs = zip(mass * unknowns - forcing, rows(), strict=True)
    return all(same(a, b) for a, b in pairs) and same(own[0], energy())


def _viscous_laws() -> bool:
    lost = MU * (SLIP_X**2 + SLIP_Y**2)
    powers = (x * SLIP_X + y * SLIP_Y for x, y in map(force, ("viscous", "linear-viscous")))
    return all(vanishes(power.subs(NORMAL, 1) + lost) for power in powers)


def _same_polynomial(family: str, law: str) -> bool:
    """The disk's factors are in λ/mu and mu² under viscous friction, and in the square of `at`."""
    general, own = characteristic(family, law), derive(family, law)
    square = {"rolling": SPIN**2, "spinning": PHI**2, "circling": PHI**2}.get(family, 1)
    scaled = {M: MU**2, RATE_SQUARE: square} | ({LAM: LAM / MU} if law == "viscous" else {})
    wanted = prod((f.as_expr().subs(scaled, simultaneous=True) for f in own.factors), start=1)
    got = sum(of_disk(c) * LAM**i for i, c in enumerate(reversed(general.coefficients)))
    if family in ("rolling", "spinning"):
        got = got.subs(UPRIGHT)
    spin = COS * (K * PHI**2 * SIN - 1) / ((2 * K + 1) * PHI * SIN)  # on the surface without slip
    got = got.subs(SPIN, spin) if family in PAIRS else got
    got = got.subs(PHI, 1 / sympy.sqrt(K * SIN)) if family == "tumbling" else got
    a, b = (sympy.Poly(sympy.together(e), LAM).all_coeffs() for e in (got, wanted))
    one = len(a) == len(b) and all(vanishes(p * b[0] - q * a[0]) for p, q in zip(a, b, strict=True))
    return one and own.zeros == general.zeros


def _zero(condition: Expr, speed: Expr, square: Expr) -> bool:
    """Whether a condition of upright motion, positive for fast motion, vanishes at this square."""
    poly = sympy.Poly(of_disk(condition).subs(UPRIGHT), speed)
    rises = poly.degree() == 2 and sign(poly.nth(2)) == 1
    return rises and vanishes(poly.nth(0) / poly.nth(2) + square)


def _same_flutter() -> tuple[bool, str]:
    pairs = zip(spinning.flutter(), flutter(), strict=True)
    ratios = {sympy.cancel(of_disk(a) / b) for a, b in pairs}
    words = "; ".join(f"a{2 - i} = {c}" for i, c in enumerate(flutter()))
    return len(ratios) == 1 and sign(ratios.pop()) == 1, words
