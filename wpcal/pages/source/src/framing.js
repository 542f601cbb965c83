// The place of the camera at which the shown objects fill the view.
import { Box3, Matrix4, Sphere, Vector3 } from "three";

const MOST_PLACES = 4000; // per object: enough for its outline
const NOTHING = 100; // mm around the origin, shown when there is no object

/** Places on all objects in some groups; of large objects only some. */
export function placesOf(groups) {
  const found = [];
  for (const group of groups) {
    group.updateWorldMatrix(true, true);
    group.traverse(({ geometry, matrixWorld }) => {
      const attribute = geometry?.attributes.instanceStart ?? geometry?.attributes.position;
      const step = Math.ceil((attribute?.count ?? 0) / MOST_PLACES);
      for (let i = 0; i < attribute?.count; i += step) {
        found.push(new Vector3().fromBufferAttribute(attribute, i).applyMatrix4(matrixWorld));
      }
    });
  }
  return found;
}

export function sphereAround(places) {
  if (!places.length) return new Sphere(new Vector3(), NOTHING);
  return new Box3().setFromPoints(places).getBoundingSphere(new Sphere());
}

/** Eye and target of a camera that looks from a direction at places, with a margin around them. */
export function framed(places, from, camera, margin) {
  const toEye = new Vector3(...from).normalize();
  const right = new Vector3().crossVectors(camera.up, toEye).normalize();
  const axes = new Matrix4().makeBasis(right, new Vector3().crossVectors(toEye, right), toEye);
  const turned = places.map((place) => place.clone().applyMatrix4(axes.clone().transpose()));
  const corner = new Vector3(NOTHING, NOTHING, NOTHING);
  const box = turned.length ? new Box3().setFromPoints(turned) : new Box3(corner.clone().negate(), corner);
  const centre = box.getCenter(new Vector3());
  const tall = Math.tan((camera.fov * Math.PI) / 360) / margin;
  const wide = tall * camera.aspect;
  const distanceOf = ({ x, y, z }) =>
    z - centre.z + Math.max(Math.abs(x - centre.x) / wide, Math.abs(y - centre.y) / tall);
  const nearest = 0.2 * box.getSize(new Vector3()).length(); // keeps the camera away from small objects
  const distance = turned.reduce((most, place) => Math.max(most, distanceOf(place)), nearest);
  const eye = centre
    .clone()
    .setZ(centre.z + distance)
    .applyMatrix4(axes);
  return { eye, target: centre.applyMatrix4(axes) };
}
