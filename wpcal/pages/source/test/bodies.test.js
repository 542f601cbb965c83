import "./document.js";
import assert from "node:assert/strict";
import test from "node:test";

import { bodiesTable, bodiesWords, centreOf, motionPaths, movesOfSolids, seamsOfBodiesTable } from "../src/bodies.js";

const BODY = {
  name: "web",
  touches: 2,
  tack_mm: 1,
  tack_mrad: 3,
  centre_part_mm: [100, 0, 0],
  moved_mm: [0, 0, 2],
  turned_mrad: [0, 0, 4],
  sigmas: 2.7,
  p_still: 0.0004,
  has_moved: true,
  solids: ["web"],
  T_part_moved: "T",
};
const QUARTER = [
  [0, -1, 0, 10],
  [1, 0, 0, 20],
  [0, 0, 1, 30],
  [0, 0, 0, 1],
];
const SEAM = {
  seam: "W2",
  bodies: ["base", "web"],
  never_touched: [],
  u95_mm: 1.2,
  u95_across_mm: 0.4,
  u95_placing_mm: 0.3,
  u95_unseen_mm: 1.1,
  gap_min_mm: 0.1,
  gap_max_mm: 0.6,
  gap_u95_mm: 0.2,
};

const cells = (shown) =>
  [...shown.querySelectorAll("tbody tr")].map((row) => [...row.children].map((c) => c.textContent));

test("a touched body has numbers, another one has none", () => {
  const shown = cells(bodiesTable({ bodies: [BODY, { ...BODY, name: "rib", touches: 0 }] }));
  assert.deepEqual(shown[0], ["web", "2.00", "4.0", "2.7", "< 0.001", "2", "1 mm, 3 mrad"]);
  assert.deepEqual(shown[1].slice(1, 6), ["–", "–", "–", "–", "0"]);
});

test("a gap that is wider than a seam may have is bold", () => {
  const wide = seamsOfBodiesTable({ seams: [SEAM], gap_limit_mm: 0.5 });
  assert.deepEqual(cells(wide)[0], ["W2", "base + web", "1.200", "0.400", "0.300", "1.100", "0.10 … 0.60 ± 0.20", ""]);
  const bold = (shown) => shown.querySelectorAll("tbody strong").length;
  assert.equal(bold(wide), 2); // the name, too
  assert.equal(bold(seamsOfBodiesTable({ seams: [SEAM], gap_limit_mm: 1 })), 1);
});

test("arrows begin at the place in the model, turn with the part, and are longer by the factor", () => {
  assert.deepEqual(centreOf(BODY, QUARTER), [10, 120, 32]);
  const [shaft] = motionPaths([BODY], QUARTER, 50, 300);
  assert.deepEqual(shaft.points, [
    [10, 120, 30],
    [10, 120, 130],
  ]);
  assert.deepEqual(motionPaths([{ ...BODY, touches: 0 }], QUARTER, 50, 300), []);
});

test("the arc of a turn is as long as the turn times the factor", () => {
  const still = { ...BODY, moved_mm: [0, 0, 0] };
  const [arc] = motionPaths([still], null, 100, 300);
  const [x, y] = [arc.points[0], arc.points.at(-1)].map(([a, b]) => [a - 100, b]);
  const angle = Math.acos((x[0] * y[0] + x[1] * y[1]) / Math.hypot(...x) / Math.hypot(...y));
  assert.ok(Math.abs(angle - 0.4) < 1e-9);
});

test("solids have the place of their body, and sentences begin with a capital", () => {
  assert.deepEqual([...movesOfSolids({ bodies: [BODY] })], [["web", "T"]]);
  assert.deepEqual(bodiesWords({ sentence: "bodies moved", tolerances_sentence: "tack tolerance 1 mm" }), [
    "Bodies moved.",
    "Tack tolerance 1 mm.",
  ]);
});
