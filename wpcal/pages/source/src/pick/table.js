// Edits of the table of taught points: what typing, pasting, clicking and removing does to the rows.
import { Lines } from "./lines.js";
import { isHalfANumber, pointed } from "./numbers.js";
import { isTable, pastedText, readPasted } from "./pasted.js";
import { PLACE } from "./rows.js";

const NAMES = ["name", "feature"];

export class Table {
  /**
   * @param {Rows} rows
   * @param {object[]} features  of the part
   * @param {Object<string, string[]>} choices  the words that a column allows, by column
   * @param {{onChange: function, onSelect: function(row), onTable: function(text),
   *   onUndoable: function(text, before, kind), onEmpty: function}} callbacks
   */
  constructor(rows, features, choices, callbacks) {
    Object.assign(this, { rows, callbacks, byName: new Map(features.map((f) => [f.name.toLowerCase(), f])) });
    this.selected = null;
    this.lines = new Lines(rows, features, choices, {
      onInput: (row, name, { target }) => this.type(row, name, target.value),
      onChoice: (row, name, { target }) => this.change(row, name, target.value),
      onBlur: (row, name) => this.leave(row, name),
      onDone: (row, name, { target }) => this.settle(row, name, target),
      onEnter: (row, name) => this.goOn(row, name),
      onPaste: (row, name, event) => this.pasteInto(row, name, event),
      onRemove: (row) => this.remove(row),
      onSelect: (row) => this.select(row),
    });
  }

  get element() {
    return this.lines.element;
  }

  draw() {
    this.lines.draw();
    this.lines.mark(this.selected);
  }

  show(result) {
    this.lines.show(result);
  }

  type(row, name, text) {
    this.rows.typing = { row, name };
    this.change(row, name, PLACE.includes(name) ? pointed(text) : text.trim());
  }

  change(row, name, text) {
    row[name] = text;
    this.lines.fill(row);
    this.callbacks.onChange();
  }

  /** A cell is complete: it shows the text as understood. A row with an automatic name takes its feature's name. */
  settle(row, name, input) {
    if (!this.rows.rows.includes(row)) return; // the row was removed meanwhile
    const feature = name === "feature" && this.byName.get(row.feature.toLowerCase());
    const before = row.name;
    if (feature) this.rows.take(row, feature);
    input.value = row[name];
    if (row.name !== before) this.change(row, name, row[name]);
  }

  /** The caret left a cell: an unfinished number is now a fault. */
  leave(row, name) {
    const isHalf = this.rows.isTyped(row, name) && PLACE.includes(name) && isHalfANumber(row[name]);
    this.rows.typing = null;
    if (isHalf) this.callbacks.onChange();
  }

  remove(row) {
    const before = this.rows.toRecord();
    const at = this.rows.rows.indexOf(row);
    this.rows.remove(row);
    if (this.selected === row) this.select(null);
    this.draw();
    const next = this.rows.rows[at] ?? this.rows.rows[at - 1];
    if (next) this.lines.focusRemove(next);
    else this.callbacks.onEmpty();
    this.callbacks.onChange();
    this.callbacks.onUndoable(`${row.name || "A row"} removed.`, before);
  }

  /** Brings the table back to a record of `Rows.toRecord`. */
  restore(record) {
    this.lines.keepingFocus(() => {
      this.rows.restore(record);
      this.select(null);
      this.draw();
    });
    this.callbacks.onChange();
  }

  /** Takes a table of the server, while a person may be typing. */
  adopt(record) {
    this.lines.keepingFocus(() => {
      this.rows.restore(record);
      if (!this.rows.rows.includes(this.selected)) this.select(null);
      this.draw();
    });
    this.callbacks.onChange();
  }

  /** From one coordinate to the next, and from the last one to the first of the row below. */
  goOn(row, name) {
    const next = PLACE[PLACE.indexOf(name) + 1];
    const below = this.rows.rows[this.rows.rows.indexOf(row) + 1];
    if (PLACE.includes(name) && next) this.lines.focus(row, next);
    else if (PLACE.includes(name) && below) this.lines.focus(below);
    else if (!PLACE.includes(name)) this.lines.focus(row);
  }

  /** Positions fill this row and the rows below; a table is read like a file. Any other text goes into the cell. */
  pasteInto(row, name, event) {
    const text = event.clipboardData.getData("text");
    const { rows } = this.rows;
    if (!isTable(text) && !PLACE.includes(name) && !NAMES.includes(name)) return;
    if (this.paste(text, rows.slice(rows.indexOf(row)))) event.preventDefault();
  }

