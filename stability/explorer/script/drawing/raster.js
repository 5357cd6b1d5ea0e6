// The coloured plane: growth rates by a shader that Python printed from the exact polynomials.
// Where WebGL2 is missing, the same picture is computed in double precision, more coarsely.

import {rgb, shade} from "./colours.js";

const VERTEX = `#version 300 es
in vec2 corner;
void main() { gl_Position = vec4(corner, 0.0, 1.0); }`;

const PAINT = `
void main() {
  vec2 u = gl_FragCoord.xy / size, v = mix(low, high, u);
  vec2 found = look(ARGUMENTS);
  float g = found.x, a = abs(g);
  float bent = a <= linear ? width * a / linear : width + log(a / linear) / 2.302585093;
  float place = clamp(0.5 + 0.5 * sign(g) * bent / end, 0.0, 0.999999) * 5.0;
  int i = int(place);
  vec3 c = mix(ramp[i], ramp[i + 1], place - float(i));
  vec2 p = gl_FragCoord.xy / pixel;
  float cover = 0.0;
  if (found.y < 0.0) {
    float d = abs(mod(p.x - p.y, 7.0) - 3.5) * 0.7071;
    cover = 0.62 * (1.0 - smoothstep(0.15, 0.15 + 1.0 / pixel, d));
  } else if (neutral) {
    float r = length(mod(p + vec2(3.5 * mod(floor(p.y / 6.0), 2.0), 0.0), vec2(7.0, 6.0)) - 3.0);
    cover = 0.55 * (1.0 - smoothstep(0.5, 0.5 + 1.0 / pixel, r));
  }
  c = mix(c, hatch, cover);
  bool inside = DOMAIN;
  colour = inside ? vec4(c, 1.0) : vec4(0.0);
}`;

/** A canvas that shows the growth rate of a subject over two quantities. */
export class Raster {
  constructor(canvas) {
    this.canvas = canvas;
    this.gl = canvas.getContext("webgl2", {antialias: false, alpha: true, preserveDrawingBuffer: true});
    this.pen = this.gl ? null : canvas.getContext("2d");
    this.programs = new Map();
    if (!this.gl) return;
    const buffer = this.gl.createBuffer();
    this.gl.bindBuffer(this.gl.ARRAY_BUFFER, buffer);
    this.gl.bufferData(this.gl.ARRAY_BUFFER, new Float32Array([-1, -1, 3, -1, -1, 3]), this.gl.STATIC_DRAW);
  }

  /** In words, for the legend. */
  get method() {
    return this.gl ? "single precision, in a shader" : "double precision, on a coarse grid";
  }

  draw(subject, values, x, y, scale, colours, pixel) {
    if (this.gl) this.paint(subject, values, x, y, scale, colours, pixel);
    else this.compute(subject, values, x, y, scale, colours);
  }

  paint(subject, values, x, y, scale, colours, pixel) {
    const gl = this.gl, program = this.program(subject), {width, height} = this.canvas;
    gl.viewport(0, 0, width, height);
    gl.useProgram(program.id);
    const set = (name, kind, ...given) => gl[`uniform${kind}`](program.place(name), ...given);
    set("low", "2f", x.low, y.low);
    set("high", "2f", x.high, y.high);
    set("size", "2f", width, height);
    set("held", "1fv", subject.array(values));
    set("xIndex", "1i", subject.names.indexOf(x.name));
    set("yIndex", "1i", subject.names.indexOf(y.name));
    set("ramp", "3fv", colours.ramp.flatMap(rgb));
    set("hatch", "3fv", rgb(colours.hatch));
    for (const name of ["linear", "width", "end"]) set(name, "1f", scale[name]);
    set("pixel", "1f", pixel);
    set("neutral", "1i", subject.wholeEven ? 1 : 0);
    gl.drawArrays(gl.TRIANGLES, 0, 3);
  }

  program(subject) {
    if (!this.programs.has(subject.key)) {
      const gl = this.gl, id = gl.createProgram();
      for (const [kind, source] of [[gl.VERTEX_SHADER, VERTEX], [gl.FRAGMENT_SHADER, fragment(subject)]]) {
        const one = gl.createShader(kind);
        gl.shaderSource(one, source);
        gl.compileShader(one);
        gl.attachShader(id, one);
      }
      gl.bindAttribLocation(id, 0, "corner");
      gl.linkProgram(id);
      if (!gl.getProgramParameter(id, gl.LINK_STATUS)) throw new Error(gl.getProgramInfoLog(id) || "no shader");
      gl.enableVertexAttribArray(0);
      gl.vertexAttribPointer(0, 2, gl.FLOAT, false, 0, 0);
      const places = new Map();
      const place = (name) => {
        if (!places.has(name)) places.set(name, gl.getUniformLocation(id, name));
        return places.get(name);
      };
      this.programs.set(subject.key, {id, place});
    }
    return this.programs.get(subject.key);
  }

  compute(subject, values, x, y, scale, colours) {
    const {width, height} = this.canvas, image = this.pen.createImageData(width, height);
    const step = Math.max(1, Math.round(width / 130)), at = {...values};
    const hatch = rgb(colours.hatch);
    for (let j = 0; j < height; j += step) {
      for (let i = 0; i < width; i += step) {
        at[x.name] = x.value((i + step / 2) / width);
        at[y.name] = y.value(1 - (j + step / 2) / height);
        const ok = subject.accepts(x.name, at[x.name]) && subject.accepts(y.name, at[y.name]);
        const q = subject.array(at), unstable = subject.margin(q) < 0;
        const base = shade(colours.ramp, scale.place(subject.growth(q)));
        for (let b = j; b < Math.min(height, j + step); b++) {
          for (let a = i; a < Math.min(width, i + step); a++) {
            const line = unstable ? (a + b) % 8 === 0 : subject.wholeEven && a % 8 === 0 && b % 8 === 0;
            const c = line ? base.map((v, n) => 0.45 * v + 0.55 * hatch[n]) : base;
            image.data.set([...c.map((v) => 255 * v), ok ? 255 : 0], 4 * (b * width + a));
          }
        }
      }
    }
    this.pen.putImageData(image, 0, 0);
  }
}

function fragment(subject) {
  const n = subject.names.length;
  const given = subject.names.map((_, i) => `xIndex == ${i} ? v.x : yIndex == ${i} ? v.y : held[${i}]`);
  const limits = subject.quantities.flatMap((q, i) => [
    q.least === null ? null : `(${given[i]}) > ${number(q.least)}`,
    q.most === null ? null : `(${given[i]}) < ${number(q.most)}`]).filter((t) => t);
  return `#version 300 es
precision highp float;
uniform vec2 low, high, size;
uniform float held[${n}], linear, width, end, pixel;
uniform int xIndex, yIndex;
uniform bool neutral;
uniform vec3 ramp[6], hatch;
out vec4 colour;
${subject.shader}
${PAINT.replace("ARGUMENTS", given.join(", ")).replace("DOMAIN", limits.join(" && ") || "true")}`;
}

function number(value) {
  const found = String(value);
  return /[.e]/.test(found) ? found : `${found}.0`;
}
