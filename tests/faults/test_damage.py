"""Damaged files: each reads to the right numbers or is refused in a sentence, and soon."""

import json
import math
import os
import shutil
from collections import Counter
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import cache, partial
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from damage import BOMBS, bomb, damage

import stability as st
from stability.jobs import measured_cells as journal
from stability.jobs.measured_cells import DONE, Cell, Journal
from stability.storage.checksum import ATTRIBUTE, LENGTH, seal
from stability.storage.pieces import Checkpoint

SEED = int(os.environ.get("STABILITY_SEED", "20261121"))
SLOWEST = 20.0
"""Seconds of processor time that a file may take."""
AXES: dict[str, Any] = {"x": ("at", 0.5, 4, 10), "y": ("mu", 0.1, 2, 8)}


@dataclass
class Sample:
    """A kind of file, and how it is read."""

    content: bytes
    other: bytes
    """Of a file of the same kind that holds something else."""
    suffix: str
    read: Callable[[Path], Any]
    """What it holds, or None where it counts as not there."""
    right: Callable[[Any], bool]
    """Whether that is what was written."""
    swaps: bool = True
    """Whether the other file, as a whole, is damage: it holds what it says otherwise."""


@pytest.fixture(scope="module")
def samples(tmp_path_factory: pytest.TempPathFactory) -> Iterator[dict[str, Sample]]:
    folder = tmp_path_factory.mktemp("samples")
    found = {}
    maps = [st.stability_map(f, **AXES, certify=True, modes=True) for f in ("spinning", "rolling")]
    files = [st.write_map(m, folder / f"map{i}.nc") for i, m in enumerate(maps)]
    found["map"] = Sample(
        *(f.read_bytes() for f in files), ".nc", st.read_map, maps[0].identical, swaps=False
    )
    streams = [st.stream_map(f, **AXES, out=folder / f"{f}.nc") for f in ("spinning", "rolling")]
    verdicts = st.read_map(streams[0])
    found["stream"] = Sample(
        *(f.read_bytes() for f in streams), ".nc", st.read_map, verdicts.identical, swaps=False
    )
    runs = [
        st.simulate(
            st.Disk(), st.Coulomb(0.2), {"theta": 1.2, "slip_x": v}, np.arange(3.0), pose=True
        )
        for v in (0.1, 0.2)
    ]
    files = [st.write_motion(r, folder / f"run{i}.nc") for i, r in enumerate(runs)]
    found["motion"] = Sample(
        *(f.read_bytes() for f in files), ".nc", st.read_motion, runs[0].identical, swaps=False
    )
    found["part"] = _part(folder)
    with pytest.MonkeyPatch.context() as patch:  # the package does not change meanwhile
        patch.setattr(journal, "fingerprint", cache(journal.fingerprint))
        found["journal"] = _journal(folder)
        yield found


def _part(folder: Path) -> Sample:
    """A chunk of a checkpoint; the other is the same chunk of another map."""
    random, key = np.random.default_rng(1), {"family": "spinning"}
    chunks = [{"abscissa": random.normal(size=300), "codes": np.ones(300, np.int8)} for _ in "ab"]
    contents = []
    for i, chunk in enumerate(chunks):
        Checkpoint(folder / f"kept{i}", key | {"map": i}).add(0, chunk)
        contents.append((folder / f"kept{i}" / "0.npz").read_bytes())

    def read(path: Path) -> Any:
        parts = Checkpoint(folder / "kept0", key | {"map": 0})
        shutil.copy(path, parts.folder / "0.npz")
        return parts.get(0)

    return Sample(
        contents[0],
        contents[1],
        ".npz",
        read,
        lambda found: all(np.array_equal(found[n], v) for n, v in chunks[0].items()),
    )


