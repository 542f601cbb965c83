"""Programs of two robots in coordinated motion, read from their text by `tests.coordinated_programs`."""

import dataclasses
import re
from functools import cache

import numpy as np
import pytest

from tests.coordinated_faults import Seam, chord_error_mm, faults
from tests.coordinated_programs import READERS, followed
from tests.few import few
from tests.saddle import CELLS, changed
from wpcal.controllers.audit import audit_path
from wpcal.controllers.judge.in_step import in_step, require_in_step
from wpcal.controllers.judge.written import WrittenWrongError
from wpcal.controllers.program.arc import ArcSettings
from wpcal.controllers.program.coordinated_program import build_coordinated_program
from wpcal.controllers.program.two_robots import HeldWeld, build_sync_program, possible_coordinated, possible_programs
from wpcal.controllers.registry import controller_named
from wpcal.core.errors import InputError
from wpcal.core.rotations import rotation_from_zyx
from wpcal.core.transform import RigidTransform
from wpcal.planning.cell.closed_chain import SeamPath
from wpcal.planning.cell.shape import Shape
from wpcal.planning.plan.coordinated import HolderMove, coordinate_run
from wpcal.planning.plan.plan import Plan, schedule_plan
from wpcal.planning.plan.run import build_run
from wpcal.planning.plan.seam_file import read_held_seams
from wpcal.robot.kinematics.inverse import follow_path
from wpcal.robot.moves import Arc, PathTolerance
from wpcal.weld.find import find_welds
from wpcal.weld.place import StatedWeld
from wpcal.weld.rules import shipped_rules

pytest.importorskip("fcl", reason="python-fcl is not installed")
HOLDING, NEAR = np.radians([19.0, 21.0, 36.0, 15.0, -77.0, 0.0]), np.radians([0.0, 0.0, 0.0, 0.0, -45.0, 0.0])
VALUES = {"leg_mm": 5, "passes": 1, "job": 3, "current_a": 200, "voltage_v": 24, "speed_mm_s": 6.0}


@pytest.fixture(scope="module")
def saddle(cell, simple_plan):
    """A closed seam, which robot 2 turns about the pipe."""
    run = build_run(simple_plan, cell, schedule_plan(simple_plan, cell))
    return cell, run, read_held_seams(CELLS / "saddle-seams.json", cell)["W1"]


@pytest.fixture(scope="module")
def straight(saddle, make_seam):
    """A straight seam of 120 mm, while robot 2 turns the part by some 20 degrees about several axes."""
    cell, n = dataclasses.replace(saddle[0], part=()), 25
    T0, u = cell.held_places(HOLDING[None])[0, :3, :3], np.linspace(0.0, 1.0, n)
    R, along = T0.T, np.linspace(-60.0, 60.0, n)  # x of the seam along that of the world, z up
    p = np.array([0.0, 0.0, 60.0]) + along[:, None] * R[:, 0]
    seam = make_seam("W1", p, np.repeat(R[None], n, axis=0), frame="part")
    turning = np.stack([2 * u, 0 * u, -3 * u, 0 * u, 4 * np.sin(3 * u), 20 * u], axis=1)
    joints2 = HOLDING + np.radians(turning)
    T = cell.held_places(joints2)
    tool = np.tile(np.eye(4), (n, 1, 1))
    tool[:, :3, :3] = T[:, :3, :3] @ R @ np.diag([1.0, -1.0, -1.0]) @ rotation_from_zyx(0.0, 0.0, np.radians(30.0))
    tool[:, :3, 3] = np.einsum("nij,nj->ni", T[:, :3, :3], p) + T[:, :3, 3]
    flange = cell.T_world_base.inverse().matrix @ tool @ cell.T_flange_tool.inverse().matrix
    state, zero = np.concatenate([follow_path(cell.arm, flange, NEAR), joints2], axis=1), np.zeros(n)
    plan = Plan("W1", seam.frames.s_mm, state, zero, zero, zero, zero, {}, {})
    return cell, build_run(plan, cell, schedule_plan(plan, cell)), seam


def planned(cell, run, seam):
    state = run.plan.q
    part = cell.part_places(state)
    wire = (np.linalg.inv(part) @ cell.tool_places(state[:, :6]))[:, :3, 2]
    frames = seam.frames
    return Seam(frames.s_mm, frames.p, frames.R[:, :, 0], wire, part)


