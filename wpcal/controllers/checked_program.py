"""A weld program compared with the part: weld poses that are free, and linear ways between the seams."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from wpcal.brep.material import TriangleMaterial
from wpcal.brep.mesh_glb import read_part_glb
from wpcal.controllers.air_moves import MARGIN_MM, AirPlan, AirSettings, Ends, TorchAtTool, Way, plan_air_moves
from wpcal.controllers.pose_check import find_weld_pose_in_material, refused
from wpcal.controllers.program import SafePoint, WeldPath, WeldProgram
from wpcal.controllers.torch import ToolAxis, neck_directions, wire_directions
from wpcal.core.arrays import frozen
from wpcal.core.errors import ErrorCode, InputError
from wpcal.seam.torch import USUAL_TORCH, TorchShape


def check_program(
    program: WeldProgram, *, torch: TorchShape | None = None, air: AirSettings | None = None
) -> WeldProgram:
    """Compare every pose with the part, and add checked ways between the seams.

    Parameters
    ----------
    program : WeldProgram
        As `build_program` made it, with the part's triangles.
    torch : TorchShape, optional

    Returns
    -------
    WeldProgram
        With a safe point, at which it starts and ends, and with linear moves only.

    Raises
    ------
    InputError
        When the program has no triangles of the part.
    GeometryError
        When the torch would be inside material, or no checked way leads from a seam to the next.
    """
    torch, air = torch or USUAL_TORCH, air or AirSettings()
    if program.part_glb is None:
        raise InputError(
            "the result folder has no part.glb, with which poses and moves are checked; run wpcal calibrate again",
            code=ErrorCode.PART_MISSING,
        )
    part = TriangleMaterial.of(read_part_glb(program.part_glb), program.T_base_part)
    motion, axis, standoff = program.motion, program.torch.tool_axis, program.torch.standoff_mm
    back_mm = (motion.approach_mm, motion.retract_mm)
    ends, inside = list[Ends](), dict[str, str]()
    for path in program.paths:
        p, R, frame, _ = path.stations()
        wire = wire_directions(R, axis)
        tips = p + (standoff + path.seam.more_wire_mm) * wire
        bend = None if torch.neck is None else neck_directions(R, axis)
        found = find_weld_pose_in_material(part, path.seam, tips, -wire, torch, back_mm=back_mm, frame=frame, bend=bend)
        if found is not None:
            inside[path.seam.name] = found
        at = [path.weld_rows.start - 1, path.weld_rows.stop]
        ends.append(Ends(path.seam.name, path.p_base[at], path.R_base[at]))
    if inside:
        raise refused(inside, [path.seam.name for path in program.paths], torch)
    plan = plan_air_moves(part, ends, TorchAtTool(torch, axis, standoff), air)
    paths = [
        _with_ways(path, to_seam, from_seam)
        for path, to_seam, from_seam in zip(program.paths, plan.to_seam, plan.from_seam, strict=True)
    ]
    safe = SafePoint(frozen(plan.safe.p), frozen(plan.safe.R))
    return replace(program, paths=tuple(paths), safe_point=safe, checked=_describe(part, torch, axis, plan))


def _with_ways(path: WeldPath, to_seam: Way, from_seam: Way) -> WeldPath:
    return replace(
        path,
        p_base=frozen(np.concatenate([to_seam.p, path.p_base, from_seam.p])),
        R_base=frozen(np.concatenate([to_seam.R, path.R_base, from_seam.R])),
        before=path.before + len(to_seam),
        after=path.after + len(from_seam),
    )


def _describe(part: TriangleMaterial, torch: TorchShape, axis: ToolAxis, plan: AirPlan) -> tuple[str, ...]:
    side = "-x" if axis is ToolAxis.Z else "+z"
    neck = () if torch.neck is None else (f"the neck of {torch.name} bends towards {side} of the tool",)
    return (
        f"checked against the part, to {part.deflection_mm:.2g} mm: {torch}",
        *neck,
        f"between seams the tool goes {plan.clearance_mm:g} mm above the part, {MARGIN_MM:g} mm from it at least",
    )
