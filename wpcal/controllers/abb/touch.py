r"""ABB RAPID: a program that touches the part, and a module with its results.

``NAME_touch.mod`` is the program: a procedure per search, one that runs them all, and `wptTouch`, which searches.
``NAME_touch_res.mod`` holds the results as ``PERS`` data; the program saves it with ``Save``. With `with_package` the
search is ``Search_1D`` of SmarTac. It searches over twice the distance from its start to its search point, which is
therefore half of the stroke.

References
----------
ABB, Technical reference manual: RAPID Instructions, Functions and Data types (SearchL, Save, TRYNEXT, ERRNO).
ABB, Application manual SmarTac (Search_1D).
"""

from __future__ import annotations

import re

from wpcal.controllers.abb.configuration import confdata
from wpcal.controllers.abb.write import (
    DEG_DECIMALS,
    JOINT_SPEED,
    LONGEST_COMMENT,
    NAMES,
    NO_EXTERNAL_AXES,
    OFF,
    ON,
    TURN_DEG_S,
    frame_as_written,
    pose_texts,
)
from wpcal.controllers.language.naming import comment_lines, own_name
from wpcal.controllers.program.planned import angle_texts
from wpcal.controllers.program.touch_program import (
    ACTIVE,
    ACTIVE_TEXT,
    FOUND,
    MISSED,
    MISSED_TEXT,
    NOT_RUN,
    TouchPost,
    TouchProgram,
    TouchSteps,
    describe_touches,
)
from wpcal.core.errors import InputError

SIGNAL = "diTouch"
"""The input, if the touch setup names none."""
RESULTS = "_res"
"""The name of the module of results is that of the program and this."""
NOWHERE = f"[[0,0,0],[1,0,0,0],[0,0,0,0],{NO_EXTERNAL_AXES}]"
"""The place of a search that was not run."""
OUTCOME, PLACE = "wptO_", "wptP_"
HOME = "wptHome"
AIR, SEARCH = "wptAir", "wptSearch"
FOLDER = re.compile(r"[\w:/.-]+")
"""Of a file system of the controller, as ``HOME:`` or ``HOME:/touch``."""
HELD_MM = 0.01
"""Where a search of SmarTac ended without contact, it may leave the place as it was."""


def write_touch_rapid(program: TouchProgram) -> dict[str, str]:
    """Write a RAPID module of searches and a module of their results.

    Returns
    -------
    dict of str to str. ``NAME_touch.mod`` and ``NAME_touch_res.mod``, with lines ended by CR LF.

    Raises
    ------
    InputError : When RAPID does not allow the name of the tool, of a signal or of the folder.
    """
    module = program.name(NAMES)
    frame, T_base_frame = frame_as_written(program.plan.T_base_part)
    steps = program.steps(T_base_frame)
    wobj = f'[FALSE,TRUE,"",[{frame}],[[0,0,0],[1,0,0,0]]];'
    post = TouchPost("rapid", program)
    lines = [
        f"MODULE {module}",
        *post.header(_about(program, module)),
        f"  LOCAL PERS wobjdata wpPart:={wobj}",
        *(_speed(name, mm_s) for name, mm_s in _speeds(program)),
        *_home(program),
        *(line for each in steps for line in _targets(each)),
        *(line for each in steps for line in ("", *_search(each, program, post))),
        "",
        *_touch(program, post),
        "",
        *_all(program, module, steps, post),
        "",
        *_clear(program, steps, wobj),
        "",
        *_save(program, module),
        *post.footer(),
        "",
    ]
    results = [
        f"MODULE {module}{RESULTS}",
        *comment_lines(
            [f"results of {module}; the program writes them, and saves this module"], mark="  ! ", longest=72
        ),
        '  PERS string wptPlan:="";',
        f'  PERS string wptTool:="{_tool(program)}";',
        f"  PERS num wptCount:={len(steps)};",
        f"  PERS wobjdata wptPart:={wobj}",
        *(line for each in steps for line in _stored(each)),
        "ENDMODULE",
        "",
    ]
    files = {module: lines, f"{module}{RESULTS}": results}
    return {f"{name}.mod": "\r\n".join(text) for name, text in files.items()}


def _tool(program: TouchProgram) -> str:
    return own_name(program.controller.tool_name, NAMES, what="tool")


