"""The ways through the air beside a part that does not stand where it is planned.

The part is displaced in drawn directions of its six freedoms, along each as far as 99 % of the places reach: as far as
the strokes of the searches are made for. Between the drawn directions nothing is compared. A torch beside a displaced
part is the same as a torch displaced the other way beside the planned part.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from scipy.special import chdtri

from wpcal.brep.graph import BrepGraph
from wpcal.brep.material import Material, TriangleMaterial
from wpcal.core.arrays import BoolArray, FloatArray, IntArray
from wpcal.core.tangent import exp_rotation, point_jacobian
from wpcal.robot.moves.sweep import poses_between
from wpcal.robot.torch.shape import TorchShape
from wpcal.touch.plan.free import APPROACH_MM, Strokes, tool_axes, torch_keeps_away
from wpcal.touch.plan.options import HIT_LEVEL, NominalError
from wpcal.touch.plan.part import PartPlace
from wpcal.touch.weldment import Tacked

PLACES = 48  #: Displaced places of the part, drawn with a fixed seed.
USUAL_BODIES, LEAST_PLACES = 5, 12
"""Up to five bodies each have as many places of their own; of more bodies each has fewer, but not fewer than twelve."""
STEP_MM = 4.0  #: Places on a straight way are this far apart; the torch is felt wider by half of it.
STEP_RAD = math.radians(5.0)  #: And the torch turns by at most this between them.
WITHIN_MM = 0.1
"""Along its own axis the wire is felt thinner by this: at the start it may have no more room than it needs."""


@dataclass(frozen=True, slots=True, eq=False)
class DisplacedBody:
    """What moves as one, at all places where it may stand."""

    material: Material  #: As planned.
    #: `R`, `t`: shapes (k, 3, 3), (k, 3). Its displacements about the centre of the part, mm.
    R: FloatArray
    t: FloatArray


@dataclass(frozen=True, slots=True, eq=False)
class DisplacedPart:
    """A part at all places where it may stand."""

    bodies: tuple[DisplacedBody, ...]  #: One of a part that moves as one.
    centre: FloatArray  #: shape (3,). About which it is turned, in `part`, mm.
    standoff_mm: float = 0.0  #: Of the tool beside it: see `poses_between`.

    @classmethod
    def of(cls, material: Material, centre: FloatArray, nominal: NominalError) -> DisplacedPart:
        """Draw the displacements about a centre, shape (3,), in `part`, mm."""
        drawn = _drawn(np.random.default_rng(0), PLACES, 6) @ nominal.root.T
        return cls((DisplacedBody(material, exp_rotation(drawn[:, :3]), drawn[:, 3:]),), centre)

    @classmethod
    def of_bodies(
        cls, material: Material, graph: BrepGraph, place: PartPlace, tacked: Tacked, nominal: NominalError
    ) -> DisplacedPart:
        """Draw displacements of the whole, and of each body within it."""
        rng, bodies, found = np.random.default_rng(0), tacked.bodies, []
        places = max(LEAST_PLACES, PLACES * USUAL_BODIES // max(len(bodies), USUAL_BODIES))
        for b in range(len(bodies)):
            arm = bodies.centroid_part[b] - place.centre
            whole = np.eye(6)
            whole[3:] = point_jacobian(arm[None])[0]  # its turn about the middle of the part moves the centroid
            known = whole @ nominal.covariance @ whole.T
            both = _drawn(rng, places, 6) @ np.linalg.cholesky(known + np.diag(bodies.scales[b] ** 2)).T
            R = exp_rotation(both[:, :3])
            t = arm + both[:, 3:] - R @ arm
            solids = np.unique(graph.face_solid[tacked.face_body == b])
            found.append(DisplacedBody(_of_solids(material, solids, graph), R, t))
        return cls(tuple(found), place.centre)

    def lets_pass(
        self, torch: TorchShape, wire_mm: float, p: FloatArray, R: FloatArray, *, along_wire: bool = False
    ) -> bool:
        """Tell whether a torch passes it on straight ways, wherever it stands.

        `p`: shape (m, 3). Points of the way of the tip of the wire, in `part`, mm.
        `R`: shape (m, 3, 3). Axes of the tool there; it turns evenly between them.
        """
        tips, axes, _ = poses_between(p, R, STEP_MM, STEP_RAD, self.standoff_mm)
        felt_mm = wire_mm - WITHIN_MM if along_wire else wire_mm + STEP_MM
        return bool(self._is_free(torch, felt_mm, tips, axes).all())

    def lets_through(self, torch: TorchShape, wire_mm: float, p: FloatArray, R: FloatArray) -> bool:
        """Tell whether a torch passes it at poses, shapes (n, 3), (n, 3, 3), at most `STEP_MM` apart."""
        return bool(self._is_free(torch, wire_mm + STEP_MM, p, R).all())

    def lets_start(self, strokes: Strokes, torch: TorchShape, wire_mm: float) -> BoolArray:
        """Tell at which searches the torch comes to the start wherever the part stands, shape (n,)."""
        free = np.ones(len(strokes), dtype=bool)
        start, R = strokes.at(strokes.before_mm), tool_axes(strokes)
        for back_mm in np.arange(0.0, APPROACH_MM + 0.1, 2.0 * STEP_MM):
            rows = np.flatnonzero(free)
            tips = start[rows] - back_mm * strokes.contacts.wire[rows]
            free[rows] = self._is_free(torch, wire_mm - WITHIN_MM, tips, R[rows])
        return free

    def _is_free(self, torch: TorchShape, felt_mm: float, tips: FloatArray, axes: FloatArray) -> BoolArray:
        """Tell at which poses the torch is free of the part at all its places, shape (n,)."""
        free = np.ones(len(tips), dtype=bool)
        for body in self.bodies:
            rows = np.flatnonzero(free)
            away = tips[rows] - self.centre - body.t[:, None]
            moved = self.centre + np.einsum("kji,knj->kni", body.R, away)
            turned = np.einsum("kji,njl->knil", body.R, axes[rows]).reshape(-1, 3, 3)
            clear = np.full(len(turned), STEP_MM / 2.0)
            is_free = torch_keeps_away([body.material], torch, moved.reshape(-1, 3), turned, clear, wire_mm=felt_mm)
            free[rows] = is_free.reshape(len(body.R), -1).all(axis=0)
        return free


def _drawn(rng: np.random.Generator, places: int, freedoms: int) -> FloatArray:
    """Draw directions of the freedoms, each as far as 99 % of the places reach along it, shape (places, freedoms)."""
    drawn = rng.standard_normal((places, freedoms))
    drawn *= math.sqrt(chdtri(1, 1.0 - HIT_LEVEL)) / np.linalg.norm(drawn, axis=1, keepdims=True)
    return np.asarray(drawn)


def _of_solids(material: Material, solids: IntArray, graph: BrepGraph) -> Material:
    """Return the material of some solids; the whole, which keeps farther away, where it cannot be divided."""
    if not isinstance(material, TriangleMaterial) or len(material.names) != len(graph.solid_names):
        return material
    return material.of_solids(solids)