def by_language(files):
    endings = {"rapid": (".mod",), "inform": (".jbi",), "fanuc": (".ls",), "krl": (".src", ".dat")}
    found = {name: {k: v for k, v in files.items() if k.endswith(end)} for name, end in endings.items()}
    return {name: own for name, own in found.items() if own}


def welded(seam, **more):
    stated = [StatedWeld("W1", None, {**VALUES, **more})]
    identity = RigidTransform.identity(target="base", source="part")
    return find_welds([seam], identity, shipped_rules(), stated=stated).by_seam()["W1"]


@pytest.fixture(scope="module")
def programs(saddle, straight):
    """Return a function for all programs of a seam, dry or with the arc: by language."""

    @cache
    def made(which, burns):
        cell, run, seam = {"saddle": saddle, "straight": straight}[which]
        tacks = {"tacks": {"length_mm": 8.0, "pitch_mm": 50.0}} if which == "straight" else {}
        arc = ArcSettings(4) if burns else None
        held = HeldWeld(seam=seam, weld=welded(seam, **tacks) if burns else None, arc=arc)
        files, refusals, motions = possible_coordinated(run, cell, held)
        return by_language(files), refusals, motions

    return made


@pytest.mark.parametrize("burns", few([False, True], 1))
@pytest.mark.parametrize("which", ["saddle", "straight"])
def test_every_language_keeps_to_the_seam_in_the_held_part(which, burns, programs, request):
    cell, run, seam = request.getfixturevalue(which)
    files, refusals, motions = programs(which, burns)
    assert set(files) == set(motions)
    assert set(files) == set(READERS), refusals
    for name, own in files.items():
        way = planned(cell, run, seam)
        sag_mm = chord_error_mm(way) if name == "fanuc" else 0.0  # lines alone: as good as the frames of the seam
        assert faults(own, name, cell, way, most_mm=0.05 + sag_mm) == [], name


def test_the_straight_seam_has_one_line_and_the_saddle_few_arcs(programs):
    """The marks are those where the seam, or the turn of the part, needs them."""
    for name, motion in programs("straight", False)[2].items():
        ends = [type(move) for move in motion.moves.moves]
        assert Arc not in ends, name
        assert len(ends) <= 4, name  # a sine of 4 degrees within 1 degree, in lines of robot 2
    motions = {name: each for name, each in programs("saddle", False)[2].items() if name != "fanuc"}  # it has no arcs
    assert {len(motion.moves.moves) for motion in motions.values()} == {len(motions["rapid"].moves.moves)}
    assert len(motions["rapid"].moves.moves) <= 20
    assert len(motions["rapid"].run.plan) == 73


def test_the_arm_follows_what_was_read_without_a_jump(programs, saddle, straight):
    for which, (cell, run, _) in (("saddle", saddle), ("straight", straight)):
        for name, own in programs(which, False)[0].items():
            torch, part, _ = followed(READERS[name](own, cell), cell, 5)
            flange = cell.T_world_base.inverse().matrix @ part @ torch @ cell.T_flange_tool.inverse().matrix
            joints = follow_path(cell.arm, flange, run.q[0, :6])
            assert np.degrees(np.abs(np.diff(joints, axis=0))).max() < 20.0, (which, name)


def test_all_say_that_they_are_dry_or_not_what_was_checked_and_which_tack_welds_are_missing(programs):
    for which, burns in (("saddle", False), ("straight", False), ("straight", True)):
        for own in programs(which, burns)[0].values():
            text = re.sub(r"^ *\d+:", "", next(iter(own.values())), flags=re.MULTILINE)
            first = re.sub(r"[\r\n;!'\s]+", " ", text)
            assert ("DRY RUN" in first) != burns
            assert ("tack welds of W1 (3) are not in this plan" in first) == (burns and which == "straight")
            assert "RUN IT DRY FIRST" in first
            assert re.search(r"its moves as planned: free,? \d+ states checked", first)


def test_a_run_without_room_for_approach_and_retract_begins_and_ends_on_the_seam(straight, programs):
    cell, run, seam = straight
    for name, motion in programs("straight", False)[2].items():
        bare = dataclasses.replace(motion, approach=None, retract=None)
        program = build_coordinated_program(bare, seam)
        assert len(program.path) == len(motion.moves)
        own = dict(controller_named(name).write_coordinated(program))
        assert faults(own, name, cell, planned(cell, run, seam)) == [], name


