// Lines and points with sizes in pixels. They are drawn a little in front of their places: a seam lies in the corner of
// two faces, and half of its line would be inside them.
import { BufferAttribute, BufferGeometry, Color, Points, PointsMaterial } from "three";
import { LineMaterial } from "three/examples/jsm/lines/LineMaterial.js";
import { LineSegments2 } from "three/examples/jsm/lines/LineSegments2.js";
import { LineSegmentsGeometry } from "three/examples/jsm/lines/LineSegmentsGeometry.js";

const LINE_LIFT_PX = 6; // towards the eye: a line of 5 px in a right-angled corner is fully visible
// In front of the lines that end at the point, and equal to the slack of `depth.js`: a visible point can be clicked.
const POINT_LIFT_PX = 10;

/** GLSL that moves only the depth of gl_Position towards the eye, by a length given in pixels. */
const lifting = (px) => `
  {
    float eyeZ = -gl_Position.w;
    float pixel = 2.0 * gl_Position.w / (projectionMatrix[1][1] * viewSize.y);
    float lifted = eyeZ + ${px.toFixed(1)} * pixel;
    gl_Position.z = (projectionMatrix[2][2] * lifted + projectionMatrix[3][2]) / -lifted * gl_Position.w;
  }
`;

function lift(material, after, px, resolution) {
  material.onBeforeCompile = (shader) => {
    const lifted = shader.vertexShader.replace(after, (line) => `${line}\n${lifting(px)}`);
    if (lifted === shader.vertexShader) throw new Error(`three.js has no '${after}' in this shader any more`);
    shader.uniforms.viewSize = { value: resolution };
    shader.vertexShader = `uniform vec2 viewSize;\n${lifted}`;
  };
}

/** Segments with a colour at each end. The view keeps `resolution` up to date. */
export function fatLines(positions, colors, { width, opacity, dashed, resolution }) {
  const geometry = new LineSegmentsGeometry();
  geometry.setPositions(positions);
  geometry.setColors(colors);
  const material = new LineMaterial({
    vertexColors: true,
    linewidth: width,
    transparent: opacity < 1,
    opacity,
    dashed,
  });
  material.uniforms.resolution.value = resolution;
  if (dashed) Object.assign(material, { dashSize: 4, gapSize: 3 });
  lift(material, "gl_Position = clip;", LINE_LIFT_PX, resolution);
  const lines = new LineSegments2(geometry, material);
  if (dashed) lines.computeLineDistances();
  lines.onBeforeRender = () => {}; // the class would overwrite the shared resolution
  return lines;
}

/** Points as discs with a white rim; `resolution` as for lines. Their attribute `share` scales each of them. */
export function roundPoints(points, sizePx, resolution) {
  const geometry = new BufferGeometry();
  geometry.setAttribute("position", new BufferAttribute(new Float32Array(points.flatMap(({ p }) => p)), 3));
  geometry.setAttribute(
    "color",
    new BufferAttribute(new Float32Array(points.flatMap(({ color }) => linear(color))), 3),
  );
  geometry.setAttribute("share", new BufferAttribute(new Float32Array(points.length).fill(1), 1));
  const material = new PointsMaterial({ size: sizePx, sizeAttenuation: false, vertexColors: true });
  lift(material, "#include <project_vertex>", POINT_LIFT_PX, resolution);
  const lifted = material.onBeforeCompile;
  material.onBeforeCompile = (shader) => {
    lifted(shader);
    const scaled = shader.vertexShader.replace(
      "gl_PointSize = size;",
      "gl_PointSize = size * share;\n  shown = share;",
    );
    if (scaled === shader.vertexShader) throw new Error("three.js sets the size of points in another way");
    shader.vertexShader = `attribute float share;\nvarying float shown;\n${scaled}`;
    shader.fragmentShader = `varying float shown;\n${shader.fragmentShader}`.replace(
      "#include <color_fragment>",
      `#include <color_fragment>
       float r = length(gl_PointCoord - 0.5);
       if (r > 0.5 || shown == 0.0) discard;
       if (r > 0.36) diffuseColor.rgb = vec3(1.0);`,
    );
  };
  return new Points(geometry, material);
}

function linear(color) {
  return new Color(color).toArray();
}

/** Segments of paths {points, colors | color}, with colours made linear. */
export function segmentsOfPaths(paths) {
  const [positions, colors, known] = [[], [], new Map()]; // thousands of points share a few colours
  const linearOf = (name) => known.get(name) ?? known.set(name, linear(name)).get(name);
  for (const { points, colors: own, color } of paths) {
    const one = own ? null : linearOf(color);
    for (let i = 0; i + 1 < points.length; i += 1) {
      positions.push(...points[i], ...points[i + 1]);
      colors.push(...(one ?? linearOf(own[i])), ...(one ?? linearOf(own[i + 1])));
    }
  }
  return { positions: new Float32Array(positions), colors: new Float32Array(colors) };
}
