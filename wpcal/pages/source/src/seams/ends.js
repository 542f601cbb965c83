// Which seams meet: seams can be joined where their ends are at one place.
const MEETING_MM = 1; // as `MEETING_MM` of wpcal.seam.edited_run, which decides

function ends({ p }) {
  return [p[0], p.at(-1)];
}

/** The rows of the seams that begin or end where this one does. */
export function meetingRows({ seams, frames }, row) {
  if (seams[row].closed) return [];
  const own = ends(frames[row]);
  const isNear = (other) => ends(frames[other]).some((q) => own.some((p) => distance(p, q) <= MEETING_MM));
  return seams.map((_, other) => other).filter((other) => other !== row && !seams[other].closed && isNear(other));
}

export function distance(p, q) {
  return Math.hypot(...p.map((v, i) => v - q[i]));
}
