// What is known of the point: its verdict and proof, and its modes, one of which may be chosen.

import {complexText, element, symbol, text} from "../drawing/elements.js";
import {onceAFrame} from "../drawing/redrawn.js";

const SENTENCES = {
  stable: "Every disturbance of the linear motion decays, except those along the family.",
  isolated: "Every disturbance of the linear motion decays.",
  unstable: "Some disturbance grows exponentially.",
  neutral: "No disturbance grows, and none decays: nothing takes energy away.",
  drifting: "Every other eigenvalue decays, but zeros form a Jordan block: a disturbance grows like a power of time.",
  absent: "The family has no member here: there is no such steady motion.",
  undecided: "The point is on a boundary, as far as double precision can see.",
};
const UNREACHED = "The page reaches no member here: the family ends on the way, or its root-finder fails. Python says which.";
const ANOTHER = "The page finds no member here: none exists, or its search meets another inclination than the one that is meant. Python says which.";

export class PointPanel {
  constructor(view) {
    this.view = view;
    this.badge = element("strong", {class: "badge"});
    this.place = element("span", {class: "place"});
    this.sentence = element("p", {class: "sentence"});
    this.proof = element("p", {class: "small proof"});
    this.modes = element("div", {class: "modes", role: "radiogroup", "aria-label": "Modes"});
    this.said = element("p", {class: "unseen", id: "stability-said", "aria-live": "polite"});
    this.root = element("div", {class: "point-panel"},
      element("p", {class: "verdict"}, this.badge, this.place), this.sentence, this.proof, this.said);
    this.render = onceAFrame(() => this.draw());
    view.on(() => this.render());
  }

  draw() {
    const {view} = this, {subject, state} = view, q = view.point(), {verdict, rows} = subject.judge(q);
    const {sign, word} = view.data.looks.verdicts[verdict];
    this.badge.className = `badge ${verdict}`;
    this.badge.replaceChildren(element("span", {"aria-hidden": "true"}, sign), ` ${word}`);
    const at = subject.quantities.map((one) => {
      const {size, unit} = view.shown(one);
      return [symbol(one.symbol), ` = ${text(state.values[one.name] * size, 5)}${unit ? ` ${unit}` : ""}`];
    });
    this.place.replaceChildren("at ", ...at.flatMap((parts, i) => (i ? [", ", ...parts] : parts)));
    const solved = subject.solved(q);
    if (verdict !== "absent") subject.unknown.forEach((n, i) => this.place.append("; ", symbol(n), ` = ${text(solved[i], 5)}`));
    const unsure = subject.solver ? UNREACHED : ANOTHER; // a family in closed form knows where it ends
    const said = verdict === "stable" && !subject.zeros ? "isolated" : verdict;
    this.sentence.textContent = verdict === "absent" && !subject.proved ? unsure : SENTENCES[said];
    if (verdict === "stable" && subject.drift) this.sentence.append(` Beyond the linear motion it ${subject.drift}.`);
    this.proof.replaceChildren(...this.proved(verdict, rows));
    this.list(verdict === "absent" ? [] : subject.eigenvalues(q));
    clearTimeout(this.later);
    this.later = setTimeout(() => { this.said.textContent = `${verdict} ${this.place.textContent}`; }, 400);
  }

  proved(verdict, rows) {
    const one = this.view.certificate(), out = [];
    if (verdict === "absent") return [];
    if (verdict === "undecided") out.push("Not proved here. ");
    else if (!this.view.subject.proved) out.push("Float: the signs of the conditions below in double precision, without a proof. ");
    else if (!rows.length) out.push("Proved for every member of the family, offline. ");
    else out.push(element("b", {}, "Proved in this page"), this.view.state.si ? " for the dimensionless numbers" : "",
      ": the signs of the conditions below exceed their rounding errors. ");
    if (one && one.verdict !== "undecided") {
      const {view} = this, ends = one.ends.map((e) => {
        const q = view.subject.quantity[e.name], {size} = view.shown(q);
        return [symbol(q.symbol), ` from ${text(e.low * size, 4)} to ${text(e.high * size, 4)}`];
      });
      out.push(element("b", {class: "certified"}, "Certified by the package"), `: ${one.verdict} for every `,
        ...ends[0], " and ", ...ends[1], ".");
    } else if (one) out.push("The file's certificate is made of rectangles. The one around this point is left open.");
    else out.push("The file carries no certificate for these numbers.");
    return out;
  }

  list(all) {
    const shown = all.filter((z) => z[1] >= 0).reverse(), {state} = this.view;
    const chosen = state.mode !== null && state.mode < shown.length ? state.mode : null;
    if (this.modes.children.length !== shown.length) {
      this.modes.replaceChildren(...shown.map((_, i) => element("button", {
        role: "radio", class: "mode", onclick: () => this.view.set({mode: i, show: "mode"}),
        onkeydown: (event) => this.arrows(event, i)},
      element("span", {class: "dot"}), element("span", {class: "lambda"}), element("span", {class: "small words"}))));
    }
    const rate = this.view.curve("growth rate"), time = this.view.curve("time");
    shown.forEach((z, i) => {
      const row = this.modes.children[i], [dot, lambda, words] = row.children;
      dot.className = `dot ${z[0] > 1e-12 ? "grows" : "decays"}`;
      lambda.textContent = complexText(z.map((v) => v * rate.size));
      words.textContent = inWords(z, time);
      row.setAttribute("aria-checked", String(i === chosen));
      row.tabIndex = i === (chosen === null ? 0 : chosen) ? 0 : -1;
    });
  }

  arrows(event, i) {
    const step = {ArrowDown: 1, ArrowRight: 1, ArrowUp: -1, ArrowLeft: -1}[event.key];
    if (!step) return;
    const count = this.modes.children.length, next = (i + step + count) % count;
    this.view.set({mode: next, show: "mode"});
    this.modes.children[next].focus();
    event.preventDefault();
  }
}

/** How fast a mode grows or decays, and its period, in a unit of time. */
function inWords([re, im], {size: second, unit}) {
  const size = Math.hypot(re, im), parts = [], time = (t) => `${text(second * t, 3)}${unit ? ` ${unit}` : ""}`;
  if (Math.abs(re) > 1e-12 * size) parts.push(`${re > 0 ? "doubles" : "halves"} in ${time(Math.LN2 / Math.abs(re))}`);
  else if (size > 0) parts.push("persists");
  if (im !== 0) parts.push(`period ${time((2 * Math.PI) / Math.abs(im))}`);
  return parts.join(", ");
}
