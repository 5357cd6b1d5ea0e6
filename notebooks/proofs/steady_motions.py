"""Theorems: the steady motions of every body of revolution, and where their families meet."""

from __future__ import annotations

from functools import lru_cache
from typing import Any

import sympy

from stability.derivation.characteristic import COS, MU, SIN

from .body_polynomials import (
    AXIAL,
    BEND,
    FORCE_X,
    FORCE_Y,
    I1,
    I3,
    NORMAL,
    PHI,
    RADIUS,
    RHO,
    SLIP_X,
    SLIP_Y,
    SLOPE,
    SPEEDS,
    SPIN,
    SQUARE,
    STILL,
    STORED_LAWS,
    H,
    R,
    Z,
    characteristic,
    equations,
    pencil,
)
from .mechanics import NO_SLIP, STEADY, StatedForce, along, power_theorem, rate, vanishes
from .proof import BODY_TESTS, POLE_TESTS, Proof, Theorem
from .rolling import Q
from .spinning import EDGE

Expr = Any
"""A SymPy expression; SymPy states no types."""
MOMENT = SLOPE + PHI * SIN * (I3 * SPIN - I1 * PHI * COS)
"""Zero on the steady motions without force."""
RIM = RADIUS * SPIN - PHI * SIN * AXIAL
"""ω₃ r - φ̇ sinθ z: the speed of the point of contact about the centre."""
SURFACE = SLOPE + PHI * (SPIN * (RADIUS * H + I3 * SIN) - PHI * SIN * (AXIAL * H + I1 * COS))
"""Zero on the steady motions without slip."""
FREE = {FORCE_X: 0, FORCE_Y: 0, NORMAL: 1, SLIP_X: 0, SLIP_Y: 0}
"""No force, no slip, the weight on the plane."""
SEARCH = "tests/bodies/test_round_families.py::test_no_other_steady_motion_is_found"
"""The test that searches for other motions."""


def jellett() -> bool:
    """Whether L·a is constant under every force if h′′ = const - h, that is for a sphere."""
    found = equations(StatedForce)
    integral = -I1 * PHI * SIN * RADIUS - I3 * SPIN * AXIAL
    change = rate(integral).subs(BEND, RHO - H)
    # a = r 1̂ - z 3̂; the torque a × F is across a, so Euler's rows times a leave L·ȧ
    rows = RADIUS * found.rows[3] - AXIAL * found.rows[5]
    offset = sympy.Symbol("e")
    sphere = {H: RHO - offset * COS, SLOPE: offset * SIN}
    return vanishes((change - rows).subs(sphere))


