// What the solids of a part are taken for: members that can be welded, fasteners, and so on, and why.
import { drawAllLines, el, table } from "../dom.js";

/**
 * The table under the seams; null for a record without members.
 *
 * @param {{solid: string, taken_as: string, factor: number, why: string[]}[]} members
 * @param {function(string)} onFind  gets the name of a solid whose seams a person wants to see
 * @param {{onSay: function(string, string), options: string}} [said]  `onSay` gets the name of a solid and what is said
 *   about it: rules, weld or not; `options` say the same on a command line
 */
export function memberTable(members, onFind, said = null) {
  if (!members.length) return null;
  const button = ({ solid }) => {
    const attributes = { type: "button", class: "find", title: `the seams of ${solid}`, onclick: () => onFind(solid) };
    return el("button", attributes, solid);
  };
  const columns = [
    { title: "solid", cell: button },
    { title: "taken for", cell: ({ taken_as }) => taken_as },
    { title: "why", cell: ({ why }) => why.join("; ") },
  ];
  if (said) columns.push({ title: "you say", cell: (member) => choice(member, said.onSay) });
  const rowOf = (member) => ({ id: idOf(members, member.solid), tabindex: -1, class: member.factor < 1 ? "dim" : "" });
  const how = said?.options || "wpcal seams --weld NAME or --not NAME sets it right";
  const caption = `what the solids are taken for; ${said?.options ? `as options: ${how}` : how}`;
  return el("section", { id: "members" }, table(columns, members, { rowOf, caption }));
}

const WORDS = { rules: null, weld: true, not: false };

/** Whether a solid can be welded, as a person says it. */
function choice({ solid, said }, onSay) {
  const options = Object.entries(WORDS).map(([word, value]) =>
    el("option", { value: word, selected: value === (said ?? null) }, word === "rules" ? "" : word),
  );
  const onchange = ({ target }) => onSay(solid, target.value);
  return el("select", { class: "said", "aria-label": `${solid}: weld or not`, onchange }, options);
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
