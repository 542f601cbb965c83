"""FANUC TP: a program ``NAME_TOUCH.ls`` that touches the part.

A search is a move with ``Skip,LBL[n],PR[k]=LPOS``. It ends when the skip condition is met, and the place where it was
met is in the position register. If the condition is not met, the program goes to the label. The program itself sets the
user frame to the part as planned, and writes outcomes, fingerprint and numbers of frame and tool into registers.

With `with_package` the searches are those of the Touch Sensing option (``Search Start``, ``Search[…]``). They run along
one axis of the touch frame of their schedule, which must be parallel to the part.

References
----------
FANUC, R-30iB HandlingTool Operator's Manual (skip condition, position registers); ArcTool Touch Sensing.
"""

from __future__ import annotations

import numpy as np

from wpcal.controllers.fanuc.write import (
    CONFIGURATION,
    DECIMALS,
    JOINT_PERCENT,
    LANGUAGE,
    NAMES,
    coordinates,
    joint_bodies,
    numbered,
    tp_file,
    tp_speed,
    wrapped,
)
from wpcal.controllers.language.rounding import rounded_frame, zyx_degrees
from wpcal.controllers.program.touch_program import (
    ACTIVE,
    FOUND,
    MISSED,
    NOT_RUN,
    Room,
    TouchPost,
    TouchProgram,
    TouchSteps,
    describe_touches,
    number_of,
    require_frame,
    require_room,
)
from wpcal.core.errors import InputError
from wpcal.core.transform import RigidTransform
from wpcal.touch.searches import halves_of

LARGEST_INPUT = 4096
LARGEST_FRAME = 9
"""Of user frames, unless the controller was set up for more."""
LABELS = 4
"""Of a search: missed, active, on, and end."""
HEAD = 5
"""Registers before the outcomes: two of the fingerprint, user frame, tool, count."""
CONTACT_REGISTER = 32
"""The position register in which Touch Sensing keeps where the contact was."""
SEARCH_AXES = "XYZ"
PARALLEL = 1e-3
"""Sine of the largest angle between a search of the package and its axis: 0.06 degrees."""


def write_touch_fanuc(program: TouchProgram) -> dict[str, str]:
    """Write a TP program of searches. ``NAME_TOUCH.ls``, with lines ended by CR LF.

    Raises
    ------
    InputError
        When there are too few registers, TP cannot write a speed, the configuration is missing, TP has no such input,
        output or user frame, or a search of the package does not run along an axis of the part.
    """
    _check(program)
    name = program.name(NAMES).upper()
    digits = {"mm_decimals": LANGUAGE.mm_decimals, "deg_decimals": LANGUAGE.deg_decimals}
    T_base_frame = rounded_frame(program.plan.T_base_part, **digits)
    steps = program.steps(T_base_frame)
    post = TouchPost("fanuc", program)
    lines = [*post.header(wrapped(_about(program))), *_frame(program, T_base_frame), *_clear(program)]
    positions = list[tuple[str, ...]]()
    home = _home(program, positions, post)
    lines += home
    for number, each in enumerate(steps):
        first = len(positions) + 1
        positions += _bodies(program, each)
        lines += _search(program, each, number, first, post)
    return {f"{name}.ls": tp_file(name, [*lines, *home, *post.footer()], numbered(positions))}


def _check(program: TouchProgram) -> None:
    setup, count = program.setup.fanuc, len(program.plan.searches)
    require_frame(program, language="FANUC", most=LARGEST_FRAME)
    for what, first, last, needed in (
        ("position register", setup.first_position_register, setup.last_position_register, count + 1),
        ("register", setup.first_register, setup.last_register, count + HEAD),
    ):
        require_room(program, Room(what, first, last, needed, least=1), language="FANUC")
    if program.arm is not None and not program.arm.couplings:
        raise InputError(
            "FANUC shows J3 against the horizontal: the arm's file needs a coupling of J3 to J2 with factor 1"
        )


def _signal(program: TouchProgram) -> str:
    return f"DI[{number_of(program.setup.signal, default=1, what='signal', language='FANUC', most=LARGEST_INPUT)}]"


def _enable(program: TouchProgram) -> str:
    if not program.setup.enable:
        return ""
    return f"DO[{number_of(program.setup.enable, default=1, what='enable', language='FANUC', most=LARGEST_INPUT)}]"


def _about(program: TouchProgram) -> list[str]:
    setup, count = program.setup.fanuc, len(program.plan.searches)
    first, place = setup.first_register, setup.first_position_register
    results = [
        f"results: R[{first + HEAD}] to R[{first + HEAD + count - 1}] outcomes, "
        f"PR[{place + 1}] to PR[{place + count}] places, in the order of the searches: "
        "copy posreg.va and numreg.va",
        f"R[{first}] to R[{first + HEAD - 1}]: fingerprint, user frame, tool, count",
        f"UFRAME {program.setup.frame_number} becomes the part as planned (PR[{place}]): weld programs must use "
        "another one",
        f"points and places are relative to it, mm; {LANGUAGE.rotation}, deg",
        CONFIGURATION.origin(program.controller, has_arm=program.arm is not None),
    ]
    if program.setup.with_package:
        results.append(f"touch schedule {setup.schedule}: its frame must be parallel to the part, its speed is used")
    return describe_touches(program, signal=_signal(program), results=results)


def _number(value: float) -> str:
    """Write a number of an assignment; TP wants brackets round a negative one."""
    return f"({value:.{DECIMALS}f})" if value < 0.0 else f"{value:.{DECIMALS}f}"


