"""The oracle of convex bodies (tests/oracles/convex_body.py) against what is known without it.

Its thin disk is the package's disk and that of Kane's equations; its sphere has a closed form; its
two ways to a contact point (meridian, equation of the surface) and its two moments of inertia
(quadrature, textbook) agree; energy and Jellett's integral are kept.
"""

from __future__ import annotations

import math
from dataclasses import replace

import body_profiles as bodies
import kane_disk
import mpmath as mp
import numpy as np
import pytest
from body_surfaces import Arc, Implicit, Profile, Surface
from convex_body import (
    LAWS,
    Law,
    axis_pose,
    axis_rates,
    jacobian,
    pose_at,
    rates,
    respond,
    response_at,
    spectrum,
    state_of,
)
from jets import Array, cos, half_turns, plain, precise, sin
from random_bodies import BODIES, random_scene, scenes

import stability as st

DISK_LAWS = ("smooth", "viscous", "linear-viscous", "rough")


def _disk_states(law: str, count: int) -> list[tuple[Array, float, float]]:
    rng, found = np.random.default_rng(5), []
    while len(found) < count:
        x = rng.normal(size=6)
        x[0], k, mu = rng.uniform(0.3, 2.8), rng.uniform(0.2, 0.6), rng.uniform(0.05, 1)
        if law == "rough":
            x[4:] = 0
        if k + math.cos(x[0]) ** 2 - mu * x[4] * math.sin(2 * x[0]) / 2 > 0.1:
            found.append((x, k, mu))
    return found


@pytest.mark.parametrize(
    ("judge", "count"), [("fixed axes", 8), pytest.param("kane", 25, marks=pytest.mark.long)]
)
@pytest.mark.parametrize("law", DISK_LAWS)
def test_the_thin_rim_is_the_disk_of_the_package_and_of_kane(
    law: str, judge: str, count: int
) -> None:
    system = st.disk_system(law)
    n = len(system.states)
    for x, k, mu in _disk_states(law, count):
        body = bodies.thin_disk(k)
        with mp.workdps(30):
            ours = plain(rates(body, Law(law, mu), precise(x), 0.4, 1.1))
        theirs = system.rates(x[:n], [k, mu][: len(system.parameters)])
        known = kane_disk.ORACLES[judge](law, x, np.array([k, mu]))
        scale = np.abs(ours).max()
        assert np.abs(ours[:n] - theirs[:n]).max() <= 1e-12 * scale
        assert np.abs(ours - known.rates).max() <= 1e-11 * scale
        response = response_at(body, Law(law, mu), x)
        assert response.force[2] == pytest.approx(known.normal_force, rel=1e-11)
        assert response.power == pytest.approx(known.power, rel=1e-11, abs=1e-13)
        if law == "viscous":
            s, c = math.sin(x[0]), math.cos(x[0])
            strength = k + c * c - mu * x[4] * s * c
            assert k * response.compliance == pytest.approx(strength, rel=1e-12)


def test_the_coulomb_disk_is_that_of_the_package() -> None:
    system = st.disk_system("coulomb")
    for x, k, mu in _disk_states("viscous", 10):
        law = Law("coulomb", mu)
        if response_at(bodies.thin_disk(k), law, x).compliance < 0.1:
            continue
        ours = rates(bodies.thin_disk(k), law, x)
        assert np.abs(ours - system.rates(x, [k, mu])).max() <= 1e-12 * np.abs(ours).max()


def test_a_ball_slides_as_a_ball() -> None:
    """F at distance R below: slip' = F (1/m + R^2/I), w' = a x F/I."""
    radius, inertia, mass, gravity, mu = 0.7, 0.3, 1.5, 2.0, 0.4
    body = bodies.eccentric_sphere(0.0, inertia, inertia, radius, mass, gravity)
    x = np.array([1.1, 0.3, -0.8, 1.7, 0.5, -0.2])
    response = response_at(body, Law("viscous", mu), x)
    push = -mu * mass * gravity * x[4:]
    assert response.force == pytest.approx([*push, mass * gravity], abs=1e-14)
    assert response.slip_rate[:2] == pytest.approx(push * (1 / mass + radius**2 / inertia))
    assert response.spin_rate == pytest.approx(
        np.array([push[1], -push[0], 0]) * radius / inertia, abs=1e-14
    )


@pytest.mark.few(1)
@pytest.mark.parametrize("name", BODIES)
def test_doubles_agree_with_thirty_digits_at_any_yaw(name: str) -> None:
    for scene in scenes(11, 12, name=name):
        with mp.workdps(30):
            fine = plain(rates(scene.body, scene.law, precise(scene.state)))
        rough = rates(scene.body, scene.law, scene.state, 2.1, -0.6)
        assert np.abs(rough - fine).max() <= 1e-12 * np.abs(fine).max()


