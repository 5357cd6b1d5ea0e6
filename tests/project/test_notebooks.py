"""The notebooks run from top to bottom, and the README's Python does too."""

import ast
import re
import runpy
from pathlib import Path
from typing import Any

import matplotlib.pyplot as plt
import numpy as np
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
    _run(page)


def _run(page: str) -> dict[str, Any]:
    blocks = re.findall(r"```python\n(.*?)```", (ROOT / page).read_text(), re.DOTALL)
    assert blocks
    space: dict[str, Any] = {}
    for block in blocks:
        exec(compile(block, page, "exec"), space)
    return space


def test_the_towed_wheel_of_the_page_has_the_condition_derived_by_hand(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """With d = trail - centre: (m d s² + trail (c s + k)) (trail s + v) + (J - m centre d) s³."""
    monkeypatch.chdir(tmp_path)
    space = _run("docs/own-systems.md")
    g, edge = space["given"], space["edge"]
    d = g["trail"] - g["centre"]

    def polynomial(v: float) -> np.ndarray:
        swaying = [g["m"] * d, g["trail"] * g["c"], g["trail"] * g["k"]]
        return np.polyadd(
            np.polymul(swaying, [g["trail"], v]), [g["J"] - g["m"] * g["centre"] * d, 0, 0, 0]
        )

    cubic, square, linear, constant = polynomial(edge.value)
    assert square * linear == pytest.approx(cubic * constant, rel=1e-12)  # Routh
    assert edge.frequency == pytest.approx((linear / cubic) ** 0.5, rel=1e-12)
    mine = np.sort_complex(np.roots(polynomial(0.3)))
    assert np.sort_complex(space["spectrum"].eigenvalues) == pytest.approx(mine, rel=1e-9)
    assert (tmp_path / "towed-wheel.png").stat().st_size > 10_000


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


def shown(name: str, capsys: pytest.CaptureFixture[str]) -> str:
    runpy.run_path(str(ROOT / "examples" / name), run_name="__main__")
    return capsys.readouterr().out


def test_the_top_example_prints_where_it_stands(capsys: pytest.CaptureFixture[str]) -> None:
    """Lagrange: I3² spin² > 4 I1 m g l."""
    text = shown("lagrange_top.py", capsys)
    assert text.startswith("3.9 unstable\n4.1 neutral\n")
    assert "above 4.000000000000 rad/s" in text


def test_the_sleigh_example_prints_attraction_and_final_speed(
    capsys: pytest.CaptureFixture[str],
) -> None:
    """Rate -m a v / (I + m a²); v∞² = v0² + (I + m a²) w0²/m: two routes to 13 digits."""
    text = shown("chaplygin_sleigh.py", capsys)
    assert f"[{-0.3 / 0.29:.8f}+0.j]" in text
    assert "settled at v = 1.0003624343" in text
    # m (a w' + v w) with w' = -m a v w / (I + m a²)
    assert f"{0.3 * 0.3 * 0.05 / 0.29 - 0.05:.6f}" in text


def test_a_first_verdict_takes_at_most_25_lines() -> None:
    for name in ("lagrange_top.py", "chaplygin_sleigh.py"):
        tree = ast.parse((ROOT / "examples" / name).read_text())
        first = next(n.end_lineno or 0 for n in tree.body if "spectrum" in ast.unparse(n))
        code = ast.unparse(ast.Module(tree.body[1:], []))
        lines = (ROOT / "examples" / name).read_text().splitlines()[tree.body[0].end_lineno : first]
        assert "mechanics(" in code
        assert len([line for line in lines if line.strip()]) <= 25, name


@pytest.mark.long
def test_the_nonlinear_bicycle_example_prints_the_published_speeds(
    capsys: pytest.CaptureFixture[str],
) -> None:
    with pytest.warns(UserWarning, match="not complete"):
        text = shown("nonlinear_bicycle.py", capsys)
    assert "-14.0783896928" in text
    assert "4.292382536341 m/s (flutter)" in text
    assert "6.024262015388 m/s (static)" in text
