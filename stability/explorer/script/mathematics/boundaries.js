// Boundary curves in double precision: zeros of the conditions, by bisection between grid points.

const CELLS_X = 120, CELLS_Y = 90, HALVINGS = 50;

/**
 * Curves on which the verdict changes, {kind, points: [[x, y], …]} in values of the axes, and `good(u, v)`: whether
 * every condition holds at the nearest point of the grid, or null without a member there.
 * `detail` is a share of the full fineness; at 1 every point of a curve is exact to double precision.
 */
export function boundaryCurves(subject, values, x, y, detail = 1) {
  const cells = [Math.round(CELLS_X * detail), Math.round(CELLS_Y * detail)];
  const absent = subject.rules.flatMap(() => [NaN, NaN]);
  const q = subject.array(values), i = subject.names.indexOf(x.name), j = subject.names.indexOf(y.name);
  const all = (u, v) => {
    q[i] = x.value(u);
    q[j] = y.value(v);
    return subject.exists(q) ? subject.formula.conditions(q) : absent;
  };
  const grid = sampled(all, cells, subject.rules.length), curves = [];
  subject.rules.forEach((rule, index) => {
    const own = (u, v) => all(u, v)[2 * index];
    const others = (u, v) => {
      const found = all(u, v);
      return subject.rules.every((_, n) => n === index || found[2 * n] > 0);
    };
    for (const points of contour(own, grid[index], Math.ceil(HALVINGS * detail))) {
      for (const piece of subject.rules.length > 1 ? kept(points, others) : [points]) {
        curves.push({kind: rule.kind, points: piece.map(([u, v]) => [x.value(u), y.value(v)])});
      }
    }
  });
  const good = (u, v) => {
    const [i, j] = [Math.round(u * cells[0]), Math.round(v * cells[1])];
    if (!subject.rules.length) return all(u, v) === absent ? null : true;
    return grid.some((one) => Number.isNaN(one[j][i])) ? null : grid.every((one) => one[j][i] > 0);
  };
  return {curves, good};
}

/** Each condition on the points of a grid over the unit square. */
function sampled(all, [columns, rows], count) {
  const grids = Array.from({length: count}, () => []);
  for (let j = 0; j <= rows; j++) {
    for (const grid of grids) grid.push(new Float64Array(columns + 1));
    for (let i = 0; i <= columns; i++) {
      const found = all(i / columns, j / rows);
      for (let n = 0; n < count; n++) grids[n][j][i] = found[2 * n];
    }
  }
  return grids;
}

/** Zero lines of a function on the unit square, as polylines. */
function contour(f, grid, halvings) {
  const segments = [], rows = grid.length - 1, columns = grid[0].length - 1;
  for (let j = 0; j < rows; j++) {
    for (let i = 0; i < columns; i++) {
      if (Number.isNaN(grid[j][i] + grid[j][i + 1] + grid[j + 1][i] + grid[j + 1][i + 1])) continue; // no member
      const first = grid[j][i] > 0;
      if (first !== grid[j][i + 1] > 0 || first !== grid[j + 1][i] > 0 || first !== grid[j + 1][i + 1] > 0) {
        segments.push(...cell(f, grid, i, j, halvings));
      }
    }
  }
  return joined(segments);
}

function cell(f, grid, i, j, halvings) {
  const corners = [[i, j], [i + 1, j], [i + 1, j + 1], [i, j + 1]];
  const value = corners.map(([a, b]) => grid[b][a]), cuts = [];
  for (let k = 0; k < 4; k++) {
    const next = (k + 1) % 4;
    if ((value[k] > 0) === (value[next] > 0)) continue;
    // one key for both cells of an edge, and one direction, so that their ends agree
    const [a, b] = [corners[k], corners[next]].sort((p, q) => p[0] - q[0] || p[1] - q[1]);
    cuts.push({key: `${a}|${b}`, at: edge(f, a, b, grid, halvings)});
  }
  if (cuts.length === 2) return [cuts];
  if (cuts.length !== 4) return [];
  const middle = f((i + 0.5) / (grid[0].length - 1), (j + 0.5) / (grid.length - 1)) > 0;
  return middle === value[0] > 0 ? [[cuts[0], cuts[1]], [cuts[2], cuts[3]]]
    : [[cuts[3], cuts[0]], [cuts[1], cuts[2]]];
}

function edge(f, a, b, grid, halvings) {
  let low = 0, high = 1;
  const positive = grid[a[1]][a[0]] > 0;
  const [columns, rows] = [grid[0].length - 1, grid.length - 1];
  const point = (t) => [(a[0] + t * (b[0] - a[0])) / columns, (a[1] + t * (b[1] - a[1])) / rows];
  for (let n = 0; n < halvings; n++) {
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
