// Curves over time: energy, normal force, or the states of a system of one's own.

import {element, shape, text} from "../drawing/elements.js";
import {boxOf} from "../drawing/redrawn.js";
import {ticks} from "../drawing/scales.js";

const LEFT = 58, RIGHT = 10, ROW = 62, FOOT = 20, LABEL = 12, MOST = 700, NOTHING = 1e-4;
const SEEN = 0.01, SEEN_LINEAR = 1e-9; // least change of a curve over its size; of a linear motion, which has no rounding
const DIGITS = [3, 5, 7, 9]; // as many as both ends need to differ

export class Traces {
  /** `measure` gives size and unit of a curve, and of `time`, by its name. */
  constructor(seek, measure) {
    this.measure = measure;
    this.drawing = shape("svg", {class: "traces", role: "img"});
    this.root = element("div", {class: "traces-box"}, this.drawing);
    this.run = null;
    this.drawing.addEventListener("pointerdown", (event) => {
      const move = (e) => {
        const box = this.drawing.getBoundingClientRect();
        if (this.run) seek(((e.clientX - box.left - LEFT) / (box.width - LEFT - RIGHT)) * this.span);
      };
      move(event);
      this.drawing.setPointerCapture(event.pointerId);
      this.drawing.addEventListener("pointermove", move);
      this.drawing.addEventListener("pointerup", () => this.drawing.removeEventListener("pointermove", move), {once: true});
    });
    this.box = boxOf(this.root, () => this.draw());
  }

  /** Show a run: {times, series, ended, linear}, over a span of time. */
  show(run, span) {
    this.run = run;
    this.span = span;
    this.draw();
  }

  draw() {
    const {width} = this.box();
    if (!this.run || !width) {
      this.drawing.replaceChildren();
      this.cursor = null;
      return;
    }
    const names = Object.keys(this.run.series), height = ROW * names.length + FOOT, parts = [];
    const wide = width - LEFT - RIGHT, at = (t) => LEFT + (wide * t) / this.span;
    names.forEach((name, row) => {
      const {size, unit} = this.measure(name), values = this.run.series[name], top = row * ROW + 15, tall = ROW - 21;
      let low = Math.min(...values), high = Math.max(...values);
      if (name === "normal force") { low = Math.min(low, 0); high = Math.max(high, 1); }
      const still = low === high, small = (this.run.linear ? SEEN_LINEAR : SEEN) * Math.max(Math.abs(low), Math.abs(high), 1e-9);
      if (high - low < small) { // a constant is drawn as a line in the middle
        const middle = (low + high) / 2;
        [low, high] = [middle - small / 2, middle + small / 2];
      }
      const y = (v) => top + tall * (1 - (v - low) / (high - low));
      const skip = Math.max(1, Math.floor(values.length / MOST));
      const line = this.run.times.map((t, i) => [t, values[i], i]).filter(([, , i]) => i % skip === 0 || i === values.length - 1)
        .map(([t, v]) => `${at(t).toFixed(1)} ${y(v).toFixed(2)}`).join("L");
      parts.push(shape("path", {class: "grid", d: `M${LEFT} ${top + tall}h${wide}`}));
      const digits = DIGITS.find((n) => text(low * size, n) !== text(high * size, n)) || 3;
      const near = (v) => (Math.abs(v) < NOTHING * (high - low) ? 0 : v); // no 10⁻¹⁰ at the foot of a decay
      for (const v of still ? [values[0]] : [low, high]) parts.push(shape("text", {class: "number", x: LEFT - 5, y: y(v) + 3.5, "text-anchor": "end"}, text(near(v) * size, digits)));
      parts.push(shape("text", {class: "number strong", x: LEFT, y: top - 4}, bracketed(name, unit)));
      parts.push(shape("path", {class: "trace", d: `M${line}`}));
      if (this.run.ended) parts.push(shape("circle", {class: "ended", cx: at(this.run.until), cy: y(values[values.length - 1]), r: 3.5}));
    });
    const time = this.measure("time");
    for (const t of ticks(0, this.span * time.size, Math.max(3, Math.floor(wide / 70)))) {
      parts.push(shape("text", {class: "number", x: at(t / time.size), y: height - 5, "text-anchor": "middle"}, text(t, 4)));
    }
    parts.push(shape("text", {class: "number strong", x: width - RIGHT, y: height + 9, "text-anchor": "end"}, bracketed("time t", time.unit)));
    this.cursor = shape("path", {class: "cursor"});
    this.height = height;
    this.drawing.setAttribute("viewBox", `0 0 ${width} ${height + LABEL}`);
    this.drawing.style.height = `${height + LABEL}px`;
    this.drawing.setAttribute("aria-label", `${names.join(" and ")} over time`);
    this.drawing.replaceChildren(...parts, this.cursor);
    this.mark(this.time || 0);
  }

  /** Put the cursor at a time. */
  mark(time) {
    this.time = time;
    if (!this.cursor) return;
    const wide = this.box().width - LEFT - RIGHT;
    this.cursor.setAttribute("d", `M${LEFT + (wide * time) / this.span} 2V${this.height - FOOT + 4}`);
  }
}

function bracketed(name, unit) {
  return unit ? `${name} [${unit}]` : name;
}
