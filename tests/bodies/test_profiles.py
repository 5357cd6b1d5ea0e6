"""Bodies from their meridians: spheroids by closed forms, eggs by other integrals, refusals."""

import math

import mpmath as mp
import numpy as np
import pytest
from scipy.integrate import quad

import stability as st


@pytest.mark.long
@pytest.mark.parametrize("aspect", [0.5, 1.0, 1.8])
def test_a_spheroid_from_its_meridian_is_the_spheroid(aspect: float) -> None:
    body = st.from_profile(lambda u: (np.sin(u), -aspect * np.cos(u)))
    known = st.Spheroid(aspect)
    assert body.error < 1e-11
    assert body.moments() == pytest.approx(known.moments(), rel=1e-13)
    theta = np.linspace(0.0, math.pi, 41)
    for slope, most in ((0, 1e-12), (1, 1e-10), (2, 1e-8)):
        gap = np.abs(body.height_at(theta, slope) - known.height_at(theta, slope)).max()
        assert gap < most * (1 + aspect)
    family, at = ("tumbling", 0.8) if aspect < 1 else ("rolling", 1.3)
    for law in (st.Viscous(0.4), st.Rough()):
        pair = [st.spectrum(family, at=at, body=b, contact=law) for b in (body, known)]
        assert pair[0].eigenvalues == pytest.approx(pair[1].eigenvalues, abs=1e-8)


def test_an_egg_has_the_moments_of_its_slices() -> None:
    taper, aspect = 0.25, 1.4
    egg = st.Egg(taper, aspect=aspect)

    def over(weight: object) -> float:
        def slice_(u: float) -> float:
            r, z = math.sin(u) * (1 + taper * math.cos(u)), -aspect * math.cos(u)
            return weight(r, z) * aspect * math.sin(u)  # type: ignore[operator]

        return float(quad(slice_, 0, math.pi, epsabs=1e-14, epsrel=1e-13)[0])

    mass = over(lambda r, _: r**2)
    centre = over(lambda r, z: r**2 * z) / mass
    axial = over(lambda r, _: r**4 / 2) / mass
    across = over(lambda r, z: r**4 / 4 + r**2 * z**2) / mass - centre**2
    assert egg.moments() == pytest.approx((axial, across), rel=1e-12)
    u = np.linspace(0, math.pi, 2_000_001)
    r, z = np.sin(u) * (1 + taper * np.cos(u)), -aspect * np.cos(u) - centre
    for theta in (0.0, 0.7, 1.9, math.pi):
        depth = (r * math.sin(theta) - z * math.cos(theta)).max()
        assert egg.height_at(theta) == pytest.approx(depth, rel=1e-12)


@pytest.mark.long
@pytest.mark.parametrize(("taper", "aspect"), [(0.4, 1.3), (0.1, 3.0), (0.4, 2.0), (0.3, 0.4)])
def test_a_series_has_the_error_that_is_asked_for(taper: float, aspect: float) -> None:
    """Next to a pole too, where the contact point lies between the pole and the next sample.

    The centre of mass is read from the body itself: at θ = 0 it stands on its blunt end.
    """
    for tolerance, most in ((4e-13, 1e-11), (1e-16, 1e-13)):
        egg = st.Egg(taper, aspect=aspect, tolerance=tolerance)
        assert egg.error < most
        centre = float(egg.height_at(0.0)) - aspect
        for theta in (1e-4, 1e-3, 2e-3, 0.3, 2.0, math.pi - 1e-3):
            gap = _deepest(taper, aspect, centre, theta) - egg.height_at(theta)
            assert abs(gap) < most * (1 + aspect), theta


def _deepest(taper: float, aspect: float, centre: float, theta: float) -> float:
    """Depth of the lowest point of an egg's meridian, to 30 digits."""
    with mp.workdps(30):
        a, t, s, c = mp.mpf(aspect), mp.mpf(taper), mp.sin(theta), mp.cos(theta)

        def depth(u: mp.mpf) -> mp.mpf:
            return mp.sin(u) * (1 + t * mp.cos(u)) * s + (a * mp.cos(u) + centre) * c

        near = max(mp.linspace(0, mp.pi, 4001), key=depth)
        return float(depth(mp.findroot(lambda u: mp.diff(depth, u), near)))


def test_density_moves_the_centre_of_mass() -> None:
    """A ball with the density 1 + z/2: its centre lies at z = 1/10 (∫z² / ∫1 = 1/5)."""
    ball = st.from_profile(lambda u: (np.sin(u), -np.cos(u)), density=lambda _, z: 1 + z / 2)
    theta = np.linspace(0.1, 3.0, 7)
    assert ball.height_at(theta) == pytest.approx(1 + 0.1 * np.cos(theta), rel=1e-12)
    assert ball.moments() == pytest.approx((0.4, 0.4 - 0.01), rel=1e-12)


@pytest.mark.parametrize(
    ("make", "words"),
    [
        (lambda: st.from_profile(lambda u: (1 + 0 * u, u)), "both must be 0"),
        (lambda: st.from_profile(
            lambda u: (np.sin(u) * (1 + 0.5 * np.cos(2 * u) ** 2), -np.cos(u))), "convex|smooth"),
        (lambda: st.from_profile(lambda u: (np.minimum(u, np.pi - u), u)), "no smooth|settle"),
        (lambda: st.Egg(0.9), r"taper is 0.9; it must lie in \[0, 0.4\]"),
        (lambda: st.Egg(0.1, aspect=-1), "aspect is -1"),
        (lambda: st.Egg(0.1, tolerance=1e-17), r"is 1e-17; it must lie in \[1e-16, 1e-09\]"),
        (lambda: st.Egg(0.1, radius=1), "'radius'"),
    ],
)  # fmt: skip
def test_what_is_no_smooth_convex_meridian_is_refused(make: object, words: str) -> None:
    with pytest.raises(st.StabilityError, match=words) as error:
        make()  # type: ignore[operator]
    assert "\n" not in str(error.value)
