// Roots of real polynomials in double precision: closed forms, otherwise Aberth's iteration.

const CLOSE = 4e-16; // relative correction at which the iteration ends

/** Roots of c[0] + c[1] λ + … as pairs [re, im], sorted by real, then imaginary part. */
export function polynomialRoots(c, even = false) {
  const found = even ? evenRoots(c) : ordinaryRoots(c);
  return found.sort((a, b) => a[0] - b[0] || a[1] - b[1]);
}

function evenRoots(c) {
  const squares = ordinaryRoots(c.filter((_, i) => i % 2 === 0));
  return squares.flatMap(([re, im]) => {
    const root = complexRoot(re, im);
    return [root, [-root[0], -root[1]]];
  });
}

function complexRoot(re, im) {
  if (im === 0) return re < 0 ? [0, Math.sqrt(-re)] : [Math.sqrt(re), 0];
  const size = Math.hypot(re, im), half = Math.sqrt((size + Math.abs(re)) / 2);
  return re >= 0 ? [half, im / (2 * half)] : [Math.abs(im) / (2 * half), im < 0 ? -half : half];
}

function ordinaryRoots(c) {
  let degree = c.length - 1;
  while (degree > 0 && c[degree] === 0) degree--; // a pole of the family: a root at infinity
  const zeros = [];
  let first = 0;
  while (first < degree && c[first] === 0) { zeros.push([0, 0]); first++; }
  const rest = c.slice(first, degree + 1);
  if (rest.length < 2) return zeros;
  if (rest.length === 2) return [...zeros, [-rest[0] / rest[1], 0]];
  if (rest.length === 3) return [...zeros, ...quadraticRoots(rest[0], rest[1], rest[2])];
  return [...zeros, ...aberth(rest)];
}

function quadraticRoots(c, b, a) {
  const inner = b * b - 4 * a * c;
  if (inner < 0) {
    const re = -b / (2 * a), im = Math.sqrt(-inner) / (2 * Math.abs(a));
    return [[re, -im], [re, im]];
  }
  const q = -(b + (b < 0 ? -1 : 1) * Math.sqrt(inner)) / 2;
  return q === 0 ? [[0, 0], [0, 0]] : [[q / a, 0], [c / q, 0]];
}

function aberth(c) {
  const n = c.length - 1, a = c.map((v) => v / c[n]);
  let radius = 0;
  for (let i = 0; i < n; i++) radius = Math.max(radius, Math.abs(a[i]) ** (1 / (n - i)));
  const re = new Float64Array(n), im = new Float64Array(n);
  for (let i = 0; i < n; i++) {
    const angle = (2 * Math.PI * i) / n + 0.4;
    re[i] = radius * Math.cos(angle);
    im[i] = radius * Math.sin(angle);
  }
  for (let round = 0; round < 80; round++) {
    let largest = 0;
    for (let i = 0; i < n; i++) {
      const [nr, ni] = newtonStep(a, re[i], im[i]);
      let sr = 0, si = 0;
      for (let j = 0; j < n; j++) {
        if (j === i) continue;
        const dr = re[i] - re[j], di = im[i] - im[j], size = dr * dr + di * di;
        if (size === 0) continue;
        sr += dr / size;
        si -= di / size;
      }
      // w = N / (1 - N S)
      const br = 1 - (nr * sr - ni * si), bi = -(nr * si + ni * sr), b = br * br + bi * bi;
      const wr = (nr * br + ni * bi) / b, wi = (ni * br - nr * bi) / b;
      if (!Number.isFinite(wr + wi)) continue;
      re[i] -= wr;
      im[i] -= wi;
      largest = Math.max(largest, Math.hypot(wr, wi) / (Math.hypot(re[i], im[i]) || 1));
    }
    if (largest < CLOSE) break;
  }
  return paired(a, re, im);
}

