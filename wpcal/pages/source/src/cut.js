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
    this.clip(objects);
  }

  /** Faces and edges that are no longer drawn. */
  remove(object) {
    this.objects = this.objects.filter((each) => each !== object);
  }

  /** Faces and edges whose layer is shown. */
  shown() {
    return this.objects.filter(({ parent }) => parent?.visible);
  }

  clip(objects) {
    for (const { material } of objects) {
      material.clippingPlanes = this.plane ? [this.plane] : [];
      material.needsUpdate = true;
    }
  }

  /**
   * Cuts, or shows everything.
   *
   * @param {{normal: number[], offset: number}|null} plane  drawn: normal · p + offset ≥ 0
   */
  set(plane) {
    this.plane = plane && new Plane(new Vector3(...plane.normal), plane.offset);
    this.clip(this.objects);
    this.viewer.depth.cut(this.plane);
    this.viewer.render();
  }

  /** Whether a place is cut away. */
  removes(p) {
    return this.plane !== null && this.plane.distanceToPoint(new Vector3(...p)) < 0;
  }
}
