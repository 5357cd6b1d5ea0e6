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
from stability.boundary.brackets import AxisScan, refine
from stability.spectra.problem import system_problem

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
    line = AxisScan(system_problem(family, None, {"q": 0.5}), "p", {"q": 0.5})
    low, high = -0.7591, -0.7590957
    ends = [float(st.spectrum(family, at=p_, q=0.5).states[0]) for p_ in (low, high)]
    assert line.sign(low) * line.sign(high) < 0  # of members on two branches
    assert abs(ends[1] - ends[0]) > 1
    assert refine(line, low, high) is None
