// A sequence of one robot over all seams: plan.html.
import { el, fixed, table } from "../dom.js";
import { buildPlayer } from "../plan/player.js";
import { buildScene } from "../plan/scene.js";
import { timeChart } from "../plan/time_chart.js";
import { rowAt, stateAt } from "../plan/times.js";
import { buildOrSayWhy } from "../stage.js";
import { readBlob, readData, readJsonBlob } from "../viewer.js";

const CLASSES = { free: "pass", "not free": "fail" };

async function main() {
  const data = readData();
  const [part, curves, raw] = await Promise.all([readBlob("part"), readJsonBlob("curves"), readBlob("frames")]);
  const frames = new Float32Array(raw);
  const view = el("section", { id: "view", "aria-label": "the cell in 3-D" });
  const list = el("section", { id: "front" });
  const charts = buildCharts(data, curves, (t) => player.seek(t));
  const player = buildPlayer((t) => showTime(t));
  document
    .getElementById("page")
    .append(header(data), el("div", { class: "side-by-side" }, view, list), charts.element);
  const scene = buildOrSayWhy(view, () => buildScene(view, data, part));
  view.append(player.element);
  const lines = data.seams.map(({ points }) => points);
  let shown = null;

  function choose(row) {
    if (row === shown) return;
    shown = row;
    scene?.seams(lines, row);
    list.replaceChildren(...seams(data, row, player), ...unwelded(data), ...plans(data));
  }

  function showTime(t) {
    const at = stateAt(curves.t, t);
    scene?.pose(frames, at);
    charts.cursor(t);
    choose(curves.piece[rowAt(curves.t, t)]);
    player.say(placeText(data, curves, at));
  }

  player.load(curves.t.at(-1), data.seams[0].from_s);
  scene?.whole();
  window.wpcal = { viewer: scene?.viewer, seek: player.seek, ready: true };
}

function header(data) {
  const welded = data.seams.reduce((sum, { length }) => sum + length, 0);
  const title = el(
    "div",
    { class: "title" },
    el("p", { class: "eyebrow" }, "one robot, all seams"),
    el("h1", {}, data.cell),
    el("p", {}, `${fixed(welded, 0)} mm welded in ${data.seams.length} pieces`),
  );
  if (data.issues.length)
    title.append(
      el(
        "ul",
        { class: "issues", "data-test": "issues" },
        data.issues.map(({ message }) => el("li", {}, message)),
      ),
    );
  // what is open comes first; only a plan without an open point is large and green
  const isOpen = data.freedom === "free" && data.open.length > 0;
  const word = isOpen ? data.open[0].split(":")[0] : data.freedom.toUpperCase();
  const verdict = el("div", { class: "verdict" }, el("p", { class: "stamp", "data-test": "freedom" }, word));
  const items = data.open.map((text) => el("li", {}, text));
  if (items.length) verdict.append(el("ul", { class: "issues", "data-test": "open" }, items));
  verdict.append(el("p", { "data-test": "checked" }, `moves: ${data.freedom}; ${data.checked}`));
  return el("header", { class: isOpen ? "open" : CLASSES[data.freedom] }, title, verdict);
}

/** The seams in the order of welding; a click goes to the start of one. */
function seams(data, chosen, player) {
  const angle = (value) => (value === null ? "" : fixed(value, 0));
  const columns = [
    { title: "seam", cell: ({ name, reversed }) => (reversed ? `${name} (reversed)` : name) },
    { title: "mm", number: true, cell: ({ length }) => fixed(length, 0) },
    { title: "slope", number: true, cell: ({ slope }) => angle(slope) },
    { title: "rotation", number: true, cell: ({ rotation }) => angle(rotation) },
    { title: "off position", number: true, cell: ({ off }) => `${angle(off)}${off > data.tolerance ? " !" : ""}` },
    { title: "margin, mm", number: true, cell: ({ margin }) => fixed(margin, 1) },
    { title: "moves from home, to home", cell: ({ alone }) => alone.map((n) => (n < 0 ? "none" : n)).join(", ") },
    { title: "from, s", number: true, cell: ({ from_s }) => fixed(from_s, 1) },
  ];
  const rowOf = (seam) => ({
    class: seam === data.seams[chosen] ? "link chosen" : "link",
    onclick: () => player.seek(seam.from_s),
  });
  return [el("h2", {}, "Seams in the order of welding"), table(columns, data.seams, { rowOf })];
}

function unwelded({ unwelded: rows }) {
  if (!rows.length) return [];
  const items = rows.map((text) => el("li", {}, text));
  return [el("h2", {}, "Not welded"), el("ul", { class: "issues", "data-test": "unwelded" }, items)];
}

function plans({ plans: rows }) {
  const columns = [
    { title: "plan", cell: ({ name, chosen }) => (chosen ? `${name} *` : name) },
    { title: "off position, deg", number: true, cell: ({ position_deg }) => fixed(position_deg, 1) },
    { title: "torch, deg", number: true, cell: ({ torch_deg }) => fixed(torch_deg, 1) },
    { title: "motion, deg/mm", number: true, cell: ({ motion_deg_per_mm }) => fixed(motion_deg_per_mm, 3) },
    { title: "time, s", number: true, cell: ({ time_s }) => fixed(time_s, 0) },
  ];
  return [el("h2", {}, "Plans"), table(columns, rows)];
}

/** All axes, and the clearance; a shaded stretch from the first weld to the last. */
function buildCharts(data, curves, onSeek) {
  const common = { burns: [data.seams[0].from_s, data.seams.at(-1).to_s], onSeek };
  const axis = (i) => ({ name: data.axes[i], t: curves.t, values: curves.axes.map((q) => q[i]) });
  const arm = timeChart("Joints of the arm, deg", [0, 1, 2, 3, 4, 5].map(axis), common);
  const outer = data.axes.slice(6).map((_, i) => axis(i + 6));
  const limit = { value: 0, text: "safety distance" };
  const margin = [{ name: "margin, at least", t: curves.t, values: curves.margin }];
  const charts = [
    arm,
    ...(outer.length ? [timeChart("External axes, deg (rail: mm)", outer, common)] : []),
    timeChart("Clearance beyond the safety distance, mm", margin, { ...common, limit }),
  ];
  return {
    element: el("div", { class: "charts" }, ...charts.map((chart) => chart.element)),
    cursor: (t) => charts.forEach((chart) => chart.cursor(t)),
  };
}

function placeText(data, curves, { row, part }) {
  const piece = curves.piece[row + 1] ?? curves.piece[row];
  if (piece < 0) return "through the air";
  const name = data.seams[piece].name;
  const [from, to] = [curves.s[row], curves.s[row + 1]];
  if (from === null || to === null || to === undefined) return `${curves.phase[row + 1]}: ${name}`;
  return `${name}: s = ${fixed(from + part * (to - from), 1)} mm`;
}

main();
