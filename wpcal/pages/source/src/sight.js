// Directions from which places on a part are seen: a ray from each place to the eye meets nothing.
import { Raycaster, Vector3 } from "three";

const MOST_PLACES = 7; // of a seam: its ends and what is between
const START = 2e-3; // of the radius of everything: rays leave the faces on which the place is

/** The 26 directions to the corners, edges and faces of a cube. */
const AROUND = [-1, 0, 1]
  .flatMap((x) => [-1, 0, 1].flatMap((y) => [-1, 0, 1].map((z) => new Vector3(x, y, z))))
  .filter((direction) => direction.lengthSq() > 0)
  .map((direction) => direction.normalize());

/** How many of some places the part does not hide from a direction. */
export function seenFrom(viewer, places, direction) {
  const [parts, from] = [viewer.groups(["part"]), new Vector3(...direction).normalize()];
  const caster = new Raycaster();
  caster.near = START * viewer.extent().radius;
  const isSeen = (place) => {
    caster.set(new Vector3(...place), from);
    return caster.intersectObjects(parts, true).length === 0;
  };
  return places.filter(isSeen).length;
}

/**
 * The direction nearest to the wanted one from which most of the places are seen.
 *
 * @param {number[][]} places
 * @param {number[]} wanted  from the places to the eye
 */
export function clearDirection(viewer, places, wanted) {
  const step = Math.max(1, Math.ceil(places.length / MOST_PLACES));
  const some = places.filter((_, i) => i % step === 0 || i === places.length - 1);
  const first = new Vector3(...wanted).normalize();
  const others = [...AROUND].sort((a, b) => b.dot(first) - a.dot(first));
  let best = { seen: -1, direction: first };
  for (const direction of [first, ...others]) {
    const seen = seenFrom(viewer, some, direction.toArray());
    if (seen > best.seen) best = { seen, direction };
    if (seen === some.length) break;
  }
  return best.direction.toArray();
}
