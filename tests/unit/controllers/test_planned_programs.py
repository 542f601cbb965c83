"""Programs of plans, read by patterns of the languages and checked by kinematics of their own."""

import dataclasses
import re
from pathlib import Path

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from tests.one_robot_cells import TEE, TEE_ON_TABLE, fixed_cell, pipe_ring, with_positioner, write_cell
from tests.unit.controllers.judging import judged
from wpcal.controllers.audit.two_robots import two_robot_faults
from wpcal.controllers.judge.written import WrittenWrongError
from wpcal.controllers.language.jobs import ConfigurationRule
from wpcal.controllers.plan_programs import write_plan
from wpcal.controllers.program import ControllerSettings
from wpcal.controllers.program.arc import ArcSettings
from wpcal.controllers.program.describe import UNCHECKED, describe
from wpcal.controllers.program.planned_program import PlanOutput, build_planned_program
from wpcal.controllers.registry import controller_named
from wpcal.controllers.tool_data import read_tool_data
from wpcal.core.errors import FormatError, InputError
from wpcal.planning.cell.cell import Rail
from wpcal.planning.cell.cell_file import read_one_robot
from wpcal.planning.plan.run import Phase
from wpcal.planning.sequence.kept_plan import KeptPlan
from wpcal.planning.sequence.plan_sequence import plan_sequence
from wpcal.planning.sequence.sequence_input import read_sequence_input
from wpcal.planning.sequence.targets import SequenceTargets, WeldPosition
from wpcal.planning.sequence.timeline import build_timeline
from wpcal.planning.sequence.trajectory import joint_trajectory, tesseract_states
from wpcal.robot.kinematics.arm import Coupling
from wpcal.robot.moves import PathTolerance
from wpcal.weld.find import find_welds
from wpcal.weld.place import StatedWeld
from wpcal.weld.rules import shipped_rules
from wpcal.weld.runs import RunChoice, Tacks, WeaveBy

yaml = pytest.importorskip("yaml", reason="pyyaml is not installed")
pytest.importorskip("fcl", reason="python-fcl is not installed")

NUMBER = r"[-+0-9.eE]+"
WRITTEN_MM = 2e-3  #: Angles with five decimals move a point at 2 m by less.
LANGUAGES = ("rapid", "krl", "inform", "fanuc")
STATED = {"job": 3, "current_a": 200.0, "voltage_v": 24.0, "speed_mm_s": 7.0}


@pytest.fixture(scope="module")
def given():
    """W2 with weld data, and W3 in two stitches."""
    read = read_sequence_input(TEE, fixed_cell(), ["W2", "W3"])
    T, seams = read.in_base(fixed_cell())
    stated = [
        StatedWeld("W2", None, STATED),
        StatedWeld("W3", None, {**STATED, "stitch": {"length_mm": 40, "pitch_mm": 110, "offset_mm": 0}}),
    ]
    found = find_welds(seams, T, shipped_rules(), stated=stated, names={"W2", "W3"})
    return read.with_welds(found.by_seam(), RunChoice(), 6.0)


@pytest.fixture(scope="module")
def sequence(tmp_path_factory, given):
    cell = read_one_robot(write_cell(tmp_path_factory.mktemp("cell"), with_positioner(TEE_ON_TABLE)))
    return plan_sequence(cell, given.part, given.seams, SequenceTargets()).sequence


def program_of(sequence, given, **more):
    return build_planned_program(KeptPlan.of(sequence), {each.name: each for each in given.seams}, PlanOutput(**more))


def with_coupling(arm):
    joints = [joint.name for joint in arm.joints]
    return dataclasses.replace(arm, couplings=(Coupling(joints[2], joints[1], 0.0),))


def files_of(program, name):
    """The files; those of FANUC with the coupling that the mh6 does not have."""
    if name == "fanuc":
        program = dataclasses.replace(program, arm=with_coupling(program.arm))
    return controller_named(name).write(program)


