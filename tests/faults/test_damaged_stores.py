"""Damaged Zarr stores: right numbers, a file that is named and made again, or a refusal."""

from __future__ import annotations

import os
import shutil
import warnings
from collections import Counter
from pathlib import Path
from typing import Any

import chunk_work
import numpy as np
import pytest
from chunk_work import LAYOUT, tree, values
from damage import damage

import stability as st
from stability.storage.zarr_store import FILES, HEAD, ITSELF, plain_json

SEED = int(os.environ.get("STABILITY_SEED", "20261128"))
AXES: dict[str, Any] = {"x": ("at", 0.5, 4, 24), "y": ("mu", 0.1, 2, 12)}
ALL = values(np.arange(LAYOUT.total))


def filled(path: Path) -> Any:
    kept = chunk_work.store(path)
    for block in kept.missing():
        cells = np.arange(LAYOUT.total).reshape(LAYOUT.shape)[LAYOUT.slices(block)].ravel()
        kept.add(block, values(cells))
    return kept


def spoiled(folder: Path, random: np.random.Generator) -> tuple[str, str]:
    """Damage to one file of a store: its name, and what became of it."""
    files = sorted(tree(folder))
    name = str(random.choice(files))
    path, other = folder / name, folder / str(random.choice([n for n in files if n != name]))
    what = str(random.choice(["damaged", "damaged", "removed", "replaced", "empty", "folder"]))
    if what == "damaged":
        content = path.read_bytes()
        what, found = damage(content, other.read_bytes(), random)
        path.write_bytes(found)
    elif what == "replaced":
        path.write_bytes(other.read_bytes())
    elif what == "empty":
        path.write_bytes(b"")
    else:
        path.unlink()
        if what == "folder":
            path.mkdir()
    return name, what


def sentence(error: Exception) -> str:
    assert isinstance(error, st.StabilityError), repr(error)
    assert len(str(error).splitlines()) == 1 and len(str(error)) <= 300
    return "refused"


def read(folder: Path) -> str:
    """How reading a store ends; other numbers fail."""
    try:
        found = chunk_work.store(folder).dataset().load()
    except st.StabilityError as error:
        return sentence(error)
    for name, array in ALL.items():
        there = found[name].values.reshape(array.shape)
        missing = found.outcome.values.ravel() == -1  # a chunk that is not there
        assert np.array_equal(there[~missing], array[~missing]), name
    assert np.array_equal(found.start.values.ravel(), np.arange(90.0) ** 2)
    return "incomplete" if missing.any() else "right"


def made_again(folder: Path, whole: dict[str, bytes]) -> str:
    """How the same call on a store ends: with every byte as it was, or with a refusal."""
    try:
        filled(folder)
    except st.StabilityError as error:
        return sentence(error)
    after = tree(folder)
    assert {n: after.get(n) for n in whole} == whole
    return "whole"


def campaign(tmp_path: Path, count: int, seed: int) -> Counter[str]:
    filled(tmp_path / "whole.zarr")
    whole, tally = tree(tmp_path / "whole.zarr"), Counter[str]()
    random = np.random.default_rng(seed)
    for i in range(count):
        folder = tmp_path / f"{i}.zarr"
        shutil.copytree(tmp_path / "whole.zarr", folder)
        name, what = spoiled(folder, random)
        with warnings.catch_warnings(record=True) as said:
            warnings.simplefilter("always", st.StabilityWarning)
            try:
                ended = read(folder) if i % 2 else made_again(folder, whole)
            except Exception as error:
                raise AssertionError(f"store {i} of seed {seed}: {name} is {what}") from error
        if i % 2 and ended == "right" and tree(folder) != whole and not said:
            assert name.split("/")[-1].startswith("whole."), (i, name, what)  # no number depends
        tally[f"{'read' if i % 2 else 'made again'}: {ended}{', named' if said else ''}"] += 1
        shutil.rmtree(folder)
    print(dict(sorted(tally.items())))
    return tally


def test_a_damaged_store_is_right_or_named(tmp_path: Path) -> None:
    tally = campaign(tmp_path, 24, SEED)
    assert sum(tally.values()) == 24


@pytest.mark.long
def test_many_damaged_stores_are_right_or_named(tmp_path: Path) -> None:
    """2000 stores, of which one file each is cut, flipped, overwritten, exchanged or removed."""
    campaign(tmp_path, 2000, SEED + 1)


