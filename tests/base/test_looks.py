"""Every figure, report and page draws a row of the table of looks, which stands nowhere else."""

import itertools
import re
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from matplotlib import rc_context
from matplotlib.collections import PolyCollection, QuadMesh
from matplotlib.colors import to_hex
from node import Engine

import stability as st
from stability.base.looks import DARK, HATCHES, LIGHT, LOOKS, OCHRE, PATTERNS, YELLOW
from stability.compare.failures import LINEAR, STEPS, Entry
from stability.compare.figures import _shares_figure
from stability.compare.marks import Mark
from stability.compare.page import _cell, write
from stability.figures.diagram import caption
from stability.figures.shading import patch

ROOT = Path(st.__file__).parent
OTHER = replace(
    LOOKS["undecided"],
    sign="¿",
    pattern="level lines",
    tone="growth",
    border="dotted",
    fill=("#123456", "#654321"),
    cell=("#abcdef", "oo"),
)


@pytest.fixture(params=["as it is", "changed"])
def look(request: Any, monkeypatch: pytest.MonkeyPatch) -> Any:
    if request.param == "changed":
        monkeypatch.setitem(LOOKS, "undecided", OTHER)
    return LOOKS["undecided"]


def test_a_diagram_draws_undecided_cells_and_boxes_as_the_table_says(look: Any) -> None:
    axes = {"x": ("at", 1, 4, 9), "y": ("mu", 0.1, 2, 9)}
    chart = st.stability_map("spinning", **axes, certify=True, levels=2)
    chart.verdict.values[:3] = st.Verdict.UNDECIDED.code
    drawn = st.plot_map(chart).axes[0]
    hatches = {h for c in drawn.collections for h in getattr(c, "hatches", None) or []}
    assert hatches == {LOOKS["unstable"].hatching, look.hatching}
    meshes = [c for c in drawn.collections if isinstance(c, QuadMesh)]
    own: Any = meshes[1].get_array()
    assert to_hex(meshes[1].cmap(0.5)) == look.fill[0]  # no cell has the colour of its rate alone
    assert ((chart.verdict.values == st.Verdict.UNDECIDED.code) == ~own.mask).all()
    with rc_context({"hatch.color": "black"}):
        assert to_hex(patch(st.Verdict.UNDECIDED).get_facecolor()) == look.fill[0]  # in a legend
    boxes = [c for c in drawn.collections if isinstance(c, PolyCollection)]
    filled = {to_hex(c.get_facecolor()[0]) for c in boxes if len(c.get_facecolor())}  # type: ignore[arg-type]
    assert filled == {look.fill[0]}
    assert f"; {look.pattern}: undecided" in caption(chart)


def test_a_report_draws_undecided_answers_as_the_table_says(look: Any, tmp_path: Path) -> None:
    figure = _shares_figure(["ad"], ["10"], np.array([[[0.0, 1.0, 0.0]]]), marks=STEPS)
    cell = figure.axes[0].patches[0]
    assert to_hex(cell.get_facecolor()) == look.cell[0] and cell.get_hatch() == look.cell[1]
    entry = Entry(LINEAR, "g", "c", "m", Mark.UNDECIDED, float("nan"), "", ())
    assert f">{look.sign}</td>" in _cell(entry)
    text = write(tmp_path, []).read_text()
    assert f".undecided {{ background: {look.cell[0]};" in text


def test_the_page_of_the_explorer_shows_verdicts_as_the_table_says(
    look: Any, tmp_path: Path
) -> None:
    path = st.explore("spinning", certify=False, out=tmp_path / "page.html")
    rule = f".badge.undecided {{ color: var(--{look.tone}); border-style: {look.border}; }}"
    assert rule in path.read_text(encoding="utf-8")
    page = Engine(path)
    verdicts = page.evaluate("stabilityExplorer.view.data.looks.verdicts")
    assert verdicts["undecided"]["sign"] == look.sign
    assert verdicts["undecided"]["pattern"] == look.pattern
    # the shader and the picture without one hatch by the same names
    numbers = page.evaluate("(names) => names.map(of_drawing_patterns.patternNumber)", [*PATTERNS])
    assert numbers[0] == 0 and sorted(numbers) == [*range(len(PATTERNS))]
    patterns = page.evaluate("stabilityExplorer.view.subject.patterns")
    good = page.evaluate("stabilityExplorer.view.subject.good")
    assert patterns == [LOOKS["unstable"].pattern, LOOKS[good].pattern, look.pattern]
    for tone in ("light", "dark"):
        colours = page.evaluate(f"stabilityExplorer.view.data.looks.tones.{tone}.undecided")
        assert colours == list(look.fill)


def test_no_colour_of_the_table_is_written_a_second_time() -> None:
    colours = {YELLOW, OCHRE, *LIGHT.ramp, *DARK.ramp}
    colours |= {c for t in (LIGHT, DARK) for c in (t.hatch, t.decay, t.growth)}
    colours |= {one.cell[0] for word, one in LOOKS.items() if word not in ("wrong", "crashed")}
    text = re.compile("|".join(sorted(colours - {""})), re.IGNORECASE)
    kinds = (".py", ".js", ".css", ".html")
    files = [p for p in ROOT.rglob("*") if p.suffix in kinds and "library" not in p.parts]
    assert len(files) > 300
    twice = {p.name for p in files if text.search(p.read_text(encoding="utf-8"))}
    assert twice == {"looks.py"}


def test_each_hatching_has_one_meaning_over_all_figures() -> None:
    """At any density: Matplotlib draws `//` and `////` alike but for their distance."""
    meanings: dict[frozenset[str], set[str]] = {}
    rows = [(word, one.hatching) for word, one in LOOKS.items()]
    rows += [(word, one.cell[1]) for word, one in LOOKS.items()]
    rows += [(word, hatching) for word, (hatching, _) in HATCHES.items()]
    for word, hatching in rows:
        meanings.setdefault(frozenset(hatching), set()).add(word)
    shared = {shape: words for shape, words in meanings.items() if shape and len(words) > 1}
    assert shared == {}
    assert len(meanings) > 15
    names = [*PATTERNS, *(name for _, name in HATCHES.values())]
    assert len(set(names)) == len(names)


def test_no_other_file_writes_a_hatching() -> None:
    literal = re.compile(
        r"""hatch\w*["']?\s*[=:,]\s*r?["'][-/\\\\|+xoO.*]+["']|r?["'](?:////|xxxx|\\.\\.\\.\\.)["']"""
    )
    files = [p for p in ROOT.rglob("*.py") if p.name != "looks.py"]
    assert literal.search('hatch(axes, x, y, first > 1, "////")')
    assert literal.search('"hatch": "oo"')
    assert {p.name for p in files if literal.search(p.read_text(encoding="utf-8"))} == set()


def test_answers_of_a_report_differ_in_grey() -> None:
    """Two marks have another hatching, or greys that are 25 of 255 apart."""
    marks = [LOOKS[mark.word].cell for mark in Mark]
    greys = [
        np.dot([int(c[i : i + 2], 16) for i in (1, 3, 5)], [0.299, 0.587, 0.114]) for c, _ in marks
    ]
    for i, j in itertools.combinations(range(len(marks)), 2):
        assert set(marks[i][1]) != set(marks[j][1]) or abs(greys[i] - greys[j]) > 25
