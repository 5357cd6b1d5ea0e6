// Axes: values over the unit interval, and ticks at round numbers.

/** An axis of a diagram. */
export function axisScale(name, low, high) {
  return {
    name, low, high,
    value: (u) => low + u * (high - low),
    place: (v) => (v - low) / (high - low),
  };
}

/** About `count` round numbers between the ends. */
export function ticks(low, high, count) {
  const raw = (high - low) / Math.max(1, count), power = 10 ** Math.floor(Math.log10(raw));
  const step = [1, 2, 2.5, 5, 10].map((s) => s * power).find((s) => s >= raw * 0.999) || 10 * power;
  const found = [];
  for (let n = Math.ceil(low / step - 1e-9); n * step <= high + 1e-9 * step; n++) {
    found.push(Number((n * step).toPrecision(12)));
  }
  return found;
}

/** Ticks of a symmetric logarithmic scale: zero and decades of both signs. */
export function rateTicks(scale, most) {
  const top = Math.floor(Math.log10(scale.limit) + 1e-9), bottom = Math.ceil(Math.log10(scale.linear) - 1e-9);
  const stride = Math.max(1, Math.ceil((top - bottom + 1) / most)), sizes = [];
  for (let n = top; n >= bottom; n -= stride) sizes.push(Number((10 ** n).toPrecision(3)));
  return [...sizes.map((v) => -v), 0, ...sizes.reverse()];
}
