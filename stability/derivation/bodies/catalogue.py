"""Every statement about bodies of revolution, with what stands behind it."""

from __future__ import annotations

import re
from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from typing import Any

import casadi as ca
import sympy

from ...bodies.round_body.body import Body
from ...bodies.round_body.shapes.named import EccentricSphere, Spheroid, ThickDisk, Torus
from ...bodies.thin_disk.disk_quantities import QUANTITIES
from ..characteristic import K
from ..proof import Proof, Step, Theorem
from .completeness import branches, jellett, rough_and_smooth, steady_motions
from .graph import I1, H, vanishes
from .painleve import painleve_limit
from .polynomials import LAWS, STATES, characteristic
from .rim import INCLINED, THRESHOLDS, Shift, shifts, tumbling_shift
from .rolling import FILE, rolling_conservative, rolling_viscous
from .spinning import spinning_conservative, spinning_low, spinning_viscous
from .tumbling import energy_decides, tumbling_static

PROOFS: dict[str, Callable[[], Theorem]] = {
    "steady-motions": steady_motions,
    "rough-smooth": rough_and_smooth,
    "branches": branches,
    "rolling-conservative": rolling_conservative,
    "rolling-viscous": rolling_viscous,
    "spinning-conservative": spinning_conservative,
    "spinning-viscous": spinning_viscous,
    "spinning-low": spinning_low,
    "tumbling-static": tumbling_static,
    "energy": energy_decides,
    "painleve": lambda: painleve(),
}
"""Functions that prove a theorem about every body, in the order of the table."""
PARTS = ("theorem", "polynomial", "known result", "rounded rim", "Painlevé limit")
"""Parts of the table."""
_SUPER = str.maketrans("0123456789", "⁰¹²³⁴⁵⁶⁷⁸⁹")
_NAMES = {n: QUANTITIES[n].symbol for n in ("phi_dot", "omega3")} | {"lam": "λ"}


@dataclass(frozen=True)
class Entry:
    """One statement."""

    part: str
    """One of `PARTS`."""
    name: str
    """Short name."""
    status: str
    """What stands behind it: proved, derived, recomputed, enclosed."""
    statement: tuple[str, ...]
    """Sentences or formulas."""
    limit: float | None = None
    """Painlevé's limit of mu |vx|, the proved lower end."""
    assumptions: tuple[str, ...] = ()
    """Assumptions."""
    steps: tuple[Step, ...] = ()
    """Steps of a proof as checked."""
    refuters: tuple[str, ...] = ()
    """Tests that try to refute it."""


def written(expression: Any) -> str:
    """An expression of SymPy in the letters of the table.

    Parameters
    ----------
    expression
        The expression.

    Examples
    --------
    >>> written(I1 * H**2 - 1)
    'I1 h² - 1'
    """
    text = str(expression)
    text = re.sub(r"\*\*(\d+)", lambda m: m[1].translate(_SUPER), text)
    for name, letter in _NAMES.items():
        text = text.replace(name, letter)
    return text.replace("*", " ")


def entries(progress: Callable[[int, int], None] | None = None) -> tuple[Entry, ...]:
    """Every statement, derived and proved again.

    Parameters
    ----------
    progress
        Called with (statements done, statements in all).

    Returns
    -------
    tuple of Entry
    """
    made: list[Callable[[], Entry]] = [partial(_theorem, prove) for prove in PROOFS.values()]
    made += [partial(_polynomial, f, law) for f in STATES for law in LAWS]
    made += [_rolling_coin, _spinning_coin, _spheroid, _jellett]
    made += [partial(_rim, shift) for shift in shifts()]
    made += [partial(_rim_tumbling, rounded) for rounded in INCLINED]
    made += [partial(_limit, *b) for b in _bodies()]
    out = []
    for done, make in enumerate(made, start=1):
        out.append(make())
        if progress:
            progress(done, len(made))
    return tuple(out)


def _theorem(prove: Callable[[], Theorem]) -> Entry:
    t = prove()
    status = "proved" if t.proved else "not proved: a conjecture"
    return Entry("theorem", t.name, status, t.statement, None, t.assumptions, t.steps, t.refuters)


def _polynomial(family: str, law: str) -> Entry:
    found = characteristic(family, law)
    degree = len(found.coefficients) - 1
    lines = tuple(
        f"λ{str(degree - i).translate(_SUPER)}: {written(c)}"
        for i, c in enumerate(found.coefficients)
        if c != 0
    )
    where = {
        "rolling": "h′ = 0; s = sinθ",
        "spinning": "θ = π/2, h′ = 0",
        "tumbling": "φ̇² s (I1 r c - I3 z s) = h′ r, ω₃ = φ̇ s z/r; h = r s + z c, "
        "h′ = r c - z s, ρ = h + h′′",
    }[family]
    return Entry(
        "polynomial", f"{family}, {law}", "derived from the general graph",
        (f"λ = 0 with multiplicity {found.zeros}; the other eigenvalues are roots of the "
         "polynomial with coefficients", *lines),
        assumptions=(where, "m = g = 1"),
        refuters=(f"{FILE}::test_polynomials_have_the_eigenvalues_of_the_spectrum",),
    )  # fmt: skip


