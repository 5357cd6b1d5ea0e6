"""Maps whose members turn, end or stand in the shadow of a cusp: each verdict is of its branch."""

from typing import Any

import casadi as ca
import numpy as np
import pytest
import sympy as sp
from real_sheets import P, Q, Sheets, X

import stability as st

CUSP = P + Q * X - X**3
CASES: dict[str, tuple[Any, Any, tuple[float, float], float, float, float]] = {
    # rate of x, rate of a second state per unit, start (p, q), x there, ranges of p and q
    "hysteresis": (CUSP, -X - sp.Rational(1, 3), (-2.0, 1.0), -1.6, 3.0, 2.0),
    "cusp, from three members": (CUSP, X - 1, (0.0, 3.0), 1.7, 3.0, 4.1),
    "cusp, from one member": (CUSP, X - sp.Rational(1, 5), (0.3, -2.0), 0.15, 3.0, 4.1),
    "shadow of a cusp": (CUSP, X - sp.Rational(1, 5), (2.0, -1.9), 0.9, 1.0, 2.1),
    "isola": ((X - 2) ** 2 + P**2 - Q, X - sp.Rational(5, 4), (0.0, 1.0), 1.0, 1.9, 2.9),
    "through infinity": (1 - P * X, X - Q, (1.0, 2.0), 1.0, 2.9, 3.0),
    "through infinity and back": (1 - P**2 * X, X - Q, (1.0, 2.0), 1.0, 2.9, 3.0),
    "narrow peak": (1 - (P**2 + sp.Rational(1, 1000)) * X, X - Q, (1.0, 2.0), 1.0, 2.9, 3.0),
    "narrow gap": (P**2 + sp.Rational(1, 1000) - X**2, X - 1, (1.0, 1.0), 1.0, 2.0, 1.0),
    "mushroom": (
        -((X**2 - 1) ** 2) - P**2 + Q + X / 10,
        X - sp.Rational(11, 10),
        (0.0, 0.5),
        1.3,
        1.4,
        1.6,
    ),
    "butterfly": (P + Q * X + 2 * X**3 - X**5, X - sp.Rational(3, 2), (0.0, 0.5), 1.48, 1.5, 1.5),
}
NONE = 4


def built(rate: Any, other: Any) -> Any:
    """The system x' = rate, y' = other · y."""
    x, p = ca.SX.sym("x", 2), ca.SX.sym("p", 2)
    values = [sp.lambdify((X, P, Q), f, "math")(x[0], p[0], p[1]) for f in (rate, other)]
    return st.System(
        "planted",
        x,
        p,
        ca.vertcat(values[0], values[1] * x[1]),
        states=("x", "y"),
        parameters=("p", "q"),
    )


@pytest.mark.few(2)
@pytest.mark.parametrize("name", CASES)
def test_each_verdict_is_that_of_the_member_which_a_straight_line_reaches(name: str) -> None:
    rate, other, start, guess, wide, high = CASES[name]
    family = built(rate, other).steady(
        ("p", "q"), held={"y": 0.0}, guess={"x": guess, "p": start[0], "q": start[1]}
    )
    found = st.stability_map(family, x=("p", -wide, wide, 6), y=("q", -high / 2, high, 4))
    sheets = Sheets(sp.expand(rate))
    rates = sp.lambdify((X, P, Q), [sp.diff(rate, X), other], "mpmath")
    kinds = set()
    for i, q in enumerate(found.q.values):
        for j, p in enumerate(found.p.values):
            said, abscissa = int(found.verdict.values[i, j]), float(found.abscissa.values[i, j])
            x = sheets.follow(start, family.anchor.unknown[0], (p, q))
            alone = bool(family.search([[p, q]], [[]]).good[0])
            assert alone == (said != NONE), (p, q)
            if x is None:
                assert said == NONE, (p, q, said)
                kinds.add(NONE)
                continue
            largest = max(rates(x, p, q))
            assert said == (st.Verdict.STABLE if largest < 0 else st.Verdict.UNSTABLE).code, (p, q)
            assert abscissa == pytest.approx(float(largest), rel=1e-7)
            kinds.add(said)
    assert len(kinds) > 1


def test_samples_of_the_structure_stay_on_the_sheet() -> None:
    """The members x² = q - p² about p = 0, q = 1e-4 fill a disc that typical sizes leave."""
    system = built(Q - P**2 - X**2, sp.Integer(-1))
    small = system.steady(("p", "q"), held={"y": 0.0}, guess={"x": 0.01, "p": 0.0, "q": 1e-4})
    found = st.spectrum(small, at=[0.0, 1e-4], certify=True)
    assert found.eigenvalues.real == pytest.approx([-1.0, -0.02], rel=1e-12)


def test_a_cell_without_a_member_says_why() -> None:
    rate, other, start, guess, *_ = CASES["isola"]
    family = built(rate, other).steady(
        ("p", "q"), held={"y": 0.0}, guess={"x": guess, "p": start[0], "q": start[1]}
    )
    said = family.search(np.array([[2.0, 1.0]]), np.zeros((1, 0))).why(0)
    assert "it stopped at a fold at p = 1, where this branch turns; branch with arc" in said


def test_on_the_line_through_a_cusp_the_end_is_called_a_cusp() -> None:
    """On one side of this line x³ = q x + p is followed to x < 0, on the other it ends at a fold.

    So the members next to a cell on the line are of two kinds, and the line itself decides nothing.
    """
    rate, other, start, guess, *_ = CASES["cusp, from one member"]
    family = built(rate, other).steady(
        ("p", "q"), held={"y": 0.0}, guess={"x": guess, "p": start[0], "q": start[1]}
    )
    cells = np.array([[-0.3 - 1e-3, 2.0], [-0.3, 2.0], [-0.3 + 1e-3, 2.0]])
    found = family.search(cells, np.zeros((3, 0)))
    assert found.good.tolist() == [True, False, False]
    lowest = Sheets(sp.expand(rate)).real(tuple(cells[0]))[0]
    assert found.u[0, 0] == pytest.approx(float(lowest), abs=1e-10)
    assert "it stopped at a cusp at p = 0, q = 0, through which this line runs" in found.why(1)
    assert "it stopped at a fold at" in found.why(2)
    near = family.search(np.array([[-0.3 - 1e-12, 2.0]]), np.zeros((1, 0)))
    assert near.good[0] or "changes too fast to follow" in near.why(0)
