"""The nonlinear bicycle of `examples/nonlinear_bicycle.py` against published numbers."""

import runpy
from functools import lru_cache
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import casadi as ca
import mpmath
import numpy as np
import pytest

import stability as st

ROOT = Path(__file__).resolve().parents[2]


@lru_cache
def bicycle() -> Any:
    return SimpleNamespace(**runpy.run_path(str(ROOT / "examples" / "nonlinear_bicycle.py")))


@lru_cache
def running() -> st.Family:
    return bicycle().straight(bicycle().riding())


# P. Basu-Mandal, A. Chatterjee & J. M. Papadopoulos, Proc. R. Soc. A 463 (2007) 1983-2003, Table 1,
# as in DynamicistToolKit's functions basu_table_one_input and basu_table_one_output.
GIVEN = {
    "x": 0,
    "y": 0,
    "z": 0.2440472102925,
    "theta": 0,
    "psi": 0.9501292851472,
    "phi": 3.1257073014894,
    "psif": 0.2311385135743,
    "xd": -2.8069345714545,
    "yd": -0.1480982396001,
    "zd": 0.1058778746261,
    "thetad": 0.7830033527065,
    "psid": 0.6068425835418,
    "phid": -0.0119185528069,
    "psifd": 0.4859824687093,
    "betard": 8.9129896614890,
    "betafd": 8.0133620584155,
}
ACCELERATIONS = [
    -0.5041626315047,
    -0.3449706619454,
    -1.4604528332980,
    0.8353281706379,
    -7.8555281128244,
    0.1205543897884,
    -4.6198904039403,
    1.8472554144217,
    2.4548072904550,
]
SIGNS = np.array([-1, 1, -1, -1, -1, -1, -1, 1, 1])
"""From the paper's axes to x forward, y right, z down, with wheels that turn forwards."""


def published_state() -> tuple[Any, Any]:
    g = GIVEN
    turned = [-g["x"], g["y"], -g["z"], -g["theta"], np.pi / 2 - g["psi"], np.pi - g["phi"]]
    rates = [
        g[n] for n in ("xd", "yd", "zd", "thetad", "psid", "phid", "psifd", "betard", "betafd")
    ]
    return np.array([*turned, -g["psif"], 0.0, 0.0]), SIGNS * rates


@pytest.mark.few(1)
@pytest.mark.parametrize("pivots", [False, True])
def test_the_nine_published_accelerations(pivots: bool) -> None:
    b = bicycle()
    words = ("x", "y", "z", "front", "yaw", "pitch")
    stated = {str(i + 1): f"{w}_rate" for i, w in enumerate(words)} if pivots else None
    system = st.mechanics(b.q, b.u, b.p, **b.model(), pivots=stated)
    place, rates = published_state()
    values = list(b.VALUES.values())
    found = system.rates([*place, *rates], values)
    assert SIGNS * found[9:] == pytest.approx(ACCELERATIONS, abs=4e-11)
    seen = system.observe([*place, *rates], values)
    assert max(abs(float(v)) for n, v in seen.items() if n.startswith("residual")) < 1e-12


def test_independent_velocities_give_the_same_accelerations() -> None:
    b = bicycle()
    system = st.mechanics(
        b.q, b.u, b.p, **b.model(), independent=("lean_rate", "steer_rate", "rear_rate")
    )
    place, rates = published_state()
    seen = system.observe([*place, *rates[[4, 6, 7]]], list(b.VALUES.values()))
    found = system.rates([*place, *rates[[4, 6, 7]]], list(b.VALUES.values()))
    speeds = [float(seen[f"{n}_rate"]) for n in ("x", "y", "z", "yaw", "pitch", "front")]
    assert speeds == pytest.approx(rates[[0, 1, 2, 3, 5, 8]], abs=1e-12)
    turns = [float(seen[f"d_{n}_rate"]) for n in ("x", "y", "z", "yaw", "pitch", "front")]
    expected = SIGNS * ACCELERATIONS
    assert turns == pytest.approx(expected[[0, 1, 2, 3, 5, 8]], abs=4e-11)
    assert found[9:] == pytest.approx(expected[[4, 6, 7]], abs=4e-11)


