"""The chart of a scene shows every model of its dataset, and no label hides another."""

import itertools
import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import xarray
from figure_audit import faults
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.collections import Collection
from matplotlib.figure import Figure
from matplotlib.text import Text

from stability.base.errors import ParameterError
from stability.figures.canvas import COLUMN, save_figure
from stability.figures.scene_chart import LOOKS, scene_caption, scene_figure

ROWS: list[tuple[str, str, float, float]] = [
    ("steady", "closed form", 4e-3, 0.14),
    ("linearised", "closed form", 4e-3, 6.7e-3),
    ("second-order", "closed form", 4.1e-3, 6.6e-3),
    ("rough", "creep", 3e-3, 8e-3),
    ("creep-1", "creep", 4.2e-3, 5e-4),
    ("creep-2", "creep", 5e-3, 2.4e-5),
    ("creep-3", "creep", 5.9e-3, 1.1e-6),
    ("slow", "reduced model", 4.5e-3, 5e-4),
    ("viscous", "full model", 3.2e-3, 6e-10),
    ("smooth law", "other law", 2.5e-3, np.inf),
    ("linear-viscous law", "other law", 2.9e-3, 8e-3),
    ("rough law", "other law", 1.4e-3, 8e-3),
    ("coulomb law, mu = 0.3", "other law", 8.6e-3, 8.1e-3),
    ("viscous law, mu = 100", "other law", np.nan, np.nan),
]
"""Models with times and errors that lie close together."""


def made(
    rows: list[tuple[str, str, float, float]], chosen: str = "creep-2", spread: float = 8e-4
) -> xarray.Dataset:
    names, kinds, costs, errors = zip(*rows, strict=True)
    error = ("model", list(errors), {"long_name": "largest error of the states"})
    return xarray.Dataset(
        {
            "cost": ("model", list(costs)),
            "true_error": error,
            "seconds": (("model", "repeat"), np.array(costs)[:, None]),
            "chosen": ("model", [n == chosen for n in names]),
            "tolerance": 1e-4,
            "spread": spread,
            "truth_error": 1e-12,
            "answer_cost": 9e-3,
        },
        {"model": list(names), "kind": ("model", list(kinds))},
        {
            "format": "stability chart scene 1",
            "law": "viscous",
            "title": "models of motion of a disk, viscous contact: cost against true error",
            "horizon": 0.5,
            "time_unit": "s",
            "parameters": json.dumps({"k": 0.25, "mu": 100.0}),
            "truth": "the full model, much finer",
            "start": json.dumps({"theta": 1.4, "theta_dot": 0.0}),
            "uncertain": "mu ± 0.1",
            "stability_version": "0",
            "created": "2020-01-01T00:00:00",
        },
    )


@pytest.fixture(scope="module")
def dataset() -> xarray.Dataset:
    return made(ROWS)


@pytest.fixture(scope="module")
def figure(dataset: xarray.Dataset) -> Figure:
    return scene_figure(dataset)


def labels(figure: Figure) -> dict[str, Text]:
    return {t.get_text(): t for t in figure.axes[0].texts}


def boxes(texts: list[Text], figure: Figure) -> list[Any]:
    canvas = FigureCanvasAgg(figure)
    canvas.draw()
    renderer = canvas.get_renderer()  # type: ignore[attr-defined]
    return [Text.get_window_extent(t, renderer) for t in texts]  # of the words, without the line


def marked(figure: Figure) -> list[tuple[float, float, str, str]]:
    """(time, error, shape, colour) of each mark."""
    found = []
    for line in figure.axes[0].get_lines():
        if line.get_linestyle() == "None" and line.get_markerfacecolor() != "none":
            x, y = (float(v[0]) for v in line.get_data())  # type: ignore[arg-type]
            found.append((x, y, str(line.get_marker()), str(line.get_color())))
    return found


def test_every_model_with_an_error_has_a_mark_of_its_kind(figure: Figure) -> None:
    expected = [
        (cost, error, LOOKS[kind]["marker"], LOOKS[kind]["color"])
        for _, kind, cost, error in ROWS
        if np.isfinite(error)
    ]
    assert marked(figure) == expected


def test_the_kinds_differ_in_shape_and_in_colour() -> None:
    for what in ("marker", "color"):
        assert len({look[what] for look in LOOKS.values()}) == len(LOOKS)


def test_the_choice_alone_has_a_ring_and_a_word(figure: Figure) -> None:
    lines = figure.axes[0].get_lines()
    rings = [line for line in lines if line.get_markerfacecolor() == "none"]
    [ring] = [r for r in rings if r.get_linestyle() == "None"]
    assert [float(v[0]) for v in ring.get_data()] == [5e-3, 2.4e-5]  # type: ignore[arg-type]
    assert [t for t in labels(figure) if "chosen" in t] == ["creep-2, chosen"]


