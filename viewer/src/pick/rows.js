// The table of taught points as data: cells of text by column, exactly as they go into the file.
export const PLACE = ["x_mm", "y_mm", "z_mm"];
const MODEL = ["model_x_mm", "model_y_mm", "model_z_mm"];
const MODEL_DIGITS = 6;

export class Rows {
  constructor({ columns, rows }) {
    this.columns = columns;
    this.rows = rows.map((cells) => Object.fromEntries(columns.map((name, i) => [name, cells[i]])));
  }

  toRecord() {
    return { columns: this.columns, rows: this.rows.map((row) => this.columns.map((name) => row[name])) };
  }

  /** The table as text for the clipboard; the picker and `wpcal calibrate` read it. */
  toText() {
    const quoted = (cell) => (/[",]/.test(cell) ? `"${cell.replaceAll('"', '""')}"` : cell);
    const { columns, rows } = this.toRecord();
    return [columns, ...rows].map((cells) => `${cells.map(quoted).join(",")}\n`).join("");
  }

  /** Adds a row; what is not given is empty. */
  add(cells) {
    const row = Object.fromEntries(this.columns.map((name) => [name, cells[name] ?? ""]));
    if ("use" in row) row.use ||= "yes";
    this.rows.push(row);
    return row;
  }

  remove(row) {
    this.rows.splice(this.rows.indexOf(row), 1);
  }

  /** Adds a row for a feature, or for a point that wpcal finds the feature of. */
  addFeature(feature) {
    const row = this.add({ name: this.freeName(feature?.name ?? "T1") });
    if (feature) this.assign(row, feature);
    return row;
  }

  /** Says that a row is a feature; in a table by model coordinates its place stands for it. */
  assign(row, feature) {
    if ("feature" in row) row.feature = feature.name;
    else MODEL.forEach((name, axis) => (row[name] = String(Number(feature.p_mm[axis].toFixed(MODEL_DIGITS)))));
  }

  /** The row of a feature, if there is one. */
  of(feature) {
    const [name, place] = [feature.name.toLowerCase(), feature.p_mm];
    const isThere = (row) => MODEL.every((key, axis) => row[key] !== "" && Math.abs(Number(row[key]) - place[axis]) < 1e-3);
    return this.rows.find((row) => ("feature" in row ? row.feature.toLowerCase() === name : isThere(row)));
  }

  isWaiting(row) {
    return PLACE.some((name) => row[name] === "");
  }

  isNameless(row) {
    return "feature" in row && row.feature === "" && !(row.kind && row.kind !== "point") && !row[MODEL[0]];
  }

  /** Takes the rows of another table: coordinates for rows of the same name that wait for them, and new rows. */
  merge(table) {
    const other = new Rows(table);
    const added = other.columns.filter((name) => !this.columns.includes(name));
    for (const row of this.rows) for (const name of added) row[name] = "";
    this.columns = [...this.columns, ...added];
    for (const cells of other.rows) {
      const waiting = this.rows.find((row) => row.name === cells.name && this.isWaiting(row));
      if (waiting) for (const [name, cell] of Object.entries(cells)) waiting[name] = cell || waiting[name];
      else this.add(cells);
    }
  }

  freeName(wanted) {
    const taken = new Set(this.rows.map(({ name }) => name));
    const stem = wanted.replace(/\d+$/, "");
    let name = wanted;
    for (let count = 1; taken.has(name); count += 1) name = stem === "T" ? `T${count}` : `${wanted}_${count + 1}`;
    return name;
  }
}
