"""Paths on elements of Chebyshev points, and linear equations along them, against closed forms."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.special import airy

from stability.scene.rungs import elements
from stability.scene.rungs.elements import Elements, LinearEquation, carried, chebyshev


def test_values_and_derivatives_converge_as_for_an_entire_function() -> None:
    errors = []
    for points in (6, 9, 12, 15):
        some = Elements(np.array([0.0, 1.0, 2.5]), points)
        values = np.sin(some.times)[..., None]
        slope = some.derivative(values)[..., 0]
        between = np.linspace(0, 2.5, 50)
        errors.append(
            (
                np.abs(slope - np.cos(some.times)).max(),
                np.abs(some.at(between, values)[:, 0] - np.sin(between)).max(),
            )
        )
    for one, other in zip(errors, errors[1:], strict=False):
        assert other[0] < one[0] / 50
        assert other[1] < one[1] / 50
    assert errors[-1][0] < 1e-11
    assert errors[-1][1] < 1e-13


def test_interpolation_at_a_point_gives_its_value() -> None:
    some = Elements(np.array([0.0, 0.7, 1.0]), 9)
    values = np.exp(some.times)[..., None]
    assert some.at(some.times.ravel(), values)[:, 0] == pytest.approx(
        np.exp(some.times).ravel(), rel=1e-15
    )


def test_the_tail_is_the_size_of_the_last_coefficients() -> None:
    some, share = Elements(np.array([0.0, 2.0]), 12), chebyshev(12)[0]
    x = 2 * share - 1
    values = (np.cos(3 * np.arccos(x)) + 1e-5 * np.cos(11 * np.arccos(x)))[None, :, None]
    assert some.tails(values)[0] == pytest.approx(1e-5, rel=1e-3)  # over the size of the values


def _airy(some: Elements) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """E'' = t e + sin t as a system, and the Airy functions for its solution without the sine."""
    t = some.times
    matrices = np.zeros((*t.shape, 2, 2))
    matrices[..., 0, 1], matrices[..., 1, 0] = 1.0, t
    ai, slope, _, _ = airy(t)
    return matrices, np.stack([ai, slope], axis=-1), np.zeros((*t.shape, 2))


@pytest.mark.parametrize("stiff", [False, True])
def test_the_linear_equation_gives_airys_function(stiff: bool) -> None:
    some = Elements(np.linspace(-6.0, 0.0, 9), 12)
    matrices, exact, none = _airy(some)
    start = exact[0, 0]
    found = (
        carried(some, matrices, none, start)
        if stiff
        else LinearEquation.along(some, matrices).solve(none, start)
    )
    assert np.abs(found - exact).max() < (1e-9 if stiff else 1e-4)


def test_a_defect_moves_the_solution_by_its_integral() -> None:
    some = Elements(np.linspace(0.0, 2.0, 5), 12)
    matrices = np.full((*some.times.shape, 1, 1), -0.5)
    defect = np.cos(some.times)[..., None]
    exact = (0.5 * np.cos(some.times) + np.sin(some.times) - 0.5 * np.exp(-some.times / 2)) / 1.25
    for found in (
        LinearEquation.along(some, matrices).solve(defect, np.zeros(1)),
        carried(some, matrices, defect, np.zeros(1)),
    ):
        assert found[..., 0] == pytest.approx(exact, abs=1e-6)


def test_the_first_elements_alone_give_the_same_solution() -> None:
    some = Elements(np.linspace(-6.0, 0.0, 9), 12)
    matrices, exact, none = _airy(some)
    whole = LinearEquation.along(some, matrices)
    part = whole.first(3).solve(none[:3], exact[0, 0])
    assert part == pytest.approx(whole.solve(none, exact[0, 0])[:3], abs=1e-15)


@pytest.mark.parametrize("n", [2, 4, 5])
def test_steps_by_machine_code_are_those_of_numpy(n: int, monkeypatch: pytest.MonkeyPatch) -> None:
    some, rng = Elements(np.array([0.0, 0.4, 1.0]), 9), np.random.default_rng(n)
    matrices = rng.normal(size=(2, 9, n, n))
    defect, start = rng.normal(size=(2, 9, n, 3)), rng.normal(size=(n, 3))
    mine = LinearEquation.along(some, matrices)
    monkeypatch.setattr(elements, "available", lambda: False)
    other = LinearEquation.along(some, matrices)
    assert mine.step == pytest.approx(other.step, abs=1e-13)
    assert mine.half == pytest.approx(other.half, abs=1e-13)
    for i in range(3):  # each solution alone is that among several
        one = other.solve(defect[..., i], start[:, i])
        assert mine.solve(defect, start)[..., i] == pytest.approx(one, abs=1e-12)
