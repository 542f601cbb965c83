"""The linear fit of a plan of touches, with which a program corrects the frame of its seams."""

from __future__ import annotations

import numpy as np

from wpcal.controllers.program.in_run import Correction, Term, WeldsAfter
from wpcal.controllers.program.weld_program import SafePoint, WeldProgram
from wpcal.core.arrays import FloatArray
from wpcal.core.errors import InputError
from wpcal.touch.plan.choose import TouchDesign
from wpcal.touch.searches import SearchKind, TouchPlan, TouchSetup

RESIDUAL_SIGMAS = 4.0  #: One run of 2000 with 8 searches exceeds it by chance.
UNSEEN_MM = 0.1  #: Faces are not quite where the drawing has them.


def welds_after(plan: TouchPlan, setup: TouchSetup, program: WeldProgram) -> WeldsAfter:
    """Return how a weld program follows the searches of a plan.

    Raises
    ------
    InputError
        When the searches of the plan are not the touches of one part on its planes and cylinders, leave a motion free,
        or are planned for another part or place than the weld program; or this has no safe point.
    """
    T, part = plan.T_base_part, (program.calibration.get("inputs") or {}).get("part", {}).get("file", plan.part)
    if plan.part and part != plan.part:
        raise InputError(f"the plan of touches is for {plan.part}, the seams are those of {part}")
    seams = program.T_base_part.inverse().apply(np.concatenate([path.seam.frames.p for path in program.paths]))
    correction = correction_of(plan, setup, seams)
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
    if plan.home_joints is None:
        p, R = program.safe_point.poses_in(program.T_base_part)
        last = plan.searches[-1]
        up = T.R.T[:, 2]
        over = last.retract + max(float((p[0] - last.retract) @ up), 0.0) * up
        rows = np.stack([over, p[0]]), np.stack([last.R_part_tool, R[0]])
        way = SafePoint(T.apply(rows[0]), T.R @ rows[1])
    return WeldsAfter(program, correction, way, T)


def correction_of(plan: TouchPlan, setup: TouchSetup, seams: FloatArray) -> Correction:
    """Return the linear fit of a plan; `seams`: shape (n, 3). Points of the seams, in `part`, mm.

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
    if len(design.free_motions()):
        raise InputError("the searches of the plan leave a motion of the part free")
    H, W = design.rows, design.weights
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
        )
        for each, normal, gain, off in zip(searches, n, gains, sigma, strict=True)
    )
    return Correction(terms, centre)
