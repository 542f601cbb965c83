"""DXF: the calibrated seams as 3-D polylines, the reference points with labels, and the residual vectors.

Lengths are mm (the header says so), in the robot's base. Each seam has its own layer, coloured by its joint. The
reference points of the model are drawn with their names where the fit puts them. The taught points have their own
layer. Residual vectors are drawn magnified, from the taught point towards the reference point, with their true length
in mm; the name of their layer states the magnification.
"""

from __future__ import annotations

import io
from typing import Any

import numpy as np

from cad.draw.reproducible import reproducible
from wpcal.controllers.language.naming import NameRules, in_ascii, safe_name, safe_names
from wpcal.controllers.program import WeldProgram
from wpcal.controllers.registry import Exporter
from wpcal.core.arrays import FloatArray
from wpcal.core.errors import KernelError
from wpcal.seam.seam import JointType

NAMES = NameRules("DXF", 60, "0 defpoints reference_points taught_points residuals_x100")
"""Old readers accept layer names of 255 characters; a list on a screen shows 60."""
JOINT_COLOUR = {
    JointType.TEE: 3,
    JointType.LAP: 5,
    JointType.BUTT: 1,
    JointType.CORNER: 6,
    JointType.EDGE: 4,
    JointType.UNKNOWN: 8,
}
"""AutoCAD colour index: green, blue, red, magenta, cyan, grey."""
REFERENCE_COLOUR, POINT_COLOUR, RESIDUAL_COLOUR = 4, 7, 30  #: Cyan, black or white by background, and orange.
REFERENCE_LAYER = "REFERENCE_POINTS"
POINT_LAYER = "TAUGHT_POINTS"
RESIDUAL_LAYER = "RESIDUALS_X100"
MAGNIFIED = 100.0  #: Residuals are tenths of a millimetre, on parts of a few hundred millimetres.
TEXT_PART = 0.01
"""Text height relative to the drawing's diagonal: labels are readable when the whole part fills the screen."""
MILLIMETRES = 4  #: The value of $INSUNITS for mm.
POINT_MARK = 35  #: The value of $PDMODE for a cross in a circle. By default a point is one pixel.
SMALLEST_TEXT_MM = 0.1  #: Text height if all points coincide.


def write_dxf(program: WeldProgram) -> dict[str, str]:
    """Write one DXF file with all seams and taught points. ``NAME.dxf``, R2018.

    Raises `KernelError` when the drawing does not pass the library's audit.
    """
    names = safe_names([path.seam.name for path in program.paths], NAMES)
    with reproducible():
        return {f"{safe_name(program.controller.program_name, NAMES)}.dxf": _drawn(program, names)}


def _drawn(program: WeldProgram, names: dict[str, str]) -> str:
    import ezdxf

    document = ezdxf.new("R2018")
    document.header["$INSUNITS"] = MILLIMETRES
    space = document.modelspace()
    points = _points(program)
    height = _text_height(program, points)
    for path in program.paths:
        layer, p = names[path.seam.name], path.seam.frames.p
        document.layers.add(layer, color=JOINT_COLOUR[path.seam.joint])
        space.add_polyline3d(p.tolist(), dxfattribs={"layer": layer})
        _label(space, path.seam.name, p[0], layer, height)
    _draw_points(document, points, height)
    require_sound(document)
    return dxf_text(document)


def require_sound(document: Any) -> None:
    """Refuse a drawing that does not pass the library's audit. Raises `KernelError` when it does not."""
    if document.audit().has_errors:
        raise KernelError("the drawing has audit errors")


def dxf_text(document: Any) -> str:
    """Return a drawing as DXF; to be called inside `reproducible`.

    The library lists the classes of the drawing's entities in the order of a set, which differs from process to
    process. Here they are listed by name before.
    """
    for name in sorted(document.entitydb.dxf_types_in_use()):
        document.classes.add_class(name)
    text = io.StringIO()
    document.write(text)
    return text.getvalue()


def _draw_points(document: Any, points: list[tuple[str, FloatArray, FloatArray]], height: float) -> None:
    document.header["$PDMODE"], document.header["$PDSIZE"] = POINT_MARK, height
    for layer, colour in (
        (REFERENCE_LAYER, REFERENCE_COLOUR),
        (POINT_LAYER, POINT_COLOUR),
        (RESIDUAL_LAYER, RESIDUAL_COLOUR),
    ):
        document.layers.add(layer, color=colour)
    space = document.modelspace()
    for name, p, residual in points:
        fitted, end = p - residual, p - MAGNIFIED * residual
        space.add_point(fitted.tolist(), dxfattribs={"layer": REFERENCE_LAYER})
        _label(space, name, fitted, REFERENCE_LAYER, height)
        space.add_point(p.tolist(), dxfattribs={"layer": POINT_LAYER})
        space.add_line(p.tolist(), end.tolist(), dxfattribs={"layer": RESIDUAL_LAYER})
        _label(space, f"{np.linalg.norm(residual):.3f}", end, RESIDUAL_LAYER, height)


def _points(program: WeldProgram) -> list[tuple[str, FloatArray, FloatArray]]:
    """Return name, place and residual of the taught points, base frame, mm."""
    return [
        (
            record["name"],
            np.array(record["p_base_mm"], dtype=np.float64),
            np.array(record["residual_mm"], dtype=np.float64),
        )
        for record in program.calibration.get("points", ())
    ]


def _text_height(program: WeldProgram, points: list[tuple[str, FloatArray, FloatArray]]) -> float:
    places = np.concatenate([*(path.seam.frames.p for path in program.paths), *(p[None] for _, p, _ in points)])
    return max(float(np.linalg.norm(np.ptp(places, axis=0))) * TEXT_PART, SMALLEST_TEXT_MM)


def _label(space: Any, text: str, p: FloatArray, layer: str, height: float) -> None:
    space.add_text(in_ascii(text), height=height, dxfattribs={"layer": layer}).set_placement((p + height / 2).tolist())


DXF = Exporter("dxf", "DXF: NAME.dxf with seams, taught points and residual vectors", write_dxf)
