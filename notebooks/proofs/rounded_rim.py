"""Statements: how the thresholds of a coin move when its rim is rounded by a small radius ε."""

from __future__ import annotations

from fractions import Fraction

from .entry import Entry, written
from .proof import BODY_TESTS
from .rim import Shift, tumbling_formula, tumbling_shift

KEPT = "I1 = k, I3 = 2 k kept; m = g = R = 1"
TORUS = {
    "h = sinθ + ε": ("with k = 1/2 also the solid torus, whose moments change at ε²",),
    "h = (1-ε) sinθ + ε": (),
}
"""Further assumptions by the height."""
EXAMPLES = ((Fraction(1, 4), Fraction(6, 5)), (Fraction(1, 4), Fraction(1)),
            (Fraction(1, 2), Fraction(1)))  # fmt: skip
"""Inertia factors and inclinations of the numbers."""
DIGITS = 15


def shifted(found: Shift) -> Entry:
    """The statement on a threshold of upright motion."""
    return Entry(
        f"{found.family}, {found.law}, {found.quantity}, {found.rounded}",
        "exact, from the theorems",
        (f"{found.quantity.split()[0]} = {written(found.value)} + ε ({written(found.slope)}) "
         "+ O(ε²)",),
        assumptions=(KEPT, *TORUS[found.rounded]),
        refuters=(f"{BODY_TESTS}::test_thresholds_of_a_rounded_coin_move_at_the_printed_rate",),
    )  # fmt: skip


def tumbling(rounded: str) -> Entry:
    """The statement on the limit of mu² of tumbling."""
    found = tumbling_formula(rounded)
    named = zip("ABCE", (found.a, found.b, found.c, found.divisor), strict=True)
    degree = len(found.moved) - 1
    lines = [f"{name} = {written(e)}" for name, e in named]
    lines += [f"D{degree - i} = {written(e)}" for i, e in enumerate(found.moved)]
    for k, theta in EXAMPLES:
        pair = tumbling_shift(rounded, k, theta)
        at = f"k = {float(k)}, θ = {float(theta)}"
        if pair is None:
            lines.append(f"{at}: stable for every mu")
        else:
            value, slope = (x.str(DIGITS, radius=False) for x in pair)
            lines.append(f"{at}: mu² = {value} + ε ({slope}) + O(ε²)")
    return Entry(
        f"tumbling, viscous, mu², {rounded}",
        "exact, from the printed polynomial; numbers enclosed to their last digit but one",
        ("Tumbling of the coin is stable where A s² M² + B s M + C > 0, M = mu²: for every mu "
         "where A ≥ 0, and up to M = (B + √(B² - 4 A C))/(-2 A s) where A < 0.",
         "The limit is M + ε dM/dε + O(ε²), dM/dε = -2 (D2 M² + D1 M + D0)/"
         "(s E (2 A s² M + B s)).", *lines,
         "Without slip and without friction tumbling of a thin disk is neutral for every θ, so no "
         "threshold moves there."),
        assumptions=(KEPT, "0 < k ≤ 1/2"),
        refuters=(f"{BODY_TESTS}::test_tumbling_of_a_rounded_coin_moves_at_the_printed_rate",
                  f"{BODY_TESTS}::test_tumbling_of_a_rounded_coin_ends_at_the_limit_of_spinning"),
    )  # fmt: skip
