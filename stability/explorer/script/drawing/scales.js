// Axes: values over the unit interval, and ticks at round numbers.

/** An axis of a diagram; `spacing` is "log" for even steps in the logarithm, from a positive end. */
export function axisScale(name, low, high, spacing) {
  const log = spacing === "log" && low > 0;
  return {
    name, low, high, log,
    value: log ? (u) => low * (high / low) ** u : (u) => low + u * (high - low),
    place: log ? (v) => Math.log(v / low) / Math.log(high / low) : (v) => (v - low) / (high - low),
  };
}

/** The axis of a quantity in a state of the page. */
export function axisOf(state, name) {
  return axisScale(name, ...state.ranges[name]);
}

/** About `count` round numbers on an axis whose values are shown times `size`. */
export function axisTicks(axis, count, size = 1) {
  const [low, high, log] = [axis.low * size, axis.high * size, axis.log];
  const decades = log ? Math.log10(high / low) : 0;
  if (decades < 1) return ticks(low, high, count);
  const sizes = 2 * decades <= count ? [1, 2, 5] : [1], stride = Math.ceil(decades / count), found = [];
  for (let n = Math.floor(Math.log10(low)); n <= Math.log10(high); n += stride) {
    for (const s of sizes) found.push(Number((s * 10 ** n).toPrecision(12)));
  }
  return found.filter((v) => v >= low * (1 - 1e-9) && v <= high * (1 + 1e-9));
}

/** About `count` round numbers between two ends. */
export function ticks(low, high, count) {
  const raw = (high - low) / Math.max(1, count), power = 10 ** Math.floor(Math.log10(raw));
  const step = [1, 2, 2.5, 5, 10].map((s) => s * power).find((s) => s >= raw * 0.999) || 10 * power;
  const found = [];
  for (let n = Math.ceil(low / step - 1e-9); n * step <= high + 1e-9 * step; n++) {
    found.push(Number((n * step).toPrecision(12)));
  }
  return found;
}

/** Ticks of a symmetric logarithmic scale shown times `size`: zero and decades of both signs. */
export function rateTicks(scale, most, size) {
  const top = Math.floor(Math.log10(scale.limit * size) + 1e-9), bottom = Math.ceil(Math.log10(scale.linear * size) - 1e-9);
  const stride = Math.max(1, Math.ceil((top - bottom + 1) / most)), sizes = [];
  for (let n = top; n >= bottom; n -= stride) sizes.push(Number((10 ** n).toPrecision(3)));
  return [...sizes.map((v) => -v), 0, ...sizes.reverse()];
}
