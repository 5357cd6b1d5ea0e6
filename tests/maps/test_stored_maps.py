"""Large maps in Zarr folders: the verdicts of the NetCDF file, continued after an interruption."""

from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from chunk_work import tree
from executors import Distributed

import stability as st
from stability.cli import main
from stability.jobs.processes import processes

AXES: dict[str, Any] = {"x": ("at", 0.05, 1.5, 40), "y": ("mu", 0.1, 5, 30)}
MAP = ("map", "tumbling", "--x", "at:0.05:1.5:40", "--y", "mu:0.1:5:30", "--verdict-only")


@pytest.fixture(autouse=True)
def small(monkeypatch: pytest.MonkeyPatch) -> None:
    """Ten chunks to a map."""
    monkeypatch.setattr("stability.maps.stream.BAND", 120)


@pytest.mark.few(1)
@pytest.mark.parametrize("kind", ["own", "threads", "processes", "distributed"])
def test_a_folder_holds_the_verdicts_of_the_file(kind: str, tmp_path: Path) -> None:
    file = st.read_map(st.stream_map("tumbling", **AXES, out=tmp_path / "a.nc"))
    told: list[tuple[int, int]] = []
    how: dict[str, Any] = {"out": tmp_path / "a.zarr", "progress": lambda *pair: told.append(pair)}
    if kind == "own":
        st.stream_map("tumbling", **AXES, **how)
    else:
        pools: Any = {
            "threads": lambda: ThreadPoolExecutor(2),
            "processes": lambda: processes(2),
            "distributed": Distributed,
        }
        with pools[kind]() as pool:
            st.stream_map("tumbling", **AXES, **how, executor=pool, workers=2)
    found = st.read_map(tmp_path / "a.zarr")
    assert found.drop_attrs().identical(file.drop_attrs())
    assert len(list((tmp_path / "a.zarr" / "verdict").glob("whole.*"))) == 10
    assert told[-1] == (1200, 1200)
    for name in file.coords:
        assert found[name].attrs == file[name].attrs
    assert found.verdict.attrs["flag_meanings"] == file.verdict.attrs["flag_meanings"]
    same = set(file.attrs) - {"created", "method"}
    assert {n: found.attrs[n] for n in same} == {n: file.attrs[n] for n in same}
    assert "created" not in found.attrs


def test_chunks_that_do_not_span_the_map(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    st.stream_map("tumbling", **AXES, out=tmp_path / "a.zarr")
    monkeypatch.setattr("stability.maps.stream.BAND", 16)  # three chunks along x, one row each
    st.stream_map("tumbling", **AXES, out=tmp_path / "b.zarr")
    assert len(list((tmp_path / "b.zarr" / "verdict").glob("whole.*"))) == 90
    one, other = (st.read_map(tmp_path / f"{n}.zarr").verdict.values for n in "ab")
    assert np.array_equal(one, other)


def test_an_interrupted_map_is_continued(tmp_path: Path) -> None:
    def stop(done: int, _: int) -> None:
        if done > 500:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt, match=r"finished cells are kept in .*a\.zarr"):
        st.stream_map("tumbling", **AXES, out=tmp_path / "a.zarr", progress=stop)
    there = len(list((tmp_path / "a.zarr" / "verdict").glob("whole.*")))
    assert 5 <= there < 10
    for lazy in (False, True):
        with pytest.raises(st.StabilityError, match=f"holds {there} of 10 chunks; give the comm"):
            st.read_map(tmp_path / "a.zarr", lazy=lazy)
    told: list[int] = []
    st.stream_map("tumbling", **AXES, out=tmp_path / "a.zarr", progress=lambda n, _: told.append(n))
    assert told[0] == 120 * there
    st.stream_map("tumbling", **AXES, out=tmp_path / "b.zarr")
    assert tree(tmp_path / "a.zarr") == tree(tmp_path / "b.zarr")


def test_a_folder_of_another_map_is_refused_or_replaced(tmp_path: Path) -> None:
    st.stream_map("tumbling", **AXES, out=tmp_path / "a.zarr")
    other = {**AXES, "y": ("mu", 0.1, 6, 30)}
    for family, axes in (("tumbling", other), ("rolling", AXES)):
        with pytest.raises(st.StabilityError, match="was made with other arguments"):
            st.stream_map(family, **axes, out=tmp_path / "a.zarr")
    st.stream_map("tumbling", **other, out=tmp_path / "a.zarr", overwrite=True)
    assert st.read_map(tmp_path / "a.zarr").mu.values[-1] == 6


def test_a_damaged_or_other_folder_is_not_read(tmp_path: Path) -> None:
    st.stream_map("tumbling", **AXES, out=tmp_path / "a.zarr")
    path = tmp_path / "a.zarr" / "verdict" / "c.3.0"
    path.write_bytes(path.read_bytes()[:-1])
    with pytest.raises(st.StabilityError, match="chunk 3.0 of verdict is damaged; give"):
        st.read_map(tmp_path / "a.zarr")
    (tmp_path / "b.zarr").mkdir()
    for name in ("b.zarr", "c.zarr"):
        with pytest.raises(st.StabilityError, match="cannot be read as a Zarr store"):
            st.read_map(tmp_path / name)


def test_the_command_writes_and_continues_a_folder(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    out = tmp_path / "a.zarr"
    assert main([*MAP, "--out", str(out)]) == 0
    assert "1200 verdicts" in capsys.readouterr().out
    (out / "verdict" / "c.2.0").unlink()
    assert main([*MAP, "--out", str(out)]) == 0
    assert main(["map", "rolling", *MAP[2:], "--out", str(out)]) == 2
    said = capsys.readouterr().err.splitlines()
    assert "was made with other arguments" in said[-1]
    assert main([*MAP[:-1], "--out", str(out)]) == 2  # it holds no growth rates
    assert "growth rates: missing there, true here" in capsys.readouterr().err
