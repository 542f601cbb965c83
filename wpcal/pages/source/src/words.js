// Sentences that several pages need.
import { short } from "./dom.js";

/** "1 row", "2 rows". */
export function plural(count, noun) {
  return `${count} ${noun}${count === 1 ? "" : "s"}`;
}

/**
 * The verdict of a fit as a sentence.
 *
 * @param {{verdict: "PASS"|"FAIL", tolerance_mm: number}} calibration  or an answer of the picker's server
 */
export function verdictText({ verdict, tolerance_mm: tolerance }) {
  const what = verdict === "PASS" ? "Every point is within" : "A point is off by more than";
  return `${what} the tolerance of ${short(tolerance)} mm.`;
}
