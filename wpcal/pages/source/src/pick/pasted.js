// What a pasted text is: a table of taught points, positions, or neither.
import { plural } from "../words.js";
import { positionsIn } from "./numbers.js";

const HEADER = /(^|[,;\t"])\s*x_mm\s*([,;\t"]|$)/im; // of a table of taught points
const IN_USER_FRAME = /\bUF\s*:\s*[1-9]|\bBASE_NO\s+[1-9]/i; // of FANUC and KUKA

/** Whether a text is a table of taught points with its header. */
export function isTable(text) {
  return HEADER.test(text);
}

/**
 * The positions in a text, and whether they are in a user frame, so that they are not coordinates in the base.
 *
 * @returns {{positions: {name: string, xyz: string[]}[], isInUserFrame: boolean}}
 */
export function readPasted(text) {
  return { positions: positionsIn(text), isInUserFrame: IN_USER_FRAME.test(text) };
}

/** What the page says after a paste. */
export function pastedText({ positions, isInUserFrame }, newRows) {
  const what = `${plural(positions.length, "position")} pasted${newRows ? `, ${newRows} as new rows` : ""}.`;
  const warning = " They are in a user frame: open the file instead. The page then asks for the frame.";
  return isInUserFrame ? what + warning : what;
}