def _journal(folder: Path) -> Sample:
    """Cells of a report; a damaged one is done again, so that those that are left must be right."""
    kept = []
    for i in (0, 1):
        cells = Journal(folder / f"report{i}")
        for n in range(40):
            value = {"error": [n + i, 0.1 * n, math.inf], "word": "right"}  # of which JSON has none
            cells.add(f"cell {n}", Cell(f"cell {n}", DONE, value, "", 0.25 * n))
        for line in cells.path.read_text(encoding="utf-8").splitlines():
            json.loads(line.partition("\t")[0], parse_constant=pytest.fail)
        kept.append(cells)

    def read(path: Path) -> Any:
        shutil.copy(path, folder / "report0" / "cells.jsonl")
        return Journal(folder / "report0").pieces

    whole = [dict(j.pieces) for j in kept]
    return Sample(
        *(j.path.read_bytes() for j in kept),
        ".jsonl",
        read,
        lambda found: all(any(c.get(k) == v for c in whole) for k, v in found.items()),
        swaps=False,
    )


def processor() -> float:
    """Processor time of this process and of those that it waited for [s]."""
    used = os.times()
    return used.user + used.system + used.children_user + used.children_system


def judged(sample: Sample, content: bytes, path: Path) -> tuple[str, float]:
    """refused, absent or right, and the processor time that it took; anything else fails."""
    path.write_bytes(content)
    begin = processor()
    try:
        found = sample.read(path)
    except st.StabilityError as error:
        assert len(str(error).splitlines()) == 1, str(error)
        assert len(str(error)) <= 300
        return "refused", processor() - begin
    took = processor() - begin
    if found is None:
        return "absent", took
    assert sample.right(found), "read to other numbers"
    return "right", took


def campaign(samples: dict[str, Sample], counts: dict[str, int], folder: Path, seed: int) -> None:
    for kind, count in counts.items():
        tally: Counter[str] = Counter()
        random, slowest = np.random.default_rng([seed, len(kind)]), 0.0
        sample = samples[kind]
        for i in range(count):
            name, content = damage(sample.content, sample.other, random, swaps=sample.swaps)
            (folder / f"last-{kind}").write_text(f"{seed} {i} {name}")
            ended, took = judged(sample, content, folder / f"damaged{sample.suffix}")
            tally[f"{name} {ended}"] += 1
            slowest = max(slowest, took)
            assert took < SLOWEST, (kind, name, i)
        print(f"{kind}: {count} files, slowest {slowest:.1f} s; {dict(sorted(tally.items()))}")


def test_a_damaged_file_reads_to_the_right_numbers_or_is_refused(
    samples: dict[str, Sample], tmp_path: Path
) -> None:
    for sample in samples.values():  # undamaged it is read
        assert judged(sample, sample.content, tmp_path / f"same{sample.suffix}")[0] == "right"
    campaign(samples, {"part": 24, "journal": 6}, tmp_path, SEED)
    for kind in ("map", "stream", "motion"):  # those whose checksum stands are refused at once
        sample, random = samples[kind], np.random.default_rng(SEED)
        for _ in range(10):
            content = bytearray(sample.content)
            content[random.integers(len(content) - LENGTH)] ^= int(random.integers(1, 256))
            assert judged(sample, bytes(content), tmp_path / "flip.nc")[0] == "refused"


@pytest.fixture
def in_this_process(monkeypatch: pytest.MonkeyPatch) -> None:
    """As where Python is embedded: no process is started to read a file without a checksum."""
    monkeypatch.setattr("sys.executable", "")


@pytest.mark.usefixtures("in_this_process")
def test_a_file_that_lost_its_checksum_is_refused(
    samples: dict[str, Sample], tmp_path: Path
) -> None:
    sample = samples["map"]
    (tmp_path / "cut.nc").write_bytes(sample.content[:-LENGTH])
    with pytest.raises(st.StabilityError, match="checksum is missing"):
        st.read_map(tmp_path / "cut.nc")


