"""The notebooks run from top to bottom, and the README's Python does too."""

import re
import runpy
from pathlib import Path

import matplotlib.pyplot as plt
import pytest

ROOT = Path(__file__).resolve().parents[2]
NOTEBOOKS = sorted((ROOT / "notebooks").glob("*.py"))


@pytest.mark.parametrize("path", NOTEBOOKS, ids=lambda p: p.stem)
def test_notebook_runs(
    path: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    runpy.run_path(str(path))
    plt.close("all")  # what a notebook draws it shows, and leaves to its reader
    assert capsys.readouterr().out
    names = {p.name for p in tmp_path.iterdir()}
    wanted = {
        "quickstart": {"quarter.png", "quarter.pdf", "quarter.nc"},
        "rolling_drift": {"rolling_drift.png"},
        "flutter_lines": {"flutter_lines.png"},
        "launches": {"launch.png"},
        "least_model": {"least_model.png"},
    }
    assert wanted[path.stem] <= names


@pytest.mark.parametrize("page", ["README.md", "docs/compare.md", "docs/scenes.md"])
def test_python_in_a_page_runs(page: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    blocks = re.findall(r"```python\n(.*?)```", (ROOT / page).read_text(), re.DOTALL)
    assert blocks
    space: dict[str, object] = {}
    for block in blocks:
        exec(compile(block, page, "exec"), space)


def test_commands_in_the_readme_run(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    from stability.cli import main

    monkeypatch.chdir(tmp_path)
    (tmp_path / "examples").symlink_to(ROOT / "examples")  # a reader is in the root
    text = (ROOT / "README.md").read_text().replace("\\\n", " ")
    commands = re.findall(r"^\.venv/bin/stability (.+)$", text, re.MULTILINE)
    assert len(commands) >= 4
    for command in commands:
        words = command.split()
        assert main(words) == 0
        assert capsys.readouterr().out


def test_the_bicycle_example_prints_the_published_speeds(
    capsys: pytest.CaptureFixture[str],
) -> None:
    runpy.run_path(str(ROOT / "examples" / "bicycle.py"))
    text = capsys.readouterr().out
    assert "self-stable from 4.292382536341" in text
    assert "to   6.024262015388" in text
    assert "-14.0783896928" in text
