// The axes of every chart, and the lines inside them, as SVG. A chart has a viewBox of fixed size; the page scales it.
import { short, svg } from "../dom.js";

const TICK_LENGTH = 4;
const LEFT_OF_AXIS = 8; // from a number to the axis
const BELOW_AXIS = 18;
const ABOVE_LINE = 5;

/** What is drawn at the ticks of x: nothing, a short line below the axis, or a line across the plot. */
export const X_LINES = Object.freeze({ none: "none", ticks: "ticks", grid: "grid" });

/**
 * The size of a chart and the edges of its plot, in units of the viewBox, from the left and from the top.
 *
 * @param {{left: number, right: number, top: number, bottom: number}} margins
 */
export function areaOf(width, height, { left, right, top, bottom }) {
  return { width, height, left, right: width - right, top, bottom: height - bottom };
}

/** The SVG element of a chart; `title` is read aloud in place of the picture. */
export function chart(area, { title, className = "chart", role = "img" }, ...children) {
  const viewBox = `0 0 ${area.width} ${area.height}`;
  return svg("svg", { class: className, viewBox, role, "aria-label": title }, ...children);
}

/**
 * Numbers, grid and titles of both axes.
 *
 * @param {object} area  from `areaOf`
 * @param {object} x  a scale of `scales.js` from area.left to area.right
 * @param {object} y  a scale from area.bottom to area.top
 * @param {{xTitle: string, yTitle?: string, xLines?: string}} options  with a `yTitle` the title of x is centred, else
 *   it ends at the right; `xLines`: one of `X_LINES`
 */
export function axes(area, x, y, { xTitle, yTitle = null, xLines = X_LINES.none }) {
  const { left, right, bottom } = area;
  return [
    y.ticks.map((v) => svg("line", { class: "grid", x1: left, x2: right, y1: y.at(v), y2: y.at(v) })),
    y.ticks.map((v) => svg("text", { x: left - LEFT_OF_AXIS, y: y.at(v) + 4, "text-anchor": "end" }, short(v))),
    xLines === X_LINES.none ? [] : x.ticks.map((v) => verticalLine(area, x.at(v), xLines)),
    x.ticks.map((v) => svg("text", { x: x.at(v), y: bottom + BELOW_AXIS, "text-anchor": "middle" }, short(v))),
    svg("line", { class: "base", x1: left, x2: right, y1: bottom, y2: bottom }),
    yTitle === null ? endTitle(area, xTitle) : centredTitles(area, xTitle, yTitle),
  ];
}

function verticalLine({ top, bottom }, at, xLines) {
  const [y1, y2] = xLines === X_LINES.grid ? [top, bottom] : [bottom, bottom + TICK_LENGTH];
  return svg("line", { class: "grid", x1: at, x2: at, y1, y2 });
}

function endTitle({ right, height }, xTitle) {
  return svg("text", { x: right, y: height - 3, "text-anchor": "end" }, xTitle);
}

function centredTitles({ left, right, top, bottom, height }, xTitle, yTitle) {
  const turned = `translate(13 ${(top + bottom) / 2}) rotate(-90)`;
  return [
    svg("text", { x: (left + right) / 2, y: height - 6, "text-anchor": "middle" }, xTitle),
    svg("text", { transform: turned, "text-anchor": "middle" }, yTitle),
  ];
}

/** A level line across the plot with a text above its right end. */
export function level(area, y, { value, text }, className = "limit") {
  const at = y.at(value);
  return [
    svg("line", { class: className, x1: area.left, x2: area.right, y1: at, y2: at }),
    svg("text", { class: `note ${className}`, x: area.right, y: at - ABOVE_LINE, "text-anchor": "end" }, text),
  ];
}

/**
 * One polyline for every stretch of a curve without a gap.
 *
 * @param {number[]} xs
 * @param {(number|null)[]} ys  null: a gap
 * @param {string} [name]  the browser shows it when the pointer rests on the line
 */
export function curve(xs, ys, x, y, attributes, name = null) {
  const stretches = [[]];
  ys.forEach((value, i) => {
    if (value === null) stretches.push([]);
    else stretches.at(-1).push(`${x.at(xs[i]).toFixed(1)},${y.at(value).toFixed(1)}`);
  });
  const drawn = stretches.filter((points) => points.length > 1);
  return drawn.map((points) =>
    svg("polyline", { ...attributes, points: points.join(" ") }, name === null ? null : svg("title", {}, name)),
  );
}
