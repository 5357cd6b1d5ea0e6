// The stability diagram: coloured plane, boundary curves, axes, and the point under the hand.

import {boundaryCurves} from "../mathematics/boundaries.js";
import {Rates} from "../mathematics/rates.js";
import {rateScale} from "../drawing/colours.js";
import {clamp, element, shape, text} from "../drawing/elements.js";
import {Fineness, Renewal, boxOf, onceAFrame, part, show, symbolPart} from "../drawing/redrawn.js";
import {axisTicks} from "../drawing/scales.js";
import {colourBar} from "./colour_bar.js";
import {handled} from "./hand.js";
import {regionCells, regionNames} from "./region_names.js";
import {ranged} from "./view.js";

const MARGIN = {left: 56, right: 12, top: 10, bottom: 38};
const RATES = 12, COARSEST = 0.05, MOVING_RATES = 0.5; // milliseconds for rates in motion, and their fineness
const QUICK = 30, PAUSE = 400; // milliseconds from frame to frame above which pixels are coarser; after which a frame does not follow
const COARSE_PIXELS = 0.55; // least share of the pixels in both directions; hatching needs as many
const SEEKING = 3, FEWEST = 0.12; // milliseconds for members that are solved for, and their fineness
const PASSES = [0.3, 1], SLICE = 10; // finer pictures at rest; milliseconds of a part of one, between which the page answers
const CURVES = 3, LEAST_DETAIL = 0.1, MOVING_DETAIL = 0.5; // milliseconds for curves in motion, and their fineness
const DASHES = {static: "", flutter: "7 3", auxiliary: "1.5 3"};

export class Diagram {
  constructor(view, look) {
    this.view = view;
    this.look = look;
    this.refining = null; // the timer of a fine picture in the making
    this.sharp = 1; // share of the pixels while something moves, adapted to the time of a frame
    this.renewal = new Renewal();
    this.curving = new Fineness(CURVES, LEAST_DETAIL, MOVING_DETAIL);
    this.rating = new Fineness(RATES, COARSEST, MOVING_RATES);
    this.seeking = new Fineness(SEEKING, FEWEST);
    this.canvas = element("canvas", {"aria-hidden": "true"});
    this.over = shape("svg", {class: "over"});
    this.bar = shape("svg", {class: "bar", role: "img", "aria-label": "Colours of the growth rate"});
    this.stage = element("div", {
      class: "stage diagram-stage", tabindex: 0, role: "application",
      "aria-label": "Stability diagram. Arrow keys move the point, with Shift in larger steps; plus and minus zoom.",
      "aria-describedby": "stability-said",
    }, this.canvas, this.over);
    this.root = element("div", {class: "diagram"}, this.stage, this.bar);
    this.render = onceAFrame(() => this.draw());
    this.box = boxOf(this.stage, this.render);
    this.barBox = boxOf(this.bar, this.render);
    handled(this);
    view.on(this.render);
  }

  size() {
    const box = this.box();
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
    const begun = performance.now(), {view} = this;
    const x = view.axis("x"), y = view.axis("y"), {width, height} = this.size();
    const content = this.content(x, y, width, height);
    if (this.renewal.due(content, view.moving)) {
      this.fill(x, y, width, height);
      this.pace(begun);
    }
    this.vectors(x, y, width, height);
  }

  /** What the picture under the point depends on: not on the place of the point on its two axes. */
  content(x, y, width, height) {
    const {subject, state} = this.view, held = subject.names.filter((n) => n !== x.name && n !== y.name);
    return JSON.stringify([subject.key, held.map((n) => state.values[n]), [x, y].map((a) => [a.name, a.low, a.high, a.log]),
      width, height, this.look.dark(), window.devicePixelRatio, state.si]);
  }

  /** Growth rates in colour, and boundary curves. */
  fill(x, y, width, height) {
    const {view} = this, {subject} = view, {most, whole} = this.looked(x, y), colours = this.look.tones();
    this.scale = rateScale(most);
    subject.hurry(view.moving && whole); // round a cusp the next member may lie on another branch
    this.colour(x, y, width, height, colours);
    const found = this.curving.spend(view.moving, (detail) => boundaryCurves(subject, view.state.values, x, y, detail));
    this.curves = found.curves;
    this.cells = regionCells(found.good);
    subject.hurry(false);
    colourBar(this.bar, this.barBox(), this.scale, colours, subject.wholeEven, view.curve("growth rate"));
  }

