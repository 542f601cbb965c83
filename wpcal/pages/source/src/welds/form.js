// The form for the chosen value: what it means, its limits, where it comes from; set, none, back to the rules.
import { el } from "../dom.js";
import { plural } from "../words.js";
import { originText } from "./grid.js";
import { limitsOf, shown, valueFrom } from "./values.js";

export class ValueForm {
  /**
   * @param {{statements: object}} page
   * @param {{onSet: function(value), onSay: function(string), onLeave: function(), onUndo: function(), onRedo:
   *   function()}} on  `onSet` gets undefined for a value that goes back to the rules
   */
  constructor({ statements }, on) {
    Object.assign(this, { statements, on });
    this.element = el("div", { id: "value", role: "group", "aria-label": "the chosen value" });
  }

  /**
   * @param {object} field
   * @param {object} weld  the chosen one
   * @param {number[]} rows  for which the value is set
   */
  show(field, weld, row, rows) {
    Object.assign(this, { field, rows });
    const now = this.statements.value(row, field.name);
    const where = rows.length > 1 ? plural(rows.length, "ticked seam") : weld.name;
    const words = [
      el(
        "strong",
        {},
        `${weld.name}, ${field.label}: ${shown(field, now.value) || "–"} ${now.value == null ? "" : field.unit} `,
      ),
      el("span", { class: "origin" }, originText(now)),
      field.what && el("span", { class: "what" }, ` ${field.what}`),
    ];
    this.inputs = field.parts.map((part) => this.input(part, field.is_record ? now.value?.[part.name] : now.value));
    const labels = field.parts.map((part, k) =>
      el("label", {}, el("span", {}, field.is_record ? part.label : "new value"), this.inputs[k], part.unit),
    );
    const limits = field.is_record ? "" : limitsOf(field.parts[0]);
    const isUser = rows.some((one) => this.statements.value(one, field.name).from === "user");
    const back = `Back to the ${rows.length > 1 ? "rules" : "rule"}`;
    const form = el("form", { onsubmit: (event) => this.submit(event), onkeydown: (event) => this.key(event) }, [
      labels,
      field.parts[0].kind === "choice" && !field.is_record ? null : limits && el("span", { class: "limits" }, limits),
      el("button", { type: "submit", "data-act": "set" }, `Set in ${where}`),
      this.button("none", "None", () => this.on.onSet(null)),
      this.button("back", back, () => this.on.onSet(undefined), !isUser),
      this.button("undo", "Undo", this.on.onUndo, !this.statements.done.length),
      this.button("redo", "Redo", this.on.onRedo, !this.statements.undone.length),
    ]);
    this.element.replaceChildren(el("p", {}, words), form);
  }

  button(act, text, onclick, disabled = false) {
    return el("button", { type: "button", "data-act": act, disabled, onclick: () => onclick() }, text);
  }

  input(part, value) {
    const text = value === undefined || value === null ? "" : String(value);
    const title = limitsOf(part);
    if (part.kind === "choice") {
      const options = part.choices.map((one) => el("option", { value: one, selected: one === text }, one));
      return el("select", { name: part.name }, el("option", { value: "" }, ""), options);
    }
    const inputmode = part.kind === "text" ? null : "decimal";
    const attributes = {
      type: "text",
      name: part.name,
      value: text,
      size: 8,
      autocomplete: "off",
      spellcheck: "false",
    };
    return el("input", { ...attributes, inputmode, title, "aria-label": `${part.label}, ${title}` });
  }

  /** Puts the cursor into the form; `typed` replaces what is there. */
  edit(typed) {
    const [first] = this.inputs;
    first.focus();
    if (first.matches("select")) return;
    if (typed) first.value = typed;
    else first.select();
  }

  submit(event) {
    event.preventDefault();
    const texts = Object.fromEntries(this.inputs.map((input) => [input.name, input.value]));
    const { value, fault } = valueFrom(this.field, texts);
    if (fault) this.on.onSay(fault);
    else this.on.onSet(value);
  }

  key(event) {
    if (event.key !== "Escape") return;
    event.preventDefault();
    this.on.onLeave();
  }
}
