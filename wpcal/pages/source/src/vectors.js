// Vectors of three numbers.

export function cross([a, b, c], [x, y, z]) {
  return [b * z - c * y, c * x - a * z, a * y - b * x];
}

export function normalised(v) {
  const length = Math.hypot(...v);
  return v.map((value) => value / length);
}

/** Two unit vectors that complete a unit vector `z` to right-handed axes x, y, z. */
export function acrossTo(z) {
  const sizes = z.map(Math.abs);
  const least = sizes.indexOf(Math.min(...sizes));
  const helper = [0, 1, 2].map((i) => Number(i === least));
  const x = normalised(cross(helper, z));
  return [x, cross(z, x)];
}
