// One cell of the table of taught points: a text field, or a list of the words that the column allows.
import { el } from "../dom.js";
import { PLACE } from "./rows.js";

/** The id of the page's list of feature names, which the browser offers while a name is typed. */
export const FEATURE_LIST = "feature-names";

/**
 * The input of a cell. The caller listens to its events.
 *
 * @param {object} row  cells of text by column
 * @param {string} name  of the column
 * @param {string[]} [words]  the only words that the column allows, if there are such
 */
export function cellInput(row, name, words) {
  return words ? choice(row[name], name, words) : field(row[name], name);
}

function choice(text, name, words) {
  const known = words.includes(text) ? words : [text, ...words];
  const options = known.map((word) => el("option", { value: word, selected: word === text }, word));
  return el("select", { "aria-label": name }, options);
}

/** A text field without `inputmode`: the number pad of some tablets has no minus. */
function field(text, name) {
  return el("input", {
    type: "text",
    value: text,
    "aria-label": name,
    placeholder: PLACE.includes(name) ? name[0] : null, // a narrow window shows no headings
    autocomplete: "off",
    spellcheck: "false",
    list: name === "feature" ? FEATURE_LIST : null,
  });
}
