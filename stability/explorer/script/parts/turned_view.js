// What every picture of the disk shares: where its parts are, and the hand that turns the view.

import {element} from "../drawing/elements.js";
import {boxOf} from "../drawing/redrawn.js";
import {fromSource} from "../mathematics/subject.js";

const ROWS = 60, END = 1e-9, HALF = 0.55; // points of a meridian; distance from its ends; beyond upright [rad]

const RAISED = 0.004; // of the path over the plane, so that it is seen

const THIN = 0.93; // largest inner radius of a disk that is drawn

/** Where the parts of a body are in space, from the twelve numbers of its place. */
export function placed(frame) {
  const [axis, mark, centre, contact] = [0, 3, 6, 9].map((n) => frame.slice(n, n + 3));
  const side = [0, 1, 2].map((i) => axis[(i + 1) % 3] * mark[(i + 2) % 3] - axis[(i + 2) % 3] * mark[(i + 1) % 3]);
  return {mark, side, axis, centre, contact: [contact[0], contact[1], RAISED]};
}

/** The closed surface of a body of revolution: rows [r, place along the axis, inclination] of its meridian. */
export function surface({point, low, high}, p) {
  const at = (theta) => { const [r, z] = fromSource(point)([theta], p); return [Math.max(0, r), z, theta]; };
  const rows = Array.from({length: ROWS + 1}, (_, i) => at(low + END + ((high - low - 2 * END) * i) / ROWS));
  // a height up to upright is that of a body with equal halves
  if (high < Math.PI / 2 + HALF) rows.push(...rows.map(([r, z, theta]) => [r, -z, Math.PI - theta]).reverse());
  const last = rows[rows.length - 1], most = Math.max(...rows.map(([r]) => r));
  if (last[0] > 1e-6 * most) return [[0, rows[0][1], 0], ...rows, [0, last[1], Math.PI]]; // flat ends
  return rows;
}

/** Inner radius of the ring that has an inertia factor, as it is drawn; 0 for a disk. */
export function innerRadius(k) {
  return Math.min(THIN, Math.sqrt(Math.max(0, 4 * k - 1)));
}

/** Largest distance of a surface from its centre, at least so large that the eye keeps away from it; 1 for a disk. */
export function sizeOf(rows) {
  return rows ? Math.max(0.5, ...rows.map(([r, z]) => Math.hypot(r, z))) : 1;
}

/** A canvas that is looked at from an angle, which drag, pinch and keys change. */
export class TurnedView {
  constructor() {
    this.canvas = element("canvas", {role: "application", tabindex: 0,
      "aria-label": "The body on the plane; drag, or use the arrow keys, to look from another side"});
    this.angle = {azimuth: 0.75, height: 0.36, away: 5.6};
    this.target = [0, 0];
    this.box = boxOf(this.canvas, () => this.changed && this.changed());
    this.turned();
  }

  /** Where the eye is, and the point of the axis that it looks at, while the view follows the centre of a body. */
  eye(centre, size) {
    const [x, y] = this.follow(centre), {azimuth, height} = this.angle, away = size * this.angle.away, middle = 0.8 * size;
    const level = away * Math.cos(height);
    return {at: [x + level * Math.cos(azimuth), y + level * Math.sin(azimuth), middle + away * Math.sin(height)], to: [x, y, middle]};
  }

  /** Let the view follow the centre of the body, smoothly. */
  follow(centre) {
    this.target = this.target.map((v, i) => v + 0.25 * (centre[i] - v));
    if (Math.hypot(this.target[0] - centre[0], this.target[1] - centre[1]) > 1) this.target = centre.slice(0, 2);
    return this.target;
  }

  /** Look from an angle further, within what can be seen. */
  look(azimuth, height, away = 1) {
    this.angle.azimuth += azimuth;
    this.angle.height = Math.min(1.5, Math.max(0.05, this.angle.height + height));
    this.angle.away = Math.min(14, Math.max(2.4, this.angle.away * away));
    if (this.changed) this.changed();
  }

  /** Drag to turn, pinch to come nearer; arrow keys, plus and minus. */
  turned() {
    this.canvas.addEventListener("keydown", (event) => {
      const by = {ArrowLeft: [-0.1, 0], ArrowRight: [0.1, 0], ArrowUp: [0, 0.07], ArrowDown: [0, -0.07],
        "+": [0, 0, 0.88], "-": [0, 0, 1.14]}[event.key];
      if (!by) return;
      this.look(...by);
      event.preventDefault();
    });
    const fingers = new Map();
    this.canvas.addEventListener("pointerdown", (event) => {
      this.canvas.setPointerCapture(event.pointerId);
      fingers.set(event.pointerId, [event.clientX, event.clientY]);
    });
    this.canvas.addEventListener("pointermove", (event) => {
      const old = fingers.get(event.pointerId);
      if (!old) return;
      const before = spread(fingers);
      fingers.set(event.pointerId, [event.clientX, event.clientY]);
      if (fingers.size === 2) this.look(0, 0, before / (spread(fingers) || 1));
      else this.look(-0.009 * (event.clientX - old[0]), 0.007 * (event.clientY - old[1]));
    });
    for (const name of ["pointerup", "pointercancel"]) {
      this.canvas.addEventListener(name, (event) => fingers.delete(event.pointerId));
    }
  }
}

function spread(fingers) {
  const [a, b] = [...fingers.values()];
  return b ? Math.hypot(a[0] - b[0], a[1] - b[1]) : 1;
}
