"""For scripts: the fit of a weldment whose bodies moved from arrays of touches on plane faces, without a CAD part."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from wpcal.calibrate.errors.of_bodies import MeetingPoints, meeting_errors
from wpcal.calibrate.moved import MovedBodies, fit_moved_bodies
from wpcal.calibrate.observe.bodies import Bodies, TackTolerance
from wpcal.calibrate.observe.touches import Nearest, Touches
from wpcal.calibrate.solve.least_squares import kabsch
from wpcal.core.arrays import FloatArray, IntArray, as_points
from wpcal.core.errors import InputError
from wpcal.core.robot_space import RobotSpace
from wpcal.core.transform import RigidTransform


@dataclass(frozen=True, slots=True, eq=False)
class Planes:
    """Targets that are whole planes: enough for touches within their faces."""

    #: `p`, `n`: shape (m, 3). A point of each plane, and its outward unit normal; `part`, mm.
    p: FloatArray
    n: FloatArray

    def nearest(self, rows: IntArray, points: FloatArray) -> Nearest:
        """As `TouchTargets.nearest`; `rows` has the shape (k,), `points` (k, 3)."""
        n = self.n[rows]
        off = np.einsum("ij,ij->i", points - self.p[rows], n)
        return Nearest(points - off[:, None] * n, n, n[:, :, None] * n[:, None, :])


def calibrate_bodies(
    p_part: ArrayLike,
    normal_part: ArrayLike,
    p_base: ArrayLike,
    body: Sequence[str],
    *,
    sigma_mm: float,
    tack_mm: float = 1.0,
    tack_mrad: float = 3.0,
    estimate: bool = False,
) -> MovedBodies:
    """Fit the pose of a weldment and the motion of each of its bodies to touches on plane faces.

    `p_part`: shape (n, 3). The points that were touched, in the model, mm.
    `normal_part`: shape (n, 3). Outward normals of the faces there.
    `p_base`: shape (n, 3). The touched points, in `base`, mm.
    `body`: The body of each touch. Bodies are in the order in which their names come first, and turn about the middle
    of their touches.

    Returns: ``fit.T_base_part`` is the pose, ``fit.motions`` holds the motions; `predict_body_errors` gives errors.

    Raises `InputError, GeometryError, ConvergenceError` when lengths differ or values cannot be used, the touches leave
    the part free, or the fit does not settle.
    """
    p, n = as_points(p_part, name="points of the model"), as_points(normal_part, name="normals")
    q = as_points(p_base, name="touched points")
    if not len(p) == len(n) == len(q) == len(body):
        raise InputError(f"{len(p)} points, {len(n)} normals, {len(q)} touched points and {len(body)} bodies")
    n = n / np.linalg.norm(n, axis=1, keepdims=True)
    bodies, own = Bodies.of_points(p, body, TackTolerance(tack_mm, tack_mrad))
    R, t = kabsch(p[None], q[None], np.full((1, len(p)), 1.0 / len(p)))
    start = RigidTransform(R[0], t[0], target="base", source="part")
    labels = tuple(f"T{k + 1}" for k in range(len(p)))
    targets: Any = Planes(p, n)  # the fit near a start needs no more of a target
    touches = Touches(labels, q, np.zeros(len(p)), targets, labels, None, RobotSpace.NOMINAL, np.arange(len(p)))
    return fit_moved_bodies(touches, own, bodies, start, sigma_mm=sigma_mm, estimate=estimate)


def predict_body_errors(found: MovedBodies, p_part: ArrayLike, body: Sequence[str]) -> FloatArray:
    """Return the 95 % errors of points that go with one body each, shape (n,), mm.

    `p_part`: shape (n, 3). In the model, mm.
    Raises `InputError` when a body is not one of the fit.
    """
    motions = found.fit.motions
    unknown = [name for name in body if name not in motions.bodies.names]
    if unknown:
        raise InputError(f"no body {unknown[0]!r}; the fit has {', '.join(motions.bodies.names)}")
    own = np.array([motions.bodies.names.index(name) for name in body])
    moved = motions.apply(own, as_points(p_part, name="points"))
    return meeting_errors(found.fit, MeetingPoints.on(own, moved)).total_mm
