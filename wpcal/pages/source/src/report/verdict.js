// The head of the report: are the seams shown to be within the tolerance, and how large are the errors.
import { el, fixed } from "../dom.js";
import { gauge } from "../shares.js";
import { plural, verdictText } from "../words.js";

/** The largest distance of a point, fitted or checked. */
function worstPoint(points) {
  return points.reduce((worst, point) => (point.distance_mm > worst.distance_mm ? point : worst));
}

/** The seam that the verdict names. */
function worstSeam({ judgement }, seams, frames) {
  const row = seams.findIndex(({ name, accepted }) => accepted && name === judgement?.seam);
  return frames[row]?.u95 ? { name: seams[row].name, u95: Math.max(...frames[row].u95) } : null;
}

export function verdict(calibration, seams, frames) {
  const { tolerance_mm: tolerance, points, inputs = {} } = calibration;
  const point = worstPoint(points);
  const where = calibration.suspect ? null : `at ${point.name}`; // a wrong point makes residuals at right ones, too
  const seam = worstSeam(calibration, seams, frames);
  const accepted = seams.filter((one) => one.accepted);
  const length = accepted.reduce((sum, one) => sum + one.length_mm, 0);
  const checked = points.filter(({ use }) => use === "check").length;
  const counts = [
    `${plural(points.length - checked, "point")} fitted${checked ? `, ${checked} checked` : ""}`,
    `${plural(accepted.length, "seam")}, ${fixed(length, 0)} mm`,
  ];
  return el(
    "header",
    { class: calibration.verdict.toLowerCase() },
    el(
      "div",
      { class: "title" },
      el("p", { class: "eyebrow" }, "Calibration"),
      el("h1", {}, inputs.part?.file ?? "part"),
      el("p", {}, counts.join(" · ")),
    ),
    el(
      "div",
      { class: "verdict" },
      el("span", { class: "stamp" }, calibration.verdict),
      el("p", {}, verdictText(calibration)),
      calibration.criterion_advice && el("p", {}, calibration.criterion_advice),
    ),
    el(
      "div",
      { class: "gauges" },
      gauge("largest residual", point.distance_mm, tolerance, where),
      seam && gauge("largest 95 % error of a seam", seam.u95, tolerance, `on ${seam.name}`),
    ),
  );
}
