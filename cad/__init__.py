"""The CAD side of wpcal: everything that touches build123d, OCP, trimesh or ezdxf.

The names below are for scripts; each is imported when it is used. Type checkers and editors read the
imports and `__all__`, Python reads `_HOMES`; a test compares them with each other and with what the documentation uses.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from wpcal.core.lazy_names import lazy_names

if TYPE_CHECKING:
    from cad.kernel.to_brep import to_brep
    from cad.step.read import read_step
    from cad.step.write import write_moved_step
    from cad.workpiece.advise import advise_weldment
    from cad.workpiece.bodies import BodiesOptions
    from cad.workpiece.calibrate import calibrate_workpiece
    from cad.workpiece.seams import find_seams
    from cad.workpiece.show import show
    from cad.workpiece.to_build123d import seam_locations, seam_planes, seam_wire
    from cad.workpiece.touches import plan_touches
    from cad.workpiece.workpiece import open_workpiece

_HOMES = {
    "BodiesOptions": "cad.workpiece.bodies:BodiesOptions",
    "advise_weldment": "cad.workpiece.advise:advise_weldment",
    "calibrate_workpiece": "cad.workpiece.calibrate:calibrate_workpiece",
    "find_seams": "cad.workpiece.seams:find_seams",
    "open_workpiece": "cad.workpiece.workpiece:open_workpiece",
    "plan_touches": "cad.workpiece.touches:plan_touches",
    "read_step": "cad.step.read:read_step",
    "seam_locations": "cad.workpiece.to_build123d:seam_locations",
    "seam_planes": "cad.workpiece.to_build123d:seam_planes",
    "seam_wire": "cad.workpiece.to_build123d:seam_wire",
    "show": "cad.workpiece.show:show",
    "to_brep": "cad.kernel.to_brep:to_brep",
    "write_moved_step": "cad.step.write:write_moved_step",
}
__all__ = [
    "BodiesOptions",
    "advise_weldment",
    "calibrate_workpiece",
    "find_seams",
    "open_workpiece",
    "plan_touches",
    "read_step",
    "seam_locations",
    "seam_planes",
    "seam_wire",
    "show",
    "to_brep",
    "write_moved_step",
]
__getattr__, __dir__ = lazy_names(__name__, _HOMES)
