import assert from "node:assert/strict";
import { test } from "node:test";
import { BoxGeometry, DoubleSide, Mesh, MeshBasicMaterial } from "three";
import { clearDirection, seenFrom } from "../src/sight.js";

/** A box as a part has them, centred at a place. */
function box(size, at) {
  const mesh = new Mesh(new BoxGeometry(...size), new MeshBasicMaterial({ side: DoubleSide }));
  mesh.position.set(...at);
  mesh.updateMatrixWorld(true);
  return mesh;
}

/** A viewer that shows these boxes. */
const showing = (...parts) => ({ groups: () => parts, extent: () => ({ radius: 150 }) });

const PLATE = box([200, 100, 10], [0, 0, -5]);
const CORNER = [
  [-50, 0, 0],
  [0, 0, 0],
  [50, 0, 0],
];

test("the wanted direction is kept where nothing is in front", () => {
  assert.deepEqual(clearDirection(showing(PLATE), CORNER, [0, 0, 2]), [0, 0, 1]);
});

test("a plate in front is passed at the side", () => {
  const wall = box([300, 5, 200], [0, -40, 100]);
  const wanted = [0, -1, 0.5];
  const viewer = showing(PLATE, wall);
  assert.equal(seenFrom(viewer, CORNER, wanted), 0);
  const found = clearDirection(viewer, CORNER, wanted);
  assert.equal(seenFrom(viewer, CORNER, found), 3);
  assert.ok(found[2] > 0, "not through the plate from below");
});

test("in a closed box the wanted direction stays", () => {
  assert.deepEqual(clearDirection(showing(box([300, 300, 300], [0, 0, 0])), CORNER, [1, 0, 0]), [1, 0, 0]);
});
