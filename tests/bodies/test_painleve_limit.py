"""Painlevé's limit of mu |vx|: against another minimisation, closed forms, and the graph."""

from __future__ import annotations

import math

import casadi as ca
import numpy as np
import pytest
from scipy.optimize import minimize_scalar

import stability as st
from stability.bodies.contact_laws import LAWS
from stability.bodies.painleve import painleve_limit
from stability.bodies.round_body.equations import round_system

EGG = st.Body(
    lambda theta, a, b: 1 + a * ca.cos(theta) + b * ca.cos(2 * theta) + 0.01 * ca.cos(3 * theta),
    axial=0.3,
    transverse=0.4,
    shape={"a": 0.1, "b": 0.08},
    name="egg",
)


@pytest.mark.few(2)
@pytest.mark.parametrize(
    "body",
    [
        st.Torus(0.1),
        st.Torus(0.4, solid=False),
        st.Spheroid(0.5),
        st.Spheroid(1.8),
        st.EccentricSphere(0.3),
        EGG,
        st.Egg(0.2),
    ],
    ids=lambda b: b.name,
)
def test_painleve_limits_are_the_least_values(body: st.Body) -> None:
    found = painleve_limit(body)
    moment = body.moments()[1]

    def ratio(theta: float) -> float:
        h, slope = float(body.height_at(theta)), abs(float(body.height_at(theta, 1)))
        return math.inf if slope < 1e-12 else (moment + slope**2) / (h * slope)

    low, high = body.between
    grid = np.linspace(low, high, 400)[1:-1]
    best = min(grid, key=ratio)
    least = minimize_scalar(
        ratio, bounds=(best - 0.01, best + 0.01), method="bounded", options={"xatol": 1e-10}
    ).fun
    assert found.low <= found.high
    assert found.low == pytest.approx(least, rel=1e-11)
    assert (found.high - found.low) < 1e-12 * found.high


@pytest.mark.parametrize("whole", [False, pytest.param(True, marks=pytest.mark.long)])
def test_painleve_limits_of_disks_are_in_closed_form(whole: bool) -> None:
    for k in (0.25, 0.5):
        body = st.Body(lambda t: ca.sin(t), axial=2 * k, transverse=k)
        known = 2 * math.sqrt(k * (k + 1))
        found = painleve_limit(body)
        assert found.low <= known * (1 + 1e-15) and known * (1 - 1e-15) <= found.high
        assert found.middle == pytest.approx(known, rel=1e-13)
    if not whole:
        return
    for t in (0.2, 1.0, 4.0):
        kappa = (3 + t * t) / 12 / (1 + t * t / 4)
        found = painleve_limit(st.ThickDisk(t))
        assert found.middle == pytest.approx(2 * math.sqrt(kappa * (kappa + 1)), rel=1e-13)
    assert painleve_limit(st.Spheroid(1.0)).low > 1e5
    assert (
        painleve_limit(st.Body(lambda theta: 1 + 0 * theta, axial=0.4, transverse=0.4)).low
        == math.inf
    )
    with pytest.raises(st.StabilityError, match="one number"):
        painleve_limit(st.Torus([0.1, 0.2]))
    disk, body = (
        st.painleve_limit(st.Disk(k=0.5)),
        painleve_limit(st.Body(lambda t: ca.sin(t), axial=1.0, transverse=0.5)),
    )
    assert (disk.low, disk.high, disk.theta) == (body.low, body.high, body.theta)
    assert "przybylska2016" in disk.citation and "przybylska2016" in body.citation
    for wrong in ("egg", 0.25, None):
        with pytest.raises(st.StabilityError, match=r"give a stability\.Body or a"):
            st.painleve_limit(wrong)  # type: ignore[arg-type]


def test_the_determinant_of_the_graph_vanishes_at_the_limit() -> None:
    body = st.Torus(0.2)
    found = painleve_limit(body)
    system = round_system(body, LAWS["viscous"], ("mu",), physical=False)
    p = [{"tube": 0.2, "mu": 1.0}[n] for n in system.parameters]
    slip = math.copysign(found.middle, math.cos(found.theta))
    for share, good in ((1 - 1e-6, True), (1 + 1e-6, False)):
        state = [found.theta, 0.0, 0.3, 0.2, share * slip, 0.0]
        if good:
            assert system.observe(state, p)["determinant"] > 0
        else:
            with pytest.raises(st.StabilityError, match="D = "):
                system.observe(state, p)
