import assert from "node:assert/strict";
import test from "node:test";

import { areaOf, axes, chart, curve, level, X_LINES } from "../src/charts/axes.js";
import { linear } from "../src/charts/scales.js";
import { texts, values } from "./document.js";

const AREA = areaOf(200, 100, { left: 30, right: 10, top: 5, bottom: 20 });
const x = linear([0, 10], [AREA.left, AREA.right]);
const y = linear([0, 4], [AREA.bottom, AREA.top]);

test("the plot lies inside the margins", () => {
  assert.deepEqual(AREA, { width: 200, height: 100, left: 30, right: 190, top: 5, bottom: 80 });
});

test("the axes name every tick and both titles", () => {
  const drawn = chart(AREA, { title: "T" }, axes(AREA, x, y, { xTitle: "s, mm", yTitle: "error, mm" }));
  assert.equal(drawn.getAttribute("viewBox"), "0 0 200 100");
  assert.deepEqual(texts(drawn, "text"), [
    "0",
    "1",
    "2",
    "3",
    "4",
    "0",
    "2",
    "4",
    "6",
    "8",
    "10",
    "s, mm",
    "error, mm",
  ]);
});

test("lines at the ticks of x: none, short ones, or a grid", () => {
  const heights = (xLines) => {
    const drawn = chart(AREA, { title: "T" }, axes(AREA, x, y, { xTitle: "x", xLines }));
    const lines = [...drawn.querySelectorAll("line.grid")].filter(
      (line) => line.getAttribute("x1") === line.getAttribute("x2"),
    );
    return lines.map((line) => Math.abs(line.getAttribute("y2") - line.getAttribute("y1")));
  };
  assert.deepEqual(heights(X_LINES.none), []);
  assert.deepEqual(heights(X_LINES.ticks), Array(6).fill(4));
  assert.deepEqual(heights(X_LINES.grid), Array(6).fill(75));
});

test("a curve has one line per stretch without a gap", () => {
  const lines = curve([0, 5, 6, 8, 10], [0, 4, null, 2, 0], x, y, { class: "series" }, "W1");
  const drawn = chart(AREA, { title: "T" }, lines);
  assert.deepEqual(values(drawn, "polyline", "points"), ["30.0,80.0 110.0,5.0", "158.0,42.5 190.0,80.0"]);
  assert.deepEqual(texts(drawn, "title"), ["W1", "W1"]);
});

test("a single value between gaps draws nothing", () => {
  assert.deepEqual(curve([0, 1, 2], [null, 3, null], x, y, {}), []);
});

test("a level line crosses the whole plot", () => {
  const drawn = chart(AREA, { title: "T" }, level(AREA, y, { value: 2, text: "limit" }));
  const line = drawn.querySelector("line.limit");
  assert.deepEqual(
    ["x1", "x2", "y1", "y2"].map((name) => Number(line.getAttribute(name))),
    [30, 190, 42.5, 42.5],
  );
  assert.deepEqual(texts(drawn, "text.limit"), ["limit"]);
});
