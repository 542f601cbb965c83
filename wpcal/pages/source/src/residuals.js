// Residuals as arrows, drawn longer than they are.
const RESIDUAL = "#d6246e"; // on no colour scale of the pages
const LONGEST_PART = 0.2; // a residual is drawn at most this long, as a part of the radius of everything
export const FACTORS = [1, 2, 5, 10, 20, 50, 100, 200, 500, 1000, 2000, 5000, 10000];

/** The largest factor by which the longest of some distances can be drawn. */
export function fittingFactor(distances, radius) {
  const longest = Math.max(...distances, 1e-9);
  return FACTORS.filter((factor) => factor * longest <= LONGEST_PART * radius).at(-1) ?? FACTORS[0];
}

/** Paths from the fitted place along `factor` times the residual, with four barbs. */
export function arrow(start, r, factor) {
  const end = start.map((v, i) => v + factor * r[i]);
  const length = Math.hypot(...r);
  if (length === 0) return [];
  const x = r.map((v) => v / length);
  const least = x.map(Math.abs).indexOf(Math.min(...x.map(Math.abs)));
  const y = normalised(
    cross(
      x,
      [0, 1, 2].map((i) => Number(i === least)),
    ),
  );
  const z = cross(x, y);
  const back = 0.18 * factor * length;
  const barb = (side, sign) => end.map((v, i) => v - back * x[i] + sign * 0.4 * back * side[i]);
  const tips = [barb(y, 1), barb(y, -1), barb(z, 1), barb(z, -1)];
  return [[start, end], ...tips.map((tip) => [end, tip])].map((pair) => ({ points: pair, color: RESIDUAL }));
}

function cross([a, b, c], [x, y, z]) {
  return [b * z - c * y, c * x - a * z, a * y - b * x];
}

function normalised(v) {
  const length = Math.hypot(...v);
  return v.map((value) => value / length);
}