@pytest.mark.filterwarnings("ignore::DeprecationWarning")  # of pyparsing, in rapidchecker
def test_rapid_is_what_another_grammar_takes(programs):
    check = pytest.importorskip("rapidchecker.check", reason="rapidchecker is not installed")
    for which, burns in (("straight", True), ("saddle", False)):
        for text in programs(which, burns)[0]["rapid"].values():
            assert check.check_format(text) == []


PLANTED = {
    "rapid": {
        "tool": (r"(ID:=20,vWeld,\w+),tTorch", r"\1,tool0"),
        "the work object of robot 1": (r'"ROB_2"', '"ROB_1"'),
        "a fixed work object": (r"FALSE,FALSE,", "FALSE,TRUE,"),
        "the frame of the tool as that of the part": (r"(\[\[0,0,0\],\[1,0,0,0\]\],\[\[)[^\]]*", r"\g<1>0,0,350"),
        "a mark of robot 2": (r"\n[^\n]*held_0002\\ID:=20[^\n]*", ""),
        "the number of a mark": (r"(W1_held_0002\\ID:=)20", r"\g<1>25"),
        "the start of the synchronised motion": (r"\n[^\n]*SyncMoveOn[^\n]*", ""),
        "a point": (r"(robtarget W1_0002:=\[\[)([-\d.]+)", r"\g<1>99"),
        "the comment at the start": (r"\n[^\n]*! ARC ON", ""),
    },
    "inform": {
        "tools": (r"///TOOL 1\r\nC00002", "///TOOL 0\r\nC00002"),
        "robots": (r"///GROUP1 RB1\r\n///GROUP2 RB2", "///GROUP1 RB2\r\n///GROUP2 RB1"),
        "the master of a move": (r"(SMOVL C00004[^\n]*\+MOVJ C)00005", r"\g<1>00007"),
        "coordination": (r"SMOV(L C00004)", r"MOV\1"),
        "a joint of robot 2": (r"(C00005=)([-\d.]+)", r"\g<1>0.0"),
        "the comment at the end": (r"\n'ARC OFF", ""),
    },
    "fanuc": {
        "tools": (r"(P\[2\]\{\r\n   GP1:\r\n\tUF : 0, UT : )1", r"\g<1>2"),
        "groups": (r"1,1,\*,\*,\*", "1,*,*,*,*"),
        "coordination": (r"(L P\[3\][^;]*) COORD", r"\1"),
        "the place of the part": (r"(!  ?Z )[-\d.]+", r"\g<1>0.0"),
        "robots": (r"(P\[3\]\{\r\n)   GP1(:.*?)   GP2", r"\1   GP2\2   GP1"),
    },
    "krl": {
        "tools": (r"\$TOOL=PART_HELD", "$TOOL=TOOL_DATA[1]"),
        "the base": (r"SBASE\(1\)", "BASE_DATA[1]"),
        "a mark": (r'\$SYNC_ID\[\]="M20"', '$SYNC_ID[]="M21"'),
        "a point": (r"(E6POS W1_0002=\{X )[-\d.]+", r"\g<1>99"),
        "the place of the part": (r"(PART_HELD=\{X )[-\d.]+", r"\g<1>9"),
    },
}


@pytest.mark.parametrize(("name", "fault"), [(name, fault) for name, own in PLANTED.items() for fault in own])
def test_a_planted_fault_is_found(name, fault, programs, straight):
    """One change in one file; what is in both files of a language is changed in one of them only."""
    cell, run, seam = straight
    files = programs("straight", False)[0][name]
    pattern, by = PLANTED[name][fault]
    row = next(row for row, text in files.items() if re.search(pattern, text, re.DOTALL))
    changed = {**files, row: re.sub(pattern, by, files[row], count=1, flags=re.DOTALL)}
    assert changed != files
    assert faults(changed, name, cell, planned(cell, run, seam)) != []
    program = build_coordinated_program(programs("straight", False)[2][name], seam)
    with pytest.raises(WrittenWrongError, match=r", line \d+: "):
        require_in_step(changed, program, cell)


