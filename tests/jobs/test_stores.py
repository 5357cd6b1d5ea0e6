"""Stores of chunks: what they hold, what they refuse, and what a killed or full one leaves."""

import json
import os
import random
import subprocess
import sys
from pathlib import Path
from typing import Any

import chunk_work
import numpy as np
import pytest
import xarray
import zarr
from chunk_work import ATTRS, COORDS, LAYOUT, VARIABLES, store, tree, undisturbed, values

import stability as st
from stability.storage.chunks import Layout, Memory, Variable
from stability.storage.files import write_file
from stability.storage.zarr_store import FORMAT, ZarrStore, file_name

ALL = values(np.arange(90))
TOOLS = Path(chunk_work.__file__).parent
ENVIRONMENT = os.environ | {
    "PYTHONPATH": os.pathsep.join([str(Path(st.__file__).parents[1]), str(TOOLS)])
}


def chunk(block: tuple[int, ...]) -> dict[str, np.ndarray[Any, Any]]:
    cells = np.arange(90).reshape(9, 10)[LAYOUT.slices(block)].ravel()
    return values(cells)


def fill_all(into: Any, blocks: list[tuple[int, ...]]) -> Any:
    for block in blocks:
        into.add(block, chunk(block))
    return into


# --- the grid ---


def test_chunks_cover_each_cell_once_and_number_it() -> None:
    chosen = random.Random(20261123)
    for _ in range(60):
        axes = chosen.randint(1, 4)
        shape = tuple(chosen.randint(1, 7) for _ in range(axes))
        layout = Layout(tuple("abcd"[:axes]), shape, tuple(chosen.randint(1, 8) for _ in shape))
        numbers, seen = np.arange(layout.total).reshape(shape), np.zeros(shape, int)
        for block in layout.blocks():
            cells = numbers[layout.slices(block)]
            assert cells.shape == layout.sizes(block)
            assert [layout.number(block, i) for i in range(cells.size)] == cells.ravel().tolist()
            seen[layout.slices(block)] += 1
        assert (seen == 1).all()
        assert layout.blocks() == sorted(layout.blocks())


@pytest.mark.parametrize(
    "parts",
    [
        (("x",), (3, 4), (2,)),
        (("x", "x"), (3, 4), (2, 2)),
        ((), (), ()),
        (("x",), (0,), (2,)),
        (("x",), (3,), (0,)),
    ],
)
def test_a_grid_that_is_none_is_refused(parts: Any) -> None:
    with pytest.raises(st.StabilityError, match="the chunks have"):
        Layout(*parts)


# --- what a store holds ---


def test_memory_and_zarr_hold_the_same_and_xarray_reads_it(tmp_path: Path) -> None:
    memory = fill_all(Memory(LAYOUT, VARIABLES, COORDS, ATTRS), LAYOUT.blocks()).dataset()
    kept = fill_all(store(tmp_path / "a.zarr"), LAYOUT.blocks())
    read = xarray.open_zarr(tmp_path / "a.zarr").load()
    for found in (memory, kept.dataset(), read):
        assert found.outcome.dtype == np.int8
        assert found.outcome.dims == ("y", "x")
        assert found["last"].dims == ("y", "x", "state")
        for name, array in ALL.items():
            assert np.array_equal(found[name].values.reshape(array.shape), array)
        assert found.time.attrs == {"units": "s", "long_name": "time of the event"}
        assert list(found.outcome.attrs["flag_values"]) == [0, 1, 2, 3, 4, 9]
        assert found.x.attrs == {"units": "rad"}
        assert set(found.coords) == {"x", "y", "start", "state"}
        assert found.start.values[8, 9] == 89.0**2
        assert found.state.values.tolist() == ["theta", "phi", "psi"]
        assert found.attrs["title"] == "numbers of cells"
    assert kept.missing() == []
    assert json.loads(read.attrs["question"])["its horizon"] == "40.0"


def test_a_file_for_each_variable_of_each_chunk_by_the_format(tmp_path: Path) -> None:
    kept = store(tmp_path / "a.zarr")
    before = set(tree(tmp_path))
    kept.add((4, 2), chunk((4, 2)))
    new = set(tree(tmp_path)) - before
    assert new == {
        f"a.zarr/{n}" for n in ("outcome/c.4.2", "outcome/whole.4.2", "time/c.4.2", "last/c.4.2.0")
    }
    group = zarr.open_group(str(tmp_path / "a.zarr"), mode="r")
    assert group.metadata.zarr_format == 3
    assert group["outcome"][8, 8:].tolist() == [3, 4]
    assert (group["outcome"][:8] == -1).all()


