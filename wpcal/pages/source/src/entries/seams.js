// What `wpcal seams --html` writes: the seams found on a part, those that were not taken, and why.

import { sides, toggles, tooltip } from "../controls.js";
import { el, facts, fixed, table } from "../dom.js";
import { lookAtSeam } from "../report/scene.js";
import { createViewer, readBlob, readData, readJsonBlob } from "../viewer.js";

const TAKEN = "#c2410c";
const REFUSED = "#8a94a0";

async function main() {
  const { seams, file } = readData();
  const [frames, part] = await Promise.all([readJsonBlob("frames"), readBlob("part")]);
  const root = document.getElementById("page");
  const taken = seams.filter(({ accepted }) => accepted);
  const said = `${taken.length} seams taken, ${seams.length - taken.length} candidates not taken`;
  const view = el("section", { id: "view", "aria-label": "3-D view" });
  root.append(el("header", {}, el("h1", {}, file), el("p", { "data-test": "count" }, said)), view);
  const viewer = build(view, { seams, frames, part });
  const focus = (row) => {
    const box = view.querySelector(`input[data-layer="${layerOf(seams[row])}"]`);
    if (box && !box.checked) box.click();
    lookAtSeam(viewer, frames[row]);
    view.scrollIntoView({ behavior: "smooth" });
  };
  root.append(el("section", { id: "seams" }, list(seams, focus)));
  window.wpcal = { viewer, project: (p) => viewer.project(p), ready: true };
}

function layerOf({ accepted }) {
  return accepted ? "seams" : "candidates";
}

function build(host, { seams, frames, part }) {
  const canvas = el("canvas", { tabindex: 0, "aria-label": "3-D view of the part and its seams" });
  const overlay = el("div", { class: "overlay" });
  const stage = el("div", { class: "stage" }, canvas, overlay);
  host.append(stage);
  const dark = matchMedia("(prefers-color-scheme: dark)").matches;
  const viewer = createViewer(canvas, { overlay, theme: dark ? "dark" : "light" });
  const solid = part && viewer.addPart(part, {});
  seams.forEach((seam, row) => {
    const { p } = frames[row];
    const path = { points: p, color: seam.accepted ? TAKEN : REFUSED };
    viewer.addPaths(layerOf(seam), [path], { width: seam.accepted ? 6 : 3 });
    viewer.addTargets(layerOf(seam), p, { seam });
    const middle = p[Math.floor(p.length / 2)];
    if (seam.accepted) viewer.addLabels("names", [{ p: middle, text: seam.name }], { className: "of-seam" });
  });
  const tip = tooltip(stage);
  viewer.onHover((found) => (found ? tip.show(words(found.data.seam), found) : tip.hide()));
  const xray = el("input", { type: "checkbox", onchange: () => solid.setOpacity(xray.checked ? 0.35 : 1) });
  const layers = [
    part && { label: "part", layers: ["part"], on: true },
    part && { label: "edges", layers: ["part edges"], on: true },
    { label: "seams", layers: ["seams"], on: true },
    { label: "not taken", layers: ["candidates"], on: false },
    { label: "names", layers: ["names"], on: true },
  ].filter(Boolean);
  const alone = part && el("label", { class: "toggle-alone" }, xray, el("span", {}, "see through"));
  host.append(el("div", { class: "panel" }, toggles(viewer, layers), alone));
  stage.append(sides(viewer));
  viewer.view("iso");
  return viewer;
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
      ["sure", `${Math.round(100 * seam.confidence)} %`],
      ...seam.against.map((reason) => ["against", reason]),
    ]),
  );
}

function list(seams, focus) {
  const columns = [
    { title: "seam", cell: ({ name }) => name },
    { title: "joint", cell: ({ joint }) => joint },
    { title: "weld", cell: ({ weld }) => weld },
    { title: "joins", cell: ({ solids }) => solids.join(" + ") },
    { title: "length mm", number: true, cell: ({ length_mm }) => fixed(length_mm) },
    { title: "sure", number: true, cell: ({ confidence }) => `${Math.round(100 * confidence)} %` },
    { title: "what speaks against it", cell: ({ against }) => against.join("; ") },
  ];
  const row = (seam) => ({ class: seam.accepted ? "link" : "link dim", onclick: () => focus(seams.indexOf(seam)) });
  return table(columns, seams, { rowOf: row });
}

main();
