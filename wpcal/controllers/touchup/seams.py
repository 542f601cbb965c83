"""The seams of a calibrated part as places: the bodies that they join, and the directions in which these hold them."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from wpcal.brep.mesh import PartMesh, SolidMesh
from wpcal.brep.mesh_glb import read_part_glb
from wpcal.calibrate.corrections import SeamPlaces
from wpcal.core.arrays import FloatArray, IntArray
from wpcal.core.errors import InputError
from wpcal.results.folder import FinishedCalibration
from wpcal.seam.seam import Seam

ON_FACE_MM = 0.6  #: A seam lies on the faces that it joins to within this: a mesh is not the model.
ALONG_FACE = 0.2  #: Most that the normal of such a face leans along the seam, or into the joint.
MOST_PER_SEAM = 9  #: Places that stand for a seam.


@dataclass(frozen=True, eq=False)
class WeldedPart:
    """A calibrated part with the seams that are accepted."""

    finished: FinishedCalibration
    seams: tuple[Seam, ...]

    @classmethod
    def of(cls, finished: FinishedCalibration) -> WeldedPart:
        """Take the accepted seams; `InputError` when there is none."""
        seams = tuple(seam for seam in finished.seams if seam.accepted and len(seam.frames))
        if not seams:
            raise InputError("the calibration has no accepted seam; no program can be compared with it")
        return cls(finished, seams)

    @cached_property
    def kinds(self) -> tuple[str, ...]:
        """The kinds of seams, as ``tee fillet``."""
        return tuple(sorted({_kind(seam) for seam in self.seams}))

    @cached_property
    def bodies(self) -> tuple[str, ...]:
        """Names of the bodies that the seams join."""
        return tuple(sorted({name for seam in self.seams if len(seam.solids) == 2 for name in seam.solids}))

    @cached_property
    def _mesh(self) -> PartMesh | None:
        glb = self.finished.part_glb
        return None if glb is None else read_part_glb(glb)

    @cached_property
    def promised_mm(self) -> dict[str, float]:
        """The largest 95 % error of each seam that the calibration states."""
        named = zip(self.finished.seams, self.finished.u95_mm, strict=True)
        return {seam.name: float(u95.max()) for seam, u95 in named if u95 is not None}

    @cached_property
    def spread(self) -> IntArray:
        """Places that stand for all seams: number of the seam and of its frame, shape (k, 2)."""
        return np.array(
            [
                (i, j)
                for i, seam in enumerate(self.seams)
                for j in np.unique(np.linspace(0, len(seam.frames) - 1, MOST_PER_SEAM).round().astype(int)).tolist()
            ]
        )

    def places(self, rows: IntArray, at: FloatArray | None = None) -> SeamPlaces:
        """Return places on seams.

        `rows`: shape (k, 2). Number of the seam and of its frame.
        `at`: shape (k, 3). The places themselves, mm; None: the frames.
        """
        frames = [(self.seams[i].frames, j) for i, j in rows.tolist()]
        p = np.array([each.p[j] for each, j in frames]).reshape(-1, 3)
        R = np.array([each.R[j] for each, j in frames]).reshape(-1, 3, 3)
        bodies, normals = np.full((len(rows), 2), -1), np.zeros((len(rows), 2, 3))
        for row, side, number, normal in self._sides(rows[:, 0], p, R):
            bodies[row, side], normals[row, side] = number, normal
        kind = np.array([self.kinds.index(_kind(self.seams[i])) for i in rows[:, 0].tolist()], dtype=np.int64)
        return SeamPlaces(p if at is None else at, R, kind, bodies, normals)

    def _sides(
        self, seam: IntArray, p: FloatArray, R: FloatArray
    ) -> Iterator[tuple[IntArray, int, int, FloatArray | float]]:
        """Yield rows of one seam, the side, its body, and the normals there, in `base`."""
        solids = {} if self._mesh is None else {solid.name: solid for solid in self._mesh.solids}
        inside = self.finished.T_base_part.inverse()
        for number in np.unique(seam).tolist():
            names, rows = self.seams[number].solids, np.flatnonzero(seam == number)
            for side, name in enumerate(names if len(names) == 2 else ()):
                normal: FloatArray | float = 0.0
                if name in solids:
                    normal = _normals(solids[name], inside.apply(p[rows]), inside.R @ R[rows]) @ inside.R
                yield rows, side, self.bodies.index(name), normal

    def frames_at(self, points: FloatArray, of_program: Sequence[int]) -> IntArray:
        """Return the seam and the frame of the points of a program, shape (k, 2).

        `points`: shape (k, 3). mm.
        `of_program`: The seam of the program to which each point belongs; its points are on one seam of the part. That
        with the least mean distance is taken: at a corner the ends of several are equally near.
        """
        found, of = np.zeros((len(points), 2), dtype=np.int64), np.asarray(of_program)
        for number in np.unique(of):
            rows = np.flatnonzero(of == number)
            best = int(np.argmin([apart_mm(seam, points[rows]).mean() for seam in self.seams]))
            to_frames = np.linalg.norm(points[rows][:, None] - self.seams[best].frames.p[None], axis=2)
            found[rows, 0], found[rows, 1] = best, np.argmin(to_frames, axis=1)
        return found


def _kind(seam: Seam) -> str:
    return f"{seam.joint.value} {seam.weld.value}"


def apart_mm(seam: Seam, points: FloatArray) -> FloatArray:
    """Return the distance of points from the lines between the frames of a seam, shape (k,)."""
    a, b = seam.frames.p[:-1], seam.frames.p[1:]
    if not len(a):
        return np.asarray(np.linalg.norm(points - seam.frames.p[0], axis=1))
    along, out = b - a, points[:, None] - a[None]
    share = np.einsum("kni,ni->kn", out, along) / np.maximum(np.einsum("ni,ni->n", along, along), 1e-12)
    return np.asarray(np.linalg.norm(out - np.clip(share, 0.0, 1.0)[..., None] * along, axis=2).min(axis=1))


def _normals(solid: SolidMesh, p: FloatArray, R: FloatArray) -> FloatArray:
    """Return the normal of the face of a solid at each place of a seam, shape (k, 3); zero where there is none."""
    corner = solid.points[solid.triangles]
    normal = np.cross(corner[:, 1] - corner[:, 0], corner[:, 2] - corner[:, 0])
    normal = normal / np.maximum(np.linalg.norm(normal, axis=1), 1e-12)[:, None]
    low, high = corner.min(axis=1) - ON_FACE_MM, corner.max(axis=1) + ON_FACE_MM
    found = np.zeros((len(p), 3))
    for row, (x, axes) in enumerate(zip(p, R, strict=True)):
        near = np.flatnonzero(np.all((x >= low) & (x <= high), axis=1))
        near = near[np.abs(np.einsum("ti,ti->t", normal[near], x - corner[near, 0])) <= ON_FACE_MM]
        seen = normal[near] @ axes
        near = near[(np.abs(seen[:, 0]) <= ALONG_FACE) & (seen[:, 2] > ALONG_FACE)]
        if len(near):
            found[row] = normal[near[int(np.argmax(normal[near] @ axes[:, 2]))]]
    return found