function newtonStep(a, x, y) { // p / p' by Horner's scheme
  let pr = 1, pi = 0, dr = 0, di = 0;
  for (let i = a.length - 2; i >= 0; i--) {
    [dr, di] = [dr * x - di * y + pr, dr * y + di * x + pi];
    [pr, pi] = [pr * x - pi * y + a[i], pr * y + pi * x];
  }
  const size = dr * dr + di * di;
  return size === 0 ? [0, 0] : [(pr * dr + pi * di) / size, (pi * dr - pr * di) / size];
}

/** Real roots made real and pairs made conjugate; one more Newton step for each. */
function paired(a, re, im) {
  const left = Array.from(re, (v, i) => [v, im[i]]), out = [];
  while (left.length) {
    const z = left.pop();
    let best = -1, gap = Infinity;
    left.forEach((w, i) => {
      const apart = Math.hypot(w[0] - z[0], w[1] + z[1]);
      if (apart < gap) [best, gap] = [i, apart];
    });
    if (best < 0 || 2 * Math.abs(z[1]) <= gap) {
      const [step] = newtonStep(a, z[0], 0);
      out.push([Math.abs(step) < 1e-6 * (Math.abs(z[0]) || 1) ? z[0] - step : z[0], 0]);
    } else {
      const [w] = left.splice(best, 1);
      const x = (z[0] + w[0]) / 2, y = (Math.abs(z[1]) + Math.abs(w[1])) / 2;
      out.push([x, -y], [x, y]);
    }
  }
  return out;
}

/** A vector v with A v = λ v, largest entry 1, by inverse iteration; A row by row. */
export function eigenvector(matrix, n, [re, im]) {
  const size = Math.max(1e-300, ...matrix.map(Math.abs)), shift = 1e-9 * size;
  let v = Array.from({length: n}, (_, i) => [1 / (1 + i), 0.3 * (i % 3)]);
  for (let round = 0; round < 3; round++) {
    const rows = Array.from({length: n}, (_, i) => [
      ...Array.from({length: n}, (_, j) => (i === j
        ? [matrix[i * n + j] - re - shift, -im] : [matrix[i * n + j], 0])), v[i]]);
    v = solved(rows, size);
    const top = v.reduce((a, b) => (Math.hypot(...b) > Math.hypot(...a) * 1.0001 ? b : a));
    v = v.map((z) => quotient(z, top));
  }
  return v;
}

function quotient(a, b) {
  const size = b[0] * b[0] + b[1] * b[1];
  return [(a[0] * b[0] + a[1] * b[1]) / size, (a[1] * b[0] - a[0] * b[1]) / size];
}

function solved(rows, size) { // Gauss with pivots; a vanishing pivot is replaced by a tiny one
  const n = rows.length;
  for (let k = 0; k < n; k++) {
    let p = k;
    for (let i = k + 1; i < n; i++) if (Math.hypot(...rows[i][k]) > Math.hypot(...rows[p][k])) p = i;
    [rows[k], rows[p]] = [rows[p], rows[k]];
    if (Math.hypot(...rows[k][k]) < 1e-15 * size) rows[k][k] = [1e-15 * size, 0];
    for (let i = k + 1; i < n; i++) {
      const f = quotient(rows[i][k], rows[k][k]);
      if (f[0] === 0 && f[1] === 0) continue;
      for (let j = k; j <= n; j++) {
        const [x, y] = rows[k][j];
        rows[i][j] = [rows[i][j][0] - f[0] * x + f[1] * y, rows[i][j][1] - f[0] * y - f[1] * x];
      }
    }
  }
  const x = new Array(n);
  for (let i = n - 1; i >= 0; i--) {
    let [a, b] = rows[i][n];
    for (let j = i + 1; j < n; j++) {
      a -= rows[i][j][0] * x[j][0] - rows[i][j][1] * x[j][1];
      b -= rows[i][j][0] * x[j][1] + rows[i][j][1] * x[j][0];
    }
    x[i] = quotient([a, b], rows[i][i]);
  }
  return x;
}
