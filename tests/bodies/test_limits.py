"""Limits of bodies with their orders: a torus with a thin tube, a spheroid that is nearly round."""

from collections.abc import Callable, Sequence

import numpy as np
import pytest
from scipy.optimize import linear_sum_assignment

import stability as st

SIZES = 2.0 ** -np.arange(7, 14)
"""Tubes, or aspects less 1, in which an order is fitted."""
FEW = SIZES[::3]
MU = 0.4
LAWS = {
    "viscous": st.Viscous(MU),
    "linear-viscous": st.LinearViscous(MU),
    "rough": st.Rough(),
    "smooth": st.Smooth(),
}

Spectrum = Callable[[float], np.ndarray]


def _moved(found: Spectrum, limit: Sequence[complex], size: float) -> np.ndarray:
    """Eigenvalues of a size less those of the limit that they belong to."""
    ours, known = found(size), np.asarray(limit, dtype=complex)
    assert ours.shape == known.shape
    far = np.abs(np.subtract.outer(ours, known))
    rows, columns = linear_sum_assignment(far)
    gaps = np.empty(len(known), dtype=complex)
    gaps[columns] = ours[rows] - known[columns]
    return gaps


def order(sizes: np.ndarray, gaps: Sequence[float]) -> float:
    """Exponent p of the best fit gap = C size^p."""
    return float(np.polyfit(np.log(sizes), np.log(gaps), 1)[0])


def _order(found: Spectrum, limit: Sequence[complex], sizes: np.ndarray) -> float:
    """At which the largest distance to the limit falls."""
    return order(sizes, [float(np.abs(_moved(found, limit, size)).max()) for size in sizes])


# --- a ring with a thin tube is a thin hoop ---


HOOP = [("rolling", 2.3), ("rolling", 0.2), ("spinning", 2.6), ("tumbling", 0.7), ("tumbling", 1.2)]


@pytest.mark.parametrize(
    ("family", "at", "law", "sizes"),
    [
        ("rolling", 2.3, "viscous", FEW),
        ("rolling", 0.2, "rough", FEW),
        ("spinning", 2.6, "linear-viscous", FEW),
        ("tumbling", 1.2, "smooth", FEW),
    ]
    + [pytest.param(*where, law, SIZES, marks=pytest.mark.long) for where in HOOP for law in LAWS],
)
def test_a_torus_becomes_the_hoop(family: str, at: float, law: str, sizes: np.ndarray) -> None:
    """A height sin θ + b, and moments that change with b²: first order, where h itself stands.

    Without friction upright motions hold h'' and moments alone: second order.
    """

    def ring(tube: float) -> np.ndarray:
        body = st.Torus(tube)
        return st.spectrum(family, at=at, body=body, contact=LAWS[law]).eigenvalues

    hoop = st.spectrum(family, at=at, disk=st.Disk(k=0.5), contact=LAWS[law])
    theory = 2 if law == "smooth" and family != "tumbling" else 1
    assert _order(ring, hoop.eigenvalues, sizes) == pytest.approx(theory, abs=0.02)


@pytest.mark.long
@pytest.mark.parametrize("solid", [True, False])
def test_eigenvalues_of_a_torus_move_at_the_rate_of_the_closed_forms(solid: bool) -> None:
    """With I1 = 1/2, I3 = 1, h = 1 + b and h'' = -1, moments to first order in b.

    Rolling: I1 (I1 + h²) λ² + h'' I1 + I3 (I3 + h²) w² = 0 without slip, and without friction
    I1² λ² + I1 h'' + I3² w² = 0.  Spinning: λ² + w² + h''/(I1 + h²) = 0, and with I1 alone.
    """

    def square(family: str, law: str) -> Spectrum:
        def of(tube: float) -> np.ndarray:
            found = st.spectrum(
                family, at=2.6, body=st.Torus(tube, solid=solid), contact=LAWS[law]
            ).eigenvalues
            assert found.shape == (2,)
            return found[:1] ** 2

        return of

    w2, half = 2.6**2, 0.5
    known = {  # λ² at b = 0, and its slope by b
        ("rolling", "rough"): (
            -(2 * w2 - half) / (half * 1.5),
            (2 * (2 * w2 - half) / 1.5 - 2 * w2) / (half * 1.5),
        ),
        ("spinning", "rough"): (-w2 + 1 / 1.5, -2 / 1.5**2),
        ("rolling", "smooth"): (-(w2 - half) / half**2, 0.0),
        ("spinning", "smooth"): (-w2 + 1 / half, 0.0),
    }
    for (family, law), (start, slope) in known.items():
        found = square(family, law)
        left = [abs(complex(found(b)[0]) - start - slope * b) for b in SIZES]
        assert order(SIZES, left) == pytest.approx(2, abs=0.02), (family, law)


