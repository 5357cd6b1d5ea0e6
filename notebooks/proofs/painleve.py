"""Theorem: Painlevé's limit of disks in closed form."""

from __future__ import annotations

import sympy

from stability.derivation.characteristic import K

from .mechanics import vanishes
from .proof import Proof, Theorem


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
        ("tests/bodies/test_painleve_limit.py::test_painleve_limits_are_the_least_values",),
    )  # fmt: skip
