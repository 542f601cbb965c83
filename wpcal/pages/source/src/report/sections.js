// The sections of the report below the view: tables, charts and the sources.
import { bodiesTable, bodiesWords, seamsOfBodiesTable } from "../bodies.js";
import { el, facts, fixed, short, signed, table } from "../dom.js";
import { bar, divided, swatch } from "../shares.js";
import { plural } from "../words.js";
import { annealingPlot, errorPlot } from "./plots.js";

const CRITERIA = { minimax: "minimax", least_squares: "least squares", weighted: "weighted", robust: "robust" };

const EQUAL =
  "Minimax makes its largest residuals equal by construction: they do not show which point is worst. " +
  "The notes name a point that the others contradict.";

function section(id, title, ...content) {
  return el("section", { id, "aria-labelledby": `${id}-title` }, el("h2", { id: `${id}-title` }, title), content);
}

/** Why a candidate is not a seam; nothing for an accepted one. */
export function whyNot({ accepted, against = [], edit }) {
  if (accepted) return "";
  return [...(edit?.accept === false ? ["rejected by hand"] : []), ...against].join("; ");
}

/** Whether bodies moved, and which; null for a part that was fitted as one piece. */
export function bodiesSection({ bodies }, focus = null, focusSeam = null) {
  if (!bodies) return null;
  const [sentence, tolerances] = bodiesWords(bodies);
  return section(
    "bodies",
    "Bodies that may have moved",
    el("p", { class: "sentence" }, sentence),
    el("p", { class: "caption" }, tolerances),
    bodiesTable(bodies, focus),
    bodies.seams.length ? el("h3", {}, "Seams where the moved faces meet") : null,
    bodies.seams.length ? seamsOfBodiesTable(bodies, focusSeam) : null,
  );
}

export function seamsSection(seams, frames, tolerance, focus) {
  const rows = seams.map((seam, row) => ({ ...seam, row, ...frames[row] }));
  const worst = ({ u95 }) => (u95 ? Math.max(...u95) : null);
  const columns = [
    { title: "seam", cell: ({ name }) => el("strong", {}, name) },
    { title: "95 % error mm", number: true, cell: (row) => fixed(worst(row), 3) },
    { title: "", cell: (row) => (worst(row) === null ? "" : bar(worst(row), tolerance)) },
    { title: "joint", cell: ({ joint, weld }) => `${joint} ${weld}` },
    { title: "joins", cell: ({ solids }) => solids.join(" + ") },
    { title: "length mm", number: true, cell: ({ length_mm }) => fixed(length_mm, 1) },
    { title: "frames", number: true, cell: ({ s }) => String(s.length) },
    { title: "position", cell: ({ position }) => [...new Set(position ?? [])].filter(Boolean).join(", ") || "–" },
  ];
  const rowOf = ({ row, accepted }) => ({
    class: accepted ? "link" : "link dim",
    title: accepted ? "show in the view" : "a candidate that was not accepted as a seam",
    onclick: () => focus(row),
  });
  const plot = errorPlot(seams, frames, tolerance);
  const none = "The part has no seam that wpcal recognises.";
  const [taken, refused] = [rows.filter(({ accepted }) => accepted), rows.filter(({ accepted }) => !accepted)];
  const because = { title: "not accepted because", cell: whyNot };
  const folded = refused.length > 0 && [
    el("summary", {}, `${refused.length} candidates that are not accepted`),
    table([...columns, because], refused, { rowOf }),
  ];
  return section(
    "seams",
    "Seams",
    rows.length ? table(columns, taken, { rowOf }) : el("p", {}, none),
    folded && el("details", { "data-test": "refused" }, ...folded),
    plot,
  );
}

