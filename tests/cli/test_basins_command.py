"""`stability basins`: what it launches, what it says before and after, and what it refuses."""

import json
import os
import pty
import random
import re
import signal
import subprocess
import sys
import time
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import xarray
from command_line import interrupted, output, refused
from PIL import Image

import stability as st
from stability.cli.commands import main
from stability.cli.terminal import progress_bar

EXAMPLES = Path(__file__).resolve().parents[2] / "examples"
MAP = (
    "basins",
    "--family",
    "spinning",
    "--x",
    "at:0.5:3:6",
    "--y",
    "tilt:0.1:0.5:4",
    "--mu",
    "0.3",
    "--time",
    "30",
)


@pytest.fixture(autouse=True)
def few_trials(monkeypatch: pytest.MonkeyPatch) -> None:
    """Of two launches, which is enough for what is said of them."""
    monkeypatch.setattr("stability.basin.cost.LAST", 2)


@pytest.mark.long
def test_the_store_is_that_of_the_function(
    capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    out, png = tmp_path / "a.zarr", tmp_path / "a.png"
    found = json.loads(output(capsys, *MAP, "--out", str(out), "--plot", str(png), "--json"))
    true = st.basins(
        contact="viscous",
        mu=0.3,
        family="spinning",
        x=("at", 0.5, 3, 6),
        y=("tilt", 0.1, 0.5, 4),
        horizon=30.0,
    )
    store = xarray.open_zarr(out)
    for name in ("outcome", "member", "end_time", "start_state", "linear_verdict"):
        np.testing.assert_array_equal(store[name].values, true[name].values)
    assert found["launches"] == 24 == sum(found["outcomes"].values())
    assert found["outcomes"]["settled"] == int((true.outcome == 1).sum()) > 0
    assert found["cost"]["launches"] == 24
    assert png.read_bytes().startswith(b"\x89PNG")
    again = json.loads(output(capsys, *MAP, "--out", str(out), "--json"))
    assert again["outcomes"] == found["outcomes"]
    assert (again["cost"]["launches"], again["cost"]["stored"]) == (0, 24)


def test_it_says_what_it_will_cost_before_it_starts(
    capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    assert st.cli.main([*MAP, "--out", str(tmp_path / "a.zarr"), "--workers", "2"]) == 0
    said = capsys.readouterr()
    assert re.fullmatch(
        r"stability: 24 launches to run: (about|under) [\w. ]+ with 2 workers, [\w. ]+ of "
        r"computing; store about [\d.]+ kB; by 2 launches that were tried\n",
        said.err,
    )
    assert re.fullmatch(r".*a\.zarr: \d+ moving, \d+ settled\n", said.out)


def test_a_dry_run_says_the_cost_and_writes_nothing(
    capsys: pytest.CaptureFixture[str], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("stability.jobs.filling.fill", lambda *_, **__: pytest.fail("it ran"))
    words = (*MAP, "--out", str(tmp_path / "a.zarr"), "--plot", str(tmp_path / "a.png"))
    text = output(capsys, *words, "--dry-run")
    assert text.startswith("24 launches to run: ")
    found = json.loads(output(capsys, *words, "--dry-run", "--json"))["cost"]
    assert found["launches"] == 24
    assert found["computing_seconds"] > 0
    assert list(tmp_path.iterdir()) == []


def test_a_dry_run_leaves_a_store_of_another_question_as_it_is(
    capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    out = tmp_path / "a.zarr"
    output(capsys, *MAP, "--out", str(out))
    before = {p: p.read_bytes() for p in out.rglob("*") if p.is_file()}
    other = (*MAP[:-1], "31", "--out", str(out), "--dry-run")
    assert "other arguments (horizon: 30.0 there, 31.0 here)" in refused(capsys, *other)
    law = (*MAP, "--mu", "0.31", "--out", str(out))
    assert "(mu of its parameters: 0.3 there, 0.31 here)" in refused(capsys, *law)
    assert output(capsys, *other, "--force").startswith("24 launches to run: ")
    assert {p: p.read_bytes() for p in out.rglob("*") if p.is_file()} == before


@pytest.mark.long
def test_borders_are_refined_for_the_figure(
    capsys: pytest.CaptureFixture[str], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    drawn: list[xarray.Dataset] = []
    monkeypatch.setattr("stability.figures.basins.plot_basins", drawn.append)
    monkeypatch.setattr("stability.figures.canvas.save_figure", lambda _, path, **__: path.touch())
    monkeypatch.setattr("stability.basin.cost.LAST", 24)
    words = (*MAP, "--out", str(tmp_path / "a.zarr"), "--levels", "2")
    told = output(capsys, *words, "--dry-run")
    assert re.match(r"24 launches to run and about \d+ along borders: ", told)
    cost = json.loads(output(capsys, *words, "--json", "--plot", str(tmp_path / "a.png")))["cost"]
    again = json.loads(output(capsys, *words, "--json"))["cost"]
    assert (again["launches"], again["border_launches"]) == (0, 0)
    true = st.basins(
        contact="viscous",
        mu=0.3,
        family="spinning",
        x=("at", 0.5, 3, 6),
        y=("tilt", 0.1, 0.5, 4),
        horizon=30.0,
        levels=2,
    )
    assert true.sizes["border_point"] > 10
    np.testing.assert_array_equal(drawn[0].border_tilt.values, true.border_tilt.values)
    assert 0.3 < cost["border_launches"] / true.border_launches < 3


@pytest.mark.long
@pytest.mark.filterwarnings("ignore::ResourceWarning")
def test_a_scheduler_in_one_word_writes_the_bytes_of_threads(
    capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    pytest.importorskip("distributed")
    before, stores = random.getstate(), {}
    for where in ("threads", "dask"):
        out = tmp_path / f"{where}.zarr"
        words = (*MAP, "--out", str(out), "--chunk", "6", "--scheduler", where, "--workers", "2")
        assert "24 launches" in output(capsys, *words, "--dry-run")
        output(capsys, *words)
        stores[where] = {p.relative_to(out): p.read_bytes() for p in out.rglob("*") if p.is_file()}
    random.setstate(before)  # `distributed` draws from it
    assert len(stores["threads"]) > 4 * 8
    assert stores["dask"] == stores["threads"]


def launches_of(capsys: pytest.CaptureFixture[str], tmp_path: Path, *words: str) -> xarray.Dataset:
    tmp_path.mkdir(exist_ok=True)
    out = tmp_path / "s.zarr"
    output(capsys, "basins", *words, "--out", str(out))
    return xarray.open_zarr(out)


@pytest.mark.long
def test_a_sample_has_its_distributions_and_its_seed(
    capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    words = (
        "--sample",
        "theta:uniform:0.3:1.5",
        "--sample",
        "omega3:normal:2:0.1",
        "--sample",
        "mu:log:0.1:1",
        "--count",
        "7",
        "--seed",
        "5",
        "--time",
        "2",
        "--plot",
        str(tmp_path / "s.png"),
    )
    found = launches_of(capsys, tmp_path, *words)
    with Image.open(tmp_path / "s.png") as picture:
        assert picture.width > 800
    spread = {
        "theta": st.Uniform(0.3, 1.5),
        "omega3": st.Normal(2, 0.1),
        "mu": st.LogUniform(0.1, 1),
    }
    true = st.basins(contact="viscous", distribution=spread, count=7, seed=5, horizon=2.0)
    for name in ("theta", "omega3", "mu", "outcome"):
        np.testing.assert_array_equal(found[name].values, true[name].values)


@pytest.mark.long
def test_bodies_systems_and_numbers_are_launched(
    capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    torus = (
        "--body",
        "torus",
        "--tube",
        "0.2",
        "--x",
        "omega3:0:1:2",
        "--y",
        "theta:1:1.2:2",
        "--set",
        "phi_dot=0.5",
        "--mu",
        "0.3",
        "--time",
        "1",
    )
    found = launches_of(capsys, tmp_path / "torus", *torus)
    assert found.attrs["body"] == st.Torus(0.2).name
    np.testing.assert_array_equal(found.start_state.values[..., 2], 0.5)
    near = (
        "--body",
        "eccentric-sphere",
        "--offset",
        "0.3",
        "--family",
        "vertical",
        "--pole",
        "pi",
        "--x",
        "at:1:2:2",
        "--y",
        "tilt:0.1:0.2:2",
        "--mu",
        "0.3",
        "--time",
        "1",
    )
    found = launches_of(capsys, tmp_path / "top", *near)
    true = st.basins(
        st.EccentricSphere(0.3),
        "viscous",
        mu=0.3,
        family="vertical",
        pole="pi",
        x=("at", 1, 2, 2),
        y=("tilt", 0.1, 0.2, 2),
        horizon=1.0,
    )
    np.testing.assert_array_equal(found.start_state.values, true.start_state.values)
    assert found.attrs["launched_near"] == "vertical at theta = pi"
    governor = (
        "--system",
        f"{EXAMPLES}/watt_governor.py:running",
        "--x",
        "x:0.5:1.5:2",
        "--y",
        "y:-1:1:2",
        "--set",
        "z=1.4",
        "--set",
        "e=0.8",
        "--set",
        "a=0.5",
        "--set",
        "b=0.5",
        "--time",
        "5",
    )
    found = launches_of(capsys, tmp_path / "governor", *governor)
    assert set(found.outcome.values.ravel().tolist()) <= {0, 1}
    assert float(found.z) == 1.4
    rod = (
        "--k",
        "0.3",
        "--x",
        "omega3:0:1:2",
        "--y",
        "mu:0.1:1:2",
        "--set",
        "theta=1.2",
        "--time",
        "1",
    )
    found = launches_of(capsys, tmp_path / "disk", *rod)
    assert json.loads(found.attrs["parameters"])["k"] == 0.3


GOOD = (
    "--x",
    "omega3:0:1:2",
    "--y",
    "theta:1:1.2:2",
    "--mu",
    "0.3",
    "--time",
    "1",
    "--out",
    "a.zarr",
)


@pytest.mark.parametrize(
    ("words", "sentence"),
    [
        (GOOD[2:], "--x is missing"),
        ((*GOOD, "--set", "omega3=1"), "omega3 varies and is set"),
        ((*GOOD, "--set", "omega3"), "give NAME=NUMBER"),
        ((*GOOD, "--set", "phi_dot=fast"), "a number is needed"),
        ((*GOOD, "--set", "speed=1"), "varies nothing here"),
        ((*GOOD, "--set", "mu=1"), "mu is given as --mu and by --set"),
        ((*GOOD, "--count", "5"), "--count belongs to --sample"),
        ((*GOOD, "--sample", "theta:uniform:0:1"), "--x does not go with --sample"),
        (("--sample", "theta:uniform:0.3:1", *GOOD[4:]), "--count is missing"),
        (("--sample", "theta:flat:0:1", "--count", "5", *GOOD[4:]), "give uniform, log or normal"),
        (("--sample", "theta:0:1", "--count", "5", *GOOD[4:]), "NAME:uniform:LOW:HIGH"),
        ((*GOOD[:-1], "a.nc"), ".zarr"),
        ((*GOOD[:-1], "missing/a.zarr"), "missing"),
        ((*GOOD, "--plot", "a.txt"), "a.txt"),
        ((*GOOD, "--more", "phi_dot:0:1:2", "--plot", "a.png"), "--plot draws a map of two axes"),
        ((*GOOD, "--scheduler", "cloud"), "give threads, processes, dask"),
        ((*GOOD, "--scheduler", "tcp://127.0.0.1:1"), "does not answer"),
        ((*GOOD, "--family", "flying"), "give one of rolling, spinning, tumbling"),
        ((*GOOD, "--workers", "0"), "workers"),
        (
            (
                "--sample theta:uniform:0.1:1 --count 5 --mu 0.3 --time 1 --out a.zarr --levels 2"
            ).split(),
            "--levels refines a map",
        ),
        ((*GOOD, "--levels", "-1", "--plot", "a.png"), "levels is -1"),
        ((*GOOD, "--chunk", "0"), "chunk"),
        ((*GOOD[:6], "--time", "-1", "--out", "a.zarr"), "horizon is -1"),
        ((*GOOD, "--x", "mu:0.1:1:3"), "mu is given as --mu and as an axis"),
        ((*GOOD, "--system", f"{EXAMPLES}/watt_governor.py:running"), "--mu belongs to the disk"),
        ((*GOOD, "--family", "rolling", "--x", "at:1:2:3", "--y", "tilt:0:2:9"), "the tilt takes"),
    ],
)
def test_bad_input_gets_one_sentence(
    capsys: pytest.CaptureFixture[str],
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    words: tuple[str, ...],
    sentence: str,
) -> None:
    monkeypatch.chdir(tmp_path)
    assert sentence in refused(capsys, "basins", *words)
    assert list(tmp_path.iterdir()) == []


MANY = (
    "basins",
    "--family",
    "spinning",
    "--x",
    "at:0.5:3:60",
    "--y",
    "tilt:0.1:0.5:400",
    "--mu",
    "0.3",
    "--time",
    "30",
    "--chunk",
    "100",
    "--workers",
    "2",
    "--out",
    "a.zarr",
)


def _kept_and_said(folder: Path, code: int | None, out: str, err: str) -> None:
    assert (code, out) == (130, "")
    last = err.strip().splitlines()[-1]
    where = r".* kept in .*a\.zarr: give the same command again"
    told = re.search(r"interrupted; (\d+) of 24000 " + where, last)
    assert told
    kept = len(list((folder / "a.zarr" / "outcome").glob("whole.*")))
    assert 0 < kept < 240
    assert int(told[1]) == 100 * kept  # those that ended while it stopped, too


def test_an_interrupted_run_keeps_all_and_says_how_to_go_on(
    capsys: pytest.CaptureFixture[str], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    chunks = tmp_path / "a.zarr" / "outcome"
    code = interrupted(lambda: list(chunks.glob("whole.*")), *MANY)
    said = capsys.readouterr()
    _kept_and_said(tmp_path, code, said.out, said.err)


@pytest.mark.long
def test_an_interrupted_process_keeps_all_and_says_how_to_go_on(tmp_path: Path) -> None:
    run = subprocess.Popen(
        [sys.executable, "-m", "stability", *MANY],
        cwd=tmp_path,
        text=True,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
    )
    while run.poll() is None and not list((tmp_path / "a.zarr" / "outcome").glob("whole.*")):
        time.sleep(0.05)
    run.send_signal(signal.SIGINT)
    out, err = run.communicate(timeout=60)
    _kept_and_said(tmp_path, run.returncode, out, err)


def test_the_time_left_is_that_of_the_launches_that_are_left(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """Ten thousand were stored, and a chunk of a thousand takes ten seconds: ninety are left."""
    now = [100.0]
    shown: list[float] = []
    monkeypatch.setattr("stability.cli.terminal.TICK", 1000.0)
    reader, writer = pty.openpty()
    with os.fdopen(writer, "w") as screen, monkeypatch.context() as patch:
        patch.setattr(sys, "stderr", screen)
        with progress_bar("launches", after=0.0) as progress:
            from stability.cli import terminal

            [bar] = terminal._bars
            bar._time = lambda: now[0]
            bar.last_print_t = now[0]
            now[0] += 40.0  # the prediction
            progress(10_000, 20_000)
            for tick in range(1, 41):
                now[0] += 0.25
                if tick == 40:
                    progress(11_000, 20_000)
                bar.update(0)  # as the clock does
            d = bar.format_dict
            rate = d["rate"] or (d["n"] - d["initial"]) / d["elapsed"]
            shown.append((20_000 - 11_000) / rate)
    os.close(reader)
    assert shown == pytest.approx([90.0])


def test_a_place_that_holds_no_store_is_refused_before_a_launch_is_tried(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    def tried(*_: Any, **__: Any) -> None:
        raise AssertionError("a launch was tried")

    monkeypatch.setattr("stability.basin.cost.predict", tried)
    (tmp_path / "mine.zarr").mkdir()
    (tmp_path / "mine.zarr" / "mine.txt").write_text("x")
    words = [
        "basins",
        "--family",
        "spinning",
        "--mu",
        "0.3",
        "--x",
        "at:2:3:4",
        "--y",
        "tilt:0.1:0.4:3",
        "--time",
        "5",
        "--out",
    ]
    assert main([*words, str(tmp_path / "mine.zarr"), "--overwrite"]) == 2
    assert "is no store of ours, or is damaged" in capsys.readouterr().err
    if Path("/proc").is_dir():
        assert main([*words, "/proc/a.zarr"]) == 2
        assert "cannot be written" in capsys.readouterr().err
    assert [p.name for p in tmp_path.iterdir()] == ["mine.zarr"]


def test_a_sample_may_name_the_member_by_at(tmp_path: Path) -> None:
    words = [
        "basins",
        "--family",
        "spinning",
        "--mu",
        "0.3",
        "--sample",
        "at:uniform:2:3",
        "--sample",
        "tilt:uniform:0.1:0.2",
        "--count",
        "4",
        "--time",
        "1",
        "--no-check",
        "--out",
        str(tmp_path / "a.zarr"),
    ]
    assert main(words) == 0
    assert {"phi_dot", "tilt"} <= set(xarray.open_zarr(tmp_path / "a.zarr").coords)


@pytest.mark.long
def test_refined_borders_are_said_to_be_sensitive_or_not(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    words = [
        "basins",
        "--family",
        "spinning",
        "--k",
        "0.5",
        "--mu",
        "0.3",
        "--x",
        "at:1:2.2:5",
        "--y",
        "tilt:0.05:0.6:5",
        "--levels",
        "4",
        "--time",
        "60",
        "--no-check",
        "--out",
        str(tmp_path / "a.zarr"),
    ]
    assert main(words) == 0
    found = xarray.open_zarr(tmp_path / "a.zarr")
    low, high = found.attrs["border_exponent_interval"]
    blocks, marked = found.border_sensitive.size, int((found.border_sensitive == 1).sum())
    open_ = int((found.border_sensitive == 2).sum())
    assert 0 < marked + open_ < blocks  # a thin region between two rests
    said = capsys.readouterr().out
    assert (
        f"; uncertainty exponent {found.attrs['border_exponent']:.2f} [{low:.2f}, {high:.2f}], "
        f"{marked} of {blocks} blocks along borders sensitive" in said
    )
    assert (f"{open_} open (a longer --time decides)" in said) == (open_ > 0)
    assert main([*words, "--json"]) == 0
    record = json.loads(capsys.readouterr().out)
    assert record["border_exponent_interval"] == [low, high]
    assert (record["border_blocks"], record["border_sensitive_blocks"]) == (blocks, marked)
