import assert from "node:assert/strict";
import test from "node:test";

import { mergedText } from "../src/pick/files.js";
import { FAULTS } from "../src/pick/link.js";
import { Rows } from "../src/pick/rows.js";
import { gauges, seamTables, stateOf } from "../src/pick/summary.js";
import { texts } from "./document.js";

const COLUMNS = ["name", "x_mm", "y_mm", "z_mm", "feature", "use"];
const SEAMS = [
  { name: "W1", accepted: true, joint: "tee", weld: "fillet", length_mm: 100 },
  { name: "W2", accepted: false, joint: "butt", weld: "groove", length_mm: 50, against: [] },
];
const ANSWER = {
  verdict: "UNSURE",
  judgement: { seam: "W1", sentence: "seam W1 may be off by 0.5 mm: touch V3 as well" },
  tolerance_mm: 0.4,
  points: [
    { name: "A", distance_mm: 0.1 },
    { name: "B", distance_mm: 0.3 },
  ],
  u95_mm: [
    [0.2, 0.5],
    [9, 9],
  ],
};
const NONE = { answer: null, fault: null };

function rowsOf(complete, waiting = 0) {
  const row = (x, i) => [`R${i}`, x, x, x, "", "yes"];
  const rows = [...Array(complete).fill("1"), ...Array(waiting).fill("")].map(row);
  return new Rows({ columns: COLUMNS, rows });
}

test("an empty page says the first step", () => {
  assert.match(stateOf(rowsOf(0), NONE).text, /^Click a feature on the part/);
});

test("fewer than three points: the page says how many are missing", () => {
  assert.match(stateOf(rowsOf(1), NONE).text, /^A fit needs 2 more points that/);
  assert.match(stateOf(rowsOf(2, 1), NONE).text, /^A fit needs the coordinates of 1 more point that/);
});

test("touches that all wait ask for their coordinates; wpcal counts those that are typed", () => {
  const touched = (x) =>
    new Rows({ columns: ["name", "x_mm", "y_mm", "z_mm", "kind"], rows: [["T1", x, x, x, "plane"]] });
  assert.match(stateOf(touched(""), NONE).text, /^Type the coordinates/);
  assert.equal(stateOf(touched("1"), NONE).text, "");
});

test("a fault of a row counts first, one of the whole table only when enough points are there", () => {
  const ofRow = { message: "A, x_mm: expected a number", code: "format", row: 0, column: "x_mm" };
  const ofAll = { message: "the points lie on one line", code: "geometry", row: null, column: null };
  assert.deepEqual(stateOf(rowsOf(1), { answer: null, fault: ofRow }), { kind: "wrong", text: ofRow.message });
  assert.equal(stateOf(rowsOf(1), { answer: null, fault: ofAll }).kind, "hint");
  assert.equal(stateOf(rowsOf(3), { answer: null, fault: ofAll }).text, ofAll.message);
});

test("a server that is gone is said at once", () => {
  const fault = { message: "gone", code: FAULTS.noServer, row: null, column: null };
  assert.equal(stateOf(rowsOf(0), { answer: null, fault }).text, "gone");
});

test("the verdict in wpcal's words, and rows without coordinates", () => {
  const { kind, text } = stateOf(rowsOf(3, 2), { answer: ANSWER, fault: null });
  assert.equal(kind, "unsure");
  assert.equal(text, "UNSURE: Seam W1 may be off by 0.5 mm: touch V3 as well. 2 rows have no coordinates yet.");
});

test("the figures are the worst point and the worst accepted seam", () => {
  const [point, seam] = gauges(ANSWER, SEAMS);
  assert.equal(point.querySelector(".value").textContent, "0.300 mm");
  assert.match(point.textContent, /at B · 75 % of the tolerance/);
  assert.match(seam.textContent, /0\.500 mm.*on W1/);
  assert.deepEqual(gauges(null, SEAMS), []);
});

test("the table of seams follows the answers", () => {
  const { element, show } = seamTables(SEAMS, 0.4, () => {});
  const errors = () =>
    texts(element, "tbody tr")
      .slice(0, 1)
      .map((text) => text.replace("W1tee fillet100.0", ""));
  assert.deepEqual(errors(), ["–"]);
  show(ANSWER);
  assert.deepEqual(errors(), ["0.5000"]);
  show(null);
  assert.deepEqual(errors(), ["–"]);
});

test("refused seams are listed with the reason", () => {
  const refused = { ...SEAMS[1], joint: "tee", weld: "fillet", accepted: false, against: ["no torch gets there"] };
  const { element } = seamTables([SEAMS[0], refused, { ...refused, edit: { reject: true } }], 0.4, () => {});
  const reasons = texts(element, ".refused tbody td:last-child");
  assert.deepEqual(reasons, ["no torch gets there", "refused by hand; no torch gets there"]);
});

test("what a file brought is counted, and long lists are cut", () => {
  const none = { added: 0, filled: 0, replaced: 0 };
  assert.equal(mergedText("a.csv", { rows: [1] }, none), "a.csv: 1 point, all in the table already.");
  const leftOut = Array.from({ length: 8 }, (_, i) => `P${i}`);
  assert.equal(
    mergedText("a.ls", { rows: [1, 2], left_out: leftOut }, { added: 1, filled: 0, replaced: 1 }),
    "a.ls: 2 points, 1 new, 1 replaced. Left out: P0; P1; P2; P3; P4; P5; and 2 more.",
  );
});
