// Residuals as arrows, drawn longer than they are.
import { acrossTo } from "./vectors.js";

const RESIDUAL = "#d6246e"; // no colour scale of the pages has it
const LONGEST_PART = 0.2; // of the radius of everything: no residual is drawn longer
export const FACTORS = [1, 2, 5, 10, 20, 50, 100, 200, 500, 1000, 2000, 5000, 10000];

/** The largest factor by which the longest of some distances can be drawn. */
export function fittingFactor(distances, radius) {
  const longest = Math.max(...distances, 1e-9);
  return FACTORS.filter((factor) => factor * longest <= LONGEST_PART * radius).at(-1) ?? FACTORS[0];
}

/** Paths from a place along `factor` times the vector `r`, with four barbs at the tip. */
export function arrow(start, r, factor, color = RESIDUAL) {
  const end = start.map((v, i) => v + factor * r[i]);
  const length = Math.hypot(...r);
  if (length === 0) return [];
  const x = r.map((v) => v / length);
  const [y, z] = acrossTo(x);
  const back = 0.18 * factor * length;
  const barb = (side, sign) => end.map((v, i) => v - back * x[i] + sign * 0.4 * back * side[i]);
  const tips = [barb(y, 1), barb(y, -1), barb(z, 1), barb(z, -1)];
  return [[start, end], ...tips.map((tip) => [end, tip])].map((pair) => ({ points: pair, color }));
}
