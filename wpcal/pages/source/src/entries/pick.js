// What `wpcal pick` serves: features are clicked, coordinates typed, and the fit follows.

import { el, fixed, short } from "../dom.js";
import { contentOf, latestOnly, post } from "../pick/link.js";
import { Rows } from "../pick/rows.js";
import { Scene } from "../pick/scene.js";
import { gauges, seamTable, stateOf } from "../pick/summary.js";
import { Table } from "../pick/table.js";
import { lookAtSeam } from "../report/scene.js";
import { readBlob, readData, readJsonBlob } from "../viewer.js";

const PAUSE_MS = 120; // of the typing hand, before a fit is asked for
const NOTHING = {};
const MOST_NAMED = 6; // points that a program has no coordinates of

class Picker {
  constructor(root, { data, features, frames, part }) {
    Object.assign(this, { data, root, answered: { answer: null, fault: null }, version: 0, savedVersion: 0 });
    Object.assign(this, { reading: Promise.resolve(), readings: 0, undo: null });
    this.rows = new Rows(data.table);
    this.fitting = latestOnly(() => this.fit(), PAUSE_MS);
    this.table = new Table(this.rows, features, {
      onChange: () => this.change(),
      onSelect: (row) => this.scene?.select(row),
      onTable: (text) => this.read([new File([text], "pasted.csv")]),
      onUndoable: (text, before, kind) => this.offerUndo(text, before, kind),
      onEmpty: () => this.addButton.focus(),
    });
    this.build();
    const onPick = (feature) => this.table.pick(feature);
    this.scene = new Scene(this.view, {
      features,
      frames,
      part,
      seams: data.seams,
      tolerance: data.tolerance_mm,
      onPick,
    });
    this.listen();
    this.show();
    if (this.rows.rows.length) this.fitting.ask();
  }

  // What stands on the page -------------------------------------------------------------------------------------------

  build() {
    const { data } = this;
    this.view = el("section", { id: "view", "aria-label": "3-D view" });
    this.state = el("p", { id: "state", role: "status" });
    this.gauges = el("div", { class: "gauges" });
    this.saveButton = el("button", { type: "button", id: "save", class: "main" }, `Save ${data.saves_to}`);
    this.saveState = el("p", { id: "save-state", role: "status" });
    this.file = el("input", { type: "file", id: "file", multiple: true, hidden: true });
    this.frame = el("form", { id: "frame", hidden: true });
    this.seams = seamTable(data.seams, data.tolerance_mm, (row) =>
      lookAtSeam(this.scene.viewer, this.scene.frames[row]),
    );
    this.notes = el("ul", {});
    const button = (id, text, onclick) => el("button", { type: "button", id, onclick }, text);
    this.addButton = button("add", "Add point", () => this.table.addNameless());
    this.suggestButton = button("suggest", "Suggest points", () => this.suggest());
    const buttons = el(
      "div",
      { class: "buttons" },
      this.saveButton,
      this.addButton,
      this.suggestButton,
      button("open", "Open file …", () => this.file.click()),
      button("copy", "Copy", () => this.copy()),
      this.file,
    );
    const head = el("header", {}, el("h1", {}, data.file), this.state, this.gauges);
    const points = el("section", { id: "points" }, this.table.element, buttons, this.frame, this.saveState);
    this.notesSection = el("section", { id: "notes" }, this.notes);
    this.root.append(
      this.view,
      el("div", { id: "side" }, head, points, el("section", { id: "seams" }, this.seams.element), this.notesSection),
    );
  }

  listen() {
    this.saveButton.addEventListener("click", () => this.save());
    this.file.addEventListener("change", () => {
      this.read([...this.file.files]);
      this.file.value = ""; // so that the same file can be opened again
    });
    this.frame.addEventListener("submit", (event) => event.preventDefault());
    this.listenToDrops();
    addEventListener("beforeunload", (event) => this.isUnsaved && event.preventDefault());
    addEventListener("paste", (event) => {
      if (event.defaultPrevented || isTypedInto(event.target)) return;
      event.preventDefault(); // the caret comes into a cell, and the browser would paste there once more
      const text = event.clipboardData.getData("text");
      if (text.trim() && !this.table.paste(text))
        this.say("what was pasted is no table and holds no positions", "wrong");
    });
    addEventListener("keydown", (event) => {
      if (!(event.ctrlKey || event.metaKey) || event.altKey) return;
      const key = event.key.toLowerCase();
      const isUndo = key === "z" && this.undo && !isTypedInto(event.target);
      if (key !== "s" && !isUndo) return;
      event.preventDefault();
      if (isUndo) this.undo();
      else if (!event.repeat) this.save();
    });
  }

