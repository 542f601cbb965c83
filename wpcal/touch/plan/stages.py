"""Touches in two stages: large faces first, then the small ones from the place that is known so far.

A face must be larger than the part may be displaced along it. The end of a thin plate is not, until its large faces
were touched. The searches of the first stage are chosen one by one, each where the place of a face is known least. What
they leave is the displacement for which the second stage is planned; this holds the part by itself.
"""

from __future__ import annotations

import numpy as np

from wpcal.brep.graph import BrepGraph, SurfaceKind
from wpcal.core.arrays import FloatArray, IntArray
from wpcal.core.errors import InputError
from wpcal.core.tangent import exp_rotation, point_jacobian
from wpcal.core.transform import RigidTransform
from wpcal.taught.table import TaughtPoints
from wpcal.touch.plan.free import Strokes
from wpcal.touch.plan.options import NominalError
from wpcal.touch.plan.part import PartPlace
from wpcal.touch.searches import FirstStage, TouchPlan

TOUCHED_MM = 0.2
"""Standard deviation of a touch: the search, the robot, and faces that are not quite where the drawing has them. The
stick-out does not count: it is the same in both stages."""
MOST_FIRST = 8  #: Searches of the first stage: it need not find the part, only the way to its small faces.
STEPS = 20  #: Of the fit; each makes what is left a hundred times smaller or more.


def first_stage(
    graph: BrepGraph, strokes: Strokes, place: PartPlace, nominal: NominalError
) -> tuple[IntArray, FirstStage]:
    """Return which searches on planes are made first, rows of shape (k,), and what is known of the place after them."""
    contacts = strokes.contacts
    H = _rows(contacts.p, contacts.normal, place.centre)
    is_plane = graph.face_kind[contacts.face] == SurfaceKind.PLANE
    C, chosen = nominal.covariance, list[int]()
    for _ in range(MOST_FIRST):
        unknown = np.where(is_plane, np.einsum("ni,ij,nj->n", H, C, H), 0.0)
        unknown[chosen] = 0.0
        best = int(np.argmax(unknown))
        if unknown[best] <= 1.0:  # each is known as well as it would be touched
            break
        chosen.append(best)
        C = C - np.outer(C @ H[best], H[best] @ C) / (1.0 + unknown[best])
    return np.array(chosen, dtype=np.int64), FirstStage(place.centre, (C + C.T) / 2.0)


def found_place(plan: TouchPlan, taught: TaughtPoints | None) -> tuple[RigidTransform, FloatArray]:
    """Return ``T_base_part`` after the first stage, and its covariance; what no search sees is as it was planned.

    `taught`: None where both stages are one program, which corrects its frame between them: the place of the plan.

    Raises `InputError` when the plan is not that of a first stage, or a search of it found nothing.
    """
    known = plan.first_stage
    if known is None:
        raise InputError("this plan of touches holds the part by itself: calibrate with it (wpcal calibrate --touches)")
    if taught is None:
        return plan.T_base_part, known.covariance
    searches = [plan.search(name) for name in taught.names]
    if missed := {each.name for each in plan.searches} - {each.name for each in searches}:
        raise InputError(f"{', '.join(sorted(missed))} of the first stage found nothing: the second needs all of them")
    found = ((each.contact_part, each.normal_part, each.radius_mm) for each in searches)
    p, normal, radius = map(np.array, zip(*found, strict=True))
    H, q = _rows(p, normal, known.centre_part), plan.T_base_part.inverse().apply(taught.p_base) - known.centre_part
    moved = np.zeros(6)
    for _ in range(STEPS):
        back = (q - moved[3:]) @ exp_rotation(moved[:3]) - (p - known.centre_part)
        off = (np.einsum("ni,ni->n", back, normal) - radius) / TOUCHED_MM
        moved = known.covariance @ H.T @ (off + H @ moved)
    R = exp_rotation(moved[:3])
    t = known.centre_part + moved[3:] - R @ known.centre_part
    return plan.T_base_part @ RigidTransform(R, t, target="part", source="part"), known.covariance


def _rows(p: FloatArray, normal: FloatArray, centre: FloatArray) -> FloatArray:
    """Return the derivatives of touches by turn and motion, in standard deviations of a touch, shape (n, 6)."""
    return np.asarray(np.einsum("ni,nij->nj", normal, point_jacobian(p - centre)) / TOUCHED_MM)
