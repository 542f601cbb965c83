// The table of taught points as a person edits it: inputs for the cells, and what the fit says of each row.
import { el, fixed } from "../dom.js";
import { bar } from "../shares.js";
import { isHalfANumber, pointed, positionsIn } from "./numbers.js";
import { PLACE } from "./rows.js";

const HEADINGS = { x_mm: "x mm", y_mm: "y mm", z_mm: "z mm" };
const CHOICES = {
  use: ["yes", "check", "no"],
  kind: ["point", "plane", "edge", "hole", "cylinder", "sphere", "surface"],
};
const HEADER = /(^|[,;\t"])\s*x_mm\s*([,;\t"]|$)/im; // of a table of taught points
const IN_USER_FRAME = /\bUF\s*:\s*[1-9]|\bBASE_NO\s+[1-9]/i; // of FANUC and KUKA
const FEATURES_LISTED = 2000; // a longer list is slow to open; any name can be typed

/**
 * @param {Rows} rows
 * @param {object[]} features  of the part
 * @param {{onChange: function, onSelect: function(row), onTable: function(text),
 *   onUndoable: function(text, before, kind), onEmpty: function}} callbacks
 */
export class Table {
  constructor(rows, features, callbacks) {
    Object.assign(this, { rows, callbacks, byName: new Map(features.map((f) => [f.name.toLowerCase(), f])) });
    this.selected = null;
    this.lines = new Map(); // of the elements of each row
    this.element = el("div", { class: "table-scroll" });
    const names = features.slice(0, FEATURES_LISTED).map(({ name }) => el("option", { value: name }));
    this.list = el("datalist", { id: "feature-names" }, names);
    this.draw();
  }

  /** The columns in the order in which they are worked through. */
  columns() {
    const first = ["name", "feature", ...PLACE].filter((name) => this.rows.columns.includes(name));
    const others = this.rows.columns.filter((name) => !first.includes(name) && name !== "use");
    return [...first, ...others, ...this.rows.columns.filter((name) => name === "use")];
  }

  /** Draws what changed: a cell under the typing hand stays the very element that it is, with its caret and its undo. */
  draw() {
    const columns = this.columns();
    if (columns.join() !== this.drawnColumns) this.drawAnew(columns);
    const rows = new Set(this.rows.rows);
    for (const [row, { line }] of this.lines) {
      if (rows.has(row)) continue;
      line.remove();
      this.lines.delete(row);
    }
    const fresh = this.rows.rows.filter((row) => !this.lines.has(row));
    this.body.append(...fresh.map((row) => this.line(row, columns)));
    for (const [row, drawn] of this.lines) this.fill(row, drawn);
    this.mark();
  }

  drawAnew(columns) {
    const heading = (name) => el("th", { scope: "col" }, HEADINGS[name] ?? name.replaceAll("_", " "));
    const end = [el("th", { scope: "col" }, "off by mm"), el("th", {}, el("span", { class: "unseen" }, "take away"))];
    this.drawnColumns = columns.join();
    this.lines.clear();
    this.body = el("tbody", {});
    this.element.replaceChildren(
      this.list,
      el("table", {}, el("thead", {}, el("tr", {}, columns.map(heading), end)), this.body),
    );
  }

  /** Brings the cells of a row up to date. */
  fill(row, { line, inputs, remove }) {
    line.dataset.name = row.name;
    remove.setAttribute("aria-label", `take ${row.name || "this row"} away`);
    for (const [name, input] of Object.entries(inputs)) {
      if (this.rows.typing?.row === row && this.rows.typing.name === name) continue;
      if (input.value !== row[name]) input.value = row[name];
    }
  }

  /** Runs what may build the table anew; the caret comes back to the cell of the same row and column. */
  keepingFocus(change) {
    const at = this.rows.rows.findIndex((row) => this.lines.get(row)?.line.contains(document.activeElement));
    const cells = Object.entries(this.lines.get(this.rows.rows[at])?.inputs ?? {});
    const name = cells.find(([, one]) => one === document.activeElement)?.[0];
    const { selectionStart: start, selectionEnd: end } = document.activeElement;
    change();
    const input = this.lines.get(this.rows.rows[at])?.inputs[name || "name"];
    if (!input || input === document.activeElement) return;
    input.focus();
    if (start !== undefined) input.setSelectionRange?.(start, end);
  }

