// What the solids of a part are taken for: members that can be welded, fasteners, and so on, and why.
import { el, table } from "../dom.js";

/**
 * The table under the seams; null for a record without members.
 *
 * @param {{solid: string, taken_as: string, factor: number, why: string[]}[]} members
 * @param {function(string)} onFind  gets the name of a solid whose seams a person wants to see
 */
export function memberTable(members, onFind) {
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
  const rowOf = (member) => ({ id: idOf(members, member.solid), tabindex: -1, class: member.factor < 1 ? "dim" : "" });
  const caption = "what the solids are taken for; wpcal seams --weld NAME or --not NAME sets it right";
  return el("section", { id: "members" }, table(columns, members, { rowOf, caption }));
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
  const row = document.getElementById(id);
  row.scrollIntoView({ block: "center" });
  row.focus();
}

function idOf(members, solid) {
  const row = members.findIndex((member) => member.solid === solid);
  return row < 0 ? null : `solid-${row + 1}`;
}
