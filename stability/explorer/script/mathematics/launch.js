// A launch from a tilted steady motion, and the pose of a body that moves in one mode.

import {integrate} from "./integrator.js";
import {fromSource} from "./subject.js";

const SAMPLES = 1201;
const CALM = 1e-6; // largest rate of a state of a steady motion, and largest speed of a body at rest
const PLACES = /^(theta|axis_)/; // states of a body that are no speeds
const LONGEST = 1.5; // seconds of computing after which a launch is shown as far as it came

/** The start of a launch: the states of the motion, the first one (the angle) less the tilt, as `launch` gives it. */
export function startOf(subject, motion, q, tilt) {
  if (subject.start) return fromSource(subject.start)(q, [-(tilt[0] || 0)]);
  const states = subject.steady(q), y = new Array(motion.names.length).fill(0);
  states.slice(0, motion.states).forEach((v, i) => { y[i] = v; });
  tilt.forEach((by, i) => { y[i] += by; });
  return y;
}

/** Run a launch; outcome is the name of the guard that ended it, or `moving`. */
export function launched(subject, motion, q, tilt, until, options = {}) {
  const p = [...subject.parameters.map((i) => q[i]), ...motion.more];
  const f = fromSource(motion.rates), g = fromSource(motion.guard), observe = fromSource(motion.observe);
  const rates = (y) => f(y, p), guards = (y) => g(y, p);
  const start = options.start || startOf(subject, motion, q, tilt);
  const failed = guards(start).findIndex((g) => !(g > 0));
  if (failed >= 0 || !rates(start).every(Number.isFinite)) {
    return {outcome: motion.guards[failed] || "undefined", refused: true, times: [], states: [], until: 0};
  }
  const times = options.times || Array.from({length: SAMPLES}, (_, i) => (until * i) / (SAMPLES - 1));
  const run = integrate(rates, guards, start, times, {seconds: LONGEST, ...options});
  const outcome = run.stopped ? "unresolved" : run.end ? motion.guards[run.end.guard] : "moving";
  const kept = times.slice(0, run.states.length), states = [...run.states];
  if (run.end) { kept.push(run.end.time); states.push(run.end.state); }
  const seen = states.map((y) => observe(y, p));
  const series = Object.fromEntries(motion.observed.map((name, i) => [name, seen.map((v) => v[i])]));
  return {outcome, calm: outcome === "moving" ? calm(subject, motion, run.state, rates(run.state)) : "", times: kept, states, series,
    until: run.time, final: run.state, steps: run.steps, refused: false, p};
}

/** Whether a state is one at `rest` (of a body) or `steady`; empty where it changes. */
function calm(subject, motion, state, rates) {
  if (rates.slice(0, motion.states).some((rate) => !(Math.abs(rate) < CALM))) return "";
  const speeds = motion.names.slice(0, motion.states).map((name, i) => (PLACES.test(name) ? 0 : Math.abs(state[i])));
  return subject.pose && speeds.every((speed) => speed < CALM) ? "rest" : "steady";
}

/** Place of the body at a time of a launch, between two samples: axis, mark, centre, contact point. */
export function poseAt(run, motion, t) {
  const {times, states} = run, i = before(times, t), j = Math.min(i + 1, times.length - 1);
  const u = times[j] > times[i] ? Math.min(1, Math.max(0, (t - times[i]) / (times[j] - times[i]))) : 0;
  return fromSource(motion.frame)(Array.from(states[i], (v, n) => (1 - u) * v + u * states[j][n]), run.p);
}

export function before(times, t) {
  let low = 0, high = times.length - 1;
  while (low < high) {
    const middle = (low + high + 1) >> 1;
    if (times[middle] <= t) low = middle; else high = middle - 1;
  }
  return low;
}

const MODE_SAMPLES = 900, VISIBLE = 0.22; // largest tilt of the picture of a mode [rad]

/**
 * The linear motion of one mode, large enough to be seen: {times, poses, size}.
 * The largest entry of the tilt is VISIBLE; the mode grows or decays as its eigenvalue says.
 */
export function modeMotion(subject, q, eigenvalue) {
  const {states, p} = subject.linearised(q), vector = subject.mode(q, eigenvalue);
  const [re, im] = eigenvalue, pace = Math.max(Math.abs(im), Math.abs(re), 0.05);
  const until = Math.min(40, Math.max(4, (im !== 0 ? 3 * 2 * Math.PI : 4) / pace));
  const growth = Math.exp(Math.max(0, re * until)), tilt = Math.hypot(...vector[0], ...(subject.still.length > 4 ? vector[1] : []));
  const speeds = Math.max(...vector.map((v) => Math.hypot(...v)));
  const size = Math.min(VISIBLE / Math.max(tilt, 1e-9), 1.0 / speeds) / growth;
  const at = (t) => {
    const e = size * Math.exp(re * t), c = Math.cos(im * t), s = Math.sin(im * t);
    return states.map((v, i) => v + e * (vector[i][0] * c - vector[i][1] * s));
  };
  const pose = fromSource(subject.pose), frame = fromSource(subject.frame), h = until / (MODE_SAMPLES - 1);
  let y = [...subject.still];
  const times = [], poses = [];
  for (let i = 0; i < MODE_SAMPLES; i++) {
    const t = i * h, x = at(t);
    times.push(t);
    poses.push(frame(x, p, y));
    const rate = (s, z) => pose(at(s), p, z);
    const a = rate(t, y), b = rate(t + h / 2, y.map((v, j) => v + (h / 2) * a[j]));
    const c = rate(t + h / 2, y.map((v, j) => v + (h / 2) * b[j])), d = rate(t + h, y.map((v, j) => v + h * c[j]));
    y = y.map((v, j) => v + (h / 6) * (a[j] + 2 * b[j] + 2 * c[j] + d[j]));
  }
  return {times, poses, until, vector, size};
}
