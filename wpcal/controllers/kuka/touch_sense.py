"""Searches of KUKA TouchSense, for `wpcal.controllers.kuka.touch`: folds and their data.

A fold goes to the start, searches over the via point, which is the middle of the stroke, and at most half of the stroke
farther. It goes back to the start. TouchSense keeps the place in ``VCD….Meas_W``, relative to ``$WORLD``; the program
turns it into the part.

The form follows programs of a public post-processor (docs/how-to/touch-programs.md). No controller ran it.
"""

from __future__ import annotations

import numpy as np

from wpcal.controllers.kuka.arc import DATA, act_lines
from wpcal.controllers.kuka.write import BLEND_MM, DEG_DECIMALS, aggregates
from wpcal.controllers.language.rounding import zyx_degrees
from wpcal.controllers.program.touch_program import FOUND, MISSED, TouchProgram, TouchSteps
from wpcal.core.rotations import rotation_from_zyx
from wpcal.core.transform import RigidTransform

ZERO = "{X 0.0,Y 0.0,Z 0.0,A 0.0,B 0.0,C 0.0}"


def middle_label(steps: TouchSteps) -> str:
    """Return the name of the via point, without the X of a fold."""
    return f"WPT_{steps.name}_M"


def sense_data(program: TouchProgram, steps: TouchSteps, T_base_frame: RigidTransform, start: str) -> list[str]:
    """Return the declarations of one search.

    Parameters
    ----------
    T_base_frame : Of the frame that `steps` are relative to.
    start : Name of the point at the start, without the X of a fold.
    """
    setup, mark = program.setup, middle_label(steps)
    first, last = steps.p[steps.way_count + 1 : steps.way_count + 3]
    R = steps.R[:1]
    texts = aggregates(np.stack([first, (first + last) / 2.0]), np.repeat(zyx_degrees(R, decimals=DEG_DECIMALS), 2, 0))
    T = T_base_frame @ RigidTransform(
        rotation_from_zyx(*np.radians(zyx_degrees(R[0], decimals=DEG_DECIMALS))), (first + last) / 2.0, "part", "tool"
    )
    reference = aggregates(T.t_mm[None], zyx_degrees(T.R, decimals=DEG_DECIMALS)[None])[0]
    tool, base = program.controller.tool_number, setup.frame_number
    half = float(np.linalg.norm(last - first)) / 2.0
    return [
        f"DECL E6POS X{start}={texts[0]}",
        f"DECL E6POS X{mark}={texts[1]}",
        f'DECL FDAT F{start}={{TOOL_NO {tool},BASE_NO {base},IPO_FRAME #BASE,POINT2[] " "}}',
        f"DECL LDAT LCPDAT{start}={{{DATA.format(blend=BLEND_MM)}}}",
        f"DECL TSg_PCollCD_T VCD{mark}={{CD_IPO_MODE #BASE,Mastered TRUE,SDir_W {ZERO},Ref_W {reference},"
        f"Meas_W {ZERO},Diff_W {ZERO},VecLenDiff_W 0.0,MEnum #CDEmpty,MC 1}}",
        f"DECL TSg_SearchProperty_T ZSP{mark}={{MoveType #MoveWithLin,TouchType #Single,DynamicStep #Slow,"
        f"SensorNum {setup.krl.sensor},SearchDepth_Tol {half:.4f},bBackToStartPos TRUE,PartThickness 0.0}}",
    ]


def sense_moves(program: TouchProgram, steps: TouchSteps, start: str, speed: str) -> list[str]:
    """Return the fold of one search and what takes its place into the part; `start` as of `sense_data`."""
    mark = middle_label(steps)
    tool, base = program.controller.tool_number, program.setup.frame_number
    parameters = (
        f"IlfProvider=kukaroboter.touchsense.searchlin; Kuka.IsGlobalPoint=False; Kuka.PointName={start}; "
        f"Kuka.BlendingEnabled=False; Kuka.MoveDataName=CPDAT{start}; Kuka.VelocityPath={speed}; "
        "Kuka.CurrentCDSetIndex=0; Kuka.MovementParameterFieldEnabled=True; MoveType=LIN"
    )
    own = (
        f"TouchSense.SearchViaPoint={mark}; TouchSense.ReferenceMove=CD{mark}; TouchSense.SearchParam=SP{mark}; "
        f"TouchSense.Sensor={program.setup.krl.sensor}"
    )
    return [
        f"VCD{mark}.MEnum=#CDEmpty",
        f";FOLD TouchSense SEARCH LIN {start} Vel={speed} m/s CPDAT{start} VIA {mark} CD{mark} SP{mark} "
        f"Tool[{tool}] Base[{base}] ;%{{PE}}",
        ";FOLD Parameters ;%{h}",
        f";Params {parameters}",
        ";FOLD Parameters TouchSense ;%{h}",
        f";Params {own}",
        ";ENDFOLD",
        ";ENDFOLD",
        *act_lines(start, speed),
        f"LIN X{start}",
        f"TS_InitMovement($POS_ACT,X{mark},ZSP{mark})",
        f"TS_ManMoveToVia(X{mark})",
        f"TS_Search(X{mark},ZSP{mark},VCD{mark})",
        f"TS_SetCorrData(ZSP{mark},VCD{mark})",
        ";ENDFOLD",
        f"WPRESULT={MISSED}",
        f"IF VCD{mark}.MEnum<>#CDEmpty THEN",
        f"WPRESULT={FOUND}",
        f"WPSEEN=INV_POS(WPPART):VCD{mark}.Meas_W",
        *(f"WPPLACE.{axis}=WPSEEN.{axis}" for axis in "XYZABC"),
        "ENDIF",
    ]
