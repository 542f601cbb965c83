"""Universal Robots: one URScript program ``NAME_touch.script`` that touches the part.

A thread moves; the program watches the input in every cycle of the controller, takes the pose when the input comes,
ends the thread and stops the robot. Results are lines of the log (``textmsg``), and are sent to a socket if the touch
setup names a computer.

References
----------
Universal Robots, The URScript Programming Language (threads, get_actual_tcp_pose, stopl, textmsg, sockets, popup).
"""

from __future__ import annotations

import re

from wpcal.controllers.language.naming import comment_lines
from wpcal.controllers.program.touch_program import (
    ACTIVE,
    ACTIVE_TEXT,
    FOUND,
    MISSED,
    MISSED_TEXT,
    TouchPost,
    TouchProgram,
    TouchSteps,
    describe_touches,
    number_of,
    refuse_package,
)
from wpcal.controllers.ur.write import (
    JOINT_LIMITS,
    LONGEST_COMMENT,
    NAMES,
    frame_as_written,
    limits,
    poses_of,
)
from wpcal.core.errors import InputError

LARGEST_INPUT = 7
"""Standard inputs and outputs are 0 to 7."""
STOP_M_S2 = 2.0
"""Of the stop at contact: from 10 mm/s within 0.03 mm."""
MARK = "wpcal"
"""At the begin of every line of results."""
HOST = re.compile(r"[A-Za-z0-9.:_-]+")
"""The name or the address of a computer."""
SOCKET = "wpt"
RAD_DECIMALS = 9
"""1e-9 rad moves a point at 2 m by 2e-6 mm."""


def write_touch_urscript(program: TouchProgram) -> dict[str, str]:
    """Write a URScript program of searches. ``NAME_touch.script``.

    Raises
    ------
    InputError : When the robot has no such input or output, or the results cannot be sent to such a computer.
    """
    refuse_package(program, "URScript")
    name = program.name(NAMES)
    T_base_frame = frame_as_written(program.plan.T_base_part)
    post = TouchPost("urscript", program)
    frame = poses_of(T_base_frame.t_mm[None], T_base_frame.R[None])[0]
    home = _home(program, post)
    host, port = program.setup.urscript.results_host, program.setup.urscript.results_port
    if host and not HOST.fullmatch(host):
        raise InputError(f"results_host = {host!r} of the touch setup: expected the name or the address of a computer")
    line = f'"{MARK} {program.plan.fingerprint}'
    steps = program.steps(T_base_frame)
    count = len(program.plan.searches)
    lines = [
        f"def {name}():",
        *post.header(_about(program)),
        f"  wp_part = {frame}",
        "  global wpt_goal = wp_part",
        "  global wpt_place = wp_part",
        "  global wpt_moved = False",
        f"  global wpt_outcome = {MISSED}",
        *_functions(program, post),
        *([f'  socket_open("{host}", {port}, "{SOCKET}")'] if host else []),
        f'  wpt_say({line} begin ", {count})',
        f'  wpt_say({line} tool ", get_tcp_offset())',
        f'  wpt_say({line} part ", wp_part)',
        *home,
        *(text for each in steps for text in _search(program, each, post, line)),
        *home,
        f'  wpt_say({line} end", "")',
        *([f'  socket_close("{SOCKET}")'] if host else []),
        *post.footer(),
        "",
    ]
    return {f"{name}.script": "\n".join(lines)}


def _about(program: TouchProgram) -> list[str]:
    host = program.setup.urscript.results_host
    to = f", and sent to {host}:{program.setup.urscript.results_port}" if host else ""
    results = [
        f"results: lines of the log that begin with {MARK} {program.plan.fingerprint}{to}: keep them as a text file",
        "poses are relative to wp_part, the part as planned; m and rotation vectors in rad",
        "set the tool centre point before this program",
    ]
    about = describe_touches(program, signal=f"digital input {_signal(program)}", results=results)
    return comment_lines(about, mark="", longest=LONGEST_COMMENT)


def _signal(program: TouchProgram) -> int:
    text = program.setup.signal
    return number_of(text, default=0, what="signal", language="URScript", most=LARGEST_INPUT, least=0)


