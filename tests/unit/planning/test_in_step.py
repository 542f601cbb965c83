"""Texts of two robots are swept with the wire, the mesh of the held part and the way from home; the audit does so."""

import dataclasses
import json
import re
import shutil

import numpy as np
import pytest

from tests.running import run_here
from tests.saddle import CELLS, scan_coarsely
from wpcal.brep.material import TriangleMaterial
from wpcal.brep.mesh_glb import read_part_glb
from wpcal.controllers.audit import audit_path
from wpcal.controllers.judge.in_step import in_step
from wpcal.core.transform import RigidTransform
from wpcal.planning.cell.cell import CARRIER
from wpcal.planning.cell.cell_file import read_cell
from wpcal.planning.cell.shape import Shape

pytest.importorskip("fcl", reason="python-fcl is not installed")
TEE = CELLS.parent / "tee" / "golden"
HOME_DEG = [[70.0, -30.0, 40.0, -45.0, 80.0, -90.0], [-10.0, 30.0, 25.0, 5.0, -100.0, -80.0]]  #: Near the seam.


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """A plan of two robots whose cell states a home, with its programs, which switch the arc."""
    place = tmp_path_factory.mktemp("held")
    record = json.loads((CELLS / "two-mh6-tee.json").read_text())
    for name, home in zip(("torch_robot", "holder_robot"), HOME_DEG, strict=True):
        record[name]["home_deg"] = home
    (place / "cell.json").write_text(json.dumps(record))
    with pytest.MonkeyPatch.context() as patch:
        scan_coarsely(patch)
        arc = ["--welds", TEE.parent / "welds.json", "--arc", "on"]
        ended = run_here("plan", place / "cell.json", TEE, "--seam", "W2", *arc, "-o", place / "plan")
    assert ended.returncode == 0
    return place / "plan"


def swept(folder, cell, moved_mm=(0.0, 0.0, 0.0)):
    """Return what is told of the INFORM job, by the texts of its lines; the mesh of the part is moved in the hand."""
    T = RigidTransform(np.eye(3), np.array(moved_mm), target="part", source="part")
    part = TriangleMaterial.of(read_part_glb((TEE / "part.glb").read_bytes()), T)
    text = (folder / "WPCAL_W2.jbi").read_text()
    found = in_step({"WPCAL_W2.jbi": text}, cell, first_state(folder), tools=[1], part=part).meetings()
    return [(text.splitlines()[each.motion.place.line - 1], each.what) for each in found]


def first_state(folder):
    first = json.loads((folder / "plan.json").read_text())["points"][0]
    return np.radians([*first["robot1_deg"], *first["robot2_deg"]])


def with_ball(cell, q, z_mm, radius_mm):
    """Return the cell with a ball where the tool is at a state, this far along the wire."""
    T = cell.tool_places(q[None])[0]
    p = [T[:3, 3] + z_mm * T[:3, 2]]
    return dataclasses.replace(cell, bench=(Shape("ball", p, p, np.array([radius_mm])),))


def test_the_home_of_one_robot_alone_is_none(folder, tmp_path):
    """A way from a home that nobody stated would be called swept."""
    record = json.loads((folder / "input" / "cell.json").read_text())
    (tmp_path / "both.json").write_text(json.dumps(record))
    del record["holder_robot"]["home_deg"]
    (tmp_path / "one.json").write_text(json.dumps(record))
    assert [read_cell(tmp_path / f"{name}.json").goes_from_home for name in ("both", "one")] == [True, False]


