"""The notebooks run from top to bottom, and the README's Python does too."""

import ast
import base64
import io
import json
import math
import re
import runpy
import sys
from pathlib import Path
from typing import Any

import matplotlib.pyplot as plt
import numpy as np
import pytest
from figure_audit import faults
from PIL import Image

from stability.figures.canvas import COLUMN

ROOT = Path(__file__).resolve().parents[2]
NOTEBOOKS = sorted((ROOT / "notebooks").glob("*.py"))


@pytest.mark.long
@pytest.mark.parametrize("path", NOTEBOOKS, ids=lambda p: p.stem)
def test_notebook_runs(
    path: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(plt, "show", lambda: plt.close("all"))
    with plt.rc_context():
        space = runpy.run_path(str(path))
    assert faults(space["figure"], COLUMN) == []
    assert not plt.get_fignums()  # what a notebook draws it shows
    kept = "".join(
        "".join(output["text"])
        for cell in kept_cells(path)
        for output in cell.get("outputs", ())
        if output["output_type"] == "stream"
    )
    assert words(capsys.readouterr().out) == words(kept)
    wanted = {"quarter.png", "quarter.pdf", "quarter.nc"} if path.stem == "quickstart" else set()
    assert {p.name for p in tmp_path.iterdir()} == wanted


def kept_cells(path: Path) -> list[dict[str, Any]]:
    """The cells of the notebook that is kept with its output."""
    found: list[dict[str, Any]] = json.loads(path.with_suffix(".ipynb").read_text())["cells"]
    return found


def words(text: str) -> list[str]:
    """What a notebook prints, without its numbers: their last digits depend on the machine."""
    return re.findall(r"[A-Za-z_]{3,}", text)


def script_cells(path: Path) -> list[tuple[str, str]]:
    """Kind and text of each cell of a script."""
    _, *parts = re.split(r"^# %%", path.read_text(), flags=re.MULTILINE)
    found = []
    for part in parts:
        head, _, body = part.partition("\n")
        kind = "markdown" if "[markdown]" in head else "code"
        lines = [re.sub("^# ?", "", s) if kind == "markdown" else s for s in body.splitlines()]
        found.append((kind, "\n".join(lines).strip()))
    return found


@pytest.mark.parametrize("path", NOTEBOOKS, ids=lambda p: p.stem)
def test_a_notebook_is_kept_with_its_output_and_small_pictures(path: Path) -> None:
    """`make pictures` runs a script that was changed, and keeps it."""
    kept = kept_cells(path)
    assert [(c["cell_type"], "".join(c["source"])) for c in kept] == script_cells(path)
    outputs = [output for cell in kept for output in cell.get("outputs", ())]
    assert all(o["output_type"] != "error" and o.get("name") != "stderr" for o in outputs)
    pictures = [o["data"]["image/png"] for o in outputs if "image/png" in o.get("data", {})]
    assert pictures
    for picture in pictures:
        data = base64.b64decode(picture)
        assert len(data) < 150_000
        with Image.open(io.BytesIO(data)) as image:
            assert image.width >= 900  # sharp in a column of a page
            assert len(image.convert("L").getcolors(256) or ()) > 16


FAST = ["README.md", "docs/explanation/contact-laws.md", "docs/explanation/citing.md"]
PAGES = [f"docs/explanation/{name}.md" for name in ("tour", "scenes")]


@pytest.mark.parametrize("page", [*FAST, *(pytest.param(p, marks=pytest.mark.long) for p in PAGES)])
def test_python_in_a_page_runs(page: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    _run(page)


def _run(page: str) -> dict[str, Any]:
    blocks = re.findall(r"```python\n(.*?)```", (ROOT / page).read_text(), re.DOTALL)
    assert blocks
    space: dict[str, Any] = {}
    for block in blocks:
        if load := re.match(r":load: (\S+)", block):
            block = ((ROOT / page).parent / load[1]).read_text()
        printed: dict[int, list[str]] = {}

        def record(*values: Any, _printed: dict[int, list[str]] = printed) -> None:
            line = sys._getframe(1).f_lineno
            _printed.setdefault(line, []).append(" ".join(map(str, values)))

        space["print"] = record
        exec(compile(block, page, "exec"), space)
        for number, line in enumerate(block.splitlines(), 1):
            if said := re.search(r"  # prints (.*?)(…?)$", line):
                first = printed[number][0]
                assert first.startswith(said[1]) if said[2] else first == said[1], line
    return space


@pytest.mark.long
def test_the_page_of_bodies_runs() -> None:
    _run("docs/explanation/bodies.md")


@pytest.mark.long
def test_the_towed_wheel_of_the_page_has_the_condition_derived_by_hand(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """With d = trail - centre: (m d s² + trail (c s + k)) (trail s + v) + (J - m centre d) s³."""
    monkeypatch.chdir(tmp_path)
    space = _run("docs/tutorials/towed-wheel.md")
    g, edge = space["GIVEN"], space["edge"]
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
    assert space["short"].rule == space["same"].rule
    assert "0.07 = 7/100" in space["same"].numbers


@pytest.mark.long
@pytest.mark.parametrize("page", ["README.md", "docs/explanation/tour.md"])
def test_commands_of_a_reader_in_the_root_run(
    page: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    from stability.cli import main

    monkeypatch.chdir(tmp_path)
    (tmp_path / "examples").symlink_to(ROOT / "examples")  # a reader is in the root
    text = (ROOT / page).read_text().replace("\\\n", " ")
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


def test_the_tippe_top_example_prints_its_thresholds_for_every_friction(
    capsys: pytest.CaptureFixture[str],
) -> None:
    """Thresholds of Jellett's integral; their formulas are checked in test_benchmarks.py."""
    text = shown("tippe_top.py", capsys)
    assert text.startswith("stable\n")
    for friction in ("0.3", "3.0", "30.0"):
        line = "upright below 27.667917094780, inverted above 41.332688957659 rad/s"
        assert f"mu = {friction}: {line}" in text
    assert "integral there: 3.438879721e-06 J s m" in text
    assert "upright, every mu: 27.667917094780 rad/s, mu to the power 0, spin to 2" in text
    assert "inverted, every mu: 41.332688957659 rad/s, mu to the power 0, spin to 2" in text
    assert text.count("rad/s, every mu: Unstable at every member of the domain.") == 3


def test_the_linear_bicycle_example_prints_table_1(capsys: pytest.CaptureFixture[str]) -> None:
    """J. P. Meijaard et al. (2007), Table 1: the entries, and the speeds."""
    text = shown("linear_bicycle.py", capsys)
    assert text.startswith("stable\n")
    printed = dict(line.split() for line in text.splitlines() if "_" in line)
    published = {
        "M_00": 80.81722,
        "M_01": 2.31941332208709,
        "M_11": 0.29784188199686,
        "C1_01": 33.86641391492494,
        "C1_10": -0.85035641456978,
        "C1_11": 1.68540397397560,
        "K0_00": -80.95,
        "K0_01": -2.59951685249872,
        "K0_11": -0.80329488458618,
        "K2_01": 76.59734589573222,
        "K2_11": 2.65431523794604,
        "M_10": 2.31941332208709,
        "K0_10": -2.59951685249872,
        "C1_00": 0.0,
        "K2_00": 0.0,
        "K2_10": 0.0,
    }
    assert set(printed) == set(published)
    for name, value in published.items():
        assert float(printed[name]) == pytest.approx(value, rel=2e-14, abs=1e-14), name
    assert "4.292382536341 m/s (flutter)" in text
    assert "6.024262015388 m/s (static)" in text


PRINTED = {
    # y'' and psi'' of the course, by hand: the quartic in tests/tables/test_benchmarks.py
    "railway_wheelset": [
        "-94.32282188-12.14204292j",
        "-5.67717812+12.14204292j",
        "above 48.558435944090 m/s, with 26.132674311418 rad/s",
    ],
    # e = 2 a b^(3/2); with x = arccos b and z² = 1/b: frequency² = (1 - b²)/b
    "watt_governor": [
        "0.3 unstable\n0.4 stable",
        f"above e = {0.5**1.5:.12f}",
        f"with {1.5**0.5:.12f}",
    ],
    # L² = -W² ± k
    "rotating_saddle": ["1.7 unstable\n1.8 neutral", f"above {3**0.5:.12f} rad/s"],
    # O. N. Kirillov & F. Verhulst: 41/28 + b²/2, and 7/2 - sqrt(2) without damping
    "ziegler_column": [
        "stable\n",
        *(f"b = {b:g}: flutter above {41 / 28 + b * b / 2:.12f}" for b in (1.0, 0.1, 0.001)),
        f"b = 0: flutter above {3.5 - 2**0.5:.12f}",
    ],
    # W = w0 (1 + de/di), where the shaft whirls with w0
    "jeffcott_rotor": [
        "240.0 stable\n260.0 unstable",
        "above 250.000000000000 rad/s, with 100.000000000000 rad/s",
        "w0**2*de**2 + 2*w0**2*de*di - W**2*di**2 + w0**2*di**2 > 0",
    ],
    # 2 (Fs - Fk)/v + 2 pi - 2 atan((Fs - Fk)/v): the mass sticks for the first term
    "belt_friction": [
        "sticks for 5.000000000000",
        f"period {5 + 2 * math.pi - 2 * math.atan(2.5):.12f}",
    ],
}
"""What each example must print, from closed forms."""


@pytest.mark.few(3)
@pytest.mark.parametrize("name", PRINTED)
def test_an_example_of_a_known_system_prints_the_known_numbers(
    name: str, capsys: pytest.CaptureFixture[str]
) -> None:
    text = shown(f"{name}.py", capsys)
    for part in PRINTED[name]:
        assert part in text


def test_the_triangular_points_example_prints_the_mass_ratio(
    capsys: pytest.CaptureFixture[str],
) -> None:
    """E. J. Routh: 27 m (1 - m) = 1."""
    text = shown("triangular_points.py", capsys)
    assert "0.0121505856 neutral\n0.04 unstable" in text
    assert f"below m = {(1 - 69**0.5 / 9) / 2:.15f}" in text


FIRST = (
    "lagrange_top",
    "chaplygin_sleigh",
    "tippe_top",
    "railway_wheelset",
    "watt_governor",
    "rotating_saddle",
    "triangular_points",
    "ziegler_column",
    "jeffcott_rotor",
)
"""Examples whose first verdict takes few lines."""


def test_a_first_verdict_takes_at_most_25_lines() -> None:
    for name in (f"{word}.py" for word in FIRST):
        tree = ast.parse((ROOT / "examples" / name).read_text())
        first = next(n.end_lineno or 0 for n in tree.body if "spectrum" in ast.unparse(n))
        code = ast.unparse(ast.Module(tree.body[1:], []))
        lines = (ROOT / "examples" / name).read_text().splitlines()[tree.body[0].end_lineno : first]
        assert "mechanics(" in code or "System" in code
        assert len([line for line in lines if line.strip()]) <= 25, name


@pytest.mark.long
def test_the_nonlinear_bicycle_example_prints_the_published_speeds(
    capsys: pytest.CaptureFixture[str],
) -> None:
    text = shown("nonlinear_bicycle.py", capsys)  # a warning would say that it is not complete
    assert "-14.0783896928" in text
    assert "4.292382536341 m/s (flutter)" in text
    assert "6.024262015388 m/s (static)" in text
