"""Yaskawa INFORM: a job ``NAME_TOUCH.jbi`` that touches the part.

A search is a ``MOVL … SRCH RIN#(n)=ON``: it ends at the end of its stroke, or where the direct input comes. ``$B002``
then says whether it came, and ``$PX002`` where, as pulses; ``CNVRT`` turns them into the user frame. INFORM cannot ask
for a direct input before a move. A contact that is found within `AT_START_MM` of the start counts as active at start.

Places are in P-variables, outcomes in B-variables, fingerprint and numbers of frame and tool in D-variables.

References
----------
Yaskawa, INFORM Language manuals (SRCH, GETS, CNVRT, GETE); docs/how-to/touch-sensing.md says what is confirmed.
"""

from __future__ import annotations

import numpy as np

from wpcal.controllers.language.jobs import frame_in_words
from wpcal.controllers.language.naming import comment_lines
from wpcal.controllers.language.rounding import rounded_frame, zyx_degrees
from wpcal.controllers.program.touch_program import (
    ACTIVE,
    ACTIVE_TEXT,
    FOUND,
    MISSED,
    MISSED_TEXT,
    NOT_RUN,
    Room,
    TouchPost,
    TouchProgram,
    TouchSteps,
    describe_touches,
    number_of,
    refuse_package,
    require_frame,
    require_room,
)
from wpcal.controllers.yaskawa.write import (
    CONFIGURATION,
    DEG_DECIMALS,
    JOINT_PERCENT,
    LANGUAGE,
    LONGEST_COMMENT,
    NAMES,
    coordinates_of,
    inform_job,
    inform_speed,
    joint_rows,
)
from wpcal.core.transform import RigidTransform
from wpcal.touch.searches import halves_of

DIRECT_INPUTS = 6
"""The controllers have RIN#(1) to RIN#(5) or RIN#(6)."""
LARGEST_OUTPUT = 4096
LARGEST_FRAME = 63
"""Of user frames."""
HEAD = 5
"""D-variables: two of the fingerprint, user frame, tool, count. The next one is for the comparison with the start."""
AT_START_MM = 0.3
"""A robot that finds the input on stops within this distance at search speeds."""
UNITS_PER_MM = 1000
"""Of positions in variables."""
HOME_ENDING = "H"
"""The job that goes home is named as the main job, and this."""


def write_touch_inform(program: TouchProgram) -> dict[str, str]:
    """Write an INFORM job of searches, and one that goes home where the plan has a home.

    Returns
    -------
    dict of str to str. ``NAME_TOUCH.jbi`` and ``NAME_TOUCHH.jbi``, with lines ended by CR LF.

    Raises
    ------
    InputError
        When there are too few variables, INFORM cannot write a speed, the configuration is missing, or INFORM has no
        such input, output or user frame.
    """
    refuse_package(program, "INFORM")
    _check(program)
    name = program.name(NAMES).upper()
    digits = {"mm_decimals": LANGUAGE.mm_decimals, "deg_decimals": LANGUAGE.deg_decimals}
    T_base_frame = rounded_frame(program.plan.T_base_part, **digits)
    steps = program.steps(T_base_frame)
    post = TouchPost("inform", program)
    about = comment_lines(_about(program, T_base_frame), mark="", longest=LONGEST_COMMENT)
    home = [] if program.plan.home_joints is None else [f"CALL JOB:{name}{HOME_ENDING}"]
    lines = [*post.header(about), *_clear(program), *home]
    first = 0
    for number, each in enumerate(steps):
        lines += _search(program, each, number, first, post)
        first += len(each.p)
    instructions = [*lines, *home, *post.footer()]
    job = inform_job(name, _positions(program, steps), instructions, user=program.setup.frame_number)
    return {f"{name}.jbi": job, **_home_job(program, f"{name}{HOME_ENDING}", post)}


def _check(program: TouchProgram) -> None:
    setup, count = program.setup.inform, len(program.plan.searches)
    require_frame(program, language="INFORM", most=LARGEST_FRAME)
    for what, first, last, needed in (
        ("position", setup.first_position_variable, setup.last_position_variable, count),
        ("byte", setup.first_byte_variable, setup.last_byte_variable, count),
        ("double", setup.first_double_variable, setup.last_double_variable, HEAD + 1),
    ):
        require_room(program, Room(f"{what} variable", first, last, needed), language="INFORM")


def _signal(program: TouchProgram) -> str:
    number = number_of(program.setup.signal, default=1, what="signal", language="INFORM", most=DIRECT_INPUTS)
    return f"RIN#({number})"


def _enable(program: TouchProgram) -> str:
    if not program.setup.enable:
        return ""
    number = number_of(program.setup.enable, default=1, what="enable", language="INFORM", most=LARGEST_OUTPUT)
    return f"OT#({number})"


def _about(program: TouchProgram, T_base_frame: RigidTransform) -> list[str]:
    setup, count = program.setup.inform, len(program.plan.searches)
    byte, place, head = setup.first_byte_variable, setup.first_position_variable, setup.first_double_variable
    results = [
        *frame_in_words(LANGUAGE, program.setup.frame_number, T_base_frame),
        "weld jobs must use another user frame",
        CONFIGURATION.origin(program.controller, has_arm=program.arm is not None),
        f"results: B{byte:03d} to B{byte + count - 1:03d} outcomes, P{place:03d} to P{place + count - 1:03d} places, "
        "in the order of the searches: copy VAR.DAT",
        f"D{head:03d} to D{head + HEAD - 1:03d}: fingerprint, user frame, tool, count",
    ]
    return describe_touches(program, signal=_signal(program), results=results)


