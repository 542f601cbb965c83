// Tables and robot programs that are opened or dropped: their points go into the table.
import { el } from "../dom.js";
import { plural } from "../words.js";
import { contentOf, FAULTS, post } from "./link.js";

const MOST_NAMED = 6; // points of a program that were left out; the others are counted

export class Files {
  constructor({ rows, table, status }) {
    Object.assign(this, { rows, table, status });
    this.frameForm = el("form", { id: "frame", hidden: true });
    this.frameForm.addEventListener("submit", (event) => event.preventDefault());
    this.asksFor = null; // name of the file whose user frame is asked for
    this.last = Promise.resolve();
    this.waiting = 0;
  }

  get isIdle() {
    return this.waiting === 0;
  }

  /** Reads files one after the other, in the given order. */
  read(files) {
    return this.queue(async () => {
      const before = this.rows.toRecord();
      const outcomes = [];
      for (const file of files) outcomes.push(await this.take(await contentOf(file)));
      this.report(outcomes, before);
    });
  }

  queue(task) {
    this.waiting += 1;
    this.last = this.last.then(task).finally(() => {
      this.waiting -= 1;
    });
    return this.last;
  }

  report(outcomes, before) {
    const text = outcomes.map((one) => one.text).join(" ");
    const kind = outcomes.some(({ isWrong }) => isWrong) ? "wrong" : "";
    if (outcomes.some(({ isChange }) => isChange)) this.status.offerUndo(text, before, kind);
    else this.status.say(text, kind);
  }

  /**
   * Merges the points of one file into the table, or asks for its user frame where the file does not contain it.
   *
   * @param {{name: string, base64?: string, uframe?: string, fault?: object}} file
   * @returns {Promise<{text: string, isWrong?: boolean, isChange?: boolean}>}
   */
  async take(file) {
    const { answer, fault } = file.fault ? file : await post("read", file);
    const wasAsked = this.asksFor === file.name && !this.frameForm.hidden;
    if (fault) {
      if (fault.code === FAULTS.userFrameMissing && !wasAsked) this.askForFrame(file);
      return { text: fault.message, isWrong: true };
    }
    if (wasAsked) this.frameForm.hidden = true;
    const counts = this.table.merge(answer);
    return { text: mergedText(file.name, answer, counts), isChange: Object.values(counts).some(Boolean) };
  }

  askForFrame(file) {
    const input = el("input", { type: "text", name: "uframe", autocomplete: "off", spellcheck: "false" });
    input.addEventListener("keydown", (event) => {
      if (event.key === "Escape") this.frameForm.hidden = true;
    });
    const words = "User frame in the robot's base, as the pendant shows it, or the word base";
    const again = el("button", { type: "submit" }, `Read ${file.name} in this frame`);
    this.asksFor = file.name;
    this.frameForm.replaceChildren(el("label", {}, el("span", {}, words), input), again);
    this.frameForm.hidden = false;
    this.frameForm.onsubmit = () =>
      this.queue(async () => {
        const before = this.rows.toRecord();
        this.report([await this.take({ ...file, uframe: input.value.trim() })], before);
      });
    input.focus();
  }
}

/** What a file brought, in one or two sentences. */
export function mergedText(name, { rows, left_out: leftOut = [] }, { added, filled, replaced }) {
  const counts = [
    [added, "new"],
    [filled, "filled in"],
    [replaced, "replaced"],
  ].filter(([count]) => count);
  const what = counts.map(([count, word]) => `${count} ${word}`).join(", ") || "all in the table already";
  const more = leftOut.length > MOST_NAMED ? `; and ${leftOut.length - MOST_NAMED} more` : "";
  const without = leftOut.length ? ` Left out: ${leftOut.slice(0, MOST_NAMED).join("; ")}${more}.` : "";
  return `${name}: ${plural(rows.length, "point")}, ${what}.${without}`;
}
