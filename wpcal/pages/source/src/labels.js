// Texts beside places of the view: elements of an overlay that move when the view is drawn.
import { Vector3 } from "three";

export class Labels {
  constructor(viewer, overlay) {
    this.viewer = viewer;
    this.overlay = overlay;
    this.items = [];
    this.hidden = new Set();
  }

  add(layer, labels, className, priority) {
    for (const { p, text } of labels) {
      const element = document.createElement("span");
      element.className = `label ${className}`.trim();
      element.textContent = text;
      this.overlay.append(element);
      this.items.push({ layer, p: new Vector3(...p), element, priority, behind: false });
    }
  }

  show(layer, visible) {
    if (visible) this.hidden.delete(layer);
    else this.hidden.add(layer);
  }

  clear(layer) {
    for (const item of this.items) if (item.layer === layer) item.element.remove();
    this.items = this.items.filter((item) => item.layer !== layer);
  }

  placeOf({ layer, p }) {
    return p.clone().applyMatrix4(this.viewer.layer(layer).matrixWorld).toArray();
  }

  /** Finds the labels whose places are behind the part. They fade, and other labels have priority over them. */
  sort() {
    for (const item of this.items) {
      item.behind = !this.hidden.has(item.layer) && this.viewer.isHidden(this.placeOf(item));
      item.element.classList.toggle("behind", item.behind);
    }
    this.place();
  }

  /** Paints the shown labels onto a picture of the view, in pixels of the picture. */
  paint(context, scale) {
    Object.assign(context, { font: `${12 * scale}px sans-serif`, textBaseline: "middle", lineWidth: 3 * scale });
    Object.assign(context, { strokeStyle: "#ffffff", fillStyle: "#17202a", lineJoin: "round" });
    for (const item of this.items.filter(({ element, behind }) => !element.hidden && !behind)) {
      const { x, y } = this.viewer.project(this.placeOf(item));
      const [left, text] = [(x + 10) * scale, item.element.textContent];
      context.strokeText(text, left, y * scale);
      context.fillText(text, left, y * scale);
    }
  }

  /** Moves every label. Of two labels that would overlap, the one with lower priority, or the later one, is hidden. */
  place() {
    const taken = [];
    for (const item of [...this.items].sort((a, b) => a.behind - b.behind || b.priority - a.priority)) {
      const { layer, element } = item;
      const { x, y, inside } = this.viewer.project(this.placeOf(item));
      const width = 7 * element.textContent.length + 6; // estimated: measuring costs a layout
      const box = [x, y - 8, x + width, y + 8];
      const free = taken.every(
        (other) => box[0] > other[2] || box[2] < other[0] || box[1] > other[3] || box[3] < other[1],
      );
      const visible = inside && free && !this.hidden.has(layer);
      element.hidden = !visible;
      if (!visible) continue;
      taken.push(box);
      element.style.transform = `translate(${x.toFixed(1)}px, ${y.toFixed(1)}px)`;
    }
  }
}
