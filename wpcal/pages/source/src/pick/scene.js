// The picker's 3-D view: the part in its own frame, the features that can be touched, and the result of the fit.
import { centreOf, motionFactor, motionPaths } from "../bodies.js";
import { drawOnTop, sides, toggles, tooltip } from "../controls.js";
import { el, facts, fixed } from "../dom.js";
import { legend, pointTip, seamTip } from "../report/explain.js";
import { arrow, fittingFactor } from "../residuals.js";
import { placesAlong } from "../seams/ends.js";
import { buildStage, checkBox, seeThroughBox } from "../stage.js";
import { cutControl, measureTool } from "../view_tools.js";
import { colourOf } from "../viewer.js";
import { FeatureMarks } from "./feature_marks.js";
import { Touching } from "./touching.js";

const KINDS = {
  V: "corners",
  C: "circles",
  H: "holes",
  S: "spheres",
  B: "bosses",
  M: "edge midpoints",
  E: "edge ends",
};
const SHOWN_AT_FIRST = ["V", "C", "H", "S", "B"]; // places without a mark on the part are shown on request
const FITTED = "#1d3f94";
const CHECKED = "#6d7682";
const WAITING = "#d99a1c";
const UNKNOWN_ERROR = "#c2410c";
const CANDIDATE = "#8a94a0";
const CHOSEN = "#1d5fa8";
const REACH_PX = 48; // from the pointer to the nearest feature
const SEAM_REACH_PX = 7;
const MOTIONS = "motions";
const COLOUR_STEPS = 100; // from zero to the tolerance

export class Scene {
  constructor(host, { features, seams, frames, part, tolerance, onPick, onSeam, onTouch, onSay }) {
    const label = "3-D view of the part; click a feature to add its row";
    const { viewer, stage, overlay } = buildStage(host, label, { wheel: "always" });
    Object.assign(this, { viewer, stage });
    Object.assign(this, { seams, frames, tolerance, u95: null, picks: [], selected: null });
    const solid = part && this.viewer.addPart(part, {});
    this.byName = new Map(features.map((feature) => [feature.name.toLowerCase(), feature]));
    const places = easiestAtEachPlace(features);
    const letters = Object.keys(KINDS).filter((letter) => places.some((feature) => feature.letter === letter));
    this.marks = new FeatureMarks(this.viewer);
    for (const letter of letters) {
      const these = places.filter((feature) => feature.letter === letter);
      this.marks.add(letter, these, REACH_PX);
    }
    this.addSeams();
    this.answerToPointer(onPick, onSeam);
    this.factor = el("span", { class: "factor", "data-test": "factor" });
    const measure = measureTool(this.viewer).element;
    this.touching = new Touching(this.viewer, { onTouch, onSay, other: measure.querySelector("input") });
    this.panelElement = this.panel(letters, overlay, [
      part && seeThroughBox(solid),
      measure,
      part && cutControl(viewer),
    ]);
    host.append(this.panelElement);
    this.legend = el("div", { hidden: true }, legend(tolerance)); // there are no errors yet
    this.stage.append(sides(this.viewer), this.legend, this.factor);
    this.viewer.view("iso");
    this.radius = this.viewer.extent().radius;
  }

  panel(letters, overlay, tools) {
    const items = [
      ...letters.map((letter) => ({ label: KINDS[letter], layers: [letter], on: SHOWN_AT_FIRST.includes(letter) })),
      { label: "seams", layers: ["seams"], on: true },
      { label: "refused", layers: ["refused"], on: false },
      { label: "touches", layers: ["touches"], on: true },
      { label: "motions", layers: [MOTIONS], on: true },
    ];
    const named = checkBox("names", (isOn) => (overlay.hidden = !isOn), { checked: true });
    return el("div", { class: "panel" }, toggles(this.viewer, items), named, tools, this.touching.element);
  }