@pytest.mark.long
def test_energy_is_kept_and_the_wheels_carry_the_weight() -> None:
    b = bicycle()
    system = running().system
    seen = system.observables
    rate = ca.Function(
        "rate", [system.x, system.p], [ca.jtimes(seen["energy"], system.x, system.rhs)]
    )
    x = np.random.default_rng(2).uniform(-0.3, 0.3, (5, 7)) + [-0.3, 0, 0, 0, 0, 0, 10]
    values = np.array(list(b.VALUES.values()))
    assert max(abs(float(rate(row, values))) for row in x) < 1e-9  # of some 1e4 W that come and go
    upright = system.observe([-0.3, 0, 0, 0, 0, 0, 10.0], values)
    v = b.VALUES
    weight = [v[f"m{n}"] * v["g"] for n in "RBHF"]
    on_front = sum(f * x for f, x in zip(weight, (0, v["xB"], v["xH"], v["w"]), strict=True))
    assert float(upright["multiplier_6"]) == pytest.approx(-on_front / v["w"], rel=1e-12)
    both = upright["multiplier_3"] + upright["multiplier_6"]
    assert float(both) == pytest.approx(-sum(weight), rel=1e-12)


# J. P. Meijaard, J. M. Papadopoulos, A. Ruina & A. L. Schwab, Proc. R. Soc. A 463 (2007), Table 1
MASS = [["80.81722", "2.31941332208709"], ["2.31941332208709", "0.29784188199686"]]
C1 = [["0", "33.86641391492494"], ["-0.85035641456978", "1.68540397397560"]]
K0 = [["-80.95", "-2.59951685249872"], ["-2.59951685249872", "-0.80329488458618"]]
K2 = [["0", "76.59734589573222"], ["0", "2.65431523794604"]]


def benchmark(speed: float) -> Any:
    """Roots of det(M λ² + v C₁ λ + g K₀ + v² K₂) to 40 digits, by real, then imaginary part."""
    with mpmath.workdps(40):
        mass, damp, still, fast = (mpmath.matrix(m) for m in (MASS, C1, K0, K2))
        v, g = mpmath.mpf(speed), mpmath.mpf("9.81")
        stiff = g * still + v * v * fast
        product = [mpmath.mpf(0)] * 5
        for sign, left, right in ((1, (0, 0), (1, 1)), (-1, (0, 1), (1, 0))):
            for i, a in enumerate((mass[left], v * damp[left], stiff[left])):
                for j, b in enumerate((mass[right], v * damp[right], stiff[right])):
                    product[i + j] += sign * a * b
        roots = mpmath.polyroots(product, maxsteps=200, extraprec=200)
        return np.array(sorted(map(complex, roots), key=lambda r: (round(r.real, 9), r.imag)))


@pytest.mark.few(2)
@pytest.mark.parametrize(("speed", "word"), [(3.0, "unstable"), (5.0, "stable"), (8.0, "unstable")])
def test_running_straight_has_the_spectrum_of_the_linear_benchmark(speed: float, word: str) -> None:
    """Three more zeros: the speed, and the heights of the two contacts."""
    found = st.spectrum(running(), at=speed / 0.3, **bicycle().VALUES)
    assert found.structural_zeros == 3
    assert abs(found.eigenvalues - benchmark(speed)).max() < 1e-10
    assert found.verdict.word == word


def test_default_pivots_do_not_vanish_where_the_bicycle_runs_straight() -> None:
    system = running().system
    values = list(bicycle().VALUES.values())
    seen = system.observe([-0.3, 0, 0, 0, 0, 0, 10.0], values)
    pivots = {n: float(v) for n, v in seen.items() if n.startswith("pivot")}
    assert len(pivots) >= 3
    assert min(pivots.values()) > 0.01
