// Triangles of a capsule: a cylinder with half a ball at each end.
import { acrossTo } from "../vectors.js";

const AROUND = 48;
const RINGS = 12; // of half a ball

/** Positions (mm, flat) and indices of the capsule around the axis p to q. */
export function capsuleMesh(p, q, radius) {
  const [x, y, z] = axesAlong(p.map((v, i) => q[i] - v));
  const rings = [];
  for (let ring = 0; ring <= 2 * RINGS + 1; ring += 1) {
    const lower = ring <= RINGS;
    const angle = ((lower ? ring - RINGS : ring - RINGS - 1) / RINGS) * (Math.PI / 2);
    rings.push({ centre: lower ? p : q, out: radius * Math.cos(angle), up: radius * Math.sin(angle) });
  }
  const positions = rings.flatMap(({ centre, out, up }) =>
    Array.from({ length: AROUND }, (_, k) => {
      const a = (2 * Math.PI * k) / AROUND;
      return centre.map((v, i) => v + out * (Math.cos(a) * x[i] + Math.sin(a) * y[i]) + up * z[i]);
    }).flat(),
  );
  const indices = [];
  for (let ring = 0; ring + 1 < rings.length; ring += 1) {
    for (let k = 0; k < AROUND; k += 1) {
      const next = (k + 1) % AROUND;
      const [a, b, c, d] = [
        ring * AROUND + k,
        ring * AROUND + next,
        (ring + 1) * AROUND + k,
        (ring + 1) * AROUND + next,
      ];
      indices.push(a, b, d, a, d, c);
    }
  }
  return { positions: new Float32Array(positions), indices };
}

/** Three axes, the last one along a direction; a direction of length zero counts as upright. */
function axesAlong(direction) {
  const length = Math.hypot(...direction);
  const z = length > 0 ? direction.map((v) => v / length) : [0, 0, 1];
  return [...acrossTo(z), z];
}
