"""KUKA KRL: a pair ``NAME_touch.src`` and ``NAME_touch.dat`` that touches the part.

An interrupt on the touch signal stops the search (``BRAKE``), stores ``$POS_INT``, the place where the signal came, and
leaves the search (``RESUME``). ``RESUME`` ends all subprograms up to the level that declared the interrupt. The search
is therefore two levels deep: `WPFIND` declares the interrupt, `WPSEARCH` moves and is ended. ``WAIT SEC 0`` after the
move stops the advance run, so that the program does not leave `WPSEARCH` before the robot is there.

With `with_package` the searches are folds of TouchSense (`wpcal.controllers.kuka.touch_sense`).

Results are variables of the data list, which the controller keeps in the ``.dat``.

References
----------
KUKA, System Software 8.x: Operating and Programming Instructions for System Integrators (INTERRUPT, BRAKE, RESUME,
$POS_INT).
"""

from __future__ import annotations

from wpcal.controllers.kuka.configuration import status_and_turn
from wpcal.controllers.kuka.touch_sense import sense_data, sense_moves
from wpcal.controllers.kuka.write import (
    ATTRIBUTES,
    DEG_DECIMALS,
    JOINT_PERCENT,
    LONGEST_COMMENT,
    MM_DECIMALS,
    NAMES,
    aggregates,
)
from wpcal.controllers.language.naming import comment_lines
from wpcal.controllers.language.rounding import rounded_frame, zyx_degrees
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
    number_of,
)
from wpcal.core.errors import InputError
from wpcal.core.transform import RigidTransform

LARGEST_INPUT = 4096
"""Inputs and outputs of a KR C4."""
LARGEST_INTERRUPT = 39
"""Numbers up to it, and from 81 on, are free for users."""
OUTCOME, PLACE = "WPO_", "WPR_"
HOME = "WPHOME"
NOWHERE = "{X 0.0,Y 0.0,Z 0.0,A 0.0,B 0.0,C 0.0,S 0,T 0,E1 0.0,E2 0.0,E3 0.0,E4 0.0,E5 0.0,E6 0.0}"
"""The place of a search that was not run."""


def write_touch_krl(program: TouchProgram) -> dict[str, str]:
    """Write a KRL program of searches and its data list.

    Returns
    -------
    dict of str to str. ``NAME_touch.src`` and ``NAME_touch.dat``, with lines ended by CR LF.

    Raises
    ------
    InputError : When KRL has no such input, output or interrupt.
    """
    name = program.name(NAMES)
    T_base_frame = rounded_frame(program.plan.T_base_part, mm_decimals=MM_DECIMALS, deg_decimals=DEG_DECIMALS)
    steps = program.steps(T_base_frame)
    known = _configurations(steps)
    post = TouchPost("krl", program)
    header = post.header(_about(program, name, known=known is not None))
    frame = aggregates(T_base_frame.t_mm[None], zyx_degrees(T_base_frame.R, decimals=DEG_DECIMALS)[None])[0]
    data = [
        *ATTRIBUTES,
        f"DEFDAT {name} PUBLIC",
        *header,
        "DECL CHAR WPPLAN[8]",
        f'WPPLAN[]="{program.plan.fingerprint}"',
        f"DECL INT WPTOOL={program.controller.tool_number}",
        f"DECL INT WPCOUNT={len(steps)}",
        f"DECL FRAME WPPART={frame}",
        f"DECL INT WPRESULT={NOT_RUN}",
        f"DECL E6POS WPPLACE={NOWHERE}",
        *([f"DECL FRAME WPSEEN={frame}"] if program.setup.with_package else []),
        *_home(program),
        *(line for row, each in enumerate(steps) for line in _points(each, None if known is None else known[row])),
        *(line for each in steps for line in _sensed(program, each, T_base_frame)),
        *(line for each in steps for line in _stored(each)),
        "ENDDAT",
        "",
    ]
    source = [
        *ATTRIBUTES,
        f"DEF {name}()",
        *header,
        *_start(program, steps),
        *(line for each in steps for line in _search(each, program, post)),
        *([] if program.plan.home_joints is None else post.joint_move(HOME, speed="")),
        *post.footer(),
        "",
        *([] if program.setup.with_package else [*_find(program, post), ""]),
    ]
    return {f"{name}.src": "\r\n".join(source), f"{name}.dat": "\r\n".join(data)}


