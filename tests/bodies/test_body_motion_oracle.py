"""Motions by the oracle of convex bodies: two integrators, integrals, and what is published."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Any

import body_profiles as bodies
import numpy as np
import pytest
from body_motion import Motion, move, quaternion, rotation
from body_references import SEEN, Reference, stored
from convex_body import Law, Pose, pose_at
from jets import UP, Array, cross
from random_bodies import BODIES, random_scene
from scipy.integrate import quad

STORED = stored()
QUICK = ("thick disk", "spheroid, through 0", "tippe top, through pi")
"""Motions that stay in the fast tests."""


@pytest.mark.parametrize(
    ("reference", "entry"),
    [
        pytest.param(r, e, id=r.name, marks=() if r.name in QUICK else pytest.mark.long)
        for r, e in STORED
    ],
)
def test_two_integrators_give_the_same_motion(reference: Reference, entry: dict[str, Any]) -> None:
    """DOP853 in doubles, and extrapolation with 25 digits; five of these cross a pole.

    The long motion magnifies the errors of DOP853, which fall with its tolerance: 2.9e-8, 2.5e-9
    and 2.1e-10 at 1e-11, 1e-12 and 1e-13.
    """
    bound = 1e-9 if entry["times"][-1] > 10 else 1e-11
    body, law = reference.body, reference.law
    given = [body.name, dict(body.parameters), body.axial, body.transverse]
    assert given == [entry[n] for n in ("body", "parameters", "axial", "transverse")]
    assert [law.name, law.coefficient] == [entry["law"], entry["coefficient"]]
    assert entry["name"] == reference.name
    assert entry["error"] < 1e-15
    motion = move(body, law, reference.start(), entry["times"])
    for name in SEEN:
        assert np.abs(getattr(motion, name) - entry[name]).max() <= bound
    assert motion.normal_force.min() > 0.2


def test_the_stored_motions_cross_the_poles() -> None:
    entries = [entry for _, entry in STORED]
    crossing = [e for e in entries if np.abs(e["axis"][:, :2]).max(axis=1).min() < 1e-15]
    assert [np.sign(e["axis"][2, 2]) for e in crossing] == [1, -1, 1, -1, 1]
    turning = next(e for e in entries if "turning over" in e["name"])
    assert turning["axis"][0, 2] > 0.99
    assert turning["axis"][-1, 2] < -0.99


def test_a_quaternion_is_read_back() -> None:
    rng = np.random.default_rng(0)
    for q in [*rng.normal(size=(20, 4)), *np.eye(4)]:
        assert rotation(quaternion(rotation(q))) == pytest.approx(rotation(q), abs=1e-15)


@pytest.mark.few(2)
@pytest.mark.parametrize("name", BODIES)
def test_energy_falls_by_the_power_of_the_contact(name: str) -> None:
    rng = np.random.default_rng(12)
    for law in ("smooth", "viscous", "linear-viscous", "rough"):
        scene = random_scene(rng, name, law, units=False)
        start = pose_at(scene.body, scene.state)
        motion = move(scene.body, scene.law, start, np.array([0, 0.02, 0.04]), 1e-12)
        assert motion.energy + motion.lost == pytest.approx(motion.energy[0], rel=1e-11)
        assert motion.gap == pytest.approx(0, abs=1e-11)
        if law in ("smooth", "rough"):
            assert motion.lost == pytest.approx(0, abs=1e-12)
        else:
            assert motion.lost[-1] > 0


def _pivoting(pose: Pose) -> tuple[Array, Array]:
    """A drag of air against the spin, and a pivoting moment for each normal force."""
    return -0.1 * pose.spin, -0.05 * np.array([0, 0, 1]) * pose.spin[2]


def test_moments_take_the_power_that_they_say() -> None:
    scene = random_scene(np.random.default_rng(1), "spheroid", "rough", units=False)
    law = replace(scene.law, moments=(_pivoting,))
    start, times = pose_at(scene.body, scene.state), np.linspace(0, 0.2, 3)
    motion = move(scene.body, law, start, times, 1e-12)
    assert motion.energy + motion.lost == pytest.approx(motion.energy[0], rel=1e-10)
    assert motion.lost[-1] > 1e-4
    free = move(scene.body, scene.law, start, times, 1e-12)
    assert np.abs(free.spin - motion.spin).max() > 1e-3


@pytest.mark.few(1)
@pytest.mark.parametrize("law", ["smooth", "viscous", "linear-viscous", "coulomb"])
def test_jelletts_integral_is_kept_for_a_sphere(law: str) -> None:
    """J. H. Jellett, Treatise on the theory of friction (1872); another body does not keep it."""
    contact = Law(law, 0.0 if law == "smooth" else 0.3)
    state, times = np.array([1.0, 0.5, 0.8, 4.0, 2.7, 1.8]), np.linspace(0, 1.0, 5)
    sphere = bodies.eccentric_sphere(0.3, 0.4, 0.375)
    motion = move(sphere, contact, pose_at(sphere, state), times, 1e-12)
    assert motion.jellett == pytest.approx(motion.jellett[0], abs=1e-11)
    oval = bodies.spheroid(1.0, 1.3, 0.4, 0.538)
    other = move(oval, contact, pose_at(oval, state), times, 1e-12)
    assert np.abs(other.jellett - other.jellett[0]).max() > 1e-4


def test_a_coulomb_contact_that_would_stick_is_refused() -> None:
    """The law has no direction without slip; a motion is not integrated past that."""
    sphere, state = bodies.eccentric_sphere(0.3, 0.4, 0.375), np.array([1, 0, 0, 0, 0.2, 0.0])
    with pytest.raises(ArithmeticError, match="begins to stick"):
        move(sphere, Law("coulomb", 0.5), pose_at(sphere, state), [0, 1.0], 1e-9)


# ------------------------------------------------------------------ gyroscopic eggs

TRANSVERSE, AXIAL, ALONG, FRICTION = 0.538, 0.4, 1.3, 0.1
"""A uniform prolate spheroid with semi-axes 1 and 1.3."""


def _rising(rate: float) -> tuple[Motion, Array]:
    """An egg in gyroscopic balance with its centre at rest; its inclinations."""
    body = bodies.spheroid(1.0, ALONG, AXIAL, TRANSVERSE)
    state = np.array([1.2, 0, rate, TRANSVERSE * rate * math.cos(1.2) / AXIAL, 0, 0])
    still = pose_at(body, state)
    state[4:] = cross(still.spin, still.arm)[:2]
    times = np.linspace(0, 24, 41)
    motion = move(body, Law("viscous", FRICTION), pose_at(body, state), times, 1e-8)
    return motion, np.arccos(motion.axis[:, 2])


def _time_to_rise(theta: float) -> float:
    """Time from 1.2 to theta by J theta_dot = -F h^2.

    The friction is F = mu m g v, and v the slip of a body in balance whose centre is at rest.
    """

    def pace(x: float) -> float:
        s, c = math.sin(x), math.cos(x)
        h = math.hypot(s, ALONG * c)
        side, excess = (1 - ALONG**2) * s * c / h, (TRANSVERSE / AXIAL - 1) * c
        slip = abs((1 + excess * c) * side + excess * s * h)
        return FRICTION * slip * h / TRANSVERSE

    return float(quad(lambda x: 1 / pace(x), theta, 1.2)[0])


@pytest.mark.long
def test_a_spinning_egg_rises_as_moffatt_and_shimomura_say() -> None:
    """Gyroscopic balance C n = A Omega cos theta and the Jellett constant A Omega h.

    H. K. Moffatt & Y. Shimomura, Nature 416 (2002) 385.  Both hold at large Omega; so does the
    rate of rise that follows from them.  What is left of them falls about with the
    square of Omega.
    """
    left = []
    for rate in (5.0, 10.0):
        motion, theta = _rising(rate)
        assert theta[-1] < 0.8
        drift = np.abs(motion.jellett / motion.jellett[0] - 1).max()
        spin = np.einsum("ij,ij->i", motion.spin, motion.axis)
        turning = (motion.spin @ UP - spin * np.cos(theta)) / np.sin(theta) ** 2
        balance = AXIAL * spin - TRANSVERSE * turning * np.cos(theta)
        pace = np.polyfit(motion.times, [_time_to_rise(t) for t in theta], 1)[0]
        left.append([drift, 1 - pace, np.abs(balance).max() / (AXIAL * rate)])
    drift, pace, _ = np.log2(np.array(left[0]) / np.array(left[1]))
    assert drift == pytest.approx(2, abs=0.3)
    assert pace == pytest.approx(2, abs=0.3)
    assert left[1][2] < 0.1
