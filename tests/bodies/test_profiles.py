"""Bodies from their meridians: spheroids by closed forms, eggs by other integrals, refusals."""

import math
from dataclasses import replace
from typing import Any

import casadi as ca
import mpmath as mp
import numpy as np
import pytest
from body_profiles import solid
from body_surfaces import Arc, Profile
from convex_body import ConvexBody, Law, jacobian, pose_at, rates, spectrum
from jets import cos, half_turns, precise, sin
from scipy.integrate import quad

import stability as st


@pytest.mark.long
@pytest.mark.parametrize("aspect", [0.5, 1.0, 1.8])
def test_a_spheroid_from_its_meridian_is_the_spheroid(aspect: float) -> None:
    body = st.from_profile(lambda u: (np.sin(u), -aspect * np.cos(u)))
    known = st.Spheroid(aspect)
    assert body.error < 1e-9
    assert body.moments() == pytest.approx(known.moments(), rel=1e-13)
    theta = np.linspace(0.0, math.pi, 41)
    for slope, most in ((0, 1e-13), (1, 1e-11), (2, 1e-9)):
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

    The centre of mass is read from the body itself: at θ = 0 it stands on its blunt end.  `error`
    counts the slopes, whose rounding is that of the terms times n².
    """
    for tolerance, most in ((4e-13, 1e-11), (1e-16, 1e-13)):
        egg = st.Egg(taper, aspect=aspect, tolerance=tolerance)
        assert egg.error < 1e-9
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


@pytest.mark.parametrize(("taper", "aspect"), [(0.2, 1.3), (0.3, 0.4)])
def test_the_stated_error_holds_the_height_and_both_slopes(taper: float, aspect: float) -> None:
    """Against the contact point itself: h' is its distance, h + h'' the radius of curvature."""
    egg = st.Egg(taper, aspect=aspect)
    centre = float(egg.height_at(0.0)) - aspect
    for theta in (1e-3, 0.9, 2.0):
        with mp.workdps(30):
            a, t, s, c = mp.mpf(aspect), mp.mpf(taper), mp.sin(theta), mp.cos(theta)
            meridian = lambda u: (mp.sin(u) * (1 + t * mp.cos(u)), -a * mp.cos(u) - centre)  # noqa: B023, E731
            slopes = lambda u: (mp.cos(u) + t * mp.cos(2 * u), a * mp.sin(u))  # noqa: B023, E731
            rise = lambda u: slopes(u)[0] * s - slopes(u)[1] * c  # noqa: B023, E731
            u = mp.findroot(rise, (mp.mpf(10) ** -9, mp.pi - mp.mpf(10) ** -9), solver="anderson")
            (r, z), (dr, dz) = meridian(u), slopes(u)
            curving = dr * a * mp.cos(u) + dz * (mp.sin(u) + 2 * t * mp.sin(2 * u))
            radius = mp.hypot(dr, dz) ** 3 / curving
        h = r * s - z * c
        for slope, true in enumerate((h, r * c + z * s, radius - h)):
            assert abs(egg.height_at(theta, slope) - float(true)) < egg.error * (1 + aspect)


def _on_the_meridian(taper: float, aspect: float) -> ConvexBody:
    """The egg as its surface and the integrals of that, without a height."""

    def curve(u: Any) -> tuple[Any, Any]:
        s, c = sin(half_turns(u)), cos(half_turns(u))
        return c * (1 + taper * -s), aspect * s

    arc = Arc(curve, -0.5, 0.5)
    across, axial, centre = solid([arc])
    return ConvexBody("egg", {}, Profile([arc.shift(centre)]), axial, across)


def test_what_is_proved_of_an_egg_is_proved_of_its_fit() -> None:
    """The true egg's eigenvalues lie outside the proved discs, and within the stated error."""
    with mp.workdps(20):
        body, law = _on_the_meridian(mp.mpf(0.2), mp.mpf(1.3)), Law("viscous", mp.mpf(0.3))
        lever = lambda t: pose_at(body, precise([t, 0, 0, 0, 0, 0])).arm[0]  # noqa: E731
        theta = mp.findroot(lever, (1.78, 1.79), tol=1e-34)
        state = precise([theta, 0, 0, 1.3, 0, 0])
        true = spectrum(jacobian(lambda x: rates(body, law, x), state, 20), 20)
    true = true[abs(true) > 1e-6]
    egg = st.Egg(0.2)
    found = st.spectrum("rolling", at=1.3, body=egg, contact=st.Viscous(0.3), certify=True)
    gap = np.abs(np.sort_complex(found.eigenvalues) - true).max()
    assert found.radius.max() < 1e-15 < gap < 4 * egg.error
    fit = "for the fitted height of egg: it, its slopes and the moments are off by 5e-11, an"
    assert found.certified and fit in found.reason
    assert fit in found.to_xarray().approximation


def test_every_proof_about_a_fit_says_so_and_one_about_a_formula_does_not() -> None:
    """A user's table or fit too, by `error`."""
    fit = "for the fitted height of tabulated: it, its slopes and the moments are off by 1e-06, an"
    height = lambda t: ca.sin(t) + 0.2  # noqa: E731
    given = {"axial": 1.0, "transverse": 0.5}
    table, ring = (st.Body(height, **given, name="tabulated", error=e) for e in (1e-6, 0.0))
    asked = {"contact": st.Viscous(0.3)}
    for body, says in ((table, True), (ring, False)):
        sure = st.spectrum("rolling", at=1.8, body=body, certify=True, **asked)
        changes = st.boundaries("rolling", axis=("at", 0.1, 3, 9), body=body, **asked)
        chart = st.stability_map("rolling", x=("at", 1, 3, 4), y=("mu", 0.1, 2, 4), body=body)
        low = replace(body, height=lambda t: 1 - 0.3 * ca.cos(t), axial=0.4, transverse=0.4)
        start = {"theta": 0.02, "phi_dot": 0.5, "omega3": 0.5}
        run = st.simulate(low, asked["contact"], start, 50.0)
        evidence = str(run.evidence.item())
        assert "proved in ball arithmetic" in evidence
        texts = [sure.reason, repr(changes), changes.statement("at"), str(chart.attrs), evidence]
        texts += [run.attrs["source"], repr(st.painleve_limit(body))]
        assert [fit in str(text) for text in texts] == [says] * len(texts)


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
        (
            lambda: st.from_profile(
                lambda u: (np.sin(u) * (1 + 0.5 * np.cos(2 * u) ** 2), -np.cos(u))
            ),
            "convex|smooth",
        ),
        (lambda: st.from_profile(lambda u: (np.minimum(u, np.pi - u), u)), "no smooth|settle"),
        (lambda: st.Egg(0.9), r"taper is 0.9; it must lie in \[0, 0.4\]"),
        (lambda: st.Egg(0.1, aspect=-1), "aspect is -1"),
        (lambda: st.Egg(0.1, tolerance=1e-17), r"is 1e-17; it must lie in \[1e-16, 1e-09\]"),
        (lambda: st.Egg(0.1, radius=1), "'radius'"),
    ],
)
def test_what_is_no_smooth_convex_meridian_is_refused(make: object, words: str) -> None:
    with pytest.raises(st.StabilityError, match=words) as error:
        make()  # type: ignore[operator]
    assert "\n" not in str(error.value)
