// The verdict written into each region of the diagram, where it is deepest.

const COLUMNS = 36, ROWS = 24;
const LEAST = 0.03; // share of the diagram that a region needs for its name

const WIDE = 2.6; // a word is this much wider than high

/** [word, u, v] with places in the unit square. */
export function regionNames(view, x, y) {
  const {subject, state} = view, q = subject.array(state.values);
  const i = subject.names.indexOf(x.name), j = subject.names.indexOf(y.name), cells = [];
  for (let row = 0; row < ROWS; row++) {
    for (let column = 0; column < COLUMNS; column++) {
      q[i] = x.value((column + 0.5) / COLUMNS);
      q[j] = y.value((row + 0.5) / ROWS);
      cells.push(subject.margin(q) > 0);
    }
  }
  const found = [];
  for (const [kind, word] of [[true, subject.good], [false, "unstable"]]) {
    if (cells.filter((c) => c === kind).length < LEAST * cells.length) continue;
    const best = deepest(cells, kind);
    if (best) found.push([word, (best[0] + 0.5) / COLUMNS, (best[1] + 0.5) / ROWS]);
  }
  return found;
}

/** The cell that is farthest from every cell of the other kind, by two sweeps. */
function deepest(cells, kind) {
  const away = cells.map((c) => (c === kind ? Infinity : 0)), [dx, dy] = [1 / WIDE, 1];
  const at = (i, j) => (i < 0 || j < 0 || i >= COLUMNS || j >= ROWS ? 0 : away[j * COLUMNS + i]);
  const diagonal = Math.hypot(dx, dy);
  for (const s of [1, -1]) {
    for (let n = 0; n < cells.length; n++) {
      const m = s > 0 ? n : cells.length - 1 - n, i = m % COLUMNS, j = Math.floor(m / COLUMNS);
      away[m] = Math.min(away[m], at(i - s, j) + dx, at(i, j - s) + dy, at(i - s, j - s) + diagonal, at(i + s, j - s) + diagonal);
    }
  }
  const most = Math.max(...away), deep = away.map((v, n) => n).filter((n) => away[n] > 0.9 * most);
  if (!(most > 1.2)) return null;
  // of the points that are about as deep the one nearest to the middle of the region
  const all = cells.map((c, n) => n).filter((n) => cells[n] === kind);
  const mean = (list, f) => list.reduce((sum, n) => sum + f(n), 0) / list.length;
  const [mi, mj] = [mean(all, (n) => n % COLUMNS), mean(all, (n) => Math.floor(n / COLUMNS))];
  const gap = (n) => Math.hypot((n % COLUMNS) - mi, Math.floor(n / COLUMNS) - mj);
  const best = deep.reduce((a, b) => (gap(b) < gap(a) ? b : a));
  return [best % COLUMNS, Math.floor(best / COLUMNS)];
}
