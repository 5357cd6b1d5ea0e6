// The verdict written into each region of the diagram, where it is deepest.

const COLUMNS = 36, ROWS = 24;
const LEAST = 0.03; // share of the diagram that a region needs for its name

const LETTER = 4.3, LINE = 10; // half of a letter's width, half of a word's height [px]

const ROOM = 13; // room that a word leaves around the point [px]

/** Whether the verdict is the good one, cell by cell; null without a member. `good` says so at a place. */
export function regionCells(good) {
  const cells = [];
  for (let row = 0; row < ROWS; row++) {
    for (let column = 0; column < COLUMNS; column++) cells.push(good((column + 0.5) / COLUMNS, (row + 0.5) / ROWS));
  }
  return cells;
}

/** [word, u, v] with places in the unit square, for the cells of a diagram of this size in pixels. */
export function regionNames(cells, view, x, y, width, height) {
  const {subject, state} = view, [px, py] = [x.place(state.values[x.name]), y.place(state.values[y.name])], found = [];
  for (const [kind, word] of [[true, subject.good], [false, "unstable"]]) {
    if (cells.filter((c) => c === kind).length < LEAST * cells.length) continue;
    const half = LETTER * word.length, sides = [width / COLUMNS / half, height / ROWS / LINE];
    const free = cells.map((c, n) => width * Math.abs((n % COLUMNS + 0.5) / COLUMNS - px) > half + ROOM
      || height * Math.abs((Math.floor(n / COLUMNS) + 0.5) / ROWS - py) > LINE + ROOM);
    const best = deepest(cells, kind, free, sides);
    if (best) found.push([word, (best[0] + 0.5) / COLUMNS, (best[1] + 0.5) / ROWS]);
  }
  return found;
}

/**
 * The cell that is farthest from every cell of the other kind, by two sweeps; null where no word fits.
 * `sides` are those of a cell over half the width and height of the word.
 */
function deepest(cells, kind, free, [dx, dy]) {
  const away = cells.map((c) => (c === kind ? Infinity : 0));
  const at = (i, j) => (i < 0 || j < 0 || i >= COLUMNS || j >= ROWS ? 0 : away[j * COLUMNS + i]);
  const diagonal = Math.hypot(dx, dy);
  for (const s of [1, -1]) {
    for (let n = 0; n < cells.length; n++) {
      const m = s > 0 ? n : cells.length - 1 - n, i = m % COLUMNS, j = Math.floor(m / COLUMNS);
      away[m] = Math.min(away[m], at(i - s, j) + dx, at(i, j - s) + dy, at(i - s, j - s) + diagonal, at(i + s, j - s) + diagonal);
    }
  }
  const most = Math.max(...away);
  const deep = [0.9, 0.7, 0.5].map((share) => away.map((v, n) => n).filter((n) => away[n] > share * most && free[n]))
    .find((found) => found.length);
  if (!(most > 1) || !deep) return null;
  // of the points that are about as deep the one nearest to the middle of the region
  const all = cells.map((c, n) => n).filter((n) => cells[n] === kind);
  const mean = (list, f) => list.reduce((sum, n) => sum + f(n), 0) / list.length;
  const [mi, mj] = [mean(all, (n) => n % COLUMNS), mean(all, (n) => Math.floor(n / COLUMNS))];
  const gap = (n) => Math.hypot((n % COLUMNS) - mi, Math.floor(n / COLUMNS) - mj);
  const best = deep.reduce((a, b) => (gap(b) < gap(a) ? b : a));
  return [best % COLUMNS, Math.floor(best / COLUMNS)];
}
