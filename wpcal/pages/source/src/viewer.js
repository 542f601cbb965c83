// The 3-D view of wpcal's pages. It draws in millimetres with z up, in the frame of the page (the report: `base`).
//
// Everything is in named layers, which are shown, hidden and moved as a whole. Lines, points and labels keep their size
// in pixels. The view draws when something changed, never in a loop.
import { Group, Matrix4, Raycaster, Scene, Sphere, Vector2, Vector3, WebGLRenderer } from "three";
import { cameraWithLights, controlsOf, fitDepthRange, listenToKeys, VIEWS } from "./camera.js";
import { Cut } from "./cut.js";
import { DepthMap, OCCLUDERS } from "./depth.js";
import { framed, placesOf, sphereAround } from "./framing.js";
import { Labels } from "./labels.js";
import { fatLines, roundPoints, segmentsOfPaths } from "./marks.js";
import { bodyObject, partObjects, setOpacity } from "./solids.js";
import { Targets } from "./targets.js";

export { BEYOND, colourOf, ramp } from "./colours.js";
export { readBlob, readData, readJsonBlob } from "./embedded.js";
export { distanceOf, edgeAt, snapped } from "./measure.js";
export { decodePart } from "./part.js";
export { clearDirection, seenFrom } from "./sight.js";

const AXIS_COLOURS = ["#d63c3c", "#2f9e44", "#2f6fde"]; // x red, y green, z blue, as in most CAD programs
const MARGIN = 1.15; // some air at the rim, and room for labels
const REST_MS = 150; // after the last drawing, before labels behind the part fade
const THEMES = {
  light: { part: "#b9c2cc", edge: "#38434f" },
  dark: { part: "#7d8a98", edge: "#0e1318" },
};

/** A transform as wpcal writes it, row-major 4×4, nested or flat; null is the identity. */
function matrixOf(T) {
  return T ? new Matrix4().set(...T.flat()) : new Matrix4();
}

function flat(rows) {
  return rows instanceof Float32Array ? rows : new Float32Array(rows.flat(Infinity));
}

/**
 * Makes a view on a canvas.
 *
 * @param {HTMLCanvasElement} canvas  the view follows its CSS size
 * @param {object} [options]
 * @param {HTMLElement} [options.overlay]  element over the canvas for the labels; without it there are no labels
 * @param {"light"|"dark"} [options.theme]
 * @param {"always"|"after-press"} [options.wheel]  when the wheel zooms, see `controlsOf`
 */
export function createViewer(canvas, { overlay = null, theme = "light", wheel = "after-press" } = {}) {
  return new Viewer(canvas, overlay, theme, wheel);
}

class Viewer {
  constructor(canvas, overlay, theme, wheel) {
    this.canvas = canvas;
    this.colours = THEMES[theme];
    this.renderer = new WebGLRenderer({ canvas, antialias: true, alpha: true });
    this.scene = new Scene();
    this.camera = cameraWithLights(this.scene);
    this.resolution = new Vector2(1, 1);
    this.layers = new Map();
    this.targets = new Targets(this);
    this.depth = new DepthMap(this);
    this.labels = overlay ? new Labels(this, overlay) : null;
    this.asked = false;
    this.atRest = [() => this.labels?.sort()]; // called when nothing was drawn for a moment
    this.controls = controlsOf(this.camera, canvas, wheel, () => this.render());
    listenToKeys(canvas, this.controls, () => this.view());
    this.cut = new Cut(this);
    new ResizeObserver(() => this.resize()).observe(canvas);
    this.resize();
  }

  // Layers ------------------------------------------------------------------------------------------------------------

  /** The group of a layer; a new name makes a new layer. */
  layer(name) {
    if (!this.layers.has(name)) {
      const group = new Group();
      group.name = name;
      group.matrixAutoUpdate = false;
      this.layers.set(name, group);
      this.scene.add(group);
    }
    return this.layers.get(name);
  }

  /** Shows or hides a layer with its labels and targets. */
  show(name, visible = true) {
    this.layer(name).visible = visible;
    this.labels?.show(name, visible);
    this.depth.outdate();
    this.render();
  }

  isShown(name) {
    return this.layer(name).visible;
  }

  /** Moves a layer: T is row-major 4×4, mm. */
  move(name, T) {
    this.layer(name).matrix.copy(matrixOf(T));
    this.layer(name).updateMatrixWorld(true);
    this.depth.outdate();
    this.render();
  }

