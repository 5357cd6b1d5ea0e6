"""Named bodies: heights and moments of inertia, from the bodies' surfaces alone."""

from collections.abc import Callable

import numpy as np
import pytest
from scipy.integrate import quad

import stability as st

Profile = Callable[[float], tuple[float, float]]


def _filled(profile: Profile, ends: tuple[float, float]) -> tuple[float, float, float]:
    """Axial, transverse moment and centre of a filled body, over its mass; z rises along it.

    Slices across the axis: a disk of radius r at z has moments r⁴/2 and r⁴/4 + r²z², over π.
    """

    def over(weight: Callable[[float, float], float]) -> float:
        def slope(u: float) -> float:
            r, z = profile(u)
            step = 1e-6
            rise = (profile(u + step)[1] - profile(u - step)[1]) / (2 * step)
            return weight(r, z) * rise

        return float(quad(slope, *ends, epsabs=1e-11, epsrel=1e-11, limit=200)[0])

    mass = over(lambda r, _: r**2)
    centre = over(lambda r, z: r**2 * z) / mass
    axial = over(lambda r, _: r**4 / 2) / mass
    across = over(lambda r, z: r**4 / 4 + r**2 * z**2) / mass - centre**2
    return axial, across, centre


def _lowest(profile: Profile, ends: tuple[float, float], theta: float, centre: float) -> float:
    """Largest depth of the surface below the centre: the support function by its definition."""
    u = np.linspace(*ends, 400001)
    r, z = profile(u)  # type: ignore[arg-type]
    return float(np.max(r * np.sin(theta) - (z - centre) * np.cos(theta)))


def test_spheroid() -> None:
    for aspect in (0.3, 1.0, 2.2):
        body = st.Spheroid(aspect)
        ends = -np.pi / 2, np.pi / 2

        def profile(u: float, a: float = aspect) -> tuple[float, float]:
            return np.cos(u), a * np.sin(u)

        axial, across, centre = _filled(profile, ends)
        assert body.moments() == pytest.approx((axial, across), rel=1e-8)
        for theta in (0.2, 1.0, 2.5):
            assert body.height_at(theta) == pytest.approx(
                _lowest(profile, ends, theta, centre), rel=1e-9
            )


@pytest.mark.parametrize("solid", [True, False])
def test_torus(solid: bool) -> None:
    tube = 0.3
    body = st.Torus(tube, solid=solid)

    def mean(weight: Callable[[float, float], float]) -> float:
        """Mean over the tube of a weight of (radius, z), with the element of volume or area."""

        def ring(part: float, u: float) -> float:
            r = 1 + part * np.cos(u)
            return r * part

        parts = np.linspace(0, tube, 1001)[1:] - tube / 2000 if solid else np.array([tube])
        u = np.linspace(0, 2 * np.pi, 201)[:-1]
        p, v = np.meshgrid(parts, u)
        share = ring(p, v)
        r, z = 1 + p * np.cos(v), p * np.sin(v)
        return float((share * weight(r, z)).sum() / share.sum())

    axial = mean(lambda r, _: r**2)
    across = mean(lambda r, z: r**2 / 2 + z**2)
    assert body.moments() == pytest.approx((axial, across), rel=1e-6)
    assert body.height_at(0.7) == pytest.approx(np.sin(0.7) + tube, rel=1e-15)


def test_thick_disk() -> None:
    thickness = 0.4
    body = st.ThickDisk(thickness)
    axial, across, _ = _filled(lambda u: (1.0, u), (-thickness / 2, thickness / 2))
    assert body.moments() == pytest.approx((axial, across), rel=1e-9)
    corners = np.array([[1.0, -thickness / 2], [1.0, thickness / 2]])
    for theta in (0.1, 0.9, 1.5):
        depth = corners @ [np.sin(theta), -np.cos(theta)]
        assert body.height_at(theta) == pytest.approx(depth.max(), rel=1e-14)


def test_eccentric_sphere_is_a_ball_with_a_point_of_mass_on_its_surface() -> None:
    for offset in (0.05, 0.4):
        ball, point = 1 - offset, offset  # masses; z up from the ball's centre, the point at -1
        centre = -point
        axial = 2 * ball / 5
        across = 2 * ball / 5 + ball * centre**2 + point * (-1 - centre) ** 2
        body = st.EccentricSphere(offset)
        assert body.moments() == pytest.approx((axial, across), rel=1e-14)
        assert body.height_at(0.0) == pytest.approx(1 - offset)  # the centre of mass lies lowest
    typed = st.EccentricSphere(0.1, axial=0.4, transverse=0.4)
    assert typed.moments() == (0.4, 0.4)


def test_limits_are_the_disk_and_the_ball() -> None:
    """A tube that vanishes leaves the hoop's moments; a spheroid with aspect 1 is a ball."""
    small = [st.Torus(b).moments() for b in (1e-3, 1e-4)]
    hoop = np.array([1.0, 0.5])
    gaps = [np.abs(np.array(m) - hoop).max() for m in small]
    assert gaps[1] / gaps[0] == pytest.approx(1e-2, rel=1e-6)  # of second order in the tube
    assert st.Spheroid(1.0).moments() == pytest.approx((0.4, 0.4))


@pytest.mark.parametrize(
    ("make", "words"),
    [
        (lambda: st.Torus(0.0), "tube of the torus is 0"),
        (lambda: st.Torus(1.5), r"tube of the torus is 1.5; it must lie in \(0, 1\]"),
        (lambda: st.EccentricSphere(1.0), "axial is 0"),
        (lambda: st.EccentricSphere(0.1, axial=0.4), "give both or none"),
        (lambda: st.Spheroid(-1), "aspect of the spheroid is -1"),
        (lambda: st.ThickDisk(0.1, radius=2.0), "'radius'.*mass, gravity, length"),
        (lambda: st.Torus(0.1, axial=0.5), "axial is given, but the body has its own"),
        (lambda: st.Body(lambda _: 1.0, axial=0.9, transverse=0.4), "axial above twice"),
        (lambda: st.Body(lambda _: -1.0, axial=0.4, transverse=0.4), "above the plane"),
        (
            lambda: st.Body(
                lambda theta: 1 + theta * 0 - 0.9 * np.cos(2 * theta), axial=0.4, transverse=0.4
            ),
            "height is",
        ),
        (lambda: st.Body(lambda _, e: e, axial=0.4, transverse=0.4), "no value at CasADi"),
        (
            lambda: st.Body(lambda _: 1.0, axial=0.4, transverse=0.4, shape={"at": 1.0}),
            "shape names 'at'",
        ),
        (
            lambda: st.Body(lambda _: 1.0, axial=0.4, transverse=0.4, between=(0.0, 4.0)),
            "between is",
        ),
    ],
)
def test_what_is_no_body_is_refused_in_a_sentence(make: Callable[[], object], words: str) -> None:
    with pytest.raises(st.StabilityError, match=words) as error:
        make()
    assert "\n" not in str(error.value)
