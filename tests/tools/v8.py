"""The scripts of an explorer's page in V8, asked as a page in a browser is: nothing is drawn."""

from __future__ import annotations

import json
import re
from pathlib import Path
from typing import Any

from py_mini_racer import MiniRacer

from stability.explorer.page import script

START = """
const performance = {now: Date.now};
const data = of_explorer.whole(JSON.parse(text)), view = new of_parts_view.View(data);
const diagram = {
  get curves() {
    return of_mathematics_boundaries.boundaryCurves(
      view.subject, view.state.values, view.axis("x"), view.axis("y")).curves;
  },
};
const stabilityExplorer = {
  view, diagram, launched: of_mathematics_launch.launched,
  polynomialRoots: of_mathematics_roots.polynomialRoots,
  shader: of_drawing_raster_shader.subjectShader,
};
const plain = (_, value) => ArrayBuffer.isView(value) ? Array.from(value)
  : typeof value === "number" && !Number.isFinite(value) ? {number: String(value)} : value;
const asked = (found, argument) =>
  JSON.stringify(typeof found === "function" ? found(argument) : found, plain);
"""
"""The part of `mount` in explorer.js that needs no window; NaN and infinities survive as texts."""


class Engine:
    """A page's view, subjects and launches; `.page.evaluate` is that of Playwright."""

    def __init__(self, page: Path) -> None:
        html = page.read_text(encoding="utf-8")
        [text] = re.findall(r'<script type="application/json" id="data">(.*?)</script>', html, re.S)
        self._context = MiniRacer()
        self._context.eval(f"{script()}\nconst text = {json.dumps(text)};\n{START}")
        self.page = self

    def evaluate(self, code: str, argument: Any = None) -> Any:
        """The value of an expression, or of a function at an argument."""
        text = self._context.eval(f"asked({code}\n, {json.dumps(argument)})")
        return None if text is None else json.loads(text, object_hook=_number)


def _number(found: dict[str, Any]) -> Any:
    return float(found["number"].replace("Infinity", "inf")) if [*found] == ["number"] else found
