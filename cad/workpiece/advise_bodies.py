"""Which features to teach of a weldment whose bodies may have moved (`wpcal.touch.moved_advice`)."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from cad.workpiece.bodies import BodiesOptions, PartBodies, find_bodies
from cad.workpiece.moved_bodies import USUAL_CONTACT_SHARE, meeting_points
from cad.workpiece.touched_bodies import bodies_at, bodies_touched
from cad.workpiece.workpiece import Workpiece
from wpcal.calibrate.errors.of_bodies import MeetingPoints
from wpcal.calibrate.errors.prediction import Sigma, TeachingError
from wpcal.calibrate.observe.bodies import KeptContacts
from wpcal.calibrate.observe.contacts import find_kept_contacts
from wpcal.calibrate.observe.motions import Motions
from wpcal.calibrate.observe.touches import Touches
from wpcal.core.arrays import FloatArray, IntArray
from wpcal.core.transform import RigidTransform
from wpcal.seam.options import SeamOptions
from wpcal.seam.path.moved import moved_seams
from wpcal.seam.seam import Seam
from wpcal.taught.features import Ease, ReferenceFeature, Touchable
from wpcal.taught.match.places import HARD_TO_FIND
from wpcal.touch.advice import fills_a_plane, require_seams, where_it_is
from wpcal.touch.design import farthest_rows
from wpcal.touch.moved_advice import HowMany, MovedAdvice, TouchChoices, advise_moved
from wpcal.touch.weldment import MovedModel, SeamPoints, Tacked

PER_BODY = 12  #: Features of a body that are judged, far from one another, if there are many bodies.
MOST_CHOICES = 400  #: Features that are judged together.
TOUCHES_PER_BODY = 2  #: How many are advised if nothing is said.


def tacked_bodies(
    workpiece: Workpiece, seams: Sequence[Seam], choice: BodiesOptions, seam_options: SeamOptions
) -> Tacked:
    """Return the bodies of a part with the points of seams at which they meet.

    Raises `InputError` as in `find_bodies`.
    Raises `GeometryError` when there is no seam.
    """
    require_seams(seams)
    part = find_bodies(workpiece.trimmed, choice)
    contacts, gap_mm = KeptContacts.none(), seam_options.gap_for(workpiece.graph)
    if choice.keeps_contacts:
        sigma_mm = choice.contact_sigma_mm or gap_mm * USUAL_CONTACT_SHARE
        contacts = find_kept_contacts(workpiece.trimmed, part.face_body, gap_mm=gap_mm, sigma_mm=sigma_mm)
    return Tacked(part.bodies, part.face_body, _seam_points(workpiece, seams, part), contacts)


def _seam_points(workpiece: Workpiece, seams: Sequence[Seam], part: PartBodies) -> SeamPoints:
    some = [seam for seam in seams if len(seam.frames)]
    still = Motions.rigid(part.bodies, RigidTransform.identity(target="base", source="part"))
    points = [meeting_points(moved) for moved in moved_seams(workpiece.graph, some, part.face_body, still)]
    names = tuple(seam.name for seam in some for _ in range(len(seam.frames)))
    return SeamPoints(MeetingPoints.joined(points), names)


@dataclass(frozen=True, slots=True, eq=False)
class Advisable:
    """What of a part may be taught, and what for."""

    workpiece: Workpiece
    seams: Sequence[Seam]  #: Where the error counts.
    allowed: Sequence[Touchable]  #: What may be taught.
    have: Sequence[ReferenceFeature]  #: What is taught in any case.


def advise_bodies(
    asked: Advisable,
    choice: BodiesOptions,
    *,
    teaching: TeachingError,
    seam_options: SeamOptions,
    touched: Touches | None = None,
    how_many: HowMany | None = None,
) -> MovedAdvice:
    """Choose the features of a weldment to teach whose bodies may have moved.

    On each body the easiest to touch are used. Harder ones join only if the tolerance is not reached without them.

    Raises `InputError` or `GeometryError` as in `find_bodies` and `advise_moved`.
    """
    workpiece, have = asked.workpiece, asked.have
    tacked = tacked_bodies(workpiece, asked.seams, choice, seam_options)
    model, sigma_mm = tacked.model(), Sigma.expected(teaching.per_axis_mm).mm
    taught = {feature.name for feature in have}
    usual = max(TOUCHES_PER_BODY * len(tacked.bodies) - len(taught), 1)
    how_many = replace(how_many or HowMany(usual), usual=usual)
    made = [_of_features(workpiece, tacked, model, have, sigma_mm)]
    if touched is not None:
        made.append(_of_touches(touched, tacked, model, sigma_mm))
    rows, places, _ = (np.concatenate(each) for each in zip(*made, strict=True))
    free = [item for item in asked.allowed if item.feature.name not in taught]
    for is_easy in (True, False):
        advice = advise_moved(
            model,
            _choices(workpiece, tacked, model, free, sigma_mm, is_easy=is_easy),
            tacked.seams,
            how_many,
            have=(rows, places),
            teaching=teaching,
        )
        if not advice.why_not:
            break
    return advice


def _of_touches(
    touched: Touches, tacked: Tacked, model: MovedModel, sigma_mm: float
) -> tuple[FloatArray, FloatArray, IntArray]:
    """Return the rows of touches on faces, edges and points, their places and bodies, as `_of_features`."""
    near, body = touched.targets.nearest(touched.rows, touched.p_base), bodies_touched(touched, tacked.face_body)
    return model.rows(near.p, near.projector / sigma_mm, body), near.p, body


def _of_features(
    workpiece: Workpiece, tacked: Tacked, model: MovedModel, features: Sequence[ReferenceFeature], sigma_mm: float
) -> tuple[FloatArray, FloatArray, IntArray]:
    """Return rows, places and bodies of features, each taught as a point with an error per axis.

    Their shapes are (n, 3, m), (n, 3) and (n,).
    A tip that slides along an edge feels nothing: a place on an edge counts across its edge only.
    """
    p = np.array([feature.p_mm for feature in features]).reshape(-1, 3)
    body = bodies_at(workpiece.graph, p, tacked.face_body)
    felt = np.tile(np.eye(3), (len(p), 1, 1))
    for k, feature in enumerate(features):
        if feature.kind in HARD_TO_FIND and feature.direction is not None:
            felt[k] -= np.outer(feature.direction, feature.direction)
    return model.rows(p, felt / sigma_mm, body), p, body


def _choices(
    workpiece: Workpiece,
    tacked: Tacked,
    model: MovedModel,
    allowed: Sequence[Touchable],
    sigma_mm: float,
    *,
    is_easy: bool,
) -> TouchChoices:
    """Return the features to choose from: on each body the easiest, or all, far from one another."""
    p = np.array([item.feature.p_mm for item in allowed]).reshape(-1, 3)
    body = bodies_at(workpiece.graph, p, tacked.face_body)
    each = max(PER_BODY, MOST_CHOICES // len(tacked.bodies))
    kept = list[int]()
    for b in range(-1, len(tacked.bodies)):
        own = np.flatnonzero(body == b)
        eases = np.array([allowed[k].ease for k in own.tolist()], dtype=np.int64)
        for ease in Ease if is_easy else ():
            easy = own[eases <= ease]
            if len(easy) and fills_a_plane(p[easy]):
                own = easy
                break
        kept += own[farthest_rows(p[own], each)].tolist() if len(own) else []
    features = [allowed[k].feature for k in sorted(kept)]
    rows, p, body = _of_features(workpiece, tacked, model, features, sigma_mm)
    names, where = tuple(each.name for each in features), tuple(where_it_is(each) for each in features)
    return TouchChoices(names, where, body, p, rows)
