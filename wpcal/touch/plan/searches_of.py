"""A stroke written as a search of the plan, and the search on a post."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from wpcal.core.arrays import FloatArray
from wpcal.core.transform import RigidTransform
from wpcal.taught.features.reference import FeatureKind
from wpcal.touch.plan.contacts import word_of
from wpcal.touch.plan.free import APPROACH_MM, Strokes, tool_axes
from wpcal.touch.plan.options import TouchOptions
from wpcal.touch.plan.part import TouchPart
from wpcal.touch.searches import Contact, Search, SearchKind

ROUND = ("cylinder", "hole")
SAME_AXIS_MM = 0.01  #: A wall belongs to the hole whose axis is this near to its own.
POST_ROOM_MM = 10.0
"""The search on the post begins and ends this far from it: more than the wire is ever too long or too short."""


def stick_out_sigma_mm(options: TouchOptions) -> float:
    """Return what is not known of the stick-out: with a post, only the error of the touch on it."""
    return options.setup.repeatability_mm if options.post_base is not None else options.setup.stick_out_sigma_mm


def search_of(part: TouchPart, strokes: Strokes, row: int, name: str, via: FloatArray, options: TouchOptions) -> Search:
    """Return one stroke as a search. `via`: shape (k, 3). Points on the way to its approach, in `part`, mm."""
    one = strokes.select(np.array([row]))
    contacts, setup = one.contacts, options.setup
    face, wire, normal = int(contacts.face[0]), contacts.wire[0], contacts.normal[0]
    late = setup.latency_sigma_s * setup.search_speed_mm_s
    covariance = setup.repeatability_mm**2 * np.eye(3)
    covariance += stick_out_sigma_mm(options) ** 2 * np.outer(wire, wire) + late**2 * np.outer(normal, normal)
    return Search(
        name,
        word_of(part.graph, face),
        _feature(part, face),
        contacts.p[0],
        normal,
        Contact.END if contacts.cos_angle[0] > np.cos(np.radians(20.0)) else Contact.SIDE,
        float(one.radius_mm[0]),
        tool_axes(one)[0],
        via,
        one.approach[0],
        one.at(one.before_mm)[0],
        one.at(-one.after_mm)[0],
        one.approach[0],
        covariance,
        axis=part.graph.face_frame[face][[0, 3]] if word_of(part.graph, face) in ROUND else None,
    )


def _feature(part: TouchPart, face: int) -> str:
    """Return the name of the hole that a wall belongs to, or nothing."""
    if word_of(part.graph, face) != "hole":
        return ""
    origin, axis = part.graph.face_frame[face, 0], part.graph.face_frame[face, 3]
    solid = part.graph.solid_names[part.graph.face_solid[face]]
    for feature in part.features:
        if feature.kind is FeatureKind.HOLE and feature.solid == solid:
            off = feature.p_mm - origin
            same = feature.diameter_mm is None or abs(feature.diameter_mm / 2 - part.graph.face_param[face, 0]) < 1e-3
            if same and np.linalg.norm(off - (off @ axis) * axis) <= SAME_AXIS_MM:
                return feature.name
    return ""


def post_search(options: TouchOptions, T_base_part: RigidTransform, up: FloatArray, safe_mm: float) -> Search:
    """Return the search down on the middle of the post's top; `up`, of shape (3,), is in `part`."""
    p = T_base_part.inverse().apply(np.array(options.post_base))
    x = np.cross(up, np.eye(3)[np.argmin(np.abs(up))])
    x /= np.linalg.norm(x)
    R = np.stack([x, np.cross(-up, x), -up], axis=1)
    start, end = p + POST_ROOM_MM * up, p - POST_ROOM_MM * up
    approach = start + APPROACH_MM * up
    via = (approach + max(safe_mm - float(approach @ up), 0.0) * up)[None]
    covariance = options.setup.repeatability_mm**2 * np.eye(3)
    none = Search("POST", "plane", "", p, up, Contact.END, 0.0, R, via, approach, start, end, approach, covariance)
    return replace(none, kind=SearchKind.POST)
