// Boundary curves in double precision: zeros of the conditions, by bisection between grid points.

const CELLS_X = 120, CELLS_Y = 90, HALVINGS = 46;

/**
 * Polylines on which the verdict changes: {kind, points: [[x, y], …]} in values of the axes.
 * `detail` is a share of the grid's full fineness; every point is exact to double precision.
 */
export function boundaryCurves(subject, values, x, y, detail = 1) {
  const cells = [Math.round(CELLS_X * detail), Math.round(CELLS_Y * detail)];
  const at = (u, v) => subject.array({...values, [x.name]: x.value(u), [y.name]: y.value(v)});
  const curves = [];
  subject.rules.forEach((rule, index) => {
    const sign = (u, v) => subject.conditionsAt(at(u, v))[index].value;
    const others = (u, v) => subject.conditionsAt(at(u, v)).every((r, i) => i === index || r.value > 0);
    for (const points of contour(sign, cells)) {
      for (const piece of kept(points, others)) {
        curves.push({kind: rule.kind, points: piece.map(([u, v]) => [x.value(u), y.value(v)])});
      }
    }
  });
  return curves;
}

/** Zero lines of a function on the unit square, as polylines. */
function contour(f, [columns, rows]) {
  const grid = [];
  for (let j = 0; j <= rows; j++) {
    const row = new Float64Array(columns + 1);
    for (let i = 0; i <= columns; i++) row[i] = f(i / columns, j / rows);
    grid.push(row);
  }
  const segments = [];
  for (let j = 0; j < rows; j++) {
    for (let i = 0; i < columns; i++) segments.push(...cell(f, grid, i, j));
  }
  return joined(segments);
}

function cell(f, grid, i, j) {
  const corners = [[i, j], [i + 1, j], [i + 1, j + 1], [i, j + 1]];
  const value = corners.map(([a, b]) => grid[b][a]), cuts = [];
  for (let k = 0; k < 4; k++) {
    const next = (k + 1) % 4;
    if ((value[k] > 0) === (value[next] > 0)) continue;
    // one key for both cells of an edge, and one direction, so that their ends agree
    const [a, b] = [corners[k], corners[next]].sort((p, q) => p[0] - q[0] || p[1] - q[1]);
    cuts.push({key: `${a}|${b}`, at: edge(f, a, b, grid)});
  }
  if (cuts.length === 2) return [cuts];
  if (cuts.length !== 4) return [];
  const middle = f((i + 0.5) / (grid[0].length - 1), (j + 0.5) / (grid.length - 1)) > 0;
  return middle === value[0] > 0 ? [[cuts[0], cuts[1]], [cuts[2], cuts[3]]]
    : [[cuts[3], cuts[0]], [cuts[1], cuts[2]]];
}

function edge(f, a, b, grid) {
  let low = 0, high = 1;
  const positive = grid[a[1]][a[0]] > 0;
  const [columns, rows] = [grid[0].length - 1, grid.length - 1];
  const point = (t) => [(a[0] + t * (b[0] - a[0])) / columns, (a[1] + t * (b[1] - a[1])) / rows];
  for (let n = 0; n < HALVINGS; n++) {
    const t = (low + high) / 2;
    if (f(...point(t)) > 0 === positive) low = t; else high = t;
  }
  return point((low + high) / 2);
}

function joined(segments) {
  const ends = new Map();
  segments.forEach((s, n) => s.forEach((cut) => {
    if (!ends.has(cut.key)) ends.set(cut.key, []);
    ends.get(cut.key).push(n);
  }));
  const used = new Set(), lines = [];
  const follow = (start, cut) => {
    const line = [];
    for (let n = start, from = cut; n !== undefined;) {
      used.add(n);
      const to = segments[n].find((c) => c.key !== from.key) || segments[n][1];
      line.push(to.at);
      from = to;
      n = ends.get(to.key).find((m) => !used.has(m));
    }
    return line;
  };
  segments.forEach((s, n) => {
    if (used.has(n)) return;
    const there = follow(n, s[0]);
    const back = ends.get(s[0].key).find((m) => !used.has(m));
    const before = back === undefined ? [] : follow(back, s[0]).reverse();
    lines.push([...before, s[0].at, ...there]);
  });
  return lines;
}

/** The parts of a polyline where the other conditions hold, so that the verdict changes on it. */
function kept(points, holds) {
  const out = [];
  let piece = [];
  points.forEach((p, i) => {
    const here = holds(...p), last = points[i - 1];
    if (last && here !== holds(...last)) piece.push(between(last, p, holds));
    if (here) piece.push(p);
    else if (piece.length) { out.push(piece); piece = []; }
  });
  if (piece.length) out.push(piece);
  return out.filter((p) => p.length > 1);
}

function between(a, b, holds) {
  const first = holds(...a);
  let low = 0, high = 1;
  const point = (t) => [a[0] + t * (b[0] - a[0]), a[1] + t * (b[1] - a[1])];
  for (let n = 0; n < 30; n++) {
    const t = (low + high) / 2;
    if (holds(...point(t)) === first) low = t; else high = t;
  }
  return point((low + high) / 2);
}
