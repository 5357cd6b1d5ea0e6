"""Cells of a map at which the rates have no slope: marked, and the rest of the map is drawn."""

from typing import Any

import casadi as ca
import numpy as np
import pytest
from own_systems import system_of

import stability as st

X, V, C, P = (ca.SX.sym(n) for n in ("x", "v", "c", "p"))
FORCES = {
    "a softened |x|": 3 * (ca.sqrt(P**2 + X**2) - ca.fabs(P)),
    "the same times exp(x)": 3 * (ca.sqrt(P**2 + X**2) - ca.fabs(P)) * ca.exp(X),
    "a softened hypot": 3 * (ca.hypot(P, X) - ca.fabs(P)),
}


@pytest.mark.few(1)
@pytest.mark.parametrize("force", FORCES)
@pytest.mark.parametrize("count", [5, 401])
def test_an_inner_row_without_a_slope_is_left_out(force: str, count: int) -> None:
    """λ² + c λ + 1 where p is not 0; at p = 0 the force has a kink."""
    system = system_of("s", [X, V], [C, P], [V, -X - C * V + FORCES[force]])
    family = st.Family(system, "rest", ("c",), held={"x": 0.0, "v": 0.0})
    found = st.stability_map(family, x=("c", -1, 2, 4), y=("p", -1, 1, count))
    words = found.verdict.attrs["flag_meanings"].split()
    flags: dict[str, Any] = dict(zip(words, found.verdict.attrs["flag_values"], strict=True))
    wanted = ["unstable", "neutral", "stable", "stable"]
    for p, row in zip(found.p.values, found.verdict.values, strict=True):
        assert row.tolist() == [flags[w if p else "no_member"] for w in wanted]
    assert np.isnan(found.abscissa.sel(p=0.0)).all()


def test_a_point_at_the_kink_is_refused_and_a_map_of_nothing_else_too() -> None:
    system = system_of("s", [X, V], [C, P], [V, -X - C * V + P * ca.fabs(X)])
    family = st.Family(system, "rest", ("c",), held={"x": 0.0, "v": 0.0})
    with pytest.raises(st.StabilityError, match="have no slope there"):
        st.spectrum(family, at=1.0, p=1.0)
    with pytest.raises(st.StabilityError, match="have no slope there"):
        st.stability_map(family, x=("c", -1, 2, 40), y=("p", 0.5, 1, 40))
