// What the pointer is on: the nearest target on the screen that no face hides.
import { Matrix4 } from "three";

const CLICK_PX = 4; // a longer way is a drag

export class Targets {
  constructor(viewer) {
    this.viewer = viewer;
    this.sets = [];
    this.onHover = () => {};
    this.onPick = () => {};
    this.onClick = null; // takes all clicks while a tool is on
    this.current = null;
    this.listen(viewer.canvas);
  }

  add(layer, points, data, priority, radius) {
    this.sets.push({ layer, points, data, priority, radius });
  }

  clear(layer) {
    this.sets = this.sets.filter((set) => set.layer !== layer);
    if (this.current?.layer === layer) this.hover(null);
  }

  listen(canvas) {
    let pressed = null;
    let waiting = null;
    const placeOf = (event) => {
      const box = canvas.getBoundingClientRect();
      return [event.clientX - box.left, event.clientY - box.top];
    };
    canvas.addEventListener("pointerdown", (event) => (pressed = placeOf(event)));
    // Not pointerup: after a tap the browser would still move the focus to the canvas, and two fingers are not a click.
    canvas.addEventListener("click", (event) => {
      const [x, y] = placeOf(event);
      const isClick = pressed && Math.hypot(x - pressed[0], y - pressed[1]) < CLICK_PX;
      pressed = null;
      if (!isClick) return;
      if (this.onClick) {
        this.onClick(x, y);
        return;
      }
      const found = this.at(x, y);
      this.hover(found);
      this.onPick(found);
    });
    canvas.addEventListener("pointermove", (event) => {
      if (event.buttons) return;
      const isAsked = waiting !== null;
      waiting = placeOf(event);
      if (isAsked) return;
      requestAnimationFrame(() => {
        this.hover(this.at(...waiting));
        waiting = null;
      });
    });
    canvas.addEventListener("pointerleave", (event) => {
      if (event.pointerType === "mouse") this.hover(null);
    });
  }

  hover(found) {
    const same = found?.data === this.current?.data && found?.index === this.current?.index;
    this.current = found;
    if (!same) this.onHover(found);
  }

  /** The target at a pixel: higher priority first, then the nearest. */
  at(x, y) {
    const near = this.sets.flatMap((set) => this.near(set, x, y));
    near.sort((a, b) => b.set.priority - a.set.priority || a.distance - b.distance);
    const found = near.find(({ p }) => !this.viewer.isHidden(p));
    if (!found) return null;
    const { set, index, p } = found;
    return { layer: set.layer, data: set.data, index, p, ...this.viewer.project(p) };
  }

  near(set, x, y) {
    const { viewer } = this;
    const group = viewer.layer(set.layer);
    if (!group.visible) return [];
    const { camera, width, height } = viewer;
    const m = new Matrix4().multiplyMatrices(camera.projectionMatrix, camera.matrixWorldInverse);
    const e = m.multiply(group.matrixWorld).elements;
    const found = [];
    for (let i = 0; 3 * i < set.points.length; i += 1) {
      const [px, py, pz] = set.points.subarray(3 * i, 3 * i + 3);
      const w = e[3] * px + e[7] * py + e[11] * pz + e[15];
      if (w <= 0) continue;
      const dx = ((e[0] * px + e[4] * py + e[8] * pz + e[12]) / w + 1) * (width / 2) - x;
      const dy = (1 - (e[1] * px + e[5] * py + e[9] * pz + e[13]) / w) * (height / 2) - y;
      const distance = Math.hypot(dx, dy);
      if (distance <= set.radius)
        found.push({ set, index: i, distance, p: transformed(group.matrixWorld, px, py, pz) });
    }
    return found;
  }
}

function transformed({ elements: e }, x, y, z) {
  return [0, 1, 2].map((row) => e[row] * x + e[row + 4] * y + e[row + 8] * z + e[row + 12]);
}
