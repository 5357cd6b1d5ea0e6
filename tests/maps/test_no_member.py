"""Maps in whose cells some members do not exist: a flag, no number, and the rest as always."""

from pathlib import Path
from typing import Any

import casadi as ca
import h5py
import numpy as np
import pytest

import stability as st

AXES: dict[str, Any] = {"x": ("r", 0.5, 40, 12), "y": ("b", 0.5, 4, 6)}


@pytest.fixture(scope="module")
def plus() -> Any:
    x, p = ca.SX.sym("x", 3), ca.SX.sym("p", 3)
    rates = ca.vertcat(p[0] * (x[1] - x[0]), x[0] * (p[1] - x[2]) - x[1], x[0] * x[1] - p[2] * x[2])
    system = st.System("L", x, p, rates, states=("x", "y", "z"), parameters=("sigma", "r", "b"))
    guess = {"x": 8, "y": 8, "z": 27, "r": 28, "sigma": 10, "b": 8 / 3}
    return system.steady("r", guess=guess, name="C+")


@pytest.fixture(scope="module")
def lorenz(plus: Any) -> Any:
    return st.stability_map(plus, **AXES, sigma=10, modes=True)


def test_a_map_says_where_no_member_exists_and_draws_the_rest(lorenz: Any) -> None:
    """C+ exists for r > 1; it is stable below r = σ(σ+b+3)/(σ-b-1)."""
    flags = dict(
        zip(
            lorenz.verdict.attrs["flag_meanings"].split(),
            lorenz.verdict.attrs["flag_values"].tolist(),
            strict=True,
        )
    )
    assert flags == {
        "undecided": 0,
        "stable": 1,
        "unstable": 2,
        "neutral": 3,
        "drifting": 5,
        "no_member": 4,
    }
    r, b = np.meshgrid(lorenz.r.values, lorenz.b.values)
    hopf = 10 * (10 + b + 3) / (10 - b - 1)
    wanted = np.where(r <= 1, 4, np.where(r < hopf, 1, 2))
    assert (lorenz.verdict.values == wanted).all()
    assert lorenz.attrs["no_member"] == "6 of 72 cells have no member"
    missing = lorenz.verdict.values == 4
    for name in ("abscissa", "abscissa_error", "frequency", "eigenvalues"):
        cells = lorenz[name].values.reshape(*missing.shape, -1)
        assert np.isnan(cells[missing]).all()
        assert np.isfinite(cells[~missing]).all()


def test_boundary_curves_leave_out_the_edge_of_existence(lorenz: Any) -> None:
    r, b = lorenz.boundary_r.values, lorenz.boundary_b.values
    assert len(r) >= 6
    assert np.abs(r - 10 * (10 + b + 3) / (10 - b - 1)).max() < 1e-13
    assert lorenz.attrs["boundary_unresolved"] == 0


def test_missing_numbers_survive_the_file_as_a_fill_value(lorenz: Any, tmp_path: Path) -> None:
    path = st.write_map(lorenz, tmp_path / "map.nc")
    assert st.read_map(path).identical(lorenz)
    with h5py.File(path) as file:
        assert file["abscissa"].attrs["_FillValue"] == file["abscissa"][0, 0] > 9e36
        assert np.isfinite(file["abscissa"][()]).all()
        assert file["verdict"][0, 0] == 4


def test_the_figure_names_the_empty_region(plus: Any) -> None:
    found = st.stability_map(plus, x=("r", -20, 20, 21), y=("b", 0.5, 4, 9), sigma=10)
    figure = st.plot_map(found)
    words = {t.get_text() for t in figure.axes[0].texts}
    assert {"no member", "stable"} <= words
    r, b = np.meshgrid(found.r.values, found.b.values)
    stable = int(((r > 1) & (r < 10 * (13 + b) / (9 - b))).sum())
    counts = {code: int((found.verdict == code).sum()) for code in (1, 2, 4)}
    assert counts == {1: stable, 2: 90 - stable, 4: 99}


def test_a_map_without_any_member_is_refused(plus: Any) -> None:
    with pytest.raises(st.StabilityError, match="stopped at a pitchfork at r = 1"):
        st.stability_map(plus, x=("r", -5, 0.5, 4), y=("b", 0.5, 4, 4), sigma=10)


def test_a_map_goes_on_from_its_checkpoint(plus: Any, lorenz: Any, tmp_path: Path) -> None:
    for _ in range(2):
        found = st.stability_map(plus, **AXES, sigma=10, modes=True, checkpoint=tmp_path / "parts")
        assert (found.verdict == lorenz.verdict).all()
        assert found.abscissa.equals(lorenz.abscissa)


def test_a_plain_family_and_a_failing_condition_leave_cells_out_too() -> None:
    """√p exists for p > 0; the condition asks for x > 1, that is p > 1."""
    x, p = ca.SX.sym("x"), ca.SX.sym("p", 2)
    for conditions, least in (((), 0.0), ((st.Condition(x - 1, "x - 1 is {value}"),), 1.0)):
        system = st.System(
            "root",
            x,
            p,
            p[1] * (p[0] - x**2),
            states=("x",),
            parameters=("p", "c"),
            conditions=conditions,
        )
        family = st.Family(
            system, "upper", at=("p",), unknown={"x": 1.5}, equations=("x",), positive=("x",)
        )
        found = st.stability_map(family, x=("p", -1.05, 3.95, 11), y=("c", 0.5, 2, 3))
        wanted = np.where(found.p.values > least, 1, 4)
        assert (found.verdict.values == wanted).all()
        kept = found.abscissa.where(found.p > least, drop=True)
        assert np.allclose(kept, -2 * found.c * np.sqrt(kept.p), rtol=1e-12)


def test_maps_with_all_members_have_the_flags_of_before() -> None:
    found = st.stability_map("spinning", x=("at", 1, 4, 5), y=("mu", 0.1, 2, 5))
    assert found.verdict.attrs["flag_meanings"] == "undecided stable unstable neutral drifting"
    assert "no_member" not in found.attrs
