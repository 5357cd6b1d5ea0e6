"""Dry friction of bodies of revolution, also with resistances, against inertial axes.

The oracle knows the surface, and Newton's and Euler's laws along fixed axes.  It slides or is held:
where each begins and ends follows from the run, and is checked by slip and friction cone.
"""

import math
from itertools import pairwise
from typing import Any

import body_profiles as shapes
import numpy as np
import pytest
from body_motion import move
from convex_body import Law, pose_at, respond
from resisted import moments

import stability as st
from stability.bodies.model import Dry
from stability.bodies.round_body.models.angle_model import round_model
from stability.bodies.thin_disk import disk_model
from stability.integrators.stick_slip import continuations, suspects

STATES = ("theta", "theta_dot", "phi_dot", "omega3", "slip_x", "slip_y")
EVERY = (st.RollingResistance(0.03), st.PivotingResistance(0.05), st.AirTorque(0.02))
FAST = 2e-3
"""Slip speed down to which the oracle slides."""
SCENES: dict[str, tuple[Any, Any, Any, float, float, tuple[str, ...]]] = {
    "torus": (
        shapes.torus(1.0, 0.2, 1.03, 0.525),
        st.Torus(0.2),
        (1.3, 0.1, 0.4, 1.2, 0.1, -0.5),
        0.3,
        6.0,
        ("stick", "slip", "stick"),
    ),
    "sphere off its centre": (
        shapes.eccentric_sphere(0.2, 0.4, 0.4),
        st.EccentricSphere(0.2, axial=0.4, transverse=0.4),
        (1.3, 0.0, 0.3, 1.5, 0.0, 0.7),
        0.2,
        6.0,
        ("stick",),
    ),
    "thick disk in SI": (
        shapes.thick_disk(0.3, 0.03, 0.09, 0.0456, 2.0, 9.81),
        st.ThickDisk(0.2, mass=2.0, gravity=9.81, length=0.3),
        (1.2, 0.5, 2.0, 5.0, 0.4, 0.2),
        0.4,
        0.6,
        ("stick",),
    ),
}


@pytest.mark.few(2)
@pytest.mark.parametrize("which", [(), (0, 1, 2)], ids=["alone", "resisted"])
@pytest.mark.parametrize("scene", SCENES)
def test_motions_slide_and_stick_as_in_fixed_axes(scene: str, which: tuple[int, ...]) -> None:
    surface, body, start, mu, last, kinds = SCENES[scene]
    resistance = tuple(EVERY[i] for i in which)
    run = st.simulate(
        body,
        st.Coulomb(mu),
        start,
        np.linspace(0, last, 61),
        check=False,
        resistance=resistance or None,
        tolerance=1e-13,
    )
    found = np.stack([run[n].values for n in STATES], axis=-1)
    events = [
        (str(k), float(t))
        for k, t in zip(run.event_kind.values, run.event_time.values, strict=True)
    ]
    assert tuple(k for k, _ in events)[: len(kinds)] == kinds
    sliding = True
    for (_, begin), (kind, end) in pairwise([("start", 0.0), *events, ("end", last)]):
        there = (run.time.values >= begin) & (run.time.values <= end)
        fast = np.hypot(found[:, 4], found[:, 5]) > FAST * np.sqrt(surface.gravity)
        rows = np.flatnonzero(there & (fast if sliding else ~fast))
        name = "coulomb" if sliding else "rough"
        if len(rows) > 1:
            law = Law(name, mu, moments(resistance))
            times = run.time.values[rows] - run.time.values[rows[0]]
            true = move(surface, law, pose_at(surface, found[rows[0]]), times)
            assert np.abs(np.cos(found[rows, 0]) - true.axis[:, 2]).max() < 1e-8
            turn = np.sum(true.spin * true.axis, axis=1)
            assert np.abs(found[rows, 3] - turn).max() < 1e-8 * (1 + np.abs(turn).max())
            force = run.normal_force.values[rows]
            assert force == pytest.approx(true.normal_force, rel=1e-7)
        if not sliding and len(rows):
            assert (found[rows, 4:] == 0).all()
            for row in rows:
                held = respond(pose_at(surface, found[row]), Law("rough", 0, moments(resistance)))
                assert math.hypot(*held.force[:2]) <= mu * held.force[2] * (1 + 1e-7)
        sliding = {"stick": False, "slip": True, "reverse": True}.get(kind, sliding)
    assert float(run.energy_error) < 1e-9


def test_a_disk_is_the_body_of_its_height() -> None:
    start = {"theta": 1.4, "omega3": 2.0, "slip_x": 0.3, "slip_y": 0.5}
    disk = st.simulate(st.Disk(), st.Coulomb(0.2), start, 6.0, pose=True, check=False)
    # a resistance of zero leaves the motion as it is, and makes the disk a body
    body = st.simulate(
        st.Disk(), st.Coulomb(0.2), start, 6.0, pose=True, check=False, resistance=st.AirTorque(0.0)
    )
    assert body.event_time.values == pytest.approx(disk.event_time.values, abs=1e-9)
    for name in (*STATES, "force_x", "force_y", "phi", "centre_x", "centre_y"):
        assert np.abs(body[name].values - disk[name].values).max() < 1e-8, name


def dry_of(body: st.Body | None) -> Dry:
    model = (
        disk_model("coulomb")
        if body is None
        else (round_model(body, st.Coulomb, ("mu",), pose=False))
    )
    assert model.dry is not None
    return model.dry


@pytest.mark.parametrize("body", [None, st.Torus(0.3)], ids=["disk", "torus"])
def test_every_row_with_a_way_other_than_sticking_is_looked_at(body: st.Body | None) -> None:
    dry, rng = dry_of(body), np.random.default_rng(4)
    own = 0.3, *(body.moments() if body and "axial" in dry.held.parameters else ())
    several = 0
    for mu in (0.1, 0.8, 3.0, 10.0):
        rows = np.column_stack([rng.uniform(0.3, 2.8, 40), *rng.normal(0, 2, (3, 40))])
        p = np.array([*own, mu])
        looked = suspects(dry, rows, p)
        for row, one in zip(rows, looked, strict=True):
            ways = continuations(dry, row, p)
            several += bool(ways.directions) or ways.lifts
            assert one or not (ways.directions or ways.lifts)
    assert several > 20
