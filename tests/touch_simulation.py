"""Touches without a robot: the wire as a cylinder against the displaced surface, then the fit of what is stored.

Nothing here uses the formulas with which a plan is chosen. The contact is found on the true surface by moving the wire.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from wpcal.brep.surfaces import project_to_faces
from wpcal.calibrate.observe.targets import GraphTargets, TargetKind
from wpcal.calibrate.observe.touches import Touches
from wpcal.calibrate.solve.touches import Pose, fit_squares
from wpcal.core.arrays import FloatArray, IntArray
from wpcal.core.robot_space import RobotSpace
from wpcal.core.tangent import exp_rotation
from wpcal.core.transform import RigidTransform
from wpcal.touch.plan import NominalError, TouchPart
from wpcal.touch.searches import Search
from wpcal.touch.searches.setup import TouchSetup

RIM = 16  #: Points around the wire, at its end and above it.
ABOVE_MM = (0.0, 0.5, 1.0, 2.0, 4.0, 8.0)  #: Heights above the end at which the wire is felt.
CONTACT_MM = 1e-7  #: The wire touches if it is this near.


class MissedError(Exception):
    """The wire touches at the start of its search, or not at all."""


@dataclass(frozen=True, slots=True)
class Simulation:
    """The errors that are simulated."""

    setup: TouchSetup
    nominal: NominalError
    wire_mm: float = 1.2

    def errors(self, part: TouchPart, searches: Sequence[Search], runs: int, seed: int = 1) -> FloatArray:
        """Return how far the points of the seams are from where the fit has them, shape (runs, k), mm.

        A run in which a touch misses is NaN: the part was displaced beyond the 99 % of a stroke.
        """
        rng = np.random.default_rng(seed)
        faces = faces_of(part, searches)
        seam = np.concatenate([each.frames.p for each in part.seams])
        centre = part.graph.vertex_p.mean(axis=0)
        weights = np.stack([search.covariance_part for search in searches])
        found = np.empty((runs, len(seam)))
        for run in range(runs):
            R = exp_rotation(rng.normal(0.0, self.nominal.sigma_rad, 3))
            t = centre - R @ centre + rng.normal(0.0, self.nominal.sigma_mm, 3)
            try:
                stored = self.stored(part, searches, faces, RigidTransform(R, t, "base", "part"), rng)
            except MissedError:
                found[run] = np.nan
                continue
            fitted = fit(part, searches, faces, stored, weights)
            found[run] = np.linalg.norm(seam @ (fitted.R - R).T + fitted.t - t, axis=1)
        return found

    def stored(
        self, part: TouchPart, searches: Sequence[Search], faces: IntArray, T: RigidTransform, rng: np.random.Generator
    ) -> FloatArray:
        """Return the places of the tool centre point that the controller stores, shape (n, 3)."""
        setup = self.setup
        longer = rng.normal(0.0, setup.stick_out_sigma_mm)
        late = rng.normal(0.0, setup.latency_sigma_s) * setup.search_speed_mm_s
        places = [
            contact(part, search, int(face), T, self.wire_mm, longer) + late * search.direction
            for search, face in zip(searches, faces, strict=True)
        ]
        return np.stack(places) + rng.normal(0.0, setup.repeatability_mm, (len(places), 3))


def faces_of(part: TouchPart, searches: Sequence[Search]) -> IntArray:
    """Return the face that each search is meant for: its contact lies on it, with the same normal."""
    every = np.arange(part.graph.face_count)
    found = []
    for search in searches:
        foot = project_to_faces(part.graph, every, np.tile(search.contact_part, (len(every), 1)))
        off = np.linalg.norm(foot.p - search.contact_part, axis=1) + 10.0 * (foot.normal @ search.normal_part < 0.99)
        off += 10.0 * ~part.trimmed.contains(every, foot.uv)
        found.append(int(np.argmin(off)))
        assert off[found[-1]] < 1e-6, search.name
    return np.array(found)


def contact(
    part: TouchPart, search: Search, face: int, T: RigidTransform, wire_mm: float, longer_mm: float
) -> FloatArray:
    """Return where the tool centre point is when the wire first meets the face of the displaced part."""
    x, y, z = search.R_part_tool.T
    turn = np.arange(RIM) * 2.0 * np.pi / RIM
    rim = wire_mm / 2.0 * (np.cos(turn)[:, None] * x + np.sin(turn)[:, None] * y)
    wire = np.concatenate([rim + (longer_mm - above) * z for above in ABOVE_MM])

    def gap(s: float) -> float:
        p = T.inverse().apply(search.start + s * search.direction + wire)
        foot = project_to_faces(part.graph, np.full(len(p), face), p)
        height = np.einsum("ni,ni->n", p - foot.p, foot.normal)
        height[~part.trimmed.contains(np.full(len(p), face), foot.uv)] = np.inf  # beside the face
        return float(height.min())

    low, high = 0.0, search.stroke_mm
    at_low, at_high = gap(low), gap(high)
    if at_low <= 0.0 or at_high >= 0.0:
        raise MissedError(search.name)
    while high - low > CONTACT_MM:
        share = at_low / (at_low - at_high) if np.isfinite(at_low) else 0.5
        middle = low + float(np.clip(share, 0.01, 0.99)) * (high - low)
        here = gap(middle)
        if abs(here) < CONTACT_MM:
            return search.start + middle * search.direction
        if here > 0.0:
            low, at_low = middle, here
        else:
            high, at_high = middle, here
    return search.start + low * search.direction


def fit(
    part: TouchPart, searches: Sequence[Search], faces: IntArray, stored: FloatArray, covariances: FloatArray
) -> Pose:
    """Fit stored places as `wpcal calibrate` does, weighted with the covariances of the plan."""
    n = len(searches)
    kinds = np.full(n, TargetKind.FACE, dtype=np.int64)
    touches = Touches(
        tuple(search.name for search in searches),
        stored,
        np.array([search.radius_mm for search in searches]),
        GraphTargets(part.trimmed, kinds, faces, np.full((n, 3), np.nan)),
        ("",) * n,
        covariances,
        RobotSpace.NOMINAL,
        np.arange(n),
    )
    return fit_squares(touches, Pose.of(touches, np.eye(3), np.zeros(3)), weighted=True)
