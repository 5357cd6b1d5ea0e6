"""Questions on a family whose equations have several branches: each answer is of its member's own.

The branches are planted, so that the growth rate on each is known by hand.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import casadi as ca
import numpy as np
import pytest

import stability as st
from stability.base.errors import DomainError
from stability.bodies.subject import subject_of
from stability.boundary.brackets import AxisScan, refine
from stability.spectra.problem import problem_of

BRANCHES: dict[str, tuple[float, list[Callable[[Any], Any]], list[Callable[[Any], Any]]]] = {
    "a line and another": (2.0, [lambda p: p, lambda p: 1 - p], []),
    "three lines": (2.0, [lambda p: p, lambda p: 1 - p, lambda p: 2 * p + 1], []),
    "a line and a parabola": (-2.0, [lambda p: p, lambda p: p * p - 1], []),
    "a line and roots": (3.0, [lambda p: p / 4 + 1], [lambda p: p * p + 1]),
}
"""Guess, branches y = b(p), and branches y² = s(p)."""


def planted(name: str, sign: int = -1) -> tuple[st.Family, Callable[[float, float], float]]:
    """A family y' = ± ∏ (y - b) ∏ (y² - s), and its growth rate at (y, p)."""
    guess, lines, squares = BRANCHES[name]
    y, p = ca.SX.sym("y"), ca.SX.sym("p")

    def parts(v: Any, q: Any) -> list[Any]:
        return [*(v - b(q) for b in lines), *(v * v - s(q) for s in squares)]

    rate: Any = sign
    for part in parts(y, p):
        rate = rate * part
    system = st.System("planted", y, p, rate, states=("y",), parameters=("p",))
    family = st.Family(
        system, "m", at=("p",), unknown={"y": guess}, equations=("y",), typical={"p": 2.0}
    )

    def growth(v: float, q: float) -> float:
        slopes = [1.0] * len(lines) + [2 * v] * len(squares)
        values = parts(v, q)
        return sign * sum(
            slope * float(np.prod(values[:i] + values[i + 1 :])) for i, slope in enumerate(slopes)
        )

    return family, growth


@pytest.mark.parametrize("sign", [-1, 1])
@pytest.mark.parametrize("name", BRANCHES)
def test_conditions_answer_for_the_members_own_branch_or_refuse(name: str, sign: int) -> None:
    family, growth = planted(name, sign)
    found = st.conditions(family)
    answered = refused = 0
    for p in (-2.0, -1.0, -0.25, 0.25, 0.75, 1.5, 2.0, 3.0):
        member = float(st.spectrum(family, at=p).states[0])
        for _ in range(2):
            try:
                word = found.verdict(p).word
            except DomainError as error:
                assert "another branch" in str(error)
                refused += 1
                continue
            assert word == ("stable" if growth(member, p) < 0 else "unstable")
            answered += 1
    assert answered
    assert refused or name == "a line and roots"


def test_a_rule_and_latex_name_their_branch() -> None:
    family, _ = planted("a line and another")
    found = st.conditions(family)
    assert found.branch == "the branch with y = p"
    assert found.rule.startswith("On the branch with y = p: stable where 2*p - 1 > 0; ")
    assert "On the branch with y = p:" in st.latex(found, standalone=False)
    with pytest.raises(DomainError, match=r"^y is 2 at this member, which lies on another branch"):
        found.verdict(-1.0)
    x, p = ca.SX.sym("x"), ca.SX.sym("p")
    alone = st.System("alone", x, p, p - 2 * x, states=("x",), parameters=("p",))
    rest = st.Family(alone, "m", at=("p",), unknown={"x": 1.0}, equations=("x",))
    assert st.conditions(rest).branch == ""
    assert st.conditions(rest).rule == "Stable at every member of the domain."


def test_a_jump_of_the_root_finder_is_no_boundary() -> None:
    """From y = 0.3 Newton's method passes from branch to branch between neighbouring doubles."""
    y, p, q = ca.SX.sym("y"), ca.SX.sym("p"), ca.SX.sym("q")
    rate = -(y - p / 2 - 1 - q) * (y - 2 * p + 1) * (y + p - 1) * (y * y - p)
    system = st.System("jumps", y, ca.vertcat(p, q), rate, states=("y",), parameters=("p", "q"))
    family = st.Family(system, "m", at=("p",), unknown={"y": 0.3}, equations=("y",))
    line = AxisScan(problem_of(subject_of(family, parameters={"q": 0.5})), "p", {"q": 0.5})
    low, high = -0.7591, -0.7590957
    ends = [float(st.spectrum(family, at=p_, q=0.5).states[0]) for p_ in (low, high)]
    assert line.sign(low) * line.sign(high) < 0  # of members on two branches
    assert abs(ends[1] - ends[0]) > 1
    assert refine(line, low, high) is None


def two_lines(guess: float, other: bool) -> st.Family:
    """Branches y = p and, where wanted, y = -p; the pair of u, v is damped by q + y."""
    x, p = ca.SX.sym("x", 3), ca.SX.sym("P", 2)
    y, u, v = ca.vertsplit(x)
    rate = -(y - p[0]) * (y + p[0]) if other else -2 * p[0] * (y - p[0])
    rates = ca.vertcat(rate, v, -u - (p[1] + y) * v - v**3)
    system = st.System("two", x, p, rates, states=("y", "u", "v"), parameters=("p", "q"))
    return st.Family(
        system, "m", at=("p",), held={"u": 0.0, "v": 0.0}, unknown={"y": guess}, equations=("y",)
    )


@pytest.mark.parametrize("other", [False, True])
def test_points_of_two_conditions_are_those_of_members_of_the_branch(*, other: bool) -> None:
    """On y = p a zero (p = 0) and a pair (q = -p) meet at the origin, where branches cross."""
    family = two_lines(2.0, other)
    axes: dict[str, Any] = {"x": ("p", -1, 1, 3), "y": ("q", -1, 1.5, 3)}
    if not other:
        found = st.codimension_two(family, **axes)
        assert found.complete
        [point] = found
        assert (point.kind.word, point.x, point.y) == ("zero hopf", 0.0, 0.0)
        return
    with pytest.warns(st.StabilityWarning, match="not complete"):
        found = st.codimension_two(family, **axes)
    assert not found.complete
    assert not found.vanishing_complete
    assert any("several branches" in box.reason for box in found.unresolved)
    for point in found:
        member = float(st.spectrum(family, at=point.x, q=point.y).states[0])
        assert member == pytest.approx(point.x, abs=1e-9)


def test_a_factor_without_members_is_no_other_branch() -> None:
    """Where sin x = 0 the second equation, cos x = b, leaves z free: no member is isolated."""
    x, b = ca.SX.sym("x", 2), ca.SX.sym("b")
    rates = ca.vertcat(ca.sin(x[0]) * (x[1] * ca.cos(x[0]) - 1), b - ca.cos(x[0]))
    system = st.System("swing", x, b, rates, states=("x", "z"), parameters=("b",))
    family = st.Family(
        system,
        "m",
        at=("b",),
        unknown={"x": 1.0, "z": 2.0},
        equations=("x", "z"),
        typical={"b": 0.5},
    )
    found = st.conditions(family)
    assert found.branch == ""
    for value in (0.3, 0.7):
        slope = np.array([[0.0, value * np.sqrt(1 - value**2)], [np.sqrt(1 - value**2), 0.0]])
        slope[0, 0] = -np.sqrt(1 - value**2) * np.sqrt(1 - value**2) / value
        right = "stable" if np.linalg.eigvals(slope).real.max() < 0 else "unstable"
        assert found.verdict(value).word == right
