"""A weld program compared with the part: weld poses that are free, and linear ways between the seams."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from wpcal.brep.material import Material, TriangleMaterial
from wpcal.brep.mesh_glb import read_part_glb
from wpcal.controllers.program import SafePoint, WeldPath, WeldProgram
from wpcal.controllers.program.air_moves import MARGIN_MM, AirPlan, AirSettings, Ends, TorchAtTool, Way, plan_air_moves
from wpcal.core.arrays import FloatArray, IntArray, frozen
from wpcal.core.errors import ErrorCode, GeometryError, InputError
from wpcal.robot.torch.attitude import ToolAxis, neck_directions, wire_directions
from wpcal.robot.torch.shape import USUAL_TORCH, TorchShape
from wpcal.seam.judge.material import find_poses_in_material
from wpcal.seam.judge.stations import start_mm
from wpcal.seam.seam import Seam

STEP_MM = 1.0
"""Between two points of a seam the torch is compared with the part at this step: less than the thinnest sheet that is
welded as a rib, and small against the nozzle."""
MOST_TOLD = 3  #: Seams whose place is told; of the others the names: the message is one line.


def find_weld_pose_in_material(
    part: Material,
    seam: Seam,
    tips: FloatArray,
    back: FloatArray,
    torch: TorchShape,
    *,
    back_mm: tuple[float, float],
    frame: FloatArray | None = None,
    bend: FloatArray | None = None,
) -> str | None:
    """Say where along a seam, or on its way along the wire to its ends, the torch is inside material.

    Parameters
    ----------
    tips : shape (n, 3). Tips of the wire in `base`, mm.
    back : shape (n, 3). Unit vectors from the tips along the wire towards the torch.
    back_mm : How far the torch comes from along the wire at the first point, and goes at the last, mm.
    frame : ndarray, shape (n,), optional
        Numbers of the seam's frames at the tips, with fractions between them. None: the tips are those of the frames.
    bend : ndarray, shape (n, 3), optional
        Unit directions in `base` towards which the neck of the torch bends. None: neck and body are not compared.

    Returns
    -------
    str or None
        The seam, the first point (counted from 0, as in ``seams.csv``), what is inside and the solid; None if the torch
        is free everywhere.
    """
    at = _places(tips)
    rows = np.minimum(at.astype(int), len(tips) - 2)
    share = (at - rows)[:, None]
    p = tips[rows] + share * (tips[rows + 1] - tips[rows])
    away = _between(back, rows, share)
    more = np.zeros(len(p))
    more[0], more[-1] = back_mm
    torch = torch.with_more_wire(seam.more_wire_mm)
    side = None if bend is None else _between(bend, rows, share)
    found = find_poses_in_material(part, p, away, torch, start_mm=start_mm(seam), more_mm=more, bend=side)
    if len(found) == 0:
        return None
    x, y, z = p[found.row[0]]
    place = float(at[found.row[0]])
    place = place if frame is None else float(np.interp(place, np.arange(len(frame)), frame))
    row = math.floor(place)
    where = f"point {row}" if row == place else f"between points {row} and {row + 1}"
    what = f"the {found.part[0].value} is inside {found.solid[0]!r}"
    return f"seam {seam.name}: {where}, base {x:.1f}, {y:.1f}, {z:.1f} mm: {what}"


def _between(ways: FloatArray, rows: IntArray, share: FloatArray) -> FloatArray:
    """Return unit vectors between those at `rows` and the next ones."""
    way = ways[rows] + share * (ways[rows + 1] - ways[rows])
    return np.asarray(way / np.linalg.norm(way, axis=1, keepdims=True), dtype=np.float64)


def _places(tips: FloatArray) -> FloatArray:
    """Return the numbers of points to compare, with fractions between two points."""
    steps = np.maximum(np.ceil(np.linalg.norm(np.diff(tips, axis=0), axis=1) / STEP_MM), 1.0).astype(int)
    return np.concatenate([*(row + np.arange(count) / count for row, count in enumerate(steps)), [float(len(steps))]])


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


def check_program(
    program: WeldProgram, *, torch: TorchShape | None = None, air: AirSettings | None = None
) -> WeldProgram:
    """Compare every pose with the part, and add checked ways between the seams.

    Raises `InputError` when the program has no triangles of the part.
    Raises `GeometryError` when the torch would be inside material, or no checked way leads from a seam to the next.
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
