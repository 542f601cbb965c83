// What a person decides about seams, as data: the objects `candidate` and `edit` of seams.json. wpcal carries decisions
// out and judges what follows; nothing here moves a torch.
//
// A seam is shown as {name, accepted, candidate, edit?, length_mm, closed, …}. An operation is {kind, row, …}:
//   {kind: "accept" | "refuse", row} or, for several at once, {kind, rows}
//   {kind: "turn" | "otherSide" | "separate", row}
//   {kind: "rename", row, name}    {kind: "cut", row, s: mm from the start}    {kind: "join", row, other: row}

const SAME_MM = 1e-6; // two lengths of one candidate are the same place
const LETTERS = "abcdefghijklmnopqrstuvwxyz";

/** Why an operation is not possible, for the person who asked for it. */
export class Refusal extends Error {}

/** The decisions behind the seams that are shown. */
export function decisionsOf(seams) {
  return seams.filter(({ edit }) => edit).map(({ candidate, edit }) => ({ candidate, edit }));
}

/**
 * The decisions after an operation.
 *
 * @throws {Refusal} if the operation is not possible
 */
export function decisionsAfter(seams, operation) {
  const { edits, freed } = changesBy(seams, operation);
  const kept = seams.flatMap(({ candidate, edit }, row) =>
    (edits.get(row) ?? [edit]).filter(isSomething).map((one) => ({ candidate, edit: one })),
  );
  return [...kept, ...freed.filter(({ edit }) => isSomething(edit))];
}

/**
 * What an operation changes: the new edits by row (none: the seam is now a part of another one), and the decisions
 * about stretches that are seams of their own again.
 *
 * @returns {{edits: Map<number, object[]>, freed: {candidate: object, edit: object}[]}}
 */
export function changesBy(seams, operation) {
  const { kind, row } = operation;
  if (kind === "accept" || kind === "refuse") return decided(seams, kind, operation.rows ?? [row]);
  const own = { ...(seams[row].edit ?? {}) };
  const one = (edit) => ({ edits: new Map([[row, [edit]]]), freed: [] });
  if (kind === "turn") return one(toggled(own, "reverse"));
  if (kind === "otherSide") return one(toggled(own, "other_side"));
  if (kind === "rename") return one({ ...own, name: newName(seams, row, operation.name) });
  if (kind === "cut") return { edits: new Map([[row, cut(seams, row, operation.s)]]), freed: [] };
  if (kind === "join") return join(seams, row, operation.other);
  if (kind === "separate") return separate(seams, row);
  throw new Error(`unknown operation ${kind}`);
}

/** Seams that are welded, or not, whatever wpcal thinks of them. */
function decided(seams, kind, rows) {
  const [said, other] = kind === "accept" ? ["accept", "reject"] : ["reject", "accept"];
  const editOf = (row) => ({ ...without(seams[row].edit ?? {}, other), [said]: true });
  return { edits: new Map(rows.map((row) => [row, [editOf(row)]])), freed: [] };
}

function isSomething(edit) {
  return Boolean(edit) && Object.keys(edit).length > 0;
}

function without(edit, ...names) {
  return Object.fromEntries(Object.entries(edit).filter(([name]) => !names.includes(name)));
}

function toggled(edit, name) {
  return edit[name] ? without(edit, name) : { ...edit, [name]: true };
}

function newName(seams, row, text) {
  const name = text.trim();
  if (!name) throw new Refusal("Type a name.");
  if (seams.some((seam, other) => other !== row && seam.name === name))
    throw new Refusal(`Another seam is called ${name}.`);
  return name;
}

/** The stretch of its candidate that a seam is. */
function rangeOf({ candidate, edit }) {
  return edit?.range_mm ?? [0, candidate.length_mm];
}

function cut(seams, row, s) {
  const seam = seams[row];
  if (seam.edit?.join) throw new Refusal("Separate the joined seams first, then cut the one that is meant.");
  const [low, high] = rangeOf(seam);
  const isForwards = !seam.edit?.reverse;
  const at = isForwards ? low + s : high - s;
  if (!(at > low + SAME_MM && at < high - SAME_MM))
    throw new Refusal(`Cut between 0 and ${(high - low).toFixed(1)} mm from the start.`);
  const halves = [
    { ...seam.edit, range_mm: [low, at] },
    { ...seam.edit, range_mm: [at, high] },
  ];
  const names = freeNames(seams, seam.name);
  return (isForwards ? halves : halves.reverse()).map((edit, k) => ({ ...edit, name: names[k] }));
}

/** Two names that no seam has. */
function freeNames(seams, name) {
  const taken = new Set(seams.map((seam) => seam.name));
  return [...LETTERS].map((letter) => name + letter).filter((text) => !taken.has(text));
}

function join(seams, row, other) {
  const [first, second] = [seams[row], seams[other]];
  if (row === other) throw new Refusal("Choose another seam to join with.");
  if (first.closed || second.closed) throw new Refusal("A closed seam has no end to join.");
  const edit = { ...(first.edit ?? {}) };
  const whole = mergedRange(first, second);
  if (whole) Object.assign(edit, { range_mm: whole });
  else edit.join = [...(edit.join ?? []), stretchOf(second), ...(second.edit?.join ?? [])];
  const isWhole = whole && whole[0] === 0 && Math.abs(whole[1] - first.candidate.length_mm) <= SAME_MM;
  const isCutName = new RegExp(`^${escaped(first.candidate.name)}[a-z]$`).test(edit.name ?? "");
  const kept = isWhole ? without(edit, "range_mm", ...(isCutName ? ["name"] : [])) : edit;
  return {
    edits: new Map([
      [row, [kept]],
      [other, []],
    ]),
    freed: [],
  };
}

function escaped(text) {
  return text.replace(/[.*+?^${}()|[\]\\]/g, "\\$&");
}

/** The stretch of two neighbouring parts of one candidate, or null. */
function mergedRange(first, second) {
  const isOne = JSON.stringify(first.candidate) === JSON.stringify(second.candidate);
  if (!isOne || first.edit?.join || second.edit?.join) return null;
  const [a, b] = [rangeOf(first), rangeOf(second)].sort((one, two) => one[0] - two[0]);
  return Math.abs(a[1] - b[0]) <= SAME_MM ? [a[0], b[1]] : null;
}

function stretchOf({ candidate, edit }) {
  return edit?.range_mm ? { candidate, range_mm: edit.range_mm } : { candidate };
}

function separate(seams, row) {
  const { edit } = seams[row];
  if (!edit?.join) throw new Refusal("This seam is not joined.");
  const taken = seams.map((seam) => ({ name: seam.name }));
  const freed = edit.join.map(({ candidate, range_mm }) => {
    if (!range_mm) return { candidate, edit: null };
    const [name] = freeNames(taken, candidate.name);
    taken.push({ name });
    return { candidate, edit: { range_mm, name } };
  });
  return { edits: new Map([[row, [without(edit, "join")]]]), freed };
}