  /** Removes everything in a layer, with its labels and targets. */
  clear(name) {
    const group = this.layer(name);
    group.traverse((object) => {
      this.cut.remove(object);
      if (object.layers.isEnabled(OCCLUDERS)) this.depth.outdate();
      object.geometry?.dispose();
      object.material?.dispose();
    });
    group.clear();
    this.labels?.clear(name);
    this.targets.clear(name);
    this.render();
  }

  // What can be drawn -------------------------------------------------------------------------------------------------

  /**
   * Draws a part from the bytes of `part.glb`. Its faces become the layer NAME, its edges the layer "NAME edges".
   * `moves`: solids that are not where the model has them, as a Map of row-major 4×4 by name.
   *
   * @returns {{solids: {name: string}[], setOpacity: function(number)}}
   */
  addPart(bytes, { name = "part", T = null, moves = null, edge = this.colours.edge } = {}) {
    const { mesh, edges, solids } = partObjects(bytes, { part: this.colours.part, edge }, moves);
    this.cut.add(mesh, edges);
    this.layer(name).add(mesh);
    this.layer(`${name} edges`).add(edges);
    this.move(name, T);
    this.move(`${name} edges`, T);
    return {
      solids,
      setOpacity: (opacity) => {
        setOpacity(mesh, opacity);
        this.depth.outdate();
        this.render();
      },
    };
  }

  /** Draws triangles: positions (n×3, mm) and indices; for arms, fixtures and the like. */
  addMesh(layer, { positions, indices = null, color = this.colours.part, opacity = 1 }) {
    const mesh = bodyObject(flat(positions), indices, color, opacity);
    this.cut.add(mesh);
    this.layer(layer).add(mesh);
    this.depth.outdate();
    this.render();
    return mesh;
  }

  /**
   * Draws paths of a width in pixels.
   *
   * @param {{points: number[][], colors?: string[], color?: string}[]} paths  `colors`: one per point
   */
  addPaths(layer, paths, { width = 4, opacity = 1, dashed = false } = {}) {
    const { positions, colors } = segmentsOfPaths(paths);
    return this.addSegments(layer, positions, colors, { width, opacity, dashed });
  }

  /** Gives other colours to lines that `addPaths` returned; `paths` are the same paths in the same order. */
  recolour(lines, paths) {
    lines.geometry.setColors(segmentsOfPaths(paths).colors);
    this.render();
  }

  /** Draws segments: six numbers each in `positions` (mm) and in `colors` (linear RGB, 0…1). */
  addSegments(layer, positions, colors, { width = 2, opacity = 1, dashed = false } = {}) {
    const lines = fatLines(flat(positions), flat(colors), { width, opacity, dashed, resolution: this.resolution });
    this.layer(layer).add(lines);
    this.render();
    return lines;
  }

  /** Draws the axes of frames: {p: [3], R: 3×3 rows, whose columns are the axes}. */
  addTriads(layer, frames, lengthMm, { width = 2 } = {}) {
    const paths = frames.flatMap(({ p, R }) =>
      [0, 1, 2].map((axis) => ({
        points: [p, p.map((v, row) => v + lengthMm * R[row][axis])],
        color: AXIS_COLOURS[axis],
      })),
    );
    return this.addPaths(layer, paths, { width });
  }

  /** Draws round points of a size in pixels: {p, color}. */
  addPoints(layer, points, { size = 11 } = {}) {
    const marks = roundPoints(points, size, this.resolution);
    this.layer(layer).add(marks);
    this.render();
    return marks;
  }

  /** Writes texts beside places: {p, text}. They stay text, whatever they contain. */
  addLabels(layer, labels, { className = "", priority = 0 } = {}) {
    this.labels?.add(layer, labels, className, priority);
    this.render();
  }

  // Hovering and clicking --------------------------------------------------------------------------------------------

  /**
   * Makes places of a layer answer to the pointer. The callbacks get `data` and the index of the place.
   *
   * @param {number[][]} points  mm, in the layer's own frame
   */
  addTargets(layer, points, data, { priority = 0, radius = 14 } = {}) {
    this.targets.add(layer, flat(points), data, priority, radius);
  }

  /** Calls back with {data, index, p, x, y} when the pointer moves to another target, with null when it leaves one. */
  onHover(callback) {
    this.targets.onHover = callback;
  }

  /** Calls back with the same record for a click (not a drag) on a target, with null for a click on no target. */
  onPick(callback) {
    this.targets.onPick = callback;
  }

