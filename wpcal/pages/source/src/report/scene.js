// The report's 3-D view: the part where it is, the seams in the colours of their errors, the taught points.
import { centreOf, motionFactor, motionPaths, movesOfSolids } from "../bodies.js";
import { factorSlider, sides, toggles, tooltip } from "../controls.js";
import { el } from "../dom.js";
import { arrow, FACTORS, fittingFactor } from "../residuals.js";
import { buildStage, seeThroughBox } from "../stage.js";
import { cutControl, measureTool } from "../view_tools.js";
import { clearDirection, colourOf, seenFrom } from "../viewer.js";
import { bodyTip, legend, pointTip, seamTip } from "./explain.js";

const FITTED = "#1d3f94";
const CHECKED = "#6d7682";
const CANDIDATE = "#8a94a0";
const MODEL = "model";
const GHOST = "#c77d0a"; // edges at their place in the model
const MOST_TRIADS = 600; // more would cover the part
const TRIAD_PART = 0.035; // of the radius of everything
const OBLIQUE = [-0.62, -0.68, 0.5]; // from the front, the left and above
const AROUND_SEAM = 0.15; // of the radius of everything: shown around a seam that the view looks at

/** Builds the view inside `host` and returns it. */
export function buildScene(host, { calibration, seams, frames, part }) {
  const label = "3-D view of the part, its seams and the taught points";
  const { viewer, stage } = buildStage(host, label);
  const { bodies, T_base_part: T, tolerance_mm: tolerance } = calibration;
  const solid = part && viewer.addPart(part, { T, moves: bodies && movesOfSolids(bodies) });
  if (part && bodies) viewer.addPart(part, { name: MODEL, T, edge: GHOST });
  viewer.show(MODEL, false); // its edges are enough
  const lines = addSeams(viewer, seams, frames, tolerance);
  addPoints(viewer, calibration.points);
  const radius = viewer.extent().radius;
  addFrames(viewer, frames, radius * TRIAD_PART);
  const sliders = [residualControl(viewer, calibration.points, radius)];
  const legends = { "95 % error": legend(tolerance) };
  if (bodies) {
    sliders.push(motionControl(viewer, bodies, T, radius));
    legends["error across"] = legend(tolerance, "95 % error across the seam, mm");
    legends["error across"].hidden = true;
    legends.gap = legend(bodies.gap_limit_mm, "gap between the bodies, mm");
    legends.gap.hidden = true;
    sliders.push(colourChoice(viewer, legends, lines, { seams, frames, tolerance, limit: bodies.gap_limit_mm }));
  }
  const tip = tooltip(stage);
  viewer.onHover((found) => showTip(viewer, tip, found, frames, radius * TRIAD_PART));
  const panel = el(
    "div",
    { class: "panel" },
    toggles(viewer, layersOf(seams, part, bodies)),
    part && seeThroughBox(solid),
    sliders,
    measureTool(viewer).element,
    part && cutControl(viewer),
  );
  stage.append(sides(viewer), ...Object.values(legends));
  host.append(panel);
  viewer.view(bestSide(viewer, seams, frames));
  return viewer;
}

/** The oblique side from which most of the seams are seen that are welded. */
function bestSide(viewer, seams, frames) {
  const middles = frames.filter((_, row) => seams[row].accepted).map(({ p }) => p[Math.floor(p.length / 2)]);
  const [x, y, z] = OBLIQUE;
  const sides = [OBLIQUE, [-x, y, z], [x, -y, z], [-x, -y, z]];
  const seen = sides.map((side) => seenFrom(viewer, middles, side));
  return sides[seen.indexOf(Math.max(...seen))];
}

/** Shows one seam with its surroundings, from a side near that of the torch on which nothing is in front of it. */
export function lookAtSeam(viewer, { p, R }) {
  const outward = [0, 1, 2].map((row) => R.reduce((sum, axes) => sum + axes[row][2], 0) / R.length);
  const isRound = Math.hypot(...outward) < 0.3; // around a pipe the directions cancel each other
  const room = AROUND_SEAM * viewer.extent().radius;
  const steps = [-room, room].flatMap((d) => [
    [d, 0, 0],
    [0, d, 0],
    [0, 0, d],
  ]);
  const around = p.flatMap((place) => steps.map((step) => place.map((v, i) => v + step[i])));
  const aside = [0, 1, 2].map((row) => R[0][row][0]); // seen from straight ahead, edges hide each other
  const wanted = isRound ? OBLIQUE : outward.map((v, i) => v + 0.35 * aside[i]);
  viewer.lookAt(around, clearDirection(viewer, p, wanted));
}

/** Shows one taught point with its surroundings. */
export function lookAtPoint(viewer, p) {
  const room = AROUND_SEAM * viewer.extent().radius;
  const around = [-room, room].flatMap((d) => [0, 1, 2].map((axis) => p.map((v, i) => (i === axis ? v + d : v))));
  viewer.lookAt(around, OBLIQUE);
}

