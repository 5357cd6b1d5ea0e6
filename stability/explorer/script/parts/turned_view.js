// What every picture of the disk shares: where its parts are, and the hand that turns the view.

import {element} from "../drawing/elements.js";

/** Where the parts of the disk are in space, for a pose. */
export function placed({theta, phi, psi, x, y}) {
  const [ct, st, cp, sp] = [Math.cos(theta), Math.sin(theta), Math.cos(phi), Math.sin(phi)];
  const towards = [ct * cp, ct * sp, -st], along = [-sp, cp, 0], axis = [st * cp, st * sp, ct];
  const [c, s] = [Math.cos(psi), Math.sin(psi)], centre = [x, y, st];
  const mark = towards.map((v, i) => c * v + s * along[i]), side = towards.map((v, i) => c * along[i] - s * v);
  return {mark, side, axis, centre, contact: [x + towards[0], y + towards[1], 0.004]};
}

/** A canvas that is looked at from an angle, which drag, pinch and keys change. */
export class TurnedView {
  constructor() {
    this.canvas = element("canvas", {role: "application", tabindex: 0,
      "aria-label": "The disk on the plane; drag, or use the arrow keys, to look from elsewhere"});
    this.angle = {azimuth: 0.75, height: 0.36, away: 5.6};
    this.target = [0, 0];
    this.turned();
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
