"""Whole plans of public robots, judged by other kinematics and real meshes; this judge finds planted faults."""

import json
import shutil

import numpy as np
import pytest

from tests.cluttered_cells import FIXTURES, ROBOTS, TOOL, urdf
from tests.running import run_here
from wpcal.brep.material import TriangleMaterial
from wpcal.brep.mesh_glb import read_part_glb

pytest.importorskip("fcl", reason="python-fcl is not installed")
pytest.importorskip("ompl", reason="ompl is not installed")
pytestmark = [
    pytest.mark.deep,
    pytest.mark.skipif(not ROBOTS.is_dir(), reason="the folder of URDF files lies beside the checkout and is not here"),
]
ARMS = ("irb1600_6_12", "ma2010", "kr5_arc", "m10ia")


def planned(folder, robot, part):
    """Plan as a user does, and return what the judge needs."""
    cell, out, result = folder / "cell.json", folder / "plan", FIXTURES / part / "golden"
    tool = ",".join(map(str, TOOL))
    assert run_here("cell", "new", "--torch-robot", urdf(robot), "--tool", tool, "-o", cell).returncode == 0
    done = run_here("plan", cell, result, "-o", out)
    assert done.returncode in (0, 1), done.stderr
    triangles = TriangleMaterial.of(read_part_glb((result / "part.glb").read_bytes(), path="part.glb")).corners
    return out, cell, {"robot": urdf(robot)}, result / "seams.json", triangles


@pytest.mark.parametrize("part", ["tee", "frame", "saddle"])
@pytest.mark.parametrize("robot", ARMS)
def test_a_whole_plan_has_no_fault(robot, part, tmp_path):
    from tests.plan_faults import plan_faults

    assert plan_faults(*planned(tmp_path, robot, part)) == []


def test_planted_faults_are_found(tmp_path):
    from tests.plan_faults import plan_faults

    out, cell, urdfs, seams, part = planned(tmp_path, "irb1600_6_12", "tee")
    plan = json.loads((out / "plan.json").read_text(encoding="utf-8"))

    def faults_of(change):
        folder = tmp_path / "changed"
        shutil.rmtree(folder, ignore_errors=True)
        folder.mkdir()
        record = json.loads(json.dumps(plan))
        change(record)
        (folder / "plan.json").write_text(json.dumps(record), encoding="utf-8")
        return " ".join(plan_faults(folder, cell, urdfs, seams, part))

    welds = [row for row, point in enumerate(plan["points"]) if point["phase"] == "weld"]
    row = welds[len(welds) // 2]

    def shift(record):
        record["points"][row]["axes"][0] += 0.1

    def swap(record):
        axes = record["points"][row]["axes"]
        axes[3:6] = [axes[3] - np.sign(axes[3] or 1.0) * 180.0, -axes[4], axes[5] - 180.0]

    def leave_out(record):
        record["seams"].pop()

    def sink(record):
        record["T_carrier_part"]["xyz_mm"][2] += 30.0

    def hurry(record):
        for number, point in enumerate(record["points"]):
            point["t_s"] = 0.01 * number

    assert faults_of(lambda record: None) == ""
    assert "off the seam" in faults_of(shift)
    assert "off the seam" in faults_of(swap)
    assert "mm welded" in faults_of(leave_out)
    assert "meets part" in faults_of(sink)
    assert "allowed" in faults_of(hurry)