def _clear(program: TouchProgram) -> list[str]:
    setup, count = program.setup.inform, len(program.plan.searches)
    numbers = [*halves_of(program.plan.fingerprint), program.setup.frame_number, program.controller.tool_number, count]
    return [
        *(f"SET D{number:03d} {value}" for number, value in enumerate(numbers, start=setup.first_double_variable)),
        *(f"SET B{setup.first_byte_variable + row:03d} {NOT_RUN}" for row in range(count)),
    ]


def _positions(program: TouchProgram, steps: tuple[TouchSteps, ...]) -> list[str]:
    has_arm = program.arm is not None
    lines = [
        f"///USER {program.setup.frame_number}",
        f"///TOOL {program.controller.tool_number}",
        "///POSTYPE USER",
        "///RECTAN",
    ]
    p, R = np.concatenate([each.p for each in steps]), np.concatenate([each.R for each in steps])
    texts = coordinates_of(p, zyx_degrees(R, decimals=DEG_DECIMALS))
    confs = [
        conf
        for each in steps
        for conf in CONFIGURATION.texts_of(
            program.controller, each.postures, len(each.p), where=f"search {each.name}", has_arm=has_arm
        )
    ]
    before = None
    for conf, text in zip(confs, texts, strict=True):
        lines += [f"///RCONF {conf}", text] if conf != before else [text]
        before = conf
    return lines


def _home_job(program: TouchProgram, name: str, post: TouchPost) -> dict[str, str]:
    """Return the job that goes home: a job in a user frame has no positions in joints."""
    if program.plan.home_joints is None:
        return {}
    kind, rows = joint_rows(program.plan.home_joints[None], program.arm)
    head = [f"///TOOL {program.controller.tool_number}", f"///POSTYPE {kind}", f"///{kind}"]
    move = post.joint_move("C00000", speed=f"VJ={JOINT_PERCENT:.2f}")
    return {f"{name}.jbi": inform_job(name, [*head, f"C00000={','.join(rows[0])}"], move)}


def _search(program: TouchProgram, steps: TouchSteps, number: int, first: int, post: TouchPost) -> list[str]:
    """Return one search: the way to it, the search, the way from it, the stop if it found nothing."""
    setup = program.setup.inform
    air = f"{inform_speed(program.setup.air_speed_mm_s)} PL=0"
    outcome, place = f"B{setup.first_byte_variable + number:03d}", f"{setup.first_position_variable + number:03d}"
    at = {mark: f"C{first + row:05d}" for row, mark in enumerate(steps.marks)}
    way = [at[mark] for mark in steps.marks[:-3]]
    is_first = number == 0 and program.plan.home_joints is None
    joint = f"VJ={JOINT_PERCENT:.2f} PL=0"
    lines = [f"'{steps.name}", *post.air_move(way[0], speed=joint if is_first else air, joint=is_first)]
    for point in (*way[1:], at["S"]):
        lines += post.air_move(point, speed=air)
    signal, level = _signal(program), "ON" if program.setup.is_on_high else "OFF"
    lines += [
        *post.sensing(on=True, signal=signal, enable=_enable(program)),
        f"MOVL {at['E']} {inform_speed(program.setup.search_speed_mm_s)} SRCH {signal}={level}",
        f"TIMER T={program.setup.hold_s:.2f}",
        f"GETS PX{place} $PX002",
        f"CNVRT PX{place} PX{place} UF#({program.setup.frame_number}) TL#({program.controller.tool_number})",
        f"GETS {outcome} $B002",
        *post.sensing(on=False, signal=signal, enable=_enable(program)),
        *_judge(program, steps, number, outcome, place),
    ]
    for mark in "SR":
        lines += post.air_move(at[mark], speed=air)
    return [*lines, f"JUMP *E{number} IF {outcome}={FOUND}", "PAUSE", f"*E{number}"]


def _judge(program: TouchProgram, steps: TouchSteps, number: int, outcome: str, place: str) -> list[str]:
    """Return what turns ``$B002`` into an outcome; a contact at the start is one that was there before."""
    compared = f"D{program.setup.inform.first_double_variable + HEAD:03d}"
    start, end = steps.p[steps.way_count + 1], steps.p[steps.way_count + 2]
    axis = int(np.argmax(np.abs(end - start)))
    stroke = float(np.linalg.norm(end - start))
    near = abs(end[axis] - start[axis]) / stroke * min(AT_START_MM, stroke / 2.0)
    low, high = (round((start[axis] + sign * near) * UNITS_PER_MM) for sign in (-1, 1))
    return [
        f"JUMP *F{number} IF {outcome}={FOUND}",
        f"SET {outcome} {MISSED}",
        f'MSG "{steps.name} {MISSED_TEXT}"',
        f"JUMP *G{number}",
        f"*F{number}",
        f"GETE {compared} P{place} ({axis + 1})",
        f"JUMP *G{number} IF {compared}<{low}",
        f"JUMP *G{number} IF {compared}>{high}",
        f"SET {outcome} {ACTIVE}",
        f'MSG "{steps.name} {ACTIVE_TEXT}"',
        f"*G{number}",
    ]
