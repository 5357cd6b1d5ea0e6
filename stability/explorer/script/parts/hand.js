// Mouse, touch and keyboard on the diagram: the point follows, two fingers or the wheel zoom.

import {ranged} from "./view.js";

const STEP = 0.01, LARGE = 10, SMALL = 0.1; // of the axis, for one arrow key

/** Let the hand work on a diagram. */
export function handled(diagram) {
  const {stage, view} = diagram, fingers = new Map();
  const local = (event) => {
    const box = stage.getBoundingClientRect();
    return [event.clientX - box.left, event.clientY - box.top];
  };
  const zoom = (factor, center) => {
    const ranges = {...view.state.ranges}, middle = diagram.under(...center);
    for (const which of ["x", "y"]) ranges[view.state[which]] = zoomed(view, which, middle, factor);
    view.set({ranges});
  };
  stage.addEventListener("pointerdown", (event) => {
    if (event.button > 0) return;
    stage.setPointerCapture(event.pointerId);
    fingers.set(event.pointerId, local(event));
    if (fingers.size === 1) view.move(diagram.under(...local(event)), view.state.x);
  });
  stage.addEventListener("pointermove", (event) => {
    if (!fingers.has(event.pointerId)) return;
    const old = [...fingers.values()];
    fingers.set(event.pointerId, local(event));
    const now = [...fingers.values()];
    if (now.length === 1) view.move(diagram.under(...now[0]));
    else if (now.length === 2) {
      const apart = ([a, b]) => Math.hypot(a[0] - b[0], a[1] - b[1]) || 1;
      const middle = [0, 1].map((i) => (now[0][i] + now[1][i]) / 2);
      zoom(apart(old) / apart(now), middle);
    }
  });
  for (const name of ["pointerup", "pointercancel"]) {
    stage.addEventListener(name, (event) => fingers.delete(event.pointerId));
  }
  stage.addEventListener("wheel", (event) => {
    event.preventDefault();
    zoom(Math.exp(Math.max(-0.3, Math.min(0.3, event.deltaY / 400))), local(event));
  }, {passive: false});
  stage.addEventListener("dblclick", () => diagram.whole());
  stage.addEventListener("keydown", (event) => {
    const size = STEP * (event.shiftKey ? LARGE : event.altKey ? SMALL : 1);
    const arrows = {ArrowRight: ["x", size], ArrowLeft: ["x", -size], ArrowUp: ["y", size], ArrowDown: ["y", -size]};
    const arrow = arrows[event.key];
    if (arrow) {
      const axis = view.axis(arrow[0]);
      view.move({[axis.name]: axis.value(axis.place(view.state.values[axis.name]) + arrow[1])}, axis.name);
    } else if (event.key === "+" || event.key === "=" || event.key === "-") {
      const {x, y} = view.state, v = view.state.values;
      zoom(event.key === "-" ? 1.25 : 0.8, diagram.pixel(view.axis("x"), view.axis("y"), [v[x], v[y]]));
    } else if (event.key === "0" || event.key === "Home") diagram.whole();
    else return;
    event.preventDefault();
  });
}

function zoomed(view, which, middle, factor) {
  const axis = view.axis(which), q = view.subject.quantity[axis.name], at = middle[axis.name];
  const place = axis.place(at);
  let low = axis.value(place * (1 - factor)), high = axis.value(place + (1 - place) * factor);
  const whole = q.high - q.low;
  if (high - low < 1e-6 * whole) return view.state.ranges[axis.name];
  const [least, most] = [q.least === null ? -20 * whole : q.least, q.most === null ? 20 * whole : q.most];
  low = Math.max(low, least + 1e-4 * whole * (q.least !== null));
  high = Math.min(high, most);
  return high > low ? ranged([low, high], axis.log ? "log" : "") : view.state.ranges[axis.name];
}
