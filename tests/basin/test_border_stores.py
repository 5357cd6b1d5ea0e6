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
from stability.basin.refinement import waves
from stability.figures.basin.basins import basins_caption

MAP: dict[str, Any] = {
    "contact": "viscous", "mu": 0.3, "family": "spinning", "x": ("at", 2.2, 4.6, 7),
    "y": ("tilt", 0.05, 0.95, 6), "horizon": 60.0, "check": False, "workers": 1, "chunk": 16,
}  # fmt: skip


def tree(folder: Path) -> dict[str, bytes]:
    return {str(p.relative_to(folder)): p.read_bytes() for p in folder.rglob("*") if p.is_file()}


@pytest.fixture(scope="module")
def whole(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A store that nothing disturbed, of three halvings."""
    folder = tmp_path_factory.mktemp("whole") / "a.zarr"
    st.basins(**MAP, levels=3, store=folder)
    return folder


def test_an_opened_store_has_the_borders_of_memory_and_draws_them(whole: Path) -> None:
    memory, opened = st.basins(**MAP, levels=3), xarray.open_zarr(whole)
    names = [str(n) for n in memory.variables if str(n).startswith("border_")]
    assert len(names) == 7 and memory.sizes["border_point"] > 20
    for name in names:
        np.testing.assert_array_equal(opened[name].values, memory[name].values)
        assert opened[name].dtype == memory[name].dtype
    for name in ("border_width", "border_launches", "border_levels", "border_note"):
        assert opened.attrs[name] == memory.attrs[name]
    [main] = [a for a in st.plot_basins(opened).axes if a.get_ylabel().startswith("tilt")]
    drawn = [c for c in main.collections if isinstance(c, LineCollection)][-1].get_segments()
    true = np.stack([memory.border_phi_dot, memory.border_tilt], axis=1)
    np.testing.assert_array_equal(np.concatenate(drawn), true)
    assert "refined" in basins_caption(opened)
    assert "refined" not in basins_caption(opened.drop_vars(names))


def test_more_halvings_ask_only_what_is_new(
    whole: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    asked: list[int] = []
    run = waves.LaunchLabels.of

    def counted(self: Any, points: Any) -> Any:
        asked.append(len(points))
        return run(self, points)

    monkeypatch.setattr(waves.LaunchLabels, "of", counted)
    out = tmp_path / "a.zarr"
    few = st.basins(**MAP, levels=2, store=out)
    assert sum(asked) == few.attrs["border_launches"] > 0
    before = sum(asked)
    more = st.basins(**MAP, levels=3, store=out)
    assert sum(asked) == more.attrs["border_launches"] > before
    assert tree(out) == tree(whole)
    st.basins(**MAP, levels=3, store=out)
    assert sum(asked) == more.attrs["border_launches"]


def test_progress_counts_the_launches_along_borders() -> None:
    told: list[tuple[int, int]] = []
    found = st.basins(**MAP, levels=3, progress=lambda done, total: told.append((done, total)))
    done = [d for d, _ in told]
    assert done == sorted(done) and all(d <= t for d, t in told)
    assert told[-1] == (42 + found.attrs["border_launches"],) * 2
    [first] = {t for d, t in told if 42 < d < 60} or {0}
    assert first == 0 or 0.3 < (first - 42) / found.attrs["border_launches"] < 3


def test_while_borders_are_replaced_the_store_is_a_map_without_them(
    whole: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The write fails at each file in turn: what is there is always whole."""
    import stability.jobs.zarr_store as module

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


SCRIPT = """
import sys
import stability as st
st.basins(contact="viscous", mu=0.3, family="spinning", x=("at", 2.2, 4.6, 7),
          y=("tilt", 0.05, 0.95, 6), horizon=60.0, check=False, workers=1, chunk=16, levels=3,
          store=sys.argv[1])
"""


@pytest.mark.skipif(sys.platform == "win32", reason="SIGKILL")
@pytest.mark.parametrize("kills", [2, pytest.param(10, marks=pytest.mark.long)])
def test_a_killed_refinement_is_resumed_to_the_same_bytes(
    kills: int, whole: Path, tmp_path: Path
) -> None:
    out, rng = tmp_path / "a.zarr", np.random.default_rng(7)
    total = len(tree(whole))
    for _ in range(kills):
        run = subprocess.Popen([sys.executable, "-c", SCRIPT, str(out)], env=dict(os.environ))
        aim = len(tree(out)) + int(rng.integers(1, max(2, total // 8))) if out.exists() else 30
        while run.poll() is None and (not out.exists() or len(files(out)) < aim):
            time.sleep(0.002)
        run.send_signal(signal.SIGKILL)
        run.wait()
        if out.exists():
            opened = xarray.open_zarr(out)
            assert ("border_point" in opened.sizes) == ("border_levels" in opened.attrs)
    done = subprocess.run([sys.executable, "-c", SCRIPT, str(out)], capture_output=True,
                          text=True, check=False)  # fmt: skip
    assert done.returncode == 0, done.stderr
    assert tree(out) == tree(whole)


def files(folder: Path) -> list[str]:
    return [name for _, _, names in os.walk(folder) for name in names]