# --- known results ---


def _rolling_coin() -> Entry:
    formula = THRESHOLDS["rolling", "rough", "ω₃²"].subs({H: 1, sympy.Symbol("h′′"): -1})
    values = [formula.subs({I1: k, sympy.Symbol("I3"): 2 * k})
              for k in (sympy.Rational(1, 2), sympy.Rational(1, 4))]  # fmt: skip
    return Entry(
        "known result", "rolling hoop and coin", "recomputed; agrees with the textbook values",
        (f"Without slip the hoop rolls stably for ω₃² > {values[0]} g/R, the uniform disk for "
         f"ω₃² > {values[1]} g/R.",),
        assumptions=("thin: h = sinθ; textbook values g/(4R) and g/(3R)",),
    )  # fmt: skip


def _spinning_coin() -> Entry:
    formula = THRESHOLDS["spinning", "rough", "φ̇²"].subs({H: 1, sympy.Symbol("h′′"): -1})
    values = [formula.subs(I1, k) for k in (sympy.Rational(1, 2), sympy.Rational(1, 4))]
    return Entry(
        "known result", "spinning hoop and coin", "recomputed; no source was compared",
        (f"Without slip the hoop spins stably for φ̇² > {values[0]} g/R, the uniform disk for "
         f"φ̇² > {values[1]} g/R.",),
        assumptions=("thin: h = sinθ",),
    )  # fmt: skip


def _spheroid() -> Entry:
    return Entry(
        "known result", "the egg that rises",
        "proved here; agrees with the abstract of the source, which names no number",
        ("A uniform prolate spheroid that spins fast enough with its axis level is unstable with "
         "viscous friction: φ̇² > 5 g/R, R the radius of its equator.",),
        assumptions=("Moffatt, Shimomura and Branicki, Proc. R. Soc. A 460 (2004)",),
        refuters=(f"{FILE}::test_a_lying_spheroid_rises_above_the_same_number",),
    )  # fmt: skip


def _jellett() -> Entry:
    status = "proved; agrees with the well-known integral" if jellett() else "not proved"
    return Entry(
        "known result", "Jellett's integral", status,
        ("For a ball whose centre of mass is off its centre, h = ρ - e cosθ, the product L·a is "
         "constant under every contact force; a leads from the centre of mass to the contact.",),
        assumptions=("identity of Euler's rows of the general graph",),
    )  # fmt: skip


# --- a rounded rim ---


TORUS = {
    "h = sinθ + ε": ("with k = 1/2 also the solid torus, whose moments change at ε²",),
    "h = (1-ε) sinθ + ε": (),
}
"""Further assumptions by the height."""


def _rim(found: Shift) -> Entry:
    return Entry(
        "rounded rim", f"{found.family}, {found.law}, {found.quantity}, {found.rounded}",
        "exact, from the theorems",
        (f"{found.quantity.split()[0]} = {written(found.value)} + ε ({written(found.slope)}) "
         "+ O(ε²)",),
        assumptions=("I1 = k, I3 = 2 k kept; m = g = R = 1", *TORUS[found.rounded]),
        refuters=(f"{FILE}::test_thresholds_of_a_rounded_coin_move_at_the_printed_rate",),
    )  # fmt: skip


def _rim_tumbling(rounded: str) -> Entry:
    lines = []
    for k, theta in ((0.25, 1.2), (0.25, 1.0), (0.5, 1.0)):
        for value, slope in tumbling_shift(rounded, k, theta):
            lines.append(f"k = {k}, θ = {theta}: mu² = {value:.10g} + ε ({slope:.10g}) + O(ε²)")
    return Entry(
        "rounded rim", f"tumbling, viscous, mu², {rounded}",
        "roots in double precision of exact polynomials",
        (*lines, "Without slip and without friction tumbling of a thin disk is neutral for every "
         "θ, so no threshold moves there."),
        assumptions=("I1 = k, I3 = 2 k kept; m = g = R = 1",),
        refuters=(f"{FILE}::test_tumbling_of_a_rounded_coin_moves_at_the_printed_rate",),
    )  # fmt: skip


# --- Painlevé ---


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


def _bodies() -> list[tuple[str, Body, str]]:
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
    ]  # fmt: skip


def _limit(name: str, body: Body, closed: str) -> Entry:
    found = painleve_limit(body)
    status = "enclosed, and in closed form" if closed else "enclosed"
    own = f", {closed}" if closed else ""
    return Entry(
        "Painlevé limit", name, status,
        (f"D > 0 at every θ exactly for mu |vx| < {found.middle:.12g}{own}; D vanishes first at "
         f"θ = {found.theta:.6g}.",),
        found.low, ("viscous friction; mu |vx| without unit",),
        refuters=(f"{FILE}::test_painleve_limits_are_the_least_values",),
    )  # fmt: skip