def test_a_planted_wire_mesh_and_way_from_home_are_named_by_line(folder, golden):
    cell, q = read_cell(folder / "input" / "cell.json"), first_state(folder)
    cell = dataclasses.replace(cell, d1_mm=0.0)
    assert swept(folder, cell) == []
    unstated = dataclasses.replace(cell, home=np.zeros(12))
    (line, what), *_ = swept(folder, with_ball(unstated, q, -8.0, 2.0))
    assert line.startswith("MOVJ C00000")
    assert "robot 1 wire and ball miss" in what
    told = swept(folder, unstated, (0.0, 0.0, 25.0))
    assert any(line.startswith("SMOVL") and re.search("robot 1 .* and part miss", what) for line, what in told)
    elbow = cell.frames(q[None])[CARRIER + 3].p[:, 0]
    told = swept(
        folder, unstated, (np.linalg.inv(cell.part_places(q[None])[0]) @ [*elbow, 1.0])[:3] - [100.0, 0.0, 5.0]
    )
    assert any("robot 2" in what and "and part miss" in what for _, what in told)
    halfway = with_ball(cell, (cell.home + q) / 2.0, 0.0, 2.0)
    (line, what), *_ = swept(folder, halfway)
    assert line.startswith("MOVJ C00000")
    assert "on the way there from home robot 1" in what
    assert "the way to the first point" not in (folder / "WPCAL_W2.jbi").read_text()
    golden([what, told])


@pytest.mark.parametrize(
    ("file", "before", "by", "says"),
    [
        ("WPCAL_W2_R1.mod", r"robtarget W2_0002:=\[\[", 2.5, "mm off the line of W2"),
        ("WPCAL_W2_R1.dat", r"W2_0002=\{X ", 2.5, "mm off the line of W2"),
        ("WPCAL_W2_R1.dat", r"W2_0002=\{.*?,C ", 9.0, "the wire is turned by 9 deg from its direction on W2"),
        ("WPCAL_W2.jbi", r"C00004=", 2.5, "mm off the line of W2"),
        ("wpcal_w2.ls", r"P\[3\]\{[^}]*?Y =", 2.5, "mm off the line of W2"),
        ("WPCAL_W2_R1.mod", r"vWeld:=\[", 50.0, "mm/s along a seam: its header says 7.1 at most"),
        ("WPCAL_W2_R1.src", r"W2_0002 WITH .VEL\.CP=", 0.05, "mm/s along a seam: its header says 7.1 at most"),
        ("WPCAL_W2.jbi", r"SMOVL C00004 V=", 50.0, "mm/s along a seam: its header says 7.1 at most"),
        ("wpcal_w2.ls", r"P\[2\]", 50.0, "mm/s in the air: its header says 50 at most"),
    ],
)
def test_the_audit_finds_a_place_beside_the_seam_of_two_robots(file, before, by, says, folder, tmp_path, golden):
    path = shutil.copytree(folder, tmp_path / "plan") / file
    stated = re.search(rf"{before}\s*([-\d.]+)", path.read_text(), re.DOTALL)
    path.write_text(f"{stated.string[: stated.start(1)]}{float(stated[1]) + by}{stated.string[stated.end(1) :]}")
    faults = [fault for each in audit_path(path.parent).files for fault in each.faults]
    assert any(says in fault.message and fault.line for fault in faults), faults
    golden([fault.message for fault in faults])


def test_the_audit_sweeps_both_programs_in_the_cell_of_the_plan(folder, tmp_path):
    copy = shutil.copytree(folder, tmp_path / "plan")
    programs = [each for each in audit_path(copy).files if "two robots" in each.kind]
    assert [(each.faults, "swept together" in each.checked) for each in programs] == [((), True)] * 8
    held = copy / "WPCAL_W2_R2.mod"
    bend = lambda m: f"{m[1]}{float(m[2]) - 60.0:.4f}"  # noqa: E731
    held.write_text(re.sub(r"(jointtarget \w+_0002:=\[\[[-\d.]+,[-\d.]+,)([-\d.]+)", bend, held.read_text()))
    faults = [fault for each in audit_path(copy).files for fault in each.faults]
    assert any(fault.line and "with WPCAL_W2_R2.mod, line" in fault.message for fault in faults), faults
    (copy / "input" / "cell.json").write_text("{}")
    assert any("not what plan.json was made from" in f.message for each in audit_path(copy).files for f in each.faults)
