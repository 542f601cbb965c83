// The cell in 3-D. Every body is in a layer of the frame that carries it; a pose moves the layers.
import { sides, toggles } from "../controls.js";
import { el } from "../dom.js";
import { buildStage } from "../stage.js";
import { cutControl, measureTool } from "../view_tools.js";
import { capsuleMesh } from "./capsule.js";

const NUMBERS = 12; // per frame: three rows of four
const COLOURS = { robot1: "#4f7cac", torch: "#c9742d", robot2: "#6b9a74", part: "#c3ccd6", bench: "#97897a" };
const SEAM = "#d6246e";
const OTHER_SEAM = "#1f7a3d";
const TIP = "#ffb000";
const WIRE = "#b98a2f";
const GRID_MM = 250;
const GRID_COLOUR = "#8a94a0";
const GRID_REACH_MM = 500; // beyond the bases
const BESIDE_MM = 300; // from a base to its label: beyond a pedestal
const AXIS_MM = 200; // of a drawn frame
const AXIS_COLOURS = ["#c8102e", "#2e8b57", "#1f5fbf"];
const MOUNT = "#7a3e9d";
const MOUNT_MM = 180; // half of a side
const FROM = [-0.35, -0.85, 0.4]; // on the side of the torch, a little above

/** Builds the view inside `host`; returns {viewer, whole(), pose(frames, {row, part}), seam(points)}. */
export function buildScene(host, data, part) {
  const label = "3-D view of the robots, the torch and the part";
  const { viewer, stage } = buildStage(host, label);
  const carried = new Map(); // layer -> carrier
  data.bodies.forEach((body) => addBody(viewer, body, carried, part !== null));
  if (part) {
    viewer.addPart(part);
    ["part", "part edges"].forEach((layer) => carried.set(layer, data.carriers.part));
  }
  viewer.addPaths(
    "wire",
    [
      {
        points: [
          [0, 0, 0],
          [0, 0, -data.wire_mm],
        ],
        color: WIRE,
      },
    ],
    { width: 3 },
  );
  viewer.addPoints("tip", [{ p: [0, 0, 0], color: TIP }], { size: 11 });
  ["wire", "tip"].forEach((layer) => carried.set(layer, data.carriers.tool));
  carried.set("seam", data.carriers.part);
  addFloor(viewer, data.bases, data.floor_z_mm);
  addFrames(viewer, data, carried);
  viewer.addLabels(
    "names",
    data.bases.map((p, i) => ({ p: [p[0], p[1] - BESIDE_MM, data.floor_z_mm], text: data.labels[`robot${i + 1}`] })),
  );
  const near = ["tip", "seam", "part", ...data.bodies.filter((body) => body.group === "part").map(layerOf)];
  const bodies = ["part", ...new Set(data.bodies.map(layerOf))];
  const closer = el(
    "button",
    { type: "button", "data-test": "closer", onclick: () => viewer.view(FROM, near) },
    "torch",
  );
  const looks = sides(viewer);
  looks.append(closer);
  stage.append(looks);
  const measure = measureTool(viewer);
  const cut = cutControl(viewer, { layers: bodies, what: "the cell" });
  host.append(el("div", { class: "panel" }, toggles(viewer, layersOf(data, part)), measure.element, cut));
  return {
    viewer,
    whole: () => viewer.view(FROM, bodies),
    pose(frames, at) {
      measure.forget(); // the places that were clicked are elsewhere now
      pose(viewer, carried, frames, data.carriers.count, at);
    },
    seam(points) {
      viewer.clear("seam");
      viewer.addPaths("seam", [{ points, color: SEAM }], { width: 4 });
    },
    /** All seams as lines; the one in row `chosen` stands out. */
    seams(lines, chosen) {
      viewer.clear("seam");
      viewer.addPaths(
        "seam",
        lines.map((points, row) => ({ points, color: row === chosen ? SEAM : OTHER_SEAM })),
        { width: 4 },
      );
    },
  };
}

