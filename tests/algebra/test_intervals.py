"""Arrays of intervals hold what a graph takes there, and going back loses no such point."""

from __future__ import annotations

import casadi as ca
import numpy as np
import pytest

from stability.algebra.intervals import INTERVALS, Interval, Tape
from stability.algebra.program import Program

X, P = ca.SX.sym("x", 2), ca.SX.sym("p")
A, B = X[0], X[1]
GRAPHS = {
    **{
        name: getattr(ca, name)(A) - B
        for name in (
            *("sqrt", "exp", "log", "sinh", "cosh", "tanh", "asinh", "acosh", "atanh", "asin"),
            *("acos", "atan", "fabs", "expm1", "log1p"),
        )
    },
    "sin": ca.sin(A) * B,
    "cos": ca.cos(A) - B,
    "tan": ca.tan(A) + B,
    "atan2": ca.atan2(A, B) - 1,
    "hypot": ca.hypot(A, B) - 1,
    "cube": A**3 - B,
    "fourth": A**4 - B,
    "pole": A**-3 - B,
    "root": A**1.5 - B,
    "power": A**P - B,
    "quotient": A / B - 1,
    "product": A * B - 1,
    "square": A**2 - B,
}
BOXES, SAMPLES = 2000, 20


@pytest.mark.parametrize("name", GRAPHS)
@pytest.mark.parametrize("exponent", [2.0, 3.0, 2.5])
def test_values_in_boxes_are_enclosed_and_kept(name: str, exponent: float) -> None:
    graph = ca.Function("graph", [X, P], [GRAPHS[name]])
    rng = np.random.default_rng(4)
    middle = 3 * rng.normal(size=(2, BOXES))
    width = rng.uniform(0, 1, (2, BOXES)) ** 3 * rng.choice([0.01, 1, 10], (2, BOXES))
    tape = Tape()
    x = [Interval(m - w, m + w, tape) for m, w in zip(middle, width, strict=True)]
    with np.errstate(all="ignore"):
        arguments = [x, [Interval(np.float64(exponent), np.float64(exponent))]]
        result = Program(graph).run(INTERVALS, arguments)[0][0]
        low, high = result.lo.copy(), result.hi.copy()
        void = np.broadcast_to(tape.void, BOXES).copy()
        goal = rng.normal(size=BOXES)
        result.meet((goal - 0.1, goal + 0.1))
        tape.narrowed()
    kept = 0
    for _ in range(SAMPLES):
        at = middle + width * rng.uniform(-1, 1, (2, BOXES)) * rng.choice([0.3, 1.0])
        value = np.array(graph.map(BOXES)(at, np.full((1, BOXES), exponent))).ravel()
        real = np.isfinite(value)
        assert not (real & ((value < low) | (value > high) | void)).any()
        near = real & (np.abs(value - goal) <= 0.1)
        for number, ends in zip(at, x, strict=True):
            assert not (near & ((number < ends.lo) | (number > ends.hi) | tape.void)).any()
        kept += int(near.sum())
    assert kept > 100


def test_a_slope_beyond_a_pole_or_a_jump_is_marked() -> None:
    def broken(graph: ca.SX, low: float, high: float) -> bool:
        tape = Tape(recording=False)
        program = Program(ca.Function("graph", [X, P], [graph]))
        x = [Interval(np.array([low]), np.array([high]), tape) for _ in range(2)]
        with np.errstate(all="ignore"):
            program.run(INTERVALS, [x, [Interval(0.5, 0.5)]])
        return bool(np.any(tape.broken))

    for graph in (1 / A, A**-3, ca.tan(A * np.pi), ca.atan2(B, A), A ** (P * B)):
        assert broken(graph, -1, 2)
    for graph in (1 / A, A**-3, ca.tan(A), ca.atan2(B, A), A ** (P * B)):
        assert not broken(graph, 0.5, 1.5)