@lru_cache(maxsize=1)
def steady_motions() -> Theorem:
    """Completeness for every body and every law that takes energy from every slip."""
    proof = Proof()
    rows = [r.subs(STEADY) for r in equations(StatedForce).rows]
    nx, ny, nz, e1, e2, e3 = (r.subs(FREE) for r in rows)
    proof.step("the rows hold h and h′; linearisations at θ̇ = 0 hold h, h′ and h′′, and no "
               "higher derivative", "free symbols of the general graph with a cubic height",
               derivatives_that_enter)  # fmt: skip
    proof.step("dE/dt = F·vA for every force F at the contact",
               "identity: Newton times the centre's velocity plus Euler times ω",
               power_theorem)  # fmt: skip
    proof.step("vA = 0 and F = 0: energy is constant, so F·vA = 0, which the law allows at vA = 0 "
               "alone", "step 2", lambda: proof.steps[1].proved)  # fmt: skip
    proof.step("gn = 1", "Newton along ẑ", lambda: vanishes(rows[2] - 1 + NORMAL) and nz == 0)
    proof.step("φ̇ (ω₃ r - φ̇ s z) = 0", "Newton along x̂", lambda: vanishes(nx - PHI * RIM))
    proof.step("h′ + φ̇ s (I3 ω₃ - I1 φ̇ c) = 0", "Euler along 2̂", lambda: vanishes(e2 - MOMENT))
    proof.step("φ̇ = 0: h′ = 0, with ω₃ free: rolling", "the last equation at φ̇ = 0",
               lambda: vanishes(MOMENT.subs(PHI, 0) - SLOPE))  # fmt: skip
    proof.step(
        "φ̇ ≠ 0: ω₃ = φ̇ s z/r, and φ̇² s (I1 r c - I3 z s) = h′ r: tumbling, or spinning "
        "where both sides vanish for every φ̇",
        "elimination of ω₃",
        _tumbles,
    )
    proof.step("both sides vanish for every φ̇ upright (c = 0 and h′ = 0), or where h′ = 0 and "
               "I1 r c = I3 z s, which at h′ = 0 is (I1-I3) h s c = 0",
               "identity at h′ = 0", _both)  # fmt: skip
    proof.step("there ω₃ = φ̇ c, so ω = φ̇ Ẑ, and the contact point lies below the centre",
               "ω₃ = φ̇ s z/r at h′ = 0, where r = h s and z = h c", _turns)  # fmt: skip
    proof.step("no equation is left, and each of the motions is steady under every such law",
               "Newton along ŷ, Euler along 1̂ and 3̂ vanish",
               lambda: all(vanishes(r) for r in (ny, e1, e3)))  # fmt: skip
    proof.step("dr/dθ = ρ cosθ: with r ≥ 0 at both ends, r > 0 between them",
               "derivative along θ; ρ ≥ 0, and not zero throughout where r = 0 at an end",
               lambda: vanishes(along(RADIUS) - (H + BEND) * COS))  # fmt: skip
    return Theorem(
        "steady motions of every body under any friction",
        ("If I1 ≠ I3, the steady motions are exactly rolling (φ̇ = 0, h′ = 0), spinning (θ = π/2, "
         "h′ = 0, ω₃ = 0) and tumbling (ω₃ = φ̇ sinθ z/r, φ̇² sinθ (I1 r cosθ - I3 z sinθ) = "
         "h′ r), with vA = 0 and F = 0 in each.",
         "A body with I1 = I3 has one more family: leaning spin, ω = φ̇ Ẑ with φ̇ free, at every "
         "other θ with h′ = 0; there the equation of tumbling is 0 = 0."),
        ("0 < θ < π, sinθ ≠ 0, h > 0, h + h′′ ≥ 0 and not zero for all θ < π/2 if the contact "
         "reaches the axis (so r ≠ 0); I1 > 0, I3 > 0",
         "the law of friction at gn = 1: F·vA < 0 where vA ≠ 0, F = 0 where vA = 0; nothing else",
         "steady: θ, θ̇ = 0, φ̇, ω₃ and vA are constant; the next theorem has the poles sinθ = 0"),
        tuple(proof.steps),
        (SEARCH, f"{SEARCH}_at_or_near_a_pole",
         f"{POLE_TESTS}::test_a_body_of_equal_moments_leans_and_spins"),
    )  # fmt: skip


def _tumbles() -> bool:
    left = MOMENT.subs(SPIN, PHI * SIN * AXIAL / RADIUS) * RADIUS
    right = SLOPE * RADIUS - PHI**2 * SIN * (I1 * RADIUS * COS - I3 * AXIAL * SIN)
    return vanishes(left - right)


def _both() -> bool:
    level = (I1 * RADIUS * COS - I3 * AXIAL * SIN).subs(SLOPE, 0)
    return vanishes(level - (I1 - I3) * H * SIN * COS)


def _turns() -> bool:
    return vanishes((PHI * SIN * AXIAL / RADIUS).subs(SLOPE, 0) - PHI * COS)