def written(program, name):
    """Return the files as one text, judged."""
    files = files_of(program, name)
    judged(files, program, name)
    return "\r\n".join(files.values())


@pytest.fixture(scope="module")
def dry(sequence, given):
    program = program_of(sequence, given)
    return program, {name: written(program, name) for name in LANGUAGES}


def test_a_seam_whose_moves_are_not_free_keeps_nearer_to_the_plan(sequence, given):
    told = iter([False, True, True, True])
    program = program_of(sequence, given, is_free=lambda T, vias, q: next(told))
    assert [path.moves.most_mm for path in program.paths] == [0.0125, 0.05, 0.05]


def test_between_the_frames_of_a_seam_a_program_turns_the_torch_as_planned(sequence, given):
    plan = KeptPlan.of(sequence)
    piece, *rest = plan.pieces
    top = piece.before + int(np.flatnonzero(~piece.task.is_source)[1])
    ends = [piece.before, top, len(piece.states) - piece.after - 1]
    states = piece.states.copy()
    states[:, 4] += np.radians(8.0) * np.interp(np.arange(len(states)), ends, [0.0, 1.0, 0.0])
    bent = dataclasses.replace(plan, pieces=(dataclasses.replace(piece, states=states), *rest))
    path = build_planned_program(bent, {each.name: each for each in given.seams}).paths[0]
    assert np.abs(path.joints - states[top, :6]).max(axis=1).min() <= PathTolerance().wire_rad


def test_inform_states_the_positioner_at_every_position(dry):
    program = dry[0]
    jobs = controller_named("inform").write(program)
    for path in program.paths:
        job = jobs[f"{path.seam.name.replace('.', '_').upper()}.jbi"]
        assert len(re.findall(r"\nC\d{5}=", job)) == job.count("\nEC0") == len(path)
        assert f"///NPOS {len(path)},0,{len(path)},0,0,0" in job
        assert "///GROUP2 ST1" in job


def test_krl_states_status_turn_and_external_axes(dry):
    text = dry[1]["krl"]
    poses = re.findall(r"DECL E6POS \w+=\{([^}]*)\}", text)
    assert len(poses) == 9
    assert all(re.search(rf"S \d,T \d+,E1 {NUMBER},E2 {NUMBER}$", pose) for pose in poses)
    axes = re.findall(r"DECL E6AXIS (\w+)=\{A1 ", text)
    assert sorted(re.findall(r"PTP (WPJ\w+)", text)) == sorted(axes)
    assert text.index("RUN IT") < text.index("PTP WPJ")
    assert "BASE_DATA" not in text  # the part turns: the points are in the base of the robot


def test_fanuc_goes_to_joints_along_a_seam_where_no_source_says_the_config(dry, monkeypatch):
    def refused(*_):
        raise InputError("the wrist is behind axis 1 (B)")

    monkeypatch.setattr(ConfigurationRule, "texts", refused)
    text = written(dry[0], "fanuc")
    assert "positions are joints" in text
    assert "CONFIG" not in text


def test_fanuc_refuses_an_arm_without_the_coupling_of_its_third_joint(dry):
    with pytest.raises(InputError, match="FANUC shows J3 against the horizontal"):
        controller_named("fanuc").write(dry[0])


def test_every_run_has_its_speed_and_dry_runs_say_so(dry):
    program, texts = dry
    assert sorted(path.seam.name for path in program.paths) == ["W2", "W3.s1", "W3.s2"]
    for name, speed in (("rapid", "[7,"), ("krl", "$VEL.CP=0.007"), ("inform", "V=7.0"), ("fanuc", "7mm/sec")):
        assert texts[name].count(speed) >= 3
        assert "DRY RUN" in texts[name]
        assert "checked against" in texts[name]


