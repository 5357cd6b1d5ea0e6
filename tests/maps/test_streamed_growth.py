"""Growth maps streamed to Zarr: the numbers of `stability_map`, by any engine, after any end."""

import os
import re
import signal
import subprocess
import sys
from importlib.util import find_spec
from pathlib import Path
from typing import Any

import casadi as ca
import numpy as np
import pytest
from chunk_work import tree

import stability as st
from stability.jobs.dask import pool_of
from stability.maps.stream import no_rates

AXES: dict[str, Any] = {"x": ("at", 0.3, 3.2, 40), "y": ("mu", 0.1, 5, 30)}
NAMES = ("verdict", "abscissa", "abscissa_error", "frequency")
needs_numba = pytest.mark.skipif(find_spec("numba") is None, reason="numba is not installed")


@pytest.fixture(autouse=True)
def small(monkeypatch: pytest.MonkeyPatch) -> None:
    """Ten chunks to a map."""
    for name in ("BAND", "SWEPT_BAND", "CHUNK"):
        monkeypatch.setattr(f"stability.maps.cells.{name}", 120)


def own_family() -> st.Family:
    """A linear system of four states at rest, rational in two numbers."""
    x, p = ca.SX.sym("x", 4), ca.SX.sym("p", 2)
    a, b = p[0], p[1]
    rates = ca.vertcat(
        x[2],
        x[3],
        -(2 + b) * x[0] + (a * a - 1) * x[1] - (1 - a * b) * x[2],
        (1 - a) * x[0] - 3 * b * x[1] - a * x[2] - (0.5 + b) * x[3],
    )
    states = ("s0", "s1", "s2", "s3")
    system = st.System("own", x, p, rates, states=states, parameters=("a", "b"))
    return st.Family(system, "rest", at=("a",), held=dict.fromkeys(states, 0.0))


def lorenz() -> Any:
    """C+ of Lorenz's system, which exists for r > 1."""
    x, p = ca.SX.sym("x", 3), ca.SX.sym("p", 3)
    rates = ca.vertcat(p[0] * (x[1] - x[0]), x[0] * (p[1] - x[2]) - x[1], x[0] * x[1] - p[2] * x[2])
    system = st.System("L", x, p, rates, states=("x", "y", "z"), parameters=("sigma", "r", "b"))
    guess = {"x": 8, "y": 8, "z": 27, "r": 28, "sigma": 10, "b": 8 / 3}
    return system.steady("r", guess=guess, name="C+")


OWN: dict[str, Any] = {"x": ("a", -1.5, 2.0, 40), "y": ("b", -1.0, 1.7, 30)}


def both(family: Any, folder: Path, **words: Any) -> tuple[Any, Any]:
    """The streamed map and that of `stability_map`."""
    out = st.stream_map(family, **words, growth=True, out=folder / "g.zarr")
    return st.read_map(out), st.stability_map(family, **words, boundaries=False)


@pytest.mark.few(2)
@pytest.mark.parametrize(
    ("family", "words"),
    [
        ("rolling", AXES),
        ("spinning", {**AXES, "y": ("k", 0.1, 0.5, 30), "contact": st.Smooth()}),
        ("spinning", {**AXES, "body": st.Torus(0.2)}),
    ],
    ids=["rolling", "smooth", "torus"],
)
def test_numbers_are_those_of_the_map_to_the_last_bit(
    family: str, words: Any, tmp_path: Path
) -> None:
    found, whole = both(family, tmp_path, **words)
    assert len(list((tmp_path / "g.zarr" / "abscissa").glob("c.*"))) == 10
    assert sorted(map(str, found.data_vars)) == sorted(NAMES)
    for name in NAMES:
        np.testing.assert_array_equal(found[name].values, whole[name].values)
        assert found[name].dtype == whole[name].dtype
    for name in (*NAMES[1:], *found.coords):
        assert found[name].attrs == whole[name].attrs
    assert re.sub(r" \(\d+ of 1200 cells there\)", "", whole.method) == found.method
    assert len(np.unique(found.verdict)) > 1


def test_the_disks_verdicts_have_the_flags_of_its_map(tmp_path: Path) -> None:
    found, whole = both("rolling", tmp_path, **AXES)
    assert found.verdict.attrs.keys() == whole.verdict.attrs.keys()
    assert found.verdict.attrs["flag_meanings"] == whole.verdict.attrs["flag_meanings"]


