// The verdict written into each region of the diagram, where it is deepest.

const COLUMNS = 36, ROWS = 24;
const LEAST = 0.03; // share of the diagram that a region needs for its name

/** [word, u, v] with places in the unit square. */
export function regionNames(view, x, y) {
  const {subject, state} = view, at = {...state.values}, good = subject.wholeEven ? "neutral" : "stable";
  const cells = [];
  for (let j = 0; j < ROWS; j++) {
    for (let i = 0; i < COLUMNS; i++) {
      at[x.name] = x.value((i + 0.5) / COLUMNS);
      at[y.name] = y.value((j + 0.5) / ROWS);
      cells.push(subject.margin(subject.array(at)) > 0);
    }
  }
  const found = [];
  for (const [kind, word] of [[true, good], [false, "unstable"]]) {
    if (cells.filter((c) => c === kind).length < LEAST * cells.length) continue;
    const best = deepest(cells, kind);
    if (best) found.push([word, (best[0] + 0.5) / COLUMNS, (best[1] + 0.5) / ROWS]);
  }
  return found;
}

/** The cell that is farthest from every cell of the other kind, wide words counted. */
function deepest(cells, kind) {
  const others = [];
  cells.forEach((c, n) => { if (c !== kind) others.push([n % COLUMNS, Math.floor(n / COLUMNS)]); });
  let best = null, most = 1.2;
  cells.forEach((c, n) => {
    if (c !== kind) return;
    const i = n % COLUMNS, j = Math.floor(n / COLUMNS);
    let least = Math.min((i + 1) / 2.6, (COLUMNS - i) / 2.6, j + 1, ROWS - j);
    for (const [a, b] of others) {
      if (least <= most) return;
      least = Math.min(least, Math.hypot((a - i) / 2.6, b - j));
    }
    if (least > most) [best, most] = [[i, j], least];
  });
  return best;
}