ARCS = {
    "rapid": (r"ArcLStart (\w+)", r"ArcLEnd (\w+)"),
    "krl": (r"ARC_START\(3\)", r"ARC_END\(\)"),
    "inform": (r"ARCON ASF#\(3\)", r"ARCOF AEF#\(3\)"),
    "fanuc": (r"Weld Start\[1,3\]", r"Weld End\[1,3\]"),
}


@pytest.mark.parametrize("name", LANGUAGES)
def test_with_the_arc_on_every_run_starts_and_ends_it_once(sequence, given, name):
    program = program_of(sequence, given, arc=ArcSettings())
    text = written(program, name)  # the audit of arcs reads it
    code = "\n".join(line for line in text.splitlines() if not line.startswith(";"))  # comments name functions too
    for pattern in ARCS[name]:
        assert len(re.findall(pattern, code)) == 3
    assert "DRY RUN" not in text
    assert "with the arc blocked" in " ".join(re.findall(r"[A-Za-z]+", text))


def test_a_plan_has_the_tack_welds_of_export_first_and_names_data_beside_a_weave_of_points():
    read = read_sequence_input(TEE, fixed_cell(), ["W2"])
    T, seams = read.in_base(fixed_cell())
    extra = {"tacks": {"length_mm": 10, "pitch_mm": 110}, "weave": {"shape": "zigzag", "width_mm": 4, "length_mm": 10}}
    found = find_welds(seams, T, shipped_rules(), stated=[StatedWeld("W2", None, {**STATED, **extra})], names={"W2"})
    welds = found.by_seam()
    for tacks, names in ((Tacks.OFF, ["W2"]), (Tacks.ONLY, ["W2.t1", "W2.t2"])):
        assert [each.name for each in read.with_welds(welds, RunChoice(tacks), 6.0).seams] == names
    planned = read.with_welds(welds, RunChoice(weave=WeaveBy.POINTS), 6.0)
    sequence = plan_sequence(fixed_cell(), planned.part, planned.seams, SequenceTargets()).sequence
    program = program_of(sequence, planned)
    assert [path.seam.name.partition(".t")[0] for path in program.paths] == ["W2"] * 3
    assert program.paths[2].seam.name == "W2"
    header = "\n".join(describe(program))
    assert "data of the controller must have no weave of their own, or there are two: W2 (job 3)" in header


def test_templates_of_a_shop_are_used_and_a_missing_name_is_one_line(tmp_path, sequence, given):
    own = tmp_path / "rapid"
    own.mkdir()
    (own / "joint_move.txt").write_text("    myAbsJ {{ point }},{{ speed }},{{ tool }};\n", encoding="utf-8")
    program = program_of(sequence, given, controller=ControllerSettings(templates=tmp_path))
    text = written(program, "rapid")
    assert "MoveAbsJ" not in text
    assert text.count("myAbsJ wpJ") == sum(map(len, program.planned.legs))
    wrong = tmp_path / "wrong"
    (wrong / "rapid").mkdir(parents=True)
    (wrong / "rapid" / "joint_move.txt").write_text("{{ points }}\n", encoding="utf-8")
    with pytest.raises(FormatError, match="there is no name 'points'"):
        written(program_of(sequence, given, controller=ControllerSettings(templates=wrong)), "rapid")


def test_on_a_rail_all_languages_state_it(given, golden):
    """Positions count from where the base is at 0 mm of the rail: the axis is a coordinated one."""
    cell = given.placed(fixed_cell())
    rail = Rail(np.array([0.0, 1.0, 0.0]), -300.0, 300.0, 500.0)
    cell = dataclasses.replace(cell, rail=rail, home=np.append(cell.home, 200.0), touched_at=np.array([200.0]))
    found = plan_sequence(cell, given.part, given.seams[:1], SequenceTargets()).sequence
    program = program_of(found, given)
    texts = {name: written(program, name) for name in LANGUAGES}
    (path,) = program.paths
    along = path.external[0, 0]
    assert f"[{along:.5f}," in texts["rapid"]
    assert f"E1 {along:.6f}}}" in texts["krl"]
    assert f"BC00000={along:.4f}" in texts["inform"]
    assert "RB1,BS1" in texts["inform"]
    assert f"E1= {along:.3f}  mm" in texts["fanuc"]
    q = np.concatenate([path.joints[1], [along]])[None]
    T = np.linalg.inv(cell.T_world_base.matrix) @ cell.tool_places(q)[0]
    assert np.allclose(T[:3, 3], path.p_base[1], rtol=0, atol=WRITTEN_MM)
    assert not np.isclose(along, 0.0)
    golden(found.pieces)


