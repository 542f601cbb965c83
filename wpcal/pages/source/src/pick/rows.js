// The table of taught points as data: cells of text by column, exactly as they are saved.
import { randomName } from "./names.js";
import { isHalfANumber } from "./numbers.js";

export const PLACE = ["x_mm", "y_mm", "z_mm"];
const MODEL = ["model_x_mm", "model_y_mm", "model_z_mm"];
const MODEL_DIGITS = 6;
const TOUCH_DIGITS = 3; // a click is on a pixel
const LONG_ZEROS = /^([+-]?\d+\.\d{2,}?)0{4,}$/; // positions of programs arrive with nine decimals
const FORMULA = /^'*[=+\-@＝＋－＠]/; // a spreadsheet would run it; the server writes and reads the mark alike
const NUMBER = /^[+-]?(\d+([.,]\d*)?|[.,]\d+)([eE][+-]?\d+)?$/;
const AUTOMATIC_NAME = /^T\d+$/; // from `addFeature`
const KEY = Symbol("key"); // of a row: by it, windows know the row as the same one; not a column

/** A text that no spreadsheet takes for a formula. */
function asText(cell) {
  return FORMULA.test(cell) && !NUMBER.test(cell) ? `'${cell}` : cell;
}

function isSameNumber(a, b) {
  return a === b || (a !== "" && b !== "" && Number(a) === Number(b));
}

/** A name in lower case, and the same name without the X that KUKA puts before the name of a position. */
function spellings(name) {
  const word = name.toLowerCase();
  return word ? [word, word.replace(/^x(?=.)/, "")] : [];
}

/** A new row without cells. */
function keyed(key = randomName()) {
  return { [KEY]: key };
}

/** Copies cells into the empty cells of a row, and over the cells of the `replaced` columns. */
function fillIn(row, cells, replaced) {
  for (const [name, cell] of Object.entries(cells)) {
    if (row[name] === "" || (replaced.includes(name) && cell)) row[name] = cell;
  }
}

export class Rows {
  constructor({ columns, rows, keys }) {
    this.typing = null; // {row, name} of the cell that is being typed in
    this.rows = [];
    this.restore({ columns, rows, keys });
  }

  /** Brings the table to a record of `toRecord`. Rows that are in both stay the same objects. */
  restore({ columns, rows, keys = [] }) {
    const known = new Map(this.rows.map((row) => [row[KEY], row]));
    const cell = (name, text) => [name, PLACE.includes(name) ? text.replace(LONG_ZEROS, "$1") : text];
    this.columns = columns;
    this.rows = rows.map((cells, index) => {
      const row = known.get(keys[index]) ?? keyed(keys[index]);
      return Object.assign(row, Object.fromEntries(columns.map((name, i) => cell(name, cells[i]))));
    });
  }

  toRecord() {
    const { columns, rows } = this;
    return { columns, rows: rows.map((row) => columns.map((name) => row[name])), keys: rows.map((row) => row[KEY]) };
  }

  /** The rows to fit. A number that is still being typed counts as empty, not as a fault. */
  toFit() {
    const { columns } = this;
    return { columns, rows: this.rows.map((row) => columns.map((name) => (this.isBegun(row, name) ? "" : row[name]))) };
  }

  isTyped(row, name) {
    return this.typing?.row === row && this.typing.name === name;
  }

  isBegun(row, name) {
    return this.isTyped(row, name) && PLACE.includes(name) && isHalfANumber(row[name]);
  }

