"""Labels of launches, and the borders of a map of them."""

from typing import Any

import casadi as ca
import numpy as np
import pytest
from scipy.integrate import solve_ivp

import stability as st
from stability.base.errors import ParameterError


def pendulum() -> tuple[Any, list[Any]]:
    x, c = ca.SX.sym("x", 2), ca.SX.sym("c")
    system = st.System(
        "pendulum",
        x,
        c,
        ca.vertcat(x[1], -ca.sin(x[0]) - c * x[1]),
        states=("angle", "rate"),
        parameters=("c",),
    )
    rests = [
        st.Family(system, f"turns {n:+d}", at=("c",), held={"angle": 2 * np.pi * n, "rate": 0.0})
        for n in (-2, -1, 0, 1, 2)
    ]
    return system, rests


def turns(angle: float, rate: float) -> int:
    """Number of whole turns after which a damped pendulum rests, by an independent integration."""
    end = solve_ivp(
        lambda _, y: [y[1], -np.sin(y[0]) - 0.3 * y[1]],
        (0, 90),
        [angle, rate],
        method="DOP853",
        rtol=1e-10,
        atol=1e-12,
    ).y[0, -1]
    return round(end / (2 * np.pi))


AXES = {"x": ("angle", -2.0, 2.0, 9), "y": ("rate", -3.5, 3.5, 9)}


@pytest.mark.long
def test_borders_of_a_map_separate_launches_that_end_apart() -> None:
    system, rests = pendulum()
    found = st.basins(system, held={"c": 0.3}, families=rests, horizon=120.0, levels=3, **AXES)
    assert set(found.outcome.values.ravel().tolist()) == {1}
    width = np.array(found.border_width)
    assert np.allclose(width, [0.5 / 8, 0.875 / 8])
    points = np.stack([found.border_angle.values, found.border_rate.values], axis=1)
    assert len(points) > 20 and found.border_launches < found.attrs["border_cells"][-1] * 8
    names = found.family.attrs["flag_meanings"].split()
    rng = np.random.default_rng(0)
    for i in rng.choice(len(points), 8, replace=False):
        sides = {names[int(found[f"border_family_{s}"][i])] for s in ("low", "high")}
        around = [turns(*(points[i] + width * d)) for d in ((-1, -1), (1, 1), (-1, 1), (1, -1))]
        assert sides <= {f"turns_{n:+d}" for n in around}
    # far from all borders an independent integration agrees with the map
    for i, j in ((4, 4), (0, 0), (8, 8), (2, 6)):
        asked = found.isel(rate=i, angle=j)
        expected = turns(float(asked.angle), float(asked.rate))
        assert names[int(asked.family)] == f"turns_{expected:+d}"


def middle_area(c: float, wide: float, high: float) -> float:
    """Area of the launches that do not turn over, in |angle| < wide and |rate| < high.

    They lie between the two trajectories that end on the saddles at ±π, each the other one turned.
    Both are graphs over the angle: rate' = -sin(angle) / rate - c, from the saddle's slope.
    """
    slope, off = (c + np.sqrt(c**2 + 4)) / 2, 1e-5
    upper = solve_ivp(
        lambda a, r: -np.sin(a) / r - c,
        (np.pi - off, -wide),
        [slope * off],
        method="DOP853",
        rtol=1e-11,
        atol=1e-13,
        dense_output=True,
    )
    at, weights = np.polynomial.legendre.leggauss(400)
    rates = np.minimum(upper.sol(wide * at)[0], high)
    return float(2 * wide * weights @ rates)


@pytest.mark.long
def test_shares_of_random_launches_hold_the_area_between_the_separatrices() -> None:
    system, rests = pendulum()
    spread = {"angle": st.Uniform(-2, 2), "rate": st.Uniform(-3.5, 3.5)}
    some = st.basins(
        system,
        held={"c": 0.3},
        families=rests,
        horizon=120.0,
        check=False,
        distribution=spread,
        count=3000,
        seed=4,
    )
    area = middle_area(0.3, 2.0, 3.5) / 28
    parts = [*some.family.values.reshape(20, 150), some.family.values]
    held, widths = [], []
    for part in parts:
        [middle] = [f for f in st.fractions(part) if f.label == 3]
        held.append(middle.low < area < middle.high)
        widths.append(middle.high - middle.low)
    assert held[-1] and widths[-1] < 0.04
    assert sum(held[:-1]) >= 16  # of 20 intervals of 95 %; fewer are rarer than 1 in 300
    assert not any(f.low < 1.1 * area < f.high for f in st.fractions(some.family.values))
    again = st.basins(
        system,
        held={"c": 0.3},
        families=rests,
        horizon=120.0,
        check=False,
        distribution=spread,
        count=200,
        seed=4,
        chunk=64,
    )
    assert (again.angle.values == some.angle.values[:200]).all()
    assert (again.family.values == some.family.values[:200]).all()


@pytest.mark.long
def test_a_smooth_border_has_the_exponent_one() -> None:
    system, rests = pendulum()
    ends = st.launch_labels(
        system,
        varied=("angle", "rate"),
        held={"c": 0.3},
        families=rests,
        horizon=120.0,
        check=False,
    )
    found = st.uncertainty_exponent(
        ends, [-2, -3.5], [2, 3.5], [0.004, 0.01, 0.025, 0.06], points=600, seed=1
    )
    assert found.interval[0] < 1.0 < found.interval[1] and found.interval[0] > 0.6


def test_the_smallest_shock_is_confirmed_by_an_independent_integration() -> None:
    system, rests = pendulum()
    ends = st.launch_labels(
        system,
        varied=("angle", "rate"),
        held={"c": 0.3},
        families=rests,
        horizon=120.0,
        check=False,
    )
    found = st.fatal_shock(ends, [0.5, 0.0], reach=4.0, budget=150, seed=2)
    assert found.found and turns(0.5, 0.0) == 0 != turns(*found.launch)
    inside = found.start + (found.launch - found.start) * found.inner / found.size
    assert turns(*inside) == 0
    for angle in np.linspace(0, 2 * np.pi, 6, endpoint=False):  # no ray is much shorter
        there = found.start + 0.9 * found.size * np.array([np.cos(angle), np.sin(angle)])
        assert turns(*there) == 0


def test_labels_refuse_what_they_cannot_read() -> None:
    with pytest.raises(ParameterError, match="give a list of names"):
        st.launch_labels(contact="viscous", mu=0.3, varied="theta", horizon=1.0)
    refused: list[tuple[dict[str, Any], str]] = [
        ({"horizon": -1.0}, "horizon is -1; give a last time above 0"),
        ({"tolerance": 1.0}, "tolerance is 1; give one from"),
        ({"check": "yes"}, "check is"),
        ({"workers": 0}, "workers is 0"),
    ]
    for wrong, words in refused:
        with pytest.raises(ParameterError, match=words):
            st.launch_labels(
                contact="viscous", mu=0.3, varied=("theta",), **({"horizon": 1.0} | wrong)
            )
    ends = st.launch_labels(contact="viscous", mu=0.3, varied=("theta",), horizon=1.0)
    with pytest.raises(ParameterError, match=r"give shape \(n, 1\): theta"):
        ends(np.zeros((2, 2)))
