import assert from "node:assert/strict";
import test from "node:test";

import { DOT, MOST_FULL, sharesOf } from "../src/pick/thinning.js";

const at = (x, y, inside = true) => ({ x, y, inside });
const nobody = () => false;

test("the marks of a small part are all drawn in full", () => {
  const shares = sharesOf(Array(MOST_FULL).fill(at(5, 5)), () => true);
  assert.deepEqual([...new Set(shares)], [1]);
});

test("of many marks in one place the first is drawn in full", () => {
  const shares = sharesOf(Array(5000).fill(at(5, 5)), nobody);
  assert.deepEqual([shares[0], shares.slice(1).some(Boolean)], [1, false]);
});

test("a mark behind the part takes no place from others", () => {
  const shares = sharesOf([at(2, 2), at(9, 2), ...Array(MOST_FULL).fill(at(-9, 2, false))], (i) => i === 0);
  assert.deepEqual([...shares.slice(0, 3)], [0, 1, 0]);
});

test("the marks cover little of the part, and near to every mark one is drawn", () => {
  const places = [];
  for (let x = 0; x < 960; x += 4) for (let y = 0; y < 720; y += 4) places.push(at(x + 1, y + 1));
  const shares = [...sharesOf(places, nobody)];
  assert.equal(shares.filter((share) => share === 1).length, MOST_FULL);
  assert.ok(shares.every((share) => [0, 1, Math.fround(DOT)].includes(share)));
  const area = shares.reduce((sum, share) => sum + (Math.PI / 4) * (7 * share) ** 2, 0);
  assert.ok(area < 0.12 * 960 * 720, `${area}`);
  const drawn = new Set(places.filter((_, i) => shares[i]).map(({ x, y }) => `${x >> 3},${y >> 3}`));
  assert.ok(places.every(({ x, y }) => drawn.has(`${x >> 3},${y >> 3}`)));
});