@lru_cache(maxsize=1)
def rough_and_smooth() -> Theorem:
    """Steady motions without slip, and without friction."""
    proof = Proof()
    rows = [r.subs(STEADY).subs(NO_SLIP) for r in equations(StatedForce).rows]
    held = {FORCE_X: PHI * RIM, FORCE_Y: 0, NORMAL: 1}
    slide = sympy.Symbol("w")  # uniform velocity of the centre across x̂
    proof.step(
        "without slip F = (φ̇ (ω₃ r - φ̇ s z), 0) and gn = 1",
        "Newton along x̂, ŷ, ẑ",
        lambda: all(vanishes(r.subs(held)) for r in rows[:3]),
    )
    proof.step("without slip: h′ + φ̇ (ω₃ (r h + I3 s) - φ̇ s (z h + I1 c)) = 0",
               "Euler along 2̂ with this force; along 1̂ and 3̂ nothing is left",
               lambda: vanishes(rows[4].subs(held) - SURFACE)
               and vanishes(rows[3].subs(held)) and vanishes(rows[5].subs(held)))  # fmt: skip
    proof.step("this is a smooth surface but at rest with h′′ = 0, so two eigenvalues are zero",
               "its gradient: φ̇ (r h + I3 s) by ω₃; ω₃ (r h + I3 s) by φ̇ at φ̇ = 0; h′′ by θ at "
               "rest", _gradient)  # fmt: skip
    proof.step("its two dimensions are two structural zeros, and it holds rolling, spinning and "
               "tumbling", "multiplicity of λ in the characteristic polynomials of the general "
               "graph; substitution", _holds_families)  # fmt: skip
    proof.step("Coulomb: the steady motions are those with |φ̇ (ω₃ r - φ̇ s z)| ≤ mu",
               "in slip F·vA = -mu gn |vA| < 0, so none slides (dE/dt = F·vA ≠ 0); at rest the "
               "force of step 1 must satisfy |F| ≤ mu gn", power_theorem)  # fmt: skip
    proof.step("without friction: h′ + φ̇ s (I3 ω₃ - I1 φ̇ c) = 0, the centre at rest or in "
               "uniform straight motion", "Euler along 2̂ with F = 0; ẑ, 1̂ and 3̂ hold",
               lambda: _without_friction(slide))  # fmt: skip
    return Theorem(
        "steady motions of every body without slip, and without friction",
        ("Without slip the steady motions are the surface h′ + φ̇ (ω₃ (r h + I3 sinθ) - "
         "φ̇ sinθ (z h + I1 cosθ)) = 0, which holds rolling, spinning and tumbling; its two "
         "dimensions are the two structural zeros.",
         "Under Coulomb friction they are those without slip with |φ̇ (ω₃ r - φ̇ sinθ z)| ≤ mu.",
         "Without friction they are the surface h′ + φ̇ sinθ (I3 ω₃ - I1 φ̇ cosθ) = 0."),
        ("0 < θ < π, h > 0, r > 0",
         "without slip: vA = 0 and any force; without friction: F = 0; Coulomb: mu > 0"),
        tuple(proof.steps),
        (f"{BODY_TESTS}::test_members_of_circling_and_precession_lie_on_the_surfaces", SEARCH),
    )  # fmt: skip


def _gradient() -> bool:
    lever = RADIUS * H + I3 * SIN
    at_rest = along(SURFACE).subs({PHI: 0, SPIN: 0})
    return (
        vanishes(SURFACE.diff(SPIN) - PHI * lever)
        and vanishes(SURFACE.diff(PHI).subs(PHI, 0) - SPIN * lever)
        and vanishes(at_rest - BEND)
    )


def _holds_families() -> tuple[bool, str]:
    families = ("circling", "rolling", "spinning", "tumbling")
    zeros = {family: characteristic(family, "rough").zeros for family in families}
    members = (
        {SLOPE: 0, PHI: 0},
        {SLOPE: 0, SPIN: 0, COS: 0},
        {SPIN: PHI * SIN * Z / R, SLOPE: PHI**2 * SIN * (I1 * R * COS - I3 * Z * SIN) / R},
    )
    # tumbling is given by r and z
    placed = SURFACE.subs({RADIUS: R, AXIAL: Z})
    held = (SURFACE.subs(members[0]), SURFACE.subs(members[1]), placed.subs(members[2]))
    words = ", ".join(f"{name} {count}" for name, count in zeros.items())
    return set(zeros.values()) == {2} and all(vanishes(e) for e in held), words


def _without_friction(slide: Expr) -> bool:
    rows = [r.subs(STEADY).subs({FORCE_X: 0, FORCE_Y: 0, NORMAL: 1})
            for r in equations(StatedForce).rows]  # fmt: skip
    # slip of a centre at rest is that of the rim; a moving centre adds a constant velocity, which
    # stands in no row along ẑ, 1̂, 2̂, 3̂
    moved = [rows[i].subs({SLIP_X: slide, SLIP_Y: slide}) for i in (2, 3, 4, 5)]
    return vanishes(moved[2] - MOMENT) and all(vanishes(moved[i]) for i in (0, 1, 3))


