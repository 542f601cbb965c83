import assert from "node:assert/strict";
import test from "node:test";

import { Draft, idOf } from "../src/pick/draft.js";
import { Rows } from "../src/pick/rows.js";
import { freeName } from "../src/pick/saving.js";
import { theirsText } from "../src/pick/theirs.js";

const COLUMNS = ["name", "x_mm", "y_mm", "z_mm", "feature", "use"];
const TABLE = { columns: COLUMNS, rows: [["V2", "1", "2", "3", "V2", "yes"]], keys: ["a"] };

/** A draft whose server answers with `answers` in turn; `sent` are the requests. */
function draftOf(t, answers) {
  const sent = [];
  t.mock.method(globalThis, "setInterval", () => 0);
  t.mock.method(globalThis, "fetch", async (action, { body }) => {
    sent.push([action, JSON.parse(body)]);
    const answer = answers.shift();
    if (!answer) throw new TypeError("network");
    return { ok: true, json: async () => answer };
  });
  globalThis.addEventListener ??= () => {};
  const said = [];
  const rows = new Rows(TABLE);
  const on = {
    onTheirs: (merged) => {
      rows.restore(merged.table);
      said.push(theirsText(merged));
    },
    onFault: (message) => said.push(message),
    onName: () => {},
  };
  const draft = new Draft(rows, { revision: 4, table: TABLE, saves_to: "taught.csv" }, on);
  return { draft, rows, sent, said };
}

test("a change is sent with the revision on which it is based, and is then kept", async (t) => {
  const { draft, rows, sent } = draftOf(t, [{ answer: { revision: 5, warning: "" } }]);
  assert.equal(draft.isKept, true);
  rows.rows[0].x_mm = "7";
  assert.equal(draft.isKept, false);
  assert.equal(await draft.keep(), true);
  assert.deepEqual([draft.isKept, draft.revision], [true, 5]);
  const [[action, { revision, table, number }]] = sent;
  assert.deepEqual([action, revision, table.rows[0][1], number], ["keep", 4, "7", 1]);
});

test("a stale change is merged and sent again", async (t) => {
  const theirs = { ...TABLE, rows: [["V2", "1", "9", "3", "V2", "yes"]] };
  const stale = { answer: { is_stale: true, revision: 6, table: theirs, saves_to: "taught.csv" } };
  const { draft, rows, sent, said } = draftOf(t, [stale, { answer: { revision: 7, warning: "" } }]);
  rows.rows[0].x_mm = "7";
  assert.equal(await draft.keep(), true);
  assert.deepEqual(
    sent.map(([, { revision, table }]) => [revision, table.rows[0].slice(1, 3)]),
    [
      [4, ["7", "2"]],
      [6, ["7", "9"]],
    ],
  );
  assert.deepEqual(said, ["Changed in another window: V2."]);
  assert.equal(draft.undecided.length, 0);
});

test("two texts in one cell are both said", async (t) => {
  const theirs = { ...TABLE, rows: [["V2", "8", "2", "3", "V2", "yes"]] };
  const stale = { answer: { is_stale: true, revision: 6, table: theirs, saves_to: "taught.csv" } };
  const { draft, rows, sent, said } = draftOf(t, [stale, { answer: { revision: 7, warning: "" } }]);
  rows.rows[0].x_mm = "7";
  await draft.keep();
  assert.match(said[0], /^Two windows changed 1 cell: V2, x_mm: this window has 7, another window 8\./);
  assert.deepEqual(sent.at(-1)[1].conflicts, [idOf(draft.undecided[0])]); // the server knows of it
  draft.decided(draft.undecided);
  assert.deepEqual(draft.own().conflicts, []);
});

test("without the server a change is at risk", async (t) => {
  const { draft, rows, said } = draftOf(t, []);
  rows.rows[0].x_mm = "7";
  assert.equal(draft.isAtRisk, false); // the browser sends it when the window closes
  assert.equal(await draft.keep(), false);
  assert.equal(draft.isAtRisk, true);
  assert.deepEqual(said, []);
});

test("why the draft cannot be written is said once", async (t) => {
  const answer = (revision) => ({ answer: { revision, warning: "no space left" } });
  const { draft, rows, said } = draftOf(t, [answer(5), answer(6)]);
  for (const text of ["7", "8"]) {
    rows.rows[0].x_mm = text;
    await draft.keep();
  }
  assert.deepEqual(said, ["no space left"]);
});

test("the proposed name is the next number", () => {
  assert.equal(freeName("taught.csv"), "taught-2.csv");
  assert.equal(freeName("/a/b.c/taught-9.csv"), "taught-10.csv");
  assert.equal(freeName("points"), "points-2");
});
