// The words in the view: tooltips and the legend of its colours.
import { el, facts, fixed, short, signed } from "../dom.js";
import { BEYOND, ramp } from "../viewer.js";

function place(p) {
  return p.map((v) => fixed(v)).join(", ");
}

/** One frame of a seam. */
export function seamTip(seam, { s, p, u95, slope, rotation, position, across, placing, unseen, gap }, i) {
  const rows = [
    ["arc length", `${fixed(s[i])} of ${fixed(seam.length_mm)} mm`],
    ["x, y, z", `${place(p[i])} mm`],
  ];
  if (slope) {
    const turn = rotation[i] === null ? "undefined" : `${fixed(rotation[i], 1)}°`;
    rows.push(["slope / rotation", `${fixed(slope[i], 1)}° / ${turn}${position[i] ? ` (${position[i]})` : ""}`]);
  }
  if (u95) rows.push(["95 % error", `${fixed(u95[i], 4)} mm`]);
  if (across) rows.push(["across the seam", `${fixed(across[i], 4)} mm`]);
  if (placing) rows.push(["from placing / not seen", `${fixed(placing[i], 4)} / ${fixed(unseen[i], 4)} mm`]);
  if (gap) rows.push(["gap", `${fixed(gap[i], 2)} mm`]);
  const kind = `${seam.joint} ${seam.weld}${seam.accepted ? "" : ", candidate"}`;
  return el("div", {}, el("strong", {}, seam.name), " ", el("span", { class: "kind" }, kind), facts(rows));
}

/** One taught point. */
export function pointTip({ name, use, p_base_mm, residual_mm, distance_mm, error_95_mm }) {
  const rows = [
    ["taught", `${place(p_base_mm)} mm`],
    ["residual", `${residual_mm.map((v) => signed(v, 4)).join(", ")} mm`],
    ["distance", `${fixed(distance_mm, 4)} mm`],
    ["95 % error", `${fixed(error_95_mm, 4)} mm`],
  ];
  const kind = use === "check" ? "check point, not fitted" : "taught point";
  return el("div", {}, el("strong", {}, name), " ", el("span", { class: "kind" }, kind), facts(rows));
}

/** One body that may have moved. */
export function bodyTip({ name, touches, moved_mm, turned_mrad, sigma_mm, sigma_mrad, sigmas, has_moved: hasMoved }) {
  const withSigma = (values, sigmas, digits) =>
    values.map((value, i) => `${signed(value, digits)} ± ${fixed(sigmas[i], digits)}`).join(", ");
  const rows = [
    ["moved x, y, z", `${withSigma(moved_mm, sigma_mm, 2)} mm`],
    ["turned x, y, z", `${withSigma(turned_mrad, sigma_mrad, 1)} mrad`],
    ["evidence", `${fixed(sigmas, 1)} sigma, ${touches} touches`],
  ];
  const kind = touches ? (hasMoved ? "has moved" : "not shown to have moved") : "never touched";
  return el("div", {}, el("strong", {}, name), " ", el("span", { class: "kind" }, kind), facts(rows));
}

/** The colour scale of the seams. */
export function legend(tolerance, title = "95 % error of the seam, mm") {
  const bar = el("div", { class: "ramp" });
  bar.style.background = ramp();
  const ticks = [0, 0.5, 1].map((share) => el("span", {}, short(share * tolerance)));
  const beyond = el("div", { class: "ramp" });
  beyond.style.background = BEYOND;
  const scale = el(
    "div",
    { class: "scale" },
    bar,
    beyond,
    el("div", { class: "ticks" }, ticks),
    el("span", {}, "more"),
  );
  return el("div", { class: "legend" }, el("div", {}, title), scale);
}
