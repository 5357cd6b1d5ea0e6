"""A format is one record: with a toy in the list, every command writes and reads it."""

import dataclasses
import json
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import xarray

import stability as st
from stability.base.errors import FileError
from stability.cli import main
from stability.scene.answer import FORMAT
from stability.storage.checksum import ATTRIBUTE
from stability.storage.datasets import dataset_target, format_to_write, read_dataset
from stability.storage.formats import FORMATS, NETCDF, ZARR, Format
from stability.storage.text import marked, unmarked

MAP = ("map", "spinning", "--x", "at:1:4:4", "--y", "mu:0.1:2:3")
RUN = ("simulate", "--theta", "1.3", "--phi-dot", "1", "--mu", "0.3", "--time", "0.5")


def write_lines(dataset: xarray.Dataset, path: Path) -> None:
    """A line for the attributes, and one for each variable."""
    lines: list[Any] = [plain(dataset.attrs)]
    for name, variable in dataset.variables.items():
        lines.append(
            {
                "name": name,
                "dims": list(variable.dims),
                "shape": list(variable.shape),
                "dtype": str(variable.dtype),
                "values": marked(variable.values.tolist()),
                "attrs": plain(variable.attrs),
                "coordinate": name in dataset.coords,
            }
        )
    path.write_text("\n".join(json.dumps(line) for line in lines), "utf-8")


def plain(attrs: Any) -> dict[str, Any]:
    """Attributes as JSON has them."""
    return {str(n): v.tolist() if hasattr(v, "tolist") else v for n, v in attrs.items()}


def read_lines(path: Path, *, lazy: bool) -> xarray.Dataset:
    """The dataset of a file of lines."""
    assert isinstance(lazy, bool)
    attrs, *variables = (
        json.loads(line, object_hook=unmarked) for line in Path(path).read_text().splitlines()
    )
    arrays = {
        v["name"]: (
            v["dims"],
            np.array(v["values"], v["dtype"]).reshape(v["shape"]),
            v["attrs"],
        )
        for v in variables
    }
    found = xarray.Dataset(arrays, attrs=attrs)
    return found.set_coords([v["name"] for v in variables if v["coordinate"]])


@pytest.fixture
def lines() -> Iterator[Format]:
    """The toy, in the list during a test."""
    toy = Format("JSON lines", (".jsonl", ".lines"), read=read_lines, write=write_lines)
    FORMATS.append(toy)
    yield toy
    FORMATS.remove(toy)


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """An empty current folder."""
    monkeypatch.chdir(tmp_path)
    return tmp_path


def same(one: Any, other: Any) -> None:
    """Two datasets of the same call, but for the time at which they were made."""
    for dataset in (one, other):
        dataset.attrs.pop("created", None)
    xarray.testing.assert_equal(one, other)
    assert plain(one.attrs) == plain(other.attrs)


@pytest.mark.usefixtures("lines")
@pytest.mark.parametrize("ending", [".jsonl", ".lines"])
def test_maps_come_back(ending: str, folder: Path) -> None:
    found = st.stability_map("rolling", x=("at", 0.5, 4, 4), y=("mu", 0.1, 2, 3), modes=True)
    path = st.write_map(found, folder / f"map{ending}")
    assert json.loads(path.read_text().splitlines()[0])["format"] == found.attrs["format"]
    same(st.read_map(path), found)
    with pytest.raises(FileError, match="exists; choose another name"):
        st.write_map(found, path)
    with pytest.raises(FileError, match="is JSON lines but not a motion written by stability"):
        st.read_motion(path)


@pytest.mark.usefixtures("lines", "folder")
def test_the_command_map_writes_it_and_cite_reads_it(capsys: pytest.CaptureFixture[str]) -> None:
    for name in ("map.jsonl", "map.nc"):
        assert main([*MAP, "--out", name]) == 0
    same(st.read_map("map.jsonl"), st.read_map("map.nc"))
    capsys.readouterr()
    texts = []
    for name in ("map.jsonl", "map.nc"):
        assert main(["cite", name]) == 0
        texts.append(capsys.readouterr().out)
    assert texts[0] == texts[1] != ""


