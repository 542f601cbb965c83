"""Weldments of real parts whose bodies moved: touches on their faces, and where their seams really are."""

from collections.abc import Collection, Iterator, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

import cad
from tests.samples.uprights import bodies, planned_touches
from tests.weldments import Weldment, fit_bodies
from wpcal.brep.graph import SurfaceKind
from wpcal.brep.surfaces import project_to_faces
from wpcal.brep.trim import TrimmedFaces
from wpcal.calibrate.errors.of_bodies import MeetingErrors, MeetingPoints, meeting_errors
from wpcal.calibrate.observe.bodies import Bodies, TackTolerance
from wpcal.calibrate.observe.motions import Motions
from wpcal.calibrate.observe.targets import GraphTargets, TargetKind
from wpcal.calibrate.solve.bodies import BodiesFit
from wpcal.calibrate.trust.motion_evidence import estimated_tolerances
from wpcal.core.arrays import BoolArray, FloatArray, IntArray
from wpcal.core.tangent import point_jacobian
from wpcal.core.transform import RigidTransform
from wpcal.seam import Seam
from wpcal.seam.options import SeamOptions
from wpcal.seam.path.moved import MovedSeam, StillSeams

SIGMA_MM = 0.2
FIXTURE = Path(__file__).parents[1] / "fixtures" / "uprights" / "uprights.step"
TRIED_PER_FACE = 200  #: Points in the box of a face; those that lie in the face may be touched.
LEAST_RADIUS_MM = 10.0
"""Nobody touches the wall of a bolt hole that is somewhere within a millimetre. Where a body can slide round a wall by
more than a tenth of its radius, the band is too narrow: the normal of the touch is then not known."""
MOST_SEAMS = 12  #: Of a part, evenly chosen: its other seams are between the same bodies.


@dataclass(frozen=True, slots=True, eq=False)
class PartWeldment:
    """A part with several bodies, its seams, and touches on it."""

    seams: StillSeams  #: Accepted ones, each with a few of its frames.
    weldment: Weldment

    def met(self, motions: Motions) -> list[MovedSeam]:
        """Where the seams are when the bodies have moved."""
        return self.seams.moved(motions)


@dataclass(frozen=True, slots=True, eq=False)
class Simulated:
    """One simulated weldment: all points of all seams, n."""

    off_mm: FloatArray  #: shape (n,). Distance of the fitted from the true point.
    across_mm: FloatArray  #: shape (n,). The same across the seam.
    errors: MeetingErrors
    fit: BodiesFit

    @property
    def inside(self) -> BoolArray:
        """Whether the 95 % band covers the true point, shape (n,)."""
        return np.asarray(self.off_mm <= self.errors.total_mm)


def part_weldment(path: Path, *, each: int, on_base: int = 6, frames: int = 3) -> PartWeldment:
    """Open a part, find its seams, and choose touches that say most about its bodies.

    `each`, `on_base`: Touches on each body, and on the largest one.
    `frames`: At most so many of each seam.
    """
    trimmed, seams = _opened(path, frames)
    graph = trimmed.graph
    count = len(graph.solid_names)
    candidates = [face_candidates(trimmed, np.flatnonzero(graph.face_solid == b)) for b in range(count)]
    centroids = np.stack([(p.min(axis=0) + p.max(axis=0)) / 2.0 for _, p, _ in candidates])
    own = Bodies(tuple(graph.solid_names), centroids, (TackTolerance(),) * count)
    largest = int(np.argmax([np.ptp(p, axis=0).max() for _, p, _ in candidates]))
    rows = [
        _telling(candidates[b], centroids[b], own.scales[b], on_base if b == largest else each) for b in range(count)
    ]
    face, p, n = (
        np.concatenate([each_body[k][at] for each_body, at in zip(candidates, rows, strict=True)]) for k in range(3)
    )
    body = np.repeat(np.arange(count), [len(at) for at in rows])
    return PartWeldment(
        StillSeams.of(graph, seams, graph.face_solid), Weldment(own, p, n, body, on_faces(trimmed, face))
    )


def uprights_weldment(each: int) -> PartWeldment:
    """Open `fixtures/uprights` with its own touches and tolerances, so many on each upright."""
    trimmed, seams = _opened(FIXTURE, 3)
    graph, planned = trimmed.graph, planned_touches(each)
    frame = graph.face_frame
    above = np.einsum("fi,nfi->nf", frame[:, 3], planned.p[:, None] - frame[:, 0])
    along = np.einsum("fi,ni->nf", frame[:, 3] * graph.face_outward[:, None], planned.normal)
    fits = (np.abs(above) < 1e-6) & (along > 0.999) & (graph.face_solid == planned.body[:, None])
    targets = on_faces(trimmed, np.argmax(fits, axis=1))
    return PartWeldment(
        StillSeams.of(graph, seams, graph.face_solid),
        Weldment(bodies(), planned.p, planned.normal, planned.body, targets),
    )


