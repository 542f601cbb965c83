"""COMPAS: frames as ``compas.json_load`` reads them.

A `compas.geometry.Frame` has a point and two axes; its z is their cross product. COMPAS sets no unit: lengths are in
mm, and the file says so. All digits are kept. The frames are those of the tool in the robot's base.

References: COMPAS 2: compas.data (dtype and data), compas.geometry.Frame.
"""

from typing import Any

from wpcal.controllers.language.naming import NameRules, safe_name
from wpcal.controllers.program import SafePoint, WeldPath, WeldProgram
from wpcal.controllers.program.describe import describe, describe_path
from wpcal.controllers.registry import Exporter
from wpcal.core.records import to_json

NAMES = NameRules("COMPAS", 60)  #: For the name of the file. The length is our choice; COMPAS sets no limit.
SCHEMA = "wpcal/compas/1"


def write_compas(program: WeldProgram) -> dict[str, str]:
    """Write one JSON file with all seams. ``NAME.compas.json``."""
    record = {
        "schema": SCHEMA,
        "about": describe(program, has_arc=False),
        "frame": "base",
        "units": {"length": "mm"},
        "wire_axis": f"+{program.torch.tool_axis.value}",
        "z_sense": "inward",
        "safe_point": None if program.safe_point is None else _frames(program.safe_point)[0],
        "seams": [_seam(path) for path in program.paths],
    }
    return {f"{safe_name(program.controller.program_name, NAMES)}.compas.json": to_json(record)}


def _seam(path: WeldPath) -> dict[str, Any]:
    frames, rows = _frames(path), path.weld_rows
    errors = None if path.u95_mm is None else path.u95_mm.tolist()
    return {
        "name": path.seam.name,
        "what": describe_path(path),
        "to_seam": frames[: rows.start - 1],
        "approach": frames[rows.start - 1],
        "weld": frames[rows],
        "retract": frames[rows.stop],
        "from_seam": frames[rows.stop + 1 :],
        "error_95_mm": errors,
    }


def _frames(path: WeldPath | SafePoint) -> list[dict[str, Any]]:
    return [
        {"dtype": "compas.geometry/Frame", "data": {"point": p, "xaxis": x, "yaxis": y}}
        for p, x, y in zip(
            path.p_base.tolist(), path.R_base[:, :, 0].tolist(), path.R_base[:, :, 1].tolist(), strict=True
        )
    ]


COMPAS = Exporter("compas", "COMPAS: NAME.compas.json with frames for compas.json_load", write_compas)
