"""Where a body rolls at several inclinations, each answer is about the one that is meant."""

import numpy as np
import pytest
from edged_body import EDGE, curvature, edged, slope, zeros

import stability as st
from stability.bodies.contact_laws import Rough, Viscous
from stability.bodies.round_body.inclinations import levels, start
from stability.spectra.problem import formulas_of


def neutral(theta: float, bend: float, omega3: float) -> bool:
    """The condition of rolling without slip at any inclination, I₁ = 0.3 and I₃ = 0.5."""
    s, c = np.sin(theta), np.cos(theta)
    h = s + bend * np.sqrt(c * c + EDGE) - 0.05 * c
    bent = curvature(theta, bend)
    q = 0.3 * 0.5 + h * h * (0.3 * s * s + 0.5 * c * c)
    return bool(bent * q + 0.5 * (0.5 + h * h) * (0.5 + h * h + h * bent * c * c) * omega3**2 > 0)


@pytest.mark.long
@pytest.mark.parametrize(
    ("edge", "law"),
    [(1e-4, Rough()), (9e-4, Rough()), (1e-2, st.Smooth()), (9e-4, Viscous(0.3))],
)
def test_the_inclination_that_is_meant_is_the_one_that_is_judged(edge: float, law: object) -> None:
    body = edged(edge)
    for at in zeros(0.25, edge):
        found = st.spectrum("rolling", at=0.3, body=body, contact=law, theta=at, certify=True)
        assert found.states[0] == pytest.approx(at, abs=1e-12)
        near = st.spectrum("rolling", at=0.3, body=body, contact=law, theta=round(at, 2))
        assert near.states[0] == pytest.approx(at, abs=1e-12)


def test_verdicts_boundaries_and_maps_are_about_that_inclination() -> None:
    body = edged()
    known = zeros(0.25)
    assert len(known) == 3
    for at in known:
        found = st.spectrum("rolling", at=0.3, body=body, contact=Rough(), theta=at, certify=True)
        assert (found.verdict is st.Verdict.NEUTRAL) == neutral(at, 0.25, 0.3)
        chart = st.stability_map(
            "rolling",
            x=("omega3", 0.1, 3.0, 8),
            y=("bend", 0.2, 0.3, 3),
            body=body,
            contact=Rough(),
            theta=at,
        )
        for bend, row in zip(chart.bend.values, chart.verdict.values, strict=True):
            place = min(zeros(bend), key=lambda t: abs(t - at))
            for omega3, code in zip(chart.omega3.values, row, strict=True):
                assert (code == 3) == neutral(place, bend, omega3), (at, bend, omega3)
        ends = st.boundaries(
            "rolling", axis=("omega3", 0.1, 3.0, 8), body=body, contact=Rough(), theta=at
        )
        changes = neutral(at, 0.25, 0.1) != neutral(at, 0.25, 3.0)
        assert ends.complete and len(ends) == changes
        for point in ends:
            sides = [neutral(at, 0.25, point.value * (1 + d)) for d in (-1e-4, 1e-4)]
            assert sides[0] != sides[1]


def test_newton_from_the_start_would_go_to_another_inclination() -> None:
    """The test above is one of the search: without it this body is judged at a wrong place."""
    body = edged()
    at = zeros(0.25)[1]
    begin = start(body, levels(body)[1])
    assert min(zeros(0.25), key=lambda t: abs(t - begin)) == at
    plain = begin
    for _ in range(60):
        plain -= slope(plain, 0.25) / curvature(plain, 0.25)
    assert abs(plain - at) > 0.1
    form = formulas_of(body.family("rolling", "rough", theta=at))
    bends = np.linspace(0.2, 0.3, 11)
    names = body.family("rolling", "rough", theta=at).parameters
    q = [bends if n == "bend" else np.asarray(body.given[n]) for n in names]
    for bend, found in zip(bends, form.near(q), strict=True):  # type: ignore[union-attr]
        near = min(zeros(bend), key=lambda t: abs(t - form.start))  # type: ignore[union-attr]
        assert found == pytest.approx(near, abs=1e-12)


@pytest.mark.parametrize("family", ["rolling", "spinning"])
def test_a_ball_has_the_verdict_of_a_ball_as_a_spheroid_too(family: str) -> None:
    """Equal half axes give equal moments, exactly: no verdict hangs on the rounding of 2/5."""
    ball = st.Body(lambda _: 1.0, axial=0.4, transverse=0.4, name="ball")
    one, other = (
        st.spectrum(family, at=2, body=b, contact=Viscous(0.3), certify=True)
        for b in (st.Spheroid(1), ball)
    )
    assert one.verdict is other.verdict is st.Verdict.NEUTRAL
    assert one.abscissa == 0.0
