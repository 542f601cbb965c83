// Names that no other window gives.

/** 128 random bits; `crypto.randomUUID` is missing where the page is not served by this machine. */
export function randomName() {
  return Array.from(crypto.getRandomValues(new Uint8Array(16)), (byte) => byte.toString(16).padStart(2, "0")).join("");
}
