// Places on seams: where two of them meet, and between the frames.
const BETWEEN = 10; // places from one frame to the next; on the screen they are a few pixels apart

function ends({ p }) {
  return [p[0], p.at(-1)];
}

/** The rows of the seams that begin or end at most `join_mm` from an end of this one: wpcal joins no others. */
export function meetingRows({ seams, frames }, row, join_mm) {
  if (seams[row].closed) return [];
  const own = ends(frames[row]);
  const isNear = (other) => ends(frames[other]).some((q) => own.some((p) => distance(p, q) <= join_mm));
  return seams.map((_, other) => other).filter((other) => other !== row && !seams[other].closed && isNear(other));
}

export function distance(p, q) {
  return Math.hypot(...p.map((v, i) => v - q[i]));
}

/**
 * Places along a seam, closer to each other than its frames: for a pointer on the seam.
 *
 * @returns {{p: number[][], s: number[], rows: number[]}}  `rows` are the nearest frames
 */
export function placesAlong({ s, p }) {
  const found = { p: [p[0]], s: [s[0]], rows: [0] };
  for (let i = 0; i + 1 < s.length; i += 1) {
    for (let k = 1; k <= BETWEEN; k += 1) {
      const share = k / BETWEEN;
      found.p.push(p[i].map((v, axis) => v + share * (p[i + 1][axis] - v)));
      found.s.push(s[i] + share * (s[i + 1] - s[i]));
      found.rows.push(share < 0.5 ? i : i + 1);
    }
  }
  return found;
}
