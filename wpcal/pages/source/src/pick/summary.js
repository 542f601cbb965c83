// What the rows are worth: verdict, the two figures, what is wrong or odd, and the error of every seam.
import { el, fixed, short, table } from "../dom.js";
import { bar, gauge } from "../shares.js";

const LEAST_POINTS = 3;

/** The line below the heading: what is missing, or wrong, or that all is well. */
export function stateOf(rows, { answer, fault }, seams) {
  if (fault && (fault.row !== null || fault.isGone)) return { kind: "wrong", text: fault.message };
  const waiting = rows.rows.filter((row) => rows.isWaiting(row)).length;
  const ready = rows.rows.filter((row) => !rows.isWaiting(row) && row.use === "yes").length;
  if (!rows.rows.length)
    return {
      kind: "hint",
      text: "Click a feature on the part, and type what the robot shows there. Or drop a table or a robot program here.",
    };
  if (ready < LEAST_POINTS && !("kind" in rows.rows[0])) {
    const more = LEAST_POINTS - ready;
    const what =
      waiting >= more
        ? `the coordinates of ${more} more point${more > 1 ? "s" : ""}`
        : `${more} more point${more > 1 ? "s" : ""}`;
    return { kind: "hint", text: `A fit needs ${what} that do not lie on a line.` };
  }
  if (fault) return { kind: "wrong", text: fault.message };
  if (!answer) return { kind: "hint", text: "" };
  const wait = waiting ? ` ${waiting} row${waiting > 1 ? "s wait" : " waits"} for coordinates.` : "";
  const word = answer.verdict === "PASS" ? "Every point is within" : "A point is off by more than";
  const count = worstOfSeams(answer, seams).filter(({ mm }) => mm > answer.tolerance_mm).length;
  const beyond = count ? ` The predicted error of ${count} seam${count > 1 ? "s" : ""} is larger.` : "";
  return {
    kind: answer.verdict.toLowerCase(),
    text: `${word} the tolerance of ${short(answer.tolerance_mm)} mm.${beyond}${wait}`,
  };
}

/** Largest residual and largest predicted error of a seam. */
export function gauges(answer, seams) {
  if (!answer) return [];
  const point = answer.points.reduce(
    (worst, one) => (one.distance_mm > (worst?.distance_mm ?? -1) ? one : worst),
    null,
  );
  const worst = worstOfSeams(answer, seams).sort((a, b) => b.mm - a.mm)[0];
  return [
    point && gauge("largest residual", point.distance_mm, answer.tolerance_mm, `at ${point.name}`),
    worst && gauge("largest 95 % error of a seam", worst.mm, answer.tolerance_mm, `on ${worst.seam.name}`),
  ].filter(Boolean);
}

/** The table of seams, made once: {element, show(answer)}. */
export function seamTable(seams, tolerance, focus) {
  const cells = new Map(); // of what follows from an answer
  const cellsOf = (row) =>
    cells.get(row) ?? cells.set(row, { error: el("span", {}, "–"), share: el("span", {}) }).get(row);
  const rows = seams.map((seam, row) => ({ ...seam, row })).filter(({ accepted }) => accepted);
  const button = ({ name, row }) => el("button", { type: "button", class: "name", onclick: () => focus(row) }, name);
  const columns = [
    { title: "seam", cell: button },
    { title: "joint", cell: ({ joint, weld }) => `${joint} ${weld}` },
    { title: "length mm", number: true, cell: ({ length_mm }) => fixed(length_mm, 1) },
    { title: "95 % error mm", number: true, cell: ({ row }) => cellsOf(row).error },
    { title: "", cell: ({ row }) => cellsOf(row).share },
  ];
  const show = (answer) => {
    const errors = new Map(answer ? worstOfSeams(answer, seams).map(({ row, mm }) => [row, mm]) : []);
    for (const [row, { error, share }] of cells) {
      const text = fixed(errors.get(row), 4);
      if (text === error.textContent) continue;
      error.textContent = text;
      share.replaceChildren(...(errors.has(row) ? [bar(errors.get(row), tolerance)] : []));
    }
  };
  if (!rows.length) return { element: el("p", { class: "none" }, "wpcal found no seam on this part."), show };
  return { element: table(columns, rows, { rowOf: ({ name }) => ({ "data-name": name }) }), show };
}

function worstOfSeams({ u95_mm }, seams) {
  return seams.map((seam, row) => ({ seam, row, mm: Math.max(...u95_mm[row]) })).filter(({ seam }) => seam.accepted);
}
