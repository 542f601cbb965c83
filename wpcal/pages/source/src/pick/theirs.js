// What the page says when another window changed the table.
import { plural } from "../words.js";

const MOST_NAMED = 6;

/** @param {{changed: string[], conflicts: object[]}} merged  as from `mergeTables` */
export function theirsText({ changed, conflicts }) {
  if (conflicts.length) {
    const words = ({ row, column, mine, theirs }) =>
      `${row}, ${column}: this window has ${mine || "nothing"}, another window ${theirs || "nothing"}`;
    const cells = listed(conflicts.map(words), "; ");
    return `Two windows changed ${plural(conflicts.length, "cell")}: ${cells}. The text of this window was taken.`;
  }
  return `Changed in another window: ${listed(
    changed.map((name) => name || "a row"),
    ", ",
  )}.`;
}

function listed(texts, separator) {
  const more = texts.length > MOST_NAMED ? ` and ${texts.length - MOST_NAMED} more` : "";
  return texts.slice(0, MOST_NAMED).join(separator) + more;
}
