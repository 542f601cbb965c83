// Touches on faces: a click on the part while the box is checked adds a row; arrows show where the touches go.
import { el, fixed } from "../dom.js";
import { arrow } from "../residuals.js";
import { checkBox } from "../stage.js";
import { SEARCH } from "../touches/drawing.js";
import { edgeAt } from "../viewer.js";
import { post } from "./link.js";

const LAYER = "touches";
const EDGE_PX = 4; // nearer to an edge, the edge is meant: the sides of thin plates are narrow
const HINT = "click faces or edges of the part, one after the other";
const ARROW_PART = 0.1; // of the radius of the part
const BESIDE_POINT = 0.25; // of the arrow

export class Touching {
  /**
   * @param {Viewer} viewer
   * @param {{onTouch: function({kind, p_mm, radius}), onSay: function(string, string), other: HTMLInputElement}} on
   *   `other` is the box of another tool that takes clicks
   */
  constructor(viewer, on) {
    Object.assign(this, { viewer, on, known: new Map() });
    const toggle = (isOn) => this.toggle(isOn);
    const box = checkBox("add touches", toggle);
    this.box = box.querySelector("input");
    this.radius = el("input", {
      type: "text",
      size: 4,
      name: "radius",
      "aria-label": "distance of the controlled point from the face, mm: the wire's radius",
      title: "distance of the controlled point from the face: radius of the wire, of a ball; empty: 0 or --ball-mm",
      autocomplete: "off",
      disabled: true,
    });
    this.radiusLabel = el("label", {}, "radius", this.radius, "mm");
    this.element = el("span", { class: "tool" }, box, this.radiusLabel);
    this.output = el("p", { id: "promise", "aria-live": "polite" });
    on.other.addEventListener("change", () => on.other.checked && this.box.checked && this.box.click());
  }

  toggle(isOn) {
    if (isOn && this.on.other.checked) this.on.other.click();
    this.viewer.onClick(isOn ? (x, y) => this.take(x, y) : null);
    this.radius.disabled = !isOn;
    if (isOn && !this.output.textContent) this.output.textContent = HINT;
  }

  async take(x, y) {
    const face = this.viewer.surfaceAt(x, y);
    const edge = edgeAt(this.viewer, x, y, EDGE_PX);
    if (!face) return;
    if (edge) {
      this.on.onTouch({ kind: "edge", p_mm: nearestOn(edge, face.p), radius: "" });
      return;
    }
    const { answer, fault } = await post("touch", { p: face.p, normal: face.normal });
    if (fault) this.on.onSay(fault.message, "wrong");
    else this.on.onTouch({ ...answer, radius: this.radius.value.trim().replace(",", ".") });
  }

  /** Shows what the rows promise, or why nothing: arrows at the touches, and the largest error of a seam. */
  show(promise, fault = null) {
    const { viewer } = this;
    viewer.clear(LAYER);
    this.known = new Map((promise?.touches ?? []).map((touch) => [touch.row, touch]));
    if (!promise) {
      this.output.textContent = fault?.message ?? (this.box.checked ? HINT : "");
      return;
    }
    const length = ARROW_PART * viewer.extent(["part"]).radius;
    for (const { p_mm: p, normal } of this.known.values()) {
      const start = p.map((v, i) => v + (1 + BESIDE_POINT) * length * normal[i]); // the mark of the row is at its end
      const down = normal.map((v) => -length * v);
      viewer.addPaths(LAYER, arrow(start, down, 1, SEARCH), { width: 3 });
    }
    this.output.textContent = promiseText(promise);
  }

  /** Where the row of an index touches the part, or undefined. */
  placeOf(row) {
    return this.known.get(row)?.p_mm;
  }
}

/** What planned touches promise, as a sentence. */
export function promiseText({ touches, error_95_mm, seam, free, sigma_mm }) {
  if (!touches.length) return "";
  if (free) return free;
  if (error_95_mm === null) return "the touches hold all six freedoms";
  return `predicted 95 % error: at most ${fixed(error_95_mm, 3)} mm, on ${seam} (σ ${sigma_mm} mm per axis)`;
}

/** The point of a segment that is nearest to a place. */
export function nearestOn([a, b], p) {
  const d = b.map((v, i) => v - a[i]);
  const square = d.reduce((sum, v) => sum + v * v, 0);
  const along = d.reduce((sum, v, i) => sum + v * (p[i] - a[i]), 0);
  const t = square ? Math.min(Math.max(along / square, 0), 1) : 0;
  return a.map((v, i) => v + t * d[i]);
}
