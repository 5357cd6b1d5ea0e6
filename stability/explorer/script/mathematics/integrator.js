// DOP853 with step control, dense output, and guards that end the motion where one reaches zero.

import {DENSE, ERROR_FIFTH, ERROR_THIRD, EXTRA_STAGES, STAGES, WEIGHTS} from "./tableau.js";

const LOOKS = 8; // places within a step at which guards are looked at
const COUNT = WEIGHTS.length;

/** One step of size h from y, whose rate is k[0]: the new state and the stages. */
function stepped(rates, y, h, first) {
  const n = y.length, k = [first];
  const at = (row) => {
    const z = new Float64Array(n);
    for (let i = 0; i < n; i++) {
      let sum = 0;
      for (let s = 0; s < row.length; s++) if (row[s] !== 0) sum += row[s] * k[s][i];
      z[i] = y[i] + h * sum;
    }
    return z;
  };
  for (let s = 1; s < COUNT; s++) k.push(rates(at(STAGES[s])));
  const next = at(WEIGHTS);
  k.push(rates(next));
  return {next, k};
}

function errorNorm(k, h, y, next, tolerance) {
  let third = 0, fifth = 0;
  for (let i = 0; i < y.length; i++) {
    const scale = tolerance * (1 + Math.max(Math.abs(y[i]), Math.abs(next[i])));
    let a = 0, b = 0;
    for (let s = 0; s <= COUNT; s++) {
      a += ERROR_THIRD[s] * k[s][i];
      b += ERROR_FIFTH[s] * k[s][i];
    }
    third += (a / scale) ** 2;
    fifth += (b / scale) ** 2;
  }
  if (fifth === 0 && third === 0) return 0;
  return (Math.abs(h) * fifth) / Math.sqrt((fifth + 0.01 * third) * y.length);
}

/** A function of u in [0, 1] along a step. */
function denseOutput(rates, y, next, h, k) {
  const n = y.length, all = [...k];
  for (const row of EXTRA_STAGES) {
    const z = new Float64Array(n);
    for (let i = 0; i < n; i++) {
      let sum = 0;
      for (let s = 0; s < row.length; s++) sum += row[s] * all[s][i];
      z[i] = y[i] + h * sum;
    }
    all.push(rates(z));
  }
  const parts = [];
  for (let i = 0; i < n; i++) {
    const delta = next[i] - y[i];
    const own = [delta, h * k[0][i] - delta, 2 * delta - h * (k[COUNT][i] + k[0][i])];
    for (const row of DENSE) {
      let sum = 0;
      for (let s = 0; s < row.length; s++) sum += row[s] * all[s][i];
      own.push(h * sum);
    }
    parts.push(own);
  }
  return (u) => {
    const out = new Float64Array(n);
    for (let i = 0; i < n; i++) {
      let sum = 0;
      for (let m = 6; m >= 0; m--) sum = (sum + parts[i][m]) * ((6 - m) % 2 === 0 ? u : 1 - u);
      out[i] = y[i] + sum;
    }
    return out;
  };
}

/**
 * Integrate from `start` to the last of `times`, or to the first zero of a guard.
 * Returns {states, end: null | {time, state, guard}, steps, stopped}.
 */
export function integrate(rates, guards, start, times, options = {}) {
  const {tolerance = 1e-12, mostSteps = 100000, seconds = Infinity} = options;
  const last = times[times.length - 1], begun = performance.now();
  let t = times[0], y = Float64Array.from(start), k0 = rates(y);
  let h = Math.min(1e-2, last - t), steps = 0, index = 0;
  const states = [];
  while (index < times.length && times[index] <= t) { states.push(y); index++; }
  while (t < last) {
    if (steps++ > mostSteps || performance.now() - begun > 1000 * seconds || h < 1e-13) {
      return {states, end: null, steps, stopped: true, time: t, state: y};
    }
    h = Math.min(h, last - t);
    const {next, k} = stepped(rates, y, h, k0), error = errorNorm(k, h, y, next, tolerance);
    if (!(error < 1)) {
      h *= Number.isFinite(error) ? Math.max(0.2, 0.9 * error ** -0.125) : 0.2;
      continue;
    }
    const along = denseOutput(rates, y, next, h, k);
    const crossing = firstCrossing(guards, along, next);
    if (crossing) {
      const end = located(rates, guards, y, h, k0, crossing);
      while (index < times.length && times[index] <= t + end.h) {
        states.push(along((times[index] - t) / h));
        index++;
      }
      return {states, end: {time: t + end.h, state: end.state, guard: crossing.guard}, steps,
        stopped: false, time: t + end.h, state: end.state};
    }
    while (index < times.length && times[index] <= t + h) {
      states.push(times[index] === t + h ? next : along((times[index] - t) / h));
      index++;
    }
    t = last - (t + h) < 1e-14 * Math.abs(last) ? last : t + h;
    y = next;
    k0 = k[COUNT];
    h *= error === 0 ? 10 : Math.min(6, 0.9 * error ** -0.125);
  }
  while (index < times.length) { states.push(y); index++; }
  return {states, end: null, steps, stopped: false, time: t, state: y};
}

/** The first guard that is not positive along a step, and an interval in which it fails. */
function firstCrossing(guards, along, next) {
  let before = 0, values = guards(along(0));
  for (let look = 1; look <= LOOKS; look++) {
    const u = look / LOOKS, here = guards(look === LOOKS ? next : along(u));
    const failed = here.findIndex((g) => !(g > 0));
    if (failed >= 0) return {guard: failed, low: before, high: u};
    const dip = lowest(guards, along, before, u, values, here);
    if (dip) return dip;
    [before, values] = [u, here];
  }
  return null;
}

/** A guard that dips below zero between two looks: its minimum by golden section. */
function lowest(guards, along, a, b, left, right) {
  for (let g = 0; g < left.length; g++) {
    const tiny = 1e-3 * (b - a), inner = guards(along(a + tiny))[g], outer = guards(along(b - tiny))[g];
    if (!(inner < left[g] && outer < right[g])) continue;
    let low = a, high = b;
    for (let n = 0; n < 20; n++) {
      const p = low + 0.382 * (high - low), q = low + 0.618 * (high - low);
      if (guards(along(p))[g] < guards(along(q))[g]) high = q; else low = p;
    }
    const u = (low + high) / 2;
    if (!(guards(along(u))[g] > 0)) return {guard: g, low: a, high: u};
  }
  return null;
}

/** The zero of a guard by steps of varied size, so that its time has the order of the method. */
function located(rates, guards, y, h, first, {guard, low, high}) {
  const value = (u) => guards(stepped(rates, y, u * h, first).next)[guard];
  let a = low, b = high, fa = value(a), fb = value(b);
  if (!(fa > 0)) a = 0;
  for (let n = 0; n < 60 && b - a > 1e-15; n++) {
    const secant = a + ((b - a) * fa) / (fa - fb);
    const u = n % 3 === 2 || !(secant > a && secant < b) ? (a + b) / 2 : secant;
    const f = value(u);
    if (f > 0) [a, fa] = [u, f]; else [b, fb] = [u, f];
    if (f === 0) break;
  }
  return {h: b * h, state: stepped(rates, y, b * h, first).next};
}