def test_a_ring_is_welded_flat_by_turning_the_positioner(tmp_path, given, golden):
    """The fillet of a pipe on a plate in PA all round: only the positioner moves, and programs follow it."""
    ring = pipe_ring(given.seams[0])
    cell = read_one_robot(write_cell(tmp_path, with_positioner((0.0, 0.0, 10.0))))
    found = plan_sequence(cell, None, [ring], SequenceTargets(position=WeldPosition.PA)).sequence
    (piece,) = found.pieces
    q = piece.candidate.q
    assert abs(np.ptp(q[:, 7])) == pytest.approx(2.0 * np.pi)
    assert np.ptp(q[:, :7], axis=0).max() < np.radians(0.1)
    up = np.einsum("nij,njk->nik", cell.part_places(q)[:, :3, :3], piece.candidate.task.R)[:, 2]
    assert np.degrees(np.arccos(up[:, 2].min())) < 1.0  # out of the joint is up everywhere
    assert np.abs(up[:, 0]).max() < np.sin(np.radians(1.0))  # and the travel is level
    program = build_planned_program(KeptPlan.of(found), {"R1": ring}, PlanOutput(has_part=False))
    rapid, krl = written(program, "rapid"), written(program, "krl")
    assert 2 <= rapid.count("MoveC ") <= 3
    told = write_plan(KeptPlan.of(found), [ring], PlanOutput(has_part=False), [controller_named("rapid")], None)
    header = " ".join(line.strip("! ") for line in told.files["rapid"]["WPCAL.mod"].splitlines())
    assert [line[:32] for line in told.notes(why=True)] == [UNCHECKED[:32]]
    assert all(line in header for line in told.notes(why=True))
    assert '[FALSE,FALSE,"STN1",' in rapid
    assert "ActUnit STN1;" in rapid
    assert "$BASE=EK(MACHINE_DEF[2].ROOT,MACHINE_DEF[2].MECH_TYPE,WP_PART)" in krl
    points = re.findall(r"robtarget R1_0\d+:=\[\[([^\]]*)\]", rapid)
    radius = [np.hypot(*(float(v) for v in point.split(",")[:2])) for point in points]
    assert np.allclose(radius, 60.0, rtol=0, atol=WRITTEN_MM)  # in the part, which the positioner carries
    check_coordinated(program, cell)
    lines = build_planned_program(KeptPlan.of(found), {"R1": ring}, PlanOutput(has_part=False, is_carried=False))
    check_coordinated(lines, cell)
    with pytest.raises(InputError, match="positions are expected in the base of the robot"):
        written(program, "fanuc")
    with pytest.raises(InputError, match="positions are expected in the part that the positioner carries"):
        written(lines, "rapid")
    golden(piece)


