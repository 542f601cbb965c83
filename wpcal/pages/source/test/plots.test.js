import assert from "node:assert/strict";
import test from "node:test";

import { annealingPlot, errorPlot } from "../src/report/plots.js";
import { texts, values } from "./document.js";

const SEAMS = [
  { name: "W1", accepted: true },
  { name: "W2", accepted: false },
  { name: "W3", accepted: true },
];
const FRAMES = [
  { s: [0, 50, 100], u95: [0.2, 0.1, 0.3] },
  { s: [0, 400], u95: [9, 9] },
  { s: [0, 80], u95: [0.1, 0.2] },
];

test("the plot of errors shows the accepted seams, each by its name", () => {
  const drawn = errorPlot(SEAMS, FRAMES, 0.5);
  assert.deepEqual(texts(drawn, "polyline.series title"), ["W1", "W3"]);
  assert.deepEqual(values(drawn, "polyline.series", "data-series"), ["0", "1"]);
  assert.deepEqual(texts(drawn, "text[data-series]"), ["W1", "W3"]);
  assert.deepEqual(texts(drawn, "text.limit"), ["tolerance 0.5 mm"]);
});

test("a larger error is drawn higher, and below the upper edge", () => {
  const [points] = values(errorPlot(SEAMS, FRAMES, 0.5), "polyline.series", "points");
  const heights = points.split(" ").map((point) => Number(point.split(",")[1]));
  assert.ok(heights[2] < heights[0] && heights[0] < heights[1]);
  assert.ok(heights.every((height) => height > 14 && height < 208));
});

test("names that end at the same place do not cover each other", () => {
  const frames = FRAMES.map(() => FRAMES[0]);
  const heights = values(errorPlot(SEAMS, frames, 0.5), "text[data-series]", "y").map(Number);
  assert.ok(Math.abs(heights[0] - heights[1]) >= 12);
});

test("without predicted errors there is no plot", () => {
  assert.equal(errorPlot(SEAMS, [{ s: [0], u95: null }, FRAMES[1], { s: [0], u95: null }], 0.5), null);
});

const TRACE = { temperature_mm: [100, 10, 1, 0.1], f_mm: [20, 5, 3, 0.4], best_f_mm: [20, 4, 0.5, 0.3] };

test("the annealing trace runs from hot on the left to cold on the right", () => {
  const drawn = annealingPlot(TRACE, 0.25);
  const [all, best] = values(drawn, "polyline", "points").map((points) =>
    points.split(" ").map((point) => point.split(",").map(Number)),
  );
  assert.deepEqual([all[0][0], all.at(-1)[0]], [58, 546]);
  assert.ok(best.every(([, height], i) => height >= all[i][1]));
  assert.deepEqual(texts(drawn, "text.answer"), ["answer 0.2500 mm"]);
});

test("points that fit exactly leave no trace to draw", () => {
  assert.equal(annealingPlot({ temperature_mm: [1, 0.1], f_mm: [0, 0], best_f_mm: [0, 0] }, 0), null);
});
