// The controls of a view: check boxes for its layers, buttons for its sides, the tooltip.
import { el } from "./dom.js";

/**
 * Check boxes that show and hide layers.
 *
 * @param {{label: string, layers: string[], on: boolean}[]} items
 */
export function toggles(viewer, items) {
  return el(
    "div",
    { class: "toggles" },
    items.map(({ label, layers, on }) => {
      const box = el("input", { type: "checkbox", checked: on, "data-layer": layers[0] });
      const apply = () => layers.forEach((layer) => viewer.show(layer, box.checked));
      box.addEventListener("change", apply);
      apply();
      return el("label", {}, box, el("span", {}, label));
    }),
  );
}

/** Buttons that turn the view to one side of the part. */
export function sides(viewer, names = ["iso", "front", "top", "right"]) {
  const button = (name) => el("button", { type: "button", onclick: () => viewer.view(name) }, name);
  return el("div", { class: "sides", role: "group", "aria-label": "look from" }, names.map(button));
}

/** A box beside the pointer that never leaves the view: {element, show(content, {x, y}), hide()}. */
export function tooltip(parent) {
  const box = el("div", { class: "tooltip", role: "status", hidden: true });
  parent.append(box);
  return {
    element: box,
    show(content, { x, y }) {
      box.replaceChildren(content);
      box.hidden = false;
      const [width, height] = [box.offsetWidth, box.offsetHeight];
      const left = x + 18 + width < parent.clientWidth ? x + 18 : Math.max(x - 18 - width, 4);
      const top = Math.min(Math.max(y - height / 2, 4), Math.max(parent.clientHeight - height - 4, 4));
      box.style.transform = `translate(${left.toFixed(0)}px, ${top.toFixed(0)}px)`;
    },
    hide() {
      box.hidden = true;
    },
  };
}

/**
 * A slider for the factor by which vectors are drawn longer, with the factor beside it.
 *
 * @param {{layer: string, label: string, test: string, factors: number[], start: number,
 *   pathsOf: function(number): object[], onTop?: boolean}} options  `pathsOf` gives the paths of the layer at a factor
 */
export function factorSlider(viewer, { layer, label, test, factors, start, pathsOf, onTop = false }) {
  const output = el("output", { "data-test": test });
  const draw = (factor) => {
    const wasShown = viewer.isShown(layer);
    viewer.clear(layer);
    const lines = viewer.addPaths(layer, pathsOf(factor), { width: 3 });
    if (onTop) drawOnTop(lines);
    viewer.show(layer, wasShown);
    output.textContent = `× ${factor}`;
  };
  const slider = el("input", { type: "range", min: 0, max: factors.length - 1, value: factors.indexOf(start) });
  slider.addEventListener("input", () => draw(factors[slider.value]));
  draw(start);
  return el("label", { class: "slider" }, el("span", {}, label), slider, output);
}

/** Draws lines also where the part is before them. */
export function drawOnTop(lines) {
  lines.material.depthTest = false;
  lines.renderOrder = 1;
}
