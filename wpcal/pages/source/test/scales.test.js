import assert from "node:assert/strict";
import test from "node:test";

import { decades, linear, logarithmic, roundSteps } from "../src/charts/scales.js";
import { short } from "../src/dom.js";

test("a linear scale maps both ends and comes back", () => {
  const scale = linear([-2, 6], [50, 450]);
  assert.deepEqual([scale.at(-2), scale.at(2), scale.at(6)], [50, 250, 450]);
  assert.equal(scale.back(scale.at(1.25)), 1.25);
});

test("a linear scale may fall, as the places of y do", () => {
  const scale = linear([0, 10], [200, 0]);
  assert.deepEqual([scale.at(0), scale.at(10)], [200, 0]);
  assert.deepEqual(scale.ticks, [0, 2, 4, 6, 8, 10]);
});

test("one value alone still has a place", () => {
  const scale = linear([3, 3], [0, 100]);
  assert.equal(scale.at(3), 0);
  assert.ok(scale.ticks.includes(3));
});

test("ticks are multiples of 1, 2 or 5 times a power of ten, inside the range", () => {
  assert.deepEqual(roundSteps(0, 1), [0, 0.2, 0.4, 0.6000000000000001, 0.8, 1]);
  assert.deepEqual(roundSteps(-3, 22), [0, 5, 10, 15, 20]);
  assert.deepEqual(roundSteps(0.0012, 0.0058), [0.002, 0.003, 0.004, 0.005]);
});

test("a tick at the very end survives round-off", () => {
  assert.equal(roundSteps(0, 0.1 + 0.2).at(-1), 0.30000000000000004);
});

test("decades, and every second one where there are many", () => {
  assert.deepEqual(decades(0.5, 200), [1, 10, 100]);
  assert.deepEqual(decades(1, 1000), [1, 10, 100, 1000]);
  assert.deepEqual(decades(1e-6, 1e4).map(short), ["1e-6", "1e-4", "0.01", "1", "100", "10000"]);
});

test("a logarithmic scale may fall and keeps its ticks", () => {
  const scale = logarithmic([100, 1], [0, 300]);
  const near = (value, expected) => assert.ok(Math.abs(value - expected) < 1e-9, `${value} is not ${expected}`);
  near(scale.at(100), 0);
  near(scale.at(10), 150);
  near(scale.back(300), 1);
  assert.deepEqual(scale.ticks, [1, 10, 100]);
});