def _about(program: TouchProgram, name: str, *, known: bool) -> list[str]:
    results = [
        f"results: variables {OUTCOME} and {PLACE} of {name}.dat, which the controller keeps: copy this file",
        "points and results are relative to WPPART, the part as planned; mm; R = Rz(A) Ry(B) Rx(C), deg",
        f"BASE_DATA[{program.setup.frame_number}] becomes WPPART: weld programs must use another base",
        "S and T are computed from the joints"
        if known
        else "S and T are not known and left out: LIN ignores them, PTP keeps the present ones",
        f"tool {program.controller.tool_number}, interrupt {_interrupt(program)}",
        f"PTP moves run with {JOINT_PERCENT} % of the axes' speed",
    ]
    if program.setup.with_package:
        results.append(f"searches with TouchSense, sensor {program.setup.krl.sensor}, at its slow speed")
    about = describe_touches(program, signal=f"$IN[{_signal(program)}]", results=results)
    return comment_lines(about, mark="", longest=LONGEST_COMMENT)


def _signal(program: TouchProgram) -> int:
    return number_of(program.setup.signal, default=1, what="signal", language="KRL", most=LARGEST_INPUT)


def _enable(program: TouchProgram) -> str:
    if not program.setup.enable:
        return ""
    return f"$OUT[{number_of(program.setup.enable, default=1, what='enable', language='KRL', most=LARGEST_INPUT)}]"


def _interrupt(program: TouchProgram) -> int:
    number = program.setup.krl.interrupt
    if not 1 <= number <= LARGEST_INTERRUPT:
        raise InputError(f"interrupt = {number} of the touch setup: KRL: expected 1 to {LARGEST_INTERRUPT}")
    return number


def _configurations(steps: tuple[TouchSteps, ...]) -> list[list[tuple[int, int]]] | None:
    """Return S and T of every pose of every search; None unless all are known."""
    try:
        known = [status_and_turn(each.postures) for each in steps if each.postures is not None]
    except InputError:
        return None
    return known if len(known) == len(steps) else None


def _home(program: TouchProgram) -> list[str]:
    if program.plan.home_joints is None:
        return []
    joints = angle_texts(program.plan.home_joints[None], DEG_DECIMALS)[0]
    return [f"DECL E6AXIS {HOME}={{{','.join(f'A{row} {value}' for row, value in enumerate(joints, start=1))}}}"]


def _label(steps: TouchSteps, mark: str) -> str:
    return f"WPT_{steps.name}_{mark}"


def _points(steps: TouchSteps, known: list[tuple[int, int]] | None) -> list[str]:
    texts = aggregates(steps.p, zyx_degrees(steps.R, decimals=DEG_DECIMALS))
    if known is not None:
        texts = [f"{text[:-1]},S {status},T {turn}}}" for text, (status, turn) in zip(texts, known, strict=True)]
    return [f"DECL E6POS {_label(steps, mark)}={text}" for mark, text in zip(steps.marks, texts, strict=True)]


def _sensed(program: TouchProgram, steps: TouchSteps, T_base_frame: RigidTransform) -> list[str]:
    return sense_data(program, steps, T_base_frame, _label(steps, "S")) if program.setup.with_package else []


def _stored(steps: TouchSteps) -> list[str]:
    return [f"DECL INT {OUTCOME}{steps.name}={NOT_RUN}", f"DECL E6POS {PLACE}{steps.name}={NOWHERE}"]


