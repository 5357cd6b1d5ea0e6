"""What tests ask a page of the explorer, in Chromium or in Node, and the package."""

import math
from typing import Any

import numpy as np

import stability as st

FAMILIES = ("rolling", "spinning", "tumbling")
LAWS = {"smooth": (), "viscous": ("mu",), "linear-viscous": ("mu",), "rough": ()}
COIN = st.Disk.named("quarter")
RATE = math.sqrt(9.81 / 0.01213)
"""√(g/R) of the coin, by hand [1/s]."""
SAME = 1e-9
"""Largest difference of eigenvalues over the largest modulus."""


def spectrum(family: str, law: str, points: np.ndarray) -> st.Spectrum:
    """Spectra of the disk at points (at, mu where the law has one, k)."""
    friction: dict[str, Any] = {"mu": points[:, 1]} if LAWS[law] else {}
    return st.spectrum(
        family, at=points[:, 0], contact=law, disk=st.Disk(k=points[:, -1]), **friction
    )


def eigenvalues(page: Any) -> np.ndarray:
    """Eigenvalues of the page in the unit that it shows."""
    found = page.evaluate(
        "(() => { const {view} = stabilityExplorer, {size} = view.curve('growth rate');"
        "return view.subject.eigenvalues(view.point()).map((z) => z.map((v) => v * size)); })()"
    )
    return np.array([complex(*z) for z in found])


def apart(found: np.ndarray, known: np.ndarray) -> float:
    """Largest difference of two sets of eigenvalues, over the largest modulus."""
    gaps = np.abs(found[:, None] - known[None, :])
    return float(max(gaps.min(axis=0).max(), gaps.min(axis=1).max()) / np.abs(known).max())


REST = """async () => {
  const explorer = window.stabilityExplorer;
  const frame = () => new Promise((r) => requestAnimationFrame(r));
  const busy = () => explorer
    && (explorer.motion.waits || explorer.view.moving || explorer.diagram.refining);
  for (let idle = 0; idle < 3; idle = busy() ? 0 : idle + 1) await frame();
}"""
"""Ends when the page has drawn and computed everything that was asked."""

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
LOOKED = """([key, points]) => {
  const s = stabilityExplorer.view.subjects.get(key), look = stabilityExplorer.look(s);
  const size = (q) => Math.max(...s.eigenvalues(q).map((z) => Math.hypot(...z)));
  return points.map((q) => ({found: look(s.full(q)),
    growth: s.growth(q), verdict: s.judge(q).verdict, size: size(q)}));
}"""
"""Growth rate, sign and least of members by the lines that a picture is computed with.

Next to them growth rate, verdict and largest modulus by the scripts of a point.
"""
