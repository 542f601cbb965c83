// The page of `wpcal pick`: a person clicks features and types coordinates, and the fit follows.
import { centreOf } from "../bodies.js";
import { el, fixed, short } from "../dom.js";
import { AllSeams } from "../pick/all_seams.js";
import { Draft } from "../pick/draft.js";
import { Files } from "../pick/files.js";
import { listenToGestures } from "../pick/gestures.js";
import { buildLayout } from "../pick/layout.js";
import { latestOnly, post } from "../pick/link.js";
import { Moving } from "../pick/moving.js";
import { Rows } from "../pick/rows.js";
import { Saving } from "../pick/saving.js";
import { Scene } from "../pick/scene.js";
import { PickerSeams } from "../pick/seams.js";
import { Status } from "../pick/status.js";
import { gauges, seamTables, stateOf } from "../pick/summary.js";
import { Table } from "../pick/table.js";
import { theirsText } from "../pick/theirs.js";
import { lookAtPoint, lookAtSeam } from "../report/scene.js";
import { SeamEditor } from "../seams/editor.js";
import { readBlob, readData, readJsonBlob } from "../viewer.js";

const PAUSE_MS = 120; // without a key, before the page asks for a fit
const NOTHING = {};

class Picker {
  constructor(root, { data, start, features, frames, part }) {
    Object.assign(this, { data, root, answered: { answer: null, fault: null }, version: 0, isStepping: false });
    this.rows = new Rows(start.table);
    this.fitting = latestOnly(() => this.fit(), PAUSE_MS);
    this.promising = latestOnly(() => this.promise(), PAUSE_MS);
    this.status = new Status((before) => this.table.restore(before));
    this.table = new Table(this.rows, features, data.choices, {
      onChange: () => this.change(),
      onSelect: (row) => this.scene?.select(row),
      onTable: (text) => this.files.read([new File([text], "pasted.csv")]),
      onUndoable: (text, before, kind) => this.status.offerUndo(text, before, kind),
      onEmpty: () => this.layout.addButton.focus(),
    });
    this.files = new Files(this);
    this.draft = new Draft(this.rows, start, {
      onTheirs: (merged) => this.takeTheirs(merged),
      onFault: (message) => this.status.say(`This change is not kept on disk: ${message}`, "wrong"),
      onName: (name) => this.showName(name),
    });
    this.saving = new Saving(this, start.saves_to);
    const onSolids = (solids) => this.allSeams.takeSolids(solids);
    this.backend = new PickerSeams(data.seams_revision, (state) => this.editor.take(state), onSolids);
    const onSeams = {
      onState: (state) => this.takeSeams(state),
      onSelect: (row) => {
        this.scene.chooseSeam(row);
        this.allSeams.show();
        this.editor.element.scrollIntoView({ block: "nearest" });
      },
    };
    this.editor = new SeamEditor({ seams: data.seams, frames }, this.backend, onSeams, data.join_mm);
    this.seamsBox = el("div", { class: "seam-tables" });
    const onLook = (name) => this.lookAtMember(name);
    const said = { onSay: (name, word) => this.saySolid(name, word), onLook, judging: data.judging };
    this.allSeams = new AllSeams(this.editor, data.members, (row) => this.focusSeam(row), said);
    this.moving = new Moving(start.moving, {
      onChange: () => this.refit(),
      onFault: (message) => this.status.say(message, "wrong"),
      onBody: (body) => lookAtPoint(this.scene.viewer, centreOf(body, null)),
      onSeam: (name) => this.focusSeam(this.editor.state.seams.findIndex((seam) => seam.name === name)),
    });
    this.tabulate(data.seams);
    this.layout = this.build();
    const { tolerance_mm: tolerance, seams } = data;
    const onPick = (feature) => this.table.pick(feature);
    const onSeam = (row, s) => this.editor.select(row, s);
    const onTouch = (touch) => this.table.addTouch(touch);
    const onSay = (text, kind) => this.status.say(text, kind);
    const on = { onPick, onSeam, onTouch, onSay };
    this.scene = new Scene(this.layout.view, { features, frames, part, seams, tolerance, ...on });
    this.layout.showPromise(this.scene.touching.output);
    this.listen();
    this.show();
    if (this.rows.rows.length) this.ask();
    this.backend.look(); // a reload shows what was decided since the start
  }

