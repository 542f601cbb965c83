"""Recognise B-splines that are planes, cylinders, cones, spheres, lines or circles.

Some exporters write every surface as a B-spline. Without this step, such a file has no holes and no datum planes.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from OCP.BRep import BRep_Tool
from OCP.BRepBuilderAPI import BRepBuilderAPI_MakeFace
from OCP.Geom import Geom_RectangularTrimmedSurface
from OCP.GeomAbs import GeomAbs_CurveType
from OCP.gp import gp_Cone, gp_Cylinder, gp_Pln, gp_Sphere
from OCP.ShapeAnalysis import ShapeAnalysis_CanonicalRecognition

from cad.kernel.call import KERNEL_EXCEPTIONS
from wpcal.brep import CurveKind, SurfaceKind
from wpcal.core.arrays import FloatArray

SAME_SHAPE_MM = 1e-3
"""A B-spline this close to a plane, cylinder, circle … counts as one. Exporters approximate to 1e-4 mm."""
CRUMB_MM = 1e-5  #: A curve shorter than this is a line, whatever it is: the kernel cannot cut it from a spline.


def recognise_surface(face: Any) -> tuple[int, Any] | None:
    """Return the kind and the kernel's elementary surface; None when no surface fits within `SAME_SHAPE_MM`.

    A surface on which the kernel's recognition fails counts as free-form.
    """
    try:
        return _recognised(_on_its_basis(face))
    except KERNEL_EXCEPTIONS:
        return None


def _on_its_basis(face: Any) -> Any:
    """Return a face on the basis of a trimmed surface, on which the recognition would fail; other faces as they are."""
    surface = BRep_Tool.Surface_s(face)
    if not isinstance(surface, Geom_RectangularTrimmedSurface):
        return face
    return BRepBuilderAPI_MakeFace(surface.BasisSurface(), *surface.Bounds(), SAME_SHAPE_MM).Face()


def _recognised(face: Any) -> tuple[int, Any] | None:
    analysis = ShapeAnalysis_CanonicalRecognition(face)
    for kind, surface, matches in (
        (SurfaceKind.PLANE, gp_Pln(), analysis.IsPlane),
        (SurfaceKind.CYLINDER, gp_Cylinder(), analysis.IsCylinder),
        (SurfaceKind.CONE, gp_Cone(), analysis.IsCone),
        (SurfaceKind.SPHERE, gp_Sphere(), analysis.IsSphere),
    ):
        if matches(SAME_SHAPE_MM, surface):
            return int(kind), surface
    return None


@dataclass(frozen=True, slots=True, eq=False)
class RecognisedCurve:
    """A line or circle that a curve of another kind was recognised as. Its own parameter runs the same way."""

    kind: CurveKind
    #: shape (4, 3). As in `BrepGraph.edge_frame`, mm. A line starts at the curve's first point; a circle has it on its
    #: x axis.
    frame: FloatArray
    radius: float  #: mm; 0 for a line.
    span: tuple[float, float]  #: First and last parameter.


SAMPLES_PER_SPAN = 9
"""Points tested per span: a B-spline of one span that agrees with a circle at nine points is that circle."""


def recognise_curve(adaptor: Any) -> RecognisedCurve | None:
    """Return the line or circle within `SAME_SHAPE_MM` of an edge's curve, or None."""
    first, last = adaptor.FirstParameter(), adaptor.LastParameter()
    spans = adaptor.NbKnots() - 1 if adaptor.GetType() == GeomAbs_CurveType.GeomAbs_BSplineCurve else 1
    samples = SAMPLES_PER_SPAN * max(1, spans)
    values = [adaptor.Value(t) for t in np.linspace(first, last, samples)]
    points = np.array([(p.X(), p.Y(), p.Z()) for p in values])
    return _as_line(points) or _as_circle(points)


def _as_line(points: FloatArray) -> RecognisedCurve | None:
    run = points[-1] - points[0]
    length = float(np.linalg.norm(run))
    if np.linalg.norm(points - points[0], axis=1).max() <= CRUMB_MM:
        x = run / length if length > 0.0 else np.array([1.0, 0.0, 0.0])
        return RecognisedCurve(CurveKind.LINE, np.array([points[0], x, np.zeros(3), np.zeros(3)]), 0.0, (0.0, length))
    if length <= SAME_SHAPE_MM:
        return None
    x = run / length
    along = (points - points[0]) @ x
    off = np.linalg.norm(points - points[0] - along[:, None] * x, axis=1)
    if off.max() > SAME_SHAPE_MM or (np.diff(along) <= 0).any():
        return None
    return RecognisedCurve(CurveKind.LINE, np.array([points[0], x, np.zeros(3), np.zeros(3)]), 0.0, (0.0, length))


def _as_circle(points: FloatArray) -> RecognisedCurve | None:
    centre0 = points.mean(axis=0)
    _, _, axes = np.linalg.svd(points - centre0, full_matrices=False)
    flat = (points - centre0) @ axes.T
    if np.abs(flat[:, 2]).max() > SAME_SHAPE_MM:
        return None
    # |p - c|² = r² is linear in c and r² - |c|²
    solution = np.linalg.lstsq(np.column_stack([2 * flat[:, :2], np.ones(len(flat))]), (flat[:, :2] ** 2).sum(1))[0]
    centre = centre0 + solution[:2] @ axes[:2]
    arms = points - centre
    radius = float(np.linalg.norm(arms, axis=1).mean())
    if np.abs(np.linalg.norm(arms, axis=1) - radius).max() > SAME_SHAPE_MM:
        return None
    x = arms[0] / np.linalg.norm(arms[0])
    z = np.cross(arms[0], arms[1])
    z /= np.linalg.norm(z)
    y = np.cross(z, x)
    angle = np.unwrap(np.arctan2(arms @ y, arms @ x))
    if (np.diff(angle) <= 0).any() or angle[-1] > 2 * np.pi + 1e-6:
        return None
    return RecognisedCurve(CurveKind.CIRCLE, np.array([centre, x, y, z]), radius, (0.0, float(angle[-1])))
