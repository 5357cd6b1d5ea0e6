// Members whose unknowns are solved for: by Newton's method from a guess, or followed from a known member along a
// straight line, with the package's own limits of a step, so that both reach the same member.

const STEPS = 200, ROOT = 1e-11, FLOOR = 1e-8; // Newton's steps; its largest last step; unknowns that count as this large
const SHARES = [1, 2, 0.5, 4, 0.25]; // first guesses of positive unknowns, over the given ones
const LEAST = 1e-8, MOST = 400, SHORTER = 0.45; // shortest step of a line, most steps, factor after a failure
const REACH = 0.5, FIRST = 0.1, CONTRACTION = 0.25, CLOSE = 1e-2, SETTLED = 1e-10; // limits of one step
const ENOUGH = 1e-7; // last step of a picture in motion
const BEND = 0.6, SLIGHT = 0.01; // largest change of a tangent

export class Members {
  /** `equations` gives residuals, their slopes by the unknowns, and by the quantities, row by row. */
  constructor({guess, anchor, positive, cut}, equations) {
    Object.assign(this, {guess, anchor, positive, cut, equations});
    this.last = null;
    this.hasty = false;
  }

  /** The unknowns at the quantities; NaN where no member is reached. */
  solve(q) {
    if (!this.last || q.some((v, i) => v !== this.last.q[i])) {
      const found = this.nearby(q) || (this.anchor ? this.followed(q) : this.searched(q));
      this.last = {q: [...q], u: found || this.guess.map(() => NaN)};
    }
    return this.last.u;
  }

  /** Residual, slopes by the unknowns, and slopes along a change of the quantities. */
  at(q, u, turn = null) {
    const n = u.length, flat = this.equations(q.slice(0, this.cut), u, q.slice(this.cut)), m = q.length;
    const slope = u.map((_, i) => flat.slice(n + i * n, n + (i + 1) * n)), first = n + n * n;
    const along = turn && u.map((_, i) => turn.reduce((sum, v, j) => sum + (v === 0 ? 0 : v * flat[first + i * m + j]), 0));
    return {r: flat.slice(0, n), slope, along};
  }

  /** For a picture in motion: the member next to the last one, where Newton's method contracts fast. */
  nearby(q) {
    if (!this.hasty || !this.last || !this.last.u.every(Number.isFinite)) return null;
    let {u} = this.last, before = FIRST / CONTRACTION;
    for (let n = 0; n < 4; n++) {
      const {r, slope} = this.at(q, u), {x} = solved(slope, r);
      u = u.map((v, i) => v - x[i]);
      const size = Math.max(...x.map((v, i) => Math.abs(v) / (1 + Math.abs(u[i]))));
      if (!(size <= CONTRACTION * before)) return null;
      if (size <= ENOUGH) return this.positive.every((i) => u[i] > 0) ? u : null;
      before = size;
    }
    return null;
  }

  searched(q) {
    for (const share of this.positive.length ? SHARES : [1]) {
      const u = this.guess.map((v, i) => (this.positive.includes(i) ? share * v : v)), found = this.newton(q, u);
      if (found && this.positive.every((i) => found[i] > 0)) return found;
    }
    return null;
  }

  newton(q, first) {
    let u = first, before = Infinity;
    for (let n = 0; n < STEPS; n++) {
      const {r, slope} = this.at(q, u), step = solved(slope, r).x;
      u = u.map((v, i) => v - step[i]);
      if (!u.every(Number.isFinite)) return null;
      const size = Math.max(...step.map((s, i) => Math.abs(s) / Math.max(Math.abs(u[i]), FLOOR)));
      if (size <= ROOT && size >= before / 4) return u; // to the last digits
      if (size === 0) return u;
      before = size;
    }
    return null;
  }

  /** From the known member along a straight line; a fold, or a branch point, ends it. */
  followed(q) {
    const {given, unknown} = this.anchor, turn = q.map((v, i) => v - given[i]);
    let u = unknown, t = 0, step = 1, patience = 0;
    const start = this.at(given, u, turn), first = solved(start.slope, start.along);
    let tangent = first.x.map((v) => -v), sign = first.sign;
    for (let n = 0; t < 1 && n < MOST; n++) {
      if (step < Math.min(LEAST, 1 - t) || sign === 0) return null;
      const room = Math.min(...u.map((v, i) => (REACH * (1 + Math.abs(v))) / Math.max(Math.abs(tangent[i]), 1e-300)));
      const h = Math.min(step, room, 1 - t), to = h === 1 - t ? 1 : t + h;
      const next = this.corrected(given.map((v, i) => v + to * turn[i]), u.map((v, i) => v + h * tangent[i]), turn);
      if (next && next.sign === sign && smooth(h, u, next.u, tangent, next.tangent)) {
        [u, t, tangent] = [next.u, to, next.tangent];
        step = patience > 0 ? h : 2 * h;
        patience = Math.max(patience - 1, 0);
      } else {
        step = h * SHORTER;
        patience = 2;
      }
    }
    const found = t === 1 ? this.newton(q, u) : null;
    return found && this.positive.every((i) => found[i] > 0) ? found : null;
  }

  /** Three steps of Newton's method from a prediction, where they contract fast. */
  corrected(q, predicted, turn) {
    let u = predicted, last = null;
    const sizes = [];
    for (let n = 0; n < 3; n++) {
      last = this.at(q, u, turn);
      const {x} = solved(last.slope, last.r);
      sizes.push(Math.max(...x.map((v, i) => Math.abs(v) / (1 + Math.abs(u[i])))));
      u = u.map((v, i) => v - x[i]);
    }
    const [first, second, third] = sizes;
    const fine = first <= FIRST && second <= Math.max(CONTRACTION * first, SETTLED)
      && third <= Math.max(CLOSE * first, SETTLED) && u.every(Number.isFinite);
    if (!fine) return null;
    const {x, sign} = solved(last.slope, last.along);
    return {u, sign, tangent: x.map((v) => -v)};
  }
}

/** Whether tangents before and after a step fit one smooth curve, unknown by unknown. */
function smooth(h, u, next, before, after) {
  const most = Math.max(...next.map(Math.abs));
  return u.every((v, i) => {
    const bend = Math.abs(after[i] - before[i]);
    return bend <= BEND * Math.max(Math.abs(after[i]), Math.abs(before[i]))
      || h * bend <= SLIGHT * Math.max(Math.abs(next[i]), Math.abs(v)) || h * bend <= SETTLED * (1 + most);
  });
}

/** Solution of a small system by elimination with pivots, and the sign of its determinant. */
function solved(matrix, right) {
  const rows = matrix.map((row, i) => [...row, right[i]]), n = right.length, x = new Array(n).fill(0);
  let sign = 1;
  for (let i = 0; i < n; i++) {
    let best = i;
    for (let j = i + 1; j < n; j++) if (Math.abs(rows[j][i]) > Math.abs(rows[best][i])) best = j;
    if (best !== i) { [rows[i], rows[best]] = [rows[best], rows[i]]; sign = -sign; }
    sign *= Math.sign(rows[i][i]) || 0;
    for (let j = i + 1; j < n; j++) {
      const share = rows[j][i] / rows[i][i];
      for (let k = i; k <= n; k++) rows[j][k] -= share * rows[i][k];
    }
  }
  for (let i = n - 1; i >= 0; i--) {
    let rest = rows[i][n];
    for (let k = i + 1; k < n; k++) rest -= rows[i][k] * x[k];
    x[i] = rest / rows[i][i];
  }
  return {x, sign};
}
