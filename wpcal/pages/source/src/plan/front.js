// The plans between which one chooses: a chart to click in, and a table of the same.
import { colourOf, ramp } from "../viewer.js";
import { el, fixed, short, svg, table } from "../dom.js";
import { linear } from "./chart.js";

const [WIDTH, HEIGHT, LEFT, RIGHT, TOP, BOTTOM] = [520, 330, 62, 18, 16, 46];
const RADIUS = 7;

/** An objective as people write it: "motion, deg/mm". */
function titleOf({ label, unit }) {
  return `${label}, ${unit}`;
}

/** Returns {element, show(row)}; `onPick(row)` is called for a click. */
export function buildFront(data, onPick) {
  const { plans, objectives } = data;
  const [xAxis, yAxis] = [objectives[0], objectives.at(-1)];
  const third = objectives.length > 2 ? objectives[1] : null;
  const values = ({ name }) => plans.map((plan) => plan.objectives[name]);
  const behind = data.fronts.flatMap((front) => front.values);
  const x = linear(padded([...values(xAxis), ...behind.map((row) => row[0])]), [LEFT, WIDTH - RIGHT]);
  const y = linear(padded([...values(yAxis), ...behind.map((row) => row.at(-1))]), [HEIGHT - BOTTOM, TOP]);
  const shades = third ? shadesOf(values(third)) : plans.map(() => colourOf(0));
  const marks = plans.map((plan, row) => mark(plan, row, x.at(plan.objectives[xAxis.name]), y.at(plan.objectives[yAxis.name]), shades[row], onPick));
  const chart = svg("svg", { class: "chart front", viewBox: `0 0 ${WIDTH} ${HEIGHT}`, role: "group", "aria-label": "the front" }, axes(x, y, xAxis, yAxis), data.fronts.map((front, i) => crosses(front, i, x, y)), marks);
  const rows = [];
  const list = table(columns(objectives), plans.map((plan, row) => ({ plan, row })), { rowOf: ({ row }) => ({ "data-row": row, tabindex: 0, class: "link" }) });
  for (const line of list.querySelectorAll("tbody tr")) {
    const row = Number(line.dataset.row);
    rows[row] = line;
    line.addEventListener("click", () => onPick(row));
    line.addEventListener("keydown", (event) => event.key === "Enter" && onPick(row));
  }
  const element = el("section", { id: "front" }, el("h2", {}, "Plans"), chart, third && legend(third, values(third)), data.fronts.map(found), list);
  return {
    element,
    show(chosen) {
      marks.forEach((node, row) => node.classList.toggle("chosen", row === chosen));
      rows.forEach((node, row) => node.classList.toggle("chosen", row === chosen));
      list.scrollTop = rows[chosen].offsetTop - list.clientHeight / 2;
    },
  };
}

/** What one method found by itself, as small crosses behind the plans. */
function crosses({ name, values }, i, x, y) {
  const cross = (row) => {
    const [px, py] = [x.at(row[0]), y.at(row.at(-1))];
    const d = i === 0 ? `M ${px - 4} ${py} h 8 M ${px} ${py - 4} v 8` : `M ${px - 3} ${py - 3} l 6 6 M ${px + 3} ${py - 3} l -6 6`;
    return svg("path", { d });
  };
  return svg("g", { class: "found", "data-series": i, "data-front": name }, svg("title", {}, `found by ${name}`), values.map(cross));
}

function found({ name, values, hypervolume }, i) {
  const text = `${values.length} plans by itself, hypervolume ${fixed(hypervolume, 1)}`;
  return el("p", { class: "names" }, el("span", { class: "name", "data-series": i }, i === 0 ? "+ " : "× ", name), text);
}

function columns(objectives) {
  return [
    { title: "plan", cell: ({ row }) => String(row + 1) },
    ...objectives.map((one) => ({ title: titleOf(one), number: true, cell: ({ plan }) => short(plan.objectives[one.name]) })),
    { title: "margin, mm", number: true, cell: ({ plan }) => (plan.check?.between ? short(plan.check.least_margin_mm) : "–") },
    { title: "path", cell: ({ plan }) => plan.freedom },
    { title: "found by", cell: ({ plan }) => plan.found_by },
  ];
}

function padded(values) {
  const [low, high] = [Math.min(...values), Math.max(...values)];
  const air = (high - low || Math.abs(high) || 1) * 0.08;
  return [low - air, high + air];
}

function shadesOf(values) {
  const [low, high] = [Math.min(...values), Math.max(...values)];
  return values.map((value) => colourOf((value - low) / (high - low || 1)));
}

/** A disc for a path of the ladder, a diamond for any other; hollow where the path is not known to be free. */
function mark(plan, row, px, py, shade, onPick) {
  const shape = { class: "shape", fill: plan.freedom === "free" ? shade : "none", stroke: shade };
  const drawn =
    plan.found_by === "ladder"
      ? svg("circle", { ...shape, cx: px, cy: py, r: RADIUS })
      : svg("path", { ...shape, d: `M ${px} ${py - RADIUS - 2} l ${RADIUS + 1} ${RADIUS + 2} l ${-RADIUS - 1} ${RADIUS + 2} l ${-RADIUS - 1} ${-RADIUS - 2} z` });
  const halo = svg("circle", { class: "halo", cx: px, cy: py, r: RADIUS + 5 });
  const text = `plan ${row + 1}, ${plan.freedom}`;
  const node = svg("g", { class: "plan", tabindex: 0, role: "button", "aria-label": text, "data-plan": row }, halo, drawn, svg("title", {}, text));
  node.addEventListener("click", () => onPick(row));
  node.addEventListener("keydown", (event) => event.key === "Enter" && onPick(row));
  return node;
}

function axes(x, y, xAxis, yAxis) {
  const [right, bottom] = [WIDTH - RIGHT, HEIGHT - BOTTOM];
  return [
    ...y.ticks.map((v) => svg("line", { class: "grid", x1: LEFT, x2: right, y1: y.at(v), y2: y.at(v) })),
    ...y.ticks.map((v) => svg("text", { x: LEFT - 8, y: y.at(v) + 4, "text-anchor": "end" }, short(v))),
    ...x.ticks.map((v) => svg("line", { class: "grid", x1: x.at(v), x2: x.at(v), y1: TOP, y2: bottom })),
    ...x.ticks.map((v) => svg("text", { x: x.at(v), y: bottom + 18, "text-anchor": "middle" }, short(v))),
    svg("line", { class: "base", x1: LEFT, x2: right, y1: bottom, y2: bottom }),
    svg("text", { x: (LEFT + right) / 2, y: HEIGHT - 6, "text-anchor": "middle" }, titleOf(xAxis)),
    svg("text", { transform: `translate(14 ${(TOP + bottom) / 2}) rotate(-90)`, "text-anchor": "middle" }, titleOf(yAxis)),
  ];
}

function legend(objective, values) {
  const bar = el("span", { class: "ramp" });
  bar.style.background = ramp();
  const [low, high] = [Math.min(...values), Math.max(...values)].map(short);
  return el("p", { class: "colours" }, el("span", {}, titleOf(objective)), el("span", {}, low), bar, el("span", {}, high), el("span", {}, "disc: ladder, diamond: other; hollow: not known to be free"));
}
