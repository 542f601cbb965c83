// The members of a part: what they are and weigh, the welds on them, what the solids are taken for, and why.
import { drawAllLines, el, fixed, table } from "../dom.js";

/** What a person may say of a solid, and how it reads; of a member of a solid all but the first two. */
const WORDS = {
  weld: "weld",
  not: "not",
  plate: "plate",
  bar: "bar",
  tube: "tube",
  profile: "profile",
  piece: "one piece, welded to others",
  cast: "cast or bought, not welded",
  weldment: "welded of pieces",
};
const RULES = "rules";

/** One row for each solid, and one for each of its members if it was several. */
export function memberRows(members) {
  return members.flatMap((member) => {
    const [whole, ...parts] = member.listed ?? [];
    return [{ ...whole, ...member, name: member.solid }, ...parts.map((part) => ({ ...part, solid: null }))];
  });
}

/** What is said about a member by its name: one of the words, the name of the member with which it is one, or rules. */
export function wordOf({ name, said = null }, judging) {
  const own = judging?.members?.find(({ member }) => member === name);
  if (own) return own.is;
  return said === null ? RULES : said ? "weld" : "not";
}

/**
 * The table under the seams; null for a record without members.
 *
 * @param {{solid: string, taken_as: string, factor: number, why: string[], listed: object[]}[]} members
 * @param {function(string)} onFind  gets the name of a solid or member whose seams a person wants to see
 * @param {{onSay: function(string, string), judging: object}} [said]  `onSay` gets a name, and a word of
 *   `wordOf`
 */
export function memberTable(members, onFind, said = null) {
  if (!members.length) return null;
  const rows = memberRows(members);
  const button = ({ name }) => {
    const attributes = {
      type: "button",
      class: "find",
      title: `faces and seams of ${name}`,
      onclick: () => onFind(name),
    };
    return el("button", attributes, name);
  };
  const number = (title, value) => ({ title, number: true, cell: (row) => (row.kind === undefined ? "" : value(row)) });
  const columns = [
    { title: "member", cell: button },
    { title: "is", cell: ({ kind }) => el("span", { class: "size" }, kind ?? "") },
    number("length mm", ({ length_mm }) => (length_mm ? fixed(length_mm, 0) : "")),
    number("kg", ({ mass_kg }) => fixed(mass_kg, 2)),
    number("weld mm", ({ weld_mm }) => fixed(weld_mm, 0)),
    { title: "taken for", cell: ({ taken_as }) => taken_as ?? "" },
    { title: "why", cell: ({ why }) => (why ?? []).join("; ") },
  ];
  const ticked = new Set();
  const together = el("button", { type: "button", class: "together", disabled: true }, "These two are one");
  if (said) {
    const onTick = (name, isOn) => {
      if (isOn) ticked.add(name);
      else ticked.delete(name);
      together.disabled = ticked.size !== 2;
    };
    together.addEventListener("click", () => said.onSay(...ticked));
    columns.unshift({ title: "", cell: ({ name }) => tickBox(name, onTick) });
    columns.splice(3, 0, { title: "you say", cell: (row) => choice(row, said) });
  }
  const rowOf = ({ name, solid, factor }) => ({
    id: solid ? idOf(members, name) : null,
    tabindex: -1,
    class: `${factor < 1 ? "dim" : ""}${solid ? "" : " of-solid"}`,
  });
  const how = said
    ? "what you say is kept with the decisions about seams"
    : "wpcal seams --member NAME=KIND, --weld NAME or --not NAME sets it right";
  const parts = [
    table(columns, rows, { rowOf, caption: `members${weightOf(rows)}, and what the solids are taken for; ${how}` }),
  ];
  if (said) parts.unshift(together);
  return el("section", { id: "members" }, parts);
}

/** The weight of the whole part. */
function weightOf(rows) {
  const kg = rows.reduce((sum, { solid, mass_kg }) => sum + (solid ? mass_kg : 0), 0);
  return Number.isFinite(kg) ? ` (${fixed(kg, 2)} kg)` : "";
}

function tickBox(name, onTick) {
  const onchange = ({ target }) => onTick(name, target.checked);
  return el("input", { type: "checkbox", class: "tick", "aria-label": `tick ${name}`, onchange });
}

/** What a member is, as a person says it. */
function choice(row, { onSay, judging }) {
  const word = wordOf(row, judging);
  const words = Object.entries(WORDS).slice(row.solid ? 0 : 2);
  const isOther = word !== RULES && !(word in WORDS); // the name of the member with which it is one
  const all = [[RULES, ""], ...words, ...(isOther ? [[word, `one with ${word}`]] : [])];
  const options = all.map(([value, text]) => el("option", { value, selected: value === word }, text));
  const onchange = ({ target }) => onSay(row.name, target.value);
  return el("select", { class: "said", "aria-label": `${row.name} is`, onchange }, options);
}

/** The names of the solids that a seam joins, each with a link to what the solid is taken for. */
export function solidLinks(members, solids) {
  return solids.map((solid, k) => {
    const id = idOf(members, solid);
    const text = id ? el("a", { href: `#${id}`, onclick: (event) => goTo(event, id) }, solid) : solid;
    return [k ? " + " : "", text];
  });
}

/** Without a new entry in the browser's history: its back button leaves the page, as before. */
function goTo(event, id) {
  event.preventDefault();
  if (!document.getElementById(id)) drawAllLines();
  const row = document.getElementById(id);
  row.scrollIntoView({ block: "center" });
  row.focus();
}

function idOf(members, solid) {
  const row = members.findIndex((member) => member.solid === solid);
  return row < 0 ? null : `solid-${row + 1}`;
}