function layerOf(body) {
  return `${body.group}@${body.carrier}`;
}

function addBody(viewer, body, carried, hasPart) {
  if (body.group === "part" && hasPart) return;
  const layer = layerOf(body);
  const color = COLOURS[body.group];
  carried.set(layer, body.carrier);
  if (body.hull) viewer.addMesh(layer, { positions: body.hull.positions, indices: body.hull.indices.flat(), color });
  else body.capsules.forEach(({ p, q, radius }) => viewer.addMesh(layer, { ...capsuleMesh(p, q, radius), color }));
}

function layersOf(data, part) {
  const of = (group) => [...new Set(data.bodies.filter((body) => body.group === group).map(layerOf))];
  const items = [
    { label: data.labels.robot1, layers: of("robot1"), on: true },
    { label: "torch", layers: [...of("torch"), "wire", "tip"], on: true },
    { label: data.labels.robot2, layers: of("robot2"), on: true },
    { label: "part", layers: part ? ["part", "part edges"] : of("part"), on: true },
    { label: "bench", layers: of("bench"), on: true },
    { label: "seam", layers: ["seam"], on: true },
    { label: "floor", layers: ["floor"], on: true },
    { label: "frames", layers: data.frames.map(frameLayer), on: data.showsFrames },
    { label: "mounting faces", layers: ["mounting faces"], on: data.showsFrames },
  ];
  return items.filter(({ layers }) => layers.length > 0);
}

function frameLayer(carrier) {
  return `frame@${carrier}`;
}

/** Axes of some carriers (x red, y green, z blue), and a square around each mounting face. */
function addFrames(viewer, { frames, mounts }, carried) {
  for (const carrier of frames) {
    const axes = AXIS_COLOURS.map((color, i) => {
      const end = [0, 0, 0];
      end[i] = AXIS_MM;
      return { points: [[0, 0, 0], end], color };
    });
    viewer.addPaths(frameLayer(carrier), axes, { width: 3 });
    carried.set(frameLayer(carrier), carrier);
  }
  const squares = mounts.map(({ p, x, y }) => {
    const corner = (a, b) => p.map((value, i) => value + MOUNT_MM * (a * x[i] + b * y[i]));
    return { points: [corner(-1, -1), corner(1, -1), corner(1, 1), corner(-1, 1), corner(-1, -1)], color: MOUNT };
  });
  viewer.addPaths("mounting faces", squares, { width: 3 });
}

/** Lines on the floor around both bases. */
function addFloor(viewer, bases, z) {
  const range = (axis) => {
    const values = bases.map((p) => p[axis]);
    const low = Math.floor((Math.min(...values) - GRID_REACH_MM) / GRID_MM);
    const high = Math.ceil((Math.max(...values) + GRID_REACH_MM) / GRID_MM);
    return Array.from({ length: high - low + 1 }, (_, i) => (low + i) * GRID_MM);
  };
  const [xs, ys] = [range(0), range(1)];
  const lines = [
    ...xs.map((x) => [
      [x, ys[0], z],
      [x, ys.at(-1), z],
    ]),
    ...ys.map((y) => [
      [xs[0], y, z],
      [xs.at(-1), y, z],
    ]),
  ];
  viewer.addPaths(
    "floor",
    lines.map((points) => ({ points, color: GRID_COLOUR })),
    { width: 1, opacity: 0.35 },
  );
}

/** Moves every layer to where its carrier is between two states. */
function pose(viewer, carried, frames, count, { row, part }) {
  const states = frames.length / (count * NUMBERS);
  const next = Math.min(row + 1, states - 1);
  for (const [layer, carrier] of carried) {
    const [a, b] = [row, next].map((state) => (state * count + carrier) * NUMBERS);
    const T = Array.from({ length: NUMBERS }, (_, i) => (1 - part) * frames[a + i] + part * frames[b + i]);
    viewer.move(layer, [...T, 0, 0, 0, 1]);
  }
}