  build() {
    const parts = {
      table: this.table.element,
      frameForm: this.files.frameForm,
      saveForm: this.saving.form,
      status: this.status.element,
      editor: this.editor.element,
      seams: [this.moving.element, this.seamsBox, this.allSeams.element],
    };
    return buildLayout(this.root, this.data, this.saving.savesTo, parts, {
      onSave: () => this.saving.save(),
      onAdd: () => this.table.addNameless(),
      onSuggest: () => this.suggest(),
      onExchange: (row, feature) => this.table.exchange(row, feature),
      onFiles: (files) => this.files.read(files),
      onCopy: () => this.copy(),
      onRobot: () => this.readRobot(),
    });
  }

  listen() {
    listenToGestures(this.root, {
      onFiles: (files) => this.files.read(files),
      onText: (text) => {
        const isTaken = this.table.paste(text);
        if (!isTaken) this.status.say("the pasted text is not a table and contains no positions", "wrong");
      },
      onSave: () => this.saving.save(),
      onRobot: () => this.readRobot(),
      canUndo: () => this.status.undo !== null,
      onUndo: () => this.status.undo(),
      isAtRisk: () => this.draft.isAtRisk,
    });
  }

  get isIdle() {
    const parts = [this.fitting, this.promising, this.files, this.draft, this.moving];
    return parts.every(({ isIdle }) => isIdle) && !this.editor.isBusy;
  }

  tabulate(seams) {
    this.seams = seamTables(seams, this.data.tolerance_mm, (row) => this.focusSeam(row));
    this.seamsBox.replaceChildren(this.seams.element);
  }

  focusSeam(row) {
    this.editor.select(row);
    lookAtSeam(this.scene.viewer, this.editor.state.frames[row]);
  }

  /** A person decided about the seams, here or in another window: their errors are predicted anew. */
  takeSeams(state) {
    this.version += 1;
    this.answered = { ...this.answered, answer: null };
    this.tabulate(state.seams);
    this.allSeams.show();
    this.scene.takeSeams(state);
    this.scene.chooseSeam(this.editor.selected);
    this.show();
    if (this.rows.rows.length) this.ask();
  }

  /** A person says what a solid or member is. */
  async saySolid(name, word) {
    this.editor.say(`finding the seams again: ${name}`);
    const warning = await this.backend.say(name, word);
    const known = { rules: "the rules decide", weld: "welded", not: "not welded" };
    this.editor.say(warning || `${name}: ${known[word] ?? word}`, warning ? "wrong" : "");
  }

  /** Draws the borders of the faces of a member. */
  async lookAtMember(name) {
    const { answer } = await post("outline", { solid: name });
    if (answer) this.scene.markMember(answer.p_mm);
  }

  change() {
    this.version += 1;
    this.root.classList.add("stale");
    this.status.say("");
    this.draft.change();
    this.ask();
  }

  /** The same rows, fitted in another way. */
  refit() {
    this.version += 1;
    this.root.classList.add("stale");
    this.ask();
  }

  ask() {
    this.fitting.ask();
    this.promising.ask();
  }

  /** Another window changed the table. */
  takeTheirs(merged) {
    this.table.adopt(merged.table);
    const text = theirsText(merged);
    const { conflicts } = merged;
    if (conflicts.length) this.status.say(text, "wrong", " ", this.saving.takeTheirsButton(conflicts));
    else this.status.say(text);
  }

  showName(name) {
    this.saving.savesTo = name;
    this.layout.showName(name);
  }

  async fit() {
    const { version } = this;
    const isEmpty = !this.rows.rows.some((row) => !this.rows.isWaiting(row));
    const { answer = null, fault = null } = isEmpty ? NOTHING : await post("fit", this.rows.toFit());
    if (version !== this.version) return; // the rows have changed since: another fit is already asked for
    if (answer && answer.seams_revision !== this.backend.revision) {
      await this.backend.look(); // another window changed the seams
      return;
    }
    this.answered = { answer, fault };
    this.show();
    if (this.isStepping) this.stepOn(answer);
  }

