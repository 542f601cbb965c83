// The page of `wpcal seams --html`: the seams of a part, the candidates that were rejected, and the reasons.
import { sides, toggles, tooltip } from "../controls.js";
import { el, facts, fixed, table } from "../dom.js";
import { lookAtSeam } from "../report/scene.js";
import { buildOrSayWhy, buildStage, seeThroughBox } from "../stage.js";
import { cutControl, measureBox } from "../view_tools.js";
import { readBlob, readData, readJsonBlob } from "../viewer.js";
import { plural } from "../words.js";

const ACCEPTED = "#c2410c";
const REJECTED = "#8a94a0";

async function main() {
  const { seams, file } = readData();
  const [frames, part] = await Promise.all([readJsonBlob("frames"), readBlob("part")]);
  const root = document.getElementById("page");
  const accepted = seams.filter((seam) => seam.accepted).length;
  const said = `${plural(accepted, "seam")} accepted, ${plural(seams.length - accepted, "candidate")} rejected`;
  const view = el("section", { id: "view", "aria-label": "3-D view" });
  root.append(el("header", {}, el("h1", {}, file), el("p", { "data-test": "count" }, said)), view);
  const viewer = buildOrSayWhy(view, () => build(view, { seams, frames, part }));
  const focus = (row) => {
    const box = view.querySelector(`input[data-layer="${layerOf(seams[row])}"]`);
    if (box && !box.checked) box.click();
    if (viewer) lookAtSeam(viewer, frames[row]);
    view.scrollIntoView({ behavior: "smooth" });
  };
  root.append(el("section", { id: "seams" }, list(seams, focus)));
  window.wpcal = { viewer, project: (p) => viewer.project(p), ready: true };
}

function layerOf({ accepted }) {
  return accepted ? "seams" : "candidates";
}

function build(host, { seams, frames, part }) {
  const { viewer, stage } = buildStage(host, "3-D view of the part and its seams");
  const solid = part && viewer.addPart(part, {});
  seams.forEach((seam, row) => {
    const { p } = frames[row];
    const path = { points: p, color: seam.accepted ? ACCEPTED : REJECTED };
    viewer.addPaths(layerOf(seam), [path], { width: seam.accepted ? 6 : 3 });
    viewer.addTargets(layerOf(seam), p, { seam });
    const middle = p[Math.floor(p.length / 2)];
    if (seam.accepted) viewer.addLabels("names", [{ p: middle, text: seam.name }], { className: "of-seam" });
  });
  const tip = tooltip(stage);
  viewer.onHover((found) => (found ? tip.show(words(found.data.seam), found) : tip.hide()));
  const layers = [
    part && { label: "part", layers: ["part"], on: true },
    part && { label: "edges", layers: ["part edges"], on: true },
    { label: "seams", layers: ["seams"], on: true },
    { label: "rejected", layers: ["candidates"], on: false },
    { label: "names", layers: ["names"], on: true },
  ].filter(Boolean);
  host.append(
    el(
      "div",
      { class: "panel" },
      toggles(viewer, layers),
      part && seeThroughBox(solid),
      measureBox(viewer),
      part && cutControl(viewer),
    ),
  );
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
      ["confidence", `${Math.round(100 * seam.confidence)} %`],
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
    { title: "confidence", number: true, cell: ({ confidence }) => `${Math.round(100 * confidence)} %` },
    { title: "reasons against it", cell: ({ against }) => against.join("; ") },
  ];
  const row = (seam) => ({ class: seam.accepted ? "link" : "link dim", onclick: () => focus(seams.indexOf(seam)) });
  return table(columns, seams, { rowOf: row });
}

main();
