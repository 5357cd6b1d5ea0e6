"""Production routes to a verdict: one list that certificates, boundaries and maps read."""

from dataclasses import replace

import casadi as ca
import pytest
from flint import arb

import stability as st
from stability.algebra.number_types import precision
from stability.base.verdict import Verdict
from stability.bodies.subject import subject_of
from stability.spectra import verdict_routes
from stability.spectra.certificate import certify, verdict
from stability.spectra.eigenvalues import REASONS
from stability.spectra.problem import problem_of
from stability.spectra.verdict_routes import (
    ANYTHING,
    GRAPH,
    ROUTES,
    Point,
    Proof,
    VerdictRoute,
)

OMEGA = 0.5671432904097838
"""The root of c exp c = 1, rounded."""
WORDS = "the sign of the damping"


def oscillator() -> st.Family:
    """A mass on a spring whose damping is c exp c - 1."""
    x, c = ca.SX.sym("x", 2), ca.SX.sym("c")
    rates = ca.vertcat(x[1], -x[0] - (c * ca.exp(c) - 1) * x[1])
    system = st.System("oscillator", x, c, rates, states=("q", "v"), parameters=("c",))
    return st.Family(system, "rest", at=("c",), held={"q": 0, "v": 0})


def by_damping(asked: list[float]) -> VerdictRoute:
    """A route of its own, which notes the points that it is asked about."""

    def attempt(point: Point, zeros: int) -> Proof | None:
        if point.problem.family.name != "rest":
            return None
        assert zeros == 0
        c = point.values["c"]
        asked.append(c)
        with precision(200):
            damped = arb(c) * arb(c).exp() > 1
        return Proof(Verdict.STABLE if damped else Verdict.UNSTABLE, -77)

    return VerdictRoute("damping", GRAPH, "every verdict", attempt, -77, WORDS)


@pytest.fixture
def asked(monkeypatch: pytest.MonkeyPatch) -> list[float]:
    """Points that a further route, the first of the list, is asked about."""
    points: list[float] = []
    monkeypatch.setattr(verdict_routes, "ROUTES", [by_damping(points), *ROUTES])
    return points


def test_a_certificate_comes_from_the_first_route_with_a_proof(asked: list[float]) -> None:
    found = st.spectrum(oscillator(), at=0.5, certify=True)
    assert found.verdict is Verdict.UNSTABLE and f"proved in {WORDS}" in found.reason
    assert asked == [0.5]
    problem = problem_of(subject_of(oscillator(), at=0.8))
    certificate = certify(problem, problem.values)
    assert (certificate.verdict, certificate.how) == (Verdict.STABLE, WORDS)
    # the disk has no use for it
    disk = st.spectrum("rolling", at=1.2, contact=st.Viscous(0.3), certify=True)
    assert "rational arithmetic" in disk.reason and asked == [0.5, 0.8]


def test_open_cells_and_boundaries_read_the_same_list(asked: list[float]) -> None:
    problem = problem_of(subject_of(oscillator(), at=0.9))
    assert verdict(problem, problem.values) is Verdict.STABLE
    assert asked == [0.9]
    [edge] = st.boundaries(oscillator(), axis=("c", 0.1, 2.0, 9))
    assert abs(edge.value - OMEGA) <= edge.error + 1e-16 and not edge.stable_below
    assert {edge.value - edge.error, edge.value + edge.error} <= set(asked)


def test_its_verdicts_are_those_of_the_package() -> None:
    problem = problem_of(subject_of(oscillator()))
    asked: list[float] = []
    route = by_damping(asked)
    for c in (0.1, OMEGA - 1e-15, OMEGA + 1e-15, 2.0):
        proof = route.attempt(Point(problem, {"c": c}), 0)
        assert proof is not None and proof.verdict is verdict(problem, {"c": c})


def test_every_route_says_what_it_needs_and_proves() -> None:
    assert len({route.name for route in ROUTES}) == len(ROUTES)
    assert all(route.needs and route.proves for route in ROUTES)
    codes = [route.code for route in ROUTES if route.code]
    assert len(set(codes)) == len(codes) and all(code < 0 for code in codes)
    assert not set(codes) & set(REASONS)


def test_a_route_that_proves_nothing_passes_on(monkeypatch: pytest.MonkeyPatch) -> None:
    silent = VerdictRoute("silent", ANYTHING, "nothing", lambda *_: None)
    monkeypatch.setattr(verdict_routes, "ROUTES", [silent, *ROUTES])
    found = st.spectrum(oscillator(), at=0.5, certify=True)
    assert found.verdict is Verdict.UNSTABLE and "balls of 128 bits" in found.reason
    monkeypatch.setattr(verdict_routes, "ROUTES", [silent])
    assert st.spectrum(oscillator(), at=0.5, certify=True).verdict is Verdict.UNDECIDED


@pytest.mark.parametrize(("code", "words"), [(-6, "which means"), (3, "and not negative")])
def test_a_code_that_is_taken_is_refused(code: int, words: str) -> None:
    with pytest.raises(st.StabilityError, match=words):
        replace(ROUTES[0], name="toy", code=code)
