// The plane of eigenvalues, with the paths that they take while one quantity runs.

import {element, shape, text} from "../drawing/elements.js";
import {Fineness, Renewal, boxOf, onceAFrame, part, show} from "../drawing/redrawn.js";
import {axisOf, ticks} from "../drawing/scales.js";

const SAMPLES = 140, FINER = 9; // values along a path; halvings between two of them where it turns
const LONGEST = 0.03, FINEST = 600; // step of a path over the plane; halvings of all steps together
const PATHS = 3, LEAST_PATHS = 0.25; // milliseconds for paths in motion, and their least fineness
const MARGIN = {left: 8, right: 8, top: 8, bottom: 18};
const LEAST = 1e-6; // below it all eigenvalues count as zero, and the plane shows the unit of rates
const NEAR = 22; // pixels within which a tap chooses an eigenvalue

export class EigenvaluePlane {
  constructor(view) {
    this.view = view;
    this.drawing = shape("svg", {class: "plane", role: "img", "aria-label": "Eigenvalues in the complex plane"});
    this.choice = element("select", {"aria-label": "Quantity whose change moves the eigenvalues along their paths",
      onchange: () => view.set({along: this.choice.value})});
    this.root = element("div", {class: "plane-box"}, this.drawing,
      element("label", {class: "small along"}, "Eigenvalues λ (float: double precision); paths: λ while ", this.choice, " runs"));
    this.drawing.addEventListener("click", (event) => this.pick(event));
    this.render = onceAFrame(() => this.draw());
    this.box = boxOf(this.drawing, this.render);
    this.renewal = new Renewal();
    this.tracing = new Fineness(PATHS, LEAST_PATHS);
    view.on(() => this.render());
  }

  draw() {
    const box = this.box();
    if (!box.width) return;
    const {view} = this, {subject, state} = view, now = subject.eigenvalues(view.point()).filter((z) => Number.isFinite(z[0] + z[1]));
    this.offer();
    const [reach, tall] = this.extent(now), paths = this.kept(reach, tall);
    const {left, right, top, bottom} = MARGIN;
    const width = box.width - left - right, height = box.height - top - bottom;
    this.place = ([re, im]) => [left + width * (0.5 + re / (2 * reach)), top + height * (0.5 - im / (2 * tall))];
    this.now = now;
    const {size, unit} = view.curve("growth rate"), named = (word) => (view.state.si ? `${word} [${unit}]` : word);
    const [ox, oy] = this.place([0, 0]), words = [], parts = [
      part("rect", {class: "growing", x: ox, y: top, width: left + width - ox, height}),
      part("rect", {class: "decaying", x: left, y: top, width: ox - left, height}),
    ];
    for (const rate of ticks(-reach * size, reach * size, 5)) {
      const v = rate / size, [x] = this.place([v, 0]);
      if (v !== 0) parts.push(part("path", {class: "grid", d: `M${x} ${top}v${height}`}));
      if (Math.abs(v) < 0.93 * reach) words.push(part("text", {class: "number", x, y: box.height - 5, "text-anchor": "middle"}, text(rate, 3)));
    }
    for (const rate of ticks(-tall * size, tall * size, 4)) {
      const v = rate / size, [, y] = this.place([0, v]);
      if (v === 0 || Math.abs(v) > 0.93 * tall) continue;
      parts.push(part("path", {class: "grid", d: `M${left} ${y}h${width}`}));
      words.push(part("text", {class: "number", x: left + 3, y: y - 2}, `${text(rate, 3)} i`));
    }
    parts.push(part("path", {class: "axis", d: `M${left} ${oy}h${width}M${ox} ${top}v${height}`}));
    words.push(part("text", {class: "number", x: left + width - 3, y: oy - 4, "text-anchor": "end"}, named("Re λ")),
      part("text", {class: "number", x: ox + 4, y: top + 10}, named("Im λ")));
    for (const path of paths) {
      for (const piece of this.inside(path, reach, tall)) {
        parts.push(part("path", {class: "locus", d: `M${piece.map((z) => this.place(z).map((v) => v.toFixed(1)).join(" ")).join("L")}`}));
      }
    }
    parts.push(...words);
    const chosen = state.mode === null ? null : this.shown(now)[state.mode];
    for (const z of now) {
      const [x, y] = this.place(z), own = chosen && z[0] === chosen[0] && Math.abs(z[1]) === Math.abs(chosen[1]);
      parts.push(part("circle", {class: `value ${z[0] > 1e-12 ? "grows" : "decays"}${own ? " chosen" : ""}`,
        cx: x, cy: y, r: own ? 6.5 : 4.5}));
    }
    this.drawing.setAttribute("viewBox", `0 0 ${box.width} ${box.height}`);
    show(this.drawing, parts);
  }

