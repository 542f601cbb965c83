// The data in the page: `<script type="application/json" id="data">` and deflated, base64-coded blobs.
import { unpackGlb } from "./packing.js";

/** The page's JSON. */
export function readData(id = "data") {
  return JSON.parse(document.getElementById(id).textContent);
}

/** A blob as an ArrayBuffer, or null if the page has no blob of this name. */
export async function readBlob(name) {
  const element = document.getElementById(`blob-${name}`);
  if (!element) return null;
  const text = atob(element.textContent.trim());
  const bytes = Uint8Array.from(text, (character) => character.charCodeAt(0));
  const stream = new Blob([bytes]).stream().pipeThrough(new DecompressionStream("deflate"));
  const raw = await new Response(stream).arrayBuffer();
  return element.dataset.kind === "glb" ? unpackGlb(raw) : raw;
}

/** The values of a JSON blob, or null. */
export async function readJsonBlob(name) {
  const bytes = await readBlob(name);
  return bytes && JSON.parse(new TextDecoder().decode(bytes));
}
