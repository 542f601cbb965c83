// Triangles as objects of three.js: the part with its edges, and plain bodies such as arms and fixtures.
import {
  BufferAttribute,
  BufferGeometry,
  Color,
  DoubleSide,
  LineBasicMaterial,
  LineSegments,
  Mesh,
  MeshLambertMaterial,
} from "three";
import { OCCLUDERS } from "./depth.js";
import { decodePart } from "./part.js";

const SURFACE = {
  side: DoubleSide, // open shells show their inside, too
  polygonOffset: true, // edges lie on faces: faces are drawn a little behind them
  polygonOffsetFactor: 1,
  polygonOffsetUnits: 2,
};

/**
 * The part in the bytes of `part.glb`.
 *
 * @param {{part: string, edge: string}} colours
 * @param {Map<string, number[][]>|null} moves  where solids are, by their names
 * @returns {{mesh: Mesh, edges: LineSegments, solids: {name: string}[]}}
 */
export function partObjects(bytes, colours, moves = null) {
  const { faces, edges, solids } = decodePart(bytes, new Color(colours.part), moves);
  const mesh = new Mesh(faces, new MeshLambertMaterial({ ...SURFACE, vertexColors: true }));
  mesh.userData.solids = solids;
  mesh.layers.enable(OCCLUDERS);
  return { mesh, edges: new LineSegments(edges, new LineBasicMaterial({ color: colours.edge })), solids };
}

/** A body of flat triangles: `positions` as a Float32Array of n×3 mm, `indices` of its corners. */
export function bodyObject(positions, indices, color, opacity) {
  const geometry = new BufferGeometry();
  geometry.setAttribute("position", new BufferAttribute(positions, 3));
  if (indices) geometry.setIndex(new BufferAttribute(new Uint32Array(indices), 1));
  const material = new MeshLambertMaterial({ ...SURFACE, color, opacity, transparent: opacity < 1, flatShading: true });
  const mesh = new Mesh(geometry, material);
  if (opacity === 1) mesh.layers.enable(OCCLUDERS);
  return mesh;
}

/** Makes a mesh transparent or solid; only a solid mesh hides what is behind it. */
export function setOpacity(mesh, opacity) {
  const looks = { opacity, transparent: opacity < 1, depthWrite: opacity === 1, needsUpdate: true };
  Object.assign(mesh.material, looks);
  mesh.layers[opacity < 1 ? "disable" : "enable"](OCCLUDERS);
}