export function pointsSection({ points, tolerance_mm, criterion }, focus = null) {
  const columns = [
    { title: "point", cell: ({ name }) => el("strong", {}, name) },
    { title: "use", cell: ({ use }) => (use === "check" ? "check" : "fit") },
    { title: "95 % error mm", number: true, cell: ({ error_95_mm }) => fixed(error_95_mm, 4) },
    { title: "distance mm", number: true, cell: ({ distance_mm }) => fixed(distance_mm, 4) },
    { title: "", cell: ({ distance_mm }) => bar(distance_mm, tolerance_mm) },
    ...vector("taught ", ({ p_base_mm }) => p_base_mm.map((v) => fixed(v, 3))),
    ...vector("residual ", ({ residual_mm }) => residual_mm.map((v) => signed(v, 4))),
  ];
  const rowOf = (point) => ({
    class: [point.distance_mm > tolerance_mm && "bad", focus && "link"].filter(Boolean).join(" ") || null,
    title: focus && "show in the view",
    onclick: focus && (() => focus(point)),
  });
  const caption =
    "Taught: as read from the robot. Residual: taught place minus fitted place. Both in the base frame. " +
    `The bar is full at the tolerance.${criterion === "minimax" ? ` ${EQUAL}` : ""}`;
  return section("points", "Taught points", table(columns, points, { rowOf, caption }));
}

function vector(word, texts) {
  return [0, 1, 2].map((axis) => ({
    title: `${word}${"xyz"[axis]} mm`,
    number: true,
    cell: (row) => texts(row)[axis],
  }));
}

export function criteriaSection({ criteria, criterion }) {
  if (!criteria) return null;
  const remark = (row) => {
    const remarks = [row.criterion === criterion && "used", row.criterion === criteria.best && "least predicted error"];
    return remarks.filter(Boolean).join(", ");
  };
  const columns = [
    { title: "criterion", cell: (row) => CRITERIA[row.criterion] ?? row.criterion },
    { title: "largest mm", number: true, cell: ({ largest_mm }) => fixed(largest_mm, 4) },
    { title: "RMS mm", number: true, cell: ({ rms_mm }) => fixed(rms_mm, 4) },
    { title: "95 % seam error mm", number: true, cell: ({ seam_error_95_mm }) => fixed(seam_error_95_mm, 4) },
    { title: "", cell: remark },
  ];
  const best = CRITERIA[criteria.best] ?? criteria.best;
  const why = `Least predicted error: ${best} (${criteria.why}).`;
  return section("criteria", "Criteria on the same data", table(columns, criteria.rows), el("p", {}, why));
}

const MOST_SEAMS = 8; // of the budget, those with the largest errors

/** What the predicted errors consist of; null where bodies moved, which have errors of their own. */
export function budgetSection({ budget, bodies }) {
  if (!budget?.seams.length || bodies) return null;
  const parts = budget.contributions.filter(({ name }) => budget.seams.some(({ shares }) => shares[name] >= 0.001));
  const percent = ({ shares }) => parts.map(({ name }) => `${name} ${fixed(100 * shares[name], 0)} %`).join(", ");
  const columns = [
    { title: "seam", cell: ({ seam }) => el("strong", {}, seam || "fitted points") },
    { title: "95 % error mm", number: true, cell: ({ error_95_mm }) => fixed(error_95_mm, 3) },
    { title: "u mm", number: true, cell: (row) => fixed(row.standard_uncertainty_mm, 3) },
    { title: "k", number: true, cell: ({ coverage_factor }) => (coverage_factor ? fixed(coverage_factor, 2) : "–") },
    { title: "", cell: ({ shares }) => divided(parts.map(({ name }) => shares[name])) },
    { title: "shares of the variance", cell: percent },
  ];
  const worstFirst = [...budget.seams].sort((a, b) => b.error_95_mm - a.error_95_mm).slice(0, MOST_SEAMS);
  const legend = parts.map(({ name, type, source }, k) =>
    el("li", {}, swatch(k), ` ${name} (type ${type}): ${source}`),
  );
  const caption =
    "Where the error of each seam comes from, at its worst point: standard uncertainty u, coverage factor k, and the " +
    "share of each contribution (type A: from these touches; type B: known otherwise).";
  return section("budget", "Error budget", table(columns, worstFirst, { caption }), el("ul", {}, legend));
}

/** The pose of the part as the pendants of the makers show it; `orientations` has one text per maker. */
export function poseSection({ T_base_part }, orientations) {
  const [x, y, z] = T_base_part.map((row) => fixed(row[3], 3));
  const columns = [
    { title: "pendant", cell: ([maker]) => el("strong", {}, maker) },
    { title: "position", cell: () => `X ${x}  Y ${y}  Z ${z} mm` },
    { title: "orientation", cell: ([, text]) => text },
  ];
  const caption = "Where the part is in the robot's base, in the numbers of each pendant.";
  return section("pose", "Pose of the part", table(columns, Object.entries(orientations), { caption }));
}

