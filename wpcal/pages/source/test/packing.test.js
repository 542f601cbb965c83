import assert from "node:assert/strict";
import test from "node:test";

import { unpackGlb } from "../src/packing.js";

const DOCUMENT = {
  buffers: [{ byteLength: 34 }],
  bufferViews: [{ byteOffset: 0, byteStride: 8 }, { byteOffset: 16, byteStride: 4 }, { byteOffset: 24 }],
  accessors: [
    { bufferView: 0, componentType: 5123, count: 2 },
    { bufferView: 1, componentType: 5120, count: 2 },
    { bufferView: 2, componentType: 5125, count: 2 },
  ],
};
const NUMBERS = [
  { kind: Uint16Array, width: 4, rows: [1, 65535, 300, 0, 0, 2, 40000, 0] },
  { kind: Uint8Array, width: 4, rows: [127, 129, 0, 0, 1, 255, 64, 0] },
  { kind: Uint32Array, width: 1, rows: [4_000_000_000, 7] },
];

/** What `wpcal/pages/packing.py` writes for these rows: folded differences, one plane per byte. */
function packed({ kind, width, rows }) {
  const bits = 8 * kind.BYTES_PER_ELEMENT;
  const count = rows.length / width;
  const folded = [];
  for (let column = 0; column < width; column += 1) {
    for (let i = 0; i < count; i += 1) {
      const before = i ? rows[(i - 1) * width + column] : 0;
      const step = BigInt.asIntN(bits, BigInt(rows[i * width + column]) - BigInt(before));
      folded.push(step < 0n ? -2n * step - 1n : 2n * step);
    }
  }
  const planes = Array.from({ length: kind.BYTES_PER_ELEMENT }, (_, plane) =>
    folded.map((value) => Number((value >> BigInt(8 * plane)) & 255n)),
  );
  return planes.flat();
}

test("a GLB file comes back number by number", () => {
  const text = new TextEncoder().encode(JSON.stringify(DOCUMENT).padEnd(400));
  const bytes = new Uint8Array([
    ...new Uint8Array(new Uint32Array([text.length]).buffer),
    ...text,
    ...NUMBERS.flatMap(packed),
  ]);
  const glb = unpackGlb(bytes.buffer);
  const view = new DataView(glb);
  assert.deepEqual([view.getUint32(0, true), view.getUint32(4, true)], [0x46546c67, 2]);
  assert.equal(view.getUint32(8, true), glb.byteLength);
  assert.deepEqual(JSON.parse(new TextDecoder().decode(new Uint8Array(glb, 20, text.length))), DOCUMENT);
  const start = 20 + text.length + 8;
  NUMBERS.forEach(({ kind, rows }, i) => {
    assert.deepEqual([...new kind(glb, start + DOCUMENT.bufferViews[i].byteOffset, rows.length)], rows);
  });
});
