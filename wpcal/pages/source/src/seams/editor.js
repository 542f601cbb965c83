// The editor of seams: what can be done with the seam that is chosen, with undo and redo. Its `backend` knows whether
// wpcal carries decisions out at once (the picker) or when it gets the file (the page of seams).
import { el, fixed } from "../dom.js";
import { plural } from "../words.js";
import { Refusal } from "./decisions.js";
import { meetingRows } from "./ends.js";

export class SeamEditor {
  /**
   * @param {{seams: object[], frames: object[]}} state  what is shown
   * @param {{change: function(state, operation): Promise, restore: function(state): Promise}} backend  both return the
   *   new state, or {state, warning}, or throw a Refusal
   * @param {{onState: function(state), onSelect: function(row)}} on
   * @param {number} join_mm  wpcal joins ends that are at most so far from each other
   */
  constructor(state, backend, on, join_mm) {
    Object.assign(this, {
      state,
      backend,
      on,
      join_mm,
      ticked: new Set(),
      selected: null,
      undone: [],
      done: [],
      isBusy: false,
    });
    this.bar = el("div", { class: "seam-bar" });
    this.said = el("p", { class: "seam-said", role: "status" });
    this.element = el("div", { id: "seam-editor", role: "group", "aria-label": "edit seams" }, this.bar, this.said);
    this.show();
  }

  /** Chooses a seam; `s` is where a cut is proposed, mm from its start. */
  select(row, s = null) {
    this.selected = row;
    this.s = s ?? this.state.frames[row].s.at(-1) / 2;
    this.show();
    this.on.onSelect(row);
  }

  /** Other seams than those of this editor: from another window, or carried out by wpcal. */
  take(state) {
    Object.assign(this, { state, undone: [], done: [] });
    this.adopt(state);
  }

  adopt(state, name = this.state.seams[this.selected]?.name) {
    this.state = state;
    this.keepTicks();
    const row = state.seams.findIndex((seam) => seam.name === name);
    this.selected = row < 0 ? null : row;
    if (row >= 0) this.s = state.frames[row].s.at(-1) / 2;
    this.show();
    this.on.onState(state);
  }

  /** Ticks seams, by name, or takes their ticks away: what is said next is said about all that are ticked. */
  tick(names, isOn) {
    for (const name of names) isOn ? this.ticked.add(name) : this.ticked.delete(name);
    this.show();
  }

  keepTicks() {
    const names = new Set(this.state.seams.map(({ name }) => name));
    this.ticked = new Set([...this.ticked].filter((name) => names.has(name)));
  }

  /** What can be said about all ticked seams at once; null without any. */
  tickedForm() {
    if (!this.ticked.size) return null;
    const { seams } = this.state;
    const rows = seams.map((_, row) => row).filter((row) => this.ticked.has(seams[row].name));
    const length = rows.reduce((sum, row) => sum + seams[row].length_mm, 0);
    const act = async (kind, said) => {
      this.ticked.clear();
      await this.do({ kind, rows }, `${plural(rows.length, "seam")} ${said}`);
    };
    const several = rows.length > 1;
    return el(
      "div",
      { class: "buttons ticked" },
      el("strong", {}, `${plural(rows.length, "seam")} ticked, ${fixed(length, 1)} mm`),
      button("Accept ticked", () => act("accept", several ? "are welded" : "is welded")),
      button("Refuse ticked", () => act("refuse", several ? "are not welded" : "is not welded")),
      button("Untick", () => this.untick()),
    );
  }

  untick() {
    this.ticked.clear();
    this.show();
    this.on.onState(this.state);
  }

  say(text, kind = "") {
    this.said.className = `seam-said ${kind}`;
    this.said.textContent = text;
  }

  do(operation, said) {
    const before = this.state;
    return this.run(
      () => this.backend.change(before, operation),
      () => {
        this.done.push(before);
        this.undone = [];
      },
      said,
      this.nameAfter(operation),
    );
  }

  /** The name under which the chosen seam goes on. */
  nameAfter({ kind, row, name, rows }) {
    if (rows) return this.state.seams[this.selected]?.name;
    const own = this.state.seams[row].name;
    return kind === "rename" ? name.trim() : kind === "cut" ? `${own}a` : own;
  }

  undo() {
    const before = this.state;
    return this.run(
      () => this.backend.restore(this.done.at(-1)),
      () => {
        this.done.pop();
        this.undone.push(before);
      },
      "undone",
    );
  }

  redo() {
    const before = this.state;
    return this.run(
      () => this.backend.restore(this.undone.at(-1)),
      () => {
        this.undone.pop();
        this.done.push(before);
      },
      "done again",
    );
  }

