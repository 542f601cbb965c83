"""Whole plans of public robots, judged by other kinematics and real meshes; this judge finds planted faults."""

import json
import re
import shutil

import numpy as np
import pytest

from tests.cluttered_cells import FIXTURES, ROBOTS, urdf
from tests.few import few
from tests.whole_table import ARMS, ASSEMBLIES, STEP, judged, texts_of, triangles_of

pytest.importorskip("fcl", reason="python-fcl is not installed")
pytestmark = pytest.mark.skipif(
    not ROBOTS.is_dir(), reason="the folder of URDF files lies beside the checkout and is not here"
)

LEAST_WELDED = 0.6  #: Of the frame of eight bodies; what is left is told: the wrist does not turn so far.


@pytest.fixture(scope="module")
def results(tmp_path_factory):
    """The folder of the calibrations of assemblies."""
    return tmp_path_factory.mktemp("results")


@pytest.mark.deep
@pytest.mark.parametrize("part", ["tee", "frame", "saddle", *ASSEMBLIES])
@pytest.mark.parametrize("arm", ARMS)
def test_a_whole_plan_has_no_fault(arm, part, tmp_path, results):
    if part in ASSEMBLIES and not STEP.is_dir():
        pytest.skip("the folder of STEP files lies beside the checkout and is not here")
    row = judged(part, arm, tmp_path, results)
    assert row.faults == ()
    assert row.untold == ()
    assert row.no_program == ()


def way_and_text(folder):
    """Return the way of a plan, and the name and the text of its RAPID program."""
    from tests.plan_text import way_of
    from tests.real_cells import RealCell, of_record

    plan = json.loads((folder / "plan" / "plan.json").read_text(encoding="utf-8"))
    real = RealCell(folder / "cell.json", {"robot": urdf("irb1600_6_12")}, None, of_record(plan["T_carrier_part"]))
    return way_of(plan, real), *next(iter(texts_of(folder / "plan" / "rapid").items()))


@pytest.mark.parametrize("part", few(["tee", "frame"], 1))
def test_program_and_plan_have_no_fault_but_planted_ones(part, tmp_path):
    from tests.plan_text import text_faults

    row = judged(part, "irb1600_6_12", tmp_path, tmp_path)
    assert (row.faults, row.untold, row.no_program) == ((), (), ())
    assert row.welded_mm > LEAST_WELDED * row.accepted_mm
    way, name, text = way_and_text(tmp_path)

    def faults_of(pattern, to):
        changed, count = re.subn(pattern, to, text, count=1)
        assert count
        return " ".join(text_faults("rapid", {name: changed}, way))

    assert "configuration" in faults_of(r"(robtarget .*?\],\[)-?\d+(,-?\d+,-?\d+,\d+\])", r"\g<1>3\2")
    assert "is not on the plan" in faults_of(r"(jointtarget wpJ0003:=\[\[)(-?\d+)", r"\g<1>1\2")
    assert "is not on the plan" in faults_of(r"(robtarget .*?:=\[\[)(\d+)\.", r"\g<1>1\2.")
    assert "off its way" in faults_of(
        r"    MoveL (\w+_0001),vAir.*\n    ! ARC ON\n    MoveL", "    ! ARC ON\n    MoveL"
    )
    assert "the program ends at" in faults_of(
        r"(?s)(PROC run_\w+\(\)(?:(?!ENDPROC).)*)    MoveAbsJ \w+,[^\n]*\n", r"\1"
    )


@pytest.mark.deep
def test_planted_faults_are_found(tmp_path):
    from tests.plan_faults import plan_faults

    judged("tee", "irb1600_6_12", tmp_path, tmp_path)
    out, cell, urdfs = tmp_path / "plan", tmp_path / "cell.json", {"robot": urdf("irb1600_6_12")}
    seams, part = FIXTURES / "tee" / "golden" / "seams.json", triangles_of(FIXTURES / "tee" / "golden")
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
