// Shader source around the formulas that Python printed: the whole picture at once, or growth rates
// on a coarse grid and a picture from these, while something moves and drawing is slow.

import {COVER} from "./patterns.js";

export const VERTEX = `#version 300 es
in vec2 corner;
void main() { gl_Position = vec4(corner, 0.0, 1.0); }`;

const HEAD = `#version 300 es
precision highp float;
uniform vec2 size;
uniform float pixel;
uniform ivec2 patterns; // of the unstable side, and of the other one
uniform vec3 ramp[6], hatch;
out vec4 colour;
${COVER}
vec3 painted(float place, bool unstable, vec2 p) {
  float at = clamp(place, 0.0, 0.999999) * 5.0;
  int i = int(at);
  vec3 c = mix(ramp[i], ramp[i + 1], at - float(i));
  return mix(c, hatch, cover(unstable ? patterns.x : patterns.y, p));
}
`;

const LOOK = `
void main() {
  vec2 v = mix(low, high, gl_FragCoord.xy / size);
  if (logs.x == 1) v.x = exp(v.x);
  if (logs.y == 1) v.y = exp(v.y);
  UNKNOWNS
  vec3 found = look(ARGUMENTS);
  float g = found.x, a = abs(g);
  float bent = a <= linear ? width * a / linear : width + log(a / linear) / 2.302585093;
  float place = clamp(0.5 + 0.5 * sign(g) * bent / end, 0.0, 1.0);
  bool inside = DOMAIN && started && found.z > 0.0;
  RESULT
}`;
// members of a grid around a point, whose mean starts Newton's method
const GRID = `
uniform sampler2D roots;
uniform vec2 nodes;
bool near(vec2 at, out vec4 u) {
  vec2 g = at * (nodes - 1.0);
  ivec2 i = ivec2(min(floor(g), nodes - 2.0));
  vec2 f = g - vec2(i);
  vec4 sum = vec4(0.0);
  float total = 0.0;
  for (int n = 0; n < 4; n++) {
    ivec2 step = ivec2(n & 1, n >> 1);
    vec4 t = texelFetch(roots, i + step, 0);
    vec2 w = mix(1.0 - f, f, vec2(step));
    float weight = t.x < 1e30 ? w.x * w.y + 1e-6 : 0.0;
    if (weight > 0.0) sum += weight * t;
    total += weight;
  }
  u = sum / max(total, 1e-9);
  return total > 0.0;
}`;
const WHOLE = "colour = inside ? vec4(painted(place, found.y < 0.0, gl_FragCoord.xy / pixel), 1.0) : vec4(0.0);";
// 16 bits of the place in two channels, then the sign and the domain
const PACKED = "float v16 = place * 255.0; "
  + "colour = vec4(floor(v16) / 255.0, fract(v16), found.y < 0.0 ? 0.0 : 1.0, inside ? 1.0 : 0.0);";

/** The shader of a subject: a picture, or packed growth rates. */
export function subjectShader(subject, packed) {
  const n = subject.names.length;
  const given = subject.names.map((_, i) => `xIndex == ${i} ? v.x : yIndex == ${i} ? v.y : held[${i}]`);
  const limits = subject.quantities.flatMap((q, i) => [
    q.least === null ? null : `(${given[i]}) > ${number(q.least)}`,
    q.most === null ? null : `(${given[i]}) < ${number(q.most)}`]).filter((t) => t);
  const unknowns = subject.unknown.map((_, i) => `u.${"xyzw"[i]}`);
  return `${HEAD}${unknowns.length ? GRID : ""}
uniform vec2 low, high;
uniform float held[${n}], linear, width, end;
uniform int xIndex, yIndex;
uniform ivec2 logs;
${subject.shader}
${LOOK.replace("ARGUMENTS", [...given, ...unknowns].join(", "))
    .replace("UNKNOWNS", unknowns.length ? "vec4 u; bool started = near(gl_FragCoord.xy / size, u);" : "bool started = true;").replace("DOMAIN", limits.join(" && ") || "true")
    .replace("RESULT", packed ? PACKED : WHOLE)}`;
}

/** A fine picture from packed growth rates, linear between them. */
export const UNPACKED = `${HEAD}
uniform sampler2D rates;
uniform vec2 grid;
void main() {
  vec2 at = gl_FragCoord.xy / size * grid - 0.5, f = fract(at);
  ivec2 i = ivec2(floor(at)), last = ivec2(grid) - 1;
  vec4 sum = vec4(0.0);
  for (int n = 0; n < 4; n++) {
    ivec2 step = ivec2(n & 1, n >> 1);
    vec4 t = texelFetch(rates, clamp(i + step, ivec2(0), last), 0);
    vec2 w = mix(1.0 - f, f, vec2(step));
    sum += w.x * w.y * vec4(t.r + t.g / 255.0, t.b, t.a, 1.0);
  }
  colour = sum.z > 0.5 ? vec4(painted(sum.x, sum.y < 0.5, gl_FragCoord.xy / pixel), 1.0) : vec4(0.0);
}`;

function number(value) {
  const found = String(value);
  return /[.e]/.test(found) ? found : `${found}.0`;
}
