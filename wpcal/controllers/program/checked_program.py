"""A weld program compared with the part: weld poses that are free, and linear ways between the seams."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from functools import lru_cache

import numpy as np

from wpcal.brep.material import TriangleMaterial
from wpcal.brep.mesh_glb import read_part_glb
from wpcal.controllers.program import MotionSettings, SafePoint, WeldPath, WeldProgram
from wpcal.controllers.program.air_moves import (
    MARGIN_MM,
    AirPlan,
    AirSettings,
    AirWay,
    Ends,
    NoWayError,
    TorchAtTool,
    plan_air_moves,
)
from wpcal.controllers.program.few_moves import to_every_point
from wpcal.core.arrays import FloatArray, frozen
from wpcal.core.errors import ErrorCode, GeometryError, InputError
from wpcal.core.transform import RigidTransform
from wpcal.robot.torch.attitude import ToolAxis, wire_directions
from wpcal.robot.torch.shape import USUAL_TORCH, TorchShape
from wpcal.seam.judge.reach import find_in_ways

ROUND_OFF_MM = 1e-3
MOST_TOLD = 3  #: Seams whose place is told; of the others the names: the message is one line.


def refused(found: Mapping[str, str], names: Sequence[str], torch: TorchShape) -> GeometryError:
    """Return the error that names every seam with poses in material, and what can be done."""
    told = [*found.values()][:MOST_TOLD]
    more = [*found][MOST_TOLD:]
    others = f"; also {len(more)} more: {', '.join(more)}" if more else ""
    free = [name for name in names if name not in found]
    leave_out = f"; the others can be written: --only {','.join(free)}" if free else ""
    return GeometryError(
        f"{'; '.join(told)}{others} ({torch}); no program is written. Cut it there (range_mm in seams.json), tilt "
        "the torch with --work-angle-deg or --travel-angle-deg, or state its shape (--nozzle-radius-mm, --wire-mm, "
        f"--torch-length-mm){leave_out}",
        code=ErrorCode.POSE_IN_MATERIAL,
    )


@lru_cache(maxsize=1)
def part_in_base(part_glb: bytes, T_base_part: RigidTransform) -> TriangleMaterial:
    """Return the triangles of a part in the base: before and after it is written, a program is compared with them."""
    return TriangleMaterial.of(read_part_glb(part_glb), T_base_part)


def check_program(
    program: WeldProgram, *, torch: TorchShape | None = None, air: AirSettings | None = None, strict: bool = True
) -> WeldProgram:
    """Compare every pose with the part, and add checked ways between the seams.

    `strict`: Whether one seam that cannot be written refuses the program; otherwise it is left out, with its reason.

    Raises `InputError` when the program has no triangles of the part.
    Raises `GeometryError` when the torch would be inside material, or no checked way leads from a seam to the next; if
    not `strict`, when this holds for all seams.
    """
    torch, air = torch or USUAL_TORCH, air or AirSettings()
    if program.part_glb is None:
        raise InputError(
            "the result folder has no part.glb, with which poses and moves are checked; run wpcal calibrate again",
            code=ErrorCode.PART_MISSING,
        )
    part = part_in_base(program.part_glb, program.T_base_part)
    program, inside = _with_free_poses(program, part, torch)
    paths = [path for path in program.paths if path.seam.name not in inside]
    if inside and (strict or not paths):
        raise refused(inside, [path.seam.name for path in program.paths], torch)
    at_tool = TorchAtTool(torch, program.torch.tool_axis, program.torch.standoff_mm)
    paths, plan, cut_off = _between(paths, part, at_tool, air, strict=strict)
    ways = zip(paths, plan.ends, plan.to_seam, plan.from_seam, strict=True)
    return replace(
        program,
        shape=torch,
        paths=tuple(_with_ways(*each) for each in ways),
        safe_point=SafePoint(frozen(plan.safe.p), frozen(plan.safe.R)),
        checked=(*_describe(part, torch, program.torch.tool_axis, plan), *_shorter(program.motion, paths, plan)),
        left_out=inside | cut_off,
    )


def _with_free_poses(
    program: WeldProgram, part: TriangleMaterial, torch: TorchShape
) -> tuple[WeldProgram, dict[str, str]]:
    """Return which welds are inside material; where lines and arcs are, the poses of the frames may be free."""
    inside = _inside(program, part, torch)
    if fitted := {path.seam.name for path in program.paths if path.moves is not None} & inside.keys():
        own = (to_every_point(path, program.torch) if path.seam.name in fitted else path for path in program.paths)
        program = replace(program, paths=tuple(own))
        return program, _inside(program, part, torch)
    return program, inside


def _between(
    paths: list[WeldPath], part: TriangleMaterial, at_tool: TorchAtTool, air: AirSettings, *, strict: bool
) -> tuple[list[WeldPath], AirPlan, dict[str, str]]:
    """Return the paths to which ways lead, these ways, and why others are left out; errors as in `check_program`."""
    try:
        return paths, plan_air_moves(part, [_ends(path) for path in paths], at_tool, air), {}
    except NoWayError as error:
        reached = [path for path in paths if path.seam.name not in error.seams]
        if strict or not reached:
            raise
        return reached, plan_air_moves(part, [_ends(path) for path in reached], at_tool, air), dict(error.seams)


def _shorter(motion: MotionSettings, paths: Sequence[WeldPath], plan: AirPlan) -> Iterator[str]:
    """Yield where the torch comes or goes less far along the wire than was asked."""
    asked_mm = {"approach": motion.approach_mm, "retract": motion.retract_mm}
    for path, ends in zip(paths, plan.ends, strict=True):
        far_mm = np.linalg.norm(ends - _ends(path).weld, axis=1)
        pairs = zip(asked_mm.items(), far_mm, strict=True)
        if told := [f"{word} {mm:.4g} mm" for (word, most), mm in pairs if mm < most - ROUND_OFF_MM]:
            yield f"SHORTER at {path.seam.name}: {', '.join(told)}: no room for more"


def _ends(path: WeldPath) -> Ends:
    first, stop = path.weld_rows.start, path.weld_rows.stop
    at, welds = [first - 1, stop], path.p_base[[first, stop - 1]]
    return Ends(path.seam, path.p_base[at], path.R_base[at], welds)


def _with_ends(path: WeldPath, ends: FloatArray) -> WeldPath:
    p = path.p_base.copy()
    p[[path.weld_rows.start - 1, path.weld_rows.stop]] = ends
    return replace(path, p_base=frozen(p))


def _inside(program: WeldProgram, part: TriangleMaterial, torch: TorchShape) -> dict[str, str]:
    """Return the seams along which the torch is inside material, and in words where first."""
    axis, ways, frames = program.torch.tool_axis, [], list[FloatArray]()
    for path in program.paths:
        p, R, frame, _ = path.stations()
        tips = p + (program.torch.standoff_mm + path.seam.more_wire_mm) * wire_directions(R, axis)
        ways.append((path.seam, tips, R))
        frames.append(frame)
    found = zip(ways, find_in_ways(part, ways, torch, axis=axis), frames, strict=True)
    return {seam.name: places[0].describe(seam.name, frame) for (seam, *_), places, frame in found if places}


def _with_ways(path: WeldPath, ends: FloatArray, to_seam: AirWay, from_seam: AirWay) -> WeldPath:
    p = _with_ends(path, ends).p_base
    return replace(
        path,
        p_base=frozen(np.concatenate([to_seam.p, p, from_seam.p])),
        R_base=frozen(np.concatenate([to_seam.R, path.R_base, from_seam.R])),
        before=path.before + len(to_seam),
        after=path.after + len(from_seam),
    )


def _describe(part: TriangleMaterial, torch: TorchShape, axis: ToolAxis, plan: AirPlan) -> tuple[str, ...]:
    side = "-x" if axis is ToolAxis.Z else "+z"
    neck = () if not torch.bends else (f"the neck of {torch.name} bends towards {side} of the tool",)
    return (
        f"checked against the part, to {part.deflection_mm:.2g} mm: {torch}",
        *neck,
        f"between seams the tool goes {plan.clearance_mm:g} mm above the part, {MARGIN_MM:g} mm from it at least",
        *(f"NEARER on the first {mm:g} mm aside at {name}: no room there" for name, mm in plan.near_mm.items() if mm),
    )