  /** Fewer or more pixels while something moves, by the time from frame to frame. */
  pace(begun) {
    const took = begun - this.begun;
    this.begun = begun;
    if (this.view.moving && took < PAUSE) this.sharp = clamp(this.sharp * (took > QUICK ? 0.8 : 1.08), COARSE_PIXELS, 1);
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

  /** A coarse picture at once; at rest then one with a rate for each pixel of the page, a part at a time. */
  colour(x, y, width, height, colours) {
    if (!this.raster) this.raster = this.look.raster(this.canvas);
    const {view, canvas} = this, {subject, state} = view, full = Math.min(2, window.devicePixelRatio || 1);
    const dense = view.moving ? full * this.sharp : full;
    const wide = Math.max(40, Math.round(width * dense)), high = Math.max(40, Math.round(height * dense));
    if (canvas.width !== wide) canvas.width = wide;
    if (canvas.height !== high) canvas.height = high;
    Object.assign(canvas.style, {left: `${MARGIN.left}px`, top: `${MARGIN.top}px`, width: `${width}px`, height: `${height}px`});
    clearTimeout(this.refining);
    this.refining = null;
    const grid = (fine, seek) => new Rates(subject, state.values, x, y, this.scale,
      [width, height].map((v) => Math.max(24, Math.round(fine * v))), seek);
    const draw = (rates) => this.raster.draw(rates, colours, wide / width);
    draw(this.rating.spend(true, (fine) => {
      const rates = grid(fine, (members) => this.seeking.spend(view.moving, members));
      rates.fill();
      return rates;
    }));
    if (view.moving) return;
    const passes = [...PASSES];
    let rates = null;
    const more = () => {
      if (!rates) rates = grid(passes.shift());
      if (rates.fill(performance.now() + SLICE)) {
        draw(rates);
        rates = null;
      }
      this.refining = rates || passes.length ? setTimeout(more) : null;
      if (!this.refining) view.tell(["fine"]);
    };
    this.refining = setTimeout(more);
  }

  /** Curves, names of regions, the point, and the axes. */
  vectors(x, y, width, height) {
    const {left, top} = MARGIN, box = this.box(), clip = this.look.id("clip");
    const path = (points) => points.map((p) => this.pixel(x, y, p).map((v) => v.toFixed(2)).join(" ")).join("L");
    const curves = this.curves.map((curve) => [curve.kind, `M${path(curve.points)}`]);
    const lines = [
      ...curves.map(([, d]) => part("path", {class: "halo", d})),
      ...curves.map(([kind, d]) => part("path", {class: `boundary ${kind}`, d, "stroke-dasharray": DASHES[kind] || null})),
    ];
    const names = regionNames(this.cells, this.view, x, y, width, height).map(([word, u, v]) => (
      part("text", {class: "region", x: left + u * width, y: top + (1 - v) * height}, word)));
    const within = part("clipPath", {id: clip}, part("rect", {x: left, y: top, width, height}));
    show(this.over, [part("defs", {}, within), part("g", {"clip-path": `url(#${clip})`},
      ...[lines, names, this.point(x, y, width, height)].map((parts) => part("g", {}, parts))),
    part("g", {}, this.axes(x, y, width, height))]);
    this.over.setAttribute("viewBox", `0 0 ${box.width} ${box.height}`);
  }

  point(x, y, width, height) {
    const {left, top} = MARGIN, {values} = this.view.state, [px, py] = this.pixel(x, y, [values[x.name], values[y.name]]);
    if (!(px >= left - 1 && px <= left + width + 1 && py >= top - 1 && py <= top + height + 1)) return [];
    return [
      part("path", {class: "cross", d: `M${px} ${top}V${top + height}M${left} ${py}H${left + width}`}),
      part("circle", {class: "point", cx: px, cy: py, r: 7}),
      part("circle", {class: "dot", cx: px, cy: py, r: 2.2})];
  }

  axes(x, y, width, height) {
    const {view} = this, {left, top} = MARGIN, {quantity} = view.subject, parts = [part("rect", {class: "frame", x: left, y: top, width, height})];
    const many = Math.max(3, Math.floor(width / 80)), rows = Math.max(3, Math.floor(height / 55));
    const [qx, qy] = [quantity[x.name], quantity[y.name]], [sx, sy] = [qx, qy].map((q) => view.shown(q).size);
    for (const v of axisTicks(x, many, sx)) {
      const [at] = this.pixel(x, y, [v / sx, y.low]);
      parts.push(part("path", {class: "tick", d: `M${at} ${top + height}v4`}),
        part("text", {class: "number", x: at, y: top + height + 15, "text-anchor": "middle"}, text(v, 6)));
    }
    for (const v of axisTicks(y, rows, sy)) {
      const [, at] = this.pixel(x, y, [x.low, v / sy]);
      parts.push(part("path", {class: "tick", d: `M${left} ${at}h-4`}),
        part("text", {class: "number", x: left - 7, y: at + 3.5, "text-anchor": "end"}, text(v, 6)));
    }
    parts.push(part("text", {class: "title", x: left + width / 2, y: top + height + 32, "text-anchor": "middle"},
      ...labelled(qx, view)));
    parts.push(part("text", {class: "title", "text-anchor": "middle",
      transform: `translate(11 ${top + height / 2}) rotate(-90)`}, ...labelled(qy, view)));
    return parts;
  }
}

function labelled(q, view) {
  const {unit} = view.shown(q);
  return [q.label ? `${q.label} ` : "", symbolPart(q.symbol), unit ? ` [${unit}]` : ""];
}