function layersOf(seams, part, bodies) {
  const candidates = seams.some(({ accepted }) => !accepted);
  return [
    part && { label: "part", layers: ["part"], on: true },
    part && { label: "edges", layers: ["part edges"], on: true },
    { label: "seams", layers: ["seams"], on: true },
    candidates && { label: "candidates", layers: ["candidates"], on: false },
    { label: "frames", layers: ["frames"], on: false },
    { label: "taught points", layers: ["points"], on: true },
    { label: "residuals", layers: ["residuals"], on: true },
    bodies && { label: "motions", layers: ["motions drawn", "motions"], on: true },
    bodies && part && { label: "place in the model", layers: [`${MODEL} edges`], on: false },
    { label: "names", layers: ["names"], on: true },
  ].filter(Boolean);
}

function addSeams(viewer, seams, frames, tolerance) {
  return seams.map((seam, row) => {
    const { p, u95 } = frames[row];
    const layer = seam.accepted ? "seams" : "candidates";
    const colors = u95 && seam.accepted ? u95.map((mm) => colourOf(mm / tolerance)) : null;
    const path = colors ? { points: p, colors } : { points: p, color: CANDIDATE };
    const line = viewer.addPaths(layer, [path], { width: seam.accepted ? 6 : 3 });
    viewer.addTargets(layer, p, { kind: "seam", seam, row });
    const middle = p[Math.floor(p.length / 2)];
    if (seam.accepted) viewer.addLabels("names", [{ p: middle, text: seam.name }], { className: "of-seam" });
    return { row, line };
  });
}

function addPoints(viewer, points) {
  const places = points.map(({ p_base_mm: p, use }) => ({ p, color: use === "yes" ? FITTED : CHECKED }));
  viewer.addPoints("points", places, { size: 13 });
  viewer.addTargets(
    "points",
    points.map(({ p_base_mm }) => p_base_mm),
    { kind: "point", points },
    { priority: 1 },
  );
  viewer.addLabels(
    "names",
    points.map(({ p_base_mm: p, name: text }) => ({ p, text })),
    { className: "of-point" },
  );
}

function addFrames(viewer, frames, length) {
  const all = frames.flatMap(({ p, R }) => p.map((place, i) => ({ p: place, R: R[i] })));
  const step = Math.ceil(all.length / MOST_TRIADS);
  viewer.addTriads(
    "frames",
    all.filter((_, i) => i % step === 0),
    length,
  );
}

/** A slider for the factor by which residuals are drawn longer. */
function residualControl(viewer, points, radius) {
  const distances = points.map(({ distance_mm }) => distance_mm);
  return factorSlider(viewer, {
    layer: "residuals",
    label: "residuals drawn",
    test: "factor",
    factors: FACTORS,
    start: fittingFactor(distances, radius),
    pathsOf: (factor) => points.flatMap((point) => arrow(fittedPlace(point), point.residual_mm, factor)),
  });
}

/** The arrows and arcs of the bodies that moved, with their names and the slider of their factor. */
function motionControl(viewer, { bodies }, T, radius) {
  const places = bodies.map((body) => centreOf(body, T));
  viewer.addTargets("motions", places, { kind: "body", bodies }, { priority: 1 });
  viewer.addLabels(
    "names",
    bodies.map(({ name: text }, row) => ({ p: places[row], text })),
    { className: "of-body" },
  );
  return factorSlider(viewer, {
    layer: "motions drawn",
    label: "motions drawn",
    test: "motion-factor",
    factors: FACTORS,
    start: motionFactor(bodies, radius),
    pathsOf: (factor) => motionPaths(bodies, T, factor, radius),
    onTop: true, // they begin inside their bodies
  });
}

/** Colours the seams by their 95 % error, or by the gap between their bodies. */
function colourChoice(viewer, legends, lines, { seams, frames, tolerance, limit }) {
  const scales = {
    "95 % error": { of: ({ u95 }) => u95, full: tolerance },
    "error across": { of: ({ across }) => across, full: tolerance },
    gap: { of: ({ gap }) => gap?.map(Math.abs), full: limit },
  };
  const choose = (name) => {
    const { of, full } = scales[name];
    for (const { row, line } of lines) {
      const colors = of(frames[row])?.map((mm) => colourOf(mm / full));
      if (colors && seams[row].accepted) viewer.recolour(line, [{ points: frames[row].p, colors }]);
    }
    for (const [of, legend] of Object.entries(legends)) legend.hidden = of !== name;
  };
  const names = Object.keys(scales);
  const select = el(
    "select",
    { "data-test": "colour", onchange: () => choose(select.value) },
    names.map((name) => el("option", { value: name }, name)),
  );
  return el("label", { class: "choice" }, el("span", {}, "colours"), select);
}

function fittedPlace({ p_base_mm: taught, residual_mm: r }) {
  return taught.map((v, i) => v - r[i]);
}

function showTip(viewer, tip, found, frames, length) {
  viewer.clear("hovered");
  if (!found) return tip.hide();
  const { data, index } = found;
  if (data.kind === "body") return tip.show(bodyTip(data.bodies[index]), found);
  if (data.kind === "point") return tip.show(pointTip(data.points[index]), found);
  const of = frames[data.row];
  viewer.addTriads("hovered", [{ p: of.p[index], R: of.R[index] }], 1.6 * length, { width: 3 });
  return tip.show(seamTip(data.seam, of, index), found);
}
