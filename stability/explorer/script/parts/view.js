// What is shown: one record that every part reads, changes of it, and its text in the link.

import {Subject, certified} from "../mathematics/subject.js";
import {axisOf} from "../drawing/scales.js";

const REST = 160; // milliseconds without a change after which nothing moves
const SEEN = ["values", "ranges", "x", "y"]; // what moves a picture

/** Ends of an axis with its spacing: "log", which needs a positive end, or nothing. */
export function ranged([low, high], spacing) {
  return spacing === "log" && low > 0 ? [low, high, "log"] : [low, high];
}

export class View {
  constructor(data, link = "") {
    this.data = data;
    this.subjects = new Map(data.subjects.map((s) => [s.key, new Subject(s, data.looks.verdicts)]));
    this.listeners = [];
    this.memory = {}; // values of quantities that the last subjects had, by family and name
    this.moving = true; // the first picture, or a hand moves the point or the axes: pictures may be coarser
    this.state = this.initial(data.start.subject, data.start.values || {});
    (data.start.axes || []).forEach((axis, i) => {
      if (!axis) return;
      const which = "xy"[i], other = "yx"[i];
      if (this.state[other] === axis[0]) this.state[other] = this.state[which];
      this.state[which] = axis[0];
      this.state.ranges[axis[0]] = axis.slice(1);
    });
    this.state = {...this.state, ...this.read(link)};
  }

  get subject() {
    return this.subjects.get(this.state.subject);
  }

  get motion() {
    return this.data.motions[this.subject.model] || null;
  }

  /** The state with the values that a subject has at first, or those given. */
  initial(key, values) {
    const subject = this.subjects.get(key), own = {}, ranges = {};
    for (const q of subject.quantities) {
      own[q.name] = values[q.name] === undefined ? q.value : values[q.name];
      ranges[q.name] = [Math.min(q.low, own[q.name]), Math.max(q.high, own[q.name])];
    }
    const [x, y] = subject.axes;
    return {subject: key, values: own, ranges, x, y, along: x, mode: null, kick: 0, show: "launch",
      tilt: 0.1, until: 60, si: this.hasSI};
  }

  /** Whether the page knows the body's mass, length and gravity. */
  get hasSI() {
    return Boolean((this.data.si || {}).sizes);
  }

  /** Size and unit of numbers of a kind as they are shown; `words` is the unit without SI. */
  measure(kind, words) {
    const known = this.state.si && this.data.si.sizes[kind];
    return known ? {size: known[0], unit: known[1]} : {size: 1, unit: words};
  }

  /** The same of a quantity. */
  shown(q) {
    return this.measure(q.kind, q.unit);
  }

  /** The same of a time, a rate or a curve. */
  curve(name) {
    return this.measure(this.data.kinds[name], this.data.units[name] || "");
  }

  /** Change the state and tell every part what changed. */
  set(patch) {
    const changed = Object.keys(patch).filter((n) => patch[n] !== this.state[n]);
    if (!changed.length) return;
    this.state = {...this.state, ...patch};
    if (changed.includes("subject")) this.moving = false;
    else if (changed.some((n) => SEEN.includes(n))) this.stir();
    this.tell(changed);
  }

  /** Something moves, until a while after the last change. */
  stir() {
    this.moving = true;
    clearTimeout(this.resting);
    this.resting = setTimeout(() => { this.moving = false; this.tell(["moving"]); }, REST);
  }

  tell(changed) {
    for (const listener of this.listeners) listener(new Set(changed));
  }

  /** Change one quantity, within what its family accepts. */
  move(given, along = null) {
    const values = {...this.state.values};
    for (const [name, value] of Object.entries(given)) {
      if (this.subject.accepts(name, value)) values[name] = value;
    }
    this.set({values, along: along || this.state.along});
  }

