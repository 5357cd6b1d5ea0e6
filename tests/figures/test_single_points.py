"""Boundary curves of a map on which one point alone has another kind than the rest."""

import casadi as ca
import numpy as np
import pytest

import stability as st
from stability.figures.diagram import _without_single_points


def column() -> st.Family:
    """Two equal oscillators under a load p and a follower force f."""
    x = ca.SX.sym("x", 4)
    k, c, p, f = (ca.SX.sym(n) for n in ("k", "c", "p", "f"))
    pull = -(k - p) * x[:2] - c * x[2:] + f * ca.vertcat(x[1], -x[0])
    system = st.System(
        "column",
        x,
        ca.vertcat(k, c, p, f),
        ca.vertcat(x[2:], pull),
        states=("x", "y", "u", "v"),
        parameters=("k", "c", "p", "f"),
    )
    return st.Family(system, "straight", at=("p",), held=dict.fromkeys(system.states, 0.0))


def test_a_static_end_of_a_flutter_boundary_is_drawn_as_flutter() -> None:
    """s² + c s + (k - p) ± i f = 0: flutter wherever f > 0, divergence at f = 0 and p = k alone."""
    found = st.stability_map(column(), x=("p", 0.0, 1.5, 20), y=("f", 0.0, 0.3, 12), k=1.0, c=0.2)
    kinds = found.boundary_kind.values
    assert len(np.unique(kinds)) == 2  # the file says both
    lines = [line for line in st.plot_map(found).axes[0].lines if len(line.get_xdata()) > 1]
    lengths = {
        style: sum(np.ptp(line.get_ydata()) for line in lines if line.get_linestyle() == style)
        for style in ("-", "--")
    }
    assert lengths["--"] > 0.1 and lengths["-"] == 0


@pytest.mark.parametrize(
    ("kind", "curve", "wanted"),
    [
        ([1, 2, 2], [0, 0, 0], [2, 2, 2]),
        ([2, 2, 1], [0, 0, 0], [2, 2, 2]),
        ([2, 2, 1, 2, 2], [0, 0, 0, 0, 0], [2, 2, 2, 2, 2]),
        ([2, 1, 2], [0, 0, 0], [2, 1, 2]),  # no line has a kind that is known
        ([1, 1, 2, 2], [0, 0, 0, 0], [1, 1, 2, 2]),
        ([1, 2, 2], [0, 1, 1], [1, 2, 2]),
    ],
)
def test_a_point_alone_has_the_kind_of_its_line(
    kind: list[int], curve: list[int], wanted: list[int]
) -> None:
    assert _without_single_points(np.array(kind), np.array(curve)).tolist() == wanted
