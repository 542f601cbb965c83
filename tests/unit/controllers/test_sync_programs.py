"""Programs of two robots, read back by parsers that know the languages and nothing of the writers."""

import re
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from wpcal.controllers.abb.two_robots import write_sync_rapid
from wpcal.controllers.program import ControllerSettings
from wpcal.controllers.program.coordinated_program import SyncProgram
from wpcal.controllers.yaskawa.two_robots import SYNC_NUMBERS, joint_percents, write_sync_inform
from wpcal.core.errors import InputError
from wpcal.robot.kinematics.arm_file import find_arm

HALF_RAPID_DEG = 0.5e-5 + 1e-12  #: Half of the fifth decimal, and round-off.
HALF_INFORM_DEG = 0.5e-4 + 1e-12  #: Half of the fourth decimal, and round-off.
HALF_SECOND = 0.5e-4 + 1e-12  #: Half of the fourth decimal of a time.


def program_of(seed, n=9, **changes):
    rng = np.random.default_rng(seed)
    arms = (find_arm("irb1600_6_12"), find_arm("mh6"))
    joints = tuple(np.cumsum(rng.uniform(-0.02, 0.02, (n, 6)), axis=0) + rng.uniform(-2, 2, 6) for _ in arms)
    values = {
        "seam": "W1",
        "arms": arms,
        "joints": joints,
        "seconds": rng.uniform(0.2, 0.5, n - 1),
        "arc_on": 2,
        "arc_off": n - 3,
        "notes": ("checked: free",),
    }
    return SyncProgram(**{**values, **changes})


def parse_rapid(text):
    """Joints in the order of the moves, the marks, the times, and where the arc burns."""
    code = [line.strip() for line in text.split("\r\n")]
    targets = {
        m[1]: [float(v) for v in m[2].split(",")]
        for m in re.finditer(r"CONST jointtarget (\w+):=\[\[([^\]]*)\],\[(?:9E\+09,?){6}\]\];", text)
    }
    body = code[next(i for i, line in enumerate(code) if line.startswith("PROC")) + 1 : code.index("ENDPROC")]
    first = re.fullmatch(r"MoveAbsJ (\w+),vStep,fine,(\w+);", body[0])
    assert body[1] == "SyncMoveOn start_W1,tasks_W1;"
    assert body[-1] == "SyncMoveOff end_W1;"
    joints, marks, seconds, arc = [targets[first[1]]], [1], [], []
    for line in body[2:-1]:
        if line.startswith("! ARC"):
            arc.append((line[2:], marks[-1]))
            continue
        label, mark, time, zone, tool = re.fullmatch(
            r"MoveAbsJ (\w+)\\ID:=(\d+),vStep\\T:=([\d.]+),(z1|fine),(\w+);", line
        ).groups()
        joints.append(targets[label])
        marks.append(int(mark))
        seconds.append(float(time))
        assert tool == first[2]
    assert zone == "fine"
    assert all(len(line) <= 80 or line.startswith("LOCAL CONST") for line in code)
    return np.array(joints), marks, np.array(seconds), arc


def parse_inform(text):
    """The same of a job; for times the shares of the largest joint speeds; and the numbers of TSYNC."""
    head, instructions = text.split("//INST")
    rows = [[float(v) for v in m[1].split(",")] for m in re.finditer(r"^C\d{5}=([^\r]*)", head, re.MULTILINE)]
    assert int(re.search(r"///NPOS (\d+),0,0,0,0,0", head)[1]) == len(rows)
    joints, marks, shares, arc, syncs = [], [], [], [], []
    for line in instructions.split("\r\n"):
        if m := re.fullmatch(r"MOVJ C(\d{5}) VJ=(\d+\.\d\d) PL=0", line):
            joints.append(rows[int(m[1])])
            shares.append(float(m[2]))
        elif m := re.fullmatch(r"'MARK (\d+)", line):
            marks.append(int(m[1]))
        elif m := re.fullmatch(r"TSYNC (\d+) SNUM=2", line):
            syncs.append(int(m[1]))
        elif line.startswith("'ARC"):
            arc.append((line[1:], marks[-1]))
    assert len(syncs) == len(marks)
    assert all(len(line) <= 33 for line in instructions.split("\r\n") if line.startswith("'"))
    return np.array(joints), marks, np.array(shares[1:]), arc, syncs, re.search(r"///POSTYPE (\w+)", head)[1]


@given(seed=st.integers(0, 2**32), n=st.integers(6, 40))
def test_programs_give_back_joints_times_and_marks(seed, n):
    program = program_of(seed, n)
    rapid, inform = write_sync_rapid(program), write_sync_inform(program)
    assert sorted(rapid) == ["WPCAL_R1.mod", "WPCAL_R2.mod"]
    assert sorted(inform) == ["WPCAL.jbi", "WPCAL_R1.jbi", "WPCAL_R2.jbi"]
    for robot in (1, 2):
        one, other = rapid[f"WPCAL_R{robot}.mod"], inform[f"WPCAL_R{robot}.jbi"]
        joints, marks, seconds, arc = parse_rapid(one)
        np.testing.assert_allclose(joints, np.degrees(program.joints[robot - 1]), rtol=0, atol=HALF_RAPID_DEG)
        np.testing.assert_allclose(seconds, program.seconds, rtol=0, atol=HALF_SECOND)
        assert 'PERS tasks tasks_W1{2}:=[["T_ROB1"],["T_ROB2"]];\r' in one
        joints, *same, syncs, kind = parse_inform(other)
        np.testing.assert_allclose(joints, np.degrees(program.joints[robot - 1]), rtol=0, atol=HALF_INFORM_DEG)
        assert marks == same[0] == list(range(1, n + 1))
        assert arc == same[2] == [("ARC ON", program.arc_on + 1), ("ARC OFF", program.arc_off + 1)]
        assert (kind, syncs) == ("ANGLE", [(mark - 1) % SYNC_NUMBERS + 1 for mark in marks])
        assert f"///GROUP1 RB{robot}" in other


