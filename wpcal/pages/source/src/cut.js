// A plane that cuts parts open: what lies outside it is not drawn and hides nothing. Lines and points stay.
import { Plane, Vector3 } from "three";

export class Cut {
  constructor(viewer) {
    this.viewer = viewer;
    this.plane = null;
    this.objects = [];
    viewer.renderer.localClippingEnabled = true;
  }

  /** Faces and edges that are cut. */
  add(...objects) {
    this.objects.push(...objects);
  }

  /**
   * Cuts, or shows everything.
   *
   * @param {{normal: number[], offset: number}|null} plane  drawn: normal · p + offset ≥ 0
   */
  set(plane) {
    this.plane = plane && new Plane(new Vector3(...plane.normal), plane.offset);
    for (const { material } of this.objects) {
      material.clippingPlanes = this.plane ? [this.plane] : [];
      material.needsUpdate = true;
    }
    this.viewer.depth.cut(this.plane);
    this.viewer.render();
  }

  /** Whether a place is cut away. */
  removes(p) {
    return this.plane !== null && this.plane.distanceToPoint(new Vector3(...p)) < 0;
  }
}
