// What `wpcal pick` serves: features are clicked, coordinates typed, and the fit follows.
import { readBlob, readData, readJsonBlob } from "../viewer.js";
import { el } from "../dom.js";
import { lookAtSeam } from "../report/scene.js";
import { base64Of, latestOnly, post } from "../pick/link.js";
import { Rows } from "../pick/rows.js";
import { Scene } from "../pick/scene.js";
import { gauges, seamTable, stateOf } from "../pick/summary.js";
import { Table } from "../pick/table.js";

const PAUSE_MS = 120; // of the typing hand, before a fit is asked for
const NOTHING = {};

class Picker {
  constructor(root, { data, features, frames, part }) {
    Object.assign(this, { data, root, answered: { answer: null, fault: null }, version: 0, savedVersion: 0 });
    this.rows = new Rows(data.table);
    this.fitting = latestOnly(() => this.fit(), PAUSE_MS);
    this.table = new Table(this.rows, features, {
      onChange: () => this.change(),
      onSelect: (row) => this.scene?.select(row),
      onTable: (text) => this.take({ name: "pasted.csv", base64: base64OfText(text) }),
    });
    this.build();
    const onPick = (feature) => this.table.pick(feature);
    this.scene = new Scene(this.view, { features, frames, part, seams: data.seams, tolerance: data.tolerance_mm, onPick });
    this.focus = (row) => lookAtSeam(this.scene.viewer, frames[row]);
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
    this.file = el("input", { type: "file", id: "file", hidden: true });
    this.frame = el("form", { id: "frame", hidden: true });
    this.seams = el("div", {});
    this.notes = el("ul", {});
    const button = (id, text, onclick) => el("button", { type: "button", id, onclick }, text);
    const buttons = el(
      "div",
      { class: "buttons" },
      this.saveButton,
      button("add", "Add a point", () => this.table.addNameless()),
      button("open", "Open a file …", () => this.file.click()),
      button("copy", "Copy the table", () => this.copy()),
      this.file,
    );
    const head = el("header", {}, el("h1", {}, data.file), this.state, this.gauges);
    const points = el("section", { id: "points" }, this.table.element, buttons, this.frame, this.saveState);
    this.notesSection = el("section", { id: "notes" }, this.notes);
    this.root.append(this.view, el("div", { id: "side" }, head, points, el("section", { id: "seams" }, this.seams), this.notesSection));
  }

  listen() {
    this.saveButton.addEventListener("click", () => this.save());
    this.file.addEventListener("change", () => this.readFile(this.file.files[0]));
    this.frame.addEventListener("submit", (event) => event.preventDefault());
    addEventListener("dragover", (event) => event.preventDefault());
    addEventListener("drop", (event) => {
      event.preventDefault();
      this.readFile(event.dataTransfer.files[0]);
    });
    addEventListener("beforeunload", (event) => this.isUnsaved && event.preventDefault());
    addEventListener("keydown", (event) => {
      if (!(event.ctrlKey || event.metaKey) || event.key !== "s") return;
      event.preventDefault();
      this.save();
    });
  }

  get isUnsaved() {
    return this.version !== this.savedVersion;
  }

  get isIdle() {
    return this.fitting.isIdle;
  }

  // What happens ------------------------------------------------------------------------------------------------------

  change() {
    this.version += 1;
    this.root.classList.add("stale");
    this.saveState.textContent = "";
    this.fitting.ask();
  }

  async fit() {
    const { version } = this;
    const isEmpty = !this.rows.rows.some((row) => !this.rows.isWaiting(row));
    const { answer = null, fault = null } = isEmpty ? NOTHING : await post("fit", this.rows.toRecord());
    if (version !== this.version) return; // typed on meanwhile: the next answer is on its way
    this.answered = { answer, fault };
    this.show();
  }

  show() {
    const { answer, fault } = this.answered;
    const { data } = this;
    this.root.classList.remove("stale");
    const state = stateOf(this.rows, this.answered);
    Object.assign(this.state, { textContent: state.text, className: state.kind });
    this.gauges.replaceChildren(...gauges(answer, data.seams));
    this.table.show({ ...(answer ?? NOTHING), tolerance: data.tolerance_mm, fault: fault?.row ?? null });
    this.scene.show(this.rows, answer ?? NOTHING);
    this.seams.replaceChildren(seamTable(answer, data.seams, data.tolerance_mm, (row) => this.focus(row)));
    const notes = [...(answer?.notes ?? []), ...data.notes];
    this.notes.replaceChildren(...notes.map((text) => el("li", {}, text)));
    this.notesSection.hidden = !notes.length;
  }

  async save() {
    const { version } = this;
    const { answer, fault } = await post("save", this.rows.toRecord());
    this.saveState.className = fault ? "wrong" : "";
    if (fault) {
      this.saveState.textContent = `not saved: ${fault.message}`;
      return;
    }
    this.savedVersion = version;
    const left = answer.left_out.length ? ` Not in it, for want of coordinates: ${answer.left_out.join(", ")}.` : "";
    const said = `saved ${answer.rows} row${answer.rows === 1 ? "" : "s"} to ${answer.file}.${left} Now: `;
    this.saveState.replaceChildren(said, el("code", {}, this.data.command));
  }

  async copy() {
    try {
      await navigator.clipboard.writeText(this.rows.toText());
      this.say("copied");
    } catch (error) {
      this.say(`not copied: ${error.message}`, "wrong");
    }
  }

  say(text, kind = "") {
    Object.assign(this.saveState, { textContent: text, className: kind });
  }

  // Files -------------------------------------------------------------------------------------------------------------

  async readFile(file) {
    if (!file) return;
    await this.take({ name: file.name, base64: await base64Of(file) });
    this.file.value = "";
  }

  /** Reads a table or a program; where its frame is not known, asks for it. */
  async take(file) {
    const { answer, fault } = await post("read", file);
    this.frame.hidden = !fault || !fault.message.includes("--uframe");
    if (!this.frame.hidden) this.askForFrame(file);
    if (fault) return this.say(fault.message, "wrong");
    const before = this.rows.rows.length;
    this.table.merge(answer);
    return this.say(`${file.name}: ${answer.rows.length} points, ${this.rows.rows.length - before} of them new rows`);
  }

  askForFrame(file) {
    const input = el("input", { type: "text", name: "uframe", value: file.uframe ?? "", autocomplete: "off" });
    const again = el("button", { type: "submit" }, `Read ${file.name} in this frame`);
    const label = el("label", {}, el("span", {}, "User frame in the base, as on the pendant, or the word base"), input);
    this.frame.replaceChildren(label, again);
    this.frame.onsubmit = (event) => {
      event.preventDefault();
      this.take({ ...file, uframe: input.value.trim() });
    };
    input.focus();
  }
}

function base64OfText(text) {
  return btoa(String.fromCharCode(...new TextEncoder().encode(text)));
}

async function main() {
  const data = readData();
  const [features, frames, part] = await Promise.all([readJsonBlob("features"), readJsonBlob("frames"), readBlob("part")]);
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
