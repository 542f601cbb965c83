import assert from "node:assert/strict";
import test from "node:test";

import { beginOf, placeAt, wayOf } from "../src/touches/way.js";

const search = (x) => ({
  via: [],
  approach: [x, 0, 100],
  start: [x, 0, 10],
  planned: [x, 0, 0],
  end: [x, 0, -10],
  retract: [x, 0, 100],
});
const DATA = { searches: [search(0), search(200)], air_speed_mm_s: 100, search_speed_mm_s: 10, hold_s: 0.5 };

test("the way goes to each start, searches slowly to the face, waits and leaves", () => {
  const way = wayOf(DATA);
  assert.equal(way.t.length, way.p.length);
  assert.deepEqual(placeAt(way, beginOf(way, 0)), { p: [0, 0, 10], row: 0, what: "searches" });
  assert.ok(Math.abs(placeAt(way, beginOf(way, 0) + 0.5).p[2] - 5) < 1e-9);
  assert.deepEqual(placeAt(way, beginOf(way, 0) + 1.2), { p: [0, 0, 0], row: 0, what: "touches" });
  const total = 0.9 + 1 + 0.5 + 0.1 + 0.9; // approach, search, hold, start, retract
  assert.ok(Math.abs(way.t.at(-1) - (2 * total + 2)) < 1e-9);
  assert.deepEqual(placeAt(way, way.t.at(-1)).p, [200, 0, 100]);
});
