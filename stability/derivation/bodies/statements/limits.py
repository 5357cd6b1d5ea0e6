"""Rows: Painlevé's limit of bodies, and its closed form for disks."""

from __future__ import annotations

import casadi as ca
import sympy

from ....bodies.round_body.body import Body
from ....bodies.round_body.shapes.named import EccentricSphere, Spheroid, ThickDisk, Torus
from ....bodies.round_body.shapes.profile import Egg
from ...characteristic import K
from ...proof import Proof, Theorem
from ..graph import vanishes
from ..painleve import painleve_limit
from ..rolling import FILE
from .entry import Entry


def painleve() -> Theorem:
    """Painlevé's limit of the disk and the thick disk in closed form."""
    proof, x = Proof(), sympy.Symbol("x")
    proof.step(
        "with x = cos²ψ: (κ + x)²/(x (1-x)) = 4κ(κ+1) + ((2κ+1) x - κ)²/(x (1-x))",
        "identity",
        lambda: vanishes((K + x) ** 2 - 4 * K * (K + 1) * x * (1 - x) - ((2 * K + 1) * x - K) ** 2),
    )
    proof.step(
        "the least value is at tan²ψ = (κ+1)/κ > 1, so at ψ or π - ψ between π/4 and 3π/4, one of "
        "which lies in every open range of length π/2 that begins in [0, π/2)",
        "the root of the square",
        lambda: vanishes((1 - K / (2 * K + 1)) / (K / (2 * K + 1)) - (K + 1) / K),
    )
    return Theorem(
        "Painlevé's limit of disks",
        ("D = I1 + h′² - mu vx h h′ > 0 at every θ exactly where mu |vx| is below the least value "
         "of (I1 + h′²)/(h |h′|).",
         "For h = L sin(θ + α) this is 2 √(κ(κ+1)) with κ = I1/L²: the thin disk with L = 1, the "
         "thick disk with L² = 1 + t²/4."),
        ("viscous friction; mu |vx| without unit; 0 ≤ α < π/2",),
        tuple(proof.steps),
        (f"{FILE}::test_painleve_limits_are_the_least_values",),
    )  # fmt: skip


def bodies() -> list[tuple[str, Body, str]]:
    """Bodies of the table: name, body, and the closed form of its limit if there is one."""
    disk = {k: Body(lambda theta: ca.sin(theta), axial=2 * k, transverse=k, name="disk")
            for k in (0.25, 0.5)}  # fmt: skip
    return [
        ("disk, k = 0.25", disk[0.25], "2 √(k(k+1))"), ("disk, k = 0.5", disk[0.5], "2 √(k(k+1))"),
        ("thick disk, t = 0.2", ThickDisk(0.2), "2 √(κ(κ+1))"),
        ("torus, b = 0.1", Torus(0.1), ""), ("torus, b = 0.3", Torus(0.3), ""),
        ("hollow torus, b = 0.1", Torus(0.1, solid=False), ""),
        ("spheroid, aspect 0.5", Spheroid(0.5), ""), ("spheroid, aspect 1.5", Spheroid(1.5), ""),
        ("eccentric sphere, e = 0.1", EccentricSphere(0.1), ""),
        ("eccentric sphere, e = 0.3", EccentricSphere(0.3), ""),
        ("egg, taper 0.2", Egg(0.2), ""),
    ]  # fmt: skip


def limit(name: str, body: Body, closed: str) -> Entry:
    """The row of a body's limit.

    Parameters
    ----------
    name, body, closed
        As from `bodies`.
    """
    found = painleve_limit(body)
    status = "enclosed, and in closed form" if closed else "enclosed"
    own = f", {closed}" if closed else ""
    return Entry(
        "Painlevé limit", name, status,
        (f"D > 0 at every θ exactly for mu |vx| < {found.middle:.12g}{own}; D vanishes first at "
         f"θ = {found.theta:.6g}{found.approximation and f'; {found.approximation}'}.",),
        found.low, ("viscous friction; mu |vx| without unit",),
        refuters=(f"{FILE}::test_painleve_limits_are_the_least_values",),
    )  # fmt: skip