export function fitSection(record) {
  const { solver, rms_mm } = record;
  const rows = [
    ["criterion", CRITERIA[record.criterion] ?? record.criterion],
    ["RMS", `${fixed(rms_mm, 4)} mm`],
    ["solver", `${solver.method}, seed ${record.seed}`],
  ];
  const trace = solver.trace && annealingPlot(solver.trace, record.objective_mm);
  const legend =
    "Annealing: the largest distance at the end of each temperature (faint) and the best so far. " +
    "The dotted line is the final answer.";
  const figure = trace && el("figure", {}, trace, el("figcaption", { class: "caption" }, legend));
  const details = el(
    "details",
    {},
    el("summary", {}, "Details"),
    el("div", { class: "beside" }, fitDetails(record), figure),
  );
  return section("fit", "Fit", facts(rows), details);
}

function fitDetails(record) {
  const c = record.correction.six_tuple;
  const rows = [
    ["objective", `${fixed(record.objective_mm, 6)} mm`],
    ["no rigid fit is below", `${fixed(record.lower_bound_mm, 6)} mm${record.certified ? " (certified)" : ""}`],
    ["correction x, y, z", `${[c.x_mm, c.y_mm, c.z_mm].map((v) => fixed(v, 4)).join(", ")} mm`],
    ["correction α, β, γ", `${[c.alpha_rad, c.beta_rad, c.gamma_rad].map((v) => fixed(v, 7)).join(", ")} rad`],
  ];
  const cells = (row) => row.map((v) => el("td", { class: "number" }, fixed(v, 6)));
  const matrix = el(
    "table",
    { class: "matrix" },
    record.T_base_part.map((row) => el("tr", {}, cells(row))),
  );
  const pose = "T_base_part: the columns are the axes of the part in the robot's base, then its origin in mm.";
  return el("div", {}, facts(rows), el("p", { class: "caption" }, pose), el("div", { class: "table-scroll" }, matrix));
}

/** What to do now; null if the verdict asks for nothing. */
export function stepsSection(steps = [], help = "") {
  if (!steps.length) return null;
  const list = el(
    "ol",
    {},
    steps.map((step) => el("li", {}, step)),
  );
  const more = el("p", { class: "caption" }, "Every verdict sentence is explained in ", el("code", {}, help), ".");
  return section("steps", "What to do now", list, more);
}

export function notesSection({ issues }) {
  if (!issues.length) return null;
  return section(
    "notes",
    "Notes on the data",
    el(
      "ul",
      {},
      issues.map(({ message }) => el("li", {}, message)),
    ),
  );
}

function teachingError({ bound_mm, used_sigma_mm, provenance, degrees_of_freedom }) {
  if (bound_mm !== null) return `within ±${bound_mm} mm per axis, stated`;
  if (provenance === undefined) return "–";
  const freedom = degrees_of_freedom === null ? "" : ` with ${plural(degrees_of_freedom, "degree")} of freedom`;
  const how = provenance === "estimated" ? `estimated from the residuals${freedom}` : provenance;
  return `σ ${short(used_sigma_mm)} mm per axis, ${how}`;
}

export function sourcesSection(record, mesh) {
  const files = Object.entries(record.inputs ?? {});
  const columns = [
    { title: "input", cell: ([role]) => role },
    { title: "file", cell: ([, { file }]) => file || "–" },
    { title: "SHA-256", cell: ([, { sha256 }]) => el("code", {}, sha256 ?? "–") },
  ];
  const rows = [
    ["tolerance", `${record.tolerance_mm} mm`],
    ["teaching error", teachingError(record.teaching_error)],
    ["robot space", record.robot_space],
    [
      "versions",
      Object.entries(record.versions)
        .map(([name, version]) => `${name} ${version}`)
        .join(", "),
    ],
  ];
  if (mesh) rows.push(["triangles of the view", `within ${fixed(mesh.deflection_mm, 3)} mm of the model`]);
  return section("sources", "Sources", table(columns, files), facts(rows));
}
