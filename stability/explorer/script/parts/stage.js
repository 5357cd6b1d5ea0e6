// The disk or a body of revolution in three dimensions on its plane, with the path of its contact point.

import {TurnedView, innerRadius, placed, sizeOf} from "./turned_view.js";

const TRAIL = 4000, GRID = 14, ROUND = 72;
const STRIPES = [[0, 0.1, "mark"], [0.25, 0.02, "spoke"], [0.5, 0.02, "spoke"], [0.75, 0.02, "spoke"]]; // turn, half width [rad]
const OVER = 1.004; // of a stripe over the surface

/** The picture by WebGL; its constructor fails where that is missing. */
export class Stage extends TurnedView {
  constructor(library, look) {
    super();
    this.three = library;
    this.style = look;
    this.renderer = new library.WebGLRenderer({canvas: this.canvas, antialias: true, alpha: true});
    this.scene = new library.Scene();
    this.camera = new library.PerspectiveCamera(36, 1.5, 0.1, 60);
    this.camera.up.set(0, 0, 1);
    this.build();
  }

  build() {
    const T = this.three, {scene} = this;
    this.body = new T.Group();
    this.shadow = new T.Group();
    this.colour = {};
    for (const name of ["face", "edge", "mark", "spoke"]) this.colour[name] = new T.MeshLambertMaterial();
    this.colour.shade = new T.MeshBasicMaterial({color: 0x000000, transparent: true, opacity: 0.16, depthWrite: false});
    this.colour.grid = new T.LineBasicMaterial({transparent: true, opacity: 0.8});
    this.colour.trail = new T.LineBasicMaterial();
    this.sky = new T.HemisphereLight(0xffffff, 0x9aa4ad, 1.9);
    this.sun = new T.DirectionalLight(0xffffff, 1.9);
    this.sun.position.set(3, -4, 7);
    const trail = new T.BufferGeometry();
    trail.setAttribute("position", new T.BufferAttribute(new Float32Array(3 * TRAIL), 3));
    this.trail = new T.Line(trail, this.colour.trail);
    this.trail.frustumCulled = false;
    const lines = [];
    // one piece for each side of a square: software rendering loses lines that pass behind the eye
    for (let i = -GRID; i <= GRID; i++) {
      for (let j = -GRID; j < GRID; j++) lines.push(i, j, 0, i, j + 1, 0, j, i, 0, j + 1, i, 0);
    }
    const grid = new T.BufferGeometry();
    grid.setAttribute("position", new T.Float32BufferAttribute(lines, 3));
    this.grid = new T.LineSegments(grid, this.colour.grid);
    scene.add(this.sky, this.sun, this.grid, this.trail, this.shadow, this.body);
    this.recolour();
  }

  recolour() {
    const {style} = this, T = this.three;
    for (const name of ["face", "edge", "mark", "spoke"]) this.colour[name].color.set(style.colour(name));
    this.colour.grid.color.set(style.colour("ground"));
    this.colour.trail.color.set(style.colour("mark"));
    this.colour.shade.opacity = style.dark() ? 0.45 : 0.16;
    this.scene.fog = new T.Fog(style.colour("page"), 7, 15);
  }

  /** Draw another body: the disk with inertia factor k, or a surface by rows of its meridian. */
  shapeOf(name, {k, rows}) {
    if (this.name === name) return;
    this.name = name;
    for (const child of [...this.body.children, ...this.shadow.children]) child.geometry.dispose();
    this.body.clear();
    this.shadow.clear();
    this.lift = rows ? 0 : 0.012; // half the thickness that the disk is drawn with
    this.distance = sizeOf(rows); // from farther away at a larger body
    if (rows) this.revolved(rows); else this.disk(k);
  }

  revolved(rows) {
    const T = this.three, whole = turned(T, rows, 0, 2 * Math.PI, 1);
    this.body.add(new T.Mesh(whole, this.colour.face), ...STRIPES.map(([turn, half, name]) => new T.Mesh(
      turned(T, rows, 2 * Math.PI * turn - half, 2 * Math.PI * turn + half, OVER), this.colour[name])));
    this.shadow.add(new T.Mesh(whole.clone(), this.colour.shade));
  }

