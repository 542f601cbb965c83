// The page of `wpcal welds --html`: every value of every weld, where it came from, and an editor. What a person states
// goes into a file, which wpcal takes with --values.
import { sides, toggles, tooltip } from "../controls.js";
import { el, facts, fixed } from "../dom.js";
import { lookAtSeam } from "../report/scene.js";
import { download } from "../seams/file.js";
import { buildOrSayWhy, buildStage, seeThroughBox } from "../stage.js";
import { cutControl, measureTool } from "../view_tools.js";
import { readBlob, readData, readJsonBlob } from "../viewer.js";
import { ValueForm } from "../welds/form.js";
import { WeldGrid } from "../welds/grid.js";
import { Statements } from "../welds/statements.js";
import { shown } from "../welds/values.js";
import { plural } from "../words.js";

const SEAM = "#c2410c";
const CHOSEN = "#1d5fa8";
const MOST_NAMED = 6; // seams in a sentence
const IN_WORDS = ["leg_mm", "throat_mm", "depth_mm", "passes", "process", "speed_mm_s", "weave", "stitch"];

class WeldsPage {
  constructor(root, { data, lines, part }) {
    Object.assign(this, { data, lines, ticked: new Set(), saved: null });
    this.statements = new Statements(data);
    this.count = el("p", { "data-test": "count" });
    this.view = el("section", { id: "view", "aria-label": "3-D view" });
    this.said = el("p", { class: "said", role: "status" });
    this.grid = new WeldGrid(this, {
      onChoose: (row, isOther) => this.choose(row, isOther),
      onEdit: (typed) => this.form.edit(typed),
      onBack: () => this.set(undefined),
      onTick: (rows, isOn) => this.tick(rows, isOn),
    });
    this.form = new ValueForm(this, {
      onSet: (value) => this.set(value),
      onSay: (text) => this.say(text, true),
      onLeave: () => this.grid.cell().focus(),
      onUndo: () => this.go("undo"),
      onRedo: () => this.go("redo"),
    });
    const save = el("button", { type: "button", id: "download", onclick: () => this.save() }, `Save ${data.file}`);
    const how =
      "A page cannot change files: your browser saves this one, often among its downloads. Then type, with its path:";
    this.saving = el("div", { class: "saving", hidden: true }, save, [
      el("p", {}, how, " ", el("code", { "data-test": "command" }, data.command)),
    ]);
    const tools = el("section", { id: "tools" }, this.form.element, this.said, this.saving);
    root.append(el("header", {}, el("h1", {}, `Welds of ${data.folder}`), this.count), this.view, tools);
    root.append(el("div", { id: "lists" }, this.grid.element));
    root.addEventListener("keydown", (event) => this.key(event));
    addEventListener("beforeunload", (event) => this.isUnsaved && event.preventDefault());
    this.viewer = buildOrSayWhy(this.view, () => this.build(part));
    this.show();
  }

  get isUnsaved() {
    return this.statements.isChanged && this.saved !== this.statements.now;
  }

  build(part) {
    const { viewer, stage } = buildStage(this.view, "3-D view of the part and its seams");
    const solid = part && viewer.addPart(part, {});
    const tip = tooltip(stage);
    viewer.onHover((found) => (found ? tip.show(this.words(found.data), found) : tip.hide()));
    viewer.onPick((found) => found && this.grid.choose(found.data));
    this.lines.forEach(({ p: points }, row) => {
      const { name } = this.data.welds[row];
      viewer.addPaths("seams", [{ points, color: SEAM }], { width: 6 });
      viewer.addTargets("seams", points, row);
      viewer.addLabels("names", [{ p: middleOf(points), text: name }], { className: "of-seam" });
    });
    const layers = [
      part && { label: "part", layers: ["part"], on: true },
      part && { label: "edges", layers: ["part edges"], on: true },
      { label: "seams", layers: ["seams"], on: true },
      { label: "names", layers: ["names"], on: true },
    ].filter(Boolean);
    const tools = [part && seeThroughBox(solid), measureTool(viewer).element, part && cutControl(viewer)];
    this.view.append(el("div", { class: "panel" }, toggles(viewer, layers), tools));
    stage.append(sides(viewer));
    viewer.view("iso");
    return viewer;
  }

