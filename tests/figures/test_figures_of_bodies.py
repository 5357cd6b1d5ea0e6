"""Figures of bodies name quantities by the field's symbols, and say which body it is."""

from pathlib import Path

import casadi as ca
import numpy as np
import pytest
from matplotlib.figure import Figure
from matplotlib.text import Text

import stability as st

SI = st.Torus(0.2, mass=0.5, gravity=9.81, length=0.3)


def texts(figure: Figure) -> str:
    return "\n".join(t.get_text() for t in figure.findobj(Text))


@pytest.fixture(scope="module")
def chart() -> object:
    return st.stability_map(
        "tumbling", x=("theta", 0.2, 1.4, 9), y=("mu", 0.1, 3, 8), body=st.Torus(0.2)
    )


@pytest.mark.long
def test_a_map_has_symbols_units_and_the_body(chart: object, tmp_path: Path) -> None:
    target = tmp_path / "torus.nc"
    st.write_map(chart, target)
    for dataset in (chart, st.read_map(target)):
        figure = st.plot_map(dataset)
        assert figure.axes[0].get_xlabel() == r"axis inclination $\theta$  [rad]"
        law = r"friction coefficient $\mu$ of $F = -\mu\,N\,v$"
        assert figure.axes[0].get_ylabel() == law + "\n" + r"[$1/\sqrt{gR}$]"
        assert "torus, viscous contact, $b$ = 0.2" in texts(figure)
        assert r"[$\sqrt{g/R}$]" in texts(figure)


def test_a_map_over_shape_and_rate_in_si() -> None:
    found = st.stability_map(
        "rolling", x=("omega3", 1, 20, 6), y=("tube", 0.05, 0.9, 5), body=SI, contact="rough"
    )
    figure = st.plot_map(found)
    assert figure.axes[0].get_xlabel() == r"axial angular velocity $\omega_3$  [rad/s]"
    assert figure.axes[0].get_ylabel() == "relative tube radius $b$"
    assert "torus, rough contact, $g$ = 9.81 m/s$^2$, $R$ = 0.3 m, $m$ = 0.5 kg" in texts(figure)


def test_loci_have_symbols_units_and_the_body() -> None:
    at = np.linspace(0.4, 1.4, 9)
    body = st.EccentricSphere(0.3, axial=0.3, transverse=0.4)
    figure = st.plot_locus(st.spectrum("tumbling", at=at, body=body, contact=st.Viscous(0.5)))
    assert figure.axes[1].get_xlabel() == r"axis inclination $\theta$  [rad]"
    said = texts(figure)
    assert "eccentric sphere, viscous contact, $e$ = 0.3, $I_3/mR^2$ = 0.3" in said
    assert r"\dot\varphi" in said
    assert "phi_dot" not in said


def test_a_users_body_keeps_its_names() -> None:
    lens = st.Body(
        lambda t, rim: rim + ca.sin(t),
        axial=0.5,
        transverse=0.25,
        shape={"rim": 0.1},
        name="rounded coin",
    )
    found = st.stability_map(
        "spinning", x=("phi_dot", 1, 4, 6), y=("rim", 0.05, 0.5, 5), body=lens, contact="rough"
    )
    figure = st.plot_map(found)
    assert figure.axes[0].get_ylabel() == "rim"
    assert "rounded coin, rough contact" in texts(figure)
