"""Why a body does not stand upright: what its height is like at π/2, by closed forms."""

import math
from typing import Any

import casadi as ca
import pytest

import stability as st


def superellipsoid(power: float) -> st.Body:
    """|r|^p + |z/0.8|^p = 1: its height is the q-norm of (sin θ, 0.8 cos θ), 1/p + 1/q = 1."""
    q = power / (power - 1)

    def height(t: Any) -> Any:
        return (ca.fabs(ca.sin(t)) ** q + ca.fabs(0.8 * ca.cos(t)) ** q) ** (1 / q)

    return st.Body(height, axial=0.4, transverse=0.4, name="superellipsoid")


def said(body: st.Body) -> str:
    with pytest.raises(st.StabilityError, match=f"^{body.name} has no spinning: ") as error:
        body.family("spinning", "viscous")
    return str(error.value)


@pytest.mark.parametrize("power", [2.5, 3.0, 4.0, 20.0])
def test_an_infinite_second_derivative_is_the_reason(power: float) -> None:
    """With x = π/2 - θ, h = 1 + 0.8^q x^q/q + ..., so h'' = (q - 1) 0.8^q x^(q - 2) for q < 2."""
    q, x = power / (power - 1), 1e-8
    text = said(superellipsoid(power))
    assert "grows beyond bounds towards theta = π/2" in text and "no motion there has a lin" in text
    shown = float(text.split("(")[1].split(" at")[0])
    assert shown == pytest.approx((q - 1) * 0.8**q * x ** (q - 2), rel=0.06)


def test_a_power_of_two_is_a_spheroid_and_stands() -> None:
    assert superellipsoid(2.0).family("spinning", "viscous").at == ("phi_dot",)


def test_a_corner_a_slope_and_a_range_are_told_apart() -> None:
    can = st.Body(lambda t: ca.sin(t) + 0.4 * ca.fabs(ca.cos(t)), axial=0.5, transverse=0.5)
    assert "the slope of its height jumps from -0.4 to 0.4 at theta = π/2." in said(can)
    slope = "the slope of its height at theta = π/2 is"
    assert f"{slope} 0.3, and must vanish there." in said(st.EccentricSphere(0.3))
    assert f"{slope} 0.3, and must vanish there." in said(st.EccentricSphere([0.3, 0.4]))
    ends = f"between theta = 0 and {math.pi / 2:.6g}, without π/2 inside."
    assert ends in said(st.ThickDisk(0.3))
