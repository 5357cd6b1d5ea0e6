// What a reader takes away: a link, the diagram as SVG or PNG, and the Python calls.

import {element, text} from "../drawing/elements.js";
import {pythonCall} from "./python_call.js";

const KEPT = ["fill", "stroke", "stroke-width", "stroke-dasharray", "stroke-linejoin", "font-family", "font-size",
  "font-style", "font-weight", "opacity", "paint-order", "fill-opacity", "text-anchor"];
const DOTS = 3; // pixels of a PNG for one of the page
const HEAD = 40; // height of the two lines over the drawing
const NS = "http://www.w3.org/2000/svg";

export class ExportMenu {
  constructor(view, diagram, linked) {
    Object.assign(this, {view, diagram});
    const button = (word, title, act) => element("button", {title, onclick: act}, word);
    this.said = element("span", {class: "small", role: "status"});
    this.code = element("pre", {class: "code", tabindex: 0, "aria-label": "Python calls"});
    this.python = element("section", {class: "card python", hidden: true, "aria-label": "Python"},
      element("h2", {}, "The same in Python"), this.code, button("Copy", "Copy the calls", () => this.copy(this.code.textContent, "calls")));
    this.root = element("div", {class: "exports"}, this.said,
      linked ? button("Link", "Copy a link that restores this view", () => this.copy(location.href, "link")) : null,
      button("SVG", "Save the diagram as SVG", () => this.svg()),
      button("PNG", "Save the diagram as PNG", () => this.png()),
      button("Python", "Show the Python calls that reproduce this", () => this.toggle()));
    view.on(() => this.fill());
    this.fill();
  }

  fill() {
    if (!this.python.hidden) this.code.textContent = pythonCall(this.view);
  }

  toggle() {
    this.python.hidden = !this.python.hidden;
    this.fill();
    if (!this.python.hidden) this.python.scrollIntoView({block: "nearest"});
  }

  async copy(words, what) {
    try {
      await navigator.clipboard.writeText(words);
    } catch { // no permission, or a page from a file: by selection
      const area = element("textarea", {class: "unseen"});
      area.value = words;
      document.body.append(area);
      area.select();
      document.execCommand("copy");
      area.remove();
    }
    this.say(`${what} copied`);
  }

  say(words) {
    this.said.textContent = words;
    clearTimeout(this.later);
    this.later = setTimeout(() => { this.said.textContent = ""; }, 2500);
  }

  /** The diagram as one drawing that needs no style sheet. */
  drawing() {
    const {over, canvas, stage, bar} = this.diagram, box = stage.getBoundingClientRect(), side = bar.getBoundingClientRect();
    const wide = box.width + side.width, copy = over.cloneNode(true), legend = bar.cloneNode(true);
    inlined(over, copy);
    inlined(bar, legend);
    const place = canvas.getBoundingClientRect();
    const picture = document.createElementNS(NS, "image");
    const set = (node, given) => Object.entries(given).forEach(([n, v]) => node.setAttribute(n, v));
    set(picture, {href: canvas.toDataURL("image/png"), x: place.left - box.left, y: place.top - box.top,
      width: place.width, height: place.height, preserveAspectRatio: "none"});
    set(legend, {x: box.width, y: 0, width: side.width, height: box.height});
    const high = box.height + HEAD, style = getComputedStyle(stage);
    set(copy, {xmlns: NS, width: wide, height: high, viewBox: `0 ${-HEAD} ${wide} ${high}`});
    const page = document.createElementNS(NS, "rect");
    set(page, {y: -HEAD, width: "100%", height: "100%", fill: style.getPropertyValue("--page").trim()});
    const lines = this.heading().map((words, i) => {
      const line = document.createElementNS(NS, "text");
      set(line, {x: 10, y: 17 * (i + 1) - HEAD, fill: style.color, "font-family": style.fontFamily, "font-size": i ? 11 : 13});
      line.textContent = words;
      return line;
    });
    const title = document.createElementNS(NS, "title");
    title.textContent = this.heading().join(" ");
    copy.prepend(title, page, picture);
    copy.append(legend, ...lines);
    return {text: new XMLSerializer().serializeToString(copy), wide, high};
  }

  /** What is drawn, for whom the page is gone: the family, what is held, and how it was computed. */
  heading() {
    const {view} = this, {subject, state} = view;
    const held = subject.quantities.filter((q) => q.name !== state.x && q.name !== state.y).map((q) => {
      const {size, unit} = view.shown(q);
      return `${q.symbol} = ${text(state.values[q.name] * size, 6)}${unit ? ` ${unit}` : ""}`;
    });
    const law = subject.law ? `${subject.family}, ${subject.law} contact: ` : "";
    const units = state.si ? view.data.si.body : view.data.scale;
    return [[law + subject.title, ...held, units].filter((words) => words).join(", "),
      `Colour: largest growth rate (float). ${subject.hatching} Lines: boundaries (double precision).`];
  }

  svg() {
    this.save(new Blob([this.drawing().text], {type: "image/svg+xml"}), "svg");
  }

  async png() {
    const drawn = this.drawing(), {wide, high} = drawn, image = new Image();
    image.src = `data:image/svg+xml;charset=utf-8,${encodeURIComponent(drawn.text)}`;
    await image.decode();
    const canvas = element("canvas", {width: Math.round(DOTS * wide), height: Math.round(DOTS * high)});
    canvas.getContext("2d").drawImage(image, 0, 0, canvas.width, canvas.height);
    canvas.toBlob((blob) => this.save(blob, "png"), "image/png");
  }

  save(blob, ending) {
    const link = element("a", {href: URL.createObjectURL(blob), download: `${this.view.state.subject.replace(/\W+/g, "-")}.${ending}`});
    document.body.append(link);
    link.click();
    link.remove();
    setTimeout(() => URL.revokeObjectURL(link.href), 1000);
    this.say(`${ending.toUpperCase()} saved`);
  }
}

function inlined(from, to) {
  const style = getComputedStyle(from);
  for (const name of KEPT) to.style.setProperty(name, style.getPropertyValue(name));
  [...from.children].forEach((child, i) => inlined(child, to.children[i]));
}
