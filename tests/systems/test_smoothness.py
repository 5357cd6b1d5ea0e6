"""Rates without a slope at a member are refused, as judged by difference quotients of 60 digits."""

from __future__ import annotations

from collections.abc import Callable
from types import SimpleNamespace
from typing import Any

import casadi as ca
import mpmath
import numpy as np
import pytest
from own_systems import system_of

import stability as st
from stability.systems.graph.smoothness import sloped

Rate = Callable[[Any], Any]
DIRECTIONS = ((1, 0), (0, 1), (1, 1), (2, -3), (-1, 0), (0, -1), (-1, -1), (-2, 3))

KINKS: dict[str, Rate] = {
    "cube root of a square": lambda f: (f.x**2 + f.v**2) ** f.third,
    "fourth root of a square": lambda f: (f.x**2) ** f.quarter,
    "distance": lambda f: f.sqrt(f.x**2 + f.v**2),
    "size": lambda f: f.fabs(f.x),
    "size in a sine": lambda f: f.sin(f.fabs(f.v)),
    "arccos at its end": lambda f: f.acos(1 - f.x**2),
    "arcsin of a root": lambda f: f.asin(f.sqrt(f.x**2)),
    "root of a size": lambda f: f.sqrt(f.fabs(f.x)),
    "flat root times flat root": lambda f: (f.x**2) ** f.quarter * (f.v**2) ** f.quarter,
    "distance that a parameter rounds off": lambda f: f.sqrt(f.x**2 + f.zero**2) - f.zero,
}
SMOOTH: dict[str, Rate] = {
    "quadratic drag": lambda f: f.v * f.fabs(f.v),
    "drag along a velocity": lambda f: f.v * f.sqrt(f.x**2 + f.v**2),
    "product in a size": lambda f: f.fabs(f.x * f.v),
    "product of distances": lambda f: f.sqrt(f.x**2 + f.v**2) * f.sqrt(4 * f.x**2 + f.v**2),
    "root of a parameter": lambda f: f.x * f.sqrt(f.zero) + f.sqrt(f.zero**2) * f.v,
    "root away from its end": lambda f: f.sqrt(1 + f.x) - 1,
}


def _numbers(module: Any, x: Any, v: Any, *, zero: Any, size: Any) -> SimpleNamespace:
    names = ("sqrt", "sin", "acos", "asin")
    found = {n: getattr(module, n) for n in names}
    return SimpleNamespace(x=x, v=v, fabs=size, zero=zero, third=1 / 3, quarter=0.25, **found)


def _family(rate: Rate) -> st.Family:
    x, v, zero = ca.SX.sym("x"), ca.SX.sym("v"), ca.SX.sym("zero")
    extra = rate(_numbers(ca, x, v, zero=zero, size=ca.fabs))
    rates = ca.vertcat(v, -x - v + 3 * extra)
    system = st.System(
        "kinked", ca.vertcat(x, v), zero, rates, states=("x", "v"), parameters=("zero",)
    )
    return st.Family(system, "rest", at=("zero",), held={"x": 0.0, "v": 0.0})


def _slope(rate: Rate) -> tuple[float, float] | None:
    """The slope at 0 from difference quotients at 1e-25 in eight directions, or None."""
    with mpmath.workdps(60):
        h = mpmath.mpf(10) ** -25

        def value(a: int, b: int) -> Any:
            return rate(_numbers(mpmath, h * a, h * b, zero=mpmath.mpf(0), size=abs))

        found = [(value(a, b) - value(0, 0)) / h for a, b in DIRECTIONS]
        by_x, by_v = found[:2]
        off = [abs(q - a * by_x - b * by_v) for q, (a, b) in zip(found, DIRECTIONS, strict=True)]
        return (float(by_x), float(by_v)) if max(off) < 1e-9 else None


@pytest.mark.parametrize("name", KINKS)
def test_a_member_without_a_slope_is_refused(name: str) -> None:
    assert _slope(KINKS[name]) is None
    family = _family(KINKS[name])
    for certify in (False, True):
        with pytest.raises(st.StabilityError, match="have no slope there"):
            st.spectrum(family, at=0.0, certify=certify)
    with pytest.raises(st.StabilityError, match="have no slope there"):
        st.boundaries(family, axis=("zero", 0, 1, 5))


@pytest.mark.parametrize("name", SMOOTH)
def test_a_product_with_zero_has_the_slope_that_difference_quotients_show(name: str) -> None:
    slope = _slope(SMOOTH[name])
    assert slope is not None
    spectrum = st.spectrum(_family(SMOOTH[name]), at=0.0, certify=True)
    trace, determinant = 3 * slope[1] - 1, 1 - 3 * slope[0]
    expected = np.roots([1, -trace, determinant])
    assert np.sort_complex(spectrum.eigenvalues) == pytest.approx(np.sort_complex(expected))


