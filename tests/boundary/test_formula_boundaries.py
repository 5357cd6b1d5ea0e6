"""Boundaries from formulas against those of the graph, and against exact thresholds."""

from __future__ import annotations

from itertools import pairwise
from typing import Any

import numpy as np
import pytest

import stability as st
from stability.algebra.exact.routh import expanded_determinant, hurwitz_matrix
from stability.algebra.number_types import precision
from stability.base.errors import NoMemberError
from stability.bodies.subject import subject_of
from stability.boundary import brackets
from stability.boundary.interval_search.meetings import FormulaMeetings
from stability.boundary.interval_search.quick_pieces import quick_pieces
from stability.spectra.problem import problem_of
from stability.spectra.spectrum import spectrum
from stability.spectra.verdict_routes import BITS

CASES: list[tuple[st.Body, str, dict[str, Any]]] = [
    (st.Torus(0.2), "tumbling", {"axis": ("theta", 0.1, 1.5, 9), "contact": "viscous", "mu": 0.3}),
    (
        st.ThickDisk(0.1),
        "precession",
        {"axis": ("theta", 0.3, 1.3, 9), "at": 1.7, "contact": "smooth"},
    ),
    (
        st.Spheroid(0.6),
        "tumbling",
        {"axis": ("mu", 0.05, 2.0, 9), "at": 2.55, "contact": "viscous"},
    ),
]


@pytest.mark.long
@pytest.mark.parametrize(("body", "family", "ask"), CASES, ids=["torus", "thick disk", "spheroid"])
def test_boundaries_are_those_of_the_graph(
    body: st.Body, family: str, ask: dict[str, Any], monkeypatch: pytest.MonkeyPatch
) -> None:
    fast = st.boundaries(family, body=body, **ask)
    monkeypatch.setattr(brackets, "formulas_of", lambda _: None)
    slow = st.boundaries(family, body=body, **ask)
    assert fast.complete
    assert len(fast) == len(slow) > 0
    for ours, true in zip(fast, slow, strict=True):
        assert abs(ours.value - true.value) <= ours.error + true.error
        assert (ours.crossing, ours.stable_below) == (true.crossing, true.stable_below)
        assert ours.frequency == pytest.approx(true.frequency, abs=1e-10)


@pytest.mark.long
def test_both_sides_of_a_boundary_have_proved_verdicts() -> None:
    body, family, ask = CASES[0]
    [point] = st.boundaries(family, body=body, **ask)
    sides = [
        spectrum(
            family,
            at=point.value * (1 + 1e-12 * way),
            body=body,
            contact="viscous",
            mu=0.3,
            certify=True,
        ).verdict
        for way in (-1, 1)
    ]
    assert set(sides) == {"stable", "unstable"}
    assert (sides[0] == "stable") == point.stable_below


@pytest.mark.parametrize("log", [False, True])
def test_pieces_proved_in_doubles_hold_what_they_say(log: bool) -> None:
    """Signs at many points, in balls: one on each clear piece, and one change on a single piece."""
    family = st.Torus(0.2).family("tumbling", "viscous")
    line = brackets.AxisScan(
        problem_of(subject_of(family, parameters={"tube": 0.2, "mu": 0.3})),
        "theta",
        {"tube": 0.2, "mu": 0.3},
    )
    assert line.formulas is not None
    functions = FormulaMeetings(line, line.formulas)
    found = quick_pieces(functions, 0.1, 1.5, log=log)
    assert found is not None
    assert not found.left
    clear = [leaf for leaf in found.leaves if leaf.meetings == 0]
    single = [leaf for leaf in found.leaves if leaf.meetings == 1]
    ends = sorted((leaf.low, leaf.high) for leaf in (*clear, *single))
    assert (ends[0][0], ends[-1][1]) == (0.1, 1.5)
    assert all(a[1] == b[0] for a, b in pairwise(ends))
    for one in clear:
        points = np.linspace(one.low, one.high, 3)
        assert len({tuple(functions._point_signs(float(v))) for v in points}) == 1
    for one in single:
        below, above = (functions._point_signs(v) for v in (one.low, one.high))
        assert sum(a != b for a, b in zip(below, above, strict=True)) == 1
        if one.near is not None:  # a pole has none
            near = [functions._point_signs(one.near[0] * (1 + way * 1e-15)) for way in (-1, 1)]
            assert near == [below, above]
    assert len(single) > 0


@pytest.mark.long
def test_no_member_leaves_a_part_open() -> None:
    """Upright a torus has no tumbling member: that part of the axis stays open."""
    with pytest.warns(st.StabilityWarning):
        found = st.boundaries(
            "tumbling", body=st.Torus(0.2), contact="rough", axis=("theta", 1.4, 1.7, 9)
        )
    assert not found.complete
    assert any(u.low <= 1.5707963267948966 <= u.high for u in found.unresolved)


def test_formulas_say_nothing_where_the_height_does_not_hold() -> None:
    """Beyond π/2 a thick disk lies on its other rim, where its formulas still have values."""
    family = st.ThickDisk(0.1).family("precession", "smooth")
    problem = problem_of(subject_of(family, parameters={"thickness": 0.1, "phi_dot": 1.7}))
    line = brackets.AxisScan(problem, "theta", problem.values)
    assert line.formulas is not None
    found = FormulaMeetings(line, line.formulas)
    with precision(BITS):
        assert found.piece(1.3, 1.4).forms
        with pytest.raises(NoMemberError):
            found.piece(1.6, 1.7)
    with pytest.raises(NoMemberError):
        line.coefficients(1.65, BITS)


def test_hurwitz_determinants_of_a_known_polynomial() -> None:
    # (λ + 1)(λ² + 1): a pair on the imaginary axis
    assert expanded_determinant(hurwitz_matrix([1, 1, 1, 1], 2, None)) == 0
    # (λ + 1)^3: 8 by Orlando's formula, the product of the sums of two roots up to sign
    assert expanded_determinant(hurwitz_matrix([1, 3, 3, 1], 2, None)) == 8