def plain(dataset: Any, path: Path) -> Path:
    """A file as version 0.4.0 wrote it: without a checksum."""
    assert ATTRIBUTE not in dataset.attrs
    dataset.to_netcdf(path, engine="h5netcdf")
    return path


def test_a_map_of_an_earlier_version_is_read(tmp_path: Path) -> None:
    a_map = st.stability_map("rolling", x=("at", 0.5, 4, 4), y=("mu", 0.1, 2, 3))
    assert st.read_map(plain(a_map, tmp_path / "map.nc")).identical(a_map)


@pytest.mark.usefixtures("in_this_process")
def test_a_run_of_an_earlier_version_is_read(tmp_path: Path) -> None:
    a_run = st.simulate(st.Disk(), st.Viscous(0.3), {"theta": 1.4}, [0.5, 1.0], method="dop853")
    assert st.read_motion(plain(a_run, tmp_path / "run.nc")).identical(a_run)


@pytest.mark.usefixtures("in_this_process")
def test_a_flag_without_a_meaning_is_refused_in_an_old_file(tmp_path: Path) -> None:
    found = st.stability_map("rolling", **AXES)
    found.verdict[3, 4] = 77
    with pytest.raises(st.StabilityError, match="flag has no meaning"):
        st.read_map(plain(found, tmp_path / "map.nc"))


@pytest.mark.long
@pytest.mark.parametrize("with_checksum", [False, True])
@pytest.mark.parametrize("kind", BOMBS)
def test_a_small_file_that_declares_gigabytes_is_refused(
    tmp_path: Path, kind: str, with_checksum: bool
) -> None:
    path = tmp_path / "bomb.nc"
    bomb(path, kind)
    assert path.stat().st_size < 1e6
    if with_checksum:
        seal(path)
    with pytest.raises(st.StabilityError, match=r"declares .* bytes") as caught:
        st.read_map(path)
    assert len(str(caught.value).splitlines()) == 1


