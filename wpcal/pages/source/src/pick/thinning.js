// The marks of a large part: of those near one another on the screen only one is drawn in full, so that the marks do
// not hide the part. The pointer finds all of them.

export const MOST_FULL = 300; // marks in full; with so few the part is visible whatever their places
export const DOT = 0.35; // of the full size
const CELL_PX = 24; // one mark in full per square of this size: at most 7 % of it
const DOT_CELL_PX = 8; // one dot per square of this size: at most 8 % of it

/**
 * How large each mark is drawn, as a share of its full size.
 *
 * @param {{x: number, y: number, inside: boolean}[]} places  pixels of the view, the most useful marks first
 * @param {function(number): boolean} isHidden  whether the part hides the mark of that number
 * @returns {Float32Array}  1, `DOT` or 0
 */
export function sharesOf(places, isHidden) {
  if (places.length <= MOST_FULL) return new Float32Array(places.length).fill(1);
  const shares = new Float32Array(places.length);
  const [cells, dots] = [new Set(), new Set()];
  let full = 0;
  places.forEach(({ x, y, inside }, i) => {
    const [cell, dot] = [CELL_PX, DOT_CELL_PX].map((px) => `${Math.floor(x / px)},${Math.floor(y / px)}`);
    const isFull = full < MOST_FULL && !cells.has(cell);
    if (!inside || (!isFull && dots.has(dot)) || isHidden(i)) return;
    cells.add(cell);
    dots.add(dot);
    shares[i] = isFull ? 1 : DOT;
    full += isFull;
  });
  return shares;
}
