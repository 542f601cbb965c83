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
from wpcal.robot.moves import Arc, Move

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


def fold_moves(path: WeldPath, along: Sequence[str], program: WeldProgram, stops: Sequence[bool]) -> list[str]:
    """Return the folds along a seam."""
    data, air = str(path.values.weld_data), program.motion.air_speed_mm_s / 1000.0
    tool, base = program.controller.tool_number, program.controller.frame_number
    place = f"Tool[{tool}] Base[{base}];%{{PE}}"
    first, on_the_fly = along[0], f"ArcGetPath(#OnTheFlyArcOn,{data})"
    lines = [
        f";FOLD ARCON {data} LIN {first} Vel={air:g} m/s CPDAT{first} {place}",
        *_parameters("arconlin", first, "", data, air, blends=False),
        *act_lines(first, f"{air:g}"),
        _trigger(f"DISTANCE=1 DELAY=ArcGetDelay(#PreDefinition,{data})", f"#PreDefinition,{data},W{first}"),
        _trigger(f"PATH={on_the_fly} DELAY=ArcGetDelay(#GasPreflow,{data})", f"#GasPreflow,{data},W{first}"),
        _trigger(f"PATH={on_the_fly} DELAY=0", f"#ArcOnMoveStd,{data},W{first}"),
        f"ArcMainNG(#ArcOnBeforeMoveStd,{data},W{first})",
        f"LIN X{first}",
        f"ArcMainNG(#ArcOnAfterMoveStd,{data},W{first})",
        ";ENDFOLD",
    ]
    moves = list(zip(path.weld_moves, stops, strict=True))
    for number, (move, stop) in enumerate(moves, 1):
        lines += _fold(move, along, data, place, is_last=number == len(moves), blends=not stop)
    return lines


def _fold(move: Move, along: Sequence[str], data: str, place: str, *, is_last: bool, blends: bool) -> list[str]:
    to, via = along[move.to], along[move.via] if isinstance(move, Arc) else ""
    kind, word = ("circ", "CIRC") if via else ("lin", "LIN")
    points, helped = (f"{via} {to}", f"W{to},W{via}") if via else (to, f"W{to}")
    provider, name = ("arcoff", "ARCOFF") if is_last else ("arcswi", "ARCSWI")
    ends = " C_DIS" if blends and not is_last else ""
    head = [
        f";FOLD {name} {data} {word} {points} CPDAT{to} {place}",
        *_parameters(f"{provider}{kind}", to, via, data, 0.0, blends=bool(ends)),
        *act_lines(to, "gArcBasVelDefinition"),
    ]
    motion = f"{word} {f'X{via},' if via else ''}X{to}{ends}"
    if not is_last:
        return [
            *head,
            _trigger("DISTANCE=1 DELAY=0", f"#ArcSwiMoveStd,{data},{helped}"),
            f"ArcMainNG(#ArcSwiBeforeMoveStd,{data},{helped})",
            motion,
            f"ArcMainNG(#ArcSwiAfterMoveStd,{data},{helped})",
            ";ENDFOLD",
        ]
    return [
        *head,
        _trigger(f"PATH=ArcGetPath(#ArcOffBefore,{data}) DELAY=0", f"#ArcOffBeforeOffStd,{data},{helped}"),
        _trigger(f"PATH=ArcGetPath(#OnTheFlyArcOff,{data}) DELAY=0", f"#ArcOffMoveStd,{data},{helped}"),
        f"ArcMainNG(#ArcOffBeforeMoveStd,{data},{helped})",
        motion,
        f"ArcMainNG(#ArcOffAfterMoveStd,{data},{helped})",
        ";ENDFOLD",
    ]


def _trigger(when: str, state: str) -> str:
    return f"TRIGGER WHEN {when} DO ArcMainNG({state}) PRIO=-1"


def _parameters(provider: str, point: str, via: str, data: str, velocity: float, *, blends: bool) -> list[str]:
    help_point = f" Kuka.HelpPointName={via};" if via else ""
    text = (
        f"IlfProvider=kukaroboter.arctech.{provider}; Kuka.IsGlobalPoint=False; Kuka.PointName={point};{help_point} "
        f"Kuka.BlendingEnabled={blends}; Kuka.MoveDataName=CPDAT{point}; Kuka.VelocityPath={velocity:g}; "
        f"Kuka.CurrentCDSetIndex=0; Kuka.MovementParameterFieldEnabled=True; ArcTech.WdatVarName={data}"
    )
    return [";FOLD Parameters ;%{h}", f";Params {text}", ";ENDFOLD"]


def act_lines(point: str, velocity: str) -> list[str]:
    """Return what every fold of a linear move sets before it."""
    return [
        "$BWDSTART=FALSE",
        f"LDAT_ACT=LCPDAT{point}",
        f"FDAT_ACT=F{point}",
        f"BAS(#CP_PARAMS,{velocity})",
        "SET_CD_PARAMS(0)",
    ]
