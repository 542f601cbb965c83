// Coordinates as a person pastes them: from a file of the pendant, a spreadsheet, a measuring report. The digits stay
// as written; signs and decimal marks become those of a file. A text that can be read in two ways is not read.
const NUMBER = "[+-]?(?:\\d+(?:[.,]\\d*)?|[.,]\\d+)(?:e[+-]?\\d+)?";
const LABELLED = new RegExp(
  ["x", "y", "z"].map((axis) => `(?<![a-z])${axis}\\s*[:=]?\\s*(${NUMBER})`).join("[^xyz]*?"), // KUKA, FANUC, reports
  "gi",
);
const BRACKETED = new RegExp(
  `\\[\\s*\\[\\s*${Array(3)
    .fill(`(${NUMBER.replaceAll(",", "")})`)
    .join("\\s*,\\s*")}\\s*\\]`,
  "gi",
); // ABB
const DECLARED = /([A-Za-z_]\w*)\s*:?=[\s{[]*$/; // the name before a position in a program
const PLAIN = /^[+-]?(?:\d+\.?\d*|\.\d+)(?:e[+-]?\d+)?$/i;
const COMMA = /^[+-]?\d*,\d+$/;
const THOUSANDS = [/^[+-]?\d{1,3}(?:\.\d{3})+,\d+$/, /^[+-]?\d{1,3}(?:,\d{3})+\.\d+$/];
const HALF = /^[+-]?(?:\d*[.,]?|(?:\d+[.,]?\d*|[.,]\d+)e[+-]?)$/i; // the beginning of a number
const MINUS = /[\u2212\u2013\uFE63\uFF0D]/g; // minus signs of typesetters and spreadsheets
const LONGEST = 9; // numbers per line: a position with its angles, and more

/** The same number with a decimal point. A text that is not a number stays as it is. */
export function pointed(text) {
  const trimmed = text
    .trim()
    .replace(MINUS, "-")
    .replace(/(\d)\s*mm$/i, "$1");
  if (COMMA.test(trimmed)) return trimmed.replace(",", ".");
  if (THOUSANDS[0].test(trimmed)) return trimmed.replaceAll(".", "").replace(",", ".");
  return THOUSANDS[1].test(trimmed) ? trimmed.replaceAll(",", "") : trimmed;
}

/** Whether a text is the beginning of a number and not yet one. */
export function isHalfANumber(text) {
  return text !== "" && HALF.test(text) && !/^[+-]?\d+\.?$/.test(text);
}

/** Positions in a pasted text: {name, xyz}. The name may be empty; the coordinates are texts. */
export function positionsIn(text) {
  const plain = text.replace(MINUS, "-");
  for (const pattern of [LABELLED, BRACKETED]) {
    const found = [...plain.matchAll(pattern)];
    if (found.length)
      return found.map((match, k) => ({ name: nameBefore(plain, found, k), xyz: match.slice(1, 4).map(ended) }));
  }
  const lines = plain.split(/\r?\n/).filter((line) => line.trim());
  const below = lines.map(pointed);
  if (below.length === 3 && below.every((line) => PLAIN.test(line))) return [{ name: "", xyz: below }];
  return lines.map(positionInLine).filter(Boolean);
}

/** The name of a position: at the beginning of its line, or in its declaration. */
function nameBefore(text, found, k) {
  const start = k ? found[k - 1].index + found[k - 1][0].length : 0;
  const before = text.slice(start, found[k].index);
  const numbered = [...before.matchAll(/\bP\[\s*(\d+)\s*(?::\s*"?([^"\]]*))?/g)].at(-1); // FANUC
  if (numbered) return numbered[2]?.trim() || `P${numbered[1]}`;
  const lines = before.split(/\r?\n/);
  return lines.at(-1).match(DECLARED)?.[1] ?? lines.at(-1).match(/^\s*([A-Za-z_]\w*)[\s,;:]+\{?\s*$/)?.[1] ?? "";
}

/** The number without a final comma or point. */
function ended(number) {
  return pointed(number.replace(/[.,]$/, ""));
}

/** The position in a line whose words are separated by blanks, tabs or semicolons, or else by commas. */
function positionInLine(line) {
  const bare = line.replace(/["'[\](){}]/g, " ").replace(/(\d)\s*mm\b/gi, "$1 ");
  const declared = bare.match(/^\s*([A-Za-z_]\w*)\s*:?=(.*)/);
  const content = declared ? declared[2] : bare;
  const [blanks, commas] = [content.split(/[;\s]+|,\s+/), content.split(/[,;\s]+/)].map((words) =>
    words.filter(Boolean),
  );
  const isInDoubt = !content.includes(".") && commas.length > 4; // 812,29,-240,62,165,80: six numbers, or three?
  const position = positionOf(blanks) ?? (isInDoubt ? null : positionOf(commas));
  return position && { name: declared?.[1] ?? "", ...position };
}

/** The position in some words: a name or a count, three coordinates, perhaps angles. */
function positionOf(words) {
  const isNumber = (word) => PLAIN.test(pointed(word));
  const first = words.findIndex(isNumber);
  const numbers = words.slice(first);
  const isCounted =
    /^\d+$/.test(numbers[0]) && numbers.length > 3 && numbers.slice(1, 4).every((word) => /[.,]/.test(word));
  const own = isCounted ? numbers.slice(1) : numbers;
  const isPosition =
    first >= 0 && first <= 1 && own.length >= 3 && own.length <= LONGEST && own.slice(0, 3).every(isNumber);
  if (!isPosition) return null;
  return { ...(first ? { name: words[0].replace(/:$/, "") } : {}), xyz: own.slice(0, 3).map(pointed) };
}
