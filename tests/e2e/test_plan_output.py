"""`wpcal plan` from files to files: the plan, its page and the programs of both robots say the same."""

import json
import re
import shutil
from pathlib import Path

import numpy as np
import pytest

from tests.few import few
from tests.running import run_here
from tests.saddle import THINNED, scan_coarsely
from wpcal.brep.mesh import PartMesh, SolidMesh
from wpcal.brep.mesh_glb import write_part_glb
from wpcal.core.motion import WELD_SPEED_MM_S

pytest.importorskip("fcl", reason="python-fcl is not installed")
CELLS = Path(__file__).parents[2] / "fixtures" / "cells"
CLOSED_CHAIN_MM = 1e-6  #: Asked of every point of every plan.


@pytest.fixture(scope="module", params=few([6, None], 1), ids=["a piece", "whole"])
def planned(request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A plan of every fourth point of the saddle, of a piece with few weights; the mesh of the part is a triangle."""
    folder = tmp_path_factory.mktemp("plan")
    record = json.loads((CELLS / "saddle-seams.json").read_text())
    for seam in record["seams"]:
        seam["frames"] = seam["frames"][::THINNED][: request.param]
    (folder / "seams.json").write_text(json.dumps(record))
    corners = np.array([[0.0, 0, 0], [50, 0, 0], [0, 50, 0]])
    solid = SolidMesh("pipe", corners, np.array([[0, 1, 2]]), np.array([[0, 1], [1, 2], [2, 0]]))
    (folder / "part.glb").write_bytes(write_part_glb(PartMesh((solid,), 0.1, 0.3)))
    with pytest.MonkeyPatch.context() as patch:
        if request.param:
            scan_coarsely(patch)
        done = run_here(
            "plan", CELLS / "two-mh6.json", folder / "seams.json", "--seam", "W1", "-o", folder / "out", "--joints"
        )
    assert (done.returncode, done.stderr) == (0, "")
    return folder / "out"


def test_every_file_is_there(planned: Path) -> None:
    jobs = {f"WPCAL_W1{end}" for end in (".jbi", "_R1.jbi", "_R2.jbi", "_R1.mod", "_R2.mod")}
    assert {f.name for f in planned.iterdir()} == {"pareto.json", "plan.json", "plan.csv", "plan.html", "input"} | jobs
    assert 'id="blob-part"' in (planned / "plan.html").read_text(encoding="utf-8")


def test_both_programs_wait_at_the_same_marks(planned: Path) -> None:
    ids = [re.findall(r"\\ID:=(\d+)", (planned / f"WPCAL_W1_R{robot}.mod").read_text()) for robot in (1, 2)]
    marks = [
        re.findall(r"^'MARK (\d+)", (planned / f"WPCAL_W1_R{robot}.jbi").read_text(), re.MULTILINE) for robot in (1, 2)
    ]
    points = json.loads((planned / "plan.json").read_text())["points"]
    assert ids[0] == ids[1] == [str(point["mark"]) for point in points[1:]]
    assert marks[0] == marks[1] == [str(point["mark"]) for point in points]


def test_what_is_called_free_was_measured(planned: Path) -> None:
    record = json.loads((planned / "plan.json").read_text())
    assert record["freedom"] == "free"
    assert {plan["freedom"] for plan in json.loads((planned / "pareto.json").read_text())["plans"]} == {"free"}
    assert record["check"]["steps_cut_into"] == 20  # its points are four times as far apart as in the file
    assert record["check"]["states"] == 20 * (len(record["points"]) - 1) + 1
    assert record["check"]["least_margin_mm"] > 0
    speeds = np.diff([p["s_mm"] for p in record["points"] if p["s_mm"] is not None]) / np.diff(
        [p["t_s"] for p in record["points"] if p["s_mm"] is not None]
    )
    np.testing.assert_allclose(speeds, record["speed_mm_s"], rtol=1e-9, atol=0)
    assert record["speed_mm_s"] == WELD_SPEED_MM_S


def test_a_file_that_is_no_mesh_is_refused_before_any_work(tmp_path: Path) -> None:
    shutil.copy(CELLS / "saddle-seams.json", tmp_path / "seams.json")
    (tmp_path / "part.glb").write_bytes(b"no mesh")
    done = run_here("plan", CELLS / "two-mh6.json", tmp_path / "seams.json", "--seam", "W1", "-o", tmp_path / "out")
    assert (done.returncode, done.stdout) == (2, "")
    assert done.stderr.count("\n") == 1
    assert "part.glb" in done.stderr
    assert not (tmp_path / "out").exists()