  /** A uniform disk, or the ring that has this inertia factor. */
  disk(k) {
    const T = this.three, inner = innerRadius(k);
    const outline = new T.Shape().absarc(0, 0, 1, 0, 2 * Math.PI);
    if (inner > 0) outline.holes.push(new T.Path().absarc(0, 0, inner, 0, 2 * Math.PI));
    const depth = 0.05, solid = new T.ExtrudeGeometry(outline, {depth, bevelEnabled: false, curveSegments: 72});
    solid.translate(0, 0, -depth / 2);
    const sector = (middle, half, material) => {
      const from = middle - half, to = middle + half;
      const piece = new T.Shape().absarc(0, 0, 0.995, from, to).absarc(0, 0, Math.max(inner * 1.005, 0.05), to, from, true);
      const made = new T.ExtrudeGeometry(piece, {depth: depth + 0.006, bevelEnabled: false, curveSegments: 16});
      made.translate(0, 0, -depth / 2 - 0.003);
      return new T.Mesh(made, material);
    };
    this.body.add(new T.Mesh(solid, [this.colour.face, this.colour.edge]), sector(0, 0.1 + 0.05 * inner, this.colour.mark),
      ...[0.25, 0.5, 0.75].map((s) => sector(2 * Math.PI * s, 0.012, this.colour.spoke)));
    this.shadow.add(new T.Mesh(solid.clone(), this.colour.shade));
  }

  /** Draw a pose, with the contact points of the path so far. */
  draw(pose, path) {
    if (!this.canvas.isConnected) return;
    const box = this.box();
    if (!box.width || !box.height) return;
    const T = this.three, {mark, side, axis, centre} = placed(pose);
    const turn = new T.Matrix4().set(mark[0], side[0], axis[0], centre[0], mark[1], side[1], axis[1], centre[1],
      mark[2], side[2], axis[2], centre[2] + this.lift, 0, 0, 0, 1);
    this.body.matrixAutoUpdate = false;
    this.body.matrix.copy(turn);
    this.shadow.matrixAutoUpdate = false; // flattened along the light
    this.shadow.matrix.set(1, 0, -0.22, 0, 0, 1, 0.3, 0, 0, 0, 0.002, 0.003, 0, 0, 0, 1).multiply(turn);
    const points = this.trail.geometry.attributes.position, skip = Math.max(1, Math.ceil(path.length / TRAIL));
    let count = 0;
    for (let i = 0; i < path.length; i += skip) points.setXYZ(count++, ...path[i]);
    points.needsUpdate = true;
    this.trail.geometry.setDrawRange(0, count);
    this.look3d(centre, box);
    this.renderer.render(this.scene, this.camera);
  }

  look3d(centre, box) {
    const {at, to} = this.eye(centre, this.distance), ratio = Math.min(2, window.devicePixelRatio || 1);
    this.camera.position.set(...at);
    this.camera.lookAt(...to);
    this.grid.position.set(Math.round(to[0]), Math.round(to[1]), 0);
    if (this.size !== `${box.width} ${box.height}`) {
      this.size = `${box.width} ${box.height}`;
      this.renderer.setPixelRatio(ratio);
      this.renderer.setSize(box.width, box.height, false);
      this.camera.aspect = box.width / box.height;
      this.camera.updateProjectionMatrix();
    }
  }
}

/** A part of a surface of revolution, from one angle about the axis to another; normals of the rows. */
function turned(T, rows, from, to, over) {
  const count = Math.max(2, Math.round((ROUND * (to - from)) / (2 * Math.PI))), place = [], normal = [], faces = [];
  for (const [r, z, theta] of rows) {
    for (let j = 0; j <= count; j++) {
      const a = from + ((to - from) * j) / count, [c, s] = [Math.cos(a), Math.sin(a)];
      place.push(over * r * c, over * r * s, over * z);
      normal.push(Math.sin(theta) * c, Math.sin(theta) * s, -Math.cos(theta));
    }
  }
  for (let i = 0; i + 1 < rows.length; i++) {
    for (let j = 0; j < count; j++) {
      const a = i * (count + 1) + j, b = a + count + 1;
      faces.push(a, a + 1, b, b, a + 1, b + 1);
    }
  }
  const made = new T.BufferGeometry();
  made.setAttribute("position", new T.Float32BufferAttribute(place, 3));
  made.setAttribute("normal", new T.Float32BufferAttribute(normal, 3));
  made.setIndex(faces);
  return made;
}
