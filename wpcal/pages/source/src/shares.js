// A length compared with the tolerance: a bar in a table, a figure in a heading.
import { el, fixed, short } from "./dom.js";
import { colourOf } from "./viewer.js";

/** A bar that is full at the tolerance. */
export function bar(value, tolerance) {
  const fill = el("i", { class: "fill" });
  fill.style.width = `${Math.min((100 * value) / tolerance, 100).toFixed(1)}%`;
  fill.style.background = colourOf(value / tolerance);
  return el("span", { class: "bar", "aria-hidden": "true" }, fill);
}

/** A figure with a bar that is full at the tolerance; `note` says where it is, or is null. */
export function gauge(label, value, tolerance, note) {
  const percent = `${short(Math.round((100 * value) / tolerance))} % of the tolerance`;
  return el(
    "div",
    { class: "gauge" },
    el("div", { class: "term" }, label),
    el("div", { class: "value" }, fixed(value, 3), el("small", {}, " mm")),
    bar(value, tolerance),
    el("div", { class: "note" }, [note, percent].filter(Boolean).join(" · ")),
  );
}