@lru_cache(maxsize=1)
def branches() -> Theorem:
    """Where tumbling meets spinning, and where it comes to rest."""
    proof = Proof()
    proof.step("near θ = π/2 + δ with h′ = h′′ δ: φ̇² of tumbling → h h′′/(I3 ρ - I1 h)",
               "limit of the closed form, h′′ = ρ - h", _meets)  # fmt: skip
    proof.step("there the constant term of spinning under viscous friction vanishes",
               "with h = 1 it is z1 of spinning",
               lambda: vanishes(_limit().subs(H, 1) - EDGE))  # fmt: skip
    proof.step("at another θ with h′ = 0, near it h′ = h′′ δ: φ̇² ≈ h′′ δ/((I1-I3) s c), to 0",
               "derivative of the closed form", _rests)  # fmt: skip
    proof.step(
        "at rest energy is h plus a positive definite form of the speeds: a minimum where "
        "h′′ > 0, none where h′′ < 0",
        "energy from the graph; its speeds have positive coefficients",
        _energy,
    )
    proof.step(
        "where h′′ < 0 one eigenvalue at rest is positive",
        "constant terms of rolling at ω₃ = 0: mu² h′′ Q, h′′ Q, h′′ I1",
        _unstable,
    )
    return Theorem(
        "where the families meet",
        ("Tumbling branches off spinning at φ̇² = h h′′/(I3 ρ - I1 h), if this is positive; there "
         "the constant term of spinning under viscous friction vanishes: a static boundary.",
         "Tumbling ends at rest, in rolling with ω₃ = 0, at each leaning θ with h′ = 0, on the "
         "side where h′′ (θ - θ*) (I1-I3) cosθ* > 0.",
         "At rest h decides, with viscous friction, without slip, and without friction: h′′ > 0 "
         "stable, as energy is least there; h′′ < 0 unstable."),
        ("h > 0, ρ = h + h′′; I1 ≠ I3 at the leaning end",),
        tuple(proof.steps),
        (f"{BODY_TESTS}::test_tumbling_meets_spinning_and_rest_where_the_theorem_says",),
    )  # fmt: skip


def _limit() -> Expr:
    return H * (RHO - H) / (I3 * RHO - I1 * H)


def _near(cosine: Expr, sine: Expr) -> Expr:
    """φ̇² of tumbling at first order in δ, as a ratio of derivatives along θ."""
    top, bottom = SLOPE * RADIUS, SIN * (I1 * RADIUS * COS - I3 * AXIAL * SIN)
    given = {SLOPE: 0, COS: cosine, SIN: sine}
    return along(top).subs(given), along(bottom).subs(given), bottom.subs(given)


def _meets() -> bool:
    top, bottom, value = _near(sympy.Integer(0), sympy.Integer(1))
    place = {R: RADIUS, Z: AXIAL}
    closed = SLOPE * RADIUS / (SIN * (I1 * RADIUS * COS - I3 * AXIAL * SIN))
    return (
        vanishes(SQUARE.subs(place) - closed)
        and value == 0
        and vanishes((top / bottom).subs(BEND, RHO - H) - _limit())
    )


def _rests() -> bool:
    top, _, value = _near(COS, SIN)
    return vanishes(top / value - BEND / ((I1 - I3) * SIN * COS))


def _energy() -> bool:
    energy = equations(StatedForce).energy
    order = [3, 4, 0, 1, 2]  # the slips first
    form = sympy.hessian(energy, SPEEDS).extract(order, order)
    first = I1 + SLOPE**2
    wanted = (1, 1, first, first * I1 * SIN**2, first * I1 * SIN**2 * I3)
    minors = (form[:n, :n].det() for n in range(1, 6))
    still = energy.subs(dict.fromkeys(SPEEDS, 0))
    return vanishes(still - H) and all(vanishes(p - q) for p, q in zip(minors, wanted, strict=True))


def _unstable() -> bool:
    """Whether the constant terms at rest are h′′ times the positive Q, and h′′ alone."""
    found = {
        law: characteristic("rolling", law).coefficients[-1].subs(SPIN, 0) for law in STORED_LAWS
    }
    return (
        vanishes(found["viscous"] - MU**2 * BEND * Q)
        and vanishes(found["rough"] - BEND * Q)
        and vanishes(found["smooth"] - BEND * I1)
    )


def derivatives_that_enter() -> tuple[bool, str]:
    """Whether the height, its slope and its second derivative alone enter every linearisation."""
    kept = {law: pencil(law).free_symbols for law in STORED_LAWS}
    third = [law for law, symbols in kept.items() if any(str(x) == "h′′′" for x in symbols)]
    steady = [r.subs(STILL | {NORMAL: 1, FORCE_X: 0, FORCE_Y: 0}) for r in equations("rough").rows]
    bend = any(row.has(BEND) for row in steady)
    words = "entries of the pencils hold h, h′, h′′; the steady rows hold h, h′"
    return not third and not bend, words
