// Tools of every view: measure a distance, and cut what is shown open.
import { el, fixed, signed } from "./dom.js";
import { checkBox } from "./stage.js";
import { distanceOf, snapped } from "./viewer.js";

const LAYER = "measured";
const INK = "#d6246e";
const HINT = "click two places: corners, edges, points or faces";
const STEPS = 200; // of the slider of the cut
const AXES = { x: [1, 0, 0], y: [0, 1, 0], z: [0, 0, 1] };

/**
 * A check box; while it is on, two clicks measure. The text says what was measured.
 *
 * @returns {{element, forget: function()}}  `forget` is for a view in which bodies have moved
 */
export function measureTool(viewer) {
  const output = el("output", { "data-test": "measured", "aria-live": "polite" });
  let first = null;
  const draw = (picks) => {
    viewer.clear(LAYER);
    const places = picks.flatMap(({ ends }) => ends);
    viewer.addPoints(
      LAYER,
      places.map((p) => ({ p, color: INK })),
      { size: 10 },
    );
    for (const { ends } of picks) viewer.addPaths(LAYER, [{ points: ends, color: INK }], { width: 3 });
  };
  const take = (x, y) => {
    const pick = snapped(viewer, x, y);
    if (!pick) return;
    if (!first) {
      first = pick;
      draw([pick]);
      output.textContent = `from a ${pick.kind}; click the other place`;
      return;
    }
    const { mm, d, ends } = distanceOf(first, pick);
    draw([first, pick, { ends }]);
    output.textContent = `${fixed(mm)} mm (${d.map((v, i) => `${"xyz"[i]} ${signed(v)}`).join(", ")})`;
    first = null;
  };
  let isOn = false;
  const forget = () => {
    if (!isOn) return;
    first = null;
    viewer.clear(LAYER);
    output.textContent = HINT;
  };
  const toggle = (isChecked) => {
    isOn = true;
    forget();
    isOn = isChecked;
    viewer.onClick(isOn ? take : null);
    output.textContent = isOn ? HINT : "";
  };
  return { element: el("span", { class: "tool" }, checkBox("measure", toggle), output), forget };
}

/**
 * A choice of the axis and a slider: what is in front of the plane is not drawn.
 *
 * @param {object} [options]  `layers`: between whose ends the slider moves the plane; `what`: their name
 */
export function cutControl(viewer, { layers = ["part"], what = "the part" } = {}) {
  const choices = ["off", ...Object.keys(AXES), "−x", "−y", "−z"];
  const choice = el(
    "select",
    { "aria-label": `cut ${what}` },
    choices.map((name) => el("option", { value: name }, name === "off" ? "no cut" : `cut ${name}`)),
  );
  const slider = el("input", { type: "range", min: 0, max: STEPS, value: STEPS / 2, "aria-label": "place of the cut" });
  const output = el("output", { "data-test": "cut" });
  const apply = () => {
    const name = choice.value;
    slider.hidden = name === "off";
    output.textContent = "";
    if (name === "off") return viewer.cut.set(null);
    const sign = name.startsWith("−") ? -1 : 1;
    const axis = AXES[name.at(-1)];
    const row = axis.indexOf(1);
    const { center, radius } = viewer.extent(layers);
    const at = center.getComponent(row) + radius * ((2 * slider.value) / STEPS - 1);
    output.textContent = `${name.at(-1)} = ${fixed(at, 1)} mm`;
    return viewer.cut.set({ normal: axis.map((v) => -sign * v), offset: sign * at });
  };
  choice.addEventListener("change", apply);
  slider.addEventListener("input", apply);
  apply();
  return el("span", { class: "tool" }, choice, slider, output);
}
