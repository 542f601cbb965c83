// What the rows are worth: the verdict, the two figures, what is wrong or missing, and the error of every seam.
import { el, fixed, table } from "../dom.js";
import { reasonsOf } from "../seams/list.js";
import { bar, gauge } from "../shares.js";
import { plural, verdictText } from "../words.js";
import { FAULTS } from "./link.js";

const LEAST_POINTS = 3;
const FIRST_STEP =
  "Click a feature on the part, and type the coordinates that the robot shows there. " +
  "Or drop a table or a robot program here.";

const TOUCH_STEP = "Type the coordinates that the robot shows at each touch.";

/**
 * The line below the heading: what is missing, what is wrong, or the verdict.
 *
 * @param {Rows} rows
 * @param {{answer: object|null, fault: object|null}} answered  by the server
 * @returns {{kind: "wrong"|"hint"|"pass"|"unsure"|"fail", text: string}}
 */
export function stateOf(rows, { answer, fault }) {
  if (fault && (fault.row !== null || fault.code === FAULTS.noServer)) return { kind: "wrong", text: fault.message };
  if (!rows.rows.length) return { kind: "hint", text: FIRST_STEP };
  const missing = missingText(rows);
  if (missing) return { kind: "hint", text: missing };
  if (fault) return { kind: "wrong", text: fault.message };
  if (!answer) return { kind: "hint", text: "" };
  return { kind: answer.verdict.toLowerCase(), text: answerText(rows, answer) };
}

/** What a fit still needs, or null. Touches on faces are counted by wpcal, not here. */
function missingText(rows) {
  const ready = rows.rows.filter((row) => !rows.isWaiting(row) && row.use === "yes").length;
  if ("kind" in rows.rows[0]) return waitingIn(rows) === rows.rows.length ? TOUCH_STEP : null;
  if (ready >= LEAST_POINTS) return null;
  const points = plural(LEAST_POINTS - ready, "more point");
  const isTyping = waitingIn(rows) >= LEAST_POINTS - ready;
  return `A fit needs ${isTyping ? "the coordinates of " : ""}${points} that do not lie on one line.`;
}

function answerText(rows, answer) {
  const waiting = waitingIn(rows);
  const enough = answer.verdict === "PASS" ? "; it is enough without" : "";
  const wait = waiting
    ? ` ${plural(waiting, "row")} ${waiting === 1 ? "has" : "have"} no coordinates yet${enough}.`
    : "";
  return `${answer.verdict}: ${verdictText(answer)}${wait}`;
}

function waitingIn(rows) {
  return rows.rows.filter((row) => rows.isWaiting(row)).length;
}

/** Largest residual and largest predicted error of a seam. */
export function gauges(answer, seams) {
  if (!answer) return [];
  const { points, tolerance_mm: tolerance } = answer;
  const point = points.reduce((worst, one) => (one.distance_mm > (worst?.distance_mm ?? -1) ? one : worst), null);
  const worst = worstOfSeams(answer, seams).find(({ seam }) => seam.name === answer.judgement.seam);
  return [
    point && gauge("largest residual", point.distance_mm, tolerance, `at ${point.name}`),
    worst && gauge("largest 95 % error of a seam", worst.mm, tolerance, `on ${worst.seam.name}`),
  ].filter(Boolean);
}

/**
 * The tables of accepted and of refused seams, made once for these seams: {element, show(answer)}.
 *
 * @param {object[]} seams
 * @param {number} tolerance  mm
 * @param {function(number)} focus  gets the row of a seam that was clicked
 */
export function seamTables(seams, tolerance, focus) {
  const cells = new Map(); // row -> the elements that an answer changes
  let errors = new Map(); // row -> mm, of the last answer
  const say = (row, { error, share }) => {
    const text = fixed(errors.get(row), 4);
    if (text === error.textContent) return;
    error.textContent = text;
    share.replaceChildren(...(errors.has(row) ? [bar(errors.get(row), tolerance)] : []));
  };
  const newCells = (row) => {
    const made = { error: el("span", {}), share: el("span", {}) };
    say(row, made);
    return made;
  };
  const cellsOf = (row) => cells.get(row) ?? cells.set(row, newCells(row)).get(row);
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
    errors = new Map(answer ? worstOfSeams(answer, seams).map(({ row, mm }) => [row, mm]) : []);
    for (const [row, made] of cells) say(row, made);
  };
  const rowOf = ({ name }) => ({ "data-name": name });
  const accepted = rows.length
    ? table(columns, rows, { rowOf })
    : el("p", { class: "none" }, seams.length ? "No seam is accepted." : "wpcal found no seam on this part.");
  return { element: el("div", {}, accepted, refusedTable(seams, button, rowOf)), show };
}

/** The candidates that are not welded, with the reasons; null if there are none. */
function refusedTable(seams, button, rowOf) {
  const rows = seams.map((seam, row) => ({ ...seam, row })).filter(({ accepted }) => !accepted);
  if (!rows.length) return null;
  const columns = [
    { title: "refused", cell: button },
    { title: "joint", cell: ({ joint, weld }) => `${joint} ${weld}` },
    { title: "length mm", number: true, cell: ({ length_mm }) => fixed(length_mm, 1) },
    { title: "reason", cell: reasonsOf },
  ];
  return el("div", { class: "refused" }, table(columns, rows, { rowOf }));
}

function worstOfSeams({ u95_mm }, seams) {
  return seams.map((seam, row) => ({ seam, row, mm: Math.max(...u95_mm[row]) })).filter(({ seam }) => seam.accepted);
}
