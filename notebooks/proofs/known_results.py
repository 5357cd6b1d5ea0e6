"""Results of others, recovered from the theorems, each with what of its source was at hand.

`published` holds what the source prints, where that was at hand, and the status then says whether
it was recovered.  Everything else is recomputed.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import sympy

from stability.derivation.characteristic import COS, SIN

from .body_polynomials import (
    AXIAL,
    BEND,
    I1,
    I3,
    PHI,
    RADIUS,
    RHO,
    SLOPE,
    SPIN,
    H,
)
from .entry import Entry
from .mechanics import vanishes
from .pole.graph import RATE
from .pole.vertical import THRESHOLD, WITHOUT_SLIP
from .proof import BODY_TESTS, POLE_TESTS
from .rim import THRESHOLDS
from .steady_motions import MOMENT, jellett

Expr = Any
"""A SymPy expression; SymPy states no types."""
OFFSET, ASPECT = sympy.symbols("e a")
BALL = {1: {H: 1 - OFFSET, RHO: 1}, -1: {H: 1 + OFFSET, RHO: 1}}
"""Height and radius of curvature of a ball with its centre of mass e off its centre, by the pole:
1 upright, -1 inverted; radius 1."""
SPHEROID = {I1: (1 + ASPECT**2) / 5, I3: sympy.Rational(2, 5), H: ASPECT, RHO: 1 / ASPECT}
"""A solid spheroid on its end; radius of the equator 1, half of its axis a."""


def known_results() -> tuple[Callable[[], Entry], ...]:
    """Functions that make the statements, in order."""
    return (_inverted_top, _tippe_top, _ball_on_top, _rolling_coin, _rolling_hoop, _spinning_coin,
            _balance, _lying_egg, _standing_egg, _jellett)  # fmt: skip


def edge(values: dict[Expr, Expr], condition: Expr = THRESHOLD) -> Expr:
    """n² at which a condition of vertical spin, linear in it, vanishes.

    Examples
    --------
    >>> edge(SPHEROID)
    5*a**3
    """
    poly = sympy.Poly(sympy.expand(condition.subs(BEND, RHO - H).subs(values)), RATE)
    return sympy.factor(-poly.nth(0) / poly.nth(2))


def _agrees(holds: bool, words: str = "published; recovered as an identity") -> str:  # noqa: FBT001
    return words if holds else "not recovered"


# --- tops ---


def _inverted_top() -> Entry:
    square = (I3 * BALL[-1][H]) ** 2 * edge(BALL[-1])  # of Jellett's integral, I3 ω₃ (R + e)
    printed = I3 * OFFSET * (1 + OFFSET) ** 4 / (1 + OFFSET - I1 / I3)
    return Entry(
        "tippe top, inverted", _agrees(vanishes(square - printed)),
        ("Inverted vertical spin is stable for every mu where Jellett's integral exceeds the "
         "printed value, if I1 < I3 (1+α).",
         "The source gives this value as the one above which the minimum of an effective potential "
         "moves from θ near 0 to θ near π."),
        assumptions=("α = e/R; I1, I3 about the centre of mass; m, g, R as in the source",),
        refuters=("tests/bodies/test_threshold_sides.py"
                  "::test_a_tippe_top_turns_at_its_published_thresholds",),
        source="Rauch-Wojciechowski and Rutstam, SIGMA 10 (2014) 017; its abstract was at hand",
        published="λ_thres = √(m g R³ I3 α) (1+α)²/√(1+α-γ), γ = I1/I3",
    )  # fmt: skip


def _tippe_top() -> Entry:
    upright = OFFSET * (1 - OFFSET) ** 2 / (I1 - I3 * (1 - OFFSET))
    inverted = OFFSET * (1 + OFFSET) ** 2 / (I3 * (1 + OFFSET) - I1)
    holds = vanishes(edge(BALL[1]) - upright) and vanishes(edge(BALL[-1]) - inverted)
    return Entry(
        "tippe top, both ends", _agrees(holds, "recomputed; the source was not at hand"),
        ("Upright vertical spin of an eccentric ball is unstable above n² = m g e (R-e)²/"
         "(R (I1 - I3 (1 - e/R))), if I1 > I3 (1 - e/R).",
         "Inverted vertical spin is stable above n² = m g e (R+e)²/(R (I3 (1 + e/R) - I1)), if "
         "I1 < I3 (1 + e/R).", "Both hold for every mu."),
        assumptions=("viscous or linear viscous friction; e > 0",),
        refuters=("tests/bodies/test_pole_equations.py"
                  "::test_tippe_top_turns_over_by_its_known_thresholds",),
        source="Ebenfeld and Scheck, Ann. Phys. 243 (1995) 195, to whom these are ascribed; not at "
        "hand",
    )  # fmt: skip


def _ball_on_top() -> Entry:
    square = edge(BALL[-1], WITHOUT_SLIP)
    known = 4 * OFFSET * (I1 + (1 + OFFSET) ** 2) / (I3 + 1 + OFFSET) ** 2
    return Entry(
        "Routh's sphere",
        _agrees(vanishes(square - known), "recomputed; agrees with `table benchmarks`"),
        ("Without slip a ball of radius 1 with its centre of mass e above its centre spins "
         "neutrally about the vertical for n² > 4 e (I1 + (1+e)²)/(I3 + 1 + e)².",),
        assumptions=("m = g = R = 1",),
        refuters=(f"{POLE_TESTS}::test_rouths_sphere_has_the_value_of_the_benchmarks",),
        source="E. J. Routh, Dynamics of a System of Rigid Bodies, Advanced Part; not at hand",
    )  # fmt: skip


# --- hoop and coin ---


def _thin(law: str, family: str, rate: str, k: Expr) -> Expr:
    formula = THRESHOLDS[family, law, rate].subs({H: 1, BEND: -1})
    return formula.subs({I1: k, I3: 2 * k})


def _rolling_coin() -> Entry:
    value = _thin("rough", "rolling", "ω₃²", sympy.Rational(1, 4))
    holds = value == sympy.Rational(1, 3)
    return Entry(
        "rolling coin", _agrees(holds, "published; recovered exactly"),
        (f"Without slip the uniform disk rolls neutrally for ω₃² > {value} g/R.",),
        assumptions=("thin: h = sinθ",),
        refuters=("tests/bodies/test_threshold_sides.py"
                  "::test_coin_and_hoop_roll_above_their_published_speeds",),
        source="SymPy, test_rolling_disc of sympy/physics/mechanics/tests/test_kane.py; at hand. "
        "Encyclopaedia Britannica: not at hand",
        published="every eigenvalue is zero at u2 = 1/√3 for m = g = r = 1",
    )  # fmt: skip


def _rolling_hoop() -> Entry:
    value = _thin("rough", "rolling", "ω₃²", sympy.Rational(1, 2))
    holds = value == sympy.Rational(1, 4)
    return Entry(
        "rolling hoop",
        _agrees(holds, "recomputed; equals the value that is quoted from textbooks"),
        (f"Without slip the hoop rolls neutrally for ω₃² > {value} g/R.",),
        assumptions=("thin: h = sinθ",),
        refuters=("tests/bodies/test_threshold_sides.py"
                  "::test_coin_and_hoop_roll_above_their_published_speeds",),
        source="Encyclopaedia Britannica, and textbooks: not at hand; g/(4R) is known at second "
        "hand",
    )  # fmt: skip


def _spinning_coin() -> Entry:
    values = [_thin("rough", "spinning", "φ̇²", sympy.Rational(1, n)) for n in (2, 4)]
    return Entry(
        "spinning hoop and coin", "recomputed; no source was compared",
        (f"Without slip the hoop spins neutrally for φ̇² > {values[0]} g/R, the uniform disk for "
         f"φ̇² > {values[1]} g/R.",),
        assumptions=("thin: h = sinθ",),
    )  # fmt: skip


# --- eggs ---


def _balance() -> Entry:
    spin = sympy.solve(MOMENT, SPIN)[0]
    leading = sympy.limit(spin / PHI, PHI, sympy.oo)
    product = I1 * PHI * SIN * RADIUS + I1 * PHI * COS * AXIAL  # -L·a with I3 ω₃ = I1 φ̇ cosθ
    holds = (
        vanishes(leading - I1 * COS / I3)
        and vanishes(spin - leading * PHI + SLOPE / (I3 * PHI * SIN))
        and vanishes(product - I1 * PHI * H)
    )
    return Entry(
        "gyroscopic balance", _agrees(holds, "published; recovered for large φ̇"),
        ("Precession without friction has I3 ω₃ = I1 φ̇ cosθ - h′/(φ̇ sinθ): the printed balance, "
         "but for a term that falls like 1/φ̇.",
         "With the balance, Jellett's product -L·a is I1 φ̇ h."),
        assumptions=("C = I3, A = I1, n = ω₃, Ω = φ̇ in the source; m = g = 1",),
        refuters=("tests/bodies/test_body_motion_oracle.py"
                  "::test_a_spinning_egg_rises_as_moffatt_and_shimomura_say",),
        source="Moffatt and Shimomura, Nature 416 (2002) 385; its text up to eq. (7) was at hand, "
        "its condition (14) for spheroids was not",
        published="C n = A Ω cosθ (7)",
    )  # fmt: skip


def _lying_egg() -> Entry:
    return Entry(
        "the egg that rises",
        "proved here; agrees with the words of the source, which name no number",
        ("A uniform prolate spheroid that spins fast enough with its axis level is unstable with "
         "viscous friction: φ̇² > 5 g/R, R the radius of its equator.",),
        refuters=(f"{BODY_TESTS}::test_a_lying_spheroid_rises_above_the_same_number",),
        source="Moffatt, Shimomura and Branicki, Proc. R. Soc. A 460 (2004); its abstract was at "
        "hand",
        published="a uniform prolate spheroid in sufficiently rapid spinning motion with its axis "
        "horizontal is unstable",
    )  # fmt: skip


def _standing_egg() -> Entry:
    holds = vanishes(edge(SPHEROID) - 5 * ASPECT**3) and vanishes(
        THRESHOLD.subs(SPHEROID) - (ASPECT**2 - 1) * (RATE**2 - 5 * ASPECT**3) / (5 * ASPECT**2)
    )
    return Entry(
        "spheroids on their ends",
        _agrees(holds, "proved here; agrees with the words of the sources, which name no number"),
        ("A uniform prolate spheroid on its end is stable for n² > 5 a³ g/R, and unstable below; "
         "an oblate one is stable for n² < 5 a³ g/R, and unstable above, for every mu.",),
        assumptions=("R the radius of the equator, a R half of the axis; viscous or linear "
                     "viscous friction",),
        refuters=(f"{POLE_TESTS}::test_spheroids_on_their_ends_turn_at_the_same_number",),
        source="Moffatt and Shimomura, Nature 416 (2002) 385, and Moffatt, Shimomura and Branicki, "
        "Proc. R. Soc. A 460 (2004); first page and abstract were at hand",
        published="an oblate spheroid spun sufficiently rapidly with its axis vertical rises on "
        "its edge; a prolate one rises to the vertical",
    )  # fmt: skip


def _jellett() -> Entry:
    return Entry(
        "Jellett's integral",
        _agrees(jellett(), "proved; the well-known integral, whose source was not at hand"),
        ("For a ball whose centre of mass is off its centre, h = ρ - e cosθ, the product L·a is "
         "constant under every contact force; a leads from the centre of mass to the contact.",),
        assumptions=("identity of Euler's rows of the general graph",),
        source="J. H. Jellett, A Treatise on the Theory of Friction (1872); not at hand",
    )  # fmt: skip
