import assert from "node:assert/strict";
import test from "node:test";

import { distanceOf, shortestWay } from "../src/measure.js";

const point = (...p) => ({ kind: "corner", ends: [p, p] });
const edge = (...ends) => ({ kind: "edge", ends });

test("the distance of two places has its components", () => {
  const { mm, d } = distanceOf(point(1, 2, 3), point(4, 6, 3));
  assert.deepEqual([mm, d], [5, [3, 4, 0]]);
});

test("from a place to an edge the shortest way counts, also beyond the end of the edge", () => {
  assert.equal(distanceOf(point(5, 3, 0), edge([0, 0, 0], [10, 0, 0])).mm, 3);
  assert.equal(distanceOf(edge([0, 0, 0], [10, 0, 0]), point(13, 4, 0)).mm, 5);
});

test("crossing, parallel and apart edges", () => {
  assert.equal(distanceOf(edge([-5, 0, 0], [5, 0, 0]), edge([0, -5, 2], [0, 5, 2])).mm, 2);
  assert.equal(distanceOf(edge([0, 0, 0], [10, 0, 0]), edge([2, 7, 0], [8, 7, 0])).mm, 7);
  assert.equal(distanceOf(edge([0, 0, 0], [1, 0, 0]), edge([4, 4, 0], [9, 4, 0])).mm, 5);
});

test("two places that are one are no distance apart", () => {
  const place = [1, 1, 1];
  assert.deepEqual(shortestWay([place, place], [place, place]), [place, place]);
});
