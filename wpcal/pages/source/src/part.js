// Reads `part.glb` as wpcal writes it: one node per solid with quantised positions (mm after the scale and translation
// of the node), normals, triangles and edges. The root's rotation to metres and y up is ignored: the view has mm, z up.
import { BufferAttribute, BufferGeometry, Color } from "three";

const HEADER = 12; // magic, version, length
const CHUNK = 8; // length, type
const COMPONENTS = { 5120: Int8Array, 5123: Uint16Array, 5125: Uint32Array };
const SIZES = { SCALAR: 1, VEC3: 3 };
const MUTED = 0.5; // 0: the colour of the solid, 1: the grey of the view
const TRIANGLES = 4;
const LINES = 1;

function chunks(bytes) {
  const view = new DataView(bytes);
  const jsonLength = view.getUint32(HEADER, true);
  const json = new TextDecoder().decode(new Uint8Array(bytes, HEADER + CHUNK, jsonLength));
  return { document: JSON.parse(json), start: HEADER + CHUNK + jsonLength + CHUNK };
}

function readerOf(bytes) {
  const { document, start } = chunks(bytes);
  /** The numbers of an accessor, their count of rows, and how many numbers a row has with its padding. */
  const read = (number) => {
    const { bufferView, componentType, count, type } = document.accessors[number];
    const { byteOffset = 0, byteStride } = document.bufferViews[bufferView];
    const [kind, size] = [COMPONENTS[componentType], SIZES[type]];
    const stride = (byteStride ?? size * kind.BYTES_PER_ELEMENT) / kind.BYTES_PER_ELEMENT;
    return { data: new kind(bytes, start + byteOffset, count * stride), stride, count };
  };
  return { document, read };
}

function sizes(nodes, document) {
  let [points, corners, ends] = [0, 0, 0];
  for (const node of nodes) {
    for (const primitive of document.meshes[node.mesh].primitives) {
      const indices = document.accessors[primitive.indices].count;
      if (primitive.mode === LINES) ends += indices;
      else {
        corners += indices;
        points += document.accessors[primitive.attributes.POSITION].count;
      }
    }
  }
  return { points, corners, ends };
}

/** Moves the points in a range of an array by a row-major 4×4; a turn of milliradians leaves the shading as it is. */
function moveRows(positions, start, end, T) {
  for (let i = start; i < end; i += 3) {
    const [x, y, z] = [positions[i], positions[i + 1], positions[i + 2]];
    for (let row = 0; row < 3; row += 1) positions[i + row] = T[row][0] * x + T[row][1] * y + T[row][2] * z + T[row][3];
  }
}

/**
 * Decodes all solids into one geometry of faces and one geometry of edges.
 *
 * @param {Map<string, number[][]>|null} moves  where solids are, by their names: row-major 4×4
 * @returns {{faces: BufferGeometry, edges: BufferGeometry, solids: {name: string, end: number}[]}}  `end`: index of
 *   the first triangle of the next solid
 */
export function decodePart(bytes, defaultColour, moves = null) {
  const { document, read } = readerOf(bytes);
  const nodes = document.nodes.filter((node) => "mesh" in node);
  const total = sizes(nodes, document);
  const positions = new Float32Array(3 * total.points);
  const normals = new Int8Array(3 * total.points);
  const colours = new Uint8Array(3 * total.points);
  const corners = new Uint32Array(total.corners);
  const ends = new Uint32Array(total.ends);
  const at = { point: 0, corner: 0, end: 0 };
  const solids = nodes.map((node) => {
    const { primitives } = document.meshes[node.mesh];
    const faces = primitives.find(({ mode = TRIANGLES }) => mode === TRIANGLES);
    const lines = primitives.find(({ mode }) => mode === LINES);
    const p = read(faces.attributes.POSITION);
    const n = read(faces.attributes.NORMAL);
    const [tx, ty, tz] = node.translation;
    const scale = node.scale[0];
    for (let i = 0, to = 3 * at.point; i < p.count; i += 1, to += 3) {
      const [from, turn] = [i * p.stride, i * n.stride];
      positions[to] = p.data[from] * scale + tx;
      positions[to + 1] = p.data[from + 1] * scale + ty;
      positions[to + 2] = p.data[from + 2] * scale + tz;
      normals[to] = n.data[turn];
      normals[to + 1] = n.data[turn + 1];
      normals[to + 2] = n.data[turn + 2];
    }
    colours.set(repeated(colourOfSolid(document, faces, defaultColour), p.count), 3 * at.point);
    at.corner = append(corners, at.corner, read(faces.indices).data, at.point);
    if (lines) at.end = append(ends, at.end, read(lines.indices).data, at.point);
    const T = moves?.get(node.name);
    if (T) moveRows(positions, 3 * at.point, 3 * (at.point + p.count), T);
    at.point += p.count;
    return { name: node.name, end: at.corner / 3 };
  });
  const place = new BufferAttribute(positions, 3);
  const faces = new BufferGeometry();
  faces.setAttribute("position", place);
  faces.setAttribute("normal", new BufferAttribute(normals, 3, true));
  faces.setAttribute("color", new BufferAttribute(colours, 3, true));
  faces.setIndex(new BufferAttribute(corners, 1));
  const edges = new BufferGeometry();
  edges.setAttribute("position", place);
  edges.setIndex(new BufferAttribute(ends, 1));
  return { faces, edges, solids };
}

function append(target, start, indices, offset) {
  for (let i = 0; i < indices.length; i += 1) target[start + i] = indices[i] + offset;
  return start + indices.length;
}

/** The colour of the solid (linear, as in glTF), mixed with the grey of the view so that seams remain visible on it. */
function colourOfSolid(document, primitive, fallback) {
  const { extras, pbrMetallicRoughness } = document.materials[primitive.material];
  const [red, green, blue] = pbrMetallicRoughness.baseColorFactor;
  const { r, g, b } = extras.stated ? new Color(red, green, blue).lerp(fallback, MUTED) : fallback;
  return [r, g, b].map((value) => Math.round(255 * value));
}

function repeated(rgb, count) {
  const all = new Uint8Array(3 * count);
  for (let i = 0; i < all.length; i += 1) all[i] = rgb[i % 3];
  return all;
}
