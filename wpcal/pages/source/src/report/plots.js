// The charts of the report: predicted errors along the seams, and the course of the annealing.
import { areaOf, axes, chart, curve, level, X_LINES } from "../charts/axes.js";
import { linear, logarithmic } from "../charts/scales.js";
import { fixed, short, svg } from "../dom.js";

const AREA = areaOf(560, 250, { left: 58, right: 14, top: 14, bottom: 42 });
const SERIES_COLOURS = 6; // in base.css
const MOST_NAMES = 8; // more seam names would cover the chart
const NAME_WIDTH = 44;
const NAME_HEIGHT = 12;

/**
 * Predicted error along every accepted seam, or null where no seam has one.
 *
 * @param {{name: string, accepted: boolean}[]} seams
 * @param {{s: number[], u95: number[]}[]} frames  of each seam: arc length and 95 % error, mm
 * @param {number} tolerance  mm
 */
export function errorPlot(seams, frames, tolerance) {
  const shown = seams.map((seam, row) => ({ seam, ...frames[row] })).filter(({ seam, u95 }) => seam.accepted && u95);
  if (!shown.length) return null;
  const highest = Math.max(...shown.flatMap(({ u95 }) => Math.max(...u95)), tolerance) * 1.12;
  const x = linear([0, Math.max(...shown.map(({ s }) => s.at(-1)))], [AREA.left, AREA.right]);
  const y = linear([0, highest], [AREA.bottom, AREA.top]);
  const attributes = (i) => ({ class: "series", "data-series": i % SERIES_COLOURS });
  return chart(
    AREA,
    { title: "95 % error along the seams" },
    axes(AREA, x, y, { xTitle: "arc length, mm", yTitle: "95 % error, mm", xLines: X_LINES.ticks }),
    level(AREA, y, { value: tolerance, text: `tolerance ${short(tolerance)} mm` }),
    shown.map(({ seam, s, u95 }, i) => curve(s, u95, x, y, attributes(i), seam.name)),
    shown.length > MOST_NAMES ? [] : endLabels(shown, x, y),
  );
}

/** The name of each seam above the end of its line; a name that would touch another one is moved up. */
function endLabels(shown, x, y) {
  const taken = [];
  return shown.map(({ seam, s, u95 }, i) => {
    const end = x.at(s.at(-1));
    const anchor = s.at(-1) > 0 && end > AREA.right - NAME_WIDTH ? "end" : "start";
    let above = y.at(u95.at(-1)) - 6;
    const touches = ([x0, y0]) => Math.abs(x0 - end) < NAME_WIDTH && Math.abs(y0 - above) < NAME_HEIGHT;
    while (taken.some(touches)) above -= NAME_HEIGHT;
    taken.push([end, above]);
    const series = { class: "note", "data-series": i % SERIES_COLOURS };
    return svg("text", { ...series, x: end, y: above, "text-anchor": anchor }, seam.name);
  });
}

/**
 * The largest distance at the end of each temperature, and the best so far: figure 2 of the paper. Null where nothing
 * is above zero, as a logarithmic scale cannot show it.
 *
 * @param {{temperature_mm: number[], f_mm: number[], best_f_mm: number[]}} trace
 * @param {number} objective  of the answer, mm
 */
export function annealingPlot({ temperature_mm: T, f_mm: f, best_f_mm: best }, objective) {
  const low = Math.min(...best.filter((v) => v > 0), objective || Infinity) / 1.5;
  if (!Number.isFinite(low)) return null;
  const positive = (values) => values.map((v) => Math.max(v, low));
  const x = logarithmic([T[0], T.at(-1)], [AREA.left, AREA.right]);
  const y = logarithmic([low, Math.max(...f) * 1.5], [AREA.bottom, AREA.top]);
  const xTitle = "temperature, mm (falling to the right)";
  const answer = { value: objective, text: `answer ${fixed(objective, 4)} mm` };
  return chart(
    AREA,
    { title: "Annealing trace" },
    axes(AREA, x, y, { xTitle, yTitle: "largest distance, mm", xLines: X_LINES.ticks }),
    objective > 0 ? level(AREA, y, answer, "answer") : [],
    curve(T, positive(f), x, y, { class: "series faint", "data-series": 0 }),
    curve(T, positive(best), x, y, { class: "series", "data-series": 1 }),
  );
}