def _signal(program: TouchProgram) -> str:
    return own_name(program.setup.signal or SIGNAL, NAMES, what="signal of the touch setup")


def _enable(program: TouchProgram) -> str:
    enable = program.setup.enable
    return own_name(enable, NAMES, what="enable of the touch setup") if enable else ""


def _folder(program: TouchProgram) -> str:
    folder = program.setup.rapid.results_folder
    if not FOLDER.fullmatch(folder):
        raise InputError(f"results_folder {folder!r} of the touch setup: expected a folder of the controller, as HOME:")
    return folder.rstrip("/")


def _about(program: TouchProgram, module: str) -> list[str]:
    results = [
        f"results: module {module}{RESULTS}, which must be loaded too; saved as "
        f"{_folder(program)}/{module}{RESULTS}.mod",
        "targets and results are relative to wpPart, the part as planned; mm; q1..q4 = w,x,y,z",
        "confdata is not known: ConfJ, ConfL \\Off let the controller choose, and are On again at the end"
        if program.arm is None
        else "confdata is computed from the joints",
        f"run the procedure run_{module}; tool {_tool(program)} must be declared on the controller",
    ]
    if program.setup.with_package:
        results.append("searches with SmarTac, at its own speed (SMARTAC_SPEEDS); if it asks, answer RAISE")
    about = describe_touches(program, signal=_signal(program), results=results)
    return comment_lines(about, mark="", longest=LONGEST_COMMENT)


def _speeds(program: TouchProgram) -> tuple[tuple[str, float], ...]:
    return (AIR, program.setup.air_speed_mm_s), (SEARCH, program.setup.search_speed_mm_s)


def _speed(name: str, mm_s: float) -> str:
    return f"  LOCAL CONST speeddata {name}:=[{mm_s:g},{TURN_DEG_S},{mm_s:g},{TURN_DEG_S}];"


def _home(program: TouchProgram) -> list[str]:
    if program.plan.home_joints is None:
        return []
    joints = ",".join(angle_texts(program.plan.home_joints[None], DEG_DECIMALS)[0])
    return [f"  LOCAL CONST jointtarget {HOME}:=[[{joints}],{NO_EXTERNAL_AXES}];"]


def _label(steps: TouchSteps, mark: str) -> str:
    return f"wpt{steps.name}_{mark}"


def _targets(steps: TouchSteps) -> list[str]:
    confs = ["[0,0,0,0]"] * len(steps.p) if steps.postures is None else confdata(steps.postures)
    texts = zip(steps.marks, pose_texts(steps.p, steps.R), confs, strict=True)
    return [
        f"  LOCAL CONST robtarget {_label(steps, mark)}:=[{text},{conf},{NO_EXTERNAL_AXES}];"
        for mark, text, conf in texts
    ]


def _stored(steps: TouchSteps) -> list[str]:
    return [f"  PERS num {OUTCOME}{steps.name}:={NOT_RUN};", f"  PERS robtarget {PLACE}{steps.name}:={NOWHERE};"]


def _search(steps: TouchSteps, program: TouchProgram, post: TouchPost) -> list[str]:
    """Return the procedure of one search: the way to it, the search, the way from it, the stop if it found nothing."""
    way = [_label(steps, mark) for mark in steps.marks[:-3]]
    is_first = steps.search is program.plan.searches[0] and program.plan.home_joints is None
    moves = post.air_move(way[0], speed=JOINT_SPEED if is_first else AIR, joint=is_first)
    for label in way[1:]:
        moves += post.air_move(label, speed=AIR)
    start, end, retract = (_label(steps, mark) for mark in "SER")
    moves += post.air_move(start, speed=AIR)
    moves += [f"    wptTouch {start},{end},{OUTCOME}{steps.name},{PLACE}{steps.name};"]
    moves += post.air_move(start, speed=AIR)
    moves += post.air_move(retract, speed=AIR)
    moves += [f'    IF {OUTCOME}{steps.name}<>{FOUND} wptTell "{steps.name}",{OUTCOME}{steps.name};']
    off, on = ((), ()) if steps.postures is not None else (OFF, ON)
    return [f"  LOCAL PROC touch_{steps.name}()", *off, *moves, *on, "  ENDPROC"]


