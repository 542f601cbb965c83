// What every page needs around its 3-D view: the canvas with its labels, and a sentence where there is no WebGL.
import { el } from "./dom.js";
import { createViewer } from "./viewer.js";

const SEE_THROUGH = 0.35; // opacity of the part

/**
 * Adds a canvas with its overlay of labels to `host`, in the colours of the window.
 *
 * @param {string} label  of the canvas, for a screen reader
 * @param {object} [options]  of `createViewer`
 * @returns {{viewer, stage: HTMLElement, overlay: HTMLElement}}
 */
export function buildStage(host, label, options = {}) {
  const canvas = el("canvas", { tabindex: 0, "aria-label": label });
  const overlay = el("div", { class: "overlay" });
  const stage = el("div", { class: "stage" }, canvas, overlay);
  host.append(stage);
  const theme = matchMedia("(prefers-color-scheme: dark)").matches ? "dark" : "light";
  return { viewer: createViewer(canvas, { overlay, theme, ...options }), stage, overlay };
}

/** What `build` returns, or null without WebGL: then `host` says so, and the numbers of the page are still there. */
export function buildOrSayWhy(host, build) {
  try {
    return build();
  } catch (error) {
    host.replaceChildren(el("p", { class: "note" }, `This browser shows no 3-D view: ${error.message}`));
    return null;
  }
}

/** A check box with a label; `onToggle` gets whether it is checked. */
export function checkBox(text, onToggle, { checked = false } = {}) {
  const box = el("input", { type: "checkbox", checked, onchange: () => onToggle(box.checked) });
  return el("label", { class: "toggle-alone" }, box, el("span", {}, text));
}

/** A check box that makes the part transparent. */
export function seeThroughBox(part) {
  return checkBox("see through", (isOn) => part.setOpacity(isOn ? SEE_THROUGH : 1));
}