@pytest.mark.few(4)
@pytest.mark.parametrize("law", LAWS)
def test_the_rates_are_the_time_derivatives_of_the_coordinates(law: str) -> None:
    """A step along the accelerations in inertial axes, its coordinates read again, to 1e-12."""
    rng = np.random.default_rng(3)
    with mp.workdps(40):
        for _ in range(4):
            scene = random_scene(rng, law=law)
            body, step = scene.body, mp.mpf(10) ** -13
            pose = pose_at(body, precise(scene.state))
            response = respond(pose, scene.law)
            ends = []
            for h in (step, -step):
                spin, axis = pose.spin + response.spin_rate * h, pose.axis
                turned = axis + _cross(pose.spin, axis) * h
                slip = pose.slip + response.slip_rate * h
                values = np.array([*turned[:2], *spin, *slip[:2]])
                ends.append(state_of(axis_pose(body, values, 1 if axis[2] > 0 else -1)))
            slope = plain((ends[0] - ends[1]) / (2 * step))
            expected = plain(rates(body, scene.law, precise(scene.state)))
            assert np.abs(slope - expected).max() <= 1e-12 * np.abs(expected).max()


def _cross(a: Array, b: Array) -> Array:
    return np.array([a[i - 2] * b[i - 1] - a[i - 1] * b[i - 2] for i in range(3)])


@pytest.mark.parametrize("name", ["torus", "eccentric sphere", "spheroid", "egg", "superellipsoid"])
def test_meridian_and_equation_give_the_same_contact(name: str) -> None:
    for scene in scenes(2, 10, name=name):
        given, surface = scene.body.parameters, scene.body.surface
        other: Surface
        if name == "torus":
            other = bodies.implicit_torus(given["rim"], given["tube"])
        else:
            assert isinstance(surface, Implicit)
            other = Profile(surface.arcs)
        for azimuth in (0.3, 4.0):
            s, c = math.sin(scene.state[0]), math.cos(scene.state[0])
            up = np.array([-s * math.cos(azimuth), -s * math.sin(azimuth), c])
            (a, da), (b, db) = surface.contact(up), other.contact(up)
            across = np.eye(3) - np.outer(up, up)
            assert a == pytest.approx(b, abs=1e-13)
            assert np.abs((da - db) @ across).max() <= 1e-10


@pytest.mark.parametrize("name", BODIES)
def test_the_contact_is_the_lowest_point_and_its_slope_is_right(name: str) -> None:
    for scene in scenes(8, 2, name=name):
        pose = pose_at(scene.body, scene.state)
        surface = scene.body.surface
        for arc in surface.arcs:
            for t in np.linspace(0, 1, 301):
                r, z = arc.curve(float(arc.start) + (float(arc.end) - float(arc.start)) * t)
                s, c = math.sin(scene.state[0]), math.cos(scene.state[0])
                assert z * c - r * s >= pose.arm[2] - 1e-14
        with mp.workdps(40):
            up = np.array([precise(row) for row in pose.attitude.T])[:, 2]
            turn = precise([0.3, -0.7, 0.2])
            step = mp.mpf(10) ** -13
            move = _cross(turn, up)
            high, low = (surface.contact(up + move * h)[0] for h in (step, -step))
            slope = plain((high - low) / (2 * step))
            expected = plain(surface.contact(up)[1] @ move)
        assert slope == pytest.approx(expected, abs=1e-12 * max(1, np.abs(expected).max()))


def _tube(rim: float, tube: float) -> list[Arc]:
    def inner(u: object) -> tuple[object, object]:
        angle = half_turns(u)
        return rim - tube * cos(angle), -tube * sin(angle)

    return [bodies.circle(tube, rim), Arc(inner, -0.5, 0.5)]


@pytest.mark.long
def test_moments_by_quadrature_are_those_of_textbooks() -> None:
    """(I1/m, I3/m, centre), as in any handbook of mechanics."""
    r, a, h, c = 1.0, 0.25, 0.125, 1.5
    q = mp.mpf(1) / 4
    known = [
        (bodies.solid(_tube(r, a)), (mp.mpf(1) / 2 + 5 * q * q / 8, 1 + 3 * q * q / 4, 0)),
        (bodies.shell(_tube(r, a)), (mp.mpf(1) / 2 + 5 * q * q / 4, 1 + 3 * q * q / 2, 0)),
        (bodies.solid([bodies.ellipse(r, c)]), ((1 + mp.mpf(c) ** 2) / 5, mp.mpf(2) / 5, 0)),
        (bodies.shell([bodies.circle(r)]), (mp.mpf(2) / 3, mp.mpf(2) / 3, 0)),
        (bodies.solid(bodies.thick_disk_arcs(r, h)), (q + mp.mpf(h) ** 2 / 3, mp.mpf(1) / 2, 0)),
    ]
    for found, expected in known:
        assert plain(found) == pytest.approx(plain(expected), rel=1e-14, abs=1e-14)


def test_moments_of_a_half_ball_and_of_a_bowl() -> None:
    """Half ball: centre 3/8, I3 2/5, I1 83/320 about the centre; bowl: 1/2, 2/3, 5/12."""
    quarter = math.pi / 2
    half_ball = bodies.solid(bodies.cap_arcs(1.0, quarter))
    bowl = bodies.shell(bodies.cap_arcs(1.0, quarter)[:1])
    assert plain(half_ball) == pytest.approx([83 / 320, 2 / 5, -3 / 8], rel=1e-14)
    assert plain(bowl) == pytest.approx([5 / 12, 2 / 3, -1 / 2], rel=1e-14)