  /** Where a pixel of the canvas first meets a part, or one of the given objects: {p, normal, solid} or null. */
  surfaceAt(x, y, objects = this.groups(["part"]).filter(({ visible }) => visible)) {
    const hit = this.ray(x, y)
      .intersectObjects(objects, true)
      .find(({ point, face }) => face && !this.cut.removes(point.toArray()));
    if (!hit) return null;
    const solid = hit.object.userData.solids?.find(({ end }) => hit.faceIndex < end);
    const normal = hit.face.normal.clone().transformDirection(hit.object.matrixWorld);
    return { p: hit.point.toArray(), normal: normal.toArray(), solid: solid?.name ?? null };
  }

  ray(x, y) {
    const caster = new Raycaster();
    const pointer = new Vector2((2 * x) / this.width - 1, 1 - (2 * y) / this.height);
    caster.setFromCamera(pointer, this.camera);
    return caster;
  }

  /** Pixel of the canvas (CSS pixels from its upper left) of a place, its depth (nearer: less), and if it is inside. */
  project(p) {
    const v = new Vector3(...p).project(this.camera);
    const [x, y] = [((v.x + 1) / 2) * this.width, ((1 - v.y) / 2) * this.height];
    return { x, y, depth: v.z, inside: Math.abs(v.x) <= 1 && Math.abs(v.y) <= 1 && Math.abs(v.z) <= 1 };
  }

  /** Takes all clicks as (x, y), in the place of `onPick`; null gives them back. */
  onClick(callback) {
    this.targets.onClick = callback;
  }

  /** Whether faces hide a place; a place on a face is not hidden by that face. */
  isHidden(p) {
    return this.depth.hides(p);
  }

  // Camera ------------------------------------------------------------------------------------------------------------

  /** The groups of the named layers, or of all layers that are shown. */
  groups(names = null) {
    return [...this.layers]
      .filter(([name, group]) => (names ? names.includes(name) : group.visible))
      .map(([, group]) => group);
  }

  /** The sphere around everything shown, or around the named layers. */
  extent(names = null) {
    return sphereAround(placesOf(this.groups(names)));
  }

  /** Looks at everything from a side (`iso`, `front`, `top`, …) or from a direction, so that it fills the view. */
  view(from = "iso", names = null) {
    this.lookAt(placesOf(this.groups(names)), VIEWS[from] ?? from);
  }

  /** Looks at places (Vector3 or [x, y, z], mm) from a direction, so that they fill the view. */
  lookAt(places, direction) {
    const points = places.map((place) => (Array.isArray(place) ? new Vector3(...place) : place));
    const { eye, target } = framed(points, direction, this.camera, MARGIN);
    this.bounds = this.extent();
    this.controls.target.copy(target);
    this.camera.position.copy(eye);
    this.controls.update();
    this.render();
  }

  // Drawing -----------------------------------------------------------------------------------------------------------

  resize() {
    this.width = Math.max(this.canvas.clientWidth, 1);
    this.height = Math.max(this.canvas.clientHeight, 1);
    this.renderer.setPixelRatio(Math.min(devicePixelRatio, 2)); // a finer picture looks the same and is slower
    this.renderer.setSize(this.width, this.height, false);
    this.resolution.set(this.width, this.height);
    this.camera.aspect = this.width / this.height;
    this.draw();
  }

  /** Asks for a drawing before the next frame. */
  render() {
    if (this.asked) return;
    this.asked = true;
    requestAnimationFrame(() => {
      this.asked = false;
      this.draw();
    });
  }

  /** A picture of the view with its labels, as the address of a PNG. */
  picture() {
    this.draw();
    const { width, height } = this.canvas;
    const copy = Object.assign(document.createElement("canvas"), { width, height });
    const context = copy.getContext("2d");
    context.drawImage(this.canvas, 0, 0);
    this.labels?.paint(context, this.renderer.getPixelRatio());
    return copy.toDataURL("image/png");
  }

  draw() {
    fitDepthRange(this.camera, this.bounds ?? new Sphere(new Vector3(), 1000));
    this.renderer.render(this.scene, this.camera);
    this.labels?.place();
    this.outdateDepth();
    clearTimeout(this.resting);
    this.resting = setTimeout(() => this.atRest.forEach((act) => act()), REST_MS);
  }

  /** While the camera does not move, marks and colours change, but what the faces hide stays the same. */
  outdateDepth() {
    const { projectionMatrix, matrixWorld } = this.camera;
    const seen = [...projectionMatrix.elements, ...matrixWorld.elements, this.width, this.height].join();
    if (seen !== this.seen) this.depth.outdate();
    this.seen = seen;
  }
}
