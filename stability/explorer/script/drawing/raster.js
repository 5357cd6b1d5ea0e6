// The coloured plane: growth rates by a shader that Python printed from the exact polynomials.
// Where WebGL2 is missing, the same picture is computed in double precision, more coarsely.

import {rgb, shade} from "./colours.js";
import {covers, patternNumber} from "./patterns.js";
import {Fineness} from "./redrawn.js";
import {UNPACKED, VERTEX, subjectShader} from "./raster_shader.js";

const COLUMNS = 130; // of the picture without WebGL
const NODES = [49, 37], NONE = 3e38; // grid of members that are solved for; where there is none
const SEEKING = 3, FEWEST = 0.12; // milliseconds for that grid in motion, and its least fineness

/** A canvas that shows the growth rate of a subject over two quantities. */
export class Raster {
  constructor(canvas) {
    this.canvas = canvas;
    this.gl = canvas.getContext("webgl2", {antialias: false, alpha: true, preserveDrawingBuffer: true});
    this.pen = this.gl ? null : canvas.getContext("2d");
    this.programs = new Map();
    this.seeking = new Fineness(SEEKING, FEWEST);
    if (!this.gl) return;
    const gl = this.gl;
    gl.bindBuffer(gl.ARRAY_BUFFER, gl.createBuffer());
    gl.bufferData(gl.ARRAY_BUFFER, new Float32Array([-1, -1, 3, -1, -1, 3]), gl.STATIC_DRAW);
    gl.enableVertexAttribArray(0);
    gl.vertexAttribPointer(0, 2, gl.FLOAT, false, 0, 0);
  }

  /** In words, for the legend. */
  get method() {
    return this.gl ? "single precision, in a shader" : "double precision, on a coarse grid";
  }

  /** Draw; `share` is the resolution of the growth rates over that of the canvas, `moving` whether a hand moves it. */
  draw(subject, values, x, y, scale, colours, pixel, share, moving) {
    this.moving = moving;
    if (!this.gl) this.compute(subject, values, x, y, scale, colours);
    else if (share >= 1) this.paint(subject, values, x, y, scale, colours, pixel);
    else {
      const size = [this.canvas.width, this.canvas.height].map((v) => Math.max(24, Math.round(share * v)));
      this.target(size);
      this.paint(subject, values, x, y, scale, colours, pixel, size);
      this.unpack(subject, colours, pixel, size);
    }
  }

  /** Compile what a picture in motion needs, before a hand moves it. */
  prepare(subject) {
    if (!this.gl) return;
    this.program(subject, true);
    this.use("unpacked", () => UNPACKED);
  }

  program(subject, packed) {
    return this.use(`${subject.key}${packed ? " packed" : ""}`, () => subjectShader(subject, packed));
  }

  paint(subject, values, x, y, scale, colours, pixel, packed = null) {
    const gl = this.gl, set = this.program(subject, packed !== null);
    const [width, height] = packed || [this.canvas.width, this.canvas.height];
    gl.bindFramebuffer(gl.FRAMEBUFFER, packed ? this.frame : null);
    gl.viewport(0, 0, width, height);
    const end = (axis, value) => (axis.log ? Math.log(value) : value);
    set("low", "2f", end(x, x.low), end(y, y.low));
    set("high", "2f", end(x, x.high), end(y, y.high));
    set("logs", "2i", Number(x.log), Number(y.log));
    set("held", "1fv", subject.array(values));
    set("xIndex", "1i", subject.names.indexOf(x.name));
    set("yIndex", "1i", subject.names.indexOf(y.name));
    for (const name of ["linear", "width", "end"]) set(name, "1f", scale[name]);
    if (subject.solver) this.seeking.spend(this.moving, (fine) => this.members(set, subject, values, x, y, fine));
    this.common(set, subject, colours, pixel, [width, height]);
  }

  /** Unknowns of the members on a grid, as a texture: the shader starts from them. */
  members(set, subject, values, x, y, fine) {
    const gl = this.gl, [columns, rows] = NODES.map((n) => Math.round(1 + fine * (n - 1))), found = new Float32Array(4 * columns * rows), q = subject.array(values);
    const [i, j] = [x, y].map((axis) => subject.names.indexOf(axis.name));
    for (let n = 0; n < columns * rows; n++) {
      q[i] = x.value((n % columns) / (columns - 1));
      q[j] = y.value(Math.floor(n / columns) / (rows - 1));
      subject.solved(q).forEach((v, k) => { found[4 * n + k] = Number.isFinite(v) ? v : NONE; });
    }
    gl.activeTexture(gl.TEXTURE1);
    if (!this.roots) this.roots = unblended(gl);
    gl.bindTexture(gl.TEXTURE_2D, this.roots);
    gl.texImage2D(gl.TEXTURE_2D, 0, gl.RGBA32F, columns, rows, 0, gl.RGBA, gl.FLOAT, found);
    gl.activeTexture(gl.TEXTURE0);
    set("roots", "1i", 1);
    set("nodes", "2f", columns, rows);
  }

