// How seams look after a decision, before wpcal has carried it out: for a page without wpcal behind it.
import { changesBy, Refusal } from "./decisions.js";
import { distance } from "./ends.js";

const JUDGED = new Set(["cut", "join", "otherSide"]); // material and reach may be others then
const SAME_MM = 1e-6;

/** The state {seams, frames} after an operation; the seams that wpcal still judges are `pending`. */
export function previewed({ seams, frames }, operation) {
  const { kind, row, s, other } = operation;
  const { edits } = changesBy(seams, operation);
  if (kind === "separate") throw new Refusal("Undo takes a join back; wpcal seams --html shows the seams anew.");
  const next = { seams: [], frames: [] };
  seams.forEach((seam, at) => {
    const isMeant = at === row || (operation.rows?.includes(at) ?? false);
    const own = edits.get(at) ?? [seam.edit];
    const shapes = at === row ? shapesAfter(kind, frames, { row, s, other }) : [frames[at]];
    own.forEach((edit, k) => {
      next.seams.push(isMeant ? changed(seam, edit, shapes[k], kind) : seam);
      next.frames.push(shapes[k]);
    });
  });
  return next;
}

function changed(seam, edit, shape, kind) {
  const isRefused = seam.inside?.length > 0;
  return {
    ...seam,
    edit,
    name: edit.name ?? (seam.edit?.name ? seam.candidate.name : seam.name),
    length_mm: shape.s.at(-1),
    accepted: edit.accept ? !isRefused : edit.reject ? false : seam.accepted,
    closed: kind === "cut" ? false : kind === "join" ? distance(shape.p[0], shape.p.at(-1)) < SAME_MM : seam.closed,
    pending: seam.pending || JUDGED.has(kind),
  };
}

function shapesAfter(kind, frames, { row, s, other }) {
  const own = frames[row];
  if (kind === "turn") return [backwards(own)];
  if (kind === "otherSide") return [turned(own, [1, -1, -1])];
  if (kind === "cut") return [stretch(own, 0, s), stretch(own, s, own.s.at(-1))];
  if (kind === "join") return [joined(own, frames[other])];
  return [own];
}

/** Frames with axes multiplied by signs; + 0 leaves no negative zero. */
function turned(shape, signs) {
  return { ...shape, R: shape.R.map((rows) => rows.map((r) => r.map((v, axis) => signs[axis] * v + 0))) };
}

function backwards(shape) {
  const { s, p, R } = turned(shape, [-1, -1, 1]);
  return { s: s.map((v) => s.at(-1) - v).reverse(), p: p.toReversed(), R: R.toReversed() };
}

/** The part between two lengths; its ends are put between the frames around them. */
function stretch({ s, p, R }, low, high) {
  const rows = s.map((_, i) => i).filter((i) => s[i] > low && s[i] < high);
  const first = endAt({ s, p, R }, low);
  const last = endAt({ s, p, R }, high);
  return {
    s: [low, ...rows.map((i) => s[i]), high].map((v) => v - low),
    p: [first.p, ...rows.map((i) => p[i]), last.p],
    R: [first.R, ...rows.map((i) => R[i]), last.R],
  };
}

function endAt({ s, p, R }, at) {
  const i = Math.min(Math.max(s.findIndex((v) => v >= at) - 1, 0), s.length - 2);
  const share = (at - s[i]) / (s[i + 1] - s[i]);
  return { p: p[i].map((v, k) => v + share * (p[i + 1][k] - v)), R: share < 0.5 ? R[i] : R[i + 1] };
}

/** Two runs whose ends meet as one, in the direction of the first. */
function joined(one, two) {
  const [a, b] = [one.p[0], one.p.at(-1)];
  const [c, d] = [two.p[0], two.p.at(-1)];
  const ways = [
    [distance(b, c), one, two],
    [distance(b, d), one, backwards(two)],
    [distance(a, d), two, one],
    [distance(a, c), backwards(two), one],
  ].sort((x, y) => x[0] - y[0]);
  const [gap, first, last] = ways[0];
  const length = first.s.at(-1) + gap;
  const from = gap > SAME_MM ? 0 : 1; // a bridge has two ends
  return {
    s: [...first.s, ...last.s.slice(from).map((v) => v + length)],
    p: [...first.p, ...last.p.slice(from)],
    R: [...first.R, ...last.R.slice(from)],
  };
}
