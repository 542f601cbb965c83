// The table of welds and values: one cell is chosen, arrow keys go from cell to cell.
import { el, fixed } from "../dom.js";
import { shown } from "./values.js";

const STEPS = { ArrowLeft: [0, -1], ArrowRight: [0, 1], ArrowUp: [-1, 0], ArrowDown: [1, 0] };

export class WeldGrid {
  /**
   * @param {{data: object, statements: object}} page
   * @param {{onChoose: function(row, isOther), onEdit: function(string), onBack: function(), onTick: function(number[],
   *   boolean)}} on  `onEdit` gets the character that was typed, or an empty text
   */
  constructor({ data, statements }, on) {
    Object.assign(this, { data, statements, on, group: "all", row: 0, column: 0 });
    const names = ["all", ...new Set(data.fields.map(({ group }) => group))];
    const choose = (name) => () => {
      this.group = name;
      this.column = 0;
      this.fill();
    };
    this.groups = names.map((name) =>
      el("button", { type: "button", "data-group": name, onclick: choose(name) }, name),
    );
    this.body = el("div", {
      class: "table-scroll",
      onclick: (event) => this.click(event),
      onkeydown: (event) => this.key(event),
    });
    const hint = "Arrow keys choose a value. Type or press Enter to change it, Delete gives it back to the rules.";
    this.element = el(
      "section",
      { id: "welds" },
      el("div", { class: "kinds", role: "group", "aria-label": "which values" }, this.groups),
      this.body,
      el("p", { class: "hint" }, hint),
    );
  }

  get fields() {
    return this.data.fields.filter(({ group }) => ["all", group].includes(this.group));
  }

  get field() {
    return this.fields[this.column];
  }

  fill(ticked = this.ticked) {
    this.ticked = ticked;
    for (const button of this.groups) button.setAttribute("aria-pressed", String(button.dataset.group === this.group));
    const { welds } = this.data;
    const rows = welds.map((_, row) => row);
    const title = ({ label, unit }) => [label, unit && el("small", {}, ` ${unit}`)];
    const head = el(
      "tr",
      {},
      el("th", { class: "fixed" }, this.tickBox("all seams", rows), " seam"),
      this.fields.map((field) => el("th", { scope: "col", title: field.what }, title(field))),
    );
    const lines = rows.map((row) => this.line(row));
    const hadFocus = this.body.contains(document.activeElement);
    const { scrollLeft } = this.body;
    this.body.replaceChildren(el("table", { role: "grid" }, el("thead", {}, head), el("tbody", {}, lines)));
    this.body.scrollLeft = scrollLeft;
    if (hadFocus) this.cell()?.focus({ preventScroll: true });
  }

  line(row) {
    const weld = this.data.welds[row];
    const name = el("th", { scope: "row", class: "fixed", title: `${weld.joint}, ${fixed(weld.length_mm, 1)} mm` }, [
      this.tickBox(weld.name, [row]),
      el("span", {}, ` ${weld.name}`),
    ]);
    const cells = this.fields.map((field, column) => {
      const { value, from, of, isStale } = this.statements.value(row, field.name);
      const isChosen = row === this.row && column === this.column;
      const kinds = [`from-${from || "nothing"}`, isStale && "stale", field.is_record || "number"];
      return el(
        "td",
        {
          class: kinds.filter((kind) => typeof kind === "string").join(" "),
          role: "gridcell",
          tabindex: isChosen ? 0 : -1,
          "aria-selected": String(isChosen),
          "data-cell": `${weld.name} ${field.name}`,
          title: originText({ from, of, isStale }),
        },
        shown(field, value),
      );
    });
    return el("tr", { "data-name": weld.name, class: row === this.row ? "chosen" : null }, name, cells);
  }

  tickBox(what, rows) {
    const checked = rows.length > 0 && rows.every((row) => this.ticked.has(row));
    const onchange = ({ target }) => this.on.onTick(rows, target.checked);
    return el("input", { type: "checkbox", class: "tick", "aria-label": `tick ${what}`, checked, onchange });
  }

  cell() {
    return this.body.querySelector('[aria-selected="true"]');
  }

  click({ target }) {
    const cell = target.closest("td, th[scope=row]");
    if (!cell || target.matches("input")) return;
    const row = [...cell.closest("tbody").children].indexOf(cell.closest("tr"));
    this.choose(row, cell.matches("td") ? cell.cellIndex - 1 : this.column);
  }

  choose(row, column = this.column) {
    const isIn = row >= 0 && row < this.data.welds.length && column >= 0 && column < this.fields.length;
    if (!isIn) return;
    const isOther = row !== this.row;
    this.mark(false);
    Object.assign(this, { row, column });
    this.mark(true);
    this.on.onChoose(row, isOther);
    this.cell().focus();
  }

  /** Shows which cell is chosen, without a new table: it can be long. */
  mark(isChosen) {
    const line = this.body.querySelector("tbody").rows[this.row];
    const cell = line.cells[this.column + 1];
    line.classList.toggle("chosen", isChosen);
    cell.setAttribute("aria-selected", String(isChosen));
    cell.tabIndex = isChosen ? 0 : -1;
  }

  key(event) {
    const { key, ctrlKey, metaKey, altKey, target } = event;
    if (!target.matches("td") || altKey || ctrlKey || metaKey) return;
    const { row, column } = this;
    if (key in STEPS) this.choose(row + STEPS[key][0], column + STEPS[key][1]);
    else if (key === "Home") this.choose(row, 0);
    else if (key === "End") this.choose(row, this.fields.length - 1);
    else if (key === "Delete" || key === "Backspace") this.on.onBack();
    else if (key === " ") this.on.onTick([row], !this.ticked.has(row));
    else if (key === "Enter" || key === "F2") this.on.onEdit("");
    else if (key.length === 1) this.on.onEdit(key);
    else return;
    event.preventDefault();
  }
}

/** Where a value comes from, in words. */
export function originText({ from, of, isStale }) {
  if (!from) return isStale ? "wpcal computes it anew" : "nothing states it";
  const words = { rule: `rule: ${of}`, file: `file: ${of}`, model: `measured in ${of}`, user: "you" }[from];
  return isStale ? `${words}; wpcal computes it anew` : words;
}
