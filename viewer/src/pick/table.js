// The table of taught points as a person edits it: inputs for the cells, and what the fit says of each row.
import { el, fixed } from "../dom.js";
import { bar } from "../shares.js";
import { linesWithCoordinates, pointed } from "./numbers.js";
import { PLACE } from "./rows.js";

const HEADINGS = { x_mm: "x mm", y_mm: "y mm", z_mm: "z mm" };
const CHOICES = { use: ["yes", "check", "no"], kind: ["point", "plane", "edge", "hole", "cylinder", "sphere", "surface"] };
const FEATURES_LISTED = 2000; // a longer list is slow to open; any name can be typed

/**
 * @param {Rows} rows
 * @param {object[]} features  of the part
 * @param {{onChange: function, onSelect: function(row), onTable: function(text)}} callbacks
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

  draw() {
    const columns = this.columns();
    const heading = (name) => el("th", { scope: "col" }, HEADINGS[name] ?? name.replaceAll("_", " "));
    const head = el("tr", {}, columns.map(heading), el("th", { scope: "col" }, "off by mm"), el("th", {}));
    this.lines.clear();
    const body = this.rows.rows.map((row) => this.line(row, columns));
    this.element.replaceChildren(this.list, el("table", {}, el("thead", {}, head), el("tbody", {}, body)));
    this.mark();
  }

  line(row, columns) {
    const inputs = Object.fromEntries(columns.map((name) => [name, this.input(row, name)]));
    const distance = el("output", { class: "distance" });
    const share = el("span", { class: "share" });
    const remove = el("button", { type: "button", class: "remove", title: "take this row away" }, "×");
    const line = el(
      "tr",
      { "data-name": row.name },
      columns.map((name) => el("td", { class: `cell-${name}` }, inputs[name])),
      el("td", { class: "number" }, distance, share),
      el("td", {}, remove),
    );
    remove.setAttribute("aria-label", `take ${row.name} away`);
    remove.addEventListener("click", () => this.remove(row));
    line.addEventListener("focusin", () => this.select(row));
    this.lines.set(row, { line, inputs, distance, share });
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
      inputmode: isPlace ? "decimal" : null,
      autocomplete: "off",
      spellcheck: "false",
      list: name === "feature" ? "feature-names" : null,
    });
    input.addEventListener("input", () => this.change(row, name, isPlace ? pointed(input.value) : input.value.trim()));
    input.addEventListener("change", () => (input.value = row[name]));
    input.addEventListener("keydown", (event) => event.key === "Enter" && this.goOn(row, name));
    input.addEventListener("paste", (event) => this.paste(event, row, isPlace));
    return input;
  }

  change(row, name, text) {
    row[name] = text;
    this.callbacks.onChange();
  }

  remove(row) {
    this.rows.remove(row);
    if (this.selected === row) this.select(null);
    this.draw();
    this.callbacks.onChange();
  }

  /** From one coordinate to the next, and from the last to the first of the row below. */
  goOn(row, name) {
    const next = PLACE[PLACE.indexOf(name) + 1];
    const below = this.rows.rows[this.rows.rows.indexOf(row) + 1];
    if (PLACE.includes(name) && next) this.focus(row, next);
    else if (below) this.focus(below);
  }

  focus(row, name = "x_mm") {
    const input = this.lines.get(row)?.inputs[name];
    input?.focus();
    input?.select?.();
  }

  /** Coordinates go into their cells and the rows below, a table with a header goes in as a file. */
  paste(event, row, isPlace) {
    const text = event.clipboardData.getData("text");
    if (/(^|[,;\t"])x_mm([,;\t"]|\s|$)/im.test(text)) {
      event.preventDefault();
      this.callbacks.onTable(text);
      return;
    }
    const lines = isPlace ? linesWithCoordinates(text) : [];
    if (!lines.length) return;
    event.preventDefault();
    const start = this.rows.rows.indexOf(row);
    lines.forEach(({ name, xyz }, k) => {
      const target = this.rows.rows[start + k] ?? this.rows.addFeature(this.byName.get(name.toLowerCase()));
      PLACE.forEach((column, axis) => (target[column] = xyz[axis]));
    });
    this.draw();
    this.focus(this.rows.rows[start + lines.length] ?? this.rows.rows[start + lines.length - 1]);
    this.callbacks.onChange();
  }

  /** A click on a feature of the part: to its row, into the row that has none yet, or into a new row. */
  pick(feature) {
    let row = this.rows.of(feature);
    if (!row) {
      row = this.selected && this.rows.isNameless(this.selected) ? this.selected : this.rows.addFeature();
      if (/^T\d+$/.test(row.name)) row.name = this.rows.freeName(feature.name);
      this.rows.assign(row, feature);
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

  merge(table) {
    this.rows.merge(table);
    this.draw();
    this.callbacks.onChange();
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

  /** Shows what the fit says, by the index of the row: points with `row`, or the row of a fault. */
  show({ points = [], features = {}, tolerance = 1, fault = null }) {
    const byRow = new Map(points.map((point) => [point.row, point]));
    this.rows.rows.forEach((row, index) => {
      const { line, inputs, distance, share } = this.lines.get(row);
      const point = byRow.get(index);
      line.classList.toggle("fault", fault === index);
      line.classList.toggle("bad", Boolean(point) && point.distance_mm > tolerance);
      line.classList.toggle("waiting", this.rows.isWaiting(row));
      distance.textContent = point ? fixed(point.distance_mm, 4) : "";
      share.replaceChildren(point ? bar(point.distance_mm, tolerance) : "");
      if (inputs.feature) inputs.feature.placeholder = features[index] ?? "";
    });
  }
}
