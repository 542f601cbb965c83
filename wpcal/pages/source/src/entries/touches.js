// The page of a plan of touches: the part, its seams, the searches in their order, and what they promise.
import { sides, toggles, tooltip } from "../controls.js";
import { el, facts, fixed, table } from "../dom.js";
import { buildPlayer } from "../plan/player.js";
import { buildOrSayWhy, buildStage, seeThroughBox } from "../stage.js";
import { drawOrder, drawSearches, drawTool, SEARCH, toolPlace } from "../touches/drawing.js";
import { beginOf, placeAt, wayOf } from "../touches/way.js";
import { cutControl, measureTool } from "../view_tools.js";
import { readBlob, readData, readJsonBlob } from "../viewer.js";
import { plural } from "../words.js";

const SEAM = "#c2410c";
const LEAST_ARROW = 0.1; // of the radius of the part: on a large part, strokes are too short to be seen
const NOZZLE_PART = 0.12; // of the radius of the part: how long the nozzle is drawn
const JUST_AFTER_S = 1e-3; // the slider rounds its time
const WORDS = { end: "end of the wire", side: "side of the wire" };

class TouchesPage {
  constructor(root, { data, lines, part }) {
    Object.assign(this, { data, lines, way: wayOf(data), row: 0 });
    this.view = el("section", { id: "view", "aria-label": "3-D view" });
    this.list = el("section", { id: "searches" });
    this.player = buildPlayer((t) => this.showTime(t));
    root.append(header(data), this.view, el("div", { id: "lists" }, this.list, promises(data)));
    this.viewer = buildOrSayWhy(this.view, () => this.build(part));
    this.view.append(this.player.element);
    this.fill();
    if (data.searches.length) this.player.load(this.way.t.at(-1), beginOf(this.way, 0));
  }

  build(part) {
    const { searches, stick_out_mm } = this.data;
    const { viewer, stage } = buildStage(this.view, "3-D view of the part and the searches");
    const solid = part && viewer.addPart(part, {});
    const tip = tooltip(stage);
    viewer.onHover((found) => (found ? tip.show(words(searches[found.data]), found) : tip.hide()));
    viewer.onPick((found) => found && this.seek(found.data));
    for (const { name, p } of this.lines) {
      viewer.addPaths("seams", [{ points: p, color: SEAM }], { width: 5 });
      viewer.addLabels("seams", [{ p: p[Math.floor(p.length / 2)], text: name }], { className: "of-seam" });
    }
    drawSearches(viewer, searches, LEAST_ARROW * viewer.extent().radius);
    drawOrder(viewer, searches);
    viewer.view("iso");
    drawTool(viewer, "tool", stick_out_mm, NOZZLE_PART * viewer.extent(part ? ["part"] : null).radius);
    const layers = [
      part && { label: "part", layers: ["part"], on: true },
      part && { label: "edges", layers: ["part edges"], on: true },
      { label: "seams", layers: ["seams"], on: true },
      { label: "searches", layers: ["searches", "strokes"], on: true },
      { label: "ways", layers: ["ways", "retracts"], on: true },
      { label: "numbers", layers: ["numbers"], on: true },
      { label: "tool", layers: ["tool"], on: true },
    ].filter(Boolean);
    const tools = [part && seeThroughBox(solid), measureTool(viewer).element, part && cutControl(viewer)];
    this.view.append(el("div", { class: "panel" }, toggles(viewer, layers), tools));
    stage.append(sides(viewer));
    return viewer;
  }

  seek(row) {
    this.player.seek(beginOf(this.way, row) + JUST_AFTER_S);
  }

  showTime(t) {
    const { p, row, what } = placeAt(this.way, t);
    const search = this.data.searches[row];
    this.viewer?.move("tool", toolPlace(search.R, p));
    this.player.say(what === "to" ? `to ${search.name}` : `${search.name} ${what}`);
    if (row === this.row) return;
    this.row = row;
    this.mark();
  }