@pytest.mark.parametrize(
    ("name", "stop", "flow"),
    [
        ("rapid", r",fine,(?=t|W1|\w+;)", ",z1,"),
        ("inform", r" PL=0", " PL=1"),
        ("fanuc", r" FINE COORD", " CNT100 COORD"),
        ("krl", r"(?m)^( *SLIN [^\r\n]*)(?<!C_SPL)(?=\r?$)", r"\1 C_SPL"),
    ],
)
def test_a_stop_that_is_none_is_named(name, stop, flow, programs, straight):
    """In a file of either robot, at the ends of the seam and off it."""
    cell, _, seam = straight
    files = programs("straight", False)[0][name]
    program = build_coordinated_program(programs("straight", False)[2][name], seam)
    require_in_step(files, program, cell)
    stops = [(file, found) for file, text in files.items() for found in re.finditer(stop, text)]
    assert len(stops) >= 3
    for file, found in stops:
        text = found.string[: found.start()] + found.expand(flow) + found.string[found.end() :]
        with pytest.raises(WrittenWrongError, match="no stop where the plan has one"):
            require_in_step({**files, file: text}, program, cell)


def test_programs_of_joints_lead_through_the_plan_and_nowhere_else(straight):
    cell, run, _ = straight
    program = build_sync_program(run, cell)
    files, _ = possible_programs(program)
    require_in_step(files, program, cell)
    moves = r"MoveAbsJ \w+\\ID:=5.*\r\n|MOVJ C00005 .*\r\n"
    cases = [(name, line) for name, text in files.items() for line in re.findall(moves, text)]
    assert len(cases) == 4
    for name, line in cases:
        for new in ("", 2 * line, line.replace("5", "6")):  # left out, twice, another one
            with pytest.raises(WrittenWrongError, match=rf"{name}.*: (not the next joints|a move without)"):
                require_in_step({**files, name: files[name].replace(line, new)}, program, cell)


@pytest.mark.parametrize(("name", "target"), [("rapid", r"W1_0020:=\[\["), ("inform", r"C00019=")])
def test_arms_that_would_meet_are_named_with_the_lines_of_both(name, target, straight):
    """Robot 2 bends its elbow by 40 degrees at one mark, while robot 1 welds on."""
    cell, run, _ = straight
    program = build_sync_program(run, cell)
    files = dict(controller_named(name).write_sync(program))
    row = next(file for file in files if "_R2." in file)
    bent = re.sub(
        rf"({target}[-\d.]+,[-\d.]+,)([-\d.]+)", lambda m: f"{m[1]}{float(m[2]) - 40.0:.4f}", files[row], count=1
    )
    start = np.concatenate([q[0] for q in program.joints])
    found = list(in_step({**files, row: bent}, cell, start, tools=["tTorch"]).meetings())
    assert list(in_step(files, cell, start, tools=["tTorch"]).meetings()) == []
    what = next(each for each in found if "robot 1" in each.what)
    assert re.match(rf"with {row}, line \d+: on the move there robot 1 .* and robot 2 .* miss", what.what), what
    at = what.motion.place
    assert re.search(target[:6], files[at.file].splitlines()[at.line - 1])


@pytest.mark.parametrize(
    ("name", "pattern"),
    [
        ("rapid", r"ArcLStart"),
        ("rapid", r"ArcLEnd"),
        ("inform", r"ARCON AS[^\n]*\n"),
        ("inform", r"ARCOF A[^\n]*\n"),
        ("fanuc", r"Weld Start"),
        ("krl", r"\$OUT\[4\]=TRUE"),
        ("krl", r"\$OUT\[4\]=FALSE"),
    ],
)
def test_an_arc_instruction_that_is_missing_is_found(name, pattern, programs, straight):
    cell, run, seam = straight
    files = programs("straight", True)[0][name]
    row = next(row for row, text in files.items() if re.search(pattern, text))
    by = {"ArcLStart": "MoveL", "ArcLEnd": "ArcL"}.get(pattern, "")
    assert faults({**files, row: re.sub(pattern, by, files[row])}, name, cell, planned(cell, run, seam)) != []


