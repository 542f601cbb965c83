// The page of `wpcal seams --html`: the seams of a part, the candidates that were refused, and the reasons. What a
// person decides here goes into a file, with which wpcal finds the seams again.
import { sides, toggles, tooltip } from "../controls.js";
import { el, facts, fixed } from "../dom.js";
import { lookAtSeam } from "../report/scene.js";
import { decisionsOf } from "../seams/decisions.js";
import { SeamEditor, verdictOf } from "../seams/editor.js";
import { placesAlong } from "../seams/ends.js";
import { download, seamsFile } from "../seams/file.js";
import { SeamList } from "../seams/list.js";
import { memberTable } from "../seams/members.js";
import { previewed } from "../seams/preview.js";
import { buildOrSayWhy, buildStage, seeThroughBox } from "../stage.js";
import { cutControl, measureTool } from "../view_tools.js";
import { readBlob, readData, readJsonBlob } from "../viewer.js";
import { plural } from "../words.js";

const ACCEPTED = "#c2410c";
const REFUSED = "#8a94a0";
const CHOSEN = "#1d5fa8";
const LAYERS = ["seams", "candidates", "names"];
const FILE = "seams.json";

class SeamsPage {
  constructor(root, { file, record, frames, part }) {
    Object.assign(this, { record, file });
    this.count = el("p", { "data-test": "count" });
    this.view = el("section", { id: "view", "aria-label": "3-D view" });
    const state = { seams: record.seams, frames };
    const backend = {
      change: async (before, operation) => ({ state: previewed(before, operation) }),
      restore: async (before) => ({ state: before }),
    };
    const on = { onState: () => this.show(), onSelect: (row) => this.look(row) };
    this.editor = new SeamEditor(state, backend, on, record.join_mm);
    this.list = new SeamList({
      onChoose: (row) => this.choose(row),
      onTick: (names, isOn) => this.editor.tick(names, isOn),
      members: record.members ?? [],
    });
    const members = memberTable(record.members ?? [], (solid) => this.list.find(solid));
    const lists = el("div", { id: "lists" }, this.list.element, members);
    this.saving = el("div", { class: "saving", hidden: true }, [
      el("button", { type: "button", id: "download", onclick: () => this.save() }, `Save ${FILE}`),
      el("p", {}, "Then: ", el("code", {}, `wpcal calibrate ${file} TAUGHT.csv -o RESULT --seams ${FILE}`)),
    ]);
    const tools = el("section", { id: "tools" }, this.editor.element, this.saving);
    root.append(el("header", {}, el("h1", {}, file), this.count), this.view, tools, lists);
    this.viewer = buildOrSayWhy(this.view, () => this.build(part));
    this.show();
  }

  save() {
    download(FILE, `${JSON.stringify(seamsFile(this.record, this.editor.state.seams), null, 1)}\n`);
  }

  build(part) {
    const { viewer, stage } = buildStage(this.view, "3-D view of the part and its seams");
    const solid = part && viewer.addPart(part, {});
    const tip = tooltip(stage);
    viewer.onHover((found) => (found ? tip.show(words(found.data.seam), found) : tip.hide()));
    viewer.onPick((found) => found && this.editor.select(found.data.row, found.data.s[found.index]));
    const layers = [
      part && { label: "part", layers: ["part"], on: true },
      part && { label: "edges", layers: ["part edges"], on: true },
      { label: "seams", layers: ["seams"], on: true },
      { label: "refused", layers: ["candidates"], on: false },
      { label: "names", layers: ["names"], on: true },
    ].filter(Boolean);
    const tools = [part && seeThroughBox(solid), measureTool(viewer).element, part && cutControl(viewer)];
    this.view.append(el("div", { class: "panel" }, toggles(viewer, layers), tools));
    stage.append(sides(viewer));
    this.draw(viewer);
    viewer.view("iso");
    return viewer;
  }

  show() {
    const { seams } = this.editor.state;
    const accepted = seams.filter((seam) => seam.accepted).length;
    const refused = plural(seams.length - accepted, "candidate");
    this.count.textContent = `${plural(accepted, "seam")} accepted, ${refused} refused`;
    this.saving.hidden = !this.editor.done.length && !decisionsOf(seams).length;
    this.list.show(seams, this.editor.selected, this.editor.ticked);
    if (this.viewer) this.draw(this.viewer);
  }

  draw(viewer) {
    for (const layer of [...LAYERS, "chosen"]) viewer.clear(layer);
    const { state, selected } = this.editor;
    state.seams.forEach((seam, row) => {
      const { p, s } = state.frames[row];
      viewer.addPaths(layerOf(seam), [{ points: p, color: seam.accepted ? ACCEPTED : REFUSED }], {
        width: seam.accepted ? 6 : 3,
      });
      viewer.addTargets(layerOf(seam), p, { seam, row, s });
      const middle = p[Math.floor(p.length / 2)];
      if (seam.accepted) viewer.addLabels("names", [{ p: middle, text: seam.name }], { className: "of-seam" });
    });
    if (selected !== null) this.mark(viewer, selected);
  }

  /** A line over the chosen seam, and a point where it starts. */
  mark(viewer, row) {
    const { seams, frames } = this.editor.state;
    const { p } = frames[row];
    const places = placesAlong(frames[row]);
    viewer.addTargets("chosen", places.p, { seam: seams[row], row, s: places.s }, { priority: 1 });
    viewer.addPaths("chosen", [{ points: p, color: CHOSEN }], { width: 9, opacity: 0.6 });
    viewer.addPoints("chosen", [{ p: p[0], color: CHOSEN }], { size: 14 });
  }

  choose(row) {
    this.editor.select(row);
    if (this.viewer) lookAtSeam(this.viewer, this.editor.state.frames[row]);
  }

  look(row) {
    const box = this.view.querySelector(`input[data-layer="${layerOf(this.editor.state.seams[row])}"]`);
    if (box && !box.checked) box.click();
    this.show();
    this.view.scrollIntoView({ behavior: "smooth", block: "nearest" });
  }
}

function layerOf({ accepted }) {
  return accepted ? "seams" : "candidates";
}

function words(seam) {
  return el(
    "div",
    {},
    el("strong", {}, seam.name),
    facts([
      ["joint", `${seam.joint}, ${seam.weld}`],
      ["joins", seam.solids.join(" + ")],
      ["length", `${fixed(seam.length_mm)} mm`],
      ["confidence", `${Math.round(100 * seam.confidence)} %`],
      ["verdict", verdictOf(seam)],
    ]),
  );
}

async function main() {
  const { record, file } = readData();
  const [frames, part] = await Promise.all([readJsonBlob("frames"), readBlob("part")]);
  const page = new SeamsPage(document.getElementById("page"), { file, record, frames, part });
  window.wpcal = { viewer: page.viewer, project: (p) => page.viewer.project(p), ready: true };
}

main();
