"""The linear fit of a plan of touches, with which a program corrects the frame of its seams."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from wpcal.controllers.program.checked_program import part_in_base
from wpcal.controllers.program.in_run import Correction, Term, WeldsAfter
from wpcal.controllers.program.weld_program import SafePoint, WeldProgram
from wpcal.core.arrays import FloatArray
from wpcal.core.errors import InputError
from wpcal.core.transform import RigidTransform
from wpcal.robot.moves.sweep import poses_between
from wpcal.robot.torch.attitude import ToolAxis, TorchSettings
from wpcal.seam.judge.reach import sweep_torch
from wpcal.touch.plan.choose import TouchDesign
from wpcal.touch.plan.displaced import STEP_MM, STEP_RAD
from wpcal.touch.searches import SearchKind, TouchPlan, TouchSetup

RESIDUAL_SIGMAS = 4.0  #: One run of 2000 with 8 searches exceeds it by chance.
SAME_PLACE = 1e-6  #: Of the entries of a place, mm.
UNSEEN_MM = 0.1  #: Faces are not quite where the drawing has them.


FIRST = "F"  #: Before the numbers of searches of a first stage.
SEEN = 0.02  #: Of the best seen motion: a first stage corrects no motion that it sees less.


def in_stages(first: TouchPlan, second: TouchPlan, up_base: FloatArray) -> TouchPlan:
    """Return the searches of two plans as one: those of the first are F1, F2 ….

    `up_base`: shape (3,). As for `welds_after`.

    Raises `InputError` when they are not the two stages of one part in one place.
    """
    if first.first_stage is None or second.first_stage is not None:
        raise InputError(
            "--touches twice: expected a plan that does not hold the part by itself, then the second stage: wpcal "
            "touches PART --after FIRST -"
        )
    places = first.T_base_part.matrix, second.T_base_part.matrix
    if first.part != second.part or np.abs(places[0] - places[1]).max() > SAME_PLACE:
        raise InputError(
            "the two plans of touches are for other parts or places: plan the second with --after FIRST - (no results)"
        )
    if abs(first.standoff_mm - second.standoff_mm) > SAME_PLACE:
        raise InputError(
            f"the two plans of touches are for two tools: standoff_mm is {first.standoff_mm:g} in the first, "
            f"{second.standoff_mm:g} in the second: plan the second again with --after FIRST -"
        )
    if (first.home_joints is None) != (second.home_joints is None):
        raise InputError("one of the two plans of touches was made with an arm: plan both with it, or none")
    named = (replace(search, name=f"{FIRST}{number}") for number, search in enumerate(first.searches, 1))
    begin, *others = second.searches
    if second.home_joints is None:  # over the part, as high as both plans go
        last, up = first.searches[-1].retract, second.T_base_part.R.T @ up_base
        tops = [each.via[0] if len(each.via) else each.approach for each in (first.searches[0], begin)]
        high = max(float((top - last) @ up) for top in tops)
        over = [p + max(high - float((p - last) @ up), 0.0) * up for p in (last, begin.approach)]
        begin = replace(begin, via=np.array(over))
    return replace(second, searches=(*named, begin, *others))


def _require_one_tool(plan: TouchPlan, torch: TorchSettings) -> None:
    """Refuse another tool than that of the plan: a controller has one, and the wire would drive into the part."""
    if abs(plan.standoff_mm - torch.standoff_mm) > SAME_PLACE:
        raise InputError(
            f"the searches are planned for a tool centre point {plan.standoff_mm:g} mm back from the tip of the wire "
            f"(standoff_mm in touches.json), here it is {torch.standoff_mm:g} mm back: give wpcal touches and "
            "wpcal export the same --standoff-mm"
        )
    if torch.tool_axis is not ToolAxis.Z:
        raise InputError(
            "touch and weld in one run needs --tool-axis z: in touch programs the wire leaves along z of the tool"
        )


def welds_after(
    plan: TouchPlan, setup: TouchSetup, program: WeldProgram, up_base: FloatArray, *, stage: int = 0
) -> WeldsAfter:
    """Return how a weld program follows the searches of a plan.

    `up_base`: shape (3,). Unit vector away from the support of the part, in `base`.
    `stage`: How many of the searches are a first stage, which corrects the frame once before (`in_stages`).

    Raises `InputError` when the searches of the plan are not the touches of one part on its planes and cylinders, leave
    a motion free, or are planned for another part, place or tool than the weld program; or this has no safe point.
    """
    _require_one_tool(plan, program.torch)
    T, part = plan.T_base_part, (program.calibration.get("inputs") or {}).get("part", {}).get("file", plan.part)
    if plan.part and part != plan.part:
        raise InputError(f"the plan of touches is for {plan.part}, the seams are those of {part}")
    seams = program.T_base_part.inverse().apply(np.concatenate([path.seam.frames.p for path in program.paths]))
    correction = correction_of(replace(plan, searches=plan.searches[stage:]), setup, seams)
    searches = plan.searches[:stage]
    before = correction_of(replace(plan, searches=searches), setup, seams, holds=False) if stage else None
    apart = float(np.linalg.norm(T.apply(seams) - program.T_base_part.apply(seams), axis=1).max())
    most = max(search.stroke_mm for search in plan.searches)
    if apart > most:
        raise InputError(
            f"the seams are {apart:.0f} mm from where the plan of touches has them, its longest stroke is {most:.0f} "
            "mm: plan the touches for this place (--nominal), or calibrate with them first"
        )
    if program.safe_point is None:
        raise InputError("touch and weld in one run needs the checked ways between the seams of a part with a shape")
    way = None
    if stage and plan.home_joints is None:
        last, begin = plan.searches[stage - 1 : stage + 1]
        between = np.array([last.retract, *begin.via, begin.approach])
        R = np.stack([last.R_part_tool, *plan.axes(stage)[: len(between) - 1]])
        _require_free(program, T, T.apply(between), T.R @ R)
    if plan.home_joints is None:
        p, R = program.safe_point.poses_in(program.T_base_part)
        last = plan.searches[-1]
        up = T.R.T @ up_base
        start = last.retract - plan.ahead(last)
        over = start + max(float((p[0] - start) @ up), 0.0) * up
        rows = np.stack([over, p[0]]), np.stack([last.R_part_tool, R[0]])
        way = SafePoint(T.apply(rows[0]), T.R @ rows[1])
        places, turns = T.apply(np.stack([start, *rows[0]])), way.R_base[[0, 0, 1]]
        _require_free(program, T, places + program.torch.standoff_mm * turns[:, :, 2], turns)
    return WeldsAfter(program, correction, way, T, before)


def _require_free(program: WeldProgram, T_base_part: RigidTransform, p: FloatArray, R: FloatArray) -> None:
    """Refuse a way on which the torch meets the part in the place of the plan; its tool centre point goes straight.

    `p`, `R`: shapes (n, 3) and (n, 3, 3). Tips of the wire, and axes of the tool, in `base`.
    """
    if program.part_glb is None:
        return
    part = part_in_base(program.part_glb, T_base_part)
    tips, axes, _ = poses_between(p, R, STEP_MM, STEP_RAD, program.torch.standoff_mm)
    if len(found := sweep_torch(part, [(tips, axes)], program.shape, axis=program.torch.tool_axis)[1]):
        raise InputError(
            f"on the way up from the last search and to the seams the {found.part[0].value} of the torch meets "
            f"{found.solid[0]!r}: give --up, or plan the touches with an arm, which goes home"
        )


def correction_of(plan: TouchPlan, setup: TouchSetup, seams: FloatArray, *, holds: bool = True) -> Correction:
    """Return the linear fit of a plan.

    `seams`: shape (n, 3). Points of the seams, in `part`, mm.
    `holds`: Whether the searches have to hold the part; those of a first stage leave what they do not see as it is.

    Raises `InputError` as `welds_after`.
    """
    searches = plan.searches
    strange = [s.name for s in searches if s.kind is SearchKind.POST or (s.target != "plane" and s.axis is None)]
    if plan.bodies or strange:
        what = "bodies that may move" if plan.bodies else f"in {strange[0]} what is not a plane or a known cylinder"
        raise InputError(
            f"this plan touches {what}: plan it again, or write its touch program and calibrate with its results "
            "(wpcal calibrate --touches)"
        )
    p, n, wire = (
        np.array([getattr(each, name) for each in searches]) for name in ("contact_part", "normal_part", "R_part_tool")
    )
    centre = p.mean(axis=0)
    design = TouchDesign.of(
        p - centre, n, wire[:, :, 2], setup, seams - centre, stick_out_sigma_mm=setup.stick_out_sigma_mm
    )
    H, W = design.rows, design.weights
    if not holds:  # the smallest motion that explains what was found
        scale, root = np.repeat([1.0 / design.length_mm, 1.0], 3), np.sqrt(W)[:, None]
        gains = (scale[:, None] * np.linalg.pinv(root * H * scale, rcond=SEEN) * root.T).T
    elif len(design.free_motions()):
        more = "" if plan.first_stage is None else "; plan a second stage, too (wpcal touches PART --after FIRST -)"
        raise InputError(f"the searches of the plan leave a motion of the part free{more}")
    else:
        gains = np.linalg.solve(H.T @ (W[:, None] * H), H.T * W).T
    noise = np.diag(design.variances) + design.shared @ design.shared.T
    left = np.eye(len(H)) - H @ gains.T
    sigma = np.sqrt(np.maximum(np.einsum("ij,jk,ik->i", left, noise, left), 0.0))
    late = setup.latency_s * setup.search_speed_mm_s
    terms = tuple(
        Term(
            each.name.upper(),
            each.planned + late * each.direction,
            normal,
            gain[3:],
            gain[:3],
            each.axis,
            RESIDUAL_SIGMAS * float(off) + UNSEEN_MM,
            plan.ahead(each),
        )
        for each, normal, gain, off in zip(searches, n, gains, sigma, strict=True)
    )
    return Correction(terms, centre, "" if holds else "1")
