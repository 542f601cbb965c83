// The cell as its file describes it, and what is odd in it: cell.html.
import { el, fixed, table } from "../dom.js";
import { buildScene } from "../plan/scene.js";
import { buildOrSayWhy } from "../stage.js";
import { readBlob, readData } from "../viewer.js";

async function main() {
  const data = readData();
  const frames = new Float32Array(await readBlob("frames"));
  const view = el("section", { id: "view", "aria-label": "the cell in 3-D" });
  const lists = el("section", { id: "front" }, oddities(data), robots(data), bodies(data));
  document.getElementById("page").append(header(data), el("div", { class: "side-by-side" }, view, lists));
  const scene = buildOrSayWhy(view, () => buildScene(view, data, null));
  scene?.pose(frames, { row: 0, part: 0 });
  scene?.whole();
  window.wpcal = { viewer: scene?.viewer, ready: true };
}

function header({ cell, kind, pose, issues }) {
  const odd = issues.length > 0;
  const title = el("div", { class: "title" }, el("p", { class: "eyebrow" }, kind), el("h1", {}, cell));
  const text = odd ? `${issues.length} ODD` : "NOTHING ODD";
  const stamp = el("p", { class: "stamp", "data-test": "stamp" }, text);
  return el(
    "header",
    { class: odd ? "fail" : "pass" },
    title,
    el("div", { class: "verdict" }, stamp, el("p", {}, pose)),
  );
}

function oddities({ issues }) {
  if (!issues.length) return [el("h2", {}, "Odd"), el("p", {}, "nothing")];
  const items = issues.map(({ message }) => el("li", {}, message));
  return [el("h2", {}, "Odd"), el("ul", { class: "issues", "data-test": "issues" }, items)];
}

function robots({ robots: rows }) {
  const place = (p) => p.map((value) => fixed(value, 1)).join(", ");
  return [
    el("h2", {}, "Arms"),
    table(
      [
        { title: "robot", cell: ({ robot }) => String(robot) },
        { title: "arm", cell: ({ arm }) => arm },
        { title: "base frame, mm", cell: ({ base }) => place(base) },
        { title: "mounting face, mm", cell: ({ mount }) => place(mount) },
      ],
      rows,
    ),
  ];
}

function bodies({ bodies: rows, carrierNames }) {
  return [
    el("h2", {}, "Bodies"),
    table(
      [
        { title: "body", cell: ({ name }) => name },
        { title: "frame", cell: ({ carrier }) => carrierNames[carrier] },
        { title: "capsules", number: true, cell: ({ capsules }) => String(capsules.length) },
        { title: "corners of its hull", number: true, cell: ({ hull }) => String(hull ? hull.positions.length : 0) },
      ],
      rows,
    ),
  ];
}

main();
