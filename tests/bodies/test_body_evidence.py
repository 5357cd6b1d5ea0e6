"""Bodies by their heights, against the oracle that finds the contact point from the surface.

A lens, a cap that rolls on its rim, and a superellipsoid are in no list of the package: each is one
line here.
"""

import math
from collections.abc import Callable, Mapping

import casadi as ca
import convex_body as oracle
import mpmath as mp
import numpy as np
import pytest
import random_bodies

import stability as st
from stability.bodies.contact_laws import LAWS
from stability.bodies.round_body.equations import round_system
from stability.bodies.round_body.families import round_family
from stability.bodies.round_body.pole_equations import smooth_at

Given = Mapping[str, float]
Height = Callable[[ca.SX], ca.SX]


def _lens(g: Given, theta: float) -> tuple[Height, float, float]:
    radius, edge = g["radius"], g["angle"]
    offset = radius * math.cos(edge)
    if theta < edge:
        return (lambda t: radius - offset * ca.cos(t)), 0.0, edge
    if theta > math.pi - edge:
        return (lambda t: radius + offset * ca.cos(t)), math.pi - edge, math.pi
    return (lambda t: radius * math.sin(edge) * ca.sin(t)), edge, math.pi - edge


def _cap(g: Given, theta: float) -> tuple[Height, float, float]:
    radius, edge, centre = g["radius"], g["angle"], g["centre"]
    across, along = radius * math.sin(edge), radius * math.cos(edge) + centre
    if theta < edge:
        return (lambda t: radius + centre * ca.cos(t)), 0.0, edge
    return (lambda t: across * ca.sin(t) + along * ca.cos(t)), edge, math.pi


def _superellipsoid(g: Given, theta: float) -> tuple[Height, float, float]:
    a, b, q = g["across"], g["along"], g["power"] / (g["power"] - 1)
    side = math.copysign(1.0, math.cos(theta))
    low, high = (0.4, 1.2) if side > 0 else (math.pi - 1.2, math.pi - 0.4)
    return (lambda t: ((a * ca.sin(t)) ** q + (side * b * ca.cos(t)) ** q) ** (1 / q)), low, high


def _thick(g: Given, theta: float) -> tuple[Height, float, float]:
    side = math.copysign(g["half"], math.cos(theta))
    low, high = (0.0, math.pi / 2) if side > 0 else (math.pi / 2, math.pi)
    return (lambda t: g["radius"] * ca.sin(t) + side * ca.cos(t)), low, high


HEIGHTS: dict[str, Callable[[Given, float], tuple[Height, float, float]]] = {
    "torus": lambda g, _: ((lambda t: g["rim"] * ca.sin(t) + g["tube"]), 0.0, math.pi),
    "eccentric sphere": lambda g, _: (
        (lambda t: g["radius"] - g["offset"] * ca.cos(t)), 0.0, math.pi),
    "spheroid": lambda g, _: (
        (lambda t: ca.sqrt((g["across"] * ca.sin(t)) ** 2 + (g["along"] * ca.cos(t)) ** 2)), 0.0,
        math.pi),
    "thick disk": _thick, "lens": _lens, "cap": _cap, "superellipsoid": _superellipsoid,
}  # fmt: skip


TILTED = ("lens", "cap")
"""Bodies whose contact point the oracle finds only off the vertical."""


def ours(body: oracle.ConvexBody, theta: float) -> st.Body:
    """The same body by its height, in the range of θ around an inclination."""
    height, low, high = HEIGHTS[body.name](body.parameters, theta)
    return st.Body(
        height, axial=body.axial / body.mass, transverse=body.transverse / body.mass,
        mass=body.mass, gravity=body.gravity, between=(low, high), name=body.name,
    )  # fmt: skip


def _system(
    scene: random_bodies.BodyScene, theta: float, resistance: tuple[type[st.Resistance], ...] = ()
) -> tuple[st.System, list[float]]:
    law = LAWS[scene.law.name]
    given = tuple(p.name for p in law.parameters[:1])
    body = ours(scene.body, theta)
    system = round_system(body, law, given, physical=True, resistance=resistance)
    numbers = dict(body.given) | dict.fromkeys(given, scene.law.coefficient) | {
        r.coefficient: 0.05 for r in resistance}  # fmt: skip
    return system, [numbers[n] for n in system.parameters]


