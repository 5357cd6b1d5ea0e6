// The stability diagram: coloured plane, boundary curves, axes, and the point under the hand.

import {boundaryCurves} from "../mathematics/boundaries.js";
import {palette, rateScale} from "../drawing/colours.js";
import {clamp, element, onceAFrame, shape, symbol, text} from "../drawing/elements.js";
import {axisTicks} from "../drawing/scales.js";
import {colourBar} from "./colour_bar.js";
import {handled} from "./hand.js";
import {regionNames} from "./region_names.js";
import {ranged} from "./view.js";

const MARGIN = {left: 56, right: 12, top: 10, bottom: 38};
const QUICK = 30; // milliseconds from frame to frame while something moves; otherwise it is coarser
const PAUSE = 400; // milliseconds after which a frame does not follow the last one
const CURVES = 8, LEAST_DETAIL = 0.15, MOVING_DETAIL = 0.5; // milliseconds for curves in motion, and their fineness
const COARSEST = 0.12, HATCHED = 2.5, LEAST_HATCHED = 0.55;
const DASHES = {static: "", flutter: "7 3", auxiliary: "1.5 3"};

export class Diagram {
  constructor(view, look) {
    this.view = view;
    this.look = look;
    this.share = 1; // resolution while something moves, adapted to the time of a frame
    this.detail = MOVING_DETAIL; // the same of boundary curves, adapted to their own time
    this.canvas = element("canvas", {"aria-hidden": "true"});
    this.over = shape("svg", {class: "over"});
    this.bar = shape("svg", {class: "bar", role: "img", "aria-label": "Colours of the growth rate"});
    this.stage = element("div", {
      class: "stage diagram-stage", tabindex: 0, role: "application",
      "aria-label": "Stability diagram. Arrow keys move the point, with Shift in larger steps; plus and minus zoom.",
      "aria-describedby": "stability-said",
    }, this.canvas, this.over);
    this.root = element("div", {class: "diagram"}, this.stage, this.bar);
    this.times = [];
    this.render = onceAFrame(() => this.draw());
    handled(this);
    new ResizeObserver(() => this.render()).observe(this.stage);
    view.on((changed) => {
      if (changed.has("subject")) this.share = Math.min(this.share, 0.5);
      this.moving = !changed.has("subject");
      this.render();
      clearTimeout(this.settle);
      this.settle = setTimeout(() => { this.moving = false; this.render(); }, 160);
    });
  }

  size() {
    const box = this.stage.getBoundingClientRect();
    return {width: Math.max(80, box.width - MARGIN.left - MARGIN.right),
      height: Math.max(80, box.height - MARGIN.top - MARGIN.bottom)};
  }

  /** Place of a value on the stage, in pixels. */
  pixel(x, y, [u, v]) {
    const {width, height} = this.size();
    return [MARGIN.left + x.place(u) * width, MARGIN.top + (1 - y.place(v)) * height];
  }

  /** Values under a place on the stage. */
  under(px, py) {
    const {width, height} = this.size(), x = this.view.axis("x"), y = this.view.axis("y");
    return {
      [x.name]: x.value(clamp((px - MARGIN.left) / width, 0, 1)),
      [y.name]: y.value(clamp(1 - (py - MARGIN.top) / height, 0, 1)),
    };
  }

  /** Show the ranges of the start again. */
  whole() {
    const ranges = {...this.view.state.ranges};
    for (const q of this.view.subject.quantities) ranges[q.name] = ranged([q.low, q.high], ranges[q.name][2]);
    this.view.set({ranges});
  }

  draw() {
    if (!this.stage.isConnected) return;
    const begun = performance.now(), {view} = this, colours = palette(this.look.dark());
    const x = view.axis("x"), y = view.axis("y"), {width, height} = this.size();
    const {most, whole} = this.looked(x, y);
    this.scale = rateScale(most);
    view.subject.hurry(this.moving && whole); // round a cusp the next member may lie on another branch
    this.colour(x, y, width, height, colours);
    this.bound(x, y);
    this.vectors(x, y, width, height);
    view.subject.hurry(false);
    colourBar(this.bar, this.scale, colours, view.subject.wholeEven, view.curve("growth rate"));
    this.pace(begun);
  }

  /** Boundary curves, coarser while something moves. */
  bound(x, y) {
    const {subject, state} = this.view, begun = performance.now();
    this.curves = boundaryCurves(subject, state.values, x, y, this.moving ? this.detail : 1);
    if (!this.moving) return;
    const took = Math.max(1, performance.now() - begun);
    this.detail = clamp(this.detail * Math.sqrt(CURVES / took), LEAST_DETAIL, MOVING_DETAIL);
  }

  /** Coarser or finer while something moves, by the time from frame to frame. */
  pace(begun) {
    const took = begun - this.begun;
    this.begun = begun;
    if (!this.moving || !(took < PAUSE)) return;
    this.times.push(took);
    if (this.times.length > 400) this.times.shift();
    this.share = clamp(this.share * (took > QUICK ? 0.8 : 1.08), COARSEST, 1);
  }