def check_coordinated(program, cell):
    """Read the axes of both groups back: between two targets the torch moves on its line or arc in the part."""
    name, suffix = ("inform", "jbi") if program.planned.is_carried else ("fanuc", "ls")
    coupled = dataclasses.replace(program, arm=with_coupling(program.arm)) if name == "fanuc" else program
    (own,) = (text for file, text in controller_named(name).write(coupled).items() if file.lower().startswith("r1"))
    path = Path(f"r1.{suffix}")
    assert controller_named(name).load_grammar().is_in_step(own.encode(), path)
    assert two_robot_faults({path.name: own.encode()}, path, None)[0] == []
    if program.planned.is_carried:
        text = written(program, "inform")
        assert "///GROUP2 ST1" in text
        arms, stations = (
            {n: [float(v) for v in row.split(",")] for n, row in re.findall(rf"\r\n{mark}(\d+)=([^\r]*)", job)}
            for mark in ("C", "EC")
            for job in [own]
        )
        moves = re.findall(r"SMOV([LC]) C(\d+) V=([\d.]+) PL=[01]  \+MOVJ EC(\d+)", text)
        assert 2 <= [kind for kind, *_ in moves].count("C") / 3 <= 3
        assert all(one == two for _, one, _, two in moves)
        rows = [np.radians([*arms[n], *stations[n]]) for n in dict.fromkeys(n for _, n, *_ in moves)]
    else:
        assert "/PROG  R1" in written(program, "fanuc")
        text = own
        coordinated = [int(n) for n in re.findall(r":L P\[(\d+)\] \S+ (?:CNT100|FINE) COORD", text)]
        assert "C P[" not in text
        assert coordinated == list(range(3, 3 + len(coordinated)))
        assert 77 <= len(coordinated) <= 120  # 77 chords are within 0.05 mm of a circle of 60 mm
        blocks = re.findall(r"P\[\d+\]\{(.*?)\};", text, re.DOTALL)[1:-1]
        q = np.concatenate([program.paths[0].joints, program.paths[0].external], axis=1)[1:-1]
        for block, row in zip(blocks, q, strict=True):
            values = [float(v) for v in re.findall(r"[XYZWPR] = *([-\d.]+)", block)]
            T = np.linalg.inv(cell.base_places(row[None]))[0] @ cell.tool_places(row[None])[0]
            assert np.allclose(T[:3, 3], values[:3], rtol=0, atol=2 * WRITTEN_MM)
            R = Rotation.from_euler("xyz", values[3:], degrees=True).as_matrix()
            assert np.allclose(T[:3, :3], R, rtol=0, atol=1e-4)
        turned = [[float(v) for v in re.findall(r"J[12]= *([-\d.]+)", block.partition("GP2:")[2])] for block in blocks]
        rows = [np.array([*row[:6], *np.radians(two)]) for row, two in zip(q, turned, strict=True)]
    in_part = np.linalg.inv(cell.part_places(np.array(rows))) @ cell.tool_places(np.array(rows))
    assert np.allclose(np.hypot(*in_part[:, :2, 3].T), 60.0, rtol=0, atol=0.06)
    assert np.ptp(np.array(rows)[:, 7]) > np.pi


def test_the_trajectory_has_every_state_with_its_time(sequence):
    line = build_timeline(sequence)
    record = yaml.safe_load(joint_trajectory(sequence, line))
    assert record["joint_names"] == list(sequence.cell.axis_names)
    q = np.array([point["positions"] for point in record["points"]])
    assert np.allclose(q, line.q, rtol=0, atol=1e-9)
    times = [p["time_from_start"]["sec"] + 1e-9 * p["time_from_start"]["nanosec"] for p in record["points"]]
    assert np.allclose(times, line.t_s, rtol=0, atol=1e-8)

    names: dict[str, object] = {}
    exec(tesseract_states(sequence, line), names)  # a module that was written here
    assert names["JOINTS"] == list(sequence.cell.axis_names)
    states = names["STATES"]
    assert np.allclose([axes for _, axes, _ in states], line.q, rtol=0, atol=1e-9)
    assert np.allclose([t for t, _, _ in states], line.t_s, rtol=0, atol=1e-8)
    assert [burns for _, _, burns in states] == [phase is Phase.WELD for phase in line.phase]
    assert callable(names["build"])


RAPID = "PERS tooldata tGun:=[TRUE,[[10,-20,330.5],[0.92388,0,0.382683,0]],[1,[0,0,1],[1,0,0,0],0,0,0]];"
KRL = "TOOL_DATA[3]={X 1.0,Y 2.0,Z 300.0,A 0.0,B 45.0,C 0.0}\nTOOL_DATA[4]={X 0,Y 0,Z 1,A 0,B 0,C 0}"


