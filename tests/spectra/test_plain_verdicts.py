"""Verdicts by balls alone, before exact numbers are tried."""

from typing import Any

import casadi as ca
import numpy as np
import pytest
from own_systems import system_of

import stability as st
from stability.base.verdict import Verdict
from stability.bodies.subject import subject_of
from stability.spectra import certificate, verdict_routes
from stability.spectra.certificate import verdict
from stability.spectra.problem import problem_of


def governor() -> st.Family:
    """Watt's governor, whose members are solved for."""
    x, y, z, a, b, e = (ca.SX.sym(n) for n in ("x", "y", "z", "a", "b", "e"))
    rhs = ca.vertcat(y, z**2 * ca.sin(x) * ca.cos(x) - ca.sin(x) - e * y, a * (ca.cos(x) - b))
    system = system_of("governor", [x, y, z], [a, b, e], rhs)
    return st.Family(
        system,
        "running",
        at=("e",),
        held={"y": 0},
        unknown={"x": 1.0, "z": 1.4},
        equations=("y", "z"),
        positive=("x", "z"),
        typical={"e": 0.4, "a": 0.5, "b": 0.5},
    )


def kinked() -> st.Family:
    """A family whose roots are steady motions where p is not negative."""
    x, y, p, q = (ca.SX.sym(n) for n in ("x", "y", "p", "q"))
    fall = y - p
    rhs = ca.vertcat(fall + ca.sin(fall) - q * x, ca.fabs(p) - p - x - 2 * fall)
    system = system_of("kinked", [x, y], [p, q], rhs)
    return st.Family(
        system,
        "line",
        at=("p",),
        held={"x": 0},
        unknown={"y": 1.0},
        equations=("x",),
        typical={"p": 1.0, "q": 1.0},
    )


def critical(a: float, b: float) -> float:
    """The damping at which the governor begins to swing.

    With cos x = b, z² = 1/b and s = sin x: λ³ + e λ² + s²/b λ + 2 a b z s², so e = 2 a b² z.
    """
    return float(2 * a * b**1.5)


@pytest.mark.parametrize("count", [2, pytest.param(6, marks=pytest.mark.long)])
def test_balls_alone_say_what_exact_numbers_say(
    count: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    problem, draw = problem_of(subject_of(governor(), parameters={})), np.random.default_rng(5)
    points = []
    for step in (0.3, 1e-3, 1e-9, 1e-12, -1e-12, -1e-9, -1e-3, -0.3):
        for a, b in draw.uniform(0.2, 0.8, (count, 2)).round(3):
            points.append({"e": critical(a, b) * (1 + step), "a": float(a), "b": float(b)})
    plain = [verdict(problem, p) for p in points]
    assert plain == 4 * count * [Verdict.STABLE] + 4 * count * [Verdict.UNSTABLE]
    monkeypatch.setattr(verdict_routes, "ROUTES", verdict_routes.ROUTES[1:])
    assert [verdict(problem, p) for p in points] == plain


def test_exact_numbers_are_not_tried_where_balls_decide(monkeypatch: pytest.MonkeyPatch) -> None:
    def refused(*_: Any) -> None:
        raise AssertionError

    monkeypatch.setattr("stability.polynomials.member.exact_unknowns", refused)
    problem = problem_of(subject_of(governor(), parameters={}))
    assert verdict(problem, {"e": 0.4, "a": 0.5, "b": 0.5}) is Verdict.STABLE
    with pytest.raises(AssertionError):
        certificate.certify(problem, {"e": 0.4, "a": 0.5, "b": 0.5})


@pytest.mark.parametrize(("p", "found"), [(0.7, Verdict.STABLE), (-0.7, Verdict.UNDECIDED)])
def test_a_root_that_is_no_steady_motion_has_no_verdict(p: float, found: Verdict) -> None:
    assert verdict(problem_of(subject_of(kinked(), parameters={})), {"p": p, "q": 1.0}) is found