@pytest.mark.parametrize("what", ["removed", "exchanged", "cut"])
@pytest.mark.parametrize("array", ["abscissa", "frequency", "verdict"])
def test_a_damaged_chunk_of_a_map_is_refused_and_made_again(
    array: str, what: str, tmp_path: Path
) -> None:
    def stream() -> Path:
        return st.stream_map("rolling", **AXES, growth=True, out=tmp_path / "map.zarr")

    folder = stream()
    whole, right = tree(folder), st.read_map(folder)
    first, other = (sorted(folder.joinpath(array).glob("c.*"))[i] for i in (0, -1))
    if first == other:
        other = next(folder.joinpath("abscissa_error").glob("c.*"))
    if what == "removed":
        first.unlink()
    else:
        first.write_bytes(other.read_bytes() if what == "exchanged" else first.read_bytes()[:-1])
    with pytest.raises(st.StabilityError, match=f"chunk 0.0 of {array} is damaged; give"):
        st.read_map(folder)
    lazy = st.read_map(folder, lazy=True)
    with pytest.raises(st.StabilityError, match=f"chunk 0.0 of {array} is damaged"):
        lazy[array].load()
    with pytest.warns(st.StabilityWarning, match=f"chunk 0.0 of {array} is damaged, and is"):
        stream()
    assert tree(folder) == whole and st.read_map(folder).identical(right)


def test_coordinates_and_metadata_are_checked_too(tmp_path: Path) -> None:
    folder = st.stream_map("rolling", **AXES, out=tmp_path / "map.zarr")
    whole = tree(folder)
    for name in ("at/c/0", "mu/zarr.json", "verdict/zarr.json"):
        content = bytearray((folder / name).read_bytes())
        content[len(content) // 2] ^= 1
        (folder / name).write_bytes(content)
        with pytest.raises(st.StabilityError, match=f"{name} is damaged"):
            st.read_map(folder)
        with pytest.warns(st.StabilityWarning, match=f"{name} is damaged, and is written again"):
            st.stream_map("rolling", **AXES, out=folder)
        assert tree(folder) == whole
    head = (folder / HEAD).read_text(encoding="utf-8").replace("rolling", "rollins", 1)
    (folder / HEAD).write_text(head, encoding="utf-8")
    with pytest.raises(st.StabilityError, match="zarr.json is damaged"):
        st.read_map(folder)


def test_launches_of_a_damaged_store_are_run_again(tmp_path: Path) -> None:
    asked: dict[str, Any] = {
        "contact": "viscous",
        "mu": 0.3,
        "family": "spinning",
        "horizon": 20.0,
        "chunk": 8,
        "x": ("at", 0.5, 3.0, 8),
        "y": ("tilt", 0.05, 1.0, 4),
        "store": tmp_path / "a.zarr",
    }
    right = st.basins(**asked).load()
    (chunk,) = sorted((tmp_path / "a.zarr" / "end_time").glob("c.0.0"))
    assert st.read_basins(tmp_path / "a.zarr").identical(right)
    chunk.unlink()
    for lazy in (False, True):
        with pytest.raises(st.StabilityError, match=r"chunk 0.0 of end_time is damaged; give"):
            st.read_basins(tmp_path / "a.zarr", lazy=lazy).end_time.load()
    with pytest.warns(st.StabilityWarning, match=r"chunk 0.0 of end_time is damaged, and is comp"):
        again = st.basins(**asked).load()
    assert again.end_time.identical(right.end_time)


def test_a_store_of_an_earlier_version_is_read_with_a_sentence(tmp_path: Path) -> None:
    """As they were: no records of chunks, no checksums in the head."""
    import json

    from stability.storage.zarr_store import PRINT, QUESTION, fingerprint_of

    folder = st.stream_map("rolling", **AXES, out=tmp_path / "map.zarr")
    right = st.read_map(folder)
    head = json.loads((folder / HEAD).read_text(encoding="utf-8"))
    attributes = head["attributes"]
    asked = json.loads(attributes[QUESTION]) | {"the format": plain_json([1, "0.5.0"])}
    attributes |= {QUESTION: plain_json(asked), PRINT: fingerprint_of(asked)}
    del attributes[FILES], attributes[ITSELF]
    (folder / HEAD).write_text(json.dumps(head), encoding="utf-8")
    for record in folder.rglob("whole.*"):
        record.unlink()
    with pytest.warns(st.StabilityWarning, match="earlier version, without checksums"):
        found = st.read_map(folder)
    assert np.array_equal(found.verdict, right.verdict)
    with pytest.raises(st.StabilityError, match="was made with other arguments"):
        st.stream_map("rolling", **AXES, out=folder)