  /** The robot's position goes into the selected row. One at a time. */
  async readRobot() {
    const { robotButton } = this.layout;
    if (!robotButton || robotButton.disabled) return;
    const row = this.table.rowForRobot();
    robotButton.disabled = true;
    this.status.say(`reading the robot for ${row.name} …`);
    const { answer, fault } = await post("robot", {});
    robotButton.disabled = false;
    if (fault) this.status.say(`${row.name}: ${fault.message}`, "wrong");
    else this.isStepping = this.table.takeRobot(row, answer) === null && this.rows.rows.includes(row);
  }

  /** All rows have coordinates: what to touch next, unless it is enough. */
  stepOn(answer) {
    this.isStepping = false;
    if (answer?.verdict !== "PASS" && !("kind" in this.rows.rows[0])) this.suggest(false);
  }

  /** What touches promise before they are made, if the table has such rows. */
  async promise() {
    const { version } = this;
    const { answer, fault } =
      "kind" in (this.rows.rows[0] ?? NOTHING) ? await post("promise", this.rows.toFit()) : NOTHING;
    if (version !== this.version) return;
    this.scene.touching.show(answer?.touches.length ? answer : null, fault);
    this.scene.show(this.rows, this.answered.answer ?? NOTHING);
  }

  show() {
    const { answer, fault } = this.answered;
    const { data, layout } = this;
    const { seams } = this.editor.state;
    this.root.classList.remove("stale");
    const state = stateOf(this.rows, this.answered);
    Object.assign(layout.state, { textContent: state.text, className: state.kind });
    layout.gauges.replaceChildren(...gauges(answer, seams));
    this.table.show({ ...(answer ?? NOTHING), tolerance: data.tolerance_mm, fault });
    this.scene.show(this.rows, answer ?? NOTHING);
    this.seams.show(answer);
    this.moving.show(answer);
    const notes = [...(answer?.steps ?? []), answer?.criterion_advice, ...(answer?.notes ?? []), ...data.notes].filter(
      Boolean,
    );
    layout.showNotes(notes, answer?.exchanges ?? []);
  }

  /** Asks which features to touch next, and adds rows for them; unasked, only while no row is selected. */
  async suggest(isAsked = true) {
    const { suggestButton } = this.layout;
    suggestButton.disabled = true;
    if (isAsked) this.status.say("choosing points …");
    const { answer, fault } = await post("suggest", this.rows.toRecord());
    suggestButton.disabled = false;
    if (!isAsked && this.table.selected) return null; // the person went on meanwhile
    if (fault) return this.status.say(fault.message, "wrong");
    const { features, error_95_mm, seam, sigma_mm, touches = [] } = answer;
    const error = `${fixed(error_95_mm)} mm, on ${seam}, for a teaching error of ${short(sigma_mm)} mm per axis`;
    if (!features.length) return this.status.say(`No further point reduces the largest 95 % error: ${error}.`);
    const what = touches.length === 1 ? touches[0].sentence.replace(/^t/, "T") : `Touch ${features.join(", ")}`;
    const text = `${what}. With all points, the 95 % error is at most ${error}.`;
    return this.table.addFeatures(features, text);
  }

  async copy() {
    if (!navigator.clipboard) {
      this.status.say("not copied: browsers give the clipboard only to a page of the same machine. Use Save.", "wrong");
      return;
    }
    try {
      await navigator.clipboard.writeText(this.rows.toText());
      this.status.say("copied; paste the rows into a spreadsheet, or anywhere on the page of another wpcal pick");
    } catch (error) {
      this.status.say(`not copied: ${error.message}`, "wrong");
    }
  }
}

async function main() {
  const data = readData();
  const [{ answer: start, fault }, features, frames, part] = await Promise.all([
    post("table", { revision: -1 }),
    readJsonBlob("features"),
    readJsonBlob("frames"),
    readBlob("part"),
  ]);
  const root = document.getElementById("page");
  if (fault) {
    root.append(el("p", { class: "wrong" }, fault.message));
    return;
  }
  const picker = new Picker(root, { data, start, features, frames, part });
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