def _touch(program: TouchProgram, post: TouchPost) -> list[str]:
    """Return the procedure that searches, and stores the outcome last: a place counts only with it."""
    signal, enable = _signal(program), _enable(program)
    state = "high" if program.setup.is_on_high else "low"
    search = _search_1d(program) if program.setup.with_package else _search_l(program)
    return [
        "  LOCAL PROC wptTouch(robtarget pStart,robtarget pEnd,PERS num outcome,PERS robtarget place)",
        "    VAR robtarget pHit;",
        f"    VAR num nOutcome:={FOUND};",
        *(["    VAR pose peOff;", "    VAR robtarget pMiddle;"] if program.setup.with_package else []),
        *post.sensing(on=True, signal=signal, enable=enable),
        f"    IF {signal}={state} THEN",
        f"      nOutcome:={ACTIVE};",
        "    ELSE",
        *search,
        "    ENDIF",
        *post.sensing(on=False, signal=signal, enable=enable),
        f"    IF nOutcome={FOUND} place:=pHit;",
        "    outcome:=nOutcome;",
        "  ERROR",
        "    IF ERRNO=ERR_WHLSEARCH THEN",
        f"      nOutcome:={MISSED};",
        "      TRYNEXT;",
        "    ELSEIF ERRNO=ERR_SIGSUPSEARCH THEN",
        f"      nOutcome:={ACTIVE};",
        "      StopMove;",
        "      ClearPath;",
        "      StartMove;",
        "      TRYNEXT;",
        *(["    ELSE", f"      nOutcome:={MISSED};", "      TRYNEXT;"] if program.setup.with_package else []),
        "    ENDIF",
        "  ENDPROC",
    ]


def _search_l(program: TouchProgram) -> list[str]:
    edge = "" if program.setup.is_on_high else "\\NegFlank"
    return [
        f"      SearchL\\Stop,{_signal(program)}{edge},pHit,pEnd,{SEARCH},{_tool(program)}\\WObj:=wpPart;",
        f"      WaitTime {program.setup.hold_s:g};",
    ]


def _search_1d(program: TouchProgram) -> list[str]:
    return [
        "      pMiddle:=pEnd;",
        "      pMiddle.trans:=0.5*(pStart.trans+pEnd.trans);",
        "      pHit:=pEnd;",
        f"      Search_1D peOff\\SearchStop:=pHit,pStart,pMiddle,{AIR},{_tool(program)}\\WObj:=wpPart;",
        f"      IF Distance(pHit.trans,pEnd.trans)<{HELD_MM:g} nOutcome:={MISSED};",
        f"      WaitTime {program.setup.hold_s:g};",
    ]


def _all(program: TouchProgram, module: str, steps: tuple[TouchSteps, ...], post: TouchPost) -> list[str]:
    home = [] if program.plan.home_joints is None else post.joint_move(HOME, speed=JOINT_SPEED)
    calls = [f"    touch_{each.name};" for each in steps]
    return [f"  PROC run_{module}()", "    wptClear;", *home, *calls, *home, "    wptSave;", "  ENDPROC"]


def _clear(program: TouchProgram, steps: tuple[TouchSteps, ...], wobj: str) -> list[str]:
    """Return the procedure that forgets the results of an earlier run; also a stale module of results gets its plan."""
    return [
        "  LOCAL PROC wptClear()",
        *(f"    {OUTCOME}{each.name}:={NOT_RUN};" for each in steps),
        f'    wptPlan:="{program.plan.fingerprint}";',
        f'    wptTool:="{_tool(program)}";',
        f"    wptCount:={len(steps)};",
        "    wptPart:=wpPart;",
        "  ENDPROC",
    ]


def _save(program: TouchProgram, module: str) -> list[str]:
    file = f"{module}{RESULTS}"
    return [
        "  LOCAL PROC wptTell(string name,num outcome)",
        "    wptSave;",
        f"    IF outcome={ACTIVE} THEN",
        f'      TPWrite name+" {ACTIVE_TEXT}";',
        "    ELSE",
        f'      TPWrite name+" {MISSED_TEXT}";',
        "    ENDIF",
        "    Stop;",
        "  ENDPROC",
        "",
        "  LOCAL PROC wptSave()",
        f'    Save "{file}"\\FilePath:="{_folder(program)}"\\File:="{file}.mod";',
        "  ERROR",
        f'    TPWrite "results not saved; they are in {file}";',
        "    TRYNEXT;",
        "  ENDPROC",
    ]
