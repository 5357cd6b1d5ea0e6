// Motions of a system by its states: the linear motion of one mode, and the steady motion, as curves over time.

import {startOf} from "./launch.js";
import {fromSource} from "./subject.js";

const SAMPLES = 1201, PERIODS = 3, FOLDS = 6; // samples of a curve; its length, by the shorter of both
const NOTHING = 1e-9; // share of the largest component that is rounding
const TIE = 1e-6; // sizes that differ by less count as equal: the first of them has phase 0
const SLOW = 1e-9; // change over the usual span of time that cannot be seen

/** One eigenvalue of each pair, as the list of modes has them. */
export function modesAt(subject, q) {
  return subject.eigenvalues(q).filter((z) => z[1] >= 0).reverse();
}

/** Each component of a vector over the largest one, which has size 1 and phase 0; degrees. */
export function components(vector) {
  const sizes = vector.map((v) => Math.hypot(...v)), most = Math.max(...sizes);
  const largest = sizes.findIndex((s) => s >= (1 - TIE) * most), [a, b] = vector[largest];
  return vector.map(([re, im], i) => {
    const size = sizes[i] / sizes[largest];
    if (!(size > NOTHING)) return {size: 0, phase: 0};
    return {size, phase: (Math.atan2(im * a - re * b, re * a + im * b) * 180) / Math.PI};
  });
}

/** Length of the curves of a mode, and how many periods or e-folding times that is. */
function lengthOf([re, im], usual) {
  const fold = 1 / Math.abs(re), period = (2 * Math.PI) / Math.abs(im);
  if (Math.hypot(re, im) * usual < SLOW) return {until: usual, count: 0, each: ""};
  if (PERIODS * period <= FOLDS * fold) return {until: PERIODS * period, count: PERIODS, each: "periods"};
  return {until: FOLDS * fold, count: FOLDS, each: "e-folding times"};
}

/**
 * The linear motion x(t) = steady + amplitude · Re(v exp(λ t)), the largest component of v being 1:
 * {times, states, until, parts, factor, …}; a component that is rounding stands still. `usual` is the span of time of a mode that stands still.
 */
export function modeCurves(subject, q, eigenvalue, amplitude, usual) {
  const [re, im] = eigenvalue, steady = subject.steady(q), parts = components(subject.mode(q, eigenvalue));
  const length = lengthOf(eigenvalue, usual), {until} = length;
  const turns = parts.map(({phase}) => (phase * Math.PI) / 180);
  const times = Array.from({length: SAMPLES}, (_, i) => (until * i) / (SAMPLES - 1));
  const states = times.map((t) => {
    const size = amplitude * Math.exp(re * t);
    return steady.map((v, j) => v + size * parts[j].size * Math.cos(im * t + turns[j]));
  });
  return {...length, linear: true, times, states, steady, parts, eigenvalue, factor: Math.exp(re * until)};
}

/** The steady motion over a span of time, with its observables. */
export function steadyCurves(subject, motion, q, until) {
  const steady = subject.steady(q), p = [...subject.parameters.map((i) => q[i]), ...motion.more];
  const seen = fromSource(motion.observe)(startOf(subject, motion, q, []), p);
  return {times: [0, until], states: [steady, steady], until,
    series: Object.fromEntries(motion.observed.map((name, i) => [name, [seen[i], seen[i]]]))};
}
