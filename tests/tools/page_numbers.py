"""What tests ask a page of the explorer, in Chromium or in Node."""

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
LOOKED = r"""([key, points]) => {
  const s = stabilityExplorer.view.subjects.get(key), single = Math.fround;
  const text = s.shader
    .replace(/\b(?:float|bool|vec3) (\w+)\((.*?)\) {/g,
      (_, name, given) => `function ${name}(${given.replace(/float /g, "")}) {`)
    .replace(/^float low/gm, "let low").replace(/\(int n/g, "(let n")
    .replace(/^(float )?(\w+) ([*/]?)= (.+);$/gm, (_, own, name, by, value) =>
      `${own ? "let " : ""}${name} = single(${by ? `${name} ${by} (${value})` : value});`)
    .replace(/return vec3\((.*)\);/, "return [$1];");
  const names = ["abs", "min", "max", "pow", "sin", "cos", "tan", "sqrt", "exp", "log"];
  const look = new Function("single", `{${names}}`, `${text}\nreturn look;`)(single, Math);
  const size = (q) => Math.max(...s.eigenvalues(q).map((z) => Math.hypot(...z)));
  return points.map((q) => ({found: look(...s.full(q).map(single)),
    growth: s.growth(q), verdict: s.judge(q).verdict, size: size(q)}));
}"""
"""Growth rate, least condition and least of members by the shader's lines, in single precision.

Next to them growth rate, verdict and largest modulus by the page's scripts in double precision.
"""
SINGLE = 1e-4
"""Largest error of a growth rate in single precision over the largest modulus."""