  mark() {
    for (const [row, line] of this.list.querySelectorAll("tbody tr").entries()) {
      line.classList.toggle("chosen", row === this.row);
    }
    this.viewer?.clear("chosen");
    const search = this.data.searches[this.row];
    if (search) this.viewer?.addPoints("chosen", [{ p: search.planned, color: SEARCH }], { size: 14 });
  }

  fill() {
    const { searches } = this.data;
    const number = (title, cell) => ({ title, number: true, cell });
    const columns = [
      number("", (search) => String(searches.indexOf(search) + 1)),
      { title: "touch", cell: ({ name }) => name },
      {
        title: "on",
        cell: ({ target, feature, kind }) => (kind === "post" ? "the post" : `${target} ${feature}`.trim()),
      },
      { title: "with", cell: ({ contact }) => WORDS[contact] },
      number("stroke mm", ({ stroke_mm }) => fixed(stroke_mm, 1)),
      number("to the border mm", ({ border_mm }) => fixed(border_mm, 1)),
      number("stored place ± mm", ({ error_95_mm }) => fixed(error_95_mm, 3)),
    ];
    const caption = "in the order of the program; ±: 95 %, along the search. Click a line to see the search.";
    const rowOf = (search) => ({
      class: "link",
      "data-name": search.name,
      onclick: () => this.seek(searches.indexOf(search)),
    });
    this.list.replaceChildren(el("h2", {}, "Searches"), table(columns, searches, { rowOf, caption }));
    this.mark();
  }
}

function header({ part, robot, searches, wire_mm, stick_out_mm, notes }) {
  const how = `wire ${fixed(wire_mm, 1)} mm, stick-out ${fixed(stick_out_mm, 1)} mm${robot && `, ${robot}`}`;
  const count = el("p", { "data-test": "count" }, `${plural(searches.length, "planned touch", "es")}; ${how}`);
  const list = notes.length
    ? el(
        "ul",
        {},
        notes.map((note) => el("li", {}, note)),
      )
    : null;
  return el("header", {}, [el("h1", {}, `Touches of ${part}`), count, list].filter(Boolean));
}

/** What the plan promises for every seam. */
function promises({ predicted }) {
  const nothing = el("p", {}, "The plan predicts no error of seams.");
  if (!predicted) return el("section", { id: "promises" }, nothing);
  const columns = [
    { title: "seam", cell: ({ seam }) => seam },
    { title: "95 % error mm", number: true, cell: ({ error_95_mm }) => fixed(error_95_mm, 3) },
  ];
  const most = `${fixed(predicted.error_95_mm, 3)} mm (95 %), on ${predicted.seam}`;
  const text = `Predicted error of the seams: at most ${most}`;
  return el("section", { id: "promises" }, el("h2", {}, text), table(columns, predicted.by_seam));
}

function words(search) {
  const { name, target, feature, contact, stroke_mm, border_mm, error_95_mm, contact_mm } = search;
  return el(
    "div",
    {},
    el("strong", {}, name),
    facts([
      ["on", `${target} ${feature}`],
      ["with", WORDS[contact]],
      ["stroke", `${fixed(stroke_mm, 1)} mm`],
      ["to the border", border_mm === null ? "–" : `${fixed(border_mm, 1)} mm`],
      ["stored place", `± ${fixed(error_95_mm, 3)} mm (95 %)`],
      ["model x, y, z", `${contact_mm.map((v) => fixed(v)).join(", ")} mm`],
    ]),
  );
}

async function main() {
  const [lines, part] = await Promise.all([readJsonBlob("lines"), readBlob("part")]);
  const page = new TouchesPage(document.getElementById("page"), { data: readData(), lines, part });
  window.wpcal = {
    viewer: page.viewer,
    project: (p) => page.viewer.project(p),
    seek: page.player.seek,
    ready: true,
  };
}

main();
