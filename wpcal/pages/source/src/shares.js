// A length compared with the tolerance: a bar in a table, a figure in a heading. And a whole divided into shares.
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

/** Colours of shares; they differ in lightness, too. */
const SHARE_COLOURS = ["#1b4f72", "#e0a030", "#2e8b6f", "#c97ba0", "#9a9a9a"];

/** A bar divided by shares, which sum to one. */
export function divided(shares) {
  const parts = shares.map((share, k) => {
    const fill = el("i", { class: "fill" });
    fill.style.width = `${(100 * share).toFixed(1)}%`;
    fill.style.background = SHARE_COLOURS[k];
    return fill;
  });
  return el("span", { class: "bar divided", "aria-hidden": "true" }, parts);
}

/** The colour of share number k, for a legend. */
export function swatch(k) {
  const mark = el("i", { class: "swatch", "aria-hidden": "true" });
  mark.style.background = SHARE_COLOURS[k];
  return mark;
}