  answerToPointer(onPick, onSeam) {
    const tip = tooltip(this.stage);
    this.viewer.onHover((found) => {
      this.viewer.clear("hovered");
      if (!found) return tip.hide();
      if (found.data.seam) return tip.show(this.wordsOfSeam(found), found);
      const feature = this.featureOf(found);
      if (feature) this.mark("hovered", feature.p_mm, 20);
      const pick = found.data.picks?.[found.index] ?? this.picks.find((one) => one.feature === feature);
      return tip.show(el("div", {}, feature && wordsOf(feature), pick?.point && pointTip(pick.point)), found);
    });
    this.viewer.onPick((found) => {
      if (found?.data.seam) return onSeam(found.data.row, (found.data.s ?? this.frames[found.data.row].s)[found.index]);
      const feature = found && this.featureOf(found);
      if (feature) onPick(feature);
    });
  }

  /** A ring around the point of a feature. */
  mark(layer, p, size) {
    this.viewer.addPoints(layer, [{ p, color: UNKNOWN_ERROR }], { size }).renderOrder = -1; // below the point itself
  }

  featureOf({ data, index }) {
    return data.features?.[index] ?? data.picks?.[index].feature ?? null;
  }

  wordsOfSeam({ data: { seam, row, rows }, index }) {
    return seamTip(seam, { ...this.frames[row], u95: this.u95?.[row] ?? null }, rows ? rows[index] : index);
  }

  /** Other seams than those before: after a decision. */
  takeSeams({ seams, frames }) {
    Object.assign(this, { seams, frames, u95: null });
    for (const layer of ["seams", "refused", "chosen seam"]) this.viewer.clear(layer);
    this.addSeams();
    this.legend.hidden = true; // until the errors of these seams are there
  }

  /** A line over the seam that is edited, and a point where it starts. */
  chooseSeam(row) {
    this.viewer.clear("chosen seam");
    if (row === null) return;
    const { p } = this.frames[row];
    const places = placesAlong(this.frames[row]);
    const data = { seam: this.seams[row], row, ...places };
    this.viewer.addTargets("chosen seam", places.p, data, { priority: 2, radius: SEAM_REACH_PX });
    this.viewer.addPaths("chosen seam", [{ points: p, color: CHOSEN }], { width: 9, opacity: 0.6 });
    this.viewer.addPoints("chosen seam", [{ p: p[0], color: CHOSEN }], { size: 14 });
    const box = this.panelElement.querySelector("input[data-layer=refused]");
    if (!this.seams[row].accepted && !box.checked) box.click();
  }

  /** Lines along the borders of the faces of a member: pairs of points. */
  markMember(pairs) {
    this.viewer.clear("member");
    const paths = pairs.map((points) => ({ points, color: CHOSEN }));
    if (paths.length) drawOnTop(this.viewer.addPaths("member", paths, { width: 4 }));
  }

  /** Lines, names and targets of the seams; errors only change the colours of the lines. */
  addSeams() {
    this.accepted = this.seams
      .map((seam, row) => ({ seam, row, p: this.frames[row].p }))
      .filter(({ seam }) => seam.accepted);
    for (const { seam, row, p } of this.accepted) {
      this.viewer.addTargets("seams", p, { seam, row }, { priority: -1, radius: SEAM_REACH_PX });
      this.viewer.addLabels("seams", [{ p: p[Math.floor(p.length / 2)], text: seam.name }], { className: "of-seam" });
    }
    this.lines = this.viewer.addPaths("seams", this.seamPaths(), { width: 5 });
    const refused = this.seams.map((seam, row) => ({ seam, row })).filter(({ seam }) => !seam.accepted);
    const paths = refused.map(({ row }) => ({ points: this.frames[row].p, color: CANDIDATE }));
    if (paths.length) this.viewer.addPaths("refused", paths, { width: 3 });
    for (const { seam, row } of refused)
      this.viewer.addTargets("refused", this.frames[row].p, { seam, row }, { priority: -1, radius: SEAM_REACH_PX });
  }

  seamPaths() {
    const colours = new Map(); // steps of 1 % are not visible; rounded up: beyond the tolerance stays beyond
    const colour = (mm) => {
      const step = Math.ceil((COLOUR_STEPS * mm) / this.tolerance);
      return colours.get(step) ?? colours.set(step, colourOf(step / COLOUR_STEPS)).get(step);
    };
    return this.accepted.map(({ row, p }) =>
      this.u95 ? { points: p, colors: this.u95[row].map(colour) } : { points: p, color: UNKNOWN_ERROR },
    );
  }

  colourSeams(u95) {
    if (!u95 && !this.u95) return;
    this.u95 = u95;
    this.viewer.recolour(this.lines, this.seamPaths());
    this.legend.hidden = !u95;
  }