  line(row, columns) {
    const inputs = Object.fromEntries(columns.map((name) => [name, this.input(row, name)]));
    const distance = el("output", { class: "distance" });
    const share = el("span", { class: "share" });
    const remove = el("button", { type: "button", class: "remove", title: "take this row away" }, "×");
    const line = el(
      "tr",
      {},
      columns.map((name) => el("td", { class: `cell-${name}` }, inputs[name])),
      el("td", { class: "number" }, distance, share),
      el("td", {}, remove),
    );
    remove.addEventListener("click", () => this.remove(row));
    line.addEventListener("focusin", () => this.select(row));
    this.lines.set(row, { line, inputs, distance, share, remove });
    return line;
  }

  input(row, name) {
    if (CHOICES[name]) {
      const known = CHOICES[name].includes(row[name]) ? CHOICES[name] : [row[name], ...CHOICES[name]];
      const options = known.map((word) => el("option", { value: word, selected: word === row[name] }, word));
      const select = el("select", { "aria-label": name }, options);
      select.addEventListener("change", () => this.change(row, name, select.value));
      return select;
    }
    const isPlace = PLACE.includes(name);
    const input = el("input", {
      type: "text",
      value: row[name],
      "aria-label": name,
      placeholder: isPlace ? name[0] : null, // shown where there is no heading; no inputmode: the number pad of some tablets has no minus
      autocomplete: "off",
      spellcheck: "false",
      list: name === "feature" ? "feature-names" : null,
    });
    input.addEventListener("input", () => {
      this.rows.typing = { row, name };
      this.change(row, name, isPlace ? pointed(input.value) : input.value.trim());
    });
    input.addEventListener("blur", () => this.ended(row, name));
    input.addEventListener("change", () => this.settle(row, name));
    input.addEventListener("keydown", (event) => event.key === "Enter" && this.goOn(row, name));
    input.addEventListener("paste", (event) =>
      this.pasteInto(event, row, isPlace || name === "name" || name === "feature"),
    );
    return input;
  }

  change(row, name, text) {
    row[name] = text;
    this.fill(row, this.lines.get(row));
    this.callbacks.onChange();
  }

  /** A cell is done: it shows what is meant, and a row that the page named is called like its feature. */
  settle(row, name) {
    const drawn = this.lines.get(row);
    if (!drawn) return; // taken away meanwhile
    const feature = name === "feature" && this.byName.get(row.feature.toLowerCase());
    const before = row.name;
    if (feature) this.rows.take(row, feature);
    drawn.inputs[name].value = row[name];
    if (row.name !== before) this.change(row, name, row[name]);
  }

  /** The hand left a cell: what is no number now is a fault. */
  ended(row, name) {
    const isHalf = this.rows.typing?.row === row && PLACE.includes(name) && isHalfANumber(row[name]);
    this.rows.typing = null;
    if (isHalf) this.callbacks.onChange();
  }

  remove(row) {
    const before = this.rows.toRecord();
    const at = this.rows.rows.indexOf(row);
    this.rows.remove(row);
    if (this.selected === row) this.select(null);
    this.draw();
    const next = this.lines.get(this.rows.rows[at] ?? this.rows.rows[at - 1]);
    if (next) next.remove.focus();
    else this.callbacks.onEmpty();
    this.callbacks.onChange();
    this.callbacks.onUndoable(`${row.name || "A row"} is taken away.`, before);
  }

  /** Back to what the table was, as `toRecord` gave it. */
  restore(record) {
    this.keepingFocus(() => {
      this.rows.restore(record);
      this.select(null);
      this.draw();
    });
    this.callbacks.onChange();
  }

  /** From one coordinate to the next, and from the last to the first of the row below. */
  goOn(row, name) {
    const next = PLACE[PLACE.indexOf(name) + 1];
    const below = this.rows.rows[this.rows.rows.indexOf(row) + 1];
    if (PLACE.includes(name) && next) this.focus(row, next);
    else if (PLACE.includes(name) && below) this.focus(below);
    else if (!PLACE.includes(name)) this.focus(row);
  }

  focus(row, name = "x_mm") {
    const input = this.lines.get(row)?.inputs[name];
    input?.focus();
    input?.select?.();
  }