@pytest.mark.usefixtures("lines", "folder")
def test_the_command_simulate_writes_it() -> None:
    for name in ("run.jsonl", "run.nc"):
        assert main([*RUN, "--no-check", "--method", "dop853", "--out", name]) == 0
    same(st.read_motion("run.jsonl"), st.read_motion("run.nc"))


@pytest.mark.usefixtures("lines", "folder")
def test_the_command_scene_writes_it() -> None:
    scene = Path(st.__file__).parents[1] / "examples" / "scenes"
    text = sorted(scene.glob("*.toml"))[0]
    for name in ("run.jsonl", "run.nc"):
        assert main(["scene", str(text), "--out", name]) == 0
    kinds = {FORMAT: "the motion of a scene"}
    same(read_dataset("run.jsonl", kinds), read_dataset("run.nc", kinds))


@pytest.mark.usefixtures("lines", "folder")
@pytest.mark.parametrize(
    ("words", "endings"),
    [
        ((*MAP, "--verdict-only"), r".nc, .nc4, .netcdf, .h5, .hdf5 or .zarr"),
        (
            ("basins", "--x", "theta:1:1.5:2", "--y", "omega3:1:2:2", "--mu", "1", "--time", "1"),
            ".zarr",
        ),
    ],
)
def test_a_way_that_the_format_does_not_have_is_refused_with_the_others(
    words: tuple[str, ...], endings: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main([*words, "--out", "a.jsonl"]) == 2
    said = capsys.readouterr().err
    assert f"--out is 'a.jsonl'; the name must end in {endings}." in said
    assert list(Path().iterdir()) == []


@pytest.mark.usefixtures("lines", "folder")
@pytest.mark.parametrize("words", [MAP, RUN])
def test_a_refusal_names_the_endings_of_the_list(
    words: tuple[str, ...], capsys: pytest.CaptureFixture[str]
) -> None:
    assert main([*words, "--out", "a.txt"]) == 2
    assert ".hdf5" in (said := capsys.readouterr().err) and ".jsonl" in said and ".lines" in said
    assert main(["atlas", "--out", "a.jsonl"]) == 2
    assert "a.jsonl is named like a file" in capsys.readouterr().err


def test_a_format_that_is_not_installed_is_refused_before_anything_is_computed(
    lines: Format, folder: Path
) -> None:
    FORMATS[-1] = dataclasses.replace(lines, package="no_such_package", extra="toy")
    try:
        with pytest.raises(st.StabilityError, match="needs the package no_such") as said:
            dataset_target(folder / "a.jsonl", "write")
    finally:
        FORMATS[-1] = lines
    line = "`pip install '.[toy]'` from a checkout of stability-nonholonomic"
    assert f"{line}, or give a file that ends in .nc." in str(said.value)


def test_a_name_without_an_ending_is_that_of_the_usual_format() -> None:
    assert format_to_write("map", "write") is NETCDF
    assert format_to_write("map.ZARR", "rows", "chunks") is ZARR
    with pytest.raises(FileError, match="must end in .zarr"):
        format_to_write("map", "chunks")


def test_an_ending_that_nobody_knows_is_read_as_the_usual_format(folder: Path) -> None:
    found = st.Spectrum.to_xarray(st.spectrum("rolling", at=1.0, contact="viscous", mu=0.3))
    path = st.write_map(found, folder / "a.nc").rename(folder / "a.data")
    back = read_dataset(path, {found.attrs["format"]: "a map"})
    assert back.identical(found) and ATTRIBUTE not in back.attrs


@pytest.mark.parametrize("ending", [".csv.zip", ".NC", "nc"])
def test_an_ending_that_no_name_is_read_by_is_refused(ending: str) -> None:
    with pytest.raises(st.StabilityError, match="give a dot and one word"):
        Format("toy", (ending,), read=print)
