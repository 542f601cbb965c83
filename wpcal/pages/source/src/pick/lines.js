// The rows of the table as elements of the page: cells, the result of the fit for each row, and the caret.
import { el, fixed } from "../dom.js";
import { bar } from "../shares.js";
import { cellInput, FEATURE_LIST } from "./cells.js";
import { PLACE } from "./rows.js";

const HEADINGS = { x_mm: "x mm", y_mm: "y mm", z_mm: "z mm" };
const FEATURES_LISTED = 2000; // a longer list opens slowly; any name can be typed

export class Lines {
  /**
   * @param {Rows} rows
   * @param {object[]} features  of the part
   * @param {Object<string, string[]>} choices  the words that a column allows, by column
   * @param {{onInput: function, onChoice: function, onBlur: function, onDone: function, onEnter: function,
   *   onPaste: function, onRemove: function, onSelect: function}} handlers  called with the row, and for a cell with
   *   the name of the column and the event
   */
  constructor(rows, features, choices, handlers) {
    Object.assign(this, { rows, choices, handlers });
    this.drawn = new Map(); // row -> its elements
    this.element = el("div", { class: "table-scroll" });
    const names = features.slice(0, FEATURES_LISTED).map(({ name }) => el("option", { value: name }));
    this.list = el("datalist", { id: FEATURE_LIST }, names);
    this.draw();
  }

  /** The columns in the order in which a person fills them; what a robot told is for programs. */
  columns() {
    const first = ["name", "feature", ...PLACE].filter((name) => this.rows.columns.includes(name));
    const others = this.rows.columns.filter((name) => ![...first, "use", "reading"].includes(name));
    return [...first, ...others, ...this.rows.columns.filter((name) => name === "use")];
  }

  /** Draws what changed. A cell that is being typed in stays the same element, with its caret and its undo. */
  draw() {
    const columns = this.columns();
    if (columns.join() !== this.drawnColumns) this.drawAnew(columns);
    const rows = new Set(this.rows.rows);
    for (const [row, { line }] of this.drawn) {
      if (rows.has(row)) continue;
      line.remove();
      this.drawn.delete(row);
    }
    const fresh = this.rows.rows.filter((row) => !this.drawn.has(row));
    for (const row of fresh) this.line(row, columns);
    this.rows.rows.forEach((row, index) => {
      const [{ line }, place] = [this.drawn.get(row), this.body.children[index] ?? null];
      if (line !== place) this.body.insertBefore(line, place);
    });
    for (const row of this.drawn.keys()) this.fill(row);
  }

  drawAnew(columns) {
    const heading = (name) => el("th", { scope: "col" }, HEADINGS[name] ?? name.replaceAll("_", " "));
    const end = [el("th", { scope: "col" }, "off by mm"), el("th", {}, el("span", { class: "unseen" }, "remove"))];
    this.drawnColumns = columns.join();
    this.drawn.clear();
    this.body = el("tbody", {});
    const head = el("thead", {}, el("tr", {}, columns.map(heading), end));
    this.element.replaceChildren(this.list, el("table", {}, head, this.body));
  }

  line(row, columns) {
    const inputs = Object.fromEntries(columns.map((name) => [name, this.input(row, name)]));
    const distance = el("output", { class: "distance" });
    const share = el("span", { class: "share" });
    const remove = el("button", { type: "button", class: "remove", title: "remove this row" }, "×");
    const line = el(
      "tr",
      {},
      columns.map((name) => el("td", { class: `cell-${name}` }, inputs[name])),
      el("td", { class: "number" }, distance, share),
      el("td", {}, remove),
    );
    remove.addEventListener("click", () => this.handlers.onRemove(row));
    line.addEventListener("focusin", () => this.handlers.onSelect(row));
    this.drawn.set(row, { line, inputs, distance, share, remove });
    return line;
  }

  input(row, name) {
    const words = this.choices[name];
    const input = cellInput(row, name, words);
    const on = (event, handler) => input.addEventListener(event, (happened) => handler(row, name, happened));
    const { onInput, onChoice, onBlur, onDone, onEnter, onPaste } = this.handlers;
    if (words) {
      on("change", onChoice);
      return input;
    }
    on("input", onInput);
    on("blur", onBlur);
    on("change", onDone);
    on("keydown", (...found) => found[2].key === "Enter" && onEnter(...found));
    on("paste", onPaste);
    return input;
  }

  /** Brings the cells of a row up to date, except the one that is being typed in. */
  fill(row) {
    const { line, inputs, remove } = this.drawn.get(row);
    line.dataset.name = row.name;
    remove.setAttribute("aria-label", `remove ${row.name || "this row"}`);
    for (const [name, input] of Object.entries(inputs)) {
      if (!this.rows.isTyped(row, name) && input.value !== row[name]) input.value = row[name];
    }
  }

  /** Runs a change that may draw the table anew; the caret returns to the cell of the same row and column. */
  keepingFocus(change) {
    const active = document.activeElement;
    const at = this.rows.rows.findIndex((row) => this.drawn.get(row)?.line.contains(active));
    const row = this.rows.rows[at];
    const [rowName, cells] = [row?.name, Object.entries(this.drawn.get(row)?.inputs ?? {})];
    const name = cells.find(([, input]) => input === active)?.[0];
    const { selectionStart: start, selectionEnd: end } = active;
    change();
    const { rows } = this.rows;
    const found = rows.includes(row) ? row : (rows.find((one) => one.name === rowName) ?? rows[at]);
    const input = this.drawn.get(found)?.inputs[name || "name"];
    if (!input || input === document.activeElement) return;
    input.focus();
    if (start !== undefined) input.setSelectionRange?.(start, end);
  }

  /** Puts the caret into a cell and selects its text. */
  focus(row, name = PLACE[0]) {
    const input = this.drawn.get(row)?.inputs[name];
    input?.focus();
    input?.select?.();
  }

  focusRemove(row) {
    this.drawn.get(row).remove.focus();
  }

  mark(selected) {
    for (const [row, { line }] of this.drawn) line.classList.toggle("selected", row === selected);
  }

  /**
   * Shows the result of the fit.
   *
   * @param {{points: object[], features: object, tolerance: number, fault: object|null}} result  `points` with the
   *   index of their `row`; `features`: names that wpcal found, by index of the row
   */
  show({ points = [], features = {}, tolerance = 1, fault = null }) {
    const byRow = new Map(points.map((point) => [point.row, point]));
    this.rows.rows.forEach((row, index) => {
      const { line, inputs, distance, share } = this.drawn.get(row);
      const point = byRow.get(index);
      const isFault = fault?.row === index;
      line.classList.toggle("fault", isFault);
      for (const [name, input] of Object.entries(inputs)) {
        input.setAttribute("aria-invalid", String(isFault && fault.column === name));
      }
      line.classList.toggle("bad", Boolean(point) && point.distance_mm > tolerance);
      line.classList.toggle("waiting", this.rows.isWaiting(row));
      distance.textContent = point ? fixed(point.distance_mm, 4) : "";
      share.replaceChildren(point ? bar(point.distance_mm, tolerance) : "");
      if (inputs.feature) inputs.feature.placeholder = features[index] ?? "";
    });
  }
}
