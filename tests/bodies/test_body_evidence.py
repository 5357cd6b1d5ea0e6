"""Bodies by their heights, against the oracle that finds the contact point from the surface.

A lens, a cap that rolls on its rim, and a superellipsoid are in no list of the package: each is one
line of `body_heights`.  The egg there is the package's series of cosines for a meridian.
"""

from typing import Any

import convex_body as oracle
import mpmath as mp
import numpy as np
import pytest
import random_bodies
from body_heights import HEIGHTS, by_height

import stability as st
from stability.bodies.contact_laws import LAWS
from stability.bodies.round_body.equations import round_system


def _system(
    scene: random_bodies.BodyScene, theta: float, resistance: tuple[type[st.Resistance], ...] = ()
) -> tuple[st.System, list[float]]:
    law = LAWS[scene.law.name]
    given = tuple(p.name for p in law.parameters[:1])
    body = by_height(scene.body, theta)
    system = round_system(body, law, given, physical=True, resistance=resistance)
    numbers = (
        dict(body.given)
        | dict.fromkeys(given, scene.law.coefficient)
        | {r.coefficient: 0.05 for r in resistance}
    )
    return system, [numbers[n] for n in system.parameters]


def _scenes(seed: int, count: int, **chosen: Any) -> list[random_bodies.BodyScene]:
    """Random scenes; of eggs those without flat sides, whose series have many terms."""
    found = random_bodies.scenes(seed, 3 * count, **chosen)
    plain = [s for s in found if s.body.name != "egg" or s.body.parameters["long"] < 0.1]
    assert len(plain) >= count
    return plain[:count]


@pytest.mark.few(8)
@pytest.mark.parametrize("law", LAWS)
@pytest.mark.parametrize("name", HEIGHTS)
@pytest.mark.parametrize("count", [2, pytest.param(12, marks=pytest.mark.long)])
def test_rates_and_forces_at_random_states(name: str, law: str, count: int) -> None:
    for scene in _scenes(11, count, name=name, law=law):
        theta = float(scene.state[0])
        if law == "smooth":
            scene.state[4:] = 0
        system, p = _system(scene, theta)
        x = scene.state[: len(system.states)]
        true = oracle.rates(scene.body, scene.law, scene.state)[: len(x)]
        size = 1 + np.abs(true).max()
        assert np.abs(system.rates(x, p) - true).max() < 1e-12 * size
        response = oracle.response_at(scene.body, scene.law, scene.state)
        seen = system.observe(x, p)
        force = np.array([*np.ravel(seen["contact_force"]), seen["normal_force"]])
        frame = oracle.pose_at(scene.body, scene.state)
        curved = 1e-12 * size if name == "egg" else 0.0  # its series rounds h'' by its square
        assert force[2] == pytest.approx(response.force[2], rel=1e-12, abs=curved)
        if law != "smooth":
            assert force[:2] == pytest.approx(response.force[:2], abs=1e-12 * size)
            assert seen["energy"] == pytest.approx(frame.energy, rel=1e-13)


@pytest.mark.few(3)
@pytest.mark.parametrize("count", [4, pytest.param(15, marks=pytest.mark.long)])
@pytest.mark.parametrize("kind", [st.RollingResistance, st.PivotingResistance, st.AirTorque])
@pytest.mark.parametrize("law", ["viscous", "rough"])
def test_resistance_at_random_states(kind: type[st.Resistance], law: str, count: int) -> None:
    """The oracle takes moments M0 + N M1 along fixed axes."""

    def moment(pose: oracle.Pose) -> tuple[np.ndarray, np.ndarray]:
        w, none = pose.spin, 0 * pose.spin
        flat = w * [1, 1, 0] if kind is st.RollingResistance else w * [0, 0, 1]
        return (-0.05 * w, none) if kind is st.AirTorque else (none, -0.05 * flat)

    for scene in _scenes(12, count, law=law):
        loaded = oracle.Law(scene.law.name, scene.law.coefficient, (moment,))
        system, p = _system(scene, float(scene.state[0]), (kind,))
        x = scene.state[: len(system.states)]
        true = oracle.rates(scene.body, loaded, scene.state)[: len(x)]
        assert np.abs(system.rates(x, p) - true).max() < 1e-12 * (1 + np.abs(true).max())
        power = oracle.response_at(scene.body, loaded, scene.state).power
        assert system.observe(x, p)["power"] == pytest.approx(power, rel=1e-11, abs=1e-13)


@pytest.mark.few(8)
@pytest.mark.parametrize("law", LAWS)
@pytest.mark.parametrize("name", HEIGHTS)
@pytest.mark.parametrize("count", [1, pytest.param(4, marks=pytest.mark.long)])
def test_jacobians_at_random_states(name: str, law: str, count: int) -> None:
    for scene in _scenes(13, count, name=name, law=law):
        if law == "smooth":
            scene.state[4:] = 0
        system, p = _system(scene, float(scene.state[0]))
        n = len(system.states)
        with mp.workdps(40):
            true = oracle.jacobian(
                lambda s, b=scene.body, w=scene.law: oracle.rates(b, w, s), scene.state, 40
            )[:n, :n]
        found = system.linearise(scene.state[:n], p)
        true = np.array(true, dtype=float)
        assert np.abs(found - true).max() < 1e-9 * (1 + np.abs(true).max())
