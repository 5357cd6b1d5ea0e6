"""Datasets of launches in SI are those without dimension, scaled by the similarity of motions."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
import xarray

import stability as st
from tests.tools.similarity import powers, size

SCALES = (0.6, 0.04, 3.0)
"""Mass, length and gravity."""
START = {
    "theta": (1.3, "rad"),
    "theta_dot": (0.05, "rad/s"),
    "phi_dot": (0.4, "rad/s"),
    "omega3": (2.0, "rad/s"),
    "slip_x": (0.3, "m/s"),
    "slip_y": (-0.1, "m/s"),
}
RESISTANCES = {
    "none": (None, 0.0, "1"),
    "rolling": (st.RollingResistance, 0.02, "m"),
    "pivoting": (st.PivotingResistance, 0.02, "m"),
    "air": (st.AirTorque, 0.02, "N m"),
}
"""Class, coefficient, and its unit over a second."""
BODIES = {
    "disk": (st.Disk, "radius"),
    "torus": (st.Torus, "length"),
    "egg": (st.Spheroid, "length"),
}


def si(unit: str) -> float:
    return size(unit, *SCALES)


def launched(body: str, resistance: str, *, dimensionless: bool) -> xarray.Dataset:
    def one(unit: str) -> float:
        return 1.0 if dimensionless else si(unit)

    kind, length = BODIES[body]
    mass, size_, gravity = (1.0, 1.0, 1.0) if dimensionless else SCALES
    shape = {"torus": (0.3,), "egg": (1.4,)}.get(body, ())
    made: Any = kind(*shape, mass=mass, gravity=gravity, **{length: size_})
    start = {n: v * one(unit) for n, (v, unit) in START.items()}
    against, coefficient, unit = RESISTANCES[resistance]
    more: dict[str, Any] = {"pose": True}
    if against is not None:
        scale = 1.0 if dimensionless else si("s")
        for word in unit.split():
            scale *= one(word)
        more = {"resistance": against(coefficient * scale)}
    law = st.Viscous(0.8 * one("s/m"))
    return st.simulate(made, law, start, np.linspace(0, 3, 7) * one("s"), **more)


@pytest.mark.parametrize(
    ("body", "resistance"),
    [
        ("disk", "none"),
        ("torus", "none"),
        ("egg", "none"),
        ("torus", "rolling"),
        ("torus", "pivoting"),
        ("egg", "air"),
    ],
)
def test_every_series_has_the_size_of_its_unit(body: str, resistance: str) -> None:
    plain, scaled = (launched(body, resistance, dimensionless=d) for d in (True, False))
    seen = 0
    for name in {"time", *plain.data_vars} - {"event_state"}:
        unit = scaled[name].attrs.get("units", "1")
        if scaled[name].dtype.kind != "f" or "(" in unit or name.endswith("error"):
            continue
        powers(unit)  # a known one
        assert np.allclose(scaled[name] / si(unit), plain[name], rtol=1e-6, atol=1e-8), name
        seen += 1
    assert seen > 20
    states = [unit for _, unit in START.values()]
    assert np.allclose(scaled.start_state / [si(u) for u in states], plain.start_state)


@pytest.mark.parametrize("body", BODIES)
def test_fates_of_launches_are_similar(body: str) -> None:
    found = []
    for dimensionless in (True, False):
        rate, mu = (1.0, 0.8) if dimensionless else (si("rad/s"), 0.8 * si("s/m"))
        time = 1.0 if dimensionless else si("s")
        kind, length = BODIES[body]
        mass, size_, gravity = (1.0, 1.0, 1.0) if dimensionless else SCALES
        shape = {"torus": (0.3,), "egg": (1.4,)}.get(body, ())
        made: Any = kind(*shape, mass=mass, gravity=gravity, **{length: size_})
        thing = {"disk": made} if body == "disk" else {"body": made}
        found.append(
            st.basins(
                x=("omega3", 0.1 * rate, 4 * rate, 3),
                y=("theta", 1.2, 1.55, 2),
                horizon=40 * time,
                contact=st.Viscous(mu),
                **thing,
            )
        )
    plain, scaled = found
    assert (plain.outcome == scaled.outcome.values).all()
    assert (plain.family == scaled.family.values).all()
    words = plain.family.attrs["flag_meanings"].split()
    angles = np.array([w.startswith(("tumbling", "none")) for w in words])[plain.family.values]
    unit = np.where(angles, 1.0, si("rad/s"))
    assert np.allclose(scaled.member.values / unit, plain.member, rtol=1e-5, equal_nan=True)
    assert np.allclose(scaled.end_time.values / si("s"), plain.end_time, rtol=1e-6)
    assert scaled.end_time.attrs["units"] == "s"
