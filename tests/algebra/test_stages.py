"""Programs in stages: what is fixed is computed once, and is the same as all at once."""

from __future__ import annotations

import casadi as ca
import numpy as np
import pytest
from flint import arb

from stability.algebra.number_types import balls, numpy_algebra, precision
from stability.algebra.program import LONGER, Program
from stability.algebra.running_error import RunningError, running_error_arrays


def long_program() -> Program:
    """A polynomial of a high degree in two variables, with a root and a sine."""
    x, p = ca.SX.sym("x", 2), ca.SX.sym("p")
    total, power = ca.SX(0), ca.SX(1)
    for k in range(1, 220):
        power = power * (x[0] - x[1] / 7)
        total += power * np.sqrt(k)
    parts = [total * p, ca.sin(x[0]) / ca.sqrt(2 + x[1] ** 2), ca.SX(0.1) + ca.SX(0.2)]
    return Program(ca.Function("long", [x, p], [ca.vertcat(*parts), ca.diag(x)]))


POINTS = np.random.default_rng(11).uniform(-0.9, 0.9, (3, 24))


def test_constants_are_computed_anew_in_each_precision() -> None:
    c = ca.SX.sym("c", 2)
    program = Program(ca.Function("f", [ca.SX.sym("x"), c], [c[0] / c[1]]), [1.0, 3.0])
    for bits in (64, 256, 64, 1024):
        with precision(bits):
            [[third]] = program.run(balls(), [[arb(0)]])
            assert third.contains(arb(1) / 3)
            assert float(third.rad()) < 2.0 ** (1 - bits)


def test_a_later_stage_gives_the_bits_of_one_run() -> None:
    program, rows = long_program(), POINTS
    whole = program.run(numpy_algebra(), [list(rows[:2]), [rows[2]]])
    for varying in (frozenset({(0, 1)}), frozenset({(1, 0)}), frozenset({(0, 0), (1, 0)})):
        then = program.begun(numpy_algebra(), [list(rows[:2]), [rows[2]]], varying)
        given = [
            [rows[j] if (0, j) in varying else None for j in (0, 1)],
            [rows[2] if (1, 0) in varying else None],
        ]
        for mine, theirs in zip(then(given), whole, strict=True):
            for a, b in zip(mine, theirs, strict=True):
                np.testing.assert_array_equal(a, b)


def test_what_varies_is_read_anew() -> None:
    program = long_program()
    then = program.begun(numpy_algebra(), [[0.3, 0.2], [None]], frozenset({(1, 0)}))
    first, second = (then([[None, None], [p]])[0][0] for p in (1.0, 2.0))
    assert second == 2 * first != 0


@pytest.mark.parametrize("shape", [(), (24,), (4, 6)])
def test_balls_of_the_kernel_hold_exact_values(shape: tuple[int, ...]) -> None:
    program = long_program()
    assert program.size >= LONGER
    points = [v.reshape(shape) if shape else v[0] for v in POINTS]
    radius = 1e-9
    given = [[RunningError(v, radius) for v in points[:2]], [RunningError(points[2], 0.0)]]
    (value, error), (square, _) = running_error_arrays(program, given, shape)
    assert value.shape == (*shape, 3, 1) and square.shape == (*shape, 2, 2)
    assert (square[..., 0, 1] == 0).all()
    random = np.random.default_rng(5)
    for at in np.ndindex(shape):
        moved = [float(np.asarray(v)[at]) + radius * random.choice([-1.0, 1.0]) for v in points[:2]]
        with precision(200):
            exact = program.run(
                balls(), [[arb(v) for v in moved], [arb(float(np.asarray(points[2])[at]))]]
            )[0]
            for k, ball in enumerate(exact):
                off = abs(arb(float(value[at][k, 0])) - ball)
                assert off <= arb(float(error[at][k, 0]))
    assert error.max() < 1e-4


def test_quick_values_are_those_of_arrays() -> None:
    program = long_program()
    blocks = [list(POINTS[:2]), [POINTS[2]]]
    for mine, theirs in zip(
        program.quick(blocks, (24,)), program.arrays(blocks, (24,)), strict=True
    ):
        np.testing.assert_allclose(mine, theirs, rtol=1e-11, atol=1e-13)


def test_a_function_without_a_kernel_is_run_as_before() -> None:
    x = ca.SX.sym("x")
    total = x
    for _ in range(LONGER):
        total = total / 3 + ca.exp(-total)
    program = Program(ca.Function("f", [x], [total]))
    assert program.tape is None
    [found] = program.quick([[np.array([0.2])]], (1,))
    np.testing.assert_array_equal(found, program.arrays([[np.array([0.2])]], (1,))[0])


def test_no_points_give_no_balls() -> None:
    none = np.zeros(0)
    [value, _] = running_error_arrays(
        long_program(), [[RunningError(none, none)] * 2, [RunningError(none, none)]], (0,)
    )
    assert value[0].shape == value[1].shape == (0, 3, 1)