  /**
   * Takes a pasted text, if it holds a table or positions.
   *
   * @param {object[]} [open]  the rows for positions without a name; by default those without coordinates
   * @returns {boolean} whether it does
   */
  paste(text, open = this.rows.rows.filter((row) => this.rows.isWaiting(row))) {
    if (isTable(text)) {
      this.callbacks.onTable(text);
      return true;
    }
    const pasted = readPasted(text);
    if (!pasted.positions.length) return false;
    const [before, count] = [this.rows.toRecord(), this.rows.rows.length];
    this.rows.typing = null;
    const last = this.rows.place(pasted.positions, open, this.byName);
    this.draw();
    this.lines.focus(this.rows.rows.find((row) => this.rows.isWaiting(row)) ?? last);
    this.callbacks.onChange();
    const said = pastedText(pasted, this.rows.rows.length - count);
    this.callbacks.onUndoable(said, before, pasted.isInUserFrame ? "wrong" : "");
    return true;
  }

  /** The row that the robot's position is for: the selected one, else the next without coordinates, else a new one. */
  rowForRobot() {
    const isThere = this.selected && this.rows.rows.includes(this.selected);
    const row = isThere ? this.selected : this.rows.rows.find((one) => this.rows.isWaiting(one));
    if (!row) this.addNameless();
    return row ?? this.rows.rows.at(-1);
  }

  /** The position of the robot in a row; the caret goes on to the next row without coordinates. Can be undone. */
  takeRobot(row, { xyz_mm: xyz, note, reading }) {
    const { rows } = this.rows;
    if (!rows.includes(row)) return null; // it was removed meanwhile
    const before = this.rows.toRecord();
    this.rows.typing = null;
    this.rows.addColumns(["reading"]);
    PLACE.forEach((name, axis) => (row[name] = xyz[axis].toFixed(3)));
    row.reading = reading;
    this.draw();
    const at = rows.indexOf(row);
    const next = [...rows.slice(at), ...rows.slice(0, at)].find((one) => this.rows.isWaiting(one)) ?? null;
    if (next) this.lines.focus(next);
    else document.activeElement?.blur();
    this.select(next);
    this.callbacks.onChange();
    this.callbacks.onUndoable(`${row.name}: ${PLACE.map((name) => row[name]).join("  ")} (${note})`, before);
    return next;
  }

  /** A click on a feature of the part: goes to its row, to the selected row if that has no feature, or to a new row. */
  pick(feature) {
    let row = this.rows.of(feature);
    if (!row) {
      const isOpen = this.selected && this.rows.isNameless(this.selected);
      row = isOpen ? this.rows.take(this.selected, feature) : this.rows.addFeature(feature);
      this.draw();
      this.callbacks.onChange();
    }
    this.lines.focus(row);
  }

  /** A new row for a touch on a face or an edge; can be undone. */
  addTouch(touch) {
    const before = this.rows.toRecord();
    const row = this.rows.addTouch(touch);
    this.draw();
    this.lines.focus(row);
    this.callbacks.onChange();
    this.callbacks.onUndoable(`${row.name}: a touch on this ${touch.kind}`, before);
  }

  /** The row at an index was touched on another feature; can be undone. */
  exchange(index, name) {
    const row = this.rows.rows[index];
    const feature = this.byName.get(name.toLowerCase());
    if (!row || !feature) return;
    const before = this.rows.toRecord();
    this.rows.take(row, feature);
    this.draw();
    this.callbacks.onChange();
    this.callbacks.onUndoable(`${row.name} was touched at ${feature.name}`, before);
  }

  /** A new row for a point whose feature wpcal finds, or that is clicked afterwards. */
  addNameless() {
    const row = this.rows.addFeature();
    this.draw();
    this.callbacks.onChange();
    this.lines.focus(row);
  }

  /** New rows for features that have none yet; the caret goes to the first row without coordinates. */
  addFeatures(names, text) {
    const before = this.rows.toRecord();
    const features = names.map((name) => this.byName.get(name.toLowerCase()));
    features.filter((feature) => !this.rows.of(feature)).forEach((feature) => this.rows.addFeature(feature));
    this.draw();
    this.lines.focus(this.rows.rows.find((row) => this.rows.isWaiting(row)));
    this.callbacks.onChange();
    this.callbacks.onUndoable(text, before);
  }

  /** Takes the rows of a table that was read; returns how many were added, filled in and replaced. */
  merge(table) {
    let count = null;
    this.lines.keepingFocus(() => {
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
    this.lines.mark(row);
    this.callbacks.onSelect(row);
  }
}
