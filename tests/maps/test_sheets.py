"""Numbers of equilibria in the cells of a map, on all sheets.

Oracles: the discriminant of a cubic in exact fractions, and closed forms.
"""

from fractions import Fraction
from itertools import product
from pathlib import Path
from typing import Any

import casadi as ca
import numpy as np
import pytest
from own_systems import system_of

import stability as st

x, y, z, a, b = (ca.SX.sym(n) for n in "xyzab")


def cusp() -> st.Family:
    rate = a + b * x - x**3
    system = st.System("cusp", x, ca.vertcat(a, b), rate, states=("x",), parameters=("a", "b"))
    return system.steady("b", guess={"x": 1, "b": 1}, a=0.1)


def test_counts_of_a_cusp_are_those_of_its_discriminant(tmp_path: Path) -> None:
    m = st.stability_map(
        cusp(), x=("a", -4, 4, 33), y=("b", -1, 4, 21), box={"x": (-5, 5)}, boundaries=False
    )
    signs = [
        [
            (d > 0) - (d < 0)
            for d in (4 * Fraction(q) ** 3 - 27 * Fraction(p) ** 2 for p in m.a.values)
        ]
        for q in m.b.values
    ]
    sign = np.array(signs)
    assert (sign == 0).sum() == 5  # (0, 0), (±2, 3) and (±1/4, 3/4), where equilibria are multiple
    assert np.array_equal(m.equilibria, np.choose(sign + 1, [1, -1, 3]))
    # a root of a scalar rate that falls there is stable
    assert np.array_equal(m.stable_equilibria, np.choose(sign + 1, [1, -1, 2]))
    assert m.equilibria.dtype.kind == "i"
    assert "not proved, in 5 of 693 cells" in m.equilibria.comment
    assert st.read_map(st.write_map(m, tmp_path / "m.nc")).identical(m)


@pytest.mark.parametrize("held", [{}, {"y": 0}])
def test_counts_leave_out_what_is_outside_the_box_or_fails_a_condition(
    held: dict[str, float],
) -> None:
    # z moves and acts on nothing; y rests at 0 alone, where an eigenvalue is a - 2
    rates = {"x": b * x - x**3, "z": a * x} | {n: (a - 2) * y for n in held}
    system = st.System(
        "apart",
        ca.vertcat(*[{"x": x, "y": y, "z": z}[n] for n in rates]),
        ca.vertcat(a, b),
        ca.vertcat(*rates.values()),
        states=tuple(rates),
        parameters=("a", "b"),
        conditions=(st.Condition(x + 1.5, "x + 1.5 is positive"),),
    )
    family = system.steady("b", guess={"x": 1, "b": 1}, a=1, held=held)
    m = st.stability_map(
        family, x=("a", 1, 3, 5), y=("b", -0.9, 4.1, 6), box={"x": (-3, 2)}, boundaries=False
    )
    root = np.sqrt(np.maximum(m.b.values, 0))
    outer = (root > 0) * ((root < 2) * 1 + (root < 1.5))
    assert np.array_equal(m.equilibria, np.tile((1 + outer)[:, None], 5))
    stable = np.where(m.b.values < 0, 1, outer)[:, None] * np.ones(5, dtype=int)
    if held:  # where a = 2 an eigenvalue is 0, by exact numbers or not proved
        stable[:, m.a.values > 2] = 0
        stable[:, m.a.values == 2] = np.minimum(m.stable_equilibria[:, m.a.values == 2], 0)
    assert np.array_equal(m.stable_equilibria, stable)


def test_counts_of_cells_are_those_of_one_search_each() -> None:
    rates = ca.vertcat(x * (1 - x - a * y - b * x**2), y * (1 - y - a * x - b * y**2))
    system = system_of("rivals", [x, y], [a, b], rates)
    even = system.steady("a", guess={"x": 0.6, "y": 0.6, "a": 0.5}, b=0.1)
    box = {"y": (-0.1, 1.2), "x": (-0.1, 1.1)}
    m = st.stability_map(even, x=("a", 0.1, 3, 3), y=("b", 0.01, 0.5, 2), box=box, boundaries=False)
    for (i, q), (j, p) in product(enumerate(m.b.values), enumerate(m.a.values)):
        one = system.equilibria(box, a=p, b=q)
        assert one.complete and len(one) == m.equilibria[i, j]
        assert sum(v.word == "stable" for v in one.verdicts) == m.stable_equilibria[i, j]


@pytest.mark.parametrize(
    ("box", "words"),
    [
        ({"z": (0, 1)}, "box names z; give (low, high)"),
        ({}, "box names no state; give (low, high)"),
        ({"x": 2}, "box x is 2; give (low, high)"),
        ({"x": (1, 0)}, "box x from 1 to 0 is empty"),
        ({"x": (0, float("nan"))}, "box x is nan"),
        (3, "box is 3; give a mapping"),
    ],
)
def test_a_bad_box_of_a_map_is_refused_in_a_sentence(box: Any, words: str) -> None:
    with pytest.raises(st.StabilityError) as refusal:
        st.stability_map(cusp(), x=("a", -1, 1, 3), y=("b", -1, 1, 3), box=box)
    assert words in str(refusal.value)


def test_a_box_belongs_to_families_that_are_solved_for() -> None:
    with pytest.raises(st.StabilityError, match="no states that are solved for"):
        st.stability_map("spinning", x=("at", 1, 4, 3), y=("mu", 1, 2, 3), box={"x": (0, 1)})


def test_stable_counts_are_open_where_a_zero_is_one_by_structure() -> None:
    """A held y has y' = 0: the verdict of a member leaves this zero out, a count has no member."""
    rate = ca.vertcat(a + b * x - x**3, 0 * y)
    system = system_of("kept", [x, y], [a, b], rate)
    family = system.steady("b", guess={"x": 1, "b": 1}, a=0.1, held={"y": 0})
    m = st.stability_map(
        family, x=("a", -1, 1, 4), y=("b", 0, 1, 2), box={"x": (-3, 3)}, boundaries=False
    )
    assert m.equilibria.values.tolist() == [[1, 1, 1, 1], [1, 3, 3, 1]]
    assert (m.verdict == st.Verdict.STABLE.code).any()
    assert (m.stable_equilibria == -1).all()