def test_the_tolerance_is_a_line_and_the_spread_a_band_up_to_it(figure: Figure) -> None:
    axes = figure.axes[0]
    dashed = [line for line in axes.get_lines() if line.is_dashed()]
    assert [list(line.get_ydata()) for line in dashed] == [[1e-4, 1e-4]]
    [band] = axes.patches
    box: Any = band.get_bbox()  # type: ignore[attr-defined]
    assert (box.y0, box.y1) == (axes.get_ylim()[0], 8e-4)
    assert {"tolerance\n0.0001", "spread\n0.0008"} <= set(labels(figure))


def test_without_uncertain_inputs_there_is_no_band() -> None:
    few = made(ROWS[4:6], spread=np.nan)
    assert not scene_figure(few).axes[0].patches and "uncertain" not in scene_caption(few)


@pytest.mark.long
@pytest.mark.parametrize("spread", [np.nan, 8e-4, 1.1e-4, 0.9e-4])
def test_no_label_hides_another_and_none_leaves_the_figure(spread: float) -> None:
    figure = scene_figure(made(ROWS, spread=spread))
    assert faults(figure, COLUMN) == []  # small and pale texts too
    keys = [legend for axes in figure.axes if (legend := axes.get_legend())]
    [key] = keys or figure.legends
    texts = [
        *figure.axes[0].texts,
        *figure.texts,
        figure.axes[0].xaxis.label,
        *key.get_texts(),
    ]
    found = boxes(texts, figure)
    for (a, one), (b, other) in itertools.combinations(zip(texts, found, strict=True), 2):
        assert not one.overlaps(other), (a.get_text(), b.get_text())
    for text, box in zip(texts, found, strict=True):
        assert figure.bbox.x0 <= box.x0 and box.x1 <= figure.bbox.x1, text.get_text()
        assert figure.bbox.y0 <= box.y0 and box.y1 <= figure.bbox.y1, text.get_text()


def test_no_label_hides_a_mark(figure: Figure) -> None:
    axes = figure.axes[0]
    spots = [axes.transData.transform((x, y)) for x, y, *_ in marked(figure)]
    for text, box in zip(axes.texts, boxes(list(axes.texts), figure), strict=True):
        for x, y in spots:
            assert not (box.x0 < x < box.x1 and box.y0 < y < box.y1), text.get_text()


def test_every_mark_lies_in_the_panel(figure: Figure) -> None:
    (left, right), (low, high) = figure.axes[0].get_xlim(), figure.axes[0].get_ylim()
    assert all(left < x < right and low < y < high for x, y, *_ in marked(figure))


def test_the_caption_says_what_was_computed_and_what_has_no_mark(
    figure: Figure, dataset: xarray.Dataset
) -> None:
    told = scene_caption(dataset)
    for part in (
        "the law viscous (k = 0.25, mu = 100, SI units)",
        "from theta = 1.4",
        "horizon 0.5 s",
        "tolerance 0.0001",
        "the full model, much finer",
        "uncertain by mu ± 0.1",
        "end in another way: smooth law",
        "answer here: viscous law (μ = 100)",
    ):
        assert part in told
    [note] = [" ".join(t.get_text().split()) for t in figure.texts]
    assert note == (
        r"viscous contact, $k$ = 0.25, $\mu$ = 100 s/m ($F = -\mu\,N\,v$) "
        r"start: $\theta$ = 1.4 rad, horizon 0.5 s "
        "end in another way: smooth law no answer: viscous law (μ = 100)"
    )


def test_an_error_of_zero_has_a_mark_at_the_lowest_error() -> None:
    rows = [("rough", "full model", 2e-3, 0.0), ("smooth law", "other law", 1e-3, 1.0)]
    assert [y for _, y, *_ in marked(scene_figure(made(rows, "rough")))] == [1e-16, 1.0]


def test_a_chart_of_one_model_can_be_drawn() -> None:
    assert len(marked(scene_figure(made([ROWS[8]], "viscous", np.nan)))) == 1


def test_a_chart_without_any_error_can_be_drawn() -> None:
    rows = [("viscous", "full model", 1e-3, np.inf)]
    found = scene_figure(made(rows, "viscous", np.nan))
    assert not marked(found)
    assert not any(isinstance(c, Collection) for c in found.axes[0].collections)


@pytest.mark.few(1)
@pytest.mark.parametrize("suffix", ["png", "pdf", "svg"])
def test_the_figure_can_be_saved_with_its_fonts(
    suffix: str, figure: Figure, tmp_path: Path
) -> None:
    path = tmp_path / f"chart.{suffix}"
    save_figure(figure, path)
    content = path.read_bytes()
    assert len(content) > 5000
    if suffix == "pdf":  # TrueType, which can be searched and edited
        assert b"/FontFile2" in content and b"/Type3" not in content


def test_what_is_no_chart_is_refused(dataset: xarray.Dataset) -> None:
    for draw in (scene_figure, scene_caption):
        with pytest.raises(ParameterError, match="give what"):
            draw(dataset.assign_attrs(format="map"))
        with pytest.raises(ParameterError, match=r"dataset is \[1, 2\]"):
            draw([1, 2])  # type: ignore[arg-type]