@pytest.mark.parametrize("law", LAWS)
@pytest.mark.parametrize("name", HEIGHTS)
def test_rates_and_forces_at_random_states(name: str, law: str) -> None:
    for scene in random_bodies.scenes(11, 12, name=name, law=law):
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
        assert force[2] == pytest.approx(response.force[2], rel=1e-12)
        if law != "smooth":
            assert force[:2] == pytest.approx(response.force[:2], abs=1e-12 * size)
            assert seen["energy"] == pytest.approx(frame.energy, rel=1e-13)


@pytest.mark.parametrize("kind", [st.RollingResistance, st.PivotingResistance, st.AirTorque])
@pytest.mark.parametrize("law", ["viscous", "rough"])
def test_resistance_at_random_states(kind: type[st.Resistance], law: str) -> None:
    """The oracle takes moments M0 + N M1 along fixed axes."""

    def moment(pose: oracle.Pose) -> tuple[np.ndarray, np.ndarray]:
        w, none = pose.spin, 0 * pose.spin
        flat = w * [1, 1, 0] if kind is st.RollingResistance else w * [0, 0, 1]
        return (-0.05 * w, none) if kind is st.AirTorque else (none, -0.05 * flat)

    for scene in random_bodies.scenes(12, 15, law=law):
        if scene.body.name not in HEIGHTS:
            continue
        loaded = oracle.Law(scene.law.name, scene.law.coefficient, (moment,))
        system, p = _system(scene, float(scene.state[0]), (kind,))
        x = scene.state[: len(system.states)]
        true = oracle.rates(scene.body, loaded, scene.state)[: len(x)]
        assert np.abs(system.rates(x, p) - true).max() < 1e-12 * (1 + np.abs(true).max())
        power = oracle.response_at(scene.body, loaded, scene.state).power
        assert system.observe(x, p)["power"] == pytest.approx(power, rel=1e-11, abs=1e-13)


@pytest.mark.parametrize("name", HEIGHTS)
def test_jacobians_at_random_states(name: str) -> None:
    for law in LAWS:
        [scene] = random_bodies.scenes(13, 1, name=name, law=law)
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


@pytest.mark.parametrize("law", LAWS)
@pytest.mark.parametrize("name", HEIGHTS)
def test_spectra_at_random_members_of_every_family(name: str, law: str) -> None:
    rng = np.random.default_rng(14)
    kind, met = LAWS[law], []
    given = tuple(p.name for p in kind.parameters[:1])
    for family in ("rolling", "spinning", "tumbling", "vertical"):
        for _ in range(3 if family == "tumbling" else 1):
            scene = random_bodies.random_scene(rng, name, law)
            body = ours(scene.body, float(scene.state[0]))
            if family == "vertical" and (not smooth_at(body, 1) or name in TILTED):
                continue
            low, high = body.between
            at = rng.uniform(low, high) if family == "tumbling" else rng.uniform(0.5, 4)
            numbers = dict(body.given) | dict.fromkeys(given, scene.law.coefficient)
            try:
                record = round_family(body, family, kind, given, physical=True)
                p = [numbers[n] for n in record.parameters]
                state = record.member([at], p)
                found = st.spectrum(record, at=at, **{n: numbers[n] for n in record.parameters})
            except st.StabilityError:
                continue
            n = len(state)
            full = np.concatenate([state, np.zeros(7 - n if family == "vertical" else 6 - n)])
            with mp.workdps(30):
                rates = oracle.axis_rates if family == "vertical" else oracle.rates
                matrix = oracle.jacobian(
                    lambda s, f=rates, b=scene.body, w=scene.law: f(b, w, s), full, 30
                )[:n, :n]
                true = oracle.spectrum(matrix)
            size = np.abs(true).max()
            gaps = [np.abs(true - value).min() for value in found.eigenvalues]
            close = np.abs(np.subtract.outer(found.eigenvalues, found.eigenvalues))
            close[np.diag_indices(len(close))] = np.inf
            if close.min() < 1e-3 * size:  # nearly equal eigenvalues need more digits of the member
                continue
            assert max(gaps) < 1e-11 * size, (family, at)
            met.append(family)
            break
    if name in ("torus", "spheroid"):
        assert {"rolling", "spinning"} <= set(met)
    assert met or name in ("superellipsoid", "cap", "thick disk", "eccentric sphere")
