// The conditions of stability with the numbers of the point put in, and their signs.

import {element, text} from "../drawing/elements.js";
import {onceAFrame} from "../drawing/redrawn.js";

const KINDS = {
  static: "no real eigenvalue passes through zero (divergence)",
  flutter: "no complex pair of eigenvalues crosses the imaginary axis",
  auxiliary: "positive wherever the motion is stable",
};
const LONG = 260; // characters of a formula that is folded

export class Conditions {
  constructor(view) {
    this.view = view;
    this.rows = element("div", {class: "condition-rows"});
    this.rule = element("p", {class: "sentence"});
    this.note = element("p", {class: "small"});
    this.polynomial = element("p", {class: "small polynomial"});
    this.root = element("div", {class: "conditions"}, this.rule, this.note, this.polynomial, this.rows);
    this.render = onceAFrame(() => this.draw());
    view.on(() => this.render());
  }

  draw() {
    const {view} = this, {subject} = view;
    if (this.shown !== subject.key) this.build(subject);
    const q = view.point(), {rows} = subject.judge(q);
    const notes = [subject.note, view.state.si ? "numbers without dimension: m = R = g = 1" : ""].filter((n) => n);
    this.note.textContent = notes.map((n) => `${n}.`).join(" ").replace(/^n/, "N");
    this.note.hidden = !notes.length;
    this.polynomial.innerHTML = `Characteristic polynomial (float): ${polynomialText(subject, q)}`;
    rows.forEach((row, i) => {
      const {value, put} = this.lines[i];
      const sign = row.sign > 0 ? "> 0" : row.sign < 0 ? "< 0" : "≈ 0";
      const error = element("span", {class: "quiet"}, subject.proved ? ` ± ${text(row.error, 2)}` : " (float)");
      value.replaceChildren(`= ${text(row.value, 6)}`, error, " ",
        element("b", {class: row.sign > 0 ? "holds" : "fails"}, `${sign} ${row.sign > 0 ? "✓" : row.sign < 0 ? "✗" : "?"}`));
      if (put) put.innerHTML = this.filled(row);
    });
  }

  build(subject) {
    this.shown = subject.key;
    const good = subject.good[0].toUpperCase() + subject.good.slice(1), count = subject.rules.length;
    this.rule.textContent = count === 0
      ? `${good} at every member of the family: no eigenvalue can cross the imaginary axis.`
      : `${good} where ${count === 1 ? `this ${subject.note ? "number" : "polynomial"} is` : `these ${subject.note ? "numbers" : "polynomials"} are all`} positive, unstable where ${count === 1 ? "it" : "one"} is negative.`;
    this.lines = [];
    this.rows.replaceChildren(...subject.rules.map((rule) => {
      const value = element("span", {class: "value"}), long = rule.text.length > LONG;
      const put = rule.filled ? element("span", {class: "put"}) : null;
      this.lines.push({value, put});
      const formula = element("span", {class: "formula", html: `${rule.text} &gt; 0`});
      const head = element("span", {class: "small"}, `${rule.kind}: ${KINDS[rule.kind]}`);
      return element("div", {class: `condition ${rule.kind}`}, head,
        long ? element("details", {}, element("summary", {}, "the polynomial"), formula) : formula,
        element("span", {class: "put-line"}, put, value));
    }));
  }

  /** The formula with the numbers in the places of the letters. */
  filled(row) {
    const {subject, state} = this.view, solved = subject.solved(this.view.point());
    const values = {...state.values, ...Object.fromEntries(subject.unknown.map((n, i) => [n, solved[i]]))};
    return row.filled.replace(/\{(\w+)\}/g, (_, name) => {
      const v = values[name];
      return v < 0 ? `(${text(v, 5)})` : text(v, 5);
    }).concat(subject ? " " : "");
  }
}

/** The characteristic polynomial with its numbers, as HTML; every factor with leading coefficient 1. */
export function polynomialText(subject, q) {
  const flat = subject.formula.coefficients(q), factors = subject.zeros ? [power(subject.zeros)] : [];
  let start = 0;
  for (const degree of subject.degrees) {
    const own = flat.slice(start, start + degree + 1), words = [];
    start += degree + 1;
    for (let n = degree; n >= 0; n--) {
      const c = own[n] / own[degree], size = text(Math.abs(c), 5);
      if (c === 0) continue;
      if (!Number.isFinite(c)) return "none, as there is no member here";
      words.push(`${c < 0 ? " − " : words.length ? " + " : ""}${n === degree ? "" : size}${n ? `${n < degree ? " " : ""}${power(n)}` : ""}`);
    }
    factors.push(subject.degrees.length + Number(subject.zeros > 0) > 1 ? `(${words.join("")})` : words.join(""));
  }
  return factors.join(" ");
}

function power(n) {
  return `<i>λ</i>${n > 1 ? `<sup>${n}</sup>` : ""}`;
}
