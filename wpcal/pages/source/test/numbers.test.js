import assert from "node:assert/strict";
import test from "node:test";

import { isHalfANumber, pointed, positionsIn } from "../src/pick/numbers.js";
import { isTable, pastedText, readPasted } from "../src/pick/pasted.js";

const XYZ = ["812.29", "-240.62", "165.80"];

test("decimal commas, groups of thousands, units and typeset minus signs", () => {
  const written = ["812,29", "1.812,29", "1,812.29", "812.29 mm", "\u22125", " 7 ", "abc"];
  assert.deepEqual(written.map(pointed), ["812.29", "1812.29", "1812.29", "812.29", "-5", "7", "abc"]);
});

test("the beginning of a number is not yet a number", () => {
  assert.deepEqual(["-", "1e", "12,", ".", "+"].map(isHalfANumber), Array(5).fill(true));
  assert.deepEqual(["", "12", "12.", "x", "1e5"].map(isHalfANumber), Array(5).fill(false));
});

for (const [what, text, name] of [
  ["blanks", "812.29 -240.62 165.80", ""],
  ["a name first", "V2 812.29 -240.62 165.80", "V2"],
  ["a name with a colon", "V2: 812.29; -240.62; 165.80", "V2"],
  ["a count and angles", "3 812.29 -240.62 165.80 0.0 90.0 0.0", ""],
  ["tabs and decimal commas", "812,29\t-240,62\t165,80", ""],
  ["commas", "812.29,-240.62,165.80", ""],
  ["decimal commas and semicolons", "812,29;-240,62;165,80", ""],
  ["decimal commas and commas", "812,29, -240,62, 165,80", ""],
  ["a typesetter's minus", "812.29 \u2212240.62 165.80", ""],
  ["units", "X: 812.29 mm, Y: -240.62 mm, Z: 165.80 mm", ""],
  ["Yaskawa", "C00000=812.29,-240.62,165.80,180.0000,0.0000,90.0000", "C00000"],
  ["one number per line", "812.29\n-240.62\n165.80", ""],
  ["KUKA", "DECL E6POS XV2={X 812.29,Y -240.62,Z 165.80,A 0.0,B 90.0,C 0.0,S 2,T 35}", "XV2"],
  ["ABB", "CONST robtarget p10:=[[812.29,-240.62,165.80],[1,0,0,0],[0,0,0,0]];", "p10"],
  ["FANUC", 'P[3:"V2"]{\n GP1:\n UF : 0, UT : 1,\n X = 812.29 mm, Y = -240.62 mm, Z = 165.80 mm,\n};', "V2"],
  ["a vector in a program", "p = [812.29, -240.62, 165.80]", "p"],
]) {
  test(`a position is read from ${what}`, () => {
    const [found, ...more] = positionsIn(text);
    assert.deepEqual(more, []);
    assert.deepEqual({ name: found.name, xyz: found.xyz }, { name, xyz: XYZ });
  });
}

test("several lines are several positions, in their order", () => {
  const found = positionsIn("A 1 2 3\nB 4 5 6\n\nno numbers here\nC 7 8 9\n");
  assert.deepEqual(
    found.map(({ name, xyz }) => [name, ...xyz]),
    [
      ["A", "1", "2", "3"],
      ["B", "4", "5", "6"],
      ["C", "7", "8", "9"],
    ],
  );
});

test("a text that can be read in two ways is not read", () => {
  assert.deepEqual(positionsIn("812,29,-240,62,165,80"), []);
  assert.deepEqual(positionsIn("just words"), []);
});

test("a table is known by its header", () => {
  assert.ok(isTable("name,x_mm,y_mm,z_mm\nA,1,2,3\n"));
  assert.ok(isTable('"name"\t"x_mm"\t"y_mm"'));
  assert.ok(!isTable("V2 812.29 -240.62 165.80"));
});

test("positions in a user frame are noticed", () => {
  const fanuc = readPasted("P[1]{\n UF : 3, UT : 1,\n X = 1.0 mm, Y = 2.0 mm, Z = 3.0 mm\n};");
  assert.ok(fanuc.isInUserFrame);
  assert.match(pastedText(fanuc, 1), /^1 position pasted, 1 as new rows\. They are in a user frame/);
  assert.equal(pastedText(readPasted("1 2 3\n4 5 6"), 0), "2 positions pasted.");
});
