// Colour scales.

/** From zero to the tolerance: teal, yellow, red. The order remains visible in grey and for colour-blind people. */
const STOPS = [
  [0.0, [17, 122, 139]],
  [0.3, [63, 167, 122]],
  [0.6, [240, 200, 70]],
  [0.8, [236, 130, 50]],
  [1.0, [190, 30, 45]],
];
export const BEYOND = "#7a1fa2"; // not a colour of the scale

/** Colour (CSS) of a share of the tolerance: 0…1 on the scale, above 1 a colour of its own. */
export function colourOf(share) {
  if (!Number.isFinite(share)) return "#8a94a0";
  if (share > 1 + 1e-9) return BEYOND;
  const t = Math.max(share, 0);
  const above = Math.max(
    STOPS.findIndex(([stop]) => t <= stop),
    1,
  );
  const [[from, a], [to, b]] = [STOPS[above - 1], STOPS[above]];
  const mixed = a.map((v, i) => Math.round(v + ((b[i] - v) * (t - from)) / (to - from)));
  return `rgb(${mixed.join(",")})`;
}

/** A CSS gradient of the scale. */
export function ramp() {
  return `linear-gradient(to right, ${STOPS.map(([stop, rgb]) => `rgb(${rgb.join(",")}) ${100 * stop}%`).join(", ")})`;
}
