// Growth rates and verdicts on a grid over two axes, in double precision: what the diagram's picture is made of.

import {fromSource} from "./subject.js";

// what a node of a grid is; 0: without a member
export const UNSTABLE = 1;
export const GOOD = 2;
export const UNDECIDED = 3;
const NODES = [49, 37]; // grid of members that are solved for: Newton's method starts from them at the nodes between

export class Rates {
  /**
   * `scale` is that of the colours; `size` counts columns and rows; `seek(f)` calls f with the fineness
   * at which members are sought that have to be solved for.
   */
  constructor(subject, values, x, y, scale, size, seek = (f) => f(1)) {
    Object.assign(this, {subject, x, y, scale, size, row: 0});
    this.data = new Float32Array(2 * size[0] * size[1]); // of each node its place on the scale, and what it is
    this.look = fromSource(subject.look);
    this.q = subject.array(values);
    this.at = [x, y].map((axis) => subject.names.indexOf(axis.name));
    this.limits = [x, y].map((axis) => (v) => subject.accepts(axis.name, v));
    if (subject.solver) this.starts = seek((fine) => this.members(NODES.map((n) => Math.round(1 + fine * (n - 1)))));
  }

  /** Compute row by row, until a time of the clock; returns whether every node is there. */
  fill(until = Infinity) {
    const [columns, rows] = this.size, {q, data, scale} = this, [i, j] = this.at, [across, up] = this.limits;
    for (; this.row < rows; this.row++) {
      if (performance.now() > until) return false;
      const v = (this.row + 0.5) / rows;
      q[j] = this.y.value(v);
      if (!up(q[j])) continue;
      for (let n = 0, at = 2 * columns * this.row; n < columns; n++, at += 2) {
        const u = (n + 0.5) / columns;
        q[i] = this.x.value(u);
        if (!across(q[i])) continue;
        const full = this.starts ? this.started(u, v) : q;
        if (!full) continue;
        const [growth, sign, member] = this.look(full);
        if (!(member > 0)) continue;
        data[at] = scale.place(growth);
        data[at + 1] = sign < -1 ? UNSTABLE : sign > 1 ? GOOD : UNDECIDED;
      }
    }
    return true;
  }

  /** Unknowns of the members on a grid from edge to edge. */
  members([columns, rows]) {
    const {subject} = this, q = [...this.q], [i, j] = this.at, found = [];
    for (let row = 0; row < rows; row++) {
      for (let column = 0; column < columns; column++) {
        q[i] = this.x.value(column / (columns - 1));
        q[j] = this.y.value(row / (rows - 1));
        found.push(subject.solved(q));
      }
    }
    return {columns, rows, found};
  }

  /** Quantities and the mean of the unknowns of the members around a place, or null where there are none. */
  started(u, v) {
    const {columns, rows, found} = this.starts, a = u * (columns - 1), b = v * (rows - 1);
    const i = Math.min(Math.floor(a), columns - 2), j = Math.min(Math.floor(b), rows - 2), mean = this.subject.unknown.map(() => 0);
    let total = 0;
    for (let n = 0; n < 4; n++) {
      const [right, above] = [n & 1, n >> 1], near = found[(j + above) * columns + i + right];
      if (!near.every(Number.isFinite)) continue;
      const weight = (right ? a - i : 1 - a + i) * (above ? b - j : 1 - b + j) + 1e-6;
      near.forEach((value, k) => { mean[k] += weight * value; });
      total += weight;
    }
    return total > 0 ? [...this.q, ...mean.map((value) => value / total)] : null;
  }
}
