import assert from "node:assert/strict";
import test from "node:test";

import { Rows } from "../src/pick/rows.js";

const COLUMNS = ["name", "x_mm", "y_mm", "z_mm", "feature", "use"];
const V2 = { name: "V2", p_mm: [0, 0, 0] };
const V4 = { name: "V4", p_mm: [100, 0, 0] };
const FEATURES = new Map([V2, V4].map((feature) => [feature.name.toLowerCase(), feature]));

function rowsOf(...rows) {
  return new Rows({ columns: COLUMNS, rows });
}

function cells(rows) {
  return rows.toRecord().rows.map((row) => row.join(" "));
}

test("a record comes back as it was, without the long zeros of programs", () => {
  const rows = rowsOf(["A", "1.500000000", "2", "-0.25", "V2", "yes"]);
  assert.deepEqual(rows.toRecord().rows, [["A", "1.50", "2", "-0.25", "V2", "yes"]]);
});

test("a row for a feature takes its name, and a free one where the name is taken", () => {
  const rows = rowsOf(["V2", "", "", "", "V4", "yes"]);
  assert.equal(rows.addFeature(V2).name, "V2_2");
  assert.equal(rows.addFeature().name, "T1");
  assert.equal(rows.addFeature().name, "T2");
  assert.equal(rows.of(V2).name, "V2_2");
});

test("in a table of model coordinates a feature is its place", () => {
  const rows = new Rows({
    columns: ["name", "x_mm", "y_mm", "z_mm", "model_x_mm", "model_y_mm", "model_z_mm"],
    rows: [],
  });
  rows.addFeature(V4);
  assert.deepEqual(cells(rows), ["V4    100 0 0"]);
  assert.equal(rows.of({ name: "other", p_mm: [100.0004, 0, 0] }).name, "V4");
  assert.equal(rows.of(V2), undefined);
});

test("a number that is being typed counts as empty, and only in that cell", () => {
  const rows = rowsOf(["A", "1", "-", "3", "V2", "yes"], ["B", "1", "-", "3", "V4", "yes"]);
  rows.typing = { row: rows.rows[0], name: "y_mm" };
  assert.deepEqual(
    rows.toFit().rows.map((row) => row[2]),
    ["", "-"],
  );
  assert.deepEqual(
    rows.rows.map((row) => rows.isWaiting(row)),
    [true, false],
  );
  assert.equal(rows.toRecord().rows[0][2], "-");
});

test("text for the clipboard quotes commas and quotation marks", () => {
  const rows = rowsOf(['a "b", c', "1", "2", "3", "", "yes"]);
  assert.equal(rows.toText(), 'name,x_mm,y_mm,z_mm,feature,use\n"a ""b"", c",1,2,3,,yes\n');
  rows.rows[0].name = "=1+1";
  rows.rows[0].x_mm = "-1.5";
  assert.equal(rows.toText().split("\n")[1], "'=1+1,-1.5,2,3,,yes");
});

test("pasted positions go to their names, then to open rows, then to new ones", () => {
  const rows = rowsOf(["T1", "", "", "", "", "yes"], ["V4", "", "", "", "V4", "yes"]);
  const positions = [
    { name: "XV4", xyz: ["4", "4", "4"] },
    { name: "", xyz: ["1", "1", "1"] },
    { name: "V2", xyz: ["2", "2", "2"] },
  ];
  const last = rows.place(positions, [...rows.rows], FEATURES);
  assert.equal(last.feature, "V2");
  assert.deepEqual(cells(rows), ["T1 1 1 1  yes", "V4 4 4 4 V4 yes", "V2 2 2 2 V2 yes"]);
});

test("merging adds rows, fills empty coordinates and replaces others, and keeps what a row is for", () => {
  const rows = rowsOf(
    ["A", "1.0", "2", "3", "V2", "check"],
    ["B", "", "", "", "V4", "yes"],
    ["C", "7", "8", "9", "", "yes"],
  );
  const table = {
    columns: ["name", "x_mm", "y_mm", "z_mm", "use", "sigma_mm"],
    rows: [
      ["A", "1", "2", "3", "yes", "0.1"],
      ["B", "4", "5", "6", "yes", ""],
      ["C", "7", "8", "10", "yes", ""],
      ["D", "1", "1", "1", "no", ""],
    ],
  };
  assert.deepEqual(rows.merge(table), { added: 1, filled: 1, replaced: 1 });
  assert.deepEqual(rows.columns.at(-1), "sigma_mm");
  assert.deepEqual(cells(rows), ["A 1.0 2 3 V2 check 0.1", "B 4 5 6 V4 yes ", "C 7 8 10  yes ", "D 1 1 1  no "]);
});