  words(row) {
    const { name, joint, length_mm } = this.data.welds[row];
    const stated = this.data.fields
      .filter((field) => IN_WORDS.includes(field.name))
      .map((field) => [field.label, shown(field, this.statements.value(row, field.name).value), field.unit])
      .filter(([, text]) => text)
      .map(([label, text, unit]) => [label, `${text} ${unit}`]);
    return el(
      "div",
      {},
      el("strong", {}, name),
      facts([["joint", joint], ["length", `${fixed(length_mm, 1)} mm`], ...stated]),
    );
  }

  /** The rows for which a value is set: the ticked ones if the chosen one is ticked. */
  get rows() {
    const { row } = this.grid;
    return this.ticked.has(row) ? [...this.ticked].sort((a, b) => a - b) : [row];
  }

  set(value) {
    const { field } = this.grid;
    const { rows } = this;
    const fault = this.statements.state(rows, field.name, value);
    if (fault) return this.say(fault, true);
    this.show();
    const what =
      value === undefined ? "goes back to the rules" : `is ${shown(field, value)} ${value === null ? "" : field.unit}`;
    const few = rows.length <= MOST_NAMED;
    const where = few ? rows.map((row) => this.data.welds[row].name).join(", ") : plural(rows.length, "seam");
    this.say(`${field.label} ${what.trim()} in ${where}`);
    return this.grid.cell().focus();
  }

  go(way) {
    this.statements[way]();
    this.show();
    this.say(way === "undo" ? "undone" : "done again");
  }

  key(event) {
    const { key, ctrlKey, metaKey, shiftKey } = event;
    const way = { z: shiftKey ? "redo" : "undo", y: "redo" }[key.toLowerCase()];
    if (!(ctrlKey || metaKey) || !way || event.target.matches("input[type=text]")) return;
    event.preventDefault();
    this.go(way);
  }

  tick(rows, isOn) {
    for (const row of rows) isOn ? this.ticked.add(row) : this.ticked.delete(row);
    this.show();
  }

  choose(row, isOther) {
    this.showForm();
    if (this.viewer && isOther) lookAtSeam(this.viewer, this.lines[row]);
  }

  say(text, isWrong = false) {
    this.said.className = isWrong ? "said wrong" : "said";
    this.said.textContent = text;
  }

  save() {
    download(this.data.file, `${JSON.stringify(this.statements.file(), null, 1)}\n`);
    this.saved = this.statements.now;
  }

  show() {
    const { welds } = this.data;
    const byYou = this.statements.now.filter((stated) => Object.keys(stated).length).length;
    this.count.textContent = `${plural(welds.length, "weld")}; you stated values in ${byYou}`;
    this.saving.hidden = !this.statements.isChanged;
    this.grid.fill(this.ticked);
    this.showForm();
  }

  showForm() {
    const { welds } = this.data;
    if (!welds.length) return;
    const { row, field } = this.grid;
    this.form.show(field, welds[row], row, this.rows);
    if (this.viewer) this.mark();
  }

  mark() {
    this.viewer.clear("chosen");
    for (const row of this.rows)
      this.viewer.addPaths("chosen", [{ points: this.lines[row].p, color: CHOSEN }], { width: 9, opacity: 0.6 });
  }
}

function middleOf(points) {
  return points[Math.floor(points.length / 2)];
}

async function main() {
  const [lines, part] = await Promise.all([readJsonBlob("lines"), readBlob("part")]);
  const page = new WeldsPage(document.getElementById("page"), { data: readData(), lines, part });
  window.wpcal = { viewer: page.viewer, project: (p) => page.viewer.project(p), ready: true };
}

main();
