"""Arc instructions of KRL: the folds of ArcTech, or a digital output or two subprograms of the user.

A seam with the name of a weld data set (``weld_data``, a variable ``stArcDat_T`` of the controller) gets the folds that
ArcTech Basic writes itself: ARCON at its first point, ARCSWI at points between, ARCOFF at its last. They can be
edited on the pendant. Speed, weave and crater are then those of the data set. Other seams get plain KRL: the output
``$OUT[n]``, or ``ARC_START(job)`` and ``ARC_END()``.

References: KUKA, KR C4 ArcTech Basic: Operating and Programming Instructions (ARC ON, ARC SWITCH, ARC OFF). The text of
the folds follows programs that ArcTech 3 wrote, as public programs show them.
"""

from __future__ import annotations

from collections.abc import Sequence

from wpcal.controllers.language.emit import ArcSwitch
from wpcal.controllers.program import WeldPath, WeldProgram
from wpcal.controllers.program.arc import ArcSettings
from wpcal.robot.moves import Arc

LONGEST_PREFIX = len("LCPDAT")  #: Of the data of a point in a fold, before its name.
DATA = (
    "VEL 2.0,ACC 100.0,APO_DIST {blend:g},APO_FAC 50.0,AXIS_VEL 100.0,AXIS_ACC 100.0,ORI_TYP #VAR,CIRC_TYP #BASE,"
    "JERK_FAC 50.0,GEAR_JERK 100.0,EXAX_IGN 0"
)
"""Motion data of a point, as an inline form declares them."""


SWITCH = ArcSwitch(
    language="KRL",
    start="ARC_START({job})",
    end="ARC_END()",
    on="$OUT[{output}]=TRUE",
    off="$OUT[{output}]=FALSE",
    wait="WAIT SEC {seconds}",
    by_output="$OUT[{output}] switches the arc of seams without folds",
    by_calls="seams without folds call ARC_START(job) and ARC_END(), which must be on the controller",
    indent="",
    stand=("WAIT SEC 0",),
    no_weave="needs ArcTech (weld_data), or --weave points; or state null",
)
"""Of seams without ArcTech."""


def has_folds(path: WeldPath, program: WeldProgram) -> bool:
    """Tell whether a seam is written with the folds of ArcTech."""
    return program.arc is not None and path.values.weld_data is not None


def how(arc: ArcSettings | None, *, folds: bool) -> list[str]:
    """Say in the header how the arc is switched."""
    if arc is None:
        return ["the arc burns from ARC ON to ARC OFF"]
    lines = ["seams with weld_data have ArcTech folds; their data sets must be on the controller"] if folds else []
    return [*lines, SWITCH.in_words(arc)]


def fold_data(along: Sequence[str], program: WeldProgram, *, blend_mm: float) -> list[str]:
    """Return the declarations that folds need for the points of a seam, without the positions."""
    tool, base = program.controller.tool_number, program.controller.frame_number
    lines = []
    for name in along:
        lines += [
            f'DECL FDAT F{name}={{TOOL_NO {tool},BASE_NO {base},IPO_FRAME #BASE,POINT2[] " "}}',
            f"DECL LDAT LCPDAT{name}={{{DATA.format(blend=blend_mm)}}}",
            f'DECL stArcDat_T W{name}={{WdatId[] "W{name}"}}',
        ]
    return lines


TRIGGERS = {
    "On": {
        "#PreDefinition": "DISTANCE=1 DELAY=ArcGetDelay(#PreDefinition,{data})",
        "#GasPreflow": "PATH=ArcGetPath(#OnTheFlyArcOn,{data}) DELAY=ArcGetDelay(#GasPreflow,{data})",
        "#ArcOnMoveStd": "PATH=ArcGetPath(#OnTheFlyArcOn,{data}) DELAY=0",
    },
    "Swi": {"#ArcSwiMoveStd": "DISTANCE=1 DELAY=0"},
    "Off": {
        "#ArcOffBeforeOffStd": "PATH=ArcGetPath(#ArcOffBefore,{data}) DELAY=0",
        "#ArcOffMoveStd": "PATH=ArcGetPath(#OnTheFlyArcOff,{data}) DELAY=0",
    },
}
"""By the kind of a fold: the states that triggers set on its move, and when."""


def fold_moves(path: WeldPath, along: Sequence[str], program: WeldProgram, stops: Sequence[bool]) -> list[str]:
    """Return the folds along a seam: ARCON at its first point, ARCSWI at points between, ARCOFF at its last."""
    lines, moves = _fold("On", along[0], "", path, program), list(zip(path.weld_moves, stops, strict=True))
    for number, (move, stop) in enumerate(moves, 1):
        kind, via = "Off" if number == len(moves) else "Swi", along[move.via] if isinstance(move, Arc) else ""
        lines += _fold(kind, along[move.to], via, path, program, blends=kind == "Swi" and not stop)
    return lines


def _fold(kind: str, to: str, via: str, path: WeldPath, program: WeldProgram, *, blends: bool = False) -> list[str]:
    data, fold, word = path.values.weld_data, f"Arc{kind}", "CIRC" if via else "LIN"
    air = f"{program.motion.air_speed_mm_s / 1000.0:g}" if kind == "On" else ""
    points, moved, helped = (f"{via} {to}", f"X{via},X{to}", f"W{to},W{via}") if via else (to, f"X{to}", f"W{to}")
    place = f"Tool[{program.controller.tool_number}] Base[{program.controller.frame_number}];%{{PE}}"
    return [
        f";FOLD {fold.upper()} {data} {word} {points}{f' Vel={air} m/s' if air else ''} CPDAT{to} {place}",
        ";FOLD Parameters ;%{h}",
        f";Params IlfProvider=kukaroboter.arctech.{fold.lower()}{word.lower()}; Kuka.IsGlobalPoint=False; "
        f"Kuka.PointName={to};{f' Kuka.HelpPointName={via};' if via else ''} Kuka.BlendingEnabled={blends}; "
        f"Kuka.MoveDataName=CPDAT{to}; Kuka.VelocityPath={air or 0}; Kuka.CurrentCDSetIndex=0; "
        f"Kuka.MovementParameterFieldEnabled=True; ArcTech.WdatVarName={data}",
        ";ENDFOLD",
        *act_lines(to, air or "gArcBasVelDefinition"),
        *(
            f"TRIGGER WHEN {when.format(data=data)} DO ArcMainNG({state},{data},{helped}) PRIO=-1"
            for state, when in TRIGGERS[kind].items()
        ),
        f"ArcMainNG(#{fold}BeforeMoveStd,{data},{helped})",
        f"{word} {moved}{' C_DIS' if blends else ''}",
        f"ArcMainNG(#{fold}AfterMoveStd,{data},{helped})",
        ";ENDFOLD",
    ]


def act_lines(point: str, velocity: str) -> list[str]:
    """Return what every fold of a linear move sets before it."""
    return [
        "$BWDSTART=FALSE",
        f"LDAT_ACT=LCPDAT{point}",
        f"FDAT_ACT=F{point}",
        f"BAS(#CP_PARAMS,{velocity})",
        "SET_CD_PARAMS(0)",
    ]