def test_a_map_beyond_the_free_memory_is_refused_and_can_be_read_lazily(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    path = st.stream_map(
        "rolling", x=("at", 1, 2, 400), y=("mu", 1, 2, 300), out=tmp_path / "map.nc"
    )
    monkeypatch.setattr("stability.storage.netcdf.available", lambda: 10**5)
    with pytest.raises(st.StabilityError, match="memory are free; read it with lazy=True"):
        st.read_map(path)
    with st.read_map(path, lazy=True) as found:
        assert found.verdict.shape == (300, 400)


def test_a_checkpoint_with_a_wrong_part_gives_the_right_map(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A part with NaN and a flag of no meaning, as 0.4.0 took it over; and one of another place."""
    monkeypatch.setattr("stability.maps.cells.BAND", 16)
    fresh = st.stability_map("spinning", **AXES, checkpoint=tmp_path / "kept")
    parts = sorted((tmp_path / "kept").glob("*.npz"))
    assert len(parts) == 8
    with np.load(parts[0]) as stored:
        wrong = dict(stored)
    wrong["abscissa"][5], wrong["codes"][5] = np.nan, 77
    np.savez(parts[0], **wrong)
    shutil.copy(parts[2], parts[3])
    again = st.stability_map("spinning", **AXES, checkpoint=tmp_path / "kept")
    assert again.assign_attrs(created="").identical(fresh.assign_attrs(created=""))


def test_another_table_of_polynomials_is_refused(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    import stability.bodies.disk_polynomials as module

    content = (Path(module.__file__).parent / module.DATA).read_bytes()
    monkeypatch.setattr(module, "files", lambda _: tmp_path)
    random = np.random.default_rng(SEED)
    contents = [damage(content, content[::-1], random)[1] for _ in range(20)]
    edited = json.loads(content)
    edited["cases"]["rolling viscous"]["conditions"][0]["terms"][0][0] = 3
    contents += [json.dumps(edited).encode(), b"", b"{}"]
    try:
        for one in contents:
            module._catalogue.cache_clear()
            (tmp_path / module.DATA).write_bytes(one)
            with pytest.raises(st.StabilityError, match="not the file that was derived"):
                module.exact_polynomial("rolling", "viscous")
        module._catalogue.cache_clear()
        (tmp_path / module.DATA).write_bytes(content)
        assert module.exact_polynomial("rolling", "viscous").zeros == 2
    finally:
        module._catalogue.cache_clear()


@pytest.mark.parametrize("derived", ["as stored", pytest.param("again", marks=pytest.mark.long)])
def test_deriving_writes_the_table_and_its_digest(tmp_path: Path, derived: str) -> None:
    from proofs import stored

    import stability.bodies.disk_polynomials as module

    table = Path(module.__file__).parent / module.DATA
    source = Path(module.__file__).read_text(encoding="utf-8")
    assert module.digest(table.read_bytes()) == module.DIGEST
    assert module.digest(table.read_bytes().replace(b"\n", b"\r\n")) == module.DIGEST
    derive = stored.of_disk
    if derived == "as stored":
        derive = partial(json.loads, table.read_bytes())
    (tmp_path / "exact.py").write_text(source.replace(module.DIGEST, "0" * 64), encoding="utf-8")
    where = tmp_path / "exact.json", tmp_path / "exact.py"
    assert stored.write(*where, derive) == list(json.loads(table.read_bytes())["cases"])
    assert stored.write(*where, derive) == []
    assert (tmp_path / "exact.json").read_bytes() == table.read_bytes()
    assert (tmp_path / "exact.py").read_text(encoding="utf-8") == source
    (tmp_path / "exact.py").write_text("no digest here", encoding="utf-8")
    with pytest.raises(st.StabilityError, match="0 lines for the digest"):
        stored.write(tmp_path / "other.json", tmp_path / "exact.py", derive)
    assert not (tmp_path / "other.json").exists()


@pytest.mark.parametrize(
    "terms",
    [
        (("__import__('os')", (1,)),),
        ((1.5, (1,)),),
        ((True, (1,)),),
        ((1, ("0",)),),
        ((1, (-1,)),),
        ((1, (1, 2)),),
        ((1, (10**9,)),),
    ],
)
def test_only_integers_become_the_source_of_a_function(terms: Any) -> None:
    from stability.algebra.polynomial import Polynomial

    with pytest.raises(st.StabilityError, match="give an integer"):
        Polynomial(("x",), terms)


@pytest.mark.long
def test_thousands_of_damaged_files(samples: dict[str, Sample], tmp_path: Path) -> None:
    counts = {"map": 700, "stream": 250, "motion": 500, "part": 400, "journal": 150}
    campaign(samples, counts, tmp_path, SEED)


@pytest.mark.long
def test_damaged_files_of_earlier_versions_come_to_an_end(tmp_path: Path) -> None:
    """No checksum: numbers may be wrong, but every file is read or refused, within its time."""
    a_map = st.stability_map("spinning", **AXES, certify=True)
    a_run = st.simulate(st.Disk(), st.Coulomb(0.2), {"theta": 1.2, "slip_x": 0.1}, [0.5, 1.0])
    random, slowest = np.random.default_rng(SEED), 0.0
    tally: Counter[str] = Counter()
    for found, read in ((a_map, st.read_map), (a_run, st.read_motion)):
        content = plain(found, tmp_path / "old.nc").read_bytes()
        sample = Sample(content, content[::-1], ".nc", read, lambda _: True)
        for _ in range(150):
            name, damaged = damage(content, content[::-1], random, swaps=False)
            ended, took = judged(sample, damaged, tmp_path / "damaged.nc")
            tally[f"{name} {ended}"] += 1
            slowest = max(slowest, took)
    print(f"slowest {slowest:.1f} s; {dict(sorted(tally.items()))}")
    assert slowest < SLOWEST
