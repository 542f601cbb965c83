// The camera of the view: its lights, its controls, and the range of depth that it sees.
import { AmbientLight, DirectionalLight, PerspectiveCamera, Quaternion, Spherical, Vector3 } from "three";
import { OrbitControls } from "three/examples/jsm/controls/OrbitControls.js";

const FIELD_OF_VIEW_DEG = 28; // narrow: parallel edges look parallel, as on a drawing

/** The directions from which the view can be looked at: from the target to the eye. */
export const VIEWS = {
  iso: [-0.62, -0.68, 0.5],
  front: [0, -1, 0],
  back: [0, 1, 0],
  left: [-1, 0, 0],
  right: [1, 0, 0],
  top: [0, -1e-4, 1], // slightly tilted: straight down, "up" would be undefined
  bottom: [0, -1e-4, -1],
};

/** A camera with z up whose lights move with it, so that no visible side of the part is black. */
export function cameraWithLights(scene) {
  const camera = new PerspectiveCamera(FIELD_OF_VIEW_DEG, 1, 1, 1000);
  camera.up.set(0, 0, 1);
  const key = new DirectionalLight("#ffffff", 2.1);
  key.position.set(-0.5, 0.9, 1);
  const fill = new DirectionalLight("#ffffff", 0.55);
  fill.position.set(1, -0.6, 0.4);
  camera.add(key, fill);
  scene.add(camera, new AmbientLight("#ffffff", 1.05));
  return camera;
}

/**
 * Drag, wheel and touch.
 *
 * @param {"always"|"after-press"} wheel  "after-press": the wheel zooms after a press on the canvas, until the pointer
 *   leaves it, so that the wheel scrolls a long page
 */
export function controlsOf(camera, canvas, wheel, onChange) {
  const controls = new OrbitControls(camera, canvas);
  controls.rotateSpeed = 0.8;
  controls.zoomToCursor = true;
  controls.enableZoom = wheel === "always" || matchMedia("(pointer: coarse)").matches;
  controls.addEventListener("change", onChange);
  if (wheel === "after-press") {
    canvas.addEventListener("pointerdown", () => {
      controls.enableZoom = true;
    });
    canvas.addEventListener("pointerleave", (event) => {
      if (event.pointerType === "mouse") controls.enableZoom = false;
    });
  }
  return controls;
}

const TURN_RAD = Math.PI / 24; // by one press of an arrow key
const ZOOM = 1.15; // by one press of + or -
const PAN = 0.06; // of the distance, by one press with Shift

/**
 * Keys on the canvas: arrows turn, with Shift they move the view; + and - zoom, Home shows everything.
 *
 * @param {function()} onHome
 */
export function listenToKeys(canvas, controls, onHome) {
  const camera = controls.object;
  const arm = new Vector3();
  const sphere = new Spherical();
  const upright = new Quaternion().setFromUnitVectors(camera.up, new Vector3(0, 1, 0));
  const turn = (right, up) => {
    arm.copy(camera.position).sub(controls.target).applyQuaternion(upright);
    sphere.setFromVector3(arm);
    sphere.theta += right * TURN_RAD;
    sphere.phi -= up * TURN_RAD;
    sphere.makeSafe();
    arm.setFromSpherical(sphere).applyQuaternion(upright.clone().invert());
    camera.position.copy(controls.target).add(arm);
  };
  const shift = (right, up) => {
    const distance = camera.position.distanceTo(controls.target);
    const move = new Vector3(right, up, 0).multiplyScalar(PAN * distance).applyQuaternion(camera.quaternion);
    camera.position.add(move);
    controls.target.add(move);
  };
  const zoom = (factor) => {
    arm.copy(camera.position).sub(controls.target).multiplyScalar(factor);
    camera.position.copy(controls.target).add(arm);
  };
  const ways = {
    ArrowLeft: (move) => move(-1, 0),
    ArrowRight: (move) => move(1, 0),
    ArrowUp: (move) => move(0, 1),
    ArrowDown: (move) => move(0, -1),
    "+": () => zoom(1 / ZOOM),
    "=": () => zoom(1 / ZOOM),
    "-": () => zoom(ZOOM),
    Home: onHome,
  };
  canvas.addEventListener("keydown", (event) => {
    const { key } = event;
    if (event.ctrlKey || event.metaKey || event.altKey || !(key in ways)) return;
    ways[key](event.shiftKey ? shift : turn);
    event.preventDefault();
    controls.update();
  });
}

/** Sets the range of depth to what is shown: a sphere around everything. */
export function fitDepthRange(camera, { center, radius }) {
  const distance = camera.position.distanceTo(center);
  camera.near = Math.max((distance - 2 * radius) * 0.9, radius / 500);
  camera.far = distance + 4 * radius;
  camera.updateProjectionMatrix();
  camera.updateMatrixWorld();
}
