// Family, law, and a slider with a number for each quantity.

import {element, spoken, symbol, text} from "../drawing/elements.js";
import {onceAFrame} from "../drawing/redrawn.js";
import {axisOf} from "../drawing/scales.js";
import {ranged} from "./view.js";

const STEPS = 2000;

export class Controls {
  constructor(view, names) {
    this.view = view;
    this.names = names;
    this.family = element("div", {class: "segments", role: "radiogroup", "aria-label": "Family"});
    this.law = element("div", {class: "segments", role: "radiogroup", "aria-label": "Contact"});
    this.top = element("div", {class: "choices"}, this.family, this.law);
    this.rows = element("div", {class: "sliders"});
    this.xAxis = this.axisChoice("x");
    this.yAxis = this.axisChoice("y");
    this.ranges = element("div", {class: "ranges"});
    this.axes = element("details", {class: "axes"}, element("summary", {}, "Axes"),
      element("div", {class: "axis-line"}, element("label", {}, "across ", this.xAxis), element("label", {}, "up ", this.yAxis)),
      this.ranges);
    this.units = this.unitsChoice();
    this.root = element("div", {class: "controls"}, this.rows, this.units, this.axes);
    this.render = onceAFrame(() => this.draw());
    view.on((changed) => { if (changed.has("subject")) this.build(); this.render(); });
    this.build();
  }

  axisChoice(which) {
    const choice = element("select", {"aria-label": which === "x" ? "Horizontal axis" : "Vertical axis", onchange: () => {
      const other = which === "x" ? "y" : "x", {state} = this.view, patch = {[which]: choice.value};
      if (state[other] === choice.value) patch[other] = state[which];
      this.view.set(patch);
    }});
    return choice;
  }

  /** A switch between SI units and dimensionless numbers, where the page knows both. */
  unitsChoice() {
    const {view} = this, words = {true: "SI units", false: "Dimensionless"};
    const buttons = Object.entries(words).map(([si, word]) => element("button", {role: "radio", "data-si": si,
      onclick: () => view.set({si: si === "true"}), onkeydown: (event) => this.roam(event, this.unitButtons)}, word));
    this.unitButtons = element("div", {class: "segments", role: "radiogroup", "aria-label": "Units"}, buttons);
    return element("div", {class: "units", hidden: !view.hasSI}, this.unitButtons,
      element("span", {class: "small"}, view.hasSI ? view.data.si.body : ""));
  }

  build() {
    const {subject, subjects} = this.view, all = [...subjects.values()];
    const segment = (group, list, chosen, label, key) => group.replaceChildren(...list.map((name) => element("button", {
      role: "radio", "aria-checked": String(name === chosen), tabindex: name === chosen ? 0 : -1,
      onclick: () => this.view.choose(key(name)), onkeydown: (event) => this.roam(event, group),
    }, label(name))));
    const families = [...new Set(all.map((s) => s.family))], laws = [...new Set(all.map((s) => s.law))];
    segment(this.family, families, subject.family, (n) => this.names.families[n] || n, (n) => `${n} ${subject.law}`.trim());
    segment(this.law, laws, subject.law, (n) => this.names.laws[n] || n, (n) => `${subject.family} ${n}`.trim());
    this.family.hidden = families.length < 2;
    this.law.hidden = laws.length < 2;
    this.rows.replaceChildren(...subject.quantities.map((q) => this.row(q)));
    for (const choice of [this.xAxis, this.yAxis]) {
      choice.replaceChildren(...subject.quantities.map((q) => element("option", {value: q.name}, `${spoken(q)}`)));
    }
    this.axes.hidden = subject.quantities.length < 2;
    this.render();
  }

  roam(event, group) {
    const step = {ArrowRight: 1, ArrowDown: 1, ArrowLeft: -1, ArrowUp: -1}[event.key];
    if (!step) return;
    const all = [...group.children], next = (all.indexOf(event.currentTarget) + step + all.length) % all.length;
    all[next].click();
    group.children[next].focus();
    event.preventDefault();
  }

  row(q) {
    const id = `stability-${q.name}`, marks = q.marks.length ? `${id}-marks` : null;
    const slider = element("input", {type: "range", id, min: 0, max: STEPS, step: 1, list: marks, "aria-label": `${spoken(q)}`,
      oninput: () => {
        const place = slider.value / STEPS;
        this.refuse(number, "");
        this.view.move({[q.name]: this.held ? this.snapped(q, place) : this.onAxis(q, place)}, q.name);
      }});
    // the hand rests at a value with a name; arrow keys pass it
    slider.addEventListener("pointerdown", () => { this.held = true; });
    slider.addEventListener("pointerup", () => { this.held = false; });
    const number = element("input", {type: "number", step: "any", "aria-label": `${spoken(q)}, number`,
      onchange: () => this.typed(q, number)});
    const named = element("span", {class: "named small"});
    const ticks = marks ? element("datalist", {id: marks}) : null;
    const arrow = element("span", {class: "role small"});
    const row = element("div", {class: "slider"},
      element("label", {for: id, title: q.label || q.name}, symbol(q.symbol), arrow), slider, number, named, ticks);
    Object.assign(row, {slider, number, named, quantity: q, ticks, arrow});
    return row;
  }

  /** The scale of a slider: that of the quantity's axis. */
  axis(q) {
    return axisOf(this.view.state, q.name);
  }

