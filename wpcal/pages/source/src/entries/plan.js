// A planned weld of two robots: plan.html.
import { el } from "../dom.js";
import { buildCurves } from "../plan/curves.js";
import { buildFront } from "../plan/front.js";
import { buildHeader } from "../plan/header.js";
import { buildPlayer } from "../plan/player.js";
import { buildScene } from "../plan/scene.js";
import { stateAt } from "../plan/times.js";
import { buildOrSayWhy } from "../stage.js";
import { readBlob, readData, readJsonBlob } from "../viewer.js";

/** The curves of one plan, and the frames of all bodies as [state][carrier][3×4]. */
async function loadPlan(row, cache) {
  if (!cache.has(row)) {
    const [curves, frames] = await Promise.all([readJsonBlob(`curves-${row}`), readBlob(`frames-${row}`)]);
    cache.set(row, { ...curves, frames: new Float32Array(frames) });
  }
  return cache.get(row);
}

async function main() {
  const data = readData();
  const part = await readBlob("part");
  const cache = new Map();
  const header = buildHeader(data);
  const view = el("section", { id: "view", "aria-label": "the cell in 3-D" });
  const curves = buildCurves(data, (t) => player.seek(t));
  const front = buildFront(data, (row) => select(row));
  const player = buildPlayer((t) => showTime(t));
  document
    .getElementById("page")
    .append(header.element, el("div", { class: "side-by-side" }, view, front.element), curves.element);
  const scene = buildOrSayWhy(view, () => buildScene(view, data, part));
  view.append(player.element);
  let shown = null;

  function showTime(t) {
    const at = stateAt(shown.t, t);
    scene?.pose(shown.frames, at);
    curves.cursor(t);
    player.say(placeText(shown, at));
  }

  async function select(row) {
    shown = await loadPlan(row, cache);
    header.show(row);
    front.show(row);
    curves.show(shown);
    scene?.seam(shown.seam);
    player.load(shown.t.at(-1), shown.t[shown.first]);
    window.wpcal = {
      viewer: scene?.viewer,
      project: (p) => scene.viewer.project(p),
      plan: row,
      seek: player.seek,
      ready: true,
    };
  }
  await select(data.chosen);
  scene?.whole();
}

function placeText(plan, { row, part }) {
  const [from, to] = [plan.s[row], plan.s[row + 1]];
  if (from === null || to === null) return row < plan.first ? "moving to the seam" : "leaving the seam";
  return `s = ${(from + part * (to - from)).toFixed(1)} mm`;
}

main();
