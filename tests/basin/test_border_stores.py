"""Borders of a map are kept wave by wave, added whole, and read back."""

import os
import signal
import subprocess
import sys
import time
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import xarray
from matplotlib.collections import LineCollection

import stability as st
from stability.basin import refinement
from stability.figures.basins import basins_caption

MAP: dict[str, Any] = {
    "contact": "viscous",
    "mu": 0.3,
    "family": "spinning",
    "x": ("at", 2.2, 4.6, 7),
    "y": ("tilt", 0.05, 0.95, 6),
    "horizon": 60.0,
    "check": False,
    "workers": 1,
    "chunk": 16,
}


def tree(folder: Path) -> dict[str, bytes]:
    return {str(p.relative_to(folder)): p.read_bytes() for p in folder.rglob("*") if p.is_file()}


@pytest.fixture(scope="module")
def whole(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A store that nothing disturbed, of three halvings."""
    folder = tmp_path_factory.mktemp("whole") / "a.zarr"
    st.basins(**MAP, levels=3, store=folder)
    return folder


@pytest.mark.long
def test_an_opened_store_has_the_borders_of_memory_and_draws_them(whole: Path) -> None:
    memory, opened = st.basins(**MAP, levels=3), xarray.open_zarr(whole)
    names = [str(n) for n in memory.variables if str(n).startswith("border_")]
    assert len(names) == 7 and memory.sizes["border_point"] > 20
    for name in names:
        np.testing.assert_array_equal(opened[name].values, memory[name].values)
        assert opened[name].dtype == memory[name].dtype
    for name in (
        "border_width",
        "border_launches",
        "border_levels",
        "border_note",
        "border_exponent_note",
        "border_sensitive_note",
    ):
        assert opened.attrs[name] == memory.attrs[name]
    [main] = [a for a in st.plot_basins(opened).axes if a.get_ylabel().startswith("tilt")]
    drawn = [c for c in main.collections if isinstance(c, LineCollection)][-1].get_segments()
    true = np.stack([memory.border_phi_dot, memory.border_tilt], axis=1)
    np.testing.assert_array_equal(np.concatenate(drawn), true)
    assert "refined" in basins_caption(opened)
    assert "refined" not in basins_caption(opened.drop_vars(names))


@pytest.mark.long
def test_more_halvings_ask_only_what_is_new(
    whole: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    asked: list[int] = []
    run = refinement.LaunchLabels.of

    def counted(self: Any, points: Any) -> Any:
        asked.append(len(points))
        return run(self, points)

    monkeypatch.setattr(refinement.LaunchLabels, "of", counted)
    out = tmp_path / "a.zarr"
    few = st.basins(**MAP, levels=2, store=out)
    assert sum(asked) == few.attrs["border_launches"] > 0
    before = sum(asked)
    more = st.basins(**MAP, levels=3, store=out)
    assert sum(asked) == more.attrs["border_launches"] > before
    assert tree(out) == tree(whole)
    st.basins(**MAP, levels=3, store=out)
    assert sum(asked) == more.attrs["border_launches"]


@pytest.mark.long
def test_progress_counts_the_launches_along_borders() -> None:
    told: list[tuple[int, int]] = []
    found = st.basins(**MAP, levels=3, progress=lambda done, total: told.append((done, total)))
    done = [d for d, _ in told]
    assert done == sorted(done) and all(d <= t for d, t in told)
    assert told[-1] == (42 + found.attrs["border_launches"],) * 2
    [first] = {t for d, t in told if 42 < d < 60} or {0}
    assert first == 0 or 0.3 < (first - 42) / found.attrs["border_launches"] < 3


@pytest.mark.long
def test_while_borders_are_replaced_the_store_is_a_map_without_them(
    whole: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The write fails at each file in turn: what is there is always whole."""
    import stability.storage.zarr_store as module

    out, write = tmp_path / "a.zarr", module._write
    st.basins(**MAP, levels=2, store=out)
    for last in range(40):
        left = [last]

        def failing(path: Path, content: bytes, left: list[int] = left) -> None:
            if left[0] == 0 and "border_labels" not in path.parts:
                raise OSError
            left[0] -= "border_labels" not in path.parts
            write(path, content)

        monkeypatch.setattr(module, "_write", failing)
        try:
            st.basins(**MAP, levels=3, store=out)
        except OSError:
            opened = xarray.open_zarr(out)
            assert (opened.outcome >= 0).all()
            levels = opened.attrs.get("border_levels")
            assert levels == (2 if last == 0 else None)
            if levels is None:
                assert "border_point" not in opened.sizes
        else:
            break
    assert last > 10
    assert tree(out) == tree(whole)


class Counted:
    """Labels that follow from the launches, and how many launches were asked."""

    asked = 0

    def of(self, points: Any) -> Any:
        self.asked += len(points)
        return (10 * points[:, 0]).astype(np.int64)


def test_a_wave_is_read_back_and_one_of_other_launches_is_computed_anew(tmp_path: Path) -> None:
    one, other = np.array([[0.1, 1.0], [0.2, 1.0]]), np.array([[0.3, 1.0], [0.4, 1.0]])
    for points, asked in (((one, other), 4), ((one, other), 0), ((one, one), 2), ((other,), 2)):
        labels = Counted()
        run = refinement.Waves(labels, tmp_path, None, 1, None, 0, 0)  # type: ignore[arg-type]
        for some in points:
            np.testing.assert_array_equal(run(some), 10 * some[:, 0])
        assert labels.asked == asked
    names = {p.name for p in (tmp_path / refinement.FOLDER).iterdir()}
    assert names == {"0000.zarr", "0001.zarr"}


SCRIPT = """
import sys
import stability as st
from stability.basin import refinement
refinement.LEAST_CHUNK = int(sys.argv[3])
if __name__ == "__main__":
    st.basins(contact="viscous", mu=0.3, family="spinning", x=("at", 2.2, 4.6, 7),
              y=("tilt", 0.05, 0.95, 6), horizon=60.0, check=False, chunk=16, levels=3,
              store=sys.argv[1], executor=sys.argv[2], workers=1 + (sys.argv[2] == "processes"))
"""
FINE = 16
"""Fewest launches of a chunk of a wave, so that two processes share one."""


@pytest.fixture(scope="module")
def fine(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The same store with waves of many chunks, by one thread."""
    folder, least = tmp_path_factory.mktemp("fine") / "a.zarr", refinement.LEAST_CHUNK
    refinement.LEAST_CHUNK = FINE
    try:
        st.basins(**MAP, levels=3, store=folder)
    finally:
        refinement.LEAST_CHUNK = least
    return folder


def test_a_refinement_that_stops_at_a_write_is_resumed_to_the_same_bytes(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """In one process; a killed one is a long test."""
    import stability.storage.zarr_store as module

    class Stopped(BaseException):
        pass

    monkeypatch.setattr(refinement, "LEAST_CHUNK", FINE)
    few: dict[str, Any] = MAP | {
        "x": ("at", 2.2, 4.6, 3),
        "y": ("tilt", 0.05, 0.95, 3),
        "horizon": 2.0,
        "levels": 2,
    }
    st.basins(**few, store=tmp_path / "whole.zarr")
    out, write, left = tmp_path / "a.zarr", module._write, [1]

    def stopping(path: Path, content: bytes) -> None:
        if refinement.FOLDER in path.parts and path.name.startswith("c."):
            if left[0] == 0:
                raise Stopped
            left[0] -= 1
        write(path, content)

    with monkeypatch.context() as patch, pytest.raises(Stopped):
        patch.setattr(module, "_write", stopping)
        st.basins(**few, store=out)
    opened = xarray.open_zarr(out)
    assert ("border_point" in opened.sizes) == ("border_levels" in opened.attrs)
    assert len(labels_of(out)) < len(labels_of(tmp_path / "whole.zarr"))
    st.basins(**few, store=out)
    assert tree(out) == tree(tmp_path / "whole.zarr")


@pytest.mark.long
@pytest.mark.skipif(sys.platform == "win32", reason="SIGKILL")
@pytest.mark.parametrize(
    ("executor", "kills"), [("threads", 2), ("processes", 1), ("threads", 10), ("processes", 6)]
)
def test_a_killed_refinement_is_resumed_to_the_same_bytes(
    executor: str, kills: int, whole: Path, fine: Path, tmp_path: Path
) -> None:
    out, rng = tmp_path / "a.zarr", np.random.default_rng(7)
    same = whole if executor == "threads" else fine
    least = str(refinement.LEAST_CHUNK if executor == "threads" else FINE)
    words = [sys.executable, "-c", SCRIPT, str(out), executor, least]
    within = 0
    for turn in range(kills):
        run = subprocess.Popen(words, env=dict(os.environ))
        while run.poll() is None and not aimed(out, same, (turn + rng.random()) / kills):
            time.sleep(0.002)
        run.send_signal(signal.SIGKILL)
        run.wait()
        within += bool(labels_of(out)) and len(labels_of(out)) < len(labels_of(same))
        if out.exists():
            opened = xarray.open_zarr(out)
            assert ("border_point" in opened.sizes) == ("border_levels" in opened.attrs)
    assert within  # at least one among the waves
    done = subprocess.run(words, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    assert tree(out) == tree(same)


def aimed(out: Path, same: Path, part: float) -> bool:
    """Whether so much of the waves is there that it is time for a kill."""
    return len(labels_of(out)) > part * len(labels_of(same))


def labels_of(folder: Path) -> list[Path]:
    """Chunks of waves that are there."""
    return list((folder / refinement.FOLDER).glob("*/label/whole.*"))
