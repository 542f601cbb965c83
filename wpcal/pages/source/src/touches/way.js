// The way of the tool centre point through all searches, and where it is at a time.
import { rowAt, stateAt } from "../plan/times.js";

/**
 * The stations of the way: {t: number[], p: number[][], row: number[], what: string[]}. `row` and `what` belong to the
 * move that ends at the station.
 *
 * @param {object} data  of the page
 */
export function wayOf({ searches, air_speed_mm_s: air, search_speed_mm_s: slow, hold_s: hold }) {
  const way = { t: [], p: [], row: [], what: [] };
  const go = (p, row, what, speed) => {
    const before = way.p.at(-1);
    const length = before ? Math.hypot(...p.map((v, i) => v - before[i])) : 0;
    stay(p, row, what, length / speed);
  };
  const stay = (p, row, what, seconds) => {
    way.t.push((way.t.at(-1) ?? 0) + seconds);
    way.p.push(p);
    way.row.push(row);
    way.what.push(what);
  };
  searches.forEach((search, row) => {
    for (const p of [...search.via, search.approach]) go(p, row, "to", air);
    go(search.start, row, "to", air);
    go(search.planned, row, "searches", slow);
    stay(search.planned, row, "touches", hold);
    go(search.start, row, "leaves", air);
    go(search.retract, row, "leaves", air);
  });
  return way;
}

/** Where the tool centre point is: {p, row, what}. */
export function placeAt(way, t) {
  const { row, part } = stateAt(way.t, t);
  const next = Math.min(row + 1, way.t.length - 1);
  const p = way.p[row].map((v, i) => v + part * (way.p[next][i] - v));
  return { p, row: way.row[next], what: way.what[rowAt(way.t, t) === way.t.length - 1 ? way.t.length - 1 : next] };
}

/** The time at which a search begins. */
export function beginOf(way, row) {
  return way.t[way.row.findIndex((one, k) => one === row && way.what[k] === "searches") - 1];
}