def _frame(program: TouchProgram, T_base_frame: RigidTransform) -> list[str]:
    """Return what sets the user frame. The register must be a position before its elements can be set."""
    place = program.setup.fanuc.first_position_register
    values = [*T_base_frame.t_mm.tolist(), *zyx_degrees(T_base_frame.R, decimals=DECIMALS).tolist()]
    frame = program.setup.frame_number
    return [
        f"  UTOOL_NUM={program.controller.tool_number}",
        f"  PR[{place}]=LPOS",
        *(f"  PR[{place},{row}]={_number(value)}" for row, value in enumerate(values, start=1)),
        f"  UFRAME[{frame}]=PR[{place}]",
        f"  UFRAME_NUM={frame}",
    ]


def _clear(program: TouchProgram) -> list[str]:
    first, count = program.setup.fanuc.first_register, len(program.plan.searches)
    values = [
        *halves_of(program.plan.fingerprint),
        program.setup.frame_number,
        program.controller.tool_number,
        count,
        *[NOT_RUN] * count,
    ]
    return [f"  R[{number}]={value}" for number, value in enumerate(values, start=first)]


def _head(program: TouchProgram) -> str:
    return f"\tUF : {program.setup.frame_number}, UT : {program.controller.tool_number},"


def _home(program: TouchProgram, positions: list[tuple[str, ...]], post: TouchPost) -> list[str]:
    if program.plan.home_joints is None:
        return []
    positions += joint_bodies(_head(program), program.plan.home_joints[None])
    return post.joint_move(f"P[{len(positions)}]", speed=f"{JOINT_PERCENT}%")


def _bodies(program: TouchProgram, steps: TouchSteps) -> list[tuple[str, ...]]:
    has_arm, where = program.arm is not None, f"search {steps.name}"
    confs = CONFIGURATION.texts_of(program.controller, steps.postures, len(steps.p), where=where, has_arm=has_arm)
    texts = coordinates(steps.p, zyx_degrees(steps.R, decimals=DECIMALS))
    return [(f"{_head(program)}\t\tCONFIG : '{conf}',", *text) for conf, text in zip(confs, texts, strict=True)]


def _search(program: TouchProgram, steps: TouchSteps, number: int, first: int, post: TouchPost) -> list[str]:
    """Return one search: the way to it, the search, the way from it, the stop if it found nothing."""
    setup, air = program.setup.fanuc, tp_speed(program.setup.air_speed_mm_s)
    outcome = f"R[{setup.first_register + HEAD + number}]"
    place = f"PR[{setup.first_position_register + 1 + number}]"
    missed, active, on, end = (LABELS * number + each for each in range(1, LABELS + 1))
    at = {mark: f"P[{first + row}]" for row, mark in enumerate(steps.marks)}
    way = [at[mark] for mark in steps.marks[:-3]]
    is_first = number == 0 and program.plan.home_joints is None
    lines = [f"  !{steps.name}"]
    lines += post.air_move(way[0], speed=f"{JOINT_PERCENT}%" if is_first else air, joint=is_first)
    for point in (*way[1:], at["S"]):
        lines += post.air_move(point, speed=air)
    signal, level = _signal(program), "ON" if program.setup.is_on_high else "OFF"
    lines += post.sensing(on=True, signal=signal, enable=_enable(program))
    lines += [f"  IF {signal}={level},JMP LBL[{active}]"]
    if program.setup.with_package:
        lines += _package(program, steps, at["S"], outcome, place)
    else:
        speed = tp_speed(program.setup.search_speed_mm_s)
        lines += [f"  SKIP CONDITION {signal}={level}"]
        lines += [f"L {at['E']} {speed} FINE Skip,LBL[{missed}],{place}=LPOS"]
    lines += [
        f"  WAIT {program.setup.hold_s:.2f}(sec)",
        f"  {outcome}={FOUND}",
        f"  JMP LBL[{on}]",
        f"  LBL[{missed}]",
        f"  {outcome}={MISSED}",
        f"  MESSAGE[{steps.name} missed]",
        f"  JMP LBL[{on}]",
        f"  LBL[{active}]",
        f"  {outcome}={ACTIVE}",
        f"  MESSAGE[{steps.name} signal on]",
        f"  LBL[{on}]",
        *post.sensing(on=False, signal=signal, enable=_enable(program)),
    ]
    for mark in "SR":
        lines += post.air_move(at[mark], speed=air)
    return [*lines, f"  IF {outcome}={FOUND},JMP LBL[{end}]", "  PAUSE", f"  LBL[{end}]"]


def _package(program: TouchProgram, steps: TouchSteps, start: str, outcome: str, place: str) -> list[str]:
    """Return a search of the option: the outcome before it is that of its alarm, which stops the program.

    The option stores the place of the contact in PR[32]; its own result, an offset, goes to the register first.
    """
    return [
        f"  {outcome}={MISSED}",
        f"  Search Start[{program.setup.fanuc.schedule}] {place}",
        f"L {start} {tp_speed(program.setup.search_speed_mm_s)} FINE Search[{_axis(steps)}]",
        "  Search End",
        f"  {place}=PR[{CONTACT_REGISTER}]",
    ]


def _axis(steps: TouchSteps) -> str:
    """Return the axis of the part along which a search runs, as ``-Y``."""
    direction = steps.search.direction
    row = int(np.argmax(np.abs(direction)))
    if np.linalg.norm(np.delete(direction, row)) > PARALLEL:
        raise InputError(
            f"FANUC: search {steps.name} runs along ({' '.join(f'{v:.3f}' for v in direction)}); Touch Sensing "
            "searches along an axis of the part only: with_package = false in the touch setup"
        )
    return f"{'-' if direction[row] < 0.0 else ''}{SEARCH_AXES[row]}"
