"""Boundaries along a branch of steady motions that is followed from a known member."""

from __future__ import annotations

import math

import casadi as ca
import numpy as np
import pytest

import stability as st
from stability.base.errors import StabilityWarning
from stability.boundary import changes
from stability.boundary.algebraic import exact_search
from stability.boundary.interval_search import pieces


def skew_bead() -> dict[str, st.Family]:
    """A bead on a hoop that turns about an axis off its centre: two, later four motions."""
    x, p = ca.SX.sym("x", 2), ca.SX.sym("p", 2)
    pull = p[0] ** 2 * (ca.sin(x[0]) + 0.5) * ca.cos(x[0]) - 9.81 * ca.sin(x[0])
    system = st.System(
        "bead",
        x,
        p,
        ca.vertcat(x[1], pull - p[1] * x[1]),
        states=("angle", "rate"),
        parameters=("turn", "damping"),
    )
    guesses = {"out": (0.5, 3.0), "in": (-2.5, 9.0)}
    return {
        n: system.steady("turn", guess={"angle": a, "turn": w, "damping": 0.3}, name=n)
        for n, (a, w) in guesses.items()
    }


@pytest.mark.few(1)
@pytest.mark.parametrize("name", ["out", "in"])
@pytest.mark.parametrize("ends", [(0.5, 10), (6.7, 10), (0.5, 6)])
def test_a_fold_of_other_motions_leaves_a_branch_complete(
    name: str, ends: tuple[float, float]
) -> None:
    family = skew_bead()[name]
    found = st.boundaries(family, axis=("turn", *ends, 20), damping=0.3)
    assert found.complete and len(found) == 0
    for turn in np.linspace(*ends, 9):  # the slope of the pull along the branch, by hand
        angle = float(family.member([turn], [0.3])[0])
        slope = turn**2 * (math.cos(2 * angle) - 0.5 * math.sin(angle)) - 9.81 * math.cos(angle)
        assert (slope < 0) == (name == "out")


@pytest.mark.long
def test_what_the_exact_search_leaves_open_is_searched_in_pieces(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    family = skew_bead()["out"]
    monkeypatch.setattr(
        exact_search.BranchMembers, "_label", lambda *_: None
    )  # it recognises no branch
    found = st.boundaries(family, axis=("turn", 0.5, 6.0, 20), damping=0.3)
    assert found.complete and len(found) == 0 and "pieces" in found.how
    monkeypatch.setattr(changes, "proved", lambda line, grid, **_: pieces.scanned(line, grid, "no"))
    with pytest.warns(StabilityWarning, match="no verdict is proved at the values tried"):
        assert not st.boundaries(family, axis=("turn", 0.5, 6.0, 20), damping=0.3).complete


POLES = {
    "cosine": (lambda p: ca.cos(p) - 0.5 * p, lambda p: math.cos(p) - 0.5 * p),
    "exponential": (
        lambda p: ca.exp(p) - 2 * ca.cos(p) - p,
        lambda p: math.exp(p) - 2 * math.cos(p) - p,
    ),
}


@pytest.mark.parametrize("name", list(POLES))
def test_a_pole_of_a_transcendental_rate_is_no_boundary_and_stays_open(name: str) -> None:
    """The eigenvalue 1/g(p) changes its sign through infinity where g vanishes."""
    graph, number = POLES[name]
    x, p = ca.SX.sym("x"), ca.SX.sym("p")
    system = st.System("s", x, p, x / graph(p), states=("x",), parameters=("p",))
    family = st.Family(system, "f", ("p",), held={"x": 0.0})
    with pytest.warns(StabilityWarning, match="has no value"):
        found = st.boundaries(family, axis=("p", 0, 2, 5))
    [gap] = found.unresolved
    assert len(found) == 0 and 0 < gap.low < gap.high < gap.low + 1e-12
    assert number(gap.low) * number(gap.high) < 0