  onAxis(q, place) {
    const {size} = this.view.shown(q);
    return Number((this.axis(q).value(place) * size).toPrecision(6)) / size;
  }

  /** The value at a place of the slider, or one with a name that is within a step of it. */
  snapped(q, place) {
    const axis = this.axis(q), near = q.marks.find(([v]) => Math.abs(axis.place(v) - place) < 0.006);
    return near ? near[0] : this.onAxis(q, place);
  }

  typed(q, input) {
    const value = Number(input.value) / this.view.shown(q).size, ok = input.value !== "" && this.view.subject.accepts(q.name, value);
    this.refuse(input, ok ? "" : this.accepted(q));
    if (!ok) return;
    const ranges = {...this.view.state.ranges}, [low, high, spacing] = ranges[q.name];
    ranges[q.name] = ranged([Math.min(low, value), Math.max(high, value)], spacing);
    this.view.set({ranges});
    this.view.move({[q.name]: value}, q.name);
  }

  /** In words, which numbers a quantity may have, as it is shown. */
  accepted(q) {
    const {size, unit} = this.view.shown(q), shown = (v) => `${text(v * size, 4)}${unit && size !== 1 ? ` ${unit}` : ""}`;
    const ends = [q.least === null ? null : `above ${shown(q.least)}`, q.most === null ? null : `at most ${shown(q.most)}`];
    return `give a number ${ends.filter((e) => e).join(" and ")}`.trim();
  }

  /** Say next to a field why its number is not taken; nothing where it is. */
  refuse(input, reason) {
    input.setAttribute("aria-invalid", String(Boolean(reason)));
    if (!input.reason) input.reason = element("span", {class: "reason small", role: "alert"});
    if (reason) input.after(input.reason);
    else input.reason.remove();
    input.reason.textContent = reason;
  }

  draw() {
    const {state} = this.view;
    for (const row of this.rows.children) {
      const q = row.quantity, value = state.values[q.name], axis = this.axis(q), {size, unit} = this.view.shown(q);
      row.slider.value = String(Math.round(axis.place(value) * STEPS));
      row.slider.setAttribute("aria-valuetext", `${text(value * size, 5)} ${unit}`);
      const refused = row.number.reason && row.number.reason.isConnected;
      if (document.activeElement !== row.number && !refused) row.number.value = String(Number((value * size).toPrecision(6)));
      const named = q.marks.find(([v]) => v === value);
      const words = named ? `${q.label}${q.label ? ": " : ""}${named[1]}` : [q.label, unit && `[${unit}]`].filter((w) => w).join(" ");
      row.named.textContent = words;
      row.arrow.textContent = q.name === state.x ? "→" : q.name === state.y ? "↑" : "";
      row.arrow.title = q.name === state.x ? "horizontal axis" : q.name === state.y ? "vertical axis" : "";
      if (row.ticks) row.ticks.replaceChildren(...q.marks.map(([v]) => element("option", {value: Math.round(axis.place(v) * STEPS)})));
    }
    for (const button of this.unitButtons.children) {
      const own = button.dataset.si === String(state.si);
      button.setAttribute("aria-checked", String(own));
      button.tabIndex = own ? 0 : -1;
    }
    this.xAxis.value = state.x;
    this.yAxis.value = state.y;
    this.limits();
  }

  limits() {
    const {view} = this, {state} = view, key = `${state.subject} ${state.x} ${state.y}`;
    if (this.limited !== key) {
      this.limited = key;
      this.ranges.replaceChildren(...[state.x, state.y].map((name) => {
        const q = view.subject.quantity[name], ends = [0, 1].map((i) => element("input", {type: "number", step: "any",
          "aria-label": `${spoken(q)}, ${i ? "upper" : "lower"} end of the axis`, onchange: () => {
            const range = [...view.state.ranges[name]];
            range[i] = Number(ends[i].value) / view.shown(q).size;
            const ok = ends[i].value !== "" && range[1] > range[0] && (range[2] !== "log" || range[0] > 0);
            const above = range[2] === "log" && !(range[0] > 0) ? "a logarithmic axis starts above zero" : "the upper end lies above the lower end";
            this.refuse(ends[i], ok ? "" : ends[i].value === "" ? "give a number" : above);
            if (ok) {
              this.refuse(ends[1 - i], "");
              view.set({ranges: {...view.state.ranges, [name]: range}});
            }
          }}));
        const log = element("input", {type: "checkbox", "aria-label": `${spoken(q)}, logarithmic axis`, onchange: () => view.set({
          ranges: {...view.state.ranges, [name]: ranged(view.state.ranges[name], log.checked ? "log" : "")}})});
        const line = element("div", {class: "axis-line"}, symbol(q.symbol), " from ", ends[0], " to ", ends[1],
          element("label", {class: "log"}, log, " logarithmic"));
        Object.assign(line, {ends, name, log});
        return line;
      }));
    }
    for (const line of this.ranges.children) {
      const [low, , spacing] = state.ranges[line.name], {size} = view.shown(view.subject.quantity[line.name]);
      line.log.checked = spacing === "log";
      line.log.disabled = !(low > 0);
      line.log.title = low > 0 ? "" : "a logarithmic axis starts above zero";
      line.ends.forEach((input, i) => {
        if (document.activeElement !== input && !(input.reason && input.reason.isConnected)) input.value = String(Number((state.ranges[line.name][i] * size).toPrecision(6)));
      });
    }
  }
}
