"""Kawasaki AS: one file ``NAME_touch.as`` that touches the part.

A search is an ``XMOVE … TILL`` the touch signal. If the signal is on when the robot has stopped, ``HERE`` stores where
it stands. This is behind the contact by the way of the stop; it counts as latency. Results are variables; the
controller writes them with ``SAVE``.

References
----------
Kawasaki, AS Language Reference Manual (XMOVE, HERE, SIG); docs/how-to/touch-sensing.md says what is confirmed.
"""

from __future__ import annotations

from wpcal.controllers.kawasaki.write import (
    ACCURACY_MM,
    DEG_DECIMALS,
    JOINT_PERCENT,
    LONGEST_COMMENT,
    MM_DECIMALS,
    NAMES,
    as_speed,
    frame_as_written,
    transformations,
    without_repeats,
)
from wpcal.controllers.language.naming import comment_lines, own_name
from wpcal.controllers.language.rounding import zyz_degrees
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
    refuse_package,
)

FIRST_INPUT, LAST_INPUT = 1001, 2256
"""Numbers of inputs."""
LAST_OUTPUT = 960
OUTCOME, PLACE, POINT = "wpto_", "wptp_", "wpt_"
PART, HOME = "wpt_part", "#wpt_home"


def write_touch_as(program: TouchProgram) -> dict[str, str]:
    """Write an AS file of searches. ``NAME_touch.as``, with lines ended by CR LF.

    Raises
    ------
    InputError : When AS does not allow the tool's name, or has no such input or output.
    """
    refuse_package(program, "AS")
    name = program.name(NAMES)
    T_base_frame = frame_as_written(program.plan.T_base_part)
    steps = program.steps(T_base_frame)
    post = TouchPost("as", program)
    frame = transformations(T_base_frame.t_mm[None], zyz_degrees(T_base_frame.R, decimals=DEG_DECIMALS)[None])[0]
    home = (
        []
        if program.plan.home_joints is None
        else [f"  SPEED {JOINT_PERCENT} ALWAYS", *post.joint_move(HOME, speed="")]
    )
    lines = [
        *_start(program, steps),
        *home,
        *(line for each in steps for line in _search(program, each, post)),
        *home,
        "  BREAK",
        "  BASE NULL",
    ]
    points = [f"{PART} {frame}", *(line for each in steps for line in _points(each))]
    text = [
        f".PROGRAM {name}()",
        *post.header(_about(program)),
        *without_repeats(lines),
        *post.footer(),
        ".END",
        ".TRANS",
        *points,
        ".END",
        *_home(program),
        "",
    ]
    return {f"{name}.as": "\r\n".join(text)}


def _signal(program: TouchProgram) -> int:
    text = program.setup.signal
    return number_of(text, default=FIRST_INPUT, what="signal", language="AS", most=LAST_INPUT, least=FIRST_INPUT)


def _enable(program: TouchProgram) -> str:
    if not program.setup.enable:
        return ""
    return str(number_of(program.setup.enable, default=1, what="enable", language="AS", most=LAST_OUTPUT))


def _tool(program: TouchProgram) -> str:
    return own_name(program.controller.tool_name, NAMES, what="tool")


def _about(program: TouchProgram) -> list[str]:
    results = [
        f"results: variables {OUTCOME}, {PLACE} and $wpt_plan: SAVE them into a file on the controller and copy it",
        f"points and results are relative to {PART}, the part as planned; mm; R = Rz(O) Ry(A) Rz(T), deg",
        "the configuration is not known: the arm keeps the one it comes with",
        f"the transformation {_tool(program)} (the torch) must be on the controller",
    ]
    about = describe_touches(program, signal=f"signal {_signal(program)}", results=results)
    return comment_lines(about, mark="", longest=LONGEST_COMMENT)


def _start(program: TouchProgram, steps: tuple[TouchSteps, ...]) -> list[str]:
    return [
        f"  BASE {PART}",
        f"  TOOL {_tool(program)}",
        "  CP ON",
        f"  ACCURACY {ACCURACY_MM} ALWAYS",
        f'  $wpt_plan = "{program.plan.fingerprint}"',
        f'  $wpt_tool = "{_tool(program)}"',
        f"  wpt_count = {len(steps)}",
        *(f"  {_stored(each)} = {NOT_RUN}" for each in steps),
    ]


def _stored(steps: TouchSteps) -> str:
    return f"{OUTCOME}{steps.name.lower()}"


def _label(steps: TouchSteps, mark: str) -> str:
    return f"{POINT}{steps.name.lower()}{mark.lower()}"


def _points(steps: TouchSteps) -> list[str]:
    texts = transformations(steps.p, zyz_degrees(steps.R, decimals=DEG_DECIMALS))
    return [f"{_label(steps, mark)} {text}" for mark, text in zip(steps.marks, texts, strict=True)]


def _home(program: TouchProgram) -> list[str]:
    if program.plan.home_joints is None:
        return []
    joints = " ".join(angle_texts(program.plan.home_joints[None], MM_DECIMALS)[0])
    return [".JOINTS", f"{HOME} {joints}", ".END"]


def _search(program: TouchProgram, steps: TouchSteps, post: TouchPost) -> list[str]:
    """Return one search: the way to it, the search, the way from it, the stop if it found nothing."""
    air, outcome = as_speed(program.setup.air_speed_mm_s), _stored(steps)
    way = [_label(steps, mark) for mark in steps.marks[:-3]]
    start, end, retract = (_label(steps, mark) for mark in "SER")
    is_first = steps.search is program.plan.searches[0] and program.plan.home_joints is None
    lines = [f"; {steps.name}"]
    lines += post.air_move(way[0], speed=f"{JOINT_PERCENT}" if is_first else air, joint=is_first)
    for label in (*way[1:], start):
        lines += post.air_move(label, speed=air)
    signal = _signal(program) if program.setup.is_on_high else -_signal(program)
    sensing = {"signal": str(signal), "enable": _enable(program)}
    lines += [
        "  BREAK",
        *post.sensing(on=True, **sensing),
        f"  wpt_outcome = {MISSED}",
        f"  IF SIG({signal}) THEN",
        f"    wpt_outcome = {ACTIVE}",
        "  ELSE",
        f"  SPEED {as_speed(program.setup.search_speed_mm_s)} ALWAYS",
        f"    XMOVE {end} TILL {signal}",
        "    BREAK",
        f"    IF SIG({signal}) THEN",
        f"      HERE {PLACE}{steps.name.lower()}",
        f"      wpt_outcome = {FOUND}",
        "    END",
        f"    TWAIT {program.setup.hold_s:g}",
        "  END",
        f"  {outcome} = wpt_outcome",
        *post.sensing(on=False, **sensing),
    ]
    for label in (start, retract):
        lines += post.air_move(label, speed=air)
    return [
        *lines,
        "  BREAK",
        f"  IF wpt_outcome == {MISSED} THEN",
        f'    PRINT "{steps.name} {MISSED_TEXT}"',
        "    PAUSE",
        "  END",
        f"  IF wpt_outcome == {ACTIVE} THEN",
        f'    PRINT "{steps.name} {ACTIVE_TEXT}"',
        "    PAUSE",
        "  END",
    ]
