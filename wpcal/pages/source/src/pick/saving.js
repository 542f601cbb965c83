// Save, and what a person can do when the file is not the one that the page shows.
import { el } from "../dom.js";
import { plural } from "../words.js";
import { idOf } from "./draft.js";
import { FAULTS, post } from "./link.js";
import { withTheirs } from "./merge.js";
import { theirsText } from "./theirs.js";

const MOST_TRIES = 5; // other windows may type while this one saves

export class Saving {
  /**
   * @param {{rows: Rows, draft: Draft, status: Status, table: Table, version: number}} page
   * @param {string} savesTo  name of the file
   */
  constructor(page, savesTo) {
    Object.assign(this, { page, savesTo });
    this.form = el("form", { id: "save-as", hidden: true });
    this.form.addEventListener("submit", (event) => event.preventDefault());
  }

  /**
   * Saves what the page shows now. If another window changes the same cell in the same instant, nothing is saved.
   *
   * @param {{name?: string, replaces?: string}} choice  another name, or the hash of a file to be replaced
   * @param {object[]} decided  the conflicts that the person has seen and decided by this click
   */
  async save(choice = {}, decided = []) {
    const { page } = this;
    const click = { ...choice, ...page.draft.shown, consent: decided.map(idOf) };
    if (page.draft.undecided.some((conflict) => !decided.includes(conflict))) return this.askToChoose(choice);
    const { answer, fault, version } = await page.draft.queue(() => this.ask(click));
    if (fault) return this.refused(fault, choice);
    page.draft.decided(decided);
    this.form.hidden = true;
    const { left_out: leftOut } = answer;
    const left = leftOut.length ? ` Kept in the draft, because coordinates are missing: ${leftOut.join(", ")}.` : "";
    const news = answer.has_news ? " It also holds what another window typed at the same moment." : "";
    const later = version === page.version ? "" : " Changes made since then are not in the file.";
    const backup = answer.backup ? ` The version before is ${answer.backup}.` : "";
    const warning = answer.warning ? ` ${answer.warning}.` : "";
    const more = left + news + later + backup + warning;
    const text = `saved ${plural(answer.rows, "row")} to ${answer.file}.${more} Now: `;
    return page.status.say(text, "", el("code", {}, answer.command));
  }

  /** Brings the server's table up to date, and then sends the click. */
  async ask(click) {
    const { draft } = this.page;
    for (let count = 0; count < MOST_TRIES; count += 1) {
      if (!(await draft.keep())) return { fault: draft.fault };
      const { version } = this.page;
      const { answer, fault } = await post("save", { ...click, revision: draft.revision });
      if (fault) return { fault };
      if (!answer.is_stale) {
        draft.saved(answer);
        return { answer, version };
      }
      draft.take(answer);
    }
    return { fault: { message: "another window changes the table all the time; save again", code: "stale" } };
  }

  /** Shows both texts of every cell that two windows changed; each button names exactly these conflicts. */
  askToChoose(choice) {
    const { draft, status } = this.page;
    const conflicts = [...draft.undecided];
    const mine = this.button("Save the text of this window", () => this.save(choice, conflicts));
    const text = `not saved. ${theirsText({ changed: [], conflicts })}`;
    return status.say(text, "wrong", " ", mine, " ", this.takeTheirsButton(conflicts));
  }

  /** Puts the other window's text into cells that two windows changed. */
  takeTheirsButton(conflicts) {
    const { draft, rows, status, table } = this.page;
    return this.button("Take the others", () => {
      draft.decided(conflicts);
      table.restore(withTheirs(rows.toRecord(), conflicts));
      status.say("taken");
    });
  }

  button(text, onclick) {
    return el("button", { type: "button", onclick }, text);
  }

  refused(fault, choice) {
    const { status } = this.page;
    const button = (text, onclick) => [" ", this.button(text, onclick)];
    const saveAs = button("Save as …", () => this.askForName());
    const text = `not saved: ${fault.message}`;
    if (fault.code === FAULTS.conflict) return this.askToChoose(choice);
    if (fault.code === FAULTS.fileReadOnly) return status.say(text, "wrong", ...saveAs);
    if (fault.code !== FAULTS.fileChanged) return status.say(text, "wrong");
    const open = button("Open it", () => this.open());
    const replace = button("Replace it", () => this.save({ replaces: fault.sha256 }));
    return status.say(`${text}. Replaced, it is kept as a .bak file.`, "wrong", ...open, ...saveAs, ...replace);
  }

  askForName() {
    const input = el("input", { type: "text", name: "name", autocomplete: "off", spellcheck: "false" });
    input.value = freeName(this.savesTo);
    input.addEventListener("keydown", (event) => {
      if (event.key === "Escape") this.form.hidden = true;
    });
    const words = `Name of a new table, in the folder of ${this.savesTo}`;
    this.form.replaceChildren(
      el("label", {}, el("span", {}, words), input),
      el("button", { type: "submit" }, "Save under this name"),
    );
    this.form.onsubmit = () => this.save({ name: input.value.trim() });
    this.form.hidden = false;
    input.focus();
    input.select();
  }

  /** Shows the rows of the file as it is now. */
  async open() {
    const { draft, rows, status, table } = this.page;
    let before = null;
    const { answer, fault } = await draft.queue(async () => {
      if (!(await draft.keep())) return { fault: draft.fault };
      before = rows.toRecord();
      const outcome = await post("open", {});
      if (outcome.answer) table.adopt(outcome.answer.table);
      if (outcome.answer) draft.replaced(outcome.answer);
      return outcome;
    });
    if (fault) return status.say(fault.message, "wrong");
    return status.offerUndo(`${answer.saves_to} opened: ${plural(answer.table.rows.length, "row")}.`, before);
  }
}

/** The name with the next number before its ending. */
export function freeName(path) {
  const [, stem, count, ending] = path
    .split(/[\\/]/)
    .at(-1)
    .match(/^(.*?)(?:-(\d+))?(\.[^.]*)?$/);
  return `${stem}-${Number(count ?? 1) + 1}${ending ?? ""}`;
}