def _enable(program: TouchProgram) -> str:
    text = program.setup.enable
    if not text:
        return ""
    return str(number_of(text, default=0, what="enable", language="URScript", most=LARGEST_INPUT, least=0))


def _home(program: TouchProgram, post: TouchPost) -> list[str]:
    if program.plan.home_joints is None:
        return []
    values = ", ".join(f"{value + 0.0:.{RAD_DECIMALS}f}" for value in program.plan.home_joints)
    return post.joint_move(f"[{values}]", speed=JOINT_LIMITS)


def _functions(program: TouchProgram, post: TouchPost) -> list[str]:
    """Return the functions: what is said, the move of a search, and the search."""
    state = "True" if program.setup.is_on_high else "False"
    is_on = f"get_standard_digital_in({_signal(program)}) == {state}"
    host = program.setup.urscript.results_host
    return [
        "  def wpt_say(text, value):",
        "    textmsg(text, value)",
        *([f'    socket_send_line(str_cat(text, to_str(value)), "{SOCKET}")'] if host else []),
        "  end",
        "  thread wpt_move():",
        f"    movel(wpt_goal, {limits(program.setup.search_speed_mm_s)})",
        "    global wpt_moved = True",
        "  end",
        "  def wpt_search():",
        f"    global wpt_outcome = {MISSED}",
        f"    if {is_on}:",
        f"      global wpt_outcome = {ACTIVE}",
        "    else:",
        "      global wpt_moved = False",
        "      wpt_thread = run wpt_move()",
        f"      while wpt_outcome == {MISSED} and wpt_moved == False:",
        f"        if {is_on}:",
        "          global wpt_place = get_actual_tcp_pose()",
        f"          global wpt_outcome = {FOUND}",
        "        end",
        "        sync()",
        "      end",
        f"      if wpt_outcome == {FOUND}:",
        "        kill wpt_thread",
        f"        stopl({STOP_M_S2:g})",
        "      else:",
        "        join wpt_thread",
        "      end",
        f"      sleep({program.setup.hold_s:g})",
        "    end",
        "  end",
    ]


def _search(program: TouchProgram, steps: TouchSteps, post: TouchPost, mark: str) -> list[str]:
    """Return one search: the way to it, the search, the way from it, the stop if it found nothing.

    `mark` begins its lines of results, with the quotation mark.
    """
    poses = [f"pose_trans(wp_part, {pose})" for pose in poses_of(steps.p, steps.R)]
    start, end, retract = poses[-3:]
    air = limits(program.setup.air_speed_mm_s)
    is_first = steps.search is program.plan.searches[0] and program.plan.home_joints is None
    lines = [f"  # {steps.name}", *post.air_move(poses[0], speed=JOINT_LIMITS if is_first else air, joint=is_first)]
    for pose in (*poses[1:-3], start):
        lines += post.air_move(pose, speed=air)
    line = f"{mark} {steps.name}"
    signal, enable = str(_signal(program)), _enable(program)
    lines += [
        f"  global wpt_goal = {end}",
        *post.sensing(on=True, signal=signal, enable=enable),
        "  wpt_search()",
        *post.sensing(on=False, signal=signal, enable=enable),
        f"  if wpt_outcome == {FOUND}:",
        f'    wpt_say({line} found ", pose_trans(pose_inv(wp_part), wpt_place))',
        f"  elif wpt_outcome == {MISSED}:",
        f'    wpt_say({line} missed", "")',
        "  else:",
        f'    wpt_say({line} active", "")',
        "  end",
    ]
    for pose in (start, retract):
        lines += post.air_move(pose, speed=air)
    return [
        *lines,
        f"  if wpt_outcome == {MISSED}:",
        f'    popup("{steps.name} {MISSED_TEXT}", title="wpcal", warning=True, blocking=True)',
        f"  elif wpt_outcome == {ACTIVE}:",
        f'    popup("{steps.name} {ACTIVE_TEXT}", title="wpcal", warning=True, blocking=True)',
        "  end",
    ]