# --- a spheroid that is nearly round is a ball ---

RATE, SLIP, TURN = 1.7, 3.5 * MU, 5**0.5
BALL = {
    # a ball keeps its angular velocity, but for the slip, which decays at the rate mu (1 + 5/2)
    ("rolling", "viscous"): [-SLIP, -SLIP, 1j * RATE, -1j * RATE],
    ("spinning", "viscous"): [-SLIP + 1j * RATE, -SLIP - 1j * RATE, 1j * RATE, -1j * RATE, 0],
    ("vertical", "viscous"): [-SLIP, -SLIP, 1j * RATE, -1j * RATE, 0, 0],
    ("rolling", "rough"): [1j * RATE, -1j * RATE],
    ("spinning", "rough"): [1j * RATE, -1j * RATE],
    ("rolling", "smooth"): [1j * RATE, -1j * RATE],
    ("spinning", "smooth"): [1j * RATE, -1j * RATE],
    # φ̇² of tumbling tends to 5 at every inclination: 2/I1 from h' = -2δ s c
    ("tumbling", "viscous"): [-SLIP + 1j * TURN, -SLIP - 1j * TURN, 1j * TURN, -1j * TURN, 0],
    ("tumbling", "rough"): [1j * TURN, -1j * TURN],
    ("tumbling", "smooth"): [1j * TURN, -1j * TURN],
}
"""Eigenvalues of a ball in the frames of the families, less the structural zeros."""


@pytest.mark.parametrize(
    ("family", "law", "side", "sizes"),
    [
        ("rolling", "viscous", 1, FEW),
        ("vertical", "viscous", -1, FEW),
        ("spinning", "rough", -1, FEW),
        ("tumbling", "smooth", 1, FEW),
    ]
    + [
        pytest.param(*where, side, SIZES, marks=pytest.mark.long)
        for where in BALL
        for side in (1, -1)
    ],
)
def test_a_spheroid_becomes_the_ball(family: str, law: str, side: int, sizes: np.ndarray) -> None:
    def spheroid(size: float) -> np.ndarray:
        body, at = st.Spheroid(1 + side * size), 0.9 if family == "tumbling" else RATE
        return st.spectrum(family, at=at, body=body, contact=LAWS[law]).eigenvalues

    assert _order(spheroid, BALL[family, law], sizes) == pytest.approx(1, abs=0.02)


@pytest.mark.parametrize("law", ["rough", "smooth"])
def test_eigenvalues_of_a_spheroid_move_at_the_rate_of_the_closed_forms(law: str) -> None:
    """With a = 1 + δ: I1 = (1 + a²)/5, I3 = 2/5, h = 1, h'' = a² - 1, so dI1 = 2δ/5, dh'' = 2δ."""
    w2, i = RATE**2, 0.4
    slopes = {
        # spinning: λ² = -w² - h''/(I1 + h²), and without friction -w² - h''/I1
        ("spinning", "rough"): -2 / 1.4,
        ("spinning", "smooth"): -2 / i,
        # rolling: λ² = -(h'' I1 + I3 (I3 + h²) w²)/(I1 (I1 + h²)) and -(I1 h'' + I3² w²)/I1²
        ("rolling", "rough"): -2 / 1.4 + w2 * i * (1 / i + 1 / 1.4),
        ("rolling", "smooth"): -2 / i + 2 * w2,
    }
    for family in ("spinning", "rolling"):
        slope = slopes[family, law]

        def left(size: float, family: str = family, slope: float = slope) -> float:
            body = st.Spheroid(1 + size)
            found = st.spectrum(family, at=RATE, body=body, contact=LAWS[law]).eigenvalues[0]
            return float(abs(complex(found) ** 2 + w2 - slope * size))

        assert order(SIZES, [left(s) for s in SIZES]) == pytest.approx(2, abs=0.02), family
