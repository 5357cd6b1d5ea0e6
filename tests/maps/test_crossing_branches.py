"""Maps over a line on which two steady motions meet: cells on the line stay open, others do not."""

from __future__ import annotations

import casadi as ca
import numpy as np
import pytest
import xarray as xr

import stability as st
from stability.base.verdict import CODES, NO_MEMBER


def crossing(sign: int, *, damping: bool) -> st.Family:
    """Branches y = p and y = q; Newton's method from above reaches the larger one."""
    x, p = ca.SX.sym("x", 3), ca.SX.sym("P", 2)
    rates = ca.vertcat(sign * (x[0] - p[0]) * (x[0] - p[1]), x[2], -2 * x[1] + (x[0] - 0.3) * x[2])
    names, held = (("y", "u", "v"), {"u": 0.0, "v": 0.0}) if damping else (("y",), {})
    n = len(names)
    system = st.System("crossing", x[:n], p, rates[:n], states=names, parameters=("p", "q"))
    return st.Family(
        system,
        "larger",
        at=("p",),
        held=held,
        unknown={"y": 3.0},
        equations=("y",),
        typical={"p": 1.0, "q": -1.0},
    )


@pytest.mark.parametrize("damping", [False, True])
@pytest.mark.parametrize("sign", [-1, 1])
def test_a_cell_where_branches_cross_does_not_end_the_map(sign: int, *, damping: bool) -> None:
    family = crossing(sign, damping=damping)

    def asked(*, boundaries: bool) -> xr.Dataset:
        axes = {"x": ("p", -1, 1, 5), "y": ("q", -1, 1, 5)}
        return st.stability_map(family, **axes, boundaries=boundaries)

    plain, *traced = (asked(boundaries=b) for b in (False, True, True))
    for one in traced:
        assert np.array_equal(one.verdict.values, plain.verdict.values)
    p, q = np.meshgrid(np.linspace(-1, 1, 5), np.linspace(-1, 1, 5))
    top, codes = np.maximum(p, q), plain.verdict.values
    stable = (top < (0.3 if damping else np.inf)) & (sign < 0)
    right = np.where(stable, CODES[st.Verdict.STABLE], CODES[st.Verdict.UNSTABLE])
    assert np.array_equal(codes[p != q], right[p != q])
    open_ = [CODES[st.Verdict.UNDECIDED], NO_MEMBER, *([CODES[st.Verdict.UNSTABLE]] * damping)]
    assert np.isin(codes[p == q], open_).all()
    if sign < 0 and damping:  # the boundary max(p, q) = 0.3 has a point on each edge that it cuts
        found = np.maximum(traced[0].boundary_p.values, traced[0].boundary_q.values)
        assert len(found) >= 4
        assert found == pytest.approx(0.3, abs=1e-12)