@pytest.mark.parametrize(
    ("name", "text", "tool", "place"),
    [
        ("a.mod", RAPID, None, [10, -20, 330.5]),
        ("a.mod", f"PERS tooldata tHalf:=tool0;\n{RAPID}", "tGun", [10, -20, 330.5]),
        ("a.src", KRL, "3", [1, 2, 300]),
        ("a.script", "  set_tcp(p[0.01,0,0.35,0,0.785398,0])", None, [10, 0, 350]),
    ],
)  # fmt: skip
def test_tool_data_are_read_from_programs(tmp_path, name, text, tool, place):
    path = tmp_path / name
    path.write_text(text, encoding="utf-8")
    found = read_tool_data(path, tool)
    assert np.allclose(found.t_mm, place, rtol=0, atol=1e-9)
    assert np.allclose(found.R, Rotation.from_euler("y", 45, degrees=True).as_matrix(), rtol=0, atol=1e-5)


@pytest.mark.parametrize(
    ("text", "tool", "says"),
    [
        ("MODULE x\nENDMODULE", None, "no tool data"),
        ("TOOL_DATA[3]={X 1,Y 2,Z 3,A 0,B 0,C 0}\n$TOOL={X 0,Y 0,Z 1,A 0,B 0,C 0}", None, "several tools: name one"),
        ("TOOL_DATA[3]={X 1,Y 2,Z 3,A 0,B 0,C 0}", "7", "no tool '7'"),
        ("PERS tooldata t:=[TRUE,[[1,2,3],[5,0,0,0]]]", None, "the quaternion has length 5"),
        ("PERS tooldata t:=[TRUE,[[1,2,x],[1,0,0,0]],load1];", "t", "t: expected .*numbers in brackets"),
        ("PERS tooldata t:=[TRUE,[[1,2,30000],[1,0,0,0]],load1];", "t", "at most 10000 mm"),
        ("PERS tooldata t:=tool0;", None, "t: expected"),
    ],
)
def test_tool_data_that_cannot_be_read_are_one_line(tmp_path, text, tool, says):
    path = tmp_path / "a.mod"
    path.write_text(text, encoding="utf-8")
    with pytest.raises(InputError, match=says):
        read_tool_data(path, tool)


@pytest.mark.parametrize("name", ["rapid", "krl", "inform", "fanuc", "as"])
def test_a_seam_is_welded_again_from_home_and_home(sequence, given, name):
    program = program_of(sequence, given)
    text = written(program, name)  # judged: all of these routines are executed
    assert len(re.findall(r"(?im)^ *(?:\.?PROGRAM |GLOBAL DEF |PROC |//NAME |/PROG +)only_\w+", text)) == 3
    (to, back), *others = program.planned.ways
    assert np.array_equal(to.joints[0], back.joints[-1])  # home
    moved = dataclasses.replace(to, joints=to.joints + 0.01)
    planned = dataclasses.replace(program.planned, ways=((moved, back), *others))
    with pytest.raises(WrittenWrongError, match=r"not asked for|missing"):
        judged(files_of(program, name), dataclasses.replace(program, planned=planned), name)


def test_a_seam_without_free_ways_has_no_routine_and_is_named(sequence, given):
    plan = KeptPlan.of(sequence)
    nothing = plan.ways[0].to_home[:0]
    plan = dataclasses.replace(plan, ways=(dataclasses.replace(plan.ways[0], to_home=nothing), *plan.ways[1:]))
    program = build_planned_program(plan, {each.name: each for each in given.seams}, PlanOutput())
    text = written(program, "rapid")
    assert len(re.findall(r"PROC only_", text)) == 2
    assert f"no free way from and to home was found: {plan.pieces[0].name}" in " ".join(describe(program))
