// Coordinates as a person pastes them: from a pendant's file, a spreadsheet, a measuring report. The digits stay as they
// are written; only a decimal comma becomes a point.
const NUMBER = "[+-]?(?:\\d+(?:[.,]\\d+)?|[.,]\\d+)(?:e[+-]?\\d+)?";
const LABELLED = ["x", "y", "z"].map((axis) => new RegExp(`(?<![a-z])${axis}\\s*[:=]?\\s*(${NUMBER})`, "i"));
const PLAIN = /(?<![\w.])[+-]?(?:\d+\.?\d*|\.\d+)(?:e[+-]?\d+)?/gi; // no digits of a name like P12
const WITH_COMMA = /^[+-]?\d*(?:,\d+)?$/;
const NAME = /^[\s"']*([A-Za-z]\w*)/;

/** The same number with a decimal point. */
export function pointed(text) {
  const trimmed = text.trim();
  return /^[+-]?\d*,\d+$/.test(trimmed) ? trimmed.replace(",", ".") : trimmed;
}

/** The three coordinates of a line, as texts, or null. */
export function coordinatesIn(line) {
  const labelled = LABELLED.map((axis) => line.match(axis)?.[1]);
  if (labelled.every(Boolean)) return labelled.map(pointed);
  const words = line.split(/[;\s]+/).filter((word) => /\d/.test(word));
  const numbers = words.filter((word) => WITH_COMMA.test(word));
  if (numbers.length >= 3 && numbers.length >= words.length - 1 && numbers.some((word) => word.includes(",")))
    return numbers.slice(0, 3).map(pointed); // "812,29 -240,62 165,8", perhaps after a name
  const plain = line.match(PLAIN) ?? [];
  return plain.length >= 3 ? plain.slice(0, 3) : null;
}

/** Lines of a pasted text that hold coordinates: {name, xyz}. */
export function linesWithCoordinates(text) {
  return text
    .split(/\r?\n/)
    .map((line) => ({ name: line.match(NAME)?.[1] ?? "", xyz: coordinatesIn(line) }))
    .filter(({ xyz }) => xyz);
}
