"""Every result prints as one line, and as a table of HTML in a notebook."""

from __future__ import annotations

import re
from collections.abc import Callable
from typing import Any

import casadi as ca
import numpy as np
import pytest

import stability as st

LAW = st.Viscous(0.3)
COIN = st.Disk.named("quarter")


def fold() -> st.Branch:
    x, p = ca.SX.sym("x"), ca.SX.sym("p")
    s = st.System("f", x, p, p - x**2, states=("x",), parameters=("p",))
    up = st.Family(s, "up", at=("p",), unknown={"x": 1.0}, equations=("x",))
    return st.branch(up, 1, -1, [], points=11)


def boundaries(low: float, high: float) -> st.Boundaries:
    return st.boundaries("spinning", axis=("at", low, high, 9), contact=LAW)


def modes(at: Any) -> Any:
    return st.spectrum("rolling", at=at, contact=LAW).modes


def cycle() -> st.Family:
    x, p = ca.SX.sym("x", 2), ca.SX.sym("p")
    r = p - x[0] ** 2 - x[1] ** 2
    rates = ca.vertcat(r * x[0] - x[1], r * x[1] + x[0])
    system = st.System("circle", x, p, rates, states=("x", "y"), parameters=("p",))
    return st.Family(system, "rest", at=("p",), held={"x": 0, "y": 0})


CASES: dict[str, tuple[Callable[[], Any], str]] = {
    "spectrum": (
        lambda: st.spectrum("rolling", at=1.8, contact=LAW),
        "<Spectrum of rolling at omega3 = 1.8 √(g/R), viscous contact (F = -μ N v), mu = 0.3 ",
    ),
    "boundaries": (
        lambda: boundaries(0.1, 5),
        "<1 boundary along at from 0.1 to 5 √(g/R): 2 ± 4.5e-16 √(g/R), static, stable above; ",
    ),
    "a law that nobody named": (
        lambda: st.boundaries("spinning", axis=("at", 0.1, 5, 9), mu=0.3),
        "<1 boundary along at from 0.1 to 5 √(g/R), F = -μ N v, taken because mu is given without "
        "a law; dry friction is Coulomb: 2 ± ",
    ),
    "birth of a cycle": (
        lambda: st.hopf(cycle(), axis=("p", -1, 1, 9))[0],
        "<CycleBirth: soft, each bound proved: at = 0 ± ",
    ),
    "no boundary": (
        lambda: boundaries(2.1, 5),
        "<0 boundaries along at from 2.1 to 5 √(g/R), stable throughout; complete: ",
    ),
    "table": (
        lambda: st.table("drift", k=0.25, mu=1),
        "<Table drift, 4 rows: k, mu [1/√(gR)], omega3 [√(g/R)], ",
    ),
    "branch": (fold, "<Branch of "),
    "drift": (
        lambda: st.drift(at=1.8, tilt=0.01, contact=LAW),
        "<Drift of rolling: threshold = 1.41421 √(g/R), time = 4901.33 √(R/g), tilt_start = 0.0111",
    ),
    "drift in SI": (
        lambda: st.drift(at=[100.0, 120.0], tilt=0.01, contact=LAW, disk=COIN),
        "<Drift of rolling: threshold = 40.2179 to 40.2179 (2 values) rad/s, time = ",
    ),
    "flutter": (
        lambda: st.hopf("spinning", contact=st.Viscous(0.8))[0],
        "<HopfPoint: elliptic, stable below, at = 2.59736740455 √(g/R), frequency = 2.3678628",
    ),
    "modes": (
        lambda: modes(1.8),
        "<Modes, 4 over 6 states: decaying mode of slip_x; decaying mode of omega3, slip_y; ",
    ),
    "modes of many": (lambda: modes([1.8, 2.0]), "<Modes of 2 points, 4 each, over 6 states>"),
    "body": (lambda: st.Torus(0.2), "<Body torus, tube = 0.2, mass = length = gravity = 1>"),
    "body in SI": (
        lambda: st.Torus([0.1, 0.2], mass=1, length=0.3, gravity=9.81),
        "<Body torus, tube = 0.1 to 0.2 (2 values), mass = 1 kg, length = 0.3 m, gravity = 9.81 m",
    ),
    "egg": (lambda: st.Egg(0.1), "<Body egg, taper = 0.1, aspect = 1.3, mass = length = gravity "),
}


@pytest.mark.parametrize(("made", "begins"), CASES.values(), ids=CASES)
def test_a_result_is_one_line_and_a_table_of_html(made: Callable[[], Any], begins: str) -> None:
    result = made()
    line, page = repr(result), result._repr_html_()
    assert line.startswith(begins) and line.endswith(">") and "\n" not in line
    assert "array(" not in line and len(line) < 600
    assert page.count("<div>") == page.count("</div>") >= 1
    for tag in ("table", "tr", "td", "th"):
        assert len(re.findall(rf"<{tag}>", page)) == len(re.findall(rf"</{tag}>", page))


def test_tables_of_modes_and_branches_name_the_states() -> None:
    assert "<th>share of slip_x</th>" in modes(1.8)._repr_html_()
    page = CASES["branch"][0]()._repr_html_()
    assert "<th>p</th><th>x</th>" in page and "state 0" not in page


def test_texts_of_a_user_are_no_html() -> None:
    x, p = ca.SX.sym("x"), ca.SX.sym("p")
    s = st.System("<b>", x, p, -p * x, states=("x",), parameters=("p",))
    rest = st.Family(s, "a<i>", at=("p",), held={"x": 0})
    page = st.spectrum(rest, at=np.array([1.0, 2.0]))._repr_html_()
    assert "a&lt;i&gt;</b> of &lt;b&gt;" in page and "<i>" not in page


@pytest.mark.parametrize(
    ("family", "ends", "contact", "verdict"),
    [
        ("rolling", (0.1, 1.4), LAW, "unstable"),
        ("rolling", (1.5, 9.0), LAW, "stable"),
        ("rolling", (1.5, 9.0), st.Rough(), "neutral"),
        ("spinning", (2.1, 5.0), LAW, "stable"),
    ],
)
def test_an_axis_without_a_boundary_has_one_verdict_throughout(
    family: str, ends: tuple[float, float], contact: st.Contact, verdict: str
) -> None:
    found = st.boundaries(family, axis=("at", *ends, 9), contact=contact)
    assert not found and found.complete and found.throughout.word == verdict
    words = f"no change of verdict along at from {ends[0]:g} to {ends[1]:g} √(g/R), {verdict} "
    assert found.statement("at").startswith(f"{words}throughout: ")
    at = np.linspace(*ends, 7)
    spectra = st.spectrum(family, at=at, contact=contact, certify=True)
    assert {v.word for v in spectra.verdict} == {verdict}


def test_an_axis_with_a_boundary_has_no_verdict_throughout() -> None:
    assert boundaries(0.1, 5).throughout is None
