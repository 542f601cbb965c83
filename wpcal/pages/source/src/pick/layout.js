// The elements of the picker's page and where they are.
import { el } from "../dom.js";

/**
 * Fills `root` and returns the elements that change: {view, state, gauges, suggestButton, addButton, showNotes(texts),
 * showName(name), showPromise(element)}.
 *
 * @param {object} data  of the page
 * @param {string} savesTo  the file that the page saves
 * @param {{table: HTMLElement, frameForm: HTMLElement, saveForm: HTMLElement, status: HTMLElement,
 *   editor: HTMLElement, seams: HTMLElement[]}} parts
 * @param {{onSave: function, onAdd: function, onSuggest: function, onFiles: function(File[]), onCopy: function,
 *   onRobot: function}} on
 */
export function buildLayout(root, data, savesTo, parts, on) {
  const view = el("section", { id: "view", "aria-label": "3-D view" });
  const state = el("p", { id: "state", role: "status" });
  const gauges = el("div", { class: "gauges" });
  const addButton = button("add", "Add point", on.onAdd);
  const suggestButton = button("suggest", "Suggest points", on.onSuggest);
  const file = fileInput(on.onFiles);
  const saveButton = el("button", { type: "button", id: "save", class: "main", onclick: () => on.onSave() });
  const showName = (name) => saveButton.replaceChildren(`Save ${name}`);
  showName(savesTo);
  const robotButton = data.robot ? button("robot", "Read the robot (F2)", on.onRobot) : null;
  robotButton?.setAttribute("title", `${data.robot}: only read, never written to`);
  const buttons = el(
    "div",
    { class: "buttons" },
    robotButton,
    saveButton,
    addButton,
    suggestButton,
    button("open", "Open file …", () => file.click()),
    button("copy", "Copy", on.onCopy),
    file,
  );
  const list = el("ul", {});
  const exchangeButtons = el("div", { class: "buttons" });
  const notes = el("section", { id: "notes" }, list, exchangeButtons);
  root.append(
    view,
    el(
      "div",
      { id: "side" },
      el("header", {}, el("h1", {}, data.file), state, gauges),
      notes,
      el("section", { id: "points" }, parts.table, buttons, parts.frameForm, parts.status, parts.saveForm),
      el("section", { id: "seams" }, parts.seams, parts.editor),
    ),
  );
  const exchangeButton = ({ row, feature }) =>
    el("button", { type: "button", class: "exchange", onclick: () => on.onExchange(row, feature) }, `Take ${feature}`);
  const showPromise = (element) => parts.table.after(element);
  const showNotes = (texts, exchanges) => {
    exchangeButtons.replaceChildren(...exchanges.map(exchangeButton));
    list.replaceChildren(...texts.map((text) => el("li", {}, text)));
    notes.hidden = !texts.length;
  };
  return { view, state, gauges, addButton, suggestButton, robotButton, showNotes, showName, showPromise };
}

function button(id, text, onclick) {
  return el("button", { type: "button", id, onclick: () => onclick() }, text);
}

function fileInput(onFiles) {
  const input = el("input", { type: "file", id: "file", multiple: true, hidden: true });
  input.addEventListener("change", () => {
    onFiles([...input.files]);
    input.value = ""; // so that the same file can be opened again
  });
  return input;
}
