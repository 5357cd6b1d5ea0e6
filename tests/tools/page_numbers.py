"""What tests ask a page of the explorer, in Chromium or in Node."""

import re
from typing import Any

import numpy as np

NEAR = 1e-6
"""Distance from a boundary, relative to the sizes of a condition's terms, that is left out."""
ASK = """(sets) => sets.map(({key, points}) => points.map((q) => {
  const subject = stabilityExplorer.view.subjects.get(key), {verdict, rows} = subject.judge(q);
  const near = Math.min(1, ...rows.map((r) => Math.abs(r.value) * r.share / r.error));
  return {verdict, near, values: subject.eigenvalues(q)};
}))"""
"""Verdict, nearness to a boundary and eigenvalues at points of some subjects."""
VERDICT = """() => {
  const {view} = stabilityExplorer;
  return view.subject.judge(view.point()).verdict;
}"""
"""The verdict at the point that is shown; `absent` where the page says `no member`."""
OPEN = "(link) => { const {view} = stabilityExplorer; view.set(view.read(link)); }"
"""Take over what a link says."""
SHARE_OF_BLUE = """(c) => {
  const copy = document.createElement("canvas"), pen = copy.getContext("2d");
  copy.width = 80;
  copy.height = 40;
  stabilityExplorer.motion.draw();
  pen.drawImage(c, 0, 0, 80, 40);
  const d = pen.getImageData(0, 0, 80, 40).data;
  let n = 0;
  for (let i = 0; i < d.length; i += 4) n += d[i + 2] - d[i] > 60;
  return n / 3200;
}"""
"""Share of a canvas that has the body's blue."""
POSE = """(key) => {
  const s = stabilityExplorer.view.subjects.get(key), q = s.quantities.map((one) => one.value);
  const {states, p} = s.linearised(q), run = (text) => new Function(`return ${text}`)(), h = 1e-6;
  const pose = run(s.pose), frame = run(s.frame), rates = pose(states, p, s.still);
  const at = (t) => frame(states, p, s.still.map((v, i) => v + t * rates[i]));
  return {now: at(0), later: at(h), before: at(-h), h, exists: s.exists(q)};
}"""
"""The place of a body at a member, and a little later and before."""


def shader_signs(text: str, points: np.ndarray) -> np.ndarray:
    """The least condition that the shader's function `look` finds, read in single precision."""
    body = text.partition("vec3 look(")[2].partition("return vec3")[0]
    head, _, lines = body.partition("{")
    names = re.findall(r"float (\w+)", head)
    single: Any = np.float32
    space: dict[str, Any] = {
        "min": np.minimum, "max": np.maximum, "pow": np.power, "inf": np.float32(np.inf),
        **{n: getattr(np, n) for n in ("abs", "sin", "cos", "tan", "sqrt", "exp", "log")},
    }  # fmt: skip
    space |= dict(zip(names, points.T.astype(single), strict=True))
    for line in re.findall(r"(?:float )?(\w+) = ([^;]+);", lines):
        if line[0] == "growth":
            continue
        number = re.sub(r"(?<![\w.])(\d+\.\d*(?:e[+-]?\d+)?)", r"single(\1)", line[1])
        space[line[0]] = eval(number, {"single": single, "__builtins__": {}}, space)  # noqa: S307
    return np.broadcast_to(space["sign"], len(points))
