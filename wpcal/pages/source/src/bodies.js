// Bodies that moved: their motions as arrows and arcs, and their table. The report and the picker show both.
import { el, fixed, table } from "./dom.js";
import { arrow, fittingFactor } from "./residuals.js";
import { acrossTo, cross, normalised } from "./vectors.js";

const MOVED = "#14181d"; // shown to have moved
const STILL = "#4a5563"; // the touches do not show it
const ARC_PART = 0.15; // radius of the arc of a turn, of the radius of everything
const MOST_TURN = 5; // rad: a longer arc would close
const ARC_STEP = 0.1; // rad
const LEAST_P = 0.001;

/** The turn of a transform (row-major 4×4; null: the identity) on a direction. */
function turned(T, v) {
  return T ? T.slice(0, 3).map((row) => row[0] * v[0] + row[1] * v[1] + row[2] * v[2]) : v;
}

/** Where a body's centre is drawn, after its motion. */
export function centreOf({ centre_part_mm: c, moved_mm: v }, T) {
  const p = c.map((value, i) => value + v[i]);
  return T ? turned(T, p).map((value, i) => value + T[i][3]) : p;
}

/** The factor by which the motions of bodies can be drawn longer. */
export function motionFactor(bodies, radius) {
  const arc = ({ turned_mrad }) => 1e-3 * Math.hypot(...turned_mrad) * ARC_PART * radius;
  return fittingFactor(
    bodies.flatMap((body) => [Math.hypot(...body.moved_mm), arc(body)]),
    radius,
  );
}

/** An arrow for the motion of every touched body, and an arc for its turn, both `factor` times as large as they are. */
export function motionPaths(bodies, T, factor, radius) {
  return bodies
    .filter(({ touches }) => touches)
    .flatMap((body) => {
      const color = body.has_moved ? MOVED : STILL;
      const centre = centreOf(body, T);
      const from = centre.map((value, i) => value - turned(T, body.moved_mm)[i]);
      return [
        ...arrow(from, turned(T, body.moved_mm), factor, color),
        ...arc(from, turned(T, body.turned_mrad), factor, radius * ARC_PART, color),
      ];
    });
}

/** A turn as an arc about its axis, with two barbs at its end. */
function arc(centre, omegaMrad, factor, radius, color) {
  const size = Math.hypot(...omegaMrad);
  const angle = Math.min(1e-3 * size * factor, MOST_TURN);
  if (angle < 1e-3) return [];
  const axis = normalised(omegaMrad);
  const [x] = acrossTo(axis);
  const y = cross(axis, x);
  const at = (a, r = radius) => centre.map((v, i) => v + r * (Math.cos(a) * x[i] + Math.sin(a) * y[i]));
  const count = Math.ceil(angle / ARC_STEP);
  const points = Array.from({ length: count + 1 }, (_, i) => at((angle * i) / count));
  const back = Math.min(0.25, 0.4 * angle);
  const barbs = [0.85, 1.15].map((share) => [at(angle), at(angle - back, share * radius)]);
  return [points, ...barbs].map((path) => ({ points: path, color }));
}

function probability(p) {
  return p < LEAST_P ? `< ${LEAST_P}` : fixed(p, 3);
}

/** Motion, turn and evidence of every body; `focus` is called with the body of a line that is clicked. */
export function bodiesTable({ bodies }, focus = null) {
  const touched = (show) => (body) => (body.touches ? show(body) : "–");
  const columns = [
    { title: "body", cell: ({ name }) => el("strong", {}, name) },
    { title: "moved mm", number: true, cell: touched(({ moved_mm }) => fixed(Math.hypot(...moved_mm), 2)) },
    { title: "turned mrad", number: true, cell: touched(({ turned_mrad }) => fixed(Math.hypot(...turned_mrad), 1)) },
    { title: "sigma", number: true, cell: touched(({ sigmas }) => fixed(sigmas, 1)) },
    { title: "p", number: true, cell: touched(({ p_still }) => probability(p_still)) },
    { title: "touches", number: true, cell: ({ touches }) => String(touches) },
    {
      title: "tack tolerance",
      cell: ({ tack_mm, tack_mrad }) =>
        `${Number(tack_mm.toPrecision(3))} mm, ${Number(tack_mrad.toPrecision(3))} mrad`,
    },
  ];
  const rowOf = (body) => ({
    class: [!body.has_moved && "dim", focus && "link"].filter(Boolean).join(" ") || null,
    title: focus && "show in the view",
    onclick: focus && (() => focus(body)),
  });
  const caption =
    "How far each body is from its place in the model. sigma, p: how strongly the touches say that a body moved; " +
    "p is corrected for the number of bodies. A body without touches has no numbers: its place rests on the tolerance.";
  return table(columns, bodies, { rowOf, caption });
}

/** Both parts of the error of every seam, the gap between its bodies, and which of them were never touched. */
export function seamsOfBodiesTable({ seams, gap_limit_mm: limit }, focus = null) {
  const gap = ({ gap_min_mm: low, gap_max_mm: high, gap_u95_mm: error }) =>
    el(high > limit ? "strong" : "span", {}, `${fixed(low, 2)} … ${fixed(high, 2)} ± ${fixed(error, 2)}`);
  const columns = [
    { title: "seam", cell: ({ seam }) => el("strong", {}, seam) },
    { title: "bodies", cell: ({ bodies }) => bodies.join(" + ") },
    { title: "95 % error mm", number: true, cell: ({ u95_mm }) => fixed(u95_mm, 3) },
    { title: "across mm", number: true, cell: ({ u95_across_mm }) => fixed(u95_across_mm, 3) },
    { title: "from placing mm", number: true, cell: ({ u95_placing_mm }) => fixed(u95_placing_mm, 3) },
    { title: "not seen mm", number: true, cell: ({ u95_unseen_mm }) => fixed(u95_unseen_mm, 3) },
    { title: "gap mm", number: true, cell: gap },
    { title: "never touched", cell: ({ never_touched }) => never_touched.join(", ") },
  ];
  const rowOf = (seam) => ({ class: focus && "link", onclick: focus && (() => focus(seam.seam)) });
  const caption =
    "Across: the part of the error across the seam; the rest is along it and moves its ends only. " +
    "From placing: the errors of the touches. Not seen: motions of bodies that no touch saw. " +
    `Bold: a gap wider than ${limit} mm (--gap-mm). A negative gap is an overlap.`;
  return table(columns, seams, { rowOf, caption });
}

/** The sentences that say whether bodies moved, and on which tolerances the answer rests. */
export function bodiesWords({ sentence, tolerances_sentence: tolerances }) {
  return [sentence, tolerances].map((text) => `${text.charAt(0).toUpperCase()}${text.slice(1)}.`);
}

/** Where the solids of a model are after their bodies moved: row-major 4×4 by the name of the solid. */
export function movesOfSolids({ bodies }) {
  return new Map(bodies.flatMap(({ solids, T_part_moved: T }) => solids.map((name) => [name, T])));
}