def test_stores_filled_in_any_order_are_equal_byte_for_byte(tmp_path: Path) -> None:
    blocks = LAYOUT.blocks()
    fill_all(store(tmp_path / "a.zarr"), blocks)
    random.Random(1).shuffle(blocks)
    fill_all(store(tmp_path / "b.zarr"), blocks)
    assert tree(tmp_path / "a.zarr") == tree(tmp_path / "b.zarr")
    assert tree(tmp_path / "a.zarr") == undisturbed(tmp_path / "c.zarr")


def test_a_chunk_is_there_exactly_if_its_record_is(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    kept, written = store(tmp_path / "a.zarr"), []

    def stopped(path: Path, content: bytes, **how: Any) -> None:
        if len(written) == limit:
            raise KeyboardInterrupt
        written.append(path)
        write_file(path, content, **how)

    for limit in range(4):
        written.clear()
        with monkeypatch.context() as patch, pytest.raises(KeyboardInterrupt):
            patch.setattr("stability.storage.zarr_store.write_file", stopped)
            kept.add((1, 1), chunk((1, 1)))
        assert len(written) == limit
        assert (1, 1) in store(tmp_path / "a.zarr").missing()
    kept.add((1, 1), chunk((1, 1)))
    assert (1, 1) not in store(tmp_path / "a.zarr").missing()


def test_a_chunk_with_one_wrong_bit_is_not_read_and_made_again(tmp_path: Path) -> None:
    kept = fill_all(store(tmp_path / "a.zarr"), LAYOUT.blocks())
    path = tmp_path / "a.zarr" / "time" / "c.1.1"
    content = bytearray(path.read_bytes())
    content[len(content) // 2] ^= 1
    path.write_bytes(content)
    assert kept.dataset().time[:2, :4].shape == (2, 4)  # another chunk
    with pytest.raises(st.StabilityError, match=r"a.zarr: chunk 1.1 of time is damaged; give"):
        kept.dataset().time.load()
    with pytest.warns(st.StabilityWarning, match=r"chunk 1.1 of time is damaged, and is computed"):
        assert kept.missing() == [(1, 1)]
    kept.add((1, 1), chunk((1, 1)))
    assert tree(tmp_path / "a.zarr") == undisturbed(tmp_path / "b.zarr")


# --- what it refuses ---


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"outcome": np.full(8, -1, np.int8)}, "outcome holds -1, which marks cells"),
        ({"outcome": np.zeros(7, np.int8)}, r"the work must give shape \(8,\), int8"),
        ({"outcome": np.zeros(8)}, r"the work must give shape \(8,\), int8"),
        ({"last": np.zeros(8)}, r"the work must give shape \(8, 3\), float32"),
        ({"more": np.zeros(8)}, "it must give"),
    ],
)
def test_a_chunk_that_does_not_fit_is_refused_whole(
    change: Any, words: str, tmp_path: Path
) -> None:
    kept = store(tmp_path / "a.zarr")
    before = tree(tmp_path)
    for into in (kept, Memory(LAYOUT, VARIABLES)):
        with pytest.raises(st.StabilityError, match=words):
            into.add((0, 0), chunk((0, 0)) | change)
        assert len(into.missing()) == 15
    assert tree(tmp_path) == before


@pytest.mark.few(4)
@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"question": {"horizon": 50.0, "body": {"k": 0.25}}}, "horizon: 40.0 there, 50.0"),
        ({"question": {"horizon": 40.0}}, r'body: {"k": 0.25} there, missing here'),
        ({"question": {"horizon": 40.0, "body": {"k": 0.5}}}, "k of its body: 0.25 there, 0.5"),
        ({"attrs": {**ATTRS, "title": "other"}}, "attribute title"),
        ({"coords": {**COORDS, "y": np.arange(1.0, 10.0)}}, "the coordinates differ"),
        ({"coords": {**COORDS, "y": ("y", np.arange(9.0), {"units": "m"})}}, "coordinates differ"),
        ({"layout": Layout(("y", "x"), (9, 10), (3, 4))}, r"chunk: \[2, 4\] there, \[3, 4\]"),
        ({"layout": Layout(("y", "z"), (9, 10), (2, 4)), "coords": {}}, "number of cells|coor"),
        ({"variables": (VARIABLES[0], Variable("time", "float32", 0.0))}, "arrays"),
    ],
)
def test_a_store_of_another_question_is_refused_and_named(
    change: Any, words: str, tmp_path: Path
) -> None:
    store(tmp_path / "a.zarr").add((0, 0), chunk((0, 0)))
    before = tree(tmp_path)
    with pytest.raises(st.StabilityError, match=words) as caught:
        store(tmp_path / "a.zarr", **change)
    assert "was made with other arguments" in str(caught.value)
    assert "overwrite=True" in str(caught.value)
    assert tree(tmp_path) == before
    again = store(tmp_path / "a.zarr", overwrite=True)
    assert len(again.missing()) == 14  # the question is the same
    other = store(tmp_path / "a.zarr", **change, overwrite=True)
    assert len(other.missing()) == len(other.layout.blocks())


