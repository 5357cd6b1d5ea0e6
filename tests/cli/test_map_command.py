"""`stability map` into a Zarr folder, and by any scheduler."""

from pathlib import Path
from typing import Any

import pytest

import stability as st
from stability.cli import main
from stability.cli.commands import _parser

MAP = ("map", "spinning", "--x", "at:0.5:5:10", "--y", "mu:0.1:5:6")
AXES: dict[str, Any] = {"x": ("at", 0.5, 5, 10), "y": ("mu", 0.1, 5, 6)}


def test_a_folder_gets_growth_rates_and_a_second_call_goes_on(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    out = tmp_path / "gm.zarr"
    assert main([*MAP, "--out", str(out)]) == 0
    assert "60 verdicts and growth rates; exact polynomials" in capsys.readouterr().out
    found = st.read_map(out, lazy=True).load()
    whole = st.stability_map("spinning", **AXES, boundaries=False)
    assert (found.abscissa.values == whole.abscissa.values).all()
    assert (found.verdict.values == whole.verdict.values).all()
    (out / "verdict" / "c.0.0").unlink()
    assert main([*MAP, "--out", str(out), "--json"]) == 0
    assert '"cells": 60' in capsys.readouterr().out
    assert main([*MAP, "--out", str(out), "--verdict-only"]) == 2
    assert "growth rates: true there, missing here" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("option", "name"),
    [
        (["--plot", "a.png"], "plot"),
        (["--points"], "points"),
        (["--certify"], "certify"),
        (["--modes"], "modes"),
        (["--checkpoint", "parts"], "checkpoint"),
    ],
)
def test_what_needs_the_whole_map_is_refused_with_a_folder(
    option: list[str],
    name: str,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    monkeypatch.chdir(tmp_path)
    assert main([*MAP, "--out", "gm.zarr", *option]) == 2
    said = capsys.readouterr().err.splitlines()[-1]
    assert said.startswith(f"stability: --{name} does not go with --out 'gm.zarr', which")
    assert list(tmp_path.iterdir()) == []


@pytest.mark.few(2)
@pytest.mark.parametrize("route", ["memory", "verdicts", "growth"])
def test_every_route_takes_a_scheduler_and_workers(
    route: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    import stability.jobs.dask as module

    seen: list[tuple[Any, Any]] = []
    original = module.engine

    def engine(name: Any, workers: Any) -> Any:
        seen.append((name, workers))
        return original("threads", workers)

    monkeypatch.setattr(module, "engine", engine)
    out = str(tmp_path / ("m.nc" if route == "memory" else "m.zarr"))
    words = ["--verdict-only"] if route == "verdicts" else []
    assert main([*MAP, "--out", out, *words, "--scheduler", "processes", "--workers", "2"]) == 0
    assert seen == [("processes", 2)]
    assert st.read_map(out).verdict.shape == (6, 10)


@pytest.mark.parametrize("out", ["m.nc", "m.zarr"])
def test_a_wrong_scheduler_is_a_sentence_before_anything_is_computed(
    out: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main([*MAP, "--out", str(tmp_path / out), "--scheduler", "fibres"]) == 2
    assert "give threads, processes, dask, or the address" in capsys.readouterr().err
    assert list(tmp_path.iterdir()) == []


def test_the_help_has_an_example_of_a_folder() -> None:
    parser: Any = _parser()
    [commands] = [a for a in parser._actions if a.dest == "==SUPPRESS==" or a.choices]
    text = commands.choices["map"].format_help()
    assert "--out large.zarr --scheduler processes" in " ".join(text.split())