  /** Files may be dropped anywhere; what else is dragged goes where the browser puts it. */
  listenToDrops() {
    const mark = (isOver) => this.root.classList.toggle("dropping", isOver);
    const hasFiles = ({ dataTransfer }) => dataTransfer.types.includes("Files");
    addEventListener("dragover", (event) => {
      if (!hasFiles(event)) return;
      event.preventDefault();
      mark(true);
    });
    addEventListener("dragleave", (event) => event.relatedTarget || mark(false));
    addEventListener("drop", (event) => {
      mark(false);
      if (!hasFiles(event)) return;
      event.preventDefault();
      this.read([...event.dataTransfer.files]);
    });
  }

  get isUnsaved() {
    return this.version !== this.savedVersion;
  }

  get isIdle() {
    return this.fitting.isIdle && this.readings === 0;
  }

  // What happens ------------------------------------------------------------------------------------------------------

  change() {
    this.version += 1;
    this.root.classList.add("stale");
    this.say("");
    this.fitting.ask();
  }

  async fit() {
    const { version } = this;
    const isEmpty = !this.rows.rows.some((row) => !this.rows.isWaiting(row));
    const { answer = null, fault = null } = isEmpty ? NOTHING : await post("fit", this.rows.toFit());
    if (version !== this.version) return; // typed on meanwhile: the next answer is on its way
    this.answered = { answer, fault };
    this.show();
  }

  show() {
    const { answer, fault } = this.answered;
    const { data } = this;
    this.root.classList.remove("stale");
    const state = stateOf(this.rows, this.answered, data.seams);
    Object.assign(this.state, { textContent: state.text, className: state.kind });
    this.gauges.replaceChildren(...gauges(answer, data.seams));
    this.table.show({ ...(answer ?? NOTHING), tolerance: data.tolerance_mm, fault });
    this.scene.show(this.rows, answer ?? NOTHING);
    this.seams.show(answer);
    const notes = [...(answer?.notes ?? []), ...data.notes];
    this.notes.replaceChildren(...notes.map((text) => el("li", {}, text)));
    this.notesSection.hidden = !notes.length;
  }

  async save() {
    const { version } = this;
    const { answer, fault } = await post("save", this.rows.toRecord());
    if (fault) return this.say(`not saved: ${fault.message}`, "wrong");
    this.savedVersion = version;
    const left = answer.left_out.length ? ` Not in it, for want of coordinates: ${answer.left_out.join(", ")}.` : "";
    const later = version === this.version ? "" : " What was typed since then is not in it.";
    const said = `saved ${answer.rows} row${answer.rows === 1 ? "" : "s"} to ${answer.file}.${left}${later} Now: `;
    return this.say(said, "", el("code", {}, this.data.command));
  }

  /** Asks which features to touch next, and makes rows for them. */
  async suggest() {
    this.suggestButton.disabled = true;
    this.say("choosing …");
    const { answer, fault } = await post("suggest", this.rows.toRecord());
    this.suggestButton.disabled = false;
    if (fault) return this.say(fault.message, "wrong");
    const { features, error_95_mm, seam, sigma_mm } = answer;
    const error = `${fixed(error_95_mm)} mm, on ${seam}, for a teaching error of ${short(sigma_mm)} mm per axis`;
    if (!features.length) return this.say(`No further point makes the largest 95 % error smaller: ${error}.`);
    return this.table.addFeatures(
      features,
      `Touch ${features.join(", ")}. All points together promise at most ${error}.`,
    );
  }

