// Distances in the view: two clicks, on corners, edges or faces of the part, or on what can be clicked.
import { Vector3 } from "three";

const SNAP_PX = 9; // a corner or an edge this near the pointer is meant

/** Ends of the shortest way between two segments [a, b]; Ericson, Real-Time Collision Detection, 5.1.9. */
export function shortestWay([p1, q1], [p2, q2]) {
  const [d1, d2, r] = [minus(q1, p1), minus(q2, p2), minus(p1, p2)];
  const [a, e, f, c, b] = [dot(d1, d1), dot(d2, d2), dot(d2, r), dot(d1, r), dot(d1, d2)];
  const within = (value) => Math.min(Math.max(value, 0), 1);
  let s = 0;
  let t = 0;
  if (a > 0 && e > 0) {
    const denominator = a * e - b * b;
    s = denominator > 1e-12 * a * e ? within((b * f - c * e) / denominator) : 0;
    t = (b * s + f) / e;
    if (t < 0 || t > 1) {
      t = within(t);
      s = within((b * t - c) / a);
    }
  } else if (e > 0) {
    t = within(f / e);
  } else if (a > 0) {
    s = within(-c / a);
  }
  return [along(p1, d1, s), along(p2, d2, t)];
}

/** What a click means: a corner, an edge, a target of the page, or a place on a face; null beside the part. */
export function snapped(viewer, x, y) {
  const target = viewer.targets.at(x, y);
  const [corner, edge] = nearestOfEdges(viewer, x, y);
  if (corner) return { kind: "corner", ends: [corner, corner] };
  if (target) return { kind: "point", ends: [target.p, target.p] };
  if (edge) return { kind: "edge", ends: edge };
  const face = viewer.surfaceAt(x, y, viewer.cut.shown());
  return face && { kind: "face", ends: [face.p, face.p] };
}

/** The segment of an edge at most `reach` pixels from a pixel, or null. */
export function edgeAt(viewer, x, y, reach) {
  return nearestOfEdges(viewer, x, y, reach)[1];
}

/** The distance between two picks: {mm, d: [x, y, z], ends}. Between edges it is the shortest one. */
export function distanceOf(first, second) {
  const ends = shortestWay(first.ends, second.ends);
  const d = minus(ends[1], ends[0]);
  return { mm: Math.hypot(...d), d, ends };
}

/** The nearest end of an edge of the part that is not hidden, and the nearest edge, within reach of the pointer. */
function nearestOfEdges(viewer, x, y, reach = SNAP_PX) {
  const found = { corner: null, edge: null };
  const nearest = { corner: reach, edge: reach };
  const take = (kind, distance, p, value) => {
    if (distance >= nearest[kind] || viewer.cut.removes(p) || viewer.isHidden(p)) return;
    nearest[kind] = distance;
    found[kind] = value;
  };
  for (const [a, b] of edgesOf(viewer)) {
    const [pa, pb] = [viewer.project(a), viewer.project(b)];
    const [dx, dy] = [pb.x - pa.x, pb.y - pa.y];
    const square = dx * dx + dy * dy;
    const t = square > 0 ? Math.min(Math.max(((x - pa.x) * dx + (y - pa.y) * dy) / square, 0), 1) : 0;
    const distance = Math.hypot(pa.x + t * dx - x, pa.y + t * dy - y);
    if (distance >= reach) continue;
    take("edge", distance, along(a, minus(b, a), t), [a, b]);
    take("corner", Math.hypot(pa.x - x, pa.y - y), a, a);
    take("corner", Math.hypot(pb.x - x, pb.y - y), b, b);
  }
  return [found.corner, found.edge];
}

/** The segments of the edges that are shown, as pairs of places in the frame of the page. */
function edgesOf(viewer) {
  const segments = [];
  for (const { geometry, matrixWorld, isLineSegments } of viewer.cut.shown()) {
    if (isLineSegments) segments.push(...segmentsOf(geometry, matrixWorld));
  }
  return segments;
}

function segmentsOf({ index, attributes: { position } }, matrix) {
  const at = (i) => new Vector3().fromBufferAttribute(position, index.getX(i)).applyMatrix4(matrix).toArray();
  return Array.from({ length: index.count / 2 }, (_, k) => [at(2 * k), at(2 * k + 1)]);
}

const minus = (a, b) => a.map((v, i) => v - b[i]);
const dot = (a, b) => a.reduce((sum, v, i) => sum + v * b[i], 0);
const along = (p, d, s) => p.map((v, i) => v + s * d[i]);