def test_the_share_of_the_joint_speed_gives_the_time_back():
    """A step takes what the slower robot needs at its VJ: the planned time, within the rounding of the larger VJ."""
    program = program_of(5, 30)
    files, needed, written = write_sync_inform(program), [], []
    for robot in (1, 2):
        joints, _, shares, *_ = parse_inform(files[f"WPCAL_R{robot}.jbi"])
        most = np.degrees([joint.speed_rad_s for joint in program.arms[robot - 1].joints])
        needed.append((np.abs(np.diff(joints, axis=0)) / most).max(axis=1) / (shares / 100))
        written.append(shares)
    taken, larger = np.max(needed, axis=0), np.max(written, axis=0)
    rounding = program.seconds * 0.005 / larger + 4 * HALF_INFORM_DEG / (200 * larger / 100)  # joints turn 200 deg/s
    assert (np.abs(taken - program.seconds) <= rounding).all()
    note = re.sub(r"\r\n'\s*", " ", files["WPCAL.jbi"])
    least, largest = (float(v) for v in re.search(r"takes ([\d.]+) to ([\d.]+) % of its time", note).groups())
    weld = 100 * (taken / program.seconds)[program.arc_on : program.arc_off]
    np.testing.assert_allclose([least, largest], [weld.min(), weld.max()], rtol=0, atol=0.2)  # joints as written


def test_a_robot_that_hardly_moves_does_not_slow_the_other():
    program = program_of(6, 12)
    slow = program.joints[1][:1] + 1e-3 * (program.joints[1] - program.joints[1][:1])
    percents = joint_percents(replace(program, joints=(program.joints[0], slow)))
    shares = 100 * np.abs(np.diff(slow, axis=0)) / [joint.speed_rad_s for joint in program.arms[1].joints]
    assert (percents[1] >= shares.max(axis=1) / program.seconds - 1e-9).all()
    assert (percents[1] >= 0.01).all()


def test_pulses_are_written_where_the_arm_states_them():
    arm = find_arm("mh6")
    counting = replace(arm, joints=tuple(replace(joint, pulses_per_deg=1000.0) for joint in arm.joints))
    program = program_of(1, arms=(counting, arm))
    files = write_sync_inform(program)
    *_, kind = parse_inform(files["WPCAL_R2.jbi"])
    assert kind == "ANGLE"
    joints, *_, kind = parse_inform(files["WPCAL_R1.jbi"])
    assert kind == "PULSE"
    np.testing.assert_allclose(joints / 1000, np.degrees(program.joints[0]), rtol=0, atol=0.5e-3)


def test_the_job_that_starts_both_moves_none():
    main = write_sync_inform(program_of(1))["WPCAL.jbi"]
    assert "///GROUP1" not in main
    assert re.findall(r"PSTART JOB:(\S+) SUB(\d)", main) == [("WPCAL_R1", "1"), ("WPCAL_R2", "2")]
    assert re.findall(r"PWAIT SUB(\d)", main) == ["1", "2"]


def test_names_that_no_controller_takes_become_ones_that_it_does():
    controller = ControllerSettings(program_name="Naht ä/" + 40 * "x", tool_name="my tool")
    program = program_of(1, seam="Rib 7 \n; DELETE", controller=controller)
    for name, text in {**write_sync_rapid(program), **write_sync_inform(program)}.items():
        assert len(name.split(".")[0]) <= 32
        assert text.isascii()
        assert not [line for line in text.split("\r\n") if line.strip().startswith("; DELETE")]


def test_programs_of_two_seams_share_no_name():
    names = []
    for seam in ("W1", "W2"):
        text = write_sync_rapid(program_of(1, seam=seam, controller=ControllerSettings(program_name=f"P_{seam}")))[
            "P_" + seam + "_R1.mod"
        ]
        names.append(set(re.findall(r"(?:MODULE|PERS tasks|VAR syncident|PROC) (\w+)", text)))
    assert len(names[0]) == 5
    assert not names[0] & names[1]


def test_an_arm_without_joint_speeds_has_no_inform():
    arm = find_arm("mh6")
    silent = replace(arm, joints=(replace(arm.joints[0], speed_rad_s=None), *arm.joints[1:]))
    with pytest.raises(InputError, match="does not state the speed of joint S"):
        write_sync_inform(program_of(1, arms=(silent, arm)))


def test_more_than_the_largest_joint_speed_is_refused():
    program = program_of(1)
    with pytest.raises(InputError, match=r"robot 1 would need \d+ % of its joint speed to mark"):
        write_sync_inform(replace(program, seconds=program.seconds * 1e-3))


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"seconds": np.full(7, 0.1)}, r"joints of shape \(8, 6\)"),
        ({"seconds": np.array([0.1, 0.0] + 6 * [0.1])}, "must be positive"),
        ({"arc_on": 8}, "expected rows of the 9 in order"),
    ],
)
def test_programs_that_make_no_sense_are_refused(changes, message):
    with pytest.raises(InputError, match=message):
        program_of(0, **changes)