  async copy() {
    try {
      await navigator.clipboard.writeText(this.rows.toText());
      this.say("copied; paste it into a spreadsheet, or anywhere on the page of another wpcal pick");
    } catch (error) {
      this.say(`not copied: ${error.message}`, "wrong");
    }
  }

  say(text, kind = "", ...more) {
    this.undo = null;
    this.saveState.className = kind;
    this.saveState.replaceChildren(text, ...more);
  }

  /** Says what happened to the table, and takes it back on demand, until something else happens. */
  offerUndo(text, before, kind = "") {
    const undo = () => {
      this.table.restore(before);
      this.say("taken back");
    };
    const button = el("button", { type: "button", onclick: undo }, "Undo");
    this.say(text, kind, " ", button);
    this.undo = undo;
  }

  // Files -------------------------------------------------------------------------------------------------------------

  /** Reads files one after the other, in the order in which they came. */
  read(files) {
    return this.queue(async () => {
      const before = this.rows.toRecord();
      const said = [];
      for (const file of files) said.push(await this.take(await contentOf(file)));
      this.report(said, before);
    });
  }

  queue(task) {
    this.readings += 1;
    this.reading = this.reading.then(task).finally(() => (this.readings -= 1));
    return this.reading;
  }

  report(said, before) {
    const text = said.map((one) => one.text).join(" ");
    const kind = said.some(({ isWrong }) => isWrong) ? "wrong" : "";
    if (said.some(({ isChange }) => isChange)) this.offerUndo(text, before, kind);
    else this.say(text, kind);
  }

  /** Takes in a table or a program; where its frame is not known, asks for it. Returns what is to be said. */
  async take(file) {
    const { answer, fault } = file.fault ? file : await post("read", file);
    const wasAsked = this.asksFor === file.name && !this.frame.hidden;
    if (!fault && wasAsked) this.frame.hidden = true;
    if (fault?.message.includes("--uframe") && !wasAsked) this.askForFrame(file);
    if (fault) return { text: fault.message, isWrong: true };
    const { added, filled, replaced } = this.table.merge(answer);
    const parts = [
      [added, "new"],
      [filled, "filled in"],
      [replaced, "replaced"],
    ].filter(([count]) => count);
    const what = parts.map(([count, word]) => `${count} ${word}`).join(", ") || "all in the table already";
    const { length } = answer.rows;
    const leftOut = answer.left_out ?? [];
    const more = leftOut.length > MOST_NAMED ? `; and ${leftOut.length - MOST_NAMED} more` : "";
    const without = leftOut.length ? ` Left out: ${leftOut.slice(0, MOST_NAMED).join("; ")}${more}.` : "";
    return {
      text: `${file.name}: ${length} point${length === 1 ? "" : "s"}, ${what}.${without}`,
      isChange: parts.length > 0,
    };
  }

  askForFrame(file) {
    const input = el("input", { type: "text", name: "uframe", autocomplete: "off", spellcheck: "false" });
    const again = el("button", { type: "submit" }, `Read ${file.name} in this frame`);
    input.addEventListener("keydown", (event) => event.key === "Escape" && (this.frame.hidden = true));
    const label = el("label", {}, el("span", {}, "User frame in the base, as on the pendant, or the word base"), input);
    this.asksFor = file.name;
    this.frame.replaceChildren(label, again);
    this.frame.hidden = false;
    this.frame.onsubmit = (event) => {
      event.preventDefault();
      this.queue(async () => {
        const before = this.rows.toRecord();
        this.report([await this.take({ ...file, uframe: input.value.trim() })], before);
      });
    };
    input.focus();
  }
}

function isTypedInto(element) {
  return element instanceof Element && element.matches("input[type=text]");
}

async function main() {
  const data = readData();
  const [features, frames, part] = await Promise.all([
    readJsonBlob("features"),
    readJsonBlob("frames"),
    readBlob("part"),
  ]);
  const picker = new Picker(document.getElementById("page"), { data, features, frames, part });
  const { viewer } = picker.scene;
  window.wpcal = {
    viewer,
    project: (p) => viewer.project(p),
    ready: true,
    get idle() {
      return picker.isIdle;
    },
  };
}

main();