@pytest.mark.few(1)
@pytest.mark.parametrize("open_", [False, True], ids=["usual", "open"])
def test_an_own_family_is_completed_chunk_by_chunk(
    open_: bool, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    if open_:  # discs that are never small enough: the graph completes every cell
        monkeypatch.setattr("stability.maps.rates.WANTED", 1e-18)
        monkeypatch.setattr("stability.maps.engine.MOST_POOR", 1.0)
    found, whole = both(own_family(), tmp_path, **OWN)
    assert found.method.startswith("characteristic polynomial of the family over Q")
    np.testing.assert_array_equal(found.verdict.values, whole.verdict.values)
    assert {1, 2} <= set(np.unique(found.verdict).tolist())
    for name in NAMES[1:]:
        assert np.isfinite(found[name].values).all()
    off = np.abs(found.abscissa.values - whole.abscissa.values)
    assert (off <= found.abscissa_error.values + whole.abscissa_error.values).all()


def test_cells_without_a_member_have_a_flag_and_no_number(tmp_path: Path) -> None:
    axes = {"x": ("r", 0.5, 40, 12), "y": ("b", 0.5, 4, 6)}
    found, whole = both(lorenz(), tmp_path, **axes, sigma=10)
    assert "no_member" in found.verdict.attrs["flag_meanings"].split()
    none = found.verdict.values == 4
    assert none.sum() == 6
    np.testing.assert_array_equal(found.verdict.values, whole.verdict.values)
    for name in NAMES[1:]:
        assert (np.isnan(found[name].values) == none).all()
        np.testing.assert_allclose(found[name].values, whole[name].values, rtol=1e-9, atol=1e-12)


@pytest.mark.long
def test_rows_longer_than_a_chunk(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("stability.maps.cells.BAND", 16)
    found, whole = both("rolling", tmp_path, **AXES)
    assert len(list((tmp_path / "g.zarr" / "verdict").glob("c.*"))) == 90
    np.testing.assert_array_equal(found.verdict.values, whole.verdict.values)
    off = np.abs(found.abscissa.values - whole.abscissa.values)
    assert (off <= found.abscissa_error.values + whole.abscissa_error.values).all()


@pytest.mark.long
@pytest.mark.parametrize(("kind", "own"), [("threads", True), ("processes", False)])
def test_engines_write_the_same_bytes(kind: str, own: bool, tmp_path: Path) -> None:
    family, axes = (own_family(), OWN) if own else ("rolling", AXES)
    told: list[tuple[int, int]] = []
    st.stream_map(
        family,
        **axes,
        growth=True,
        out=tmp_path / "a.zarr",
        executor=kind,
        workers=2,
        progress=lambda *pair: told.append(pair),
    )
    st.stream_map(family, **axes, growth=True, out=tmp_path / "b.zarr", workers=1)
    assert tree(tmp_path / "a.zarr") == tree(tmp_path / "b.zarr")
    assert told[-1] == (1200, 1200)


def test_words_name_the_engines_of_verdicts_and_of_maps_in_memory(tmp_path: Path) -> None:
    for name in ("a.nc", "a.zarr"):
        st.stream_map("rolling", **AXES, out=tmp_path / name, executor="threads", workers=2)
    own = st.stability_map("rolling", **AXES, boundaries=False)
    for name in ("a.nc", "a.zarr"):
        assert (st.read_map(tmp_path / name).verdict.values == own.verdict.values).all()
    found = st.stability_map("rolling", **AXES, boundaries=False, executor="processes", workers=1)
    assert found.drop_attrs().identical(own.drop_attrs())


VICTIM = """
import os, signal, sys
import stability as st
import stability.maps.cells as cells
cells.BAND = 120
def told(done, total):
    if done > 500:
        os.kill(os.getpid(), signal.SIGKILL)
st.stream_map("rolling", x=("at", 0.3, 3.2, 40), y=("mu", 0.1, 5, 30), growth=True,
              out=sys.argv[1], progress=told, workers=2)
"""


@pytest.mark.long
@pytest.mark.skipif(sys.platform == "win32", reason="SIGKILL")
def test_a_killed_stream_is_continued_to_the_same_bytes(tmp_path: Path) -> None:
    done = subprocess.run(
        [sys.executable, "-c", VICTIM, str(tmp_path / "a.zarr")],
        check=False,
        env=dict(os.environ),
        timeout=100,
    )
    assert done.returncode == -signal.SIGKILL
    begun = len(list((tmp_path / "a.zarr" / "verdict").glob("c.*")))
    with pytest.raises(st.StabilityError, match="of 10 chunks; give the command") as refusal:
        st.read_map(tmp_path / "a.zarr")
    there = int(re.findall(r"holds (\d+) of", str(refusal.value))[0])
    assert 4 <= there <= begun <= there + 2 < 12  # each of the two workers may have left a part
    told: list[int] = []
    for name in "ab":
        st.stream_map(
            "rolling",
            **AXES,
            growth=True,
            out=tmp_path / f"{name}.zarr",
            progress=lambda n, _: told.append(n),
        )
    assert told[0] == 120 * there
    assert tree(tmp_path / "a.zarr") == tree(tmp_path / "b.zarr")


def test_a_folder_of_the_other_kind_is_refused(tmp_path: Path) -> None:
    for growth, there, here in ((True, "missing", "true"), (False, "true", "missing")):
        out = tmp_path / f"{growth}.zarr"
        st.stream_map("rolling", **AXES, out=out, growth=not growth)
        with pytest.raises(st.StabilityError, match=f"growth rates: {there} there, {here} here"):
            st.stream_map("rolling", **AXES, out=out, growth=growth)


@needs_numba
def test_compiled_loops_and_numpy_are_two_questions(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("stability.maps.engine.COMPILED_FROM", 1000)
    found, whole = both("rolling", tmp_path, **AXES)
    assert "compiled loops" in found.method
    for name in NAMES:
        np.testing.assert_array_equal(found[name].values, whole[name].values)
    monkeypatch.setattr("stability.maps.engine.numba_found", lambda: False)
    with pytest.raises(st.StabilityError, match="was made with other arguments"):
        both("rolling", tmp_path, **AXES)


def test_what_cannot_be_streamed_is_refused_before_anything_is_computed(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    with pytest.raises(st.StabilityError, match=r"a folder whose name ends in \.zarr"):
        st.stream_map("rolling", **AXES, growth=True, out=tmp_path / "a.nc")
    with pytest.raises(st.StabilityError, match="growth is 'yes'"):
        st.stream_map("rolling", **AXES, growth="yes", out=tmp_path / "a.zarr")  # type: ignore[arg-type]
    free = type("Usage", (), {"free": 2**24 + 2 * 1200})
    monkeypatch.setattr("shutil.disk_usage", lambda _: free)
    with pytest.raises(st.StabilityError, match="may need 0 MiB, and 16 MiB are free"):
        st.stream_map("rolling", **AXES, growth=True, out=tmp_path / "a.zarr")
    assert list(tmp_path.iterdir()) == []
    st.stream_map("rolling", **AXES, out=tmp_path / "a.zarr")  # verdicts alone fit


@pytest.mark.parametrize("value", [5, "fibres", ""])
def test_an_engine_that_is_none_is_refused_with_what_is_one(value: Any, tmp_path: Path) -> None:
    for call in (
        lambda: st.stream_map("rolling", **AXES, out=tmp_path / "a.zarr", executor=value),
        lambda: st.stability_map("rolling", **AXES, executor=value),
        lambda: st.basins(
            contact="viscous",
            mu=0.3,
            x=("phi_dot", 1, 3, 3),
            y=("theta", 1, 1.2, 2),
            horizon=1.0,
            executor=value,
        ),
        lambda: pool_of(value),
    ):
        with pytest.raises(st.StabilityError, match="give threads, processes, dask, .*address"):
            call()
    assert list(tmp_path.iterdir()) == []


def test_cells_that_ended_their_worker_are_flagged() -> None:
    found = no_rates(3)
    assert (found["verdict"] == 0).all()
    assert np.isnan(found["abscissa"]).all() and np.isinf(found["abscissa_error"]).all()


def test_the_figure_of_a_streamed_map_has_no_curves(tmp_path: Path) -> None:
    out = st.stream_map("spinning", **AXES, growth=True, out=tmp_path / "g.zarr")
    with st.read_map(out, lazy=True) as lazy:
        assert lazy.abscissa.sizes == {"mu": 30, "at": 40}
        figure = st.plot_map(lazy.load())
    assert "unstable" in {t.get_text() for t in figure.axes[0].texts}


@pytest.mark.parametrize("ending", ["nc", "zarr"])
def test_a_streamed_verdict_that_balls_leave_open_is_undecided(ending: str, tmp_path: Path) -> None:
    """The stiffness a cos(1) is zero at a = 0, which no ball about cos(1) proves."""
    x, p = ca.SX.sym("x", 2), ca.SX.sym("p", 3)
    rates = ca.vertcat(x[1], -p[0] * ca.cos(p[2]) * x[0] - p[1] * x[1])
    system = st.System("ball", x, p, rates, states=("u", "v"), parameters=("a", "b", "q"))
    family = st.Family(system, "rest", at=("a",), held={"u": 0.0, "v": 0.0})
    out = st.stream_map(
        family, x=("a", -1, 1, 41), y=("b", 0.5, 2, 30), q=1.0, out=tmp_path / f"a.{ending}"
    )
    found = st.read_map(out).verdict.values
    assert (found == [*[2] * 20, 0, *[1] * 20]).all()