  unpack(subject, colours, pixel, grid) {
    const gl = this.gl, set = this.use("unpacked", () => UNPACKED), {width, height} = this.canvas;
    gl.bindFramebuffer(gl.FRAMEBUFFER, null);
    gl.viewport(0, 0, width, height);
    set("rates", "1i", 0);
    set("grid", "2f", ...grid);
    this.common(set, subject, colours, pixel, [width, height]);
  }

  common(set, subject, colours, pixel, size) {
    set("size", "2f", ...size);
    set("pixel", "1f", pixel);
    set("patterns", "2i", ...subject.patterns.map(patternNumber));
    set("ramp", "3fv", colours.ramp.flatMap(rgb));
    set("hatch", "3fv", rgb(colours.hatch));
    this.gl.drawArrays(this.gl.TRIANGLES, 0, 3);
  }

  /** A texture of this size to draw into. */
  target([width, height]) {
    const gl = this.gl;
    if (!this.frame) {
      this.frame = gl.createFramebuffer();
      this.texture = unblended(gl);
      gl.bindFramebuffer(gl.FRAMEBUFFER, this.frame);
      gl.framebufferTexture2D(gl.FRAMEBUFFER, gl.COLOR_ATTACHMENT0, gl.TEXTURE_2D, this.texture, 0);
    }
    if (this.size === `${width} ${height}`) return;
    this.size = `${width} ${height}`;
    gl.texImage2D(gl.TEXTURE_2D, 0, gl.RGBA8, width, height, 0, gl.RGBA, gl.UNSIGNED_BYTE, null);
  }

  /** Use a program, compiled once; returns what sets its uniforms. */
  use(key, source) {
    const gl = this.gl;
    if (!this.programs.has(key)) {
      const id = gl.createProgram();
      for (const [kind, text] of [[gl.VERTEX_SHADER, VERTEX], [gl.FRAGMENT_SHADER, source()]]) {
        const one = gl.createShader(kind);
        gl.shaderSource(one, text);
        gl.compileShader(one);
        gl.attachShader(id, one);
      }
      gl.bindAttribLocation(id, 0, "corner");
      gl.linkProgram(id);
      if (!gl.getProgramParameter(id, gl.LINK_STATUS)) throw new Error(gl.getProgramInfoLog(id) || "no shader");
      const places = new Map();
      this.programs.set(key, {id, set: (name, kind, ...given) => {
        if (!places.has(name)) places.set(name, gl.getUniformLocation(id, name));
        gl[`uniform${kind}`](places.get(name), ...given);
      }});
    }
    const {id, set} = this.programs.get(key);
    gl.useProgram(id);
    return set;
  }

  compute(subject, values, x, y, scale, colours) {
    const {width, height} = this.canvas, image = this.pen.createImageData(width, height);
    const step = Math.max(1, Math.round(width / COLUMNS)), at = {...values};
    const hatch = rgb(colours.hatch), [grows, persists] = subject.patterns;
    for (let j = 0; j < height; j += step) {
      for (let i = 0; i < width; i += step) {
        at[x.name] = x.value((i + step / 2) / width);
        at[y.name] = y.value(1 - (j + step / 2) / height);
        const ok = subject.accepts(x.name, at[x.name]) && subject.accepts(y.name, at[y.name]);
        const q = subject.array(at), there = ok && subject.exists(q), unstable = subject.margin(q) < 0;
        const base = shade(colours.ramp, there ? scale.place(subject.growth(q)) : 0.5);
        for (let b = j; b < Math.min(height, j + step); b++) {
          for (let a = i; a < Math.min(width, i + step); a++) {
            const line = covers(unstable ? grows : persists, a, b);
            const c = line ? base.map((v, n) => 0.45 * v + 0.55 * hatch[n]) : base;
            image.data.set([...c.map((v) => 255 * v), there ? 255 : 0], 4 * (b * width + a));
          }
        }
      }
    }
    this.pen.putImageData(image, 0, 0);
  }
}

/** A texture whose entries are read as they are, bound. */
function unblended(gl) {
  const texture = gl.createTexture();
  gl.bindTexture(gl.TEXTURE_2D, texture);
  for (const name of ["TEXTURE_MIN_FILTER", "TEXTURE_MAG_FILTER"]) gl.texParameteri(gl.TEXTURE_2D, gl[name], gl.NEAREST);
  return texture;
}
