// The parts of three.js that stability/explorer/script/parts/stage.js uses.

export {
  BufferAttribute, BufferGeometry, DirectionalLight, ExtrudeGeometry, Float32BufferAttribute, Fog, Group,
  HemisphereLight, Line, LineBasicMaterial, LineSegments, Matrix4, Mesh, MeshBasicMaterial,
  MeshLambertMaterial, Path, PerspectiveCamera, Scene, Shape, WebGLRenderer,
} from "three";
