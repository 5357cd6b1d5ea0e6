"""Theorem: the steady motions of a body of revolution whose axis is vertical."""

from __future__ import annotations

from functools import lru_cache
from typing import Any

import sympy

from ..body_polynomials import FORCE_X, FORCE_Y, I1, SLIP_X, SLIP_Y, H
from ..mechanics import StatedForce, vanishes
from ..proof import POLE_TESTS, Proof, Theorem
from .graph import POLES, TURN_X, TURN_Y, pole_graph
from .vertical import SMOOTH_POLE

Expr = Any
"""A SymPy expression; SymPy states no types."""
UPRIGHT = {TURN_X: 0, TURN_Y: 0}
"""Angular velocity along the vertical."""
SLIPS, FORCES = (SLIP_X, SLIP_Y), (FORCE_X, FORCE_Y)


@lru_cache(maxsize=1)
def steady_at_poles() -> Theorem:
    """Completeness at the poles, for every body that is smooth there and every law."""
    proof = Proof()
    proof.step("the axis stays vertical exactly where ω is vertical, ω = n Ẑ",
               "rate of the axis, ω×3̂", _axis)  # fmt: skip
    proof.step("then ṅ = 0 and gn = 1 for every force F at the contact",
               "Euler along Ẑ, Newton along Ẑ, with F as two free numbers", _spin)  # fmt: skip
    proof.step("ω stays vertical exactly where F = 0 across Ẑ",
               "Euler along X and Y are linear in F, with determinant h²/I1² > 0",
               _torque)  # fmt: skip
    proof.step("F = 0 exactly where vA = 0, under a law with F·vA < 0 off vA = 0; then the slip "
               "and the velocity of the centre stay zero", "rate of the slip at F = 0",
               _slip)  # fmt: skip
    proof.step("without slip: vA = 0 and F = 0, with any n", "rates of the graph",
               lambda: _still("rough"))  # fmt: skip
    proof.step("without friction: F = 0, any n, the centre at rest or in uniform straight motion",
               "rates of the graph; no force across Ẑ", lambda: _still("smooth"))  # fmt: skip
    return Theorem(
        "steady motions with the axis vertical",
        ("At a pole where the body is smooth the steady motions are exactly vertical spin at any "
         "rate n = omega_Z, with vA = 0 and F = 0: under any friction and without slip the centre "
         "rests, without friction it may move uniformly.",
         "With the theorem for 0 < θ < π these are all steady motions of a body that is smooth at "
         "both poles."),
        (SMOOTH_POLE + "; one point of contact (a disk, cylinder or torus lies flat there)",
         "the law of friction at gn = 1: F·vA < 0 where vA ≠ 0, F = 0 where vA = 0; nothing else",
         "steady: axis, angular velocity and slip are constant"),
        tuple(proof.steps),
        (f"{POLE_TESTS}::test_no_other_steady_motion_is_found_at_a_pole",),
    )  # fmt: skip


def _axis() -> bool:
    found = []
    for side in POLES:
        rates = pole_graph(StatedForce, side, still=False).rates[:2]
        found.append(vanishes(rates[0] - side * TURN_Y) and vanishes(rates[1] + side * TURN_X))
    return all(found)


def _spin() -> bool:
    found = []
    for side in POLES:
        graph = pole_graph(StatedForce, side, still=False)
        found += [graph.rates[4].subs(UPRIGHT), graph.normal.subs(UPRIGHT) - 1]
    return all(vanishes(e) for e in found)


def _torque() -> bool:
    found = []
    for side in POLES:
        across = [r.subs(UPRIGHT) for r in pole_graph(StatedForce, side, still=False).rates[2:4]]
        matrix = sympy.Matrix(across).jacobian(FORCES)
        rest = [e.subs(dict.fromkeys(FORCES, 0)) for e in across]
        linear = sympy.Matrix(across) - matrix * sympy.Matrix(FORCES)
        found.append(
            vanishes(matrix.det() - (H / I1) ** 2)
            and all(vanishes(e) for e in (*rest, *linear))
            and not matrix.free_symbols & {*FORCES, *SLIPS}
        )
    return all(found)


def _slip() -> bool:
    free = UPRIGHT | dict.fromkeys(FORCES, 0)
    return all(
        vanishes(r.subs(free))
        for side in POLES
        for r in pole_graph(StatedForce, side, still=False).rates[5:]
    )


def _still(law: str) -> bool:
    rates = (r for side in POLES for r in pole_graph(law, side, still=False).rates)
    return all(vanishes(r.subs(UPRIGHT)) for r in rates)