  /** Another family or law; friction and inertia stay, also over a law without friction, and each family has its member. */
  choose(key) {
    const kept = {}, old = this.state, next = this.subjects.get(key);
    const same = next.family === this.subject.family;
    const kind = (subject, i) => (i ? subject.names[i] : `${subject.family} ${subject.names[i]}`); // the first names a member
    this.subject.names.forEach((name, i) => { this.memory[kind(this.subject, i)] = old.values[name]; });
    next.names.forEach((name, i) => {
      const value = this.memory[kind(next, i)];
      if (value !== undefined && next.accepts(name, value)) kept[name] = value;
    });
    const state = this.initial(key, kept);
    if (same) for (const n of next.names) if (n in old.ranges) state.ranges[n] = old.ranges[n];
    this.set({...state, tilt: old.tilt, until: old.until, show: old.show, si: old.si});
  }

  on(listener) {
    this.listeners.push(listener);
  }

  axis(which) {
    return axisOf(this.state, this.state[which]);
  }

  /** The quantities of the point as an array. */
  point() {
    return this.subject.array(this.state.values);
  }

  certificate() {
    return certified(this.data.certificates[this.state.subject], this.state.values, this.data.looks.letters);
  }

  /** The state as the text of a link. */
  write() {
    const s = this.state, parts = [`show=${s.subject.replace(" ", "-")}`];
    for (const name of this.subject.names) parts.push(`${encodeURIComponent(name)}=${s.values[name]}`);
    for (const which of ["x", "y"]) {
      parts.push(`${which}axis=${encodeURIComponent(s[which])}:${s.ranges[s[which]].join(":")}`);
    }
    parts.push(`picture=${s.show}`, `tilt=${s.tilt}`, `time=${s.until}`, `along=${encodeURIComponent(s.along)}`);
    if (s.kick) parts.push(`kick=${s.kick}`);
    if (s.mode !== null) parts.push(`mode=${s.mode}`);
    if (this.hasSI) parts.push(`units=${s.si ? "SI" : "dimensionless"}`);
    return parts.join("&");
  }

  /** The part of the state that a link says; what it does not say, or says wrongly, stays. */
  read(link) {
    const given = Object.fromEntries(link.replace(/^#/, "").split("&").filter((p) => p.includes("=")).flatMap((p) => {
      const at = p.indexOf("=");
      try {
        return [[decodeURIComponent(p.slice(0, at)), decodeURIComponent(p.slice(at + 1))]];
      } catch { // a % without two digits
        return [];
      }
    }));
    const key = [...this.subjects.keys()].find((k) => k.replace(" ", "-") === given.show);
    const state = key ? this.initial(key, {}) : this.state;
    const subject = this.subjects.get(state.subject), values = {...state.values}, ranges = {...state.ranges};
    for (const name of subject.names) {
      if (given[name] !== undefined && subject.accepts(name, Number(given[name]))) values[name] = Number(given[name]);
    }
    const out = {...state, values, ranges};
    for (const which of ["x", "y"]) {
      const [name, low, high, spacing] = (given[`${which}axis`] || "").split(":");
      if (subject.names.includes(name)) out[which] = name;
      if (Number(high) > Number(low)) ranges[name] = ranged([Number(low), Number(high)], spacing);
    }
    if (out.x === out.y) [out.x, out.y] = subject.axes;
    if (["steady", "mode", "launch"].includes(given.picture)) out.show = given.picture;
    if (Math.abs(given.tilt) <= 1.5) out.tilt = Number(given.tilt);
    if (Number(given.time) > 0 && Number(given.time) <= 1000) out.until = Number(given.time);
    if (subject.names.includes(given.along)) out.along = given.along;
    if (/^\d+$/.test(given.kick || "") && Number(given.kick) < subject.states.length) out.kick = Number(given.kick);
    if (/^\d+$/.test(given.mode || "")) out.mode = Number(given.mode);
    if (this.hasSI && ["SI", "dimensionless"].includes(given.units)) out.si = given.units === "SI";
    return out;
  }
}