  /** Marks the places of the rows of the table, with their residuals. */
  show(rows, { points = [], features = {}, u95_mm = null, bodies = null }) {
    const byRow = new Map(points.map((point) => [point.row, point]));
    const picks = rows.rows
      .map((row, index) => ({
        row,
        point: byRow.get(index),
        feature: this.featureNamed(row.feature || features[index]),
      }))
      .map((pick, row) => ({ ...pick, p: pick.point?.p_part_mm ?? pick.feature?.p_mm ?? this.touching.placeOf(row) }))
      .filter(({ p }) => p);
    this.picks = picks;
    this.viewer.clear("picked");
    const colour = ({ row, point }) =>
      point ? (point.use === "check" ? CHECKED : FITTED) : row.use === "no" ? CANDIDATE : WAITING;
    if (picks.length)
      this.viewer.addPoints(
        "picked",
        picks.map((pick) => ({ p: pick.p, color: colour(pick) })),
        { size: 14 },
      );
    this.viewer.addTargets(
      "picked",
      picks.map(({ p }) => p),
      { picks },
      { priority: 0, radius: REACH_PX },
    );
    this.viewer.addLabels(
      "picked",
      picks.map(({ p, row }) => ({ p, text: row.name })),
      { className: "of-point", priority: 1 },
    );
    this.select(this.selected);
    this.drawResiduals(points);
    this.drawMotions(bodies?.bodies ?? []);
    this.colourSeams(u95_mm);
  }

  /** The motions of bodies as arrows and arcs, in the frame of the part. */
  drawMotions(bodies) {
    this.viewer.clear(MOTIONS);
    if (!bodies.length) return;
    const factor = motionFactor(bodies, this.radius);
    drawOnTop(this.viewer.addPaths(MOTIONS, motionPaths(bodies, null, factor, this.radius), { width: 3 }));
    const labels = bodies.map((body) => ({ p: centreOf(body, null), text: body.name }));
    this.viewer.addLabels(MOTIONS, labels, { className: "of-body" });
    this.factor.textContent += `${this.factor.textContent ? ", " : ""}motions × ${factor}`;
  }

  drawResiduals(points) {
    this.viewer.clear("residuals");
    const factor = fittingFactor(
      points.map(({ distance_mm }) => distance_mm),
      this.radius,
    );
    const along = ({ p_part_mm, residual_part_mm }) => arrow(p_part_mm, residual_part_mm, factor);
    if (points.length) this.viewer.addPaths("residuals", points.flatMap(along), { width: 3 });
    this.factor.textContent = points.length ? `residuals drawn × ${factor}` : "";
  }

  featureNamed(name) {
    return name ? this.byName.get(name.toLowerCase()) : null;
  }

  /** Shows where a row of the table is. */
  select(row) {
    this.selected = row;
    this.viewer.clear("selected");
    const p = this.picks.find((pick) => pick.row === row)?.p ?? this.featureNamed(row?.feature)?.p_mm;
    if (p) this.mark("selected", p, 26);
  }
}

/** The features to show: at one place (a hole and its rim) only the one that is easiest to touch, which comes first. */
function easiestAtEachPlace(features) {
  const key = ({ p_mm }) => p_mm.map((v) => Math.round(v * 1e3)).join();
  return [...new Map(features.toReversed().map((feature) => [key(feature), feature])).values()].reverse();
}

function wordsOf(feature) {
  const sizes = [
    feature.diameter_mm && `⌀ ${fixed(feature.diameter_mm)} mm`,
    feature.depth_mm && `${fixed(feature.depth_mm)} mm deep`,
    feature.length_mm && `${fixed(feature.length_mm)} mm long`,
  ];
  const size = sizes.filter(Boolean).join(", ");
  const rows = [
    size && ["size", size],
    ["touch", `${feature.touch}, ${feature.ease}`],
    ["on", feature.solid],
    ["model x, y, z", `${feature.p_mm.map((v) => fixed(v)).join(", ")} mm`],
  ];
  const kind = el("span", { class: "kind" }, feature.kind.replaceAll("_", " "));
  return el("div", {}, el("strong", {}, feature.name), " ", kind, facts(rows.filter(Boolean)));
}
