"""A weldment of plane faces whose plates moved: touches of it, and where its seams really are."""

from dataclasses import dataclass
from typing import Any

import numpy as np

from wpcal.calibrate.moved import MovedBodies, fit_moved_bodies
from wpcal.calibrate.observe.bodies import Bodies, KeptContacts, TackTolerance
from wpcal.calibrate.observe.motions import Motions
from wpcal.calibrate.observe.touches import Touches, TouchTargets
from wpcal.calibrate.plane_touches import Planes
from wpcal.calibrate.solve.bodies import BodiesFit, begin_bodies, fit_begun
from wpcal.core.arrays import FloatArray, IntArray
from wpcal.core.robot_space import RobotSpace
from wpcal.core.tangent import exp_rotation
from wpcal.core.transform import RigidTransform


def fit_bodies(*of: Any, **known: Any) -> BodiesFit:
    return fit_begun(*begin_bodies(*of, **known))


@dataclass(frozen=True, slots=True, eq=False)
class Weldment:
    """Bodies that may move, and where they are touched."""

    bodies: Bodies  #: The base first.
    #: `p`, `n`: shape (m, 3). Touched points and outward normals, in the model, mm.
    p: FloatArray
    n: FloatArray
    body: IntArray  #: shape (m,).
    targets: TouchTargets  #: One row for each touch.

    def drawn(self, rng: np.random.Generator, *, scale: float = 1.0) -> Motions:
        """Draw where a real part stands, and how its bodies moved: within their tolerances times `scale`."""
        T = RigidTransform(
            exp_rotation(rng.normal(size=3) * 0.3), rng.normal(size=3) * 100.0, target="base", source="part"
        )
        u = rng.normal(size=(len(self.bodies), 6)) * self.bodies.scales * scale
        return Motions(self.bodies, T, u[:, :3], u[:, 3:])

    def touched(self, true: Motions, sigma_mm: float, rng: np.random.Generator) -> Touches:
        """Touch it."""
        R, t = true.poses_of(self.body)
        q = np.einsum("nij,nj->ni", R, self.p) + t + sigma_mm * rng.normal(size=self.p.shape)
        n = len(q)
        names = tuple(f"T{i}" for i in range(n))
        return Touches(names, q, np.zeros(n), self.targets, names, None, RobotSpace.NOMINAL, np.arange(n))

    def targets_at(self, rows: IntArray) -> Planes:
        """Return the planes of some touches, of shape (k,)."""
        return Planes(self.p[rows], self.n[rows])

    def moved(self, touches: Touches, start: RigidTransform, sigma_mm: float, **known: Any) -> MovedBodies:
        """Fit it as it is fitted in use, where tolerances are not estimated."""
        return fit_moved_bodies(touches, self.body, self.bodies, start, sigma_mm=sigma_mm, estimate=False, **known)

    def fitted(self, touches: Touches, start: RigidTransform, sigma_mm: float, factor: float = 1.0) -> BodiesFit:
        """Fit it with tolerances times `factor`."""
        return fit_bodies(touches, self.body, self.bodies.scaled(factor, factor), start, sigma_mm=sigma_mm)


def uprights(touches_each: int, *, on_base: int = 6) -> Weldment:
    """Build the weldment with so many touches on every upright: on its large face, its end and its top.

    `touches_each`: At most 6.
    `on_base`: At most 6: three on the top, two on a long side, one on a short one.
    """
    base = [
        ((-280, -180, 0), (0, 0, 1)), ((280, -180, 0), (0, 0, 1)), ((0, 180, 0), (0, 0, 1)),
        ((-280, -200, -5), (0, -1, 0)), ((280, -200, -5), (0, -1, 0)), ((-300, 0, -5), (-1, 0, 0)),
    ]  # fmt: skip
    p, n, body = [], [], []
    for point, normal in base[:on_base]:
        p.append(point), n.append(normal), body.append(0)
    centres = [(0.0, 0.0, -5.0)]
    for k, (x, y, angle) in enumerate([(-120, -120, 0), (180, 0, 90), (60, 120, 20), (-120, 60, 0)], start=1):
        a = np.radians(angle)
        along, out, up = np.array([np.cos(a), np.sin(a), 0]), np.array([-np.sin(a), np.cos(a), 0]), np.array([0, 0, 1])
        centre = np.array([x, y, 60.0])
        centres.append(tuple(centre))
        own = [
            (centre - 130 * along + 4 * out - 40 * up, out), (centre + 130 * along + 4 * out - 30 * up, out),
            (centre + 4 * out + 50 * up, out), (centre - 100 * along + 60 * up, up),
            (centre + 100 * along + 60 * up, up),
            (centre - 150 * along, -along),
        ]  # fmt: skip
        for point, normal in own[:touches_each]:
            p.append(point), n.append(normal), body.append(k)
    bodies = Bodies(("base", "U1", "U2", "U3", "U4"), np.array(centres), (TackTolerance(1.0, 4.0),) * 5)
    points, normals = np.array(p, dtype=float), np.array(n, dtype=float)
    return Weldment(bodies, points, normals, np.array(body), Planes(points, normals))


def contacts_of_uprights(sigma_mm: float) -> KeptContacts:
    """Corners of the feet of the four uprights of `tests.weldments.uprights`, with the base."""
    part = uprights(2)
    p, second = [], []
    for b in range(1, 5):
        n = part.n[np.flatnonzero(part.body == b)[0]]
        along = np.cross(n, [0.0, 0.0, 1.0])
        foot = part.bodies.centroid_part[b] * [1.0, 1.0, 0.0]
        p += [foot + s * 150.0 * along + t * 4.0 * n for s in (-1, 1) for t in (-1, 1)]
        second += [b] * 4
    k = len(p)
    up = np.tile([0.0, 0.0, 1.0], (k, 1))
    return KeptContacts(np.array(p), up, np.zeros(k, dtype=np.int64), np.array(second), np.full(k, sigma_mm))
