// Charts as plain SVG.
import { fixed, short, svg } from "../dom.js";

const WIDTH = 560;
const HEIGHT = 250;
const LEFT = 58;
const RIGHT = 14;
const TOP = 14;
const BOTTOM = 42;
const TICKS = 5;

/** A scale from data to pixels, linear or logarithmic, with its ticks. */
function scale([low, high], [start, end], { log = false } = {}) {
  const [a, b] = log ? [Math.log10(low), Math.log10(high)] : [low, high];
  const at = (value) => start + (((log ? Math.log10(value) : value) - a) / (b - a || 1)) * (end - start);
  return { at, ticks: log ? decades(a, b) : roundSteps(low, high) };
}

function roundSteps(low, high) {
  const raw = (high - low || 1) / TICKS;
  const power = 10 ** Math.floor(Math.log10(raw));
  const step = [1, 2, 5, 10].map((factor) => factor * power).find((candidate) => candidate >= raw);
  const first = Math.ceil(low / step - 1e-9);
  const last = Math.floor(high / step + 1e-9);
  return Array.from({ length: last - first + 1 }, (_, i) => (first + i) * step);
}

function decades(a, b) {
  const [first, last] = [Math.ceil(a - 1e-9), Math.floor(b + 1e-9)];
  const step = Math.max(Math.ceil((last - first) / TICKS), 1);
  return Array.from({ length: Math.floor((last - first) / step) + 1 }, (_, i) => 10 ** (first + i * step));
}

/** Axes with titles around what `draw(x, y)` returns. */
function chart({ title, xTitle, yTitle, x, y, marks }) {
  const [right, bottom] = [WIDTH - RIGHT, HEIGHT - BOTTOM];
  const grid = [
    ...y.ticks.map((v) => svg("line", { class: "grid", x1: LEFT, x2: right, y1: y.at(v), y2: y.at(v) })),
    ...y.ticks.map((v) => svg("text", { class: "tick", x: LEFT - 8, y: y.at(v) + 4, "text-anchor": "end" }, short(v))),
    ...x.ticks.map((v) => svg("line", { class: "grid", x1: x.at(v), x2: x.at(v), y1: bottom, y2: bottom + 4 })),
    ...x.ticks.map((v) =>
      svg("text", { class: "tick", x: x.at(v), y: bottom + 18, "text-anchor": "middle" }, short(v)),
    ),
  ];
  const titles = [
    svg("text", { class: "axis", x: (LEFT + right) / 2, y: HEIGHT - 6, "text-anchor": "middle" }, xTitle),
    svg(
      "text",
      { class: "axis", transform: `translate(13 ${(TOP + bottom) / 2}) rotate(-90)`, "text-anchor": "middle" },
      yTitle,
    ),
  ];
  const box = { viewBox: `0 0 ${WIDTH} ${HEIGHT}`, role: "img", "aria-label": title, class: "chart" };
  return svg(
    "svg",
    box,
    grid,
    svg("line", { class: "base", x1: LEFT, x2: right, y1: bottom, y2: bottom }),
    titles,
    marks,
  );
}

function polyline(xs, ys, x, y, attributes) {
  const corners = xs.map((v, i) => `${x.at(v).toFixed(1)},${y.at(ys[i]).toFixed(1)}`);
  return svg("polyline", { ...attributes, points: corners.join(" ") });
}

function level(value, y, text, className) {
  return [
    svg("line", { class: className, x1: LEFT, x2: WIDTH - RIGHT, y1: y.at(value), y2: y.at(value) }),
    svg("text", { class: `note ${className}`, x: WIDTH - RIGHT, y: y.at(value) - 5, "text-anchor": "end" }, text),
  ];
}

/** Predicted error along every accepted seam; `pick` is called with the row of a seam whose line is clicked. */
export function errorPlot(seams, frames, tolerance) {
  const shown = seams.map((seam, row) => ({ seam, ...frames[row] })).filter(({ seam, u95 }) => seam.accepted && u95);
  if (!shown.length) return null;
  const highest = Math.max(...shown.flatMap(({ u95 }) => Math.max(...u95)), tolerance) * 1.12;
  const x = scale([0, Math.max(...shown.map(({ s }) => s.at(-1)))], [LEFT, WIDTH - RIGHT]);
  const y = scale([0, highest], [HEIGHT - BOTTOM, TOP]);
  const lines = shown.map(
    ({ seam, s, u95 }, i) =>
      polyline(s, u95, x, y, { class: "series", "data-series": i % 6 }).appendChild(svg("title", {}, seam.name))
        .parentNode,
  );
  const names = shown.length > 8 ? [] : endLabels(shown, x, y);
  const marks = [...level(tolerance, y, `tolerance ${short(tolerance)} mm`, "limit"), ...lines, ...names];
  return chart({
    title: "95 % error along the seams",
    xTitle: "arc length, mm",
    yTitle: "95 % error, mm",
    x,
    y,
    marks,
  });
}

/** The name of each seam over its end; names that would touch are pushed up. */
function endLabels(shown, x, y) {
  const taken = [];
  return shown.map(({ seam, s, u95 }, i) => {
    const [px, anchor] = [x.at(s.at(-1)), s.at(-1) > 0 && x.at(s.at(-1)) > WIDTH - 60 ? "end" : "start"];
    let py = y.at(u95.at(-1)) - 6;
    while (taken.some(([ox, oy]) => Math.abs(ox - px) < 44 && Math.abs(oy - py) < 12)) py -= 12;
    taken.push([px, py]);
    return svg("text", { class: "note", "data-series": i % 6, x: px, y: py, "text-anchor": anchor }, seam.name);
  });
}

/** The annealer's largest distance at the end of each temperature, and the best so far: the paper's figure 2. */
export function annealingPlot({ temperature_mm: T, f_mm: f, best_f_mm: best }, objective) {
  const low = Math.min(...best.filter((v) => v > 0), objective || Infinity) / 1.5;
  if (!Number.isFinite(low)) return null; // nothing above zero: nothing to show on a logarithmic scale
  const positive = (values) => values.map((v) => Math.max(v, low));
  const x = scale([T[0], T.at(-1)], [LEFT, WIDTH - RIGHT], { log: true });
  x.ticks = decades(Math.log10(T.at(-1)), Math.log10(T[0]));
  const y = scale([low, Math.max(...f) * 1.5], [HEIGHT - BOTTOM, TOP], { log: true });
  const marks = [
    ...(objective > 0 ? level(objective, y, `answer ${fixed(objective, 4)} mm`, "answer") : []),
    polyline(T, positive(f), x, y, { class: "series faint", "data-series": 0 }),
    polyline(T, positive(best), x, y, { class: "series", "data-series": 1 }),
  ];
  const xTitle = "temperature, mm (falling to the right)";
  return chart({ title: "Annealing trace", xTitle, yTitle: "largest distance, mm", x, y, marks });
}
