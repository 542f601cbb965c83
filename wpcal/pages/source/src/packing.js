// Restores a GLB file from the form that `wpcal/pages/packing.py` writes.

const KINDS = { 5120: Uint8Array, 5123: Uint16Array, 5125: Uint32Array };
const HEADER = 12;
const CHUNK = 8;
const [JSON_CHUNK, BIN_CHUNK, MAGIC] = [0x4e4f534a, 0x004e4942, 0x46546c67];

/** The bytes of the GLB file. */
export function unpackGlb(packed) {
  const length = new DataView(packed).getUint32(0, true);
  const text = new Uint8Array(packed, 4, length);
  const document = JSON.parse(new TextDecoder().decode(text));
  const size = Math.ceil(document.buffers[0].byteLength / 4) * 4;
  const glb = new ArrayBuffer(HEADER + 2 * CHUNK + length + size);
  const view = new DataView(glb);
  [MAGIC, 2, glb.byteLength, length, JSON_CHUNK].forEach((value, i) => view.setUint32(4 * i, value, true));
  new Uint8Array(glb).set(text, HEADER + CHUNK);
  [size, BIN_CHUNK].forEach((value, i) => view.setUint32(HEADER + CHUNK + length + 4 * i, value, true));
  const start = HEADER + 2 * CHUNK + length;
  let at = 4 + length;
  for (const { bufferView, componentType, count } of document.accessors) {
    const { byteOffset, byteStride } = document.bufferViews[bufferView];
    const kind = KINDS[componentType];
    const width = (byteStride ?? kind.BYTES_PER_ELEMENT) / kind.BYTES_PER_ELEMENT;
    const bytes = new Uint8Array(packed, at, count * width * kind.BYTES_PER_ELEMENT);
    unpackRows(bytes, new kind(glb, start + byteOffset, count * width), width);
    at += bytes.length;
  }
  return glb;
}

/** Restores rows from planes of bytes: a column is the running sum of differences whose signs are in the last bit. */
function unpackRows(bytes, rows, width) {
  const planes = rows.BYTES_PER_ELEMENT;
  const count = rows.length / width;
  for (let column = 0; column < width; column += 1) {
    let sum = 0;
    for (let i = 0; i < count; i += 1) {
      let folded = 0;
      for (let plane = planes - 1; plane >= 0; plane -= 1) {
        folded = ((folded << 8) | bytes[plane * rows.length + column * count + i]) >>> 0;
      }
      sum += (folded >>> 1) ^ -(folded & 1);
      rows[i * width + column] = sum; // overflows like the differences did
    }
  }
}
