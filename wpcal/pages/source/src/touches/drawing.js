// How searches are drawn: an arrow to the face, the rest of the stroke, the way before and after it, the wire.
import { arrow } from "../residuals.js";

export const SEARCH = "#b3202e";
const BEYOND = "#d99a1c";
const AIR = "#2f7bd9";
const RETRACT = "#7d8a98";
const TOOL = "#17202a";

/**
 * Draws searches into the layers searches, strokes, ways, retracts and numbers.
 *
 * @param {number} least  mm: a shorter way to the face has a longer arrow
 */
export function drawSearches(viewer, searches, least) {
  searches.forEach(({ name, start, planned, end, approach, retract, via }, row) => {
    const d = planned.map((v, i) => v - start[i]);
    const factor = Math.max(1, least / Math.hypot(...d));
    const tail = planned.map((v, i) => v - factor * d[i]);
    viewer.addPaths("searches", arrow(tail, d, factor, SEARCH), { width: 4 });
    viewer.addPaths("strokes", [{ points: [start, end], color: BEYOND }], { width: 3, dashed: true });
    viewer.addPaths("ways", [{ points: [...via, approach, start], color: AIR }], { width: 2 });
    viewer.addPaths("retracts", [{ points: [start, retract], color: RETRACT }], { width: 2, dashed: true });
    viewer.addTargets("searches", [tail, start, middle(tail, planned), planned], row);
    viewer.addLabels("numbers", [{ p: tail, text: `${row + 1} ${name}` }], { className: "of-point", priority: 1 });
  });
}

/** Arrows that show the order of the searches. */
export function drawOrder(viewer, searches) {
  searches.slice(1).forEach((search, k) => {
    const points = [searches[k].retract, ...search.via, search.approach];
    viewer.addPaths("ways", [{ points, color: AIR }], { width: 1.5, dashed: true });
  });
}

/** The wire with the tool centre point at the origin of a layer that is moved. */
export function drawTool(viewer, layer, stickOut, nozzle) {
  const back = [0, 0, -stickOut];
  viewer.addPaths(layer, [{ points: [[0, 0, 0], back], color: TOOL }], { width: 4 });
  viewer.addPaths(layer, [{ points: [back, [0, 0, -stickOut - nozzle]], color: TOOL }], { width: 11, opacity: 0.6 });
}

/** Where the tool's layer is: row-major 4×4. */
export function toolPlace(R, p) {
  return [...R.map((axes, row) => [...axes, p[row]]), [0, 0, 0, 1]];
}

function middle(a, b) {
  return a.map((v, i) => (v + b[i]) / 2);
}