@pytest.mark.long
def test_moments_of_lens_and_superellipsoid() -> None:
    """A lens of two half balls is a ball; a superellipsoid's are Beta functions (Dirichlet)."""
    ball = bodies.solid(bodies.lens_arcs(1.3, math.pi / 2))
    assert plain(ball) == pytest.approx([0.4 * 1.69, 0.4 * 1.69, 0], rel=1e-13, abs=1e-14)
    a, b, p = 1.0, 0.75, 3.0
    found = bodies.solid([bodies.superellipse(a, b, p)])

    def part(i: float, j: float) -> float:
        """Integral of r^i |z|^j r dr dz over a quarter of |r|^p + |z|^p < 1, but for 1/p^2."""
        low, high = (i + 2) / p, (j + 1) / p
        return math.gamma(low) * math.gamma(high) / math.gamma(low + high + 1)

    axial = a**2 * part(2, 0) / part(0, 0)
    across = axial / 2 + b**2 * part(0, 2) / part(0, 0)
    assert plain(found) == pytest.approx([across, axial, 0], rel=1e-13, abs=1e-14)


def test_a_torus_tends_to_the_disk_in_first_order() -> None:
    x, law = np.array([1.0, 0.3, 0.5, -0.8, 0.2, 0.1]), Law("viscous", 0.3)
    thin = rates(bodies.thin_disk(0.5), law, x)
    tubes = 10.0 ** -np.arange(2, 6)
    gaps = [np.abs(rates(bodies.torus(1 - t, t, 1.0, 0.5), law, x) - thin).max() for t in tubes]
    orders = np.diff(np.log10(gaps)) / np.diff(np.log10(tubes))
    assert orders == pytest.approx(1, abs=0.05)


def test_every_scene_scales_with_its_units() -> None:
    """Lengths by a, masses by b, times by c; rates follow their dimensions."""
    a, b, c = 2.0, 0.5, 4.0
    scene = random_scene(np.random.default_rng(4), "spheroid", "linear-viscous")
    body, given = scene.body, scene.body.parameters
    larger = bodies.spheroid(
        a * given["across"],
        a * given["along"],
        b * a**2 * body.axial,
        b * a**2 * body.transverse,
        b * body.mass,
        a / c**2 * body.gravity,
    )
    power = np.array([0, 1, 1, 1, 1, 1])
    length = np.array([1, 1, 1, 1, a, a])
    x = scene.state * length / c**power
    slower = rates(larger, replace(scene.law, coefficient=scene.law.coefficient * b / c), x)
    assert slower == pytest.approx(rates(body, scene.law, scene.state) * length / c ** (power + 1))


@pytest.mark.few(1)
@pytest.mark.parametrize(
    ("alpha", "gamma"), [(0.3, 131 / 140), (0.15, 1.0), (0.5, 0.8), (0.4, 1.2)]
)
@pytest.mark.parametrize("mu", [0.3, 3.0])
def test_a_tippe_top_is_stable_where_the_literature_says(
    alpha: float, gamma: float, mu: float
) -> None:
    """Spinning about the vertical; gamma = I1/I3, the middle alpha R off the centre of mass.

    Inverted: stable above the threshold of S. Rauch-Wojciechowski & N. Rutstam, SIGMA 10 (2014)
    017, sqrt(m g R^3 I3 alpha) (1 + alpha)^2/sqrt(1 + alpha - gamma) for Jellett's integral
    I3 R (1 + alpha) w.  Upright: stable below the mirror image of this.  Both exist if
    1 - alpha < gamma < 1 + alpha, the condition of inversion that is quoted there.
    """
    m, radius, gravity = 0.02, 0.02, 9.82
    axial = 2 / 5 * m * radius**2
    body = bodies.eccentric_sphere(alpha * radius, axial, gamma * axial, radius, m, gravity)
    weight = m * gravity * radius * alpha / axial
    upright = math.sqrt(weight / (alpha + gamma - 1)) * (1 - alpha)
    inverted = math.sqrt(weight / (1 + alpha - gamma)) * (1 + alpha)
    if (alpha, gamma) == (0.3, 131 / 140):
        assert upright == pytest.approx(27.667917094780, rel=1e-13)
        assert inverted == pytest.approx(41.332688957659, rel=1e-13)
    for side, threshold, sign in ((1, upright, 1), (-1, inverted, -1)):
        for beyond in (-1e-6, 1e-6):
            w = threshold * (1 + beyond)
            assert np.sign(_abscissa(body, Law("viscous", mu), w, side)) == sign * np.sign(beyond)


def _abscissa(body: object, law: Law, w: float, side: int) -> float:
    matrix = jacobian(lambda y: axis_rates(body, law, y, side), [0, 0, 0, 0, w, 0, 0], 40)
    values = spectrum(matrix, 30)
    zero = np.argmin(np.abs(values))
    assert abs(values[zero]) < 1e-12
    return float(np.delete(values, zero).real.max())
