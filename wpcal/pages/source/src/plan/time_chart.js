// Charts over time with a cursor that all of them share.
import { areaOf, axes, chart, curve, level } from "../charts/axes.js";
import { linear } from "../charts/scales.js";
import { el, fixed, svg } from "../dom.js";
import { valueAt } from "./times.js";

const AREA = areaOf(560, 210, { left: 50, right: 12, top: 10, bottom: 34 });
const AIR = 0.06; // above and below the curves, as a part of their range

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
  if (!known.length) return nothingKnown(title);
  const x = linear([series[0].t[0], series[0].t.at(-1)], [AREA.left, AREA.right]);
  const y = linear(withAir(limit ? [...known, limit.value] : known), [AREA.bottom, AREA.top]);
  const line = svg("line", { class: "cursor", y1: AREA.top, y2: AREA.bottom });
  const drawing = chart(
    AREA,
    { title },
    stretch(x.at(burns[0]), x.at(burns[1])),
    axes(AREA, x, y, { xTitle: "time, s" }),
    limit && level(AREA, y, limit),
    series.map(({ t, values }, i) => curve(t, values, x, y, { class: "series", "data-series": i })),
    line,
  );
  drawing.addEventListener("click", (event) => onSeek(x.back(placeOf(drawing, event))));
  const numbers = series.map(() => el("b", {}));
  const names = series.map(({ name }, i) => el("span", { class: "name", "data-series": i }, name, " ", numbers[i]));
  const said = says && el("p", { class: "said" });
  return {
    element: el("section", { class: "curves" }, el("h2", {}, title), el("p", { class: "names" }, names), drawing, said),
    cursor(t) {
      line.setAttribute("x1", x.at(t));
      line.setAttribute("x2", x.at(t));
      for (const [i, one] of series.entries()) numbers[i].textContent = fixed(valueAt(one, t), decimals);
      if (says) said.textContent = says(t);
    },
  };
}

function nothingKnown(title) {
  return { element: el("section", {}, el("h2", {}, title), el("p", {}, "nothing is known")), cursor() {} };
}

/** The range of some values with some room above and below. */
function withAir(values) {
  const [low, high] = [Math.min(...values), Math.max(...values)];
  const air = (high - low || 1) * AIR;
  return [low - air, high + air];
}

/** A shaded stretch of time: the arc is on. */
function stretch(from, to) {
  return svg("rect", { class: "burns", x: from, width: to - from, y: AREA.top, height: AREA.bottom - AREA.top });
}

/** The place of a click on the axis of time, in units of the viewBox. */
function placeOf(drawing, event) {
  const box = drawing.getBoundingClientRect();
  return ((event.clientX - box.left) / box.width) * AREA.width;
}