  /** Positions go into the row and those below, a table with a header goes in as a file; all else is text of the cell. */
  pasteInto(event, row, takesPositions) {
    const text = event.clipboardData.getData("text");
    const { rows } = this.rows;
    if (!HEADER.test(text) && !takesPositions) return;
    if (this.paste(text, rows.slice(rows.indexOf(row)))) event.preventDefault();
  }

  /**
   * Takes a pasted text, if it holds a table or positions.
   *
   * @param {object[]} [open]  the rows that positions without a name go into; those that wait
   */
  paste(text, open = this.rows.rows.filter((row) => this.rows.isWaiting(row))) {
    if (HEADER.test(text)) {
      this.callbacks.onTable(text);
      return true;
    }
    const positions = positionsIn(text);
    if (!positions.length) return false;
    const [before, count] = [this.rows.toRecord(), this.rows.rows.length];
    this.rows.typing = null;
    const last = this.rows.place(positions, open, this.byName);
    this.draw();
    this.focus(this.rows.rows.find((row) => this.rows.isWaiting(row)) ?? last);
    this.callbacks.onChange();
    const more = this.rows.rows.length - count;
    const pasted = positions.length === 1 ? "1 position" : `${positions.length} positions`;
    const what = `${pasted} pasted${more ? `, ${more} as new rows` : ""}.`;
    if (!IN_USER_FRAME.test(text)) this.callbacks.onUndoable(what, before);
    else
      this.callbacks.onUndoable(
        `${what} They stand in a user frame: open the file instead, which asks for it.`,
        before,
        "wrong",
      );
    return true;
  }

  /** A click on a feature of the part: to its row, into the row that has none yet, or into a new row. */
  pick(feature) {
    let row = this.rows.of(feature);
    if (!row) {
      const isOpen = this.selected && this.rows.isNameless(this.selected);
      row = isOpen ? this.rows.take(this.selected, feature) : this.rows.addFeature(feature);
      this.draw();
      this.callbacks.onChange();
    }
    this.focus(row);
  }

  /** A new row for a point whose feature wpcal finds, or that is clicked afterwards. */
  addNameless() {
    const row = this.rows.addFeature();
    this.draw();
    this.callbacks.onChange();
    this.focus(row);
  }

  /** New rows for features that have none yet; the caret comes into the first that waits. */
  addFeatures(names, text) {
    const before = this.rows.toRecord();
    const features = names
      .map((name) => this.byName.get(name.toLowerCase()))
      .filter((feature) => !this.rows.of(feature));
    features.forEach((feature) => this.rows.addFeature(feature));
    this.draw();
    this.focus(this.rows.rows.find((row) => this.rows.isWaiting(row)));
    this.callbacks.onChange();
    this.callbacks.onUndoable(text, before);
  }

  /** Takes the rows of a table that was read; returns how many were added, filled and replaced. */
  merge(table) {
    let count = null;
    this.keepingFocus(() => {
      this.rows.typing = null;
      count = this.rows.merge(table);
      this.draw();
    });
    this.callbacks.onChange();
    return count;
  }

  select(row) {
    if (this.selected === row) return;
    this.selected = row;
    this.mark();
    this.callbacks.onSelect(row);
  }

  mark() {
    for (const [row, { line }] of this.lines) line.classList.toggle("selected", row === this.selected);
  }

  /** Shows what the fit says, by the index of the row: points with `row`, or a fault {message, row}. */
  show({ points = [], features = {}, tolerance = 1, fault = null }) {
    const byRow = new Map(points.map((point) => [point.row, point]));
    this.rows.rows.forEach((row, index) => {
      const { line, inputs, distance, share } = this.lines.get(row);
      const point = byRow.get(index);
      line.classList.toggle("fault", fault?.row === index);
      for (const [name, input] of Object.entries(inputs)) {
        const isWrong = fault?.row === index && fault.message.includes(`, ${name}: `);
        input.setAttribute("aria-invalid", String(isWrong));
      }
      line.classList.toggle("bad", Boolean(point) && point.distance_mm > tolerance);
      line.classList.toggle("waiting", this.rows.isWaiting(row));
      distance.textContent = point ? fixed(point.distance_mm, 4) : "";
      share.replaceChildren(point ? bar(point.distance_mm, tolerance) : "");
      if (inputs.feature) inputs.feature.placeholder = features[index] ?? "";
    });
  }
}
