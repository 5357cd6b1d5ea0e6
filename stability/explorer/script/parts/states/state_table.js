// The states of a system of one's own: the value of each in the steady motion, its size and phase in the chosen mode.

import {element, text} from "../../drawing/elements.js";
import {onceAFrame} from "../../drawing/redrawn.js";
import {components, modesAt} from "../../mathematics/modes.js";
import {phaseText, sizeText} from "./mode_words.js";

const VALUE = 6; // digits of a steady value

export class StateTable {
  constructor(view) {
    this.view = view;
    this.caption = element("caption", {class: "small"});
    this.head = element("thead", {});
    this.rows = element("tbody", {});
    this.root = element("table", {class: "states"}, this.caption, this.head, this.rows);
    this.render = onceAFrame(() => this.draw());
    view.on(() => this.render());
  }

  draw() {
    const {view} = this, {subject, state} = view, q = view.point();
    this.root.hidden = Boolean(subject.pose) || !subject.exists(q);
    if (this.root.hidden) return;
    const steady = subject.steady(q), modes = modesAt(subject, q), index = Math.min(state.mode || 0, modes.length - 1);
    const parts = modes.length ? components(subject.mode(q, modes[index])) : null;
    this.caption.textContent = `The steady motion${parts ? `, and mode ${index + 1} over its largest component` : ""} (float: double precision)`;
    const titles = ["state", "steady value", ...(parts ? [`size in mode ${index + 1}`, "phase"] : [])];
    this.head.replaceChildren(element("tr", {}, titles.map((word) => element("th", {scope: "col"}, word))));
    this.rows.replaceChildren(...subject.states.map((name, i) => {
      const {unit} = view.curve(name), value = `= ${text(steady[i], VALUE)}${unit ? ` ${unit}` : ""}`;
      const cells = parts ? [sizeText(parts[i].size), parts[i].size ? phaseText(parts[i].phase) : "–"] : [];
      return element("tr", {}, element("th", {scope: "row"}, name), [value, ...cells].map((word) => element("td", {}, word)));
    }));
  }
}
