// The distance of the nearest face at every pixel: a place behind it is hidden. One drawing and one copy from the
// graphics card answer for all places at once. Rays through every triangle of a large part would be too slow.
import { DoubleSide, ShaderMaterial, Vector3, Vector4, WebGLRenderTarget } from "three";

export const OCCLUDERS = 1; // layer of three.js for objects that can hide others

// In pixels: marks lie on faces, and within one pixel the depth of a face seen at a grazing angle changes a lot.
const SLACK_PX = 10;
const NEIGHBOURS = [-1, 0, 1];

/** Draws the distance along the view, between near and far, as three bytes. */
const material = new ShaderMaterial({
  side: DoubleSide,
  uniforms: { range: { value: new Vector3() }, plane: { value: new Vector4(0, 0, 0, 1) } },
  vertexShader: `
    varying float depth;
    varying vec3 place;
    void main() {
      place = (modelMatrix * vec4(position, 1.0)).xyz;
      vec4 seen = modelViewMatrix * vec4(position, 1.0);
      depth = -seen.z;
      gl_Position = projectionMatrix * seen;
    }`,
  fragmentShader: `
    varying float depth;
    varying vec3 place;
    uniform vec3 range;
    uniform vec4 plane;
    void main() {
      if (dot(plane.xyz, place) + plane.w < 0.0) discard;
      float share = clamp((depth - range.x) / (range.y - range.x), 0.0, 0.999999);
      vec3 bytes = fract(share * vec3(1.0, 255.0, 65025.0));
      bytes.xy -= bytes.yz / 255.0;
      gl_FragColor = vec4(bytes, 1.0);
    }`,
});

export class DepthMap {
  constructor(viewer) {
    this.viewer = viewer;
    this.target = new WebGLRenderTarget(1, 1);
    this.pixels = null;
    this.plane = new Vector4(0, 0, 0, 1); // keeps everything
  }

  /** Faces outside a plane hide nothing; null takes the cut away. */
  cut(plane) {
    this.plane.set(...(plane ? [...plane.normal.toArray(), plane.constant] : [0, 0, 0, 1]));
    this.outdate();
  }

  /** The camera or an object moved: the next question makes a new picture. */
  outdate() {
    this.pixels = null;
  }

  update() {
    const { renderer, scene, camera, width, height } = this.viewer;
    this.target.setSize(width, height);
    material.uniforms.range.value.set(camera.near, camera.far, 0);
    material.uniforms.plane.value.copy(this.plane);
    const mask = camera.layers.mask;
    camera.layers.set(OCCLUDERS);
    scene.overrideMaterial = material;
    renderer.setRenderTarget(this.target);
    renderer.clear();
    renderer.render(scene, camera);
    this.pixels = new Uint8Array(4 * width * height);
    renderer.readRenderTargetPixels(this.target, 0, 0, width, height, this.pixels);
    renderer.setRenderTarget(null);
    scene.overrideMaterial = null;
    camera.layers.mask = mask;
  }

  /** Whether faces are in front of a place (mm). Places outside the picture are not hidden. */
  hides(p) {
    if (!this.pixels) this.update();
    const { camera, width, height } = this.viewer;
    const { x, y, inside } = this.viewer.project(p);
    if (!inside) return false;
    const distance = -new Vector3(...p).applyMatrix4(camera.matrixWorldInverse).z;
    const slack = (SLACK_PX * 2 * distance * Math.tan((camera.fov * Math.PI) / 360)) / height;
    const hiddenAt = (column, row) => this.depthAt(column, row) < distance - slack;
    return NEIGHBOURS.every((dx) =>
      NEIGHBOURS.every((dy) => {
        const column = Math.min(Math.max(Math.floor(x) + dx, 0), width - 1);
        const row = Math.min(Math.max(Math.floor(y) + dy, 0), height - 1);
        return hiddenAt(column, height - 1 - row); // the graphics card counts rows from the bottom
      }),
    );
  }

  depthAt(column, row) {
    const { near, far } = this.viewer.camera;
    const at = 4 * (row * this.viewer.width + column);
    const [a, b, c, drawn] = this.pixels.subarray(at, at + 4);
    return drawn ? near + (far - near) * (a / 255 + b / 65025 + c / 16581375) : Infinity;
  }
}
