"""Saving a figure costs one layout, and one drawing for each file."""

from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from matplotlib.figure import Figure

import stability as st
from stability.figures.canvas import save
from stability.figures.styled_figure import StyledFigure


def _panel() -> Figure:
    figure = StyledFigure(layout="constrained")
    figure.subplots().set_xlabel("x")
    return figure


def _map() -> Figure:
    return st.plot_map(st.stability_map("spinning", x=("at", 1, 4, 9), y=("mu", 0.1, 2, 9)))


@pytest.mark.parametrize("make", [_panel, pytest.param(_map, marks=pytest.mark.long)])
def test_a_figure_is_laid_out_once_and_drawn_once_a_file(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, make: Callable[[], Figure]
) -> None:
    figure = make()
    engine: Any = figure.get_layout_engine()
    before, canvas = figure.dpi, figure.canvas
    told: list[str] = []
    laid, drawn = type(engine).execute, Figure.draw

    def execute(self: Any, of: Figure) -> None:
        told.append("laid out")
        laid(self, of)

    def draw(self: Figure, renderer: Any) -> None:
        told.append("drawn")
        drawn(self, renderer)

    monkeypatch.setattr(type(engine), "execute", execute)
    monkeypatch.setattr(Figure, "draw", draw)
    made = save(figure, tmp_path / "map")
    assert [p.name for p in made] == ["map.png", "map.pdf"]
    assert told == ["laid out", "drawn", "drawn"]
    # the figure is the caller's, and as it was
    assert (figure.get_layout_engine(), figure.dpi, figure.canvas) == (engine, before, canvas)


@pytest.mark.long
def test_a_saved_figure_has_the_places_that_matplotlib_gives_it(tmp_path: Path) -> None:
    """The second file has the layout of the first, and that of `savefig`, to a dot."""
    found = st.spectrum("spinning", at=[1.0, 2.0, 3.0], contact=st.Viscous(0.3))
    figure = st.plot_locus(found, title="spinning")
    save(figure, tmp_path / "ours")
    mine = [a.get_position().bounds for a in figure.axes]
    figure.savefig(tmp_path / "theirs.png", dpi=300)
    theirs = [a.get_position().bounds for a in figure.axes]
    wide = 300 * float(figure.get_figwidth())
    assert len(mine) == 2
    for one, other in zip(mine, theirs, strict=True):
        assert one == pytest.approx(other, abs=1.5 / wide)
