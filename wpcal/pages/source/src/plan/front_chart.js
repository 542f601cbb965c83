// The chart of the trade-off plans: one mark per plan over two objectives, coloured by a third one.
import { areaOf, axes, chart, X_LINES } from "../charts/axes.js";
import { linear } from "../charts/scales.js";
import { svg } from "../dom.js";
import { colourOf } from "../viewer.js";

const AREA = areaOf(520, 330, { left: 62, right: 18, top: 16, bottom: 46 });
const RADIUS = 7;
const AIR = 0.08; // around the marks, as a part of their range

/**
 * Draws the plans, and behind them what each method found by itself.
 *
 * @param {object} data  of the page; `axes` names the objectives {x, y, colour}, `colour` may be null; `titles` by name
 * @param {function(number)} onPick  called with the row of a plan
 * @returns {{element, marks}}  `marks`: one element per plan
 */
export function frontChart({ plans, fronts, axes: names, titles }, onPick) {
  const behind = fronts.flatMap(({ values }) => values);
  const all = [...plans.map(({ objectives }) => objectives), ...behind];
  const x = linear(withAir(all.map((values) => values[names.x])), [AREA.left, AREA.right]);
  const y = linear(withAir(all.map((values) => values[names.y])), [AREA.bottom, AREA.top]);
  const placeOf = (values) => [x.at(values[names.x]), y.at(values[names.y])];
  const shades = names.colour
    ? shadesOf(plans.map(({ objectives }) => objectives[names.colour]))
    : plans.map(() => colourOf(0));
  const marks = plans.map((plan, row) => mark(plan, row, placeOf(plan.objectives), shades[row], onPick));
  const element = chart(
    AREA,
    { title: "the front", className: "chart front", role: "group" },
    axes(AREA, x, y, { xTitle: titles[names.x], yTitle: titles[names.y], xLines: X_LINES.grid }),
    fronts.map((front, i) => crosses(front, i, placeOf)),
    marks,
  );
  return { element, marks };
}

/** The range of some values with some room at both ends. */
function withAir(values) {
  const [low, high] = [Math.min(...values), Math.max(...values)];
  const air = (high - low || Math.abs(high) || 1) * AIR;
  return [low - air, high + air];
}

function shadesOf(values) {
  const [low, high] = [Math.min(...values), Math.max(...values)];
  return values.map((value) => colourOf((value - low) / (high - low || 1)));
}

/** What one method found by itself: small upright crosses for the first method, slanted ones for the others. */
function crosses({ name, values }, i, placeOf) {
  const upright = ([x, y]) => `M ${x - 4} ${y} h 8 M ${x} ${y - 4} v 8`;
  const slanted = ([x, y]) => `M ${x - 3} ${y - 3} l 6 6 M ${x + 3} ${y - 3} l -6 6`;
  const shape = i === 0 ? upright : slanted;
  return svg(
    "g",
    { class: "found", "data-series": i, "data-front": name },
    svg("title", {}, `found by ${name}`),
    values.map((one) => svg("path", { d: shape(placeOf(one)) })),
  );
}

/** A disc for a path of the ladder, a diamond for any other; hollow where the path is not known to be free. */
function mark(plan, row, [x, y], shade, onPick) {
  const look = { class: "shape", fill: plan.freedom === "free" ? shade : "none", stroke: shade };
  const drawn =
    plan.found_by === "ladder"
      ? svg("circle", { ...look, cx: x, cy: y, r: RADIUS })
      : svg("path", { ...look, d: diamond(x, y, RADIUS + 1, RADIUS + 2) });
  const text = `plan ${row + 1}, ${plan.freedom}`;
  const node = svg(
    "g",
    { class: "plan", tabindex: 0, role: "button", "aria-label": text, "data-plan": row },
    svg("circle", { class: "halo", cx: x, cy: y, r: RADIUS + 5 }),
    drawn,
    svg("title", {}, text),
  );
  node.addEventListener("click", () => onPick(row));
  node.addEventListener("keydown", (event) => event.key === "Enter" && onPick(row));
  return node;
}

function diamond(x, y, wide, tall) {
  return `M ${x} ${y - tall} l ${wide} ${tall} l ${-wide} ${tall} l ${-wide} ${-tall} z`;
}
