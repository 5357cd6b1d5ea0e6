// Colours of growth rates, from the table of looks that Python writes into the data.

export function isDark() {
  return window.matchMedia("(prefers-color-scheme: dark)").matches;
}

export function rgb(hex) {
  return [1, 3, 5].map((i) => parseInt(hex.slice(i, i + 2), 16) / 255);
}

const LINEAR_SHARE = 1e-3; // of the largest rate: below it the scale is linear
const LINEAR_WIDTH = 1 / 3; // width of the linear part, in decades

/** The scale of the colours, symmetric about zero: a decade of the rate has one width. */
export function rateScale(largest) {
  const limit = rounded(largest || 1), linear = LINEAR_SHARE * limit;
  const bent = (x) => {
    const size = Math.abs(x), sign = Math.sign(x);
    return size <= linear ? (LINEAR_WIDTH * x) / linear : sign * (LINEAR_WIDTH + Math.log10(size / linear));
  };
  const end = bent(limit);
  return {limit, linear, width: LINEAR_WIDTH, end, place: (x) => 0.5 + (0.5 * bent(Math.max(-limit, Math.min(limit, x)))) / end};
}

/** The next of 1, 2, 5, 10, … so that the scale does not change with every point. */
function rounded(value) {
  const power = 10 ** Math.floor(Math.log10(value)), share = value / power;
  return (share <= 1 ? 1 : share <= 2 ? 2 : share <= 5 ? 5 : 10) * power;
}

/** The colour at a place from 0 to 1, as [r, g, b] from 0 to 1. */
export function shade(ramp, place) {
  const u = Math.max(0, Math.min(0.999999, place)) * (ramp.length - 1), i = Math.floor(u), s = u - i;
  const [a, b] = [rgb(ramp[i]), rgb(ramp[i + 1])];
  return a.map((v, n) => (1 - s) * v + s * b[n]);
}

export function css(colour) {
  return `rgb(${colour.map((v) => Math.round(255 * v)).join(" ")})`;
}
