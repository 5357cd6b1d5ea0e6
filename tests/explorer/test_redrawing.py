"""What a moving hand draws again: only what has changed, and at rest what a fresh page shows."""

from pathlib import Path
from typing import Any

import pytest
from chromium import Visit, visit
from page_numbers import REST

SAID = 500  # milliseconds until words for a screen reader follow
DRAWINGS = """() => {
  const {diagram, plane} = stabilityExplorer;
  const one = (node) => (node.nodeType === 3 ? node.data : [node.tagName, node.value,
    [...node.attributes].map((a) => `${a.name}=${a.value}`).sort(), [...node.childNodes].map(one)]);
  const panels = document.querySelectorAll(".point-panel, .modes, .conditions, .controls");
  const nodes = [diagram.over, diagram.bar, plane.drawing, ...panels];
  return [...nodes.map((node) => JSON.stringify(one(node))), diagram.canvas.toDataURL()];
}"""
"""Every drawing, number and word that depends on the view."""
SWEPT = """async ([name, factor]) => {
  const {view, diagram, plane} = stabilityExplorer;
  const found = {paints: 0, curves: 0, paths: 0, measured: 0};
  const frame = () => new Promise((r) => requestAnimationFrame(r));
  const counted = (on, method, key) => {
    const own = on[method];
    on[method] = function (...given) { found[key]++; return own.apply(this, given); };
    return () => { on[method] = own; };
  };
  const undo = [counted(diagram.raster, "draw", "paints"), counted(diagram, "fill", "curves"),
    counted(plane, "paths", "paths"),
    counted(Element.prototype, "getBoundingClientRect", "measured")];
  const texts = () => [...diagram.over.querySelectorAll(".number")], before = texts();
  const middle = view.state.values[name];
  for (let i = 1; i <= 20; i++) {
    view.move({[name]: middle * (1 + (factor * i) / 20)}, name);
    await frame();
  }
  await frame();
  found.kept = texts().every((node, i) => node === before[i]);
  undo.forEach((u) => u());
  return found;
}"""


def swept(seen: Visit, name: str, factor: float) -> dict[str, Any]:
    seen.page.evaluate(REST)
    found: dict[str, Any] = seen.page.evaluate(SWEPT, [name, factor])
    seen.page.evaluate(REST)
    return found


def test_a_point_that_moves_on_its_axes_draws_no_plane(browser: Any, page_of_disk: Path) -> None:
    with visit(browser, page_of_disk, "#show=spinning-viscous") as seen:
        found = swept(seen, "at", 0.3)
        assert found["paints"] == found["curves"] == 0
        assert found["paths"] == 1  # once along another quantity than before
        found = swept(seen, "mu", 0.3)
        assert found["paints"] == found["curves"] == 0
        found = swept(seen, "k", -0.3)
        assert found["paints"] >= 20 and found["curves"] >= 20
        assert not seen.said


@pytest.mark.parametrize("name", ["at", "mu", "k"])
def test_a_slider_measures_nothing_and_keeps_the_numbers_of_the_axes(
    browser: Any, page_of_disk: Path, name: str
) -> None:
    with visit(browser, page_of_disk, "#show=rolling-viscous") as seen:
        found = swept(seen, name, -0.4)
        assert found["measured"] == 0
        assert found["kept"]


WAYS = {
    "sliders": [{"values": {"k": 0.3}}, {"values": {"mu": 1.2}}, {"values": {"at": 1.7}}],
    "axes": [{"x": "k", "y": "at"}, {"values": {"mu": 0.9}}, {"x": "at", "y": "mu"}],
    "zoom": [{"ranges": {"at": [0.5, 2.0]}}, {"ranges": {"at": [0.02, 5.0, "log"]}}],
    "families": [
        {"choose": "tumbling rough"},
        {"choose": "rolling smooth"},
        {"values": {"k": 0.4}},
    ],
    "modes": [{"mode": 1, "show": "mode"}, {"values": {"k": 0.45}}, {"mode": 0}],
    "there and back": [
        {"values": {"k": 0.5}},
        {"values": {"k": 0.25}},
        {"choose": "spinning viscous"},
    ],
}
"""Changes one after the other, as hands make them."""
CHANGE = """async (change) => {
  const {view} = stabilityExplorer, frame = () => new Promise((r) => requestAnimationFrame(r));
  if (change.choose) view.choose(change.choose);
  else if (change.values) for (const [name, value] of Object.entries(change.values)) {
    const from = view.state.values[name];
    for (let i = 1; i <= 6; i++) {
      view.move({[name]: i === 6 ? value : from + ((value - from) * i) / 6}, name);
      await frame();
    }
  } else {
    if (change.ranges) change = {ranges: {...view.state.ranges, ...change.ranges}};
    view.set(change);
  }
  await frame();
}"""


@pytest.mark.parametrize("way", WAYS)
def test_what_many_changes_leave_is_what_a_fresh_page_shows(
    browser: Any, page_of_disk: Path, way: str
) -> None:
    """The oracle of all that is kept from before: a page that has kept nothing."""
    with visit(browser, page_of_disk, "#show=rolling-viscous") as seen:
        for change in WAYS[way]:
            seen.page.evaluate(CHANGE, change)
        seen.page.evaluate(REST)
        seen.page.wait_for_timeout(SAID)
        link = seen.page.evaluate("stabilityExplorer.view.write()")
        found = seen.page.evaluate(DRAWINGS)
    with visit(browser, page_of_disk, f"#{link}") as fresh:
        fresh.page.evaluate(REST)
        fresh.page.wait_for_timeout(SAID)
        known = fresh.page.evaluate(DRAWINGS)
    for ours, theirs in zip(found, known, strict=True):
        assert ours == theirs


def test_a_moved_picture_is_fine_again_at_rest(browser: Any, page_of_disk: Path) -> None:
    with visit(browser, page_of_disk, "#show=spinning-viscous") as seen:
        seen.page.evaluate(REST)
        count = (
            "stabilityExplorer.diagram.curves.map((c) => c.points.length).reduce((a, b) => a + b)"
        )
        fine = seen.page.evaluate(count)
        seen.page.evaluate("stabilityExplorer.view.move({k: 0.2500001}, 'k')")
        coarse = seen.page.evaluate(
            f"new Promise((r) => requestAnimationFrame(() => setTimeout(() => r({count}))))"
        )
        seen.page.evaluate(REST)
        assert coarse < 0.7 * fine
        assert seen.page.evaluate(count) == fine