AUDITED = {
    "a fixed work object": ("rapid", r"FALSE,FALSE,", "FALSE,TRUE,", "does not move with a robot"),
    "the work object of robot 1": ("rapid", r'"ROB_2"', '"ROB_1"', "in the hand of ROB_1"),
    "a mark of robot 2": ("rapid", r"\n[^\n]*held_0002\\ID:=20[^\n]*", "", "mark 20 is not in WPCAL_W1_R2.mod"),
    "the arc": ("rapid", r"ArcLEnd", "ArcL", "the arc is still on at the end of a seam"),
    "a word of robot 2": ("rapid", r"AbsJ (\w+_held_0002)", r"AbsQ \1", "NOT CHECKED: ArcMoveAbsQ is unknown"),
    "another work object": ("rapid", r"(ID:=20.*?WObj:=)\w+", r"\1wobj1", "a move in wobj1"),
    "a joint move in the seam": ("inform", r"SMOV(L C00004[^+]*)\+MOVJ C00005", r"SMOV\1", "that of the master"),
    "a position": ("inform", r"\nC00005=[^\n]*", "", "there is no position C00005"),
    "the start of the arc": ("inform", r"ARCON[^\n]*\n", "", "a seam without an arc"),
    "coordination": ("fanuc", r"(L P\[3\][^;]*) COORD", r"\1", "without COORD"),
    "a group": ("fanuc", r"(P\[3\]\{.*?)   GP2:.*?\};", r"\1};", "P[3] does not hold both groups"),
    "a mark": ("krl", r'\$SYNC_ID\[\]="M20"', '$SYNC_ID[]="M21"', "mark M21 is not in"),
    "a statement that is none": ("krl", r"\$BASE=", "?BASE=", "NOT CHECKED: cannot be read: '?BASE="),
    "a number that is none": ("fanuc", r"Y = +-?\d+\.\d+", "Y = -inf", "expected a finite number"),
    "a held part nowhere": ("fanuc", r"(GP2:.*?Y = +)-?\d+\.\d+", r"\1-inf", "to a position that is no number"),
    "a point": ("krl", r"(\nSLIN )W1_0002", r"\1W1_0009", "there is no point W1_0009"),
}


@pytest.mark.parametrize("fault", AUDITED)
def test_the_audit_finds_what_does_not_fit_together(fault, programs, tmp_path):
    name, pattern, by, words = AUDITED[fault]
    files = programs("straight", True)[0][name]
    for file, text in files.items():
        (tmp_path / file).write_bytes(text.encode())
    clean = audit_path(tmp_path)
    assert [one.faults for one in clean.files] == [()] * len(files)
    assert all("two robots" in one.kind and "the part, the reach of an arm" in one.checked for one in clean.files)
    row = next(row for row, text in files.items() if re.search(pattern, text, re.DOTALL))
    (tmp_path / row).write_bytes(re.sub(pattern, by, files[row], count=1, flags=re.DOTALL).encode())
    told = [fault.message for one in audit_path(tmp_path).files for fault in one.faults]
    assert any(words in message for message in told), told


def test_a_larger_tolerance_needs_fewer_moves(saddle):
    cell, run, seam = saddle
    path = SeamPath.of_frames("W1", seam.frames)
    counts = [
        len(coordinate_run(run, cell, path, tolerance=PathTolerance(mm, np.radians(deg))).moves.moves)
        for mm, deg in ((0.02, 0.2), (0.05, 0.5), (0.5, 2.0))
    ]
    assert counts[0] > counts[1] > counts[2]


def test_a_part_that_would_collide_between_the_marks_is_refused(saddle):
    cell, run, seam = saddle
    near = cell.tool_places(run.plan.q[40:41, :6])[0, :3, 3] + [0, 0, 60]
    blocked = dataclasses.replace(cell, bench=(*cell.bench, Shape("clamp", [near], [near], [25.0])))
    languages = ("rapid", "inform")  # of one motion: the search is not repeated
    files, refusals, motions = possible_coordinated(run, blocked, HeldWeld(seam=seam), languages=languages)
    assert (files, motions, len(refusals)) == ({}, {}, 2)
    assert re.match(r"rapid: seam W1: no coordinated motion near the plan is free: .* clamp", refusals[0])


def test_a_joint_that_would_be_too_fast_is_named(saddle):
    cell, run, seam = saddle
    slow = tuple(dataclasses.replace(joint, speed_rad_s=np.radians(2.0)) for joint in cell.arm2.joints)
    lame = changed(cell, arm2=dataclasses.replace(cell.arm2, joints=slow))
    with pytest.raises(InputError, match=r"joint \w of robot 2 would need \d+ % of its speed at s = "):
        coordinate_run(run, lame, SeamPath.of_frames("W1", seam.frames), holder=HolderMove.JOINTS)


def test_weld_data_of_several_beads_are_refused_in_one_line(straight):
    cell, run, seam = straight
    held = HeldWeld(seam=seam, weld=welded(seam, leg_mm=12, passes=3))
    files, refusals, _ = possible_coordinated(run, cell, held)
    assert not files
    assert all("3 beads or stretches; a plan of two robots is one bead" in line for line in refusals)
