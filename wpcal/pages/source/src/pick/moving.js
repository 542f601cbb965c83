// Whether bodies may have moved: the switch with its tack tolerance, and what the touches then say of every body.
import { bodiesTable, bodiesWords, seamsOfBodiesTable } from "../bodies.js";
import { el } from "../dom.js";
import { checkBox } from "../stage.js";
import { latestOnly, post } from "./link.js";

const PAUSE_MS = 400; // after a key in the tolerance, before it is sent
const HINT = "Standard deviation of how far tacks let a body move and turn. Empty: estimated where touches suffice.";

export class Moving {
  /**
   * @param {{is_on: boolean, tack_mm: number|null, tack_mrad: number|null, keeps_contacts: boolean,
   *   contact_mm: number|null}} choice  at the start
   * @param {{onChange: function(), onFault: function(string), onBody: function(object), onSeam: function(string)}} on
   */
  constructor(choice, on) {
    Object.assign(this, { choice, on });
    this.box = checkBox("bodies may have moved", () => this.sending.ask(), { checked: choice.is_on });
    this.input = this.box.querySelector("input");
    this.input.setAttribute("data-test", "bodies");
    this.fields = { tack_mm: this.field("mm", "tack_mm", 1), tack_mrad: this.field("mrad", "tack_mrad", 3) };
    this.contacts = checkBox("plates stay on each other", () => this.sending.ask(), {});
    this.contacts.querySelector("input").setAttribute("data-test", "contacts");
    const tolerance = [el("span", {}, "tack tolerance"), ...Object.values(this.fields), this.contacts];
    this.tolerance = el("span", { class: "tolerance", title: HINT }, tolerance);
    this.told = el("div", { class: "bodies" });
    this.element = el("div", { id: "moving" }, el("div", { class: "moving" }, this.box, this.tolerance), this.told);
    this.sending = latestOnly(() => this.send(), PAUSE_MS);
    this.take(choice);
  }

  field(unit, name, usual) {
    const input = el("input", { name, inputmode: "decimal", placeholder: String(usual), "aria-label": `${name}` });
    input.addEventListener("input", () => this.sending.ask());
    return el("label", {}, input, el("span", {}, unit));
  }

  get isIdle() {
    return this.sending.isIdle;
  }

  /** What the page states now. */
  get stated() {
    const text = (name) => this.fields[name].querySelector("input").value.trim() || null;
    const { checked } = this.contacts.querySelector("input");
    const { contact_mm, bending_mm } = this.choice; // of the command
    const [tack_mm, tack_mrad] = ["tack_mm", "tack_mrad"].map(text);
    return { is_on: this.input.checked, tack_mm, tack_mrad, keeps_contacts: checked, contact_mm, bending_mm };
  }

  /** Shows a choice: the server's at the start, or that of another window. */
  take(choice) {
    this.choice = choice;
    this.input.checked = choice.is_on;
    this.contacts.querySelector("input").checked = choice.keeps_contacts;
    for (const [name, field] of Object.entries(this.fields)) {
      const input = field.querySelector("input");
      if (document.activeElement !== input) input.value = choice[name] ?? "";
    }
    this.tolerance.hidden = !choice.is_on;
  }

  async send() {
    const { answer, fault } = await post("moving", this.stated);
    if (fault) {
      this.on.onFault(fault.message);
      if (!this.stated.is_on || !this.choice.is_on) this.input.checked = this.choice.is_on;
      return;
    }
    this.take(answer.moving);
    if (answer.warning) this.on.onFault(answer.warning);
    this.on.onChange();
  }

  /** Shows the answer of a fit; without bodies nothing. */
  show(answer) {
    if (answer?.moving && this.isIdle) this.take(answer.moving); // another window may have changed it
    const bodies = answer?.bodies;
    if (!bodies) return this.told.replaceChildren();
    const [sentence, tolerances] = bodiesWords(bodies);
    return this.told.replaceChildren(
      el("p", { class: "sentence" }, sentence),
      el("p", { class: "caption" }, tolerances),
      bodiesTable(bodies, (body) => this.on.onBody(body)),
      ...(bodies.seams.length ? [seamsOfBodiesTable(bodies, (name) => this.on.onSeam(name))] : []),
    );
  }
}
