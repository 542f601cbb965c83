// The marks of the features that can be touched, one layer per kind.
import { DOT, MOST_FULL, sharesOf } from "./thinning.js";

const EASY = "#2f7bd9";
const HARD = "#7d8a98";
const SIZE_PX = 7;

const isEasy = ({ ease }) => ease === "sharp" || ease === "round";

export class FeatureMarks {
  constructor(viewer) {
    Object.assign(this, { viewer, kinds: [] });
    viewer.atRest.push(() => this.thin());
  }

  add(letter, features, reachPx) {
    const points = features.map((feature) => ({ p: feature.p_mm, color: isEasy(feature) ? EASY : HARD }));
    const marks = this.viewer.addPoints(letter, points, { size: SIZE_PX });
    const places = features.map(({ p_mm }) => p_mm);
    this.viewer.addTargets(letter, places, { features }, { radius: reachPx });
    this.kinds.push({ letter, features, marks });
    const count = this.kinds.reduce((sum, kind) => sum + kind.features.length, 0);
    if (count > MOST_FULL) for (const kind of this.kinds) this.resize(kind, () => DOT); // until the view rests
  }

  /** Chooses the marks that are drawn in full: features that are easy to touch first, then those near to the viewer. */
  thin() {
    const { viewer } = this;
    const marks = this.kinds
      .filter(({ letter }) => viewer.isShown(letter))
      .flatMap((kind) =>
        kind.features.map((feature, row) => ({ kind, row, feature, ...viewer.project(feature.p_mm) })),
      );
    marks.sort((a, b) => isEasy(b.feature) - isEasy(a.feature) || a.depth - b.depth);
    const shares = sharesOf(marks, (i) => viewer.isHidden(marks[i].feature.p_mm));
    const byKind = new Map(this.kinds.map((kind) => [kind, new Float32Array(kind.features.length)]));
    marks.forEach(({ kind, row }, i) => (byKind.get(kind)[row] = shares[i]));
    for (const [kind, own] of byKind) if (viewer.isShown(kind.letter)) this.resize(kind, (row) => own[row]);
  }

  resize({ marks }, shareOf) {
    const attribute = marks.geometry.getAttribute("share");
    const before = attribute.array.slice();
    attribute.array.forEach((_, row) => (attribute.array[row] = shareOf(row)));
    if (before.every((share, row) => share === attribute.array[row])) return;
    attribute.needsUpdate = true;
    this.viewer.render();
  }
}
