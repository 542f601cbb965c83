// Elements, and numbers as text. Text becomes text nodes only: a name from a file can never become markup.

const SVG = "http://www.w3.org/2000/svg";
const DRAWN = 200; // lines of a table that are drawn at once
const DRAW_ALL = "draw-all";
globalThis.addEventListener?.("beforeprint", drawAllLines);

/** Draws every line of the long tables of the page. */
export function drawAllLines() {
  for (const last of document.querySelectorAll("tr.more")) last.dispatchEvent(new Event(DRAW_ALL));
}

function filled(element, attributes, children) {
  for (const [name, value] of Object.entries(attributes)) {
    if (value === null || value === undefined || value === false) continue;
    if (name.startsWith("on")) element.addEventListener(name.slice(2), value);
    else element.setAttribute(name, value === true ? "" : value);
  }
  element.append(...children.flat(Infinity).filter((child) => child !== null && child !== undefined));
  return element;
}

/** An HTML element; strings among the children become text. */
export function el(tag, attributes = {}, ...children) {
  return filled(document.createElement(tag), attributes, children);
}

/** An SVG element. */
export function svg(tag, attributes = {}, ...children) {
  return filled(document.createElementNS(SVG, tag), attributes, children);
}

/** A number with fixed decimals; a dash for a missing number. */
export function fixed(value, decimals = 3) {
  if (value === null || value === undefined || !Number.isFinite(value)) return "–";
  const text = value.toFixed(decimals);
  return Number(text) === 0 ? (0).toFixed(decimals) : text; // no "-0.000"
}

/** A number with its sign, also when it is positive. */
export function signed(value, decimals = 3) {
  const text = fixed(value, decimals);
  return value > 0 && Number(text) !== 0 ? `+${text}` : text;
}

/** A number with three significant digits, for ticks and factors. */
export function short(value) {
  if (value === 0) return "0";
  const size = Math.abs(value);
  return size >= 1e5 || size < 1e-3 ? value.toExponential(0).replace("e+", "e") : String(Number(value.toPrecision(3)));
}

/** A row that answers to a click also answers to Enter and the space bar. */
function byKeyboard(attributes) {
  const { onclick } = attributes;
  if (!onclick) return attributes;
  const onkeydown = (event) => {
    if ((event.key !== "Enter" && event.key !== " ") || event.target !== event.currentTarget) return;
    event.preventDefault();
    onclick(event);
  };
  return { tabindex: 0, onkeydown, ...attributes };
}

/** A table: columns {title, number?, sorted?, cell: row => string | Node}; `rowOf(row)` gives attributes of its line,
 * `sorted` is ascending or descending. Of a long table the lines are drawn where one looks, and all for the printer. */
export function table(columns, rows, { rowOf = () => ({}), caption = null } = {}) {
  const kind = ({ number }) => (number ? "number" : null);
  const head = el(
    "tr",
    {},
    columns.map((column) => {
      if (!column.title) return el("td", { class: kind(column) }); // a heading without text is none
      return el("th", { scope: "col", class: kind(column), "aria-sort": column.sorted }, column.title);
    }),
  );
  const line = (row) =>
    el(
      "tr",
      byKeyboard(rowOf(row)),
      columns.map((column) => el("td", { class: kind(column) }, column.cell(row))),
    );
  const body = el("tbody", {}, rows.slice(0, DRAWN).map(line));
  if (rows.length > DRAWN) body.append(moreLines(rows, line, columns.length));
  const parts = [caption && el("caption", {}, caption), el("thead", {}, head), body];
  return el("div", { class: "table-scroll", tabindex: 0 }, el("table", {}, parts));
}

/** The line below those that are drawn: when it comes into sight, or is clicked, the next ones are drawn above it. */
function moreLines(rows, line, width) {
  let drawn = DRAWN;
  const button = el("button", { type: "button", onclick: () => draw(DRAWN) });
  const last = el("tr", { class: "more" }, el("td", { colspan: width }, button));
  const said = () => {
    button.textContent = `${rows.length - drawn} more lines`;
  };
  const draw = (count) => {
    last.before(...rows.slice(drawn, drawn + count).map(line));
    drawn += count;
    if (drawn >= rows.length) last.remove();
    else said();
  };
  last.addEventListener(DRAW_ALL, () => draw(rows.length));
  said();
  const seen = new IntersectionObserver((entries) => entries.some((one) => one.isIntersecting) && draw(DRAWN));
  seen.observe(last);
  return last;
}

/** A list of term and description pairs. */
export function facts(pairs) {
  return el(
    "dl",
    { class: "facts" },
    pairs.map(([term, value]) => el("div", {}, el("dt", {}, term), el("dd", {}, value))),
  );
}