def test_each_state_is_judged_by_itself() -> None:
    family = _family(KINKS["distance that a parameter rounds off"])
    states = np.array([[0.0, 0.0], [0.0, 0.0], [1.0, 0.0]])
    zero = np.array([[0.0], [0.5], [0.0]])
    assert sloped(family.system, states, zero).tolist() == [False, True, True]
    assert st.spectrum(family, at=0.5, certify=True).verdict.word == "stable"


def test_conditions_of_a_family_without_slopes_are_refused() -> None:
    with pytest.raises(st.StabilityError, match="no slope"):
        st.conditions(_family(KINKS["cube root of a square"]))


X, V, C = (ca.SX.sym(n) for n in "xvc")


def rest(rate: ca.SX) -> st.Family:
    system = system_of("s", [X, V], [C], [V, -X - C * V - rate])
    return st.Family(system, "rest", ("c",), held={"x": 0.0, "v": 0.0})


def _leaves_its_domain(force: ca.SX) -> bool:
    """Whether a force has no value somewhere on a small circle around x = v = 0."""
    angle = np.linspace(0, 2 * np.pi, 64)
    value = ca.Function("force", [X, V, C], [force])
    found = value(1e-3 * np.cos(angle)[None], 1e-3 * np.sin(angle)[None], 0.5)
    return bool(np.isnan(np.asarray(found)).any())


@pytest.mark.few(7)
@pytest.mark.parametrize(
    ("force", "fine"),
    [
        (X**1.5, False),
        ((2 * X + V) ** 2.5, False),
        (X ** (C + 1), False),
        (ca.sqrt(X) * X, False),
        (ca.fabs(X) ** 1.5, True),
        ((X**2 + V**2) ** 1.5, True),
        ((1 + X) ** 1.5 - 1, True),
        (X**3, True),
        ((X * V) ** 1.5, False),
        ((X**2 * V) ** 1.5, False),
        (X * ca.sqrt(X * V), False),
        ((X**2 - V**2) ** 1.5, False),
        ((-(X**2)) ** 1.5, False),
        (X * ca.acos(1 - X * V), False),
        (V * ca.asin(1 + X**2), False),
        ((C * X * V) ** 2.5, False),
        ((X * ca.sin(V)) ** 1.5, False),
        ((2 * X**2 / (1 + V)) ** 1.5, True),
        ((C * X**2 * ca.cosh(V)) ** 1.5, True),
        ((X * V) ** 2, True),
        (((X * V) ** 2) ** 1.5, True),
        (ca.fabs(X * V) ** 1.5, True),
        (V * ca.sqrt(1 - ca.cos(X)), True),
        (X * ca.acos(1 - X**2 * V**2), True),
        (ca.hypot(X, V) ** 1.5, True),
        (-((X**2 + 2 * V**4) ** 1.5), True),
    ],
)
def test_a_member_at_the_edge_of_the_domain_of_a_power_is_refused(force: ca.SX, fine: bool) -> None:
    """Next to x = 0 such a power has no value, so no neighbouring motion exists."""
    family = rest(3 * force)
    if fine:
        assert st.spectrum(family, at=0.5, certify=True).verdict.word == "stable"
        return
    assert _leaves_its_domain(force)
    for ask in (
        lambda: st.spectrum(family, at=0.5, certify=True),
        lambda: st.conditions(family),
        lambda: st.boundaries(family, axis=("c", 0.25, 0.75, 5)),
    ):
        with pytest.raises(st.StabilityError, match="no slope"):
            ask()


@pytest.mark.parametrize(
    ("force", "removable"),
    [
        (V * ca.sin(X) / X, True),
        (X**2 / X, True),
        ((ca.exp(X) - 1) / X - 1, True),
        (V * (10 * X) / (ca.exp(10 * X) - 1), True),
        ((X - V) * ca.sinh(X) / X, True),
        (1 / X, False),
        (X * V / (X**2 + V**2), False),
        (ca.sign(X), False),
        (ca.log(X), False),
        (ca.fabs(X) / X, False),
    ],
)
def test_a_gap_that_is_removable_is_called_so(force: ca.SX, removable: bool) -> None:
    with pytest.raises(st.StabilityError) as refusal:
        st.spectrum(rest(force), at=0.5)
    assert ("from all sides; cancel a common" in str(refusal.value)) is removable