  /** The table as CSV text for the clipboard; the picker and `wpcal calibrate` read it. */
  toText() {
    const quoted = (cell) => (/[",]/.test(cell) ? `"${cell.replaceAll('"', '""')}"` : cell);
    const { columns, rows } = this.toRecord();
    return [columns, ...rows].map((cells) => `${cells.map(asText).map(quoted).join(",")}\n`).join("");
  }

  /** Adds a row; cells that are not given are empty. */
  add(cells) {
    const row = Object.assign(keyed(), Object.fromEntries(this.columns.map((name) => [name, cells[name] ?? ""])));
    if ("use" in row) row.use ||= "yes";
    this.rows.push(row);
    return row;
  }

  remove(row) {
    this.rows.splice(this.rows.indexOf(row), 1);
  }

  /** Adds a row for a feature; without one, wpcal finds the feature of the point. */
  addFeature(feature) {
    const row = this.add({ name: this.freeName(feature?.name ?? "T1") });
    if (feature) this.assign(row, feature);
    return row;
  }

  /** Adds a row for a touch on a face or an edge, at a point of the model; the columns that it needs are added. */
  addTouch({ kind, p_mm, radius }) {
    const place = MODEL.map((name, axis) => [name, String(Number(p_mm[axis].toFixed(TOUCH_DIGITS)))]);
    const cells = Object.fromEntries([["kind", kind], ...place, ...(radius ? [["radius_mm", radius]] : [])]);
    this.addColumns(Object.keys(cells));
    return this.add({ name: this.freeName("T1"), ...cells });
  }

  /** Assigns a feature to a row: by its name, or by its coordinates in a table with columns of model coordinates. */
  assign(row, feature) {
    if ("feature" in row) row.feature = feature.name;
    else MODEL.forEach((name, axis) => (row[name] = String(Number(feature.p_mm[axis].toFixed(MODEL_DIGITS)))));
  }

  /** The row of a feature, if there is one. */
  of(feature) {
    const [name, place] = [feature.name.toLowerCase(), feature.p_mm];
    const isThere = (row) =>
      MODEL.every((key, axis) => row[key] !== "" && Math.abs(Number(row[key]) - place[axis]) < 1e-3);
    return this.rows.find((row) => ("feature" in row ? row.feature.toLowerCase() === name : isThere(row)));
  }

  isWaiting(row) {
    return PLACE.some((name) => row[name] === "" || this.isBegun(row, name));
  }

  isNameless(row) {
    return "feature" in row && row.feature === "" && !(row.kind && row.kind !== "point") && !row[MODEL[0]];
  }

  /** Assigns a feature to a row; an automatic name of the row is replaced by `name`. */
  take(row, feature, name = feature?.name) {
    if (name && AUTOMATIC_NAME.test(row.name)) row.name = this.freeName(name, row);
    if (feature) this.assign(row, feature);
    return row;
  }

  named(name) {
    const found = (word) => this.rows.find((row) => [row.name, row.feature].some((own) => own?.toLowerCase() === word));
    return spellings(name).map(found).find(Boolean);
  }

  /**
   * Takes pasted positions: each goes to the row of its name, else to the next of the `open` rows, else to a new row.
   *
   * @param {{name: string, xyz: string[]}[]} positions
   * @param {object[]} open  rows, in the order in which they are filled
   * @param {Map<string, object>} features  by their names in lower case
   * @returns {object} the last row that was filled
   */
  place(positions, open, features) {
    const named = new Set(positions.map(({ name }) => this.named(name)));
    const free = open.filter((row) => !named.has(row));
    let row = null;
    for (const { name, xyz } of positions) {
      const feature = spellings(name)
        .map((word) => features.get(word))
        .find(Boolean);
      const fits = free.length && (!feature || this.isNameless(free[0]));
      row = this.named(name);
      if (!row) row = this.take(fits ? free.shift() : this.addFeature(), feature, feature?.name ?? (name || undefined));
      PLACE.forEach((column, axis) => (row[column] = xyz[axis]));
    }
    return row;
  }

  /**
   * Takes the rows of another table: new rows, and coordinates for rows of the same name. Other cells of such a row are
   * filled in only where they are empty.
   *
   * @returns {{added: number, filled: number, replaced: number}} how many rows
   */
  merge(table) {
    const [other, before] = [new Rows(table), [...this.rows]];
    this.addColumns(other.columns);
    const count = { added: 0, filled: 0, replaced: 0 };
    for (const cells of other.rows) {
      const row = before.find(({ name }) => name === cells.name);
      if (!row) {
        this.add(cells);
        count.added += 1;
        continue;
      }
      const isSame = PLACE.every((name) => cells[name] === "" || isSameNumber(cells[name], row[name]));
      if (!isSame) count[this.isWaiting(row) ? "filled" : "replaced"] += 1;
      fillIn(row, cells, isSame ? [] : PLACE);
    }
    return count;
  }

  addColumns(names) {
    const more = names.filter((name) => !this.columns.includes(name));
    for (const row of this.rows) for (const name of more) row[name] = "";
    this.columns = [...this.columns, ...more];
  }

  /** A name that no row has, other than `own`. */
  freeName(wanted, own = null) {
    const taken = new Set(this.rows.filter((row) => row !== own).map(({ name }) => name));
    let name = wanted;
    for (let count = 1; taken.has(name); count += 1) name = wanted === "T1" ? `T${count}` : `${wanted}_${count + 1}`;
    return name;
  }
}
