// One family under one law: its formulas compiled, and what follows from them at a point.

import {Members} from "./members.js";
import {eigenvector, polynomialRoots} from "./roots.js";

const compiled = new Map();

/** A function from the source that Python printed; each text is compiled once. */
export function fromSource(text) {
  if (!compiled.has(text)) compiled.set(text, new Function(`return ${text}`)());
  return compiled.get(text);
}

export class Subject {
  /** `verdicts` says of each verdict how it looks. */
  constructor(record, verdicts) {
    Object.assign(this, record);
    this.names = this.quantities.map((q) => q.name);
    this.quantity = Object.fromEntries(this.quantities.map((q) => [q.name, q]));
    this.wholeEven = this.good === "neutral";
    const sides = ["unstable", this.good, "undecided"].map((verdict) => verdicts[verdict]);
    this.patterns = sides.map(({pattern}) => pattern);
    this.hatching = sides.filter(({pattern}) => pattern).map(({pattern, word}) => `${pattern}: ${word}`).join("; ").concat(".")
      .replace(/^./, (letter) => letter.toUpperCase());
    this.unknown = this.solver ? this.solver.names : [];
  }

  /** The functions of the subject, compiled when it is first shown. */
  get formula() {
    if (!this.ready) {
      const [coefficients, conditions] = [this.coefficients, this.conditions].map(fromSource);
      this.ready = {coefficients: (q) => coefficients(this.full(q)), conditions: (q) => conditions(this.full(q))};
    }
    return this.ready;
  }

  /** Unknowns of the member at the quantities; none where members are known in closed form. */
  solved(q) {
    return this.solver ? this.finder.solve(q) : [];
  }

  get finder() {
    if (!this.found) this.found = new Members(this.solver, fromSource(this.solver.equations));
    return this.found;
  }

  /** Whether members may be sought next to the last one, for a picture in motion. */
  hurry(on) {
    if (this.solver) Object.assign(this.finder, {hasty: on, last: null});
  }

  /** Quantities and unknowns: what every formula of a member takes. */
  full(q) {
    return this.solver ? [...q, ...this.solved(q)] : q;
  }

  /** States of the steady motion. */
  steady(q) {
    return fromSource(this.member)(this.full(q));
  }

  /** Quantities by name as the array that every function takes. */
  array(values) {
    return this.names.map((n) => values[n]);
  }

  /** Eigenvalues that are not zero by structure, sorted by real, then imaginary part. */
  eigenvalues(q) {
    const flat = this.formula.coefficients(q), found = [];
    let start = 0;
    this.degrees.forEach((degree, i) => {
      found.push(...polynomialRoots(flat.slice(start, start + degree + 1), this.even[i]));
      start += degree + 1;
    });
    return found.sort((a, b) => a[0] - b[0] || a[1] - b[1]);
  }

  /** Whether the family has a member there. */
  exists(q) {
    return this.solved(q).every(Number.isFinite) && (!this.members || fromSource(this.members)(this.full(q)).every((v) => v > 0));
  }

  /** Largest real part of the eigenvalues. */
  growth(q) {
    let most = -Infinity;
    if (this.solver && !this.exists(q)) return NaN;
    for (const [re] of this.eigenvalues(q)) if (re > most) most = re;
    return most;
  }

  /** Each condition with its value, a bound on its rounding error, and its proved sign or 0. */
  conditionsAt(q) {
    const flat = this.bounds ? fromSource(this.bounds)(q) : this.formula.conditions(q);
    return this.rules.map((rule, i) => {
      const value = flat[2 * i], error = (this.bounds ? 1 : rule.share) * flat[2 * i + 1];
      const sure = Math.abs(value) > error && Number.isFinite(error);
      return {...rule, value, error, sign: sure ? Math.sign(value) : 0};
    });
  }

  /** The least of the conditions over their sizes: its sign is the verdict, without proof; NaN without a member. */
  margin(q) {
    if (!this.exists(q)) return NaN;
    const flat = this.formula.conditions(q);
    let least = 1;
    for (let i = 0; i < this.rules.length; i++) least = Math.min(least, flat[2 * i] / flat[2 * i + 1]);
    return least;
  }

  /** The verdict by the signs of the conditions in double precision, or undecided; absent without a member. */
  judge(q) {
    if (!this.exists(q)) return {verdict: "absent", rows: this.conditionsAt(q)};
    const rows = this.conditionsAt(q);
    if (rows.some((r) => r.sign < 0)) return {verdict: "unstable", rows};
    if (rows.every((r) => r.sign > 0)) return {verdict: this.good, rows};
    return {verdict: "undecided", rows};
  }

  /** States of the steady motion, the parameters of its equations, and ∂ẋ/∂x row by row. */
  linearised(q) {
    const states = this.steady(q), p = this.parameters.map((i) => q[i]);
    return {states, p, matrix: fromSource(this.jacobian)(states, p)};
  }

  /** A vector of the linearised motion that belongs to an eigenvalue. */
  mode(q, eigenvalue) {
    const {matrix} = this.linearised(q);
    return eigenvector(matrix, this.states.length, eigenvalue);
  }

  /** Whether a quantity may have this value. */
  accepts(name, value) {
    const {least, most} = this.quantity[name];
    return Number.isFinite(value) && (least === null || value > least) && (most === null || value < most);
  }
}

/** The verdict that is proved on a rectangle around a point, where the file carries it; `letters` says which letter means which. */
export function certified(certificates, values, letters) {
  for (const one of certificates || []) {
    if (Object.entries(one.held).some(([name, value]) => values[name] !== value)) continue;
    const place = one.axes.map(([name, low, high]) => (values[name] - low) / (high - low));
    if (place.some((u) => !(u >= 0 && u <= 1))) continue;
    return around(one, place, letters);
  }
  return null;
}

const EDGE = 1e-12; // rounding of a place, of the whole axis: a point this near to an edge has two sides

/** What is proved around a place: on an edge of rectangles, what all of them prove. */
function around(one, [u, v], letters) {
  const inside = (w) => Math.min(1 - EDGE, Math.max(EDGE, w));
  const found = [];
  for (const a of [-EDGE, EDGE]) for (const b of [-EDGE, EDGE]) found.push(inTree(one, [inside(u + a), inside(v + b)]));
  const same = found.every((f) => f.letter === found[0].letter);
  return {verdict: same ? letters[found[0].letter] : "undecided", ends: found[0].ends};
}

function inTree(one, place) {
  let at = 0, low = [0, 0], width = 1;
  const skip = () => { // past one node with all its children
    let open = 1;
    while (open) open += one.tree[at++] === "+" ? 3 : -1;
  };
  while (one.tree[at] === "+") {
    at++;
    width /= 2;
    const side = place.map((u, i) => (u >= low[i] + width ? 1 : 0));
    for (let child = side[0] + 2 * side[1]; child > 0; child--) skip();
    low = low.map((v, i) => v + side[i] * width);
  }
  const ends = one.axes.map(([name, a, b], i) => (
    {name, low: a + (b - a) * low[i], high: a + (b - a) * (low[i] + width)}));
  return {letter: one.tree[at], ends};
}
