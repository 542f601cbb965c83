import assert from "node:assert/strict";
import test from "node:test";

import { rowAt, stateAt, valueAt } from "../src/plan/times.js";

const TIMES = [0, 1, 3, 4];

test("the row of the last time that is not after t", () => {
  assert.deepEqual(
    [-1, 0, 0.5, 1, 2.9, 3, 4, 9].map((t) => rowAt(TIMES, t)),
    [0, 0, 0, 1, 1, 2, 3, 3],
  );
});

test("the part of the way to the next state, never beyond the ends", () => {
  assert.deepEqual(stateAt(TIMES, 2), { row: 1, part: 0.5 });
  assert.deepEqual(stateAt(TIMES, -1), { row: 0, part: 0 });
  assert.deepEqual(stateAt(TIMES, 9), { row: 2, part: 1 });
  assert.deepEqual(stateAt([5], 5), { row: 0, part: 0 });
});

test("values between two states are interpolated, gaps are not", () => {
  const series = { t: TIMES, values: [0, 10, 30, null] };
  assert.equal(valueAt(series, 2), 20);
  assert.equal(valueAt(series, 3.5), 30);
  assert.equal(valueAt(series, 4), null);
});