  /** Largest growth rate in size over a few points of the plane, and whether each has a member. */
  looked(x, y) {
    const {subject, state} = this.view, q = subject.array(state.values);
    const column = subject.names.indexOf(x.name), row = subject.names.indexOf(y.name);
    let most = 0, whole = true;
    for (let i = 0; i < 9; i++) {
      for (let j = 0; j < 7; j++) {
        q[column] = x.value((i + 0.5) / 9);
        q[row] = y.value((j + 0.5) / 7);
        const rate = Math.abs(subject.growth(q));
        if (Number.isFinite(rate)) most = Math.max(most, rate);
        else whole = false;
      }
    }
    return {most, whole};
  }

  colour(x, y, width, height, colours) {
    if (!this.raster) this.raster = this.look.raster(this.canvas);
    const share = this.moving ? this.share : 1, dense = Math.min(2, window.devicePixelRatio || 1);
    // hatching needs more points than growth rates, whose picture is smooth
    const ratio = this.raster.gl ? dense * clamp(HATCHED * share, LEAST_HATCHED, 1) : Math.min(1, share);
    const wide = Math.max(40, Math.round(width * ratio)), high = Math.max(40, Math.round(height * ratio));
    if (this.canvas.width !== wide) this.canvas.width = wide;
    if (this.canvas.height !== high) this.canvas.height = high;
    Object.assign(this.canvas.style, {left: `${MARGIN.left}px`, top: `${MARGIN.top}px`,
      width: `${width}px`, height: `${height}px`});
    this.raster.draw(this.view.subject, this.view.state.values, x, y, this.scale, colours, wide / width,
      (share * dense) / ratio);
  }

  vectors(x, y, width, height) {
    const {view} = this, {values} = view.state, quantity = view.subject.quantity;
    const [left, top] = [MARGIN.left, MARGIN.top], inside = [];
    const path = (points) => points.map((p) => this.pixel(x, y, p).map((v) => v.toFixed(2)).join(" ")).join("L");
    for (const curve of this.curves) inside.push(shape("path", {class: "halo", d: `M${path(curve.points)}`}));
    for (const curve of this.curves) {
      inside.push(shape("path", {class: `boundary ${curve.kind}`, d: `M${path(curve.points)}`,
        "stroke-dasharray": DASHES[curve.kind] || null}));
    }
    inside.push(...regionNames(view, x, y, width, height).map(([word, u, v]) => shape("text", {
      class: "region", x: left + u * width, y: top + (1 - v) * height}, word)));
    const [px, py] = this.pixel(x, y, [values[x.name], values[y.name]]);
    const shown = px >= left - 1 && px <= left + width + 1 && py >= top - 1 && py <= top + height + 1;
    const point = shown ? [
      shape("path", {class: "cross", d: `M${px} ${top}V${top + height}M${left} ${py}H${left + width}`}),
      shape("circle", {class: "point", cx: px, cy: py, r: 7}),
      shape("circle", {class: "dot", cx: px, cy: py, r: 2.2})] : [];
    const many = Math.max(3, Math.floor(width / 80)), rows = Math.max(3, Math.floor(height / 55));
    const axes = [shape("rect", {class: "frame", x: left, y: top, width, height})];
    const [qx, qy] = [quantity[x.name], quantity[y.name]], [sx, sy] = [qx, qy].map((q) => view.shown(q).size);
    for (const v of axisTicks(x, many, sx)) {
      const [at] = this.pixel(x, y, [v / sx, y.low]);
      axes.push(shape("path", {class: "tick", d: `M${at} ${top + height}v4`}),
        shape("text", {class: "number", x: at, y: top + height + 15, "text-anchor": "middle"}, text(v, 6)));
    }
    for (const v of axisTicks(y, rows, sy)) {
      const [, at] = this.pixel(x, y, [x.low, v / sy]);
      axes.push(shape("path", {class: "tick", d: `M${left} ${at}h-4`}),
        shape("text", {class: "number", x: left - 7, y: at + 3.5, "text-anchor": "end"}, text(v, 6)));
    }
    axes.push(shape("text", {class: "title", x: left + width / 2, y: top + height + 32, "text-anchor": "middle"},
      ...labelled(qx, view)));
    axes.push(shape("text", {class: "title", "text-anchor": "middle",
      transform: `translate(11 ${top + height / 2}) rotate(-90)`}, ...labelled(qy, view)));
    const clip = shape("clipPath", {id: this.look.id("clip")}, shape("rect", {x: left, y: top, width, height}));
    this.over.replaceChildren(shape("defs", {}, clip),
      shape("g", {"clip-path": `url(#${this.look.id("clip")})`}, ...inside, ...point), ...axes);
    const box = this.stage.getBoundingClientRect();
    this.over.setAttribute("viewBox", `0 0 ${box.width} ${box.height}`);
  }
}

function labelled(q, view) {
  const {unit} = view.shown(q);
  return [q.label ? `${q.label} ` : "", symbol(q.symbol, true), unit ? ` [${unit}]` : ""];
}
