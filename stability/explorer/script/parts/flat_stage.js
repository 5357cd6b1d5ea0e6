// The disk, or a body by circles and stripes, on its plane without WebGL: outlines in perspective.

import {TurnedView, innerRadius, placed, sizeOf} from "./turned_view.js";

const POINTS = 72, GRID = 6, CIRCLES = 7, STRIPES = 8;
const SIGHT = 3.08; // half the height of the picture is this much of the distance

export class FlatStage extends TurnedView {
  constructor(look) {
    super();
    this.style = look;
    this.pen = this.canvas.getContext("2d");
  }

  recolour() {}

  shapeOf(name, {k, rows}) {
    this.rows = rows;
    this.size = sizeOf(rows);
    if (!rows) this.inner = innerRadius(k);
  }

  /** Draw a pose, with the contact points of the path so far. */
  draw(pose, path) {
    const box = this.box(), dense = Math.min(2, window.devicePixelRatio || 1);
    if (!box.width || !box.height) return;
    this.canvas.width = Math.round(dense * box.width);
    this.canvas.height = Math.round(dense * box.height);
    const {pen} = this, parts = placed(pose), rule = this.style.colour("rule");
    pen.setTransform(dense, 0, 0, dense, 0, 0);
    pen.clearRect(0, 0, box.width, box.height);
    this.aim(parts.centre, box);
    const [x, y] = this.target.map(Math.round);
    for (let i = -GRID; i <= GRID; i++) {
      this.line([[x + i, y - GRID, 0], [x + i, y + GRID, 0]], rule, 1);
      this.line([[x - GRID, y + i, 0], [x + GRID, y + i, 0]], rule, 1);
    }
    this.line(path.slice(-2000), this.style.colour("mark"), 1.5);
    if (this.rows) this.body(parts); else this.disk(parts);
  }

  /** Circles and stripes of a surface of revolution. */
  body({axis, mark, side, centre}) {
    const at = ([r, z], a) => centre.map((v, n) => v + z * axis[n] + r * (Math.cos(a) * mark[n] + Math.sin(a) * side[n]));
    const last = this.rows.length - 1, line = this.style.colour("face"), first = this.style.colour("blue");
    for (let i = 1; i < CIRCLES; i++) {
      const row = this.rows[Math.round((i * last) / CIRCLES)];
      this.line(Array.from({length: POINTS + 1}, (_, j) => at(row, (2 * Math.PI * j) / POINTS)), line, 1.5);
    }
    for (let j = 0; j < STRIPES; j++) {
      this.line(this.rows.map((row) => at(row, (2 * Math.PI * j) / STRIPES)), j ? line : first, j ? 1.2 : 4);
    }
  }

  disk(parts) {
    const {pen} = this;
    const ring = (r) => Array.from({length: POINTS}, (_, i) => {
      const a = (2 * Math.PI * i) / POINTS;
      return parts.centre.map((c, n) => c + r * (Math.cos(a) * parts.mark[n] + Math.sin(a) * parts.side[n]));
    });
    pen.beginPath();
    for (const loop of this.inner > 0 ? [ring(1), ring(this.inner)] : [ring(1)]) { this.trace(loop); pen.closePath(); }
    pen.fillStyle = this.style.colour("face");
    pen.fill("evenodd");
    Object.assign(pen, {strokeStyle: this.style.colour("edge"), lineWidth: 2}).stroke();
    const rim = parts.centre.map((c, n) => c + parts.mark[n]), near = parts.centre.map((c, n) => c + this.inner * parts.mark[n]);
    this.line([near, rim], this.style.colour("mark"), 4);
  }

  aim(centre, box) {
    const {azimuth, height} = this.angle, {at: eye} = this.eye(centre, this.size);
    const [ca, sa, ch, sh] = [Math.cos(azimuth), Math.sin(azimuth), Math.cos(height), Math.sin(height)];
    const back = [ch * ca, ch * sa, sh], right = [-sa, ca, 0], up = [-sh * ca, -sh * sa, ch];
    const dot = (a, b) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
    this.flat = (p) => {
      const to = p.map((v, i) => v - eye[i]), far = Math.max(0.3, -dot(to, back)), scale = (box.height / 2) * SIGHT / far;
      return [box.width / 2 + scale * dot(to, right), box.height / 2 - scale * dot(to, up)];
    };
  }

  trace(points) {
    points.map(this.flat).forEach(([x, y], i) => (i ? this.pen.lineTo(x, y) : this.pen.moveTo(x, y)));
  }

  line(points, colour, width) {
    this.pen.beginPath();
    this.trace(points);
    Object.assign(this.pen, {strokeStyle: colour, lineWidth: width}).stroke();
  }
}
