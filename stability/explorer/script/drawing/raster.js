// The coloured plane: a picture of growth rates and verdicts that are known on a grid, by a shader, or
// point by point where WebGL2 is missing. It decides nothing: what a node is comes with the grid.

import {GOOD, UNDECIDED, UNSTABLE} from "../mathematics/rates.js";
import {rgb, shade} from "./colours.js";
import {COVER, covers, patternNumber} from "./patterns.js";

const VERTEX = `#version 300 es
in vec2 corner;
void main() { gl_Position = vec4(corner, 0.0, 1.0); }`;
const PICTURE = `#version 300 es
precision highp float;
uniform vec2 size, grid;
uniform float pixel;
uniform ivec3 patterns; // of the unstable side, of the other one, of what is undecided
uniform vec3 ramp[6], hatch, open[2];
uniform highp sampler2D rates;
out vec4 colour;
${COVER}
vec3 ramped(float place) {
  float at = clamp(place, 0.0, 0.999999) * 5.0;
  int i = int(at);
  return mix(ramp[i], ramp[i + 1], at - float(i));
}
void main() {
  vec2 at = gl_FragCoord.xy / size * grid - 0.5, f = fract(at), p = gl_FragCoord.xy / pixel;
  ivec2 i = ivec2(floor(at)), last = ivec2(grid) - 1;
  float place = 0.0;
  vec4 shares = vec4(0.0); // without a member, unstable, the other verdict, undecided
  for (int n = 0; n < 4; n++) {
    ivec2 step = ivec2(n & 1, n >> 1);
    vec2 t = texelFetch(rates, clamp(i + step, ivec2(0), last), 0).rg, w = mix(1.0 - f, f, vec2(step));
    shares[int(t.g)] += w.x * w.y;
    place += w.x * w.y * t.r; // 0 without a member
  }
  float there = shares.y + shares.z + shares.w;
  vec3 c = ramped(place / max(there, 1e-6));
  if (shares.w > 0.5 * there) c = mix(open[0], open[1], cover(patterns.z, p));
  else c = mix(c, hatch, cover(shares.y > shares.z ? patterns.x : patterns.y, p));
  colour = there > 0.5 ? vec4(c, 1.0) : vec4(0.0);
}`;

/** A canvas that shows the growth rates and verdicts of a grid. */
export class Raster {
  constructor(canvas) {
    this.canvas = canvas;
    this.gl = canvas.getContext("webgl2", {antialias: false, alpha: true, preserveDrawingBuffer: true});
    this.pen = this.gl ? null : canvas.getContext("2d");
    if (this.gl) this.prepare();
  }

  /** Compile the shader, and make the texture that holds a grid. */
  prepare() {
    const {gl} = this, program = gl.createProgram();
    for (const [kind, text] of [[gl.VERTEX_SHADER, VERTEX], [gl.FRAGMENT_SHADER, PICTURE]]) {
      const shader = gl.createShader(kind);
      gl.shaderSource(shader, text);
      gl.compileShader(shader);
      gl.attachShader(program, shader);
    }
    gl.bindAttribLocation(program, 0, "corner");
    gl.linkProgram(program);
    if (!gl.getProgramParameter(program, gl.LINK_STATUS)) throw new Error(gl.getProgramInfoLog(program) || "no shader");
    gl.useProgram(program);
    this.place = Object.fromEntries(["size", "grid", "pixel", "patterns", "ramp", "hatch", "open", "rates"]
      .map((name) => [name, gl.getUniformLocation(program, name)]));
    gl.bindBuffer(gl.ARRAY_BUFFER, gl.createBuffer());
    gl.bufferData(gl.ARRAY_BUFFER, new Float32Array([-1, -1, 3, -1, -1, 3]), gl.STATIC_DRAW);
    gl.enableVertexAttribArray(0);
    gl.vertexAttribPointer(0, 2, gl.FLOAT, false, 0, 0);
    gl.bindTexture(gl.TEXTURE_2D, gl.createTexture());
    for (const name of ["TEXTURE_MIN_FILTER", "TEXTURE_MAG_FILTER"]) gl.texParameteri(gl.TEXTURE_2D, gl[name], gl.NEAREST);
    gl.uniform1i(this.place.rates, 0);
  }

  /** Draw the rates of a grid; `pixel` is pixels of the canvas for one of the page. */
  draw({data, size, subject}, {ramp, hatch, undecided}, pixel) {
    if (this.gl) this.paint(data, size, subject.patterns, ramp.map(rgb), rgb(hatch), undecided.map(rgb), pixel);
    else this.fill(data, size, subject.patterns, ramp, rgb(hatch), undecided.map(rgb));
  }

  paint(data, size, patterns, ramp, hatch, undecided, pixel) {
    const {gl, place, canvas} = this;
    gl.viewport(0, 0, canvas.width, canvas.height);
    gl.texImage2D(gl.TEXTURE_2D, 0, gl.RG32F, ...size, 0, gl.RG, gl.FLOAT, data);
    gl.uniform2f(place.size, canvas.width, canvas.height);
    gl.uniform2f(place.grid, ...size);
    gl.uniform1f(place.pixel, pixel);
    gl.uniform3i(place.patterns, ...patterns.map(patternNumber));
    gl.uniform3fv(place.ramp, ramp.flat());
    gl.uniform3fv(place.hatch, hatch);
    gl.uniform3fv(place.open, undecided.flat());
    gl.drawArrays(gl.TRIANGLES, 0, 3);
  }

  /** The same picture without a shader: each pixel as the node that it lies in. */
  fill(data, [columns, rows], [grows, persists, open], ramp, hatch, undecided) {
    const {width, height} = this.canvas, image = this.pen.createImageData(width, height);
    const look = {[UNSTABLE]: [grows, hatch], [GOOD]: [persists, hatch], [UNDECIDED]: [open, undecided[1]]};
    for (let b = 0; b < height; b++) {
      const row = rows - 1 - Math.floor(((b + 0.5) * rows) / height);
      for (let a = 0; a < width; a++) {
        const n = 2 * (row * columns + Math.floor(((a + 0.5) * columns) / width)), what = look[data[n + 1]];
        if (!what) continue;
        const base = data[n + 1] === UNDECIDED ? undecided[0] : shade(ramp, data[n]);
        const c = covers(what[0], a, b) ? base.map((v, k) => 0.45 * v + 0.55 * what[1][k]) : base;
        image.data.set([...c.map((v) => 255 * v), 255], 4 * (b * width + a));
      }
    }
    this.pen.putImageData(image, 0, 0);
  }
}