def _opened(path: Path, frames: int) -> tuple[TrimmedFaces, tuple[Seam, ...]]:
    found, workpiece = cad.find_seams(cad.open_workpiece(path), SeamOptions())
    accepted = [_thinned(seam, frames) for seam in found if seam.accepted]
    some = np.unique(np.linspace(0, len(accepted) - 1, MOST_SEAMS).astype(int)).tolist()
    return workpiece.trimmed, tuple(accepted[k] for k in some)


def on_faces(trimmed: TrimmedFaces, face: IntArray) -> GraphTargets:
    return GraphTargets(trimmed, np.full(len(face), int(TargetKind.FACE)), face, np.full((len(face), 3), np.nan))


def simulated(
    part: PartWeldment, rng: np.random.Generator, runs: int, factors: Collection[float | None]
) -> Iterator[list[Simulated]]:
    """Draw weldments, touch them, and fit each with tolerances times every factor; None: with estimated ones (REML)."""
    weldment = part.weldment
    for _ in range(runs):
        true = weldment.drawn(rng)
        touches = weldment.touched(true, SIGMA_MM, rng)
        seams = part.met(true)
        fits = []
        for factor in factors:
            fit = weldment.fitted(touches, true.T_base_part, SIGMA_MM, factor or 1.0)
            estimated = estimated_tolerances(fit.whitened, weldment.bodies) if factor is None else None
            if estimated is not None:
                fit = fit_bodies(touches, weldment.body, estimated, true.T_base_part, sigma_mm=SIGMA_MM)
            fits.append(_compared(part, fit, seams, true.T_base_part))
        yield fits


def _compared(part: PartWeldment, fit: BodiesFit, true: Sequence[MovedSeam], T: RigidTransform) -> Simulated:
    found = part.met(fit.motions)
    points = [
        MeetingPoints(s.seam.frames.p, s.wall_body, s.base_body, s.n_wall, s.n_base, s.x_wall, s.is_met) for s in found
    ]
    joined = MeetingPoints(
        *(np.concatenate([getattr(each, name) for each in points]) for name in MeetingPoints.__slots__)
    )
    at = T.apply(np.concatenate([seam.seam.frames.p for seam in true]))
    x = np.concatenate([seam.seam.frames.R[:, :, 0] for seam in true]) @ T.R.T
    off = fit.T_base_part.apply(joined.p_part) - at
    across = off - np.einsum("ni,ni->n", off, x)[:, None] * x
    norms = (np.linalg.norm(each, axis=1) for each in (off, across))
    return Simulated(*norms, meeting_errors(fit, joined), fit)


def _thinned(seam: Seam, most: int) -> Seam:
    frames = seam.frames
    rows = np.unique(np.linspace(0, len(frames) - 1, most).astype(int))
    return replace(seam, frames=frames.select(rows))


def face_candidates(trimmed: TrimmedFaces, faces: IntArray) -> tuple[IntArray, FloatArray, FloatArray]:
    """Faces, points and normals that may be touched, of one body: shapes (k,), (k, 3), (k, 3)."""
    graph, rng = trimmed.graph, np.random.default_rng(0)
    found = []
    is_plane = graph.face_kind[faces] == SurfaceKind.PLANE
    is_round = (graph.face_kind[faces] == SurfaceKind.CYLINDER) & (graph.face_param[faces, 0] >= LEAST_RADIUS_MM)
    for face in faces[is_plane | is_round].tolist():
        border = trimmed.p0[trimmed.start[face] : trimmed.start[face + 1]]
        low, high = border.min(axis=0), border.max(axis=0)
        at = np.full(TRIED_PER_FACE, face)
        foot = project_to_faces(graph, at, low + (high - low) * rng.random((TRIED_PER_FACE, 3)))
        inside = trimmed.contains(at, foot.uv)
        found.append((at[inside], foot.p[inside], foot.normal[inside]))
    face, p, n = (np.concatenate([each[k] for each in found]) for k in range(3))
    return face, p, n


def _telling(
    candidates: tuple[IntArray, FloatArray, FloatArray], centroid: FloatArray, scales: FloatArray, count: int
) -> IntArray:
    """Choose touches one after the other, each where the motion of the body is least known, shape (count,)."""
    _, p, n = candidates
    rows = np.einsum("ki,kij->kj", n, point_jacobian(p - centroid)) * scales / SIGMA_MM
    C, chosen = np.eye(6), []
    for _ in range(count):
        spread = np.einsum("ki,ij,kj->k", rows, C, rows)
        best = int(np.argmax(spread))
        chosen.append(best)
        C = C - np.outer(C @ rows[best], rows[best] @ C) / (1.0 + spread[best])
    return np.array(chosen)