def test_another_version_of_the_format_is_another_question(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    store(tmp_path / "a.zarr")
    monkeypatch.setattr("stability.storage.zarr_store.FORMAT", FORMAT + 1)
    with pytest.raises(st.StabilityError, match="format: "):
        store(tmp_path / "a.zarr")


@pytest.mark.parametrize("content", [None, "", "{", '{"attributes": {}}', '{"attributes": [1]}'])
def test_a_folder_of_others_is_refused_and_left_alone(content: str | None, tmp_path: Path) -> None:
    folder = tmp_path / "a.zarr"
    folder.mkdir()
    (folder / ("a.txt" if content is None else "zarr.json")).write_text(content or "")
    before = tree(tmp_path)
    for overwrite in (False, True):
        with pytest.raises(st.StabilityError, match="is no store of ours, or is damaged"):
            store(folder, overwrite=overwrite)
    assert tree(tmp_path) == before


def test_an_empty_folder_is_taken_and_a_missing_parent_is_not(tmp_path: Path) -> None:
    (tmp_path / "a.zarr").mkdir()
    assert len(store(tmp_path / "a.zarr").missing()) == 15
    with pytest.raises(st.StabilityError, match="does not exist; create it first"):
        store(tmp_path / "none" / "a.zarr")
    (tmp_path / "file").touch()
    with pytest.raises(st.StabilityError, match="is a file; give the name of a folder"):
        store(tmp_path / "file")


@pytest.mark.parametrize("value", [object(), float("nan"), {1j}])
def test_what_does_not_fit_json_is_refused(value: Any, tmp_path: Path) -> None:
    for change in ({"attrs": {"a": value}}, {"question": {"a": value}}):
        with pytest.raises(st.StabilityError, match="does not fit JSON"):
            store(tmp_path / "a.zarr", **change)
    assert list(tmp_path.iterdir()) == []


def test_without_zarr_there_is_one_sentence(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setitem(sys.modules, "zarr", None)
    with pytest.raises(st.StabilityError, match=r"`pip install '\.\[scale\]'` from a checkout"):
        store(tmp_path / "a.zarr")


# --- what is left behind ---


def test_the_bytes_of_a_chunk_are_on_the_disk_before_it_has_its_name(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """No marker may outlive a power cut without its chunk: flushed first, named then, it last."""
    kept, seen = store(tmp_path / "a.zarr"), list[tuple[str, int, int]]()
    flush, rename = os.fsync, Path.replace

    def told(what: str, found: os.stat_result) -> None:
        seen.append((what, found.st_ino, found.st_size))

    def flushing(handle: int) -> None:
        flush(handle)
        told("flushed", os.fstat(handle))

    def renaming(self: Path, target: Path) -> Path:
        told(target.parent.name, self.stat())
        return rename(self, target)

    monkeypatch.setattr(os, "fsync", flushing)
    monkeypatch.setattr(Path, "replace", renaming)
    kept.add((0, 0), chunk((0, 0)))
    assert [what for what, _, _ in seen[1::2]] == ["time", "last", "outcome", "outcome"]
    assert [what for what, _, _ in seen[::2]] == ["flushed"] * 4
    assert [rest for _, *rest in seen[::2]] == [rest for _, *rest in seen[1::2]]
    sizes = [
        (tmp_path / "a.zarr" / n / file_name(v, (0, 0))).stat().st_size
        for n, v in ((v.name, v) for v in (*VARIABLES[1:], VARIABLES[0]))
    ]
    assert [size for _, _, size in seen[::2]][:3] == sizes


HALF = """
import os, signal, sys
from pathlib import Path
import chunk_work, stability.storage.zarr_store as zarr_store
wait = {"file": "write_bytes", "folder": "rename"}[sys.argv[1]]
kept = chunk_work.store(Path("a.zarr")) if wait == "write_bytes" else None
whole = getattr(Path, wait)
def killed(self, *rest):
    if wait == "write_bytes":
        whole(self, rest[0][:20])
    os.kill(os.getpid(), signal.SIGKILL)
setattr(Path, wait, killed)
if kept is None:
    chunk_work.store(Path("a.zarr"))
import numpy as np
kept.add((0, 0), chunk_work.values(np.array([0, 1, 2, 3, 10, 11, 12, 13])))
"""


@pytest.mark.few(1)
@pytest.mark.skipif(sys.platform == "win32", reason="SIGKILL")
@pytest.mark.parametrize("what", ["file", "folder"])
def test_a_killed_writer_leaves_nothing_in_the_finished_store(what: str, tmp_path: Path) -> None:
    done = subprocess.run(
        [sys.executable, "-c", HALF, what], cwd=tmp_path, env=ENVIRONMENT, check=False
    )
    assert done.returncode == -9
    left = [p for p in tmp_path.rglob(".stability-*")]
    assert len(left) == 1
    assert (tmp_path / "a.zarr").exists() == (what == "file")
    fill_all(store(tmp_path / "a.zarr"), LAYOUT.blocks())
    assert list(tmp_path.rglob(".stability-*")) == []
    assert tree(tmp_path / "a.zarr") == undisturbed(tmp_path / "b.zarr")


FULL = """
import os, resource
import chunk_work
from stability.storage import files
from stability.base.errors import StabilityError
from pathlib import Path
kept = chunk_work.store(Path("a.zarr"))
resource.setrlimit(resource.RLIMIT_FSIZE, (100, 100))
try:
    chunk_work.fill(kept, chunk_work.Logged("log"), blank=chunk_work.blank, workers=2)
except StabilityError as error:
    print(error)
"""


@pytest.mark.long
@pytest.mark.skipif(sys.platform == "win32", reason="limits of a process")
def test_a_full_disk_is_a_sentence_and_the_store_resumes(tmp_path: Path) -> None:
    """No file may grow beyond some bytes: the small chunks at the edge fit, the others do not."""
    done = subprocess.run(
        [sys.executable, "-c", FULL],
        cwd=tmp_path,
        env=ENVIRONMENT,
        capture_output=True,
        text=True,
        check=True,
    )
    said = done.stdout.splitlines()
    assert len(said) == 1
    assert "cannot be written: File too large" in said[0]
    assert said[0].endswith("the finished chunks are kept: give the same command again to go on.")
    kept = store(tmp_path / "a.zarr")
    assert list(tmp_path.rglob(".stability-*")) == []
    assert kept.missing()
    fill_all(kept, kept.missing())
    assert tree(tmp_path / "a.zarr") == undisturbed(tmp_path / "b.zarr")


def test_two_runs_that_make_one_store_make_the_same(tmp_path: Path) -> None:
    """The second finds the folder when it wants to give its own the name."""
    made = []

    class Late(ZarrStore):
        def _create(self, files: Any, asked: Any) -> None:
            made.append(store(tmp_path / "a.zarr"))
            made[0].add((0, 0), chunk((0, 0)))
            super()._create(files, asked)

    late = Late(
        tmp_path / "a.zarr",
        LAYOUT,
        VARIABLES,
        COORDS,
        ATTRS,
        {"horizon": 40.0, "body": {"k": 0.25}},
    )
    assert made[0].missing() == late.missing() != []
    assert len(late.missing()) == 14
    assert list(tmp_path.glob(".stability-*")) == []


# --- what a store says of itself is no part of its question ---


def _cited(path: Path, keys: str, **more: Any) -> ZarrStore:
    return ZarrStore(
        path, LAYOUT, VARIABLES, COORDS, {**ATTRS, "citation": keys, **more}, {"horizon": 40.0}
    )


def test_a_store_goes_on_whatever_is_cited(tmp_path: Path) -> None:
    fill_all(_cited(tmp_path / "a.zarr", "stability"), LAYOUT.blocks()[:3])
    again = _cited(tmp_path / "a.zarr", "stability, casadi")
    assert len(again.missing()) == len(LAYOUT.blocks()) - 3
    with pytest.raises(st.StabilityError, match="was made with other arguments"):
        _cited(tmp_path / "a.zarr", "stability", title="another title")


@pytest.mark.parametrize("name", ["", ".", "..", "../{name}"])
def test_a_store_takes_no_place_of_the_current_folder(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, name: str
) -> None:
    here = tmp_path / "here"
    here.mkdir()
    monkeypatch.chdir(here)
    with pytest.raises(st.StabilityError, match="the current folder or holds it"):
        ZarrStore(name.format(name=here.name), LAYOUT, VARIABLES, COORDS, ATTRS)
    assert Path.cwd() == here and not list(tmp_path.rglob("zarr.json"))


@pytest.mark.parametrize("overwrite", ["no", 3, None])
def test_only_a_truth_value_lets_a_store_be_replaced(tmp_path: Path, overwrite: Any) -> None:
    store(tmp_path / "s.zarr")
    before = tree(tmp_path)
    with pytest.raises(st.StabilityError, match="give True, False or .same."):
        ZarrStore(
            tmp_path / "s.zarr",
            Layout(("y", "x"), (2, 2), (1, 1)),
            VARIABLES,
            {},
            ATTRS,
            overwrite=overwrite,
        )
    assert tree(tmp_path) == before
