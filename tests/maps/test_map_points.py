"""Points of codimension two in a map: in memory, in its file, on the figure, on the command line.

Oracles: a zero with a pair of the spinning disk at at = 2, mu = 1 (factors by hand, see
tests/boundary/test_codimension_two.py); a normal form with a planted change from soft to hard.
"""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import casadi as ca
import matplotlib
import numpy as np
import pytest

import stability as st
from stability.cli.commands import main
from stability.maps.dataset import points_of
from stability.maps.files import read_map, write_map

matplotlib.use("Agg")


def planted(units: dict[str, str]) -> st.Family:
    """Soft to hard at (1/16, 1/4), and a boundary whose eigenvalue -1 + 2 p vanishes at p = 1/2."""
    x, p = ca.SX.sym("x", 3), ca.SX.sym("p", 2)
    r, s, c = x[0] ** 2 + x[1] ** 2, p[1] - 0.25, p[0] - p[1] ** 2
    rates = ca.vertcat(
        c * x[0] - 2 * x[1] + s * r * x[0],
        2 * x[0] + c * x[1] + s * r * x[1],
        (2 * p[0] - 1) * x[2],
    )
    system = st.System(
        "planted", x, p, rates, states=("u", "v", "w"), parameters=("p", "q"), units=units
    )
    return st.Family(system, "rest", at=("p",), held=dict.fromkeys("uvw", 0))


AXES: Any = {"x": ("p", -0.5, 1, 7), "y": ("q", -0.25, 1, 6)}


@pytest.fixture(scope="module")
def dataset() -> Any:
    return st.stability_map(planted({"p": "1/s", "q": "m", "time": "s"}), points=True, **AXES)


def test_points_are_variables_with_units_bounds_and_kinds(dataset: Any) -> None:
    assert dataset.sizes["point"] == 2
    kinds = dict(
        zip(
            dataset.point_kind.flag_values.tolist(),
            dataset.point_kind.flag_meanings.split(),
            strict=True,
        )
    )
    found = [
        (kinds[int(k)], float(x), float(y))
        for k, x, y in zip(dataset.point_kind, dataset.point_p, dataset.point_q, strict=True)
    ]
    assert found[0][:2] == ("zero_hopf", 0.5) and abs(found[0][2] - 0.5**0.5) < 1e-15
    assert found[1] == ("vanishing", 0.0625, 0.25)
    assert dataset.point_p.units == dataset.point_p_error.units == "1/s"
    assert dataset.point_q.units == "m" and float(dataset.point_q_error[1]) < 1e-30
    assert dataset.point_frequency.units == dataset.abscissa.units
    assert dataset.point_frequency.values[:, 0] == pytest.approx([2, 2])
    assert np.isnan(dataset.point_frequency.values[:, 1]).all()
    assert dataset.points_complete == dataset.points_vanishing_complete == 1
    assert "over Q" in dataset.points_how and "over Q" in dataset.points_vanishing


def test_points_survive_the_file_and_are_those_of_codimension_two(
    dataset: Any, tmp_path: Path
) -> None:
    back = read_map(write_map(dataset, tmp_path / "map.nc"))
    assert back.identical(dataset)
    asked = st.codimension_two(planted({}), **AXES)
    for one in (points_of(dataset), points_of(back)):
        assert one is not None and list(one) == list(asked) and one.axes == asked.axes
        assert one.statement == asked.statement
        assert (one.complete, one.vanishing_complete) == (True, True)


def test_what_stays_open_survives_the_file_too(tmp_path: Path) -> None:
    x, p = ca.SX.sym("x", 2), ca.SX.sym("p", 2)
    rates = ca.vertcat(x[1], -(p[0] ** 2 + p[1] ** 2) * x[0] - p[0] * x[1])
    system = st.System("flat", x, p, rates, states=("u", "v"), parameters=("p", "q"))
    family = st.Family(system, "rest", at=("p",), held={"u": 0, "v": 0})
    found = st.stability_map(family, x=("p", -1, 1, 4), y=("q", -1, 1, 4), points=True)
    one = points_of(read_map(write_map(found, tmp_path / "map.nc")))
    assert one is not None and not one.complete and "not simple" in one.statement
    [box] = one.unresolved
    assert box.x[0] <= 0 <= box.x[1] and found.sizes["point"] == 0


def test_a_map_without_points_has_none_and_its_figure_marks_those_that_it_has(dataset: Any) -> None:
    plain = st.stability_map(planted({}), **AXES)
    assert points_of(plain) is None and "point_kind" not in plain
    [line] = [a for a in st.plot_map(dataset).axes[0].lines if a.get_label() == "soft to hard"]
    assert (line.get_xdata()[0], line.get_ydata()[0]) == (0.0625, 0.25)


@pytest.mark.long
def test_the_command_finds_marks_and_lists_points(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    out, plot = tmp_path / "m.nc", tmp_path / "m.svg"
    asked = ["map", "spinning", "--x", "at:1:4:7", "--y", "mu:0.1:2:6", "--points", "--out"]
    assert main([*asked, str(out), "--plot", str(plot), "--json"]) == 0
    record = json.loads(capsys.readouterr().out)["points"]
    [row] = record["rows"]
    assert (row["kind"], row["x"], row["y"]) == ("zero hopf", 2, 1) and record["complete"]
    one = points_of(read_map(out))
    assert one is not None and [(p.x, p.y) for p in one] == [(2, 1)] and plot.exists()
    assert main([*asked, str(out), "--force"]) == 0
    assert "zero hopf: at = 2 ± " in capsys.readouterr().out
    assert main([*asked, str(tmp_path / "n.nc"), "--verdict-only"]) == 2
    assert "--points does not go with --verdict-only" in capsys.readouterr().err


def test_a_family_without_such_points_is_refused_before_any_work() -> None:
    x, p = ca.SX.sym("x", 2), ca.SX.sym("p", 2)
    rates = ca.vertcat(x[1], -p[0] * p[1] * x[0])
    system = st.System("swing", x, p, rates, states=("u", "v"), parameters=("k", "m"))
    swing = st.Family(system, "rest", at=("k",), held={"u": 0, "v": 0}, conservative=True)
    with pytest.raises(st.StabilityError, match="conservative"):
        st.stability_map(swing, x=("k", 1, 2, 2), y=("m", 1, 2, 2), points=True)