  /** Runs one task of the backend at a time, and says what came of it. */
  async run(task, remember, said, name) {
    if (this.isBusy) return;
    this.isBusy = true;
    this.element.classList.add("busy");
    try {
      const { state, warning = "" } = await task();
      remember();
      this.adopt(state, name);
      this.say(warning || said, warning ? "wrong" : "");
    } catch (error) {
      if (!(error instanceof Refusal)) throw error;
      this.say(error.message, "wrong");
    } finally {
      this.isBusy = false;
      this.element.classList.remove("busy");
    }
  }

  show() {
    const seam = this.state.seams[this.selected];
    const history = [
      button("Undo", () => this.undo(), { disabled: !this.done.length }),
      button("Redo", () => this.redo(), { disabled: !this.undone.length }),
    ];
    if (!seam) {
      const hint = this.state.seams.length ? "Click a seam to accept, refuse, turn, cut, join or name it." : "";
      const parts = [el("p", { class: "hint" }, hint), this.tickedForm(), el("div", { class: "buttons" }, history)];
      this.bar.replaceChildren(...parts.filter(Boolean));
      return;
    }
    const what = `${seam.name}: ${seam.joint} ${seam.weld}, ${fixed(seam.length_mm, 1)} mm`;
    const words = [el("strong", {}, what), el("span", { class: "verdict-of-seam" }, ` ${verdictOf(seam)}`)];
    const row = this.selected;
    const simple = [
      seam.accepted
        ? button("Refuse", () => this.do({ kind: "refuse", row }, `${seam.name} is not welded`))
        : button("Accept", () => this.do({ kind: "accept", row }, `${seam.name} is welded`)),
      button("Turn", () => this.do({ kind: "turn", row }, `${seam.name} runs the other way`)),
      button("Other side", () =>
        this.do({ kind: "otherSide", row }, `${seam.name}: the torch comes from the other side`),
      ),
      ...history,
    ];
    const forms = [this.cutForm(seam), this.joinForm(seam), this.nameForm(seam), this.tickedForm()];
    this.bar.replaceChildren(el("p", {}, words), el("div", { class: "buttons" }, simple), ...forms.filter(Boolean));
  }

  cutForm(seam) {
    if (seam.edit?.join) {
      const part = () => this.do({ kind: "separate", row: this.selected }, `${seam.name} is separated`);
      return el("div", { class: "buttons" }, button("Separate", part));
    }
    const input = el("input", { type: "text", name: "cut", value: fixed(this.s, 1), autocomplete: "off", size: 7 });
    const act = () => this.do({ kind: "cut", row: this.selected, s: numberIn(input.value) }, `${seam.name} is cut`);
    return form("Cut at", input, "mm from the start", "Cut", act);
  }

  joinForm(seam) {
    const rows = meetingRows(this.state, this.selected, this.join_mm);
    if (!rows.length) return null;
    const { seams } = this.state;
    const options = rows.map((row) => el("option", { value: row }, seams[row].name));
    const choice = el("select", { name: "join" }, options);
    const act = () => {
      const other = Number(choice.value);
      this.do({ kind: "join", row: this.selected, other }, `${seam.name} and ${seams[other].name} are one seam`);
    };
    return form("Join with", choice, "", "Join", act);
  }

  nameForm(seam) {
    const input = el("input", {
      type: "text",
      name: "name",
      value: seam.name,
      autocomplete: "off",
      spellcheck: "false",
    });
    const act = () => this.do({ kind: "rename", row: this.selected, name: input.value }, `renamed to ${input.value}`);
    return form("Name", input, "", "Rename", act);
  }
}

/** Whether a seam is welded, and why not. */
export function verdictOf(seam) {
  const by = seam.edit?.accept || seam.edit?.reject ? " by hand" : "";
  const pending = seam.pending ? " (wpcal judges it when it gets the file)" : "";
  if (seam.accepted) return `accepted${by}${pending}`;
  const why = seam.inside?.length || !by ? seam.against : [];
  return `refused${by}${why.length ? `: ${why.join("; ")}` : ""}${pending}`;
}

function numberIn(text) {
  const value = Number(text.trim().replace(",", "."));
  if (text.trim() === "" || !Number.isFinite(value)) return Number.NaN; // the cut says what was expected
  return value;
}

function button(text, onclick, attributes = {}) {
  return el("button", { type: "button", onclick: () => onclick(), ...attributes }, text);
}

function form(label, field, unit, action, act) {
  const submit = (event) => {
    event.preventDefault();
    act();
  };
  const parts = [el("label", {}, el("span", {}, label), field, unit && el("span", {}, unit))];
  return el("form", { onsubmit: submit }, parts, el("button", { type: "submit" }, action));
}