  offer() {
    const {subject, state} = this.view, names = subject.names.join();
    if (this.offered !== names + subject.key) {
      this.offered = names + subject.key;
      this.choice.replaceChildren(...subject.quantities.map((q) => element("option", {value: q.name}, q.symbol.replace("_", ""))));
    }
    this.choice.value = state.along;
  }

  /** One of each pair, as in the list of modes. */
  shown(all) {
    return all.filter((z) => z[1] >= 0).reverse();
  }

  /** Half width and half height, in round numbers that do not change with every point. */
  extent(now) {
    const round = (v) => {
      const power = 10 ** Math.floor(Math.log10(v)), share = v / power;
      return ([1, 1.5, 2, 3, 4, 6, 8].find((s) => s >= share * 0.999) || 10) * power;
    };
    const size = Math.max(0, ...now.map((z) => Math.hypot(...z))), most = size > LEAST ? size : 1;
    return [0, 1].map((i) => round(1.15 * Math.max(...now.map((z) => Math.abs(z[i])), 0.2 * most)));
  }

  /** The paths, computed again where something else than the running quantity has changed, or was in motion. */
  kept(reach, tall) {
    const {subject, state, moving} = this.view, held = subject.names.filter((n) => n !== state.along).map((n) => state.values[n]);
    const content = JSON.stringify([subject.key, state.along, state.ranges[state.along], held, reach, tall]);
    if (this.renewal.due(content, moving)) {
      this.traced = this.tracing.spend(moving, (share) => this.paths(reach, tall, share));
    }
    return this.traced;
  }

  /** Eigenvalues while the quantity runs, in steps that are short wherever a path can be seen. */
  paths(reach, tall, share) {
    const {subject, state} = this.view, axis = axisOf(state, state.along), at = {...state.values};
    const seen = (z) => Math.abs(z[0]) < 1.02 * reach && Math.abs(z[1]) < 1.02 * tall;
    const apart = (a, b) => (seen(a) || seen(b) ? Math.hypot((a[0] - b[0]) / reach, (a[1] - b[1]) / tall) / 2 : 0);
    const values = (u) => {
      at[state.along] = axis.value(u);
      const found = subject.eigenvalues(subject.array(at));
      return found.every((z) => Number.isFinite(z[0] + z[1])) ? found : null;
    };
    const paths = [];
    const samples = Math.round(share * SAMPLES);
    let last = null, u = 0, more = share * FINEST;
    const step = (to, found, depth) => {
      if (found && last && last.length === found.length) {
        const next = nearest(last.map((p) => p[p.length - 1]), found);
        const turns = last.some((p, i) => apart(p[p.length - 1], found[next[i]]) > LONGEST);
        if (turns && depth < FINER && more-- > 0) {
          const middle = (u + to) / 2;
          step(middle, values(middle), depth + 1);
          step(to, found, depth + 1);
          return;
        }
        next.forEach((j, i) => last[i].push(found[j]));
      } else {
        last = found && found.map((z) => { const path = [z]; paths.push(path); return path; });
      }
      u = to;
    };
    for (let n = 0; n <= samples; n++) step(n / samples, values(n / samples), 0);
    return paths;
  }

  /** The pieces of a path within sight, a little more on each side. */
  inside(path, reach, tall) {
    const pieces = [];
    let piece = [];
    for (const z of path) {
      if (Math.abs(z[0]) < 1.02 * reach && Math.abs(z[1]) < 1.02 * tall) piece.push(z);
      else { if (piece.length > 1) pieces.push(piece); piece = []; }
    }
    if (piece.length > 1) pieces.push(piece);
    return pieces;
  }

  pick(event) {
    const box = this.drawing.getBoundingClientRect(), x = event.clientX - box.left, y = event.clientY - box.top;
    let best = null, gap = NEAR;
    for (const z of this.now) {
      const [a, b] = this.place(z), apart = Math.hypot(a - x, b - y);
      if (apart < gap) [best, gap] = [z, apart];
    }
    if (!best) return;
    const index = this.shown(this.now).findIndex((z) => z[0] === best[0] && z[1] === Math.abs(best[1]));
    this.view.set({mode: index, show: "mode"});
  }
}

/** For each of the old values the index of its successor: nearest pairs first. */
function nearest(old, found) {
  const pairs = old.flatMap((a, i) => found.map((b, j) => [Math.hypot(a[0] - b[0], a[1] - b[1]), i, j]));
  const from = new Array(old.length).fill(-1), taken = new Set();
  for (const [, i, j] of pairs.sort((p, q) => p[0] - q[0])) {
    if (from[i] < 0 && !taken.has(j)) { from[i] = j; taken.add(j); }
  }
  return from;
}
