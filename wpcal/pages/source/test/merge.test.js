import assert from "node:assert/strict";
import test from "node:test";

import { isSameTable, mergeTables, withTheirs } from "../src/pick/merge.js";

const COLUMNS = ["name", "x_mm", "feature"];

/** A table of rows such as "key name x feature"; a dash is an empty cell. */
function tableOf(...rows) {
  const cells = rows.map((row) => row.split(" ").map((cell) => (cell === "-" ? "" : cell)));
  return { columns: COLUMNS, rows: cells.map((row) => row.slice(1)), keys: cells.map(([key]) => key) };
}

const BASE = tableOf("a V2 1 V2", "b V4 2 V4");

test("changes of different cells are both taken", () => {
  const [mine, theirs] = [tableOf("a V2 7 V2", "b V4 2 V4"), tableOf("a V2 1 V2", "b V4 2 V9")];
  const { table, changed, conflicts } = mergeTables(BASE, mine, theirs);
  assert.deepEqual(table, tableOf("a V2 7 V2", "b V4 2 V9"));
  assert.deepEqual([changed, conflicts], [["V4"], []]);
});

test("a cell that both changed is a conflict: mine is taken, theirs is offered", () => {
  const [mine, theirs] = [tableOf("a V2 7 V2", "b V4 2 V4"), tableOf("a V2 8 V2", "b V4 2 V4")];
  const { table, conflicts } = mergeTables(BASE, mine, theirs);
  assert.deepEqual(table, mine);
  assert.deepEqual(withTheirs(table, conflicts), theirs);
  assert.deepEqual(conflicts, [{ key: "a", row: "V2", column: "x_mm", mine: "7", theirs: "8" }]);
  assert.deepEqual(mergeTables(BASE, mine, mine).conflicts, []);
});

test("rows of both windows are added, and a row for the same feature once", () => {
  const [mine, theirs] = [tableOf(...line("c V6 3 V6"), "d V8 - V8"), tableOf(...line("e V8 4 V8"))];
  const { table, changed } = mergeTables(BASE, mine, theirs);
  assert.deepEqual(table, tableOf(...line("e V8 4 V8"), "c V6 3 V6"));
  assert.deepEqual(changed, ["V8"]);
});

function line(row) {
  return ["a V2 1 V2", "b V4 2 V4", row];
}

test("a row that one removed is gone, unless the other changed it", () => {
  const without = tableOf("b V4 2 V4");
  const changed = tableOf("a V2 7 V2", "b V4 2 V4");
  assert.deepEqual(mergeTables(BASE, BASE, without).table, without);
  assert.deepEqual(mergeTables(BASE, BASE, without).changed, ["V2"]);
  assert.deepEqual(mergeTables(BASE, without, BASE).table, without);
  assert.deepEqual(new Set(mergeTables(BASE, changed, without).table.keys), new Set(["a", "b"]));
  assert.deepEqual(mergeTables(BASE, without, changed).table, changed);
});

test("further columns of one window are empty in the rows of the other", () => {
  const theirs = { columns: [...COLUMNS, "sigma_mm"], rows: [["V2", "1", "V2", "0.1"]], keys: ["a"] };
  const { table } = mergeTables(BASE, tableOf("a V2 1 V2", "b V4 2 V4", "c V6 3 V6"), theirs);
  assert.deepEqual(table.columns, theirs.columns);
  assert.deepEqual(table.rows, [
    ["V2", "1", "V2", "0.1"],
    ["V6", "3", "V6", ""],
  ]);
});

test("no typed cell is lost, whatever two windows do", () => {
  let state = 5;
  const draw = (n) => {
    state = (state * 1103515245 + 12345) % 2147483648;
    return state % n;
  };
  for (let round = 0; round < 300; round += 1) {
    const base = tableOf(...Array.from({ length: draw(4) }, (_, i) => `k${i} N${i} ${i} V${i}`));
    const [mine, theirs] = ["m", "t"].map((who) => edited(base, who, draw));
    const { table, conflicts } = mergeTables(base, mine, theirs);
    const others = withTheirs(table, conflicts);
    const texts = (record) => record.rows.flat();
    const typed = [mine, theirs].flatMap((record) => texts(record).filter((text) => /^[mt]\d/.test(text)));
    const kept = new Set([...texts(table), ...texts(others)]);
    for (const text of typed) assert.ok(kept.has(text), `${text} was lost in round ${round}`);
    if (!conflicts.length) assert.ok(isSameTable(table, others));
    assert.equal(new Set(table.keys).size, table.keys.length);
  }
});

function edited(base, who, draw) {
  const [rows, keys] = [base.rows.map((row) => [...row]), [...base.keys]];
  for (let count = draw(4); count > 0; count -= 1) {
    const at = draw(rows.length + 1);
    if (at === rows.length) {
      keys.push(`${who}${draw(1e6)}`);
      rows.push([`${who}${draw(1e6)}`, "", ""]);
    } else if (draw(4) === 0) {
      if (/^[mt]\d/.test(rows[at].join(""))) continue;
      rows.splice(at, 1);
      keys.splice(at, 1);
    } else rows[at][draw(3)] = `${who}${draw(1e6)}`;
  }
  return { columns: base.columns, rows, keys };
}
