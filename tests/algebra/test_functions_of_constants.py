"""Functions and powers of numbers that a graph holds: bounded, and answered the same way twice."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import casadi as ca
import mpmath
import numpy as np
import pytest
import sympy as sp

import stability as st
from stability.algebra.number_types import MORE, UNARY
from stability.algebra.program import Program
from stability.algebra.running_error import RunningError, running_error_arrays

INSIDE = {"acosh": 1.7}


@pytest.mark.parametrize("name", [*UNARY, *MORE])
def test_a_function_of_a_constant_has_a_true_bound(name: str) -> None:
    value = INSIDE.get(name, 0.37)
    x, c = ca.SX.sym("x"), ca.SX.sym("c")
    program = Program(ca.Function("f", [x, c], [getattr(ca, name)(c) * x]), [value])
    [(found, error)] = running_error_arrays(
        program, [[RunningError(np.ones(2), np.zeros(2))]], (2,)
    )
    with mpmath.workdps(40):
        true = getattr(mpmath, name)(mpmath.mpf(value))
        for v, e in zip(found.flat, error.flat, strict=True):
            assert abs(mpmath.mpf(float(v)) - true) <= mpmath.mpf(float(e))
            assert 0 < e < 1e-14


@pytest.mark.parametrize(("base", "power"), [(2.0, 0.3), (0.4, -1.7), (3.0, -2.0), (1 / 3, 1 / 3)])
def test_a_power_of_constants_has_a_true_bound(base: float, power: float) -> None:
    x, c = ca.SX.sym("x"), ca.SX.sym("c", 2)
    graph = ca.Function("f", [x, c], [c[0] ** c[1] * x, c[0] ** x, x ** c[1]])
    program = Program(graph, [base, power])
    given = RunningError(np.array([0.75]), np.zeros(1))
    with mpmath.workdps(40):
        b, p, v = map(mpmath.mpf, (base, power, 0.75))
        true = b**p * v, b**v, v**p
        for (found, error), right in zip(
            running_error_arrays(program, [[given]], (1,)), true, strict=True
        ):
            assert abs(mpmath.mpf(found.item()) - right) <= mpmath.mpf(error.item()) < 1e-14


LAWS: dict[str, tuple[Callable[[Any], Any], Callable[[Any], Any], float]] = {
    "2**(x/10)": (lambda x: 2 ** (x / 10), lambda x: mpmath.mpf(2) ** (x / 10), 0.0),
    "(1/3)**x": (lambda x: ca.SX(1 / 3) ** x, lambda x: mpmath.mpf(1 / 3) ** x, 0.5),
    "x**x": (lambda x: x**x, lambda x: x**x, 1.5),
    "x**(1/3)": (lambda x: x ** (1 / 3), lambda x: x ** mpmath.mpf(1 / 3), 2.0),
    "x**-1.5": (lambda x: x**-1.5, lambda x: x ** mpmath.mpf(-1.5), 4.0),
    "log10": (ca.log10, mpmath.log10, 3.0),
    "hypot": (lambda x: ca.hypot(x, 1), lambda x: mpmath.sqrt(x * x + 1), 0.5),
}
"""Law of a held state, the same in mpmath, and the state's value."""


@pytest.mark.parametrize("name", LAWS)
def test_laws_of_a_held_state_are_answered_the_same_way_twice(name: str) -> None:
    law, known, at = LAWS[name]
    with mpmath.workdps(30):
        slope = float(mpmath.diff(known, mpmath.mpf(at)))
    x, p = ca.SX.sym("x"), ca.SX.sym("p", 2)
    rate = -p[0] * (law(x) - law(ca.SX(at))) - p[1] * (x - at)
    system = st.System("law", x, p, rate, states=("x",), parameters=("q", "r"))
    rest = st.Family(system, "rest", at=("q",), held={"x": at})
    for _ in range(2):
        for certify in (False, True):
            found = st.spectrum(rest, at=1.0, r=0.25, certify=certify)
            assert found.eigenvalues[0] == pytest.approx(-slope - 0.25, rel=1e-13)
            assert found.verdict.word == ("stable" if slope > -0.25 else "unstable")
        [place] = st.boundaries(rest, axis=("r", -5, 5, 9), at=1.0)
        assert place.value == pytest.approx(-slope, rel=1e-13)
        cells = st.stability_map(rest, x=("q", 1, 2, 2), y=("r", -3, 3, 2), boundaries=False)
        stable = np.array([[q * slope + r > 0 for q in (1, 2)] for r in (-3, 3)])
        assert np.array_equal(cells.verdict.values == st.Verdict.STABLE.code, stable)


def test_a_cube_root_from_sympy_is_answered() -> None:
    x, p = sp.symbols("x p")
    system = st.System.from_sympy({x: -p * sp.cbrt(1 + x) + p})
    rest = st.Family(system, "rest", at=("p",), held={"x": 0})
    for certify in (False, True, False):
        found = st.spectrum(rest, at=1.0, certify=certify)
        assert found.eigenvalues[0] == pytest.approx(-1 / 3, abs=1e-15)
        assert found.verdict.word == "stable"
