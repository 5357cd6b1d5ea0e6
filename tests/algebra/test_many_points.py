"""Values of a graph at many points at once: machine code, NumPy, and CasADi's own evaluation."""

from __future__ import annotations

import sys

import casadi as ca
import numpy as np
import pytest

from stability.algebra.program import Program
from stability.integrators.taylor import available


def _function(kind: str) -> ca.Function:
    x, p = ca.SX.sym("x", 3), ca.SX.sym("p", 2)
    wide = ca.horzcat(ca.sin(x) / p[0], x * x[1], ca.SX(3, 1))  # 3 by 3, with zeros by structure
    last = ca.fabs(x[2]) if kind == "fabs" else ca.sqrt(x[2] ** 2 + p[1] ** 2)
    return ca.Function("f", [x, p], [wide, ca.vertcat(last, x[0] * p[1])])


@pytest.mark.parametrize("kind", ["smooth", "fabs", "without heyoka"])
def test_values_at_many_points_are_those_of_casadi(
    kind: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    if kind == "without heyoka":
        monkeypatch.setitem(sys.modules, "heyoka", None)
    elif not available():
        pytest.skip("heyoka is an extra")
    function, points = _function(kind), np.random.default_rng(1).uniform(0.5, 2.0, (5, 7))
    found = Program(function).many(points)
    assert found.shape == (11, 7)
    for column, mine in zip(points.T, found.T, strict=True):
        wide, tall = function(column[:3], column[3:])
        exact = np.concatenate([np.array(v.full()).ravel(order="F") for v in (wide, tall)])
        assert mine == pytest.approx(exact, rel=1e-14)
