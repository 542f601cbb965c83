// The line below the table: what was done last, with a button that undoes a change of the table.
import { el } from "../dom.js";

export class Status {
  /** @param {function(object)} restore  brings the table back to a record of `Rows.toRecord` */
  constructor(restore) {
    this.element = el("p", { id: "save-state", role: "status" });
    this.restore = restore;
    this.undo = null; // a function while there is something to undo
  }

  /** Shows a text in place of the one before; `kind` is "" or "wrong". */
  say(text, kind = "", ...more) {
    this.undo = null;
    this.element.className = kind;
    this.element.replaceChildren(text, ...more);
  }

  /** Shows what happened to the table. It can be undone until the next message. */
  offerUndo(text, before, kind = "") {
    this.undo = this.offer(text, before, kind, "Undo", "undone");
  }

  /** Shows a text with a button that puts another table in place of the present one; returns what the button does. */
  offer(text, other, kind, label, done) {
    const act = () => {
      this.restore(other);
      this.say(done);
    };
    this.say(text, kind, " ", el("button", { type: "button", onclick: act }, label));
    return act;
  }
}
