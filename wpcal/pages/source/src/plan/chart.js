// Charts over time with a cursor that all of them share.
import { el, fixed, short, svg } from "../dom.js";

const [WIDTH, HEIGHT, LEFT, RIGHT, TOP, BOTTOM] = [560, 210, 50, 12, 10, 34];
const TICKS = 5;

/** A linear scale from data to pixels with its ticks; `back` goes the other way. */
export function linear([low, high], [start, end]) {
  const slope = (end - start) / (high - low || 1);
  const power = 10 ** Math.floor(Math.log10((high - low || 1) / TICKS));
  const step = [1, 2, 5, 10].map((factor) => factor * power).find((size) => size >= (high - low || 1) / TICKS - 1e-12);
  const first = Math.ceil(low / step - 1e-9);
  const ticks = Array.from({ length: Math.floor(high / step + 1e-9) - first + 1 }, (_, i) => (first + i) * step);
  return { at: (value) => start + slope * (value - low), back: (pixel) => low + (pixel - start) / slope, ticks };
}

/**
 * Curves over time.
 *
 * @param {{name: string, t: number[], values: (number|null)[]}[]} series  a null is a gap
 * @param {object} options  decimals of the numbers; `limit`: {value, text}; `burns`: [from, to] with the arc on;
 *   `says(t)`: a line of text at a time; `onSeek(t)`
 * @returns {{element, cursor(t)}}
 */
export function timeChart(title, series, { decimals = 1, limit = null, burns, says = null, onSeek }) {
  const known = series.flatMap(({ values }) => values.filter((v) => v !== null));
  if (!known.length)
    return { element: el("section", {}, el("h2", {}, title), el("p", {}, "nothing is known")), cursor() {} };
  const all = limit ? [...known, limit.value] : known;
  const [low, high] = [Math.min(...all), Math.max(...all)];
  const air = (high - low || 1) * 0.06;
  const x = linear([series[0].t[0], series[0].t.at(-1)], [LEFT, WIDTH - RIGHT]);
  const y = linear([low - air, high + air], [HEIGHT - BOTTOM, TOP]);
  const line = svg("line", { class: "cursor", y1: TOP, y2: HEIGHT - BOTTOM });
  const chart = svg(
    "svg",
    { class: "chart", viewBox: `0 0 ${WIDTH} ${HEIGHT}`, role: "img", "aria-label": title },
    svg("rect", {
      class: "burns",
      x: x.at(burns[0]),
      width: x.at(burns[1]) - x.at(burns[0]),
      y: TOP,
      height: HEIGHT - BOTTOM - TOP,
    }),
    axes(x, y),
    limit && level(limit, y),
    series.map(({ t, values }, i) => curve(t, values, x, y, i)),
    line,
  );
  chart.addEventListener("click", (event) => onSeek(x.back(dataX(chart, event))));
  const numbers = series.map(() => el("b", {}));
  const names = series.map(({ name }, i) => el("span", { class: "name", "data-series": i }, name, " ", numbers[i]));
  const said = el("p", { class: "said" });
  return {
    element: el(
      "section",
      { class: "curves" },
      el("h2", {}, title),
      el("p", { class: "names" }, names),
      chart,
      says && said,
    ),
    cursor(t) {
      line.setAttribute("x1", x.at(t));
      line.setAttribute("x2", x.at(t));
      series.forEach((one, i) => (numbers[i].textContent = fixed(valueAt(one, t), decimals)));
      if (says) said.textContent = says(t);
    },
  };
}

function dataX(chart, event) {
  const box = chart.getBoundingClientRect();
  return ((event.clientX - box.left) / box.width) * WIDTH;
}

function axes(x, y) {
  const bottom = HEIGHT - BOTTOM;
  return [
    ...y.ticks.map((v) => svg("line", { class: "grid", x1: LEFT, x2: WIDTH - RIGHT, y1: y.at(v), y2: y.at(v) })),
    ...y.ticks.map((v) => svg("text", { x: LEFT - 7, y: y.at(v) + 4, "text-anchor": "end" }, short(v))),
    ...x.ticks.map((v) => svg("text", { x: x.at(v), y: bottom + 16, "text-anchor": "middle" }, short(v))),
    svg("line", { class: "base", x1: LEFT, x2: WIDTH - RIGHT, y1: bottom, y2: bottom }),
    svg("text", { x: WIDTH - RIGHT, y: HEIGHT - 3, "text-anchor": "end" }, "time, s"),
  ];
}

function level({ value, text }, y) {
  return [
    svg("line", { class: "limit", x1: LEFT, x2: WIDTH - RIGHT, y1: y.at(value), y2: y.at(value) }),
    svg("text", { class: "note limit", x: WIDTH - RIGHT, y: y.at(value) - 5, "text-anchor": "end" }, text),
  ];
}

/** One line for every stretch without a gap. */
function curve(t, values, x, y, index) {
  const stretches = [[]];
  values.forEach((value, i) => {
    if (value === null) stretches.push([]);
    else stretches.at(-1).push(`${x.at(t[i]).toFixed(1)},${y.at(value).toFixed(1)}`);
  });
  return stretches
    .filter((points) => points.length > 1)
    .map((points) => svg("polyline", { class: "series", "data-series": index, points: points.join(" ") }));
}

/** Row of the last time that is not after t. */
export function rowAt(times, t) {
  let [low, high] = [0, times.length];
  while (high - low > 1) {
    const middle = (low + high) >> 1;
    if (times[middle] <= t) low = middle;
    else high = middle;
  }
  return low;
}

function valueAt({ t: times, values }, t) {
  const row = rowAt(times, t);
  const [a, b] = [values[row], values[Math.min(row + 1, values.length - 1)]];
  if (a === null || b === null) return a;
  const step = times[Math.min(row + 1, times.length - 1)] - times[row];
  return step > 0 ? a + ((b - a) * (t - times[row])) / step : a;
}