def _air(program: TouchProgram) -> str:
    return f"{program.setup.air_speed_mm_s / 1000.0:g}"  # $VEL.CP is in m/s


def _start(program: TouchProgram, steps: tuple[TouchSteps, ...]) -> list[str]:
    home = [] if program.plan.home_joints is None else [f"PTP {HOME}"]
    return [
        "BAS(#INITMOV,0)",
        f"BAS(#VEL_PTP,{JOINT_PERCENT})",
        f"$TOOL=TOOL_DATA[{program.controller.tool_number}]",
        f"BASE_DATA[{program.setup.frame_number}]=WPPART",
        "$BASE=WPPART",
        "$IPO_MODE=#BASE",
        *(f"{OUTCOME}{each.name}={NOT_RUN}" for each in steps),
        *home,
    ]


def _search(steps: TouchSteps, program: TouchProgram, post: TouchPost) -> list[str]:
    """Return one search: the way to it, the search, the way from it, the stop if it found nothing."""
    air = _air(program)
    way = [_label(steps, mark) for mark in steps.marks[:-3]]
    start, end, retract = (_label(steps, mark) for mark in "SER")
    is_first = steps.search is program.plan.searches[0] and program.plan.home_joints is None
    lines = [f"; {steps.name}", f"$VEL.CP={air}", *post.air_move(way[0], speed=air, joint=is_first)]
    for label in (*way[1:], start):
        lines += post.air_move(label, speed=air)
    lines += [f"WPFIND({end})"] if not program.setup.with_package else sense_moves(program, steps, start, air)
    lines += [f"IF WPRESULT=={FOUND} THEN", f"{PLACE}{steps.name}=WPPLACE", "ENDIF"]
    lines += [f"{OUTCOME}{steps.name}=WPRESULT", f"$VEL.CP={air}"]
    for label in (start, retract):
        lines += post.air_move(label, speed=air)
    return [
        *lines,
        f"IF WPRESULT=={MISSED} THEN",
        f'MsgNotify("{steps.name} {MISSED_TEXT}")',
        "HALT",
        "ENDIF",
        f"IF WPRESULT=={ACTIVE} THEN",
        f'MsgNotify("{steps.name} {ACTIVE_TEXT}")',
        "HALT",
        "ENDIF",
    ]


def _find(program: TouchProgram, post: TouchPost) -> list[str]:
    """Return the three subprograms: the first declares the interrupt, the second moves, the third is the interrupt."""
    number, state = _interrupt(program), "TRUE" if program.setup.is_on_high else "FALSE"
    signal = f"$IN[{_signal(program)}]"
    return [
        "DEF WPFIND(WPGOAL:IN)",
        "DECL E6POS WPGOAL",
        f"INTERRUPT DECL {number} WHEN {signal}=={state} DO WPHIT()",
        "WAIT SEC 0",
        *post.sensing(on=True, signal=signal, enable=_enable(program)),
        f"WPRESULT={MISSED}",
        f"IF {signal}=={state} THEN",
        f"WPRESULT={ACTIVE}",
        "ELSE",
        "WPSEARCH(WPGOAL)",
        f"WAIT SEC {program.setup.hold_s:g}",
        "ENDIF",
        *post.sensing(on=False, signal=signal, enable=_enable(program)),
        "END",
        "",
        "DEF WPSEARCH(WPGOAL:IN)",
        "DECL E6POS WPGOAL",
        f"$VEL.CP={program.setup.search_speed_mm_s / 1000.0:g}",
        f"INTERRUPT ON {number}",
        "LIN WPGOAL",
        "WAIT SEC 0",
        f"INTERRUPT OFF {number}",
        "END",
        "",
        "DEF WPHIT()",
        f"INTERRUPT OFF {number}",
        "BRAKE",
        "WPPLACE=$POS_INT",
        f"WPRESULT={FOUND}",
        "RESUME",
        "END",
    ]
